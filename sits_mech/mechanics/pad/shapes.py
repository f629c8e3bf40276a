"""Which bricks does a pad under its target take? Boxes on a tensor grid, what is round in rings, pillars one by one.

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
    """A pad with its target seen from above [thicknesses].

    Attributes
    ----------
    plate, pad : Outline
        The target, whole, and the pad; of pillars one of them, about its own middle.
    middles : tuple of (x, y)
        Of the pillars; none for a pad in one piece.
    """

    plate: Outline
    pad: Outline
    middles: tuple[tuple[float, float], ...] = ()

    @property
    def flush(self) -> bool:
        """Whether the target reaches a side of the pad."""
        return bool(self.middles) or flush(self.plate, self.pad)

    @property
    def exponent(self) -> float:
        """Of the displacements at the target's edge; where rims cross a part of it is in the middle of the face."""
        crossing = not self.middles and covered(self.plate, self.pad) is None
        return _EXPONENTS[self.flush and not crossing]

    def holds(self, places: Array) -> Array:
        """Say which places, shape (n, 2 or more), are in a pillar, seen from above; of a pad in one piece all are."""
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


def half_bricks(shape: Shape, split: int, grading: float) -> tuple[MeshHex, Division]:
    """Return half a pad, y >= 0, and the division of its bricks.

    Parameters
    ----------
    shape : Shape
    split : int
        Parts of each base cell along every axis.
    grading : float
        Power of the lines' spacing towards the target's edge and the faces; 1 is uniform.

    Raises
    ------
    SceneError
        For rims of target and pad that cross where no cells have room.
    """
    plate, pad, middles = shape
    through, own = lines_through(split, grading, shape.flush), covered(plate, pad)
    if middles:
        inside, _ = ring_lines(pad, pad, split, grading)
        return pillar_bricks(pad, middles, (inside, through), _AROUND * split, split)
    if own is None:
        try:
            lines = (*_crossing_lines(plate, pad, split, grading), through)
            return crossing_bricks(plate, pad, lines, _AROUND * split, split)
        except ValueError as error:
            raise SceneError(f"target: {error}: draw the pad yourself, elastomer.mesh") from None
    if own.is_round or pad.is_round:
        return ring_bricks(own, pad, (*ring_lines(own, pad, split, grading), through), _AROUND * split, split)
    return box_bricks(*box_lines(own, pad, split, grading), split)


def base_cells(shape: Shape) -> tuple[int, int, int]:
    """Return the numbers of base cells of half a pad: along x, y and z of a box, else outwards, around and along z.

    Of pillars those around all of them. Where rims cross all are counted, and one more outwards: three-sided pieces
    take more memory than rings.
    """
    plate, pad, middles = shape
    own, through = covered(plate, pad), len(lines_through(1, GRADING, shape.flush)) - 1
    if middles:
        return len(ring_lines(pad, pad, 1, GRADING)[0]), 4 * _AROUND * len(middles), through
    if own is None:
        outwards = sum(len(lines) for lines in _crossing_lines(plate, pad, 1, GRADING)) - 1
        _, division = half_bricks(shape, 1, GRADING)
        return outwards + 1, -(-division.bases // (outwards * through)), through
    if own.is_round or pad.is_round:
        inside, beside = ring_lines(own, pad, 1, GRADING)
        return len(inside) + len(beside) - 1, 4 * _AROUND, through
    x, y, _ = box_lines(own, pad, 1, GRADING)
    return len(x) - 1, len(y) - 1, through


def _crossing_lines(plate: Outline, pad: Outline, split: int, grading: float) -> tuple[Array, Array]:
    """Lines from the core (0) to the bonded rim (1), and from there (0) to the farthest of the pad (1)."""
    half = max(map(min, plate[:2], pad[:2]))
    gap = pad.half_x - min(plate[:2]) if pad.is_round else float(np.hypot(*pad[:2])) - plate.half_x
    return under_lines(half, split, grading) / half, beside_lines(gap, split, grading) / gap
