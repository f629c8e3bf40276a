"""Bricks of a pad under its target: boxes on a tensor grid, round outlines in rings, pillars one by one.

Half the pad, y >= 0, is divided; lines are those of lines.py, in thicknesses. A target may be wider than its pad in one
direction or in both: what is beyond takes no part but in contact, where silicone that bulges lies on the target's
plane (faces/contact.py). What is bonded is what the target covers:

    a box under a rectangle, or within its target    tensor grid
    a rectangle and a disc, one within the other     rings around a core, the bonded outline one of them
    a rectangle and a disc that cross                rings in what they share, patches beside it (meshing/crossing.py)
    pillars                                          rings in each, flush with the target

Every mesh is one of a family: each of its base cells is divided into as many parts along each axis (lines.py).

Order. At the edge of a target in the middle of a face displacements go as ``r**0.5``, whatever Poisson's ratio; at the
corner of a flush pad, an incompressible right angle, as ``r**0.5946``. What a pad does for its target, an energy,
converges on lines graded with beta as ``m**(-2 k beta)``, k that exponent, as far as the elements' own order of 4
allows: with beta = 2 as ``m**-2`` and ``m**-2.38``. (Compliances of `biorob2018-w15` from m = 2 and 3 extrapolated so
are within 3e-4 of those of m = 4 on stronger gradings.)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from skfem import MeshHex

from sits_mech.mechanics.pad.lines import (
    beside_lines,
    box_lines,
    flush,
    lines_through,
    low_corner,
    outlines,
    ring_lines,
    under_lines,
)
from sits_mech.meshing.bricks import Division, Outline, box_bricks, covered, ring_bricks
from sits_mech.meshing.crossing import crossing_bricks
from sits_mech.meshing.pillars import pillar_bricks
from sits_mech.quantities import Array
from sits_mech.scene.elastomer import pillar_middles
from sits_mech.scene.sensor import Elastomer, SceneError, Target

GRADING = 2.0
"""Power of the lines' spacing of a pad."""
_EXPONENTS = (0.5, 0.5946)  # of the displacements at the target's edge, in the middle of a face and at a flush corner
_AROUND = 1  # base cells from a corner of the core to the next middle of a side, and of half the arc where rims cross


class Shape(NamedTuple):
    """A pad with its target seen from above [thicknesses]."""

    plate: Outline  # whole target
    pad: Outline  # of pillars one, about its own middle
    middles: tuple[tuple[float, float], ...] = ()  # (x, y) of the pillars; none for a pad in one piece

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
        """Exponent of the displacements at the target's edge; 0.5 where rims cross, within the face."""
        return _EXPONENTS[self.flush and not crosses(self)]

    def holds(self, places: Array) -> Array:
        """Whether places, (n, 2 or more), are in a pillar seen from above; True for a pad in one piece."""
        if not self.middles:
            return np.ones(len(places), dtype=bool)
        away = np.linalg.norm(places[:, None, :2] - np.array(self.middles), axis=2)
        return np.asarray(away.min(axis=1) < self.pad.half_x)


def shape_of(target: Target, elastomer: Elastomer) -> Shape:
    """Return the shape of a pad with its target, a rectangle or a disc."""
    plate, pad = outlines(target, elastomer)
    if elastomer.kind != "pillars":
        return Shape(plate, pad)
    t, radius = elastomer.thickness, 0.5 * (elastomer.diameter or 0.0) / elastomer.thickness
    middles = pillar_middles(elastomer, target.extent, plate.is_round)
    return Shape(plate, Outline(radius, radius, True), tuple((x / t, y / t) for x, y in middles))


def half_bricks(shape: Shape, split: int, grading: float, layers: int = 0) -> tuple[MeshHex, Division]:
    """Return half a pad, y >= 0, and the division of its bricks; arguments as in `bonded_block`.

    Where rims cross there are no layers. Raise SceneError for crossing rims without room for cells.
    """
    plate, pad, middles = shape
    ways, own, around = ((split, grading, layers), (1, grading, 0)), covered(plate, pad), _AROUND * split
    through, base = (lines_through(*way[:2], shape.low_corner, way[2]) for way in ways)
    if middles:
        inside, first = (ring_lines(pad, pad, *way)[0] for way in ways)
        return pillar_bricks(pad, middles, (inside, through), around, split, (first, base))
    if own is None:
        try:
            lines = (*_crossing_lines(plate, pad, split, grading), lines_through(split, grading, shape.low_corner))
            return crossing_bricks(plate, pad, lines, around, split)
        except ValueError as error:
            raise SceneError(f"target: {error}: draw the pad yourself, elastomer.mesh") from None
    if own.is_round or pad.is_round:
        rings, of_base = (ring_lines(own, pad, *way) for way in ways)
        return ring_bricks(own, pad, (*rings, through), around, split, (*of_base, base))
    boxes = [box_lines(own, pad, *way) for way in ways]
    return box_bricks(*boxes[0], base=boxes[1])


def crosses(shape: Shape) -> bool:
    """Whether the rims of target and pad cross."""
    return not shape.middles and covered(shape.plate, shape.pad) is None


def cells_of(shape: Shape, split: int, grading: float, layers: int) -> tuple[int, int, int]:
    """Return the cells of half a pad along x, y and z of a box, else outwards, around and along z.

    Of pillars those around all of them. Crossing rims count one more outwards: three-sided pieces take more memory.
    """
    plate, pad, middles = shape
    own, way, around = covered(plate, pad), (split, grading, layers), 4 * _AROUND * split
    through, core = len(lines_through(split, grading, shape.low_corner, layers)) - 1, max(1, split // 2)
    if middles:
        return len(ring_lines(pad, pad, *way)[0]) - 1 + core, around * len(middles), through
    if own is None:
        outwards, up = (sum(len(lines) for lines in _crossing_lines(plate, pad, 1, grading)) - 1), 1 + shape.low_corner
        _, division = half_bricks(shape, 1, grading)
        return split * (outwards + 1), split * -(-division.bases // (outwards * up)), split * up
    if own.is_round or pad.is_round:
        inside, beside = ring_lines(own, pad, *way)
        return len(inside) + len(beside) - 2 + core, around, through
    x, y, _ = box_lines(own, pad, *way)
    return len(x) - 1, len(y) - 1, through


def _crossing_lines(plate: Outline, pad: Outline, split: int, grading: float) -> tuple[Array, Array]:
    """Return lines from the core (0) to the bonded rim (1), and from there (0) to the farthest of the pad (1)."""
    half = max(map(min, plate[:2], pad[:2]))
    gap = pad.half_x - min(plate[:2]) if pad.is_round else float(np.hypot(*pad[:2])) - plate.half_x
    return under_lines(half, split, grading) / half, beside_lines(gap, split, grading) / gap
