"""Leave a target out of the bricks of a pad that go on above it as a cover, and what is beside the cover.

Bricks are those over the whole pad, from the ground to the cover's top, with lines at the outlines and heights of
target and cover: each lies within one of silicone, target and air, and its middle says in which. Those of silicone are
left, whole base cells of a family (bricks.py).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from skfem import MeshHex, MeshHex2

from sits_mech.geometry.meshing.bricks import Bricks, PlateOutline, Subdivision, bricks_of, inside_outline, mesh_of
from sits_mech.quantities import Array, Mask


class Inclusion(NamedTuple):
    """A target within a cover on a pad, both centred; the target's lower face is the pad's upper one."""

    target: PlateOutline
    cover: PlateOutline
    low: float  # heights of the target's faces
    high: float

    def filled(self, places: Array) -> Mask:
        """Say which places, (n, 3), from the ground to the cover's top and within the pad's outline are silicone."""
        in_target, in_cover = (inside_outline(each, places, 0.0) for each in (self.target, self.cover))
        z = places[:, 2]
        return (z < self.low) | (in_cover & (~in_target | (z > self.high)))


def hollowed(
    mesh: MeshHex, division: Subdivision, filled: Callable[[Array], Mask]
) -> tuple[MeshHex, Subdivision]:
    """Return the bricks whose middles, (n, 3), are `filled` with silicone, on the points that they have; and division.
    """
    points, corners, places = bricks_of(mesh)
    kept = filled(places[:, -1])  # middles
    used, numbers = np.unique(corners[kept], return_inverse=True)
    base, part, low, high = division
    some = Subdivision(np.unique(base[kept], return_inverse=True)[1], part[kept], low[kept], high[kept])
    numbers = numbers.reshape(-1, corners.shape[1])
    if isinstance(mesh, MeshHex2):
        return mesh_of(Bricks(points[used], numbers, places[kept])), some
    return MeshHex(np.ascontiguousarray(points[used].T), np.ascontiguousarray(numbers.T)), some
