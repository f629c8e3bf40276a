"""Read a test over time, by content, from a file: time, strain and engineering stress in their order.

Columns (see `columns`) are known by their names, upper or lower case, in any order:

    time (s), (ms), (min) or (h)
    engineering strain (-), (mm/mm) or (%)      or "nominal"; or stretch (-), which is one without load
    engineering stress (Pa), (kPa), (MPa), (N/mm2) or (psi)

Uniaxial, tension or compression (negative). What else the file holds is passed over.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sits_mech.analysis.columns import headed, number_rows
from sits_mech.analysis.material.tensile import UNITS, unit_of
from sits_mech.memory import input_text
from sits_mech.quantities import Array

_COLUMN = re.compile(
    r"(?P<what>time|stretch|(?:engineering|nominal)\s+(?:strain|stress))\s*(?:[(\[]\s*(?P<unit>[^)\]]*?)\s*[)\]])?",
    re.IGNORECASE,
)
_UNITS = {
    "time": ({"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0}, "in s, ms, min or h"),
    "stretch": UNITS["strain"],
    **UNITS,
}
_LEAST = 8  # rows


@dataclass(frozen=True)
class Record:
    """A uniaxial test over time."""

    time: Array  # (n,), not descending [s]; row number if the file has none
    strain: Array  # engineering, (n,)
    stress: Array  # engineering, (n,) [Pa]
    source: str  # file
    timed: bool = True  # the file has a time


def read_record(path: str | Path, *, timed: bool = True) -> Record:
    """Read a test over time by content; `timed`: a column of time is required.

    Raise ValueError if the file cannot be read, columns are missing or of unknown unit, fewer than 8 rows are numbers,
    a stretch is not positive, or time stands still or runs back.
    """
    lines = input_text(path, "a readable test over time", errors="replace").splitlines()
    found = headed(lines, lambda names: _columns(names, str(path), timed))
    if found is None:
        what = '"Time (s)", ' * timed + '"Engineering Strain" and "Engineering Stress (kPa)"'
        raise ValueError(f"{path}: must have the columns {what}; got none with these names")
    return _record(*found, str(path))


def _columns(names: list[str], source: str, timed: bool) -> dict[str, tuple[int, float, float]]:
    """Return place, factor to SI and offset of each column in a row of names, by quantity; none if one is missing."""
    found: dict[str, tuple[int, float, float]] = {}
    for index, name in enumerate(names):
        match = _COLUMN.fullmatch(name)
        if match is None:
            continue
        what = match["what"].lower().split()[-1]
        key, units = "strain" if what == "stretch" else what, _UNITS[what]
        unit = match["unit"] or ("s" if what == "time" else "")
        found.setdefault(key, (index, unit_of(name, unit, *units, source), -1.0 if what == "stretch" else 0.0))
    return found if {"strain", "stress", "time" if timed else "strain"} <= {*found} else {}


def _record(lines: Sequence[str], separator: str, columns: dict[str, tuple[int, float, float]], source: str) -> Record:
    """Return the rows that hold numbers, or refuse them as no test."""
    keys = [key for key in ("time", "strain", "stress") if key in columns]
    places, factors, offsets = zip(*(columns[key] for key in keys), strict=True)
    data = number_rows(lines, separator, places, source) * factors + offsets
    data = data[np.isfinite(data).all(axis=1)]
    if len(data) < _LEAST:
        raise ValueError(f"{source}: must hold at least {_LEAST} rows of numbers; got {len(data)}")
    values = dict(zip(keys, data.T, strict=True))
    time = values.get("time", np.arange(float(len(data))))
    if not np.all(np.diff(time) > 0.0):
        back = int(np.argmin(np.diff(time) > 0.0))
        raise ValueError(f"{source}: time must rise; got {time[back]:g} s and then {time[back + 1]:g} s")
    if not np.all(values["strain"] > -1.0):
        raise ValueError(f"{source}: strain must be above -1; got {values['strain'].min():g}")
    return Record(time, values["strain"], values["stress"], source, "time" in keys)
