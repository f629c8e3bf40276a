"""Where does a layer with a memory go under a history of loads? Steps of time on every level of a family of meshes.

Time. A step (rest/steps.py) is of second order. On the first level two walks go side by side, A in steps dt, B in two
halves of each, each with a memory of its own: what is left of B is a third of what they differ by,

    q = q_B + (q_B - q_A)/3,      error in time = |q_B - q_A|/3,

of the whole walk so far, not of a step. A step that lets it grow by more than a share of the tolerance is taken anew,
shorter; the times of the history are always met, and sudden loads cost one step.

Space. Further levels walk in the steps of A, and what the first level tells of time is added to them; poses are
extrapolated at each time as they are of an elastic layer (family.py), with errors over the largest displacement of the
history. Three levels are walked at most.

Contact. As for one load (retry.py): where a free face comes to lie on ground, target or another at any time, the whole
history is walked with contact. With friction, as it is without: each step is an increment.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.faces.face_contact import face_contact, face_notes, faces_press
from sits_mech.mechanics.histories import LoadHistory, Motion
from sits_mech.mechanics.levels.answer import aim, errors_of, largest_stretch, law_notes
from sits_mech.mechanics.levels.family import FEWEST, Levels, extrapolated
from sits_mech.mechanics.levels.retry import Line
from sits_mech.mechanics.rest.body import Bonded
from sits_mech.mechanics.rest.control import under
from sits_mech.mechanics.rest.linearisation import Held
from sits_mech.mechanics.rest.steps import Moment, begun, later
from sits_mech.mechanics.rest.verdict import reason_words
from sits_mech.quantities import WRENCH, Array, Pose, SolveFailed, SolveReport, Wrench

_GROWTH = 0.03  # of the tolerance: what a step may add to the error in time
_LARGER, _SMALLER, _SAFE = 3.0, 0.2, 0.9  # of a step, from one to the next
_ORDER = 3.0  # of what one step adds
_SHORTEST = 1e-6  # of the time between two loads of the history


class _Walk(NamedTuple):
    """Where a target was at each time, shape (m, k), the last moment, steps, the least J, the largest stretch."""

    q: Array
    last: Moment
    iterations: int
    min_J: float
    stretch: float
    touches: bool
    pressed: bool


@dataclass(frozen=True)
class _Times:
    """The steps that the first level was walked in: their ends, loads there, which are the history's, and time's error.

    `gap` is ``(q_B - q_A)/3`` at each, shape (m, k) [thicknesses, rad].
    """

    time: Array
    load: Array
    given: Array
    gap: Array

    @property
    def late(self) -> Array:
        """What is added to a walk in steps A."""
        return 4.0 * self.gap


class _Ended(Exception):
    """A walk that came to no rest: when, why, and the last moment."""

    def __init__(self, time: float, reason: str, last: Moment) -> None:
        super().__init__(reason)
        self.time, self.reason, self.last = time, reason, last


def motion_in_time(line: Line, history: LoadHistory) -> Motion:
    """Return where the target of a layer goes under a history of loads.

    Parameters
    ----------
    line : Line
        Of the layer, whole where a load leaves the plane.
    history : LoadHistory

    Raises
    ------
    SolveFailed
        Where no family of meshes gets to the end of the history; ``report.status`` says when it ended.
    """
    ended: list[_Ended] = []
    numbers, touched = list(range(line.free)), False
    while numbers:
        number = numbers.pop(0)
        try:
            motion, touches = _on_family(line, line[number], history)
        except _Ended as end:
            ended.append(end)
            numbers = numbers or ([] if touched else list(range(line.free, len(line))))
            continue
        if number >= line.free or not touches or line.free == len(line):
            return motion
        touched, twin = True, line.twins[number]
        numbers = list(range(line.free if twin is None else twin, len(line)))
    raise _failed(line, history, max(ended, key=lambda each: each.time))


def _failed(line: Line, history: LoadHistory, end: _Ended) -> SolveFailed:
    """What is said of a history that could not be followed to its end."""
    state = end.last.state
    words = f"{reason_words(end.reason)} (at {end.time:.6g} s of {history.time[-1]:.6g} s)"
    report = SolveReport(
        "", state.u.size, state.iterations, state.residual, 1.0, 0.0, f"history ended at {end.time:.6g} s",
        min_J=state.min_J,
    )  # fmt: skip
    return SolveFailed(f"history: {words}", report)


def _on_family(line: Line, levels: Levels, history: LoadHistory) -> tuple[Motion, bool]:
    """The motion on the levels of a family, and whether free faces touch anything on the way."""
    for level in (0, 1):
        levels.check_memory(level)
    scales = line.scales
    goals = history.wrench / scales.loads
    farthest = history.loads[int(np.argmax(np.abs(goals).max(axis=1)))]
    held, _ = aim(levels.coarse, scales, under(farthest))
    goals = goals[:, : levels.coarse.components]
    asked = line.asked if np.isfinite(line.asked) else 1.0
    times, first = _timed(levels.coarse, held, history.time, goals, _GROWTH * asked)
    walks, large = [first], ""
    weight, k = levels.coarse.levers, levels.coarse.components
    walks.append(_walked(levels.fine, held, times))
    size = max(float(np.max(np.abs((walks[1].q + times.late) * weight))), 1e-300)
    pressed = any(walk.pressed for walk in walks)

    def limits() -> tuple[Array, Array]:
        """The limit of the walks at each time and its error, of the largest displacement, shape (m, k) each."""
        found = [
            extrapolated([(walk.q[n] + times.late[n]) * weight / size for walk in walks], levels.sizes, levels.order,
                         pressed=pressed)
            for n in range(len(times.time))
        ]  # fmt: skip
        return np.array([each.value for each in found]), np.array([each.error for each in found])

    value, error = limits()
    for level in range(2, min(FEWEST, len(levels.sizes))):
        large = levels.check_memory(level)
        if np.max(error) <= asked and not levels.is_cheap(level) or large:
            break
        try:
            walks.append(_walked(levels.maker(level), held, times))
        except _Ended:
            break
        value, error = limits()
    error = error + np.abs(times.gap * weight / size)
    share = levels.share if np.isfinite(levels.order) else 0.25
    each = np.array([errors_of(row, np.ones(k), share) for row in error])
    unit = size / weight * scales.lengths[:k]
    return _motion(line, levels, times, walks, (value * unit, each * unit, float(error.max()), large)), first.touches


def _motion(
    line: Line, levels: Levels, times: _Times, walks: list[_Walk], found: tuple[Array, Array, float, str]
) -> Motion:
    """What was found, in SI, with its report."""
    scales, last = line.scales, walks[-1]
    pose, error = (np.pad(part, ((0, 0), (0, 6 - part.shape[1]))) for part in found[:2])
    pose[:, 1] += scales.standoff + scales.thickness
    body, sensor = levels.fine, line.sensor
    plate = sensor.target.thickness / scales.thickness if sensor.target is not None else 0.0
    state = walks[1].last.state
    notes = [*face_notes(body.faces, body.mesh, body.parts, state.u, state.q, plate), *law_notes(sensor, last.stretch)]
    late = float(np.max(np.abs(times.gap * body.levers)) / max(np.max(np.abs(last.q * body.levers)), 1e-300))
    notes.append(f"history: {len(times.time)} times on {len(walks)} meshes; steps of time are worth {late:.1g}")
    report = SolveReport(
        "", len(levels.maker(len(walks) - 1).free) + body.components, sum(walk.iterations for walk in walks),
        state.residual, found[2], 0.0, notes=(*notes, *([found[3]] if found[3] else [])),
        min_J=min(walk.min_J for walk in walks), stretch=last.stretch,
        error_stretch=abs(walks[-1].stretch - walks[-2].stretch),
    )  # fmt: skip
    wrench = np.pad(times.load, ((0, 0), (0, len(WRENCH) - times.load.shape[1]))) * scales.loads
    return Motion(times.time, times.given, wrench, Pose.of(pose), Pose.of(error), report)


class _Recorder:
    """What a walk leaves behind, moment by moment."""

    def __init__(self, body: Bonded) -> None:
        self.body, self.now = body, begun(body)
        self.q: list[Array] = []
        self.iterations, self.min_J, self.stretch = 0, np.inf, 1.0
        self.touches = self.pressed = False

    def keep(self, moment: Moment, iterations: int) -> None:
        """Take a moment as the present one."""
        self.now, self.iterations, state = moment, self.iterations + iterations, moment.state
        self.q.append(state.q)
        self.min_J = min(self.min_J, state.min_J)
        self.stretch = max(self.stretch, largest_stretch(self.body, state.u))
        body = self.body
        self.touches |= face_contact(body.faces, body.mesh, body.parts, state.u, state.q).touch
        self.pressed |= faces_press(body.mesh, body.parts, state.u, state.q)

    @property
    def walk(self) -> _Walk:
        """All of it."""
        return _Walk(
            np.array(self.q), self.now, self.iterations, self.min_J, self.stretch, self.touches, self.pressed
        )  # fmt: skip


def _walked(body: Bonded, held: Held, times: _Times) -> _Walk:
    """A walk in given steps."""
    kept, at = _Recorder(body), times.time[0]
    for time, load in zip(times.time, times.load, strict=True):
        moment = _stepped(body, kept.now, float(time - at), load, held, float(time))
        kept.keep(moment, moment.state.iterations)
        at = time
    return kept.walk


def _stepped(body: Bonded, now: Moment, dt: float, load: Array, held: Held, time: float) -> Moment:
    """The moment a step later."""
    found, reason = later(body, now, dt, load, held=held)
    if found is None:
        raise _Ended(time, reason, now)
    return found


def _timed(body: Bonded, held: Held, at: Array, goals: Array, growth: float) -> tuple[_Times, _Walk]:
    """The first level's walk, and the steps that the error in time allows."""
    kept, other = _Recorder(body), begun(body)
    rows: list[tuple[float, Array, bool]] = []
    gaps: list[Array] = []
    weight, size, step = body.levers, 1e-300, np.inf

    def both(time: float, dt: float, ends: tuple[Array, Array]) -> tuple[Moment, Moment, int]:
        """A step of A and two halves of B."""
        whole = _stepped(body, kept.now, dt, ends[1], held, time)
        if dt == 0.0:
            twice = _stepped(body, other, dt, ends[1], held, time)
            return whole, twice, twice.state.iterations
        half = _stepped(body, other, 0.5 * dt, 0.5 * (ends[0] + ends[1]), held, time)
        twice = _stepped(body, half, 0.5 * dt, ends[1], held, time)
        return whole, twice, half.state.iterations + twice.state.iterations

    before, last = at[0], np.zeros(goals.shape[1])
    for time, goal in zip(at, goals, strict=True):
        gone, span = 0.0, float(time - before)
        while True:
            left = span - gone
            count = max(int(np.ceil(left / step - 1e-9)), 1) if left > 0.0 else 1
            dt = left / count
            ends = [last + (goal - last) * (part / span if span > 0.0 else 1.0) for part in (gone, gone + dt)]
            moments = both(before + gone + dt, dt, (ends[0], ends[1]))
            gap = (moments[1].state.q - moments[0].state.q) / 3.0
            size = max(size, float(np.max(np.abs(moments[1].state.q * weight))))
            added = float(np.max(np.abs((gap - (gaps[-1] if gaps else 0.0)) * weight))) / size
            if dt > 0.0:
                change = float(np.clip(_SAFE * (growth / max(added, 1e-300)) ** (1.0 / _ORDER), _SMALLER, _LARGER))
                step = dt * change
                if added > growth and dt > _SHORTEST * span:
                    continue
            gone = span if count == 1 else gone + dt
            kept.keep(moments[0], moments[0].state.iterations + moments[2])
            other = moments[1]
            rows.append((before + gone, ends[1], gone >= span))
            gaps.append(gap)
            if gone >= span:
                break
        before, last = time, goal
    table = _Times(np.array([row[0] for row in rows]), np.array([row[1] for row in rows]),
                   np.array([row[2] for row in rows]), np.array(gaps))
    return table, kept.walk
