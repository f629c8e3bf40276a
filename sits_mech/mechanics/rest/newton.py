"""How is a deformed layer brought to rest? Newton's method on displacement, pressure, and the target's motion.

The unknowns are the free nodal displacements and the components of the target's motion q that the body frees. With
T = d u_bonded/dq the gradient and tangent of the total potential (body.py) are

    g = (f_free, T^T f_bonded + f_q - work of the load),      A = (K, C; C^T, D + turning),

K, C, D from element/assembly.py, loads and turning from target.py. The pressure p of the geometric stiffness is an
unknown of its own, eliminated in the element: each step moves it with the linearised volume, ``p <- K pi(J - 1 + H :
dF)``, which is Newton's method on the mixed problem. (With p taken from the current volume, K (J - 1), it would be
Newton on a stiff penalty energy, and creep.) Near the rest, where steps are small, a factor serves several of them.

Mixed control: of each pair F_x, d_h; F_z, d_z; M, alpha; ... one is given, and along a path it goes with the part t of
the path. With S, the stiffness that is left when all but q is eliminated, a step (dq, dF, dt) is that of

    S dq - (work of dF) = what is left of the forces on q,
    dq_i = slope_i dt + gap_i   of a place that is given,      dF_i = slope_i dt   of a force,
    dt = 0    or, where t is found,    normal . dq = what is left of the way to a plane across the path (`Arc`),

so that turning points of the load are nothing special. S says whether the target stands stable, too: where its
symmetric part is positive definite no small push does negative work. A step that would turn a quadrature point inside
out is shortened. What leads nowhere ends early: a first step longer than linear theory could mean, and a residual that
does not fall.

Source: P. Wriggers, Nonlinear Finite Element Methods (2008), chapter 5; R. de Borst et al., Non-linear Finite Element
Analysis of Solids and Structures (2012), chapter 4, for mixed control; E. Riks, Int. J. Solids Struct. 15 (1979) 529,
for the plane across the path.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sits_mech.mechanics.element.assembly import Pattern, Stiffness, Term
from sits_mech.mechanics.element.kernel import (
    deformation,
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
from sits_mech.mechanics.rest.body import Bonded, State, rest, smallest_volume
from sits_mech.quantities import Array

Held = NDArray[np.bool_]

SETTLED = 1e-9
"""Residual, over the load's size or the share of K below which rounding would rule, of a state at rest."""
MOST = 16
"""Iterations after which an increment is given up."""
LONGEST = 1.5
"""Way of the target's edge in the first step of an increment beyond which it is not begun [thicknesses]."""

_ROUNDING = 1e-5
_NEAR = 3e-3  # residual from which one more step leaves the target's stiffness as it is
_AGAIN = 0.1  # share of the residual that a step with an older factor must leave at most for the factor to serve on
_SHORTEN = 0.5
_PATIENCE = 8  # iterations after which the residual must lie below its first value
_CHORD = 0.3  # a step that is shorter than this share of the one before is followed by one with the same factor
_MOST_CORRECTIONS = 6  # steps
_WHOLE, _WILD = 0.2, 3.0  # a part of a step, and times the first one, at which corrections have come to a corner's fold
_LINEAR = 0.3  # of a step that no other could follow, what it may be off by
_MIN_J_KEPT = 0.2  # a step may not shrink the smallest volume ratio below this fraction of its value


class Settled(NamedTuple):
    """Where Newton's method ended; there or near by, the stiffness that the target feels: None where not known.

    The second stiffness is that on the motion which a symmetry hides; None where it hides nothing. `length` is the way
    of the target's edge in the first step [thicknesses], `part` how far the path went on where that was to be found.
    """

    state: State
    stiffness: Array | None
    hidden: Array | None = None
    length: float = 0.0
    part: float = 0.0


class Arc(NamedTuple):
    """A plane across a path: ``normal . (q - origin) = ahead``; `slope` is what is given, by the part of the path.

    All of shape (k,), scaled.
    """

    origin: Array
    normal: Array
    ahead: float
    slope: Array


class Approach(NamedTuple):
    """Where a target nearly rests: motion, load, by how much its edge may be off [thicknesses], steps.

    The state is None where it is no good to go on from.
    """

    state: State | None
    q: Array
    load: Array
    off: float
    iterations: int


class _Aim(NamedTuple):
    """What a step aims at: which places are held, what is left of the way to them, the arc and what is left to it."""

    held: Held
    gap: Array
    arc: Arc | None = None
    ahead: float = 0.0


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
    """A factored linearisation: solver of the free displacements, these by q, the side C, the stiffness on q.

    Then what was left on the free displacements, and the step that takes it away while q stays; what it was made of.
    """

    solve: Callable[[Array], Array]
    by_q: Array
    side: Array
    stiffness: Array
    left: Array
    step: Array
    made: _Linear


def newton(
    body: Bonded, start: State, goal: Array, held: Held | None = None, *, until: float = SETTLED, arc: Arc | None = None
) -> Settled:
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
    arc : Arc, optional
        A plane across a path from the goal on: how far to go on along the path is found, too.
    """
    held = np.zeros(body.components, dtype=bool) if held is None else held
    here, near = replace(start, load=np.where(held, start.load, goal)), np.inf
    factor: _Factor | None = None
    left: list[float] = []
    length = part = 0.0
    for count in range(MOST + 1):
        found = _gradient(body, here)
        aim = _aim(here, goal if arc is None else goal + part * arc.slope, held, arc)
        left.append(_residual(body, here, found, aim, until))
        here = replace(here, residual=left[-1], iterations=count)
        if left[-1] <= until or count == MOST or _hopeless(left):
            break
        if factor is None or near > _NEAR or left[-1] > _AGAIN * left[-2]:
            factor = None  # its memory is needed for the next one
            factor, near = _factored(body, here, found), left[-1]
        way = None if factor is None else _way(body, here, found, factor, aim)
        length = body.length(way[1]) if way is not None and not count else length
        stepped = None if factor is None or way is None or length > LONGEST else _stepped(body, here, factor, way)
        if stepped is None or way is None:
            here = replace(here, residual=np.inf, iterations=count + 1)
            break
        here, part = stepped[0], part + stepped[1] * way[3]
    if factor is None or near > _NEAR:
        return Settled(here, None, None, length, part)
    stiffness, made, factor = factor.stiffness, factor.made, None
    return Settled(here, stiffness, _hidden(body, made), length, part)


def approached(body: Bonded, start: State, goal: Array, held: Held, enough: float) -> Approach | None:
    """Return where the target of a body rests, near a state that is not far from rest; None without a step to go.

    For corrections from a coarser mesh: the target is where it rests long before the last corner is. Where a step turns
    a corner inside out the place is that after the last whole step, a part of which is what it may be off by. Arguments
    as of `newton`; steps end where one would move the target's edge by no more than `enough` [thicknesses].
    """
    here, gone = replace(start, load=np.where(held, start.load, goal)), [np.inf]
    factor: _Factor | None = None
    place: Approach | None = None
    for _ in range(_MOST_CORRECTIONS):
        found = _gradient(body, here)
        if len(gone) < 3 or gone[-1] >= _CHORD * gone[-2]:
            factor = None  # its memory is needed for the next one
            factor = _factored(body, here, found)
        way = None if factor is None else _way(body, here, found, factor, _aim(here, goal, held, None))
        if factor is None or way is None:
            break
        gone.append(body.length(way[1]))
        stepped = _stepped(body, here, factor, way)
        if place is None or (stepped is not None and stepped[1] == 1.0 and gone[-1] < gone[-2]):
            off = _LINEAR * gone[-1] if place is None else gone[-1] * min(1.0, gone[-1] / gone[-2])
            place = Approach(None, moved(here.q, way[1]), here.load + way[2], off, here.iterations + 1)
        if stepped is None or stepped[1] < _WHOLE or gone[-1] > _WILD * gone[1]:
            break
        here = replace(stepped[0], iterations=here.iterations + 1)
        if stepped[1] == 1.0 and len(gone) > 2 and place.off <= enough:
            return place._replace(state=here)
    return place


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


def rate(body: Bonded, state: State, stiffness: Array, held: Held, slope: Array) -> Array:
    """Return how q goes on with the part of a path from a state at rest, by its stiffness; nan where it cannot.

    `held` as of `newton`, `slope` as of `Arc`.
    """
    k = body.components
    matrix = _bordered(body, state.q, stiffness, held, (slope, np.zeros(k)))
    try:
        return np.asarray(np.linalg.solve(matrix, np.eye(2 * k + 1)[-1])[:k])
    except np.linalg.LinAlgError:
        return np.full(k, np.nan)


def correction(body: Bonded, load: Array) -> tuple[Array, float]:
    """Return how far a second Newton step from rest moves q, and the smallest J before it; infinite if inverted."""
    here, aim = replace(rest(body), load=load), _Aim(np.zeros(3, dtype=bool), np.zeros(3))
    for again in (False, True):
        found = _gradient(body, here)
        factor = _factored(body, here, found)
        if factor is None:
            break
        way = _way(body, here, found, factor, aim)
        if way is None:
            break
        if again:
            return way[1], here.min_J
        stepped = _stepped(body, here, factor, way)
        if stepped is None or stepped[1] < 1.0:
            break
        here = stepped[0]
    return np.full(3, np.inf), 0.0


def _aim(here: State, goal: Array, held: Held, arc: Arc | None) -> _Aim:
    """What is left of the way to the places that are held, and to the plane of an arc."""
    gap = np.where(held, between(here.q, np.where(held, goal, here.q)), 0.0)
    if arc is None:
        return _Aim(held, gap)
    return _Aim(held, gap, arc, arc.ahead - float(arc.normal @ between(arc.origin, here.q)))


def _residual(body: Bonded, here: State, found: _Gradient, aim: _Aim, until: float) -> float:
    """Norm of the gradient over the size of the load; infinite at rest beyond the stretch at which the law locks."""
    size = max(float(np.linalg.norm(here.load)), _ROUNDING * body.K)
    left = float(np.hypot(np.linalg.norm(found.free), np.linalg.norm(found.target))) / size
    left += float(np.abs(aim.gap).max()) + abs(aim.ahead)
    return left if left > until or np.isfinite(found.energy) else np.inf


def _hopeless(left: list[float]) -> bool:
    """Whether the residuals so far lead nowhere."""
    return not np.isfinite(left[-1]) or (len(left) > _PATIENCE and left[-1] > left[0])


def _gradient(body: Bonded, here: State) -> _Gradient:
    """Forces of a layer with its parts, and what is left of them."""
    found = element_forces(body.mesh, body.law, body.K, here.u)
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
    stiffness = element_stiffness(body.mesh, body.law, body.K, here.u, here.p)
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
    solve = pattern.factored(made.values)
    if solve is None:
        return None
    C, D = pattern.sides(made.values, made.T[:, freed])
    found = solve(-np.column_stack([C, left]))
    by_q, step = found[:, :-1], found[:, -1]
    if not np.all(np.isfinite(by_q)):
        return None
    return _Factor(solve, by_q, C, D + made.turning[freed, freed] + C.T @ by_q, left, step, made)


def _hidden(body: Bonded, made: _Linear) -> Array | None:
    """Stiffness on what a symmetry hides, displacements odd in y and the other three components of the motion."""
    if body.hidden is None:
        return None
    pattern = body.hidden()
    found = _eliminated(pattern, made, slice(3, 6), np.zeros(len(pattern.free)))
    return np.full((3, 3), np.nan) if found is None else found.stiffness


def _bordered(body: Bonded, q: Array, stiffness: Array, held: Held, path: tuple[Array, Array]) -> Array:
    """Equations of a step (dq, dF, dt) along a path given by slope and normal; dt is given where that is zero."""
    k, (slope, across) = body.components, path
    matrix = np.zeros((2 * k + 1, 2 * k + 1))
    matrix[:k, :k] = stiffness
    matrix[:k, k:-1] = -np.stack([work_of_load(unit, body.height, q)[:k] for unit in np.eye(k)], axis=1)
    matrix[k:-1, :k], matrix[k:-1, k:-1] = np.diag(1.0 * held), np.diag(1.0 * ~held)
    matrix[k:-1, -1] = -slope
    matrix[-1, :k], matrix[-1, -1] = across, 1.0 * (not across.any())
    return matrix


def _way(
    body: Bonded, here: State, found: _Gradient, factor: _Factor, aim: _Aim
) -> tuple[Array, Array, Array, float] | None:
    """Newton's step of the free displacements, of q, of the forces on the target, of the part of the path."""
    k = body.components
    slope, across = (np.zeros(k), np.zeros(k)) if aim.arc is None else (aim.arc.slope, aim.arc.normal)
    dx = factor.step if found.free is factor.left else factor.solve(-found.free)
    matrix = _bordered(body, here.q, factor.stiffness, aim.held, (slope, across))
    try:
        step = np.linalg.solve(matrix, [*-(found.target + factor.side.T @ dx), *aim.gap, aim.ahead])
    except np.linalg.LinAlgError:
        return None
    if not (np.all(np.isfinite(dx)) and np.all(np.isfinite(step))):
        return None
    further = float(step[-1])
    dq = np.where(aim.held, aim.gap + slope * further, step[:k])
    return dx + factor.by_q @ dq, dq, np.where(aim.held, step[k:-1], slope * further), further


def _stepped(
    body: Bonded, here: State, factor: _Factor, way: tuple[Array, Array, Array, float]
) -> tuple[State, float] | None:
    """State after the longest part of Newton's step that keeps every point well above inversion, and that part."""
    dx, dq, forces, _ = way
    mesh, axes = body.mesh, list(body.mesh.axes)
    linear = np.zeros_like(here.u)
    linear[body.pattern.free] = dx
    linear[body.bonded.ravel()] = factor.made.T[: body.bonded.size, : body.components] @ dq
    F, J = deformation(mesh, here.u)
    volume = J - 1.0 + (kinematics(F).H * gradients(mesh, linear)).sum(axis=-1)
    p_full, part = body.K * volumes(mesh, volume), 1.0
    while part > 1e-3:
        u, q = here.u + part * linear, moved(here.q, part * dq)
        u[body.bonded] = bonded_displacement(body.X, q)[:, axes]
        min_J = smallest_volume(body, u, everywhere=False)
        if min_J > _MIN_J_KEPT * min(here.min_J, 1.0):
            p = here.p + part * (p_full - here.p)
            return replace(here, u=u, q=q, p=p, min_J=min_J, load=here.load + part * forces), part
        part *= _SHORTEN
    return None
