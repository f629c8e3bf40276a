"""Read columns of numbers from files as machines write them: a header of any length, a row of names, rows of numbers.

Separated by semicolons, tabs or commas; cells may be in quotes; where no comma separates them one may be the point.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from sits_mech.quantities import Array
from sits_mech.units import SceneError, shown

_Known = TypeVar("_Known")
_GROUPED = re.compile(r"[-+]?\d[\d., ']*")  # as numbers are written that none of ours can be


def headed(lines: Sequence[str], known: Callable[[list[str]], _Known]) -> tuple[Sequence[str], str, _Known] | None:
    """Return the lines from the first row of names on, their separator, and what is `known` by the names; else None."""
    for number, line in enumerate(lines):
        for separator in ";\t,":
            if found := known(cells_of(line, separator)):
                return lines[number:], separator, found
    return None


def cells_of(line: str, separator: str) -> list[str]:
    """Return the cells of a line without quotes and spaces about them."""
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]
    except csv.Error:  # longer than any cell of ours
        return []


def number(cell: str, separator: str) -> float:
    """Return the number of a cell; raise ValueError where there is none."""
    return float(cell if separator == "," else cell.replace(",", "."))


def number_rows(lines: Sequence[str], separator: str, places: Sequence[int], source: str) -> Array:
    """Return the numbers, or nan, at some places of rows that hold them, (n, places); grouped digits are refused."""
    rows = list[list[float]]()
    for line in lines:
        cells = cells_of(line, separator)
        own, odd = [cells[place] for place in places if place < len(cells)], list[str]()
        rows.append([])
        for cell in own:
            try:
                rows[-1].append(number(cell, separator))
            except ValueError:
                odd.append(cell)
        if odd and all(map(_GROUPED.fullmatch, odd)):
            raise SceneError(f"{source}: rows must hold plain numbers, such as 1234.5; got {shown(line.strip())}")
    return np.array([row for row in rows if len(row) == len(places)]).reshape(-1, len(places))
