"""Define the space of designs: numbers between bounds, values of lists, and the scene of each design.

A design is a choice of one value of each list and a point x of the unit box, one coordinate for each number between
bounds; low at 0, high at 1, lengths in the unit they were written in. Keys are those of `sits-mech --set`, in which a
star stands for every coil.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from sits_mech.geometry.collision import fixed_solids
from sits_mech.quantities import Array
from sits_mech.scene.files import literal
from sits_mech.scene.parameters import keys_of, value_of
from sits_mech.scene.sensor import SceneError, Sensor, changed
from sits_mech.units import shown

_MOST = 1000  # choices
_CORNERS = 256  # of bounds and lists, whose sizes are looked at
_SILICONE = "elastomer.material"  # has no size
_ROUND = 0.02  # of the bounds' distance, at most, from a round number to the next
_NEAREST = 64  # round designs beside one
_STEPS = (5.0, 2.0, 1.0)  # round numbers of a decade, coarse first
_SPACING = ("pitch_x", "pitch_y")  # of a sweep over cells


def size_of(sensor: Sensor) -> dict[str, float]:
    """Return height and footprint of all parts at rest [m]."""
    solids = [solid for each in fixed_solids(sensor) for solid in each]
    middle, reach = np.array([(each.places[0], np.abs(each.turns[0]) @ each.half) for each in solids]).swapaxes(0, 1)
    low, high = (middle - reach).min(axis=0), (middle + reach).max(axis=0)
    layer, target = sensor.elastomer, sensor.target
    top = 0.0 if layer is None else layer.standoff + layer.thickness
    over = 0.0 if sensor.cover is None else sensor.cover.thickness
    for part, upper in ((layer, top), (target, top + over + (0.0 if target is None else target.thickness))):
        if part is not None:
            half = np.array(part.extent) / 2.0
            low, high = np.minimum(low, [*-half, 0.0]), np.maximum(high, [*half, upper])
    x, y, z = (high - low).tolist()
    return {"height": z, "footprint.x": x, "footprint.y": y}


@dataclass(frozen=True)
class Variable:
    """A number between bounds, as written: ``low`` and ``high`` in ``unit``, "" for SI or none."""

    key: str
    low: float
    high: float
    unit: str

    def value(self, x: float) -> float:
        """Return the number at a coordinate from 0 to 1 [unit]."""
        return self.low + x * (self.high - self.low)

    def text(self, number: float) -> Any:
        """Return a number as it is written in a scene."""
        plain = float(f"{number:.12g}")
        return f"{plain!r} {self.unit}" if self.unit else plain

    def round_neighbours(self, x: float) -> tuple[float, ...]:
        """Return the coordinates of the round numbers beside one, 1, 2 or 5 times a power of ten, the nearer first."""
        width, number = self.high - self.low, self.value(x)
        most = _ROUND * width * (1.0 + 1e-9)
        power = 10.0 ** math.floor(math.log10(most))
        step = next(each * power for each in _STEPS if each * power <= most)
        near = {min(max(way(number / step) * step, self.low), self.high) for way in (math.floor, math.ceil)}
        found = [(each - self.low) / width for each in near]
        return tuple(sorted(found, key=lambda each: abs(each - x)))


@dataclass(frozen=True)
class Design:
    """A design: which value of each list, and the coordinates of the numbers, shape (v,), as a tuple."""

    choice: tuple[int, ...]
    x: tuple[float, ...]

    def moved(self, number: int, by: float) -> Design:
        """Return the design with one coordinate changed."""
        return Design(self.choice, tuple(x + by * (k == number) for k, x in enumerate(self.x)))


@dataclass(frozen=True)
class Space:
    """The designs to choose from."""

    base: Sensor  # start of every design
    variables: tuple[Variable, ...]
    lists: dict[str, tuple[Any, ...]]  # values of each key that is chosen from a list

    @property
    def record(self) -> list[Any]:
        """The space as plain values, for comparison."""
        return [[(each.key, each.low, each.high, each.unit) for each in self.variables], self.lists]

    @cached_property
    def choices(self) -> tuple[tuple[int, ...], ...]:
        """All choices of one value of each list."""
        return tuple(itertools.product(*(range(len(values)) for values in self.lists.values())))

    @property
    def names(self) -> tuple[str, ...]:
        """The keys of the scene that the numbers between bounds stand for."""
        return tuple(each.key for each in self.variables)

    @property
    def growth(self) -> Array:
        """By how much each number grows from its lower bound to its upper one, over the lower; 0 if not positive."""
        return np.array([each.high / each.low - 1.0 if each.low > 0.0 else 0.0 for each in self.variables])

    @property
    def silicone(self) -> int | None:
        """The place of the silicone in a choice; None where it is the same in all."""
        return [*self.lists].index(_SILICONE) if _SILICONE in self.lists else None

    def values(self, design: Design) -> dict[str, Any]:
        """Return the values of a design by key, as written."""
        listed = {key: values[k] for (key, values), k in zip(self.lists.items(), design.choice, strict=True)}
        numbers = {each.key: each.text(each.value(x)) for each, x in zip(self.variables, design.x, strict=True)}
        return listed | numbers

    def sensor(self, design: Design) -> Sensor:
        """Return the sensor of a design; raise SceneError where it is impossible."""
        return changed(self.base, self.overrides(self.values(design)))

    def overrides(self, values: Mapping[str, Any]) -> list[str]:
        """Return values by key as overrides of the scene."""
        texts = {key: literal(item) for key, item in values.items()}
        return [f"{name}={text}" for key, text in texts.items() for name in keys_of(self.base, key)]

    def least_sizes(self) -> dict[str, float]:
        """Return the least height and footprint over corners of bounds and choices [m]; empty if they are too many."""
        every = {key: list(values) for key, values in self.lists.items() if key != _SILICONE}
        every |= {each.key: [each.text(each.low), each.text(each.high)] for each in self.variables}
        found: dict[str, float] = {}
        if math.prod(len(values) for values in every.values()) > _CORNERS:
            return found
        for values in _corners(every):
            with suppress(SceneError):
                own = size_of(changed(self.base, self.overrides(values)))
                found = {name: min(size, found.get(name, size)) for name, size in own.items()}
        return found

    def rounded(self, design: Design) -> list[Design]:
        """Return designs of round numbers beside one, the nearest first."""
        found: list[tuple[float, ...]] = [()]
        for variable, x in zip(self.variables, design.x, strict=True):
            found = [(*own, each) for own in found for each in variable.round_neighbours(x)][:_NEAREST]
        return [Design(design.choice, x) for x in found]

    def width(self, variable: Variable, sensor: Sensor) -> float:
        """Return the distance of a variable's bounds in SI."""
        ends = (variable.text(variable.low), variable.text(variable.high))
        low, high = (value_of(changed(sensor, self.overrides({variable.key: end})), variable.key) for end in ends)
        return float(high or 0.0) - float(low or 0.0)

    def words(self, design: Design) -> str:
        """Format a design for a reader: the end of each key and its value."""
        found = self.values(design)
        for each, x in zip(self.variables, design.x, strict=True):
            found[each.key] = f"{each.value(x):.4g} {each.unit}".strip()
        kinds = ((str, str), (int | float, "{:g}".format), (object, json.dumps))
        texts = {key: next(text(item) for kind, text in kinds if isinstance(item, kind)) for key, item in found.items()}
        return ", ".join(f"{key.rpartition('.')[2]} {text}" for key, text in texts.items())


def space_of(sensor: Sensor, table: Mapping[str, Any]) -> Space:
    """Return the designs that bounds, (low, high, unit), and lists of keys allow.

    Raises SceneError when a value leaves no possible scene, or choices are too many.
    """
    for key in filter(_SPACING.__contains__, table):
        raise SceneError(f'vary.{key}: must be a key of one cell, which design solves; a sweep with request = "cells" '
                         f'finds a pitch by its limit; got {shown(table[key])}')
    lists = {key: tuple(item) for key, item in table.items() if isinstance(item, list)}
    variables = [Variable(key, *item) for key, item in table.items() if key not in lists]
    found = Space(sensor, tuple(variables), lists)
    if math.prod(len(values) for values in lists.values()) > _MOST:
        raise SceneError(f"vary: must leave at most {_MOST} choices of its lists; got more")
    _check_values(found)
    return found


def _check_values(space: Space) -> None:
    """Refuse a value that leaves no possible scene, whatever the others are; of some, one that does so by itself."""
    ends = {each.key: (each.text(each.low), each.text(each.high)) for each in space.variables}
    every = {key: list(values) for key, values in (ends | space.lists).items()}
    found = []
    for key, value in ((key, value) for key, values in every.items() for value in values):
        refusal = _refusal(space, every | {key: [value]})
        if refusal is not None:
            found.append((key, value, refusal))
    if found:
        alone = ((*each[:2], _refusal(space, {each[0]: [each[1]]})) for each in found)
        key, value, refusal = next((each for each in alone if each[2] is not None), found[0])
        raise SceneError(f"vary.{key}: {shown(value)} must leave a possible scene; the first one: {refusal}")


def _refusal(space: Space, every: Mapping[str, Sequence[Any]]) -> SceneError | None:
    """Return why no scene of some values is possible; None where one is."""
    first = None
    for values in itertools.islice(_corners(every), 200):
        try:
            changed(space.base, space.overrides(values))
        except SceneError as error:
            first = first or error
        else:
            return None
    return first


def _corners(every: Mapping[str, Sequence[Any]]) -> Iterator[dict[str, Any]]:
    """Yield all combinations of values."""
    return (dict(zip(every, each, strict=True)) for each in itertools.product(*every.values()))
