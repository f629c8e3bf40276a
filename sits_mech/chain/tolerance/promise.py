"""Predict error and cost of a request on coarse meshes, and set the tolerances of both physics.

The look gives a pose, from which the goal follows (goal.py): what an error of the pose is worth in the signals. Where
the magnetic error is more than half of the tolerance it is reduced in proportion, so that the mechanics have the other
half at least. What further meshes take and leave is predicted from the estimated error of the first
(prices/forecast.py). A tolerance that is farther away than such a prediction may be off is refused before it is solved
for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from sits_mech.chain.models import loaded_model
from sits_mech.chain.prices.costs import cost, magnetic_tolerance
from sits_mech.chain.prices.forecast import Look, expected
from sits_mech.chain.propagation import poses_of
from sits_mech.chain.tolerance.goal import HALF, Goal, goal_at
from sits_mech.quantities import Equilibrium, MagneticModel, Pose, Wrench
from sits_mech.scene.sensor import SceneError, Sensor

_SURE = 3.0  # of 74 loads none reached less than 0.39 of what was planned: beyond, a tolerance is missed for sure


class Promise(NamedTuple):
    """Seconds of processor time and error, over the signals' full scale: planned after a first look, and reached."""

    planned: Look
    seconds: float
    error: float

    @property
    def record(self) -> dict[str, float]:
        """Return the four numbers by name."""
        planned = {"planned_seconds": self.planned.seconds, "planned_error": self.planned.error}
        return planned | {"seconds": self.seconds, "error": self.error}


@dataclass(frozen=True)
class Aim:
    """A magnetic model and the goal of poses, to a tolerance of the signals' full scale."""

    field: MagneticModel  # as fine as the tolerance needs
    name: str  # of the magnetic model
    goal: Goal
    tolerance: float
    asked: float  # tolerance of the magnetic model, as for `loaded_model`

    @property
    def left(self) -> float:
        """The part of the tolerance that is left to the mechanics."""
        return self.goal.left(self.tolerance)

    def promised(self, first: Equilibrium, loads: int, solved: int = 1) -> Look:
        """Predict error and cost of so many loads, `solved` of them solved, from the largest's first meshes."""
        off = self.goal.mechanics(poses_of([first]))
        seen = expected(first.report, off, self.left, solved)
        seconds = seen.seconds + cost("magnetics", self.name, magnetic_tolerance(self.name, self.asked), loads)
        return seen._replace(error=seen.error + self.goal.magnetics, seconds=seconds)

    def refuse_beyond(self, planned: Look, where: str) -> None:
        """Raise SceneError for a tolerance that cannot be reached."""
        if planned.error > _SURE * self.tolerance:
            can = f"{planned.error:.1g} can be reached in about {planned.seconds:.2g} s (--best)"
            raise SceneError(f"tolerance: must be one that can be reached at {where}; got {self.tolerance:g}: {can}")


def aim_at(
    sensor: Sensor, magnetics: str, tolerance: float, loads: Sequence[Wrench], poses: Sequence[Pose]
) -> Aim | None:
    """Return the aim of a request, with its magnetic model; None where no signal changes.

    `poses` are where some of the loads bring the target, clear of the coils, the farthest first.
    """

    def aim(asked: float) -> Aim | None:
        """Return the aim with a magnetic model of some tolerance."""
        field, choice = loaded_model(sensor, magnetics, asked, loads)
        goal = goal_at(sensor, field, poses)
        return None if goal is None else Aim(field, choice.name, goal, tolerance, asked)

    found = aim(tolerance)
    if found is None or found.goal.magnetics <= HALF * tolerance:
        return found
    return aim(HALF * tolerance**2 / found.goal.magnetics)
