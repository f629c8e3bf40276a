"""Histories of loads and the motions they cause: times with wrenches in, times with poses out.

A history gives the wrench at some times, or of components that are held the target's place, whose force is found;
between them it goes evenly, twice the same time is a sudden change, and before the first there was no load on virgin
material. Models at finite strain follow it with the memory of their silicone at every point (`TimedModel`;
levels/in_time.py). Others answer by the cheap rung, a memory of the pad as a whole (silicone/history.py): each
component of the load has crept by itself to an elastic one, and where the target is held this one relaxes,

    q(t) = q_e(Q_e(t)),      Q_e(t) = int_0^t C(t - s) dQ(s),      Q(t) = int_0^t G(t - s) dQ_e(s),

exact at small strain; the softening of a whole pad is known of proportional loads only, and is refused here. There Q_e
of a held target is that of one compliance C, and what the model's place is beside the held one counts as its error.

Of the times of a history some are solved, by default all; the load goes through the others on its way.
"""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Protocol, runtime_checkable

import numpy as np

from sits_mech.cases import Progress, untold
from sits_mech.mechanics.equilibrium.control import DOWN, PLACES, Control
from sits_mech.mechanics.pad.section import layer_parts
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import POSE, WRENCH, Array, Mask, MechanicalModel, Pose, SolveReport, Wrench
from sits_mech.scene.sensor import SceneError, Sensor, silicone_of
from sits_mech.scene.thermal import at_temperature
from sits_mech.silicone.history import relaxed_share, retardation

_EARLY, _LATE = 0.1, 10.0  # of the shortest and longest times of a creep: before and after nothing moves
_A_DECADE = 8  # times of a decade
_CORNER = 0.5  # of a load's rate: a jump by more is a corner
_SMALL = 1e-3  # shear of the loads by which a compliance is found


@dataclass(frozen=True)
class LoadHistory:
    """Loads, or places of the target, over time, linear in between."""

    time: Array  # (n,), not descending; repeated for a sudden change [s]
    course: Array  # (n, 6), loads as `WRENCH` [N, N m]; where held motions from the undeformed pad, as `POSE` [m, rad]
    solved: Mask = field(default_factory=lambda: np.array(True))  # (n,), which times are to be solved
    held: Mask = field(default_factory=lambda: np.array(False))  # (6,), components whose places are given

    def __post_init__(self) -> None:
        """Validate times and loads."""
        try:
            time, course = np.asarray(self.time, dtype=float), np.asarray(self.course, dtype=float)
        except ValueError:
            raise SceneError("history: must be n times with n x 6 loads; got no numbers, or unlike rows") from None
        solved, held = np.broadcast_to(self.solved, time.shape), np.broadcast_to(self.held, (len(WRENCH),))
        vars(self).update(time=time, course=course, solved=solved, held=held)
        if time.ndim != 1 or course.shape != (time.size, len(WRENCH)) or time.size < 1:
            raise SceneError(f"history: must be n times with n x 6 loads; got {time.shape} and {course.shape}")
        if not (np.all(np.isfinite(time)) and np.all(np.isfinite(course))):
            raise SceneError("history: times and loads must be finite numbers")
        back = np.flatnonzero(np.diff(time) < 0.0)
        if back.size:
            row = int(back[0]) + 1
            got = f"{time[row]:g} s after {time[row - 1]:g} s in row {row + 1}"
            raise SceneError(f"history: time must not run back; got {got}")

    def divided(self, parts: int, apart: int = 0) -> tuple[LoadHistory, Mask]:
        """Return the history with few times to be solved, and which times are its own.

        Steps above 1/parts of a component's range that take time are divided. Solved are corners, and between them
        times as far apart as the load moves by 1/apart of its range (by default of `parts`), at least one.
        """
        steps = np.max(np.abs(np.diff(self.shares, axis=0)), axis=1, initial=0.0)
        counts = np.maximum(np.ceil(parts * steps * (np.diff(self.time) > 0.0) - 1e-9).astype(int), 1)
        number = np.concatenate([[0], np.cumsum(counts)])  # of the history's own times among all
        every = np.arange(number[-1] + 1)
        time = np.interp(every, number, self.time)
        course = np.stack([np.interp(every, number, part) for part in self.course.T], axis=1)
        corners = np.isin(every, number[self.corners])
        solved = corners.copy()
        moved = (apart or parts) * np.concatenate([[0.0], np.cumsum(np.repeat(steps / counts, counts))])
        for begin, end in pairwise(np.flatnonzero(corners).tolist()):
            last = begin
            for row in range(begin + 1, end):
                if moved[row + 1] - moved[last] > 1.0 + 1e-9 or (last == begin and 2 * row >= begin + end):
                    solved[row], last = True, row
        return LoadHistory(time, course, solved, self.held), np.isin(every, number)

    @property
    def shares(self) -> Array:
        """The loads over the ranges of their components, (n, 6) [-]."""
        span = np.ptp(np.vstack([np.zeros(len(WRENCH)), self.course]), axis=0)
        return np.asarray(self.course / np.maximum(span, 1e-300))

    @property
    def corners(self) -> Mask:
        """Which times, (n,), are ends of a leg: first and last, sudden changes, and where the load's rate jumps."""
        span = np.diff(self.time)
        rate = np.diff(self.shares, axis=0) / np.where(span > 0.0, span, 1.0)[:, None]
        size, jump = np.linalg.norm(rate, axis=1), np.linalg.norm(np.diff(rate, axis=0), axis=1)
        found = np.ones(self.time.size, dtype=bool)
        found[1:-1] = jump > _CORNER * np.maximum(size[1:], size[:-1])
        sudden = np.flatnonzero(span <= 0.0)
        found[sudden] = found[sudden + 1] = True
        return found

    @property
    def farthest(self) -> Control:
        """The largest of each component, as it is given."""
        most = self.course[np.argmax(np.abs(self.course), axis=0), np.arange(len(WRENCH))]
        given = zip(PLACES, WRENCH, self.held, (most * np.where(self.held, DOWN, 1.0)).tolist(), strict=True)
        return Control(**{place if held else force: value for place, force, held, value in given})


@dataclass(frozen=True)
class Motion:
    """A target's motion under a history of loads, at m times."""

    time: Array  # the history's, and steps in between [s]
    given: Mask  # (m,), which are the history's
    wrench: Array  # (m, 6), given or found [N, N m]
    error_wrench: Array  # (m, 6), of components whose places are given [N, N m]
    pose: Pose  # components (m,)
    error: Pose  # absolute, components (m,) [m, rad]
    stretch: Array  # (m,), as in `SolveReport`; nan if no layer is solved
    report: SolveReport  # `estimated_error`: largest error over the largest displacement


@runtime_checkable
class TimedModel(Protocol):
    """A mechanical model whose silicone has memory at every point."""

    def in_time(self, history: LoadHistory, tell: Progress = untold) -> Motion:
        """Return the target's motion, reporting progress; raise SolveFailed where there is no equilibrium."""
        ...


def motion_of(sensor: Sensor, layer: MechanicalModel, history: LoadHistory, tell: Progress = untold) -> Motion:
    """Return a target's motion under a history of loads, reporting progress.

    Raise SceneError if the model cannot represent the silicone's softening, SolveFailed without an equilibrium on the
    way.
    """
    return layer.in_time(history, tell) if isinstance(layer, TimedModel) else _as_a_whole(sensor, layer, history)


def undeformed(sensor: Sensor) -> Array:
    """Return the components of the pose over the undeformed pad, (6,) [m, rad]."""
    pad = at_temperature(sensor).elastomer
    return Pose(0.0, 0.0 if pad is None else pad.standoff + pad.thickness).components


def compliant_loads(sensor: Sensor, layer: MechanicalModel, course: Array, held: Mask) -> tuple[Array, Array]:
    """Return the elastic loads of a course, (n, 6), and their derivatives by it, (6, 6), by one compliance.

    ``q = q_0 + C Q`` of components that are held, in the plane, with Q given of the others.
    """
    if not held.any():
        return course, np.eye(len(WRENCH))
    target, pad = layer_parts(sensor)
    force = _SMALL * pad.shear_modulus * math.prod(target.extent)
    sizes = {"F_x": force, "F_z": force, "M": force * pad.thickness}
    none, *moved = (
        layer.equilibrium(load).pose.components for load in (Wrench(), *(Wrench(**{k: v}) for k, v in sizes.items()))
    )
    C = np.zeros((len(POSE), len(WRENCH)))
    C[:, : len(sizes)] = (np.array(moved) - none).T / list(sizes.values())
    by_course = np.linalg.inv(np.where(held[:, None], C, np.eye(len(C))))
    return (course - np.where(held, none - undeformed(sensor), 0.0)) @ by_course.T, by_course


def _as_a_whole(sensor: Sensor, layer: MechanicalModel, history: LoadHistory) -> Motion:
    """Return the elastic answers to loads that have crept, component by component: the cheap model."""
    silicone, held = silicone_of(sensor), history.held
    if silicone is not None and silicone.mullins is not None:
        raise SceneError("history: softening (mullins) needs a model at finite strain, planar, axisymmetric or block")
    began, given = clock.process_time(), np.ones(history.time.size, dtype=bool)

    def over(time: Array, parts: Array, some: Mask, *, inverse: bool = False) -> Array:
        """Return parts (n, 6) over time, of which some have crept, or relaxed if `inverse`."""
        if silicone is None or not silicone.prony:
            return parts
        each = zip(parts.T, some, strict=True)
        return np.stack([relaxed_share(silicone, time, p, inverse=inverse) if own else p for p, own in each], axis=1)

    if silicone is not None and silicone.prony:
        times = retardation(silicone.prony)[1], np.array([tau for _, tau in silicone.prony if held.any()])
        history, given = _as_it_creeps(history, np.concatenate(times))
    crept, rest = over(history.time, history.course, ~held), undeformed(sensor)
    elastic, by_course = compliant_loads(sensor, layer, crept, held)
    wrench = over(history.time, np.where(held, elastic, history.course), held, inverse=True)
    solved = history.solved
    time, place = history.time[solved], history.course[solved] + rest
    found = [layer.equilibrium(Wrench(*row)) for row in elastic[solved].tolist()]
    pose, error = (np.array([getattr(each, name).components for each in found]) for name in ("pose", "error"))
    off = np.where(held, error + np.abs(pose - place), 0.0) @ np.abs(by_course).T
    off = np.where(held, np.abs(over(time, off, held, inverse=True)), 0.0)
    told = ((each.report.iterations, each.report.estimated_error, each.report.stretch) for each in found)
    iterations, errors, stretch = zip(*told, strict=True)
    last = found[-1].report
    report = SolveReport(
        last.model, last.unknowns, sum(iterations), last.residual, max(errors), clock.process_time() - began,
        notes=(*last.notes, Note(NoteKind.AS_A_WHOLE)),
    )
    target, away = Pose.of(np.where(held, place, pose)), Pose.of(np.where(held, 0.0, error))
    return Motion(time, given[solved], wrench[solved], off, target, away, np.array(stretch, dtype=float), report)


def _as_it_creeps(history: LoadHistory, times: Array) -> tuple[LoadHistory, Mask]:
    """Add times while a pad with some retardation times still moves; return also which are the history's."""
    between, before = list[float](), list[int]()  # times, and the row of the history that each goes before
    rows = np.flatnonzero(history.solved)
    for row, span in zip(rows[:-1], np.diff(history.time[rows]), strict=True):
        first, last = _EARLY * float(times.min()), min(span, _LATE * float(times.max()))
        count = int(np.ceil(_A_DECADE * np.log10(last / first))) if last > first else 0
        more = history.time[row] + np.geomspace(first, max(last, first), count, endpoint=False)
        between += more.tolist()
        before += (row + 1 + np.searchsorted(history.time[row + 1 :], more)).tolist()
    course = [np.insert(part, before, np.interp(between, history.time, part)) for part in history.course.T]
    found = replace(
        history, time=np.insert(history.time, before, between), course=np.stack(course, axis=1),
        solved=np.insert(history.solved, before, True),
    )
    return found, np.insert(np.ones(history.time.size, dtype=bool), before, False)
