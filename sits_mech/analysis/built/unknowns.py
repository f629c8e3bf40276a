"""Name what may be unknown of a bench and its sensor, and read what is known of it: "gap = 0 +- 0.3 mm".

What each does to the readings is in `setup` and `loaded`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.scene.parameters import value_of
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.units import quantity, shown, si_label, split_quantity

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
_LOADED = ("modulus", *LAYER, *CELL)
_PRIOR = re.compile(r"\s*([\w.*]+)\s*(?:=\s*(.+?)\s*(?:\+-|\+/-|±)\s*(.+?)\s*)?")


@dataclass(frozen=True)
class Known:
    """A parameter with what is known of it beforehand: value and standard deviation [SI], or neither."""

    name: str
    value: float | None = None
    deviation: float = np.inf


def known(text: str) -> Known:
    """Read a parameter: ``gap``, ``gap = 0 +- 0.3 mm``, ``target.width = 8 mm +- 20 um``.

    Raises SceneError for anything else, or a deviation that is not positive and of the same dimension.
    """
    match = _PRIOR.fullmatch(text)
    if match is None or (match[1] not in PARAMETERS and "." not in match[1]):
        names = ", ".join(PARAMETERS)
        raise SceneError(f'fit: must be {names} or a key of the scene, or "gap=0+-0.3 mm"; got {shown(text.strip())}')
    if match[2] is None:
        return Known(match[1])
    unit = split_quantity(match[3], match[1])[1]
    value, deviation = (
        each if split_quantity(each, match[1])[1] else f"{each} {unit}".strip() for each in (match[2], match[3])
    )
    if match[1] in PARAMETERS:
        found = [quantity(each, PARAMETERS[match[1]], f"fit: {match[1]}") for each in (value, deviation)]
    else:
        labels = [si_label(each) for each in (value, deviation)]
        found = [float(each) if isinstance(each, int | float) else np.nan for each in labels]
    if not found[1] > 0.0 or not np.isfinite(found[0]):
        raise SceneError(f"fit: {match[1]}: must be a value +- a deviation above zero; got {shown(text.strip())}")
    return Known(match[1], *found)


def checked(sensor: Sensor, texts: Sequence[str], posed: bool) -> tuple[Known, ...]:
    """Return the parameters of texts (see `known`); `posed` tells that poses were measured, not loads.

    Raises SceneError when there is none, one comes twice, does not fit such a bench, or a key is no number of the scene
    or has no deviation.
    """
    found = tuple(known(text) for text in texts)
    names = [each.name for each in found]
    if not found or len({*names}) < len(names):
        raise SceneError(f"fit: must be one or more different parameters; got {', '.join(names) or 'none'}")
    for each in found:
        if each.name in _LOADED and posed:
            raise SceneError(f"fit: {each.name}: must be of loads; got a bench of poses")
        if each.name.startswith("axis") and not posed:
            raise SceneError(f"fit: {each.name}: must be of poses that stages set; got a bench of loads")
        if each.name not in PARAMETERS and each.value is None:
            raise SceneError(f'fit: {each.name}: must come with what is known, "{each.name}=value +- deviation"')
        if each.name not in PARAMETERS and value_of(sensor, each.name) is None:
            raise SceneError(f"fit: {each.name}: must be a number that the scene gives; it gives none")
    return found
