"""Bend a plate under its coils, to first order: the field that its points meet where bending takes them.

A point of the plate, at a height z above its middle plane, goes by phi = (x - z w_x, y - z w_y, z + w): normals stay
normals. Currents that go with it meet, with J the gradient of phi,

    A' = J^T A(phi),

in which a plate that turns is one that turns. What currents do to each other is the same bent up or down, so that it
changes by the square of w.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from sits_mech.quantities import Array


@dataclass(frozen=True, eq=False)
class Lift:
    """How the points of a plate rise in p poses: by sums of K shapes."""

    shapes: Callable[[Array], Array]  # w, w_x, w_y, w_xx, w_xy, w_yy of each at places (q, 2) [m], (6, q, K)
    sizes: Array  # (p, K)
    middle: float  # height of its middle plane above its bottom face's centre [m]

    def some(self, poses: slice) -> Lift:
        """Return it in some of the poses."""
        return replace(self, sizes=self.sizes[poses])

    def at(self, points: Array) -> LiftedPoints:
        """Return where points (q, 3) from the bottom face's centre go."""
        return LiftedPoints(points, points[:, 2] - self.middle, self.shapes(points[:, :2]) @ self.sizes.T)


@dataclass(frozen=True, eq=False)
class LiftedPoints:
    """Points of a plate that bends, in p poses."""

    points: Array  # (q, 3) [m]
    height: Array  # (q,) above the middle plane [m]
    rise: Array  # w and its derivatives, (6, q, p)

    @cached_property
    def places(self) -> Array:
        """Where they are in the axes of the plate, (p, 3, q) [m]."""
        w, w_x, w_y = np.swapaxes(self.rise[:3], 1, 2)
        return np.stack([-self.height * w_x, -self.height * w_y, w], axis=1) + self.points.T

    def met(self, A: Array) -> Array:
        """Return A' of A at these places, (p, 3, q) each, in the axes of the plate."""
        _, w_x, w_y, w_xx, w_xy, w_yy = np.swapaxes(self.rise, 1, 2)
        x, y, z = np.moveaxis(A, 1, 0)
        along = [a - self.height * (b * x + c * y) + s * z for a, b, c, s in ((x, w_xx, w_xy, w_x), (y, w_xy, w_yy, w_y))]
        return np.stack([*along, z - w_x * x - w_y * y], axis=1)
