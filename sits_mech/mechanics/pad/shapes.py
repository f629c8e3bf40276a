"""Which bricks does a pad under its target take? Boxes on a tensor grid, what is round in rings, pillars one by one.

Half the pad, y >= 0, is divided; lines are those of lines.py, in thicknesses. A target may be wider than its pad in one
direction or in both: what is beyond takes no part but in contact, where silicone that bulges lies on the target's
plane (faces/contact.py). What is bonded is what the target covers:

    a box under a rectangle, or within its target    tensor grid
    a rectangle and a disc, one within the other     rings around a core, the bonded outline one of them
    a rectangle and a disc that cross                rings in what they share, patches beside it (meshing/crossing.py)
    pillars                                          rings in each, flush with the target

With every cell split by a factor along each direction the same maker gives the meshes that are nested in it.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from skfem import MeshHex

from sits_mech.mechanics.pad.lines import box_lines, flush, lines_through, outlines, ring_lines
from sits_mech.meshing.bricks import Outline, box_bricks, covered, ring_bricks
from sits_mech.meshing.crossing import crossing_bricks
from sits_mech.meshing.pillars import pillar_bricks
from sits_mech.meshing.structured import split_lines
from sits_mech.quantities import Array
from sits_mech.scene.elastomer import pillar_middles
from sits_mech.scene.sensor import Elastomer, SceneError, Target

_AROUND = (2, 3)  # cells from a corner of the core to the next middle of a side: up to 2 through the thickness, more
_FEWER = (1, 2)  # of each of many pillars, and of half the arc where rims cross


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


@lru_cache(maxsize=4)
def half_bricks(shape: Shape, cells: int, grading: float, split: int = 1) -> MeshHex:
    """Return half a pad, y >= 0.

    Parameters
    ----------
    shape : Shape
    cells : int
        Cells through the thickness; one more where the target reaches a side of the pad, and towards its edges.
    grading : float
        Power of the lines' spacing towards the target's edge and the faces; 1 is uniform.
    split : int
        Pieces that each of these cells is split in, along each direction.

    Raises
    ------
    SceneError
        For rims of target and pad that cross where no cells have room.
    """
    plate, pad, middles = shape
    through, around, fewer = lines_through(cells, grading, shape.flush), _AROUND[cells > 2], _FEWER[cells > 2]
    if middles:
        inside, _ = ring_lines(pad, pad, cells, grading)
        return pillar_bricks(pad, middles, (inside, through), fewer, split)
    own = covered(plate, pad)
    if own is None:
        n = np.arange(cells + 2) / (cells + 1.0)
        try:
            return crossing_bricks(plate, pad, (1.0 - (1.0 - n) ** grading, n**grading, through), fewer, split)
        except ValueError as error:
            raise SceneError(f"target: {error}: draw the pad yourself, elastomer.mesh") from None
    if own.is_round or pad.is_round:
        inside, beside = ring_lines(own, pad, cells, grading)
        lines = (split_lines(inside, split), split_lines(beside, split), split_lines(through, split))
        return ring_bricks(own, pad, lines, around * split)
    return box_bricks(*(split_lines(each, split) for each in box_lines(own, pad, cells, grading)))
