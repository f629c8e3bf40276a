"""Read what a bench recorded: a table of forces, or of poses that stages set, and of inductances or codes.

What precedes the names of columns (see `columns`) or starts with # is passed over. Columns are those of `HEADINGS`, in
any order, a unit in brackets or in a row below the names (SI without one), and `unit`, of which sensor of several the
row is (`read_units`). A load that was not measured is nan; other rows with nan are passed over. A code is that of a
tank, whose L it tells, with R where all coils show theirs.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from sits_mech.analysis.readings.columns import TextTable, line_cells, names_found, number_rows, read_tables
from sits_mech.quantities import POSE, UNITS, WRENCH, Array, shown_unit
from sits_mech.readout.converter import Converter, fault, frequency_of, tank_inductance
from sits_mech.units import SceneError, quantity


class Heading(NamedTuple):
    """What a column may be called, as ours are written, its SI unit ("": a plain number), and what it is."""

    pattern: str
    unit: str
    meaning: str


_LOAD = "A force or moment on the target that the model varies; others must be as it has them. Grams press by weight."
_PLACE = "Or where stages have put the target, 0 without a column; inf in d_v: no target."
HEADINGS = (
    *(Heading(name.replace("_", "_?"), UNITS[name], _LOAD) for name in WRENCH),
    *(Heading(name.replace("_", "_?"), UNITS[name], _PLACE) for name in POSE),
    Heading(r"L(_?\d+|_.+?)", "H", "The inductance of a coil at its terminals, by number or by name (L_C1)."),
    Heading(r"code(_?\d+|_.+?)", "", "Or the converter's code of a coil."),
    Heading("depth", "m", "Beside loads: how far the target was pressed down from where it rests without load."),
)
_ANY = "M", "alpha"  # names that a column may have for something else
_ONCE = re.compile("|".join(each.pattern for each in HEADINGS if each.pattern not in _ANY) + "|unit", re.IGNORECASE)
_OURS = {name.lower().replace("_", ""): name.lower() for name in (*WRENCH, *POSE) if "_" in name}
_WEIGHTS = {"g": "gf", "kg": "kgf", "mg": "mgf", "gram": "gf", "grams": "gf"}  # of masses that press with their weight
_NUMBERED = re.compile(r"(?:l|code)_?(\d+)")
_SAME = 1e-3  # of a load that the model has as one value: what a bench's zero may be off [1, of 1 N or 1 mN m at least]


@dataclass(frozen=True)
class Tank:
    """How codes become inductances: part, capacitance [F], reference frequency [Hz], divider of the input.

    With output gain and offset, and the coils' R [ohm] where they show L (..., n) [H]; None: none.
    """

    part: Converter
    capacitance: float
    reference: float
    divider: int = 1
    gain: int = 1
    offset: ArrayLike = 0
    resistance: Callable[[Array], Array] | None = None


@dataclass(frozen=True)
class Sheet:
    """Rows of numbers of a file, and its columns by their names in small letters: place and unit, "" where none is."""

    source: str
    columns: Mapping[str, tuple[int, str]]
    rows: Array

    def values(self, name: str, unit: str) -> Array:
        """Return a column in SI."""
        place, written = self.columns[name]
        written = _WEIGHTS.get(written, written) if unit == "N" else written
        scale = quantity(f"1 {written}", unit, f"{self.source}: column {name}") if written else 1.0
        return scale * self.rows[:, place]


@dataclass(frozen=True)
class _Written:
    """Rows of a file as they are written; columns as of `Sheet`."""

    source: str
    rows: Sequence[str]
    separator: str
    columns: Mapping[str, tuple[int, str]]


@dataclass(frozen=True)
class _Asked:
    """What a model has of a bench, as of `read_measured`."""

    forces: Sequence[str]
    coils: Sequence[str]
    tank: Tank | None
    held: Mapping[str, float]


@dataclass(frozen=True)
class Measured:
    """What a bench recorded."""

    forces: Array  # (m, d) in the order asked for [N, N m]; d is 0 where poses were recorded
    L: Array  # (m, n) [H]
    source: str  # file it came from
    poses: Array | None = None  # (m, 6) of the target, set by stages, as `POSE` [m, rad]; d_v infinite: no target
    depth: Array | None = None  # (m,) that the target was pressed down by from where it rests [m]
    coded: bool = False  # whether inductances are of codes

    def check(self) -> None:
        """Raise SceneError for an inductance that is none of such coils: nan, zero or below, or 10 mH and more."""
        wrong = np.argwhere(~((self.L > 0.0) & (self.L < 0.01)))
        if len(wrong):
            row, coil = wrong[0]
            came = f"{self.L[row, coil]:g} H of coil {coil + 1} in row {row + 1} of {len(self.L)}"
            must = "must hold inductances above 0 and below 0.01 H, in H where no unit is"
            raise SceneError(f"{self.source}: {must}; got {came}")


def read_measured(
    path: str | Path, forces: Sequence[str], coils: Sequence[str], tank: Tank | None = None,
    held: Mapping[str, float] | None = None, unseen: bool = False,
) -> Measured:
    """Read a measurement of the forces and coils of a model; without forces the file must have poses.

    `tank` is needed where the file holds codes; `held` are other components of the load that the model has, of one
    value each [N, N m]; what is neither is zero; `unseen` loads, nan, are kept. SceneError when the file cannot be
    read, a column is missing or of an unknown unit, there are fewer than 4 rows of loads (1 with `unseen`), or the file
    has other loads than the model.
    """
    return _measured(_written(path, forces), _Asked(forces, coils, tank, held or {}), unseen)


def read_units(
    path: str | Path, forces: Sequence[str], coils: Sequence[str], tank: Tank | None = None,
    held: Mapping[str, float] | None = None,
) -> dict[str, Measured]:
    """Read what a bench recorded of several sensors, separated by the column ``unit``; loads may be nan.

    Otherwise as `read_measured`. SceneError also without such a column, or for a file of poses.
    """
    file = _written(path, forces)
    if "unit" not in file.columns or (forces and forces[0].lower() not in file.columns):
        raise SceneError(f"{path}: must have columns unit and {forces[0]}; got {', '.join(file.columns)}")
    place, rows = file.columns["unit"][0], dict[str, list[str]]()
    for line in file.rows:
        if name := "".join(line_cells(line, file.separator)[place : place + 1]):
            rows.setdefault(name, []).append(line)
    if not rows:
        raise SceneError(f"{path}: must have a row with the name of its unit; got none")
    asked = _Asked(forces, coils, tank, held or {})
    return {
        name: _measured(replace(file, source=f"{path}: {name}", rows=own), asked, True) for name, own in rows.items()
    }


def _written(path: str | Path, forces: Sequence[str]) -> _Written:
    """Return the rows of a file as they are written."""
    needs = (*(name.lower() for name in forces[:1]), "d_v")
    must = f"a column {f'{forces[0]}, or d_v of a pose,' if forces else 'd_v, of a pose,'} and one for each coil"
    table, columns = table_with(path, "a readable measurement", needs, f"{must}, such as L1 [uH]")
    return _Written(str(path), table.rows, table.separator, columns)


def _measured(file: _Written, asked: _Asked, unseen: bool) -> Measured:
    """Return the measurement that rows hold, as `read_measured`."""
    source, forces = file.source, asked.forces
    coils = [_coil(file, k, coil) for k, coil in enumerate(asked.coils)]
    moved = not forces or forces[0].lower() not in file.columns
    used = POSE if moved else (*forces, *_others(file, forces), "depth")
    rows, least = _rows(file, (*coils, *used), tuple(forces) * unseen), 1 if moved or unseen else 4
    if len(rows) < least:
        raise SceneError(f"{source}: must hold at least {least} row{'s' * (least > 1)} of numbers; got {len(rows)}")
    sheet = Sheet(source, file.columns, rows)
    _check_coils(sheet, asked.coils)
    L = _inductances(sheet, coils, asked.tank)
    if moved:
        _check_finite(source, [L])
        return Measured(np.zeros((len(rows), 0)), L, source, _poses(sheet))
    loads = np.stack([sheet.values(name.lower(), UNITS[name]) for name in forces], -1)
    _check_others(sheet, forces, asked.held)
    depth = sheet.values("depth", "m") if "depth" in file.columns else None
    _check_finite(source, [L, loads] if depth is None else [L, loads, depth])
    return Measured(loads, L, source, None, depth, coils[0].startswith("code"))


def _rows(file: _Written, used: Sequence[str], unseen: Sequence[str]) -> Array:
    """Return the rows with numbers in the columns that are used, nan in those unseen alone, and in all others."""
    names = [name.lower() for name in used if name.lower() in file.columns]
    places = [file.columns[name][0] for name in names]
    found = number_rows(file.rows, file.separator, places, file.source)
    seen = ~np.isin(names, [name.lower() for name in unseen])
    found = found[~np.any(np.isnan(found[:, seen]), axis=1)]
    rows = np.full((len(found), max(places) + 1), np.nan)
    rows[:, places] = found
    return rows


def _check_finite(source: str, parts: Sequence[Array]) -> None:
    """Refuse what is infinite."""
    if np.isinf(np.column_stack(parts)).any():
        must = "must hold finite numbers, of d_v alone inf for no target"
        raise SceneError(f"{source}: {must}; got inf in another column")


def _others(file: _Written | Sheet, forces: Sequence[str]) -> list[str]:
    """Return the components of a load that a file has besides those that the model varies, which it must have."""
    absent = [name for name in forces if name.lower() not in file.columns]
    if absent:
        what = f"must have the column {absent[0]}, which the calibration varies"
        raise SceneError(f"{file.source}: {what}; got {', '.join(file.columns)}")
    there = [name for name in WRENCH if name not in forces and name.lower() in file.columns]
    return [name for name in there if name != "M" or file.columns["m"][1]]  # a column m may be anything


def _poses(sheet: Sheet) -> Array:
    """Return the poses, zero in what has no column, shape (m, 6) [m, rad]."""
    each = {name: sheet.values(name.lower(), UNITS[name]) for name in POSE if name.lower() in sheet.columns}
    poses = np.stack([each.get(name, np.zeros(len(sheet.rows))) for name in POSE], -1)
    others = np.delete(poses, POSE.index("d_v"), axis=-1)
    if not np.all(each["d_v"] > 0.0) or not np.all(np.isfinite(others)):
        came = f"{each['d_v'].min():g}"
        raise SceneError(f"{sheet.source}: d_v must be above zero, or inf where there is no target; got {came}")
    return poses


def table_with(
    path: str | Path, what: str, needs: Sequence[str], must: str
) -> tuple[TextTable, dict[str, tuple[int, str]]]:
    """Return a file's table below the names that have one of those needed, and its columns; refuse a file without.

    `what` the file must be, and what it `must` have; columns as of `Sheet`. Names that come again further below are
    passed over.
    """
    tables = read_tables(path, what, lambda columns: {*needs} & {_name(column.name) for column in columns})
    if not tables:
        raise SceneError(f"{path}: must have {must}; got {names_found(path, what)}")
    first = tables[0][0]
    columns = [_table_columns(table, needs) for table, _ in tables]
    if any(one != columns[0] for one in columns):
        raise SceneError(f"{path}: names and units that come again must be those above; got others")
    return replace(first, rows=[row for table, _ in tables for row in table.rows]), columns[0]


def _name(written: str) -> str:
    """Return the name of a column as ours are written: Fx is f_x."""
    return _OURS.get(re.sub(r"[\s_]", "", written), written)


def _table_columns(table: TextTable, needed: Sequence[str]) -> dict[str, tuple[int, str]]:
    """Return place and unit of each column by its name in small letters, those of loads and poses as ours are written.

    Raise SceneError where a column of a load, a pose, a coil or one needed comes twice.
    """
    found: dict[str, tuple[int, str]] = {}
    for column in table.columns:
        name = _name(column.name)
        if name in found and (name in needed or _ONCE.fullmatch(name)):
            titles = f"{table.columns[found[name][0]].title} and {column.title}"
            raise SceneError(f"{table.source}: a column must come once; got {titles} for {name}")
        found.setdefault(name, (column.place, column.unit))
    return found


def _check_others(sheet: Sheet, forces: Sequence[str], held: Mapping[str, float]) -> None:
    """Refuse components of a load that the model does not vary, but for those of its own value."""
    for name in _others(sheet, forces):
        values, own = sheet.values(name.lower(), UNITS[name]), held.get(name, 0.0)
        if np.max(np.abs(values - own)) > _SAME * max(abs(own), 1.0 if UNITS[name] == "N" else 1e-3):
            came = f"{values.min():.4g} to {values.max():.4g} {shown_unit(name)}"
            raise SceneError(
                f"{sheet.source}: column {name}: must be {own:.4g} {shown_unit(name)}, the calibration varies "
                f"{', '.join(forces)} alone; got {came}: calibrate with {name} as a range"
            )


def _check_coils(sheet: Sheet, coils: Sequence[str]) -> None:
    """Refuse columns of coils, by number, that the model does not have."""
    own = {coil.lower() for coil in coils} | {f"{k + 1}" for k in range(len(coils))}
    for name in sheet.columns:
        match = _NUMBERED.fullmatch(name)
        if match is not None and not {match[1], name} & own:
            must = f"must be of one of {len(coils)} coils ({', '.join(coils)}); leave it out"
            raise SceneError(f"{sheet.source}: column {name}: {must}")


def _coil(file: _Written, number: int, title: str) -> str:
    """Return the column of a coil, by number or by name, of inductances or codes."""
    tails = (f"{number + 1}", title.lower(), f"_{number + 1}", f"_{title.lower()}")
    each = [[f"{kind}{tail}" for tail in tails if f"{kind}{tail}" in file.columns] for kind in ("l", "code")]
    if doubled := next((names for names in each if len({*names}) > 1), None):
        raise SceneError(f"{file.source}: a coil must have one column; got {' and '.join(doubled)}")
    name = next((names[0] for names in each if names), None)
    if name is None:
        what = f"must have a column L{number + 1} or code{number + 1}"
        raise SceneError(f"{file.source}: {what}; got {', '.join(file.columns)}")
    return name


def _check_codes(sheet: Sheet, names: Sequence[str], codes: Array, part: Converter) -> None:
    """Refuse codes (m, n) of a coil that was not read."""
    for (row, k), code in np.ndenumerate(codes):
        if np.isfinite(code) and (why := fault(code, part)):
            must = "must be of a coil that is read; got a fault"
            raise SceneError(f"{sheet.source}: row {row + 1}, {names[k]}: {must}, {why}")


def _inductances(sheet: Sheet, names: Sequence[str], tank: Tank | None) -> Array:
    """Return the inductances of the coils, given or from codes, shape (m, n) [H]."""
    coded = [name.startswith("code") for name in names]
    values = np.stack([sheet.values(name, "" if of else "H") for name, of in zip(names, coded, strict=True)], -1)
    if not any(coded):
        return values
    if tank is None:
        name = names[coded.index(True)]
        raise SceneError(f"{sheet.source}: the column {name} must come with a converter; the scene has none for it")
    codes = np.where(coded, values, 1.0)
    _check_codes(sheet, names, codes, tank.part)
    f = frequency_of(codes, tank.part, tank.reference, tank.divider, gain=tank.gain, offset=tank.offset)
    L = np.where(coded, tank_inductance(f, tank.capacitance), values)
    for _ in range(4):  # each leaves some 1e-3 of an error
        R = np.zeros(1) if tank.resistance is None else tank.resistance(L)
        L = np.where(coded, tank_inductance(f, tank.capacitance, R), values)
    return L
