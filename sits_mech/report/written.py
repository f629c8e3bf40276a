"""Write a calibration to a folder: result.nc, result.csv, scene.toml, pictures, finished loads."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from sits_mech.analysis.readings.bench import with_terminals
from sits_mech.labels import labelled
from sits_mech.mechanics.loads import kept_key, kept_rest
from sits_mech.readout.loads import answered, request_of, varied, wrench_of
from sits_mech.report.folder import cases_folder
from sits_mech.report.pictures.section import load_view
from sits_mech.report.pictures.style import save_figures
from sits_mech.report.plots.curves import calibration_pictures
from sits_mech.report.tables.loads import csv_text
from sits_mech.scene.files import write_text
from sits_mech.scene.sensor import Sensor, save_sensor
from sits_mech.store import save_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_calibration(sensor: Sensor, data: xr.Dataset, folder: Path, *, layer: bool = True) -> list[str]:
    """Write a calibration's table, scene and pictures, each by an atomic rename; that of the `layer` may be left out.

    Return one line for each picture that could not be drawn.
    """
    data = labelled(with_terminals(sensor, data))
    save_table(data, folder / "result.nc")
    write_text(folder / "result.csv", csv_text(data))
    save_sensor(sensor, folder / "scene.toml")
    if not answered(data).any():
        return ["no pictures: no load converged"]
    pictures = calibration_pictures(data)
    if layer:
        pictures["layer"] = partial(_largest_load, sensor, data, folder)
    return save_figures(folder, pictures)


def _largest_load(sensor: Sensor, data: xr.Dataset, folder: Path) -> Figure:
    """Return the picture of the layer under the largest of the loads that converged."""
    largest = {name: float(np.abs(data[name]).max()) or 1.0 for name in varied(data)}
    dims, done = data["status"].dims, np.argwhere(answered(data).to_numpy())
    each = zip(dims, done.T, strict=True)
    shares = np.transpose([data[name].to_numpy()[at] / largest[str(name)] for name, at in each])
    first = 1e-9 * shares @ 0.5 ** np.arange(len(dims))  # of mirror images the one with the positive forces
    at = done[int(np.argmax(np.sum(shares**2, axis=1) + first))]
    wrench = wrench_of(data[["status"]].isel(dict(zip(dims, at, strict=True))))
    request = request_of(data)
    mechanics, tolerance = request["mechanics"], request["tolerance"]
    drift = "slope_T_L" in data
    known = kept_rest((cases_folder(folder), kept_key(sensor, mechanics, tolerance, drift=drift)), wrench)
    return load_view(sensor, wrench, tolerance, mechanics, known)
