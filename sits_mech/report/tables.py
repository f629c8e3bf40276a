"""What does one print? Tables in which every number carries its estimated error, for the terminal and as CSV."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr
from rich.table import Table

from sits_mech.analysis.spectrum import Terminals
from sits_mech.quantities import POSE, WRENCH, Equilibrium, Impedance, SolveReport
from sits_mech.readout.crosstalk import crosstalk, rotation_error, sensitivity, slope, slope_error
from sits_mech.readout.signals import Signals
from sits_mech.sweep import DONE

_COLUMNS = (
    ("d_h", 1e6, "d_h [um]"),
    ("d_v", 1e6, "d_v [um]"),
    ("alpha", 1e3, "alpha [mrad]"),
    ("L_v_percent", 1.0, "L_v [% L0]"),
    ("L_h_percent", 1.0, "L_h [% L0]"),
)


def with_error(value: float, error: float) -> str:
    """Return a number with its error, both to the error's second digit: ``12.34 +- 0.21``; "-" where there is none."""
    if not math.isfinite(value):
        return "-"
    if not math.isfinite(error) or abs(error) < 1e-12 * abs(value) or error == 0.0:
        return f"{value:.6g} +- {'0' if math.isfinite(error) else '?'}"
    digits = min(max(1 - math.floor(math.log10(abs(error))), 0), 12)
    return f"{value:.{digits}f} +- {abs(error):.{digits}f}"


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
    found = Table(title=f"{data.attrs['name']}: estimated errors behind every number", show_edge=False)
    for heading in ("F_x [N]", "F_z [N]", *(heading for *_, heading in _COLUMNS), "s", "status"):
        found.add_column(heading, justify="right")
    for F_x in data["F_x"].to_numpy():
        for F_z in data["F_z"].to_numpy():
            found.add_row(*_cells(data.sel(F_x=F_x, F_z=F_z)))
    return found


def _cells(row: xr.Dataset) -> list[str]:
    """Return the cells of one load."""
    cells = [f"{float(row.F_x):.4g}", f"{float(row.F_z):.4g}"]
    cells += [
        with_error(scale * _number(row, name), scale * _number(row, f"error_{name}")) for name, scale, _ in _COLUMNS
    ]
    return [*cells, f"{float(row['seconds']):.2f}", str(row["status"].item())]


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
        Sensitivities in the middle of the grid, full scales, crosstalk both ways, rotation error.
    """
    found = Table(title="figures of merit", show_edge=False)
    for heading in ("figure", "value", "unit"):
        found.add_column(heading)
    for name, value, error, unit in figures(data):
        text = with_error(value, error) if math.isfinite(error) else "not determined: within the errors of the signals"
        found.add_row(name, text if math.isfinite(value) else "-", unit)
    return found


def figures(data: xr.Dataset) -> list[tuple[str, float, float, str]]:
    """Return name, value, estimated error and unit of each figure of merit.

    The error of a figure is the largest it can be when every signal is off by its own estimated error.

    Parameters
    ----------
    data : Dataset
        As from `calibrate`.
    """
    found = []
    S, middle = sensitivity(data), {"F_x": data.F_x.size // 2, "F_z": data.F_z.size // 2}
    for signal in ("L_v", "L_h"):
        for force in ("F_z", "F_x"):
            unsure = slope_error(data[f"error_{signal}_percent"], force).isel(middle)
            value = S.sel(signal=signal, force=force).isel(middle)
            found.append((f"d{signal}/d{force} mid-grid", float(value), float(unsure), "% of L0 / N"))
    stray = crosstalk(data)
    for signal, force in (("L_h", "F_z"), ("L_v", "F_x")):
        error = 2.0 * _largest(data[f"error_{signal}_percent"])
        scale, largest = stray.attrs[f"full_scale_{signal}"], stray.attrs[f"largest_{signal}_from_{force}"]
        found.append((f"full scale of {signal}", scale, error, "% of L0"))
        wrong = _quotient_error(largest, scale, (100.0 * error, error))
        found.append((f"crosstalk of {force} into {signal}", largest, wrong, "% of full scale"))
    return found + _rotation_figures(data)


def _rotation_figures(data: xr.Dataset) -> list[tuple[str, float, float, str]]:
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


def points(data: xr.Dataset) -> Iterator[xr.Dataset]:
    """Give the points of a table one by one, the last dimension running fastest."""
    dims = data["status"].dims
    for index in np.ndindex(data["status"].shape):
        yield data.isel(dict(zip(dims, index, strict=True)))


def point_name(row: xr.Dataset) -> str:
    """Return where a point of a table is: ``F_x = 0.5 N, F_z = 2 N``."""
    items = [(str(name), row[name].item()) for name in row["status"].coords]
    numbers = [f"{value:.4g}" if isinstance(value, float) else str(value) for _, value in items]
    units = [f" {row[name].attrs.get('units', 'N' if name in ('F_x', 'F_z') else '')}".rstrip() for name, _ in items]
    return ", ".join(f"{name} = {text}{unit}" for (name, _), text, unit in zip(items, numbers, units, strict=True))


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
        With a heading of names.
    """
    flat = {}
    for name, values in data.data_vars.items():
        if "F_x" not in values.dims:
            continue
        if "coil" not in values.dims:
            flat[str(name)] = values
            continue
        for first in data["coil"].to_numpy():
            for second in data["coil_2"].to_numpy():
                flat[f"{name}[{first}][{second}]"] = values.sel(coil=first, coil_2=second, drop=True)
    frame = xr.Dataset(flat).to_dataframe(dim_order=["F_x", "F_z"])
    return str(frame.reset_index().to_csv(index=False))


def key_table(title: str, rows: Sequence[tuple[str, str]]) -> Table:
    """Return a table of names and what stands behind them."""
    found = Table(title=title, show_header=False, show_edge=False)
    for name, text in rows:
        found.add_row(name, text)
    return found


def equilibrium_table(found: Equilibrium, title: str = "pose") -> Table:
    """Return pose with errors, and how it came about."""
    lines = []
    for name in POSE[: 6 if found.wrench.beside else 3]:
        scale, unit = (1e6, "um") if name.startswith("d") else (1e3, "mrad")
        value, error = float(getattr(found.pose, name)), float(getattr(found.error, name))
        lines.append((name, f"{with_error(scale * value, scale * error)} {unit}"))
    load = [(name, getattr(found.wrench, name)) for name in WRENCH[:3] + found.wrench.beside]
    lines.append(("under", ", ".join(f"{name} = {value:.4g} N{' m' * name.startswith('M')}" for name, value in load)))
    return key_table(title, lines + volume_lines(found.report) + report_lines(found.report))


def impedance_table(coils: Sequence[str], found: Impedance) -> Table:
    """Return L and R of each pair of coils with errors at one pose, and how they came about."""
    scale, unit_L = (1e6, found.unit_L.replace("H", "uH", 1))
    unit_R = found.unit_L.replace("H", "ohm", 1)
    lines = [("frequency", f"{found.frequency:.6g} Hz")]
    for i, first in enumerate(coils):
        for j, second in enumerate(coils[: i + 1]):
            L = with_error(scale * float(found.L[i, j]), scale * float(found.error_L[i, j]))
            R = with_error(float(found.R[i, j]), float(found.error_R[i, j]))
            free = f"{scale * float(found.L0[i, j]):.6g} {unit_L} in free space"
            lines.append((f"{first}, {second}" if i != j else first, f"L = {L} {unit_L}, R = {R} {unit_R}; {free}"))
    return key_table("impedance", lines + report_lines(found.report))


def terminal_table(coils: Sequence[str], seen: Terminals | None, missing: Sequence[str] = ()) -> Table:
    """Return what each coil shows at the end of its leads, or why nothing is said of it."""
    lines = []
    if seen is not None:
        for k, name in enumerate(coils):
            shown = f"L = {1e6 * seen.L[k]:.6g} uH, R = {seen.R[k]:.4g} ohm, Q = {seen.Q[k]:.4g}"
            uneven = f"uneven current in them: {1e9 * seen.shift[k]:.3g} nH, not in L"
            lines.append((name, f"{shown}; tracks alone {seen.R_ac[k]:.4g} ohm; {uneven}"))
            resonance = 1e-6 * seen.tank_frequency[k]
            tank = f"resonance at {resonance:.5g} MHz" if resonance > 0.0 else "no resonance"
            apparent = f"L = {1e6 * seen.apparent_L[k]:.5g} uH, R = {seen.apparent_R[k]:.4g} ohm"
            lines.append(("", f"with the capacitance: {tank}; apparent {apparent}, Q = {seen.apparent_Q[k]:.4g}"))
    return key_table("terminals", [*lines, *(("left out", text) for text in missing)])


def spectrum_table(data: xr.Dataset) -> Table:
    """Return L, R and Q of each coil over frequency.

    Parameters
    ----------
    data : Dataset
        As from `spectrum`.

    Returns
    -------
    Table
        One line for each frequency and coil; with the terminals' values, where the model is in henry and ohm.
    """
    unit = data.attrs["unit_L"]
    report = json.loads(data.attrs["report"])
    title = f"{data.attrs['name']}: {report['model']}, {report['seconds']:.3g} s, {report['unknowns']} unknowns"
    found = Table(title=title, show_edge=False)
    headings = ["f [Hz]", "coil", f"L [{unit.replace('H', 'uH', 1)}]", f"R [{unit.replace('H', 'ohm', 1)}]", "Q [-]"]
    if "shift" in data:
        headings += ["terminals: L [uH]", "R [ohm]", "Q [-]"]
    for heading in headings:
        found.add_column(heading, justify="right")
    for hertz in data["frequency"].to_numpy():
        for number, coil in enumerate(data["coil"].to_numpy()):
            last = number + 1 == data.sizes["coil"]
            found.add_row(*_spectrum_cells(data.sel(frequency=hertz, coil=coil, coil_2=coil)), end_section=last)
    found.caption = "; ".join([f"largest relative error {report['estimated_error']:.1e}", *report["left_out"]])
    return found


def _spectrum_cells(row: xr.Dataset) -> list[str]:
    """Return the cells of one frequency and coil."""
    scales = (("L", 1e6), ("R", 1.0))
    L, R = (with_error(scale * float(row[k]), scale * float(row[f"error_{k}"])) for k, scale in scales)
    cells = [f"{float(row['frequency']):.6g}", str(row["coil"].item()), L, R, f"{float(row['Q']):.4g}"]
    if "shift" in row:
        L_seen, R_seen, Q_seen = (float(row[f"terminal_{name}"]) for name in ("L", "R", "Q"))
        cells += [f"{1e6 * L_seen:.6g}", f"{R_seen:.4g}", f"{Q_seen:.4g}"]
    return cells


def signal_table(found: Signals, unit_L: str) -> Table:
    """Return the two signals with errors."""
    unit = unit_L.replace("H", "uH", 1)
    lines = []
    for name in ("L_v", "L_h"):
        value, error = float(getattr(found, name)), float(getattr(found, f"error_{name}"))
        percent, wrong = float(getattr(found, f"{name}_percent")), float(getattr(found, f"error_{name}_percent"))
        absolute = with_error(1e6 * value, 1e6 * error)
        lines.append((name, f"{absolute} {unit}, that is {with_error(percent, wrong)} % of L0"))
    return key_table("signals", lines)


def volume_lines(report: SolveReport) -> list[tuple[str, str]]:
    """Return the smallest volume ratio of a layer as a line of a table; none where no layer was solved."""
    if report.min_J is None:
        return []
    return [("smallest J", f"{report.min_J:.4f} at any point of the layer, as a rule at a bonded edge")]


def report_lines(report: SolveReport) -> list[tuple[str, str]]:
    """Return how a number came about, as lines of a table."""
    solved = f"{report.model}, {report.unknowns} unknowns, {report.iterations} iterations, {report.seconds:.3g} s"
    lines = [("model", f"{solved}, relative error {report.estimated_error:.1e}, {report.status}")]
    return lines + [("note", note) for note in report.notes]
