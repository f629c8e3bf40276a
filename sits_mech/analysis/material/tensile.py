"""Read strain and engineering stress of a tensile test, by content, from a text file.

Columns (see `columns`) are known by their names, upper or lower case, in any order:

    [test] engineering strain (-), (mm/mm) or (%)     or without a unit; "nominal" for "engineering" as well
    [test] engineering stress (Pa), (kPa), (MPa), (N/mm2) or (psi)

where the test is nothing or "uniaxial", "planar" (or "pure shear"), "biaxial" (or "equibiaxial"). What else the file
holds is passed over. Each test is kept up to its largest stress, that is without the break, and with rising strain.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sits_mech.analysis.columns import headed, number_rows
from sits_mech.memory import input_text
from sits_mech.quantities import Array

UNITS = {
    "strain": ({"": 1.0, "-": 1.0, "1": 1.0, "mm/mm": 1.0, "m/m": 1.0, "%": 1e-2}, "a plain number or in %"),
    "stress": (
        {"pa": 1.0, "kpa": 1e3, "mpa": 1e6, "n/mm2": 1e6, "n/mm^2": 1e6, "psi": 6894.757293168},
        "in Pa, kPa, MPa, N/mm2 or psi",
    ),
}
"""Factors to SI of the units of a column, and what it must be in."""
_NAMES = {"uniaxial": "uniaxial", "planar": "planar", "pure shear": "planar", "biaxial": "biaxial"}
_COLUMN = re.compile(
    r"(?:(?P<test>uniaxial|planar|pure shear|(?:equi-?)?biaxial)\s+)?(?:engineering|nominal)\s+(?P<what>strain|stress)"
    r"\s*(?:[(\[]\s*(?P<unit>[^)\]]*?)\s*[)\]])?",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class TensileTest:
    """A tensile test, with those of the same silicone in other modes."""

    strain: Array  # engineering, (n,), increasing
    stress: Array  # engineering, (n,) [Pa]
    source: str  # file
    mode: str = "uniaxial"  # "uniaxial", "planar" or "biaxial"
    others: tuple[TensileTest, ...] = ()


class _Columns(NamedTuple):
    """Mode of a test, places of its strain and stress, and the factors of their units to SI."""

    mode: str
    places: list[int]
    factors: list[float]


def read_tensile(path: str | Path) -> TensileTest:
    """Read a tensile test: a header of any length, a row of column names, numbers; other modes beside it.

    The uniaxial test comes first, else the first of the file. Raise ValueError if the file cannot be read, columns are
    missing or of unknown unit, or a test has fewer than 5 usable rows.
    """
    lines = input_text(path, "a readable tensile test", errors="replace").splitlines()
    found = headed(lines, lambda names: _columns(names, str(path)))
    if found is None:
        what = 'must have the columns "Engineering Strain" and "Engineering Stress (MPa)"'
        raise ValueError(f"{path}: {what}; got none with these names")
    first, *others = (_test(found[0], found[1], columns, str(path)) for columns in found[2])
    return replace(first, others=tuple(others))


def _columns(names: list[str], source: str) -> list[_Columns]:
    """Return the tests announced by a row of column names, uniaxial first; none if it is no such row."""
    cells: dict[tuple[str, str], tuple[int, str]] = {}
    for index, name in enumerate(names):
        match = _COLUMN.fullmatch(name)
        if match is not None:
            test = re.sub("equi-?", "", (match["test"] or "uniaxial").lower())
            cells.setdefault((_NAMES[test], match["what"].lower()), (index, match["unit"] or ""))
    found = []
    for mode in ("uniaxial", "planar", "biaxial"):
        own = {what: cells[mode, what] for what in UNITS if (mode, what) in cells}
        if len(own) == len(UNITS):
            factors = [unit_of(names[place], unit, *UNITS[what], source) for what, (place, unit) in own.items()]
            found.append(_Columns(mode, [place for place, _ in own.values()], factors))
    return found


def unit_of(name: str, unit: str, units: dict[str, float], needed: str, source: str) -> float:
    """Return the factor of a column's unit to SI; refuse it, stating what is needed."""
    if unit.lower() not in units:
        raise ValueError(f'{source}: column "{name}" must be {needed}; got "{unit}"')
    return units[unit.lower()]


def _test(lines: Sequence[str], separator: str, columns: _Columns, source: str) -> TensileTest:
    """Return the rows that hold numbers, up to the largest stress."""
    data = number_rows(lines, separator, columns.places, source) * columns.factors
    data = data[np.isfinite(data).all(axis=1)]
    data = data[: int(np.argmax(np.r_[data[:, 1], -np.inf])) + 1]
    rising = data[:, 0] > np.maximum.accumulate(np.r_[-1.0, data[:-1, 0]])
    if (count := np.count_nonzero(rising)) < 5:
        must = f"must hold at least 5 rows of rising strain in the {columns.mode} test"
        raise ValueError(f"{source}: {must}; got {count}")
    return TensileTest(data[rising, 0], data[rising, 1], source, columns.mode)
