"""Tabulate a study: its plan, a line for each case, and one for each reason why cases have no result."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table

from sits_mech.batch.tables import SWEPT
from sits_mech.chain.cells.crosstalk import FORCES
from sits_mech.labels import unit_of
from sits_mech.memory import GIB
from sits_mech.readout.loads import each_of, point, points
from sits_mech.readout.signals import shown_signals
from sits_mech.report.left_out import kept_lines
from sits_mech.report.tables.solves import column_table, point_name
from sits_mech.status import ANSWERED, failure_kind

if TYPE_CHECKING:
    import xarray as xr

    from sits_mech.batch.forecast import Forecast
    from sits_mech.batch.sensitivity import Sensitivity

_POSE = ("d_h", "d_y", "d_v", "alpha_x", "alpha", "alpha_z")
_SHOWN = {
    "pose": (*_POSE, "error_mechanics"),
    "inductance": ("relative", "L", "R", "error_magnetics"),
    "simulate": _POSE,
    "cells": tuple(f"{read}_by_{force}" for read in FORCES for force in FORCES),
    "calibrate": ("failed_loads",),
    "quality": ("resolution", "error_by_model", "linearity", "crosstalk", "condition", "failed_loads"),
}
_PLANNED = ("", "times", "s each", "s in all", "s saved by sharing")
_STEPS = ("processes", "coils and plates", "pads", "rests", "cases")
_MOST = 40  # lines: the file holds all


def case_table(data: xr.Dataset) -> Table:
    """Return a study's cases in at most forty lines, SI: matrix diagonals, calibrations' spans, worst figures."""
    shown = _SHOWN[data.attrs["request"]]
    signals = () if data.attrs["request"] == "quality" else shown_signals(data)
    names = [name for name in (*shown, *signals) if name in data]
    where = [str(name) for name in data["status"].coords]
    numbered = data.attrs["request"] in SWEPT
    headings = (*["case"] * numbered, *(_heading(data, name) for name in (*where, *names)), "s", "status")
    found = column_table(f"{data.attrs['request']}: {data['status'].size} cases", headings, justify="right")
    for number, row in enumerate(points(data)):
        if number == _MOST:
            found.caption = f"and {data['status'].size - _MOST} more"
            break
        values = [_text(row[name].to_numpy()) for name in (*where, *names, "seconds")]
        found.add_row(*[str(number + 1)] * numbered, *values, str(row["status"].item()))
    return found


def plan_table(plan: Forecast, asked: str, processes: int, *, cluster: bool = False) -> Table:
    """Return what is left of a study: how often each step is made, its seconds, and those that sharing saves.

    The processes are of this machine, or the workers of a cluster, which have a core each.
    """
    whole = plan.cases + plan.kept
    found = column_table(f"{asked}: {whole} cases, {plan.kept} of them kept", _PLANNED, justify="right")
    for row in zip(_STEPS, plan.counts(processes), plan.steps, plan.saved, strict=True):
        name, count, each, saved = row
        if each or name == "cases":
            found.add_row(name, f"{count:g}", f"{each:.3g}", f"{count * each:.3g}", f"{saved:.3g}")
    memory = "" if plan.memory is None else f", {(processes + (processes > 1)) * plan.memory / GIB:.2g} GiB"
    wall, where = plan.wall(processes, processes if cluster else None), "on {} workers" if cluster else "with -j {}"
    found.caption = f"{plan.seconds(processes):.3g} s of processor time, {wall:.3g} s {where.format(processes)}{memory}"
    return found


def plan_words(plan: Forecast) -> str:
    """Return in a line what is left of a study, or some processor seconds of all: recorded, or once cases are tried."""
    count, seconds = plan.tried
    if count:
        return f"tried {count} cases in {seconds:.2g} s: all some {plan.seconds():.2g} s"
    if plan.seconds():
        return f"all some {plan.seconds():.2g} s, as its models take on other scenes"
    parts = (f"{name}: {each:g}" for name, each in zip(_STEPS[1:-1], plan.counts()[1:-1], strict=True))
    return f"{plan.cases} cases to solve, {plan.kept} kept; {', '.join(parts)}"


def _heading(data: xr.Dataset, name: str) -> str:
    """Return a column's name with its unit; of inductances that of the models, both where both are there."""
    unit = (unit_of(name, "") or data[name].attrs.get("units", "")).removeprefix("1").strip()
    if "force" in data[name].dims:
        return f"{name} [{'  '.join(data['force'].to_numpy())}]"
    if name in ("L", "R"):
        units = sorted({str(unit) for unit in data["unit_L"].to_numpy().ravel()} - {""})
        unit = " or ".join(units).replace("H", "H" if name == "L" else "ohm")
    return f"{name} [{unit}]" if unit else name


def case_failures(data: xr.Dataset) -> list[str]:
    """Return a line for each kind of reason why cases have no result: how many, the first of them, its reason."""
    status, reason = each_of(data), each_of(data, "reason")
    found: dict[str, list[int]] = {}
    for number, state in enumerate(status):
        if state not in ANSWERED:
            found.setdefault(failure_kind(state, reason[number]), []).append(number)
    return [
        f"{len(own)} of {len(status)} cases, first {point_name(point(data[['status']], own[0]))}: {status[own[0]]}: "
        f"{reason[own[0]]}" for own in found.values()
    ]


def case_remarks(data: xr.Dataset) -> list[str]:
    """Return a line for each kind of what the models of a study's cases leave out, the largest of each."""
    names = [name for name in data if str(name).startswith("left_out")]
    return [line for name in names for line in kept_lines(filter(None, each_of(data, str(name))))]


def _text(values: np.ndarray) -> str:
    """Return a number or a word, the diagonal of a matrix, or the span of many numbers."""
    if values.dtype.kind not in "fi":
        return str(values.item())
    if values.ndim == 2 and values.shape[0] == values.shape[1] <= 4:
        values = np.diagonal(values)
    if values.size <= 4:
        return "  ".join(f"{value:.5g}" for value in np.atleast_1d(values))
    if np.all(np.isnan(values)):
        return "-"
    return f"{np.nanmin(values):.5g} to {np.nanmax(values):.5g}"


def sensitivity_tables(found: Sensitivity) -> list[Table]:
    """Return the indices of a quantity with their intervals, a table for each of its parts."""
    tables, spans = [], (found.first_interval, found.total_interval)
    for k, part in enumerate(found.parts):
        name = f"{found.of}[{part}]" if part else found.of
        table = column_table(f"Sobol' indices of {name}", ("", "first order", "95 %", "total", "95 %"), justify="right")
        for i, key in enumerate(found.keys):
            own = (f"{x:.3f}" for x in (found.first_order[k, i], found.total_order[k, i]))
            ends = (f"{span[0, k, i]:.3f} to {span[1, k, i]:.3f}" for span in spans)
            table.add_row(key, *(text for pair in zip(own, ends, strict=True) for text in pair))
        tables.append(table)
    return tables
