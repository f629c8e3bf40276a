"""Which numbers of a scene can go up and down a little, by what key, and what is the scene then?

Keys are those of scene and study files, with dots; `*` stands for every entry of a list: ``coils.*.track_width`` goes
up by as much in every coil.
"""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from sits_mech.scene.sensor import SceneError, Sensor, changed, scene_text
from sits_mech.units import shown

Numbers = tuple[tuple[str, float], ...]


@lru_cache(maxsize=64)
def numbers_at(sensor: Sensor, key: str) -> Numbers:
    """Return the numbers that a key names: the full key of each, and its value in SI units.

    Parameters
    ----------
    sensor : Sensor
    key : str
        Such as "target.width", "coils.C1.centre.0" or "coils.*.inner_diameter".

    Raises
    ------
    SceneError
        If the scene has none there, or a count or a name, which do not go up and down a little.
    """
    found = _found(tomllib.loads(scene_text(sensor)), key.split("."), ())
    if not found:
        raise SceneError(f"lengths: {shown(key)} must be a number that the scene gives, such as 'target.width'")
    for name, value in found:
        if not isinstance(value, float):
            raise SceneError(f"lengths: {name} must be a number that can go up and down a little; got {shown(value)}")
    return tuple(found)


def moved(sensor: Sensor, keys: Sequence[str], by: float) -> Sensor:
    """Return the scene with every number of some keys larger by as much; raises SceneError as `changed`, `numbers_at`.

    Parameters
    ----------
    sensor : Sensor
    keys : sequence of str
        As of `numbers_at`.
    by : float
        In the numbers' SI unit.
    """
    numbers = [number for key in keys for number in numbers_at(sensor, key)]
    return changed(sensor, [f"{name}={value + by!r}" for name, value in numbers])


def _found(part: Any, steps: list[str], way: tuple[str, ...]) -> list[tuple[str, Any]]:
    """Names and values at the end of some steps down from a part; none where the scene has no such key."""
    if not steps:
        return [(".".join(way), part)]
    step, *rest = steps
    if isinstance(part, list):
        names = [entry.get("name") if isinstance(entry, dict) else None for entry in part]
        some = [k for k in range(len(part)) if step in ("*", names[k] if step in names else str(k))]
        return [each for k in some for each in _found(part[k], rest, (*way, str(k)))]
    return _found(part[step], rest, (*way, step)) if isinstance(part, dict) and step in part else []
