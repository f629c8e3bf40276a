"""Name what may be unknown of a bench and its sensor, and say what is known of it before anything is read.

What each does to the readings is in `setup` and `loaded`. What a user states ("gap = 0 +- 0.3 mm") counts, then what
the scene does (`tolerances`, where zero is known); the rest is

    modulus     ln s = 0 +- ln(1 + S)/1.69, S the spread of the silicone's sources, the range of some three of them:
                1.69 deviations are the mean range of three normal numbers; 0.3 where no source is known
    others      chosen, as moulding by hand, gluing by eye and a load cell of 1 % leave them; see `USUAL`

A planar magnetic model has no poses out of its plane, one on an axis none beside it: of such nothing is unknown.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.scene.parameters import value_of
from sits_mech.scene.sensor import SceneError, Sensor, key_unit, silicones_of
from sits_mech.silicone.laws import LAWS
from sits_mech.units import quantity, shown, si_unit, split_quantity

PARAMETERS = {
    "modulus": "", "stiffening": "", "thickness": "m", "cell": "", "frame": "rad", "frame_x": "rad", "frame_z": "rad",
    "gap": "m", "d_h": "m", "d_y": "m", "alpha": "rad", "alpha_x": "rad", "alpha_z": "rad",
    "axis_x": "m", "axis_z": "m", "lead": "H", "capacitance": "F",
}
"""What can be fitted besides keys of the scene, with its unit."""
LAYER = {"thickness": "elastomer.thickness", "stiffening": "stiffening"}
"""Those by whose derivatives the pose under a load changes, with the numbers of the scene that they are."""
CELL = ("cell", "frame", "frame_x", "frame_z")
"""Those of what the load is measured with: a sensor in use has none."""
_FACTORS = ("modulus", "cell")
_LOADED = ("modulus", *LAYER, *CELL)
_PRIOR = re.compile(r"\s*([\w.*]+)\s*(?:=\s*(.+?)\s*(?:\+-|\+/-|±)\s*(.+?)\s*)?")
USUAL = {
    "stiffening": 0.05, "thickness": 0.025, "gap": 1e-4, "d_h": 2e-4, "d_y": 2e-4, "alpha": 0.026, "alpha_x": 0.026,
    "cell": 0.01, "frame": 0.0175, "frame_x": 0.0175, "frame_z": 0.0175, "lead": 2e-8, "capacitance": 0.01,
}
"""Deviations, of the thickness over the layer's, of the capacitance over the tank's [-]; others [m, rad, H]."""
_UNKNOWN = 0.3  # of the modulus, without a source's spread
_ACROSS = ("d_y", "alpha_x", "frame_x", "frame_z")
_OFF_AXIS = ("d_h", "alpha", "frame", *_ACROSS)
_ABSENT = {"planar": _ACROSS, "planar-fem": _ACROSS, "axisymmetric": _OFF_AXIS, "axisymmetric-fem": _OFF_AXIS}
_SLOPED = ("block", "planar", "axisymmetric", "linear")  # mechanical models with derivatives by the layer
_PAIRS = {"frame": ("F_x", "F_z"), "frame_x": ("F_y", "F_z"), "frame_z": ("F_x", "F_y")}


@dataclass(frozen=True)
class PriorParameter:
    """A parameter with what is known of it beforehand: value and standard deviation [SI], or neither."""

    name: str
    value: float | None = None
    deviation: float = np.inf

    @property
    def softest(self) -> float:
        """The factor that is two deviations of its logarithm below its value; 1 where nothing is known."""
        value = self.value or 1.0
        return value * float(np.exp(-2.0 * self.deviation / value)) if np.isfinite(self.deviation) else 1.0


def known(text: str) -> PriorParameter:
    """Read a parameter: ``gap``, ``gap = 0 +- 0.3 mm``, ``target.width = 8 mm +- 20 um``.

    A unit is of both where one alone has it; a deviation in percent is of the value, unless this is zero or in percent
    itself. Raises SceneError for anything else, or a deviation that is not positive and of the same dimension.
    """
    match = _PRIOR.fullmatch(text)
    if match is None or (match[1] not in PARAMETERS and "." not in match[1]):
        names = ", ".join(PARAMETERS)
        raise SceneError(f'fit: must be {names} or a key of the scene, or "gap=0+-0.3 mm"; got {shown(text.strip())}')
    if match[2] is None:
        return PriorParameter(match[1])
    (number, own), (size, unit) = (split_quantity(match[k], f"fit: {match[1]}") for k in (2, 3))
    if unit == "%" != own and number:
        size, unit = 1e-2 * size * abs(number), own
    texts = f"{number!r} {own or unit}", f"{size!r} {unit or own}"
    value, deviation = (quantity(each, parameter_unit(match[1], texts[0]), f"fit: {match[1]}") for each in texts)
    if not (deviation > 0.0 and (value > 0.0 or match[1] not in _FACTORS)):
        raise SceneError(f"fit: {match[1]}: must be a value +- a deviation above 0, factors above 0; got {shown(text)}")
    return PriorParameter(match[1], value, deviation)


def parameter_unit(name: str, text: str) -> str:
    """Return the SI unit of a parameter, or of a key: the scene's, else that of a written quantity."""
    return PARAMETERS[name] if name in PARAMETERS else key_unit(name) or si_unit(text)


def parameters_of(sensor: Sensor, texts: Sequence[str], posed: bool) -> tuple[PriorParameter, ...]:
    """Return the parameters of texts (see `known`); `posed` tells that poses were measured, not loads.

    Raises SceneError when there is none, one comes twice, does not fit such a bench, or a key is no number of the scene
    or has no deviation.
    """
    found = tuple(known(text) for text in texts)
    names = [each.name for each in found]
    if not found or len({*names}) < len(names):
        raise SceneError(f"fit: must be one or more different parameters; got {', '.join(names) or 'none'}")
    for each in found:
        _check_fits(sensor, each, posed)
    return found


def _check_fits(sensor: Sensor, each: PriorParameter, posed: bool) -> None:
    """Refuse a parameter that a bench of loads, or of poses, does not tell, or the scene does not give."""
    if each.name in _LOADED and posed:
        raise SceneError(f"fit: {each.name}: must be of loads; got a bench of poses")
    if each.name.startswith("axis") and not posed:
        raise SceneError(f"fit: {each.name}: must be of poses that stages set; got a bench of loads")
    if each.name not in PARAMETERS and each.value is None:
        raise SceneError(f'fit: {each.name}: must come with what is known, "{each.name}=value +- deviation"')
    if each.name not in PARAMETERS and value_of(sensor, each.name) is None:
        raise SceneError(f"fit: {each.name}: must be a number that the scene gives; it gives none")


def usual_unknowns(sensor: Sensor, models: tuple[str, str], forces: Sequence[str]) -> tuple[str, ...]:
    """Return what is not known of a sensor that is read under forces, by a mechanical and a magnetic model."""
    absent = set(_ABSENT.get(models[1], ()))
    if models[0] not in _SLOPED:
        absent |= {*LAYER}
    made = silicones_of(sensor)
    if not made or any(LAWS[each.law].stiffened is None for each in made):
        absent |= {"stiffening"}
    absent |= {name for name, pair in _PAIRS.items() if not {*pair} <= {*forces}}
    absent |= {name for name in ("modulus", *USUAL) if _stated(sensor, name) == 0.0}
    return tuple(name for name in ("modulus", *USUAL) if name not in absent)


def priors(sensor: Sensor, texts: Sequence[str]) -> tuple[PriorParameter, ...]:
    """Return unknowns (`unknowns.known`) with what is known of each; SceneError as `unknowns.parameters_of`."""
    found = parameters_of(sensor, texts, False)
    return tuple(each if each.value is not None else _usual(sensor, each.name) for each in found)


def _usual(sensor: Sensor, name: str) -> PriorParameter:
    """Return what is known of an unknown that no user stated; keys of the scene state it."""
    stated = _stated(sensor, name)
    if stated:
        return PriorParameter(name, float(name in _FACTORS), stated)
    if name == "modulus":
        scatter = [each.modulus_deviation for each in silicones_of(sensor)]
        return PriorParameter(name, 1.0, max(_UNKNOWN if own is None else own for own in scatter or [None]))
    of = {"capacitance": sensor.readout.parallel_capacitance}
    if sensor.elastomer is not None:
        of["thickness"] = sensor.elastomer.thickness
    return PriorParameter(name, float(name in _FACTORS), USUAL.get(name, USUAL["alpha"]) * of.get(name, 1.0))


def _stated(sensor: Sensor, name: str) -> float | None:
    """Return the deviation that a scene states."""
    found = getattr(sensor.tolerances, name, None)
    return None if found is None else float(found)
