"""The pad as a body to solve, on a mesh of the user's own: domes, slots, pillars.

The mesh, in metres and in the pad's own place (x, y from the target's centre, ``z = 0`` on the ground), names groups of
faces: `ground` and `target` are bonded, `free` is free; `symmetry`, where it is given, lies in the plane y = 0 and says
that half the pad is meshed. Tetrahedra or hexahedra, see element/mesh.py. There is no second mesh to tell the error
from: the same nodes with pressures constant in each element give a softer answer; the pose is the mean for tetrahedra
and the stiffer one for hexahedra, and half of what they differ by is its error, with contact all of it (block.py).

Measured on boxes in compression and shear: tetrahedra of 1/4 thickness at the bonded corners and 0.9 elsewhere come
within some 2 % of the model's own mesh (the tilt by shear alone within 13 %, more than its error). Of one or two layers
of hexahedra the stiffer answer is within 6 %, mostly 2 %, where the mean would sink 3 to 24 % too far. Contact with
ground and target is that of block.py; free faces that touch each other, such as the walls of a slot, are held apart
(faces/folds.py); half a pad whose faces reach the plane of symmetry is held there.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from sits_mech.mechanics.element.mesh import BRICK, TETRAHEDRON, solid_mesh
from sits_mech.mechanics.pad.lines import outlines
from sits_mech.mechanics.pad.solid import Solid, numbered, pad_parts, solid
from sits_mech.meshing.bricks import within
from sits_mech.meshing.store import read_solid
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Elastomer, Sensor

GROUPS = ("ground", "target", "free")
"""Groups of faces that a pad's mesh must name."""

_SLACK = 1e-3  # by which a mesh may miss the sizes that the scene gives, relative


def meshed_pad(sensor: Sensor, guard: float, depth: float = 0.0) -> tuple[Solid, Solid]:
    """Return a pad on the mesh that its scene names, and its poorer companion.

    Parameters
    ----------
    sensor : Sensor
        With ``elastomer.mesh``.
    guard : float
        Part of the bulk modulus that acts pointwise against inversion [shear moduli].
    depth : float
        Over which the pressure of contact builds up, twice that for the companion; 0 for none [thicknesses].

    Raises
    ------
    ValueError
        One line: what the mesh must be, and what came.
    """
    target, elastomer = pad_parts(sensor)
    name, t = str(elastomer.mesh), elastomer.thickness
    mesh = read_solid(Path(name), GROUPS).scaled(1.0 / t)
    element, softened = (TETRAHEDRON, 0.5) if len(mesh.t) == 4 else (BRICK, 0.0)
    section, basis = solid_mesh(mesh, element)
    poorer, _ = solid_mesh(mesh, element, constant=True)
    where = np.zeros((3, len(section.nodes)), dtype=bool)
    for row, group in enumerate(("ground", "target", "symmetry")):
        if group in mesh.boundaries:
            where[row, basis.get_dofs(group).all()] = True
    _check_place(name, section.nodes, where, elastomer)
    plate, _ = outlines(target, elastomer)
    bonded = section.nodes[where[1]]
    if not np.all(within(plate, bonded, _SLACK * max(plate[:2]))):
        reach = 2e3 * t * np.abs(bonded[:, :2]).max(axis=0)
        raise ValueError(
            f"{name}: the group target must lie under the target, {_sizes(target.extent)}; got {reach[0]:.4g} x "
            f"{reach[1]:.4g} mm"
        )
    own, other = (numbered(each, where, 1.0, basis, plate, convex=False) for each in (section, poorer))
    return replace(solid(sensor, own, guard, depth), softened=softened), solid(sensor, other, guard, 2.0 * depth)


def _check_place(name: str, nodes: Array, where: Array, elastomer: Elastomer) -> None:
    """Refuse a mesh that is not where the scene's pad is; nodes [thicknesses]."""
    ground, top, middle = where
    t = elastomer.thickness
    for group, own, level in (("ground", ground, 0.0), ("target", top, 1.0)):
        away = nodes[own, 2] - level
        worst = float(away[np.argmax(np.abs(away))])
        if abs(worst) > _SLACK:
            raise ValueError(
                f"{name}: the group {group} must lie at z = {level * t:g} m (elastomer.thickness is {t:g} m); "
                f"got a node at {(level + worst) * t:g} m"
            )
    reach = 2.0 * t * np.abs(nodes[:, :2]).max(axis=0)
    if np.any(reach > (1.0 + _SLACK) * np.array(elastomer.extent)):
        raise ValueError(
            f"{name}: the pad must lie within the elastomer's {_sizes(elastomer.extent)}; got "
            f"{_sizes((float(reach[0]), float(reach[1])))}"
        )
    if np.any(middle) and (np.abs(nodes[middle, 1]).max() > _SLACK or nodes[:, 1].min() < -_SLACK):
        raise ValueError(f"{name}: the group symmetry must lie in the plane y = 0 with the pad at y > 0; it does not")


def _sizes(extent: tuple[float, float]) -> str:
    """Two lengths as one writes them."""
    return f"{1e3 * extent[0]:.4g} x {1e3 * extent[1]:.4g} mm"
