"""How is a deformed layer brought to rest? Newton's method on displacement, pressure, and what is held of the target.

The unknowns x are the free nodal displacements and the target's q = (d_h, d_z, alpha). With T = d u_bonded / dq the
gradient and tangent of the total potential (body.py) are

    g = (f_free, T^T f_bonded + f_q + dV/dq),      A = P^T K(u, p) P + (f_bonded . d2u/dalpha2 + V'') on alpha,

P the map from dx to du. The pressure p of the geometric stiffness is an unknown of its own, eliminated in the element:
each step moves it with the linearised volume, ``p <- K pi(J - 1 + H : dF)``, which is Newton's method on the mixed
problem. (With p taken from the current volume, K (J - 1), it would be Newton on a stiff penalty energy, and creep.)

Mixed control: of each pair F_x, d_h; F_z, d_z; M, alpha, one is given. Where the place is given (`held`), it changes
sides with its force: the force's column ``dg/dF`` takes the place's column in A, so that turning points of the load are
nothing special. A step that would turn a quadrature point inside out is shortened.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from sits_mech.mechanics.body import Bonded, State, rest, smallest_volume
from sits_mech.mechanics.target import bonded_displacement, bonded_tangent, load_potential
from sits_mech.quantities import Array

Held = NDArray[np.bool_]

FREE: Held = np.zeros(3, dtype=bool)
"""No component of the target's place is held."""
SETTLED = 1e-9
"""Residual, over the load's size or the share of K below which rounding would rule, of a state at rest."""
MOST = 14
"""Iterations after which an increment is given up."""

_ROUNDING = 1e-5
_SHORTEN = 0.5
_MIN_J_KEPT = 0.2  # a step may not shrink the smallest volume ratio below this fraction of its value


def newton(body: Bonded, start: State, goal: Array, held: Held = FREE) -> State:
    """Iterate to rest under one goal; the result's residual says whether it settled.

    Parameters
    ----------
    body : Bonded
    start : State
    goal : ndarray, shape (3,)
        F_x, F_z, M; where `held`, d_h, d_z, alpha instead; scaled.
    held : ndarray of bool, shape (3,)
    """
    here = replace(start, load=np.where(held, start.load, goal))
    for count in range(MOST + 1):
        gradient, A, P = linearised(body, here)
        gap = np.where(held, goal - here.q, 0.0)
        size = max(float(np.linalg.norm(here.load)), _ROUNDING * body.K)
        left = float(np.linalg.norm(gradient)) / size + float(np.abs(gap).max())
        here = replace(here, residual=left, iterations=count)
        if left <= SETTLED or not np.isfinite(left) or count == MOST:
            break
        right = -gradient
        if held.any():
            right = right - A[:, -3:] @ gap
            A = _exchanged(body, here, A, held)
        step = solved(A, right)
        moved = None if step is None else _moved(body, here, (step, gap, held), P)
        if moved is None:
            break
        here = moved
    return here


def compliance(body: Bonded, state: State, load: Array) -> Array:
    """Return d(d_h, d_z, alpha) by the target's forces and moment about a state at rest; nan where there is none."""
    return responses(body, replace(state, load=load), FREE)


def responses(body: Bonded, state: State, held: Held) -> Array:
    """Return what each free component of the target moves by for unit forces on them; nan where nothing resists."""
    A = linearised(body, state)[1]
    if held.any():
        A = _exchanged(body, state, A, held)
    unit = np.zeros((A.shape[0], 3))
    unit[-3:] = np.eye(3)
    moved = solved(A, unit[:, ~held])
    count = int(np.count_nonzero(~held))
    return np.full((count, count), np.nan) if moved is None else moved[-3:][~held]


def stable(body: Bonded, state: State, held: Held = FREE) -> bool:
    """Say whether the target at rest withstands any small push on what is not held of it.

    Its compliance is positive definite then. A crease that forms at a corner, which hardly moves the target, does not
    count.
    """
    if held.all():
        return True
    C = responses(body, state, held)
    return bool(np.all(np.isfinite(C))) and bool(np.linalg.eigvalsh(0.5 * (C + C.T))[0] > 0.0)


def correction(body: Bonded, load: Array) -> tuple[Array, float]:
    """Return how far a second Newton step from rest moves q, and the smallest J before it; infinite if inverted."""
    fixed = replace(rest(body), load=load)
    gradient, A, P = linearised(body, fixed)
    step = solved(A, -gradient)
    moved = None if step is None else _moved(body, fixed, (step, np.zeros(3), FREE), P)
    if step is None or moved is None or not np.array_equal(moved.q, step[-3:]):
        return np.full(3, np.inf), 0.0
    gradient, A, _ = linearised(body, moved)
    again = solved(A, -gradient)
    return (np.full(3, np.inf) if again is None else again[-3:]), moved.min_J


def linearised(body: Bonded, state: State) -> tuple[Array, sparse.csc_matrix, sparse.csr_matrix]:
    """Return gradient, tangent, and the map P from the unknowns to the nodal displacements and q."""
    found = body.element.tangent(body.mesh, body.law, body.K, state.u, state.p)
    T, second = bonded_tangent(body.X, float(state.q[2]))
    _, slope, curvature = load_potential(state.load, body.height, state.q)
    n, count = len(state.u), len(body.free)
    last, three = count + np.arange(3), n + np.arange(3)
    P = sparse.csr_matrix(
        (
            np.concatenate([np.ones(count), T.ravel(), np.ones(3)]),
            (
                np.concatenate([body.free, np.repeat(body.bonded.ravel(), 3), three]),
                np.concatenate([np.arange(count), np.tile(last, body.bonded.size), last]),
            ),
        ),
        shape=(n + 3, count + 3),
    )
    terms = [part(state.u, state.q) for part in body.parts]
    forces = np.concatenate([found.forces, np.zeros(3)]) + sum(term.forces for term in terms)
    values = np.concatenate([found.stiffness.ravel(), *(term.values for term in terms)])
    rows = np.concatenate([body.rows, *(term.rows for term in terms)])
    columns = np.concatenate([body.columns, *(term.columns for term in terms)])
    K = sparse.csr_matrix((values, (rows, columns)), shape=(n + 3, n + 3))
    turning = float(np.sum(forces[body.bonded] * second)) + curvature
    A = P.T @ K @ P + sparse.csr_matrix(([turning], ([count + 2], [count + 2])), shape=(count + 3, count + 3))
    gradient = P.T @ forces
    gradient[-3:] += slope
    return gradient, A.tocsc(), P


def solved(A: sparse.csc_matrix, b: Array) -> Array | None:
    """Return the solution of one sparse system; None where it is singular."""
    try:
        factor = splu(A, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.01)
    except RuntimeError:
        return None
    x = factor.solve(b)
    return x if np.all(np.isfinite(x)) else None


def _exchanged(body: Bonded, state: State, A: sparse.csc_matrix, held: Held) -> sparse.csc_matrix:
    """A with the columns of held places replaced by those of their forces."""
    cos, sin = np.cos(state.q[2]), np.sin(state.q[2])
    forces = np.array([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-body.height * cos, -body.height * sin, -1.0]])
    m = A.shape[0]
    places = m - 3 + np.flatnonzero(held)
    kept = np.ones(m)
    kept[places] = 0.0
    rows = np.repeat(m - 3 + np.arange(3), len(places))
    put = sparse.csc_matrix((forces[:, held].ravel(), (rows, np.tile(places, 3))), shape=(m, m))
    exchanged: sparse.csc_matrix = (A @ sparse.diags(kept) + put).tocsc()
    return exchanged


def _moved(body: Bonded, here: State, way: tuple[Array, Array, Held], P: sparse.csr_matrix) -> State | None:
    """State after the longest part of a step that keeps every point well above inversion."""
    step, gap, held = way
    dq, forces = np.where(held, gap, step[-3:]), np.where(held, step[-3:], 0.0)
    linear = (P @ np.concatenate([step[:-3], dq]))[:-3]
    F, J = body.element.deformation(body.mesh, here.u)
    B, dofs = body.mesh.B, body.mesh.dofs
    dF = (B.reshape(len(J), -1, dofs.shape[1]) @ linear[dofs][:, :, None]).reshape(F.shape)
    volume = J - 1.0 + np.einsum("eqi,eqi->eq", body.element.cofactor(F), dF)
    p_full = body.K * np.einsum("emq,eq->em", body.mesh.chi, volume)
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
