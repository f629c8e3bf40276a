"""The pad as a body to solve, on a mesh of the user's own: domes, slots, pillars.

The mesh, in metres and in the pad's own place (x, y from the target's centre, ``z = 0`` on the ground), names groups of
faces: `ground` and `target` are bonded, `free` is free, as are faces in no group, which the answer says; `symmetry`,
where it is given, lies in the plane y = 0 and says that half the pad is meshed. It is watertight, and each of its
pieces is bonded to ground and target. Tetrahedra or hexahedra, see element/mesh.py. It is the first level of a family
whose cells are each divided into eight; edges are singular and cells even, so that errors go down with little more than
the first power of the cells' size. A mesh too large for that is solved again with pressures constant in each element:
its own answer counts, and the difference is the error.

Measured: with the cells divided tetrahedra converge from the stiff side, 431 of them on a box of 20 x 20 x 2 mm by 3.2,
1.7 and 0.9 % in shear, 13, 6 and 3 % in compression, 32, 17 and 9 % in tilt. Contact with ground and target is that of
families.py; free faces that touch each other, such as the walls of a slot, are held apart (faces/folds.py); half a pad
whose faces reach the plane of symmetry is held there.
"""

from __future__ import annotations

from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from skfem import Mesh

from sits_mech.geometry.meshing.bricks import PlateOutline, inside_outline
from sits_mech.geometry.meshing.refinement import Refinement, refined
from sits_mech.geometry.meshing.soundness import connected_cells, place
from sits_mech.mechanics.element.mesh import BRICK, TETRAHEDRON, solid_mesh
from sits_mech.mechanics.element.prolongation import Prolongation, prolongation
from sits_mech.mechanics.equilibrium.body import Bonded
from sits_mech.mechanics.levels.family import Levels
from sits_mech.mechanics.pad.shapes import outlines
from sits_mech.mechanics.pad.solid import NumberedMesh, as_in, numbered, pad_parts, solid
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Elastomer, Sensor
from sits_mech.units import millimetres as mm

if TYPE_CHECKING:
    from sits_mech.geometry.meshing.store import ReadSolid

_NEEDED = ("ground", "target")  # groups of faces that a pad's mesh must name
GROUPS = (*_NEEDED, "free")
"""Groups of faces of a pad's mesh; faces in none are free."""
_SYMMETRY = "symmetry"  # group that half a pad's mesh must name, too

_ORDER = 1.2  # of errors with even division: edges are singular
_PER_BRICK = 6.0  # tetrahedra that take about what a brick does
_MOST_BRICKS, _MOST_TETRAHEDRA = 4000, 12000  # cells of a divided mesh
_SLACK = 1e-3  # by which a mesh may miss the sizes that the scene gives, relative


class _Sizes(NamedTuple):
    """Sizes that a scene states for a pad [m]."""

    thickness: float  # of the pad
    pad: tuple[float, float]  # extent along x and y
    target: tuple[float, float]  # extent along x and y


def meshed_share(sensor: Sensor) -> float:
    """Return the meshed share of a scene's pad, 0.5 or 1; raise as `meshed_family`."""
    return 0.5 if _level(sensor, 0)[0].half else 1.0


def meshed_family(sensor: Sensor, guard: float, share: float, depth: float = 0.0) -> Levels:
    """Return the levels of a scene's ``elastomer.mesh``, each cell divided into eight from level to level.

    A mesh too large for that is paired with itself at constant pressures. `guard` [shear moduli]; `share`: floor of
    component errors over the worst; contact `depth` on the mesh itself [thicknesses], 0 for none. Raise ValueError, one
    line, for an unsuitable mesh.
    """
    first = _level(sensor, 0)[0]
    cells = len(first.mesh.cells)
    element = TETRAHEDRON if first.mesh.cells.shape[1] == len(TETRAHEDRON.doflocs) else BRICK
    most = _MOST_TETRAHEDRA if element is TETRAHEDRON else _MOST_BRICKS
    count = 1 + int(np.log(max(most / cells, 1.0)) / np.log(8.0))

    @cache
    def made(level: int) -> Bonded:
        """Make a level."""
        if count == 1:
            return solid(sensor, _level(sensor, 0, constant=level == 0)[0], guard, depth * (2.0, 1.0)[level]).body
        return solid(sensor, _level(sensor, level)[0], guard, depth / 4.0**level).body

    @cache
    def carrier(level: int) -> Prolongation | None:
        """Carry states from the level before."""
        if count == 1:
            return None
        once = refined(_level(sensor, level - 1)[1].mesh, 1)
        return prolongation(made(level - 1).mesh, made(level).mesh, once, element)

    def changed(other: Sensor, level: int) -> Bonded | None:
        """Make a level of a changed scene with the same sizes; None for other sizes."""
        return as_in(other, made(level), guard) if _sizes(other) == _sizes(sensor) else None

    along = max(1, round((cells / (_PER_BRICK if element is TETRAHEDRON else 1.0)) ** (1.0 / 3.0)))
    sizes = 2.0 ** np.arange(count)[:, None]
    terms = sizes ** -np.array([_ORDER, 2.0 * _ORDER]) if count > 1 else np.full((2, 1), np.nan)
    return Levels(terms, lambda level: 3 * (along * 2 ** (level if count > 1 else 0),), made, carrier, share, changed)


def _level(sensor: Sensor, times: int, *, constant: bool = False) -> tuple[NumberedMesh, Refinement]:
    """Return a scene's mesh with its cells divided, and its refinement; pressures linear or constant."""
    target, elastomer = pad_parts(sensor)
    return _divided(_file(elastomer), outlines(target, elastomer)[0], _sizes(sensor), times, constant)


def _sizes(sensor: Sensor) -> _Sizes:
    """Return the sizes a scene states for its pad."""
    target, elastomer = pad_parts(sensor)
    return _Sizes(elastomer.thickness, elastomer.extent, target.extent)


@lru_cache(maxsize=8)
def _divided(
    file: tuple[Path, bool, int], plate: PlateOutline, sizes: _Sizes, times: int, constant: bool
) -> tuple[NumberedMesh, Refinement]:
    """Make the level, cached for bodies that share it."""
    t, name = sizes.thickness, str(file[0])
    refinement = refined(_stamped(*file).mesh.scaled(1.0 / t), times)
    mesh = refinement.mesh
    own, basis = solid_mesh(mesh, TETRAHEDRON if len(mesh.t) == 4 else BRICK, constant)
    where = np.zeros((3, len(own.nodes)), dtype=bool)
    for row, group in enumerate(("ground", "target", _SYMMETRY)):
        if group in mesh.boundaries:
            where[row, basis.get_dofs(group).all()] = True
    _check_place(name, own.nodes, where, sizes)
    bonded = own.nodes[where[1]]
    if not np.all(inside_outline(plate, bonded, _SLACK * max(plate[:2]))):
        reach = 2e3 * t * np.abs(bonded[:, :2]).max(axis=0)
        raise ValueError(
            f"{name}: the group target must lie under the target, {_words(sizes.target)}; got {reach[0]:.4g} x "
            f"{reach[1]:.4g} mm"
        )
    return numbered(own, where, basis, plate, half=bool(np.any(where[2])), convex=False), refinement


def mesh_notes(sensor: Sensor) -> tuple[Note, ...]:
    """Return notes on a scene's mesh, if any: nodes merged, faces in no group."""
    if sensor.elastomer is None or sensor.elastomer.mesh is None:
        return ()
    mesh, merged = _stamped(*_file(sensor.elastomer))
    name, notes = str(sensor.elastomer.mesh), list[Note]()
    if merged:
        notes.append(Note.of(NoteKind.NODES_MERGED, mesh=name, count=int(merged)))
    outer = mesh.boundary_facets()
    lone = np.setdiff1d(outer, np.concatenate([mesh.boundaries.get(group, []) for group in (*GROUPS, _SYMMETRY)]))
    if lone.size:
        first = mesh.p.T[mesh.facets[:, int(lone[0])]].mean(axis=0).tolist()
        count = {"count": int(lone.size), "of": int(outer.size)}
        notes.append(Note.of(NoteKind.FACES_FREE, mesh=name, **count, **dict(zip("xyz", first, strict=True))))
    return tuple(notes)


def _file(elastomer: Elastomer) -> tuple[Path, bool, int]:
    """Return the identity of a pad's mesh: file, whether welded, time written."""
    path = Path(str(elastomer.mesh))
    return path, elastomer.weld, path.stat().st_mtime_ns if path.is_file() else 0


@lru_cache(maxsize=4)
def _stamped(path: Path, weld: bool, stamp: int) -> ReadSolid:
    """Read the mesh of a file as written at one time."""
    from sits_mech.geometry.meshing.store import read_solid  # and meshio, for who has a mesh

    found = read_solid(path, _NEEDED, weld=weld)
    _check_groups(str(path), found.mesh)
    return found


def _check_groups(name: str, mesh: Mesh) -> None:
    """Refuse faces in two groups, and pieces of a pad that are not bonded to both ground and target."""
    known = [group for group in (*GROUPS, _SYMMETRY) if group in mesh.boundaries]
    for k, group in enumerate(known):
        for other in known[k + 1 :]:
            both = np.intersect1d(mesh.boundaries[group], mesh.boundaries[other])
            if both.size:
                raise ValueError(
                    f"{name}: a face must be in one of the groups {', '.join(known)}; {both.size} are in {group} and "
                    f"{other}, the first about {place(mesh.p.T[mesh.facets[:, both[0]]])}"
                )
    inner = mesh.f2t[:, mesh.f2t[1] >= 0]
    piece = connected_cells(mesh.t.shape[1], inner)
    for group in ("ground", "target"):
        held = np.isin(piece, piece[mesh.f2t[0, mesh.boundaries[group]]])
        if not held.all():
            cell, lost = int(np.argmin(held)), np.unique(piece[~held]).size
            raise ValueError(
                f"{name}: every piece must be bonded to ground and target; {lost} of {piece.max() + 1} pieces "
                f"({np.count_nonzero(~held)} of {held.size} cells) have no face in the group {group}, the first about "
                f"{place(mesh.p.T[mesh.t[:, cell]])}"
            )


def _check_place(name: str, nodes: Array, where: Array, sizes: _Sizes) -> None:
    """Refuse a mesh that is not where the scene's pad is; nodes [thicknesses]."""
    ground, top, middle = where
    t = sizes.thickness
    for group, own, level in (("ground", ground, 0.0), ("target", top, 1.0)):
        away = nodes[own, 2] - level
        worst = float(away[np.argmax(np.abs(away))])
        if abs(worst) > _SLACK:
            raise ValueError(
                f"{name}: the group {group} must lie at z = {mm(level * t)} (elastomer.thickness is "
                f"{mm(t)}, the file in metres); got a node at {mm((level + worst) * t)}"
            )
    reach = 2.0 * t * np.abs(nodes[:, :2]).max(axis=0)
    if np.any(reach > (1.0 + _SLACK) * np.array(sizes.pad)):
        raise ValueError(
            f"{name}: the pad must lie within the elastomer's {_words(sizes.pad)}; got "
            f"{_words((float(reach[0]), float(reach[1])))}"
        )
    if np.any(middle) and (np.abs(nodes[middle, 1]).max() > _SLACK or nodes[:, 1].min() < -_SLACK):
        raise ValueError(f"{name}: the group symmetry must lie in the plane y = 0 with the pad at y > 0; it does not")


def _words(extent: tuple[float, float]) -> str:
    """Format two lengths."""
    return f"{1e3 * extent[0]:.4g} x {1e3 * extent[1]:.4g} mm"

