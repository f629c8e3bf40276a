"""Follow the current through a net: one path from end to end over tracks, arcs and vias, as polylines.

A net is one path where two joints are its ends and two tracks meet in every other. What branches, closes a loop or
falls apart is refused with where. Where pads part a net into pieces, the longest is the coil. The path starts at the
end whose pad has the lesser name, else at the greater distance from the coil's middle: outside.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from sits_mech.boards.copper import Track, board_point
from sits_mech.boards.joints import ROUNDING, End, Joints, connections
from sits_mech.boards.lines import flattened, length_of, spaced, thinned
from sits_mech.boards.pieces import Copper, parts
from sits_mech.quantities import Array
from sits_mech.units import SceneError
from sits_mech.units import millimetres as mm

_CARELESS = 0.05  # of the narrowest track's width: ends that are nearer meet, where rounding does not make one path
_LIKE = 0.5  # a piece longer than this share of the longest may be the coil as well
_SAME_WIDTH = 0.01  # tracks whose widths differ by less are one run
_FINEST = 0.02  # points closer than this share of the width are one


@dataclass(frozen=True)
class Run:
    """A polyline of copper on one layer, of one width: the centre line, points of shape (n, 2) [m]."""

    layer: str
    width: float
    points: Array


@dataclass(frozen=True)
class Route:
    """A coil's copper as a path."""

    name: str  # of the coil
    title: str  # what it is on the board, for a reader, such as "net L1"
    nets: frozenset[str]  # of its tracks, and what it was asked by
    runs: tuple[Run, ...]  # in series, in the direction of the current
    ends: tuple[str, str]  # where it starts and ends, for a reader
    end_nets: frozenset[str] = frozenset()  # of the pads in which it ends
    notes: tuple[str, ...] = ()  # what was left out


def route(copper: Copper, chord_error: float) -> Route:
    """Return the path of a coil's copper, its arcs within `chord_error` [m] of polylines.

    Raise SceneError in one line: it is no single path, and where.
    """
    where = copper.where
    if not copper.tracks:
        raise SceneError(f"{where}: must have tracks, or copper drawn to its pads; got none")
    for track in copper.tracks:
        if not track.width > 0.0:
            at, got = board_point(track.points[0]), mm(track.width)
            raise SceneError(f"{where}: the track at {at} must have a width; got {got}")
        flattened(track, chord_error, where)
    piece, chain, left_out = _path(copper)
    lines = [flattened(piece.tracks[k], chord_error, where)[:: 1 if e == 0 else -1] for k, e in chain]
    both = (chain[0], (chain[-1][0], 1 - chain[-1][1]))
    runs = tuple(replace(run, points=thinned(run.points, chord_error)) for run in _runs(piece, chain, lines))
    nets = frozenset({copper.net, *(track.net for track in piece.tracks)} - {""})
    held = [piece.hole(int(piece.numbers[end])) for end in both]
    end_nets = frozenset(hole.net for hole in held if hole is not None) - nets - {""}
    ends = (_name(piece, both[0]), _name(piece, both[1]))
    return Route(copper.name, copper.title, nets, runs, ends, end_nets, left_out)


def _path(copper: Copper) -> tuple[Joints, list[End], tuple[str, ...]]:
    """Return the longest piece of copper, its tracks in order, and notes; if needed, ends that nearly meet join."""
    refusal = None
    for nearness in (ROUNDING, _CARELESS * min(track.width for track in copper.tracks)):
        try:
            piece, left_out = _longest(connections(copper.tracks, copper.holes, nearness, copper.where), copper)
            return piece, _walk(piece, copper.where), left_out
        except SceneError as error:
            refusal = refusal or error
    raise refusal or SceneError(f"{copper.where}: must be one path; got none")


def _longest(joints: Joints, copper: Copper) -> tuple[Joints, tuple[str, ...]]:
    """Return the longest piece between pads, and what to say of the others; refuse copper that falls apart."""
    where = copper.where
    if not joints.tracks:
        raise SceneError(f"{where}: must have tracks; got none that leads from one place to another")
    every = parts(joints)
    mine, *others = sorted([part for part in every if copper.has(part)] or every, key=_length, reverse=True)
    if not others:
        return mine, ()
    if not all(part.holes for part in (mine, *others)):
        lost = min(others, key=lambda part: bool(part.holes))
        raise SceneError(
            f"{where}: must be one track from end to end; got {1 + len(others)} pieces, apart between "
            f"{_gap(mine, lost)}"
        )
    if _length(others[0]) > _LIKE * _length(mine):
        places = " and ".join(f"from {_ends(part)}" for part in (mine, others[0]))
        raise SceneError(
            f"{where}: must have one track much longer than others between pads; got two, {places}: take one by --at"
        )
    rest = 1e3 * sum(map(_length, others))
    return mine, (f"{where}: left out beyond pads: {len(others)} pieces of {rest:.4g} mm together",)


def _length(piece: Joints) -> float:
    """Return the length of a piece's tracks [m]."""
    return sum(length_of(track.points) for track in piece.tracks)


def _ends(piece: Joints) -> str:
    """Return where a piece ends, for a reader."""
    return " to ".join(sorted(_name(piece, end) for end in piece.loose())) or board_point(piece.tracks[0].points[0])


def _gap(one: Joints, other: Joints) -> str:
    """Return where the ends of two pieces are that are nearest to each other, for a reader."""
    ends = [[piece.point(end) for end in piece.loose()] or [piece.tracks[0].points[0]] for piece in (one, other)]
    a, b = min(product(*ends), key=lambda pair: float(np.hypot(*(pair[1] - pair[0]))))
    return f"{board_point(a)} and {board_point(b)}"


def _walk(joints: Joints, where: str) -> list[End]:
    """Return the tracks in order, each with the end at which the current enters."""
    meeting = joints.meeting()
    for ends in meeting.values():
        if len(ends) > 2:
            k, e = ends[0]
            raise SceneError(
                f"{where}: must be one path without branches; got {len(ends)} tracks that meet at "
                f"{board_point(joints.point((k, e)))} on {joints.tracks[k].layer}"
            )
    loose = joints.loose()
    if not loose:
        at = board_point(joints.point((0, 0)))
        layer = joints.tracks[0].layer
        raise SceneError(f"{where}: must be one path with two ends; got a loop through {at} on {layer}")
    chain = [_first(joints, loose)]
    while True:
        k, e = chain[-1]
        after = [end for end in meeting[int(joints.numbers[k, 1 - e])] if end != (k, 1 - e)]
        if not after:
            return chain
        chain.append(after[0])


def _first(joints: Joints, loose: Sequence[End]) -> End:
    """Return the end that the path starts from."""
    middle = np.mean([track.points.mean(axis=0) for track in joints.tracks], axis=0)

    def order(end: End) -> tuple[bool, list[tuple[int, str]], float]:
        hole = joints.hole(int(joints.numbers[end]))
        name = hole.name if hole is not None else ""
        words = [(int(word) if word.isdigit() else -1, word) for word in re.findall(r"\d+|\D+", name)]
        return not name, words, -float(np.hypot(*(joints.point(end) - middle)))

    return min(loose, key=order)


def _name(joints: Joints, end: End) -> str:
    """Return where a path ends, for a reader: the pad, or place and layer."""
    hole = joints.hole(int(joints.numbers[end]))
    if hole is not None and hole.name:
        return hole.name
    return f"{board_point(joints.point(end))} on {joints.tracks[end[0]].layer}"


def _runs(joints: Joints, chain: Sequence[End], lines: Sequence[Array]) -> tuple[Run, ...]:
    """Return a chain's centre lines joined to runs, one for each stretch on one layer and of one width."""
    runs: list[tuple[list[Track], list[Array]]] = []
    for number, ((k, e), line) in enumerate(zip(chain, lines, strict=True)):
        track = joints.tracks[k]
        if number > 0:
            line = _led(_joint(joints, int(joints.numbers[k, e]), line[0]), line, track.width)
        if number < len(chain) - 1:
            line = _led(_joint(joints, int(joints.numbers[k, 1 - e]), line[-1]), line[::-1], track.width)[::-1]
        if (
            not runs or track.layer != (first := runs[-1][0][0]).layer
            or abs(track.width - first.width) > _SAME_WIDTH * first.width
        ):
            runs.append(([], []))
        runs[-1][0].append(track)
        runs[-1][1].append(line)
    found = []
    for tracks, pieces in runs:
        weights = [length_of(track.points) for track in tracks]
        width = float(np.average([track.width for track in tracks], weights=weights))
        found.append(Run(tracks[0].layer, width, spaced(np.vstack(pieces), max(ROUNDING, _FINEST * width))))
    return tuple(found)


def _joint(joints: Joints, number: int, near: Array) -> Array:
    """Return where a joint is [m]: the middle of its via, else the end of the longest straight track that meets in it.

    So long tracks stay exactly parallel, whatever the last digit of the arcs between them.
    """
    hole = joints.hole(number)
    if hole is not None and not hole.name:
        return hole.place
    met = [(int(k), int(e)) for k, e in np.argwhere(joints.numbers == number)]
    straight = [end for end in met if len(joints.tracks[end[0]].points) == 2]
    return joints.point(max(straight, key=lambda end: length_of(joints.tracks[end[0]].points))) if straight else near


def _led(joint: Array, line: Array, width: float) -> Array:
    """Return a line that starts at its joint: its first point moved a little, or a new one before it."""
    return np.vstack([joint[None], line[1:] if np.hypot(*(line[0] - joint)) <= width / 4 else line])
