"""Force in, inductance out: the one place where both physics meet.

    wrench --(mechanics)--> pose p +- e --(magnetics)--> L(p), R(p) --> signals

Linear algebra has one thread: factors of sparse matrices slow down with more. In a calibration a second thread prepares
the plate for a pad in space while that is solved, at poses that one compliance foretells. What is kept of it
does not depend on who asked first, so neither does the result.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from threadpoolctl import threadpool_limits

from sits_mech.filling import settle_grid
from sits_mech.geometry.collision import Collision, check_clearance
from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.field import planar_fem
from sits_mech.magnetics.rings import axisymmetric
from sits_mech.magnetics.sheets import Sheets, sheets
from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.block_mesh import pad_parts
from sits_mech.mechanics.finite_length import small_strain_stiffness
from sits_mech.mechanics.layer import linear_layer, planar_layer
from sits_mech.mechanics.loads import kept_key
from sits_mech.mechanics.strip import strip_layer
from sits_mech.omissions import mirrored
from sits_mech.plan import Choice, Plan, choose_magnetics, choose_mechanics, magnetic_tolerance
from sits_mech.quantities import Equilibrium, Impedance, MagneticModel, MechanicalModel, Pose, Wrench
from sits_mech.reading import read_poses, signals_at, stacked
from sits_mech.readout.signals import Signals
from sits_mech.sensor import SceneError, Sensor, scene_hash, scene_text
from sits_mech.sweep import DONE, Progress, Row, table
from sits_mech.version import __version__

MECHANICS: Mapping[str, Callable[[Sensor, float], MechanicalModel]] = {
    "planar": planar_layer,
    "linear": linear_layer,
    "block": block_pad,
    "closed-form": strip_layer,
}
"""The mechanical models by name; each factory takes a sensor and a tolerance."""
MAGNETICS: Mapping[str, Callable[[Sensor, float], MagneticModel]] = {
    "planar": planar_bars,
    "planar-fem": planar_fem,
    "axisymmetric": axisymmetric,
    "sheets": sheets,
}
"""The magnetic models by name; each factory takes a sensor and a tolerance."""


@dataclass(frozen=True)
class Simulation:
    """What the sensor shows under one load.

    Attributes
    ----------
    equilibrium : Equilibrium
        Where the target comes to rest.
    impedance : Impedance
        What the coils show; its errors include what the pose's error makes of them.
    signals : Signals
        Combined, with errors.
    """

    equilibrium: Equilibrium
    impedance: Impedance
    signals: Signals


def plan(
    sensor: Sensor, loads: Sequence[Wrench] = (), *, tolerance: float = 1e-2, mechanics: str = "auto",
    magnetics: str = "auto",
) -> Plan:  # fmt: skip
    """Return what a request takes, what it leaves out, and what to expect of it.

    Parameters
    ----------
    sensor : Sensor
        The scene.
    loads : sequence of Wrench
        Those asked for; none where poses are given.
    tolerance, mechanics, magnetics
        As for `simulate`.

    Raises
    ------
    SceneError
        When a model is unknown or cannot hold the scene.
    """
    by_layer = choose_mechanics(sensor, mechanics, tuple(MECHANICS), loads, tolerance) if loads else None
    by_field = choose_magnetics(sensor, magnetics, tuple(MAGNETICS), bool(loads))
    return Plan.of(sensor, loads, checked_tolerance(tolerance), by_layer, by_field)


def mechanical_model(
    sensor: Sensor, name: str = "auto", tolerance: float = 1e-2, loads: Sequence[Wrench] = ()
) -> tuple[MechanicalModel, Choice]:
    """Return the mechanical model of a name with the reason for it.

    Parameters
    ----------
    sensor : Sensor
        The scene.
    name : str
        "auto" or a key of `MECHANICS`.
    tolerance : float
        Asked relative error of the pose.
    loads : sequence of Wrench
        All it will be asked for, where that is known: small ones need less.

    Raises
    ------
    SceneError
        When the model is unknown or cannot hold the scene.
    """
    choice = choose_mechanics(sensor, name, tuple(MECHANICS), loads, tolerance)
    return MECHANICS[choice.name](sensor, checked_tolerance(tolerance)), choice


def magnetic_model(sensor: Sensor, name: str = "auto", tolerance: float = 1e-3) -> tuple[MagneticModel, Choice]:
    """Return the magnetic model of a name of `MAGNETICS` or "auto" with the reason; as `mechanical_model`."""
    choice = choose_magnetics(sensor, name, tuple(MAGNETICS))
    return MAGNETICS[choice.name](sensor, checked_tolerance(tolerance)), choice


def loaded_model(sensor: Sensor, name: str = "auto", tolerance: float = 1e-2) -> tuple[MagneticModel, Choice]:
    """Return the magnetic model for poses that loads give to a tolerance, with the reason; as `magnetic_model`."""
    choice = choose_magnetics(sensor, name, tuple(MAGNETICS), True)
    return MAGNETICS[choice.name](sensor, magnetic_tolerance(choice.name, checked_tolerance(tolerance))), choice


def checked_tolerance(tolerance: float) -> float:
    """Return a tolerance, or raise SceneError where it is none."""
    if not 0.0 < tolerance < 1.0:
        raise SceneError(f"tolerance must lie between 0 and 1; got {tolerance}")
    return tolerance


def simulate(
    sensor: Sensor, wrench: Wrench, *, tolerance: float = 1e-2, mechanics: str = "auto", magnetics: str = "auto"
) -> Simulation:
    """Return what the sensor shows under a load.

    Parameters
    ----------
    sensor : Sensor
        With target and elastomer.
    wrench : Wrench
        The load [N, N m].
    tolerance : float
        Asked relative error of the pose; of the change of inductance a tenth of it, by sheets as much.
    mechanics, magnetics : str
        Names of the models.

    Returns
    -------
    Simulation
        Equilibrium, impedance and signals.

    Raises
    ------
    SceneError
        When a model cannot hold the scene.
    Collision
        When the target comes to the coil plane.
    SolveFailed
        When the layer has no equilibrium that could be reached.
    """
    field, _ = loaded_model(sensor, magnetics, tolerance)
    layer, _ = mechanical_model(sensor, mechanics, tolerance, [wrench])
    with threadpool_limits(1):
        return _simulated(sensor, layer, field, wrench)


def at_rest(sensor: Sensor, layer: MechanicalModel, wrench: Wrench) -> Equilibrium:
    """Return where a target rests; shift and tilt that symmetry forbids are zero without error.

    Parameters
    ----------
    sensor : Sensor
        The scene.
    layer : MechanicalModel
        Of the sensor.
    wrench : Wrench
        The load [N, N m].

    Raises
    ------
    SolveFailed
        When the layer has no equilibrium that could be reached.
    """
    found = layer.equilibrium(wrench)
    if not mirrored(sensor) or wrench.F_x != 0.0 or wrench.M != 0.0:
        return found
    pose, error = (Pose(0.0, part.d_v, 0.0) for part in (found.pose, found.error))
    return replace(found, pose=pose, error=error)


def _simulated(sensor: Sensor, layer: MechanicalModel, field: MagneticModel, wrench: Wrench) -> Simulation:
    """Return what the sensor shows under a load by given models."""
    equilibrium = at_rest(sensor, layer, wrench)
    check_clearance(sensor, equilibrium.pose)
    reading = read_poses(sensor, field, stacked([equilibrium.pose]), stacked([equilibrium.error]))
    found = reading.impedance
    single = {name: getattr(found, name)[0] for name in ("L", "R", "error_L", "error_R")}
    return Simulation(equilibrium, replace(found, **single), signals_at(reading.signals, 0))


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
