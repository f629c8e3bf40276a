"""Follow the current through a net: one path from end to end over tracks, arcs and vias, as polylines.

A net is one path where two joints are its ends and two tracks meet in every other. What branches, closes a loop or
falls apart is refused with where. Where pads part a net into pieces, the longest is the coil. The path starts at the
end whose pad has the lesser name, else at the greater distance from the coil's middle: outside.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from itertools import product

import numpy as np

from sits_mech.boards.joints import ROUNDING, End, Joints, flattened, joined, merged, thinned
from sits_mech.boards.kicad import Board, Hole, Track, place
from sits_mech.quantities import Array
from sits_mech.units import SceneError, shown

_CARELESS = 0.05  # of the narrowest track's width: ends that are nearer meet, where rounding does not make one path
_LIKE = 0.5  # a piece longer than this share of the longest may be the coil as well
FEW = 6  # names in a message
_SAME_WIDTH = 0.01  # tracks whose widths differ by less are one run
_SAME, _FINEST = 1e-6, 0.02  # points closer than this [m], or than this share of the width, are one


@dataclass(frozen=True)
class Run:
    """A polyline of copper on one layer, of one width: the centre line, points of shape (n, 2) [m]."""

    layer: str
    width: float
    points: Array


@dataclass(frozen=True)
class Route:
    """A net as a path."""

    net: str
    runs: tuple[Run, ...]  # in series, in the direction of the current
    ends: tuple[str, str]  # where it starts and ends, for a reader
    notes: tuple[str, ...] = ()  # what was left out


def route(board: Board, net: str, chord_error: float) -> Route:
    """Return the path of a net, its arcs within `chord_error` [m] of polylines.

    Raise SceneError in one line: the net is not there, has no tracks, or is no single path, and where.
    """
    if net not in board.nets:
        raise SceneError(f"--net: {board.name}: {_unknown(net, board.nets)}")
    where = f"{board.name}: net {net}"
    tracks, holes = _copper(board, net)
    if not tracks:
        raise SceneError(f"{where}: must have tracks; got none")
    for track in tracks:
        if not track.width > 0.0:
            raise SceneError(f"{where}: the track at {place(track.points[0])} must have a width; got {track.width:g} m")
        flattened(track, chord_error, where)
    piece, chain, left_out = _path(tracks, holes, net, where)
    lines = [flattened(piece.tracks[k], chord_error, where)[:: 1 if e == 0 else -1] for k, e in chain]
    ends = (_name(piece, chain[0]), _name(piece, (chain[-1][0], 1 - chain[-1][1])))
    runs = tuple(replace(run, points=thinned(run.points, chord_error)) for run in _runs(piece, chain, lines))
    return Route(net, runs, ends, left_out)


def _path(
    tracks: Sequence[Track], holes: Sequence[Hole], net: str, where: str
) -> tuple[Joints, list[End], tuple[str, ...]]:
    """Return the longest piece of a net, its tracks in order, and notes; if needed, ends that nearly meet join."""
    refusal = None
    for nearness in (ROUNDING, _CARELESS * min(track.width for track in tracks)):
        try:
            piece, left_out = _longest(joined(tracks, holes, nearness, where), net, where)
            return piece, _walk(piece, where), left_out
        except SceneError as error:
            refusal = refusal or error
    raise refusal or SceneError(f"{where}: must be one path; got none")


def _unknown(net: str, nets: Sequence[str]) -> str:
    """Return the hint for a missing net: all names of a few, or the most similar of many."""
    if len(nets) <= FEW:
        return f"must be a net of the board, one of {', '.join(nets) or 'none'}; got {shown(net)}"
    likeness = {name: SequenceMatcher(None, net.lower(), name.lower()).ratio() for name in nets}
    near = sorted(nets, key=lambda name: -likeness[name])[:FEW]
    return f"must be one of the board's {len(nets)} nets, such as {', '.join(near)}; got {shown(net)}"


def _copper(board: Board, net: str) -> tuple[list[Track], list[Hole]]:
    """Return the tracks of a net and what joins them; lines of a footprint go with the nets of its pads."""
    drawn = {track.footprint for track in board.tracks if track.footprint >= 0}
    whole = drawn & {hole.footprint for hole in board.holes if hole.net == net}
    tracks = [item for item in board.tracks if (item.net == net if item.footprint < 0 else item.footprint in whole)]
    return tracks, [hole for hole in board.holes if hole.layers and (hole.net == net or hole.footprint in whole)]


def length_of(points: Array) -> float:
    """Return the length of a polyline [m]."""
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def _longest(joints: Joints, net: str, where: str) -> tuple[Joints, tuple[str, ...]]:
    """Return the longest piece between pads, and what to say of the others; refuse a net that falls apart."""
    if not joints.tracks:
        raise SceneError(f"{where}: must have tracks; got none that leads from one place to another")
    count = 1 + max([int(joints.numbers.max()), *(number for number, _ in joints.holes)])
    label = merged(count, joints.numbers)[joints.numbers[:, 0]]
    parts = [np.flatnonzero(label == number).tolist() for number in np.unique(label)]
    parts = [part for part in parts if _touches(joints, part, net)] or parts
    lengths = [sum(length_of(joints.tracks[k].points) for k in part) for part in parts]
    best = int(np.argmax(lengths))
    mine = _part(joints, parts[best])
    if len(parts) == 1:
        return mine, ()
    at_pads = [any(joints.hole(int(number)) for number in joints.numbers[part].ravel()) for part in parts]
    if not all(at_pads):
        lost = min((k for k in range(len(parts)) if k != best), key=lambda k: at_pads[k])
        raise SceneError(
            f"{where}: must be one track from end to end; got {len(parts)} pieces, apart between "
            f"{_gap(mine, _part(joints, parts[lost]))}"
        )
    second = int(np.argsort(lengths)[-2])
    if lengths[second] > _LIKE * lengths[best]:
        places = " and ".join(f"from {_ends(part)}" for part in (mine, _part(joints, parts[second])))
        raise SceneError(f"{where}: must have one track much longer than others between pads; got two, {places}")
    rest = 1e3 * (sum(lengths) - lengths[best])
    note = f"{where}: left out beyond pads: {len(parts) - 1} pieces of {rest:.4g} mm together"
    return mine, (note,)


def _ends(piece: Joints) -> str:
    """Return where a piece ends, for a reader."""
    return " to ".join(sorted(_name(piece, end) for end in piece.loose())) or place(piece.tracks[0].points[0])


def _gap(one: Joints, other: Joints) -> str:
    """Return where the ends of two pieces are that are nearest to each other, for a reader."""
    ends = [[piece.point(end) for end in piece.loose()] or [piece.tracks[0].points[0]] for piece in (one, other)]
    a, b = min(product(*ends), key=lambda pair: float(np.hypot(*(pair[1] - pair[0]))))
    return f"{place(a)} and {place(b)}"


def _touches(joints: Joints, members: Sequence[int], net: str) -> bool:
    """Tell whether tracks are of a net, or end in its pads; those of a footprint may be another coil's."""
    numbers = set(joints.numbers[list(members)].ravel().tolist())
    of_net = any(joints.tracks[k].net == net for k in members)
    return of_net or any(number in numbers and hole.net == net for number, hole in joints.holes)


def _part(joints: Joints, members: Sequence[int]) -> Joints:
    """Return some of the tracks with their joints."""
    return Joints(tuple(joints.tracks[k] for k in members), joints.numbers[list(members)], joints.holes)


def _walk(joints: Joints, where: str) -> list[End]:
    """Return the tracks in order, each with the end at which the current enters."""
    meeting = joints.meeting()
    for ends in meeting.values():
        if len(ends) > 2:
            k, e = ends[0]
            raise SceneError(
                f"{where}: must be one path without branches; got {len(ends)} tracks that meet at "
                f"{place(joints.point((k, e)))} on {joints.tracks[k].layer}"
            )
    loose = joints.loose()
    if not loose:
        at = place(joints.point((0, 0)))
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
    return f"{place(joints.point(end))} on {joints.tracks[end[0]].layer}"


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
        found.append(Run(tracks[0].layer, width, _apart(np.vstack(pieces), max(_SAME, _FINEST * width))))
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


def _apart(points: Array, least: float) -> Array:
    """Return the points of a line without those nearer than `least` to the one before, its ends kept."""
    kept = [points[0]]
    for point in points[1:-1]:
        if np.hypot(*(point - kept[-1])) > least:
            kept.append(point)
    if len(kept) > 1 and np.hypot(*(points[-1] - kept[-1])) <= least:
        kept.pop()
    return np.array([*kept, points[-1]])
