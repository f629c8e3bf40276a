"""Check that a user's mesh is one watertight solid, before anything is solved; say where it is not; find nodes to weld.

A face belongs to one cell, on the surface, or to two that lie on its two sides. Faces of the surface that lie on each
other are a cut: cells there do not hold together, though nothing shows it. Nodes of two cells that are closer than
1/1000 of the shortest edge that ends in either are one place; where whole faces of the surface lie on each other so,
the nodes can be merged ("welded"). A node within a face of the surface that it is no corner of hangs there, and the
middle of a face within another face tells two surfaces that do not match; no merging of nodes joins these.

Faces are taken as flat, four-cornered ones as four triangles about their middle. Lengths [m], printed in mm.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from sits_mech.quantities import Array, Integers, Mask

FACES = {
    4: ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)),
    8: ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
}
"""Corners of the faces of tetrahedra and hexahedra, around each, in the order of VTK, which is that of Abaqus."""

_NEAR = 1e-3  # of the shortest edge: what is closer than that is one place


class CellFaces(NamedTuple):
    """Faces of the cells: corners around each (f, c), its cell (f,), its number (f,), how often each number occurs."""

    corners: Integers
    cell: Integers
    number: Integers
    times: Integers

    @property
    def outer(self) -> Mask:
        """Which faces belong to one cell."""
        return np.asarray(self.times[self.number] == 1)

    @property
    def shared(self) -> Integers:
        """Faces that belong to two cells, in pairs, shape (2, n)."""
        order = np.argsort(self.number, kind="stable")
        return np.asarray(order[self.times[self.number[order]] == 2].reshape(-1, 2).T)


def faces_of(cells: Integers) -> CellFaces:
    """Return the faces of cells, given by their corners, shape (e, 4) or (e, 8)."""
    local = np.array(FACES[cells.shape[1]])
    corners = cells[:, local].reshape(-1, local.shape[1])
    _, number, count = np.unique(np.sort(corners, axis=1), axis=0, return_inverse=True, return_counts=True)
    return CellFaces(corners, np.repeat(np.arange(len(cells)), len(local)), number.ravel(), count)


def merged_corners(points: Array, cells: Integers) -> Integers:
    """Return for each corner of the cells the first one that is at its place, itself where it is alone; shape (n,)."""
    surface = faces_of(cells)
    own = surface.corners[surface.outer]
    shortest = _shortest_edges(points, own)
    nodes = np.unique(own)
    pairs = cKDTree(points[nodes]).query_pairs(_NEAR * shortest[nodes].max(), output_type="ndarray")
    a, b = nodes[pairs].T
    near = np.linalg.norm(points[a] - points[b], axis=1) < _NEAR * np.minimum(shortest[a], shortest[b])
    graph = sparse.coo_matrix((np.ones(near.sum()), (a[near], b[near])), shape=(len(points), len(points)))
    _, group = connected_components(graph, directed=False)
    first = np.full(group.max() + 1, len(points))
    np.minimum.at(first, group, np.arange(len(points)))
    return first[group]


def check_sound(name: str, points: Array, cells: Integers) -> None:
    """Refuse a mesh that is no watertight solid: ValueError with one line, what is wrong, how often, and where first.

    `points` (n, 3) are corners of cells only [m]; none of the `cells` (e, 4) or (e, 8) is flat.
    """
    surface = faces_of(cells)
    _refuse(name, points[surface.corners[surface.times[surface.number] > 2]], "faces must belong to one cell or two",
            "belong to more")
    _refuse(name, points[surface.corners[_one_sided(points, cells, surface)]],
            "cells must lie on the two sides of the face that they share", "have both on one side")
    outer, same = surface.corners[surface.outer], merged_corners(points, cells)
    _, number, count = np.unique(np.sort(same[outer], axis=1), axis=0, return_inverse=True, return_counts=True)
    merged = np.count_nonzero(same != np.arange(len(same)))
    _refuse(name, points[outer[count[number.ravel()] > 1]], "must not be cut by duplicated nodes",
            f"of the surface lie on each other ({merged} nodes too many; elastomer.weld = true, or --weld, "
            "merges them)")
    _check_touching(name, points, outer, same)
    _check_hinges(name, points, cells, surface)


def connected_cells(count: int, pairs: Integers) -> Integers:
    """Return the piece that each of `count` cells belongs to, by the pairs that share a face, shape (2, k)."""
    graph = sparse.coo_matrix((np.ones(pairs.shape[1]), pairs), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1])


def place(points: Array) -> str:
    """Return the middle of points, shape (k, 3) [m], as one writes it."""
    x, y, z = 1e3 * points.mean(axis=0) + 0.0
    return f"({x:.4g}, {y:.4g}, {z:.4g}) mm"


def _refuse(name: str, bad: Array, rule: str, fault: str, what: str = "faces") -> None:
    """Say how many faces are bad and where the first is, from their corners, shape (f, c, 3); nothing if none is."""
    if len(bad):
        raise ValueError(f"{name}: {rule}; {len(bad)} {what} {fault}, the first about {place(bad[0])}")


def _shortest_edges(points: Array, faces: Integers) -> Array:
    """Return the shortest edge of any face that ends in each node, infinite where none does, shape (n,)."""
    lengths = np.linalg.norm(points[faces] - points[np.roll(faces, -1, axis=1)], axis=-1)
    found = np.full(len(points), np.inf)
    np.minimum.at(found, faces, lengths)
    np.minimum.at(found, np.roll(faces, -1, axis=1), lengths)
    return found


def _one_sided(points: Array, cells: Integers, surface: CellFaces) -> Integers:
    """Return one face of each pair that two cells on one side of it share."""
    first, second = surface.shared
    at = points[surface.corners[first]]
    normal = np.cross(at[:, 2] - at[:, 0], at[:, -1] - at[:, 1] if at.shape[1] == 4 else at[:, 1] - at[:, 0])
    middle = points[cells].mean(axis=1)
    heights = [((middle[surface.cell[each]] - at.mean(axis=1)) * normal).sum(axis=1) for each in (first, second)]
    return np.asarray(first[heights[0] * heights[1] >= 0.0])


def _check_touching(name: str, points: Array, faces: Integers, same: Integers) -> None:
    """Refuse nodes that hang within a face of the surface, and faces that lie on others."""
    shortest = _shortest_edges(points, faces)
    near = _NEAR * shortest[faces].min(axis=1)
    nodes = np.unique(faces)
    face, node = _within(points[faces], points[nodes], near)
    node = nodes[node]
    near_too = np.all(same[faces[face]] != same[node][:, None], axis=1)
    hanging = np.unique(node[near_too])
    _refuse(name, points[hanging][:, None], "nodes must be corners of every cell that they lie on",
            "hang in the middle of a face or edge", "nodes")
    face, other = _within(points[faces], points[faces].mean(axis=1), near)
    lying = np.unique(other[face != other])
    _refuse(name, points[faces[lying]], "must not be cut", "of the surface lie on others that do not match")


def _within(faces: Array, points: Array, near: Array) -> tuple[Integers, Integers]:
    """Return pairs of a face, corners (f, c, 3), and a point that is nearer to it than `near`, shape (f,)."""
    middle = faces.mean(axis=1)
    reach = np.linalg.norm(faces - middle[:, None], axis=-1).max(axis=1) + near
    found = cKDTree(points).query_ball_point(middle, reach)
    face = np.repeat(np.arange(len(faces)), [len(own) for own in found])
    point = np.concatenate([np.asarray(own, dtype=np.int64) for own in found])
    corners, after = faces[face], np.roll(faces[face], -1, axis=1)
    parts = range(faces.shape[1]) if faces.shape[1] == 4 else (0,)
    tips = middle[face] if faces.shape[1] == 4 else corners[:, 2]
    away = [_distance(points[point], np.stack([corners[:, k], after[:, k], tips], axis=1)) for k in parts]
    close = np.min(away, axis=0) < near[face]
    return face[close], point[close]


def _distance(points: Array, triangles: Array) -> Array:
    """Return the distance of points (k, 3) from triangles (k, 3, 3); infinite beside them by more than that."""
    a, b, c = triangles.swapaxes(0, 1)
    normal = np.cross(b - a, c - a)
    double = np.linalg.norm(normal, axis=1)
    double = np.where(double > 0.0, double, 1.0)
    height = np.abs(((points - a) * normal).sum(axis=1)) / double
    outward = np.zeros(len(points))
    for start, end in ((a, b), (b, c), (c, a)):
        across = np.cross(normal, end - start)
        size = np.linalg.norm(across, axis=1)
        inward = ((points - start) * across).sum(axis=1) / np.where(size > 0.0, size, 1.0)
        outward = np.maximum(outward, -inward)
    return np.asarray(np.maximum(height, outward))


def _check_hinges(name: str, points: Array, cells: Integers, surface: CellFaces) -> None:
    """Refuse pieces that hang together by an edge or a node only."""
    own = connected_cells(len(cells), surface.cell[surface.shared])
    low, high = np.full(len(points), len(cells)), np.full(len(points), -1)
    spread = np.repeat(own, cells.shape[1])
    np.minimum.at(low, cells.ravel(), spread)
    np.maximum.at(high, cells.ravel(), spread)
    shared = np.flatnonzero((high >= 0) & (low != high))
    _refuse(name, points[shared][:, None], "pieces must hold together by faces", "alone hold two together", "nodes")
