"""Show what cells read of each other: as a record for a program, as tables, and as a picture of pad and matrix."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from sits_mech.chain.cells.crosstalk import FORCES, CellCrosstalk, CellTouch
from sits_mech.geometry.tracks import coil_lines
from sits_mech.quantities import POSE
from sits_mech.report.pictures.style import COLUMN, TRACKS, add_polygons, new_figure
from sits_mech.report.records import status_record
from sits_mech.report.tables.solves import column_table, key_table, status_lines, with_error
from sits_mech.scene.cells import Cells
from sits_mech.scene.parts.slots import Slot
from sits_mech.units import MM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def cells_record(found: CellCrosstalk | CellTouch) -> dict[str, Any]:
    """Return crosstalk by cell that reads, force read, cell pressed and force on it, or what a touch does by cell."""
    more: dict[str, Any] = {"coils": found.cells.coil_names, "components": POSE}
    if isinstance(found, CellCrosstalk):
        more = {"forces": FORCES, "total": found.total}
    shown = {each.name: getattr(found, each.name) for each in fields(found) if each.name not in ("cells", "flags")}
    return {"cells": found.cells.names} | more | shown | status_record(found.flags)


def cells_tables(found: CellCrosstalk | CellTouch) -> list[Table]:
    """Return crosstalk for a reader: the largest of each force, F_z of each cell, its parts and what is left out."""
    if isinstance(found, CellTouch):
        return _touch_tables(found)
    names, own = found.cells.names, np.eye(len(found.cells.names), dtype=bool)[:, None, :, None]
    total, magnetic, error = 100.0 * np.stack([found.total, found.magnetic, found.error])
    fields = np.where(own, 0.0, np.abs(magnetic))
    most = column_table("largest reading by a force on another cell [%]", ["reads", *FORCES])
    for force, *row in zip(found.reads, *(100.0 * part for part in found.largest), strict=True):
        most.add_row(force, *(with_error(*both) for both in zip(*row, strict=True)))
    press = column_table("F_z read by F_z on another cell [%]", ["reads", *(f"on {name}" for name in names)])
    for i, name in enumerate(names):
        each = zip(total[i, 0, :, 0], error[i, 0, :, 0], strict=True)
        press.add_row(name, *(with_error(*both) if j != i else "" for j, both in enumerate(each)))
    strain = _strain(found.finite_strain, "each figure")
    lines = [
        *status_lines(found.flags),
        ("through fields", f"{np.nanmax(fields):.2g} % at most; all else through the silicone"),
        ("left out", f"finite strain: {strain} where a cell is pressed by {found.load:g} N"),
        ("took", f"{found.seconds:.3g} s"),
    ]
    return [most, press, key_table("crosstalk", lines)]


def _touch_tables(found: CellTouch) -> list[Table]:
    """Return what a touch does for a reader: how far the target of each cell moves, its coils, forces read."""
    coils = found.cells.coil_names
    moves = column_table("targets move", ["cell", *(f"{x} [u{'rad' if 'alpha' in x else 'm'}]" for x in POSE)])
    read = column_table("cells read", ["cell", *(f"{name} [%]" for name in coils), *(f"{x} [mN]" for x in found.reads)])
    values = [1e6 * found.moved, np.hstack([100.0 * (found.L / found.L_rest - 1.0), 1e3 * found.read])]
    errors = [1e6 * found.pose_error, np.hstack([100.0 * found.L_error / found.L_rest, 1e3 * found.read_error])]
    for table, *both in zip((moves, read), values, errors, strict=True):
        for name, *row in zip(found.cells.names, *both, strict=True):
            sizes, known = np.nanmax(np.abs(both[0]), axis=0), np.isfinite(row[0])
            each = zip(*row, sizes, known, strict=True)
            table.add_row(name, *(with_error(*own) if one else "" for *own, one in each))
    lines = [
        *status_lines(found.flags),
        ("touch", f"{found.cells.touched.words}, {found.force:g} N"),
        ("finite strain", f"{_strain(found.finite_strain, 'how far targets move')}; left out of forces read"),
        ("took", f"{found.seconds:.3g} s"),
    ]
    return [moves, read, key_table("touch", lines)]


def _strain(share: float, of: str) -> str:
    """Return a share of finite strain in words."""
    return "not bounded" if math.isinf(share) else f"{100.0 * share:.2g} % of {of}"


def cells_figure(found: CellCrosstalk | CellTouch) -> Figure:
    """Draw the pad with its cells from above, and which F_z each reads by F_z on another, or what a touch changes."""
    if isinstance(found, CellTouch):
        change = 100.0 * (found.L / found.L_rest - 1.0)
        with new_figure(1.0, width=1.2 * COLUMN) as (figure, (plan,)):
            words = ["\n".join(f"{each:+.2g} %" for each in own if each == each) for own in change]
            _draw_plan(plan, found.cells, words)
            plan.set(title=f"$\\Delta L$ under a {found.cells.touched.words}, {found.force:g} N")
            return figure
    names, own = found.cells.names, np.eye(len(found.cells.names), dtype=bool)
    percent = np.where(own, np.nan, 100.0 * found.total[:, 0, :, 0])
    with new_figure(0.55, columns=2, width=2.0 * COLUMN) as (figure, (plan, matrix)):
        _draw_plan(plan, found.cells)
        most = float(np.nanmax(np.abs(percent)))
        matrix.imshow(percent, cmap="RdBu", vmin=-2.0 * most, vmax=2.0 * most)  # pale enough for black numbers
        for (i, j), value in np.ndenumerate(percent):
            matrix.annotate("" if i == j else f"{value:.2g}", (j, i), ha="center", va="center", fontsize=6)
        matrix.set_xticks(range(len(names)), names)
        matrix.set_yticks(range(len(names)), names)
        matrix.set(xlabel="pressed", ylabel="reads", title=f"cells read up to {most:.2g} % of $F_z$ on another")
        matrix.grid(False)
        return figure


def _slot_colour(slot: Slot) -> str:
    """Return the colour of a wall, of a slot through the pad, or of one with a bottom."""
    return "#808080" if slot.wall else "#ffffff" if slot.depth is None else "#f9ecd8"


def _draw_plan(axes: Axes, cells: Cells, labels: Sequence[str] = ()) -> None:
    """Draw pad, targets, coils and what touches them from above, cells with labels below their names."""
    pad, box = cells.pad, np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    add_polygons(axes, MM * box[None] * pad.extent, facecolors="#efcf9f")
    for slot in cells.slots:
        size, middle = np.array(pad.extent), np.zeros(2)
        size[slot.axis], middle[slot.axis] = slot.width, slot.ends.mean()
        add_polygons(axes, MM * (middle + box * size)[None], facecolors=_slot_colour(slot))
    add_polygons(axes, MM * (cells.centres[:, None] + box * np.ptp(cells.ends, axis=1)[:, None]), facecolors="#b87333")
    each = zip(cells.targets, cells.centres, labels or [""] * len(cells.targets), strict=True)
    for k, (cell, place, label) in enumerate(each):
        for line in (line for coil in cells.coils_at(k, place) for line, _ in coil_lines(coil)):
            axes.plot(*MM * line[:, :2].T, color=TRACKS[1], linewidth=0.35)
        axes.annotate(f"{cell.name}\n{label}".strip(), MM * place, ha="center", va="center", fontsize=7)
    if len(cells.cover_ends):
        low, high = cells.cover_ends
        add_polygons(axes, MM * (box * (high - low) + (low + high) / 2.0)[None], facecolors="#e8c48a80", edgecolors="k")
    if cells.touch is not None:
        at, flat = cells.touch.place, cells.touch.border
        axes.fill(*MM * (flat + at).T, facecolor="#3050c040", edgecolor="#3050c0")
        axes.plot(*MM * np.array(at), "+", color="#3050c0", markersize=6)
    axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal", title="cells and coils from above")
    axes.grid(False)
