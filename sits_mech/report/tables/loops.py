"""What does one print of a load that comes and goes? The width of the signals' loops, cycle by cycle."""

from __future__ import annotations

import json
from typing import Any

import xarray as xr
from rich.table import Table

from sits_mech.quantities import POSE
from sits_mech.report.tables.solves import with_error


def loop_table(data: xr.Dataset) -> Table:
    """Return the loops of `load_cycle`, a line for each cycle; "-" where the signal's range is within its error."""
    found = Table(title=f"{data.attrs['name']}: width of the loops", show_edge=False)
    for heading in ("cycle", "L_v [% of its range]", "L_h [% of its range]"):
        found.add_column(heading, justify="right")
    for number, (v, h) in enumerate(zip(_widths(data, "L_v"), _widths(data, "L_h"), strict=True), 1):
        found.add_row(str(number), with_error(*v), with_error(*h))
    found.caption = data.attrs["notes"] or None
    return found


def loop_record(data: xr.Dataset) -> dict[str, Any]:
    """Return the loops for a program, with the request and the ends of pose and signals."""
    names = (*POSE, "L_v_percent", "L_h_percent")
    ends = {name: [float(data[name].min()), float(data[name].max())] for name in names}
    loops = {f"loop_{name}_percent": [value for value, _ in _widths(data, name)] for name in ("L_v", "L_h")}
    errors = {f"error_loop_{name}_percent": [error for _, error in _widths(data, name)] for name in ("L_v", "L_h")}
    notes = [data.attrs["notes"]] if data.attrs["notes"] else []
    return {"request": json.loads(data.attrs["request"]), "ends": ends, "notes": notes} | loops | errors


def _widths(data: xr.Dataset, name: str) -> list[tuple[float, float]]:
    """Return width and error of each loop."""
    widths, errors = data.attrs[f"loop_{name}_percent"], data.attrs[f"error_loop_{name}_percent"]
    return list(zip(widths, errors, strict=True))
