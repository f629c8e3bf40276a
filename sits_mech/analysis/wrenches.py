"""How do the coils answer each component of a load at rest? F_x, F_z, M_y, and by the scene turned, F_y and M_x.

    dL/dF = dL/d(pose) d(pose)/dF,    pose = (d_h, d_v, alpha),

the second factor the layer's compliance at small strain, the first a central difference of the magnetic model. The
components of the other plane are those of the scene turned by a quarter about z: coils, target and elastomer change x
with y. M_z turns the target about its own axis, which the models do not have: a disc shows nothing of it, nor does, to
first order, a target over coils that mirror each other. `components_resolved` says which components the coils resolve.
"""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from sits_mech.analysis.bench import free_inductances
from sits_mech.chain.models import magnetic_model, mechanical_model
from sits_mech.quantities import Array, MagneticModel, MechanicalModel, Pose, Wrench
from sits_mech.readout.observability import Observability, observability
from sits_mech.sensor import SceneError, Sensor

COMPONENTS = ("F_x", "F_z", "M_y", "F_y", "M_x")
"""Of a load [N, N m], as `wrench_slopes` orders them."""
_STEP = 2e-3  # of the distance to the coils: steps of the differences
_LOAD = 1e-3  # [N, N m / 1000]: small enough for small strain, large enough for rounding
_TOLERANCE = 1e-2  # of the field in space: slopes at rest decide between seen and hidden
_LEVER = 0.25  # of the target's sides: where the greatest normal force acts for the full scale of the moments


def turned(sensor: Sensor) -> Sensor:
    """Return the scene turned by a quarter about z: what acted along y acts along x."""
    if sensor.target is None or sensor.elastomer is None or sensor.target.shape == "outline" or sensor.conductors:
        needed = "must have a rectangle or disc on an elastomer, and no conductors"
        raise SceneError(f"{sensor.name}: {needed}, to be turned; got another scene")
    coils = tuple(coil.model_copy(update={"centre": (coil.centre[1], -coil.centre[0])}) for coil in sensor.coils)
    sizes = [{"width": part.length, "length": part.width} for part in (sensor.target, sensor.elastomer)]
    target = sensor.target.model_copy(update=sizes[0])
    elastomer = sensor.elastomer.model_copy(update=sizes[1])
    return sensor.model_copy(update={"coils": coils, "target": target, "elastomer": elastomer})


def wrench_slopes(
    sensor: Sensor, mechanics: Callable[[Sensor], MechanicalModel], magnetics: Callable[[Sensor], MagneticModel]
) -> Array:
    """Return the slopes of L over L0 by `COMPONENTS` at rest, shape (n, 5) [1/N, 1/(N m)].

    Parameters
    ----------
    sensor : Sensor
        With target and elastomer.
    mechanics, magnetics : callable
        Scene to model, such as ``lambda sensor: magnetic_model(sensor, "sheets")[0]``.

    Raises
    ------
    SceneError
        When the scene cannot be turned.
    """
    own = _plane(sensor, mechanics(sensor), magnetics(sensor))
    other = turned(sensor)
    across = _plane(other, mechanics(other), magnetics(other))
    return np.hstack([own, across[:, [0, 2]]])


def components_resolved(sensor: Sensor, data: xr.Dataset, noise: ArrayLike) -> Observability:
    """Return which of `COMPONENTS` the coils of a calibrated sensor resolve at rest, by the field in space.

    Parameters
    ----------
    sensor : Sensor
        What was calibrated.
    data : Dataset
        As from `calibrate`: its mechanics, and its greatest forces as full scale. F_y has that of F_x; a moment that of
        F_z acting a quarter of the target's side off its centre.
    noise : array_like, shape (n,)
        Standard deviation of each inductance [H].

    Raises
    ------
    SceneError
        When the scene cannot be turned, or the table has no F_x or F_z.
    """
    if sensor.target is None:
        raise SceneError(f"{sensor.name}: target: must be given to bear a load; it is missing")
    request = json.loads(data.attrs["request"])
    F_x, F_z = (float(np.abs(data[name]).max()) for name in ("F_x", "F_z"))
    if not (F_x > 0.0 and F_z > 0.0):
        raise SceneError(f"table: must reach beyond zero in F_x and F_z; got {F_x:g} and {F_z:g} N")
    width, length = sensor.target.extent
    slopes = wrench_slopes(
        sensor,
        lambda scene: mechanical_model(scene, request["mechanics"], request["tolerance"])[0],
        lambda scene: magnetic_model(scene, "sheets", _TOLERANCE)[0],
    )
    full_scale = [F_x, F_z, _LEVER * width * F_z, F_x, _LEVER * length * F_z]
    return observability(COMPONENTS, slopes, np.asarray(noise, dtype=float) / free_inductances(sensor), full_scale)


def _plane(sensor: Sensor, layer: MechanicalModel, field: MagneticModel) -> Array:
    """Return the slopes by F_x, F_z and the moment of one plane, shape (n, 3)."""
    rest = layer.equilibrium(Wrench()).pose
    at_rest = np.array([rest.d_h, rest.d_v, rest.alpha], dtype=float)
    loads = np.array([_LOAD, _LOAD, 1e-3 * _LOAD])
    moved = [layer.equilibrium(Wrench(*(loads * (np.arange(3) == k)))).pose for k in range(3)]
    compliance = np.array([[p.d_h, p.d_v, p.alpha] for p in moved], dtype=float) - at_rest
    width = 1.0 if sensor.target is None else sensor.target.extent[0]
    steps = _STEP * at_rest[1] * np.array([1.0, 1.0, 2.0 / width])
    stack = np.repeat(at_rest[None], 6, axis=0)
    for k in range(3):
        stack[2 * k, k] += steps[k]
        stack[2 * k + 1, k] -= steps[k]
    shown = field.impedance(Pose(*stack.T), sensor.frequency)
    L = np.diagonal(shown.L, axis1=-2, axis2=-1) / np.diagonal(shown.L0)
    by_pose = (L[::2] - L[1::2]) / (2.0 * steps[:, None])
    return np.asarray(((compliance / loads[:, None]) @ by_pose).T)
