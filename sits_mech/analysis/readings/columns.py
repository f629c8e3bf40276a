"""Read tables of numbers as machines write them: a header of any length, a row of names, one of units, rows of numbers.

Separated by semicolons, tabs or commas; cells may be in quotes; where no comma separates them one may be the point.
A unit is in brackets behind its name ("Kraft [N]", also "Kraft in N", "Kraft/N"), or in a row of its own below the
names. Text is UTF-8, UTF-16, or of Windows: western European (cp1252), or Japanese (cp932) where the names are known in
that alone.
"""

from __future__ import annotations

import csv
import re
import unicodedata
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from sits_mech.memory import input_bytes
from sits_mech.quantities import Array
from sits_mech.units import SceneError, is_unit, printable, shown

_Known = TypeVar("_Known")
_GROUPED = re.compile(r"[-+]?\d[\d., ']*")  # as numbers are written that none of ours can be
_TITLE = re.compile(r"(.*?)\s*(?:[(\[]\s*([^()\[\]]*?)\s*[)\]])?")
_BEHIND = re.compile(r"(.+?)\s*(?:\s(?:in|en)\s|[/,])\s*(\S+)")  # as in "Kraft in N"
_UNITS = {"sec": "s", "sek": "s", "秒": "s", "minute": "min", "minutes": "min", "-": "", "1": ""}


@dataclass(frozen=True)
class Column:
    """A column of a table: its place, its title as it is written, the title without a unit in small letters, its unit.

    A unit is "" where none is written.
    """

    place: int
    title: str
    name: str
    unit: str


@dataclass(frozen=True)
class TextTable:
    """A table of a file: the cells of the lines above its names, its columns, and its rows as they are written."""

    source: str
    above: Sequence[list[str]]
    columns: Sequence[Column]
    rows: Sequence[str]
    separator: str

    def numbers(self, places: Sequence[int]) -> Array:
        """Return the numbers, or nan, at some places of rows that hold them, (n, places)."""
        return number_rows(self.rows, self.separator, places, self.source)


def read_tables(
    path: str | Path, what: str, known: Callable[[Sequence[Column]], _Known]
) -> list[tuple[TextTable, _Known]]:
    """Return the tables of a file below each row of names by which anything is `known`; none without such a row.

    `what` the file must be. Raise SceneError when it cannot be read.
    """
    for lines, separator in _ways(path, what):
        at: list[tuple[int, _Known]] = []
        for k, line in enumerate(lines):
            if _may_name(line, separator, bool(at)) and (hit := known(_columns(lines, k, separator))):
                at.append((k, hit))
        if at:
            edges = [0, *(k for k, _ in at), len(lines)]
            return [
                (_table(str(path), lines[before:after], k - before, separator), hit)
                for (k, hit), before, after in zip(at, edges, edges[2:], strict=False)
            ]
    return []


def _table(source: str, lines: Sequence[str], k: int, separator: str) -> TextTable:
    """Return the table whose names are line k."""
    first = k + 1 + bool(_unit_row(lines[k + 1 : k + 2], separator))
    rows = [line for line in lines[first:] if not line.lstrip().startswith("#")]
    above = [line_cells(line, separator) for line in lines[:k]]
    return TextTable(source, above, _columns(lines, k, separator), rows, separator)


def _may_name(line: str, separator: str, again: bool) -> bool:
    """Whether a line may hold names of columns, `again` after others: then none of its cells is a number."""
    if line.lstrip().startswith("#") or not any(letter.isalpha() for letter in line):
        return False
    return not (again and any(_is_number(cell, separator) for cell in line_cells(line, separator)))


def names_found(path: str | Path, what: str) -> str:
    """Return, for messages, the row of words that stands above the first two rows of numbers of a file."""
    for lines, separator in _ways(path, what):
        counts = [sum(_is_number(cell, separator) for cell in line_cells(line, separator)) for line in lines[:1000]]
        for k in range(1, len(counts) - 1):
            if min(counts[k : k + 2]) > 1 and (words := [j for j in range(k) if not counts[j]]):
                last = words[-1] if not _unit_row([lines[words[-1]]], separator) or len(words) < 2 else words[-2]
                return printable(", ".join(filter(None, line_cells(lines[last], separator))))
    return "no row of names above rows of numbers"


def plain(text: str) -> str:
    """Return a text in small letters without accents and marks, for comparing words; "ae" is "a" as in umlauts."""
    letters = unicodedata.normalize("NFD", unicodedata.normalize("NFKC", text).casefold())
    letters = "".join(letter for letter in letters if not unicodedata.combining(letter))
    return " ".join(re.sub(r"(?<=[aou])e", "", re.sub(r"[\s_.:/-]+", " ", letters)).split())


def titled(title: str) -> tuple[str, str]:
    """Return the name in small letters and the unit of a title; units of the names that machines give them are ours."""
    match = _TITLE.fullmatch(unicodedata.normalize("NFKC", title).strip())
    name, unit = (title, "") if match is None else (match[1], _unit(match[2] or ""))
    behind = None if unit else _BEHIND.fullmatch(name)
    if behind is not None and is_unit(behind[2]):
        name, unit = behind[1], behind[2]
    return name.casefold(), unit


def _unit(written: str) -> str:
    """Return a unit as it is known here."""
    unit = unicodedata.normalize("NFKC", written).strip(" ()[].")
    return _UNITS.get(unit.casefold(), unit)


def _ways(path: str | Path, what: str) -> Iterator[tuple[list[str], str]]:
    """Return the lines of a file that hold anything, by each of the ways that it may be encoded and separated."""
    content = input_bytes(path, what)
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        ways = ["utf-16"]
    elif 3 * content[:1000].count(0) > len(content[:1000]):
        ways = ["utf-16-le" if content[1:1000:2].count(0) > content[:1000:2].count(0) else "utf-16-be"]
    else:
        try:
            content.decode("utf-8-sig")
            ways = ["utf-8-sig"]
        except UnicodeDecodeError:
            ways = ["cp1252", "cp932"]
    for way in ways:
        lines = [line for line in content.decode(way, "replace").splitlines() if line.strip(" ;,\t")]
        yield from ((lines, separator) for separator in ";\t,")


def _columns(lines: Sequence[str], k: int, separator: str) -> list[Column]:
    """Return the columns by the names in a line, and units by the next line where it holds them."""
    below = _unit_row(lines[k + 1 : k + 2], separator)
    columns = []
    for place, title in enumerate(line_cells(lines[k], separator)):
        name, unit = titled(title)
        if own := "".join(below[place : place + 1]):  # and brackets in the title may say which strain it is
            name, unit = name if is_unit(unit) else title.casefold(), own
        columns.append(Column(place, title, name, unit))
    return columns


def _unit_row(lines: Sequence[str], separator: str) -> list[str]:
    """Return the units of a line whose cells hold them, most of them known; none of another line."""
    units = [_unit(cell) for line in lines for cell in line_cells(line, separator)]
    written = [unit for unit in units if unit]
    if not written or any(_is_number(unit, separator) for unit in written):
        return []
    return units if 2 * sum(map(is_unit, written)) >= len(written) else []


def _is_number(cell: str, separator: str) -> bool:
    """Whether a cell is a number."""
    try:
        cell_number(cell, separator)
    except ValueError:
        return False
    return True


def line_cells(line: str, separator: str) -> list[str]:
    """Return the cells of a line without quotes and spaces about them."""
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]
    except csv.Error:  # longer than any cell of ours
        return []


def cell_number(cell: str, separator: str) -> float:
    """Return the number of a cell; raise ValueError where there is none."""
    return float(cell if separator == "," else cell.replace(",", "."))


def number_rows(lines: Sequence[str], separator: str, places: Sequence[int], source: str) -> Array:
    """Return the numbers, or nan, at some places of rows that hold them, (n, places); grouped digits are refused."""
    rows = list[list[float]]()
    for line in lines:
        cells = line_cells(line, separator)
        own, odd = [cells[place] for place in places if place < len(cells)], list[str]()
        rows.append([])
        for cell in own:
            try:
                rows[-1].append(cell_number(cell, separator))
            except ValueError:
                odd.append(cell)
        if odd and all(map(_GROUPED.fullmatch, odd)):
            raise SceneError(f"{source}: rows must hold plain numbers, such as 1234.5; got {shown(line.strip())}")
    return np.array([row for row in rows if len(row) == len(places)]).reshape(-1, len(places))
