"""Which loads of a grid need solving? As many as a smooth map through them takes to foretell the others.

A grid is solved at 5, 9, 17, ... of its values along each force, ends included, until the map of the poses through
those loads (Chebyshev least squares, its error by foretelling what is left out) is within the tolerance of the largest
displacement. The loads between take their pose from the map; its error is added to the solver's. A grid of fewer than
seven values along a force is solved whole, and so is one with a load that failed, or whose error nothing is known of.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from sits_mech.mechanics.loads import Load, settle
from sits_mech.quantities import Array, MechanicalModel
from sits_mech.readout.surrogate import SmoothMap, fit_map
from sits_mech.sensor import Sensor
from sits_mech.sweep import DONE, Progress, Row

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
            return _filled(found, rows, grid, progress)
    return settle(layer, grid, symmetric=symmetric, keep=keep, known=rows, progress=progress)


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


def _filled(
    found: SmoothMap, rows: dict[Load, Row], grid: Mapping[str, Sequence[float]], progress: Progress | None
) -> dict[Load, Row]:
    """Return the rows with those between them."""
    loads = [(x, z) for x in grid["F_x"] for z in grid["F_z"]]
    missing = [load for load in loads if load not in rows]
    worst = max(row["error_mechanics"] for row in rows.values())
    highest = np.max([[row[f"error_{name}"] for name in _POSE] for row in rows.values()], axis=0)
    for load, values in zip(missing, found.at(np.array(missing)), strict=True):
        row: Row = {"status": DONE, "reason": "", "lasting": True}
        row |= {name: float(value) for name, value in zip(_POSE, values[:3], strict=True)}
        errors = np.clip(values[3:6], 0.0, highest) + found.error[:3]
        row |= {f"error_{name}": float(error) for name, error in zip(_POSE, errors, strict=True)}
        row |= {"min_J": float(values[6]), "error_mechanics": worst, "iterations": 0, "notes": BETWEEN, "seconds": 0.0}
        rows[load] = row
    if progress is not None:
        progress(len(loads), len(loads))
    return rows
