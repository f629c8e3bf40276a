"""Show what cells read of each other: as a record for a program, as tables, and as a picture of pad and matrix."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from sits_mech.chain.cells import FORCES, CellCrosstalk
from sits_mech.chain.cells_touch import CellTouch
from sits_mech.chain.propagation import unloaded_pose
from sits_mech.geometry.tracks import coil_lines
from sits_mech.quantities import POSE
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
    strain = _strain(found.finite_strain) + " of each figure" * math.isfinite(found.finite_strain)
    lines = [
        *status_lines(found.flags),
        ("through fields", f"{fields.max():.2g} % at most; all else through the silicone"),
        ("left out", f"finite strain: {strain} where a cell is pressed by {found.load:g} N"),
        ("took", f"{found.seconds:.3g} s"),
    ]
    return [most, press, key_table("crosstalk", lines)]


def touch_record(found: CellTouch) -> dict[str, Any]:
    """Return what a touch does for a program: by cell, its pose, coils and forces read [m, rad, H, N]."""
    shown = ("force", "poses", "pose_error", "L", "L_error", "L_rest", "reads", "read", "read_error", "finite_strain",
             "seconds")
    coils = [coil.name for coil in found.cells.sensor.coils]
    record = {"cells": found.cells.names, "coils": coils, "components": POSE}
    return record | {name: getattr(found, name) for name in shown} | status_record(found.flags)


def touch_tables(found: CellTouch) -> list[Table]:
    """Return what a touch does for a reader: poses and coils of each cell, forces read, and what is left out."""
    names, (turns, coils) = found.cells.names, (("alpha", "alpha_x"), found.cells.sensor.coils)
    poses = column_table("how far targets move", ["cell", "d_h [um]", "d_y [um]", "d_v [um]",
                                                  *(f"{name} [mrad]" for name in turns)])
    columns = [(name, 1e3 if name in turns else 1e6) for name in ("d_h", "d_y", "d_v", *turns)]
    rest = unloaded_pose(found.cells.sensor).components
    for name, pose, error in zip(names, found.poses - rest, found.pose_error, strict=True):
        each = [[scale * float(part[POSE.index(key)]) for part in (pose, error)] for key, scale in columns]
        poses.add_row(name, *(with_error(*both) for both in each))
    heads = [f"{coil.name} [% of L_rest]" for coil in coils] + [f"reads {name} [mN]" for name in found.reads]
    read = column_table("what cells read", ["cell", *heads])
    percent, off = (100.0 * part / found.L_rest for part in (found.L - found.L_rest, found.L_error))
    for k, name in enumerate(names):
        forces = 1e3 * found.read[k], 1e3 * found.read_error[k]
        both = np.concatenate([np.stack([percent[k], off[k]], axis=1), np.stack(forces, axis=1)])
        read.add_row(name, *(with_error(*each) for each in both.tolist()))
    lines = [
        *status_lines(found.flags),
        ("touch", f"{found.cells.touched.words}, {found.force:g} N"),
        ("finite strain", f"{_strain(found.finite_strain)} of how far targets move; of small strain: forces read"),
        ("took", f"{found.seconds:.3g} s"),
    ]
    return [poses, read, key_table("touch", lines)]


def touch_figure(found: CellTouch) -> Figure:
    """Draw the pad with its cells and the touch from above, and what the coils of each change by."""
    names, coils = found.cells.names, found.cells.sensor.coils
    with new_figure(0.55, columns=2, width=2.0 * COLUMN) as (figure, (plan, bars)):
        _draw_plan(plan, found.cells)
        change, off = (100.0 * part / found.L_rest for part in (found.L - found.L_rest, found.L_error))
        for k, coil in enumerate(coils):
            places = np.arange(len(names)) + 0.8 * ((k + 0.5) / len(coils) - 0.5)
            bars.bar(places, change[:, k], 0.7 / len(coils), yerr=off[:, k], color=f"C{k}", label=coil.name)
        bars.set_xticks(range(len(names)), names)
        bars.set(xlabel="cell", ylabel=r"$\Delta L$ [% of $L$ at rest]", title=f"coils under {found.force:g} N")
        if len(coils) > 1:
            bars.legend()
        return figure


def _strain(share: float) -> str:
    """Return a share of finite strain in words."""
    return "not bounded" if math.isinf(share) else f"{100.0 * share:.2g} %"


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
    if cells.cover_ends is not None:
        low, high = cells.cover_ends
        add_polygons(axes, MM * (box * (high - low) + (low + high) / 2.0)[None], facecolors="#e8c48a80", edgecolors="k")
    if cells.touch is not None:
        at, flat = cells.touch.place, cells.touch.border
        axes.fill(*MM * (flat + at).T, facecolor="#3050c040", edgecolor="#3050c0")
        axes.plot(*MM * np.array(at), "+", color="#3050c0", markersize=6)
    axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal", title="cells and coils from above")
    axes.grid(False)
