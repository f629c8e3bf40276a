"""Find what looks like a coil on a board, by its turns alone, and how each is taken.

Of each piece of copper the longest way between two of its joints is followed; it looks like a coil where its direction
turns by 0.7 of a full turn or more (`pieces.TURNS`).
"""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from sits_mech.boards.copper import Board, board_point
from sits_mech.boards.joints import ROUNDING, Joints
from sits_mech.boards.lines import length_of
from sits_mech.boards.pieces import COARSE, FEW, TURNS, Copper, alone, longest_path, of_footprint, of_net, pieces, turns
from sits_mech.boards.route import Route, route
from sits_mech.boards.stackup import METRES
from sits_mech.quantities import Array
from sits_mech.units import SceneError

_MOST = 40  # that are listed


@dataclass(frozen=True)
class CoilCandidate:
    """What looks like a coil."""

    turns: float
    layers: tuple[str, ...]  # in the order of the current
    length: float  # [m]
    middle: Array  # (2,) of the box around it [m]
    size: Array  # (2,) of that box [m]
    nets: tuple[str, ...]  # of its tracks and of the pads that it ends in
    take: str  # the option that takes it, as a shell needs it
    refusal: str  # why it is no coil; empty where it is one
    path: Route | None  # where it is one

    @property
    def text(self) -> str:
        """Return what it is in a line, for a reader."""
        nets = f", nets {' and '.join(self.nets)}" if self.nets else ", no net"
        return f"{self.take} ({1e3 * self.length:.4g} mm, {self.turns:.1f} turns at {board_point(self.middle)}{nets})"


def windings(board: Board) -> tuple[CoilCandidate, ...]:
    """Return what looks like a coil, that of most turns first."""
    found = [(turns(piece), piece, longest_path(piece)) for piece in pieces(board)]
    most = sorted((each for each in found if each[0] >= TURNS), key=lambda each: -each[0])[:_MOST]
    return tuple(_winding(board, *each) for each in most)


def hint(board: Board) -> str:
    """Return what looks like a coil and can be taken, in words for the end of a message."""
    found = [each for each in windings(board) if not each.refusal]
    more = f" and {len(found) - FEW} more" if len(found) > FEW else ""
    listed = ", ".join(each.text for each in found[:FEW]) + more
    return f"what looks like a coil: {listed}" if found else "no single path of its copper looks like a coil"


def _winding(board: Board, number: float, piece: Joints, line: Array) -> CoilCandidate:
    """Return a piece as what looks like a coil."""
    low, high = line.min(axis=0), line.max(axis=0)
    layers = tuple(dict.fromkeys(track.layer for track in piece.tracks))
    path, refusal = _followed(alone(board, piece))
    if path is not None:
        line = np.vstack([run.points for run in path.runs])
        layers = tuple(layer for layer, _ in groupby(run.layer for run in path.runs))
    take, nets = _take(board, piece, path), tuple(sorted(piece.track_nets | piece.hole_nets))
    return CoilCandidate(number, layers, length_of(line), (low + high) / 2, high - low, nets, take, refusal, path)


def _take(board: Board, piece: Joints, path: Route | None) -> str:
    """Return the option that takes a piece alone: its net, its footprint, a net of its pads, else a place on it."""
    x, y = piece.tracks[0].points[0] / METRES * (1, -1) + 0.0
    by_place = f"--at={x:.10g},{y:.10g},{piece.tracks[0].layer}"
    if path is None:
        return by_place
    held = [hole.net for hole in board.holes]
    asked = [("--net", net) for net in sorted(piece.track_nets)]
    asked += [("--footprint", name) for name in board.references(piece.tracks)]
    asked += [("--net", net) for net in sorted(sorted(piece.hole_nets), key=held.count)]  # ground last
    for option, name in asked:
        found, _ = _followed((of_net if option == "--net" else of_footprint)(board, name))
        if found is not None and found.ends == path.ends:
            return f"{option}={shlex.quote(name)}"
    return by_place


def _followed(copper: Copper) -> tuple[Route | None, str]:
    """Return copper as a path, else why it is none."""
    try:
        return route(copper, max(COARSE * max((track.width for track in copper.tracks), default=0.0), ROUNDING)), ""
    except SceneError as error:
        return None, str(error).removeprefix(f"{copper.where}: ")
