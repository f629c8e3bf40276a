"""How far is a measurement from the model, and which few physical parameters bring them together?

    L_i(F) = L_map,i(F / s, g) + l,     s  modulus of the silicone over the scene's
                                        g  more gap than the scene has, between coils and target [m]
                                        l  inductance of the leads [H], besides the scene's

A hyperelastic layer under dead loads, all of whose moduli are s times as large, rests under F where it rested under
F / s: no layer is solved again. The gap moves every pose of the table up by g, which costs one magnetic solve of all
poses. What is per metre of depth is taken relative to free space (`bench`): its scale then is part of the misfit.
Inductances are those at the terminals, with leads and idle coils; without more gap they are the table's own. Loads
F / s may leave the table while the map can be followed: its first missing term, of the size of its error e on [-1, 1],
is e T_(P+1)(x) beyond, and may be 5 e.
Neglected: that a gap of adhesive also changes the layer; rate, friction, temperature.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.interpolate import BarycentricInterpolator

from sits_mech.analysis.bench import absolute, sensor_front_end, terminals
from sits_mech.analysis.spectrum import at_terminals
from sits_mech.cases import DONE
from sits_mech.chain.models import loaded_model
from sits_mech.geometry.collision import clearance
from sits_mech.maps.surrogate import SmoothMap, fit_map
from sits_mech.quantities import POSE, Array, Pose, shown_unit
from sits_mech.readout.loads import points, several, varied, wrench_of
from sits_mech.readout.measured import Measured, ParameterFit, Tank, fit_parameters
from sits_mech.scene.sensor import SceneError, Sensor

PARAMETERS = ("modulus", "gap", "lead")
"""What can be fitted: s, g and l above."""
_LEVELS = 5  # heights of the map
_REACH = 0.25  # of the least clearance over the table: how far the gap may move
_LEAD = 2e-6  # [H] most
_MISSING = 5.0  # of the map's error: what its first missing term may be beyond the table
_MODULI = (0.02, 10.0)  # least and greatest factor


@dataclass(frozen=True)
class Comparison:
    """A measurement beside the model.

    Attributes
    ----------
    measured : Measured
    fit : ParameterFit
        ``modulus`` [-], ``gap`` [m], ``lead`` [H].
    predicted : ndarray, shape (m, n)
        By the scene as it is [H].
    shear_modulus : float
        The scene's at small strain, times the fitted factor where it was fitted [Pa].
    map_error : float
        Of the map between the table's loads, over each coil's range.
    """

    measured: Measured
    fit: ParameterFit
    predicted: Array
    shear_modulus: float
    map_error: float


def tank_of(sensor: Sensor, data: xr.Dataset, clock: float | None = None) -> Tank | None:
    """Return how the scene's converter, set for a table, makes codes of inductances; None where it cannot.

    Parameters
    ----------
    sensor : Sensor
    data : Dataset
        As from `calibrate`.
    clock : float, optional
        External clock [Hz]; the part's greatest by default.
    """
    try:
        front, _ = sensor_front_end(sensor, data, clock=clock)
    except ValueError:
        if clock is not None:
            raise
        return None
    return Tank(front.part, sensor.readout.parallel_capacitance, front.reference, front.input_divider)


def compare(sensor: Sensor, data: xr.Dataset, measured: Measured, free: Sequence[str] = PARAMETERS) -> Comparison:
    """Return a measurement beside the model, and the parameters that bring them together.

    Parameters
    ----------
    sensor : Sensor
        What was calibrated.
    data : Dataset
        As from `calibrate`; its loads must reach as far as the measured ones over the modulus that is to be found, or
        a little less, as far as its map can be followed.
    measured : Measured
        Forces in the order of `several`, inductances at the terminals.
    free : sequence of str
        Which of `PARAMETERS` to fit.

    Raises
    ------
    SceneError
        When a parameter is unknown, the table is too small, or a value is at the end of its reach.
    """
    unknown = [name for name in free if name not in PARAMETERS]
    if unknown or not free:
        raise SceneError(f"fit: must be some of {', '.join(PARAMETERS)}; got {', '.join(unknown) or 'none'}")
    names, reach = several(data), _gap_reach(sensor, data)
    lifted = _lifted_map(sensor, data, names, reach)
    (softest, stiffest), why = _moduli(measured.forces, lifted, names)
    if not softest <= 1.0 <= stiffest and "modulus" not in free:
        raise SceneError(f"table: must reach beyond the measured forces; {why[int(softest <= 1.0)]}")

    def model(p: Array) -> Array:
        """Return the inductances for the free parameters."""
        values = {"modulus": 1.0, "gap": 0.0, "lead": 0.0} | dict(zip(free, p.tolist(), strict=True))
        return np.asarray(lifted.at(measured.forces / values["modulus"], values["gap"]) + values["lead"])

    ends = {"modulus": (softest, stiffest), "gap": (-reach, reach), "lead": (-_LEAD, _LEAD)}
    inside = (softest + 1e-3 * (stiffest - softest), stiffest - 1e-3 * (stiffest - softest))
    start = {"modulus": float(np.clip(1.0, *inside)), "gap": 0.0, "lead": 0.0}
    sizes = {"modulus": 1.0, "gap": reach, "lead": 1e-8}
    low, high = zip(*(ends[name] for name in free), strict=True)
    fit = fit_parameters(
        model, measured.L, free, start=[start[name] for name in free], bounds=(low, high),
        sizes=[sizes[name] for name in free], beyond={"modulus": why}, own=lifted.own,
    )  # fmt: skip
    factor = float(fit.values[list(free).index("modulus")]) if "modulus" in free else 1.0
    modulus = np.nan if sensor.elastomer is None else sensor.elastomer.silicone.shear_modulus
    return Comparison(measured, fit, lifted.at(measured.forces, 0.0), factor * modulus, lifted.error)


@dataclass(frozen=True)
class _Lifted:
    """Inductances over the forces at several gaps, between them by the polynomial through all of them."""

    map: SmoothMap
    gaps: Array

    def at(self, forces: Array, gap: float) -> Array:
        """Return L at forces (m, d) with a gap [m], shape (m, n) [H]."""
        each = self.map.at(forces).reshape(len(forces), len(self.gaps), -1)
        return np.asarray(BarycentricInterpolator(self.gaps, each, axis=1)(gap)).reshape(len(forces), -1)

    def ends(self) -> tuple[Array, Array]:
        """Return how far the map can be followed in each force [N, N m]."""
        half = 0.5 * (self.map.high - self.map.low)
        known = np.all(np.isfinite(self.map.error))
        beyond = [np.cosh(np.arccosh(_MISSING) / (degree + 1)) - 1.0 if known else 0.0 for degree in self.map.degrees]
        return self.map.low - half * beyond, self.map.high + half * beyond

    @property
    def error(self) -> float:
        """Of the map, over each range."""
        return float(np.max(self.map.error / self._ranges()))

    @property
    def own(self) -> float:
        """Root mean square error of the map, over each range, of a grid fine enough to tell it; else zero."""
        rms = self.map.rms / self._ranges()
        return float(np.sqrt(np.mean(rms[np.isfinite(rms)] ** 2))) if np.any(np.isfinite(rms)) else 0.0

    def _ranges(self) -> Array:
        """Return the range of each inductance over the forces [H]."""
        axes = [np.linspace(a, b, 9) for a, b in zip(self.map.low, self.map.high, strict=True)]
        loads = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(axes))
        return np.asarray(np.ptp(self.map.at(loads), axis=0))


def _gap_reach(sensor: Sensor, data: xr.Dataset) -> float:
    """Return how far the gap may move from the scene's [m]."""
    return _REACH * float(np.nanmin(clearance(sensor, Pose.of(_places(data.where(data["status"] == DONE))))))


def _places(data: xr.Dataset) -> Array:
    """Return the poses of a table's loads, shape (*sizes, 6) [m, rad]."""
    each = [data[name] if name in data else 0.0 * data["d_v"] for name in POSE]
    return np.stack([part.transpose(*varied(data)).to_numpy() for part in each], -1)


def _lifted_map(sensor: Sensor, data: xr.Dataset, names: Sequence[str], reach: float) -> _Lifted:
    """Return the coils' inductances at their terminals over forces and gap."""
    data = data.isel({name: 0 for name in varied(data) if name not in names})
    good = (data["status"].transpose(*names) == DONE).to_numpy()
    forces = np.stack(np.meshgrid(*(data[name].to_numpy() for name in names), indexing="ij"), -1)[good]
    gaps = -reach * np.cos(np.linspace(0.0, np.pi, _LEVELS))
    request = json.loads(data.attrs["request"])
    loads = [wrench_of(row) for row in points(data)]
    field, _ = loaded_model(sensor, request["magnetics"], request["tolerance"], loads)
    places = np.tile(_places(data)[good], (_LEVELS, 1, 1))
    places[..., POSE.index("d_v")] += gaps[:, None]
    shown, _ = absolute(sensor, field.impedance(Pose.of(places.reshape(-1, len(POSE))), sensor.frequency))
    seen, _ = at_terminals(sensor, shown)
    own = np.diagonal(shown.L, axis1=-2, axis2=-1) + sensor.readout.lead_inductance
    L = (own if seen is None else seen.L).reshape(_LEVELS, len(forces), -1)
    if seen is not None:  # the middle gap is the scene's: there the table's own holds
        L = L - L[_LEVELS // 2] + terminals(sensor, data)[0]["L"].transpose(*names, "coil").to_numpy()[good]
    return _Lifted(fit_map(names, forces, L.swapaxes(0, 1).reshape(len(forces), -1)), gaps)


def _moduli(forces: Array, lifted: _Lifted, names: Sequence[str]) -> tuple[tuple[float, float], tuple[str, str]]:
    """Return the least and greatest factor of the modulus for which the map holds every measured force, and why."""
    (least, most), (why_least, why_most) = _MODULI, ("", "")
    for k, (name, low, high) in enumerate(zip(names, *lifted.ends(), strict=True)):
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
