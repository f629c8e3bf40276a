"""Which pours can a scene hold? Plates parallel to the coils, clear of them and of each other; the rest is told.

A pour is a rectangle or a disc where it fills 98 % of its bounding box or of the circle in a square one, which is what
the rounded corners of a fill leave. Of others the box is taken, and how much of it is copper is told: notches, slots
and holes are lost. What would then touch a coil or a larger plate is left out, and so are islands below 1 % of the area
of the coils' box: what a small plate takes of an inductance goes with the 3/2 power of that, 0.1 % at most.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sits_mech.boards.pours import Pour
from sits_mech.boards.stackup import Layer
from sits_mech.quantities import Array
from sits_mech.scene.apart import check_parts
from sits_mech.scene.parts import Conductor
from sits_mech.scene.sensor import Sensor
from sits_mech.units import SceneError

_SMALL = 0.01  # of the coils' box, an island's area
_FULL = 0.98  # of a shape that a fill with rounded corners stands for
_DIGITS = 10  # of lengths: a tenth of the board's own step
Tables = list[dict[str, Any]]


def plates(
    sensor: Sensor, poured: Sequence[Pour], stack: Mapping[str, Layer], origin: Array, top: float
) -> tuple[Tables, tuple[str, ...]]:
    """Return the conductors that stand for pours, and what to say of them.

    Parameters
    ----------
    sensor : Sensor
        The coils, which plates must be clear of.
    poured : sequence of Pour
    stack : mapping
        Heights of the board's layers.
    origin : ndarray, shape (2,)
        Of the scene on the board [m].
    top : float
        z = 0 of the scene, in the board's heights [m].
    """
    found: Tables = []
    kept: list[Conductor] = []
    notes = []
    least = _SMALL * _box(sensor)
    small = [pour.area for pour in poured if pour.area < least]
    if small:
        all_of = f"{1e6 * sum(small):.3g} mm2 together"
        notes.append(f"{len(small)} pours of less than {1e6 * least:.3g} mm2: left out, {all_of}")
    for pour in sorted((item for item in poured if item.area >= least), key=lambda item: -item.area):
        table, share = _table(pour, stack[pour.layer], origin, top)
        table["name"] = _free(f"{pour.net or 'copper'} {pour.layer}", [item["name"] for item in found])
        plate = Conductor.model_validate(table)
        title = f"pour of {pour.net or 'no net'} on {pour.layer}, {1e6 * pour.area:.4g} mm2"
        try:
            check_parts(sensor.coils, None, None, (*kept, plate), None)
        except SceneError as error:
            notes.append(f"{title}: left out, its bounding box does not fit: {str(error).partition(', which')[0]}")
            continue
        found.append(table)
        kept.append(plate)
        if share < _FULL:
            count = len(pour.holes)
            lost = f", slots and {count} hole{'s' * (count > 1)}" if count else ""
            notes.append(f"{title}: taken as its bounding box, of which it fills {share:.0%}; notches{lost} are lost")
    return found, tuple(notes)


def _box(sensor: Sensor) -> float:
    """Return the area of the box around all coils [m^2]."""
    middle = np.array([coil.centre for coil in sensor.coils])
    half = np.array([coil.extent for coil in sensor.coils]) / 2
    return float(np.prod((middle + half).max(axis=0) - (middle - half).min(axis=0)))


def _table(pour: Pour, layer: Layer, origin: Array, top: float) -> tuple[dict[str, Any], float]:
    """Return the table of a plate, and how much of it is copper."""
    low, high = pour.rim.min(axis=0), pour.rim.max(axis=0)
    x, y = (round(float(v), _DIGITS) + 0.0 for v in (low + high) / 2 - origin)
    width, length = (round(float(v), _DIGITS) for v in high - low)
    table: dict[str, Any] = {"name": "", "material": "copper", "shape": "rectangle"}
    sizes, share = {"width": width, "length": length}, pour.area / float(np.prod(high - low))
    round_share = share * 4.0 / math.pi
    if abs(width - length) < (1.0 - _FULL) * width and _FULL < round_share < 2.0 - _FULL:
        table, sizes, share = table | {"shape": "disc"}, {"diameter": max(width, length)}, round_share
    centre = [x, y, round(layer.z - top, _DIGITS)]
    return table | {"centre": centre} | sizes | {"thickness": round(layer.thickness, _DIGITS)}, share


def _free(name: str, taken: Sequence[str]) -> str:
    """Return a name that is not taken, with a number where it must be."""
    numbered = (name if k == 1 else f"{name} {k}" for k in range(1, len(taken) + 2))
    return next(one for one in numbered if one not in taken)
