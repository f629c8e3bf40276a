"""Convert written quantities: units live at the edge of the package; inside, all is SI and radians.

A quantity is a plain number, taken as SI, or a string of a number and a unit such as ``"2 mm"``, ``"5 MHz"``,
``"30 kPa"`` or ``"10 deg"``. The SI unit itself, its powers of ten and a few more are read at once; every other unit is
converted by pint, which takes a third of a second to come.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from functools import cache
from numbers import Real
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from pint import UnitRegistry

Read = TypeVar("Read")
MM = 1e3  # millimetres in a metre
SLACK = 1e-9  # relative: lengths that are equal as written may differ by rounding
_FACTOR = r"(?:[A-Za-zµμΩ°]+|%(?!.*%))(?:(?:\^|\*\*)-?[1-9]|[23²³])?"
_QUANTITY = re.compile(
    rf"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{{1,3}})?)\s*((?:(?<=\s)1\s*/\s*)?{_FACTOR}(?:\s*[*/·]\s*{_FACTOR}|\s+{_FACTOR})*)?\s*"
)
QUANTITY_PATTERN = f"^{_QUANTITY.pattern}$"
"""What a number with an optional unit looks like, for schemas."""
_KINDS = {
    "m": 'a length, such as "2 mm"',
    "m^2": 'an area, such as "24 mm^2"',
    "Hz": 'a frequency, such as "5 MHz"',
    "N": 'a force, such as "2 N"',
    "N*m": 'a moment, such as "1 N*mm"',
    "Pa": 'a pressure, such as "30 kPa"',
    "rad": 'an angle, such as "10 deg"',
    "S/m": 'a conductivity, such as "58 MS/m"',
    "H": 'an inductance, such as "3 uH"',
    "F": 'a capacitance, such as "330 pF"',
    "ohm": 'a resistance, such as "1 ohm"',
    "s": 'a time, such as "1 ms"',
    "K": 'a temperature, such as "20 degC"',
    "1/Pa": 'a compressibility, such as "0.1 1/MPa"',
    "1/K": 'a coefficient, such as "300 ppm/K"',
    "": "a plain number",
}
_NEAR_BY = {("%", ""): 1e-2, ("deg", "rad"): math.pi / 180.0, ("N*mm", "N*m"): 1e-3, ("MS/m", "S/m"): 1e6}
ZERO_CELSIUS = 273.15  # K
_POWER = re.compile(r"(?<=[A-Za-zµμ])([23²³])")  # as in N/mm2
_SQUARES = str.maketrans("²³·", "23*")
_CELSIUS = ("degC", "°C")
_MOST = 10_000  # values of a range
_PREFIXES = {"": 1.0, "G": 1e9, "M": 1e6, "k": 1e3, "m": 1e-3, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "n": 1e-9, "p": 1e-12}


class SceneError(ValueError):
    """A scene, or a quantity in it, that cannot be used; the message is one line: where, what it must be, what came.

    Examples
    --------
    >>> try:
    ...     sm.load_sensor("biorob2018", ["target.thickness=thin"])
    ... except sm.SceneError as error:
    ...     print(error)
    biorob2018: target.thickness: must be a length, such as "2 mm", or a finite number [m]; got "thin"
    """


@cache
def _registry() -> UnitRegistry[float]:
    """Return the one pint registry."""
    from pint import UnitRegistry

    return UnitRegistry()


def printable(text: str, length: int = 200) -> str:
    """Return `text` on one line, cut to `length` characters, with a question mark for what cannot be printed."""
    line = " ".join("".join(letter if letter.isprintable() or letter.isspace() else "?" for letter in text).split())
    return line if len(line) <= length else line[: length - 3] + "..."


def shown(value: object) -> str:
    """Return `value` about as it would be written in a scene file, on one line and short."""
    return printable(f'"{value}"' if isinstance(value, str) else repr(value), length=60)


def millimetres(length: float, digits: int = 6) -> str:
    """Return a length [m] as it is written in a scene."""
    return f"{MM * length:.{digits}g} mm"


def _converted(number: float, unit: str, into: str) -> float:
    """Return `number` in SI, or NaN where `unit` does not exist or is of another dimension."""
    factor = _PREFIXES.get(unit.removesuffix(into)) if into.isalpha() and unit.endswith(into) else None
    factor = _NEAR_BY.get((unit, into), 1.0 if unit == into else factor)
    if factor is not None:
        return float(f"{number * factor:.15g}")
    if into == "K" and unit in _CELSIUS:
        return float(f"{number + ZERO_CELSIUS:.15g}")
    from pint import PintError

    try:
        # fifteen digits, so that 85 um is 8.5e-05 m and not its neighbour; pint's mil is an angle
        pints = "thou" if (unit, into) == ("mil", "m") else _POWER.sub(r"**\1", unit).translate(_SQUARES)
        return float(f"{_registry().convert(number, pints, into):.15g}")
    except (PintError, AttributeError, ArithmeticError, ValueError, AssertionError):  # the last of "dB/m"
        return math.nan


def si_value(value: object, unit: str) -> float:
    """Return a number, or a string of a number with an optional unit, in the SI `unit`; "" for a plain number.

    Raise SceneError, saying what it must be and what came, for other dimensions and what is not finite.
    """
    number = math.nan
    if isinstance(value, int | float) and not isinstance(value, bool):
        number = float(value) if abs(value) < 1e300 else math.nan
    elif isinstance(value, str) and (match := _QUANTITY.fullmatch(value[:100])):
        number = float(match[1])
        if match[2]:
            number = _converted(number, match[2], unit)
    if not math.isfinite(number):
        plain = f", or a finite number [{unit}]" if unit else ""
        raise SceneError(f"must be {_KINDS.get(unit, f'a quantity in {unit}')}{plain}; got {shown(value)}")
    return number


def quantity(value: object, unit: str, name: str) -> float:
    """Return a written quantity in SI; `name`, such as "--fx", stands first in the error that `si_value` raises."""
    return _of(name, si_value, value, unit)


def _of(name: str, read: Callable[[Any, str], Read], written: object, unit: str) -> Read:
    """Return what is read in a unit, with a name first in the error."""
    try:
        return read(written, unit)
    except SceneError as error:
        raise SceneError(f"{name}: {error}") from None


def checked_tolerance(tolerance: float, least: float = 0.0) -> float:
    """Return an asked relative error; raise SceneError unless above zero, at least `least` and below one."""
    if not (isinstance(tolerance, Real) and 0.0 < tolerance < 1.0 and tolerance >= least):
        raise SceneError(f"tolerance must lie between {least:g} and 1; got {shown(tolerance)}")
    return float(tolerance)


def quantity_range(text: str, unit: str, name: str) -> list[float]:
    """Return the values of a range as `si_range`; `name` stands first in the error."""
    return _of(name, si_range, text, unit)


def si_range(text: str, unit: str) -> list[float]:
    """Return the values of ``"first:last:count"`` such as "-1 N:1 N:9", evenly spaced, or of one quantity [unit].

    An exact mirror image of itself when its ends are. Raise SceneError: what it must be, what came.
    """
    parts = text.split(":")
    ends = [si_value(part, unit) for part in parts[:2]]
    if len(parts) == 1:
        return ends
    if len(parts) != 3 or not parts[2].strip().isdecimal() or not 1 < int(parts[2]) <= _MOST or ends[0] == ends[1]:
        example = "-10 degC:60 degC:8" if unit == "K" else "0 N:4 N:9"
        form = f'first:last:count with two different ends and a count from 2 to {_MOST}, such as "{example}"'
        raise SceneError(f"must be {form}, or one quantity; got {shown(text)}")
    import numpy as np  # not before the command line has set how many threads

    values = np.linspace(ends[0], ends[1], int(parts[2]))
    return [float(value) for value in ((values - values[::-1]) / 2 if ends[0] == -ends[1] else values)]


def frequency_range(text: str, name: str) -> list[float]:
    """Return the frequencies of a written range, evenly spaced in their logarithm [Hz]; raise as `quantity_range`."""
    values = quantity_range(text, "Hz", name)
    if min(values) <= 0.0:
        raise SceneError(f"{name}: must be a positive frequency, or two as first:last:count; got {text!r}")
    import numpy as np

    return values if len(values) == 1 else [float(f) for f in np.geomspace(values[0], values[-1], len(values))]


def quantity_or_range(text: str, unit: str, name: str) -> float | list[float]:
    """Return the value of a written quantity, or the values of a written range; as `quantity_range`."""
    found = quantity_range(text, unit, name)
    return found[0] if len(found) == 1 else found


def split_quantity(value: object, name: str) -> tuple[float, str]:
    """Return number and unit of a written quantity, "" where it has none; raise SceneError, naming `name`."""
    if isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value):
        return float(value), ""
    match = _QUANTITY.fullmatch(value[:100]) if isinstance(value, str) else None
    if match is None:
        raise SceneError(f'{name}: must be a number, or a number with a unit such as "2 mm"; got {shown(value)}')
    return float(match[1]), match[2] or ""


def si_label(value: object) -> object:
    """Return a written quantity of any dimension as its number in SI, and anything else as it is or as its text."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return str(value)
    if not isinstance(value, str):
        return float(value)
    match = _QUANTITY.fullmatch(value[:100])
    if match is None:
        return value
    if not match[2]:
        return float(match[1])
    unit = _si_of(match[2])
    return _converted(float(match[1]), match[2], unit) if unit else value


def si_unit(value: object) -> str:
    """Return the SI unit that `si_label` gives a written quantity in, "" where it has none."""
    match = _QUANTITY.fullmatch(value[:100]) if isinstance(value, str) else None
    return _si_of(match[2]) if match is not None and match[2] else ""


def is_unit(text: str) -> bool:
    """Whether a text is a unit of one of the dimensions here, or of a plain number."""
    return text in ("", "-", "1", "%") or bool(len(text) < 98 and _QUANTITY.fullmatch(f"1 {text}") and _si_of(text))


def _si_of(unit: str) -> str:
    """Return the SI unit of a unit's dimension, "" where it is none of those here."""
    return next((kind for kind in _KINDS if kind and math.isfinite(_converted(1.0, unit, kind))), "")
