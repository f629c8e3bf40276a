"""Convert a scene to another temperature: a sensor at a temperature is a sensor.

The numbers of a scene are those at 20 degC. At T, with dT = T - 20 degC,

    resistivity     rho (1 + a dT) of target, conductors and tracks; permeability mu_r (1 + b dT)
    plates          sizes of target and conductors times 1 + e dT of their metal, each about its own middle; the pad's
                    sizes go with the target that it is bonded to
    pad             what a length of the silicone would be if nothing held it, ``free_stretch`` times (1 + e dT) of the
                    silicone over 1 + e dT of the target; how far it lifts the target is for the mechanics to solve
    modulus         constants of the silicone that are stresses times T / 293.15 K: rubber's elasticity is entropic
    board           places and sizes of coils in their plane times 1 + e dT, heights of layers and tracks alike
    capacitor       C (1 + c dT)
    clock           the reference clock (1 + c dT), which codes are counted by: `clock_factor`

each a cause that can be asked for alone. What has no known coefficient is refused by name, as is a temperature outside
the range in which a coefficient holds. Sources of the coefficients stand beside them in the catalogue.

Neglected: what target and board expand differently under the pad, a percent of what the pad does; expansion of a
stand-off and of what holds the conductors; bulk modulus, permittivity and times of a Prony series over temperature;
temperatures that differ from part to part.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from sits_mech.scene.materials import Metal, metals
from sits_mech.scene.parts.coils import ACROSS, UPRIGHT
from sits_mech.scene.parts.cover import Cover
from sits_mech.scene.parts.elastomer import Layer
from sits_mech.scene.sensor import REFERENCE, Coil, Elastomer, SceneError, Sensor, metal_parts
from sits_mech.silicone.laws import LAWS
from sits_mech.silicone.material import Silicone
from sits_mech.units import ZERO_CELSIUS

CAUSES = ("conductivity", "plates", "pad", "modulus", "board", "capacitor", "clock")
"""Parts of a sensor that a temperature changes, each by its own coefficients."""


def at_temperature(sensor: Sensor, temperature: float | None = None) -> Sensor:
    """Return the scene that a sensor is at a temperature [K], its own by default; `temperature` is back at 20 degC.

    Raises SceneError for an unknown coefficient, or outside its range.

    Examples
    --------
    >>> from sits_mech.scene.thermal import at_temperature
    >>> warm = at_temperature(sm.load_sensor("biorob2018"), 333.15)
    >>> round(warm.elastomer.free_stretch, 4), round(warm.target.metal.conductivity / 1e6, 1)
    (1.0113, 50.1)
    """
    asked = sensor.temperature if temperature is None else temperature
    sensor = sensor if sensor.temperature == REFERENCE else sensor.model_copy(update={"temperature": REFERENCE})
    if asked == REFERENCE:
        return sensor
    check_temperature(sensor, asked)
    return warmed(sensor, dict.fromkeys(CAUSES, asked - REFERENCE))


def at_each(sensor: Sensor, temperatures: Sequence[float]) -> list[Sensor]:
    """Return the scene at each of some temperatures [K], unsolved; all are checked first."""
    for each in temperatures:
        check_temperature(sensor, each)
    return [sensor.model_copy(update={"temperature": each}) for each in temperatures]


def clock_factor(sensor: Sensor) -> float:
    """Return the frequency of the reference clock where a sensor is used, over that at 20 degC."""
    return 1.0 + sensor.readout.clock_coefficient * (sensor.temperature - REFERENCE)


def check_temperature(sensor: Sensor, temperature: float) -> None:
    """Refuse a temperature [K] at which something of a sensor is not known, in one line that names it."""
    if temperature == REFERENCE:
        return
    for name, part in metal_parts(sensor):
        keys = ("temperature_coefficient", "permeability_coefficient", "expansion")
        _check_known(name, part.metal, keys, f"{name}: {part.metal.name or 'its metal'}", temperature)
    for coil in sensor.coils:
        _check_range(f"coils.{coil.name}: the tracks' copper", _copper().temperature_range, temperature)
        if coil.conductivity is not None and coil.temperature_coefficient is None:
            raise _missing(f"coils.{coil.name}.temperature_coefficient", temperature)
    if sensor.elastomer is not None:
        _check_pad(sensor.elastomer, temperature)
    if sensor.cover is not None:
        _check_silicone("cover", sensor.cover.silicone, temperature)


def _check_pad(pad: Elastomer, temperature: float) -> None:
    """Refuse a pad whose sizes or silicones are not known at a temperature."""
    if pad.mesh is not None:
        raise SceneError(f"temperature: must be 20 degC with an elastomer.mesh, whose sizes are fixed; got "
                         f"{celsius(temperature)}")
    for place, silicone in pad.places.items():
        _check_silicone(place, silicone, temperature)


def _check_silicone(place: str, silicone: Silicone, temperature: float) -> None:
    """Refuse a silicone that is not known at a temperature; `place` is the key of what is made of it."""
    title = f"{place.partition('.')[0]}: {silicone.name or 'the silicone'}"
    _check_known(f"{place}.material", silicone, ("expansion", "temperature_range"), title, temperature)


def unknown_coefficients(sensor: Sensor) -> str:
    """Return why changes with temperature are not known; "" where they are."""
    try:
        check_temperature(sensor, REFERENCE + 1e-3)
    except SceneError as error:
        return str(error)
    return ""


def celsius(temperature: float) -> str:
    """Format a temperature [K] in degrees Celsius."""
    return f"{temperature - ZERO_CELSIUS:.6g} degC"


def warmed(sensor: Sensor, dT: Mapping[str, float]) -> Sensor:
    """Return a scene at 20 degC whose causes of change are each so much warmer [K], known to hold there or not.

    `dT` is by the names of `CAUSES`; an unknown coefficient counts as zero.
    """
    own = dict.fromkeys(CAUSES, 0.0) | dict(dT)
    target = sensor.target
    grown = 1.0 if target is None else 1.0 + (target.metal.expansion or 0.0) * own["plates"]
    changes: dict[str, Any] = {"coils": tuple(_coil(coil, own) for coil in sensor.coils)}
    if sensor.conductors:
        changes["conductors"] = tuple(_plate(part, own) for part in sensor.conductors)
    if target is not None:
        changes["target"] = _plate(target, own)
    if sensor.elastomer is not None:
        changes["elastomer"] = _pad(sensor.elastomer, own, grown)
    if sensor.cover is not None:
        over = sensor.cover.model_copy(update=_warm(sensor.cover, own, grown))
        changes["cover"] = over.model_copy(update={"overhang": grown * over.overhang})
    if own["capacitor"] and sensor.readout.capacitance_coefficient:
        C = sensor.readout.parallel_capacitance * (1.0 + sensor.readout.capacitance_coefficient * own["capacitor"])
        changes["readout"] = sensor.readout.model_copy(update={"parallel_capacitance": C})
    return sensor.model_copy(update=changes)


def _copper() -> Metal:
    """Return the metal of tracks."""
    return metals()["copper"]


def _check_known(name: str, of: Metal | Silicone, keys: Sequence[str], title: str, temperature: float) -> None:
    """Refuse a material without the coefficients that a temperature needs, or outside their range."""
    for key in keys:
        if getattr(of, key) is None:
            raise _missing(f"{name}.{key}", temperature)
    _check_range(title, of.temperature_range, temperature)


def _check_range(name: str, ends: tuple[float, float] | None, temperature: float) -> None:
    """Refuse a temperature outside a range."""
    if ends is not None and not ends[0] <= temperature <= ends[1]:
        reach = f"from {celsius(ends[0])} to {celsius(ends[1])}, where what is known of {name} holds"
        raise SceneError(f"temperature: must be {reach}; got {celsius(temperature)}")


def _missing(key: str, temperature: float) -> SceneError:
    """Return the error about an unknown coefficient."""
    return SceneError(f"{key}: must be given for a temperature other than 20 degC; it is missing, and "
                      f"{celsius(temperature)} is asked for")


def _plate(part: Any, dT: Mapping[str, float]) -> Any:
    """Return a target or conductor that is warmer."""
    metal, changes, resistive = part.metal, dict[str, Any](), dT["conductivity"]
    if resistive:
        changes["conductivity"] = metal.conductivity / (1.0 + (metal.temperature_coefficient or 0.0) * resistive)
        changes["relative_permeability"] = metal.relative_permeability * (
            1.0 + (metal.permeability_coefficient or 0.0) * resistive
        )
    grown = 1.0 + (metal.expansion or 0.0) * dT["plates"]
    if grown != 1.0:
        keys = ("width", "length", "diameter", "inner_diameter", "thickness", "load_height")
        changes |= {key: grown * size for key in keys if (size := getattr(part, key, None)) is not None}
        if part.points is not None:
            changes["points"] = _scaled(part.points, grown)
        changes["holes"] = tuple(_scaled(hole, grown) for hole in part.holes)
    return part.model_copy(update=changes)


def _scaled(points: Any, factor: float) -> tuple[tuple[float, ...], ...]:
    """Return points times a factor."""
    return tuple(tuple(factor * each for each in point) for point in points)


def _pad(pad: Elastomer, dT: Mapping[str, float], grown: float) -> Elastomer:
    """Return a pad that is warmer under a target that has grown by a factor."""
    keys = ("width", "length", "diameter", "pitch", "edge_radius")
    sizes = {key: grown * size for key in keys if (size := getattr(pad, key)) is not None}
    return pad.remade(lambda layer: _warm(layer, dT, grown), **sizes)


def _warm(layer: Layer | Cover, dT: Mapping[str, float], grown: float) -> dict[str, Any]:
    """Return what changes of a layer or a cover at a target that has grown by a factor."""
    silicone = layer.silicone
    free = 1.0 + (silicone.expansion or 0.0) * dT["pad"]
    changes = {"thickness": grown * layer.thickness, "free_stretch": layer.free_stretch * free / grown}
    made = {"material": stiffer(silicone, 1.0 + dT["modulus"] / REFERENCE)} if dT["modulus"] else {}
    return changes | made


def stiffer(silicone: Silicone, factor: float) -> Silicone:
    """Return a silicone with all constants that are stresses times a factor; its bulk modulus stays."""
    constants = LAWS[silicone.law].rescaled(silicone.constants, lambda value: factor * value)
    return replace(silicone, constants=constants)


def _coil(coil: Coil, dT: Mapping[str, float]) -> Coil:
    """Return a coil that is warmer, on its board."""
    changes: dict[str, Any] = {}
    if dT["conductivity"]:
        changes["conductivity"] = _conductivity(coil, dT["conductivity"])
    if dT["board"]:
        across, up = 1.0 + coil.board_expansion * dT["board"], 1.0 + coil.board_expansion_z * dT["board"]
        changes |= {key: across * getattr(coil, key) for key in ACROSS}
        changes |= {key: up * getattr(coil, key) for key in UPRIGHT}
        changes["centre"] = tuple(across * place for place in coil.centre)
        changes["path_widths"] = tuple(across * width for width in coil.path_widths)
        changes["layer_z"] = tuple(up * z for z in coil.layer_z)
        changes["path"] = tuple(tuple((across * x, across * y, up * z) for x, y, z in line) for line in coil.path)
    return coil.model_copy(update=changes)


def _conductivity(coil: Coil, dT: float) -> float:
    """Return the conductivity of a coil's tracks that are warmer [S/m]."""
    coefficient = coil.temperature_coefficient
    if coefficient is None:
        coefficient = _copper().temperature_coefficient or 0.0
    return (coil.conductivity or _copper().conductivity) / (1.0 + coefficient * dT)
