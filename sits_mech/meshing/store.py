"""How does a mesh of the user's own come in? A file that meshio reads, with named groups of faces, lengths in metres.

Tetrahedra or hexahedra, straight or quadratic. What cannot be solved is refused with one line: no mesh, no cells in
space, a group that is missing, a cell that is flat or inside out.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray
from skfem import Mesh
from skfem.io.meshio import from_meshio

from sits_mech.quantities import Array
from sits_mech.scene.outlines import read_mesh

CELLS = {"tetra": 4, "tetra10": 4, "hexahedron": 8, "hexahedron27": 8}
"""Cells that can be read, with their corners."""

_FLAT = 1e-6  # smallest determinant of the map onto a cell, over the cube of the cell's size


def read_solid(path: str | Path, groups: Sequence[str]) -> Mesh:
    """Return the solid in a mesh file, its named groups of faces in `boundaries`.

    Parameters
    ----------
    path : str or Path
        Any format that meshio reads and that has names.
    groups : sequence of str
        Names that must be there.

    Raises
    ------
    ValueError
        One line: file, what it must hold, what came.
    """
    given = read_mesh(path)
    kinds = [kind for kind in given.cells_dict if kind in CELLS]
    if len(kinds) != 1:
        came = ", ".join(given.cells_dict) or "none"
        raise ValueError(f"{path}: must hold cells of one kind of {', '.join(CELLS)}; got {came}")
    cells, used = given.cells_dict[kinds[0]], np.unique(given.cells_dict[kinds[0]])
    number = np.full(len(given.points), -1)
    number[used] = np.arange(used.size)
    faces = {kind: block for kind, block in given.cells_dict.items() if kind.startswith(("triangle", "quad"))}
    _check_cells(str(path), np.asarray(given.points, dtype=float), cells[:, : CELLS[kinds[0]]])
    mesh = from_meshio(meshio.Mesh(given.points[used], {kinds[0]: number[cells]}))
    _check_curved(str(path), mesh)
    named = {name: _facets(mesh, [number[faces[kind][own]] for kind, own in own_faces.items() if kind in faces])
             for name, own_faces in _groups(given).items()}  # fmt: skip
    for name in groups:
        if name not in named or not len(named[name]):
            came = ", ".join(sorted(named)) or "none"
            raise ValueError(f"{path}: must name groups of faces {', '.join(groups)}; got {came}")
    return mesh.with_boundaries(named)


def _groups(mesh: meshio.Mesh) -> dict[str, dict[str, NDArray[np.int64]]]:
    """Numbers of the cells of each kind that belong to a name."""
    named = {name: own for name, own in mesh.cell_sets_dict.items() if not name.startswith("gmsh:")}
    marks = mesh.cell_data_dict.get("gmsh:physical", {})
    for name, (tag, _) in mesh.field_data.items():
        own = {kind: np.flatnonzero(values == tag) for kind, values in marks.items()}
        named.setdefault(name, {kind: numbers for kind, numbers in own.items() if numbers.size})
    return named


def _facets(mesh: Mesh, faces: list[NDArray[np.int64]]) -> NDArray[np.int64]:
    """Numbers of the mesh's facets that have the corners of given faces."""
    count = len(mesh.facets)
    place = {tuple(corners): number for number, corners in enumerate(np.sort(mesh.facets.T, axis=1).tolist())}
    wanted = [tuple(sorted(face[:count])) for block in faces for face in block.tolist()]
    return np.array([place[corners] for corners in wanted if corners in place], dtype=np.int64)


def _check_cells(name: str, points: Array, cells: NDArray[np.int64]) -> None:
    """Refuse cells that are flat, or turned another way than the others."""
    ways = _CORNERS[cells.shape[1]]
    at = points[cells]
    edges = np.stack([at[:, b] - at[:, [a]] for a, b in ways], axis=1)  # cell, corner, edge, component
    turn = np.linalg.det(edges)
    size = np.max(np.linalg.norm(edges, axis=-1), axis=(1, 2)) ** 3
    bad = np.any(turn * np.sign(np.median(turn)) < _FLAT * size[:, None], axis=1)
    _refuse(name, np.flatnonzero(bad), len(cells))


def _check_curved(name: str, mesh: Mesh) -> None:
    """Refuse curved cells that fold."""
    points = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]) if len(mesh.t) == 4 else np.full((3, 1), 0.5)
    determinant = mesh.mapping().detDF(np.hstack([points, np.full((3, 1), 0.25)]))
    bad = np.any(determinant * np.sign(determinant[:, -1:]) <= 0.0, axis=1)
    _refuse(name, np.flatnonzero(bad), len(bad))


def _refuse(name: str, bad: NDArray[np.int64], count: int) -> None:
    """Say which cells are bad, if any."""
    if bad.size:
        raise ValueError(
            f"{name}: cells must not be flat or inside out; {bad.size} of {count} are, the first is cell {bad[0]}"
        )


_CORNERS = {
    4: [(0, [1, 2, 3])],
    8: [(a, [b, d, u]) for a, b, d, u in (
        (0, 1, 3, 4), (1, 2, 0, 5), (2, 3, 1, 6), (3, 0, 2, 7), (4, 7, 5, 0), (5, 4, 6, 1), (6, 5, 7, 2), (7, 6, 4, 3)
    )],
}  # fmt: skip
"""Corners of a cell with the ends of the three edges that leave each, as a right-handed frame."""
