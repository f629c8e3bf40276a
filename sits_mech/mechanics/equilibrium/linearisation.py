"""Linearise a layer about a state and take one Newton step.

The unknowns are the free nodal displacements and the components of the target's motion q that the body frees. With
T = d u_bonded/dq the gradient and tangent of the total potential (body.py) are

    g = (f_free, T^T f_bonded + f_q - work of the load),      A = (K, C; C^T, D + turning),

K, C, D from element/assembly.py, loads and turning from element/target.py. The pressure p of the geometric stiffness is
an unknown of its own, eliminated in the element: each step moves it with the linearised volume, ``p <- K pi(J - J_0 + H
: dF)``, which is Newton's method on the mixed problem. (With p taken from the current volume, K (J - 1), it would be
Newton on a stiff penalty energy, and creep.)

Mixed control: of each pair F_x, d_h; F_z, d_z; M, alpha; ... one is given, and along a path it goes with the part t of
the path. With S, the stiffness that is left when all but q is eliminated, a step (dq, dF, dt) is that of

    S dq - (work of dF) = what is left of the forces on q,
    dq_i = slope_i dt + gap_i   of a place that is given,      dF_i = slope_i dt   of a force,
    dt = 0    or, where t is found,    normal . dq = what is left of the way to a plane across the path (`Arc`),

so that turning points of the load are nothing special. A step that would turn a quadrature point inside out is
shortened. In a descent one that climbs is turned round, and shortened where the potential does not fall as its slope
promises.

Source: R. de Borst et al., Non-linear Finite Element Analysis of Solids and Structures (2012), chapter 4, for mixed
control; E. Riks, Int. J. Solids Struct. 15 (1979) 529, for the plane across the path.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, cast

import numpy as np

from sits_mech.mechanics.element.assembly import Factored, Pattern, Stiffness, Term
from sits_mech.mechanics.element.kernel import (
    deformed,
    element_forces,
    element_stiffness,
    gradients,
    kinematics,
    volumes,
)
from sits_mech.mechanics.element.sideways import off_axis_stiffness
from sits_mech.mechanics.element.target import bonded_tangent, moved, turning, work_between, work_of_load
from sits_mech.mechanics.equilibrium.body import Bonded, State, deformed_state, smallest_volume
from sits_mech.mechanics.equilibrium.outcome import StepTarget, bordered
from sits_mech.quantities import Array, Integers, Mask

_SHORTEN = 0.5  # of a step that does not lower the potential, at most
_SHORTEST = 1e-3  # part of a step
_ROUNDING = 1e-12  # of the potential, and of a shear modulus everywhere in the layer
_ARMIJO = 1e-4  # share of the fall that a step's slope promises, below which the step is shortened
_STEEP, _LEAST_STEP = 0.5, 0.05  # slope at the end of a step over that at its beginning; smallest share of it at once
MIN_J_KEPT = 0.2
"""A step may not shrink the smallest volume ratio below this fraction of its value."""


class NewtonStep(NamedTuple):
    """Newton's step."""

    free: Array  # of the free displacements
    q: Array
    forces: Array  # on the target
    part: float  # of the path
    height: float = 0.0  # of a shape on a cover


class Residuals(NamedTuple):
    """Forces on displacements and q, the residual on each, the energy, and terms of the parts."""

    forces: Array
    free: Array  # residual on the free displacements
    target: Array  # residual on q
    energy: float
    terms: list[Term]
    shape: float = 0.0  # residual on the height of a shape on a cover


class _Linear(NamedTuple):
    """Terms of a linearisation: numbers and values of the stiffnesses, border by (dc, dw), turning."""

    numbers: tuple[Integers, ...]
    values: Stiffness
    T: Array  # (b, 7), the last of the height of a shape
    turning: Array
    at: State


class Factor(NamedTuple):
    """A linearisation factored on the free displacements."""

    of_free: Factored
    by_q: Array  # free displacements by q
    side: Array  # C
    stiffness: Array  # S, on q
    left: Array  # residual on the free displacements
    step: Array  # step that removes it at fixed q
    made: _Linear
    shape: Array | None = None  # eliminated height of a shape: free displacements, C, S of q and of itself by it


def residuals_of(body: Bonded, here: State) -> Residuals:
    """Return forces and residuals of a layer with its parts."""
    found = element_forces(body.mesh, body.laws, here.u, deformed_state(body, here))
    terms = [term for part in body.parts if len((term := part(here.u, here.q)).numbers)]
    terms += [] if body.press is None else [body.press(here.u, here.load, here.height)]
    forces = np.concatenate([found.forces, np.zeros(8)])
    for term in terms:
        forces[: len(term.forces)] += term.forces
    pattern, k = body.pattern, body.components
    on_target = _border_by_q(body, here.q)[:, :k].T @ forces[pattern.border]
    on_target = on_target - work_of_load(body.on_target(here.load), body.height, here.q)[:k]
    energy = found.energy + sum(term.energy for term in terms)
    return Residuals(forces, forces[pattern.free], on_target, energy, terms, float(forces[-2]))


def factored(body: Bonded, here: State, found: Residuals) -> Factor | None:
    """Linearise about a state and eliminate the free displacements; None if singular."""
    k = body.components
    freed = [*range(k), *([6] if body.meets(here.load) else [])]
    own = _eliminated(body.pattern, _linearised(body, here, found), freed, found.free)
    if own is not None and len(freed) > k:
        own = _without_height(own)
    return None if own is None else own._replace(stiffness=on_motions(body, own.stiffness))


def _without_height(own: Factor) -> Factor | None:
    """Eliminate the height of a shape, the last of the motions; None where nothing holds it."""
    by, S = own.by_q[:, -1], own.stiffness[-1]
    if not S[-1] > 0.0:
        return None
    shape = np.concatenate([by, own.side[:, -1], S])
    ahead = S[:-1] / S[-1]
    return own._replace(
        by_q=own.by_q[:, :-1] - by[:, None] * ahead, side=own.side[:, :-1], shape=shape,
        stiffness=own.stiffness[:-1, :-1] - S[:-1, None] * ahead,
    )


def _linearised(body: Bonded, here: State, found: Residuals) -> _Linear:
    """Return the terms of the linearisation about a state."""
    stiffness = element_stiffness(body.mesh, body.laws, here.u, here.p, deformed_state(body, here))
    values = (stiffness, *(term.stiffness for term in found.terms))
    on_bonded = np.zeros((len(body.bonded), 3))
    on_bonded[:, list(body.mesh.axes)] = found.forces[body.bonded]
    on_bonded[:, 0] *= 0.5 if body.mesh.hoop else 1.0  # their mean along x, or y, over a turn
    T, extra = _border_by_q(body, here.q), np.zeros((7, 7))
    extra[:6, :6] = turning(on_bonded, body.X, body.on_target(here.load), body.height, here.q)
    numbers = (body.mesh.dofs, *(term.numbers for term in found.terms))
    return _Linear(numbers, values, T, extra, here)


def factored_shapes(
    body: Bonded, here: State, shapes: Array, parts: Sequence[tuple[Pattern, Sequence[int]]]
) -> list[Factor]:
    """Eliminate displacements that are free by a pattern from some of the motion q and `shapes` (n, d, m) after it.

    Raises ValueError where that is singular.
    """
    made = _with_shapes(body, here, residuals_of(body, here), shapes)
    found = [_eliminated(pattern, made, [*some], np.zeros(len(pattern.free))) for pattern, some in parts]
    if None in found:
        raise ValueError("elastomer: must have a stiffness at rest; it has none")
    return cast(list[Factor], found)


def bending_equations(body: Bonded, here: State, shapes: Array, f: Array | float = 0.0) -> tuple[Array, Array] | None:
    """Return S and r of S (dq, a) = -r, Newton's step of q and `shapes` (n, d, m) of the bonded nodes from a state.

    Of the motions those that move the body; r is of the pad and of forces `f` on nodes, on the shapes, which the state
    has not. None if singular.
    """
    found, moving = residuals_of(body, here), np.flatnonzero(body.freed)
    made = _with_shapes(body, here, found, shapes)
    left = found.forces[: body.mesh.nodes.size] - f
    factor = _eliminated(body.pattern, made, [*moving, *range(6, 6 + shapes.shape[-1])], left[body.pattern.free])
    if factor is None:
        return None
    on_shapes = np.einsum("ni,nim->m", left[body.bonded], shapes)
    return factor.stiffness, np.concatenate([found.target[moving], on_shapes]) + factor.side.T @ factor.step


def _with_shapes(body: Bonded, here: State, found: Residuals, shapes: Array) -> _Linear:
    """Return the terms of the linearisation with `shapes` (n, d, m) of the bonded nodes after the motions."""
    made, m = _linearised(body, here, found), shapes.shape[-1]
    T = np.pad(made.T[:, :6], ((0, 0), (0, m)))
    T[: body.bonded.size, 6:] = shapes.reshape(-1, m)
    return made._replace(T=T, turning=np.pad(made.turning[:6, :6], (0, m)))


def on_motions(body: Bonded, S: Array) -> Array:
    """Return the stiffness S of a target; of one that moves along an axis alone as on d_z on all three."""
    return S[1, 1] * np.eye(len(S)) if body.mesh.hoop else S


def hidden_stiffness(body: Bonded, made: _Linear) -> Array | None:
    """Return the stiffness on motions hidden by symmetry: displacements odd in y, three components of q.

    About an axis those on d_y and alpha_x, (2, 2), without contact.
    """
    if body.mesh.hoop:
        here, nodes = made.at, body.bonded[:, 0] // 2
        return off_axis_stiffness(body.mesh, body.laws, (here.u, here.p), (nodes, body.X), made.turning[2, 2])
    if body.hidden is None:
        return None
    pattern = body.hidden()
    found = _eliminated(pattern, made, slice(3, 6), np.zeros(len(pattern.free)))
    return np.full((3, 3), np.nan) if found is None else found.stiffness


def way_of(body: Bonded, here: State, found: Residuals, factor: Factor, aim: StepTarget) -> NewtonStep | None:
    """Return Newton's step; None where there is none."""
    k = body.components
    slope, across = (np.zeros(k), np.zeros(k)) if aim.arc is None else (aim.arc.slope, aim.arc.normal)
    dx = factor.step if found.free is factor.left else factor.of_free.solve(-found.free)
    height, ahead = 0.0, np.zeros(k)
    if factor.shape is not None:
        (by, C), S = factor.shape[: 2 * len(dx)].reshape(2, -1), factor.shape[2 * len(dx) :]
        height, ahead = -float(found.shape + C @ dx) / float(S[-1]), S[:-1] / S[-1]
        dx = dx + by * height
    matrix = bordered(body, here.q, factor.stiffness, aim.held, (slope, across))
    try:
        step = np.linalg.solve(matrix, [*-(found.target + factor.side.T @ dx), *aim.gap, aim.ahead])
    except np.linalg.LinAlgError:
        return None
    if not (np.all(np.isfinite(dx)) and np.all(np.isfinite(step))):
        return None
    further = float(step[-1])
    dq = np.where(aim.held, aim.gap + slope * further, step[:k])
    forces = np.where(aim.held, step[k:-1], slope * further)
    return NewtonStep(dx + factor.by_q @ dq, dq, forces, further, height - float(ahead @ dq))


def stepped(
    body: Bonded, here: State, found: Residuals, factor: Factor, way: NewtonStep, held: Mask, *,
    falling: bool = False,
) -> tuple[State, float, Residuals] | None:
    """Return the state after the longest admissible part of Newton's step, that part, and the gradient there.

    Points stay well above inversion. If `falling`, unless held places move, a step that climbs is turned round, and the
    potential satisfies Armijo's condition (L. Armijo, Pacific J. Math. 16 (1966) 1). Under friction the slope at the
    end counts instead, as the tangent changes within a hair of slip.
    """
    slope = float(way.free @ found.free + way.q @ found.target + way.height * found.shape)
    loose = not np.any(way.q[held])
    measured = falling and loose and way.part == 0.0 and np.isfinite(found.energy)
    if measured and slope > 0.0:
        way, slope = NewtonStep._make(-part for part in way), -slope
    (linear, p_full), dq, forces, part = increments(body, here, factor, way), way.q, way.forces, 1.0
    rounding = _ROUNDING * (float(body.mesh.inside.weights.sum()) + abs(found.energy))
    while part > _SHORTEST:
        u, q = here.u + part * linear, moved(here.q, part * dq)
        u[body.bonded] = body.with_target(q)
        known = deformed(body.mesh, u)
        min_J = smallest_volume(body, u, everywhere=False, known=known)
        if min_J > MIN_J_KEPT * min(here.min_J, 1.0):
            p = here.p + part * (p_full - here.p)
            there = replace(
                here, u=u, q=q, p=p, min_J=min_J, load=here.load + part * forces, known=known,
                height=here.height + part * way.height,
            )
            after = residuals_of(body, there)
            if body.slips:
                shorter = _overshot(slope, after, way) if loose else 1.0
                if shorter == 1.0:
                    return there, part, after
                part *= shorter
                continue
            gained = work_between(body.on_target(here.load), body.height, (here.q, q), part * dq)
            if not measured or after.energy - found.energy - gained <= _ARMIJO * part * slope + rounding:
                return there, part, after
        part *= _SHORTEN
    return None


def _overshot(before: float, found: Residuals, way: NewtonStep) -> float:
    """Return the part of a step that the potential admits, by its slope before it; 1 where it falls."""
    after = float(way.free @ found.free + way.q @ found.target)
    if before >= 0.0 or after <= -_STEEP * before:
        return 1.0
    return min(max(before / (before - after), _LEAST_STEP), _SHORTEN)


def increments(body: Bonded, here: State, factor: Factor, way: NewtonStep) -> tuple[Array, Array]:
    """Return Newton's step of all displacements, and the pressures after it."""
    linear = np.zeros_like(here.u)
    linear[body.pattern.free] = way.free
    linear[body.bonded.ravel()] = factor.made.T[: body.bonded.size, : body.components] @ way.q
    _, F, J = deformed_state(body, here)
    volume = J - body.laws.swelling + (kinematics(F).H * gradients(body.mesh, linear)).sum(axis=-1)
    return linear, body.laws.K * volumes(body.mesh, volume)


def _border_by_q(body: Bonded, q: Array) -> Array:
    """Return the derivative of the border (bonded displacements, q, a height) by (dc, dw) and it, shape (b, 7)."""
    T = bonded_tangent(body.X, q)[:, list(body.mesh.axes)]
    found = np.eye(7 + T[..., 0].size)[:, -7:]
    found[:-7, :6] = T.reshape(-1, 6)
    found[:-1, : body.components] *= body.freed
    return found


def _eliminated(pattern: Pattern, made: _Linear, freed: slice | list[int], left: Array) -> Factor | None:
    """Eliminate the free displacements and their residual from the freed components of (dc, dw)."""
    pattern = pattern.following(made.numbers)
    of_free = pattern.factored(made.values)
    if of_free is None:
        return None
    C, D = pattern.sides(made.values, made.T[:, freed])
    found = of_free.solve(-np.column_stack([C, left]))
    by_q, step = found[:, :-1], found[:, -1]
    if not np.all(np.isfinite(by_q)):
        return None
    return Factor(of_free, by_q, C, D + made.turning[freed][:, freed] + C.T @ by_q, left, step, made)
