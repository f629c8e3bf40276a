"""Bricks of a pad under its target: boxes on a tensor grid, round outlines in rings, pillars one by one.

Half the pad, y >= 0, is divided; lengths are in thicknesses. A target may be wider than its pad in one direction or in
both: what is beyond takes no part but in contact, where silicone that bulges lies on the target's plane
(faces/contact.py). What is bonded is what the target covers:

    a box under a rectangle, or within its target    tensor grid
    a rectangle and a disc, one within the other     rings around a core, the bonded outline one of them
    a rectangle and a disc that cross                rings in what they share, patches (geometry/meshing/crossing.py)
    pillars                                          rings in each, flush with the target

Every mesh is one of a family: each of its base cells is divided into as many parts along each axis.

A cover lies above, from z = 1: lines go on through the target's height and the cover, and there are lines at the
cover's outline. Its rim has one base cell, or, from half a thickness on, two that are closer to its edges: below that
even parts are no larger than those of the pad up to m = 2.

Order. At the edge of a target in the middle of a face displacements go as ``r**0.5``, whatever Poisson's ratio; at the
corner of a flush pad, an incompressible right angle, as ``r**0.5946``. What a pad does for its target, an energy,
converges on lines graded with beta as ``m**(-2 k beta)``, k that exponent, as far as the elements' own order of 4
allows: with beta = 2 as ``m**-2`` and ``m**-2.38``. (Compliances of `biorob2018-w15` from m = 2 and 3 extrapolated so
are within 3e-4 of those of m = 4 on stronger gradings.)

Lines are closer towards the target's edge and the bonded faces. The i-th of n lines of a segment of length l lies ``l
(i/n)**beta`` from the singular edge. A base has few cells: one or more beside the target, under it and through the
thickness. Every cell is divided into m parts so that the segment keeps its grading: the meshes of m = 1, 2, 3, ... are
a family, and errors go with a power of 1/m. Where the target is much wider than the pad is thick nothing happens in its
middle but the flow of pressure: base cells there grow by a factor away from the edge. Some meshes have further layers
at the edge alone: the cell that touches it is cut where twice as many parts would have their first line, once for each
layer. Meshes of m = 1, 2, 2 with a layer, 4, ... nest.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from skfem import MeshHex

from sits_mech.geometry.meshing.bricks import PlateOutline, Subdivision, box_bricks, covered, pillar_bricks, ring_bricks
from sits_mech.geometry.meshing.crossing import crossing_bricks
from sits_mech.geometry.meshing.inclusion import Inclusion, hollowed
from sits_mech.mechanics.pad.fillet import SLACK
from sits_mech.mechanics.pad.stack import Covering, Interface, interfaces, widened
from sits_mech.quantities import Array, Mask
from sits_mech.scene.parts.elastomer import pillar_middles
from sits_mech.scene.sensor import Elastomer, SceneError, Target

GRADING = 2.0
"""Power of the lines' spacing of a pad."""
NEAR = 1.0
"""Thicknesses beside the target within which the corner of side and ground is loaded like the target's edge."""
_EXPONENTS = (0.5, 0.5946)  # of the displacements at the target's edge, in the middle of a face and at a flush corner
_AROUND = 1  # base cells from a corner of the core to the next middle of a side, and of half the arc where rims cross
_STRETCH = 3.0  # thicknesses of half target that one base cell more than one is worth
_LONG = 6.0  # thicknesses from the target's edge from which on cells grow,
_GROWTH = 3.0  # by so much each
_REACH = 1.25  # thicknesses beside the target within which the pad is stressed: one base cell does beyond
_TALL = 0.5  # thicknesses from which on the rim of a target in its cover has two base cells
_CLEAR = 2.5e-3  # of a disc's radius that its rim keeps from the sides of a box: cells there would have no width


class PadShape(NamedTuple):
    """A pad with its target seen from above [thicknesses]."""

    plate: PlateOutline  # whole target
    pad: PlateOutline  # of pillars one, about its own middle
    middles: tuple[tuple[float, float], ...] = ()  # (x, y) of the pillars; none for a pad in one piece
    between: tuple[Interface, ...] = ()  # of its layers
    cover: Covering | None = None

    @property
    def flush(self) -> bool:
        """Whether the target reaches a side of the pad."""
        return bool(self.middles) or flush(self.plate, self.pad)

    @property
    def low_corner(self) -> bool:
        """Whether a side of the pad is so near the target that the corner at its foot is graded."""
        return bool(self.middles) or low_corner(self.plate, self.pad)

    @property
    def exponent(self) -> float:
        """Exponent of the displacements at the target's edge; 0.5 where rims cross, within the face, or in a cover."""
        return _EXPONENTS[self.flush and not crosses(self) and self.cover is None]

    @property
    def inclusion(self) -> Inclusion | None:
        """The target in its cover; None without one."""
        if self.cover is None:
            return None
        outline = PlateOutline(self.cover.half_x, self.cover.half_y, self.plate.is_round)
        return Inclusion(self.plate, outline, 1.0, self.cover.levels[0])

    def holds(self, places: Array) -> Mask:
        """Whether places, (n, 3), are in a pillar seen from above, or in pad or cover; True for a pad in one piece."""
        if self.inclusion is not None:
            return self.inclusion.filled(places)
        if not self.middles:
            return np.ones(len(places), dtype=bool)
        away = np.linalg.norm(places[:, None, :2] - np.array(self.middles), axis=2)
        return np.asarray(away.min(axis=1) < self.pad.half_x)


def shape_of(target: Target, elastomer: Elastomer, cover: Covering | None = None) -> PadShape:
    """Return the shape of a pad with its target, a rectangle or a disc, under a cover or none."""
    (plate, pad), between = outlines(target, elastomer), interfaces(elastomer)
    if elastomer.kind != "pillars":
        return PadShape(plate, pad, between=between, cover=cover)
    t, radius = elastomer.thickness, 0.5 * (elastomer.diameter or 0.0) / elastomer.thickness
    middles = pillar_middles(elastomer, target.extent, plate.is_round)
    return PadShape(plate, PlateOutline(radius, radius, True), tuple((x / t, y / t) for x, y in middles), between)


def half_bricks(shape: PadShape, split: int, grading: float, layers: int = 0) -> tuple[MeshHex, Subdivision]:
    """Return half a pad, y >= 0, and the division of its bricks; arguments as in `bonded_block`.

    Where rims cross there are no layers. Raise SceneError for crossing rims without room for cells.
    """
    plate, pad, middles, between, cover = shape
    ways, own, around = ((split, grading, layers), (1, grading, 0)), covered(plate, pad), _AROUND * split
    through, base = (lines_through(*way[:2], shape.low_corner, way[2], between, cover) for way in ways)
    if middles:
        inside, first = (ring_lines(pad, pad, *way)[0] for way in ways)
        return pillar_bricks(pad, middles, (inside, through), around, split, (first, base))
    if own is None:
        try:
            rings, z = _crossing_lines(plate, pad, split, grading), lines_through(split, grading, True, 0, between)
            return crossing_bricks(plate, pad, (*rings, z), around, split)
        except ValueError as error:
            raise SceneError(f"target: {error}: draw the pad yourself, elastomer.mesh") from None
    if own.is_round or pad.is_round:
        rings, of_base = (ring_lines(own, pad, *way, cover) for way in ways)
        outline = None if shape.inclusion is None else shape.inclusion.cover
        found: tuple[MeshHex, Subdivision] = ring_bricks(
            own, pad, (*rings, through), around, split, (*of_base, base), outline
        )
    else:
        boxes = [box_lines(own, pad, *way, between, cover) for way in ways]
        found = box_bricks(*boxes[0], base=boxes[1])
    return found if shape.inclusion is None else hollowed(*found, shape.inclusion.filled)


def crosses(shape: PadShape) -> bool:
    """Whether the rims of target and pad cross."""
    return not shape.middles and covered(shape.plate, shape.pad) is None


def cells_of(shape: PadShape, split: int, grading: float, layers: int) -> tuple[int, int, int]:
    """Return the cells of half a pad along x, y and z of a box, else outwards, around and along z.

    Of pillars those around all of them. Crossing rims count one more outwards: three-sided pieces take more memory.
    """
    plate, pad, middles, between, cover = shape
    own, way, around = covered(plate, pad), (split, grading, layers), 4 * _AROUND * split
    low, core = shape.low_corner, max(1, split // 2)
    through, up = (
        len(lines_through(parts, grading, low, more, between, cover)) - 1 for parts, more in ((split, layers), (1, 0))
    )
    if middles:
        return len(ring_lines(pad, pad, *way)[0]) - 1 + core, around * len(middles), through
    if own is None:
        outwards = sum(len(lines) for lines in _crossing_lines(plate, pad, 1, grading)) - 1
        _, division = half_bricks(shape, 1, grading)
        return split * (outwards + 1), split * -(-division.bases // (outwards * up)), split * up
    if own.is_round or pad.is_round:
        inside, outside = ring_lines(own, pad, *way, cover)
        return len(inside) + len(outside) - 2 + core, around, through
    x, y, _ = box_lines(own, pad, *way, cover=cover)
    return len(x) - 1, len(y) - 1, through


def _crossing_lines(plate: PlateOutline, pad: PlateOutline, split: int, grading: float) -> tuple[Array, Array]:
    """Return lines from the core (0) to the bonded rim (1), and from there (0) to the farthest of the pad (1)."""
    half = max(map(min, plate[:2], pad[:2]))
    gap = pad.half_x - min(plate[:2]) if pad.is_round else float(np.hypot(*pad[:2])) - plate.half_x
    return under_lines(half, split, grading) / half, outside_lines(gap, split, grading) / gap


def outlines(target: Target, elastomer: Elastomer) -> tuple[PlateOutline, PlateOutline]:
    """Return target and pad seen from above [thicknesses]; a box touching a disc is widened a little."""
    t = elastomer.thickness
    plate, pad = ([length / (2.0 * t) for length in part.extent] for part in (target, elastomer))
    disc, cylinder = target.is_round, elastomer.is_round
    if disc and not cylinder and plate[0] < (1.0 + 1e-9) * min(pad):
        pad = [max(size, (1.0 + _CLEAR) * plate[0]) for size in pad]
    if disc == cylinder:
        plate = [widened(*both) for both in zip(plate, pad, strict=True)]
    return PlateOutline(plate[0], plate[1], disc), PlateOutline(pad[0], pad[1], cylinder)


def flush(plate: PlateOutline, pad: PlateOutline) -> bool:
    """Whether a target reaches a side of its pad, or goes on beyond it."""
    own = covered(plate, pad)
    return own is None or pad.half_x - own.half_x < 1e-9 or pad.half_y - own.half_y < 1e-9


def graded(split: int, grading: float, layers: int = 0) -> Array:
    """Return the lines of a segment of length 1 from its singular end (0): `split` parts, spacing power `grading`.

    The part that touches the end is cut `layers` times.
    """
    lines = (np.arange(split + 1) / split) ** grading
    cuts = lines[1] * 2.0 ** (-grading * np.arange(layers, 0, -1))
    return np.concatenate([lines[:1], cuts, lines[1:]])


def low_corner(plate: PlateOutline, pad: PlateOutline) -> bool:
    """Whether a side of the pad is so near its target that the corner at its foot is graded, too."""
    own = covered(plate, pad)
    return own is None or min(pad.half_x - own.half_x, pad.half_y - own.half_y) < NEAR


def _both_ends(split: int, grading: float, layers: int) -> Array:
    """Return the lines of a segment of length 1 that is singular at both ends, of two base cells."""
    lower = 0.5 * graded(split, grading, layers)
    return np.concatenate([lower, 1.0 - lower[-2::-1]])


def box_lines(
    plate: PlateOutline, pad: PlateOutline, split: int, grading: float, layers: int = 0,
    between: tuple[Interface, ...] = (),
    cover: Covering | None = None,
) -> tuple[Array, Array, Array]:
    """Return the lines of a box along x, along y from the middle on, and through the thickness.

    Half sizes of target and pad in thicknesses; `split` parts of a base cell; grading and layers as in `graded`.
    """
    way = (split, grading, layers)
    x, y = (
        np.concatenate([under_lines(edge, *way), edge + _covered_lines(over - edge, end - edge, *way)[1:]])
        for edge, over, end in zip(plate[:2], plate[:2] if cover is None else cover[:2], pad[:2], strict=True)
    )
    z = lines_through(split, grading, low_corner(plate, pad), layers, between, cover)
    return np.concatenate([-x[:0:-1], x]), y, z


def _covered_lines(over: float, gap: float, split: int, grading: float, layers: int = 0) -> Array:
    """Return the lines from the target's edge (0) over a cover's outline to the pad's side."""
    if over < 1e-9:
        return outside_lines(gap, split, grading, layers)
    own, end = over * graded(split, grading, layers), outside_lines(gap - over, split, grading)
    return np.concatenate([own[:-1], over + end])


def ring_lines(
    plate: PlateOutline, pad: PlateOutline, split: int, grading: float, layers: int = 0, cover: Covering | None = None
) -> tuple[Array, Array]:
    """Return the lines from the core (0) to the target's outline (1), and from there (0) to the pad's (1).

    With a cover from there (0) to its outline (1), and to the pad's (2).
    """
    half = max(plate[:2])
    inside = under_lines(half, split, grading, layers) / half
    if cover is not None:
        gap = min(pad.half_x - cover.half_x, pad.half_y - cover.half_y)
        end = outside_lines(gap, split, grading) / max(gap, 1e-9)
        return inside, np.concatenate([graded(split, grading, layers)[:-1], 1.0 + end])
    gap = min(pad.half_x - plate.half_x, pad.half_y - plate.half_y)
    return inside, np.zeros(1) if flush(plate, pad) else outside_lines(gap, split, grading, layers) / gap


def under_lines(edge: float, split: int, grading: float, layers: int = 0) -> Array:
    """Return the lines from the middle to the target's edge."""
    near = min(edge, _LONG)
    away = near * graded((1 + int(near / _STRETCH + SLACK)) * split, grading, layers)
    last = away[-1] - away[-1 - split]
    while away[-1] < edge * (1.0 - SLACK):
        left = edge - away[-1]
        last = left if left < 1.5 * _GROWTH * last else _GROWTH * last
        away = np.concatenate([away, away[-1] + last * np.arange(1, split + 1) / split])
    lines = edge - away[::-1]
    lines[0] = 0.0
    return lines


def outside_lines(gap: float, split: int, grading: float, layers: int = 0) -> Array:
    """Return the lines from the target's edge (0) to the pad's side; none but the first where there is no gap."""
    if gap < 1e-9:
        return np.zeros(1)
    if gap < NEAR:
        return gap * _both_ends(split, grading, layers)
    near = graded(split, grading, layers)
    if gap <= 1.5 * _REACH:
        return gap * near
    return np.concatenate([_REACH * near, np.linspace(_REACH, gap, split + 1)[1:]])


def lines_through(
    split: int, grading: float, both: bool, layers: int = 0, between: tuple[Interface, ...] = (),
    cover: Covering | None = None,
) -> Array:
    """Return the lines through the thickness, graded to the upper face or, for a singular lower corner, to both.

    Every interface has a line, and lines are graded to it from both sides where it is singular. With a cover they go on
    through the target's height and over it.
    """
    ends, found = (Interface(0.0, both), *between, Interface(1.0, True)), [np.zeros(1)]
    for (low, below), (high, above) in pairwise(ends):
        own = graded(split, grading, layers) if below or above else np.linspace(0.0, 1.0, split + 1)
        own = _both_ends(split, grading, layers) if below and above else 1.0 - own[::-1] if above else own
        found.append(np.append(low + (high - low) * own[1:-1], high))
    if cover is not None:
        low, high = cover.levels
        even = cover.rim < _TALL
        rim = np.linspace(0.0, 1.0, split + 1) if even else _both_ends(split, grading, layers)
        over = cover.thickness * graded(split, grading, layers)[1:]
        found += [np.append(1.0 + cover.rim * rim[1:-1], low), low + over]
    return np.concatenate(found)
