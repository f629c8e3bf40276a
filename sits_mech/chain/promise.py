"""What will a request reach, and for how much? A look at its largest load on the first meshes, then the rest is aimed.

The look gives a pose, from which the goal follows (goal.py): what an error of the pose is worth in the signals. Where
the magnetics leave more than half of the tolerance in doubt they are made finer in proportion, so that the mechanics
have the other half at least. What the first meshes own to tells what further ones take and leave (prices/look.py). A
tolerance that is farther away than such a prediction may be off is refused before it is solved for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from sits_mech.chain.goal import HALF, Goal, goal_at
from sits_mech.chain.models import loaded_model
from sits_mech.chain.prices.costs import cost, magnetic_tolerance
from sits_mech.chain.prices.look import Look, expected
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
        """The four numbers by name."""
        planned = {"planned_seconds": self.planned.seconds, "planned_error": self.planned.error}
        return planned | {"seconds": self.seconds, "error": self.error}


@dataclass(frozen=True)
class Aim:
    """A magnetic model and what poses are for, to a tolerance of the signals' full scale.

    Attributes
    ----------
    field : MagneticModel
        As fine as the tolerance takes.
    name : str
        Of it.
    goal : Goal
    tolerance : float
    asked : float
        Of the magnetic model, for which it is as fine; as for `loaded_model`.
    """

    field: MagneticModel
    name: str
    goal: Goal
    tolerance: float
    asked: float

    @property
    def left(self) -> float:
        """What is left of the tolerance to the mechanics."""
        return self.goal.left(self.tolerance)

    def promised(self, first: Equilibrium, loads: int, solved: int = 1) -> Look:
        """Return what so many loads, so many of them solved, will take and reach; the largest's first meshes tell."""
        off = self.goal.mechanics(first.error.components, first.shared)
        seen = expected(first.report, off, self.left, solved)
        seconds = seen.seconds + cost("magnetics", self.name, magnetic_tolerance(self.name, self.asked), loads)
        return seen._replace(error=seen.error + self.goal.magnetics, seconds=seconds)

    def refuse_beyond(self, planned: Look, where: str) -> None:
        """Refuse a tolerance that cannot be reached; raise SceneError."""
        if planned.error > _SURE * self.tolerance:
            can = f"{planned.error:.1g} can be reached in about {planned.seconds:.2g} s (--best)"
            raise SceneError(f"tolerance: must be one that can be reached at {where}; got {self.tolerance:g}: {can}")


def aim_at(
    sensor: Sensor, magnetics: str, tolerance: float, loads: Sequence[Wrench], poses: Sequence[Pose]
) -> Aim | None:  # fmt: skip
    """Return what a request is after, with the magnetic model that it takes; None where the coils show nothing of it.

    Parameters
    ----------
    sensor, magnetics, tolerance, loads
        As for `loaded_model`.
    poses : sequence of Pose
        Where some of the loads bring the target, clear of the coils; the farthest first.
    """

    def aim(asked: float) -> Aim | None:
        """What a magnetic model of some tolerance makes of it."""
        field, choice = loaded_model(sensor, magnetics, asked, loads)
        goal = goal_at(sensor, field, poses)
        return None if goal is None else Aim(field, choice.name, goal, tolerance, asked)

    found = aim(tolerance)
    if found is None or found.goal.magnetics <= HALF * tolerance:
        return found
    return aim(HALF * tolerance**2 / found.goal.magnetics)
