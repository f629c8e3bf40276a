"""Refine a mesh so that answers on it can be carried over: every cell into 2^d, parents known.

The corners of the new cells are the nodes of the quadratic element on the old ones: corners, middles of edges, and of a
brick those of faces and inside. A new cell is the image of the whole reference cell under

    xi_parent = A xi + b,

one of a few maps: the halves of a square or brick, the corners of a tetrahedron and the four tetrahedra about the
shortest diagonal of the octahedron between them (which keeps their shape). Curved cells stay exactly where they are:
their map is quadratic on the new cells, too. Groups of faces are carried along. New cells stand in the order of their
parents, as many for each.

Source: J. Bey, Computing 55 (1995) 355, regular refinement of tetrahedra; S. Zhang, Houston J. Math. 21 (1995) 541,
the shortest diagonal. Lengths in any unit.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from skfem import Mesh, MeshHex, MeshHex2, MeshQuad, MeshQuad2, MeshTet, MeshTet2
from skfem.assembly import Dofs
from skfem.element import Element, ElementHex1, ElementHex2, ElementQuad1, ElementQuad2, ElementTetP1, ElementTetP2

from sits_mech.quantities import Array, Integers

_ELEMENTS: dict[type[Mesh], tuple[type[Mesh], Element, Element]] = {
    MeshTet: (MeshTet, ElementTetP1(), ElementTetP2()), MeshTet2: (MeshTet, ElementTetP1(), ElementTetP2()),
    MeshHex: (MeshHex, ElementHex1(), ElementHex2()), MeshHex2: (MeshHex, ElementHex1(), ElementHex2()),
    MeshQuad: (MeshQuad, ElementQuad1(), ElementQuad2()), MeshQuad2: (MeshQuad, ElementQuad1(), ElementQuad2()),
}
"""Straight mesh, linear and quadratic element of each kind of mesh."""

_DIAGONALS = ((0, 1), (2, 3)), ((0, 2), (1, 3)), ((0, 3), (1, 2))
"""Edges of a tetrahedron at whose middles each inner diagonal ends."""


@dataclass(frozen=True, eq=False)
class Refinement:
    """A refined mesh, and where each of its cells lies in the mesh that it was made of."""

    mesh: Mesh  # of the same kind, with the same groups in `boundaries`
    parents: Integers  # (f,) cell of the first mesh in which each cell lies
    kinds: Integers  # (f,) which of `maps` each cell has
    maps: Array  # (k, d, d + 1) (A, b) of xi_parent = A xi + b

    def within(self, points: Array) -> Array:
        """Return where points of the reference cell, shape (n, d), lie in the parent by kind, shape (k, n, d)."""
        return points @ self.maps[:, :, :-1].swapaxes(1, 2) + self.maps[:, None, :, -1]


def refined(mesh: Mesh, times: int) -> Refinement:
    """Return a mesh with its cells, straight or curved, divided `times` times into 2^d each; ValueError for others."""
    if type(mesh) not in _ELEMENTS:
        raise ValueError(f"mesh: must be one of {', '.join(kind.__name__ for kind in _ELEMENTS)}; got {type(mesh)}")
    d, count = mesh.dim(), mesh.t.shape[1]
    none = np.zeros(count, dtype=np.int64)
    found = Refinement(mesh, np.arange(count), none, np.eye(d, d + 1)[None])
    for _ in range(times):
        once = _halved(found.mesh)
        kinds = found.kinds[once.parents] * len(once.maps) + once.kinds
        kept, kinds = np.unique(kinds, return_inverse=True)
        outer, inner = found.maps[kept // len(once.maps)], once.maps[kept % len(once.maps)]
        maps = outer[:, :, :-1] @ inner
        maps[:, :, -1] += outer[:, :, -1]
        found = Refinement(once.mesh, found.parents[once.parents], kinds.ravel(), maps)
    return found


def quadratic_points(mesh: Mesh) -> tuple[Array, Integers]:
    """Return the nodes of the quadratic element on a mesh, shape (n, d), and those of each cell, shape (e, k)."""
    _, linear, quadratic = _ELEMENTS[type(mesh)]
    cells = np.asarray(Dofs(mesh, quadratic).element_dofs.T, dtype=np.int64)
    if mesh.doflocs.shape[1] > mesh.nvertices:  # curved: its own nodes
        return np.ascontiguousarray(mesh.doflocs.T), cells
    points = np.empty((cells.max() + 1, mesh.dim()))
    points[cells] = shape_values(linear, quadratic.doflocs) @ mesh.p.T[mesh.t.T]
    return points, cells


def shape_values(element: Element, points: Array) -> Array:
    """Return the shape functions of an element, shape (n, k), at points of its reference cell, shape (n, d)."""
    return np.stack([element.lbasis(points.T, i)[0] * np.ones(len(points)) for i in range(len(element.doflocs))], 1)


def _halved(mesh: Mesh) -> Refinement:
    """Divide once."""
    plain, linear, quadratic = _ELEMENTS[type(mesh)]
    points, nodes = quadratic_points(mesh)
    halves = [0.5 * (linear.doflocs + shift) for shift in product((0.0, 1.0), repeat=linear.doflocs.shape[1])]
    children = _tetrahedra() if plain is MeshTet else np.stack(halves)
    local = np.argmin(np.abs(children[:, :, None] - quadratic.doflocs).sum(axis=-1), axis=-1)
    every = np.arange(len(nodes))
    kinds = _by_diagonal(points[nodes]) if plain is MeshTet else np.tile(np.arange(len(children)), (len(nodes), 1))
    parents, kinds = np.repeat(every, kinds.shape[1]), kinds.ravel()
    cells = nodes[parents[:, None], local[kinds]]
    at = np.column_stack([linear.doflocs, np.ones(len(linear.doflocs))])
    maps = np.linalg.lstsq(at, np.moveaxis(children, 0, 1).reshape(len(at), -1), rcond=None)[0]
    maps = np.moveaxis(maps.reshape(mesh.dim() + 1, len(children), mesh.dim()), 0, -1)
    fine = plain(np.ascontiguousarray(points.T), np.ascontiguousarray(cells.T))
    found = Refinement(fine, parents, kinds, maps)
    groups = _carried(mesh, fine, nodes, parents) if mesh.boundaries else None
    if plain is not type(mesh):
        fine = _curved(type(mesh), found, points[nodes])
    return Refinement(fine if groups is None else fine.with_boundaries(groups), parents, kinds, maps)


def _curved(kind: type[Mesh], found: Refinement, coarse: Array) -> Mesh:
    """Put the nodes of a refined mesh where the quadratic map of their parents, shape (e, k, d), has them."""
    quadratic = _ELEMENTS[kind][2]
    fine = kind.from_mesh(found.mesh)
    values = np.stack([shape_values(quadratic, points) for points in found.within(quadratic.doflocs)])
    places = fine.doflocs.copy()
    nodes = Dofs(fine, quadratic).element_dofs.T
    places[:, nodes] = np.moveaxis(values[found.kinds] @ coarse[found.parents], -1, 0)
    return kind(places, fine.t)


def _carried(mesh: Mesh, fine: Mesh, nodes: Integers, parents: Integers) -> dict[str, Integers]:
    """Return facets of a refined mesh in each group: all corners on one facet of its parent that is in the group."""
    _, linear, quadratic = _ELEMENTS[type(mesh)]
    values = shape_values(linear, quadratic.doflocs)
    parent = parents[fine.f2t[0]]
    holder = np.full(fine.facets.shape[1], -1, dtype=np.int64)
    for number, corners in enumerate(quadratic.refdom.facets):
        local = np.flatnonzero(values[:, list(corners)].sum(axis=1) > 1.0 - 1e-9)
        on = nodes[parent][:, local]
        inside = np.all(np.any(fine.facets.T[:, :, None] == on[:, None, :], axis=2), axis=1)
        holder[inside] = mesh.t2f[number, parent[inside]]
    return {name: np.flatnonzero(np.isin(holder, own)) for name, own in mesh.boundaries.items()}


def _tetrahedra() -> Array:
    """Return corners of a tetrahedron's pieces, shape (16, 4, 3): four at its corners, four about each diagonal."""
    corners = np.vstack([np.zeros(3), np.eye(3)])
    pieces = [0.5 * (corners + corner) for corner in corners]
    for (a, b), (c, d) in _DIAGONALS:
        ends = [corners[list(edge)].mean(axis=0) for edge in ((a, b), (c, d))]
        around = [corners[sorted(edge)].mean(axis=0) for edge in ((a, c), (b, c), (b, d), (a, d))]
        for one, other in zip(around, [*around[1:], around[0]], strict=True):
            piece = np.stack([*ends, one, other])
            turned = np.linalg.det(piece[1:] - piece[0]) < 0.0
            pieces.append(piece[[1, 0, 2, 3]] if turned else piece)
    return np.stack(pieces)


def _by_diagonal(places: Array) -> Integers:
    """Return pieces of each tetrahedron (e, 8), of its quadratic element's nodes: by its shortest diagonal."""
    corners, nodes = np.vstack([np.zeros(3), np.eye(3)]), ElementTetP2().doflocs
    middle = {
        edge: int(np.argmin(np.abs(nodes - corners[list(edge)].mean(axis=0)).sum(axis=1)))
        for diagonal in _DIAGONALS for edge in diagonal
    }
    lengths = [np.linalg.norm(places[:, middle[a]] - places[:, middle[b]], axis=1) for a, b in _DIAGONALS]
    best = np.argmin(np.round(np.stack(lengths) / np.max(lengths, axis=0), 9), axis=0)
    return np.column_stack([np.tile(np.arange(4), (len(places), 1)), 4 + 4 * best[:, None] + np.arange(4)])
