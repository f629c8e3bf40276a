"""Which numbers of a scene can an answer be differentiated by, and what does a small change of one make of the scene?

A parameter is a number of the scene that varies continuously, by its dotted key as in ``--set``:

    elastomer.thickness, target.width, coils.C1.inner_diameter, coils.*.track_width (all coils alike),
    elastomer.material.c10 (a constant of the silicone, of a catalogued one as well), elastomer.material.mu.0,
    modulus          a common factor of all constants of the silicone that are stresses, 1 as it is; the bulk modulus
                     stays.

Derivatives by it are those of differences of second order over a step h far below the lengths of the scene,

    f' = [f(h) - f(-h)] / (2 h),      or on one side   f' = [4 f(h) - 3 f - f(2 h)] / (2 h)

where the other is no scene (a stand-off below zero) or one of another kind (a target that is wider than its pad).
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

from sits_mech.scene.materials import silicones
from sits_mech.scene.sensor import SceneError, Sensor, scene_text, sensor_from
from sits_mech.silicone.laws import LAWS
from sits_mech.silicone.material import table_of
from sits_mech.units import shown

MODULUS = "modulus"
"""The parameter that stands for all stresses among a silicone's constants."""
STEP = 1e-6
"""Of the value: what is held nearly incompressible answers a step s with K s besides, K in shear moduli."""
_MATERIAL = ("elastomer", "material")


class Place(NamedTuple):
    """A changed scene, and its weight in a derivative."""

    sensor: Sensor
    weight: float


class Stencil(NamedTuple):
    """A derivative: weights of some changed scenes and of the scene itself [1/unit]."""

    places: tuple[Place, ...]
    own: float


@dataclass(frozen=True)
class Parameter:
    """A number of a scene.

    Attributes
    ----------
    name : str
        Its dotted key, or "modulus".
    value : float
        What the scene has [SI].
    step : float
        By which it is changed for a derivative [SI].
    """

    name: str
    value: float
    step: float
    _table: Mapping[str, Any] = field(repr=False, compare=False)
    _where: str = field(repr=False, default="scene")

    def changed(self, amount: float) -> Sensor:
        """Return the scene with the parameter changed by an amount; raise SceneError where that is no scene."""
        table = _copied(self._table)
        if self.name == MODULUS:
            _scale(table["elastomer"]["material"], 1.0 + amount)
        for path in _paths(table, self.name.split(".")) if self.name != MODULUS else ():
            *most, last = path
            _at(table, most)[last] += amount
        return sensor_from(table, self._where)

    @cached_property
    def _sides(self) -> dict[float, Sensor]:
        """Scenes at so many steps, those that there are."""
        found = {}
        for side in (1.0, -1.0, 2.0, -2.0):
            try:
                found[side] = self.changed(side * self.step)
            except SceneError:
                continue
        return found

    def stencil(self, alike: Callable[[Sensor], bool] = lambda _: True) -> Stencil:
        """Return a derivative by changed scenes that are alike the scene.

        Parameters
        ----------
        alike : callable
            Whether a changed scene is one of the same kind.

        Raises
        ------
        SceneError
            Where there is none on either side.
        """
        h, there = self.step, {side: sensor for side, sensor in self._sides.items() if alike(sensor)}
        if {1.0, -1.0} <= there.keys():
            return Stencil(tuple(Place(there[side], 0.5 * side / h) for side in (1.0, -1.0)), 0.0)
        for side in (1.0, -1.0):
            if {side, 2.0 * side} <= there.keys():
                near, far = Place(there[side], 2.0 * side / h), Place(there[2.0 * side], -0.5 * side / h)
                return Stencil((near, far), -1.5 * side / h)
        raise SceneError(f"{self.name}: must be a number that can be changed a little; no scene of this kind is beside")


def parameter(sensor: Sensor, name: str) -> Parameter:
    """Return a number of a scene by its name.

    Parameters
    ----------
    sensor : Sensor
    name : str
        A dotted key, or "modulus".

    Raises
    ------
    SceneError
        When there is no such number in the scene, or it is a count or a text.
    """
    table = tomllib.loads(scene_text(sensor))
    steps = name.split(".")
    of_material = name == MODULUS or (tuple(steps[:2]) == _MATERIAL and len(steps) > 2)
    if of_material:
        if sensor.elastomer is None:
            raise SceneError(f"{name}: needs an elastomer; it is missing")
        if isinstance(table["elastomer"]["material"], str):
            table["elastomer"]["material"] = table_of(silicones()[table["elastomer"]["material"]])
    if name == MODULUS:
        return Parameter(name, 1.0, STEP, table, sensor.name)
    if steps[0] == "target" and steps[-1] == "load_height" and "load_height" not in table.get("target", {}):
        table["target"]["load_height"] = table["target"]["thickness"]
    values = [_at(table, path) for path in _paths(table, steps)]
    if not values or not all(isinstance(value, float) for value in values):
        come = shown(values[0]) if values else "nothing of that name"
        raise SceneError(f"{name}: must be a number of the scene that varies continuously; got {come}")
    return Parameter(name, values[0], STEP * (abs(values[0]) or _size(sensor, of_material)), table, sensor.name)


def _size(sensor: Sensor, of_material: bool) -> float:
    """What a number that is zero is compared with: the shear modulus, or the thickness of the layer or the plate."""
    if sensor.elastomer is not None:
        return sensor.elastomer.silicone.shear_modulus if of_material else sensor.elastomer.thickness
    return sensor.target.thickness if sensor.target is not None else 1e-3


def _paths(table: Any, steps: list[str]) -> list[list[Any]]:
    """Where the numbers of a name stand: keys and places in lists; * stands for every entry of one."""
    if not steps:
        return [[]]
    step, found = steps[0], list[list[Any]]()
    if isinstance(table, list):
        names = [entry.get("name") if isinstance(entry, dict) else None for entry in table]
        own: list[Any] = [k for k, name in enumerate(names) if step in ("*", name, str(k))]
    else:
        own = [step] if isinstance(table, dict) and step in table else []
    for key in own:
        found += [[key, *rest] for rest in _paths(table[key], steps[1:])]
    return found


def _at(table: Any, path: list[Any]) -> Any:
    """What stands at a path."""
    for key in path:
        table = table[key]
    return table


def _scale(material: dict[str, Any], factor: float) -> None:
    """Multiply the constants of a material that are stresses."""
    for key, unit in LAWS[material["law"]].units.items():
        if unit == "Pa":
            own = material[key]
            material[key] = [factor * value for value in own] if isinstance(own, list) else factor * own


def _copied(value: Any) -> Any:
    """Copy tables and lists."""
    if isinstance(value, Mapping):
        return {key: _copied(item) for key, item in value.items()}
    return [_copied(item) for item in value] if isinstance(value, list) else value
