"""Mean of 1/r between right prisms of any polygon: the inductance kernel of the target in three dimensions.

Two bodies that carry uniform currents J, J' have the mutual energy

    mu0 / (4 pi)  (integral J) . (integral J')  G,      G = < 1 / |r - r'| >   [1/m],

the mean over both volumes (of boxes: `boxes`): near, the potential of a homogeneous polyhedron in closed form, over the
other's Gauss points; far apart the second moments, ``1/R + (1/2) M : grad grad (1/R)``; between, Gauss points of both
along the plate, and their second moments m, m' through it, ``1/r + (m + m')/2 d^2/dz^2 (1/r)``.

Source: R. A. Werner and D. J. Scheeres, Celest. Mech. Dyn. Astron. 65 (1997) 313. Errors by 3 x 3 x 2 points: 2e-3 in
the mean and 2e-2 at worst where thin prisms touch, some 3e-4 of L and 3e-3 of R of discs many skin depths thick, which
no finer division shows; by 5 x 5 x 4, 2e-5 and 2e-4. All near pairs take as many: errors of neighbours cancel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from sits_mech.quantities import Array, Mask
from sits_mech.scene.outlines import signed_area

_NEAR_PRISMS, _FAR_PRISMS = 1.2, 2.5  # where prisms stop being near, and start being far, in largest diameters
_PAIRS = 1_000_000  # held at once
_TIMES = 1.7e-6, 8e-6, 1.4e-7  # s of processor time that a point of a near pair takes, a pair between, a far one
FEW, MANY = (3, 2), (5, 4)
"""Gauss points of a near prism: along each of its sides, and through it."""


@dataclass(frozen=True)
class Prisms:
    """Right prisms along z."""

    corners: Array  # (n, 4, 2) base, counter-clockwise; a triangle repeats its last corner [m]
    low: Array  # (n,) z of the lower face [m]
    high: Array  # (n,) of the upper [m]

    def some(self, index: Any) -> Prisms:
        """Return some of them."""
        return Prisms(self.corners[index], self.low[index], self.high[index])


def prism_means(
    first: Prisms, second: Prisms, *, points: tuple[int, int] = FEW, symmetric: bool = False
) -> Array:
    """Return G between all prisms of two sets, shape (n, m) [1/m]; of symmetric parts (n, n) half is worked out."""
    one, two = _shape(first), _shape(second)
    G = np.empty((first.low.size, second.low.size))
    step = max(1, _PAIRS // second.low.size)
    for start in range(0, first.low.size, step):
        rows = slice(start, start + step)
        x, y, z = (a[rows, None] - b for a, b in zip(one.centre.T, two.centre.T, strict=True))
        M = one.moments[rows, None] + two.moments
        square = x * x + y * y + z * z
        apart = np.sqrt(square) / np.maximum(one.diameter[rows, None], two.diameter)
        square = np.where(square > 0.0, square, 1.0)
        quadratic = M[..., 0, 0] * x * x + 2.0 * M[..., 0, 1] * x * y + M[..., 1, 1] * y * y + M[..., 2, 2] * z * z
        trace = M[..., 0, 0] + M[..., 1, 1] + M[..., 2, 2]
        G[rows] = (1.0 + (3.0 * quadratic / square - trace) / (2.0 * square)) / np.sqrt(square)
        if symmetric:
            n = first.low.size
            apart[np.arange(start, start + len(apart))[:, None] > np.arange(second.low.size) % n] = np.inf
        near, far = apart < _NEAR_PRISMS, apart >= _FAR_PRISMS
        for choice, means in ((near, partial(_near, points)), (~near & ~far, _middle)):
            i, j = np.nonzero(choice)
            G[start + i, j] = means(first.some(start + i), second.some(j))
    if symmetric:  # part by part (n, n)
        parts = np.swapaxes(G.reshape(len(G), -1, len(G)), 0, 1)
        G = np.swapaxes(np.triu(parts) + np.swapaxes(np.triu(parts, 1), 1, 2), 0, 1).reshape(G.shape)
    return G


def prism_seconds(first: Prisms, second: Prisms, points: tuple[int, int] = FEW) -> float:
    """Return about what `prism_means` takes [s], by some of the first."""
    step = math.ceil(first.low.size / 64)
    one, two = _shape(first.some(slice(None, None, step))), _shape(second)
    apart = np.linalg.norm(one.centre[:, None] - two.centre, axis=-1) / np.maximum(one.diameter[:, None], two.diameter)
    times = (_TIMES[0] * points[0] ** 2 * points[1], *_TIMES[1:])
    return step * float(np.choose(np.digitize(apart, (_NEAR_PRISMS, _FAR_PRISMS)), times).sum())


def _near(count: tuple[int, int], first: Prisms, second: Prisms) -> Array:
    """Return the mean over Gauss points of the smaller prism of the larger's potential, pair by pair."""
    size = [signed_area(prisms.corners) * (prisms.high - prisms.low) for prisms in (first, second)]
    swap = size[0] > size[1]
    outer, inner = _chosen(swap, second, first), _chosen(swap, first, second)
    points, weights = gauss_points(outer, count[0], through=count[1])
    value = np.zeros(swap.size)
    for point, weight in zip(np.moveaxis(points, 1, 0), np.moveaxis(weights, 1, 0), strict=True):
        value += weight * prism_potential(point, inner.corners, inner.low, inner.high)
    return value / np.maximum(*size)


def _chosen(yes: Mask, first: Prisms, second: Prisms) -> Prisms:
    """Return the first's prisms where `yes`, the second's elsewhere."""
    corners = np.where(yes[:, None, None], first.corners, second.corners)
    return Prisms(corners, np.where(yes, first.low, second.low), np.where(yes, first.high, second.high))


def _middle(first: Prisms, second: Prisms) -> Array:
    """Return the mean over Gauss points of both prisms, pair by pair."""
    (p, u), (q, v) = (gauss_points(prisms, 3, through=1) for prisms in (first, second))
    moment = ((first.high - first.low) ** 2 + (second.high - second.low) ** 2)[:, None] / 24.0
    total = np.zeros(first.low.size)
    for k, point in enumerate(np.moveaxis(p, 1, 0)):
        x, y, z = (q[..., i] - point[:, i, None] for i in range(3))
        square = x * x + y * y + z * z
        total += u[:, k] * (v / np.sqrt(square) * (1.0 + moment * (3.0 * z * z / square - 1.0) / square)).sum(1)
    return total


def prism_potential(point: Array, corners: Array, low: Array, high: Array) -> Array:
    """Return the integral of 1/r over right prisms, one point (n, 3) to each, shape (n,) [m^2].

    `corners` (n, k, 2) of the bases run counter-clockwise, `low` and `high` (n,) are z of the faces [m].
    """
    a = corners - point[:, None, :2]
    b = np.roll(a, -1, axis=1)
    side = b - a
    length = np.hypot(side[..., 0], side[..., 1])
    t = side / np.where(length > 0.0, length, 1.0)[..., None]
    d = a[..., 0] * t[..., 1] - a[..., 1] * t[..., 0]
    sa, sb = (end[..., 0] * t[..., 0] + end[..., 1] * t[..., 1] for end in (a, b))
    square_a, square_b = (end[..., 0] ** 2 + end[..., 1] ** 2 for end in (a, b))
    top, bottom = (high - point[:, 2])[:, None], (low - point[:, 2])[:, None]
    total = np.zeros(d.shape)
    distances = []
    for z, sign in ((top, 1.0), (bottom, -1.0)):
        ra, rb = np.sqrt(square_a + z * z), np.sqrt(square_b + z * z)
        turn = _arctan(sb * z, d, rb) - _arctan(sa * z, d, ra)
        plane = np.sign(d) * (np.arctan2(sb, np.abs(d)) - np.arctan2(sa, np.abs(d)))
        total += sign * (d * z * _edge_log(length, ra + rb) + (z * z - d * d) * turn / 2 - z * np.abs(z) * plane / 2)
        distances.append((ra, rb))
    (ra, rb), (qa, qb) = distances
    total += d / 2 * (sb * _edge_log(top - bottom, rb + qb) - sa * _edge_log(top - bottom, ra + qa))
    return np.asarray(total.sum(-1))


def _arctan(numerator: Array, d: Array, r: Array) -> Array:
    """Return arctan(numerator / (d r)), of d's sign where d vanishes."""
    return np.sign(d) * np.arctan2(numerator, np.abs(d) * r)


def _edge_log(length: Array, sum_of_distances: Array) -> Array:
    """Return the integral of 1/r along an edge, bounded on the edge itself (where its factor vanishes)."""
    ratio = length / np.maximum(sum_of_distances, 1e-300)
    return 2.0 * np.arctanh(np.minimum(ratio, 1.0 - 1e-15))


def gauss_points(prisms: Prisms, n: int, across: int = 0, through: int = 2) -> tuple[Array, Array]:
    """Return Gauss points of each prism (z fastest) and their weights (sum 1): shapes (m, p, 3), (m, p).

    There are n along its sides, or along the second one as many as `across`, if that is given.
    """
    (s, ws), (t, wt), (v, wv) = map(np.polynomial.legendre.leggauss, (n, across or n, through))
    u, w = (g.ravel() for g in np.meshgrid((1 + s) / 2, (1 + t) / 2, indexing="ij"))
    c = prisms.corners
    blend = np.stack([(1 - u) * (1 - w), u * (1 - w), u * w, (1 - u) * w])
    plan = np.einsum("kp,mkd->mpd", blend, c)
    du = np.einsum("p,md->mpd", 1 - w, c[:, 1] - c[:, 0]) + np.einsum("p,md->mpd", w, c[:, 2] - c[:, 3])
    dw = np.einsum("p,md->mpd", 1 - u, c[:, 3] - c[:, 0]) + np.einsum("p,md->mpd", u, c[:, 2] - c[:, 1])
    jacobian = (du[..., 0] * dw[..., 1] - du[..., 1] * dw[..., 0]) * np.outer(ws, wt).ravel()
    weight = jacobian / jacobian.sum(1, keepdims=True)
    middle, half = (prisms.low + prisms.high) / 2, (prisms.high - prisms.low) / 2
    z = middle[:, None] + half[:, None] * v
    m, p = weight.shape
    points = np.concatenate([np.repeat(plan, through, axis=1), np.tile(z, (1, p))[..., None]], axis=2)
    return points, np.repeat(weight, through, axis=1) * np.tile(wv / 2, (m, p))


@dataclass(frozen=True)
class _Shape:
    """Centres (n, 3), second central moments (n, 3, 3) and diameters (n,) of prisms."""

    centre: Array
    moments: Array
    diameter: Array


def _shape(prisms: Prisms) -> _Shape:
    """Return the far field's moments of prisms."""
    points, weights = gauss_points(prisms, 3)
    centre = np.einsum("mpd,mp->md", points, weights)
    offset = points - centre[:, None, :]
    moments = np.einsum("mpi,mpj,mp->mij", offset, offset, weights)
    spans = prisms.corners.max(1) - prisms.corners.min(1)
    height = prisms.high - prisms.low
    return _Shape(centre, moments, np.sqrt((spans**2).sum(1) + height**2))
