"""Choose the loads of a design's table, and interpolate between them: polynomials through Chebyshev's points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from sits_mech.quantities import Array, tensor_grid

_COUNTS = {1: 5, 2: 5}  # loads along each component, by their number, three of more; one less to one side
FEW = 3
"""Of a search: with pads strained to 0.7 of their data resolutions are within 1.2 %, errors within 2.4 % of 7 x 7's."""
_FINE = {1: 17, 2: 7, 3: 5}


class Loads(NamedTuple):
    """Names of load components and their values on a grid."""

    names: tuple[str, ...]
    axes: tuple[Array, ...]

    @property
    def span(self) -> Array:
        """The range of each component, shape (d,)."""
        return np.array([axis[-1] - axis[0] for axis in self.axes])

    @property
    def points(self) -> Array:
        """The g loads, the last component running fastest, shape (g, d)."""
        return tensor_grid(*self.axes).reshape(-1, len(self.axes))


def loads_between(ends: Mapping[str, tuple[float, float]], most: int = 99) -> Loads:
    """Return Chebyshev's points of the range of each component, the ends among them, so many at most.

    A range that is even to both sides contains zero, and half of its loads are images where the pad is symmetric.
    """
    count = _COUNTS.get(len(ends), 3)
    each = {name: min(count - (count > 3 and -ends[name][0] != ends[name][1]), most) for name in ends}
    unit = {name: chebyshev.chebpts2(count) for name, count in each.items()}
    even = {name: 0.5 * (points - points[::-1]) for name, points in unit.items()}  # images to the last digit
    axes = [0.5 * (a + b) + 0.5 * (b - a) * even[name] for name, (a, b) in ends.items()]
    return Loads(tuple(ends), tuple(np.where(np.abs(axis) < 1e-12 * np.ptp(axis), 0.0, axis) for axis in axes))


@dataclass(frozen=True)
class Operator:
    """Interpolation of inductances and slopes from the g loads of a grid."""

    loads: Loads

    @cached_property
    def fine(self) -> list[Array]:
        """Values of each component at which figures are evaluated."""
        count = _FINE.get(len(self.loads.names), 4)
        return [np.linspace(axis[0], axis[-1], count) for axis in self.loads.axes]

    @cached_property
    def points(self) -> Array:
        """Loads at which figures are evaluated, shape (m, d)."""
        return tensor_grid(*self.fine).reshape(-1, len(self.fine))

    @cached_property
    def known(self) -> Array:
        """No load; then each component at its largest, the others zero, shape (1 + d, d)."""
        largest = [axis[int(np.argmax(np.abs(axis)))] for axis in self.loads.axes]
        rest = np.array([np.clip(0.0, axis[0], axis[-1]) for axis in self.loads.axes])
        return np.vstack([rest, rest + np.diag(largest - rest)])

    @cached_property
    def at_points(self) -> tuple[Array, Array]:
        """Matrices from the grid to values (m, g) and derivatives (d, m, g) at the points."""
        return self.values(self.points), self.derivatives(self.points)

    @cached_property
    def at_known(self) -> tuple[Array, Array]:
        """Matrices from the grid to values and derivatives at the known loads."""
        return self.values(self.known), self.derivatives(self.known)

    def values(self, points: Array) -> Array:
        """Return the matrix from the grid to values at points (m, d), shape (m, g)."""
        return _products([_along(axis, x)[0] for axis, x in zip(self.loads.axes, points.T, strict=True)])

    def derivatives(self, points: Array) -> Array:
        """Return the matrices from the grid to derivatives at points (m, d), shape (d, m, g)."""
        each = [_along(axis, x) for axis, x in zip(self.loads.axes, points.T, strict=True)]
        rows = range(len(each))
        return np.stack([_products([one[int(k == own)] for k, one in enumerate(each)]) for own in rows])


def _along(axis: Array, x: Array) -> tuple[Array, Array]:
    """Return matrices from values on an axis (k,) to values and slopes at x (m,), shape (m, k) each."""
    half, middle = 0.5 * (axis[-1] - axis[0]), 0.5 * (axis[-1] + axis[0])
    s, t = (axis - middle) / half, (x - middle) / half
    inverse = np.linalg.inv(chebyshev.chebvander(s, len(s) - 1))
    slope = chebyshev.chebder(np.eye(len(s)), axis=0)
    rate = chebyshev.chebvander(t, len(s) - 2) @ slope / half
    return chebyshev.chebvander(t, len(s) - 1) @ inverse, rate @ inverse


def _products(parts: list[Array]) -> Array:
    """Return products over the axes, the last running fastest, shape (m, g)."""
    found = np.ones((len(parts[0]), 1))
    for part in parts:
        found = (found[:, :, None] * part[:, None]).reshape(len(part), -1)
    return found
