"""Estimate what a solve costs and reaches: processor seconds and errors of each model's rungs, as measured.

Measured on one core of the machine that `studies/omissions.py` ran on, within a factor of some three elsewhere; those
of the mechanics and what large loads take on a faster one, by `studies/solve_costs.py`, which measures all.

A load at finite strain is looked at first: on two meshes (0.1 to 0.5 s in space), with their own estimate e of the
error. Where that is small enough the answer is theirs. Otherwise a third mesh and a fourth follow, which take so many
times the seconds of the first two and leave so many times their error. Those of pads are medians of 72 scenes and loads
by chance, those of layers in the plane of ten, those of tables of nine; `studies/promises.py` draws other sixty, and
compares predictions with results.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from sits_mech.mechanics.loads import RefinedModel
from sits_mech.quantities import Equilibrium, MechanicalModel, SolveFailed, SolveReport, Wrench

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


_FURTHER = {"block": ((2.7, 0.25), (8.0, 0.2)), "planar": ((1.5, 0.25), (15.0, 0.02))}
"""By model, a mesh more and all there are: seconds over those of two meshes, and error over theirs."""
_NONE = ((0.0, 1.0),)  # of a model with one set of meshes
_ONCE, _EACH = 0.05, 8e-6  # seconds of two meshes, and for each iteration and unknown of the finer one
_WANDERED = 24  # iterations of two meshes beyond which no finer one was seen to settle
_MEAN, _COMPARED = 0.65, 2  # of the largest load's seconds, those of a load of a table; loads that are compared
_OF_ALL = 0.6  # of the largest load's error, what two loads on a third mesh leave of all of a table
MANY_ON_THREE = 3e-3
"""Tolerance from which on many loads take three meshes: a fourth leaves 0.8 of their error for thrice the cost."""
_TOUCHING = "frictionless contact"  # as notes of answers say
_PRESSED = 3.5e-4  # for each unknown where faces touch: the way there is by contact that grows harder


class Look(NamedTuple):
    """Relative error to expect of a load's answer, processor seconds, and notes that speak against it.

    The error is infinite where the load is not carried; `magnetics` is the error beside it, where known.
    """

    error: float
    seconds: float
    notes: tuple[str, ...] = ()
    magnetics: float | None = None


def look(
    layer: MechanicalModel, load: Wrench, tolerance: float, measure: Callable[[Equilibrium], float]
) -> Look | None:
    """Return what to expect of a load [N, N m]; None of a model that has no first meshes.

    `measure` gives the error of an answer on the first meshes, which `tolerance` is asked of.
    """
    if not isinstance(layer, RefinedModel):
        return None
    try:
        found = layer.rough.equilibrium(load)
    except SolveFailed as failure:
        return Look(float("inf"), _seconds(failure.report), (f"a large load for this pad: {failure}",))
    return expected(found.report, measure(found), tolerance)


def expected(first: SolveReport, error: float, tolerance: float, count: int = 1) -> Look:
    """Return what to expect of `count` loads from the answer and error of the largest one's first two meshes.

    Of many loads only two are solved on finer meshes, and neither is the largest.
    """
    spent, wandered = _seconds(first), count == 1 and first.iterations > _WANDERED
    each, finer = (spent, 1) if count == 1 else (_MEAN * spent, _COMPARED)
    if error <= tolerance:
        return Look(error, count * each, _known(first))
    more: Sequence[tuple[float, float]] = _FURTHER.get(first.model, _NONE)
    if count > 1:
        more = [(times, max(share, _OF_ALL)) for times, share in more[: 1 if tolerance >= MANY_ON_THREE else None]]
    further = [((count + finer * times) * each, (1.0 if wandered else share) * error) for times, share in more]
    seconds, left = next((each for each in further if each[1] <= tolerance), further[0 if wandered else -1])
    beyond = f"the tolerance {tolerance:g} cannot be reached at this load, about {left:.1g} can"
    return Look(left, seconds, (*_known(first), *([beyond] if left > tolerance else [])))


def _known(report: SolveReport) -> tuple[str, ...]:
    """Return notes that speak against a load."""
    return tuple(note for note in report.notes if " end at stretch " in note)


def _seconds(report: SolveReport) -> float:
    """Estimate the time of the first two meshes from size and iterations, so that a plan is reproducible."""
    touching = any(_TOUCHING in note for note in report.notes)
    return _ONCE + (_PRESSED if touching else _EACH * report.iterations) * report.unknowns
