"""Show the quality of a calibrated sensor: its figures and their scatter by tolerances."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from rich.table import Table

from sits_mech.analysis.limits import AFTER, PERIOD, Limits
from sits_mech.analysis.tolerances import ForceSpread
from sits_mech.quantities import Array, as_jsonable, shown_unit
from sits_mech.readout.crosstalk import crosstalk, largest_rotation, short_name, signals_of
from sits_mech.readout.loads import load_words
from sits_mech.readout.observability import Observability
from sits_mech.readout.quality import Quality
from sits_mech.report.notes import sentence
from sits_mech.report.records import named
from sits_mech.report.tables.loads import per
from sits_mech.report.tables.solves import column_table, figure_text, key_table, short, shown_scale

Record = dict[str, Any]
_NOTHING = 1e-6  # of the largest of an amount: what is printed as 0
_ROUNDING = 1e-9  # of a force's full scale: scatter that symmetry forbids


def quality_record(found: Quality, data: xr.Dataset, scatter: ForceSpread | None = None) -> Record:
    """Return a sensor's quality figures, SI, with signal crosstalk and rotation error from its table."""
    forces, coils, stray = found.forces, found.coils, crosstalk(data).attrs
    own = {name: short_name(signal) for name, signal in signals_of(data).items() if name in forces}
    before, unsure = _before(found, stray, own)
    signals = {str(name): float(value) for name, value in stray.items()}
    for name, (value, error) in largest_rotation(data).items():
        signals |= {f"rotation_as_{name}": value, f"error_rotation_as_{name}": error}
    bent = named(forces, found.crosstalk_error)
    for name, signal in own.items():
        size = stray[f"full_scale_{signal}"]
        bent[name] = stray[f"error_full_scale_{signal}"] / size if size > 0.0 else math.inf
    record = {
        "full_scale": named(forces, found.full_scale),
        "own_signal": own,
        "signal_range": named(coils, found.signal_range),
        "error_range": named(coils, found.error_range),
        "linearity": named(forces, found.linearity),
        "error_linearity": bent,
        "sensitivity": _matrix(coils, forces, found.sensitivity),
        "error_sensitivity": _matrix(coils, forces, found.error_sensitivity),
        "crosstalk_before": before,
        "error_crosstalk_before": unsure,
        "crosstalk": _matrix(forces, forces, found.crosstalk),
        "error_crosstalk": named(forces, found.crosstalk_error),
        "crosstalk_after": _matrix(forces, forces, found.crosstalk_after),
        "error_crosstalk_after": named(forces, 2.0 * found.by_map / np.ptp(found.full_scale, axis=1)),
        "resolution": named(forces, found.resolution),
        "error_by_model": named(forces, found.by_model),
        "error_by_map": named(forces, found.by_map),
        "force_error": named(forces, found.force_error),
        "condition": list(found.condition),
        "forces_seen": components_record(found.seen),
        "valid_share": found.valid_share,
        "no_inverse": list(found.no_inverse),
        "map_error": found.map_error,
        "hysteresis": named(forces, found.hysteresis),
        "signals": signals,
    }
    return record | ({} if scatter is None else {"tolerances": _scatter_record(scatter)})


def _matrix(rows: Sequence[str], columns: Sequence[str], values: Array) -> Record:
    """Return the rows of a matrix by their names, each by those of the columns."""
    return {name: named(columns, row) for name, row in zip(rows, values, strict=True)}


def _before(found: Quality, stray: Mapping[Hashable, Any], own: Mapping[str, str]) -> tuple[Record, Record]:
    """Return crosstalk of each force's own signal over full scale, and its errors.

    A force without a signal of its own is read by the linear sum of all coils.
    """
    values, errors = {}, {}
    for k, name in enumerate(found.forces):
        keys = {other: f"largest_{own.get(name)}_from_{other}" for other in found.forces}
        values[name] = {other: stray.get(key, math.nan) / 100.0 for other, key in keys.items()}
        errors[name] = {other: stray.get(f"error_{key}", math.nan) / 100.0 for other, key in keys.items()}
        if name not in own:
            values[name] = named(found.forces, found.crosstalk[k])
            errors[name] = dict.fromkeys(found.forces, float(found.crosstalk_error[k]))
    return values, errors


def components_record(found: Observability) -> Record:
    """Return which components of a load the coils resolve, for a program."""
    fine = {name: float(size) for name, size in zip(found.names, found.resolution, strict=True) if np.isfinite(size)}
    return {
        "resolved": list(found.resolved),
        "resolution": fine,
        "alone": named(found.names, found.alone),
        "unseen": list(found.unseen),
        "signal": found.signal.tolist(),
    }


def _component_rows(record: Record) -> list[tuple[str, str]]:
    """Return which components are resolved, how far each moves the coils, and which loads do not."""
    resolved = [f"{name} to {_amount(size, name)}" for name, size in record["resolution"].items()]
    moved = [f"{name} {size:.3g}" if size >= 1.0 else f"{name} below it" for name, size in record["alone"].items()]
    return [
        ("resolved", f"at rest, in space: {', '.join(resolved) or 'no component on its own'}"),
        ("", f"each alone at full scale moves the coils, in their noise: {', '.join(moved)}"),
        ("not seen", "; ".join(record["unseen"]) or "nothing"),
    ]


def _amount(size: float, name: str) -> str:
    """Return an amount of a component of a load for a reader, in thousandths."""
    return f"{short(1e3 * size, 2)} m{shown_unit(name)}" if math.isfinite(size) else "not known"


def _scatter_record(scatter: ForceSpread) -> list[Record]:
    """Return deviation, interval and shares of each force at each load."""
    table, rows = scatter.table(), []
    for k, load in enumerate(scatter.loads.tolist()):
        row = {"load": dict(zip(scatter.forces, load, strict=True))}
        for force in scatter.forces:
            at = table.sel(force=force).isel(load=k)
            shares = {name: as_jsonable(at[name].to_numpy()) for name in ("first", "total")}
            named = {name: dict(zip(scatter.spread.names, values, strict=True)) for name, values in shares.items()}
            row[force] = {name: float(at[name]) for name in ("deviation", "low", "high")} | named
        rows.append(row)
    return rows


def limits_record(found: Limits) -> Record:
    """Return the limits of a pad for a program, SI; what is not known is None."""
    names = ("stretch", "known_stretch", "clearance", "error_clearance", "hysteresis", "left", "spread")
    values = {name: getattr(found, name) for name in names}
    record = {name: value if math.isfinite(value) else None for name, value in values.items()}
    record["force_factor"] = None if record["spread"] is None else [1.0 / found.spread, found.spread]
    record |= {"stretch_under": found.stretch_under, "clearance_under": found.clearance_under}
    if found.capacity:
        record["capacity"] = [
            {
                "load": {name: value for name, value in vars(each.load).items() if value != 0.0},
                "multiple": each.multiple if math.isfinite(each.multiple) else None,
                "error": each.error if math.isfinite(each.error) else None,
                "reason": sentence(each.reason),
            }
            for each in found.capacity
        ]
    return record


def limits_table(record: Record) -> Table:
    """Return the limits of a pad for a reader, from `limits_record`."""
    least, known = record["clearance"], record["known_stretch"]
    data = "the range of the silicone's data is unknown"
    if known is not None:
        side = "" if record["stretch"] is None else "BEYOND " if record["stretch"] > known else "within "
        data = f"{side}the silicone's data, which end at {known:.3g}"
    stretch = "unknown" if record["stretch"] is None else f"{record['stretch']:.3g} under {record['stretch_under']}"
    rows = [("largest stretch", f"{stretch}; {data}")]
    if least is not None:
        unsure = math.nan if record["error_clearance"] is None else record["error_clearance"]
        gap = figure_text(least, unsure, 1e3, "mm")
        rows.append(("smallest clearance", f"{gap} over the coils, under {record['clearance_under']}"))
    loop = f"load up and down in {PERIOD:g} s"
    left = f"of the displacement left {AFTER:g} s after a long load"
    rows += [("hysteresis", _known(record["hysteresis"], loop, "neither prony nor mullins"))]
    rows += [("recovery", _known(record["left"], left, "no prony")), ("modulus", modulus_words(record["spread"]))]
    for each in record.get("capacity", ()):
        share, load = each["multiple"], load_words(each["load"])
        off = "" if each["error"] is None else f" +- {each['error']:.2g}"
        times = "any multiple of" if share is None else f"{share:.3g}{off} times"
        rows.append(("carries", f"{times} {load}; then {each['reason']}"))
    return key_table("limits of the pad", rows)


def _known(value: float | None, of: str, lacks: str) -> str:
    """Return a share in percent, or that it is not known."""
    return f"unknown: the silicone has {lacks}" if value is None else f"{100.0 * round(value, 9):.2g} %, {of}"


def modulus_words(spread: float | None) -> str:
    """Return what force a reading of 1 N means by sources that differ on the modulus by a factor, in words."""
    if spread is None:
        return "spread between sources unknown"
    return f"sources differ by a factor of {spread:.3g}: a reading of 1 N means {1.0 / spread:.2g} to {spread:.3g} N"


def quality_tables(record: Record) -> list[Table]:
    """Return the tables of a record, for a reader."""
    more = [limits_table(record["limits"])] if "limits" in record else []
    more += [_scatter_table(record)] if "tolerances" in record else []
    tables = [_force_table(record), _crosstalk_table(record), _coil_table(record)]
    return [*tables, key_table("sensor", _sensor_rows(record)), *more]


def _force_table(record: Record) -> Table:
    """Return range, linearity, and errors of forces by noise alone and in all, a line for each force."""
    headings = ("force", "nonlinearity", "noise (1 sigma)", "error (90 %)")
    found = column_table("quality: linearity, and errors of the forces: median, smallest to largest", headings)
    for name, (low, high) in record["full_scale"].items():
        fine, own = (_usual(record[key][name], name) for key in ("resolution", "force_error"))
        bend = _share(record["linearity"][name], record["error_linearity"][name], unit="%")
        span = f"{low:.4g} to {high:.4g} {shown_unit(name)}"
        if name not in record["forces_seen"]["resolved"]:
            fine = "not resolved"
        found.add_row(f"{name}\n{span}", bend, fine, own)
    return found


def _usual(values: Sequence[float], name: str) -> str:
    """Return the median of an amount, and its ends."""
    best, usual, worst = values
    if not math.isfinite(usual):
        return "-"
    ends = [short(1e3 * size, 2) if size > _NOTHING * worst else "0" for size in (best, worst)]
    return _amount(usual, name) if ends[0] == ends[1] else f"{_amount(usual, name)}\n{' to '.join(ends)}"


def _crosstalk_table(record: Record) -> Table:
    """Return the largest misreading of each readout at full scale of the other forces, three lines for each force."""
    forces = list(record["full_scale"])
    headings = ("force", "read by", *(f"{name} applied" for name in forces))
    found = column_table("crosstalk: largest misreading [% of full scale]", headings)
    found.caption = "<: below the error shown; ?: error not bounded"
    for name in forces:
        own, unsure = record["own_signal"].get(name), record["error_crosstalk_before"][name]
        first = [_share(part, unsure[other]) for other, part in record["crosstalk_before"][name].items()]
        found.add_row(name, f"its signal {own}" if own else "its best sum", *first)
        for key, way in (("crosstalk", "best linear sum"), ("crosstalk_after", "the inverse")):
            cells = [_share(part, record[f"error_{key}"][name]) for part in record[key][name].values()]
            found.add_row("", way, *cells, end_section=key == "crosstalk_after")
    return found


def _share(part: float, error: float, scale: float = 100.0, unit: str = "") -> str:
    """Return a share, in percent by default, with its error, short enough for a matrix."""
    if math.isinf(error) and math.isfinite(part):
        return "?"
    return f"< {short(scale * error)} {unit}".rstrip() if abs(part) <= error else figure_text(part, error, scale, unit)


def _coil_table(record: Record) -> Table:
    """Return the range of each coil and its slopes by each force."""
    slopes = (f"by {name} [ppm/{per(name)}]" for name in record["full_scale"])
    headings = ("coil", "range [% of L0]", *slopes)
    found = column_table("coils: range of inductance, slopes at the smallest loads", headings)
    for coil, part in record["signal_range"].items():
        pairs = zip(record["sensitivity"][coil].values(), record["error_sensitivity"][coil].values(), strict=True)
        found.add_row(coil, _share(part, record["error_range"][coil]), *(_share(*pair, 1e6) for pair in pairs))
    return found


def _sensor_rows(record: Record) -> list[tuple[str, str]]:
    """Return figures of the whole sensor: condition, hysteresis, components of a load, rotation."""
    rows = []
    low, high = record["condition"]
    share = f"unique inverse for {100.0 * record['valid_share']:.4g} % of the loads"
    size = f"{low:.3g} to {high:.3g}" if math.isfinite(high) else "infinite: more forces than coils"
    rows.append(("condition", f"{size}; {share}"))
    rows += [("no inverse", region) for region in record["no_inverse"]]
    seen = record["forces_seen"]
    if seen["unseen"]:
        rows.append(("no coil sees", f"{'; '.join(seen['unseen'])}: moves the coils by less than their noise"))
    if "components" not in record:
        names = ", ".join(seen["resolved"]) or "no force on its own"
        rows.append(("resolved", f"{names}; for all six components: quality --components"))
    if "misplaced" in record:
        off, by_map = record["misplaced"]["error"], record["error_by_map"]
        words = [f"{name}: {figure_text(off[name], by_map[name], unit=shown_unit(name))}" for name in off]
        far = f"{1e3 * record['misplaced']['within']:.4g} mm"
        rows.append(("touch elsewhere", f"up to {far} away, change of {', '.join(words)}"))
    lag = [f"{100.0 * part:.3g} % of {name}" for name, part in record["hysteresis"].items() if np.isfinite(part)]
    rows += [("hysteresis", f"{', '.join(lag)}, loading against unloading")] if lag else []
    if "components" in record:
        rows += _component_rows(record["components"])
    signals = record["signals"]
    for name in ("F_x", "d_h", "F_y", "d_y"):
        if f"rotation_as_{name}" in signals:
            pair = signals[f"rotation_as_{name}"], signals[f"error_rotation_as_{name}"]
            text = figure_text(*pair, *shown_scale(name))
            rows.append(("rotation", f"misread as {name}, at most: {text}"))
    return rows


def _scatter_table(record: Record) -> Table:
    """Return the scatter by tolerances, a line for each force of each load; none where it is rounding."""
    headings = ("force", "standard deviation", "95 % between", "shares (first-order)")
    table = column_table("misreading caused by tolerances, load by load", headings)
    for row in record["tolerances"]:
        for number, (force, value) in enumerate(row["load"].items(), 1):
            at, (low, high), unit = row[force], record["full_scale"][force], shown_unit(force)
            cells = ["none", "", ""]
            if at["deviation"] > _ROUNDING * (high - low):
                shares = [f"{name} {100.0 * part:.0f} %" for name, part in at["first"].items() if part is not None]
                ends = f"{at['low']:.3g} and {at['high']:.3g} {unit}"
                cells = [f"{at['deviation']:.3g} {unit}", ends, ", ".join(shares)]
            table.add_row(load_words({force: value}), *cells, end_section=number == len(row["load"]))
    return table
