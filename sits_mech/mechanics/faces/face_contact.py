"""Find what the free faces of a layer touch: the ground, the target, or each other.

Read off the deformed nodes and the contacts' energy. Where contact is solved, a face lies on its plane within the
contact depth, or on another face (folds.py); where it is not, it may have gone through. The target's top face is solved
nowhere: what reaches it is found here and named.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sits_mech.geometry.meshing.bricks import PlateOutline, inside_outline
from sits_mech.mechanics.element.assembly import Part
from sits_mech.mechanics.element.kernel import deformation
from sits_mech.mechanics.element.mesh import MixedMesh
from sits_mech.mechanics.element.target import placed
from sits_mech.mechanics.faces.contact import Contact, Plane
from sits_mech.mechanics.faces.facets import is_monotone, lines_cross, triangles_cross
from sits_mech.mechanics.faces.folds import SelfContact
from sits_mech.mechanics.faces.skin import Skin
from sits_mech.mechanics.faces.surface import Surface
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array, Integers

LEFT_SHARE = 0.15
"""Share of what contact changes that is its error where faces touch each other: for the depth over which they do.

At the depth that is solved, 3e-3 thicknesses, the slotted example pad lacks 6 to 8 % of what contact is worth to its
sink (10 and 12 N, depths of 3e-3 and 1e-2 extrapolated to none), two blocks without room to the sides 11 to 15 % of
their force in closed form (pressed by 2.3 and 1.1 shear moduli, K = 50 of them). Finer levels have a smaller depth.
Meshes that do not match cost 0.2 % (folds.py).
"""

_SEEN = 1e-6  # thicknesses behind a plane that count
_SOFTER = 30.0  # times the depth of contact with planes, where both faces are bent: with less they are hard to follow
_PRESSED = 1e-14  # energy of a contact that counts [shear modulus times thickness to the power of the dimension]


@dataclass(frozen=True, eq=False)
class Faces:
    """The faces of a meshed layer."""

    nodes: Integers  # of the free faces
    under: Integers  # nodes before the target's plane
    outer: Integers  # nodes before its side walls
    target: PlateOutline  # half sizes [thicknesses]
    lines: tuple[Integers, ...] = ()  # of a section, the nodes of its faces in order
    skin: Skin | None = None  # None where faces are not held against each other
    convex: bool = True  # the layer at rest is known to be convex
    mirror: float = -np.inf  # y of the plane of symmetry; -inf of a whole layer [thicknesses]
    middle: Integers | None = None  # (m, 5), of a solid, faces in y = 0: cell, four corners in order


@dataclass(frozen=True)
class FaceContact:
    """What free faces touch."""

    ground: bool  # on or behind the ground
    target: bool  # the bottom face of a target that reaches over it
    walls: bool  # the sides of a narrower target
    rise: float  # of a face at the sides above the target's bottom face [thicknesses]
    held: bool = False  # faces lie on each other, or on their image, in contact
    crossing: bool = False  # faces pass through one another without contact
    missed: bool = False  # a crossing that contact would hold; it holds no inner corners

    @property
    def touch(self) -> bool:
        """Whether anything is touched that contact holds."""
        return self.ground or self.target or self.walls or self.held or self.missed


def contacts(
    faces: Faces, surfaces: tuple[tuple[Plane, Surface], ...], depth: float, friction: float = 0.0
) -> tuple[Part, ...]:
    """Return the contacts of a layer's faces with planes, and with each other; none at zero depth.

    `friction` is the coefficient on planes; faces on each other, and on images, have none.
    """
    if depth == 0.0:
        return ()
    level = faces.mirror if np.isfinite(faces.mirror) else 0.0
    planes = tuple(
        Contact(own, plane, depth, faces.target, level, friction * (plane != "mirror")) for plane, own in surfaces
    )
    return planes if faces.skin is None else (*planes, SelfContact(faces.skin, _SOFTER * depth))


def softened(parts: tuple[Part, ...], factor: float) -> tuple[Part, ...]:
    """Return contacts of `factor` times the depth."""
    return tuple(
        replace(part, depth=factor * part.depth) if isinstance(part, Contact | SelfContact) else part for part in parts
    )


def face_contact(faces: Faces, mesh: MixedMesh, parts: tuple[Part, ...], u: Array, q: Array) -> FaceContact:
    """Return what the free faces touch at displacements (d n,) [thicknesses] and motion q; `parts` of the body."""
    place = _places(mesh, u)
    centre, turn = placed(q)
    seen = (place - centre - (0.0, 0.0, 1.0)) @ turn
    above = seen[:, 2] > _SEEN
    inside = np.logical_and(inside_outline(faces.target, seen[faces.outer], -_SEEN), above[faces.outer])
    behind = {
        "ground": bool(np.any(place[faces.nodes, 2] < -_SEEN)),
        "plane": bool(np.any(above[faces.under])),
        "wall": bool(np.any(inside)),
        "mirror": False,
    }
    for part in parts:
        if isinstance(part, Contact):
            behind[part.plane] |= part(u, q).energy > _PRESSED
    held = behind["mirror"] or any(isinstance(part, SelfContact) and part(u, q).energy > _PRESSED for part in parts)
    rise = float(seen[faces.outer][inside, 2].max(initial=0.0))
    crossing = not held and crosses_itself(faces, mesh, u)
    missed = False
    if crossing and faces.skin is not None:
        beyond = np.any(place[faces.nodes, 1] < faces.mirror - _SEEN)
        missed = bool(beyond) or SelfContact(faces.skin, 1.0)(u, q).energy > 0.0
    return FaceContact(behind["ground"], behind["plane"], behind["wall"], rise, held, crossing, missed)


def faces_press(mesh: MixedMesh, parts: tuple[Part, ...], u: Array, q: Array) -> bool:
    """Whether free faces of a section press something, so that its meshes show no order."""
    touching = (part for part in parts if isinstance(part, Contact | SelfContact))
    return len(mesh.axes) == 2 and any(part(u, q).energy > _PRESSED for part in touching)


def face_notes(
    faces: Faces, mesh: MixedMesh, parts: tuple[Part, ...], u: Array, q: Array, plate: float
) -> tuple[Note, ...]:
    """Return notes on free faces under a target of thickness `plate`."""
    found = face_contact(faces, mesh, parts, u, q)
    surfaces = {"ground": found.ground, "target": found.target, "sides": found.walls}
    kind, more = NoteKind.FACE_FOLDS, dict[str, float]()
    if any(isinstance(part, Contact) for part in parts):
        kind = NoteKind.FACE_TOUCHES
        more["friction"] = max(part.friction for part in parts if isinstance(part, Contact))
    notes = [Note.of(kind, surface=name, **more) for name, own in surfaces.items() if own]
    others = {
        NoteKind.FACE_RISES: found.walls and found.rise > plate,
        NoteKind.FACES_TOUCH: found.held,
        NoteKind.FACES_CROSS: found.crossing,
    }
    return (*notes, *(Note(other) for other, own in others.items() if own))


def crosses_itself(faces: Faces, mesh: MixedMesh, u: Array) -> bool:
    """Whether free faces pass through one another."""
    place = _places(mesh, u)
    if faces.lines:
        return lines_cross([place[line][:, [0, 2]] for line in faces.lines])
    if faces.skin is None or faces.convex and is_monotone(deformation(mesh, u)[0]):
        return False
    return triangles_cross(faces.skin.facets, place, faces.mirror)


def _places(mesh: MixedMesh, u: Array) -> Array:
    """Return the deformed nodes x, y, z, shape (n, 3)."""
    place = np.zeros((len(mesh.nodes), 3))
    place[:, list(mesh.axes)] = mesh.nodes + u.reshape(mesh.nodes.shape)
    return place
