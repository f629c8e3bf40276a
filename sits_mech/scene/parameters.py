"""Select the numbers of a scene that answers can be differentiated by, and change them slightly.

A parameter is a number of the scene that varies continuously, by its key in scene and study files, with dots and `*`
for every entry of a list, or what a catalogued silicone is made of:

    elastomer.thickness, target.width, coils.C1.inner_diameter, coils.C1.centre.0, coils.*.track_width (of all coils, by
    as much), elastomer.material.c10 (a constant of the silicone, of a catalogued one as well), elastomer.material.mu.0,
    temperature.pad  what one of the causes of scene/thermal.py changes with temperature, the others held at the scene's
                     own [K]; beside it a scene's numbers are those at its temperature,
    modulus          a common factor of all constants of the silicone that are stresses, 1 as it is; the bulk modulus
                     stays,
    stiffening       what the silicone stiffens by besides, zero as it is: the share k of w + k mu/2 (I1 - 3)^2.

Of a pad of layers the keys are elastomer.layers.0.thickness and elastomer.layers.0.material.c10; elastomer.thickness is
that of all in proportion, and the last two are of all of them. A cover has cover.thickness, cover.overhang and
cover.material.c10, and goes with the pad in the last two.

Derivatives by it are differences of second order (maps/differences.py) over a step h far below the lengths of the
scene, on both sides, or on one where the other is no scene (a stand-off below zero) or one of another kind (a target
that takes other cells).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from sits_mech.maps.differences import SECOND_ORDER
from sits_mech.scene.sensor import REFERENCE, SceneError, Sensor, changed, scene_table
from sits_mech.scene.thermal import CAUSES, at_temperature, stiffer, warmed
from sits_mech.silicone.material import Silicone
from sits_mech.units import shown

MODULUS = "modulus"
"""The parameter that stands for all stresses among a silicone's constants."""
STIFFENING = "stiffening"
"""The parameter that stands for a silicone that stiffens more with strain than the scene's."""
THICKNESS = "elastomer.thickness"
"""The parameter of a pad's thickness, of all layers in proportion."""
TEMPERATURE = "temperature."
"""What the parameters begin with that stand for a cause of change with temperature."""
STEP = 1e-6
"""Of the value: what is held nearly incompressible answers a step s with K s besides, K in shear moduli."""
_OF_MATERIAL = re.compile(r"(elastomer\.(layers\.[^.]+\.)?|cover\.)material\.")
_STIFFER = 1e-4  # step of the stiffening: rounding of the forces is some 1e-12 of the layer's
_KELVIN = 3e-3  # step of a temperature: some 1e-6 of what it changes
_REACHES = dict.fromkeys(CAUSES, 6e4) | {"conductivity": 300.0, "modulus": 300.0, "pad": 3e3}  # 1 over coefficients [K]


class Perturbation(NamedTuple):
    """A changed scene, the amount of its change, and its weight in a derivative."""

    sensor: Sensor
    amount: float
    weight: float


class SceneStencil(NamedTuple):
    """A derivative: weights of some changed scenes and of the scene itself [1/unit].

    A stencil of maps/differences.py, which has weights of numbered places alone, at the scenes of a parameter.
    """

    places: tuple[Perturbation, ...]
    own: float


@dataclass(frozen=True)
class Parameter:
    """A number of a scene, or several that change together, all in SI."""

    name: str  # dotted key, or "modulus"
    numbers: tuple[tuple[str, float], ...]  # key, without a star, and value of each
    step: float  # change for a derivative
    scene: Sensor  # at its temperature, with constants of its silicone where it is one of them
    become: Callable[[float], Sensor] | None = None  # scene by an amount, where it is no number of a scene file
    reach: float = 0.0  # amount of a change by all of itself, where that is not its value; or zero

    @property
    def value(self) -> float:
        """The value in the scene, of the first number where there are several [SI]."""
        return self.numbers[0][1]

    def changed(self, amount: float) -> Sensor:
        """Return the scene with the parameter changed by an amount; raise SceneError where that is no scene."""
        if self.become is not None:
            return self.become(amount)
        if self.name == MODULUS:
            return _remade(self.scene, lambda silicone: stiffer(silicone, 1.0 + amount))
        return changed(self.scene, [f"{key}={value + amount!r}" for key, value in self.numbers])

    def scenes(self, places: Iterable[int]) -> dict[int, Sensor]:
        """Return the possible scenes among those at so many steps."""
        found = {}
        for place in places:
            with suppress(SceneError):
                found[place] = self.changed(place * self.step)
        return found

    @cached_property
    def _perturbed(self) -> dict[int, Sensor]:
        """Scenes for derivatives of second order."""
        return self.scenes((1, -1, 2, -2))

    def stencil(self, alike: Callable[[Sensor], bool] = lambda _: True) -> SceneStencil:
        """Return a derivative by changed scenes of the same kind, as `alike` tells.

        Raises SceneError where there is none on either side.
        """
        h, there = self.step, {place: sensor for place, sensor in self._perturbed.items() if alike(sensor)}
        for rule in SECOND_ORDER:
            shares = {m: share / h for m, share in rule.shares.items() if m}
            if shares.keys() <= there.keys():
                places = tuple(Perturbation(there[m], m * h, weight) for m, weight in shares.items())
                return SceneStencil(places, rule.shares[0] / h)
        raise SceneError(f"{self.name}: must be a number that can be changed a little; no scene of this kind is beside")


def parameter(sensor: Sensor, name: str) -> Parameter:
    """Return a number of a scene by its dotted key, or "modulus".

    Raises SceneError when there is no such number in the scene, or it is a count or a text.
    """
    if name.startswith(TEMPERATURE):
        return _by_cause(sensor, name)
    sensor = at_temperature(sensor)
    if name == MODULUS:
        return Parameter(name, ((name, 1.0),), STEP, _with_constants(sensor, name))
    if own := _of_pad(sensor, name):
        return own
    sensor = _with_constants(sensor, name)
    found = [(key, value) for key, value in _ends(scene_table(sensor), name.split("."), ()) if value is not None]
    if not found:
        raise SceneError(f"{name}: must be a number that the scene gives, such as target.width; it gives none")
    for key, value in found:
        if not isinstance(value, float):
            raise SceneError(f"{key}: must be a number that can go up and down a little; got {shown(value)}")
    size = max(abs(value) for _, value in found) or _size(sensor, bool(_OF_MATERIAL.match(name)))
    return Parameter(name, tuple(found), STEP * size, sensor)


def _of_pad(sensor: Sensor, name: str) -> Parameter | None:
    """Return the parameter that stiffens a pad's silicones, or the thickness of its layers; None for other names."""
    if name == STIFFENING:
        scene = _with_constants(sensor, MODULUS)
        return Parameter(
            name, ((name, 0.0),), _STIFFER, scene, lambda share: _remade(scene, lambda own: own.stiffened(share))
        )
    if name == THICKNESS and sensor.elastomer is not None and sensor.elastomer.layers:
        pad, t = sensor.elastomer, sensor.elastomer.thickness
        return Parameter(name, ((name, t),), STEP * t, sensor, lambda amount: sensor.model_copy(
            update={"elastomer": pad.of_thickness(t + amount)}))
    return None


def _by_cause(sensor: Sensor, name: str) -> Parameter:
    """Return the parameter of one cause's temperature, from the scene's own on."""
    cause, dT = name.removeprefix(TEMPERATURE), sensor.temperature - REFERENCE
    if cause not in CAUSES:
        raise SceneError(f"{name}: must be one of {', '.join(TEMPERATURE + each for each in CAUSES)}")
    here, plain = at_temperature(sensor), at_temperature(sensor, REFERENCE)
    held = dict.fromkeys(CAUSES, dT)
    return Parameter(
        name, ((name, sensor.temperature),), _KELVIN, here,
        lambda amount: warmed(plain, held | {cause: dT + amount}), _REACHES[cause],
    )


def value_of(sensor: Sensor, key: str) -> float | None:
    """Return the number of a key [SI], also of a count; the first one's of a star; None where the scene gives none."""
    if key == THICKNESS and sensor.elastomer is not None:
        return sensor.elastomer.thickness
    if sensor.elastomer is not None:
        sensor = _with_constants(sensor, key)
    here = next((value for _, value in _ends(scene_table(sensor), key.split("."), ()) if value is not None), None)
    return float(here) if isinstance(here, int | float) and not isinstance(here, bool) else None


def keys_of(sensor: Sensor, key: str) -> list[str]:
    """Return the keys that one stands for, a star meaning every entry of a list, given there or not."""
    return [each for each, _ in _ends(scene_table(sensor), key.split("."), ())]


def numbers_of(sensor: Sensor) -> dict[str, Any]:
    """Return what a scene gives, by dotted key, entries of lists by number."""
    found: dict[str, Any] = {}

    def read(part: Any, path: str) -> None:
        if isinstance(part, Mapping):
            for key, item in part.items():
                read(item, f"{path}{key}.")
        elif isinstance(part, list | tuple) and any(isinstance(item, Mapping) for item in part):
            for number, item in enumerate(part):
                read(item, f"{path}{number}.")
        else:
            found[path[:-1]] = part

    read(scene_table(sensor), "")
    return found


def _ends(part: Any, steps: list[str], way: tuple[str, ...]) -> list[tuple[str, Any]]:
    """Return keys and values at the end of some steps down from a part; None where it has none."""
    if not steps:
        return [(".".join(way), part)]
    step, *rest = steps
    if isinstance(part, list | tuple):
        part = _named(part)
        if step == "*":
            return [end for name, each in part.items() for end in _ends(each, rest, (*way, name))]
        if step not in part and step in map(str, range(len(part))):
            step = list(part)[int(step)]
    if isinstance(part, Mapping) and step in part:
        return _ends(part[step], rest, (*way, step))
    return [(".".join((*way, *steps)), None)]


def _named(entries: Sequence[Any]) -> dict[str, Any]:
    """Return entries of a list by name; by number, where they have none, or none that may be part of a key."""
    names = [str(entry.get("name", "")) if isinstance(entry, Mapping) else "" for entry in entries]
    return {name if name and not set(name) & set(".=") else str(k): entries[k] for k, name in enumerate(names)}


def _with_constants(sensor: Sensor, name: str) -> Sensor:
    """Return a scene with the constants of its silicones, where a name is of them; else unchanged."""
    if name != MODULUS and not _OF_MATERIAL.match(name):
        return sensor
    if sensor.elastomer is None:
        raise SceneError(f"{name}: needs an elastomer; it is missing")
    return _remade(sensor, lambda silicone: silicone)


def _size(sensor: Sensor, of_material: bool) -> float:
    """Return the scale of a number that is zero: the shear modulus, or the thickness of the layer or of the plate."""
    if sensor.elastomer is not None:
        return sensor.elastomer.shear_modulus if of_material else sensor.elastomer.thickness
    return sensor.target.thickness if sensor.target is not None else sensor.coils[0].outer_diameter


def _remade(sensor: Sensor, change: Callable[[Silicone], Silicone]) -> Sensor:
    """Return a scene with each silicone of its pad and its cover changed."""
    if sensor.elastomer is None:
        return sensor
    pad, cover = sensor.elastomer.remade(lambda layer: {"material": change(layer.silicone)}), sensor.cover
    over = None if cover is None else cover.model_copy(update={"material": change(cover.silicone)})
    return sensor.model_copy(update={"elastomer": pad, "cover": over})
