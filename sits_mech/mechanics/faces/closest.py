"""Distance of a point from a flat facet.

A facet is a segment of a section or a triangle of a solid, its corners v_i in the order that turns its normal n
outwards. The point nearest to x on it is y = sum l_i v_i, the weights l_i >= 0 of sum one. Flat facets through the
nodes of quadratic faces say which of these a point is near, and about where (skin.py, curved.py).

Lengths in thicknesses. Source: P. Wriggers, Computational Contact Mechanics (2006), chapter 4.
"""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Array


def normals(corners: Array) -> Array:
    """Return the outward unit normals, shape (n, d), of facets of corners (n, d, d)."""
    way = corners[:, 1] - corners[:, 0]
    if corners.shape[1] == 2:
        across = np.stack([-way[:, 1], way[:, 0]], axis=1)
    else:
        across = np.cross(way, corners[:, 2] - corners[:, 0])
    return np.asarray(across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300))


def nearest(x: Array, corners: Array) -> Array:
    """Return the corner weights (n, d) of the points nearest to x (n, d) on facets of corners (n, d, d)."""
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
    """Return distances from facets, and heights of the points along the normals n (n, d), (n,) each."""
    r = x - _point(weights, corners)
    return np.linalg.norm(r, axis=1), (r * n).sum(axis=1)


def _point(weights: Array, corners: Array) -> Array:
    """Return the points of weights."""
    return np.asarray((weights[:, None, :] @ corners)[:, 0])


def _on_segment(x: Array, ends: Array) -> Array:
    """Return the weights of the nearest points of segments, ends (n, 2, d)."""
    way = ends[:, 1] - ends[:, 0]
    s = ((x - ends[:, 0]) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), 1e-300)
    s = np.clip(s, 0.0, 1.0)
    return np.stack([1.0 - s, s], axis=1)


def _in_plane(x: Array, corners: Array) -> Array:
    """Return the weights of the nearest points in the planes of triangles."""
    a, b, r = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], x - corners[:, 0]
    aa, ab, bb = (a * a).sum(axis=1), (a * b).sum(axis=1), (b * b).sum(axis=1)
    ra, rb = (r * a).sum(axis=1), (r * b).sum(axis=1)
    det = np.maximum(aa * bb - ab * ab, 1e-300)
    s, t = (bb * ra - ab * rb) / det, (aa * rb - ab * ra) / det
    return np.stack([1.0 - s - t, s, t], axis=1)
