"""Read a user's mesh from a file (formats.py), with named groups of faces, lengths in metres.

Tetrahedra or hexahedra, straight or quadratic; nodes in any order. What cannot be solved is refused with one line: no
mesh, cells of two kinds, a group that is missing or names what is no face, a cell that is flat or inside out, and what
is no watertight solid (soundness.py). Duplicated nodes are merged on request.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import meshio
import numpy as np
from skfem import Mesh
from skfem.io.meshio import from_meshio

from sits_mech.geometry.meshing.abaqus import CORNERS
from sits_mech.geometry.meshing.cells import Named
from sits_mech.geometry.meshing.formats import read_named
from sits_mech.geometry.meshing.soundness import check_sound, merged_corners, place
from sits_mech.quantities import Array, Integers

CELLS = ("tetra", "tetra10", "hexahedron", "hexahedron27")
"""Cells that can be read."""
MADE = ("hexahedron20", "wedge")
"""Cells that others are made of."""
NAMING = (".msh", ".inp", ".med", ".vtu", ".vtk", ".e")
"""Suffixes of files that keep names of faces."""
_LOWER = ("vertex", "line", "triangle", "quad", "polygon")

_FLAT = 1e-6  # smallest determinant of the map onto a cell, over the cube of the cell's size


class ReadSolid(NamedTuple):
    """A solid with its named groups of outer faces in `boundaries`, and how many nodes were merged."""

    mesh: Mesh
    merged: int


def read_solid(path: str | Path, groups: Sequence[str], *, weld: bool = False) -> ReadSolid:
    """Return the solid in a mesh file, which must have the named groups.

    `weld` merges duplicated nodes; faces that they held apart leave their groups. ValueError with one line: file, what
    it must hold, what came, and where.
    """
    name, given = str(path), read_named(path)
    kind = _only_kind(name, given)
    cells, all_points = given.cells[kind], given.points
    _check_numbers(name, cells, given)
    count = CORNERS[kind]
    ends = np.unique(cells[:, :count])
    used = np.concatenate([ends, np.setdiff1d(cells, ends)])  # corners first, as skfem takes them
    if all_points.shape[1] != 3 or not np.all(np.isfinite(all_points[used])):
        raise ValueError(f"{name}: nodes must have three finite coordinates; some have not")
    number = np.full(len(all_points), -1)
    number[used] = np.arange(used.size)
    points, cells = all_points[used], number[cells]
    _check_cells(name, points, cells[:, :count])
    merged = 0
    if weld:
        number, points, cells, merged = _welded(number, points, cells, count)
    corners, own = np.unique(cells[:, :count], return_inverse=True)
    check_sound(name, points[corners], own.reshape(len(cells), -1))
    mesh = from_meshio(meshio.Mesh(points, {kind: cells}))
    _check_curved(name, mesh)
    named = _groups(name, mesh, given, number)
    for group in groups:
        if not len(named.get(group, ())):
            raise ValueError(f"{name}: must name groups of faces {', '.join(groups)}; {_came(named, given, name)}")
    return ReadSolid(mesh.with_boundaries({group: own for group, own in named.items() if len(own)}), merged)


def _check_numbers(name: str, cells: Integers, given: Named) -> None:
    """Refuse cells, faces and sets of nodes that the file has not."""
    parts = (cells, *(block for blocks in given.faces.values() for block in blocks), *given.nodes.values())
    if any(part.size and (part.min() < 0 or part.max() >= len(given.points)) for part in parts):
        raise ValueError(f"{name}: cells and sets must be of nodes of the file; some are not")


def _groups(name: str, mesh: Mesh, given: Named, number: Integers) -> dict[str, Integers]:
    """Return the outer facets of each name: of faces, else of nodes; `number`: the file's nodes in the mesh."""
    named = {
        group: _facets(f"{name}: the group {group}", mesh, blocks, given.points, number)
        for group, blocks in given.faces.items()
    }
    by_nodes = _of_nodes(mesh, {group: number[own] for group, own in given.nodes.items()})
    return named | {group: facets for group, facets in by_nodes.items() if not len(named.get(group, ()))}


def _came(named: Mapping[str, Integers], given: Named, name: str) -> str:
    """Return in words what names a file has, and where it has none in which formats they are kept."""
    some = [f"{group} (no faces)" if not len(own) else group for group, own in sorted(named.items())]
    if some:
        return f"got {', '.join(some)}"
    return f"got none: names are kept in {', '.join(NAMING)}"


def _of_nodes(mesh: Mesh, sets: Mapping[str, Integers]) -> dict[str, Integers]:
    """Return the outer facets whose corners are all in a set of nodes; of two such sets the smaller one has it."""
    outer, taken, found = mesh.boundary_facets(), np.zeros(len(mesh.facets.T), dtype=bool), dict[str, Integers]()
    for name, own in sorted(sets.items(), key=lambda item: len(item[1])):
        inside = np.isin(mesh.facets[:, outer], own[own >= 0]).all(axis=0)
        facets = outer[inside & ~taken[outer]]
        taken[facets] = len(facets) < len(outer)
        found[name] = np.asarray(facets)
    return found


def _only_kind(name: str, given: Named) -> str:
    """Return the one kind of cells in space that a mesh has."""
    solid = {kind: own[0] for kind, own in given.cells.items() if not kind.startswith(_LOWER) and len(own)}
    first = str(next(iter(solid), "none"))
    if len(solid) == 1 and first in CELLS:
        return first
    some = (
        f"{len(given.cells[kind])} {kind}, the first about {place(given.points[at[at < len(given.points)]])}"
        for kind, at in solid.items()
    )
    came = "; ".join(some) or ", ".join(given.cells) or "none"
    raise ValueError(f"{name}: must hold cells of one kind of {', '.join((*CELLS, *MADE))}; got {came}")


def _welded(number: Integers, points: Array, cells: Integers, corners: int) -> tuple[Integers, Array, Integers, int]:
    """Merge duplicated nodes: new numbers of the file's nodes, nodes, cells, and how many nodes fewer."""
    ends, own = np.unique(cells[:, :corners], return_inverse=True)
    to = np.arange(len(points))
    to[ends] = ends[merged_corners(points[ends], own.reshape(len(cells), -1))]
    kept, new = np.unique(to[cells], return_inverse=True)
    place_of = np.full(len(points), -1)
    place_of[kept] = np.arange(kept.size)
    number = np.where(number >= 0, place_of[to[number]], -1)
    return number, points[kept], new.reshape(cells.shape), len(points) - kept.size


def _facets(what: str, mesh: Mesh, blocks: list[Integers], points: Array, number: Integers) -> Integers:
    """Return numbers of the mesh's outer facets that are the given faces of the file, `number` its nodes in the mesh.

    A group that holds faces of cells holds no others; one that holds none belongs to something else in the file.
    """
    count = len(mesh.facets)
    known = {tuple(corners): k for k, corners in enumerate(np.sort(mesh.facets.T, axis=1).tolist())}
    faces = [face for block in blocks for face in block if len(face) == count]
    found = [known.get(tuple(sorted(number[face].tolist())), -1) for face in faces]
    lost = [face for face, facet in zip(faces, found, strict=True) if facet < 0]
    if 0 < len(lost) < len(faces):
        raise ValueError(
            f"{what} must hold faces of cells; {len(lost)} of {len(faces)} are none, the first about "
            f"{place(points[lost[0]])}"
        )
    facets = np.unique(np.array(found, dtype=np.int64))
    facets = facets[facets >= 0]
    return np.asarray(facets[mesh.f2t[1, facets] < 0])


def _check_cells(name: str, points: Array, cells: Integers) -> None:
    """Refuse cells that are flat, or turned another way than the others."""
    ways = _CORNERS[cells.shape[1]]
    at = points[cells]
    edges = np.stack([at[:, b] - at[:, [a]] for a, b in ways], axis=1)  # cell, corner, edge, component
    turn = np.linalg.det(edges)
    size = np.max(np.linalg.norm(edges, axis=-1), axis=(1, 2)) ** 3
    bad = np.any(turn * np.sign(np.median(turn)) < _FLAT * size[:, None], axis=1)
    _refuse(name, np.flatnonzero(bad), points[cells])


def _check_curved(name: str, mesh: Mesh) -> None:
    """Refuse curved cells that fold."""
    points = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]) if len(mesh.t) == 4 else np.full((3, 1), 0.5)
    determinant = mesh.mapping().detDF(np.hstack([points, np.full((3, 1), 0.25)]))
    bad = np.any(determinant * np.sign(determinant[:, -1:]) <= 0.0, axis=1)
    _refuse(name, np.flatnonzero(bad), mesh.p.T[mesh.t.T])


def _refuse(name: str, bad: Integers, corners: Array) -> None:
    """Say which cells are bad, if any, and where the first is, from their corners, shape (e, c, 3)."""
    if bad.size:
        raise ValueError(
            f"{name}: cells must not be flat or inside out; {bad.size} of {len(corners)} are, the first is cell "
            f"{bad[0]} about {place(corners[bad[0]])}"
        )


_CORNERS = {
    4: [(0, [1, 2, 3])],
    8: [(a, [b, d, u]) for a, b, d, u in (
        (0, 1, 3, 4), (1, 2, 0, 5), (2, 3, 1, 6), (3, 0, 2, 7), (4, 7, 5, 0), (5, 4, 6, 1), (6, 5, 7, 2), (7, 6, 4, 3)
    )],
}
"""Corners of a cell with the ends of the three edges that leave each, as a right-handed frame."""
