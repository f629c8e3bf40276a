"""Flat facets of free faces: distances from them, and whether they pass through one another (where no contact holds).

A section's faces are lines, held against each other segment by segment. The free faces of a solid's elements are cut
into triangles around their middle nodes. Of two triangles whose bounding balls meet, each side of one is held against
the other (T. Moeller, B. Trumbore, J. Graphics Tools 2 (1997) 21): a side that passes through it is a face in itself.
Elements' faces with a common node are not held against each other: where they are strongly curved, as at a bonded
corner, their triangles may cross and they not. Of half a pad, a face behind the plane of symmetry is in its image.

A convex pad is spared that where the symmetric part of F is positive definite throughout: of any two of its points

    (x(b) - x(a)) . (b - a)  =  int_0^1 (b - a) . F(a + s (b - a)) (b - a) ds  >  0,

so that no two come together. F is looked at in the quadrature points.

Distances. A facet is a segment of a section or a triangle of a solid, its corners v_i in the order that turns its
normal n outwards. The point nearest to x on it is y = sum l_i v_i, the weights l_i >= 0 of sum one. Flat facets through
the nodes of quadratic faces say which of these a point is near, and about where (skin.py, curved.py).

Lengths in thicknesses. Source: P. Wriggers, Computational Contact Mechanics (2006), chapter 4.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree
from skfem import Basis

from sits_mech.quantities import Array, Integers

_SEEN = 1e-6  # thicknesses behind the plane of symmetry that count, and shares of a triangle that do not
_BLOCK = 256  # triangles compared with those around them at once: slender ones have thousands


def skin(basis: Basis, facets: Integers) -> Integers:
    """Return the triangles, shape (faces, m, 3), of some faces of a mesh."""
    corners = basis.nodal_dofs[0][basis.mesh.facets[:, facets]]
    between = basis.edge_dofs[0][basis.mesh.f2e[:, facets]]
    ring = np.stack([corners, between], axis=1).reshape(-1, len(facets))
    middle = np.broadcast_to(basis.facet_dofs[0][facets], ring.shape)
    return np.stack([ring, np.roll(ring, -1, axis=0), middle], axis=-1).swapaxes(0, 1)


def is_monotone(F: Array) -> bool:
    """Whether no two points of a convex body can have come together; F of shape (e, q, 9)."""
    tensor = F.reshape(-1, 3, 3)
    twice = tensor + tensor.swapaxes(1, 2)
    first = twice[:, 0, 0]
    second = first * twice[:, 1, 1] - twice[:, 0, 1] ** 2
    return bool(np.all(first > 0.0) and np.all(second > 0.0) and np.all(np.linalg.det(twice) > 0.0))


def lines_cross(lines: list[Array]) -> bool:
    """Whether any two segments of some open lines, shapes (m, 2), cross, except neighbours."""
    start = np.concatenate([line[:-1] for line in lines])
    way = np.concatenate([np.diff(line, axis=0) for line in lines])
    number = np.concatenate([np.arange(len(line) - 1) + 10 * k * len(line) for k, line in enumerate(lines)])
    between = start[None, :, :] - start[:, None, :]

    def cross(a: Array, b: Array) -> Array:
        return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]

    det = cross(way[:, None, :], way[None, :, :])
    det = np.where(np.abs(det) > 1e-14, det, np.inf)
    s, t = cross(between, way[None, :, :]) / det, cross(between, way[:, None, :]) / det
    apart = np.abs(number[:, None] - number[None, :]) > 1
    return bool(np.any((s > 0.0) & (s < 1.0) & (t > 0.0) & (t < 1.0) & apart))


def triangles_cross(faces: Integers, place: Array, plane: float = -np.inf) -> bool:
    """Whether free faces, triangles (f, m, 3) from `skin`, pass through one another at nodes (n, 3).

    `plane`: y of the plane of symmetry of half a pad [thicknesses].
    """
    if np.any(place[faces, 1] < plane - _SEEN):
        return True
    corners, ring = place[faces.reshape(-1, 3)], np.repeat(faces[:, :, 0], faces.shape[1], axis=0)
    centre = corners.mean(axis=1)
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    slack = 4.0 * _SEEN * radius[:, None]
    low, high, tree = corners.min(axis=1) - slack, corners.max(axis=1) + slack, cKDTree(centre)
    for first in range(0, len(centre), _BLOCK):
        some = np.arange(first, min(first + _BLOCK, len(centre)))
        near = tree.query_ball_point(centre[some], 2.0 * radius[some], return_sorted=False)  # from the larger of a pair
        one, other = np.repeat(some, list(map(len, near))), np.concatenate(near).astype(int)
        meet = np.all((low[one] <= high[other]) & (low[other] <= high[one]), axis=1)
        one, other = one[meet], other[meet]
        apart = ~np.any(ring[one][:, :, None] == ring[other][:, None, :], axis=(1, 2))
        one, other = one[apart], other[apart]
        both = ((corners[one], corners[other]), (corners[other], corners[one]))
        if any(_passes(sides[:, k], sides[:, (k + 1) % 3], through) for sides, through in both for k in range(3)):
            return True
    return False


def _passes(begin: Array, end: Array, triangle: Array) -> bool:
    """Whether any segment, ends (n, 3), passes through its triangle (n, 3, 3) or its edge: meshes are symmetric."""
    way, u, v = end - begin, triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]
    across = np.cross(way, v)
    det = np.einsum("ni,ni->n", u, across)
    size = np.linalg.norm(u, axis=1) * np.linalg.norm(across, axis=1)
    parallel = np.abs(det) <= 1e-9 * size  # or in its plane
    det = np.where(parallel, 1.0, det)
    start = begin - triangle[:, 0]
    upright = np.cross(start, u)
    a = np.einsum("ni,ni->n", start, across) / det
    b = np.einsum("ni,ni->n", way, upright) / det
    s = np.einsum("ni,ni->n", v, upright) / det
    inside = (a > -_SEEN) & (b > -_SEEN) & (a + b < 1.0 + _SEEN) & (s > -_SEEN) & (s < 1.0 + _SEEN)
    return bool(np.any(inside & ~parallel))


def normals(corners: Array) -> Array:
    """Return the outward unit normals, shape (n, d), of facets of corners (n, d, d)."""
    return upright(corners[:, 1:] - corners[:, :1])


def upright(ways: Array) -> Array:
    """Return the unit normals, shape (n, d), of the directions (n, d - 1, d) of faces."""
    if ways.shape[1] == 1:
        across = np.stack([-ways[:, 0, 1], ways[:, 0, 0]], axis=1)
    else:
        across = np.cross(ways[:, 0], ways[:, 1])
    return np.asarray(across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300))


def nearest(x: Array, corners: Array) -> Array:
    """Return the corner weights (n, d) of the points nearest to x (n, d) on facets of corners (n, d, d)."""
    if corners.shape[1] == 2:
        return _on_segment(x, corners)
    a, b, r = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], x - corners[:, 0]
    aa, ab, bb = (a * a).sum(axis=1), (a * b).sum(axis=1), (b * b).sum(axis=1)
    ra, rb = (r * a).sum(axis=1), (r * b).sum(axis=1)
    det = np.maximum(aa * bb - ab * ab, 1e-300)
    s, t = (bb * ra - ab * rb) / det, (aa * rb - ab * ra) / det
    weights = np.stack([1.0 - s - t, s, t], axis=1)  # of the nearest points in the planes of triangles
    outside = np.flatnonzero(np.any(weights <= 0.0, axis=1))
    best = np.full(len(outside), np.inf)
    for sides in ([0, 1], [1, 2], [2, 0]):
        own = np.zeros((len(outside), 3))
        own[:, sides] = _on_segment(x[outside], corners[outside][:, sides])
        away = np.linalg.norm(x[outside] - weighted(own, corners[outside]), axis=1)
        weights[outside[away < best]] = own[away < best]
        best = np.minimum(best, away)
    return weights


def behind(x: Array, corners: Array, weights: Array, n: Array) -> tuple[Array, Array]:
    """Return distances from facets, and heights of the points along the normals n (n, d), (n,) each."""
    r = x - weighted(weights, corners)
    return np.linalg.norm(r, axis=1), (r * n).sum(axis=1)


def weighted(shares: Array, nodes: Array) -> Array:
    """Sum nodes (n, k, d) by their shares (n, k)."""
    return (shares[:, None, :] @ nodes)[:, 0]


def _on_segment(x: Array, ends: Array) -> Array:
    """Return the weights of the nearest points of segments, ends (n, 2, d)."""
    way = ends[:, 1] - ends[:, 0]
    s = ((x - ends[:, 0]) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), 1e-300)
    s = np.clip(s, 0.0, 1.0)
    return np.stack([1.0 - s, s], axis=1)
