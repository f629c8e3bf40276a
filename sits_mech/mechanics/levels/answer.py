"""Turn a layer solved on a family of meshes (family.py) into a pose with estimated errors.

The first two levels are at rest (pair.py), finer ones correct the target's place until the estimated error is small
enough. States of the first two levels are kept.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain
from typing import NamedTuple

import numpy as np

from sits_mech.geometry.collision import ground_notes
from sits_mech.mechanics.element.kernel import most_stretched
from sits_mech.mechanics.equilibrium.body import Bonded, State, pack_state, unpack_state
from sits_mech.mechanics.equilibrium.control import Control, Scales
from sits_mech.mechanics.equilibrium.outcome import Outcome
from sits_mech.mechanics.faces.face_contact import face_notes
from sits_mech.mechanics.levels.family import Levels, Limit, Line
from sits_mech.mechanics.levels.refine import later_rests, refinements
from sits_mech.notes import Note
from sits_mech.quantities import Array, Bounded, Equilibrium, Mask, Pose, SolveReport, Wrench
from sits_mech.scene.sensor import Sensor, silicones_of
from sits_mech.silicone.stability import layer_notes

_ROUNDING = 1e-6  # of the largest force: forces that hold a target below it are rounding
_PAYS = 0.7  # of an error, from which on a level that does not give the one asked is not worth its price
_STRETCHED = 0.001  # share of the silicone that may be stretched more than what is called its largest stretch


def scaled_control(body: Bonded, scales: Scales, control: Control) -> tuple[Mask, Array]:
    """Return which components of the motion are given, and the given values, scaled; shape (k,) each.

    Out-of-plane components of a whole body are held where no load leaves the plane: a user's mesh need not be exactly
    symmetric.
    """
    k, held = body.components, control.held
    if k == 6 and not control.out_of_plane:
        held[3:] = True
    return held[:k], control.scaled(scales.lengths, scales.loads)[:k]


def starts(levels: Levels, scales: Scales, load: Wrench, state: Array) -> list[State]:
    """Return the states of the second and the first level under a load from what an equilibrium keeps of them."""
    bodies, own = (levels.fine, levels.coarse), scales.load(load)[: levels.fine.components]
    halves = np.split(state[1:], [levels.fine.size])
    return [unpack_state(body, half, own) for body, half in zip(bodies, halves, strict=True)]


def errors_of(difference: Array, share: float, lever: Array | float = 1.0) -> Array:
    """Bound component errors below by a share of the worst one; an angle counts at the target's end."""
    floor = share * np.max(difference * lever) / lever
    return np.maximum(difference, floor)


def relative(error: Array, moved: Array, lever: Array | float = 1.0) -> float:
    """Return the largest error over the displacement; an angle counts at the target's end."""
    size = float(np.max(np.abs(moved) * lever))
    return float(np.max(error * lever)) / size if size > 0.0 else 0.0


def whole_error(body: Bonded, scales: Scales, moved: Array) -> Pose:
    """Return an error as large as a displacement, (k,) or (6,) [m, rad], in every component that a body frees."""
    lever = body.reach(scales.thickness)
    size = float(np.max(np.abs(moved) * lever[: len(moved)]))
    return Pose.of(np.where(np.arange(6) < body.components, size / lever, 0.0))


def enlarged(found: Equilibrium, error: Pose, share: float, *notes: Note) -> Equilibrium:
    """Return an equilibrium with another error, as such and over the displacement, and further notes."""
    report = replace(found.report, estimated_error=share, notes=(*found.report.notes, *notes))
    return replace(found, error=error, report=report)


class Stretched(NamedTuple):
    """The stretch, or reciprocal, that all but a share of a silicone stays below.

    Of layers that of the one nearest to the end of its data, its strain over these times the least that any has: one
    number that is beyond what is known of the pad (`known_stretch`) where a layer is beyond its own data.
    """

    value: float
    doubt: float  # by how much it falls where the share grows by half the cell that has it
    each: tuple[float, ...]  # own value of each silicone, from the ground up


def layer_stretch(body: Bonded, u: Array, *, apart: float = _STRETCHED) -> Stretched:
    """Return the largest stretch of a layer with nodal displacements u, but for a share `apart`."""
    stretch, weights, laws = most_stretched(body.mesh, u), body.mesh.inside.weights, body.laws
    own = [laws.elements(number) for number in range(len(laws.each))]
    found = [_stretch_and_doubt(stretch[some], weights[some], apart) for some in own]
    known = np.array([law.silicone.known_stretch - 1.0 for law in laws.each])
    unknown = np.isnan(known)
    share = np.ones(len(known)) if unknown.all() else np.where(unknown, 0.0, np.nanmin(known) / known)
    worst = int(np.argmax([factor * (value - 1.0) for factor, (value, _) in zip(share, found, strict=True)]))
    (value, doubt), factor = found[worst], float(share[worst])
    return Stretched(value - (1.0 - factor) * (value - 1.0), factor * doubt, tuple(each for each, _ in found))


def _stretch_and_doubt(stretch: Array, weights: Array, apart: float) -> tuple[float, float]:
    """Return the stretch that all but a share of some elements' points (e, q) stays below, and its doubt.

    A coarse cell holds more silicone than that share, and its points are of one polynomial.
    """
    order, cells = np.argsort(stretch, axis=None), weights.reshape(len(stretch), -1).sum(axis=1)
    below, last = np.cumsum(weights.ravel()[order]), len(order) - 1

    def at(share: float) -> int:
        """Return the point that all but a share stays below."""
        return int(order[min(np.searchsorted(below, (1.0 - share) * below[-1]), last)])

    own = at(apart)
    near = at(apart + 0.5 * cells[own // stretch.shape[1]] / below[-1])
    value, less = (max(1.0, float(stretch.ravel()[each])) for each in (own, near))
    return value, value - less


def touch_notes(line: Line, body: Bonded, state: State) -> tuple[Note, ...]:
    """Return notes on what free faces touch in a state."""
    target = line.sensor.target
    plate = target.thickness / line.scales.thickness if target is not None else 0.0
    return face_notes(body.faces, body.mesh, body.parts, state.u, state.q, plate)


def law_notes(sensor: Sensor, each: Sequence[float]) -> tuple[Note, ...]:
    """Return notes on the silicones' laws at their largest stretches: stability, range of their data."""
    pairs = zip(silicones_of(sensor), each, strict=True)
    return tuple(dict.fromkeys(note for silicone, stretch in pairs for note in layer_notes(silicone, stretch)))


def extrapolated_equilibrium(
    line: Line, number: int, control: Control, states: tuple[State, State], walk: Iterator[Outcome] | None = None
) -> Equilibrium:
    """Extrapolate the equilibrium and its errors from two levels at rest and finer ones, by default `later_rests`.

    The state of the answer begins with the family's `number`.
    """
    (coarse, fine), sensor, scales, goal = states, line.sensor, line.scales, line.goal
    levels = line[number].folding(states)
    body = levels.fine
    k, (held, end) = body.components, scaled_control(body, scales, control)
    given = bool(np.any(control.held[:k]))
    lever = body.reach(scales.thickness)[:k]
    weight = body.levers  # of q in thicknesses at the target's end, 1 over that of a load
    moved, holding = (fine.q * weight)[~held], (fine.load / weight)[held]
    size = [float(np.max(np.abs(own), initial=1e-300)) for own in (moved, holding)]
    largest = float(np.max(np.abs(fine.load / weight)))
    size[1] = max(size[1], (_ROUNDING if given else 1.0) * largest)  # what holds out of the plane is of uneven cells
    unit, share = np.where(held, size[1] * weight, size[0] / weight), levels.least_share(-float(fine.q[1]))

    def shown(found: Outcome) -> Array:
        """Return the motion, or the load where held, over the largest of its kind."""
        return np.where(held, found.state.load, found.state.q) / unit

    def left(limit: Limit) -> float:
        """Return the error of what is asked."""
        if goal is None or given:
            return float(np.max(limit.error))
        size = unit * scales.lengths[:k]
        own = Bounded.of(limit.value * size, errors_of(limit.error, share) * size, limit.parts * size)
        return float(np.max(own.mapped(goal[:, :k]).error, initial=0.0))

    begun, pressed, depths = [Outcome(state) for state in states], body.pressed(fine), body.sunk(fine.q)
    best = levels.early([shown(each) for each in begun], held | (np.arange(k) == 1), pressed=pressed, sunk=depths)
    kept = 2  # levels that `best` is the limit of
    most = 3 if body.parts and len(body.mesh.axes) == 3 else levels.rested  # contact moves with every mesh
    most = min(most, len(levels), line.deepest)

    for found in refinements(levels, chain(begun, walk or later_rests(levels, states, (held, end), given)), most):
        large, level = None, len(found)
        if level > 2:
            late = np.where(held, 0.0, found[-1].off / unit)
            if np.max(late, initial=0.0) > np.max(best.error):  # it does not settle there
                break
            best = levels.limit([shown(each) for each in found], late, pressed=pressed, sunk=depths)
            kept = level
        if left(best) <= line.asked and not (pressed and level == 2):  # in contact two may agree by chance
            break
        last = level if len(body.mesh.axes) == 3 else most - 1  # sections are cheap
        paid = max(line.asked, _PAYS * left(best))
        if level >= most or left(levels.foreseen(best, level, last)) > paid or levels.creased(states):
            break  # no further level pays
        large = levels.check_memory(level)
    last, spent = len(found) - 1, sum(each.state.iterations for each in found)
    before, strained = (layer_stretch(levels.maker(k), found[k].state.u) for k in (last - 1, last))
    error = np.where(held, 0.0, errors_of(best.error, share)) * unit * scales.lengths[:k]
    q, load = np.where(held, fine.q, best.value * unit), np.where(held, best.value * unit, fine.load)
    off = relative(best.error, best.value)
    beneath = ground_notes(sensor, scales.pose(q))
    if beneath:  # the true target is held there: the error is the whole displacement
        whole = np.max(np.abs(q * scales.lengths[:k]) * lever) / lever
        error, off = np.where(held, 0.0, np.maximum(error, whole)), max(off, 1.0)
    notes = (*touch_notes(line, body, fine), *beneath, *law_notes(sensor, strained.each), *filter(None, [large]))
    report = SolveReport(
        "", len(levels.maker(last).free) + k, spent, fine.residual, off, 0.0, notes=notes, min_J=fine.min_J,
        stretch=strained.value, error_stretch=max(abs(strained.value - before.value), strained.doubt),
        creased=levels.creased(states),
    )
    state_kept = np.concatenate([[number], pack_state(fine), pack_state(coarse)])
    shared = np.pad(np.where(held, 0.0, best.parts * unit * scales.lengths[:k]), ((0, 0), (0, 6 - k)))
    finest = tuple(pack_state(each.state) for each in found[2:kept])
    sunk = _sunk(levels, [each.state for each in found[:kept]], scales)
    pose, wrench = scales.pose(q), scales.wrench(load)
    return Equilibrium(wrench, pose, Pose.of(error), state_kept, report, shared, finest, sunk=sunk)


def _sunk(levels: Levels, states: Sequence[State], scales: Scales) -> tuple[float, float] | None:
    """Return how deep a shape on a cover stands, and its error [m]: of meshes, and the depth of contact."""
    if levels.fine.press is None or not levels.fine.meets(states[-1].load):
        return None
    each = [np.array([-levels.maker(k).stands(state.u, state.load)]) for k, state in enumerate(states)]
    two, whole = len(each) == 2, np.ones(1, dtype=bool)
    limit = levels.early(each, whole, pressed=True) if two else levels.limit(each, pressed=True)
    return float(limit.value[0]) * scales.thickness, float(limit.error[0] + levels.fine.press.depth) * scales.thickness
