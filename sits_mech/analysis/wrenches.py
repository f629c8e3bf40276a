"""Differentiate the coils' inductances by each of the six components of a load, at rest.

    dL/dF = dL/d(pose) d(pose)/dF,    pose = (d_h, d_v, alpha, d_y, alpha_x, alpha_z),

both by central differences: of the field in space (`pose_slopes`), and of the pad under loads so small that its strain
is. No symmetry is assumed: where the scene is its own image in y = 0, what F_y, M_x and M_z do comes out as rounding.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from sits_mech.analysis.readings.bench import self_inductances
from sits_mech.chain.models import magnetic_model, mechanical_model
from sits_mech.magnetics.pose_slopes import pose_slopes
from sits_mech.quantities import POSE, WRENCH, Array, MagneticModel, MechanicalModel, Pose, Wrench
from sits_mech.readout.loads import request_of
from sits_mech.readout.observability import Observability, observability
from sits_mech.scene.sensor import SceneError, Sensor

_LOAD = 1e-3  # [N, N m / 1000]: small enough for small strain, large enough for rounding
_TOLERANCE = 1e-2  # of the field in space: slopes at rest decide between seen and unseen
_LEVER = 0.25  # of the target's sides: where the greatest force acts for the full scale of a moment


def wrench_slopes(sensor: Sensor, pad: MechanicalModel, field: MagneticModel) -> Array:
    """Return the slopes of L over L0 by the components of `WRENCH` at rest, shape (n, 6) [1/N, 1/(N m)].

    `pad` and `field` take wrenches and poses that leave the plane y = 0.
    """
    loads = np.where([name.startswith("F") for name in WRENCH], _LOAD, 1e-3 * _LOAD)
    up, down = (np.array([pad.equilibrium(Wrench(*load)).pose.components for load in np.diag(sign * loads)])
                for sign in (1.0, -1.0))
    compliance = (up - down) / (2.0 * loads[:, None])
    rest = Pose.of(pad.equilibrium(Wrench()).pose.components[None])
    found, by_pose, _ = pose_slopes(sensor, field, rest, sensor.frequency, POSE)
    return np.asarray(np.einsum("ccp,wp->cw", by_pose[0], compliance) / np.diag(found.L0)[:, None])


def resolved_components(sensor: Sensor, data: xr.Dataset, noise: ArrayLike) -> Observability:
    """Return which components of `WRENCH` the coils of a calibrated sensor resolve at rest, in space.

    `data` gives the tolerance and the greatest loads as full scale. Where it has none, a shear force has that of the
    other one, or of F_z, and F_z that of shear; a moment has that of a force a quarter of the target's side off its
    centre: F_z, for M_z shear. `noise` (n,) is the deviation of each inductance [H]. Raises SceneError when the models
    in space cannot hold the scene, or the table has no force.
    """
    if sensor.target is None:
        raise SceneError(f"{sensor.name}: target: must be given to bear a load; it is missing")
    extent, sensor = sensor.target.extent, sensor.model_copy(update={"touch": None})  # components are of a wrench
    pad = mechanical_model(sensor, "block", request_of(data)["tolerance"])[0]
    slopes = wrench_slopes(sensor, pad, magnetic_model(sensor, "sheets", _TOLERANCE)[0])
    noise = np.asarray(noise, dtype=float) / self_inductances(sensor)
    return observability(WRENCH, slopes, noise, _full_scale(data, extent))


def _full_scale(data: xr.Dataset, extent: tuple[float, float]) -> list[float]:
    """Return the full scale of each component [N, N m]."""
    largest = {name: float(np.abs(data[name]).max()) for name in WRENCH if name in data.dims}
    side = max(largest.get(name, 0.0) for name in ("F_x", "F_y"))
    side, down = side or largest.get("F_z", 0.0), largest.get("F_z", 0.0) or side
    if not side > 0.0:
        raise SceneError("table: must reach beyond zero in a force; got none")
    width, length = (_LEVER * part for part in extent)
    usual = Wrench(side, down, width * down, side, length * down, max(width, length) * side)
    return [largest.get(name, 0.0) or getattr(usual, name) for name in WRENCH]
