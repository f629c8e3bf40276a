"""Histories of loads and the motions they cause: times with wrenches in, times with poses out.

A history gives the wrench at some times; between them it goes evenly, twice the same time is a sudden change, and
before the first there was no load on virgin material. Models at finite strain follow it with the memory of their
silicone at every point (`TimedModel`; levels/in_time.py). Others answer by the cheap rung, a memory of the pad as a
whole (silicone/history.py): each component of the load has crept by itself to an elastic one,

    q(t) = q_e(Q_e(t)),      Q_e(t) = int_0^t C(t - s) dQ(s),

exact at small strain; the softening of a whole pad is known of proportional loads only, and is refused here.
"""

from __future__ import annotations

import time as clock
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from sits_mech.cases import Progress, untold
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import WRENCH, Array, Mask, MechanicalModel, Pose, SolveReport, Wrench
from sits_mech.scene.sensor import SceneError, Sensor, silicone_of
from sits_mech.silicone.history import relaxed_share, retardation

_EARLY, _LATE = 0.1, 10.0  # of the shortest and longest times of a creep: before and after nothing moves
_A_DECADE = 8  # times of a decade


@dataclass(frozen=True)
class LoadHistory:
    """Wrenches over time, linear in between."""

    time: Array  # (n,), not descending; repeated for a sudden change [s]
    wrench: Array  # (n, 6), in the order of `WRENCH` [N, N m]

    def __post_init__(self) -> None:
        """Validate times and wrenches."""
        try:
            time, wrench = np.asarray(self.time, dtype=float), np.asarray(self.wrench, dtype=float)
        except ValueError:
            raise SceneError("history: must be n times with n x 6 loads; got no numbers, or unlike rows") from None
        vars(self).update(time=time, wrench=wrench)
        if time.ndim != 1 or wrench.shape != (time.size, len(WRENCH)) or time.size < 1:
            raise SceneError(f"history: must be n times with n x 6 loads; got {time.shape} and {wrench.shape}")
        if not (np.all(np.isfinite(time)) and np.all(np.isfinite(wrench))):
            raise SceneError("history: times and loads must be finite numbers")
        back = np.flatnonzero(np.diff(time) < 0.0)
        if back.size:
            row = int(back[0]) + 1
            got = f"{time[row]:g} s after {time[row - 1]:g} s in row {row + 1}"
            raise SceneError(f"history: time must not run back; got {got}")

    def divided(self, parts: int) -> tuple[LoadHistory, Mask]:
        """Divide steps above 1/parts of a component's range; return the history, and which times are its own."""
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
    """A target's motion under a history of loads, at m times."""

    time: Array  # the history's, and steps in between [s]
    given: Mask  # (m,), which are the history's
    wrench: Array  # (m, 6) [N, N m]
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


def _as_a_whole(sensor: Sensor, layer: MechanicalModel, history: LoadHistory) -> Motion:
    """Return the elastic answers to loads that have crept, component by component: the cheap model."""
    silicone = silicone_of(sensor)
    if silicone is not None and silicone.mullins is not None:
        raise SceneError("history: softening (mullins) needs a model at finite strain, planar, axisymmetric or block")
    began, given, crept = clock.process_time(), np.ones(history.time.size, dtype=bool), history.wrench
    if silicone is not None and silicone.prony:
        history, given = _as_it_creeps(history, retardation(silicone.prony)[1])
        crept = np.stack([relaxed_share(silicone, history.time, part) for part in history.wrench.T], axis=1)
    found = [layer.equilibrium(Wrench(*row)) for row in crept.tolist()]
    pose, error = (Pose.of(np.array([getattr(each, name).components for each in found])) for name in ("pose", "error"))
    told = ((each.report.iterations, each.report.estimated_error, each.report.stretch) for each in found)
    iterations, errors, stretch = zip(*told, strict=True)
    last = found[-1].report
    report = SolveReport(
        last.model, last.unknowns, sum(iterations), last.residual, max(errors), clock.process_time() - began,
        notes=(*last.notes, Note(NoteKind.AS_A_WHOLE)),
    )
    return Motion(history.time, given, history.wrench, pose, error, np.array(stretch, dtype=float), report)


def _as_it_creeps(history: LoadHistory, times: Array) -> tuple[LoadHistory, Mask]:
    """Add times while a pad with some retardation times still moves; return also which are the history's."""
    between, before = list[float](), list[int]()  # times, and the row of the history that each goes before
    for row, span in enumerate(np.diff(history.time), 1):
        first, last = _EARLY * float(times.min()), min(span, _LATE * float(times.max()))
        count = int(np.ceil(_A_DECADE * np.log10(last / first))) if last > first else 0
        more = history.time[row - 1] + np.geomspace(first, max(last, first), count, endpoint=False)
        between += more.tolist()
        before += [row] * count
    wrench = [np.insert(part, before, np.interp(between, history.time, part)) for part in history.wrench.T]
    found = LoadHistory(np.insert(history.time, before, between), np.stack(wrench, axis=1))
    return found, np.insert(np.ones(history.time.size, dtype=bool), before, False)
