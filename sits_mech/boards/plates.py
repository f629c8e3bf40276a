"""Find the pours of a board and turn them into plates parallel to the coils; name those left out.

A fill is written as one polygon, its holes tied to the rim by bridges: edges that go to the hole and come back over the
same two corners. Taking out each edge that has its opposite leaves the rims, the outer one and those of the holes.

A pour without holes is a rectangle or a disc where it fills 98 % of one and no corner of its rim is further than the
tolerance from that, which is what the rounded corners of a fill leave. Others keep their outlines with slots and holes,
in fewer corners: none of those left out was further than the tolerance from the edge that stands for it (Douglas and
Peucker, without crossings: shapely). The tolerance is 1 % of the coils' size, the root of their box's area. Left out
are holes less across, and islands of less area, than a disc of 1 % of that box: what a small plate takes of an
inductance, or a small hole gives back, goes with the 3/2 power of that, 0.1 % at most. What would touch a coil, and
what lies in the box of a larger plate of its layer, which no model holds, is left out and told.

Source: D. H. Douglas and T. K. Peucker, Cartographica 10 (1973) 112.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sits_mech.boards.kicad import Board, place
from sits_mech.boards.route import Route, Run
from sits_mech.boards.stackup import Layer
from sits_mech.quantities import Array
from sits_mech.scene.apart import check_parts
from sits_mech.scene.outlines import polygon, signed_area
from sits_mech.scene.parts import Conductor
from sits_mech.scene.sensor import Sensor
from sits_mech.units import SceneError

_GRID = 1e-9  # the board's own step [m]


@dataclass(frozen=True)
class Pour:
    """A plate of copper."""

    net: str
    layer: str
    rim: Array  # (n, 2) counter-clockwise [m]
    holes: tuple[Array, ...]  # [m]

    @property
    def area(self) -> float:
        """Return the area of the copper [m^2]."""
        return float(signed_area(self.rim)) - sum(abs(float(signed_area(hole))) for hole in self.holes)


def pours(board: Board, routes: Sequence[Route]) -> tuple[tuple[Pour, ...], tuple[str, ...]]:
    """Return the filled copper of nets other than the coils', and omissions; raise SceneError if it touches a coil."""
    nets = {found.net for found in routes}
    found, notes = [], []
    for zone in board.zones:
        title, on = f"zone {zone.net or 'without net'}", ", ".join(zone.layers)
        if zone.net in nets:
            notes.append(f"{title} on {on}: left out, it is of the coil's own net")
        elif not zone.fills:
            notes.append(f"{title} on {on}: left out, it is not filled: fill all zones in KiCad and save")
        else:
            for layer, points in zone.fills:
                found += _pours(zone.net, layer, points)
    for pour in found:
        copper = polygon([pour.rim, *pour.holes])
        for other in routes:
            for run in other.runs:
                _check_clear(pour, copper, run, f"{board.name}: net {other.net}")
    return tuple(found), tuple(notes)


def _pours(net: str, layer: str, points: Array) -> list[Pour]:
    """Return the pieces of a filled polygon as plates."""
    return [
        Pour(net, layer, rim if signed_area(rim) > 0.0 else rim[::-1], tuple(holes)) for rim, *holes in loops(points)
    ]


def loops(points: Array) -> list[list[Array]]:
    """Return the rims of each piece of a polygon (k, 2) whose holes are tied in by bridges, the outer ones first [m].

    A polygon that touches itself in a point has several pieces.
    """
    import shapely

    whole = shapely.make_valid(shapely.Polygon(np.round(points / _GRID)), method="structure")
    if not whole.area > 0.0:
        return [[points]]
    pieces = (piece.simplify(0.0) for piece in shapely.get_parts(whole) if piece.geom_type == "Polygon")
    rings = ([piece.exterior, *piece.interiors] for piece in pieces)
    return [[shapely.get_coordinates(ring)[:-1] * _GRID for ring in each] for each in rings]


def _check_clear(pour: Pour, copper: Any, run: Run, where: str) -> None:
    """Refuse a pour, a polygon of shapely beside it, that touches the copper of a run on its layer."""
    if pour.layer != run.layer:
        return
    import shapely

    pieces = shapely.linestrings(np.stack([run.points[:-1], run.points[1:]], axis=1))
    near = np.flatnonzero(shapely.dwithin(copper, pieces, run.width / 2))
    at = run.points[near[0]] if len(near) else None
    if at is not None:
        raise SceneError(
            f"{where}: its track must be clear of the pour of {pour.net or 'no net'} on {pour.layer}; got one that "
            f"touches it at {place(at)}"
        )


_SMALL = 0.01  # of the square of the coils' size, an island's area
_FINE = 0.01  # of the coils' size
_FULL = 0.98  # of a shape that a fill with rounded corners stands for
DIGITS = 10  # of lengths: a tenth of the board's own step


@dataclass(frozen=True)
class _Frame:
    """Where pours go: heights of the layers, the scene's origin on the board (2,), its z = 0, the coils' size [m]."""

    stack: Mapping[str, Layer]
    origin: Array
    top: float
    size: float


def plates(
    sensor: Sensor, poured: Sequence[Pour], stack: Mapping[str, Layer], origin: Array, top: float
) -> tuple[list[dict[str, Any]], tuple[str, ...]]:
    """Return the conductors that stand for pours, clear of the sensor's coils, and notes on them.

    `origin` (2,) is the scene's on the board [m], `top` its z = 0 in the board's heights [m].
    """
    frame = _Frame(stack, origin, top, math.sqrt(_box(sensor)))
    least = _SMALL * frame.size**2
    found = []
    kept: list[Conductor] = []
    notes = []
    small = [pour.area for pour in poured if pour.area < least]
    if small:
        all_of = f"{1e6 * sum(small):.3g} mm2 together"
        notes.append(f"{len(small)} pours of less than {1e6 * least:.3g} mm2: left out, {all_of}")
    for pour in sorted((item for item in poured if item.area >= least), key=lambda item: -item.area):
        table, said = _table(pour, frame)
        table = {"name": _free(f"{pour.net or 'copper'} {pour.layer}", [plate.name for plate in kept])} | table
        title = f"pour of {pour.net or 'no net'} on {pour.layer}, {1e6 * pour.area:.4g} mm2"
        try:
            plate = Conductor.model_validate(table)
            _check_boxes(plate, kept)
            check_parts(sensor.coils, None, None, (*kept, plate), None)
        except SceneError as error:
            notes.append(f"{title}: left out, it does not fit: {str(error).partition(', which')[0]}")
            continue
        found.append(table)
        kept.append(plate)
        notes += [f"{title}: {said}"] if said else []
    return found, tuple(notes)


def _box(sensor: Sensor) -> float:
    """Return the area of the box around all coils [m^2]."""
    middle = np.array([coil.centre for coil in sensor.coils])
    half = np.array([coil.extent for coil in sensor.coils]) / 2
    return float(np.prod((middle + half).max(axis=0) - (middle - half).min(axis=0)))


def _check_boxes(plate: Conductor, others: Sequence[Conductor]) -> None:
    """Refuse a plate whose box reaches into that of another in its layer."""
    for other in others:
        apart = np.abs(np.subtract(plate.centre, other.centre))
        reach = np.add((*plate.extent, plate.thickness), (*other.extent, other.thickness)) / 2
        if np.all(apart < reach):
            raise SceneError(f"its box must be clear of that around conductors.{other.name}; they overlap")


def _table(pour: Pour, frame: _Frame) -> tuple[dict[str, Any], str]:
    """Return the table of a plate, and notes on it."""
    layer, fine = frame.stack[pour.layer], _FINE * frame.size
    low, high = pour.rim.min(axis=0), pour.rim.max(axis=0)
    middle = (low + high) / 2
    least = 2.0 * math.sqrt(_SMALL / math.pi) * frame.size
    holes = [hole for hole in pour.holes if float(np.hypot(*np.ptp(hole, axis=0))) >= least]  # by the box's diagonal
    lost = len(pour.holes) - len(holes)
    said = [f"without {lost} hole{'s' * (lost > 1)} less than {1e3 * least:.3g} mm across"] if lost else []
    sizes = None if holes else _simple(pour.rim - middle, high - low, fine)
    if sizes is None:
        rims = simplified([pour.rim, *holes], fine)
        loops = [[[_rounded(x), _rounded(y)] for x, y in (rim - middle).tolist()] for rim in rims]
        sizes = {"shape": "outline", "points": loops[0]} | ({"holes": loops[1:]} if holes else {})
        among = f", {len(holes)} hole{'s' * (len(holes) > 1)} among them" if holes else ""
        said = [f"outline of {sum(map(len, rims))} corners, to {1e3 * fine:.2g} mm{among}", *said]
    place = [*(_rounded(v) + 0.0 for v in middle - frame.origin), _rounded(layer.z - frame.top)]
    table = {"material": "copper", "centre": place, "thickness": _rounded(layer.thickness)} | sizes
    return table, ", ".join(said)


def _simple(rim: Array, size: Array, fine: float) -> dict[str, Any] | None:
    """Return shape and sizes of the rectangle or disc about the middle that a rim is; None if it is neither."""
    away, area = np.abs(rim), float(signed_area(rim))
    if area > _FULL * float(np.prod(size)) and float(np.min(size / 2 - away, axis=1).max()) <= fine:
        return {"shape": "rectangle", "width": _rounded(size[0]), "length": _rounded(size[1])}
    if area > _FULL * math.pi / 4 * float(size.max()) ** 2 and float(np.ptp(np.hypot(*away.T))) <= fine:
        return {"shape": "disc", "diameter": _rounded(size.max())}
    return None


def _rounded(value: float) -> float:
    """Return a length as a scene has it."""
    return round(float(value), DIGITS)


def simplified(rims: Sequence[Array], fine: float) -> list[Array]:
    """Return rims (k, 2), not closed, with fewer corners, clear of each other and off by `fine` at most [m]."""
    import shapely

    whole, corners = polygon(rims), shapely.points(np.vstack(rims))
    found = whole.simplify(fine)
    if shapely.distance(found.boundary, corners).max() > fine:  # a ring's first corner goes last, and moves the others
        found = whole.simplify(fine / 2)
    return [shapely.get_coordinates(ring)[:-1] for ring in (found.exterior, *found.interiors)]


def _free(name: str, taken: Sequence[str]) -> str:
    """Return a name that is not taken, with a number where it must be."""
    numbered = (name if k == 1 else f"{name} {k}" for k in range(1, len(taken) + 2))
    return next(one for one in numbered if one not in taken)
