"""How is a deformed layer brought to rest? Newton's method on displacement, pressure, and what is held of the target.

The unknowns x are the free nodal displacements and the target's q = (d_h, d_z, alpha). With T = d u_bonded / dq the
gradient and tangent of the total potential (body.py) are

    g = (f_free, T^T f_bonded + f_q + dV/dq),      A = (K, C; C^T, D + (f_bonded . d2u/dalpha2 + V'') on alpha),

K, C, D from assembly.py. The pressure p of the geometric stiffness is an unknown of its own, eliminated in the element:
each step moves it with the linearised volume, ``p <- K pi(J - 1 + H : dF)``, which is Newton's method on the mixed
problem. (With p taken from the current volume, K (J - 1), it would be Newton on a stiff penalty energy, and creep.)

Mixed control: of each pair F_x, d_h; F_z, d_z; M, alpha, one is given. Where the place is given (`held`), it changes
sides with its force: the force's column ``dg/dF`` takes the place's column in S, the stiffness that is left when all
but q is eliminated, so that turning points of the load are nothing special. S says whether the target stands stable,
too. A step that would turn a quadrature point inside out is shortened.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from sits_mech.mechanics.assembly import solved_in_order
from sits_mech.mechanics.body import Bonded, State, rest, smallest_volume
from sits_mech.mechanics.target import bonded_displacement, bonded_tangent, load_potential
from sits_mech.quantities import Array

Held = NDArray[np.bool_]
_Step = tuple[Array, Array, Array]  # of the free displacements, q and the forces that hold it

FREE: Held = np.zeros(3, dtype=bool)
"""No component of the target's place is held."""
SETTLED = 1e-9
"""Residual, over the load's size or the share of K below which rounding would rule, of a state at rest."""
MOST = 14
"""Iterations after which an increment is given up."""

_ROUNDING = 1e-5
_NEAR = 1e-3  # residual from which one more step leaves the target's stiffness as it is
_SHORTEN = 0.5
_MIN_J_KEPT = 0.2  # a step may not shrink the smallest volume ratio below this fraction of its value


class Settled(NamedTuple):
    """Where Newton's method ended, and the stiffness that the target feels near there; None where that is not known."""

    state: State
    stiffness: Array | None


class Linear(NamedTuple):
    """A linearised layer: gradient on the free displacements and on q; stiffness entries; T of the border, d2V/dq2.

    Last the elements' energy: infinite where one is beyond its law's locking stretch, and that is no rest.
    """

    gradient: Array
    on_target: Array
    values: Array
    T: Array
    turning: float
    energy: float


def newton(body: Bonded, start: State, goal: Array, held: Held = FREE, *, until: float = SETTLED) -> Settled:
    """Iterate to rest under one goal; the result's residual says whether it settled.

    Parameters
    ----------
    body : Bonded
    start : State
    goal : ndarray, shape (3,)
        F_x, F_z, M; where `held`, d_h, d_z, alpha instead; scaled.
    held : ndarray of bool, shape (3,)
    until : float
        Residual at which to stop.
    """
    here, stiffness, before = replace(start, load=np.where(held, start.load, goal)), None, np.inf
    for count in range(MOST + 1):
        found = linearised(body, here)
        gap = np.where(held, goal - here.q, 0.0)
        size = max(float(np.linalg.norm(here.load)), _ROUNDING * body.K)
        left = float(np.hypot(np.linalg.norm(found.gradient), np.linalg.norm(found.on_target))) / size
        left += float(np.abs(gap).max())
        left = left if left > until or np.isfinite(found.energy) else np.inf
        here = replace(here, residual=left, iterations=count)
        if left <= until or not np.isfinite(left) or count == MOST:
            break
        before = left
        eliminated = _eliminated(body, found)
        if eliminated is None:
            break
        stiffness = eliminated[0]
        way = _way(body, here, eliminated, (gap, held))
        moved = None if way is None else _moved(body, here, way, found.T)
        if moved is None:
            break
        here = moved
    return Settled(here, stiffness if before <= _NEAR else None)


def compliance(body: Bonded, state: State, load: Array) -> Array:
    """Return d(d_h, d_z, alpha) by the target's forces and moment about a state at rest; nan where there is none."""
    S = felt(body, replace(state, load=load))
    try:
        return np.asarray(np.linalg.inv(S))
    except np.linalg.LinAlgError:
        return np.full((3, 3), np.nan)


def felt(body: Bonded, state: State) -> Array:
    """Return the stiffness that the target feels, d(forces on d_h, d_z, alpha) by them; nan where there is none."""
    eliminated = _eliminated(body, linearised(body, state))
    return np.full((3, 3), np.nan) if eliminated is None else eliminated[0]


def stable(stiffness: Array, held: Held = FREE) -> bool:
    """Say whether the target at rest withstands any small push on what is not held of it, by the stiffness it feels.

    It is positive definite then. A crease that forms at a corner, which hardly moves the target, does not count.
    """
    S = stiffness[np.ix_(~held, ~held)]
    return bool(np.all(np.isfinite(S))) and bool(np.all(np.linalg.eigvalsh(0.5 * (S + S.T)) > 0.0))


def correction(body: Bonded, load: Array) -> tuple[Array, float]:
    """Return how far a second Newton step from rest moves q, and the smallest J before it; infinite if inverted."""
    here, nothing = replace(rest(body), load=load), (np.zeros(3), FREE)
    q = np.full(3, np.inf)
    for again in (False, True):
        found = linearised(body, here)
        eliminated = _eliminated(body, found)
        way = None if eliminated is None else _way(body, here, eliminated, nothing)
        if way is None:
            return np.full(3, np.inf), 0.0
        q = way[1]
        if again:
            break
        moved = _moved(body, here, way, found.T)
        if moved is None or not np.array_equal(moved.q, q):
            return np.full(3, np.inf), 0.0
        here = moved
    return q, here.min_J


def linearised(body: Bonded, state: State) -> Linear:
    """Return gradient and stiffness of a layer about a state."""
    found = body.element.tangent(body.mesh, body.law, body.K, state.u, state.p)
    first, second = bonded_tangent(body.X, float(state.q[2]))
    _, slope, curvature = load_potential(state.load, body.height, state.q)
    terms = [part(state.u, state.q) for part in body.parts]
    forces = np.concatenate([found.forces, np.zeros(3)]) + sum(term.forces for term in terms)
    values = np.concatenate([found.stiffness.ravel(), *(term.values for term in terms)])
    T = np.concatenate([first.reshape(-1, 3), np.eye(3)])
    pattern = body.pattern
    turning = float(np.sum(forces[body.bonded] * second)) + curvature
    return Linear(forces[pattern.free], T.T @ forces[pattern.border] + slope, values, T, turning, found.energy)


def _eliminated(body: Bonded, found: Linear) -> tuple[Array, Array, Array] | None:
    """Stiffness on q, forces on q, and the free displacements by (q, 1), all others eliminated; None if singular."""
    K, C, D = body.pattern.equations(found.values, found.T)
    D[2, 2] += found.turning
    X = solved_in_order(K, np.column_stack([-C, -found.gradient]))
    if X is None:
        return None
    S = D + C.T @ X[:, :3]
    return 0.5 * (S + S.T), found.on_target + C.T @ X[:, 3], X


def _way(body: Bonded, here: State, eliminated: tuple[Array, Array, Array], aim: tuple[Array, Held]) -> _Step | None:
    """Newton's step: of q where it is free, of the forces where it is held; None where there is none."""
    (S, g, X), (gap, held) = eliminated, aim
    cos, sin = np.cos(here.q[2]), np.sin(here.q[2])
    forces = np.array([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-body.height * cos, -body.height * sin, -1.0]])
    try:
        found = np.linalg.solve(np.where(held, forces, S), -g - S @ gap)
    except np.linalg.LinAlgError:
        return None
    dq = np.where(held, gap, found)
    return X[:, :3] @ dq + X[:, 3], dq, np.where(held, found, 0.0)


def solved(A: sparse.csc_matrix, b: Array) -> Array | None:
    """Return the solution of one sparse system; None where it is singular."""
    try:
        factor = splu(A, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.01)
    except RuntimeError:
        return None
    x = factor.solve(b)
    return x if np.all(np.isfinite(x)) else None


def _moved(body: Bonded, here: State, way: _Step, T: Array) -> State | None:
    """State after the longest part of a step that keeps every point well above inversion."""
    dx, dq, forces = way
    linear = np.zeros_like(here.u)
    linear[body.pattern.free] = dx
    linear[body.bonded.ravel()] = T[:-3] @ dq
    F, J = body.element.deformation(body.mesh, here.u)
    B, dofs = body.mesh.B, body.mesh.dofs
    dF = (B.reshape(len(J), -1, dofs.shape[1]) @ linear[dofs][:, :, None]).reshape(F.shape)
    volume = J - 1.0 + (body.element.cofactor(F) * dF).sum(axis=-1)
    p_full = body.K * (body.mesh.chi @ volume[:, :, None])[..., 0]
    part = 1.0
    while part > 1e-3:
        u, q = here.u + part * linear, here.q + part * dq
        u[body.bonded] = bonded_displacement(body.X, q)
        min_J = smallest_volume(body, u, everywhere=False)
        if min_J > _MIN_J_KEPT * min(here.min_J, 1.0):
            p = here.p + part * (p_full - here.p)
            return replace(here, u=u, q=q, p=p, min_J=min_J, load=here.load + part * forces)
        part *= _SHORTEN
    return None
