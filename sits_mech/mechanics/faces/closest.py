"""How far is a point from a flat facet that moves, and how does that change?

A facet is a segment of a section or a triangle of a solid, its corners v_i in the order that turns its normal n
outwards. The point nearest to x on it is y = sum l_i v_i, the weights l_i >= 0 of sum one; corners of weight zero play
no part: y lies inside the facet, on a side or in a corner. With r = x - y and Y_a = v_a - v_0 of the corners that
count, the gap g = +-|r| is positive before the facet, negative behind it, and

    Y_a . r = 0,    dg = n . db,    db = dx - sum l_i dv_i,    n = r/g,
    d2g = (db . Q db)/g - 2 t_a m^ab s_b - g s_a m^ab s_b,
    t_a = Y_a . db,    s_a = n . (dv_a - dv_0),    m_ab = Y_a . Y_b,    Q = 1 - n n^T - Y_a m^ab Y_b^T,

Q = 0 inside the facet, whose n is its normal. The distance from a surface of such facets is the least of theirs: behind
the surface its energy has ridges where the nearest facet changes, and no valleys, so that no state at rest is caught
between two facets.

Lengths in thicknesses. Source: P. Wriggers, Computational Contact Mechanics (2006), chapters 4 and 9; the second
derivative as that of a smallest value, by the implicit function theorem.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sits_mech.quantities import Array


class Gap(NamedTuple):
    """Gaps of n points: g (n,), its slope and curvature by the displacements of k nodes, (n, k d) and (n, k d, k d)."""

    value: Array
    slope: Array
    curvature: Array


def normals(corners: Array) -> Array:
    """Return the outward unit normals, shape (n, d), of facets of corners (n, d, d)."""
    way = corners[:, 1] - corners[:, 0]
    if corners.shape[1] == 2:
        across = np.stack([-way[:, 1], way[:, 0]], axis=1)
    else:
        across = np.cross(way, corners[:, 2] - corners[:, 0])
    return np.asarray(across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300))


def nearest(x: Array, corners: Array) -> Array:
    """Return the weights (n, d) of corners (n, d, d) in the points of facets that are nearest to x, shape (n, d)."""
    if corners.shape[1] == 2:
        return _on_segment(x, corners)
    weights = _in_plane(x, corners)
    outside = np.flatnonzero(np.any(weights <= 0.0, axis=1))
    best = np.full(len(outside), np.inf)
    for sides in ([0, 1], [1, 2], [2, 0]):
        own = np.zeros((len(outside), 3))
        own[:, sides] = _on_segment(x[outside], corners[outside][:, sides])
        away = np.linalg.norm(x[outside] - _point(own, corners[outside]), axis=1)
        weights[outside[away < best]] = own[away < best]
        best = np.minimum(best, away)
    return weights


def behind(x: Array, corners: Array, weights: Array, n: Array) -> tuple[Array, Array]:
    """Return distances from facets, and how far along their normals n (n, d) the points are before them, (n,) each."""
    r = x - _point(weights, corners)
    return np.linalg.norm(r, axis=1), (r * n).sum(axis=1)


def gaps(x: Array, corners: Array, weights: Array, shape: Array, places: Array) -> Gap:
    """Return gaps with two derivatives.

    Parameters
    ----------
    x : ndarray, shape (n, d)
        Points.
    corners : ndarray, shape (n, d, d)
        Of the facet that is nearest to each.
    weights : ndarray, shape (n, d)
        From `nearest`.
    shape : ndarray, shape (n, k)
        Share of each node in x; of the facet's nodes zero.
    places : ndarray, shape (n, d)
        Which of the k nodes the corners are.
    """
    n, d = x.shape
    k, every = shape.shape[1], np.arange(n)
    value, slope, curvature = np.zeros(n), np.zeros((n, k * d)), np.zeros((n, k * d, k * d))
    counted = np.count_nonzero(weights, axis=1)
    share = shape.copy()
    share[every[:, None], places] -= weights
    for count in range(1, d + 1):
        on = np.flatnonzero(counted == count)
        kept = np.argsort(weights[on] == 0.0, axis=1, kind="stable")[:, :count]
        own, at = np.take_along_axis(corners[on], kept[..., None], axis=1), np.take_along_axis(places[on], kept, axis=1)
        found = _gaps(x[on] - _point(weights[on], corners[on]), normals(corners[on]), own, share[on], at)
        value[on], slope[on], curvature[on] = found
    return Gap(value, slope, curvature)


def _gaps(r: Array, normal: Array, corners: Array, share: Array, places: Array) -> Gap:
    """Gaps by the corners that count, shape (n, c, d), all of weights above zero."""
    (n, c, d), k = corners.shape, share.shape[1]
    before, away = (r * normal).sum(axis=1), np.maximum(np.linalg.norm(r, axis=1), 1e-300)
    g = before if c == d else np.where(before < 0.0, -away, away)
    out = normal if c == d else r / g[:, None]
    Y = corners[:, 1:] - corners[:, :1]
    inverse = np.linalg.inv(Y @ Y.swapaxes(1, 2))
    turned = np.zeros((n, c - 1, k))  # share of each node in v_a - v_0
    every = np.arange(n)
    for a in range(1, c):
        turned[every, a - 1, places[:, a]] += 1.0
        turned[every, a - 1, places[:, 0]] -= 1.0

    def along(nodes: Array, way: Array) -> Array:
        both = nodes[..., None] * way[..., None, :]
        return np.asarray(both.reshape(*both.shape[:-2], k * d))

    t, s = along(share[:, None, :], Y), along(turned, out[:, None, :])
    mixed = t.swapaxes(1, 2) @ inverse @ s
    curvature = -mixed - mixed.swapaxes(1, 2) - g[:, None, None] * (s.swapaxes(1, 2) @ inverse @ s)
    if c < d:
        Q = np.eye(d) - out[:, :, None] * out[:, None, :] - Y.swapaxes(1, 2) @ inverse @ Y
        bent = share[:, :, None, None, None] * share[:, None, None, :, None] * Q[:, None, :, None, :]
        curvature += bent.reshape(n, k * d, k * d) / g[:, None, None]
    return Gap(g, along(share, out), curvature)


def _point(weights: Array, corners: Array) -> Array:
    """Points of some weights."""
    return np.asarray((weights[:, None, :] @ corners)[:, 0])


def _on_segment(x: Array, ends: Array) -> Array:
    """Weights of the nearest points of segments, ends (n, 2, d)."""
    way = ends[:, 1] - ends[:, 0]
    s = ((x - ends[:, 0]) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), 1e-300)
    s = np.clip(s, 0.0, 1.0)
    return np.stack([1.0 - s, s], axis=1)


def _in_plane(x: Array, corners: Array) -> Array:
    """Weights of the nearest points of the planes that triangles lie in."""
    a, b, r = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], x - corners[:, 0]
    aa, ab, bb = (a * a).sum(axis=1), (a * b).sum(axis=1), (b * b).sum(axis=1)
    ra, rb = (r * a).sum(axis=1), (r * b).sum(axis=1)
    det = np.maximum(aa * bb - ab * ab, 1e-300)
    s, t = (bb * ra - ab * rb) / det, (aa * rb - ab * ra) / det
    return np.stack([1.0 - s - t, s, t], axis=1)
