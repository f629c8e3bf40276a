"""Show what looks like a coil on a board: a table with how each is taken, and the board with its coils."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from sits_mech.boards.copper import Board
from sits_mech.boards.pieces import drawn
from sits_mech.boards.scene import coil_alone
from sits_mech.boards.windings import CoilCandidate
from sits_mech.magnetics.coils.loops import free_inductances
from sits_mech.report.pictures.style import new_figure
from sits_mech.report.tables.solves import column_table, short
from sits_mech.units import MM, SceneError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LEAST, _TALLEST = 0.7, 1.6  # heights of a picture, over its width


@dataclass(frozen=True)
class Listed:
    """What looks like a coil, with its inductance in free space [H], None of what is no coil."""

    coil: CoilCandidate
    inductance: float | None

    @property
    def shown(self) -> str:
        """Return the inductance for a reader."""
        return "-" if self.inductance is None else short(1e6 * self.inductance, 4)


def listed(board: Board, found: Sequence[CoilCandidate]) -> tuple[Listed, ...]:
    """Return windings with their inductances."""
    return tuple(Listed(each, _inductance(board, each)) for each in found)


def _inductance(board: Board, found: CoilCandidate) -> float | None:
    """Return the inductance of a coil in free space [H]; None of what is none."""
    try:
        return None if found.path is None else float(free_inductances((coil_alone(board, found.path),))[0, 0])
    except SceneError:
        return None


def winding_table(board: Board, found: Sequence[Listed]) -> Table:
    """Return the table of what looks like a coil."""
    headings = ("", "take it by", "turns", "layers", "track [mm]", "size [mm]", "L [uH]", "nets", "ends", "refused")
    some = headings[: len(headings) - all(each.coil.path is not None for each in found)]
    table = column_table(f"{board.name}: what looks like a coil", some)
    for number, each in enumerate(found, start=1):
        one, (a, b) = each.coil, MM * each.coil.size
        ends = "" if one.path is None else " to ".join(one.path.ends)
        row = (
            str(number), one.take, f"{one.turns:.1f}", ", ".join(one.layers), short(MM * one.length, 4),
            f"{short(a)} x {short(b)}", each.shown, ", ".join(one.nets), ends, one.refusal,
        )
        table.add_row(*row[: len(some)])
    return table


def board_figure(board: Board, found: Sequence[Listed]) -> Figure:
    """Draw a board as KiCad shows it: its copper, and in colours what looks like a coil, by number."""
    from matplotlib.collections import LineCollection, PolyCollection

    corners = np.vstack([np.zeros((0, 2)), *(track.points for track in board.tracks)])
    low, high = (corners.min(axis=0), corners.max(axis=0)) if len(corners) else (np.zeros(2), np.ones(2))
    spread = np.maximum(high - low, 1e-3)
    height = spread[1] / spread[0] + 0.3 + 0.08 * len(found)
    with new_figure(height=min(max(height, _LEAST), _TALLEST)) as (figure, (axes,)):
        fills = [MM * points * (1, -1) for zone in board.zones for _, points in zone.fills]
        pours = PolyCollection(fills, facecolor="0.92", edgecolor="0.8", linewidth=0.3)
        pours.set_label("copper" if fills else "")
        axes.add_collection(pours)
        lines = [MM * drawn(track) * (1, -1) for track in board.tracks]
        axes.add_collection(LineCollection(lines, colors="0.7", linewidth=0.4))
        for number, each in enumerate(found, start=1):
            one, colour = each.coil, f"C{(number - 1) % 7}"
            runs: list[Any] = [] if one.path is None else [MM * run.points * (1, -1) for run in one.path.runs]
            axes.add_collection(LineCollection(runs, colors=colour, linewidth=0.6))
            x, y = MM * one.middle * (1, -1)
            axes.annotate(f"{number}", (x, y), color=colour, ha="center", va="center")
            axes.plot([], [], color=colour, label=f"{number}: {one.take}, {each.shown} uH")
        axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
        axes.autoscale_view()
        axes.margins(0.08)
        axes.invert_yaxis()
        figure.suptitle(f"{fill(Path(board.name).name, 30)}: what looks like a coil")
        if found:
            figure.legend(loc="outside lower center", ncols=1)
    return figure
