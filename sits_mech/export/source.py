"""Take a finished calibration to export: its sensor, its table, and the load of a single state."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from sits_mech.quantities import LOAD_ARGUMENTS, POSE, Pose, Wrench, shown_unit
from sits_mech.readout.loads import answered, fixed, load_words, request_of, varied
from sits_mech.scene.sensor import SceneError, Sensor


@dataclass(frozen=True)
class Source:
    """A calibration and a load."""

    sensor: Sensor
    data: xr.Dataset
    load: Wrench = Wrench()  # of a single state; a zero component is the table's own where that is constant

    @property
    def request(self) -> dict[str, Any]:
        """Return the request of the calibration: models, tolerance, forces."""
        return request_of(self.data)

    @property
    def about(self) -> str:
        """Return name, models and version in one line."""
        models = f"{self.request['mechanics']} mechanics, {self.request['magnetics']} magnetics"
        return f"{self.sensor.name}; {models}; sits-mech {self.data.attrs['version']}"


def resting_load(source: Source) -> Wrench:
    """Return the source's load with the table's constant components; raise SceneError outside the table."""
    found = {}
    for option, name in LOAD_ARGUMENTS.items():
        value, values = getattr(source.load, name), np.array([fixed(source.data).get(name, 0.0)])
        if name in source.data.dims:
            values = source.data[name].to_numpy()
        elif value == 0.0:
            value = float(values[0])
        if not values.min() <= value <= values.max():
            unit = shown_unit(name)
            ends = [f"{end:.4g} {unit}" for end in dict.fromkeys((values.min(), values.max()))]
            span = f"be {ends[0]}, as in the calibration"
            if len(ends) > 1:
                span = f"lie within the calibration, from {' to '.join(ends)}"
            raise SceneError(f"--{option}: must {span}; got {value:.4g} {unit}")
        found[name] = value
    return Wrench(**found)


def interpolated_pose(source: Source) -> Pose:
    """Return the pose under the source's load, linear between the table's loads.

    Raise SceneError when the load is outside the table, or next to one without a result.
    """
    load = resting_load(source)
    parts = source.data[[name for name in POSE if name in source.data]].where(answered(source.data))
    for name in varied(source.data):  # a force with one value has nothing between
        alone = parts.sizes[name] == 1
        parts = parts.isel({name: 0}) if alone else parts.interp({name: getattr(load, name)})
    found = Pose(**{str(name): float(value) for name, value in parts.items()})
    if not math.isfinite(float(found.d_h)):
        came = load_words({name: getattr(load, name) for name in varied(source.data)})
        raise SceneError(f"load: must have results on all sides in the calibration; got {came}")
    return found


def own_folder(path: Path, kind: str, endings: Sequence[str], stale: str = "*.none") -> None:
    """Make the folder of an export, without what is `stale` of an earlier one; raise SceneError where that fails."""
    if path.suffix in endings or path.is_file():
        raise SceneError(f"--output: must name a folder for --to {kind}; got {path.name!r}")
    try:
        path.mkdir(parents=True, exist_ok=True)
        for old in path.glob(stale):
            old.unlink()
    except OSError as error:
        raise SceneError(f"--output: must be writable; got: {error.strerror}: {path}") from None


def comment(text: str) -> str:
    """Return a text that may stand within a comment of C: neither begins nor ends one, and has no trigraph."""
    return " ".join(re.sub(r"(?<=\*)(?=/)|(?<=/)(?=\*)|(?<=\?)(?=\?)", " ", text).split())
