"""Predict error and cost of a request on coarse meshes, and solve its loads until the signals meet the tolerance.

The first two meshes give a pose, and at it the goal (goal.py): the effect of an error of the pose on the signals. Where
the magnetic error is more than half of the tolerance it is reduced in proportion, so that the mechanics have the other
half at least. Cost and error of further meshes are predicted from the estimated error of the first (prices.py). A
tolerance that is missed even if the prediction is off by its known factor is refused before the solve.

Of a table the largest load and its images are solved first; if it is not carried, the other loads are. When all needed
loads are solved on the first meshes, finer ones follow until the worst of them is good enough (interpolate.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np

from sits_mech.chain.interpolate import LayerGrid, poses_on_grid, solved_likely, worst
from sits_mech.chain.models import MAGNETICS, Choice, Why, loaded_model, mechanical_model
from sits_mech.chain.omitted.mechanical import with_omissions
from sits_mech.chain.plans.goal import HALF, Goal, goal_at
from sits_mech.chain.plans.prices import SURE, MeshForecast, predicted
from sits_mech.chain.propagation import poses_of
from sits_mech.description import Question
from sits_mech.geometry.collision import Collision, check_clearance
from sits_mech.mechanics.levels.load_path import depends_on_path
from sits_mech.mechanics.levels.words import wrench_words
from sits_mech.mechanics.loads import RefinedModel, Settled, first_key, settle
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.quantities import WRENCH, Equilibrium, MagneticModel, MechanicalModel, Pose, Wrench
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.status import FAILED, OK
from sits_mech.units import SLACK


class Promise(NamedTuple):
    """Seconds of processor time and error, over the signals' full scale: planned after a first look, and reached."""

    planned: MeshForecast
    seconds: float
    reached: float  # as planned: of the numerics
    error: float  # the whole, with what is left out

    @property
    def record(self) -> dict[str, float]:
        """Return the numbers by name."""
        planned = {"planned_seconds": self.planned.seconds, "planned_error": self.planned.error}
        return planned | {"seconds": self.seconds, "reached": self.reached, "error": self.error}


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
        """The part of the tolerance that is left to the numerics of the mechanics."""
        return self.goal.left(self.tolerance)

    def sharing(self, own: Sequence[Equilibrium], whole: Sequence[Equilibrium]) -> Aim:
        """Return the aim that leaves a part to what a model leaves out, by equilibria without it and with it."""
        numerics, all_of_it = (self.goal.mechanics(poses_of(each)) for each in (own, whole))
        return replace(self, goal=replace(self.goal, left_out=all_of_it - numerics))

    def promised(self, first: Equilibrium, loads: int, solved: int = 1) -> MeshForecast:
        """Predict error and cost of so many loads, `solved` of them solved, from the largest's first meshes."""
        off = self.goal.mechanics(poses_of([first]))
        found = predicted(first.report, off, self.left, solved)
        model = MAGNETICS[self.name]
        question = Question(model.share * self.asked, (first.wrench,) * loads)
        seconds = found.seconds + model.cost(question).seconds
        return found._replace(error=found.error + self.goal.magnetics, seconds=seconds)

    def refuse_beyond(self, planned: MeshForecast, where: str) -> None:
        """Raise SceneError for a tolerance that cannot be reached."""
        if planned.error > SURE * self.tolerance:
            can = f"{planned.error:.1g} can be reached in about {planned.seconds:.2g} s, which best takes"
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


def aimed_mechanics(
    sensor: Sensor, name: str, tolerance: float, loads: Sequence[Wrench], magnetics: str
) -> tuple[MechanicalModel, Choice]:
    """Return `mechanical_model` of some loads for a tolerance of the signals.

    One that no goal refines, and that misses what the coils leave, is chosen again to a tolerance as much smaller; that
    one may miss as well.
    """
    layer, choice = mechanical_model(sensor, name, tolerance, loads)
    if choice.why is not Why.WITHIN or isinstance(layer, RefinedModel) or depends_on_path(sensor):
        return layer, choice
    sizes, ways = np.array([load.components for load in loads]), list(product((1.0, -1.0), repeat=len(WRENCH)))
    sizes /= np.maximum(np.abs(sizes).max(axis=0), SLACK)
    ends = [loads[k] for k in dict.fromkeys(np.argmax(sizes @ np.transpose(ways), axis=0).tolist())]
    settled = settle(layer, ends, symmetry=symmetry_of(sensor)).values()
    aim = aim_at(sensor, magnetics, tolerance, loads, readable_poses(sensor, settled))
    if aim is None:
        return layer, choice
    rests = [one.rest for one in settled if one.rest]
    aim = aim.sharing(rests, with_omissions(sensor, rests, choice.name))
    off, pose = max((aim.goal.mechanics(poses_of([one])), one.report.estimated_error) for one in rests)
    if min(off - aim.left, pose) <= 0.0:
        return layer, choice
    return mechanical_model(sensor, name, min(pose, tolerance) * aim.left / off, loads)


class AimedLoads(NamedTuple):
    """What comes of all loads, and the magnetic model that reads them."""

    settled: Mapping[Wrench, Settled]
    field: MagneticModel  # as fine as the signals need
    asked: float  # tolerance of `field`
    planned: MeshForecast | None = None  # from the largest load's first meshes; None where nothing was planned
    reached: float = np.nan  # error over the signals' full scale; NaN where nothing was planned
    goal: Goal | None = None  # None where no signal changes


def aimed_loads(
    grid: LayerGrid, magnetics: str, *, best: bool = True,
    whole: Callable[[Sequence[Equilibrium]], Sequence[Equilibrium]] = lambda rests: rests,
) -> AimedLoads:
    """Solve a grid of loads to a tolerance of the signals' full scale.

    `magnetics` is the magnetic model's name as asked for; `whole` adds what the mechanical model leaves out to the
    errors of equilibria. A tolerance that cannot be reached is answered with what is;
    without `best` it raises SceneError.
    """
    sensor, layer, symmetry, keep = grid.sensor, grid.layer, grid.symmetry, grid.keep
    loads, begun = grid.loads, dict[Wrench, Settled]()
    aim: Aim | None = None
    first: Equilibrium | None = None  # under the largest load
    planned: MeshForecast | None = None

    def aimed(some: Iterable[Settled]) -> Aim | None:
        """Return the aim of the table from some of its loads; None where they tell nothing."""
        rests = [one.rest for one in some if one.rest]
        found = aim_at(sensor, magnetics, grid.tolerance, loads, readable_poses(sensor, some))
        return None if found is None else found.sharing(rests, whole(rests))

    if isinstance(layer, RefinedModel) and not depends_on_path(sensor):
        sizes = np.abs([load.components for load in loads])  # the load whose components are largest, each of its own
        far = symmetry.standard(loads[int(np.argmax((sizes / np.maximum(sizes.max(axis=0), 1e-300)).sum(axis=1)))])[0]
        images = [load for load in loads if symmetry.standard(load)[0] == far]
        begun = settle(layer.rough, images, symmetry=symmetry, keep=(keep[0], first_key(keep[1])))
        aim = aimed(begun.values())
        first = begun[far].rest
    if aim is not None and first is not None:
        solved = len(symmetry.without_images(solved_likely(loads, grid.axes, grid.place)))
        planned = aim.promised(first, len(loads), solved)
        if not best:
            aim.refuse_beyond(planned, wrench_words(vars(far)))

    def after(solved: Iterable[Settled]) -> Goal | None:
        """Return the goal of the poses from the largest load, or else from the solved loads."""
        nonlocal aim
        aim = aim or aimed(solved)
        return None if aim is None else aim.goal

    found = poses_on_grid(grid, after=after, begun=begun)
    aim = aim or aimed(found.values())
    if aim is None:
        return AimedLoads(found, loaded_model(sensor, magnetics, grid.tolerance, loads)[0], grid.tolerance)
    reached = np.nan if planned is None else worst(found.values(), aim.goal) + aim.goal.magnetics
    return AimedLoads(found, aim.field, aim.asked, planned, float(reached), aim.goal)


def readable_poses(sensor: Sensor, settled: Iterable[Settled]) -> list[Pose]:
    """Return the poses of the loads that have a reading."""
    return [one.rest.pose for one in settled if one.rest and status_of(sensor, one)[0] == OK]


def status_of(sensor: Sensor, settled: Settled) -> tuple[str, str]:
    """Return status and reason of a load; one whose target reaches the coils has no reading."""
    if settled.rest is None:
        return settled.status, settled.reason
    try:
        check_clearance(sensor, settled.rest.pose)
    except Collision as error:
        return FAILED, str(error)
    return OK, ""
