"""Which numbers of a scene can an answer be differentiated by, and what does a small change of one make of the scene?

A parameter is a number of the scene that varies continuously, by its dotted key (lengths.py), and what a catalogued
silicone is made of:

    elastomer.thickness, target.width, coils.C1.inner_diameter, coils.*.track_width (all coils alike),
    elastomer.material.c10 (a constant of the silicone, of a catalogued one as well), elastomer.material.mu.0,
    modulus          a common factor of all constants of the silicone that are stresses, 1 as it is; the bulk modulus
                     stays.

Derivatives by it are those of differences of second order over a step h far below the lengths of the scene,

    f' = [f(h) - f(-h)] / (2 h),      or on one side   f' = [4 f(h) - 3 f - f(2 h)] / (2 h)

where the other is no scene (a stand-off below zero) or one of another kind (a target that takes other cells).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

from sits_mech.scene.lengths import moved, numbers_at
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.silicone.laws import LAWS
from sits_mech.silicone.material import Silicone

MODULUS = "modulus"
"""The parameter that stands for all stresses among a silicone's constants."""
STEP = 1e-6
"""Of the value: what is held nearly incompressible answers a step s with K s besides, K in shear moduli."""
_MATERIAL = "elastomer.material."


class Place(NamedTuple):
    """A changed scene, by how much it is changed, and its weight in a derivative."""

    sensor: Sensor
    amount: float
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
    scene : Sensor
        With the constants of its silicone where the number is one of them.
    """

    name: str
    value: float
    step: float
    scene: Sensor

    def changed(self, amount: float) -> Sensor:
        """Return the scene with the parameter changed by an amount; raise SceneError where that is no scene."""
        if self.name == MODULUS and self.scene.elastomer is not None:
            return _of_silicone(self.scene, _stiffer(self.scene.elastomer.silicone, 1.0 + amount))
        return moved(self.scene, [self.name], amount)

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
            return Stencil(tuple(Place(there[side], side * h, 0.5 * side / h) for side in (1.0, -1.0)), 0.0)
        for side in (1.0, -1.0):
            if {side, 2.0 * side} <= there.keys():
                near = Place(there[side], side * h, 2.0 * side / h)
                far = Place(there[2.0 * side], 2.0 * side * h, -0.5 * side / h)
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
    of_material = name == MODULUS or name.startswith(_MATERIAL)
    if of_material and sensor.elastomer is None:
        raise SceneError(f"{name}: needs an elastomer; it is missing")
    if of_material and sensor.elastomer is not None:
        sensor = _of_silicone(sensor, sensor.elastomer.silicone)
    if name == MODULUS:
        return Parameter(name, 1.0, STEP, sensor)
    _, value = numbers_at(sensor, name)[0]
    return Parameter(name, value, STEP * (abs(value) or _size(sensor, of_material)), sensor)


def _size(sensor: Sensor, of_material: bool) -> float:
    """What a number that is zero is compared with: the shear modulus, or the thickness of the layer or of the plate."""
    if sensor.elastomer is not None:
        return sensor.elastomer.silicone.shear_modulus if of_material else sensor.elastomer.thickness
    return sensor.target.thickness if sensor.target is not None else sensor.coils[0].outer_diameter


def _of_silicone(sensor: Sensor, silicone: Silicone) -> Sensor:
    """A scene whose layer is of a silicone."""
    if sensor.elastomer is None:
        return sensor
    return sensor.model_copy(update={"elastomer": sensor.elastomer.model_copy(update={"material": silicone})})


def _stiffer(silicone: Silicone, factor: float) -> Silicone:
    """A silicone with all constants that are stresses times a factor."""
    constants: dict[str, float | tuple[float, ...]] = {}
    for key, value in silicone.constants.items():
        own = factor if LAWS[silicone.law].units[key] == "Pa" else 1.0
        constants[key] = tuple(own * each for each in value) if isinstance(value, tuple) else own * value
    return replace(silicone, constants=constants)
