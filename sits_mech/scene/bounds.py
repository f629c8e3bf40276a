"""Bound the inputs of a scene: one annotated type per kind of input, each refusing bad values by itself.

The bounds are wide: they catch slips of unit and values that would only overflow later, not unusual designs. A part has
the sizes that its shape needs, and no others.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from pydantic import BaseModel, InstanceOf, PlainSerializer

from sits_mech.inputs import Reads, unknown, whole, within
from sits_mech.scene.materials import metals, silicones
from sits_mech.scene.plausible import FREQUENCY, LENGTH, PLACE
from sits_mech.silicone.material import Silicone, constants_elsewhere, silicone_from, table_of
from sits_mech.units import SceneError, shown


def _direction(value: object) -> int:
    """Check a direction of winding."""
    if isinstance(value, int) and not isinstance(value, bool) and value in (1, -1):
        return value
    raise SceneError(f"must be 1 (counter-clockwise seen from above) or -1; got {shown(value)}")


def _name(value: object) -> str:
    """Check a name: short, printable."""
    if isinstance(value, str) and 0 < len(value.strip()) <= 200 and value.isprintable():
        return value
    raise SceneError(f"must be a printable text of 1 to 200 letters; got {shown(value)}")


def _metal_name(value: object) -> str:
    """Check the name of a metal."""
    if isinstance(value, str) and value in metals():
        return value
    raise SceneError(f"{unknown(value, metals())}; another metal is given by its conductivity instead")


def _silicone(value: object) -> str | Silicone:
    """Check the name of a silicone, or make one from a table."""
    if isinstance(value, Silicone) or (isinstance(value, str) and value in silicones()):
        return value
    if isinstance(value, Mapping):
        return silicone_from(value)
    raise SceneError(unknown(value, silicones()))


Length = Annotated[float, within("m", 1e-9, 1e3, 'a length from 1 nm to 1 km, such as "2 mm"'), LENGTH]
Offset = Annotated[float, within("m", 0.0, 1e3, 'zero or a length up to 1 km, such as "0.1 mm"'), LENGTH]
Coordinate = Annotated[float, within("m", -1e3, 1e3, 'a position within 1 km, such as "-4 mm"'), PLACE]
Frequency = Annotated[float, within("Hz", 1e-6, 1e12, 'a frequency from 1 uHz to 1 THz, such as "5 MHz"'), FREQUENCY]
Conductivity = Annotated[float, within("S/m", 1e-9, 1e20, 'a conductivity up to 1e20 S/m, such as "58 MS/m"')]
LossTangent = Annotated[float, within("", 0.0, 10.0, "a loss tangent from 0 to 10")]
Permeability = Annotated[float, within("", 1.0, 1e7, "a relative permeability from 1 to 1e7")]
Permittivity = Annotated[float, within("", 1.0, 1e5, "a relative permittivity from 1 to 1e5")]
Capacitance = Annotated[float, within("F", 1e-15, 1.0, 'a capacitance from 1 fF to 1 F, such as "330 pF"')]
Inductance = Annotated[float, within("H", 0.0, 1.0, 'zero or an inductance up to 1 H, such as "10 nH"')]
Resistance = Annotated[float, within("ohm", 0.0, 1e6, 'zero or a resistance up to 1 Mohm, such as "0.1 ohm"')]
Temperature = Annotated[float, within("K", 1.0, 3e3, 'a temperature from 1 K to 3000 K, such as "20 degC"')]
Coefficient = Annotated[float, within("1/K", -0.1, 0.1, 'a coefficient within 0.1 per kelvin, such as "300 ppm/K"')]
Stretch = Annotated[float, within("", 0.8, 1.25, "a stretch from 0.8 to 1.25, 1 for none")]
Modulus = Annotated[float, within("Pa", 1e3, 1e13, 'a modulus from 1 kPa to 10 TPa, such as "120 GPa"')]
PoissonsRatio = Annotated[float, within("", 0.0, 0.4999, "Poisson's ratio, from 0 to 0.4999")]
Share = Annotated[float, within("", 0.0, 2.0, 'a share from 0 to 2, such as "5 %"')]
Turn = Annotated[float, within("rad", 0.0, 0.5, 'zero or an angle up to 0.5 rad, such as "1 deg"')]
Angle = Annotated[float, within("rad", -3.15, 3.15, 'an angle up to half a turn either way, such as "30 deg"')]
Farads = Annotated[float, within("F", 0.0, 1.0, 'zero or a capacitance up to 1 F, such as "3 pF"')]
PressingForce = Annotated[float, within("N", 1e-9, 1e6, 'a force that presses, up to 1 MN, such as "2 N"')]
Friction = Annotated[float, within("", 0.0, 10.0, "zero or a coefficient of friction up to 10")]
Count = Annotated[int, whole(1, 1000)]
Name = Annotated[str, Reads(_name, {"type": "string", "minLength": 1, "maxLength": 200})]
MetalName = Annotated[str, Reads(_metal_name, {"type": "string"})]
Direction = Annotated[int, Reads(_direction, {"enum": [1, -1]})]
Point = tuple[Coordinate, Coordinate]
Place = tuple[Coordinate, Coordinate, Coordinate]
SiliconeOrName = Annotated[
    InstanceOf[str] | InstanceOf[Silicone], Reads(_silicone, {"type": ["string", "object"]}),
    PlainSerializer(lambda made: table_of(made) if isinstance(made, Silicone) else made),
]
BESIDE_SILICONE = constants_elsewhere()
"""Keys that a table with a silicone has not, and where they stand."""
_SIZES = ("width", "length", "diameter", "inner_diameter", "pitch", "points")


def check_sizes(part: BaseModel, needed: tuple[str, ...], shape: str, keys: tuple[str, ...] = _SIZES) -> None:
    """Refuse a part without the sizes of its shape, or with those of another one, of `keys`."""
    for key in keys:
        value = getattr(part, key, None)
        if (value is not None) != (key in needed):
            come = "it is missing" if key in needed else f"got {shown(value)}"
            raise SceneError(f"{key} must {'' if key in needed else 'not '}be given for {shape}; {come}")


def extent_of(width: float | None, length: float | None, diameter: float | None) -> tuple[float, float]:
    """Return the size along x and y [m] of a rectangle or a disc."""
    if diameter is not None:
        return diameter, diameter
    return width or 0.0, length or 0.0
