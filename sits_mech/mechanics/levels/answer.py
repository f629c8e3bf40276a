"""Turn a layer solved on a family of meshes (family.py) into a pose with estimated errors.

The load path is followed on the first level, the second comes to rest from there, finer ones correct the target's place
until the estimated error is small enough. No component's error is less than a share of the worst, an angle counted at
the target's end; likewise for forces that hold the target. States of the first two levels are kept.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from sits_mech.geometry.collision import ground_notes
from sits_mech.mechanics.element.kernel import most_stretched
from sits_mech.mechanics.equilibrium.body import Bonded, State, packed, rest, unpacked
from sits_mech.mechanics.equilibrium.control import Control, Scales
from sits_mech.mechanics.equilibrium.linearisation import Held
from sits_mech.mechanics.equilibrium.newton import (
    MOST,
    Approach,
    PathEnd,
    smallest_eigenvalue,
    target_stiffness,
    unloaded,
)
from sits_mech.mechanics.equilibrium.path import Outcome, carried, follow, iteration_seconds
from sits_mech.mechanics.faces.face_contact import face_notes, faces_press
from sits_mech.mechanics.levels.family import Levels, Limit, Line, finer
from sits_mech.memory import check_seconds, kept_by_first
from sits_mech.notes import Note
from sits_mech.quantities import WRENCH, Array, Bounded, Equilibrium, Pose, SolveReport, Wrench
from sits_mech.scene.sensor import Sensor
from sits_mech.silicone.stability import layer_notes

_LOOK = 2e-2  # smallest length of the path on the coarse mesh, over that so far
_VERDICT = 60  # iterations that the finer mesh is given to locate a limit that the coarse one has found
_LAST = 25  # and where it has found none, for a last state
_UPRIGHT = 0.5  # of the stiffness without load; levels differ by 0.03 of it at most (test_answer.py)
_ROUNDING = 1e-6  # of the largest force: forces that hold a target below it are rounding
_PAYS = 0.5  # of an error, from which on a level that does not give the one asked is not worth its price
_STRETCHED = 0.001  # share of the silicone that may be stretched more than what is called its largest stretch


class Solved(NamedTuple):
    """The last equilibrium on the path, the fraction of the path it stands at, and what ended the path."""

    found: Equilibrium
    part: float
    reason: PathEnd = PathEnd.NONE
    carried: tuple[Wrench, Wrench] | None = None  # largest load and its error, if limited
    limit: tuple[float, float] | None = None  # the same as a fraction of the path, with its error
    laws: tuple[Note, ...] = ()  # notes on the silicone's law in the farthest state of the coarse mesh
    seen: float = 1.0  # fraction of the path the coarse mesh got to

    @property
    def refused(self) -> bool:
        """Whether the layer is known not to carry the load, whatever the errors."""
        return self.limit is not None and sum(self.limit) < 1.0


def first_look(line: Line, levels: Levels, start: Equilibrium | None, control: Control) -> Outcome:
    """Follow the path on the coarse mesh alone."""
    for level in (0, 1):
        levels.check_memory(level)
    check_seconds(MOST * iteration_seconds(levels.fine), f"a load on a mesh of {len(levels.fine.free)} unknowns")
    state, (held, end) = _begun(levels, line.scales, start, 0), aim(levels.coarse, line.scales, control)
    begin = np.where(held, state.q, state.load)
    return follow(levels.coarse, state, (begin, end), smallest=_LOOK, held=held, out_of_plane=control.held[3:])


def solve_levels(
    line: Line, levels: Levels, start: Equilibrium | None, control: Control, first: Outcome, smallest: float
) -> Solved:
    """Follow the path on the first two levels of a line's family, then refine until the error is as asked of the line.

    Without `start` the path begins at rest; `first` is the result of `first_look`; `smallest` is the least increment.
    A limit found on the coarse mesh gets its error from the finer one within a few iterations.
    """
    scales = line.scales
    held, end = aim(levels.fine, scales, control)
    coarse_start = _begun(levels, scales, start, 0)
    begin = np.where(held, coarse_start.q, coarse_start.load)

    def followed(body: Bonded, state: State, goal: Array, spend: float) -> Outcome:
        return follow(
            body, state, (begin, goal), smallest=smallest, held=held, out_of_plane=control.held[3:], most=spend
        )

    midway = begin + first.reached * (end - begin)
    spend = np.inf if first.reached == 1.0 else _LAST if first.limit is None else _VERDICT
    body = levels.fine.plain if _stands(levels, first, control) else levels.fine
    fine = followed(body, _begun(levels, scales, start, 1), midway, spend)
    fine = fine.over(0.0, first.reached)
    there, second = fine, first.state
    if first.limit is not None and fine.reached == first.reached:  # and how far beyond?
        left = follow(
            levels.fine, fine.state, (midway, end), smallest=_LOOK, held=held, out_of_plane=control.held[3:],
            most=_VERDICT,
        )
        there = left.over(first.reached, 1.0)
    elif fine.reached < first.reached:  # both must rest under one goal for the error to mean something
        second = followed(levels.coarse, coarse_start, begin + fine.reached * (end - begin), np.inf).state
    part, limit = fine.reached, carried(first, there)
    reason = (there if there.limit is not None or first.reached == 1.0 else first).reason
    last = line if part == 1.0 else replace(line, deepest=2)
    found = answer(last, levels, control, (second, fine.state))
    if part == 1.0:
        given = {name: value for name in WRENCH if (value := getattr(control, name)) is not None}
        found = replace(found, wrench=replace(found.wrench, **given))
    load = None if limit is None else _carried(found, scales, (begin, end, held), limit)
    laws = law_notes(line.sensor, largest_stretch(levels.coarse, first.state.u, apart=0.0)) if part < 1.0 else ()
    return Solved(found, part, reason, load, limit, laws, first.reached)


def _stands(levels: Levels, first: Outcome, control: Control) -> bool:
    """Whether the first level is so far from falling out of its symmetry that the second need not be asked."""
    if not (first.reached == 1.0 and np.isfinite(first.hidden)):
        return False
    return first.hidden >= _UPRIGHT * smallest_eigenvalue(_hidden_at_rest(levels), control.held[3:])


@kept_by_first(1)
def _hidden_at_rest(levels: Levels) -> Array:
    """Return the stiffness of the undeformed first level on motions that symmetry hides, (3, 3); zero for none."""
    found = target_stiffness(levels.coarse, rest(levels.coarse))[1]
    return np.zeros((3, 3)) if found is None else found


def _carried(
    found: Equilibrium, scales: Scales, way: tuple[Array, Array, Held], limit: tuple[float, float]
) -> tuple[Wrench, Wrench]:
    """Return the largest load and its error; with places given, the forces of the last equilibrium."""
    (begin, end, held), there = way, scales.load(found.wrench)[: len(way[0])]
    load, way_off = np.where(held, there, begin + limit[0] * (end - begin)), np.abs(end - begin)
    return scales.wrench(load), scales.wrench(np.where(held | (way_off == 0.0), 0.0, limit[1] * way_off))


def aim(body: Bonded, scales: Scales, control: Control) -> tuple[Held, Array]:
    """Return which components of the motion are given, and the given values, scaled; shape (k,) each.

    Out-of-plane components of a whole body are held where no load leaves the plane: a user's mesh need not be exactly
    symmetric.
    """
    k, held = body.components, control.held
    if k == 6 and not control.out_of_plane:
        held[3:] = True
    return held[:k], control.goal(scales.lengths, scales.loads)[:k]


def starts(levels: Levels, scales: Scales, start: Equilibrium) -> list[State]:
    """Return the states of the second and the first level of an equilibrium."""
    bodies = (levels.fine, levels.coarse)
    load = scales.load(start.wrench)[: levels.fine.components]
    halves = np.split(start.state, [levels.fine.size])
    return [unpacked(body, half, load) for body, half in zip(bodies, halves, strict=True)]


def _begun(levels: Levels, scales: Scales, start: Equilibrium | None, level: int) -> State:
    """Return the start on one of the first two levels: an equilibrium, or the unloaded state."""
    return unloaded(levels.maker(level)) if start is None else starts(levels, scales, start)[1 - level]


def errors_of(difference: Array, share: float, lever: Array | float = 1.0) -> Array:
    """Bound component errors below by a share of the worst one; an angle counts at the target's end."""
    floor = share * np.max(difference * lever) / lever
    return np.maximum(difference, floor)


def relative(error: Array, moved: Array, lever: Array) -> float:
    """Return the largest error over the displacement; an angle counts at the target's end."""
    size = float(np.max(np.abs(moved) * lever))
    return float(np.max(error * lever)) / size if size > 0.0 else 0.0


def largest_stretch(body: Bonded, u: Array, *, apart: float = _STRETCHED) -> float:
    """Return the stretch, or reciprocal, that all but a share `apart` of the silicone stays below."""
    stretch = most_stretched(body.mesh, u).ravel()
    order = np.argsort(stretch)
    below = np.cumsum(body.mesh.inside.weights.ravel()[order])
    return max(1.0, float(stretch[order][np.searchsorted(below, min((1.0 - apart) * below[-1], below[-1]))]))


def law_notes(sensor: Sensor, stretch: float) -> tuple[Note, ...]:
    """Return notes on the silicone's law at a largest stretch: stability, range of its data."""
    return () if sensor.elastomer is None else layer_notes(sensor.elastomer.silicone, stretch)


def answer(
    line: Line, levels: Levels, control: Control, states: tuple[State, State], walk: Iterator[Approach] | None = None
) -> Equilibrium:
    """Extrapolate the equilibrium and its errors from two levels at rest and as many finer ones as needed.

    `walk` yields the finer levels (default `finer`).
    """
    (coarse, fine), sensor, scales, goal = states, line.sensor, line.scales, line.goal
    body, t = levels.fine, scales.thickness
    k, (held, end) = body.components, aim(body, scales, control)
    given = bool(np.any(control.held[:k]))
    lever = body.reach(t)[:k]
    weight = body.levers  # of q in thicknesses at the target's end, 1 over that of a load
    moved, holding = (fine.q * weight)[~held], (fine.load / weight)[held]
    size = [max(float(np.max(np.abs(own), initial=0.0)), 1e-300) for own in (moved, holding)]
    largest = float(np.max(np.abs(fine.load / weight)))
    size[1] = max(size[1], (_ROUNDING if given else 1.0) * largest)  # what holds out of the plane is of uneven cells
    unit = np.where(held, size[1] * weight, size[0] / weight)

    def shown(q: Array, load: Array) -> Array:
        """Return the motion, or the load where held, over the largest of its kind."""
        return np.where(held, load, q) / unit

    def left(limit: Limit) -> float:
        """Return the error of what is asked."""
        if goal is None or given:
            return float(np.max(limit.error))
        size = unit * scales.lengths[:k]
        own = Bounded.of(limit.value * size, errors_of(limit.error, levels.share) * size, limit.parts * size)
        return float(np.max(own.mapped(goal[:, :k]).error, initial=0.0))

    values, walk = [shown(state.q, state.load) for state in states], walk or finer(levels, states, (held, end), given)
    pressed = faces_press(body.mesh, body.parts, fine.u, fine.q)
    best = levels.early(values, held | (np.arange(k) == 1), pressed=pressed)
    spent, sink = fine.iterations + coarse.iterations, -float(fine.q[1])
    large: Note | None = None
    beyond, kept = list[Array](), 0
    stretches = [largest_stretch(levels.coarse, coarse.u), largest_stretch(body, fine.u)]
    most = 3 if body.parts and len(body.mesh.axes) == 3 else levels.rested  # contact moves with every mesh
    for level in range(2, min(most, len(levels), line.deepest)):
        if left(best) <= line.asked and not (pressed and level == 2):  # in contact two may agree by chance
            break
        last = level if len(body.mesh.axes) == 3 else min(most, len(levels), line.deepest) - 1  # sections are cheap
        if left(levels.foreseen(best, level, last)) > max(line.asked, _PAYS * left(best)) or levels.creased(states):
            break
        large = levels.check_memory(level)
        there = None if large else next(walk, None)
        if there is None:
            break
        values, spent = [*values, shown(there.state.q, there.state.load)], spent + there.state.iterations
        limit = levels.limit(values, np.where(held, 0.0, there.off / unit), pressed=pressed, sink=sink)
        beyond.append(packed(there.state))
        stretches.append(largest_stretch(levels.maker(level), there.state.u))
        if np.max(there.off[~held] / unit[~held], initial=0.0) > np.max(best.error):  # it does not settle there
            break
        best, kept = limit, len(beyond)
    error = np.where(held, 0.0, errors_of(best.error, levels.share)) * unit * scales.lengths[:k]
    q, load = np.where(held, fine.q, best.value * unit), np.where(held, best.value * unit, fine.load)
    off = float(np.max(best.error)) / max(float(np.max(np.abs(best.value))), 1e-300) if np.any(best.value) else 0.0
    beneath = ground_notes(sensor, scales.pose(q))
    if beneath:  # the true target is held there: the error is the whole displacement
        whole = np.max(np.abs(q * scales.lengths[:k]) * lever) / lever
        error, off = np.where(held, 0.0, np.maximum(error, whole)), max(off, 1.0)
    plate = sensor.target.thickness / t if sensor.target is not None else 0.0
    notes = face_notes(body.faces, body.mesh, body.parts, fine.u, fine.q, plate)
    laws = law_notes(sensor, stretches[-1])
    notes = (*notes, *beneath, *laws, *([large] if large else []))
    report = SolveReport(
        "", len(levels.maker(len(values) - 1).free) + k, spent, fine.residual, off, 0.0, notes=notes, min_J=fine.min_J,
        stretch=stretches[-1], error_stretch=abs(stretches[-1] - stretches[-2]),
    )
    state_kept = np.concatenate([packed(fine), packed(coarse)])
    shared = np.pad(np.where(held, 0.0, best.parts * unit * scales.lengths[:k]), ((0, 0), (0, 6 - k)))
    finest = tuple(beyond[:kept])
    return Equilibrium(scales.wrench(load), scales.pose(q), Pose.of(error), state_kept, report, shared, finest)
