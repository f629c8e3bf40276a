"""Solve the loads of a table until its signals meet the tolerance.

The first meshes of the largest load and its images give what errors of the pose are worth in the signals (goal.py), the
plan and the magnetic model (promise.py); where it is not carried the other loads do. When all loads that need it are
solved on the first meshes, finer ones are taken until the worst of them is good enough (interpolate.py).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from sits_mech.chain.interpolate import LoadGrid, poses_on_grid, solved_likely, worst
from sits_mech.chain.models import loaded_model
from sits_mech.chain.prices.forecast import Look
from sits_mech.chain.tolerance.goal import Goal, goal_at
from sits_mech.chain.tolerance.promise import Aim, aim_at
from sits_mech.geometry.collision import Collision, check_clearance
from sits_mech.mechanics.levels.answer import load_words
from sits_mech.mechanics.levels.load_path import depends_on_path
from sits_mech.mechanics.loads import RefinedModel, Settled, first_key, settle
from sits_mech.quantities import Equilibrium, MagneticModel, Pose, Wrench
from sits_mech.scene.sensor import Sensor
from sits_mech.status import FAILED, OK


class AimedLoads(NamedTuple):
    """What comes of all loads, and the magnetic model that reads them."""

    settled: Mapping[Wrench, Settled]
    field: MagneticModel  # as fine as the signals need
    asked: float  # tolerance of `field`
    planned: Look | None = None  # from the largest load's first meshes; None where nothing was planned
    reached: float = np.nan  # error over the signals' full scale; NaN where nothing was planned
    goal: Goal | None = None  # None where no signal changes


def aimed_loads(grid: LoadGrid, magnetics: str, *, best: bool = True) -> AimedLoads:
    """Solve a grid of loads to a tolerance of the signals' full scale.

    `magnetics` is the magnetic model's name as asked for. A tolerance that cannot be reached is answered with what is;
    without `best` it raises SceneError.
    """
    sensor, layer, symmetry, keep = grid.sensor, grid.layer, grid.symmetry, grid.keep
    loads, begun = grid.loads, dict[Wrench, Settled]()
    aim: Aim | None = None
    first: Equilibrium | None = None  # under the largest load
    planned: Look | None = None

    def aimed(some: Iterable[Settled]) -> Aim | None:
        """Return the aim of the table from some of its loads; None where they tell nothing."""
        poses = clear(sensor, some)
        return aim_at(sensor, magnetics, grid.tolerance, loads, poses) if poses else None

    if isinstance(layer, RefinedModel) and not depends_on_path(sensor):
        far = symmetry.standard(_largest(loads))[0]
        images = [load for load in loads if symmetry.standard(load)[0] == far]
        begun = settle(layer.rough, images, symmetry=symmetry, keep=(keep[0], first_key(keep[1])))
        aim = aimed(begun.values())
        first = begun[far].rest
    if aim is not None and first is not None:
        solved = len(symmetry.without_images(solved_likely(loads)))
        planned = aim.promised(first, len(loads), solved)
        if not best:
            aim.refuse_beyond(planned, load_words(vars(far)))

    def after(solved: Iterable[Settled]) -> Goal | None:
        """Return the goal of the poses from the largest load, or else from the solved loads."""
        nonlocal aim
        aim = aim or aimed(solved)
        return None if aim is None else aim.goal

    found = poses_on_grid(grid, after=after, begun=begun)
    if aim is None:
        field = loaded_model(sensor, magnetics, grid.tolerance, loads)[0]
        goal = goal_at(sensor, field, clear(sensor, found.values()))
        return AimedLoads(found, field, grid.tolerance, goal=goal)
    reached = np.nan if planned is None else worst(found.values(), aim.goal) + aim.goal.magnetics
    return AimedLoads(found, aim.field, aim.asked, planned, float(reached), aim.goal)


def clear(sensor: Sensor, settled: Iterable[Settled]) -> list[Pose]:
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


def _largest(loads: Sequence[Wrench]) -> Wrench:
    """Return the load whose components are largest, each over its largest of all."""
    sizes = np.abs([load.components for load in loads])
    return loads[int(np.argmax((sizes / np.maximum(sizes.max(axis=0), 1e-300)).sum(axis=1)))]
