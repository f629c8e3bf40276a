"""What is a history of loads, and what comes of it? Times with wrenches in, times with poses out.

A history gives the wrench at some times; between them it goes evenly, twice the same time is a sudden change, and
before the first there was no load on virgin material. Models at finite strain follow it with the memory of their
silicone at every point (`TimedModel`; levels/in_time.py). Others answer by the cheap rung, a memory of the pad as a
whole (silicone/history.py): each component of the load has crept by itself to an elastic one,

    q(t) = q_e(Q_e(t)),      Q_e(t) = int_0^t C(t - s) dQ(s),

exact at small strain; the softening of a whole pad is known of proportional loads only, and is refused here.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from sits_mech.quantities import POSE, WRENCH, Array, MechanicalModel, Pose, SolveReport, Wrench
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.silicone.history import relaxed_share, retardation

_EARLY, _LATE = 0.1, 10.0  # of the shortest and longest times of a creep: before and after nothing moves
_A_DECADE = 8  # times of a decade
Progress = Callable[[int, int], None]
"""Is told how many parts of a work are done, of how many."""


def untold(done: int, total: int) -> None:
    """Tell nobody."""


@dataclass(frozen=True)
class LoadHistory:
    """Wrenches over time.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Not descending; twice the same is a sudden change [s].
    wrench : ndarray, shape (n, 6)
        In the order of `WRENCH` [N, N m].
    """

    time: Array
    wrench: Array

    def __post_init__(self) -> None:
        """Refuse what is no history."""
        time, wrench = self.time, self.wrench
        if time.ndim != 1 or wrench.shape != (time.size, len(WRENCH)) or time.size < 1:
            raise SceneError(f"history: must be n times with n x 6 loads; got {time.shape} and {wrench.shape}")
        if not (np.all(np.isfinite(time)) and np.all(np.isfinite(wrench))):
            raise SceneError("history: times and loads must be finite numbers")
        back = np.flatnonzero(np.diff(time) < 0.0)
        if back.size:
            row = int(back[0]) + 1
            got = f"{time[row]:g} s after {time[row - 1]:g} s in row {row + 1}"
            raise SceneError(f"history: time must not run back; got {got}")

    def divided(self, parts: int) -> tuple[LoadHistory, NDArray[np.bool_]]:
        """Return the history with times between its own, and which are its own.

        Parameters
        ----------
        parts : int
            No component goes by more than so many parts of its range from one time to the next.
        """
        span = np.maximum(np.ptp(np.vstack([np.zeros(len(WRENCH)), self.wrench]), axis=0), 1e-300)
        steps = np.max(np.abs(np.diff(self.wrench, axis=0)) / span, axis=1, initial=0.0)
        counts = np.maximum(np.ceil(parts * steps - 1e-9).astype(int), 1)
        number = np.concatenate([[0], np.cumsum(counts)])  # of the history's own times among all
        every = np.arange(number[-1] + 1)
        time = np.interp(every, number, self.time)
        wrench = np.stack([np.interp(every, number, part) for part in self.wrench.T], axis=1)
        return LoadHistory(time, wrench), np.isin(every, number)

    @property
    def loads(self) -> list[Wrench]:
        """The wrenches, one by one."""
        return [Wrench(*row) for row in self.wrench.tolist()]


@dataclass(frozen=True)
class Motion:
    """Where a target goes under a history of loads.

    Attributes
    ----------
    time : ndarray, shape (m,)
        The times of the history, and what steps between them were needed [s].
    given : ndarray of bool, shape (m,)
        Which are of the history.
    wrench : ndarray, shape (m, 6)
        [N, N m].
    pose, error : Pose of ndarray, shape (m,)
        And estimated absolute errors [m, rad].
    stretch : ndarray, shape (m,)
        As of `SolveReport`; NaN where no layer is solved.
    report : SolveReport
        ``estimated_error`` is the largest over the largest displacement of the history.
    """

    time: Array
    given: NDArray[np.bool_]
    wrench: Array
    pose: Pose
    error: Pose
    stretch: Array
    report: SolveReport


@runtime_checkable
class TimedModel(Protocol):
    """A mechanical model whose silicone remembers, point by point."""

    def in_time(self, history: LoadHistory, tell: Progress = untold) -> Motion:
        """Return where the target goes, and tell how far it is; raise SolveFailed where there is no rest on the way."""
        ...


def motion_of(sensor: Sensor, layer: MechanicalModel, history: LoadHistory, tell: Progress = untold) -> Motion:
    """Return where a target goes under a history of loads.

    Parameters
    ----------
    sensor : Sensor
        The scene.
    layer : MechanicalModel
        Of the sensor.
    history : LoadHistory
    tell : callable
        Is told how far the work is.

    Raises
    ------
    SceneError
        When the model cannot hold the silicone's softening.
    SolveFailed
        When the layer has no rest on the way.
    """
    return layer.in_time(history, tell) if isinstance(layer, TimedModel) else _as_a_whole(sensor, layer, history)


def _as_a_whole(sensor: Sensor, layer: MechanicalModel, history: LoadHistory) -> Motion:
    """The cheap rung: elastic answers to loads that have crept, component by component."""
    silicone = None if sensor.elastomer is None else sensor.elastomer.silicone
    if silicone is not None and silicone.mullins is not None:
        raise SceneError("history: softening (mullins) needs a model at finite strain, planar or block")
    began, given = clock.perf_counter(), np.ones(history.time.size, dtype=bool)
    if silicone is not None and silicone.prony:
        history, given = _as_it_creeps(history, retardation(silicone.prony)[1])
    crept = history.wrench
    if silicone is not None and silicone.prony:
        crept = np.stack([relaxed_share(silicone, history.time, part) for part in history.wrench.T], axis=1)
    found = [layer.equilibrium(Wrench(*row)) for row in crept.tolist()]
    pose, error = (_stacked([getattr(each, name) for each in found]) for name in ("pose", "error"))
    stretch = np.array([each.report.stretch for each in found], dtype=float)
    last = found[-1].report
    report = SolveReport(
        last.model, last.unknowns, sum(each.report.iterations for each in found), last.residual,
        max(each.report.estimated_error for each in found), clock.perf_counter() - began,
        notes=(*last.notes, "rate: relaxation of the pad as a whole, component by component"),
    )  # fmt: skip
    return Motion(history.time, given, history.wrench, pose, error, stretch, report)


def _as_it_creeps(history: LoadHistory, times: Array) -> tuple[LoadHistory, NDArray[np.bool_]]:
    """A history with times between its own where a pad that retards in some times still moves; which are its own."""
    spans = np.diff(history.time)
    between = []
    for begin, span in zip(history.time, spans, strict=False):
        first, last = _EARLY * float(times.min()), min(float(span), _LATE * float(times.max()))
        count = int(np.ceil(_A_DECADE * np.log10(last / first))) if last > first else 0
        between.append(begin + np.geomspace(first, max(last, first), count, endpoint=False))
    every = np.unique(np.concatenate([history.time, *between]))
    wrench = np.stack([np.interp(every, history.time, part) for part in history.wrench.T], axis=1)
    return LoadHistory(every, wrench), np.isin(every, history.time)


def _stacked(poses: Sequence[Pose]) -> Pose:
    """Many poses as one."""
    return Pose.of(np.array([pose.components for pose in poses]).reshape(-1, len(POSE)))
