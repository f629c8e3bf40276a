"""Make a scene of a board: the chosen coils as paths, other nets' pours as plates, what is still to add.

The frame of the scene: x and y from the middle of all coils' tracks (or the board's own origin), y up; z = 0 at the top
face of the uppermost layer with a track of a coil.

KiCad asks for no clearance within a net, so a board may short its coil. Two stretches of a coil touch where their
centre lines are nearer than half of both widths together. Neighbours on the path do so by nature: in a bend, or at a
corner of theta they overlap over w / (2 sin(theta/2)). Only those that are further apart along the path than six widths
count, which corners sharper than 20 degrees exceed.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np

from sits_mech.boards.copper import Board, board_point
from sits_mech.boards.joints import ROUNDING
from sits_mech.boards.kicad import read_board
from sits_mech.boards.lines import length_of
from sits_mech.boards.pieces import Copper, at_place, of_footprint, of_net
from sits_mech.boards.plates import DIGITS, free_name, plates, pours
from sits_mech.boards.route import Route, Run, route
from sits_mech.boards.stackup import METRES, permittivity
from sits_mech.boards.windings import hint
from sits_mech.quantities import Array
from sits_mech.scene.files import written
from sits_mech.scene.parts.coils import Coil
from sits_mech.scene.sensor import sensor_from
from sits_mech.units import SceneError, shown
from sits_mech.units import millimetres as mm

_FINEST, _COARSEST = 1e-9, 1e-3  # errors of chords [m]
_FIGURES = 4  # decimals of permittivities
_APART = 6.0  # along the path, over the width
_NUMBER = r"\s*([-+]?(?:\d+\.?\d*|\.\d+))\s*(?:mm)?\s*"
_PLACE = re.compile(rf"{_NUMBER},{_NUMBER}(?:,\s*(\S+)\s*)?")
_TO_ADD = """
# The board has no target and no elastomer. A target on a layer, to be adapted:
# [target]
# material = "copper"
# shape = "rectangle"
# width = "{width:.3g} mm"
# length = "{length:.3g} mm"
# thickness = "0.2 mm"
# [elastomer]
# material = "ecoflex-00-30"
# width = "{wide:.3g} mm"
# length = "{long:.3g} mm"
# thickness = "2 mm"
"""


@dataclass(frozen=True)
class Selection:
    """What to take of a board, a coil by each net, footprint and place."""

    nets: tuple[str, ...] = ()
    footprints: tuple[str, ...] = ()  # references
    places: tuple[str, ...] = ()  # "X,Y" or "X,Y,LAYER" as KiCad shows them, in millimetres or with units
    frequency: float = 5e6  # [Hz]
    origin: Literal["coil", "board"] = "coil"  # the middle of the coils' tracks, or the board's
    chord_error: float = 1e-6  # greatest distance of arcs from their polylines [m]
    with_pours: bool = True  # take other nets' filled zones as conductors

    def check(self) -> None:
        """Refuse what is named twice, and a chord error that no coil has."""
        for option, names in (("--net", self.nets), ("--footprint", self.footprints), ("--at", self.places)):
            twice = [name for name in names if names.count(name) > 1]
            if twice:
                raise SceneError(f"{option}: must name each once; got {twice[0]} twice")
        if not _FINEST <= self.chord_error <= _COARSEST:
            raise SceneError(f"--chord-error: must be a length from 1 nm to 1 mm; got {mm(self.chord_error)}")


def board_scene(path: Path, choice: Selection) -> tuple[str, tuple[str, ...]]:
    """Return the scene file of a board's coils (KiCad 5 or later), and notes on it.

    Raise SceneError in one line: the board cannot be read, a net, footprint or place is not there or no single path, or
    the scene is impossible.
    """
    choice.check()
    board = read_board(path)
    routes = _routes(board, choice)
    origin, top = _origin(routes, choice.origin), _top(board, routes)
    coils = [_coil(board, found, origin, top) for found in routes]
    table = {"name": f"Coils of {path.name}", "frequency": choice.frequency, "coils": coils}
    sensor = sensor_from(table, board.name)
    notes = list(board.notes)
    for found in routes:
        notes += [_route_note(board, found), *touching(found), *found.notes]
    if choice.with_pours:
        poured, left_out = pours(board, routes)
        conductors, changed = plates(sensor, poured, board.stack, origin, top)
        table |= {"conductors": conductors} if conductors else {}
        notes += [*left_out, *changed]
    head = "".join(f"# {line}\n" for line in notes)
    reach = [[abs(coil.centre[k]) + coil.extent[k] / 2 for coil in sensor.coils] for k in (0, 1)]
    width, length = (2e3 * max(side) for side in reach)
    more = _TO_ADD.format(width=width, length=length, wide=1.5 * width, long=1.5 * length)
    return head + written(table) + more, tuple(notes)


def coil_alone(board: Board, found: Route) -> Coil:
    """Return a coil of a board as that of a scene."""
    origin, top = _origin([found], "coil"), _top(board, [found])
    table = _coil(board, replace(found, name="coil"), origin, top)
    return sensor_from({"name": "coil", "frequency": 1e6, "coils": [table]}).coils[0]


def _routes(board: Board, choice: Selection) -> list[Route]:
    """Return the coils that are asked for, each with a name of its own; a refusal ends with what looks like a coil."""
    try:
        asked = [of_net(board, name) for name in choice.nets]
        asked += [of_footprint(board, name) for name in choice.footprints]
        asked += [_at(board, text) for text in choice.places]
        if not asked:
            raise SceneError("--net, --footprint or --at: must name a coil of the board; it is missing")
        found = [route(each, choice.chord_error) for each in asked]
    except SceneError as error:
        raise SceneError(f"{error}; {hint(board)}") from None
    names: list[str] = []
    for one in found:
        names.append(free_name(one.name or f"C{len(names) + 1}", names))
    return [replace(one, name=name) for one, name in zip(found, names, strict=True)]


def _at(board: Board, text: str) -> Copper:
    """Return the copper at a place that is given as text."""
    found = _PLACE.fullmatch(text)
    layer = (found[3] or "") if found else ""
    if found is None or layer not in ("", *board.stack):
        raise SceneError(f"--at: must be X,Y in mm as KiCad shows, or X,Y,LAYER of {[*board.stack]}; got {shown(text)}")
    return at_place(board, METRES * np.array([float(found[1]), -float(found[2])]), layer)


def _origin(routes: Sequence[Route], origin: str) -> Array:
    """Return the scene's origin on the board [m]."""
    points = np.vstack([run.points for found in routes for run in found.runs])
    return (points.min(axis=0) + points.max(axis=0)) / 2 if origin == "coil" else np.zeros(2)


def _top(board: Board, routes: Sequence[Route]) -> float:
    """Return the height of the uppermost track's top face, of its own thickness or its coil's mean [m]."""
    layers = [(board.stack[run.layer], _thickness(board, found)) for found in routes for run in found.runs]
    return max(layer.z + max(layer.thickness, mean) / 2 for layer, mean in layers)


def _thickness(board: Board, found: Route) -> float:
    """Return the thickness of a coil's copper, the mean by length where its layers differ, of two round halves [m]."""
    lengths = [length_of(run.points) for run in found.runs]
    mean = np.average([board.stack[run.layer].thickness for run in found.runs], weights=lengths)
    return 2.0 * round(float(mean) / 2.0, DIGITS)


def _coil(board: Board, found: Route, origin: Array, top: float) -> dict[str, Any]:
    """Return the table of a coil."""
    widths = [round(run.width, DIGITS) for run in found.runs]
    longest = int(np.argmax([length_of(run.points) for run in found.runs]))
    path = []
    for run in found.runs:
        z = round(board.stack[run.layer].z - top, DIGITS)
        points = np.round(run.points - origin, DIGITS) + 0.0
        path.append([[x, y, z] for x, y in points.tolist()])
    table = {
        "name": found.name, "shape": "path", "track_width": widths[longest],
        "track_thickness": round(_thickness(board, found), DIGITS), "path": path,
    }
    table |= {"path_widths": widths} if len(set(widths)) > 1 else {}
    relative = permittivity(board.stack[run.layer] for run in found.runs)
    return table | ({} if relative is None else {"board_permittivity": round(relative, _FIGURES)})


def _route_note(board: Board, found: Route) -> str:
    """Return what a coil is, for a reader."""
    layers = list(dict.fromkeys(run.layer for run in found.runs))
    lines = [run.points for run in found.runs]
    total, corners = 1e3 * sum(map(length_of, lines)), sum(map(len, lines))
    thicknesses = sorted({board.stack[layer].thickness for layer in layers})
    mean = f"; copper of {', '.join(f'{1e6 * t:.4g}' for t in thicknesses)} um taken as its mean"
    heights = [board.stack[run.layer].z for run in found.runs]
    jumps = [1e3 * abs(b - a) for a, b in pairwise(heights) if a != b]
    vias = f"; {len(jumps)} vias, {sum(jumps):.4g} mm together, are no part of the coil" if jumps else ""
    vias = f"; 1 via of {jumps[0]:.4g} mm is no part of the coil" if len(jumps) == 1 else vias
    return (
        f"{found.title}: {total:.5g} mm of track on {', '.join(layers)}, {corners} points, from {found.ends[0]} to "
        f"{found.ends[1]}{vias}{mean if len(thicknesses) > 1 else ''}"
    )


def touching(found: Route) -> tuple[str, ...]:
    """Return where turns of a coil touch, for a reader: the first such place on each layer."""
    lengths = [np.hypot(*np.diff(run.points, axis=0).T) for run in found.runs]
    starts = np.cumsum([0.0, *(each.sum() for each in lengths)])
    notes = []
    for layer in dict.fromkeys(run.layer for run in found.runs):
        mine = [k for k, run in enumerate(found.runs) if run.layer == layer]
        along = [starts[k] + np.cumsum(lengths[k]) - lengths[k] / 2 for k in mine]
        at = _first([found.runs[k] for k in mine], np.concatenate(along))
        if at is not None:
            where = f"on {layer} at {board_point(at)}"
            notes.append(f"{found.title}: its turns touch {where}: a short circuit of the board, not of the scene")
    return tuple(notes)


def _first(runs: list[Run], along: Array) -> Array | None:
    """Return a place where stretches of one layer touch, else None; `along` are their middles on the path [m]."""
    import shapely

    a, b = (np.vstack([run.points[some] for run in runs]) for some in (slice(None, -1), slice(1, None)))
    width = np.concatenate([np.full(len(run.points) - 1, run.width) for run in runs])
    length, pieces = np.hypot(*(b - a).T), shapely.linestrings(np.stack([a, b], axis=1))
    i, j = shapely.STRtree(pieces).query(pieces, "dwithin", width)
    between = np.abs(along[j] - along[i]) - (length[i] + length[j]) / 2
    gap = shapely.distance(pieces[i], pieces[j]) - (width[i] + width[j]) / 2
    met = (between > _APART * np.maximum(width[i], width[j])) & (gap < -ROUNDING)
    return np.asarray(a[np.minimum(i, j)[met].min()]) if met.any() else None
