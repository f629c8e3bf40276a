"""Solve a load to smaller and smaller tolerances, each from the start: error and time of each.

Every rung is solved with caches emptied, and costs what it costs cold. It has its own estimate, its difference from
the finest rung, and its processor time; the finest one is no truth: its own estimate says how far it may be off.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from sits_mech.cases import Progress, no_progress
from sits_mech.chain.propagation import levers, unloaded_pose
from sits_mech.chain.simulate import Simulation, simulate
from sits_mech.disk_cache import nothing_kept
from sits_mech.mechanics.levels.answer import relative
from sits_mech.quantities import SolveFailed, Wrench
from sits_mech.scene.sensor import Sensor
from sits_mech.units import SceneError, checked_tolerance

TOLERANCES = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4)  # that are asked for one by one


class LadderPoint(NamedTuple):
    """Tolerance asked, estimated error of the answer, infinite without one, and processor time [s]."""

    tolerance: float
    estimated: float
    seconds: float

    @property
    def holds(self) -> bool:
        """Whether an answer is as exact as asked, by its own estimate."""
        return self.estimated <= self.tolerance


@dataclass(frozen=True)
class LadderStep:
    """A load solved to one tolerance; errors are nan without an answer."""

    tolerance: float  # asked
    seconds: float  # processor time, from the scene on
    estimated: float = math.nan  # largest estimated error of L, over the largest change of L
    difference: float = math.nan  # of L from the finest rung, over the same
    estimated_pose: float = math.nan  # over the displacement, angles at the target's end
    difference_pose: float = math.nan  # over the same
    status: str = "converged"  # or why there is no answer

    @property
    def asked(self) -> LadderPoint:
        """The part of it that the sentence of a ladder needs."""
        return LadderPoint(self.tolerance, self.estimated if self.status == "converged" else math.inf, self.seconds)


def ladder(
    sensor: Sensor, wrench: Wrench, *, tolerance: float = 1e-2, mechanics: str = "auto", magnetics: str = "auto",
    progress: Progress = no_progress, each: Callable[[LadderStep, int], None] = lambda *_: None,
) -> list[LadderStep]:
    """Solve a load, not zero, at every tolerance from 0.1 down to a tenth of the asked one.

    `each` is called with a rung when it is solved, without differences from the finest, and how many follow. Raises
    SceneError when there is no load, or a model cannot hold the scene.
    """
    if not wrench.components.any():
        raise SceneError("ladder: must have a load, such as fz = 1 N, whose answer is solved at every rung; none came")
    least = 0.0999 * checked_tolerance(tolerance)
    asked = [one for one in TOLERANCES if one > least]
    rungs, answers = list[LadderStep](), list[Simulation | None]()
    for number, one in enumerate(asked, 1):
        progress(number - 1, len(asked))
        seconds, found, status = _solved(sensor, wrench, one, mechanics, magnetics)
        rungs.append(_compared(sensor, LadderStep(one, seconds, status=status), found, found))
        answers.append(found)
        each(rungs[-1], len(asked) - number)
    progress(len(asked), len(asked))
    finest = next((found for found in reversed(answers) if found is not None), None)
    return [_compared(sensor, rung, found, finest) for rung, found in zip(rungs, answers, strict=True)]


def forget() -> None:
    """Empty all caches of the package, so that the next solve is cold."""
    for name, module in list(sys.modules.items()):
        if name.startswith("sits_mech."):
            for item in list(vars(module).values()):
                if hasattr(item, "cache_clear"):
                    item.cache_clear()


@nothing_kept()
def _solved(
    sensor: Sensor, wrench: Wrench, tolerance: float, mechanics: str, magnetics: str
) -> tuple[float, Simulation | None, str]:
    """Return processor time, answer and status of a rung, from the scene on, nothing from the disk."""
    forget()
    began = time.process_time()
    try:
        found = simulate(sensor, wrench, tolerance=tolerance, mechanics=mechanics, magnetics=magnetics)
    except (SolveFailed, MemoryError) as failure:
        return time.process_time() - began, None, f"{type(failure).__name__}: {failure}"
    return time.process_time() - began, found, "converged"


def _compared(sensor: Sensor, rung: LadderStep, found: Simulation | None, finest: Simulation | None) -> LadderStep:
    """Return a rung with its estimates, and differences from the finest answer; as it is without an answer."""
    if found is None or finest is None:
        return rung
    L, best, lever = found.impedance, finest.impedance.L, levers(sensor)
    change = np.max(np.abs(best - L.L0))
    end = finest.equilibrium.pose.components
    error, away = found.equilibrium.error.components, np.abs(found.equilibrium.pose.components - end)
    own, off = (relative(each, end - unloaded_pose(sensor).components, lever) for each in (error, away))
    return replace(
        rung, estimated=float(np.max(L.error_L) / change), difference=float(np.max(np.abs(L.L - best)) / change),
        estimated_pose=own, difference_pose=off,
    )
