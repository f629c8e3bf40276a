"""What does the sensor show over a grid of loads? The chain of simulate.py on every load, as one labelled table.

A second thread prepares the plate for a pad in space while that is solved, at poses that one compliance foretells.
What is kept of it does not depend on who asked first, so neither does the result.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from threadpoolctl import threadpool_limits

from sits_mech.cases import DONE, Progress, Row, table
from sits_mech.chain.interpolate import settle_grid
from sits_mech.chain.models import loaded_model, mechanical_model
from sits_mech.chain.omissions import mirrored
from sits_mech.chain.pose_errors import read_poses, signals_at, stacked
from sits_mech.geometry.collision import Collision, check_clearance
from sits_mech.magnetics.sheets import Sheets
from sits_mech.mechanics.block_mesh import pad_parts
from sits_mech.mechanics.finite_length import small_strain_stiffness
from sits_mech.mechanics.loads import kept_key
from sits_mech.quantities import Impedance, MagneticModel, Pose, Wrench
from sits_mech.sensor import SceneError, Sensor, scene_hash, scene_text
from sits_mech.version import __version__


def calibrate(
    sensor: Sensor,
    *,
    F_x: Sequence[float],
    F_z: Sequence[float],
    tolerance: float = 1e-2,
    mechanics: str = "auto",
    magnetics: str = "auto",
    progress: Progress | None = None,
    folder: Path | None = None,
) -> xr.Dataset:
    """Return what the sensor shows over a grid of loads.

    Parameters
    ----------
    sensor : Sensor
        With target and elastomer.
    F_x, F_z : sequence of float
        Shear and normal forces [N].
    tolerance, mechanics, magnetics
        As for `simulate`.
    progress : callable, optional
        Called with the number of loads done and of all.
    folder : Path, optional
        Where finished loads are kept, one file each, and looked for first.

    Returns
    -------
    Dataset, dims (F_x, F_z)
        Pose, impedance, signals, each with ``error_``; ``status``, ``reason``, ``notes``, ``seconds``, ``min_J``. A
        load that fails has NaN and says why; a pose between solved loads is noted as such. Attributes hold scene,
        hash, request, version, ``unit_L``.

    Raises
    ------
    SceneError
        When a model cannot hold the scene, or a list of forces is empty, has a value twice or one that is not finite.
    """
    grid = {"F_x": _checked_forces("F_x", F_x), "F_z": _checked_forces("F_z", F_z)}
    field, by_field = loaded_model(sensor, magnetics, tolerance)
    loads = [Wrench(x, z) for x in grid["F_x"] for z in grid["F_z"]]
    layer, by_layer = mechanical_model(sensor, mechanics, tolerance, loads)
    request = {"mechanics": by_layer.name, "magnetics": by_field.name, "tolerance": tolerance, **grid}
    with threadpool_limits(1):
        ahead = _prepared_ahead(sensor, field, loads, by_layer.name)
        keep = (folder, kept_key(sensor, by_layer.name, tolerance))
        rows = settle_grid(
            sensor, layer, grid, symmetric=mirrored(sensor), tolerance=tolerance, keep=keep, progress=progress
        )
        ahead.join()
        reading, done = _read_rows(sensor, field, [rows[load.F_x, load.F_z] for load in loads])
    data = table(grid, done)
    data = data.assign_coords(coil=[coil.name for coil in sensor.coils], coil_2=[coil.name for coil in sensor.coils])
    data["L0"] = (("coil", "coil_2"), reading.L0)
    attributes = {"frequency": sensor.frequency, "unit_L": reading.unit_L, "request": json.dumps(request)}
    scene = {"scene": scene_text(sensor), "scene_hash": scene_hash(sensor), "version": __version__, "name": sensor.name}
    return data.assign_attrs(**scene, **attributes)


def _checked_forces(name: str, forces: Sequence[float]) -> list[float]:
    """Return forces in ascending order, or refuse them."""
    found = sorted(float(force) for force in forces)
    if not found or not np.all(np.isfinite(found)) or len(set(found)) < len(found):
        raise SceneError(f"{name} must be one or more different finite forces [N]; got {list(forces)}")
    return found


def _prepared_ahead(
    sensor: Sensor, model: MagneticModel, loads: Sequence[Wrench], mechanics: str
) -> threading.Thread:  # fmt: skip
    """Return a started thread that has a plate in space prepared by the time the pad is solved.

    A process among many has no core to spare for it; a thread that fails says nothing: the reading then will.
    """
    alone = multiprocessing.parent_process() is None and (os.cpu_count() or 1) > 1
    needed = alone and mechanics == "block" and isinstance(model, Sheets)

    def prepare() -> None:
        """Ask for the outermost loads."""
        try:
            model.impedance(_foretold(sensor, loads), sensor.frequency)
        except Exception:  # whatever it is, the reading meets it again and names it
            return

    thread = threading.Thread(target=prepare if needed else lambda: None, daemon=True)  # gone with an interrupted run
    thread.start()
    return thread


def _foretold(sensor: Sensor, loads: Sequence[Wrench]) -> Pose:
    """Return about where the target comes to rest under the outermost loads: by one compliance at small strain."""
    target, elastomer = pad_parts(sensor)
    F_x, F_z = np.array([[load.F_x, load.F_z] for load in loads]).T
    corners = [Wrench(x, z) for x in (F_x.min(), F_x.max()) for z in (F_z.min(), F_z.max())]
    forces = [(load.F_x, -load.F_z, load.M + load.F_x * target.load_height) for load in corners]
    d_h, d_z, alpha = np.linalg.solve(small_strain_stiffness(sensor)[0], np.transpose(forces))
    return Pose(d_h, elastomer.standoff + elastomer.thickness + d_z, alpha)


def _read_rows(sensor: Sensor, model: MagneticModel, rows: Sequence[Row]) -> tuple[Impedance, list[Row]]:
    """Return the impedance of all converged rows, and the rows with what the coils show."""
    checked = [_guarded(sensor, {name: item for name, item in row.items() if name != "state"}) for row in rows]
    good = [row for row in checked if row["status"] == DONE]
    poses = stacked([Pose(row["d_h"], row["d_v"], row["alpha"]) for row in good])
    errors = stacked([Pose(row["error_d_h"], row["error_d_v"], row["error_alpha"]) for row in good])
    reading = read_poses(sensor, model, poses, errors)
    found, coils = reading.impedance, ("coil", "coil_2")
    share = found.report.seconds / max(len(good), 1)
    numbers = iter(range(len(good)))
    done = []
    for row in checked:
        shown: dict[str, Any] = {"L_h_untilted_percent": np.nan, **dict.fromkeys(vars(reading.signals), np.nan)}
        shown |= {name: (coils, np.full(found.L0.shape, np.nan)) for name in ("L", "R", "error_L", "error_R")}
        if row["status"] == DONE:
            i = next(numbers)
            shown = {name: (coils, getattr(found, name)[i]) for name in ("L", "R", "error_L", "error_R")}
            shown |= vars(signals_at(reading.signals, i)) | {"L_h_untilted_percent": float(reading.untilted[i])}
            shown |= {"error_magnetics": found.report.estimated_error, "seconds": row["seconds"] + share}
        done.append(row | shown)
    return found, done


def _guarded(sensor: Sensor, row: Row) -> Row:
    """Return a row, or one that says so when its pose brings the target to the coil plane."""
    if row["status"] != DONE:
        return row
    try:
        check_clearance(sensor, Pose(row["d_h"], row["d_v"], row["alpha"]))
    except Collision as error:
        return row | {"status": "collision", "reason": str(error)}
    return row
