"""Read a load history: a table with a column of times and one for each force, moment or place of the target.

What precedes the names of columns (see `columns`) or starts with # is passed over, in any order, a unit in brackets (SI
without one):

    t [ms], or time [s]         rising from row to row
    F_x [N], M_x [N mm], ...    at least one component of the wrench; those without a column are zero
    d_v [mm], alpha [deg], ...  in place of F_z, M: the pose of the target, whose force is found
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np

from sits_mech.analysis.readings.columns import cell_number, line_cells
from sits_mech.analysis.readings.measured import Sheet, table_with
from sits_mech.mechanics.histories import LoadHistory
from sits_mech.mechanics.pad.section import layer_parts
from sits_mech.quantities import POSE, UNITS, WRENCH, Array
from sits_mech.scene.sensor import Sensor
from sits_mech.scene.thermal import at_temperature
from sits_mech.units import SceneError
from sits_mech.units import millimetres as mm

_TIMES = ("t", "time")
_KNOWN = *WRENCH, *POSE
_MOST = 20000  # rows


def read_history(path: str | Path, sensor: Sensor) -> LoadHistory:
    """Read a history of loads, or places of a sensor's target.

    Raises SceneError when the file cannot be read, columns or numbers are missing, a force comes with the place that it
    works on, d_v is a thickness or more from the undeformed pad's, or time stands still or runs back.
    """
    must = "a column t, such as t [s], and one for each force"
    table, columns = table_with(path, "a readable history of loads", _TIMES, must)
    names = [column.title for column in table.columns]
    _check_columns(str(path), columns, names)
    known = [name for name in _KNOWN if name.lower() in columns]
    if not known:
        raise SceneError(f"{path}: must have a column of a force, such as F_z [N], of {', '.join(_KNOWN)}; got none")
    held = np.isin(POSE, known)
    if np.any(held & np.isin(WRENCH, known)):
        raise SceneError(f"{path}: must give a force or the place that it works on; got both: {', '.join(known)}")
    sheet = Sheet(str(path), columns, _rows(table.rows, table.separator, len(names), str(path)))
    time = sheet.values(next(name for name in _TIMES if name in columns), "s")
    still = np.flatnonzero(np.diff(time) <= 0.0)
    if still.size:
        row = int(still[0]) + 1
        hint = ": a sudden load takes a short time, such as 1 ms" if time[row] == time[row - 1] else ""
        came = f"{time[row]:g} s in row {row + 1} after {time[row - 1]:g} s"
        raise SceneError(f"{path}: time must rise; got {came}{hint}")
    course = np.zeros((len(time), len(WRENCH)))
    for name in known:
        course[:, _KNOWN.index(name) % len(WRENCH)] = sheet.values(name.lower(), UNITS[name])
    pad = layer_parts(at_temperature(sensor))[1]
    t, rest = pad.thickness, pad.standoff + pad.thickness
    course[:, 1] -= rest * held[1]
    far = float(course[np.argmax(np.abs(course[:, 1])), 1] * held[1])
    if abs(far) >= t:
        raise SceneError(f"{path}: d_v must be less than {mm(t)} from {mm(rest)}; got {mm(rest + far)}")
    return LoadHistory(time, course, held=held)


def _check_columns(source: str, columns: Collection[str], names: Sequence[str]) -> None:
    """Refuse other columns than time, forces and places, and those that come twice."""
    strange = sorted({*columns} - {*_TIMES, *(name.lower() for name in _KNOWN)})
    if strange or len(columns) < len(names) or all(name in columns for name in _TIMES):
        what = f"{strange[0]!r}" if strange else ", ".join(names)
        raise SceneError(f"{source}: columns must be t and some of {', '.join(_KNOWN)}, each once; got {what}")


def _rows(lines: Sequence[str], separator: str, width: int, source: str) -> Array:
    """Return the numbers of all rows."""
    rows = []
    for row, line in enumerate(lines, 1):
        try:
            rows.append([cell_number(cell, separator) for cell in line_cells(line, separator)])
        except ValueError:
            rows.append([])
        if len(rows[-1]) != width or not np.all(np.isfinite(rows[-1])):
            raise SceneError(f"{source}: row {row} must hold {width} finite numbers; got {line.strip()!r}")
    if not 2 <= len(rows) <= _MOST:
        raise SceneError(f"{source}: must hold 2 to {_MOST} rows of numbers; got {len(rows)}")
    return np.array(rows)
