"""Distance of a point from a moving quadratic face, with two derivatives.

A face is an edge of a section or a facet of a solid, y(xi) = sum N_i(xi) v_i with its nodes v_i and one or two
parameters xi in [0, 1], or in the triangle xi_1 + xi_2 <= 1; its shape functions are polynomials of at most the second
power in each of them. The point y nearest to x lies inside, on a side or in a corner: as many directions y_a = dy/dxi_a
are free there, on a side the one along it. With r = x - y, the gap g = +-|r| is positive before the face and negative
behind it, and

    y_a . r = 0,    dg = n . db,    db = dx - sum N_i dv_i,    n = r/g,
    d2g = (db . Q db)/g - t_a (m^-1 b A^-1)_ab t_b - 2 t_a A^ab s_b - g s_a A^ab s_b,
    t_a = y_a . db,    s_a = n . sum N_i,a dv_i,    m_ab = y_a . y_b,    b_ab = n . y_ab,    A = m - g b,
    Q = 1 - n n^T - y_a m^ab y_b^T,

Q = 0 inside the face, whose n is its normal. Nothing is frozen: gap, slope and curvature are those of the distance
itself, which no rigid motion changes. The distance from a surface of such faces is the least of theirs.

Lengths in thicknesses. Source: P. Wriggers, Computational Contact Mechanics (2006), chapters 4 and 9; the second
derivative as that of a smallest value, by the implicit function theorem.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.faces.facets import behind, upright, weighted
from sits_mech.quantities import Array, Integers

_STEPS = 12  # of Newton's method for the nearest point; it ends where it stays
_STAYS = 1e-13  # of a face's parameters
_BEYOND = 0.5  # of a face's parameters, by which its polynomials are followed beyond it
_ORDERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))  # of derivatives by two parameters
_SIDES = {
    1: np.zeros((0, 2, 2)),
    3: np.array([[(0.0, 0.0), (1.0, 0.0)], [(1.0, 0.0), (-1.0, 1.0)], [(0.0, 1.0), (0.0, -1.0)]]),
    4: np.array([[(0, 0), (1, 0)], [(1, 0), (0, 1)], [(1, 1), (-1, 0)], [(0, 1), (0, -1)]], dtype=float),
}  # where each side begins and its way


class Gap(NamedTuple):
    """Gaps of n points with derivatives by the displacements of k nodes."""

    value: Array  # (n,)
    slope: Array  # (n, k d)
    curvature: Array  # (n, k d, k d)


class Nearest(NamedTuple):
    """Nearest points of n faces."""

    place: Array  # (n, p), parameters
    ways: Array  # (n, p, p), free directions of the parameters, zero beyond these
    free: Integers  # (n,), number of free directions

    def some(self, which: Integers) -> Nearest:
        """Return some of them."""
        return Nearest(self.place[which], self.ways[which], self.free[which])


class Jet(NamedTuple):
    """Shape functions of n faces at a place."""

    value: Array  # (n, k)
    slope: Array  # (n, p, k)
    curvature: Array  # (n, p, p, k)


def shapes(form: Array, place: Array) -> Jet:
    """Return shape functions at parameters (n, p), from coefficients (n, k, 3) or (n, k, 3, 3) by powers."""
    one, zero = np.ones(len(place)), np.zeros(len(place))
    own = [np.stack([[one, s, s**2], [zero, one, 2.0 * s], [zero, zero, 2.0 * one]]).T for s in place.T]
    n, k = form.shape[:2]
    if place.shape[1] == 1:
        found = (form @ own[0]).swapaxes(1, 2)
        return Jet(found[:, 0], found[:, 1:2], found[:, 2:, None])
    powers = np.stack([own[0][..., i, None] * own[1][:, None, :, j] for i, j in _ORDERS], axis=-1)
    found = (form.reshape(n, k, 9) @ powers.reshape(n, 9, len(_ORDERS))).swapaxes(1, 2)
    return Jet(found[:, 0], found[:, 1:3], found[:, [[3, 4], [4, 5]]])


def nearest_on(x: Array, form: Array, nodes: Array, start: Array, sides: int) -> Nearest:
    """Return the points nearest to x (n, d) on faces of nodes (n, k, d), from start parameters (n, p).

    `form` as in `shapes`; sides: 1 for edges of a section, 3 for triangles, 4 for quadrilaterals.
    """
    n, p = start.shape
    if sides == 1:
        s = _along(x, form, nodes, np.zeros((n, 1)), np.ones((n, 1)), start[:, 0])
        inside = (s > 0.0) & (s < 1.0)
        return Nearest(s[:, None], np.where(inside, 1.0, 0.0)[:, None, None], inside.astype(np.int64))
    place, ways, count = _inside(x, form, nodes, start), np.tile(np.eye(p), (n, 1, 1)), np.full(n, p, dtype=np.int64)
    beyond = np.any(place < 0.0, axis=1) | np.any(place > 1.0, axis=1)
    out = np.flatnonzero(beyond | ((sides == 3) & (place.sum(axis=1) > 1.0)))
    best = np.full(len(out), np.inf)
    for origin, way in _SIDES[sides]:
        begin, along = np.tile(origin, (len(out), 1)), np.tile(way, (len(out), 1))
        s = _along(x[out], form[out], nodes[out], begin, along, (start[out] - origin) @ way / (way @ way))
        there = origin + s[:, None] * way
        away = np.linalg.norm(x[out] - weighted(shapes(form[out], there).value, nodes[out]), axis=1)
        nearer = away < best
        inside = (s > 0.0) & (s < 1.0)
        own = np.zeros((len(out), p, p))
        own[inside, :, 0] = way
        place[out[nearer]], ways[out[nearer]], count[out[nearer]] = there[nearer], own[nearer], 1 * inside[nearer]
        best = np.minimum(best, away)
    return Nearest(place, ways, count)


def before(x: Array, found: Jet, nodes: Array) -> tuple[Array, Array, Array]:
    """Return distances from points of faces, heights along the outward normals, and these: (n,), (n,), (n, d)."""
    n = upright(found.slope @ nodes)
    return *behind(x, nodes, found.value, n), n


def gaps(x: Array, found: Jet, near: Nearest, nodes: Array, shape: Array) -> Gap:
    """Return gaps with two derivatives, by displacements of the point's nodes, then of the face's.

    `found`: shape functions of the nearest faces at `near`; `nodes`: of these faces, (n, k, d); `shape` (n, j): shares
    of other nodes in x (n, d).
    """
    n, d = x.shape
    size = d * (shape.shape[1] + nodes.shape[1])
    value, slope, curvature = np.zeros(n), np.zeros((n, size)), np.zeros((n, size, size))
    for count in range(d):
        on = np.flatnonzero(near.free == count)
        own, ways = Jet(*(each[on] for each in found)), near.ways[on][:, :, :count]
        value[on], slope[on], curvature[on] = _gaps(x[on], own, ways, nodes[on], shape[on])
    return Gap(value, slope, curvature)


def _gaps(x: Array, found: Jet, ways: Array, nodes: Array, shape: Array) -> Gap:
    """Return gaps where the same number c of directions is free, ways (n, p, c)."""
    (n, _, c), d, k = ways.shape, x.shape[1], shape.shape[1] + nodes.shape[1]
    away, front, normal = before(x, found, nodes)
    g = front if c == d - 1 else np.where(front < 0.0, -1.0, 1.0) * np.maximum(away, 1e-300)
    out = normal if c == d - 1 else (x - weighted(found.value, nodes)) / g[:, None]
    turned = np.zeros((n, c, k))
    turned[:, :, shape.shape[1] :] = ways.swapaxes(1, 2) @ found.slope
    Y = turned[:, :, shape.shape[1] :] @ nodes
    by_out = (found.curvature @ (nodes @ out[:, :, None])[:, None])[..., 0]
    bent = ways.swapaxes(1, 2) @ by_out @ ways
    m = Y @ Y.swapaxes(1, 2)
    inverse, A = np.linalg.inv(m), _inverse(m - g[:, None, None] * bent)
    share = np.concatenate([shape, -found.value], axis=1)

    def along(nodes: Array, way: Array) -> Array:
        both = nodes[..., None] * way[..., None, :]
        return both.reshape(*both.shape[:-2], k * d)

    t, s = along(share[:, None, :], Y), along(turned, out[:, None, :])
    mixed = t.swapaxes(1, 2) @ A @ s
    curvature = -mixed - mixed.swapaxes(1, 2) - g[:, None, None] * (s.swapaxes(1, 2) @ A @ s)
    curvature -= t.swapaxes(1, 2) @ (inverse @ bent @ A) @ t
    if c < d - 1:
        Q = np.eye(d) - out[:, :, None] * out[:, None, :] - Y.swapaxes(1, 2) @ inverse @ Y
        across = share[:, :, None, None, None] * share[:, None, None, :, None] * Q[:, None, :, None, :]
        curvature += across.reshape(n, k * d, k * d) / g[:, None, None]
    return Gap(g, along(share, out), curvature)


def _inside(x: Array, form: Array, nodes: Array, start: Array) -> Array:
    """Return the parameters of least distance from faces, extended a little beyond their sides."""
    place, on = start.copy(), np.arange(len(x))
    for _ in range(_STEPS):
        found = shapes(form[on], place[on])
        r = x[on] - weighted(found.value, nodes[on])
        Y = found.slope @ nodes[on]
        m = Y @ Y.swapaxes(1, 2)
        A = m - (found.curvature @ (nodes[on] @ r[:, :, None])[:, None])[..., 0]
        good = (np.linalg.det(A) > 0.1 * np.linalg.det(m)) & (np.trace(A, axis1=1, axis2=2) > 0.0)
        step = (_inverse(np.where(good[:, None, None], A, m)) @ (Y @ r[:, :, None]))[..., 0]
        after = np.clip(place[on] + step, -_BEYOND, 1.0 + _BEYOND)
        goes = np.abs(after - place[on]).max(axis=1) > _STAYS
        place[on] = after
        on = on[goes]
        if not on.size:
            break
    return place


def _along(x: Array, form: Array, nodes: Array, begin: Array, way: Array, start: Array) -> Array:
    """Return the place s in [0, 1] nearest to x on curves begin + s way of faces."""
    s = np.clip(start, 0.0, 1.0)
    for _ in range(_STEPS):
        found = shapes(form, begin + s[:, None] * way)
        r = x - weighted(found.value, nodes)
        Y = ((way[:, None] @ found.slope) @ nodes)[:, 0]
        bent = np.einsum("np,npqk,nq->nk", way, found.curvature, way)
        m = np.maximum((Y * Y).sum(axis=1), 1e-300)
        A = m - (r * weighted(bent, nodes)).sum(axis=1)
        after = np.clip(s + (Y * r).sum(axis=1) / np.where(A > 0.1 * m, A, m), 0.0, 1.0)
        stays = np.abs(after - s).max(initial=0.0) < _STAYS
        s = after
        if stays:
            break
    return s


def _inverse(matrices: Array) -> Array:
    """Invert matrices, singular ones after a small shift."""
    size = np.abs(matrices).max(axis=(1, 2), initial=1e-300)
    bad = np.abs(np.linalg.det(matrices)) < 1e-12 * size ** matrices.shape[1]
    return np.linalg.inv(matrices + (1e-6 * bad * size)[:, None, None] * np.eye(matrices.shape[1]))
