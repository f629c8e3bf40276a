"""Calculate slopes by temperature over a table, cause by cause, and move tables along them.

At a load held, by each cause c of scene/thermal.py alone, T the temperature of the scene,

    slope_T_L_by = dL/dT_c,    slope_T_L = sum over the causes,    slope_T_d_h, ... of the pose alike,

derivatives of the whole chain (gradient.py): the pad's expansion and its modulus move the target, what metal conducts,
plates and board change the coils where it stands. The capacitor and the clock change no inductance but what is read for
one: the tank at 20 degC that would swing as fast, over the clock, has

    d ln L_read = d ln L + d ln C + 2 d ln f_clock,    d ln R_read = d ln R + d ln C + d ln f_clock,

and so they stand in ``slope_T_L_by`` and ``slope_T_R_by``, not in ``slope_T_L``; R with the tracks' direct-current
resistance. `at_other_temperature` moves a table along its slopes: a calibration at a temperature is a calibration, and
its codes follow from L and R. Straight lines leave a remainder, second derivatives (a gap that closes over 40 K, a dT
of what resistivity changes): `read_at` solves the sensor itself at the load found F_k and T, and

    F_k+1 = inverse(L_table + slope dT + r_k, reading),    r_k = L_read(F_k, T) - (L_table + slope dT)(F_k),

R alike, three solves at most, each of which leaves of an error the share that slopes by force are off by. What the
last one changed is the error. Neglected: slopes of mutual inductances, and of tables per metre the growth of a coil's
own L0 with its board (no change of shape), by which henries and codes grow but not shares of free space.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from sits_mech.chain.columns import Columns
from sits_mech.chain.derivatives.fixed_pose import at_fixed_poses
from sits_mech.chain.derivatives.gradient import Moved, gradient, moved_derivatives, shown_change
from sits_mech.chain.propagation import poses_of
from sits_mech.chain.simulate import simulate
from sits_mech.geometry.windings import unnamed
from sits_mech.magnetics.coils.loops import free_inductances
from sits_mech.magnetics.coils.resistance import track_resistance
from sits_mech.maps.surrogate import fit_map
from sits_mech.quantities import POSE, Array, Equilibrium, Impedance, MagneticModel, Pose, SolveFailed, Wrench
from sits_mech.readout.calibration import OK, calibration, own_values
from sits_mech.readout.inversion import Inverse
from sits_mech.readout.loads import load_words, request_of, several, varied, wrench_of
from sits_mech.scene.parameters import TEMPERATURE, Parameter
from sits_mech.scene.sensor import REFERENCE, SceneError, Sensor
from sits_mech.scene.thermal import CAUSES, at_temperature, celsius, check_temperature, clock_factor

CHAINED = tuple(TEMPERATURE + cause for cause in CAUSES if cause not in ("capacitor", "clock"))
"""Parameters of the causes that change inductances."""
_SOLVES = 3  # of a reading at another temperature
_SETTLED = 0.1  # of a force's errors by map and table: what less changes is not solved again


def slopes_by_temperature(
    sensor: Sensor, model: tuple[MagneticModel, str, float], numbers: tuple[Sequence[Parameter], Sequence[Parameter]],
    shown: Impedance, rests: Sequence[Equilibrium],
) -> Columns:
    """Return the slopes of p loads by temperature, as columns of a table.

    ``slope_T_L``, (p, coil), ``slope_T_L_by``, (p, thermal_cause, coil) [H/K or H/m/K], ``slope_T_R_by`` likewise
    [ohm/K or ohm/m/K], ``slope_T_d_h``, ..., (p,) [m/K, rad/K]. `model` comes with its name and tolerance; `numbers`
    are those of `CHAINED` and which of them move the target; `rests` hold the slopes of the loads' poses.
    """
    (every, moving), pose = numbers, Pose.of(poses_of(rests).value)
    own = np.array([rest.slopes.T for rest in rests]).reshape(len(rests), len(POSE), len(moving))
    moved = moved_derivatives(every, moving, Moved(own, np.zeros_like(own)))
    direct = at_fixed_poses(sensor, model, pose, every)
    change, read = shown_change(sensor, model[0], shown, pose, every, moved, direct), _read(sensor)[:, None]
    tracks = _tracks(sensor, shown)
    L, R = np.einsum("pii->pi", shown.L), np.einsum("pii->pi", shown.R) + tracks
    by_L, by_R = (np.einsum("piin->pni", part) for part in (change.L, change.R))
    for k, number in enumerate(every):
        stencil = number.stencil()
        there = [place.weight * _tracks(place.sensor, shown) for place in stencil.places]
        by_R[:, k] += stencil.own * tracks + np.sum(there, axis=0)
    found: Columns = {"slope_T_L": (("coil",), by_L.sum(axis=1))}
    for name, own, whole, share in (("L", L, by_L, read), ("R", R, by_R, read * [[1.0], [0.5]])):
        by_cause = np.concatenate([whole, own[:, None] * share], axis=1)
        found[f"slope_T_{name}_by"] = (("thermal_cause", "coil"), by_cause)
    return found | {f"slope_T_{name}": ((), moved.pose[:, k].sum(axis=1)) for k, name in enumerate(POSE)}


def relative_slopes(
    sensor: Sensor, wrench: Wrench, *, tolerance: float = 1e-2, mechanics: str = "auto", magnetics: str = "auto"
) -> Array:
    """Return d ln L/dT as read, of each coil by each of `CAUSES`, shape (cause, coil) [1/K].

    Arguments and errors as `gradient`.
    """
    found = gradient(sensor, wrench, CHAINED, tolerance=tolerance, mechanics=mechanics, magnetics=magnetics)
    L = np.diagonal(found.simulation.impedance.L)
    change = np.einsum("iin->ni", found.L) / L
    return np.concatenate([change, np.broadcast_to(_read(sensor)[:, None], (2, len(L)))])


def _tracks(sensor: Sensor, shown: Impedance) -> Array:
    """Return the direct-current resistance of the tracks in the unit of an impedance, (n,) [ohm or ohm/m]."""
    coils = at_temperature(sensor).coils
    R = np.array([*map(track_resistance, unnamed(coils))])
    return R if shown.unit_L == "H" else R * np.diagonal(shown.L0) / np.diagonal(free_inductances(coils))


def _read(sensor: Sensor) -> Array:
    """Return the relative slopes of a read inductance by capacitor and clock, shape (2,) [1/K]."""
    parts, dT = sensor.readout, sensor.temperature - REFERENCE
    C = parts.capacitance_coefficient / (1.0 + parts.capacitance_coefficient * dT)
    return np.array([C, 2.0 * parts.clock_coefficient / clock_factor(sensor)])


def read_slopes(sensor: Sensor, L: Array, by_cause: Array) -> Array:
    """Return the whole slope of read inductances (..., n), from those of `CHAINED`, (c, ..., n) [H/K]."""
    return np.asarray(by_cause.sum(axis=0) + L * _read(sensor).sum())


def has_slopes(data: xr.Dataset) -> bool:
    """Return whether a table was made with its slopes by temperature."""
    return "slope_T_L" in data


def at_other_temperature(sensor: Sensor, data: xr.Dataset, temperature: float) -> xr.Dataset:
    """Return a table from `calibrate` with ``drift``, moved along its slopes to what is read at a temperature [K].

    Raises SceneError where the table has no slopes, or something of the sensor is not known at the temperature.
    """
    dT = temperature - sensor.temperature
    if dT == 0.0:
        return data
    if not has_slopes(data):
        raise SceneError(f"temperature: must be {celsius(sensor.temperature)}, that of the calibration, which was made "
                         f"without --drift; got {celsius(temperature)}")
    check_temperature(sensor, temperature)
    return changed_by(data, [dT * step.sum("thermal_cause") for step in slopes_of(data)])


def slopes_of(data: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Return the slopes of L and R by cause; those of R are zero in tables that were made without."""
    by_L = data["slope_T_L_by"]
    return by_L, data.get("slope_T_R_by", xr.zeros_like(by_L))


def changed_by(data: xr.Dataset, steps: Sequence[xr.DataArray]) -> xr.Dataset:
    """Return a table whose coils' own L and R are larger by steps."""
    same = xr.DataArray(np.eye(data.sizes["coil"]), dims=("coil", "coil_2"),
                        coords={name: data[name] for name in ("coil", "coil_2")})
    each = zip(("L", "R"), steps, strict=True)
    return data.assign({name: (data[name] + step * same).transpose(*data[name].dims) for name, step in each})


def read_at(
    sensor: Sensor, data: xr.Dataset, temperature: float, inverse: Callable[[xr.Dataset], Inverse]
) -> tuple[xr.Dataset, Array]:
    """Return a table at another temperature, exact near the load of a reading, and the last correction of the forces.

    `inverse` gives the forces of the one reading by a table. The correction, shape (d,) [N, N m], is zero at the
    temperature of the calibration and NaN where the reading has no force there. Raises SceneError as
    `at_other_temperature`, and where the sensor has no answer at load and temperature, or corrections grow.
    """
    moved = found = at_other_temperature(sensor, data, temperature)
    answer = inverse(found)
    if temperature == sensor.temperature:
        return data, np.zeros(np.shape(answer.forces))
    known, before, last = calibration(moved), None, np.full(np.shape(answer.forces), np.inf)
    for _ in range(_SOLVES):
        # a reading of no load of the straight lines may be of one all the same: then by the middle of the table
        load = answer.forces if answer.status == OK else 0.5 * (known.low + known.high)
        if before is not None and np.array_equal(load, before):
            break
        found, before = changed_by(moved, _remainder(sensor, moved, temperature, load)), load
        was, old, answer = last, answer.forces, inverse(found)
        last = np.abs(answer.forces - old)
        by_model = np.where(answer.error_by_model <= known.high - known.low, answer.error_by_model, 0.0)
        errors = answer.error + by_model  # beyond the range it says nothing of how often to solve
        if np.all(last < _SETTLED * errors):
            break
    if answer.status == OK and not np.all(last <= np.fmax(was, errors)):
        raise SceneError(f"temperature: must be nearer to {celsius(sensor.temperature)}, that of the calibration; got "
                         f"{celsius(temperature)}, where corrections of the load do not settle")
    return found, last


def _remainder(sensor: Sensor, moved: xr.Dataset, temperature: float, load: Array) -> list[xr.DataArray]:
    """Return L and R as read of each coil at a load less the table moved along its slopes, over ``coil``."""
    request = request_of(moved)
    warm = sensor.model_copy(update={"temperature": temperature})
    one = moved.isel({name: 0 for name in varied(moved)})
    maps = [fit_map(*own_values(moved, name)) for name in ("L", "R")]
    forces = dict(zip(several(moved), load.tolist(), strict=True))
    models = {name: request[name] for name in ("mechanics", "magnetics", "tolerance")}
    try:
        solved = simulate(warm, replace(wrench_of(one), **forces), **models)
    except (SolveFailed, ValueError) as error:
        raise SceneError(f"temperature: must be one at which the sensor can be solved; got {celsius(temperature)} with "
                         f"{load_words(forces)}: {error}") from error
    C = [at_temperature(one).readout.parallel_capacitance for one in (warm, sensor)]
    shown, clock = solved.impedance, clock_factor(warm) / clock_factor(sensor)
    L, R = np.diagonal(shown.L) * clock**2, (np.diagonal(shown.R) + _tracks(warm, shown)) * clock
    read = C[0] / C[1] * L, C[0] / C[1] * R - _tracks(sensor, shown)
    each = zip(read, maps, strict=True)
    return [xr.DataArray(one - own.at(load), dims="coil", coords={"coil": moved["coil"]}) for one, own in each]
