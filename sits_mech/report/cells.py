"""Show what cells read of each other: as a record for a program, as tables, and as a picture of pad and matrix."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from sits_mech.chain.cells import FORCES, CellCrosstalk
from sits_mech.geometry.tracks import coil_lines
from sits_mech.report.pictures.style import COLUMN, TRACKS, add_polygons, new_figure
from sits_mech.report.records import status_record
from sits_mech.report.tables.solves import column_table, key_table, status_lines, with_error
from sits_mech.scene.cells import Cells
from sits_mech.units import MM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def cells_record(found: CellCrosstalk) -> dict[str, Any]:
    """Return crosstalk for a program: by cell that reads, force read, cell pressed and force on it [N/N]."""
    shown = ("total", "mechanical", "magnetic", "error", "load", "finite_strain", "seconds")
    record = {"cells": found.cells.names, "reads": found.reads, "forces": FORCES}
    return record | {name: getattr(found, name) for name in shown} | status_record(found.flags)


def cells_tables(found: CellCrosstalk) -> list[Table]:
    """Return crosstalk for a reader: the largest of each force, F_z of each cell, its parts and what is left out."""
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
    strain = "not bounded" if math.isinf(found.finite_strain) else f"{100.0 * found.finite_strain:.2g} % of each figure"
    lines = [
        *status_lines(found.flags),
        ("through fields", f"{fields.max():.2g} % at most; all else through the silicone"),
        ("left out", f"finite strain: {strain} where a cell is pressed by {found.load:g} N"),
        ("took", f"{found.seconds:.3g} s"),
    ]
    return [most, press, key_table("crosstalk", lines)]


def cells_figure(found: CellCrosstalk) -> Figure:
    """Draw the pad with its cells from above, and which F_z each reads by F_z on another."""
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


def _draw_plan(axes: Axes, cells: Cells) -> None:
    """Draw pad, targets and coils from above."""
    (target, pad), box = cells.parts, np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    add_polygons(axes, MM * box[None] * pad.extent, facecolors="#efcf9f")
    add_polygons(axes, MM * (cells.centres[:, None] + box * target.extent), facecolors="#b87333")
    for cell, place in zip(cells.targets, cells.centres, strict=True):
        for line in (line for coil in cells.coils_at(place) for line, _ in coil_lines(coil)):
            axes.plot(*MM * line[:, :2].T, color=TRACKS[1], linewidth=0.35)
        axes.annotate(cell.name, MM * place, ha="center", va="center", fontsize=7)
    axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal", title="cells and coils from above")
    axes.grid(False)
