"""Solve a load to smaller and smaller tolerances, each from the start: error and time of each.

Every rung is solved with caches emptied, and costs what it costs cold. It has its own estimate, its difference from
the finest rung, and its processor time; the finest one is no truth: its own estimate says how far it may be off.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple

import numpy as np

from sits_mech.cases import Progress, untold
from sits_mech.chain.propagation import levers, unloaded
from sits_mech.chain.simulate import Simulation, simulate
from sits_mech.disk_cache import nothing_kept
from sits_mech.mechanics.levels.answer import relative
from sits_mech.quantities import SolveFailed, Wrench
from sits_mech.scene.sensor import Sensor
from sits_mech.units import SceneError, checked_tolerance

TOLERANCES = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4)  # that are asked for one by one


class Asked(NamedTuple):
    """Tolerance asked, estimated error of the answer, infinite without one, and processor time [s]."""

    tolerance: float
    estimated: float
    seconds: float

    @property
    def holds(self) -> bool:
        """Whether an answer is as exact as asked, by its own estimate."""
        return self.estimated <= self.tolerance


@dataclass(frozen=True)
class Rung:
    """A load solved to one tolerance; errors are nan without an answer."""

    tolerance: float  # asked
    seconds: float  # processor time, from the scene on
    estimated: float  # largest estimated error of L, over the largest change of L
    difference: float  # of L from the finest rung, over the same
    estimated_pose: float  # over the displacement, angles at the target's end
    difference_pose: float  # over the same
    status: str  # "converged", or why there is no answer

    @property
    def asked(self) -> Asked:
        """The part of it that the sentence of a ladder needs."""
        return Asked(self.tolerance, self.estimated if self.status == "converged" else math.inf, self.seconds)


def ladder(
    sensor: Sensor, wrench: Wrench, *, tolerance: float = 1e-2, mechanics: str = "auto", magnetics: str = "auto",
    progress: Progress = untold,
) -> list[Rung]:
    """Solve a load, not zero, at every tolerance from 0.1 down to a tenth of the asked one.

    Raises SceneError when there is no load, or a model cannot hold the scene.
    """
    if not wrench.components.any():
        raise SceneError("ladder: must have a load, such as fz = 1 N, whose answer is solved at every rung; none came")
    least = 0.0999 * checked_tolerance(tolerance)
    asked = [one for one in TOLERANCES if one > least]
    solved = []
    for number, one in enumerate(asked):
        progress(number, len(asked))
        solved.append(_solved(sensor, wrench, one, mechanics, magnetics))
    progress(len(asked), len(asked))
    answers = [found for _, found, _ in solved if found is not None]
    rows = []
    for one, (seconds, found, status) in zip(asked, solved, strict=True):
        sizes = (math.nan,) * 4 if found is None else _sizes(sensor, found, answers[-1])
        rows.append(Rung(one, seconds, *sizes, status))
    return rows


def sentence(ladders: Sequence[Sequence[Asked]]) -> str:
    """Summarize ladders: "ask 1e-2: 0.3 s; 3e-3: 1.1 s; errors below 1e-3 cannot be reached".

    A tolerance counts where the answer's own estimate is within it; where only some of several ladders reach it, how
    many do is said. What cannot be reached is what is below the least estimate of a ladder whose finest rung misses.
    """
    parts, count, held = [], len(ladders), dict[float, list[float]]()
    for one in chain.from_iterable(ladders):
        if one.holds:
            held.setdefault(one.tolerance, []).append(one.seconds)
    for tolerance, times in sorted(held.items(), reverse=True):
        span = _span([f"{min(times):.2g}", f"{max(times):.2g}"])
        parts.append(f"{power(tolerance)}: {span} s{_share(len(times), count)}")
    reached = [min(one.estimated for one in row) for row in ladders if not _finest(row).holds]
    limits = sorted(filter(math.isfinite, reached))
    if limits:
        span = _span([power(limits[0]), power(limits[-1])])
        parts.append(f"errors below {span} cannot be reached{_share(len(reached), count)}")
    elif not reached:
        parts.append(f"errors below {power(_finest(ladders[0]).tolerance)} were not requested")
    return f"ask {'; '.join(parts)}" if parts else "no tolerance of the ladder can be reached"


def _share(some: int, count: int) -> str:
    """Say how many of several ladders it is, empty for all."""
    return f" ({some} of {count})" if some < count else ""


def forget() -> None:
    """Empty all caches of the package, so that the next solve is cold."""
    for name, module in list(sys.modules.items()):
        if name.startswith("sits_mech."):
            for item in list(vars(module).values()):
                if hasattr(item, "cache_clear"):
                    item.cache_clear()


def power(value: float) -> str:
    """Format a tolerance as it is asked: 3e-3."""
    return f"{value:.0e}".replace("e-0", "e-")


def _span(ends: Sequence[str]) -> str:
    """Format the ends of a range, once where they are the same."""
    return ends[0] if ends[0] == ends[-1] else f"{ends[0]} to {ends[-1]}"


def _finest(row: Sequence[Asked]) -> Asked:
    """Return the rung of the least tolerance."""
    return min(row, key=lambda one: one.tolerance)


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


def _sizes(sensor: Sensor, found: Simulation, finest: Simulation) -> tuple[float, float, float, float]:
    """Return estimate and difference of L over its largest change, and those of the pose over the displacement."""
    L, best, lever = found.impedance, finest.impedance.L, levers(sensor)
    change = np.max(np.abs(best - L.L0))
    rest, last = found.equilibrium, finest.equilibrium
    pose, error, end = rest.pose.components, rest.error.components, last.pose.components
    moved = end - unloaded(sensor).components
    own, away = (relative(each, moved, lever) for each in (error, np.abs(pose - end)))
    return float(np.max(L.error_L) / change), float(np.max(np.abs(L.L - best)) / change), own, away
