"""How far are the loads of a table solved? As far as its signals need: a look at the largest load tells what that is.

The largest load's first meshes, and its images, give what errors of the pose are worth in the signals (goal.py), the
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
from sits_mech.chain.prices.look import Look
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
    """Rows of all loads, and what reads them.

    Attributes
    ----------
    rows : mapping of Wrench to dict
    field : MagneticModel
        As fine as the signals take.
    asked : float
        Tolerance that it is made for.
    planned : Look or None
        What the largest load's first meshes promised; None where nothing was planned.
    reached : float
        Error over the signals' full scale; NaN where nothing was planned.
    goal : Goal or None
        What the poses are for; None where no signal changes.
    """

    rows: Mapping[Wrench, Row]
    field: MagneticModel
    asked: float
    planned: Look | None = None
    reached: float = np.nan
    goal: Goal | None = None


def aimed_rows(
    sensor: Sensor, layer: MechanicalModel, grid: Axes, models: tuple[str, str], tolerance: float, *,
    symmetry: Symmetry, keep: tuple[Path | None, str] = (None, ""), progress: Progress | None = None, best: bool = True,
) -> AimedRows:  # fmt: skip
    """Return the rows of a grid of loads, solved to a tolerance of the signals' full scale.

    Parameters
    ----------
    sensor, layer, grid, symmetry, keep, progress
        As of `poses_on_grid`.
    models : tuple of str
        Name of the mechanical model, and of the magnetic one as it was asked for.
    tolerance : float
    best : bool
        Whether a tolerance that cannot be reached is answered with what is.

    Raises
    ------
    SceneError
        Without `best`, for a tolerance that cannot be reached.
    """
    mechanics, magnetics = models
    loads, begun = loads_of(grid), dict[Wrench, Row]()
    aim: Aim | None = None
    planned: Look | None = None

    def aimed(rows: Iterable[Row]) -> Aim | None:
        """What the table is after, by rows of some of its loads; None where they tell nothing."""
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
        """What poses are for; by those of solved loads, where the largest tells nothing."""
        nonlocal aim
        aim = aim or aimed(rows)
        return None if aim is None else aim.goal

    rows = poses_on_grid(
        sensor, layer, grid, symmetry=symmetry, tolerance=tolerance, keep=keep, progress=progress,
        after=after, begun=begun,
    )  # fmt: skip
    if aim is None:
        field = loaded_model(sensor, magnetics, tolerance, loads)[0]
        goal = goal_at(sensor, field, [pose_of(row) for row in rows.values() if status_of(sensor, row)[0] == OK])
        return AimedRows(rows, field, tolerance, goal=goal)
    reached = np.nan if planned is None else worst(rows, aim.goal) + aim.goal.magnetics
    return AimedRows(rows, aim.field, aim.asked, planned, float(reached), aim.goal)


def status_of(sensor: Sensor, row: Row) -> tuple[str, str]:
    """Return what became of a load, and why it has no reading: one whose target comes to the coils has none either."""
    if row["status"] != OK:
        return str(row["status"]), str(row["reason"])
    try:
        check_clearance(sensor, pose_of(row))
    except Collision as error:
        return FAILED, str(error)
    return OK, ""


def _largest(loads: Sequence[Wrench]) -> Wrench:
    """The load whose components are the largest, each over its largest of all."""
    sizes = np.abs([load.components for load in loads])
    return loads[int(np.argmax((sizes / np.maximum(sizes.max(axis=0), 1e-300)).sum(axis=1)))]
