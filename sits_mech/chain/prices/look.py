"""What will a load of finite strain take, and how exact will its answer be? Its first two meshes tell.

They are solved once (0.1 to 0.3 s in space), with their own estimate e of the error. Where that is small enough the
answer is theirs. Otherwise a third mesh and a fourth follow, which take so many times the seconds of the first two and
leave so many times their error; beyond a stretch of two edges settle late and leave more. Both are about the medians of
the loads in `studies/solve_costs.py`, whose table `loads.csv` also holds promises against what was reached.
"""

from __future__ import annotations

from typing import NamedTuple

from sits_mech.mechanics.loads import RefinedModel
from sits_mech.quantities import Equilibrium, MechanicalModel, SolveFailed, SolveReport, Wrench

_FURTHER = ((3.0, 0.14, 0.5), (8.0, 0.11, 0.45))  # seconds over those of two meshes, error, error at large stretch
_ONCE, _EACH = 0.1, 5e-6  # seconds of two meshes, and for each iteration and unknown of the finer one
_LARGE = 2.0  # stretch


class Look(NamedTuple):
    """Relative error that a load's answer will have, processor seconds, and what speaks against it.

    The error is infinite where the load is not carried.
    """

    error: float
    seconds: float
    notes: tuple[str, ...] = ()


def look(layer: MechanicalModel, load: Wrench, tolerance: float) -> Look | None:
    """Return what to expect of a load; None of a model that has no first meshes.

    Parameters
    ----------
    layer : MechanicalModel
    load : Wrench
        [N, N m].
    tolerance : float
        Asked of the pose, over the size of the displacement.
    """
    if not isinstance(layer, RefinedModel):
        return None
    try:
        found = layer.rough.equilibrium(load)
    except SolveFailed as failure:
        return Look(float("inf"), _seconds(failure.report), (f"a large load for this pad: {failure}",))
    return _expected(found, _seconds(found.report), tolerance)


def _seconds(report: SolveReport) -> float:
    """What the first two meshes take: told by their size and iterations, so that a plan is the same each time."""
    return _ONCE + _EACH * report.iterations * report.unknowns


def _expected(found: Equilibrium, spent: float, tolerance: float) -> Look:
    """What follows from the first two meshes."""
    error, stretch = found.report.estimated_error, found.report.stretch or 1.0
    notes = tuple(note for note in found.report.notes if "is known up to stretch" in note)
    if error <= tolerance:
        return Look(error, spent, notes)
    expected = [(times * spent, error * (large if stretch > _LARGE else gentle)) for times, gentle, large in _FURTHER]
    seconds, left = next((each for each in expected if each[1] <= tolerance), expected[-1])
    more = (f"the tolerance {tolerance:g} is not to be had at this load: {left:.1g}",) if left > tolerance else ()
    return Look(left, seconds, (*notes, *more))
