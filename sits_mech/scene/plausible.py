"""Warn of numbers of a scene that are probably slips of a unit: a thickness of 2 is metres, 5 mHz is no MHz.

`bounds.py` refuses what makes no sense; here is what makes sense but belongs to hardly any tactile sensor. The range in
which a kind of input is usual stands beside its bounds, as a `Usual` among the annotations of its type.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BaseModel

from sits_mech.quantities import POSE, TOUCH, Pose, shown_unit
from sits_mech.scene.files import toml_value
from sits_mech.silicone.material import Silicone, implausible
from sits_mech.silicone.stability import stability
from sits_mech.units import SceneError, split_quantity

_STRETCHES = 0.3, 4.0  # that pads come near to
_QUARTER = 1.6  # rad, just above a quarter turn
_NEAREST, _FARTHEST = 1e-6, 0.2  # m
_SHEAR = 100.0  # shear moduli: silicone that can escape is at a tenth of its height there; K is the most that none can


@dataclass(frozen=True)
class Usual:
    """The usual range of a kind of input; zero is always usual."""

    what: str  # such as "a length"
    low: float
    high: float
    unit: str  # SI, of `low` and `high`

    def slip(self, name: str, value: float) -> str:
        """Return the warning about a value; empty where it is usual."""
        if value == 0.0 or self.low <= abs(value) <= self.high:
            return ""
        span = f"up to {self.high:g} {self.unit}"
        span = f"{self.low:g} {self.unit} to {self.high:g} {self.unit}" if self.low else span
        return f"implausible: {name} = {value:.4g} {self.unit}; {self.what} is usually {span}: is the unit right?"


LENGTH = Usual("a length of such a sensor", _NEAREST, _FARTHEST, "m")
PLACE = Usual("a coordinate of such a sensor", 0.0, _FARTHEST, "m")
FREQUENCY = Usual("the frequency of such a sensor", 1.0, 1e9, "Hz")
ANGLE = Usual("an angle, in radians without a unit,", 0.0, _QUARTER, "rad")


def slips(part: BaseModel) -> tuple[str, ...]:
    """Return a line for each number of a scene or part, silicone included, that is probably a slip of a unit."""
    return tuple(_found(part, ""))


def slips_of_pose(pose: Pose) -> tuple[str, ...]:
    """Return a line for each component of a pose that is probably a slip of a unit."""
    usual = {"d_v": LENGTH, "d_h": PLACE, "d_y": PLACE}
    lines = (usual.get(name, ANGLE).slip(name, float(getattr(pose, name))) for name in POSE)
    return tuple(line for line in lines if line)


def bare_lengths(part: BaseModel, overrides: Sequence[str]) -> tuple[str, ...]:
    """Return those of overrides, such as ``elastomer.thickness=3``, that set a length of a part to a bare number."""
    parts = ((each, *each.partition("=")[::2]) for each in overrides)
    return tuple(each for each, key, text in parts if is_bare(toml_value(text.strip())) and _is_length(part, key))


def is_bare(value: object) -> bool:
    """Whether a value is a number other than zero without a unit, or holds one."""
    if isinstance(value, list | tuple):
        return any(map(is_bare, value))
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return False
    try:
        number, unit = split_quantity(value, "")
    except SceneError:
        return False
    return number != 0.0 and not unit


def _is_length(part: Any, key: str) -> bool:
    """Whether a key of a part, such as "coils.C1.centre", is of a length or a place."""
    *steps, last = key.strip().split(".")
    for step in steps:
        if isinstance(part, tuple):
            named = [each for k, each in enumerate(part) if step in (getattr(each, "name", ""), f"{k}")]
            part = named[0] if named else None
        else:
            part = getattr(part, step, None)
    field = type(part).model_fields.get(last) if isinstance(part, BaseModel) else None
    usual = None if field is None else next(_usual((field.annotation, *field.metadata)), None)
    return usual is not None and usual.unit == "m"


def check_loads(sensor: Any, loads: Mapping[str, ArrayLike]) -> None:
    """Refuse loads that are no numbers or far above what any state of the pad bears, by component [N, N m].

    Raises SceneError with the component and its largest value; without an elastomer nothing is refused.
    """
    if sensor.elastomer is None:
        return
    plates = [sensor.elastomer, *([sensor.target] if sensor.target else [])]
    sides = [max(plate.extent[k] for plate in plates) for k in (0, 1)]
    made = [*sensor.elastomer.places.values(), *([sensor.cover.silicone] if sensor.cover else [])]
    force = max(max(each.bulk_modulus, _SHEAR * each.shear_modulus) for each in made) * sides[0] * sides[1]
    for name, values in loads.items():
        if name in TOUCH:
            continue
        most = force if name.startswith("F") else force * max(sides)
        for value in np.ravel(values):
            if not abs(value) <= most:
                unit, why = shown_unit(name), "no pad of this silicone and size carries more (see sits-mech envelope)"
                raise SceneError(f"{name}: must be within {most:.2g} {unit}: {why}; got {value:g} {unit}")


def _found(part: BaseModel, path: str) -> Iterator[str]:
    """Yield the lines of a part and of what belongs to it."""
    yield from _cancelling(getattr(part, "directions", ()), path)
    for name, field in type(part).model_fields.items():
        value = getattr(part, name)
        usual = next(_usual((field.annotation, *field.metadata)), None)
        yield from _lines(value, f"{path}{name}", usual)


def _lines(value: Any, name: str, usual: Usual | None) -> Iterator[str]:
    """Yield the lines of a value: a part, parts, a silicone, a number, or points; of points the first that slips."""
    if isinstance(value, BaseModel):
        yield from _found(value, f"{name}.")
    elif isinstance(value, Silicone):
        yield from (*implausible(value), *_falling(value))
    elif isinstance(value, tuple) and value and isinstance(value[0], BaseModel):
        for number, each in enumerate(value):
            yield from _found(each, f"{name}.{getattr(each, 'name', number)}.")
    elif usual is not None:
        yield from [line for number in _numbers(value) if (line := usual.slip(name, number))][:1]


def _cancelling(ways: Sequence[int], path: str) -> Iterator[str]:
    """Yield the line of a coil with layers in series that run against each other, whose fields cancel."""
    if abs(sum(ways)) < len(ways):
        shown = ", ".join(f"{way:+d}" for way in ways)
        yield (f"implausible: {path}directions = {shown}: layers in series run against each other, their fields cancel "
               "and little inductance is left")


def _falling(silicone: Silicone) -> Iterator[str]:
    """Yield the line of a Yeoh law with negative terms and no known range of strain."""
    negative = [f"{key} = {c:.3g} Pa" for key, c in silicone.constants.items() if isinstance(c, float) and c < 0.0]
    if silicone.law == "yeoh" and negative and silicone.fitted_range is None:
        ends = stability(silicone, _STRETCHES)
        till = "" if ends.stable else f" and is unstable from a stretch of {ends.first_unstable:.3g} in {ends.mode} on"
        yield f"implausible: yeoh with {', '.join(negative)} has no fitted_range{till}"


def _numbers(value: Any) -> Iterator[float]:
    """Yield the finite numbers in a value, however deep."""
    if isinstance(value, tuple):
        for each in value:
            yield from _numbers(each)
    elif isinstance(value, float) and math.isfinite(value):
        yield value


def _usual(kinds: Any) -> Iterator[Usual]:
    """Yield the usual ranges among annotations, however deep."""
    for kind in kinds:
        if isinstance(kind, Usual):
            yield kind
        yield from _usual((*get_args(kind), *getattr(kind, "__metadata__", ())))
