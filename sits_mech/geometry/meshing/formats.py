"""Read a solid with named faces from the mesh files of other programs: cells as ours are numbered, names as kept.

Names come as physical groups of gmsh, families of .med, sets of cells, sets of nodes (a face is in one where all its
corners are), surfaces of elements (.inp, .e), or as whole numbers of cells with a legend: an array of the cells that is
called by the name (.vtu, .vtk: not zero inside), or by all of them, "ground-target-free" with the number of each, as
meshio's `cell_sets_to_data` writes it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np

from sits_mech.geometry.meshing.abaqus import CORNERS, Key, faces_named, read_deck
from sits_mech.geometry.meshing.cells import Named, ordered
from sits_mech.geometry.meshing.soundness import FACES
from sits_mech.quantities import Integers
from sits_mech.scene.parts.outlines import read_mesh
from sits_mech.units import SceneError

_EXODUS = {4: (1, 2, 3, 0), 8: (2, 3, 4, 5, 0, 1)}  # our numbers of its sides


def read_named(path: str | Path) -> Named:
    """Read a file: .inp of Abaqus, else what meshio reads. SceneError with one line: what it must be, or what to do."""
    if Path(path).suffix.lower() == ".inp":
        return ordered(_abaqus(path))
    given = read_mesh(path)
    cells = {str(kind): np.asarray(own, dtype=np.int64) for kind, own in given.cells_dict.items()}
    nodes = {name: np.asarray(own, dtype=np.int64) for name, own in given.point_sets.items()}
    nodes |= _tagged(getattr(given, "point_tags", None), given.point_data.get("point_tags"))
    flat = {kind: own[:, : 3 if kind.startswith("triangle") else 4]
            for kind, own in cells.items() if kind.startswith(("triangle", "quad"))}
    faces = {name: [flat[kind][own] for kind, own in parts.items() if kind in flat]
             for name, parts in _groups(given).items()}
    if Path(path).suffix.lower() in (".e", ".exo", ".ex2"):
        faces |= _side_sets(path, cells)
    points = np.asarray(given.points, dtype=float)
    return ordered(Named(points, cells, {name: own for name, own in faces.items() if own}, nodes))


def _abaqus(path: str | Path) -> Named:
    """Read an input file of Abaqus."""
    deck = read_deck(path)
    number = {key: k for k, key in enumerate(deck.nodes)}
    cells = defaultdict[str, list[list[int]]](list)
    try:
        for (part, _), (kind, own) in deck.cells.items():
            cells[kind].append([number[part, node] for node in own])
        faces = {name: _numbered(own, number) for name, own in faces_named(deck).items()}
    except KeyError as error:
        raise SceneError(f"{path}: elements must be of nodes of the file; got node {error.args[0][1]}") from None
    nodes = {name: np.array(sorted(number[key] for key in own & number.keys())) for name, own in deck.nsets.items()}
    points = np.array([*deck.nodes.values()]) if number else np.zeros((0, 3))
    return Named(points, {kind: np.array(own) for kind, own in cells.items()}, faces, nodes)


def _numbered(faces: list[list[Key]], number: Mapping[Key, int]) -> list[Integers]:
    """Return faces by the numbers of their corners: triangles, and quadrilaterals."""
    rows = [[number[key] for key in face] for face in faces]
    return [np.array(some) for size in (3, 4) if (some := [row for row in rows if len(row) == size])]


def _groups(mesh: Any) -> dict[str, dict[str, Integers]]:
    """Return numbers of the cells of each kind that belong to a name."""
    named = {name: own for name, own in mesh.cell_sets_dict.items() if not name.startswith("gmsh:")}
    marks = mesh.cell_data_dict.get("gmsh:physical", {})
    for name, (tag, _) in mesh.field_data.items():
        named.setdefault(name, {kind: np.flatnonzero(values == tag) for kind, values in marks.items()})
    families = mesh.cell_data_dict.get("cell_tags", {})
    for kind, values in families.items():
        for name, own in _tagged(getattr(mesh, "cell_tags", None), values).items():
            named.setdefault(name, {})[kind] = own
    for title, each in mesh.cell_data_dict.items():
        for kind, values in each.items():
            for name, own in _legend(title.split("-"), values, marks.get(kind)).items():
                named.setdefault(name, {}).setdefault(kind, own)
    return named


def _legend(names: list[str], values: Any, marks: Any) -> dict[str, Integers]:
    """Return the cells of each name by whole numbers, or where not zero for one name alone.

    A cell has one number: where gmsh's own sets hide a name, it is that of the others of the same physical number.
    """
    values = np.asarray(values)
    if ":" in names[0] or names == ["cell_tags"] or values.ndim != 1 or np.any(values != np.round(values)):
        return {}
    if len(names) == 1:
        return {names[0]: np.flatnonzero(values)}
    values = _unhidden(values, [k for k, name in enumerate(names) if ":" in name], marks)
    return {name: np.flatnonzero(values == k) for k, name in enumerate(names) if ":" not in name}


def _unhidden(values: Integers, hiding: list[int], marks: Any) -> Integers:
    """Return whole numbers of cells with those of gmsh's own sets replaced where the physical number tells others."""
    hidden, found = np.isin(values, hiding), values.copy()
    for mark in np.unique(np.asarray(marks)[hidden]) if marks is not None else ():
        own = np.asarray(marks) == mark
        if len(shown := np.unique(values[own & ~hidden])) == 1:
            found[own & hidden] = shown[0]
    return found


def _tagged(names: Mapping[int, list[str]] | None, values: Any) -> dict[str, Integers]:
    """Return the places of each name by families, numbers that each stand for names (.med)."""
    found: dict[str, list[Integers]] = {}
    for tag, own in (names or {}).items() if values is not None else ():
        for name in own:
            found.setdefault(name, []).append(np.flatnonzero(np.asarray(values) == tag))
    return {name: np.concatenate(parts) for name, parts in found.items()}


def _side_sets(path: str | Path, cells: dict[str, Integers]) -> dict[str, list[Integers]]:
    """Return the faces of the side sets of an Exodus file, which meshio leaves out."""
    from netCDF4 import Dataset, chartostring

    solid = next((own for kind, own in cells.items() if CORNERS.get(kind, 0) in _EXODUS), None)
    if solid is None:
        return {}
    with Dataset(str(path)) as file:
        stored = file.variables
        sides = {name: np.ma.filled(stored[name][:]) for name in stored if name.startswith(("elem_ss", "side_ss"))}
        raw: Any = chartostring(stored["ss_names"][:]) if "ss_names" in stored else []
        blocks = (stored[f"connect{k + 1}"] for k in range(len(file.dimensions["num_el_blk"])))
        before = takewhile(lambda block: str(block.elem_type)[:3].upper() not in ("TET", "HEX"), blocks)
        first = sum(block.shape[0] for block in before)
    count = 4 if solid.shape[1] in (4, 10) else 8
    local = np.array(FACES[count])[list(_EXODUS[count])]
    found = {}
    for k in range(len(sides) // 2):
        cell, side = sides[f"elem_ss{k + 1}"] - 1 - first, sides[f"side_ss{k + 1}"] - 1
        inside = (cell >= 0) & (cell < len(solid)) & (side < len(local))
        name = str(raw[k]).strip() if k < len(raw) else f"{k + 1}"
        found[name] = [np.take_along_axis(solid[cell[inside]], local[side[inside]], axis=1)]
    return found
