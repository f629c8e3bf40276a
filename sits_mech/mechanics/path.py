"""How is a deformed layer brought to rest under a load? Newton's method on mixed elements, along an adaptive load path.

The total potential is ``E(u) + V(q)`` (forms.py, target.py). Its unknowns x are the free nodal displacements and the
target's q = (d_h, d_z, alpha); the bonded nodes follow q exactly. With T = d u_bonded / dq the gradient and tangent are

    g = (f_free, T^T f_bonded + dV/dq),      A = P^T K(u, p) P + (f_bonded . d2u/dalpha2 + V'') on alpha,

P the map from dx to du. The pressure p of the geometric stiffness is an unknown of its own, eliminated in the element:
each step moves it with the linearised volume, ``p <- K pi(J - 1 + H : dF)``, which is Newton's method on the mixed
problem. (With p taken from the current volume, K (J - 1), it would be Newton on a stiff penalty energy, and creep.)

A step that would turn a quadrature point inside out is shortened; one that does not settle is cut, and the load path
from the last state at rest goes on with a smaller increment, which grows again where it is easy. A state at rest counts
only where the target is stable: beyond its critical load a layer buckles, though Newton finds it upright. Scales:
forms.py.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from sits_mech.mechanics.block_energy import SolidEnergy
from sits_mech.mechanics.energy import PlaneEnergy
from sits_mech.mechanics.forms import Indices, Section, Tangent, deformation, plane_cofactor, tangent
from sits_mech.mechanics.target import bonded_displacement, bonded_tangent, load_potential
from sits_mech.quantities import Array

_SETTLED = 1e-9  # residual over the load's size, or over the share of K below which rounding would rule
_ROUNDING = 1e-5
_ITERATIONS = 14  # of Newton's method in one load step
_EASY = 5  # iterations up to which the next increment grows
_STEPS = 400
_SHORTEN = 0.5
_MIN_J_KEPT = 0.2  # a step may not shrink the smallest volume ratio below this fraction of its value


class Element(NamedTuple):
    """What a mesh of one kind of element answers: linearisation, ``F`` and ``J``, and ``H = dJ/dF`` of F."""

    tangent: Callable[..., Tangent]
    deformation: Callable[[Section, Array], tuple[Array, Array]]
    cofactor: Callable[[Array], Array]


PLANE = Element(tangent, deformation, plane_cofactor)
"""Plane strain, forms.py."""


@dataclass(frozen=True)
class Bonded:
    """A meshed layer with its target and its law: all that stays the same from load to load.

    Attributes
    ----------
    mesh : Section
    law : callable
        Isochoric energy.
    K : float
        Bulk modulus [shear moduli].
    height : float
        Where the force acts above the bonded face [thicknesses].
    free : ndarray
        Numbers of the displacements that are unknown.
    bonded : ndarray, shape (n, 2)
        Numbers of the bonded nodes' displacements along x and z.
    X : ndarray, shape (n,)
        Their distances from the target's centre [thicknesses].
    rows, columns : ndarray
        Sparsity of the element stiffnesses.
    element : Element
        What the mesh is made of.
    """

    mesh: Section
    law: PlaneEnergy | SolidEnergy
    K: float
    height: float
    free: Indices
    bonded: Indices
    X: Array
    rows: Indices
    columns: Indices
    element: Element = PLANE


@dataclass(frozen=True)
class State:
    """A layer in a deformed state, not necessarily at rest.

    Attributes
    ----------
    u : ndarray, shape (d n,)
        Nodal displacements [thicknesses].
    q : ndarray, shape (3,)
        Shear, upward displacement [thicknesses], clockwise rotation [rad].
    p : ndarray, shape (e, d + 1)
        Pressures [shear moduli].
    residual : float
        Norm of the gradient over the size of the load.
    iterations : int
        Linear solves spent.
    min_J : float
        Smallest volume ratio at a quadrature point.
    """

    u: Array
    q: Array
    p: Array
    residual: float = 0.0
    iterations: int = 0
    min_J: float = 1.0


@dataclass(frozen=True)
class Outcome:
    """Where a load path ended.

    Attributes
    ----------
    state : State
        The last state at rest.
    reached : float
        Fraction of the path it stands at; 1 is the whole load.
    buckled : bool
        Whether the path ended where the target is not stable.
    """

    state: State
    reached: float
    buckled: bool = False


def rest(body: Bonded) -> State:
    """Return the undeformed state."""
    return State(np.zeros(body.mesh.nodes.size), np.zeros(3), np.zeros(body.mesh.chi.shape[:2]))


def packed(state: State) -> Array:
    """Return a state's displacements, q and pressures as one array."""
    return np.concatenate([state.u, state.q, state.p.ravel()])


def follow(body: Bonded, start: State, loads: tuple[Array, Array], *, smallest: float = 1e-3) -> Outcome:
    """Follow the straight load path from a state at rest.

    Parameters
    ----------
    body : Bonded
    start : State
        At rest under the first load.
    loads : tuple of ndarray, shape (3,)
        F_x, F_z, M at the start and at the end, scaled.
    smallest : float
        Increment, as a fraction of the path, below which the path is given up.

    Returns
    -------
    Outcome
        With ``reached == 1`` where the whole load is carried.
    """
    here, at, increment = start, 0.0, 1.0
    spent, buckled = start.iterations, False
    for _ in range(_STEPS):
        target = min(1.0, at + increment)
        trial = newton(body, replace(here, iterations=0), (1.0 - target) * loads[0] + target * loads[1])
        spent += trial.iterations
        settled = trial.residual <= _SETTLED
        buckled = settled and not stable(body, trial, (1.0 - target) * loads[0] + target * loads[1])
        if settled and not buckled:
            here, at = replace(trial, iterations=spent), target
            increment *= 2.0 if trial.iterations <= _EASY else 1.0
            if at == 1.0:
                break
        else:
            increment *= 0.25 if trial.iterations < _ITERATIONS else 0.5
            if increment < smallest:
                break
    return Outcome(replace(here, iterations=spent), at, buckled)


def newton(body: Bonded, start: State, load: Array) -> State:
    """Iterate to rest under one load; the result's residual says whether it settled."""
    here = start
    size = max(float(np.linalg.norm(load)), _ROUNDING * body.K)
    for count in range(_ITERATIONS + 1):
        gradient, A, P = _linearised(body, here, load)
        here = replace(here, residual=float(np.linalg.norm(gradient)) / size, iterations=count)
        if here.residual <= _SETTLED or not np.isfinite(here.residual) or count == _ITERATIONS:
            break
        step = _solved(A, -gradient)
        if step is None:
            break
        moved = _moved(body, here, step, P)
        if moved is None:
            break
        here = moved
    return replace(here, iterations=count)


def stiffness(body: Bonded, state: State, load: Array) -> sparse.csc_matrix:
    """Return the tangent of a state; the target's q are the last three unknowns."""
    return _linearised(body, state, load)[1]


def compliance(body: Bonded, state: State, load: Array) -> Array:
    """Return d(d_h, d_z, alpha) by the target's forces and moment about a state at rest; nan where there is none."""
    A = stiffness(body, state, load)
    unit = np.zeros((A.shape[0], 3))
    unit[-3:] = np.eye(3)
    moved = _solved(A, unit)
    return np.full((3, 3), np.nan) if moved is None else moved[-3:]


def stable(body: Bonded, state: State, load: Array) -> bool:
    """Say whether the target at rest withstands any small push: its compliance is positive definite.

    A crease that forms at a corner, which hardly moves the target, does not count.
    """
    C = compliance(body, state, load)
    return bool(np.all(np.isfinite(C))) and bool(np.linalg.eigvalsh(0.5 * (C + C.T))[0] > 0.0)


def correction(body: Bonded, load: Array) -> tuple[Array, float]:
    """Return how far a second Newton step from rest moves q, and the smallest J before it; infinite if inverted."""
    fixed = rest(body)
    gradient, A, P = _linearised(body, fixed, load)
    step = _solved(A, -gradient)
    moved = None if step is None else _moved(body, fixed, step, P)
    if step is None or moved is None or not np.array_equal(moved.q, step[-3:]):
        return np.full(3, np.inf), 0.0
    gradient, A, _ = _linearised(body, moved, load)
    again = _solved(A, -gradient)
    return (np.full(3, np.inf) if again is None else again[-3:]), moved.min_J


def _linearised(body: Bonded, state: State, load: Array) -> tuple[Array, sparse.csc_matrix, sparse.csr_matrix]:
    """Gradient, tangent, and the map P from the unknowns to the nodal displacements."""
    found = body.element.tangent(body.mesh, body.law, body.K, state.u, state.p)
    T, second = bonded_tangent(body.X, float(state.q[2]))
    _, slope, curvature = load_potential(load, body.height, state.q)
    n, count = len(state.u), len(body.free)
    P = sparse.csr_matrix(
        (
            np.concatenate([np.ones(count), T.ravel()]),
            (
                np.concatenate([body.free, np.repeat(body.bonded.ravel(), 3)]),
                np.concatenate([np.arange(count), np.tile(count + np.arange(3), body.bonded.size)]),
            ),
        ),
        shape=(n, count + 3),
    )
    K = sparse.csr_matrix((found.stiffness.ravel(), (body.rows, body.columns)), shape=(n, n))
    turning = float(np.sum(found.forces[body.bonded] * second)) + curvature
    A = P.T @ K @ P + sparse.csr_matrix(([turning], ([count + 2], [count + 2])), shape=(count + 3, count + 3))
    gradient = P.T @ found.forces
    gradient[-3:] += slope
    return gradient, A.tocsc(), P


def _solved(A: sparse.csc_matrix, b: Array) -> Array | None:
    """Solution of one symmetric system; None where it is singular."""
    try:
        factor = splu(A, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.01)
    except RuntimeError:
        return None
    x = factor.solve(b)
    return x if np.all(np.isfinite(x)) else None


def _moved(body: Bonded, here: State, step: Array, P: sparse.csr_matrix) -> State | None:
    """State after the longest part of a step that keeps every quadrature point well above inversion."""
    linear = P @ step
    F, J = body.element.deformation(body.mesh, here.u)
    B, dofs = body.mesh.B, body.mesh.dofs
    dF = (B.reshape(len(J), -1, dofs.shape[1]) @ linear[dofs][:, :, None]).reshape(F.shape)
    volume = J - 1.0 + np.einsum("eqi,eqi->eq", body.element.cofactor(F), dF)
    p_full = body.K * np.einsum("emq,eq->em", body.mesh.chi, volume)
    part = 1.0
    while part > 1e-3:
        u, q = here.u + part * linear, here.q + part * step[-3:]
        u[body.bonded] = bonded_displacement(body.X, q)
        _, J_new = body.element.deformation(body.mesh, u)
        min_J = float(J_new.min())
        if min_J > _MIN_J_KEPT * min(here.min_J, 1.0):
            return replace(here, u=u, q=q, p=here.p + part * (p_full - here.p), min_J=min_J)
        part *= _SHORTEN
    return None
