"""Bend a plate under its coils, to first order: the field that its points meet where bending takes them.

A point of the plate, at a height z above the plane that a shape does not stretch, goes by
phi = (x - z w_x, y - z w_y, z + w): normals stay normals. Currents that go with it meet, with J the gradient of phi,

    A' = J^T A(phi),

in which a plate that turns is one that turns. What currents do to each other is the same bent up or down, so that it
changes by the square of w.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from sits_mech.quantities import Array


@dataclass(frozen=True, eq=False)
class Lift:
    """How the points of a plate rise in p poses: by sums of K shapes."""

    shapes: Callable[[Array], Array]  # w, w_x, w_y, w_xx, w_xy, w_yy of each at places (q, 2) [m], (6, q, K)
    planes: Array  # (K,), above the bottom face, that they do not stretch [m]
    sizes: Array  # (p, K)

    def some(self, poses: slice) -> Lift:
        """Return it in some of the poses."""
        return replace(self, sizes=self.sizes[poses])

    def at(self, points: Array) -> LiftedPoints:
        """Return where points (q, 3) from the bottom face's centre go."""
        each = self.shapes(points[:, :2])
        along = ((points[:, 2:] - self.planes) * each[1:]) @ self.sizes.T
        return LiftedPoints(points, np.swapaxes(each[:3] @ self.sizes.T, 1, 2), np.swapaxes(along, 1, 2))


@dataclass(frozen=True, eq=False)
class LiftedPoints:
    """Points of a plate that bends, in p poses."""

    points: Array  # (q, 3) [m]
    rise: Array  # w, w_x, w_y, (3, p, q)
    along: Array  # z times the derivatives of w, (5, p, q)

    @property
    def places(self) -> Array:
        """Where they are in the axes of the plate, (p, 3, q) [m]."""
        return np.stack([-self.along[0], -self.along[1], self.rise[0]], axis=1) + self.points.T

    def met(self, A: Array) -> Array:
        """Return A' of A at these places, (p, 3, q) each, in the axes of the plate."""
        (_, w_x, w_y), (_, _, xx, xy, yy), (x, y, z) = self.rise, self.along, np.moveaxis(A, 1, 0)
        return np.stack([x - xx * x - xy * y + w_x * z, y - xy * x - yy * y + w_y * z, z - w_x * x - w_y * y], axis=1)
