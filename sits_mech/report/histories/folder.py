"""Write a load history to a folder: history.nc, history.csv, codes.csv, scene.toml, a picture."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import xarray as xr

from sits_mech.cases import save_table
from sits_mech.report.histories.shown import codes_csv, history_csv, history_curves
from sits_mech.report.pictures.curves import save_figure
from sits_mech.scene.files import write_text
from sits_mech.scene.sensor import Sensor, save_sensor


def write_history(sensor: Sensor, data: xr.Dataset, folder: Path) -> list[str]:
    """Write a history's table, scene and picture, each by an atomic rename; return what could not be drawn."""
    save_table(data, folder / "history.nc")
    write_text(folder / "history.csv", history_csv(data))
    if "code" in data:
        write_text(folder / "codes.csv", codes_csv(data))
    save_sensor(sensor, folder / "scene.toml")
    if find_spec("matplotlib") is None:
        return ["no picture: it needs matplotlib: pip install 'sits-mech[view]'"]
    save_figure(history_curves(data), folder / "history.png")
    return []
