"""Show what cells read of each other: as a record for a program, as tables, and as a picture of pad and matrix."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from sits_mech.chain.cells import FORCES, CellCrosstalk
from sits_mech.quantities import Array
from sits_mech.report.pictures.style import COLUMN, TRACKS, new_figure
from sits_mech.report.tables.solves import column_table, key_table, with_error
from sits_mech.scene.cells import Cells
from sits_mech.units import MM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def cells_record(found: CellCrosstalk) -> dict[str, Any]:
    """Return crosstalk for a program: by cell that reads, force read, cell pressed and force on it [N/N]."""
    shown = ("total", "mechanical", "magnetic", "error", "load", "finite_strain", "seconds")
    record = {"cells": found.cells.names, "reads": found.reads, "forces": FORCES}
    return record | {name: getattr(found, name) for name in shown}


def cells_tables(found: CellCrosstalk) -> list[Table]:
    """Return crosstalk for a reader: the largest of each force, F_z of each cell, its parts and what is left out."""
    names, own = found.cells.names, np.eye(len(found.cells.names), dtype=bool)[:, None, :, None]
    size, magnetic = (np.where(own, 0.0, np.abs(each)) for each in (found.total, found.magnetic))
    most = column_table("largest reading by a force on another cell [%]", ["reads", *FORCES])
    for k, force in enumerate(found.reads):
        at = [np.unravel_index(np.argmax(size[:, k, :, j]), own.shape[::2]) for j in range(len(FORCES))]
        most.add_row(force, *(_percent(size[i, k, o, j], found.error[i, k, o, j]) for j, (i, o) in enumerate(at)))
    press = column_table("F_z read by F_z on another cell [%]", ["reads", *(f"on {name}" for name in names)])
    for i, name in enumerate(names):
        each = zip(found.total[i, 0, :, 0], found.error[i, 0, :, 0], strict=True)
        press.add_row(name, *(_percent(*both) if j != i else "" for j, both in enumerate(each)))
    strain = "not bounded" if math.isinf(found.finite_strain) else f"{100.0 * found.finite_strain:.2g} % of each figure"
    lines = [
        ("through fields", f"{100.0 * float(magnetic.max()):.2g} % at most; all else through the silicone"),
        ("left out", f"finite strain: {strain} where a cell is pressed by {found.load:g} N"),
        ("took", f"{found.seconds:.3g} s"),
    ]
    return [most, press, key_table("crosstalk", lines)]


def _percent(value: float, error: float) -> str:
    """Return a figure with its error in percent."""
    return with_error(100.0 * float(value), 100.0 * float(error))


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
        matrix.set(xlabel="pressed", ylabel="reads", title="$F_z$ read by $F_z$ on another cell [%]")
        matrix.grid(False)
        return figure


def _draw_plan(axes: Axes, cells: Cells) -> None:
    """Draw pad, targets and coils from above."""
    target, pad = cells.parts
    coils = [(coil.centre, coil.extent, coil.is_round) for place in cells.centres for coil in cells.coils_at(place)]
    plates = [(cell.centre, target.extent, False) for cell in cells.targets]
    for parts, face, edge in (
        ([((0.0, 0.0), pad.extent, False)], "#efcf9f", "none"), (plates, "#b87333", "none"), (coils, "none", TRACKS[1])
    ):
        corners = [MM * (np.array(middle) + _around(is_round) * np.array(size) / 2) for middle, size, is_round in parts]
        for own in corners:
            axes.fill(*own.T, facecolor=face, edgecolor=edge, lw=0.8)
    for cell in cells.targets:
        x, y = cell.centre
        axes.annotate(cell.name, (MM * x, MM * y), ha="center", va="center", fontsize=7)
    axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal", title="cells and coils from above")
    axes.grid(False)


def _around(is_round: bool) -> Array:
    """Return the rim of a circle or a square from -1 to 1, shape (k, 2)."""
    if not is_round:
        return np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    turn = np.linspace(0.0, 2.0 * np.pi, 65)
    return np.column_stack([np.cos(turn), np.sin(turn)])
