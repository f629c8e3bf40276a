"""What goes into the microcontroller? Codes over the forces as integers, and their inverse in fixed point, as C header.

A smooth map is put through the codes of the calibration's loads (`readout.calibration`, here in codes instead of henry)
and laid down on a uniform grid of forces. Cubics through four nodes of each force,

    code(F) = sum_ij w_i(x) w_j(z) T_ij,    x, z positions on the grid, w Lagrange's polynomials of degree three,

follow the map to its fourth derivative times h^4; the grid is made fine until they do so to a quarter of a code. A cell
is marked by what the Python inverse says of readings from within it. The header (``firmware.h.in``) has the arithmetic.

Range: two coils, forces F_x and F_z. Neglected: noise; the error of a built sensor against the computed one.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from string import Template

import numpy as np
from numpy.typing import NDArray

from sits_mech.analysis.codes import readings
from sits_mech.export.source import Source
from sits_mech.quantities import Array
from sits_mech.readout.calibration import OK, OUTSIDE, Calibration, calibration_of
from sits_mech.scene.files import write_text
from sits_mech.scene.sensor import SceneError
from sits_mech.version import __version__

_SIZES = (9, 13, 17, 25, 33, 49, 65)  # nodes along each force
_FAITH = 0.25  # of a code, of the table to the map
_MOST_BITS = 22  # of the table's numbers, so that products stay within 64 bits
_FORCES = ("F_x", "F_z")
_MICRO = 1e6
_MARKS = {OK: 0, OUTSIDE: 1}  # any other status is SITS_AMBIGUOUS

Integers = NDArray[np.int64]


@dataclass(frozen=True)
class CodeTable:
    """Codes over a uniform grid of forces.

    Attributes
    ----------
    cal : Calibration
        The smooth map that the table follows; its "inductances" are codes.
    fraction : int
        Fractional bits of the table.
    base : ndarray of int, shape (2,)
        Code that each coil's table counts from.
    table : ndarray of int, shape (2, n, n)
        ``(code - base) 2^fraction`` over (F_x, F_z).
    cells : ndarray of int, shape (n - 1, n - 1)
        0 where readings have one answer, 1 outside the calibration, 2 where they are ambiguous.
    error : float
        Largest difference of the interpolated table to the map [codes].
    """

    cal: Calibration
    fraction: int
    base: Integers
    table: Integers
    cells: Integers
    error: float


def code_calibration(source: Source) -> Calibration:
    """Return the calibration of a source in codes of its converter.

    Raises
    ------
    SceneError
        When the sensor has no converter, other than two coils, or one of both forces does not vary.
    ValueError
        When there are too few loads.
    """
    names = [coil.name for coil in source.sensor.coils]
    sizes = {name: source.data.sizes[name] for name in _FORCES}
    if len(names) != 2 or min(sizes.values()) < 2:
        came = f"{len(names)} coils and {sizes['F_x']} x {sizes['F_z']} loads"
        raise SceneError(f"--to c: must have two coils and several values of both forces; got {came}")
    read = readings(source.sensor, source.data)
    codes = read.codes
    if codes is None:
        raise SceneError(f"--to c: must have codes of a converter; {'; '.join(read.left_out)}")
    grid = np.stack(np.meshgrid(*(source.data[name].to_numpy() for name in sizes), indexing="ij"), -1)
    good = np.isfinite(codes).all(axis=-1)
    return calibration_of(grid[good], codes[good], forces=tuple(sizes), coils=names, free=("code", [np.nan, np.nan]))


def code_table(cal: Calibration) -> CodeTable:
    """Return the coarsest table that follows a map of codes to a quarter of a code, or the finest that is made."""
    for size in _SIZES:
        found = _table(cal, size)
        if found.error <= _FAITH:
            break
    return found


def _table(cal: Calibration, size: int) -> CodeTable:
    """Return the table of one size, with its error on points between the nodes."""
    axes = [np.linspace(low, high, size) for low, high in zip(cal.low, cal.high, strict=True)]
    codes = np.moveaxis(cal.forward(*np.meshgrid(*axes, indexing="ij")), -1, 0)
    base = np.rint(0.5 * (codes.min(axis=(1, 2)) + codes.max(axis=(1, 2)))).astype(np.int64)
    above = codes - base[:, None, None]
    bits = int(np.ceil(np.log2(np.abs(above).max() + 1.0)))
    if bits > _MOST_BITS + 1:
        most = 2 ** (_MOST_BITS + 2)
        raise SceneError(f"--to c: must have codes that change by less than {most}; got {np.ptp(codes):.0f}")
    fraction = int(np.clip(_MOST_BITS - bits, 0, 6))
    table = np.rint(above * 2.0**fraction).astype(np.int64)
    between = 0.5 + np.arange(size - 1)
    weights = _weights(np.sort(np.concatenate([between, between[[0, -1]] + (-0.25, 0.25)])), size)
    positions = weights @ np.arange(size)
    there = [low + (high - low) * positions / (size - 1) for low, high in zip(cal.low, cal.high, strict=True)]
    seen = weights @ (table / 2.0**fraction) @ weights.T + base[:, None, None]
    exact = np.moveaxis(cal.forward(*np.meshgrid(*there, indexing="ij")), -1, 0)
    return CodeTable(cal, fraction, base, table, _marks(cal, axes), float(np.abs(seen - exact).max()))


def _weights(positions: Array, size: int) -> Array:
    """Return Lagrange's cubic weights of each node at positions on the grid, shape (m, size)."""
    first = np.clip(np.floor(positions).astype(int) - 1, 0, size - 4)
    found = np.zeros((len(positions), size))
    for k in range(4):
        others = [j for j in range(4) if j != k]
        away = [(positions - first - j) / (k - j) for j in others]
        found[np.arange(len(positions)), first + k] = np.prod(away, axis=0)
    return found


def _marks(cal: Calibration, axes: list[Array]) -> Integers:
    """Return what the inverse says of readings from within each cell: the worst of nine points."""
    size = len(axes[0]) - 1
    inside = [np.add.outer(axis[:-1], np.array([0.02, 0.5, 0.98]) * (axis[1] - axis[0])).ravel() for axis in axes]
    status = cal.inverse(cal.forward(*np.meshgrid(*inside, indexing="ij"))).status
    marks = np.full(status.shape, 2, dtype=np.int64)
    for name, mark in _MARKS.items():
        marks[status == name] = mark
    return np.asarray(marks.reshape(size, 3, size, 3).max(axis=(1, 3)))


def write_header(source: Source, path: Path) -> tuple[str, ...]:
    """Write the C header.

    Raises
    ------
    ValueError
        As `code_calibration`; also when the map has no inverse anywhere, or the file cannot be written.
    """
    found = code_table(code_calibration(source))
    lost = float(np.mean(found.cells > 0))
    if lost == 1.0:
        regions = "; ".join(found.cal.domain.regions) or "everywhere"
        raise SceneError(f"--to c: must have a region where codes belong to one force; there is none: {regions}")
    write_text(path, header(source, found))
    size = found.table.shape[1]
    notes = [
        f"table of {size} x {size} nodes, within {found.error:.2g} codes of the map",
        f"the map predicts loads that are left out to {_in_words(found.cal, float(found.cal.map.error.max()))}",
        f"the loads' own estimated errors are up to {_in_words(found.cal, _own_error(source))}",
    ]
    if lost > 0.0:
        notes.append(f"{lost:.1%} of the cells have no answer: {'; '.join(found.cal.domain.regions) or 'no results'}")
    return tuple(notes)


def _own_error(source: Source) -> float:
    """Return the largest estimated error of a load of the table, by its inductance, in codes."""
    read = readings(source.sensor, source.data)
    return 0.0 if read.codes is None else float(np.nanmax(0.5 * read.codes * read.error_L / read.L))


def _in_words(cal: Calibration, codes: float) -> str:
    """Return an error in codes and what it makes of each force."""
    milli = zip(_FORCES, 1e3 * codes * _worth(cal), strict=True)
    return f"{codes:.3g} codes: " + ", ".join(f"{each:.2g} mN of {name}" for name, each in milli)


def _worth(cal: Calibration) -> Array:
    """Return what one code is worth of each force, mid-range [N]."""
    return np.asarray(1.0 / np.abs(cal.slopes(*(0.5 * (cal.low + cal.high)))).max(axis=0))


def header(source: Source, found: CodeTable) -> str:
    """Return the header of a table."""
    cal, front = found.cal, readings(source.sensor, source.data).front
    low, high = (np.rint(_MICRO * values).astype(np.int64) for values in (cal.low, cal.high))
    none = np.clip(0.0, cal.low, cal.high)
    worth = _MICRO * _worth(cal)
    codes = (found.table / 2.0**found.fraction).reshape(2, -1)
    spread = [np.ptp(codes[0] + codes[1]), np.ptp(codes[0] - codes[1])]
    weights = np.clip(np.rint(max(spread) / np.maximum(spread, 1e-9)), 1, 64).astype(int)
    registers = () if front is None else front.registers
    layout = (resources.files("sits_mech.export") / "firmware.h.in").read_text(encoding="utf-8")
    return Template(layout).substitute(
        name=_comment(source.sensor.name), about=_comment(source.about), version=__version__,
        part="converter" if front is None else front.part.name,
        fx_low=f"{cal.low[0]:.4g}", fx_high=f"{cal.high[0]:.4g}", fz_low=f"{cal.low[1]:.4g}",
        fz_high=f"{cal.high[1]:.4g}",
        table_error=f"{found.error:.2g}", map_error=f"{cal.map.error.max():.3g}", own_error=f"{_own_error(source):.3g}",
        value_bits=found.fraction + 8,
        newtons_x=f"{worth[0]:.3g}", newtons_z=f"{worth[1]:.3g}",
        nx=found.table.shape[1], nz=found.table.shape[2], fraction=found.fraction,
        low=_row(low), range=_row(high - low), rest=_row(np.rint(cal.forward(*none)).astype(np.int64)),
        base=_row(found.base), registers=len(registers), weight_sum=weights[0], weight_gap=weights[1],
        register_rows=", ".join(f"{{0x{address:02X}, 0x{value:04X}}}" for address, _, value in registers),
        table=",\n".join("{" + ",\n ".join(f"{{{_row(row)}}}" for row in coil) + "}" for coil in found.table),
        cells=",\n".join(f"{{{_row(row)}}}" for row in found.cells),
    )  # fmt: skip


def _row(values: Integers) -> str:
    """Return numbers as C writes them."""
    return ", ".join(str(int(value)) for value in values)


def _comment(text: str) -> str:
    """Return a text that may stand within a comment."""
    return " ".join(text.replace("*/", "* /").split())
