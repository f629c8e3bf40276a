"""Follow a layer with memory under a history of loads: time steps on every level of a family of meshes.

Time. A step (equilibrium/increments.py) is of second order. On the first level two walks go side by side, A in steps
dt, B in two halves of each, each with a memory of its own: the remaining error of B is a third of their difference,

    q = q_B + (q_B - q_A)/3,      error in time = |q_B - q_A|/3,

of the whole walk so far, not of a step. A step that lets it grow by more than a share of the tolerance is repeated,
shorter; the times of the history are always met, and sudden loads cost one step.

Space. Further levels walk in the steps of A, and the first level's correction in time is added to them; poses are
extrapolated at each time as they are of an elastic layer (family.py), with errors over the largest displacement of the
history. Three levels are walked at most.

Contact. As for one load (settle.py): where a free face comes to lie on ground, target or another at any time, the whole
history is walked with contact. With friction a step is of first order: the error is ``|q_B - q_A|``, and q is q_B.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from sits_mech.cases import Progress, untold
from sits_mech.geometry.collision import ground_notes
from sits_mech.mechanics.equilibrium.body import Bonded
from sits_mech.mechanics.equilibrium.control import under
from sits_mech.mechanics.equilibrium.increments import Moment, begun, later, rough
from sits_mech.mechanics.equilibrium.linearisation import Held
from sits_mech.mechanics.equilibrium.outcome import REASONS, PathEnd
from sits_mech.mechanics.faces.face_contact import face_notes
from sits_mech.mechanics.histories import LoadHistory, Motion
from sits_mech.mechanics.levels.answer import aim, errors_of, largest_stretch, law_notes
from sits_mech.mechanics.levels.family import PAIR, WALKED, Levels, Line
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import POSE, WRENCH, Array, Ended, Mask, Pose, SolveFailed, SolveReport, Wrench

_GROWTH = 0.03  # of the tolerance: what a step may add to the error in time
_LARGER, _SMALLER, _SAFE = 3.0, 0.2, 0.9  # of a step, from one to the next
_ORDER = 3.0  # of what one step adds
_LEAST = 1e-6  # of the largest displacement: no error is called smaller, whatever meshes agree on near zero
_ROUNDING = 1e-9  # of a step
_LIMITS = PathEnd.BUCKLED, PathEnd.SIDEWAYS, PathEnd.TURNED  # what two families of meshes say is not their fault
_SHORTEST = 1e-6  # of the time between two loads of the history


@dataclass(frozen=True)
class _Times:
    """Time steps of the first level, and the error in time."""

    time: Array
    load: Array
    given: Mask  # which times are the history's
    gap: Array  # error in time, (m, k) [thicknesses, rad]
    late: Array  # correction to a walk in steps A, (m, k)


class _Ended(Exception):
    """A walk that found no equilibrium: when, why, and the last moment."""

    def __init__(self, time: float, reason: PathEnd, last: Moment) -> None:
        super().__init__(reason)
        self.time, self.reason, self.last = time, reason, last


def motion_in_time(line: Line, history: LoadHistory, tell: Progress = untold) -> Motion:
    """Return the target's motion under a history of loads; report progress to `tell`.

    Raise SolveFailed, with the time reached, where no family of meshes completes the history.
    """
    ended: list[_Ended] = []
    numbers = list(range(PAIR))
    while numbers and sum(each.reason in _LIMITS for each in ended) < 2:
        number = numbers.pop(0)
        try:
            motion, touches = _on_family(line, line[number], history, tell)
        except _Ended as end:
            ended.append(end)
            continue
        if number in line.last or not touches:
            tell(100, 100)
            return motion
        numbers = list(line.last)
    raise _failed(history, max(ended, key=lambda each: each.time))


def _failed(history: LoadHistory, end: _Ended) -> SolveFailed:
    """Build the error of a history that could not be completed."""
    state = end.last.state
    return SolveFailed(f"{REASONS[end.reason]} (at {end.time:.6g} s of {history.time[-1]:.6g} s)", SolveReport(
        "", state.u.size, state.iterations, state.residual, 1.0, 0.0, Ended.HISTORY,
        (Note.of(NoteKind.PATH_END, end=end.reason),), (), state.min_J
    ))


def _on_family(line: Line, levels: Levels, history: LoadHistory, tell: Progress) -> tuple[Motion, bool]:
    """Return the motion on one family of meshes, and whether free faces touch anything."""
    for level in (0, 1):
        levels.check_memory(level)
    body, goals = levels.coarse, history.wrench / line.scales.loads
    held, _ = aim(body, line.scales, under(next((load for load in history.loads if load.out_of_plane), Wrench())))
    asked = min(line.asked, 1.0)
    count, loads = min(WALKED, len(levels)), (history.time, goals[:, : body.components])
    times, first = _timed(body, held, loads, _GROWTH * asked, _shares(tell, 0, count))
    walks, large = [first, _walked(levels.fine, held, times, _shares(tell, 1, count))], None
    found = _limits(levels, times, walks)
    for level in range(2, count):
        if found.relative <= asked:
            break
        if large := levels.check_memory(level):
            break
        try:
            walks.append(_walked(levels.maker(level), held, times, _shares(tell, level, count)))
        except _Ended:
            break
        found = _limits(levels, times, walks)
    return _motion(line, levels, times, walks, found, large), any(walk.touches for walk in walks)


def _shares(tell: Progress, level: int, count: int) -> Callable[[float], None]:
    """Scale the progress of one level's walk to its share of the whole."""
    return lambda share: tell(round(100 * (level + share)), 100 * count)


class _Limits(NamedTuple):
    """Extrapolated motion and error over time."""

    q: Array  # (m, k) [thicknesses, rad]
    error: Array  # of q, (m, k)
    relative: float  # largest error over the motion


def _limits(levels: Levels, times: _Times, walks: list[_Walk]) -> _Limits:
    """Extrapolate some walks at each time; errors over the largest displacement of the history."""
    weight = levels.coarse.levers
    late = np.array([np.array(walk.q) + times.late for walk in walks]) * weight
    size = max(np.max(np.abs(late[-1])), 1e-300)
    values, errors = [], []
    for rows, gap in zip(np.moveaxis(late / size, 1, 0), times.gap, strict=True):
        limit = levels.limit(list(rows), pressed=any(walk.pressed for walk in walks), sink=-size * rows[-1][1])
        values.append(limit.value)
        own = np.maximum(limit.error + np.abs(gap * weight) / size, _LEAST if np.any(rows) else 0.0)
        errors.append(errors_of(own, levels.share))
    unit = size / weight
    return _Limits(np.array(values) * unit, np.array(errors) * unit, float(np.max(errors)))


def _motion(
    line: Line, levels: Levels, times: _Times, walks: list[_Walk], found: _Limits, large: Note | None
) -> Motion:
    """Return the motion in SI with its report."""
    scales, last, body, sensor = line.scales, walks[-1], levels.fine, line.sensor
    k = body.components
    pose, error = (np.pad(part * scales.lengths[:k], ((0, 0), (0, len(POSE) - k))) for part in found[:2])
    pose[:, 1] += scales.standoff + scales.thickness
    plate = sensor.target.thickness / scales.thickness if sensor.target is not None else 0.0
    state = walks[1].far
    beneath = ground_notes(sensor, scales.pose(state.q))
    if beneath:  # the true target is held there: the error is the whole displacement
        error = np.maximum(error, np.abs(pose - scales.pose(np.zeros(k)).components))
    faces = face_notes(body.faces, body.mesh, body.parts, state.u, state.q, plate)
    stretch, before = (float(np.max(walk.stretch)) for walk in (last, walks[-2]))
    notes = [*beneath, *faces, *law_notes(sensor, stretch), *([large] if large else [])]
    late = float(np.max(np.abs(times.gap * body.levers)) / max(np.max(np.abs(np.array(last.q) * body.levers)), 1e-300))
    notes.append(Note.of(NoteKind.TIMES, count=len(times.time), meshes=len(walks), error=late))
    if found.relative > line.asked:
        notes.append(Note.of(NoteKind.TOLERANCE_MISSED, error=found.relative, tolerance=line.asked))
    report = SolveReport(
        "", len(levels.maker(len(walks) - 1).free) + k, sum(walk.iterations for walk in walks),
        state.residual, found.relative, 0.0, "converged", tuple(notes), (), min(walk.min_J for walk in walks), stretch,
        abs(stretch - before),
    )
    wrench = np.pad(times.load, ((0, 0), (0, len(WRENCH) - k))) * scales.loads
    return Motion(times.time, times.given, wrench, Pose.of(pose), Pose.of(error), np.array(last.stretch), report)


class _Walk:
    """The target's motion over time on one level, kept moment by moment."""

    def __init__(self, body: Bonded) -> None:
        self.body, self.now = body, begun(body)
        self.q: list[Array] = []  # (k,) each
        self.stretch: list[float] = []
        self.far = self.now.state  # farthest state
        self.iterations, self.min_J = 0, np.inf
        self.touches = self.pressed = False

    def keep(self, moment: Moment, iterations: int) -> None:
        """Append a moment and make it the present one."""
        body, state = self.body, moment.state
        self.now, self.iterations = moment, self.iterations + iterations
        self.q.append(state.q)
        self.far = max(self.far, state, key=lambda each: body.length(each.q))
        self.min_J = min(self.min_J, state.min_J)
        self.stretch.append(largest_stretch(body, state.u))
        self.touches |= body.touching(state).touch
        self.pressed |= body.pressed(state)


def _walked(body: Bonded, held: Held, times: _Times, tell: Callable[[float], None]) -> _Walk:
    """Walk in given time steps."""
    kept, at = _Walk(body), times.time[0]
    for number, (time, load) in enumerate(zip(times.time, times.load, strict=True), 1):
        moment = _stepped(body, kept.now, float(time - at), load, held, float(time))
        kept.keep(moment, moment.state.iterations)
        at = time
        tell(number / len(times.time))
    return kept


def _stepped(body: Bonded, now: Moment, dt: float, load: Array, held: Held, time: float) -> Moment:
    """Return the moment one step later."""
    found, reason = later(body, now, dt, load, held=held)
    if found is None:
        raise _Ended(time, reason, now)
    return found


class _Pair:
    """The first level's walks: A in steps of time, B in two halves of each."""

    def __init__(self, body: Bonded, held: Held, growth: float) -> None:
        self.body, self.held, self.growth = body, held, growth
        self.kept, self.other = _Walk(body), begun(body)
        self.time: list[float] = []
        self.load: list[Array] = []
        self.given: list[bool] = []
        self.gap: list[Array] = []
        self.step, self.size = np.inf, 1e-300
        self.less = 1.0 if rough(body) else 3.0

    def leg(self, begin: float, end: float, loads: tuple[Array, Array]) -> None:
        """Walk from one time of the history to the next, or over a sudden load."""
        span, gone, (first, last) = end - begin, 0.0, loads
        while True:
            left = span - gone
            count = max(int(np.ceil(left / self.step - _ROUNDING)), 1) if left > 0.0 else 1
            dt, there = left / count, span if count == 1 else gone + left / count
            shares = [part / span if span > 0.0 else 1.0 for part in (gone, gone + 0.5 * dt, there)]
            middle, load = (first + (last - first) * share for share in shares[1:])
            if not self._gone(begin + there, dt, (middle, load), shortest=_SHORTEST * span):
                continue
            gone = there
            self.time.append(begin + there)
            self.load.append(load)
            self.given.append(count == 1)
            if count == 1:
                return

    def _gone(self, time: float, dt: float, loads: tuple[Array, Array], shortest: float) -> bool:
        """Take a step if it adds little to the error in time; choose the next step from what it adds."""
        body, held, weight = self.body, self.held, self.body.levers
        whole, half = _stepped(body, self.kept.now, dt, loads[1], held, time), None
        if dt > 0.0:
            half = _stepped(body, self.other, 0.5 * dt, loads[0], held, time)
        twice = _stepped(body, half or self.other, 0.5 * dt, loads[1], held, time)
        gap = (twice.state.q - whole.state.q) / self.less
        self.size = max(self.size, np.max(np.abs(twice.state.q * weight)))
        added = float(np.max(np.abs((gap - (self.gap[-1] if self.gap else 0.0)) * weight))) / self.size
        if dt > 0.0:
            change = _SAFE * (self.growth / max(added, 1e-300)) ** (1.0 / _ORDER)
            self.step = dt * float(np.clip(change, _SMALLER, _LARGER))
            if added > self.growth and dt > shortest:
                return False
        spent = sum(each.state.iterations for each in (whole, half, twice) if each is not None)
        self.kept.keep(whole, spent)
        self.other = twice
        self.gap.append(gap)
        return True


def _timed(
    body: Bonded, held: Held, loads: tuple[Array, Array], growth: float, tell: Callable[[float], None]
) -> tuple[_Times, _Walk]:
    """Walk the first level with steps limited by the error in time; before the first time there is no load."""
    pair, (at, goals) = _Pair(body, held, growth), loads
    ends = [(at[0], np.zeros(goals.shape[1])), *zip(at, goals, strict=True)]
    for number, ((begin, first), (end, last)) in enumerate(pairwise(ends), 1):
        pair.leg(float(begin), float(end), (first, last))
        tell(number / len(at))
    time, load, gap = (np.array(part) for part in (pair.time, pair.load, pair.gap))
    late = gap if rough(body) else 4.0 * gap
    return _Times(time, load, np.array(pair.given, dtype=bool), gap, late), pair.kept
