"""What does one print of a load that comes and goes? The width of the signals' loops, cycle by cycle."""

from __future__ import annotations

import json
from typing import Any

import xarray as xr
from rich.table import Table

from sits_mech.quantities import POSE
from sits_mech.readout.signals import told
from sits_mech.report.tables.solves import figure_text


def loop_table(data: xr.Dataset) -> Table:
    """Return the loops of `load_cycle`, a line for each cycle; "-" where the signal's range is within its error."""
    found = Table(title=f"{data.attrs['name']}: width of the loops", show_edge=False)
    names = told(data)
    for heading in ("cycle", *(f"{name.removesuffix('_percent')} [% of its range]" for name in names)):
        found.add_column(heading, justify="right")
    for number, widths in enumerate(zip(*(_widths(data, name) for name in names), strict=True), 1):
        found.add_row(str(number), *(figure_text(*width) for width in widths))
    found.caption = data.attrs["notes"] or None
    return found


def loop_record(data: xr.Dataset) -> dict[str, Any]:
    """Return the loops for a program, with the request and the ends of pose and signals."""
    ends = {name: [float(data[name].min()), float(data[name].max())] for name in (*POSE, *told(data))}
    loops = {f"loop_{name}": [value for value, _ in _widths(data, name)] for name in told(data)}
    errors = {f"error_loop_{name}": [error for _, error in _widths(data, name)] for name in told(data)}
    notes = [data.attrs["notes"]] if data.attrs["notes"] else []
    return {"request": json.loads(data.attrs["request"]), "ends": ends, "notes": notes} | loops | errors


def _widths(data: xr.Dataset, name: str) -> list[tuple[float, float]]:
    """Return width and error of each loop."""
    widths, errors = data.attrs[f"loop_{name}"], data.attrs[f"error_loop_{name}"]
    return list(zip(widths, errors, strict=True))
