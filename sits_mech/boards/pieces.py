"""Find copper that hangs together, by geometry alone, and what of it a net, a footprint or a place names.

Pieces are what tracks, drawings and vias make where their ends meet (`joints`); pads with a number part them. Of a net
are its tracks and the pieces without a net, drawings and a footprint's lines, that end in its tracks or pads; of a
footprint the pieces that have lines of it, else those that end in its pads; at a place is the piece whose copper is
there, else the nearest that turns, else the nearest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import lru_cache
from itertools import pairwise

import numpy as np

from sits_mech.boards.copper import Board, Hole, Track, board_point
from sits_mech.boards.joints import ROUNDING, Joints, connections, merged
from sits_mech.boards.lines import flattened, length_of, longest_way, spaced
from sits_mech.quantities import Array
from sits_mech.units import SceneError, shown

FEW = 6  # names in a message
_STEP = 3.0  # over the width, of what is counted as a turn: more than what leads into a via
COARSE = 0.05  # error of chords over the width, where copper is looked for
TURNS = 0.7  # of what may be a coil: a square loop that is open at a corner has three corners of a quarter


@dataclass(frozen=True)
class Copper:
    """What may be a coil: tracks and what joins them."""

    name: str  # of the coil; empty without one
    title: str  # for a reader: "net L1"
    board: str  # its name
    tracks: tuple[Track, ...]
    holes: tuple[Hole, ...]
    net: str = ""  # that was asked

    @property
    def where(self) -> str:
        """Return what messages begin with."""
        return f"{self.board}: {self.title}"

    def has(self, piece: Joints) -> bool:
        """Tell whether a piece of it is of what was asked: of the net, or ends in its pads."""
        return not self.net or self.net in piece.track_nets | piece.hole_nets


def parts(joints: Joints) -> tuple[Joints, ...]:
    """Return the pieces of joined tracks, each with the vias and pads that are joints of it."""
    if not joints.tracks:
        return ()
    count = 1 + max([int(joints.numbers.max()), *(number for number, _ in joints.holes)])
    label = merged(count, joints.numbers)
    of_track = label[joints.numbers[:, 0]]
    members: dict[int, list[int]] = {}
    for k, number in enumerate(of_track.tolist()):
        members.setdefault(number, []).append(k)
    holes: dict[int, list[tuple[int, Hole]]] = {}
    for joint, hole in joints.holes:
        holes.setdefault(int(label[joint]), []).append((joint, hole))
    return tuple(
        Joints(tuple(joints.tracks[k] for k in some), joints.numbers[some], tuple(holes.get(number, ())))
        for number, some in sorted(members.items())
    )


@lru_cache(maxsize=2)
def pieces(board: Board) -> tuple[Joints, ...]:
    """Return all copper of a board that hangs together."""
    holes = [hole for hole in board.holes if hole.layers]
    return parts(connections(board.tracks, holes)) if board.tracks else ()


def of_net(board: Board, net: str) -> Copper:
    """Return the copper of a net; raise SceneError where the board has no such net."""
    if net not in board.nets:
        raise SceneError(f"--net: {board.name}: {_unknown('net', net, board.nets)}")
    mine = [piece for piece in pieces(board) if net in piece.track_nets | piece.hole_nets]
    found = _together(board, mine, net, f"net {net}")
    own = {id(track): track for track in (*(track for track in board.tracks if track.net == net), *found.tracks)}
    ends = {id(hole) for hole in found.holes}
    holes = [hole for hole in board.holes if hole.layers and (hole.net == net or id(hole) in ends)]
    return replace(found, tracks=tuple(own.values()), holes=tuple(holes), net=net)


def of_footprint(board: Board, reference: str) -> Copper:
    """Return the copper of a footprint; raise SceneError where there is no such."""
    numbers = {k for k, name in enumerate(board.footprints) if name == reference}
    if not numbers:
        raise SceneError(f"--footprint: {board.name}: {_unknown('footprint', reference, sorted({*board.footprints}))}")
    lines = [piece for piece in pieces(board) if any(track.footprint in numbers for track in piece.tracks)]
    ends = [piece for piece in pieces(board) if any(hole.footprint in numbers for _, hole in piece.holes)]
    return _together(board, lines or ends, reference, f"footprint {reference}")


def at_place(board: Board, point: Array, layer: str) -> Copper:
    """Return the copper at a place (2,) [m], on any layer where that is "".

    Raise SceneError where the board has no tracks, or none on the layer.
    """
    gaps = [_away(piece, point, layer) for piece in pieces(board)]
    if min(gaps, default=np.inf) == np.inf:
        on = layer and f" on {layer}"
        raise SceneError(f"--at: {board.name}: must be a place of a board with tracks{on}; got none")
    near = [k for k in np.argsort(gaps, kind="stable").tolist() if gaps[k] < np.inf]
    here = [pieces(board)[k] for k in near if gaps[k] == 0.0 or gaps[near[0]] > 0.0]
    return alone(board, next((piece for piece in here if turns(piece) >= TURNS), here[0]))


def _away(piece: Joints, point: Array, layer: str) -> float:
    """Return how far a piece's copper is from a place, infinite where it has none on the layer [m]."""
    import shapely

    some = [track for track in piece.tracks if layer in ("", track.layer)]
    away = shapely.distance(shapely.Point(point), [shapely.LineString(drawn(track)) for track in some])
    return min((max(gap - track.width / 2, 0.0) for gap, track in zip(away, some, strict=True)), default=np.inf)


def alone(board: Board, piece: Joints) -> Copper:
    """Return a piece of copper as that of a coil, named by its net or its footprint, if any."""
    at = f"{board_point(piece.tracks[0].points[0])} on {piece.tracks[0].layer}"
    names = [*sorted(piece.track_nets), *board.references(piece.tracks), ""]
    return _together(board, [piece], names[0], f"copper at {at}")


def drawn(track: Track) -> Array:
    """Return a track as a line, roughly; a bad arc as its points."""
    try:
        return flattened(track, max(COARSE * track.width, ROUNDING), "")
    except SceneError:
        return track.points


def turns(piece: Joints) -> float:
    """Return how often the longest way through a piece turns: the reach of its direction over 2 pi."""
    line = longest_path(piece)
    steps = np.diff(spaced(line, _STEP * max(track.width for track in piece.tracks)), axis=0) if len(line) else line
    steps = steps[np.hypot(*steps.T) > 0.0]
    return float(np.ptp(np.unwrap(np.arctan2(*steps.T[::-1])))) / (2.0 * np.pi) if len(steps) else 0.0


@lru_cache(maxsize=4096)
def longest_path(piece: Joints) -> Array:
    """Return the longest of the shortest ways between two joints of a piece, as points (n, 2) [m]."""
    lines = [drawn(track) for track in piece.tracks]
    known, places = np.unique(piece.numbers, return_inverse=True)
    ends = places.reshape(-1, 2)
    which = {each: k for k, (a, b) in enumerate(ends.tolist()) for each in ((a, b), (b, a))}
    path = longest_way(ends, np.array([max(length_of(line), 1e-12) for line in lines]), len(known))
    order = [(which[step], step[0]) for step in pairwise(path)]
    return np.vstack([np.zeros((0, 2)), *(lines[k][:: 1 if ends[k, 0] == a else -1] for k, a in order)])


def _together(board: Board, some: Sequence[Joints], name: str, title: str) -> Copper:
    """Return pieces as the copper of a coil."""
    holes = {id(hole): hole for piece in some for _, hole in piece.holes}
    tracks = (track for piece in some for track in piece.tracks)
    return Copper(name, title, board.name, tuple(tracks), tuple(holes.values()))


def _unknown(kind: str, name: str, known: Sequence[str]) -> str:
    """Return what a name must be, with those of the board that are like it."""
    lower = {each.lower(): each for each in known}
    like = ", ".join(lower[each] for each in get_close_matches(name.lower(), lower, FEW))
    return f"must be a {kind} of the board{like and f', such as {like}'}; got {shown(name)}"
