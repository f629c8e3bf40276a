"""What does a designer read of a calibrated sensor? Its quality figures and the scatter by tolerances."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from rich.table import Table

from sits_mech.analysis.tolerances import ForceSpread
from sits_mech.quantities import Array, as_jsonable
from sits_mech.readout.crosstalk import crosstalk, rotation_error
from sits_mech.readout.observability import Observability
from sits_mech.readout.quality import Quality
from sits_mech.report.tables.solves import key_table

Record = dict[str, Any]


def quality_record(found: Quality, data: xr.Dataset, scatter: ForceSpread | None = None) -> Record:
    """Return the figures of a sensor for a program, SI.

    Parameters
    ----------
    found : Quality
        Of the calibration.
    data : Dataset
        Its table, for crosstalk of the signals and the rotation's error.
    scatter : ForceSpread, optional
        By tolerances.
    """
    forces, coils = found.forces, found.coils
    record = {
        "full_scale": _named(forces, found.full_scale),
        "signal_range": _named(coils, found.signal_range),
        "linearity": _named(forces, found.linearity),
        "sensitivity": {coil: _named(forces, row) for coil, row in zip(coils, found.sensitivity, strict=True)},
        "crosstalk": {name: _named(forces, row) for name, row in zip(forces, found.crosstalk, strict=True)},
        "resolution": _named(forces, found.resolution),
        "condition": list(found.condition),
        "valid_share": found.valid_share,
        "no_inverse": list(found.no_inverse),
        "map_error": found.map_error,
        "hysteresis": _named(forces, found.hysteresis),
        "signals": _signals(data),
    }
    return record | ({} if scatter is None else {"tolerances": _scatter_record(scatter)})


def _named(names: Sequence[str], values: Array) -> Record:
    """Return values by their names."""
    return dict(zip(names, values.tolist(), strict=True))


def _signals(data: xr.Dataset) -> Record:
    """Return the signals' crosstalk and what rotation alone is mistaken for, the largest over the table."""
    found = {str(name): float(value) for name, value in crosstalk(data).attrs.items()}
    if "L_h_untilted_percent" in data and data.sizes["F_x"] > 1:
        wrong = rotation_error(data)
        found["rotation_as_F_x"] = float(np.nanmax(np.abs(wrong["F_x_error"])))
        found["rotation_as_d_h"] = float(np.nanmax(np.abs(wrong["d_h_error"])))
    return found


def components_record(found: Observability) -> Record:
    """Return which components of a load the coils resolve, for a program."""
    fine = {name: float(size) for name, size in zip(found.names, found.resolution, strict=True) if np.isfinite(size)}
    return {
        "resolved": list(found.resolved),
        "resolution": fine,
        "alone": _named(found.names, found.alone),
        "unseen": list(found.unseen),
        "signal": found.signal.tolist(),
    }


def _component_rows(record: Record) -> list[tuple[str, str]]:
    """Return which components are resolved, how far each moves the coils, and which loads do not."""
    units = {"F": "N", "M": "N m"}
    resolved = [f"{name} to {size:.3g} {units[name[0]]}" for name, size in record["resolution"].items()]
    moved = [f"{name} {size:.3g}" if size >= 1.0 else f"{name} below it" for name, size in record["alone"].items()]
    return [
        ("resolved", f"at rest, in space: {', '.join(resolved) or 'no component on its own'}"),
        ("", f"each alone at full scale moves the coils, in their noise: {', '.join(moved)}"),
        ("not seen", "; ".join(record["unseen"]) or "nothing"),
    ]


def _scatter_record(scatter: ForceSpread) -> list[Record]:
    """Return deviation, interval and shares of each force at each load."""
    table, rows = scatter.table(), []
    for k, load in enumerate(scatter.loads.tolist()):
        row: Record = {"load": dict(zip(scatter.forces, load, strict=True))}
        for force in scatter.forces:
            at = table.sel(force=force).isel(load=k)
            shares = {name: as_jsonable(at[name].to_numpy()) for name in ("first", "total")}
            named = {name: dict(zip(scatter.spread.names, values, strict=True)) for name, values in shares.items()}
            row[force] = {name: float(at[name]) for name in ("deviation", "low", "high")} | named
        rows.append(row)
    return rows


def quality_tables(record: Record) -> list[Table]:
    """Return the tables of a record, for a reader."""
    rows = []
    for name, (low, high) in record["full_scale"].items():
        best, usual, worst = record["resolution"][name]
        fine = f"{1e3 * usual:.3g} mN ({1e3 * best:.3g} to {1e3 * worst:.3g})"
        rows.append((name, f"{low:.4g} to {high:.4g} N; resolution {fine}"))
        parts = record["crosstalk"][name].items()
        others = [f"{100.0 * part:.3g} % from {other}" for other, part in parts if other != name]
        bend = f"linear to {100.0 * record['linearity'][name]:.3g} %"
        rows.append(("", f"{bend}; read linearly, off by {', '.join(others) or 'nothing'}"))
    for coil, part in record["signal_range"].items():
        slopes = [f"{1e6 * slope:.4g} ppm/N by {name}" for name, slope in record["sensitivity"][coil].items()]
        rows.append((coil, f"range {100.0 * part:.3g} % of free space; {', '.join(slopes)}"))
    low, high = record["condition"]
    share = f"inverse for {100.0 * record['valid_share']:.4g} % of the loads"
    rows.append(("condition", f"{low:.3g} to {high:.3g}; {share}"))
    rows += [("no inverse", region) for region in record["no_inverse"]]
    lag = [f"{100.0 * part:.3g} % of {name}" for name, part in record["hysteresis"].items() if np.isfinite(part)]
    rows += [("hysteresis", f"{', '.join(lag)}, loading against unloading")] if lag else []
    rows += _component_rows(record["components"]) if "components" in record else []
    signals = record["signals"]
    if "rotation_as_F_x" in signals:
        force, shift = signals["rotation_as_F_x"], 1e6 * signals["rotation_as_d_h"]
        rows.append(("rotation", f"read as {force:.3g} N or {shift:.3g} um of shear at most"))
    return [key_table("quality", rows), *([_scatter_table(record["tolerances"])] if "tolerances" in record else [])]


def _scatter_table(rows: list[Record]) -> Table:
    """Return the scatter by tolerances, one line for each load and force."""
    table = Table(title="misread by tolerances", show_edge=False)
    for heading in ("load", "force", "standard deviation", "95 % between", "shares (first-order)"):
        table.add_column(heading)
    for row in rows:
        load = ", ".join(f"{name} = {force:.3g} N" for name, force in row["load"].items())
        for force in row["load"]:
            at = row[force]
            shares = ", ".join(f"{name} {100.0 * part:.0f} %" for name, part in at["first"].items() if part is not None)
            ends = f"{at['low']:.3g} and {at['high']:.3g} N"
            table.add_row(load, force, f"{at['deviation']:.3g} N", ends, shares)
    return table
