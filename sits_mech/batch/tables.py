"""Convert a calibration to a row of a study's table, and back."""

from __future__ import annotations

import json
import tomllib
from typing import TYPE_CHECKING

from sits_mech.labels import labelled
from sits_mech.quantities import WRENCH
from sits_mech.readout.loads import answered
from sits_mech.readout.signals import COMBINED
from sits_mech.scene.sensor import Sensor, sensor_from
from sits_mech.status import marked
from sits_mech.store import Row

if TYPE_CHECKING:
    import xarray as xr

SWEPT = ("calibrate", "quality")
"""Requests of a study whose cases are calibrations."""
_OWN, _OF_LOADS = {"status", "flags", "reason", "seconds"}, "load_"  # what cases have too; of their loads


def table_row(data: xr.Dataset) -> Row:
    """Return a calibration as a row; `case_calibration` makes it a calibration again."""
    row: Row = {
        f"{_OF_LOADS}{name}" if name in _OWN else str(name): (tuple(map(str, item.dims)), item.to_numpy())
        for name, item in data.data_vars.items()
    }
    failed, size = int((~answered(data)).sum()), data["status"].size
    row |= {"failed_loads": failed, "unit_L": data.attrs["unit_L"], "left_out": data.attrs.get("left_out", "")}
    row |= marked(word for text in data["flags"].to_numpy().ravel() for word in text.split("; "))
    row |= {"reason": f"{failed} of {size} loads"} if failed else {}
    return row | {"attributes": json.dumps(dict(data.attrs), default=float)}


def case_calibration(row: xr.Dataset) -> tuple[Sensor, xr.Dataset]:
    """Return sensor and calibration of a case, a point of the table of a study with a request of `SWEPT`."""
    import xarray as xr

    attributes = json.loads(row["attributes"].item())
    asked = json.loads(attributes["request"])
    axes = {name: asked[name] for name in WRENCH if name in asked}
    loads = set(row[f"{_OF_LOADS}status"].dims)
    sensor = sensor_from(tomllib.loads(attributes["scene"]))
    coils = sensor.coil_names
    row = row.isel(coil=slice(len(coils)), coil_2=slice(len(coils)))  # another case may have more
    found = {str(name): item for name, item in row.data_vars.items() if loads <= set(item.dims) or name == "L0"}
    names = {name.removeprefix(_OF_LOADS): (item.dims, item.to_numpy()) for name, item in found.items()}
    data = xr.Dataset(names, {"coil": coils, "coil_2": coils, **axes}, attributes)
    parts = [name for name in ("part", "cause") if name in data.dims]
    for name in parts:  # of which as well
        data = data.dropna(name, how="all", subset=[key for key in data if name in data[key].dims])
    pair = COMBINED * (len(coils) > 2)  # of another case
    data = data.drop_vars([name for name in data if any(f"_{own}" in f"_{name}" for own in pair)])
    return sensor, labelled(data)
