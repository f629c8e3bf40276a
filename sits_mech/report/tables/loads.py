"""What does one print of a calibration? Its loads and figures of merit with their errors, failures, notes, CSV."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from rich.table import Table

from sits_mech.cases import DONE
from sits_mech.quantities import POSE, UNITS, shown_unit
from sits_mech.readout.crosstalk import crosstalk, rotation_error, slope, slope_error
from sits_mech.readout.loads import beyond_two, fixed, load_words, middle, over_loads, points, two_forces, varied
from sits_mech.readout.signals import PAIR, told
from sits_mech.report.tables.solves import with_error

Figure = tuple[str, float, float, str]
_SCALES = {"m": (1e6, "um"), "rad": (1e3, "mrad")}


def load_table(data: xr.Dataset) -> Table:
    """Return the loads of a calibration: pose and signals with errors, status, seconds.

    Parameters
    ----------
    data : Dataset
        As from `calibrate`.

    Returns
    -------
    Table
        One line per load.
    """
    held = load_words(fixed(data))
    title = f"{data.attrs['name']}{', ' if held else ''}{held}: estimated errors behind every number"
    found, columns = Table(title=title, show_edge=False), _columns(data)
    loads = [f"{name} [{shown_unit(name)}]" for name in varied(data)]
    for heading in (*loads, *(heading for *_, heading in columns), "s", "status"):
        found.add_column(heading, justify="right", no_wrap=True)
    for row in points(data):
        cells = [f"{float(row[name]):.4g}" for name in varied(data)]
        cells += [with_error(k * _number(row, name), k * _number(row, f"error_{name}")) for name, k, _ in columns]
        found.add_row(*cells, f"{float(row['seconds']):.2f}", str(row["status"].item()))
    return found


def _columns(data: xr.Dataset) -> list[tuple[str, float, str]]:
    """Return name, scale and heading of what a table of loads shows: the pose, as far as it moves, and the signals."""
    shown = [(name, *_SCALES[UNITS[name]]) for name in POSE if name in POSE[:3] or name in data]
    pose = [(name, scale, f"{name} [{unit}]") for name, scale, unit in shown]
    return pose + [(name, 1.0, f"{name.removesuffix('_percent')} [% L0]") for name in told(data)]


def _number(row: xr.Dataset, name: str) -> float:
    """Return a number of a row, NaN where it has none."""
    return float(row[name]) if name in row else math.nan


def summary_table(data: xr.Dataset) -> Table:
    """Return the figures of merit of a calibration with their estimated errors.

    Parameters
    ----------
    data : Dataset
        As from `calibrate`.

    Returns
    -------
    Table
        Sensitivities in the middle of the grid; over F_x and F_z alone also full scales, crosstalk both ways, rotation
        error.
    """
    found = Table(title="figures of merit", show_edge=False)
    for heading in ("figure", "value", "unit"):
        found.add_column(heading)
    for name, value, error, unit in figures(data):
        text = with_error(value, error) if math.isfinite(error) else "not determined: within the errors of the signals"
        found.add_row(name, text if math.isfinite(value) else "-", unit)
    for name in missing_figures(data):
        found.add_row(name, "not available: needs a table over F_x and F_z alone", "")
    return found


def missing_figures(data: xr.Dataset) -> tuple[str, ...]:
    """Return the figures of merit that a table has not: other components than F_x and F_z, or other than two coils."""
    pair = f"{PAIR[0]}_percent" in data and not beyond_two(data)
    return () if pair else ("full scales", "crosstalk", "rotation error")


def figures(data: xr.Dataset) -> list[Figure]:
    """Return name, value, estimated error and unit of each figure of merit.

    The error of a figure is the largest it can be when every signal is off by its own estimated error.

    Parameters
    ----------
    data : Dataset
        As from `calibrate`.
    """
    if missing_figures(data):
        return _sensitivities(data, varied(data))
    data = two_forces(data)
    return _sensitivities(data, ("F_z", "F_x")) + _crosstalk_figures(data) + _rotation_figures(data)


def _sensitivities(data: xr.Dataset, components: tuple[str, ...]) -> list[Figure]:
    """Return the slope of each signal by each component in the middle of the grid."""
    at, found = middle(data), []
    for signal in told(data):
        for name in components:
            rate = float(slope(data[signal], name).isel(at))
            unsure = float(slope_error(data[f"error_{signal}"], name).isel(at))
            unit = shown_unit(name) if UNITS[name] == "N" else f"({shown_unit(name)})"
            found.append((f"d{signal.removesuffix('_percent')}/d{name} mid-grid", rate, unsure, f"% of L0 / {unit}"))
    return found


def _crosstalk_figures(data: xr.Dataset) -> list[Figure]:
    """Return the full scale of each signal and what the other's force makes of it."""
    stray, found = crosstalk(data), []
    for signal, force in (("L_h", "F_z"), ("L_v", "F_x")):
        error = 2.0 * _largest(data[f"error_{signal}_percent"])
        scale, largest = stray.attrs[f"full_scale_{signal}"], stray.attrs[f"largest_{signal}_from_{force}"]
        found.append((f"full scale of {signal}", scale, error, "% of L0"))
        wrong = _quotient_error(largest, scale, (100.0 * error, error))
        found.append((f"crosstalk of {force} into {signal}", largest, wrong, "% of full scale"))
    return found


def _rotation_figures(data: xr.Dataset) -> list[Figure]:
    """Return the rotation error as a force and as a displacement, where it is largest."""
    wrong = rotation_error(data)
    force = abs(wrong["F_x_error"])
    if not np.any(np.isfinite(force)):
        return []
    at = dict(zip(force.dims, np.unravel_index(int(np.nanargmax(force)), force.shape), strict=True))
    each = data["error_L_h_percent"]
    errors = (2.0 * float(each.isel(at)), float(slope_error(each, "F_x").isel(at)))
    found = []
    for name, signal, scale in (("shear force", "L_h", 1.0), ("displacement", "L_h_untilted", 1e6)):
        rate = abs(float(slope(data[f"{signal}_percent"], "F_x").isel(at)))
        reach = scale * (1.0 if signal == "L_h" else abs(float(slope(data["d_h"], "F_x").isel(at))))
        value = abs(float((data["L_h_percent"] - data["L_h_untilted_percent"]).isel(at))) / rate
        unit = "N" if signal == "L_h" else "um"
        found.append((f"rotation read as {name}", reach * value, reach * _quotient_error(value, rate, errors), unit))
    return found


def _quotient_error(quotient: float, divisor: float, errors: tuple[float, float]) -> float:
    """Return how far a quotient can be off when dividend and divisor are off by their errors."""
    left = abs(divisor) - errors[1]
    return (errors[0] + abs(quotient) * errors[1]) / left if left > 0.0 else math.inf


def _largest(values: xr.DataArray) -> float:
    """Return the largest of those that are numbers, zero where none is."""
    return float(np.max(np.nan_to_num(values)))


def failures(data: xr.Dataset) -> list[str]:
    """Return one line for each load or case that has no result: which one, its status and the reason."""
    lines = []
    for row in points(data):
        if row["status"].item() != DONE:
            lines.append(f"{point_name(row)}: {row['status'].item()}: {row['reason'].item()}")
    return lines


def point_name(row: xr.Dataset) -> str:
    """Return where a point of a table is: ``F_x = 0.5 N, F_z = 2 N``."""
    items = [(str(name), row[name].item()) for name in row["status"].coords]
    numbers = [f"{value:.4g}" if isinstance(value, float) else str(value) for _, value in items]
    units = [row[name].attrs.get("units", shown_unit(name) if name in UNITS else "") for name, _ in items]
    return ", ".join(f"{name} = {text} {u}".rstrip() for (name, _), text, u in zip(items, numbers, units, strict=True))


def remarks(data: xr.Dataset) -> list[str]:
    """Return what there is to say of the model, and one line for each note of the solves with their number."""
    said = [data.attrs["notes"]] if data.attrs.get("notes") else []
    notes = [note for text in data["notes"].to_numpy().ravel() for note in text.split("; ") if note]
    return said + [f"{notes.count(note)} of {data['notes'].size} loads: {note}" for note in dict.fromkeys(notes)]


def csv_text(data: xr.Dataset) -> str:
    """Return a calibration as CSV, one line per load, SI, every number to its last digit.

    Parameters
    ----------
    data : Dataset
        As from `calibrate`; what has the dimensions coil and coil_2 becomes a column for each pair of coils.

    Returns
    -------
    str
        With a heading of names: the components of the load first, those that vary before those that do not.
    """
    flat = {}
    for name in over_loads(data):
        values = data[name]
        if "coil" not in values.dims:
            flat[name] = values
            continue
        for first in data["coil"].to_numpy():
            for second in data["coil_2"].to_numpy():
                flat[f"{name}[{first}][{second}]"] = values.sel(coil=first, coil_2=second, drop=True)
    loads, held = varied(data), fixed(data)
    table = xr.Dataset(flat).drop_vars([*held], errors="ignore")
    frame = (table if loads else table.expand_dims("load")).to_dataframe(dim_order=[*loads] or ["load"])
    frame = frame.reset_index() if loads else frame
    for place, (name, value) in enumerate(held.items(), len(loads)):
        frame.insert(place, name, value)
    return str(frame.to_csv(index=False))
