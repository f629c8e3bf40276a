"""Find the pours of a board and turn them into plates parallel to the coils; name those left out.

A fill is written as one polygon, its holes tied to the rim by bridges: edges that go to the hole and come back over the
same two corners. Taking out each edge that has its opposite leaves the rims, the outer one and those of the holes.

A pour without holes is a rectangle or a disc where it fills 98 % of one and no corner of its rim is further than the
tolerance from that, which is what the rounded corners of a fill leave. Others keep their outlines with slots and holes,
in fewer corners: none of those left out was further than the tolerance from the edge that stands for it (Douglas and
Peucker, without crossings: shapely). The tolerance is 1 % of the coils' size, the root of their box's area. Left out
are holes less across, and islands of less area, than a disc of 1 % of that box: what a small plate takes of an
inductance, or a small hole gives back, goes with the 3/2 power of that, 0.1 % at most.

Models hold plates whose boxes are clear of each other. Pours of one layer side by side whose boxes overlap are one
plate, tied by bridges: one between two pieces closes no loop, so that the stream function is zero on both its sides and
no net current passes it. What would touch a coil is left out and noted; a pour in which a coil ends is cut clear of it.

Source: D. H. Douglas and T. K. Peucker, Cartographica 10 (1973) 112.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from operator import attrgetter
from typing import Any

import numpy as np

from sits_mech.boards.copper import GRID, Board, Zone, board_point
from sits_mech.boards.route import Route, Run
from sits_mech.boards.stackup import CopperLayer
from sits_mech.quantities import Array
from sits_mech.scene.apart import check_parts
from sits_mech.scene.parts.metal import Conductor
from sits_mech.scene.parts.outlines import polygon, signed_area
from sits_mech.scene.sensor import Sensor
from sits_mech.units import SceneError

_CLEAR = 2e-4  # of a pour from a coil that ends in it: KiCad's default clearance [m]


@dataclass(frozen=True, eq=False)
class Pour:
    """A plate of copper."""

    net: str
    layer: str
    rim: Array  # (n, 2) counter-clockwise [m]
    holes: tuple[Array, ...]  # [m]
    parts: tuple[Pour, ...] = ()  # that it joins, where it stands for several

    @property
    def title(self) -> str:
        """Return what it is, for a reader."""
        return f"pour of {self.net or 'no net'} on {self.layer}"

    @cached_property
    def box(self) -> tuple[Array, Array]:
        """Return the lower left and the upper right corner of the box around it [m]."""
        return self.rim.min(axis=0), self.rim.max(axis=0)

    @property
    def area(self) -> float:
        """Return the area of the copper [m^2]."""
        return float(signed_area(self.rim)) - sum(abs(float(signed_area(hole))) for hole in self.holes)


def pours(board: Board, routes: Sequence[Route]) -> tuple[tuple[Pour, ...], tuple[str, ...]]:
    """Return the filled copper of nets other than the coils', clear of the coils, and omissions.

    Raise SceneError if it touches a coil, other than the pour in which a coil ends.
    """
    nets = frozenset[str]().union(*(found.nets for found in routes))
    found: list[Pour] = []
    notes: list[str] = []
    for zone in board.zones:
        title, on = f"zone {zone.net or 'without net'}", ", ".join(zone.layers)
        if zone.net in nets:
            notes.append(f"{title} on {on}: left out, it is of the coil's own net")
        elif not zone.fills:
            notes.append(f"{title} on {on}: left out, it is not filled: fill all zones in KiCad and save")
        for layer, points in zone.fills if zone.net not in nets else ():
            for pour in _as_pours(Pour(zone.net, layer, points, ()), loops(points, zone.pen)):
                clear, remarks = _clear(pour, zone, routes, board.name)
                found += clear
                notes += remarks
    return tuple(found), tuple(notes)


def _as_pours(like: Pour, pieces: Sequence[Sequence[Array]]) -> list[Pour]:
    """Return pieces, each its rim and its holes, as pours of the net and the layer of another."""
    turned = ((rim if signed_area(rim) > 0.0 else rim[::-1], tuple(holes)) for rim, *holes in pieces)
    return [replace(like, rim=rim, holes=holes) for rim, holes in turned]


def _clear(pour: Pour, zone: Zone, routes: Sequence[Route], name: str) -> tuple[list[Pour], list[str]]:
    """Return what is left of a pour beside the coils, which may end in it, and what to say of that."""
    remarks: list[str] = []
    for found in routes:
        for run in (run for run in found.runs if run.layer == pour.layer):
            at = _touched(pour, run)
            if at is None:
                continue
            if zone.drawn:
                return [], [f"{pour.title}: left out, it is drawn and touches {found.title} at {board_point(at)}"]
            if pour.net not in found.end_nets:
                raise SceneError(
                    f"{name}: {found.title}: its track must be clear of the {pour.title}; got one that touches it at "
                    f"{board_point(at)}"
                )
            remarks = [f"{pour.title}: cut {1e3 * _CLEAR:g} mm clear of {found.title}, which ends in it"]
    return (_cut(pour, routes) if remarks else [pour]), remarks


def _cut(pour: Pour, routes: Sequence[Route]) -> list[Pour]:
    """Return what is left of a pour without what is near the coils' tracks."""
    import shapely

    runs = [run for found in routes for run in found.runs if run.layer == pour.layer]
    near = shapely.union_all([shapely.LineString(run.points).buffer(run.width / 2 + _CLEAR) for run in runs])
    return _as_pours(pour, _rings(polygon([pour.rim, *pour.holes]).difference(near)))


def _rings(shape: Any) -> list[list[Array]]:
    """Return the rims of each polygon of a shape, the outer ones first."""
    import shapely

    pieces = (piece.simplify(0.0) for piece in shapely.get_parts(shape) if piece.geom_type == "Polygon" and piece.area)
    rings = ([piece.exterior, *piece.interiors] for piece in pieces)
    return [[shapely.get_coordinates(ring)[:-1] for ring in each] for each in rings]


def loops(points: Array, pen: float = 0.0) -> list[list[Array]]:
    """Return the rims of each piece of a polygon (k, 2) whose holes are tied in by bridges, the outer ones first [m].

    A polygon that touches itself in a point has several pieces. `pen` is the width of a line along its rims [m].
    """
    import shapely

    whole = shapely.make_valid(shapely.Polygon(np.round(points / GRID)), method="structure")
    whole = whole.buffer(pen / 2 / GRID) if pen > 0.0 else whole
    return [[rim * GRID for rim in each] for each in _rings(whole)] if whole.area > 0.0 else [[points]]


def _touched(pour: Pour, run: Run) -> Array | None:
    """Return a place where a pour touches the copper of a run of its layer; None if it does not."""
    import shapely

    pieces = shapely.linestrings(np.stack([run.points[:-1], run.points[1:]], axis=1))
    near = np.flatnonzero(shapely.dwithin(polygon([pour.rim, *pour.holes]), pieces, run.width / 2))
    return np.asarray(run.points[near[0]]) if len(near) else None


_SMALL = 0.01  # of the square of the coils' size, an island's area
_FINE = 0.01  # of the coils' size
_WIDE = 0.1  # of the coils' size, a bridge between pours; its area is that of an island that is left out, at most
_FULL = 0.98  # of a shape that a fill with rounded corners stands for
DIGITS = 10  # of lengths: a tenth of the board's own step


@dataclass(frozen=True)
class _Frame:
    """Where pours go: heights of the layers, the scene's origin on the board (2,), its z = 0, the coils' size [m]."""

    stack: Mapping[str, CopperLayer]
    origin: Array
    top: float
    size: float


def plates(
    sensor: Sensor, poured: Sequence[Pour], stack: Mapping[str, CopperLayer], origin: Array, top: float
) -> tuple[list[dict[str, Any]], tuple[str, ...]]:
    """Return the conductors that stand for pours, clear of the sensor's coils, and notes on them.

    `origin` (2,) is the scene's on the board [m], `top` its z = 0 in the board's heights [m].
    """
    frame = _Frame(stack, origin, top, math.sqrt(_box(sensor)))
    least = _SMALL * frame.size**2
    found = []
    kept: list[tuple[Pour, Conductor]] = []
    notes = []
    small = [pour.area for pour in poured if pour.area < least]
    if small:
        all_of = f"{1e6 * sum(small):.3g} mm2 together"
        notes.append(f"{len(small)} pours of less than {1e6 * least:.3g} mm2: left out, {all_of}")
    waiting = merged_pours([item for item in poured if item.area >= least], frame.size)
    while waiting:
        pour = waiting.pop(0)
        table, remarks = _table(pour, frame)
        table = {"name": free_name(f"{pour.net or 'copper'} {pour.layer}", [plate.name for _, plate in kept])} | table
        title = f"{pour.title}, {1e6 * pour.area:.4g} mm2"
        try:
            plate = _fitting(pour, table, kept, sensor)
        except SceneError as error:
            if pour.parts:
                waiting = sorted([*waiting, *pour.parts], key=attrgetter("area"), reverse=True)
                continue
            notes.append(f"{title}: left out, it does not fit: {str(error).partition(', which')[0]}")
            continue
        found.append(table)
        kept.append((pour, plate))
        notes += [f"{title}: {remarks}"] if remarks else []
    return found, tuple(notes)


def _fitting(
    pour: Pour, table: dict[str, Any], kept: Sequence[tuple[Pour, Conductor]], sensor: Sensor
) -> Conductor:
    """Return a plate that is clear of those kept and of the coils; raise SceneError for another."""
    plate = Conductor.model_validate(table)
    for other, there in kept:
        if _boxes_meet(pour, other):
            raise SceneError(f"its box must be clear of that around conductors.{there.name}; they overlap")
    check_parts(sensor.coils, None, None, (*(there for _, there in kept), plate), None)
    return plate


def merged_pours(poured: Sequence[Pour], size: float) -> list[Pour]:
    """Return pours, those of a layer whose boxes overlap as one, the largest first; `size` is the coils' [m]."""
    found = sorted(poured, key=attrgetter("area"), reverse=True)
    pairs = combinations(found, 2)
    while pair := next(pairs, None):
        if _boxes_meet(*pair) and (tied := _tied(*pair, size)) is not None:
            found = sorted([each for each in found if each not in pair] + [tied], key=attrgetter("area"), reverse=True)
            pairs = combinations(found, 2)
    return found


def _boxes_meet(one: Pour, other: Pour) -> bool:
    """Tell whether two pours are on one layer and the boxes around them overlap."""
    (a, b), (c, d) = one.box, other.box
    return one.layer == other.layer and bool(np.all(np.maximum(a, c) < np.minimum(b, d)))


def _tied(one: Pour, other: Pour, size: float) -> Pour | None:
    """Return two pours as one with a bridge where they are nearest; None where that makes no single piece."""
    import shapely

    shapes = [polygon([each.rim, *each.holes]) for each in (one, other)]
    a, b = np.array(shapely.shortest_line(*shapes).coords)
    gap = max(float(np.hypot(*(b - a))), GRID)
    width = size * float(np.clip(_SMALL * size / gap, 2.0 * _FINE, _WIDE))
    step = (b - a) / gap * width
    bridge = shapely.LineString([a - step, b + step]).buffer(width / 2, cap_style="flat")
    found = _as_pours(one, _rings(shapely.union_all([*shapes, bridge])))
    nets = ", ".join(dict.fromkeys(net for each in (one, other) for net in each.net.split(", ")))
    parts = [part for each in (one, other) for part in each.parts or (each,)]
    return replace(found[0], net=nets, parts=tuple(parts)) if len(found) == 1 else None


def _box(sensor: Sensor) -> float:
    """Return the area of the box around all coils [m^2]."""
    middle = np.array([coil.centre for coil in sensor.coils])
    half = np.array([coil.extent for coil in sensor.coils]) / 2
    return float(np.prod((middle + half).max(axis=0) - (middle - half).min(axis=0)))


def _table(pour: Pour, frame: _Frame) -> tuple[dict[str, Any], str]:
    """Return the table of a plate, and notes on it."""
    layer, fine = frame.stack[pour.layer], _FINE * frame.size
    low, high = pour.box
    middle = (low + high) / 2
    least = 2.0 * math.sqrt(_SMALL / math.pi) * frame.size
    holes = [hole for hole in pour.holes if float(np.hypot(*np.ptp(hole, axis=0))) >= least]  # by the box's diagonal
    lost = len(pour.holes) - len(holes)
    remarks = [f"without {lost} hole{'s' * (lost > 1)} less than {1e3 * least:.3g} mm across"] * bool(lost)
    if pour.parts:
        areas = ", ".join(f"{1e6 * part.area:.4g}" for part in pour.parts)
        remarks.append(f"{len(pour.parts)} side by side, of {areas} mm2, as one: bridges between them carry no current")
    sizes = _simple([rim - middle for rim in (pour.rim, *holes)], high - low, fine)
    if sizes is None:
        rims = simplified([pour.rim, *holes], fine)
        loops = [[[_rounded(x), _rounded(y)] for x, y in (rim - middle).tolist()] for rim in rims]
        sizes = {"shape": "outline", "points": loops[0]} | ({"holes": loops[1:]} if holes else {})
        among = f", {len(holes)} hole{'s' * (len(holes) > 1)} among them" * bool(holes)
        remarks = [f"outline of {sum(map(len, rims))} corners, to {1e3 * fine:.2g} mm{among}", *remarks]
    place = [*(_rounded(v) + 0.0 for v in middle - frame.origin), _rounded(layer.z - frame.top)]
    table = {"material": "copper", "centre": place, "thickness": _rounded(layer.thickness)} | sizes
    return table, ", ".join(remarks)


def _simple(rims: Sequence[Array], size: Array, fine: float) -> dict[str, Any] | None:
    """Return shape and sizes of the rectangle, disc or ring about the middle that rims are; None if they are none."""
    rim, diameters = rims[0], [_circle(each, fine) for each in rims]
    full = abs(float(signed_area(rim))) > _FULL * float(np.prod(size))
    if len(rims) == 1 and full and float(np.min(size / 2 - np.abs(rim), axis=1).max()) <= fine:
        return {"shape": "rectangle", "width": _rounded(size[0]), "length": _rounded(size[1])}
    keys = {1: ("diameter",), 2: ("diameter", "inner_diameter")}.get(len(rims), ())
    if not keys or None in diameters:
        return None
    return {"shape": "ring" if len(keys) > 1 else "disc"} | dict(zip(keys, diameters, strict=True))


def _circle(rim: Array, fine: float) -> float | None:
    """Return the diameter of the circle about the middle that a rim is, to a difference; None if it is none [m]."""
    size, away = float(np.ptp(rim, axis=0).max()), np.hypot(*rim.T)
    round_ = abs(float(signed_area(rim))) > _FULL * math.pi / 4 * size**2 and float(np.ptp(away)) <= fine
    return _rounded(size) if round_ else None


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


def free_name(name: str, taken: Sequence[str]) -> str:
    """Return a name that is not taken, with a number where it must be."""
    numbered = (name if k == 1 else f"{name} {k}" for k in range(1, len(taken) + 2))
    return next(one for one in numbered if one not in taken)
