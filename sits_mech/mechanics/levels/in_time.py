"""Follow a layer with memory under a history of loads: time steps on every level of a family of meshes.

Time. A step (equilibrium/increments.py) is of second order. On the first level two walks go side by side, A in steps
dt, B in two halves of each, each with a memory of its own: the remaining error of B is a third of their difference,

    q = q_B + (q_B - q_A)/3,      error in time = |q_B - q_A|/3,

of the whole walk so far, not of a step. A step that lets it grow by more than a share of the tolerance is repeated,
shorter; the times of the history that are to be solved are always met, and sudden loads cost one step. Both walks take
the loads of the history at their own times, so that the difference holds what the load does within a step.

Space. Further levels walk in the steps of A, and the first level's correction in time is added to them; poses are
extrapolated at each time as they are of an elastic layer (family.py), with errors over the largest displacement of the
history. Three levels are walked at most. Of components whose places are given the load is found in place of q, with
errors over the largest load.

Contact. As for one load (settle.py): where a free face comes to lie on ground, target or another at any time, the whole
history is walked with contact. With friction a step is of first order: the error is ``|q_B - q_A|``, and q is q_B.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sits_mech.cases import Progress, no_progress
from sits_mech.geometry.collision import ground_notes
from sits_mech.mechanics.equilibrium.body import Bonded, State
from sits_mech.mechanics.equilibrium.control import under
from sits_mech.mechanics.equilibrium.increments import Moment, begun, later, rough
from sits_mech.mechanics.equilibrium.outcome import REASONS, PathEnd
from sits_mech.mechanics.histories import LoadHistory, Motion
from sits_mech.mechanics.levels.answer import (
    Stretched,
    errors_of,
    law_notes,
    layer_stretch,
    scaled_control,
    touch_notes,
)
from sits_mech.mechanics.levels.family import PAIR, WALKED, Levels, Line
from sits_mech.mechanics.levels.refine import refinements
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import POSE, Array, Ended, Mask, Pose, SolveFailed, SolveReport

_GROWTH = 0.03  # of the tolerance: what a step may add to the error in time
_LARGER, _SMALLER, _SAFE = 3.0, 0.2, 0.9  # of a step, from one to the next
_ORDER = 3.0  # of what one step adds
_LEAST = 1e-6  # of the largest displacement: no error is called smaller, whatever meshes agree on near zero
_ROUNDING = 1e-9  # of a step
_LIMITS = PathEnd.BUCKLED, PathEnd.SIDEWAYS, PathEnd.TURNED  # what two families of meshes say is not their fault
_SHORTEST = 1e-6  # of the time between two loads of the history


class _Ended(Exception):
    """A walk that found no equilibrium: when, why, and the last moment."""

    def __init__(self, time: float, reason: PathEnd, last: Moment) -> None:
        super().__init__(reason)
        self.time, self.reason, self.last = time, reason, last


def motion_in_time(line: Line, history: LoadHistory, progress: Progress = no_progress) -> Motion:
    """Return the target's motion under a history of loads; `progress`: parts done, of all.

    Raise SolveFailed, with the time reached, where no family of meshes completes the history.
    """
    ended: list[_Ended] = []
    numbers = list(range(PAIR))
    while numbers and sum(each.reason in _LIMITS for each in ended) < 2:
        number = numbers.pop(0)
        try:
            motion, touches = _on_family(line, line[number], history, progress)
        except _Ended as end:
            ended.append(end)
            continue
        if number in line.last or not touches:
            progress(100, 100)
            return motion
        numbers = list(line.last)
    last = max(ended, key=lambda each: each.time)
    state, why = last.last.state, f"{REASONS[last.reason]} (at {last.time:.6g} s of {history.time[-1]:.6g} s)"
    raise SolveFailed(why, SolveReport(
        "", state.u.size, state.iterations, state.residual, 1.0, 0.0, Ended.HISTORY,
        (Note.of(NoteKind.PATH_END, end=last.reason),), (), state.min_J
    ))


def _on_family(line: Line, levels: Levels, history: LoadHistory, progress: Progress) -> tuple[Motion, bool]:
    """Return the motion on one family of meshes, and whether free faces touch anything."""
    asked, count, scales = min(line.asked, 1.0), min(WALKED, len(levels)), line.scales
    ends, k = history.course / np.where(history.held, scales.lengths, scales.loads), levels.coarse.components
    given = history.held[:k]
    sides = scaled_control(levels.coarse, scales, under(history.farthest))[0] | given, given
    first = _First(levels.coarse, sides, _GROWTH * asked)

    def share(level: int) -> Callable[[float], None]:
        """Scale the progress of one level's walk to its share of the whole."""
        return lambda part: progress(round(100 * (level + part)), 100 * count)

    def walked() -> Iterator[_Walk]:
        """Yield the walks of the levels; further ones as long as they get to the end."""
        first.timed(history.time, ends[:, :k], np.flatnonzero(history.solved), share(0))
        yield first
        for level in range(1, count):
            try:
                yield _Walk(levels.maker(level), sides).follow(first, share(level))
            except _Ended:
                if level == 1:
                    raise
                return

    for walks in refinements(levels, walked(), count):
        large, least = None, (walks[0].least, walks[1].least)
        if len(walks) == count or _limits(levels, first, walks).relative <= asked or levels.creased(least):
            break  # or a further one would crease
        large = levels.check_memory(len(walks))
    return _motion(line, levels, first, walks, large), any(walk.touches for walk in walks)


class _Limits(NamedTuple):
    """Extrapolated motion over time, of components whose places are given the load, with its error."""

    value: Array  # (m, k), scaled
    error: Array  # (m, k)
    relative: float  # largest error over the largest motion, or load
    late: float  # that in time


def _limits(levels: Levels, first: _First, walks: Sequence[_Walk]) -> _Limits:
    """Extrapolate some walks at each time; errors over the largest displacement, or load, of the history."""
    gaps, pressed = np.array(first.gap), any(walk.pressed for walk in walks)
    levels = levels.folding((walks[0].least, walks[1].least))
    late = [np.array(walk.found) + gaps * (1.0 if rough(levels.coarse) else 4.0) for walk in walks]
    q, load = first.both(late[-1])
    unit, values, errors = first.unit(q, load), [], []
    for rows, gap, moved in zip(np.moveaxis(np.array(late) / unit, 1, 0), gaps / unit, q, strict=True):
        limit = levels.limit(list(rows), pressed=pressed, sunk=levels.fine.sunk(moved))
        values.append(limit.value)
        own = np.maximum(limit.error + np.abs(gap), _LEAST if np.any(rows) else 0.0)
        errors.append(errors_of(own, levels.share))
    error = np.array(errors)
    return _Limits(np.array(values) * unit, error * unit, float(np.max(error)), float(np.max(np.abs(gaps / unit))))


def _motion(line: Line, levels: Levels, first: _First, walks: Sequence[_Walk], large: Note | None) -> Motion:
    """Return the motion in SI with its report."""
    scales, body, sensor, found = line.scales, levels.fine, line.sensor, _limits(levels, first, walks)
    last, beyond, (q, load) = walks[-1], ((0, 0), (0, len(POSE) - body.components)), first.both(found.value)
    pose, error = (np.pad(part, beyond) * scales.lengths for part in (q, found.error * ~first.given))
    wrench, off = (np.pad(part, beyond) * scales.loads for part in (load, found.error * first.given))
    pose[:, 1] += scales.standoff + scales.thickness
    state = walks[1].far
    beneath = ground_notes(sensor, scales.pose(state.q))
    if beneath:  # the true target is held there: the error is the whole displacement
        error = np.maximum(error, np.abs(pose - scales.pose(0.0 * state.q).components))
    stretches = [np.array([each.value for each in walk.stretch]) for walk in walks[-2:]]
    before, stretch = map(float, map(np.max, stretches))
    each = np.max([moment.each for moment in last.stretch], axis=0)
    notes = [*beneath, *touch_notes(line, body, state), *law_notes(sensor, each), *filter(None, [large])]
    notes.append(Note.of(NoteKind.TIMES, count=len(first.time), meshes=len(walks), error=found.late))
    report = SolveReport(
        "", len(levels.maker(len(walks) - 1).free) + body.components, sum(walk.iterations for walk in walks),
        state.residual, found.relative, 0.0, "converged", tuple(notes), (),
        min(walk.least.min_J for walk in walks), stretch, abs(stretch - before),
    ).judged(line.asked)
    return Motion(
        np.array(first.time), np.array(first.rows), wrench, off, Pose.of(pose), Pose.of(error), stretches[-1], report
    )


class _Walk:
    """The target's motion over time on one level, kept moment by moment."""

    def __init__(self, body: Bonded, sides: tuple[Mask, Mask]) -> None:
        self.body, self.now = body, begun(body)
        self.held, self.given = sides  # components that are held, those of them whose places are given
        self.found: list[Array] = []  # motion, or load where the place is given, (k,) each
        self.stretch: list[Stretched] = []
        self.far = self.least = self.now.state  # farthest state; that of least J
        self.iterations = 0
        self.touches = self.pressed = False

    def keep(self, moment: Moment, iterations: int) -> None:
        """Append a moment and make it the present one."""
        body, state = self.body, moment.state
        self.now, self.iterations = moment, self.iterations + iterations
        self.found.append(self.answer(state))
        self.far = max(self.far, state, key=lambda each: body.length(each.q))
        self.least = min(self.least, state, key=lambda each: each.min_J)
        self.stretch.append(layer_stretch(body, state.u))
        self.touches |= body.touching(state).touch
        self.pressed |= body.pressed(state)

    def answer(self, state: State) -> Array:
        """Return what is found in a state, (k,)."""
        return np.where(self.given, state.load, state.q)

    def step(self, now: Moment, dt: float, end: Array, time: float) -> Moment:
        """Return the moment one step later."""
        found = later(self.body, now, dt, end, self.held)
        if isinstance(found, PathEnd):
            raise _Ended(time, found, now)
        return found

    def follow(self, first: _First, progress: Callable[[float], None]) -> _Walk:
        """Walk in the steps of the first level."""
        at = first.time[0]
        for number, (time, end) in enumerate(zip(first.time, first.ends, strict=True), 1):
            moment = self.step(self.now, time - at, end, time)
            self.keep(moment, moment.state.iterations)
            at = time
            progress(number / len(first.time))
        return self


class _First(_Walk):
    """The first level's walks: A in steps of time, B in two halves of each."""

    def __init__(self, body: Bonded, sides: tuple[Mask, Mask], growth: float) -> None:
        super().__init__(body, sides)
        self.growth, self.other = growth, begun(body)
        self.time: list[float] = []
        self.ends: list[Array] = []
        self.rows: list[bool] = []  # which times are the history's
        self.gap: list[Array] = []  # error in time of what is found, (k,) each
        self.next, self.size = np.inf, 0.0 * body.levers  # step, units of what is found so far
        self.less = 1.0 if rough(body) else 3.0

    def unit(self, q: Array, load: Array) -> Array:
        """Return the units of what is found, (k,), by the largest of motions and of loads at the target's end."""
        lever = self.body.levers
        moved, pressed = (np.max(np.abs(part), initial=1e-300) for part in (q * lever, load / lever))
        return np.asarray(np.where(self.given, pressed * lever, moved / lever))

    def both(self, found: Array) -> tuple[Array, Array]:
        """Return motions and loads, (m, k) each, of which one is found and the other given."""
        ends = np.array(self.ends)
        return np.where(self.given, ends, found), np.where(self.given, found, ends)

    def timed(self, times: Array, loads: Array, rows: NDArray[np.int_], progress: Callable[[float], None]) -> None:
        """Walk with steps limited by the error in time, to some rows; before the first time there is no load."""
        self._leg(np.repeat(times[:1], 2), np.array([np.zeros(loads.shape[1]), loads[0]]))
        for begin, end in pairwise(rows):
            self._leg(times[begin : end + 1], loads[begin : end + 1])
            progress(end / len(times))

    def _leg(self, times: Array, loads: Array) -> None:
        """Walk from one time of the history to another, or over a sudden load."""
        begin, span, gone = float(times[0]), float(times[-1] - times[0]), 0.0

        def at(moment: float) -> Array:
            """Return the loads at a time after the leg's first, after a sudden one."""
            return np.array([np.interp(moment, times - begin, part) for part in loads.T])

        while True:
            left = span - gone
            count = max(int(np.ceil(left / self.next - _ROUNDING)), 1) if left > 0.0 else 1
            dt = left / count
            there = span if count == 1 else gone + dt
            if not self._gone(begin + there, dt, (at(gone + 0.5 * dt), at(there)), shortest=_SHORTEST * span):
                continue
            gone = there
            self.time.append(float(times[-1]) if count == 1 else begin + there)
            self.ends.append(at(there))
            self.rows.append(count == 1)
            if count == 1:
                return

    def _gone(self, time: float, dt: float, loads: tuple[Array, Array], shortest: float) -> bool:
        """Take a step if it adds little to the error in time; choose the next step from what it adds."""
        whole = self.step(self.now, dt, loads[1], time)
        half = self.step(self.other, 0.5 * dt, loads[0], time) if dt > 0.0 else None
        twice = self.step(half or self.other, 0.5 * dt, loads[1], time)
        gap = (self.answer(twice.state) - self.answer(whole.state)) / self.less
        self.size = np.maximum(self.size, self.unit(twice.state.q, twice.state.load))
        added = float(np.max(np.abs(gap - (self.gap[-1] if self.gap else 0.0)) / self.size))
        if dt > 0.0:
            change = _SAFE * (self.growth / max(added, 1e-300)) ** (1.0 / _ORDER)
            self.next = dt * float(np.clip(change, _SMALLER, _LARGER))
            if added > self.growth and dt > shortest:
                return False
        self.keep(whole, sum(each.state.iterations for each in (whole, half, twice) if each is not None))
        self.other = twice
        self.gap.append(gap)
        return True
