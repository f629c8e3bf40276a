"""Solve the loads of a table as far as its signals need; the largest load's first meshes tell how far that is.

The first meshes of the largest load and its images give what errors of the pose are worth in the signals (goal.py), the
plan and the magnetic model (promise.py); where it is not carried the other loads do. When all loads that need it are
solved on the first meshes, finer ones are taken until the worst of them is good enough (interpolate.py).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sits_mech.cases import Progress, Row
from sits_mech.chain.goal import Goal, goal_at
from sits_mech.chain.interpolate import loads_of, poses_on_grid, solved_likely, worst
from sits_mech.chain.models import loaded_model
from sits_mech.chain.pose_errors import pose_of
from sits_mech.chain.prices.forecast import Look
from sits_mech.chain.promise import Aim, aim_at
from sits_mech.geometry.collision import Collision, check_clearance
from sits_mech.maps.grid import Axes
from sits_mech.mechanics.levels.answer import load_words
from sits_mech.mechanics.levels.history import depends_on_path
from sits_mech.mechanics.loads import RefinedModel, first_key, rest_of, settle
from sits_mech.mechanics.symmetry import Symmetry
from sits_mech.quantities import MagneticModel, MechanicalModel, Wrench
from sits_mech.scene.sensor import Sensor
from sits_mech.status import FAILED, OK


class AimedRows(NamedTuple):
    """Rows of all loads, and the magnetic model that reads them."""

    rows: Mapping[Wrench, Row]
    field: MagneticModel  # as fine as the signals need
    asked: float  # tolerance of `field`
    planned: Look | None = None  # from the largest load's first meshes; None where nothing was planned
    reached: float = np.nan  # error over the signals' full scale; NaN where nothing was planned
    goal: Goal | None = None  # None where no signal changes


def aimed_rows(
    sensor: Sensor, layer: MechanicalModel, grid: Axes, models: tuple[str, str], tolerance: float, *,
    symmetry: Symmetry, keep: tuple[Path | None, str] = (None, ""), progress: Progress | None = None, best: bool = True,
) -> AimedRows:
    """Return the rows of a grid of loads, solved to a tolerance of the signals' full scale.

    `models` are the names of the mechanical model and of the magnetic one as asked for. A tolerance that cannot be
    reached is answered with what is; without `best` it raises SceneError.
    """
    mechanics, magnetics = models
    loads, begun = loads_of(grid), dict[Wrench, Row]()
    aim: Aim | None = None
    planned: Look | None = None

    def aimed(rows: Iterable[Row]) -> Aim | None:
        """Return the aim of the table from rows of some loads; None where they tell nothing."""
        poses = [pose_of(row) for row in rows if status_of(sensor, row)[0] == OK]
        return aim_at(sensor, magnetics, tolerance, loads, poses) if poses else None

    if isinstance(layer, RefinedModel) and not depends_on_path(sensor):
        far = symmetry.standard(_largest(loads))[0]
        images = [load for load in loads if symmetry.standard(load)[0] == far]
        begun = settle(layer.rough, images, symmetry=symmetry, keep=(keep[0], first_key(keep[1])))
        aim = aimed(begun.values())
    if aim is not None:
        solved = len(symmetry.without_images(solved_likely(loads)))
        planned = aim.promised(rest_of(far, begun[far], mechanics), len(loads), solved)
        if not best:
            aim.refuse_beyond(planned, load_words(vars(far)))

    def after(rows: Iterable[Row]) -> Goal | None:
        """Return the goal of the poses from the largest load, or else from the solved loads."""
        nonlocal aim
        aim = aim or aimed(rows)
        return None if aim is None else aim.goal

    rows = poses_on_grid(
        sensor, layer, grid, symmetry=symmetry, tolerance=tolerance, keep=keep, progress=progress,
        after=after, begun=begun,
    )
    if aim is None:
        field = loaded_model(sensor, magnetics, tolerance, loads)[0]
        goal = goal_at(sensor, field, [pose_of(row) for row in rows.values() if status_of(sensor, row)[0] == OK])
        return AimedRows(rows, field, tolerance, goal=goal)
    reached = np.nan if planned is None else worst(rows, aim.goal) + aim.goal.magnetics
    return AimedRows(rows, aim.field, aim.asked, planned, float(reached), aim.goal)


def status_of(sensor: Sensor, row: Row) -> tuple[str, str]:
    """Return status and reason of a load; one whose target reaches the coils has no reading."""
    if row["status"] != OK:
        return str(row["status"]), str(row["reason"])
    try:
        check_clearance(sensor, pose_of(row))
    except Collision as error:
        return FAILED, str(error)
    return OK, ""


def _largest(loads: Sequence[Wrench]) -> Wrench:
    """Return the load whose components are largest, each over its largest of all."""
    sizes = np.abs([load.components for load in loads])
    return loads[int(np.argmax((sizes / np.maximum(sizes.max(axis=0), 1e-300)).sum(axis=1)))]
