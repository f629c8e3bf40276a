"""Tabulate a solve, every number with its estimated error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from sits_mech.notes import NoteKind
from sits_mech.quantities import POSE, UNITS, WRENCH, Equilibrium, Impedance, SolveReport, report_of, shown_unit
from sits_mech.readout.loads import load_words
from sits_mech.readout.signals import COMBINED, SIGNALS, Signals
from sits_mech.report.left_out import line
from sits_mech.report.notes import sentences
from sits_mech.units import millimetres

if TYPE_CHECKING:
    import xarray as xr

    from sits_mech.analysis.spectrum import Terminals

_NOTHING = 1e-6  # of the size of a run: far below what any estimate holds, far above rounding
_LEAST = 5e-13  # what twelve decimals do not show
_OFFSET = ("d_v", "L_v_percent")  # not zero at rest
_SCALES = {"m": (1e6, "um"), "rad": (1e3, "mrad")}


def with_error(value: float, error: float, size: float | None = None) -> str:
    """Return a number with its error, both to the error's second digit: ``12.34 +- 0.21``; "-" where there is none.

    An error below a millionth of `size`, by default the number's own, is "0"; a number that is, too, is "0" alone.
    """
    if not math.isfinite(value):
        return "-"
    nothing = max(_NOTHING * (abs(value) if size is None else size), _LEAST)
    value = 0.0 if abs(value) <= nothing and value != 0.0 else value
    if abs(error) <= nothing and value == 0.0:
        return "0"
    if not math.isfinite(error) or abs(error) <= nothing:
        return f"{value:.6g} +- {'0' if math.isfinite(error) else '?'}"
    digits = _digits(error)
    return f"{value:.{digits}f} +- {abs(error):.{digits}f}"


def point_name(row: xr.Dataset) -> str:
    """Return where a point of a table is: ``F_x = 0.5 N, elastomer.thickness = 2 mm``."""
    found = []
    for name in map(str, row["status"].coords):
        value, unit = row[name].item(), row[name].attrs.get("units", shown_unit(name) if name in UNITS else "")
        number = f"{value:.4g}" if isinstance(value, float) else value
        found.append(f"{name} = {millimetres(value, 4) if unit == 'm' else f'{number} {unit}'.rstrip()}")
    return ", ".join(found)


def sizes_of(data: Any, names: Sequence[str]) -> dict[str, float]:
    """Return the size of pose components and signals in a run, shared by lengths, by angles and by signals.

    `data` has values and errors (``error_`` and the name) of one load or many; what is not zero at rest counts by
    range.
    """
    own, kind = {}, {name: name[:2] for name in names}
    for name in names:
        both = (np.ravel(np.asarray(data[key], dtype=float)) for key in (name, f"error_{name}") if key in data)
        values, *errors = (each[np.isfinite(each)] for each in both)
        least = values.min(initial=np.inf) if name in _OFFSET else 0.0
        own[name] = max(float(np.abs(each).max(initial=0.0)) for each in (values - least, *errors))
    return {name: max(own[other] for other in names if kind[other] == kind[name]) for name in names}


def shown_scale(name: str) -> tuple[float, str]:
    """Return factor and unit in which a reader is shown a component of a load or a pose."""
    return _SCALES.get(UNITS[name], (1.0, shown_unit(name)))


def figure_text(value: float, error: float, scale: float = 1.0, unit: str = "", size: float = 0.0) -> str:
    """Return a figure times `scale` with its error: ``12.34 +- 0.21 mN``, ``below its error of 3.4 N``, ``-`` for none.

    An error is NaN where unknown and infinite where unbounded; `size` as in `with_error`, unscaled.
    """
    value, error, unit = scale * value, abs(scale * error), f" {unit}" if unit else ""
    size = max(scale * size, abs(value))
    if not math.isfinite(value):
        return "-"
    if math.isinf(error):
        return "not determined: within the errors of the signals"
    if math.isnan(error):
        return f"{short(value)}{unit}"
    if abs(value) <= error and error > max(_NOTHING * size, _LEAST):
        return f"below its error of {error:.{_digits(error)}f}{unit}"
    return f"{with_error(value, error, size)}{unit}"


def short(value: float, digits: int = 3) -> str:
    """Return a number to a few digits, without an exponent from a thousandth to a million."""
    return f"{value:.0f}" if 10.0**digits <= abs(value) < 1e6 else f"{value:.{digits}g}"


def _digits(error: float) -> int:
    """Return the decimals that show an error's second digit."""
    return min(max(1 - math.floor(math.log10(abs(error))), 0), 12)


def key_table(title: str, rows: Sequence[tuple[str, str]]) -> Table:
    """Return a table of names and what stands behind them."""
    found = Table(title=title, show_header=False, show_edge=False)
    for name, text in rows:
        found.add_row(name, text)
    return found


def column_table(title: str, headings: Sequence[str], **options: Any) -> Table:
    """Return an empty table with a column for each heading, all with the same options of rich."""
    found = Table(title=title, show_edge=False)
    for heading in headings:
        found.add_column(heading, **options)
    return found


def pose_names(found: Sequence[Equilibrium]) -> tuple[str, ...]:
    """Return the components of the pose to show, those out of the plane where a load or a pose has such."""
    return POSE[: 6 if any(each.wrench.out_of_plane or each.pose.out_of_plane for each in found) else 3]


def _known(report: SolveReport, error: dict[str, float]) -> dict[str, float]:
    """Return errors, NaN where something left out has no size."""
    return dict.fromkeys(error, math.nan) if any(item.unbounded for item in report.left_out) else error


def equilibrium_table(found: Equilibrium, title: str = "pose", flags: Sequence[str] = ()) -> Table:
    """Return pose with errors, "?" where something left out has no size, and how it came about."""
    lines, names = status_lines(flags), pose_names([found])
    pose, error = asdict(found.pose), asdict(found.error)
    sizes = sizes_of(pose | {f"error_{name}": off for name, off in error.items()}, names)
    shown = (pose, _known(found.report, error), sizes)
    for name in names:
        scale, unit = shown_scale(name)
        lines.append((name, f"{with_error(*(scale * each[name] for each in shown))} {unit}"))
    if found.sunk is not None:
        sunk, off = (1e6 * each for each in found.sunk)
        lines.append(("pressed in", f"{with_error(sunk, off)} um, its lowest point below the cover's top at rest"))
    for name, wrench in (("load", found.wrench), ("on the target", found.acting)):
        if wrench is not None:
            lines.append((name, load_words({part: getattr(wrench, part) for part in WRENCH[:3] + wrench.out_of_plane})))
    if found.error_F_z is not None:
        lines.append(("of the depth", f"F_z = {with_error(found.wrench.F_z, found.error_F_z)} N"))
    return key_table(title, lines + volume_lines(found.report) + report_lines(found.report))


def impedance_table(coils: Sequence[str], found: Impedance, flags: Sequence[str] = ()) -> Table:
    """Return L and R of each pair of coils with errors at one pose, and how they came about."""
    scale, unit_L = (1e6, found.unit_L.replace("H", "uH", 1))
    unit_R = found.unit_L.replace("H", "ohm", 1)
    changed, lost = scale * float(np.abs(found.L - found.L0).max()), float(np.abs(found.R).max())
    error_L = found.error_L + (0.0 if found.error_L0 is None else found.error_L0)
    lines = [*status_lines(flags), ("frequency", f"{found.frequency:.6g} Hz")]
    for i, first in enumerate(coils):
        for j, second in enumerate(coils[: i + 1]):
            L = with_error(scale * float(found.L[i, j]), scale * float(error_L[i, j]), changed)
            R = with_error(float(found.R[i, j]), float(found.error_R[i, j]), lost)
            free = f"{scale * float(found.L0[i, j]):.6g} {unit_L} in free space"
            name, lost_by = (first, "R - R_dc") if i == j else (f"{first}, {second}", "R")
            lines.append((name, f"L = {L} {unit_L}, {lost_by} = {R} {unit_R}; {free}"))
    return key_table("impedance", lines + report_lines(found.report))


def terminal_table(coils: Sequence[str], seen: Terminals | None, missing: Sequence[str]) -> Table:
    """Return each coil's impedance at the end of its leads, or why there is none."""
    lines = []
    if seen is not None:
        for k, name in enumerate(coils):
            shown = f"L = {1e6 * seen.L[k]:.6g} uH, R = {seen.R[k]:.4g} ohm, Q = {seen.Q[k]:.4g}"
            uneven = f"uneven current takes {-1e9 * seen.shift[k]:.3g} nH of L"
            lines.append((name, f"{shown}; tracks without metal: {seen.R_ac[k]:.4g} ohm, {uneven}"))
            resonance = 1e-6 * seen.tank_frequency[k]
            tank = f"resonance at {resonance:.5g} MHz" if resonance > 0.0 else "no resonance"
            apparent = f"L = {1e6 * seen.apparent_L[k]:.5g} uH, R = {seen.apparent_R[k]:.4g} ohm"
            lines.append(("", f"with the capacitance: {tank}; apparent {apparent}, Q = {seen.apparent_Q[k]:.4g}"))
            own = f"{1e12 * seen.own_capacitance[k]:.2g} pF, resonant with L at {1e-6 * seen.self_resonance[k]:.2g} MHz"
            if seen.own_capacitance[k] > 0.0:
                lines.append(("", f"own capacitance of the tracks: about {own}, not in these"))
    return key_table("terminals", [*lines, *(("left out", text) for text in missing)])


def spectrum_table(data: xr.Dataset) -> Table:
    """Return L, R and Q of each coil over frequency, with terminal values where the model is in henry and ohm."""
    unit = data.attrs["unit_L"]
    report = report_of(data.attrs["report"])
    title = f"{data.attrs['name']}: {report.model}, {report.seconds:.3g} s, {report.unknowns} unknowns"
    unit_L, unit_R = (unit.replace("H", each, 1) for each in ("uH", "ohm"))
    headings = ["f [Hz]", "coil", f"L [{unit_L}]", f"R - R_dc [{unit_R}]", "Q [-]"]
    if "shift" in data:
        headings += ["terminals: L [uH]", "R [ohm]", "Q [-]"]
    found = column_table(title, headings, justify="right")
    for hertz in data["frequency"].to_numpy():
        for number, coil in enumerate(data["coil"].to_numpy()):
            last = number + 1 == data.sizes["coil"]
            found.add_row(*_spectrum_cells(data.sel(frequency=hertz, coil=coil, coil_2=coil)), end_section=last)
    missed = sentences(note for note in report.notes if note.kind is NoteKind.TOLERANCE_MISSED)
    error = missed or [f"largest relative error {report.estimated_error:.1e}"]
    found.caption = "; ".join([*error, *map(line, report.left_out)])
    return found


def _spectrum_cells(row: xr.Dataset) -> list[str]:
    """Return the cells of one frequency and coil."""
    L = with_error(1e6 * float(row["L"]), 1e6 * float(row["error_L"] + row["error_L0"]))
    R = with_error(float(row["R"]), float(row["error_R"]))
    cells = [f"{float(row['frequency']):.6g}", str(row["coil"].item()), L, R, f"{float(row['Q']):.4g}"]
    if "shift" in row:
        L_seen, R_seen, Q_seen = (float(row[f"terminal_{name}"]) for name in ("L", "R", "Q"))
        cells += [f"{1e6 * L_seen:.6g}", f"{R_seen:.4g}", f"{Q_seen:.4g}"]
    return cells


def signal_table(found: Signals, unit_L: str, flags: Sequence[str]) -> Table:
    """Return the signals with errors."""
    unit, known = unit_L.replace("H", "uH", 1), {name: float(value) for name, value in found.known.items()}
    size, lines = max(sizes_of(known, SIGNALS).values()), status_lines(flags)
    lines += [(name, f"{with_error(known[name], known[f'error_{name}'], size)} % of L0") for name in SIGNALS]
    for name in (name for name in COMBINED if name in known):
        own = abs(known["L_v"] / known["L_v_percent"])
        absolute = with_error(1e6 * known[name], 1e6 * known[f"error_{name}"], 1e6 * own * size)
        percent = with_error(known[f"{name}_percent"], known[f"error_{name}_percent"], size)
        lines.append((name, f"{absolute} {unit}, that is {percent} % of L0"))
    return key_table("signals", lines)


def status_lines(flags: Sequence[str]) -> list[tuple[str, str]]:
    """Return the status of an answer as a line of a table; none without flags."""
    return [("status", "; ".join(flags))] if flags else []


def volume_lines(report: SolveReport) -> list[tuple[str, str]]:
    """Return smallest volume ratio and largest stretch of a layer as lines of a table; none where none was solved."""
    if report.min_J is None:
        return []
    lines = [("smallest J", f"{report.min_J:.4f}, volume ratio at the worst point, usually at a bonded edge")]
    if report.stretch is not None:
        lines.append(("stretch", f"{report.stretch:.3f}, 99.9th percentile over the layer"))
    return lines


def report_lines(report: SolveReport) -> list[tuple[str, str]]:
    """Return how a number came about, as lines of a table."""
    solved = f"{report.model}, {report.unknowns} unknowns, {report.iterations} iterations, {report.seconds:.3g} s"
    ended = "" if report.status == "converged" else f", {report.status}"
    lines = [("model", f"{solved}, relative error {report.estimated_error:.1e}{ended}")]
    return lines + [("note", words) for words in sentences(report.notes)]
