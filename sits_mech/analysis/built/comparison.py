"""Compare a measurement with the model, and fit the few physical parameters that bring them together.

    L_i(F) = L_map,i(F / s) + L_i(pose + moved, scene + changed) - L_i(pose, scene),    pose = map(F / s),

    s   modulus of the silicone over the scene's

or, where stages have set poses, the model there. What may be moved and changed, and what leads and tank add, is in
`setup`. A hyperelastic layer under dead loads, all of whose moduli are s times as large, rests under F where it rested
under F / s: no layer is solved again. What is per metre of depth is taken relative to free space (`bench`): its scale
then is part of the misfit. Inductances are those at the terminals, with leads and idle coils; with nothing moved they
are the table's own. Loads F / s may leave the table while the map can be followed: its first missing term, of the size
of its error e on [-1, 1], is e T_(P+1)(x) beyond, and may be 5 e.
Neglected: that a gap of adhesive also changes the layer; rate, friction, temperature.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from sits_mech.analysis.bench import sensor_front_end, table_impedance
from sits_mech.analysis.built.setup import Setup, checked, shown_inductances
from sits_mech.chain.models import loaded_model, magnetic_model
from sits_mech.maps.fit import Free, Model, ParameterFit, fit_parameters, profile
from sits_mech.maps.surrogate import SmoothMap, fit_map
from sits_mech.quantities import POSE, Array, MagneticModel, Pose, shown_unit
from sits_mech.readout.loads import points, several, varied, wrench_of
from sits_mech.readout.measured import Measured, Tank
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.status import ANSWERED

USUAL = ("modulus", "gap", "lead")
"""What is fitted of a bench of loads unless it is said."""
_MISSING = 5.0  # of the map's error: what its first missing term may be beyond the table
_MODULI = (0.02, 10.0)  # least and greatest factor


@dataclass(frozen=True)
class Comparison:
    """A measurement beside the model, with the fitted parameters."""

    measured: Measured
    fit: ParameterFit  # in SI
    free: tuple[Free, ...]  # with what was known of each beforehand
    model: Model  # parameters (k, p) to inductances (k, m, n) [H]
    noise: float | None  # of a reading [H]
    predicted: Array  # (m, n), by the scene as it is [H]
    shear_modulus: float  # at small strain, as fitted [Pa]
    map_error: float  # between the table's loads, over each coil's range; 0 for measured poses

    def profile(self, name: str, points: int = 9, reach: float = 1.5) -> tuple[Array, Array]:
        """Return values of a parameter, and the rise of chi^2 without its own term there (`maps.fit.profile`).

        The rise is over the fit's variance; values go `reach` half-widths to both sides of the best. Raises SceneError
        when the noise is not known, or the measurement does not determine the parameter.
        """
        place = self.fit.names.index(name)
        best, width = float(self.fit.values[place]), float(self.fit.half_widths[place])
        if self.noise is None or not np.isfinite(width):
            raise SceneError(f"profile: {name}: must have a half-width, and the noise be given; got none")
        values = best + width * np.linspace(-reach, reach, points)
        rise = profile(self.model, self.measured.L, self.free, self.fit, name, noise=self.noise, values=values)
        return values, rise / self.fit.variance


def tank_of(sensor: Sensor, data: xr.Dataset, clock: float | None = None) -> Tank | None:
    """Return the scene's converter set for a table, as a tank from inductances to codes; None where it has no settings.

    `clock` is external [Hz], by default the part's greatest.
    """
    try:
        front, _ = sensor_front_end(sensor, data, clock=clock)
    except ValueError:
        if clock is not None:
            raise
        return None
    return Tank(front.part, sensor.readout.parallel_capacitance, front.reference, front.input_divider)


def compare(
    sensor: Sensor, data: xr.Dataset | None, measured: Measured, free: Sequence[str] = USUAL, *,
    noise: float | None = None, magnetics: str = "auto", tolerance: float = 1e-3,
) -> Comparison:
    """Return a measurement beside the model, and the parameters that bring them together.

    `data` is from `calibrate` and reaches as far as the measured loads over the modulus to be found, or nearly; None
    for measured poses. `free` are names of `setup` or keys of the scene with what is known: ``"gap = 0 +- 0.3 mm"``; it
    is weighed against `noise`, the deviation of a reading [H]. Raises SceneError for an unknown parameter, a table that
    is too small, or a value at the end of its reach.
    """
    known = checked(sensor, free, measured.poses is not None)
    setup = Setup(sensor, known, _maker(data, measured, magnetics, tolerance))
    if measured.poses is not None:
        return _of_poses(setup, measured, measured.poses, noise)
    if data is None:
        raise SceneError(f"{measured.source}: loads must come with a calibration; got a scene alone")
    return _of_loads(setup, data, measured, noise)


def _maker(
    data: xr.Dataset | None, measured: Measured, magnetics: str, tolerance: float
) -> Callable[[Sensor], MagneticModel]:
    """Return a function that makes the magnetic model of a scene: the table's, or that of the poses."""
    if data is not None:
        request = json.loads(data.attrs["request"])
        loads = [wrench_of(row) for row in points(data)]
        return lambda scene: loaded_model(scene, request["magnetics"], request["tolerance"], loads)[0]
    poses = np.zeros((0, len(POSE))) if measured.poses is None else measured.poses
    there = [Pose.of(row) for row in poses if np.all(np.isfinite(row))]
    return lambda scene: magnetic_model(scene, magnetics, tolerance, there)[0]


def _of_poses(setup: Setup, measured: Measured, poses: Array, noise: float | None) -> Comparison:
    """Compare readings at poses that stages have set."""
    if not np.any(np.isfinite(poses[:, POSE.index("d_v")])):
        raise SceneError(f"{measured.source}: must hold a row with a target; got d_v = inf in all")

    def model(P: Array) -> Array:
        """Return the inductances for values of the parameters."""
        return setup.readings(np.tile(poses, (len(P), 1, 1)), P)

    free = setup.free(poses, {})
    fit = fit_parameters(model, measured.L, free, noise=noise)
    bare = replace(setup, parameters=())
    return Comparison(measured, fit, free, model, noise, bare.readings(poses[None], np.zeros((1, 0)))[0], np.nan, 0.0)


def _of_loads(setup: Setup, data: xr.Dataset, measured: Measured, noise: float | None) -> Comparison:
    """Compare readings under loads."""
    sensor, names = setup.sensor, several(data)
    table = _table(sensor, data, names)
    (softest, stiffest), why = _moduli(measured.forces, table, names)
    columns = [each.name for each in setup.parameters]
    if not softest <= 1.0 <= stiffest and "modulus" not in columns:
        raise SceneError(f"table: must reach beyond the measured forces; {why[int(softest <= 1.0)]}")

    def model(P: Array) -> Array:
        """Return the inductances for values of the parameters."""
        s = P[:, columns.index("modulus")] if "modulus" in columns else np.ones(len(P))
        L, poses = table.at(measured.forces / s[:, None, None])
        return setup.readings(poses, P, L)

    inside = (softest + 1e-3 * (stiffest - softest), stiffest - 1e-3 * (stiffest - softest))
    modulus = Free("modulus", float(np.clip(1.0, *inside)), softest, stiffest, 1.0, beyond=why)
    free = setup.free(table.poses, {"modulus": modulus})
    fit = fit_parameters(model, measured.L, free, noise=noise, own=table.own)
    factor = float(fit.values[columns.index("modulus")]) if "modulus" in columns else 1.0
    stiffness = np.nan if sensor.elastomer is None else factor * sensor.elastomer.silicone.shear_modulus
    bare = table.at(measured.forces[None])[0][0]
    return Comparison(measured, fit, free, model, noise, bare, stiffness, table.error)


@dataclass(frozen=True)
class _Table:
    """Maps from forces to inductances at the terminals and to poses, with the poses of the table's loads."""

    map: SmoothMap
    places: SmoothMap
    poses: Array

    def at(self, forces: Array) -> tuple[Array, Array]:
        """Return L, shape (k, m, n) [H], and the poses, shape (k, m, 6), at forces (k, m, d)."""
        flat, shape = forces.reshape(-1, forces.shape[-1]), forces.shape[:-1]
        return self.map.at(flat).reshape(*shape, -1), self.places.at(flat).reshape(*shape, -1)

    def ends(self) -> tuple[Array, Array]:
        """Return how far the map can be followed in each force [N, N m]."""
        half = 0.5 * (self.map.high - self.map.low)
        known = np.all(np.isfinite(self.map.error))
        beyond = [np.cosh(np.arccosh(_MISSING) / (degree + 1)) - 1.0 if known else 0.0 for degree in self.map.degrees]
        return self.map.low - half * beyond, self.map.high + half * beyond

    @property
    def error(self) -> float:
        """The error of the map, over each range."""
        return float(np.max(self.map.error / self._ranges()))

    @property
    def own(self) -> float:
        """The rms error of the map, over each range, of a grid fine enough to estimate it; else zero."""
        rms = self.map.rms / self._ranges()
        return float(np.sqrt(np.mean(rms[np.isfinite(rms)] ** 2))) if np.any(np.isfinite(rms)) else 0.0

    def _ranges(self) -> Array:
        """Return the range of each inductance over the forces [H]."""
        axes = [np.linspace(a, b, 9) for a, b in zip(self.map.low, self.map.high, strict=True)]
        loads = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(axes))
        return np.asarray(np.ptp(self.map.at(loads), axis=0))


def _table(sensor: Sensor, data: xr.Dataset, names: Sequence[str]) -> _Table:
    """Return the maps of a calibration over its forces."""
    data = data.isel({name: 0 for name in varied(data) if name not in names})
    good = data["status"].transpose(*names).isin(ANSWERED).to_numpy()
    forces = np.stack(np.meshgrid(*(data[name].to_numpy() for name in names), indexing="ij"), -1)[good]
    each = [data[name] if name in data else 0.0 * data["d_v"] for name in POSE]
    poses = np.stack([part.transpose(*names).to_numpy() for part in each], -1)[good]
    found = table_impedance(data)
    L = shown_inductances(sensor, replace(found, L=found.L[good], R=found.R[good]))
    return _Table(fit_map(names, forces, L), fit_map(names, forces, poses), poses)


def _moduli(forces: Array, table: _Table, names: Sequence[str]) -> tuple[tuple[float, float], tuple[str, str]]:
    """Return the least and greatest factor of the modulus for which the map holds every measured force, and why."""
    (least, most), (why_least, why_most) = _MODULI, ("", "")
    for k, (name, low, high) in enumerate(zip(names, *table.ends(), strict=True)):
        unit = shown_unit(name)
        span = f"the table's map can be followed for {name} from {low:.4g} to {high:.4g} {unit}"
        for sign, end in ((1.0, high), (-1.0, -low)):
            top = float(np.max(sign * forces[:, k]))
            came = f"{span}, the measurement has {sign * top:.4g} {unit}"
            if end <= 0.0 <= top and end != top:
                raise SceneError(f"table: must reach beyond the measured forces; {came}")
            if end > 0.0 and top / end > least:
                least, why_least = top / end, came
            if end < 0.0 and top / end < most:
                most, why_most = top / end, came
    return (least, most), (why_least, why_most)
