"""How does what a sensor shows change with its temperature, and which part of it is to blame? Slopes over a table.

At a load held, by each cause c of scene/thermal.py alone, T the temperature of the scene,

    slope_T_L_by = dL/dT_c,    slope_T_L = sum over the causes,    slope_T_d_h, ... of the pose alike,

derivatives of the whole chain (gradient.py): the pad's expansion and its modulus move the target, what metal conducts,
plates and board change the coils where it stands. The capacitor and the clock change no inductance but what is read for
one: with 1/((2 pi f)^2 C) taken at 20 degC,

    d ln L_read = d ln L + d ln C + 2 d ln f_clock,

and so stand in ``slope_T_L_by``, not in ``slope_T_L``. `at_other_temperature` moves a table along its slopes: a
calibration at a temperature is a calibration. Neglected there: second derivatives (the resistivity's share is some
a dT of what it changes) and slopes of mutual inductances.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from sits_mech.chain.fixed_pose import at_fixed_poses
from sits_mech.chain.gradient import Moved, columns_of, gradient, shown_change
from sits_mech.mechanics.loads import slopes_of
from sits_mech.quantities import POSE, Array, Impedance, MagneticModel, Pose, Wrench
from sits_mech.scene.parameters import TEMPERATURE, Parameter
from sits_mech.scene.sensor import REFERENCE, SceneError, Sensor
from sits_mech.scene.thermal import CAUSES, celsius, check_temperature, clock_factor

CHAINED = tuple(TEMPERATURE + cause for cause in CAUSES if cause not in ("capacitor", "clock"))
"""Parameters of the causes that change inductances."""


def slopes_by_temperature(
    sensor: Sensor, model: tuple[MagneticModel, str, float], shown: Impedance, pose: Pose,
    numbers: tuple[Sequence[Parameter], Sequence[Parameter]], rows: Sequence[dict[str, object]],
) -> dict[str, Array]:  # fmt: skip
    """Return the slopes of p loads, by the names of a table's variables.

    Parameters
    ----------
    sensor : Sensor
    model : MagneticModel, str and float
        Of it, the model's name and its tolerance.
    shown : Impedance
        Of p poses.
    pose : Pose of ndarray, shape (p,)
    numbers : two sequences of Parameter
        Those of `CHAINED`, and which of them move the target.
    rows : sequence of dict
        Of the loads, with the slopes of their poses.

    Returns
    -------
    dict of ndarray
        ``slope_T_L``, (p, coil) [H/K or H/m/K], ``slope_T_L_by``, (p, thermal_cause, coil), and ``slope_T_d_h``, ...
        (p,) [m/K, rad/K].
    """
    every, moving = numbers
    own = np.array([slopes_of(row).T for row in rows]).reshape(len(rows), len(POSE), len(moving))
    moved = columns_of(every, moving, Moved(own, np.zeros_like(own)))
    direct = at_fixed_poses(sensor, model, pose, every)
    change = np.einsum("piin->pni", shown_change(sensor, model[0], shown, pose, every, moved, direct).L)
    L = np.einsum("pii->pi", shown.L)
    by_cause = np.concatenate([change, L[:, None] * _read(sensor)[:, None]], axis=1)
    found = {"slope_T_L": change.sum(axis=1), "slope_T_L_by": by_cause}
    return found | {f"slope_T_{name}": moved.pose[:, k].sum(axis=1) for k, name in enumerate(POSE)}


def relative_slopes(
    sensor: Sensor, wrench: Wrench, *, tolerance: float = 1e-2, mechanics: str = "auto", magnetics: str = "auto"
) -> Array:
    """Return d ln L/dT of what is read for each coil's inductance by each of `CAUSES`, shape (cause, coil) [1/K].

    Arguments and errors as of `gradient`.
    """
    found = gradient(sensor, wrench, CHAINED, tolerance=tolerance, mechanics=mechanics, magnetics=magnetics)
    L = np.diagonal(found.simulation.impedance.L)
    change = np.einsum("iin->ni", found.L) / L
    return np.concatenate([change, np.broadcast_to(_read(sensor)[:, None], (2, len(L)))])


def _read(sensor: Sensor) -> Array:
    """Relative change of what is read for an inductance by the capacitor and by the clock, shape (2,) [1/K]."""
    parts, dT = sensor.readout, sensor.temperature - REFERENCE
    C = parts.capacitance_coefficient / (1.0 + parts.capacitance_coefficient * dT)
    return np.array([C, 2.0 * parts.clock_coefficient / clock_factor(sensor)])


def read_slopes(sensor: Sensor, L: Array, by_cause: Array) -> Array:
    """Return the whole slope of what is read for inductances (..., n), from those of `CHAINED`, (c, ..., n) [H/K]."""
    return np.asarray(by_cause.sum(axis=0) + L * _read(sensor).sum())


def has_slopes(data: xr.Dataset) -> bool:
    """Say whether a table was made with its slopes by temperature."""
    return "slope_T_L" in data


def at_other_temperature(sensor: Sensor, data: xr.Dataset, temperature: float) -> xr.Dataset:
    """Return a table moved along its slopes: what is read for inductances at another temperature of the sensor [K].

    Parameters
    ----------
    sensor : Sensor
        What was calibrated.
    data : Dataset
        As from `calibrate` with ``drift``.
    temperature : float
        [K].

    Raises
    ------
    SceneError
        Where the table has no slopes, or something of the sensor is not known at the temperature.
    """
    dT = temperature - sensor.temperature
    if dT == 0.0:
        return data
    if not has_slopes(data):
        raise SceneError(f"temperature: must be {celsius(sensor.temperature)}, that of the calibration, which was made "
                         f"without --drift; got {celsius(temperature)}")  # fmt: skip
    check_temperature(sensor, temperature)
    n = len(sensor.coils)
    step = data["slope_T_L_by"].sum("thermal_cause") * dT
    same = xr.DataArray(np.eye(n), dims=("coil", "coil_2"), coords={"coil": data["coil"], "coil_2": data["coil_2"]})
    L = data["L"] + step * same
    return data.assign(L=L.transpose(*data["L"].dims))
