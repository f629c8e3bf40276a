"""Where does the target rest over a grid of loads, when only as many are solved as predict the others?

The part of the grid that is solved, and what stands between its loads, is told by `maps.grid`: the map of the poses
must be within the tolerance of the largest displacement, the target's edges included. The error of the map is added to
the solver's, which goes straight from load to load. A grid is solved whole where a load fails, or where nothing is
known of its error.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from sits_mech.cases import DONE, Progress, Row
from sits_mech.maps.grid import Axes, SolvedPart, coarser, interpolated, solve_part
from sits_mech.mechanics.loads import settle, upright
from sits_mech.quantities import POSE, WRENCH, Array, MechanicalModel, Wrench
from sits_mech.scene.sensor import Sensor

INTERPOLATED = "pose between solved loads, by a smooth map through them"


def poses_on_grid(
    sensor: Sensor,
    layer: MechanicalModel,
    grid: Axes,
    *,
    symmetric: bool,
    tolerance: float,
    keep: tuple[Path | None, str] = (None, ""),
    progress: Progress | None = None,
) -> dict[Wrench, Row]:
    """Return a row for every load of a grid, solved or between solved ones.

    Parameters
    ----------
    sensor : Sensor
        For the size of its target.
    layer, grid, symmetric, keep, progress
        As for `settle`.
    tolerance : float
        Of the map, relative to the largest displacement of the target.

    Returns
    -------
    dict
        Rows by load; those between solved loads have the note `INTERPOLATED`, no state and no seconds.
    """
    rows: dict[Wrench, Row] = {}

    def poses(part: Axes) -> Array:
        """Return the poses on a part of the grid; NaN where there is none, or nothing is known of its error."""
        rows.update(settle(layer, part, symmetric=symmetric, keep=keep, known=rows, progress=progress))
        found = [rows[load] for load in loads_of(part)]
        good = [row["status"] == DONE and np.isfinite(row["error_mechanics"]) for row in found]
        values = [[row[name] if own else np.nan for name in POSE] for row, own in zip(found, good, strict=True)]
        return np.array(values).reshape(*_sizes(part), -1)

    part = solve_part(poses, grid, tolerance=tolerance, weights=_levers(sensor))
    if part is None:
        return settle(layer, grid, symmetric=symmetric, keep=keep, known=rows, progress=progress)
    more = _between(part, rows, grid)
    rows |= {load: upright(row, load) if symmetric else row for load, row in more.items()}
    if progress is not None:
        progress(len(rows), len(rows))
    return rows


def loads_of(grid: Axes) -> list[Wrench]:
    """Return the loads of a grid, the last of its components running fastest; components it has not are zero."""
    return [Wrench(**dict(zip(grid, load, strict=True))) for load in itertools.product(*grid.values())]


def solved_first(loads: Sequence[Wrench]) -> list[Wrench]:
    """Return which of some loads are solved first: of a grid its coarsest part, which most often is enough."""
    axes = {name: sorted({float(getattr(load, name)) for load in loads}) for name in WRENCH}
    if np.prod(_sizes(axes)) != len(set(loads)):
        return list(loads)
    part = next(coarser(axes), axes)
    return [load for load in loads if all(getattr(load, name) in part[name] for name in WRENCH)]


def _sizes(axes: Axes) -> tuple[int, ...]:
    """Return how many values each variable has."""
    return tuple(len(values) for values in axes.values())


def _levers(sensor: Sensor) -> Array:
    """Return what makes the components of a pose displacements: half the target's sides for the angles [m]."""
    width, length = (0.0, 0.0) if sensor.target is None else sensor.target.extent
    return np.array([1.0, 1.0, 0.5 * width, 1.0, 0.5 * length, 0.5 * max(width, length)])


def _between(part: SolvedPart, rows: Mapping[Wrench, Row], grid: Axes) -> dict[Wrench, Row]:
    """Return the rows of a grid's loads between the solved ones."""

    def on_grid(names: Sequence[str], degree: int) -> list[list[float]]:
        """Return numbers of every solved load on all of the grid; one that is missing counts as one."""
        own = np.array([[rows[load][name] for name in names] for load in loads_of(part.axes)])
        known = np.nan_to_num(own, nan=1.0).reshape(*_sizes(part.axes), -1)
        found: list[list[float]] = interpolated(part.axes, known, grid, degree=degree).reshape(-1, len(names)).tolist()
        return found

    worst = max(row["error_mechanics"] for row in rows.values())
    errors = [f"error_{name}" for name in POSE]
    more: dict[Wrench, Row] = {}
    for load, place, size in zip(loads_of(grid), on_grid((*POSE, "min_J"), 3), on_grid(errors, 1), strict=True):
        if load in rows:
            continue
        row: Row = {"status": DONE, "reason": "", "lasting": True} | dict(zip((*POSE, "min_J"), place, strict=True))
        row |= dict(zip(errors, (np.array(size) + part.error).tolist(), strict=True))
        more[load] = row | {"error_mechanics": worst, "iterations": 0, "notes": INTERPOLATED, "seconds": 0.0}
    return more
