"""How far is a measurement from the model, and which few physical parameters bring them together?

    L_i(F) = L_map,i(F / s, g) + l,     s  modulus of the silicone over the scene's
                                        g  more gap than the scene has, between coils and target [m]
                                        l  inductance of the leads [H], besides the scene's

A hyperelastic layer under dead loads, all of whose moduli are s times as large, rests under F where it rested under
F / s: no layer is solved again. The gap moves every pose of the table up by g, which costs one magnetic solve of all
poses. What is per metre of depth is taken relative to free space (`bench`): its scale then is part of the misfit.
Neglected: that a gap of adhesive also changes the layer; rate, friction, temperature.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.interpolate import BarycentricInterpolator

from sits_mech.analysis.bench import free_inductances
from sits_mech.cases import DONE
from sits_mech.chain.models import loaded_model
from sits_mech.geometry.collision import clearance
from sits_mech.maps.surrogate import SmoothMap, fit_map
from sits_mech.quantities import Array, Pose
from sits_mech.readout.converter import converter
from sits_mech.readout.loads import two_forces
from sits_mech.readout.loads import varied as components
from sits_mech.readout.measured import Measured, ParameterFit, Tank, fit_parameters
from sits_mech.scene.sensor import SceneError, Sensor

PARAMETERS = ("modulus", "gap", "lead")
"""What can be fitted: s, g and l above."""
_LEVELS = 5  # heights of the map
_REACH = 0.25  # of the least clearance over the table: how far the gap may move
_LEAD = 2e-6  # [H] most


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


def tank_of(sensor: Sensor, reference: float, divider: int = 1) -> Tank | None:
    """Return how the scene's converter makes codes of inductances; None where it has none."""
    if sensor.readout.converter == "none":
        return None
    return Tank(converter(sensor.readout.converter), sensor.readout.parallel_capacitance, reference, divider)


def varied(data: xr.Dataset) -> tuple[str, ...]:
    """Return which of F_x and F_z a table varies; raise SceneError where its loads have other components."""
    data = two_forces(data)
    return tuple(name for name in components(data) if data.sizes[name] > 1)


def compare(sensor: Sensor, data: xr.Dataset, measured: Measured, free: Sequence[str] = PARAMETERS) -> Comparison:
    """Return a measurement beside the model, and the parameters that bring them together.

    Parameters
    ----------
    sensor : Sensor
        What was calibrated.
    data : Dataset
        As from `calibrate`; its loads must reach beyond the measured ones, by the softness that is to be found.
    measured : Measured
        Forces in the order of `varied`, inductances at the terminals.
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
    data = two_forces(data)
    names, reach = varied(data), _gap_reach(sensor, data)
    lifted = _lifted_map(sensor, data, names, reach)
    softest = _softest(measured.forces, lifted.map, names)
    if softest > 1.0 and "modulus" not in free:
        raise SceneError("table: must reach beyond the measured forces; calibrate with larger ones")

    def model(p: Array) -> Array:
        """Return the inductances for the free parameters."""
        values = {"modulus": 1.0, "gap": 0.0, "lead": 0.0} | dict(zip(free, p.tolist(), strict=True))
        own = sensor.readout.lead_inductance + values["lead"]
        return np.asarray(lifted.at(measured.forces / values["modulus"], values["gap"]) + own)

    ends = {"modulus": (softest, 10.0), "gap": (-reach, reach), "lead": (-_LEAD, _LEAD)}
    start = {"modulus": max(1.0, 1.001 * softest), "gap": 0.0, "lead": 0.0}
    sizes = {"modulus": 1.0, "gap": reach, "lead": 1e-8}
    low, high = zip(*(ends[name] for name in free), strict=True)
    fit = fit_parameters(
        model, measured.L, free,
        start=[start[name] for name in free], bounds=(low, high), sizes=[sizes[name] for name in free],
    )  # fmt: skip
    factor = float(fit.values[list(free).index("modulus")]) if "modulus" in free else 1.0
    modulus = np.nan if sensor.elastomer is None else sensor.elastomer.silicone.shear_modulus
    predicted = lifted.at(measured.forces, 0.0) + sensor.readout.lead_inductance
    return Comparison(measured, fit, predicted, factor * modulus, lifted.error)


@dataclass(frozen=True)
class _Lifted:
    """Inductances over the forces at several gaps, between them by the polynomial through all of them."""

    map: SmoothMap
    gaps: Array

    def at(self, forces: Array, gap: float) -> Array:
        """Return L at forces (m, d) with a gap [m], shape (m, n) [H]."""
        each = self.map.at(forces).reshape(len(forces), len(self.gaps), -1)
        return np.asarray(BarycentricInterpolator(self.gaps, each, axis=1)(gap)).reshape(len(forces), -1)

    @property
    def error(self) -> float:
        """Of the map, over each range."""
        axes = [np.linspace(a, b, 9) for a, b in zip(self.map.low, self.map.high, strict=True)]
        shown = self.map.at(np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(axes)))
        return float(np.max(self.map.error / np.ptp(shown, axis=0)))


def _gap_reach(sensor: Sensor, data: xr.Dataset) -> float:
    """Return how far the gap may move from the scene's [m]."""
    rows = data.where(data["status"] == DONE)
    room = clearance(sensor, Pose(rows["d_h"].to_numpy(), rows["d_v"].to_numpy(), rows["alpha"].to_numpy()))
    return _REACH * float(np.nanmin(room))


def _lifted_map(sensor: Sensor, data: xr.Dataset, names: Sequence[str], reach: float) -> _Lifted:
    """Return the coils' inductances over forces and gap."""
    data = data.isel({name: 0 for name in ("F_x", "F_z") if name not in names})
    good = (data["status"].transpose(*names) == DONE).to_numpy()
    forces = np.stack(np.meshgrid(*(data[name].to_numpy() for name in names), indexing="ij"), -1)[good]
    d_h, d_v, alpha = (data[name].transpose(*names).to_numpy()[good] for name in ("d_h", "d_v", "alpha"))
    gaps = -reach * np.cos(np.linspace(0.0, np.pi, _LEVELS))
    request = json.loads(data.attrs["request"])
    field, _ = loaded_model(sensor, request["magnetics"], request["tolerance"])
    level = np.zeros((_LEVELS, 1))
    pose = Pose((d_h + level).ravel(), (d_v + gaps[:, None]).ravel(), (alpha + level).ravel())
    shown = field.impedance(pose, sensor.frequency)
    L = np.diagonal(shown.L, axis1=-2, axis2=-1)
    if shown.unit_L != "H":
        L = L / np.diagonal(shown.L0) * free_inductances(sensor)
    each = L.reshape(_LEVELS, len(forces), -1).swapaxes(0, 1).reshape(len(forces), -1)
    return _Lifted(fit_map(names, forces, each), gaps)


def _softest(forces: Array, found: SmoothMap, names: Sequence[str]) -> float:
    """Return the least factor of the modulus for which every measured force is inside the table."""
    least = 0.02
    for k, name in enumerate(names):
        for end, sign in ((found.high[k], 1.0), (found.low[k], -1.0)):
            top = float(np.max(sign * forces[:, k]))
            if top <= 0.0:
                continue
            if sign * end <= 0.0:
                raise SceneError(f"{name}: must reach {sign * top:.4g} N in the table; it ends at {end:.4g} N")
            least = max(least, top / (sign * float(end)))
    return least
