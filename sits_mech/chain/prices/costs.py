"""Estimate what a solve costs and reaches: processor seconds and errors of each model's rungs, as measured.

Measured on one core of the machine that `studies/omissions.py` ran on, within a factor of some three elsewhere; those
of the mechanics and what large loads take (forecast.py) on a faster one, by `studies/solve_costs.py`, which measures
all.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

_SHARE = 0.1  # of the tolerance that is asked of the magnetics where they are much the cheaper half
COSTS: dict[tuple[str, str], tuple[tuple[float, float, float], ...]] = {
    ("mechanics", "closed-form"): ((0.0, 0.0, 1e-5),),
    ("mechanics", "linear"): ((1e-2, 0.1, 0.005), (0.0, 0.5, 0.02)),
    ("mechanics", "planar"): ((1e-2, 0.05, 0.05), (0.0, 0.1, 0.6)),
    ("mechanics", "block"): ((1e-1, 0.1, 0.2), (1e-2, 0.2, 0.7), (1e-3, 0.3, 2.2), (0.0, 0.3, 2.5)),
    ("magnetics", "planar"): ((1e-2, 0.04, 1e-5), (1e-3, 0.1, 2e-5), (1e-4, 0.5, 2e-5), (0.0, 3.2, 6e-5)),
    ("magnetics", "planar-fem"): ((1e-2, 0.1, 0.12), (1e-3, 0.2, 0.22), (1e-4, 0.1, 0.75), (0.0, 0.1, 3.2)),
    ("magnetics", "axisymmetric"): ((1e-2, 0.03, 2e-6), (1e-3, 1.0, 2e-6), (0.0, 1.5, 2e-6)),
    ("magnetics", "sheets"): (
        (1e-1, 0.5, 2e-4), (1e-2, 2.0, 2e-4), (5e-3, 3.5, 2e-4), (2e-3, 12.0, 2e-4), (0.0, 20.0, 2e-4),
    ),
}
"""Seconds by half and model: from each tolerance on, once for a scene and for each load or pose; as measured."""
REACHED: dict[tuple[str, str], float] = {
    ("mechanics", "closed-form"): 6e-2,
    ("mechanics", "linear"): 5e-4,
    ("mechanics", "planar"): 2e-4,
    ("mechanics", "block"): 5e-4,
    ("magnetics", "planar"): 3e-6,
    ("magnetics", "planar-fem"): 1e-6,
    ("magnetics", "axisymmetric"): 4e-7,
    ("magnetics", "sheets"): 5e-4,
}
"""Relative errors that the finest rungs estimate of themselves, as seen under gentle loads."""
_AMONG = 1.0  # seconds more for a load, or a pose, among conductors: 0.5 over a ground plane, more among several plates
_OUTLINE = 15.0  # seconds more for each fixed plate of any outline: no symmetry shares its cells


def magnetic_tolerance(model: str, tolerance: float) -> float:
    """Return the tolerance of a magnetic model for poses of a tolerance: a tenth, or more where that costs much."""
    return tolerance if model == "sheets" else _SHARE * tolerance


def cost(half: str, model: str, tolerance: float, count: int) -> float:
    """Return the seconds to expect of a model for a number of loads or poses; see `COSTS`."""
    once, each = next((once, each) for asked, once, each in COSTS[half, model] if asked <= tolerance)
    return once + count * each


@dataclass(frozen=True)
class Step:
    """A half of the chain on a rung of its model's ladder."""

    half: str  # "mechanics" or "magnetics"
    model: str
    tolerance: float  # asked, relative
    error: float  # the same, but not below what the finest rung reaches
    seconds: float  # processor time to expect
    whole: float = math.nan  # error of the request with it


Steps = tuple[Step, ...]


def steps(
    parts: Sequence[tuple[str, str, int]], tolerance: float, loaded: bool, among: tuple[int, int] = (0, 0)
) -> tuple[Steps, Steps]:
    """Return what is solved, half by half, and what the next two rungs of each half would take.

    `parts` are (half, model, number of loads or poses); `loaded` tells that poses come of loads; `among` counts the
    conductors solved in space and the outlines among them.
    """
    asked, finer = [], []
    for half, model, count in parts:
        own = magnetic_tolerance(model, tolerance) if loaded and half == "magnetics" else tolerance
        least = REACHED[half, model]
        more = (_AMONG * count + _OUTLINE * among[1]) if half == "magnetics" and among[0] else 0.0

        def step(at: float, half: str = half, model: str = model, count: int = count, more: float = more) -> Step:
            return Step(half, model, at, max(at, REACHED[half, model]), cost(half, model, at, count) + more)

        asked.append(step(own))
        rungs = [max(at, least) for at, _, _ in COSTS[half, model] if max(at, least) < own]
        finer += [step(at) for at in dict.fromkeys(rungs[:2])]
    return tuple(asked), tuple(finer)
