"""Tabulate a calibration: its loads and figures of merit with errors, failures, notes, CSV."""

from __future__ import annotations

import math
from collections.abc import Hashable
from itertools import product

import numpy as np
import xarray as xr
from rich.table import Table

from sits_mech.labels import unit_of, with_unit
from sits_mech.notes import unpacked
from sits_mech.quantities import POSE, UNITS, shown_unit
from sits_mech.readout.crosstalk import (
    components_of,
    crosstalk,
    largest_rotation,
    short_name,
    signals_of,
    slope,
    slope_doubt,
)
from sits_mech.readout.loads import answered, fixed, load_words, middle, over_loads, points, varied
from sits_mech.readout.signals import shown_signals
from sits_mech.report.left_out import kept_lines
from sits_mech.report.notes import joined_words, sentence, with_words
from sits_mech.report.tables.solves import column_table, figure_text, point_name, shown_scale, sizes_of, with_error
from sits_mech.status import WORDS

KINDS = {
    "F_x": "shear force", "F_y": "shear force along y", "F_z": "normal force", "M": "moment about y",
    "M_x": "moment about x", "M_z": "moment about z", "touch_x": "touch along x", "touch_y": "touch along y",
}
"""What each component of a load is."""
Figure = tuple[str, float, float, str]


def load_table(data: xr.Dataset) -> Table:
    """Return one line per load: pose and signals with errors, status, seconds."""
    held = load_words(fixed(data))
    title = f"{data.attrs['name']}{', ' if held else ''}{held}: estimated errors behind every number"
    columns, loads = _columns(data), [f"{name} [{shown_unit(name)}]" for name in varied(data)]
    headings = (*loads, *(heading for *_, heading in columns), "s", "status")
    found = column_table(title, headings, justify="right", no_wrap=True)
    shown = {item for name, *_ in columns for item in (name, f"error_{name}") if item in data}
    sizes = sizes_of(data, [name for name, *_ in columns])
    for row in points(data[["seconds", "status", "flags", *sorted(shown)]]):
        cells = [f"{float(row[name]):.4g}" for name in varied(data)]
        for name, k, _ in columns:
            cells.append(with_error(k * _number(row, name), k * _number(row, f"error_{name}"), k * sizes[name]))
        found.add_row(*cells, f"{float(row['seconds']):.2f}", str(row["flags"].item()))
    return found


def in_width(table: Table, keys: int, width: int) -> list[Table]:
    """Split a table into tables of at most `width` characters, each starting with the first `keys` columns.

    Each has at least one further column, even where that is wider.
    """
    sizes = [3 + max(len(str(text)) for text in (one.header, *one.cells)) for one in table.columns]
    blocks: list[list[int]] = [[]]
    for k in range(keys, len(sizes)):
        if blocks[-1] and sum(sizes[:keys]) + sum(sizes[blocks[-1][0] : k + 1]) - 1 > width:
            blocks.append([])
        blocks[-1].append(k)
    return [_part(table, [*range(keys), *block], block is blocks[0]) for block in blocks]


def _part(table: Table, numbers: list[int], titled: bool) -> Table:
    """Return a table of some columns of another."""
    part, columns = Table(title=table.title if titled else None, show_edge=False), [table.columns[k] for k in numbers]
    for one in columns:
        part.add_column(one.header, justify=one.justify, no_wrap=one.no_wrap)
    for row in zip(*(one.cells for one in columns), strict=True):
        part.add_row(*row)
    return part


def _columns(data: xr.Dataset) -> list[tuple[str, float, str]]:
    """Return name, scale and heading of what a table of loads shows: the pose, as far as it moves, and the signals."""
    shown = [(name, *shown_scale(name)) for name in POSE if name in POSE[:3] or name in data]
    pose = [(name, scale, f"{name} [{unit}]") for name, scale, unit in shown]
    return pose + [(name, 1.0, f"{short_name(name)} [% L0]") for name in shown_signals(data)]


def _number(row: xr.Dataset, name: str) -> float:
    """Return a number of a row, NaN where it has none."""
    return float(row[name]) if name in row else math.nan


def summary_table(data: xr.Dataset) -> Table:
    """Return the figures of merit of a calibration with their estimated errors.

    Sensitivities in the middle of the grid, full scales, crosstalk of every component, forces that rotation reads as.
    """
    found = column_table("figures of merit", ("figure", "value", "unit"))
    each = figures(data)
    for name, value, error, unit in each:
        sizes = [abs(other) for _, other, _, its in each if its == unit and math.isfinite(other)]
        size = 100.0 if unit.startswith("% of full scale") else max(sizes, default=0.0)
        found.add_row(name, figure_text(value, error, size=size), unit)
    return found


def figures(data: xr.Dataset) -> list[Figure]:
    """Return name, value, estimated error and unit of each figure of merit.

    The error is a bound by the errors of the signals, less what cancels of them (readout/crosstalk.py).
    """
    return _sensitivities(data) + _crosstalk_figures(data) + _rotation_figures(data)


def _several(data: xr.Dataset) -> tuple[str, ...]:
    """Return the components of which a table has more than one value."""
    return tuple(name for name in components_of(data) if data.sizes[name] > 1)


def _sensitivities(data: xr.Dataset) -> list[Figure]:
    """Return the slope of each signal by each component in the middle of the grid."""
    at, found = middle(data), []
    for signal, name in product(signals_of(data).values(), _several(data)):
        rate = float(slope(data[signal], name).isel(at))
        unsure = float(slope_doubt(data, signal, name).isel(at))
        found.append((f"d({short_name(signal)})/d{name} mid-grid", rate, unsure, f"% of L0 / {per(name)}"))
    return found


def per(name: str) -> str:
    """Return the unit of a component of a load behind a stroke."""
    return shown_unit(name) if UNITS[name] == "N" else f"({shown_unit(name)})"


def _crosstalk_figures(data: xr.Dataset) -> list[Figure]:
    """Return the full scale of each signal and its crosstalk by the other components."""
    stray, found, forces = crosstalk(data).attrs, [], _several(data)
    for own, variable in signals_of(data).items():
        if own not in forces:
            continue
        signal = short_name(variable)
        keys = {f"full scale of {signal}": (f"full_scale_{signal}", "% of L0")}
        for other in forces:
            if other != own:
                keys[f"crosstalk of {other} into {signal}"] = (f"largest_{signal}_from_{other}", "% of full scale")
        found += [(name, stray[key], stray[f"error_{key}"], unit) for name, (key, unit) in keys.items()]
    return found


def _rotation_figures(data: xr.Dataset) -> list[Figure]:
    """Return the rotation error as a force and as a displacement, where it is largest."""
    shown = {"F_x": "shear force", "d_h": "displacement", "F_y": "shear force F_y", "d_y": "displacement d_y"}
    found = []
    for name, (value, error) in largest_rotation(data).items():
        scale, unit = shown_scale(name)
        found.append((f"rotation read as {shown[name]}", scale * value, scale * error, unit))
    return found


def failures(data: xr.Dataset) -> list[str]:
    """Return one line for each load or case that has no result: which one, its status and the reason."""
    lines, dims = [], data["status"].dims
    for index in np.argwhere(~answered(data).to_numpy()):
        row = data[["status", "reason"]].isel(dict(zip(dims, index.tolist(), strict=True)))
        lines.append(f"{point_name(row)}: {row['status'].item()}: {row['reason'].item()}")
    return lines


def remarks(data: xr.Dataset) -> list[str]:
    """Return notes on the model, and one line for each kind of note of the solves, with its count and the worst note.

    The worst is by status, then by stretch; notes of a kind that differ only in numbers are one.
    """
    remarked = [joined_words(data.attrs["notes"])] if data.attrs.get("notes") else []
    remarked += kept_lines([data.attrs.get("left_out", "")])
    rows = list(points(data[["status", "notes", *(["stretch"] if "stretch" in data else [])]]))
    rows.sort(key=lambda row: (-WORDS.index(row["status"].item()), -np.nan_to_num(_number(row, "stretch"))))
    kinds: dict[Hashable, list[str]] = {}
    for row in rows:
        for note in unpacked(str(row["notes"].item())):
            words = tuple(value for _, value in note.numbers if isinstance(value, str))
            kinds.setdefault((note.kind, words), []).append(f"{point_name(row)}: {sentence(note)}")
    return remarked + [f"{len(each)} of {len(rows)} loads, worst {each[0]}" for each in kinds.values()]


def csv_text(data: xr.Dataset, *, units: bool = True) -> str:
    """Return a calibration as CSV, one line per load, SI, full precision; varied load components come first.

    What goes by coils and causes becomes a column for each; headings have `units`, ``d_h [m]``.
    """
    data, flat = with_words(data), {}
    for name in over_loads(data):
        own = [dim for dim in data[name].dims if dim in ("coil", "coil_2", "thermal_cause")]
        for at in product(*(data[dim].to_numpy() for dim in own)):
            key = "".join(f"[{each}]" for each in at)
            flat[f"{name}{key}"] = data[name].sel(dict(zip(own, at, strict=True)), drop=True)
    loads, held = varied(data), fixed(data)
    table = xr.Dataset(flat).drop_vars([*held], errors="ignore")
    frame = (table if loads else table.expand_dims("load")).to_dataframe(dim_order=[*loads] or ["load"])
    frame = frame.reset_index() if loads else frame
    for place, (name, value) in enumerate(held.items(), len(loads)):
        frame.insert(place, name, value)
    known = {str(name): unit_of(str(name), data.attrs.get("unit_L", "H")) for name in frame.columns if units}
    return str(frame.rename(columns=lambda name: with_unit(name, known.get(name, ""))).to_csv(index=False))
