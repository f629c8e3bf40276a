"""Mean of 1/r between right prisms of any polygon: the inductance kernel of the target in three dimensions.

Two bodies that carry uniform currents J, J' have the mutual energy

    mu0 / (4 pi)  (integral J) . (integral J')  G,      G = < 1 / |r - r'| >   [1/m],

the mean over both volumes (of boxes: `boxes`). Near, the smaller base's Gauss points, and in closed form the rest: with

    W'' = integral over the larger base of 1/r,    r^2 = rho^2 + h^2,    W(h) = integral of h asinh(h / rho) - r,

G is the mean of sum +-W(z_i - z_j) of their faces over the larger's volume and the other's height. A side of a base,
its line d off the point, s along it, R = rho there, adds between its ends

    d/6 [3 s h asinh(h / R) - s r + (3 h^2 - d^2) ln(s + r)] + h/6 [(h^2 - 3 d^2) atan(h s / (d r)) - h^2 atan(s / d)].

Far apart the second moments, ``1/R + (1/2) M : grad grad (1/R)``; between, Gauss points of both along the plate, and
their second moments m, m' through it, ``1/r + (m + m')/2 d^2/dz^2 (1/r)``.

Errors by 3 x 3 points: 2e-3 in the mean and 1e-2 at worst where thin prisms touch, some 3e-4 of L and 3e-3 of R of
discs many skin depths thick, which no finer division shows; by 5 x 5, 2e-4 and 3e-3. All near pairs take as many:
errors of neighbours cancel.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from sits_mech.magnetics.space.fields import Prisms, gauss_points
from sits_mech.quantities import Array, Integers
from sits_mech.scene.parts.outlines import signed_area

_NEAR_PRISMS, _FAR_PRISMS = 1.2, 2.5  # where prisms stop being near, and start being far, in largest diameters
_PAIRS, _BLOCK = 250_000, 4096  # held at once, and as many as a cache holds
_ROUNDING = 1e-15  # what two sides of a triangle are longer than the third by at least, of their sum
_TIMES = 9e-7, 2.4e-6, 1.4e-7  # s of processor time that a point of a near pair takes, a pair between, a far one
FEW, MANY = 3, 5
"""Gauss points along each side of the base of a near prism."""


def prism_means(
    first: Prisms, second: Prisms, *, points: int = FEW, symmetric: bool = False
) -> Array:
    """Return G between all prisms of two sets, shape (n, m) [1/m]; of symmetric parts (n, n) half is worked out."""
    one, two = _shape(first), _shape(second)
    G = np.empty((first.low.size, second.low.size))
    step, pairs = max(1, _PAIRS // second.low.size), list[Any]()
    ways: tuple[Callable[..., Array], ...] = partial(_near, points), _middle
    for start in range(0, first.low.size, step):
        rows = slice(start, start + step)
        x, y, z = (a[rows, None] - b for a, b in zip(one.centre.T, two.centre.T, strict=True))
        xx, yy, zz, xy = (a[rows, None] + b for a, b in zip(one.moments, two.moments, strict=True))
        square = x * x + y * y + z * z
        apart = np.sqrt(square) / np.maximum(one.diameter[rows, None], two.diameter)
        square = 1.0 / np.where(square > 0.0, square, 1.0)
        quadratic = (xx * x + 2.0 * xy * y) * x + yy * y * y + zz * z * z
        G[rows] = (1.0 + (3.0 * quadratic * square - (xx + yy + zz)) * square / 2.0) * np.sqrt(square)
        if symmetric:
            n = first.low.size
            apart[np.arange(start, start + len(apart))[:, None] > np.arange(second.low.size) % n] = np.inf
        kind = np.digitize(apart, (_NEAR_PRISMS, _FAR_PRISMS))
        pairs.append([np.add(np.nonzero(kind == each), [[start], [0]]) for each in range(len(ways))])
    for means, each in zip(ways, zip(*pairs, strict=True), strict=True):
        index = np.concatenate(each, axis=1)
        for k in range(0, index.shape[1], _PAIRS):
            i, j = index[:, k : k + _PAIRS]
            G[i, j] = means(first, second, (i, j))
    if symmetric:  # part by part (n, n)
        parts = np.swapaxes(G.reshape(len(G), -1, len(G)), 0, 1)
        G = np.swapaxes(np.triu(parts) + np.swapaxes(np.triu(parts, 1), 1, 2), 0, 1).reshape(G.shape)
    return G


def prism_seconds(first: Prisms, second: Prisms, points: int = FEW) -> float:
    """Return about what `prism_means` takes [s], by some of the first."""
    step = math.ceil(first.low.size / 64)
    one, two = _shape(first.some(slice(None, None, step))), _shape(second)
    apart = np.linalg.norm(one.centre[:, None] - two.centre, axis=-1) / np.maximum(one.diameter[:, None], two.diameter)
    times = (_TIMES[0] * points**2, *_TIMES[1:])
    return step * float(np.choose(np.digitize(apart, (_NEAR_PRISMS, _FAR_PRISMS)), times).sum())


def _near(count: int, first: Prisms, second: Prisms, index: tuple[Integers, Integers]) -> Array:
    """Return the mean over Gauss points of the smaller base of what the larger does, exact through both, by pairs.

    Sheets of two cells share their W, each at its distance.
    """
    i, j = index
    (one, own), (two, other) = (_places(each.corners.reshape(-1, 8), 0) for each in (first, second))
    (z, face), (level, opposite) = (_places(np.stack([each.low, each.high])) for each in (first, second))
    heights, table = _places(np.abs(z[:, None] - level))
    height = table[face[:, None, i], opposite[:, j]]
    keys, place = _places((own[i] * len(two) + other[j]) * heights.size + height)
    (pair, h), W = np.divmod(keys, heights.size), np.empty(keys.size)
    for k in range(0, keys.size, _BLOCK):
        block = slice(k, k + _BLOCK)
        a, b = (each.reshape(-1, 4, 2) for each in (one[pair[block] // len(two)], two[pair[block] % len(two)]))
        size = signed_area(a), signed_area(b)
        swap = (size[0] > size[1])[:, None, None]
        outer, inner = np.where(swap, b, a), np.where(swap, a, b)
        points, weights = gauss_points(Prisms(outer, 0.0 * size[0], 0.0 * size[0]), count, through=1)
        each = [base_potential(point, inner, heights[h[block]]) for point in np.moveaxis(points[..., :2], 1, 0)]
        W[block] = np.einsum("kn,nk->n", each, weights) / np.maximum(*size)
    through = (first.high - first.low)[i] * (second.high - second.low)[j]
    return np.asarray(np.einsum("ab,abn->n", [[-1.0, 1.0], [1.0, -1.0]], W[place]) / through)


def _places(values: Any, axis: int | None = None) -> tuple[Any, Integers]:
    """Return what is different in an array, and which of it stands where."""
    found, place = np.unique(values, axis=axis, return_inverse=True)
    return found, place.reshape(values.shape[: None if axis is None else 1])


def _middle(first: Prisms, second: Prisms, index: tuple[Integers, Integers]) -> Array:
    """Return the mean over Gauss points of both prisms, by pairs."""
    (p, u), (q, v) = (gauss_points(prisms, 3, through=1) for prisms in (first, second))
    tall, total = [(prisms.high - prisms.low) ** 2 / 24.0 for prisms in (first, second)], np.empty(len(index[0]))
    for k in range(0, total.size, _BLOCK // 8):
        some = slice(k, k + _BLOCK // 8)
        i, j = index[0][some], index[1][some]
        x, y, z = (p[i, :, None, c] - q[j, None, :, c] for c in range(3))
        square = 1.0 / (x * x + y * y + z * z)
        moment = (tall[0][i] + tall[1][j])[:, None, None]
        each = np.sqrt(square) * (1.0 + moment * square * (3.0 * z * z * square - 1.0))
        total[some] = ((u[i, None] @ each)[:, 0] * v[j]).sum(axis=1)
    return total


def base_potential(point: Array, corners: Array, h: Array) -> Array:
    """Return W of polygons (n, k, 2), counter-clockwise, at points (n, 2) at heights h (n,) off them [m^3]."""
    a, h = corners - point[:, None], h[:, None]
    b = np.roll(a, -1, axis=1)
    side = b - a
    length = np.hypot(side[..., 0], side[..., 1])
    t = side / np.where(length > 0.0, length, 1.0)[..., None]
    d = a[..., 0] * t[..., 1] - a[..., 1] * t[..., 0]
    sa = a[..., 0] * t[..., 0] + a[..., 1] * t[..., 1]
    sb = sa + length
    square, flat = np.maximum(a[..., 0] ** 2 + a[..., 1] ** 2, np.finfo(float).tiny), d * d
    ra = np.sqrt(square + h * h)
    rise = np.log((h + ra) / np.sqrt(square))
    rb = np.roll(ra, -1, axis=1)
    total = ra + rb
    log = np.log((total + length) / np.maximum(total - length, _ROUNDING * total))
    turn = np.arctan2(h * np.abs(d) * (sb * ra - sa * rb), flat * ra * rb + h * h * sa * sb)
    plane = np.arctan2(length * np.abs(d), flat + sa * sb)
    ends = h * (sb * np.roll(rise, -1, axis=1) - sa * rise) / 2.0 - (sb * rb - sa * ra) / 6.0
    W = d * (ends + (3.0 * h * h - flat) / 6.0 * log)
    return np.asarray((W + np.sign(d) * h * ((h * h - 3.0 * flat) * turn - h * h * plane) / 6.0).sum(axis=1))


@dataclass(frozen=True)
class _Shape:
    """Centres (n, 3), second central moments (4, n) along x, y, z and of x y, and diameters (n,) of prisms."""

    centre: Array
    moments: Array
    diameter: Array


def _shape(prisms: Prisms) -> _Shape:
    """Return the far field's moments of prisms."""
    points, weights = gauss_points(prisms, 3)
    centre = np.einsum("mpd,mp->md", points, weights)
    offset = points - centre[:, None, :]
    products = (offset[..., i] * offset[..., j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1)))
    moments = np.stack([(product * weights).sum(axis=1) for product in products])
    spans = prisms.corners.max(1) - prisms.corners.min(1)
    height = prisms.high - prisms.low
    return _Shape(centre, moments, np.sqrt((spans**2).sum(1) + height**2))
