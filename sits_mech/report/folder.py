"""What does a calibration leave behind? A folder: result.nc, result.csv, scene.toml, pictures, finished loads."""

from __future__ import annotations

import json
import tempfile
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from sits_mech.batch.requests import SWEPT, case_calibration
from sits_mech.cases import read_table, save_table
from sits_mech.mechanics.loads import kept_key, kept_rest
from sits_mech.quantities import SolveFailed
from sits_mech.readout.loads import points, varied, wrench_of
from sits_mech.report.pictures.curves import calibration_pictures, save_figure
from sits_mech.report.pictures.section import load_view
from sits_mech.report.tables.loads import csv_text
from sits_mech.scene.files import write_text
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor, save_sensor
from sits_mech.status import ANSWERED
from sits_mech.version import __version__

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NEEDED = ("status", "d_h", "d_v", "alpha", "L", "R", "L0")


def prepare_folder(folder: Path, *, cases: bool = True) -> Path:
    """Make a folder, with one for finished loads, and prove that it can be written to; raise SceneError if not."""
    try:
        (cases_folder(folder) if cases else folder).mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder):
            return folder
    except OSError as error:
        raise SceneError(f"{folder}: must be a folder that can be written to; got: {error.strerror or error}") from None


def cases_folder(folder: Path) -> Path:
    """Return where the finished loads of a calibration are kept."""
    return folder / "cases"


def read_calibration(folder: Path, case: int | None = None) -> tuple[Sensor, xr.Dataset]:
    """Return sensor and table of a folder that `write_calibration` filled, or of a case of a sweep of calibrations.

    Parameters
    ----------
    folder : Path
        As it was given to ``sits-mech calibrate -o``, or ``sits-mech sweep -o``.
    case : int, optional
        Of the latter the number of a case, from 1 on.

    Raises
    ------
    SceneError
        When there is no calibration, a stopped one, one of another version or scene, or none of its loads converged.
    """
    path = folder / "result.nc"
    if not path.exists():
        state = "a calibration that was stopped: repeat its command" if cases_folder(folder).is_dir() else "none"
        raise SceneError(f"{folder}: must be the folder of a finished calibration (sits-mech calibrate); got {state}")
    data = read_table(path)
    if case is not None or data.attrs.get("request") in SWEPT:
        return _case(folder, data, case)
    missing = [name for name in _NEEDED if name not in data.variables]
    if missing:
        raise SceneError(f"{path}: must be the table of a calibration; {missing[0]} is missing")
    if data.attrs.get("version") != __version__:
        came = data.attrs.get("version", "an unknown one")
        raise SceneError(f"{folder}: must be a calibration by version {__version__}; got {came}: calibrate anew")
    sensor = load_sensor(folder / "scene.toml")
    if data.attrs.get("scene") != (folder / "scene.toml").read_text(encoding="utf-8"):
        raise SceneError(f"{folder}: scene.toml must be the scene of result.nc; it was changed: calibrate anew")
    if not data["status"].isin(ANSWERED).any():
        raise SceneError(f"{folder}: must hold at least one load that converged; got none")
    return sensor, data


def _case(folder: Path, data: xr.Dataset, case: int | None) -> tuple[Sensor, xr.Dataset]:
    """Return sensor and table of a case of a sweep, or refuse its number."""
    if data.attrs.get("request") not in SWEPT:
        raise SceneError(f"--case: must be of a sweep with request = {' or '.join(SWEPT)}; got {folder}")
    count = int(data["status"].size)
    if case is None or not 1 <= case <= count:
        came = "no --case" if case is None else f"--case {case}"
        what = f"quality and report take one of its cases, --case 1 to --case {count}"
        raise SceneError(f"{folder}: is the folder of a sweep: {what}; got {came}")
    row = list(points(data))[case - 1]
    if "load_status" not in row or not row["load_status"].isin(ANSWERED).any():
        why = row["reason"].item() or "no load converged"
        raise SceneError(f"{folder}: --case {case} must be a case with a table; it has none: {why}")
    if data.attrs.get("version") != __version__:
        came = data.attrs.get("version", "an unknown one")
        raise SceneError(f"{folder}: must be a sweep by version {__version__}; got {came}: sweep anew")
    return case_calibration(row)


def write_calibration(sensor: Sensor, data: xr.Dataset, folder: Path) -> list[str]:
    """Write a calibration's table, scene and pictures, each by an atomic rename.

    Parameters
    ----------
    sensor : Sensor
        What was calibrated.
    data : Dataset
        As from `calibrate`.
    folder : Path
        As from `prepare_folder`.

    Returns
    -------
    list of str
        One line for each picture that could not be drawn.
    """
    save_table(data, folder / "result.nc")
    write_text(folder / "result.csv", csv_text(data))
    save_sensor(sensor, folder / "scene.toml")
    if find_spec("matplotlib") is None:
        return ["no pictures: they need matplotlib: pip install 'sits-mech[view]'"]
    if not data["status"].isin(ANSWERED).any():
        return ["no pictures: no load converged"]
    pictures, warnings = calibration_pictures(data), []
    for name, draw in (pictures | {"layer": partial(_largest_load, sensor, data, folder)}).items():
        try:
            save_figure(draw(), folder / f"{name}.png")
        except (SolveFailed, SceneError) as error:
            warnings.append(f"no picture {name}.png: {error}")
    return warnings


def _largest_load(sensor: Sensor, data: xr.Dataset, folder: Path) -> Figure:
    """Return the picture of the layer under the largest of the loads that converged."""
    largest = {name: float(np.abs(data[name]).max()) or 1.0 for name in varied(data)}
    dims, done = data["status"].dims, np.argwhere(data["status"].isin(ANSWERED).to_numpy())
    each = zip(dims, done.T, strict=True)
    shares = np.transpose([data[name].to_numpy()[at] / largest[str(name)] for name, at in each])
    first = 1e-9 * shares @ 0.5 ** np.arange(len(dims))  # of mirror images the one with the positive forces
    at = done[int(np.argmax(np.sum(shares**2, axis=1) + first))]
    wrench = wrench_of(data[["status"]].isel(dict(zip(dims, at, strict=True))))
    request = json.loads(data.attrs["request"])
    mechanics, tolerance = request["mechanics"], request["tolerance"]
    drift = "slope_T_L" in data
    known = kept_rest((cases_folder(folder), kept_key(sensor, mechanics, tolerance, drift=drift)), wrench)
    return load_view(sensor, wrench, tolerance, mechanics, known)
