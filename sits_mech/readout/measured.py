"""What was measured, and which parameters of a model describe it? A table of forces and inductances or codes; a fit.

A file has a row of column names and rows of numbers, separated by commas, semicolons or tabs; what precedes the names
or starts with # is passed over. Columns, in any order, a unit in brackets (SI without one):

    F_x [N], M_x [N mm], ...    the forces and moments that the model varies; others must be as it has them
    L1 [uH], L2 [uH], ...       the inductance of each coil at its terminals, by number or by name (L_C1), or
    code1, code2, ...           the converter's codes, from which L = 1 / ((2 pi f)^2 C), f = code d_in f_ref / 2^bits

The fit minimises the sum of squares of L_model(forces; parameters) - L over all rows and coils, each coil over its
range. Half-widths at 95 % are those of Student's t with the residual's variance, or the model's own if that is more:
the residuals' picture must look like noise for them to hold. Numbers only: the model is any function.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares
from scipy.stats import t as student

from sits_mech.quantities import UNITS, WRENCH, Array, shown_unit
from sits_mech.readout.converter import Converter, frequency_of, tank_inductance
from sits_mech.units import SceneError, quantity

_COLUMN = re.compile(r"\s*([A-Za-z][\w ]*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?\s*")
_NUMBERED = re.compile(r"(?:l|code)_?(\d+)")
_LEAST_ROWS = 4
_SAME = 1e-3  # of a load that the model has as one value: what a bench's zero may be off [1, of 1 N or 1 mN m at least]


@dataclass(frozen=True)
class Tank:
    """How codes become inductances: part, capacitance [F], reference frequency [Hz], divider of the input."""

    part: Converter
    capacitance: float
    reference: float
    divider: int = 1


@dataclass(frozen=True)
class Measured:
    """What a bench recorded.

    Attributes
    ----------
    forces : ndarray, shape (m, d)
        In the order asked for [N].
    L : ndarray, shape (m, n)
        [H].
    source : str
        File it came from.
    """

    forces: Array
    L: Array
    source: str


@dataclass(frozen=True)
class ParameterFit:
    """Parameters of a model that describe a measurement.

    Attributes
    ----------
    names : tuple of str
    values, half_widths : ndarray, shape (p,)
        Best values and their 95 % half-widths; infinite where the data do not determine them.
    correlation : ndarray, shape (p, p)
    residual : ndarray, shape (m, n)
        Measured less model [H].
    rms, rms_before : float
        Of the residual with the best and with the first values, over each coil's range.
    """

    names: tuple[str, ...]
    values: Array
    half_widths: Array
    correlation: Array
    residual: Array
    rms: float
    rms_before: float


def read_measured(
    path: str | Path, forces: Sequence[str], coils: Sequence[str], tank: Tank | None = None,
    held: Mapping[str, float] | None = None,
) -> Measured:  # fmt: skip
    """Read a measurement.

    Parameters
    ----------
    path : str or Path
    forces, coils : sequence of str
        What the model has, such as ("F_x", "F_z") and ("C1", "C2").
    tank : Tank, optional
        Needed where the file holds codes.
    held : mapping, optional
        Other components of the load that the model has, of one value each [N, N m]; what is neither is zero.

    Raises
    ------
    SceneError
        When the file cannot be read, a column is missing or of an unknown unit, there are fewer than four rows, or
        the file has other loads than the model.
    """
    try:
        lines = Path(path).read_text(encoding="utf-8-sig", errors="replace").splitlines()
    except OSError as error:
        raise SceneError(f"{path}: must be a readable measurement; got: {error.strerror or error}") from None
    lines = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
    number, separator, columns = _heading(lines, forces[0].lower())
    if number < 0:
        raise SceneError(f"{path}: must have a column {forces[0]} and one for each coil, such as L1 [uH]; got none")
    rows = _numbers(lines[number + 1 :], separator)
    if len(rows) < _LEAST_ROWS:
        raise SceneError(f"{path}: must hold at least {_LEAST_ROWS} rows of numbers; got {len(rows)}")
    absent = [name for name in forces if name.lower() not in columns]
    if absent:
        raise SceneError(
            f"{path}: must have the column {absent[0]}, which the calibration varies; got {', '.join(columns)}"
        )
    found = [_values(rows, columns, name.lower(), UNITS[name], str(path)) for name in forces]
    _check_others(rows, columns, forces, held or {}, str(path))
    _check_coils(columns, coils, str(path))
    L = [_inductance(rows, columns, (k, coil), tank, str(path)) for k, coil in enumerate(coils)]
    return Measured(np.stack(found, -1), np.stack(L, -1), str(path))


def _heading(lines: Sequence[str], needed: str) -> tuple[int, str, dict[str, tuple[int, str]]]:
    """Return number, separator and columns of the row of names that has the needed one; -1 where there is none."""
    for number, line in enumerate(lines):
        separator = next((mark for mark in ";\t," if mark in line), ",")
        columns = _columns([cell.strip().strip('"') for cell in line.split(separator)])
        if needed in columns:
            return number, separator, columns
    return -1, ",", {}


def _columns(names: Sequence[str]) -> dict[str, tuple[int, str]]:
    """Return place and unit of each column by its name in small letters."""
    found: dict[str, tuple[int, str]] = {}
    for place, text in enumerate(names):
        match = _COLUMN.fullmatch(text)
        if match is not None:
            found.setdefault(match[1].lower(), (place, match[2] or ""))
    return found


def _numbers(lines: Sequence[str], separator: str) -> Array:
    """Return the rows that hold as many numbers as the first that does."""
    rows: list[list[float]] = []
    for line in lines:
        try:
            row = [float(cell) for cell in line.split(separator)]
        except ValueError:
            continue
        if np.all(np.isfinite(row)) and (not rows or len(row) == len(rows[0])):
            rows.append(row)
    return np.array(rows)


def _values(rows: Array, columns: dict[str, tuple[int, str]], name: str, unit: str, source: str) -> Array:
    """Return a column in SI."""
    if name not in columns or columns[name][0] >= rows.shape[1]:
        raise SceneError(f"{source}: must have the column {name}; got {', '.join(columns)}")
    place, written = columns[name]
    scale = quantity(f"1 {written}", unit, f"{source}: column {name}") if written else 1.0
    return np.asarray(scale * rows[:, place])


def _check_others(
    rows: Array, columns: dict[str, tuple[int, str]], forces: Sequence[str], held: Mapping[str, float], source: str
) -> None:
    """Refuse components of a load that the model does not vary, but for those of its own value."""
    for name in WRENCH:
        place, written = columns.get(name.lower(), (0, ""))
        if name in forces or name.lower() not in columns or (name == "M" and not written):
            continue  # a column m may be anything
        values, own = _values(rows, columns, name.lower(), UNITS[name], source), held.get(name, 0.0)
        if np.max(np.abs(values - own)) > _SAME * max(abs(own), 1.0 if UNITS[name] == "N" else 1e-3):
            came = f"{values.min():.4g} to {values.max():.4g} {shown_unit(name)}"
            raise SceneError(
                f"{source}: column {name}: must be {own:.4g} {shown_unit(name)}, the calibration varies "
                f"{', '.join(forces)} alone; got {came}: calibrate with {name} as a range"
            )


def _check_coils(columns: dict[str, tuple[int, str]], coils: Sequence[str], source: str) -> None:
    """Refuse columns of coils, by number, that the model does not have."""
    own = {coil.lower() for coil in coils} | {f"{k + 1}" for k in range(len(coils))}
    for name in columns:
        match = _NUMBERED.fullmatch(name)
        if match is not None and not {match[1], name} & own:
            every = ", ".join(coils)
            raise SceneError(f"{source}: column {name}: must be of one of {len(coils)} coils ({every}); leave it out")


def _inductance(
    rows: Array, columns: dict[str, tuple[int, str]], coil: tuple[int, str], tank: Tank | None, source: str
) -> Array:
    """Return the inductance of a coil, by number or by name, given or from codes [H]."""
    number, title = coil
    tails = (f"{number + 1}", title.lower(), f"_{number + 1}", f"_{title.lower()}")
    names = [f"{kind}{tail}" for kind in ("l", "code") for tail in tails]
    name = next((name for name in names if name in columns), None)
    if name is None:
        raise SceneError(f"{source}: must have a column L{number + 1} or code{number + 1}; got {', '.join(columns)}")
    if name.startswith("l"):
        return _values(rows, columns, name, "H", source)
    if tank is None:
        raise SceneError(f"{source}: the column {name} must come with a converter; the scene has none for it")
    codes = _values(rows, columns, name, "", source)
    return tank_inductance(frequency_of(codes, tank.part, tank.reference, tank.divider), tank.capacitance)


def fit_parameters(
    model: Callable[[Array], Array], L: ArrayLike, names: Sequence[str], *,
    start: Sequence[float], bounds: tuple[Sequence[float], Sequence[float]], sizes: Sequence[float],
    beyond: Mapping[str, tuple[str, str]] | None = None, own: float = 0.0,
) -> ParameterFit:  # fmt: skip
    """Return the parameters of a model that describe inductances best.

    Parameters
    ----------
    model : callable
        Parameters (p,) to inductances (m, n) [H].
    L : array_like, shape (m, n)
        Measured [H].
    names : sequence of str
        Of the parameters.
    start, sizes : sequence of float
        First values, and how large a change of each is.
    bounds : tuple
        Least and greatest values.
    beyond : mapping, optional
        Of parameters: why they must not be less, and not be more.
    own : float
        Root mean square error of the model itself, over each range: half-widths are not of less scatter.

    Raises
    ------
    SceneError
        When there are no more numbers than parameters, or the best value lies at a bound.
    """
    L = np.asarray(L, dtype=float)
    if L.size <= len(names):
        raise SceneError(f"measurement: must hold more than {len(names)} inductances; got {L.size}")
    scale = np.maximum(np.ptp(L, axis=0), 1e-6 * np.abs(L).max(axis=0))

    def off(p: Array) -> Array:
        """Return model less measured, over the range."""
        return np.asarray((model(p) - L) / scale).ravel()

    before = off(np.asarray(start, dtype=float))
    scales = np.asarray(sizes, dtype=float)
    found = least_squares(off, start, bounds=bounds, x_scale=scales, jac="3-point", xtol=1e-12, ftol=1e-12, gtol=1e-14)
    for name, value, low, high in zip(names, found.x, *bounds, strict=True):
        if min(value - low, high - value) < 1e-6 * (high - low):
            reason = (beyond or {}).get(name, ("", ""))[int(high - value < value - low)]
            came = f"the best value is at an end, {value:.4g}{': ' if reason else ''}{reason}"
            raise SceneError(f"{name}: must fit from {low:.4g} to {high:.4g}; {came}")
    freedom = L.size - len(names)
    jacobian = found.jac * np.asarray(sizes)
    flat = np.linalg.norm(jacobian, axis=0) < 1e-12
    spread = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-12, hermitian=True)
    variance = max(float(np.sum(found.fun**2)) / freedom, own**2)
    deviation = np.sqrt(np.diagonal(spread) * variance) * np.asarray(sizes)
    widths = np.where(flat, np.inf, student.ppf(0.975, freedom) * deviation)
    safe = np.sqrt(np.maximum(np.diagonal(spread), 1e-300))
    rms, first = (float(np.sqrt(np.mean(r**2))) for r in (found.fun, before))
    residual = -(found.fun.reshape(L.shape) * scale)
    return ParameterFit(tuple(names), found.x, widths, spread / np.outer(safe, safe), residual, rms, first)
