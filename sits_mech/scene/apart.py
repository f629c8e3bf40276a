"""Check that a scene's parts stand clear of each other: coils, target at rest, silicone and fixed conductors.

Each is a prism along z: a box, a cylinder or an outline, from z = bottom to top. Two are clear of each other where
either their heights or their outlines, seen from above, are. For boxes and cylinders, with the offset of their middles
taken to the box |x| <= a, |y| <= b of the boxes' half sizes together, and r the cylinders' radii together,

    gap = hypot(max(|x| - a, 0), max(|y| - b, 0)) + min(max(|x| - a, |y| - b), 0) - r,

exact. A plate that is turned counts as the box around it, sides along its own axes, beside boxes (`solids`). Pillars
count with their field. Beside an outline a cylinder is a polygon of 128 corners. Coils count with the hole in their
middle; on a curved substrate as boxes of 1/256 of their width. Polygons are their rims, rectangles and free tracks the
box around them, in each layer; what lies between their layers is clear of them; two coils of free tracks may reach into
each other as long as no tracks cross in one layer, and an outline of metal between free tracks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from sits_mech.quantities import Array
from sits_mech.scene.parts.coils import Coil
from sits_mech.scene.parts.cover import Cover
from sits_mech.scene.parts.elastomer import Elastomer, pillar_middles
from sits_mech.scene.parts.metal import BoxedPart, Conductor, Target, separation
from sits_mech.scene.parts.outlines import Loop, circle, lines_crossing, polygon
from sits_mech.units import SLACK, SceneError
from sits_mech.units import millimetres as mm

_TILES = 256  # of a curved plate


@dataclass(frozen=True)
class Prism:
    """A part in place: a box, a cylinder or an outline along z."""

    name: str  # as in the scene
    middle: tuple[float, float]  # x, y [m]
    extent: tuple[float, float]  # along x and y [m]
    bottom: float  # z [m]
    top: float  # z [m]
    is_round: bool = False  # a cylinder of the diameter `extent`, not a box
    loops: tuple[Loop, ...] = ()  # rim and holes of an outline, instead [m]
    tracks: tuple[tuple[Array, float], ...] = ()  # free tracks (k, 2), half widths; count beside outlines [m]
    box: BoxedPart | None = None  # of a plate that is turned, instead of all but its heights


def check_parts(
    coils: Sequence[Coil], target: Target | None, elastomer: Elastomer | None, conductors: Sequence[Conductor],
    substrate_radius: float | None, cover: Cover | None = None,
) -> None:
    """Refuse parts that do not fit together; raise SceneError in one line: which two, what they must be, what came."""
    _check_coils(coils)
    if target is not None and elastomer is not None and elastomer.kind == "pillars":
        pillar_middles(elastomer, target.extent, target.is_round)
    if substrate_radius is not None:
        _check_round(substrate_radius, coils)
    others = _layer_and_target(target, elastomer, cover)
    if conductors:
        others = [*(piece for coil in coils for piece in _coil(coil, substrate_radius)), *others]
    for part in map(_conductor, conductors):
        for other_part in others:
            _check_clear(part, other_part)
        others.append(part)


def _check_coils(coils: Sequence[Coil]) -> None:
    """Refuse coils that overlap."""
    around = [(coil, coil.centre, 0.5 * coil.outer_diameter) for coil in coils]
    for (coil, here, radius), (other, there, reach) in combinations(around, 2):
        if math.dist(here, there) < radius + reach:
            _check_side_by_side(coil, other)


def _conductor(part: Conductor) -> Prism:
    """Return the prism of a fixed plate."""
    x, y, _ = part.centre
    turned = part.box if part.is_turned else None
    low, high = part.span
    return Prism(part.box.name, (x, y), part.extent, low, high, part.is_round, part.loops, box=turned)


def from_windings(part: Conductor, coils: Sequence[Coil]) -> float:
    """Return a lower bound of the distance of a plate's metal, holes left out, from flat coils [m]."""
    plate, nearest = _conductor(part), math.inf
    for piece in (piece for coil in coils for piece in _layers(coil)):
        up = max(piece.bottom - plate.top, plate.bottom - piece.top, 0.0)
        nearest = min(nearest, math.hypot(up, max(gap_in_plan(plate, piece), 0.0)))
    return nearest


def _coil(coil: Coil, substrate_radius: float | None) -> list[Prism]:
    """Return the cylinder around a coil's tracks, or the boxes that stand for it on a curved substrate."""
    name, (x, y), size = f"coils.{coil.name}", coil.centre, coil.outer_diameter
    if substrate_radius is None:
        return _layers(coil)
    angles = (x + size * np.linspace(-0.5, 0.5, _TILES + 1)) / substrate_radius
    radii = np.array([[substrate_radius - coil.height], [substrate_radius]])
    across, up = radii * np.sin(angles), radii * np.cos(angles) - substrate_radius
    found = []
    for k in range(_TILES):
        (left, right), (low, high) = (
            (float(v.min()), float(v.max())) for v in (across[:, k : k + 2], up[:, k : k + 2])
        )
        found.append(Prism(name, ((left + right) / 2, y), (right - left, size), low, high))
    return found


def _layers(coil: Coil) -> list[Prism]:
    """Return the cylinder around a round coil's layers, or the box or rim around each layer with its own height."""
    name, is_round, rims = f"coils.{coil.name}", coil.is_round, (coil.rim,) if coil.rim else ()
    return [
        Prism(name, coil.centre, coil.extent, low, high, is_round, rims, _tracks(coil, z))
        for z, (low, high) in zip(coil.heights, coil.spans, strict=False)
    ]


def _tracks(coil: Coil, height: float) -> tuple[tuple[Array, float], ...]:
    """Return the free tracks of a coil in one layer."""
    pairs = zip(coil.path, coil.widths, strict=True)
    return tuple((np.array(line)[:, :2] + coil.centre, width / 2) for line, width in pairs if line[0][2] == height)


def _layer_and_target(target: Target | None, elastomer: Elastomer | None, cover: Cover | None) -> list[Prism]:
    """Return the layer with the film below it, the target at rest on it, and its cover; nothing without a layer."""
    if elastomer is None:
        return []
    top = elastomer.standoff + elastomer.thickness
    found = [Prism("elastomer", (0.0, 0.0), elastomer.extent, 0.0, top, elastomer.is_round)]
    if target is not None:
        z = top, top + target.thickness
        found.append(Prism("target", (0.0, 0.0), target.extent, *z, target.is_round, target.loops))
    if target is not None and cover is not None:
        z = top, top + target.thickness + cover.thickness
        found.append(Prism("cover", (0.0, 0.0), cover.extent(target, elastomer), *z, target.is_round))
    return found


def _check_clear(part: Prism, other: Prism) -> None:
    """Refuse a conductor that touches or overlaps another part."""
    turned = part.box is not None or other.box is not None
    above = max(other.bottom - part.top, part.bottom - other.top)  # negative where their heights overlap
    height = float(separation(_box(part), _box(other))[0]) if turned else above
    slack = SLACK * max(*part.extent, *other.extent, part.top - part.bottom, other.top - other.bottom)
    if height > slack or (aside := -math.inf if turned else gap_in_plan(part, other)) > slack:
        return
    depth = -max(height, aside)
    how = f"overlaps it by {mm(depth, 3)}" if depth > slack else "touches it"
    raise SceneError(
        f"{part.name} must be clear of {other.name}, which reaches from z = {mm(other.bottom)} to {mm(other.top)}; got "
        f"a plate from z = {mm(part.bottom)} to {mm(part.top)} that {how}"
    )


def _box(part: Prism) -> BoxedPart:
    """Return the box around a part."""
    size, middle = (*part.extent, part.top - part.bottom), (*part.middle, (part.top + part.bottom) / 2)
    return part.box or BoxedPart.level(part.name, size, middle)


def gap_in_plan(first: Prism, second: Prism) -> float:
    """Return the distance of two parts seen from above; negative where they overlap, by how much at least [m]."""
    import shapely

    if first.loops and second.tracks:
        plate = polygon(_loops(first))
        return min(_gap(plate, shapely.LineString(line), half) for line, half in second.tracks)
    if first.loops or second.loops:
        return _gap(polygon(_loops(first)), polygon(_loops(second)))
    boxes = [part.extent for part in (first, second) if not part.is_round]
    radius = 0.5 * sum(part.extent[0] for part in (first, second) if part.is_round)
    x, y = (abs(first.middle[k] - second.middle[k]) - 0.5 * sum(extent[k] for extent in boxes) for k in (0, 1))
    return math.hypot(max(x, 0.0), max(y, 0.0)) + min(max(x, y), 0.0) - radius


def _loops(part: Prism) -> list[Array]:
    """Return the rims of a part as polygons in the scene."""
    (x, y), (a, b) = part.middle, part.extent
    if part.loops:
        return [np.array(loop) + (x, y) for loop in part.loops]
    if part.is_round:
        return [np.array(circle(0.5 * a)) + (x, y)]
    return [np.array([[-a, -b], [a, -b], [a, b], [-a, b]]) / 2 + (x, y)]


def _gap(first: Any, second: Any, half: float = 0.0) -> float:
    """Return the distance of two shapes, of a track from its edge [m]; minus infinity where they meet."""
    away = float(first.distance(second))
    return away - half if away > 0.0 else -math.inf


def _check_side_by_side(coil: Coil, other: Coil) -> None:
    """Refuse coils that overlap."""
    reach = (coil.track_thickness + other.track_thickness) / 2
    shared = [z for z in coil.heights if any(abs(z - level) * (1.0 + SLACK) < reach for level in other.heights)]
    aside = gap_in_plan(_layers(coil)[0], _layers(other)[0])
    if not shared or aside > 0.0:
        return
    names = f"coils.{coil.name} and coils.{other.name}"
    if coil.shape == other.shape == "circle":
        distance, needed = math.dist(coil.centre, other.centre), 0.5 * (coil.outer_diameter + other.outer_diameter)
        if distance * (1.0 + SLACK) < needed:
            raise SceneError(
                f"{names} overlap: their centres must be at least {mm(needed)} apart for outer diameters of "
                f"{mm(coil.outer_diameter)} and {mm(other.outer_diameter)}; got {mm(distance)}"
            )
    elif coil.shape == other.shape == "path":
        for z in shared:
            _check_tracks(names, z, [*_lines(coil, z, 0.0), *_lines(other, z, reach)])
    elif -aside > SLACK * max(*coil.extent, *other.extent):
        what, by = _met(coil, other, aside)
        raise SceneError(
            f"{names} overlap: the {what} them must be clear of each other in every layer; they overlap{by} at "
            f"z = {mm(shared[0])}"
        )


def _met(coil: Coil, other: Coil, aside: float) -> tuple[str, str]:
    """Return which edges of two coils meet, and by how much where that is known."""
    return ("rims of", "") if coil.rim or other.rim else ("boxes around", f" by {mm(-aside, 3)}")


def _check_tracks(names: str, z: float, lines: Sequence[Array]) -> None:
    """Refuse tracks of two coils that cross in one layer."""
    place = lines_crossing(lines)
    if place is not None:
        raise SceneError(
            f"{names} overlap: tracks must not cross in one layer; those at z = {mm(z)} do at x = {mm(place[0], 4)}, "
            f"y = {mm(place[1], 4)}"
        )


def _lines(coil: Coil, height: float, reach: float) -> list[Array]:
    """Return the polylines in place of a coil of free tracks at a height, or nearer to it than `reach` [m]."""
    lines = [(np.array(line)[:, :2] + coil.centre, line[0][2]) for line in coil.path]
    return [line for line, z in lines if z == height or abs(z - height) * (1.0 + SLACK) < reach]


def _check_round(radius: float, coils: Sequence[Coil]) -> None:
    """Refuse coils that reach around the substrate and meet themselves."""
    reach = max(abs(coil.centre[0]) + 0.5 * coil.outer_diameter for coil in coils)
    if reach > math.pi * radius:
        raise SceneError(
            f"substrate_radius must be at least {mm(reach / math.pi)} to carry the coils; got {mm(radius)}"
        )
