"""Which loads of a grid need solving? As many as a smooth map through them takes to foretell the others.

A grid is solved at 5, 9, 17, ... of its values along each force, ends included, until the map of the poses through
those loads (Chebyshev least squares, its error by foretelling what is left out) is within the tolerance of the largest
displacement. The loads between take their pose from cubic splines through the solved ones, so that the table has no
steps between both kinds; the error of the map is added to the solver's. A grid of fewer than seven values along a force
is solved whole, and so is one with a load that failed, or whose error nothing is known of.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from scipy.interpolate import RectBivariateSpline

from sits_mech.cases import DONE, Progress, Row
from sits_mech.mechanics.loads import Load, settle, upright
from sits_mech.quantities import Array, MechanicalModel, Wrench
from sits_mech.readout.surrogate import SmoothMap, fit_map
from sits_mech.sensor import Sensor

BETWEEN = "pose between solved loads, by a smooth map through them"
_FEWEST = 7  # values along a force from which on some may be left out
_POSE = ("d_h", "d_v", "alpha")


def settle_grid(
    sensor: Sensor,
    layer: MechanicalModel,
    grid: Mapping[str, Sequence[float]],
    *,
    symmetric: bool,
    tolerance: float,
    keep: tuple[Path | None, str] = (None, ""),
    progress: Progress | None = None,
) -> dict[Load, Row]:
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
        Rows by (F_x, F_z); those between solved loads have the note `BETWEEN`, no state and no seconds.
    """
    rows: dict[Load, Row] = {}
    for part in _parts(grid):
        rows = settle(layer, part, symmetric=symmetric, keep=keep, known=rows, progress=progress)
        loads = [(x, z) for x in part["F_x"] for z in part["F_z"]]
        if any(rows[load]["status"] != DONE or not np.isfinite(rows[load]["error_mechanics"]) for load in loads):
            break
        found = _map(rows, loads)
        if _good(sensor, found, rows, tolerance):
            more = _between(found, rows, part, grid)
            rows |= {load: upright(row) if symmetric and load[0] == 0.0 else row for load, row in more.items()}
            if progress is not None:
                progress(len(rows), len(rows))
            return rows
    return settle(layer, grid, symmetric=symmetric, keep=keep, known=rows, progress=progress)


def solved_first(loads: Sequence[Wrench]) -> list[Wrench]:
    """Return which of some loads are solved first: of a grid its coarsest part, which most often is enough."""
    grid = {name: sorted({float(getattr(load, name)) for load in loads}) for name in ("F_x", "F_z")}
    if not loads or len(grid["F_x"]) * len(grid["F_z"]) != len(loads) or any(load.M for load in loads):
        return list(loads)
    part = next(_parts(grid), grid)
    return [load for load in loads if load.F_x in part["F_x"] and load.F_z in part["F_z"]]


def _parts(grid: Mapping[str, Sequence[float]]) -> Iterator[dict[str, list[float]]]:
    """Give the coarser grids, each with nearly twice the values of the one before."""
    if min(len(values) for values in grid.values()) < _FEWEST:
        return
    count = 5
    while count < max(len(values) for values in grid.values()):
        yield {name: _some(values, count) for name, values in grid.items()}
        count = 2 * count - 1


def _some(values: Sequence[float], count: int) -> list[float]:
    """Return about evenly chosen values, ends included; of a list that mirrors itself, one that does."""
    last = len(values) - 1
    half = np.round(np.linspace(0.0, last / 2.0, (min(count, last + 1) + 1) // 2)).astype(int)
    return [values[i] for i in sorted({*half.tolist(), *(last - half).tolist()})]


def _map(rows: Mapping[Load, Row], loads: Sequence[Load]) -> SmoothMap:
    """Return the map of pose, its errors and smallest J through solved loads."""
    names = (*_POSE, *(f"error_{name}" for name in _POSE), "min_J")
    values = np.array([[rows[load][name] for name in names] for load in loads])
    return fit_map(("F_x", "F_z"), np.array(loads), np.nan_to_num(values, nan=1.0))


def _good(sensor: Sensor, found: SmoothMap, rows: Mapping[Load, Row], tolerance: float) -> bool:
    """Tell whether a map foretells the target's place, its edges included, within the tolerance."""
    reach = 0.5 * sensor.target.extent[0] if sensor.target is not None else 0.0
    scale = np.array([1.0, 1.0, reach])
    poses: Array = np.array([[row[name] for name in _POSE] for row in rows.values()])
    return bool(np.max(found.error[:3] * scale) <= tolerance * np.max(np.ptp(poses, axis=0) * scale))


def _between(
    found: SmoothMap, rows: Mapping[Load, Row], part: Mapping[str, Sequence[float]], grid: Mapping[str, Sequence[float]]
) -> dict[Load, Row]:
    """Return the rows of a grid's loads between the solved ones, which are all of its part."""
    loads = [(x, z) for x in grid["F_x"] for z in grid["F_z"] if (x, z) not in rows]
    worst = max(row["error_mechanics"] for row in rows.values())
    highest = np.max([[row[f"error_{name}"] for name in _POSE] for row in rows.values()], axis=0)
    errors = np.clip(found.at(np.array(loads))[:, 3:6], 0.0, highest) + found.error[:3]
    poses = np.column_stack([_spline(rows, part, name).ev(*np.array(loads).T) for name in (*_POSE, "min_J")])
    more: dict[Load, Row] = {}
    for load, pose, error in zip(loads, poses.tolist(), errors.tolist(), strict=True):
        row: Row = {"status": DONE, "reason": "", "lasting": True}
        row |= dict(zip((*_POSE, "min_J"), pose, strict=True))
        row |= {f"error_{name}": size for name, size in zip(_POSE, error, strict=True)}
        row |= {"error_mechanics": worst, "iterations": 0, "notes": BETWEEN, "seconds": 0.0}
        more[load] = row
    return more


def _spline(rows: Mapping[Load, Row], part: Mapping[str, Sequence[float]], name: str) -> RectBivariateSpline:
    """Return cubic splines through a number of every solved load; one that is missing counts as one."""
    values = np.array([[rows[x, z][name] for z in part["F_z"]] for x in part["F_x"]])
    return RectBivariateSpline(part["F_x"], part["F_z"], np.nan_to_num(values, nan=1.0))
