"""What is exported? A finished calibration: its sensor, its table, and the load that a single state is taken at."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import xarray as xr

from sits_mech.cases import DONE
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import SceneError, Sensor


@dataclass(frozen=True)
class Source:
    """A calibration and a load.

    Attributes
    ----------
    sensor : Sensor
        What was calibrated.
    data : Dataset
        As from `calibrate`.
    F_x, F_z : float
        The load of what shows a single state [N].
    """

    sensor: Sensor
    data: xr.Dataset
    F_x: float = 0.0
    F_z: float = 0.0

    @property
    def request(self) -> dict[str, Any]:
        """What was asked of the calibration: models, tolerance, forces."""
        found = json.loads(self.data.attrs["request"])
        return found if isinstance(found, dict) else {}

    @property
    def about(self) -> str:
        """One line: name, models, version."""
        models = f"{self.request['mechanics']} mechanics, {self.request['magnetics']} magnetics"
        return f"{self.sensor.name}; {models}; sits-mech {self.data.attrs['version']}"


def resting_pose(source: Source) -> Pose:
    """Return where the target rests under the source's load, linear between the loads of the table.

    Raises
    ------
    SceneError
        When the load is outside the table, or next to one without a result.
    """
    for name in ("F_x", "F_z"):
        force, forces = getattr(source, name), source.data[name].to_numpy()
        if not forces.min() <= force <= forces.max():
            option = f"--{name.replace('_', '').lower()}"
            span = f"from {forces.min():.4g} N to {forces.max():.4g} N"
            raise SceneError(f"{option}: must lie within the calibration, {span}; got {force:.4g} N")
    parts = source.data[["d_h", "d_v", "alpha"]].where(source.data["status"] == DONE)
    for name in ("F_x", "F_z"):  # a force with one value has nothing between
        force = getattr(source, name)
        parts = parts.isel({name: 0}) if parts.sizes[name] == 1 else parts.interp({name: force})
    found = Pose(*(float(parts[name]) for name in ("d_h", "d_v", "alpha")))
    if not math.isfinite(float(found.d_h)):
        came = f"F_x = {source.F_x:.4g} N, F_z = {source.F_z:.4g} N"
        raise SceneError(f"load: must have results on all sides in the calibration; got {came}")
    return found
