"""Bring the cells of a mesh into the order and the kinds that the solver takes.

The middles of edges of quadratic cells are put in order by their places, so that no convention of numbering matters.
Bricks of 20 nodes get those of 27: in the middle of a face -1/4 of its corners and 1/2 of its edges' middles, in the
brick's -1/4 and 1/4 (serendipity). Prisms are cut into three tetrahedra each, by diagonals through the node of least
number of each side, on which two cells agree (Dompierre, Labbe, Vallet, Camarero, 1999).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sits_mech.geometry.meshing.abaqus import CORNERS
from sits_mech.quantities import Array, Integers

EDGES = {
    4: ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    8: ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
}
"""Edges of tetrahedra and hexahedra, in the order of their middles in VTK."""
_SIDES = ((0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7))  # of a brick of 27 nodes
_PRISM = ((0, 1, 2, 3, 4, 5), (1, 2, 0, 4, 5, 3), (2, 0, 1, 5, 3, 4), (3, 5, 4, 0, 2, 1), (4, 3, 5, 1, 0, 2),
          (5, 4, 3, 2, 1, 0))  # corners of a prism from each one on
_HALVES = (((0, 1, 2, 5), (0, 1, 5, 4), (0, 4, 5, 3)), ((0, 1, 2, 4), (0, 4, 2, 5), (0, 4, 5, 3)))


class Named(NamedTuple):
    """Nodes (n, 3) [m], cells by their kind, corners of the faces of each name, and nodes of each name of a set."""

    points: Array
    cells: dict[str, Integers]
    faces: dict[str, list[Integers]]
    nodes: dict[str, Integers]


def ordered(given: Named) -> Named:
    """Return cells as the solver takes them: middles in order, bricks of 27 nodes for 20, tetrahedra for prisms."""
    points, cells, faces = given.points, dict(given.cells), given.faces
    for kind in ("tetra10", "hexahedron20", "hexahedron27"):
        if kind in cells and points.shape[1] == 3 and cells[kind].max(initial=-1) < len(points):
            cells[kind] = _in_order(points, cells[kind], CORNERS[kind])
    if "hexahedron20" in cells and "hexahedron27" not in cells:
        points, cells["hexahedron27"] = _filled(points, cells.pop("hexahedron20"))
    if "wedge" in cells and not {"tetra", "hexahedron"} & {*cells}:
        cells["tetra"] = _cut(cells.pop("wedge"))
        faces = {name: _halved(own) for name, own in faces.items()}
    return Named(points, cells, faces, given.nodes)


def _in_order(points: Array, cells: Integers, count: int) -> Integers:
    """Put the middles of edges, of faces and of cells in VTK's order, by that of most cells."""
    at, middles = points[cells], cells.shape[1] - count
    parts = [*EDGES[count], *(_SIDES if middles == 19 else ()), *([tuple(range(8))] if middles == 19 else [])]
    goal = np.stack([at[:, list(part)].mean(axis=1) for part in parts], axis=1)
    near = np.argmin(np.linalg.norm(goal[:, :, None] - at[:, None, count:], axis=-1), axis=-1)
    ways, times = np.unique(near, axis=0, return_counts=True)
    best = ways[np.argmax(times)]
    if len({*best.tolist()}) < middles:  # too curved to tell: as it stands
        return cells
    return np.hstack([cells[:, :count], cells[:, count:][:, best]])


def _filled(points: Array, cells: Integers) -> tuple[Array, Integers]:
    """Add the middles of faces and bricks to bricks of 20 nodes."""
    local = np.array(_SIDES)
    edge = {frozenset(pair): 8 + k for k, pair in enumerate(EDGES[8])}
    between = np.array([[edge[frozenset((side[k], side[k - 3]))] for k in range(4)] for side in _SIDES])
    at = points[cells]
    faces = -0.25 * at[:, local].sum(axis=2) + 0.5 * at[:, between].sum(axis=2)
    keys = np.sort(cells[:, local].reshape(-1, 4), axis=1)
    _, first, number = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    inner = -0.25 * at[:, :8].sum(axis=1) + 0.25 * at[:, 8:].sum(axis=1)
    start = len(points)
    new = start + number.reshape(len(cells), 6)
    middle = start + len(first) + np.arange(len(cells))[:, None]
    return np.vstack([points, faces.reshape(-1, 3)[first], inner]), np.hstack([cells, new, middle])


def _cut(prisms: Integers) -> Integers:
    """Return three tetrahedra for each prism."""
    turned = np.take_along_axis(prisms, np.array(_PRISM)[np.argmin(prisms, axis=1)], axis=1)
    way = (turned[:, [1, 5]].min(axis=1) >= turned[:, [2, 4]].min(axis=1)).astype(int)
    return np.take_along_axis(turned[:, None], np.array(_HALVES)[way], axis=2).reshape(-1, 4)


def _halved(blocks: list[Integers]) -> list[Integers]:
    """Return triangles, quadrilaterals cut through their node of least number."""
    found = [faces for faces in blocks if faces.shape[1] == 3]
    for faces in (faces for faces in blocks if faces.shape[1] != 3):
        from_least = (np.argmin(faces, axis=1)[:, None] + np.arange(4)) % 4
        a, b, c, d = np.take_along_axis(faces, from_least, axis=1).T
        found += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    return found
