"""How is a deformed layer brought to rest? Newton's method on displacement, pressure, and the target's motion.

The unknowns are the free nodal displacements and the components of the target's motion q that the body frees. With
T = d u_bonded/dq the gradient and tangent of the total potential (body.py) are

    g = (f_free, T^T f_bonded + f_q - work of the load),      A = (K, C; C^T, D + turning),

K, C, D from element/assembly.py, loads and turning from target.py. The pressure p of the geometric stiffness is an
unknown of its own, eliminated in the element: each step moves it with the linearised volume, ``p <- K pi(J - 1 + H :
dF)``, which is Newton's method on the mixed problem. (With p taken from the current volume, K (J - 1), it would be
Newton on a stiff penalty energy, and creep.) Near the rest, where steps are small, a factor serves several of them.

Mixed control: of each pair F_x, d_h; F_z, d_z; M, alpha; ... one is given. Where the place is given (`held`), it
changes sides with its force: the force's column ``dg/dF`` takes the place's column in S, the stiffness that is left
when all but q is eliminated, so that turning points of the load are nothing special. S says whether the target stands
stable, too: where its symmetric part is positive definite no small push does negative work. A step that would turn a
quadrature point inside out is shortened.

Source: P. Wriggers, Nonlinear Finite Element Methods (2008), chapter 5; R. de Borst et al., Non-linear Finite Element
Analysis of Solids and Structures (2012), chapter 4, for mixed control.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sits_mech.mechanics.element.assembly import Factored, Pattern, Stiffness, Term
from sits_mech.mechanics.element.kernel import (
    deformed,
    element_forces,
    element_stiffness,
    gradients,
    kinematics,
    volumes,
)
from sits_mech.mechanics.element.mesh import Indices
from sits_mech.mechanics.element.target import (
    between,
    bonded_displacement,
    bonded_tangent,
    moved,
    turning,
    work_of_load,
)
from sits_mech.mechanics.rest.body import Bonded, State, deformed_state, rest, smallest_volume
from sits_mech.quantities import Array

Held = NDArray[np.bool_]

SETTLED = 1e-9
"""Residual, over the load's size or the share of K below which rounding would rule, of a state at rest."""
MOST = 16
"""Iterations after which an increment is given up."""

_ROUNDING = 1e-5
_NEAR = 3e-3  # residual from which one more step leaves the target's stiffness as it is
_AGAIN = 0.1  # share of the residual that a step with an older factor must leave at most for the factor to serve on
_SHORTEN = 0.5
_MIN_J_KEPT = 0.2  # a step may not shrink the smallest volume ratio below this fraction of its value


class Settled(NamedTuple):
    """Where Newton's method ended; there or near by, the stiffness that the target feels: None where not known.

    The second stiffness is that on the motion which a symmetry hides; None where it hides nothing.
    """

    state: State
    stiffness: Array | None
    hidden: Array | None = None


class _Gradient(NamedTuple):
    """Forces on displacements and q, what they leave on the free displacements and on q, energy, terms of the parts."""

    forces: Array
    free: Array
    target: Array
    energy: float
    terms: list[Term]


class _Linear(NamedTuple):
    """What a linearisation is made of: numbers and values of the stiffnesses, the border by (dc, dw), turning."""

    numbers: tuple[Indices, ...]
    values: Stiffness
    T: Array
    turning: Array


class _Factor(NamedTuple):
    """A linearisation, factored on the free displacements: these by q, the side C, the stiffness on q.

    Then what was left on the free displacements, and the step that takes it away while q stays; what it was made of.
    """

    of_free: Factored
    by_q: Array
    side: Array
    stiffness: Array
    left: Array
    step: Array
    made: _Linear


def newton(body: Bonded, start: State, goal: Array, held: Held | None = None, *, until: float = SETTLED) -> Settled:
    """Iterate to rest under one goal; the result's residual says whether it settled.

    Parameters
    ----------
    body : Bonded
    start : State
    goal : ndarray, shape (k,)
        F_x, F_z, M, ... for each component that the body frees; where `held`, d_h, d_z, alpha, ... instead; scaled.
    held : ndarray of bool, shape (k,), optional
        Which of the target's places are given instead of the force; none by default.
    until : float
        Residual at which to stop.
    """
    held = np.zeros(body.components, dtype=bool) if held is None else held
    known = deformed_state(body, start)
    here, before, near = replace(start, load=np.where(held, start.load, goal), known=known), np.inf, np.inf
    factor: _Factor | None = None
    for count in range(MOST + 1):
        found = _gradient(body, here)
        gap = np.where(held, between(here.q, np.where(held, goal, here.q)), 0.0)
        left = _residual(body, here, found, gap, until)
        here = replace(here, residual=left, iterations=count)
        if left <= until or not np.isfinite(left) or count == MOST:
            break
        if factor is None or near > _NEAR or left > _AGAIN * before:
            factor = None  # its memory is needed for the next one
            factor, near = _factored(body, here, found), left
        before = left
        stepped = None if factor is None else _stepped(body, here, found, factor, (gap, held))
        if stepped is None:
            break
        here = stepped
    if factor is None or near > _NEAR:
        return Settled(here, None)
    stiffness, made, factor = factor.stiffness, factor.made, None
    return Settled(here, stiffness, _hidden(body, made))


def compliance(body: Bonded, state: State, load: Array) -> Array:
    """Return d(motion) by the target's forces and moments about a state at rest, shape (k, k); nan where none."""
    try:
        return np.asarray(np.linalg.inv(target_stiffness(body, replace(state, load=load))[0]))
    except np.linalg.LinAlgError:
        return np.full((body.components, body.components), np.nan)


def target_stiffness(body: Bonded, state: State) -> tuple[Array, Array | None]:
    """Return the stiffness that the target has, d(forces on q) by q, and that on motion which a symmetry hides.

    nan where there is none; the second is None where nothing is hidden.
    """
    factor = _factored(body, state, _gradient(body, state))
    if factor is None:
        none = np.full((body.components, body.components), np.nan)
        return none, None if body.hidden is None else none
    stiffness, made, factor = factor.stiffness, factor.made, None
    return stiffness, _hidden(body, made)


def stable(stiffness: Array, held: Held | None = None) -> bool:
    """Say whether the target at rest withstands any small push on what is not held of it, by its stiffness.

    The symmetric part is positive definite then. A crease that forms at a corner, which hardly moves the target, does
    not count.
    """
    S = stiffness if held is None else stiffness[np.ix_(~held, ~held)]
    return bool(np.all(np.isfinite(S)) and np.all(np.linalg.eigvalsh(0.5 * (S + S.T)) > 0.0))


def correction(body: Bonded, load: Array) -> tuple[Array, float]:
    """Return how far a second Newton step from rest moves q, and the smallest J before it; infinite if inverted."""
    here, held = replace(rest(body), load=load), (np.zeros(3), np.zeros(3, dtype=bool))
    for again in (False, True):
        found = _gradient(body, here)
        factor = _factored(body, here, found)
        if factor is None:
            break
        way = _way(body, here, found, factor, held)
        if way is None:
            break
        if again:
            return way[1], here.min_J
        after = _stepped(body, here, found, factor, held)
        if after is None or not np.array_equal(after.q, moved(here.q, way[1])):
            break
        here = after
    return np.full(3, np.inf), 0.0


def _residual(body: Bonded, here: State, found: _Gradient, gap: Array, until: float) -> float:
    """Norm of the gradient over the size of the load; infinite at rest beyond the stretch at which the law locks."""
    size = max(float(np.linalg.norm(here.load)), _ROUNDING * body.K)
    left = float(np.hypot(np.linalg.norm(found.free), np.linalg.norm(found.target))) / size
    left += float(np.abs(gap).max())
    return left if left > until or np.isfinite(found.energy) else np.inf


def _gradient(body: Bonded, here: State) -> _Gradient:
    """Forces of a layer with its parts, and what is left of them."""
    found = element_forces(body.mesh, body.law, body.K, here.u, deformed_state(body, here))
    terms = [part(here.u, here.q) for part in body.parts]
    forces = np.concatenate([found.forces, np.zeros(6)]) + sum(term.forces for term in terms)
    pattern, k = body.pattern, body.components
    on_target = _border_by_q(body, here.q)[:, :k].T @ forces[pattern.border]
    on_target = on_target - work_of_load(here.load, body.height, here.q)[:k]
    energy = found.energy + sum(term.energy for term in terms)
    return _Gradient(forces, forces[pattern.free], on_target, energy, terms)


def _border_by_q(body: Bonded, q: Array) -> Array:
    """How the border, bonded displacements and q, goes with (dc, dw), shape (b, 6)."""
    T = bonded_tangent(body.X, q)[:, list(body.mesh.axes)]
    return np.concatenate([T.reshape(-1, 6), np.eye(6)])


def _factored(body: Bonded, here: State, found: _Gradient) -> _Factor | None:
    """Linearise about a state and eliminate the free displacements; None if singular."""
    stiffness = element_stiffness(body.mesh, body.law, body.K, here.u, here.p, deformed_state(body, here))
    values = (stiffness, *(term.stiffness for term in found.terms))
    on_bonded = np.zeros((len(body.bonded), 3))
    on_bonded[:, list(body.mesh.axes)] = found.forces[body.bonded]
    T, extra = _border_by_q(body, here.q), turning(on_bonded, body.X, here.load, body.height, here.q)
    numbers = (body.mesh.dofs, *(term.numbers for term in found.terms))
    made = _Linear(numbers, values, T, extra)
    return _eliminated(body.pattern, made, slice(0, body.components), found.free)


def _eliminated(pattern: Pattern, made: _Linear, freed: slice, left: Array) -> _Factor | None:
    """Eliminate the free displacements, and what is left on them, from the freed components of (dc, dw)."""
    pattern = pattern.following(made.numbers)
    factored = pattern.factored(made.values)
    if factored is None:
        return None
    C, D = pattern.sides(made.values, made.T[:, freed])
    found = factored.solve(-np.column_stack([C, left]))
    by_q, step = found[:, :-1], found[:, -1]
    if not np.all(np.isfinite(by_q)):
        return None
    return _Factor(factored, by_q, C, D + made.turning[freed, freed] + C.T @ by_q, left, step, made)


def _hidden(body: Bonded, made: _Linear) -> Array | None:
    """Stiffness on what a symmetry hides, displacements odd in y and the other three components of the motion."""
    if body.hidden is None:
        return None
    pattern = body.hidden()
    found = _eliminated(pattern, made, slice(3, 6), np.zeros(len(pattern.free)))
    return np.full((3, 3), np.nan) if found is None else found.stiffness


def _way(
    body: Bonded, here: State, found: _Gradient, factor: _Factor, aim: tuple[Array, Held]
) -> tuple[Array, Array, Array] | None:
    """Newton's step of the free displacements, of q where it is free, of the forces where it is held."""
    (gap, held), k = aim, body.components
    dx = factor.step if found.free is factor.left else factor.of_free.solve(-found.free)
    left = -(found.target + factor.side.T @ dx)
    matrix = factor.stiffness
    if held.any():
        by_load = -np.stack([work_of_load(unit, body.height, here.q)[:k] for unit in np.eye(k)], axis=1)
        matrix = np.where(held, by_load, matrix)
    try:
        step = np.linalg.solve(matrix, left - factor.stiffness @ gap)
    except np.linalg.LinAlgError:
        return None
    if not (np.all(np.isfinite(dx)) and np.all(np.isfinite(step))):
        return None
    dq = np.where(held, gap, step)
    return dx + factor.by_q @ dq, dq, np.where(held, step, 0.0)


def _stepped(
    body: Bonded, here: State, found: _Gradient, factor: _Factor, aim: tuple[Array, Held]
) -> State | None:
    """State after the longest part of Newton's step that keeps every point well above inversion; None without one."""
    way = _way(body, here, found, factor, aim)
    if way is None:
        return None
    dx, dq, forces = way
    mesh, axes = body.mesh, list(body.mesh.axes)
    linear = np.zeros_like(here.u)
    linear[body.pattern.free] = dx
    linear[body.bonded.ravel()] = factor.made.T[: body.bonded.size, : body.components] @ dq
    _, F, J = deformed_state(body, here)
    volume = J - 1.0 + (kinematics(F).H * gradients(mesh, linear)).sum(axis=-1)
    p_full, part = body.K * volumes(mesh, volume), 1.0
    while part > 1e-3:
        u, q = here.u + part * linear, moved(here.q, part * dq)
        u[body.bonded] = bonded_displacement(body.X, q)[:, axes]
        known = deformed(mesh, u)
        min_J = smallest_volume(body, u, everywhere=False, known=known)
        if min_J > _MIN_J_KEPT * min(here.min_J, 1.0):
            p = here.p + part * (p_full - here.p)
            return replace(here, u=u, q=q, p=p, min_J=min_J, load=here.load + part * forces, known=known)
        part *= _SHORTEN
    return None
