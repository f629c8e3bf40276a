"""Divide round pillars into bricks, each in rings like a cylinder of its own (bricks.py), at its own place.

The pattern is its own mirror image in y: half of it, y >= 0, is meshed, pillars on the plane by their halves. Pillars
touch nowhere, and each has base cells of its own.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from skfem import MeshHex2

from sits_mech.meshing.bricks import Division, Outline, joined, ring_bricks
from sits_mech.meshing.copies import both_halves, side_by_side
from sits_mech.quantities import Array

_PLANE = 1e-9  # how near to y = 0 a pillar's middle lies on it


def pillar_bricks(
    disc: Outline, middles: Sequence[tuple[float, float]], lines: tuple[Array, Array], around: int, split: int = 1,
    base: tuple[Array, Array] | None = None,
) -> tuple[MeshHex2, Division]:
    """Return the pillars at y >= 0, half of those that the plane y = 0 cuts through the middle, and their division.

    `disc` is one pillar's outline, `middles` are of all of them (those at y < 0 are images of others), `lines` go from
    the core (0) to the pillar's side (1), and along z; the others as of `ring_bricks`.
    """
    first = None if base is None else (base[0], np.zeros(1), base[1])
    half, division = ring_bricks(disc, disc, (lines[0], np.zeros(1), lines[1]), around, split, first)
    whole = both_halves(half)
    on_plane = [(half, (x, 0.0)) for x, y in middles if abs(y) <= _PLANE]
    beside = [(whole, (x, y)) for x, y in middles if y > _PLANE]
    divisions = [division] * len(on_plane) + [division.doubled] * len(beside)
    return side_by_side([*on_plane, *beside]), joined(divisions)
