"""Histories of loads and the motions they cause: times with wrenches in, times with poses out.

A history gives the wrench at some times, or of components that are held the target's place, whose force is found;
between them it goes evenly, twice the same time is a sudden change, and before the first there was no load on virgin
material. Models at finite strain follow it with the memory of their silicone at every point (`TimedModel`;
levels/in_time.py), and alone find the force that holds a place. Others answer by the cheap rung, a memory of the pad as
a whole (silicone/history.py): each component of the load has crept by itself to an elastic one,

    q(t) = q_e(Q_e(t)),      Q_e(t) = int_0^t C(t - s) dQ(s),

exact at small strain; the softening of a whole pad is known of proportional loads only, and is refused here.

Of the times of a history some are solved, by default all; the load goes through the others on its way.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Protocol, runtime_checkable

import numpy as np

from sits_mech.cases import Progress, no_progress
from sits_mech.mechanics.pad.section import layer_parts
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import WRENCH, Array, Equilibrium, Mask, MechanicalModel, Pose, SolveReport, Wrench
from sits_mech.scene.sensor import SceneError, Sensor, silicone_of
from sits_mech.silicone.history import relaxed_share, retardation

_EARLY, _LATE = 0.1, 10.0  # of the shortest and longest times of a creep: before and after nothing moves
_A_DECADE = 8  # times of a decade
_CORNER = 0.5  # of a load's rate: a jump by more is a corner


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
        if not np.isfinite(np.column_stack([time, course])).all():
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
    def farthest(self) -> Wrench:
        """The largest of each component, places in their units."""
        return Wrench(*np.abs(self.course).max(axis=0).tolist())


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

    def in_time(self, history: LoadHistory, progress: Progress = no_progress) -> Motion:
        """Return the target's motion, reporting progress; raise SolveFailed where there is no equilibrium."""
        ...


def motion_of(sensor: Sensor, layer: MechanicalModel, history: LoadHistory, progress: Progress = no_progress) -> Motion:
    """Return a target's motion under a history of loads, reporting progress.

    Raise SceneError if the model cannot represent the silicone's softening, or hold places, SolveFailed without an
    equilibrium on the way.
    """
    if isinstance(layer, TimedModel):
        return layer.in_time(history, progress)
    if history.held.any():
        raise SceneError("history: places need a model at finite strain, planar, axisymmetric or block")
    return _as_a_whole(sensor, layer, history)


def expected_loads(sensor: Sensor, history: LoadHistory) -> list[Wrench]:
    """Return the loads of a history, for the choice of models; those that hold places as of columns in shear."""
    target, pad = layer_parts(sensor)
    t, area = pad.thickness, math.prod(target.extent)
    k = pad.shear_modulus * area / t * np.array([1.0, -1.0, t**2, 1.0, t**2, t**2])
    return [Wrench(*row) for row in (history.course * np.where(history.held, k, 1.0)).tolist()]


def _as_a_whole(sensor: Sensor, layer: MechanicalModel, history: LoadHistory) -> Motion:
    """Return the elastic answers to loads that have crept, component by component: the cheap model."""
    silicone = silicone_of(sensor)
    if silicone is not None and silicone.mullins is not None:
        raise SceneError("history: softening (mullins) needs a model at finite strain, planar, axisymmetric or block")
    began, given, crept = clock.process_time(), np.ones(history.time.size, dtype=bool), history.course
    if silicone is not None and silicone.prony:
        history, given = _as_it_creeps(history, retardation(silicone.prony)[1])
        crept = np.stack([relaxed_share(silicone, history.time, part) for part in history.course.T], axis=1)
    solved = history.solved
    history, given, crept = LoadHistory(history.time[solved], history.course[solved]), given[solved], crept[solved]
    found = [layer.equilibrium(Wrench(*row)) for row in crept.tolist()]
    return through_rests(history, given, found, clock.process_time() - began, (Note(NoteKind.AS_A_WHOLE),))


def through_rests(
    history: LoadHistory, given: Mask, rests: Sequence[Equilibrium], seconds: float, notes: tuple[Note, ...] = ()
) -> Motion:
    """Return the motion of a target that rests at each time of a history; `given` as of `Motion`."""
    pose, error = (Pose.of(np.array([getattr(each, name).components for each in rests])) for name in ("pose", "error"))
    reports = [each.report for each in rests]
    last, stretch = reports[-1], np.array([each.stretch for each in reports], dtype=float)
    report = SolveReport(
        last.model, max(each.unknowns for each in reports), sum(each.iterations for each in reports), last.residual,
        max(each.estimated_error for each in reports), seconds, notes=tuple(dict.fromkeys((*last.notes, *notes))),
    )
    return Motion(history.time, given, history.course, 0.0 * history.course, pose, error, stretch, report)


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
    solved = np.insert(history.solved, before, True)
    found = LoadHistory(np.insert(history.time, before, between), np.stack(course, axis=1), solved)
    return found, np.insert(np.ones(history.time.size, dtype=bool), before, False)
