"""The pad as a body to solve in three dimensions: bricks, bonds, free faces, law, scales.

Half the pad, y >= 0, is meshed: a box under a rectangle on a tensor grid, what is round in rings (meshing/bricks.py).
Lines shrink towards the target's edge and the upper face, where the bonded corner is singular: the i-th of m lines of a
segment of length l lies ``l (i/m)**beta`` from the edge. Where the target covers the whole upper face the corner below
is as singular as the one above, and the lines through the thickness shrink towards both.

Scales: lengths by the thickness t, stresses by the initial shear modulus mu; forces by mu t^2, moments by mu t^3.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache, partial

import numpy as np
from skfem import Basis

from sits_mech.mechanics.assembly import Pattern, pattern
from sits_mech.mechanics.block_contact import Surface, contacts, surface
from sits_mech.mechanics.block_energy import cofactor, solid_energy
from sits_mech.mechanics.block_forms import BRICK, solid_deformation, solid_mesh, solid_tangent
from sits_mech.mechanics.contact import Plane
from sits_mech.mechanics.forms import Indices, Section, entries
from sits_mech.mechanics.path import Bonded, Element
from sits_mech.mechanics.self_contact import skin
from sits_mech.meshing.bricks import Outline, box_bricks, ring_bricks
from sits_mech.quantities import Array
from sits_mech.sensor import Elastomer, Sensor, Target

SOLID = Element(solid_tangent, solid_deformation, cofactor)
"""Three dimensions, block_forms.py."""

_STRETCH = 3.0  # thicknesses of half target that one cell more than through the thickness is worth
_REACH = 1.25  # thicknesses beside the target within which the pad is stressed: one cell does beyond
_GUARD_SHARE = 0.005  # of the bulk modulus that may act pointwise
_OUTER = 0.3  # of the outermost cell beside the target along x, split off: the tilt under shear hangs on it
_CLEAR = 2.5e-3  # of a disc's radius that its rim keeps from the sides of a box: cells there would have no width
_FOLDING = 1.5  # order that the error is told with in contact and of flush pads: faces fold onto a plane cell by cell
_AROUND = (2, 3)  # cells from a corner of the core to the next middle of a side: up to 2 through the thickness, more


@dataclass(frozen=True)
class Solid:
    """A pad with its target, and what is known of it besides the equations.

    Attributes
    ----------
    body : Bonded
        What is solved.
    faces : ndarray
        Nodes of the free faces.
    target : Outline
        Half the target's sizes [thicknesses].
    share : float
        Of the pad that is meshed: a half, or 1.
    middle : ndarray, shape (m, 5)
        Faces in the plane y = 0: the cell of each and its four corners in order, of a triangle the last one twice.
    fineness : float
        Cells through the thickness, or what stands for them: the error goes with its inverse squared.
    under : ndarray
        Nodes of the free faces under the target.
    skin : ndarray, shape (f, m, 3)
        Nodes of the triangles of each element's free face.
    convex : bool
        Whether the pad at rest is known to be convex.
    softened : float
        How far the pose goes towards that of a companion of the same fineness, which is softer.
    """

    body: Bonded
    faces: Indices
    target: Outline
    share: float
    middle: Indices
    fineness: float
    under: Indices
    skin: Indices
    convex: bool
    softened: float = 0.0


@dataclass(frozen=True, eq=False)
class _Numbered:
    """A mesh with its bonds, `where` and `fineness` as of `solid`; faces before a plane; patterns, found once."""

    section: Section
    where: Array
    fineness: float
    faces: Indices
    middle: Indices
    skin: Indices
    surfaces: tuple[tuple[Plane, Surface], ...]

    @cached_property
    def free(self) -> Indices:
        """Numbers of the displacements that are unknown."""
        ground, top, middle = self.where
        held = np.repeat((ground | top)[:, None], 3, axis=1)
        held[:, 1] |= middle
        return np.flatnonzero(~held.ravel())

    @cached_property
    def bonded(self) -> Indices:
        """Numbers of the displacements along x and z that the target moves."""
        return np.asarray(3 * np.flatnonzero(self.where[1])[:, None] + np.array([0, 2]))

    @cached_property
    def places(self) -> tuple[Indices, Indices]:
        """Rows and columns of the element stiffnesses."""
        return entries(self.section.dofs)

    @cached_property
    def pattern(self) -> Pattern:
        """Pattern without contact."""
        return pattern(*self.places, self.free, self._border)

    @cached_property
    def touching(self) -> Pattern:
        """Pattern with contact, in the same order of elimination: contact adds nothing to what is free."""
        each = (self.places, *(own.entries for _, own in self.surfaces))
        rows, columns = (np.concatenate(own) for own in zip(*each, strict=True))
        return pattern(rows, columns, self.pattern.free, self._border, ordered=True)

    @cached_property
    def _border(self) -> Indices:
        """Numbers of the bonded displacements and of q."""
        return np.concatenate([self.bonded.ravel(), self.section.nodes.size + np.arange(3)])


def bonded_block(sensor: Sensor, cells: int, grading: float, guard: float, give: float = 0.0) -> Solid:
    """Return half the pad (y >= 0) of a box or a cylinder with its target, meshed and scaled.

    Parameters
    ----------
    sensor : Sensor
    cells : int
        Cells through the thickness; one more where the target covers the whole upper face, and towards its edges.
    grading : float
        Power of the lines' spacing towards the target's edge and the faces; 1 is uniform.
    guard : float
        Part of the bulk modulus that acts pointwise against inversion [shear moduli].
    give : float
        Depth over which the pressure of contact builds up; 0 for no contact [thicknesses].
    """
    return _solid(sensor, _meshed(*outlines(*pad_parts(sensor)), cells, grading), guard, give)


@lru_cache(maxsize=4)
def _meshed(plate: Outline, pad: Outline, cells: int, grading: float) -> _Numbered:
    """The mesh of a pad; what differs in law, guard or contact shares it."""
    through = _through(cells, grading, flush(plate, pad))
    if plate.is_round or pad.is_round:
        mesh = ring_bricks(plate, pad, (*_ring_lines(plate, pad, cells, grading), through), _AROUND[cells > 2])
    else:
        mesh = box_bricks(*box_lines(plate, pad, cells, grading))
    section, basis = solid_mesh(mesh, BRICK)
    x, y, z = section.nodes.T
    top = (z > 1.0 - 1e-9) & within(plate, section.nodes, 1e-9)
    where = np.stack([z < 1e-9, top, y < 1e-9])
    return _numbered(section, where, len(through) - 1.0, basis, plate)


def solid(
    sensor: Sensor, section: Section, where: Array, given: tuple[float, float], basis: Basis, give: float = 0.0
) -> Solid:
    """Return a pad from its mesh.

    Parameters
    ----------
    sensor : Sensor
    section : Section
        From `solid_mesh`.
    where : ndarray of bool, shape (3, n)
        Nodes on the ground, on the target, and in the plane of symmetry if half the pad is meshed.
    given : tuple of float
        Part of the bulk modulus that acts pointwise against inversion [shear moduli]; the mesh's fineness.
    basis : Basis
        From `solid_mesh`.
    give : float
        Depth over which the pressure of contact builds up; 0 for no contact [thicknesses].
    """
    plate, _ = outlines(*pad_parts(sensor))
    return _solid(sensor, _numbered(section, where, given[1], basis, plate), given[0], give)


def _numbered(section: Section, where: Array, fineness: float, basis: Basis, plate: Outline) -> _Numbered:
    """A mesh with its faces under a target's outline."""
    facets = _free_facets(basis, where)
    found = basis.get_dofs(facets=facets).all()
    faces = np.asarray(found[~np.any(where[:2, found], axis=0)])
    middle = _middle_faces(basis, where[2])
    return _Numbered(section, where, fineness, faces, middle, skin(basis, facets), _surfaces(basis, facets, plate))


def _solid(sensor: Sensor, mesh: _Numbered, guard: float, give: float) -> Solid:
    """A pad on its mesh; arguments as of `bonded_block`."""
    target, elastomer = pad_parts(sensor)
    silicone, plate = elastomer.silicone, outlines(target, elastomer)[0]
    K = silicone.bulk_modulus / silicone.shear_modulus
    guard = min(guard, _GUARD_SHARE * K)
    body = Bonded(
        mesh.section, solid_energy(silicone, guard), K - guard, target.load_height / elastomer.thickness, mesh.free,
        mesh.bonded, mesh.section.nodes[mesh.where[1], 0], *mesh.places, SOLID, contacts(mesh.surfaces, give, plate),
        shared=partial(_pattern, mesh, give > 0.0),
    )
    below = [own.nodes.ravel() for plane, own in mesh.surfaces if plane == "plane"]
    under = np.intersect1d(np.concatenate([np.zeros(0, dtype=np.int64), *below]), mesh.faces)
    share = 0.5 if np.any(mesh.where[2]) else 1.0
    convex = elastomer.mesh is None
    return Solid(body, mesh.faces, plate, share, mesh.middle, mesh.fineness, under, mesh.skin, convex)


def _pattern(mesh: _Numbered, touching: bool) -> Pattern:
    """Pattern of the bodies on one mesh, with contact or without."""
    return mesh.touching if touching else mesh.pattern


def _free_facets(basis: Basis, where: Array) -> Indices:
    """The faces that are bonded to nothing and in no plane of symmetry; `where` as of `solid`."""
    facets = basis.mesh.boundary_facets()
    corners = basis.nodal_dofs[0][basis.mesh.facets[:, facets]]
    bonded = np.any([group[corners].all(axis=0) for group in where], axis=0)
    return np.asarray(facets[~bonded])


def _surfaces(basis: Basis, facets: Indices, plate: Outline) -> tuple[tuple[Plane, Surface], ...]:
    """What is below the top before the ground; what lies under the target before its plane, the rest before its walls.

    A face of the top lies under it with all its corners: rims of thin faces beside a disc do not.
    """
    corners = basis.mesh.p[:, basis.mesh.facets[:, facets]]
    top = np.all(corners[2] > 1.0 - 1e-9, axis=0)
    inside = np.all([within(plate, corner.T, 1e-3) for corner in corners.swapaxes(0, 1)], axis=0)
    under = np.where(top, inside, within(plate, corners.mean(axis=1).T, 1e-3))
    groups: tuple[tuple[Plane, Array], ...] = (("ground", ~top), ("plane", under), ("wall", ~under))
    return tuple((plane, surface(basis, facets[own])) for plane, own in groups if np.any(own))


def _middle_faces(basis: Basis, middle: Array) -> Indices:
    """Faces in the plane of symmetry, as of `Solid.middle`."""
    mesh = basis.mesh
    facets = mesh.boundary_facets()
    corners = basis.nodal_dofs[0][mesh.facets[:, facets]].T
    own = np.all(middle[corners], axis=1)
    corners, cells = corners[own], mesh.f2t[0, facets[own]]
    x, z = np.moveaxis(basis.doflocs.T[corners][..., [0, 2]], -1, 0)
    around = np.arctan2(z - z.mean(axis=1, keepdims=True), x - x.mean(axis=1, keepdims=True))
    corners = np.take_along_axis(corners, np.argsort(around, axis=1), axis=1)
    return np.column_stack([cells, corners, *([corners[:, -1]] if corners.shape[1] == 3 else [])])


def shares(fine: Solid, coarse: Solid) -> tuple[float, float]:
    """Return how much of what two pads' poses differ by is added to the finer one's, and how much is its error."""
    finer, folds = fine.fineness / coarse.fineness, bool(fine.body.parts)
    if finer > 1.0:
        order = _FOLDING if folds or fine.under.size > 0 else 2.0
        return 1.0 / (finer**2 - 1.0), 1.0 / (finer**order - 1.0)
    return -fine.softened, 1.0 if folds else 0.5


def outlines(target: Target, elastomer: Elastomer) -> tuple[Outline, Outline]:
    """Return target and pad seen from above, a box a little wider than a disc that touches its side [thicknesses]."""
    t = elastomer.thickness
    plate, pad = ([length / (2.0 * t) for length in part.extent] for part in (target, elastomer))
    disc, cylinder = target.shape == "disc", elastomer.diameter is not None
    if disc and not cylinder:
        pad = [max(size, (1.0 + _CLEAR) * plate[0]) for size in pad]
    return Outline(plate[0], plate[1], disc), Outline(pad[0], pad[1], cylinder)


def flush(plate: Outline, pad: Outline) -> bool:
    """Say whether a target reaches a side of its pad."""
    return pad.half_x - plate.half_x < 1e-9 or pad.half_y - plate.half_y < 1e-9


def within(outline: Outline, points: Array, slack: float) -> Array:
    """Say which points, shape (n, 2 or more), lie in an outline with `slack` around it."""
    a, b = np.abs(points[:, 0]) / (outline.half_x + slack), np.abs(points[:, 1]) / (outline.half_y + slack)
    return np.asarray(np.hypot(a, b) < 1.0 if outline.is_round else np.maximum(a, b) < 1.0)


def pad_parts(sensor: Sensor) -> tuple[Target, Elastomer]:
    """Return target and elastomer of a scene that this model can hold, or refuse it."""
    target, elastomer = sensor.target, sensor.elastomer
    if target is None or elastomer is None:
        missing = "target" if target is None else "elastomer"
        raise ValueError(f"{missing}: must be given for a force to move the target; it is missing")
    if target.shape == "outline":
        raise ValueError("target.shape: must be 'rectangle' or 'disc' for the model 'block', got 'outline'")
    return target, elastomer


def edge_notes(sensor: Sensor) -> tuple[str, ...]:
    """Say that an edge radius plays no part here."""
    if sensor.elastomer is None or sensor.elastomer.edge_radius is None:
        return ()
    return ("elastomer.edge_radius is left out: the edges of this model are sharp, or as its mesh has them",)


def box_lines(plate: Outline, pad: Outline, cells: int, grading: float) -> tuple[Array, Array, Array]:
    """Return the lines of a box along x, along y from the middle on, and through the thickness; as `bonded_block`."""
    x = _half_lines(plate.half_x, pad.half_x, cells, grading, _OUTER)
    y = _half_lines(plate.half_y, pad.half_y, cells, grading, 0.0)
    return np.concatenate([-x[:0:-1], x]), y, _through(cells, grading, flush(plate, pad))


def _half_lines(edge: float, end: float, cells: int, grading: float, outer: float) -> Array:
    """Lines from the middle to the end of the pad, closer towards the target's edge; `outer` splits the last cell."""
    covers = end - edge < 1e-9
    inner = cells + int(edge / _STRETCH) + int(covers)
    lines = edge * (1.0 - (np.arange(inner, -1, -1) / inner) ** grading)
    if covers:
        return np.asarray(lines)
    far = end - edge > 1.5 * _REACH
    beside = (np.arange(cells + 1) / cells) ** grading
    if outer > 0.0 and not far:
        beside = np.insert(beside, cells, 1.0 - outer * (1.0 - beside[-2]))
    lines = np.concatenate([lines, edge + (_REACH if far else end - edge) * beside[1:]])
    return np.append(lines, end) if far else lines


def _ring_lines(plate: Outline, pad: Outline, cells: int, grading: float) -> tuple[Array, Array]:
    """Lines from the core to the target's outline, and from there to the pad's."""
    inner = cells + int(max(plate[:2]) / _STRETCH)
    inside = 1.0 - (np.arange(inner, -1, -1) / inner) ** grading
    if flush(plate, pad):
        return inside, np.zeros(1)
    gap = min(pad.half_x - plate.half_x, pad.half_y - plate.half_y)
    lines = _half_lines(0.0, gap, cells, grading, _OUTER)
    return inside, lines[lines.searchsorted(0.0, "right") - 1 :] / gap


def _through(cells: int, grading: float, flush: bool) -> Array:
    """Lines through the thickness."""
    if not flush:
        return np.asarray(1.0 - (np.arange(cells, -1, -1) / cells) ** grading)
    s = np.linspace(0.0, 1.0, cells + 2)
    lower = 0.5 * (2.0 * np.minimum(s, 1.0 - s)) ** grading
    return np.where(s < 0.5, lower, 1.0 - lower)
