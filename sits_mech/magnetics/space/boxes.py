"""Interaction of boxes on a tensor mesh: the mean of 1/r for currents.

Two boxes that carry uniform currents J, J' have the mutual energy ``mu0 / (4 pi) (integral J) . (integral J') G``, with

    G = < 1 / |r - r'| >   [1/m], the mean over both volumes.

G V V' are differences, two along each axis, of Hoer and Love's F with ``d6 F / dx2 dy2 dz2 = 1/r``. A tensor mesh has
few different distances, so that each is evaluated once for these. Differences lose digits like r^6 / (V V'): far boxes
have the second moments, ``1/R + (1/2) M : grad grad (1/R)``.

Errors of G: rounding for near boxes, 1e-3 at the change to far ones.
Source: C. Hoer and C. Love, J. Res. NBS 69C (1965) 127.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sits_mech.quantities import Array, Integers

_FAR = 6.0  # largest sides between the centres of boxes from which on G is that of far ones: the docstring's 1e-3
_LOST = 1e10  # r^6 over the product of both volumes from which on differences in double precision lose 1e-6


def box_means(x: Array, y: Array, z: Array) -> Array:
    """Return G [1/m] between the boxes of one octant and all of the mirrored tensor mesh, shape (2, 2, 2, n, n).

    The first axes tell whether the second box is mirrored in x, y, z. Boxes run z fastest; x, y, z are nodes of the
    positive half axes, from 0 [m].
    """
    scale = max(axis[-1] for axis in (x, y, z))
    axes = [_Axis.of(axis, scale) for axis in (x, y, z)]
    F = _differences(_near_table(axes, scale), 0, axes[0])
    n = [axis.size - 1 for axis in (x, y, z)]
    result = np.empty((2, 2, 2, *n, *n))
    for i, slab in enumerate(F):  # the whole in quadruple storage would rule the memory
        whole = _differences(_differences(slab[None], 2, axes[1]), 4, axes[2]).astype(float)
        G = _mean_inverse(whole / scale, [axes[0].row(i), *axes[1:]], scale)
        for octant in np.ndindex(2, 2, 2):  # which second boxes lie in it, from the middle on
            X, Y, Z = (slice(m - 1, None, -1) if p else slice(m, None) for m, p in zip(n, octant, strict=True))
            result[octant][i] = G[0, X, :, Y, :, Z].transpose(1, 3, 0, 2, 4)
    return result.reshape(2, 2, 2, np.prod(n), np.prod(n))


@dataclass(frozen=True)
class _Axis:
    """Cells of a half axis by all cells along it: distances of nodes over a scale, and which pair has which.

    Sides of the first and of the second cell, and the distance of their centres [m].
    """

    values: Array  # (m,)
    index: Integers  # (n + 1, 2 n + 1)
    first: Array  # (n, 2 n)
    second: Array  # (n, 2 n)
    apart: Array  # (n, 2 n)

    @classmethod
    def of(cls, nodes: Array, scale: float) -> _Axis:
        """Return the cells between the nodes of a half axis."""
        scaled = nodes / scale
        between = scaled[:, None] - np.concatenate([-scaled[:0:-1], scaled])
        values, index = np.unique(np.round(np.abs(between), 15), return_inverse=True)
        side, centre = np.diff(nodes), (nodes[1:] + nodes[:-1]) / 2
        first, second = np.broadcast_arrays(side[:, None], np.concatenate([side[::-1], side]))
        apart = centre[:, None] - np.concatenate([-centre[::-1], centre])
        return cls(values, index.reshape(between.shape), first, second, apart)

    def row(self, i: int) -> _Axis:
        """Return the pairs of one first cell."""
        return replace(self, **{name: getattr(self, name)[i : i + 1] for name in ("first", "second", "apart")})

    def least(self, factor: float) -> tuple[Array, Array, Array]:
        """Return, for each distance of nodes, the least d^2, d^2 - (_FAR side)^2, s s' of its pairs, all scaled."""
        first, second, square = self.first * factor, self.second * factor, (self.apart * factor) ** 2
        near = square - (_FAR * np.maximum(first, second)) ** 2
        found = np.full((3, self.values.size), np.inf)
        for nodes in (self.index[i : i + len(first), j : j + first.shape[1]] for i, j in np.ndindex(2, 2)):
            for row, values in zip(found, (square, near, first * second), strict=True):
                np.minimum.at(row, nodes, values)
        return found[0], found[1], found[2]


def _near_table(axes: Sequence[_Axis], scale: float) -> Any:
    """Return F at all distances of near boxes, zero elsewhere; quadruple where the differences lose too much."""
    squares, nears, sides = zip(*(axis.least(1.0 / scale) for axis in axes), strict=True)
    x, y, z = np.ix_(*squares)
    a, b, c = np.ix_(*nears)
    near = (a + y + z <= 0.0) | (x + b + z <= 0.0) | (x + y + c <= 0.0)
    x, y, z = np.ix_(*(axis.values for axis in axes))
    a, b, c = np.ix_(*sides)
    fine = near & ((x**2 + y**2 + z**2) ** 3 > _LOST * a * b * c)
    F = np.zeros(near.shape, dtype=np.longdouble)
    for some, kind in ((near & ~fine, float), (fine, np.longdouble)):
        at = np.nonzero(some)
        F[some] = _hoer_love(*(axis.values.astype(kind)[i] for axis, i in zip(axes, at, strict=True)))
    return F


def _differences(F: Any, axis: int, cells: _Axis) -> Any:
    """Return minus the second difference of F at the distances along an axis, first and second cell in its place."""
    whole = np.moveaxis(np.moveaxis(F, axis, 0)[cells.index], (0, 1), (axis, axis + 1))
    return -np.diff(np.diff(whole, axis=axis), axis=axis + 1)


def _apart(axes: Sequence[_Axis], scale: float) -> tuple[Array, Array, Array]:
    """Return r^2 of the centres, V V' over scale^6 and the largest side of all pairs of boxes, two axes an axis."""
    square, volume, largest = np.zeros(1), np.ones(1), np.zeros(1)
    for k, axis in enumerate(axes):
        square = square + _shaped(axis.apart**2, k)
        volume = volume * _shaped(axis.first * axis.second / scale**2, k)
        largest = np.maximum(largest, _shaped(np.maximum(axis.first, axis.second), k))
    return square, volume, largest


def _shaped(pairs: Array, k: int) -> Array:
    """Return pairs of cells along one axis, in the shape of all pairs of boxes."""
    return pairs.reshape(*(1,) * (2 * k), *pairs.shape, *(1,) * (4 - 2 * k))


def _mean_inverse(F: Array, axes: Sequence[_Axis], scale: float) -> Array:
    """Return G of differences of F, by multipoles of far boxes."""
    square, volume, largest = _apart(axes, scale)
    far = square > (_FAR * largest) ** 2
    square = np.where(far, square, 1.0)
    moments = [((axis.first**2 + axis.second**2) / 12, axis.apart**2) for axis in axes]
    bend = sum(_shaped(m, k) * (3.0 * _shaped(d, k) / square - 1.0) for k, (m, d) in enumerate(moments))
    return np.where(far, (1.0 + bend / (2.0 * square)) / np.sqrt(square), F / volume)


def _hoer_love(x: Any, y: Any, z: Any) -> Any:
    """Return the antiderivative F for x, y, z >= 0."""
    xx, yy, zz = x * x, y * y, z * z
    r = np.sqrt(xx + yy + zz)

    def log(a: Any, b2: Any, c2: Any) -> Any:
        square = b2 + c2
        inverse = np.arcsinh(a / np.sqrt(np.where(square > 0.0, square, 1.0)))
        return (b2 * c2 / 4 - (b2 * b2 + c2 * c2) / 24) * a * inverse

    def angle(a: Any, b: Any, c: Any) -> Any:
        return a * b * c**3 / 6 * np.arctan2(a * b, c * r)

    even = (xx * xx + yy * yy + zz * zz - 3.0 * (xx * yy + yy * zz + zz * xx)) * r / 60
    logs = log(x, yy, zz) + log(y, zz, xx) + log(z, xx, yy)
    return logs + even - angle(x, y, z) - angle(y, z, x) - angle(z, x, y)
