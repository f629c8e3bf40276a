"""The pad as a body to solve in three dimensions: bricks, bonds, free faces, law, scales.

Half the pad, y >= 0, is meshed (pad/shapes.py). A load that leaves the plane y = 0 takes both halves, the same bricks
and their mirror image.

Scales: lengths by the thickness t, stresses by the initial shear modulus mu; forces by mu t^2, moments by mu t^3.

The sizes of a pad may change a little, the same cells, their nodes moved. With X' the nodes of the changed pad, all
cells go by the shape functions of the displacements, ``x' = sum_a N_a X'_a``, so that with ``G = dx'/dx``, H its
cofactors and J its determinant

    grad' N = H/J grad N,        weights' = J weights,

exactly, without a basis made anew; pressures are the polynomials of the moved places. What the law, the bulk modulus
and the place of the load are follows from the changed scene. Lengths in thicknesses of the layer each.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache, partial

import numpy as np
from skfem import Basis, MeshHex, MeshHex2
from skfem.element import ElementHex1
from skfem.quadrature import get_quadrature

from sits_mech.geometry.meshing.bricks import PlateOutline, Subdivision, both_halves, inside_outline
from sits_mech.geometry.meshing.refinement import shape_values
from sits_mech.mechanics.closed_form import HAIR
from sits_mech.mechanics.element.assembly import Pattern, pattern
from sits_mech.mechanics.element.kernel import element_forces, gradients, kinematics
from sits_mech.mechanics.element.mesh import BRICK, ORDER, MixedMesh, Points, pressures, solid_mesh
from sits_mech.mechanics.equilibrium.body import Bonded, State, border
from sits_mech.mechanics.equilibrium.control import Scales
from sits_mech.mechanics.faces.contact import Plane
from sits_mech.mechanics.faces.face_contact import Faces, contacts
from sits_mech.mechanics.faces.skin import solid_skin
from sits_mech.mechanics.faces.surface import Surface, facets_of
from sits_mech.mechanics.pad.section import layer_parts
from sits_mech.mechanics.pad.shapes import GRADING, PadShape, half_bricks, shape_of
from sits_mech.mechanics.pad.stack import Covering, covering, laws_of, layer_of_cells, press_on
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array, Integers
from sits_mech.scene.sensor import Elastomer, SceneError, Sensor, Target
from sits_mech.units import millimetres as mm


@dataclass(frozen=True, eq=False)
class Solid:
    """A pad with its target, as a body to solve."""

    body: Bonded
    share: float  # meshed part of the pad, 0.5 or 1
    division: Subdivision | None = None  # of the mesh in its family, if it has one


@dataclass(frozen=True, eq=False)
class NumberedMesh:
    """A mesh with its bonds, free faces and patterns, shared by bodies that differ in law, guard and contact."""

    mesh: MixedMesh
    where: Array  # bool (3, n): on the ground, on the target, in the plane of symmetry
    faces: Faces
    surfaces: tuple[tuple[Plane, Surface], ...]  # faces before each plane
    half: bool  # half a pad is meshed; pillars may have no node in its plane of symmetry
    division: Subdivision | None = None
    top: Callable[[Covering, int], Surface] | None = None  # so many points along edges of faces of a cover's top

    def free(self, hidden: bool = False) -> Integers:
        """Numbers of the unknown displacements; `hidden`: those odd in y, of half a pad."""
        ground, top, middle = self.where
        held = np.repeat((ground | top)[:, None], 3, axis=1)
        held[:, [0, 2] if hidden else [1]] |= middle[:, None]
        return np.flatnonzero(~held.ravel())

    @cached_property
    def bonded(self) -> Integers:
        """Numbers of the displacements that the target moves, shape (n, 3)."""
        return 3 * np.flatnonzero(self.where[1])[:, None] + np.arange(3)


@lru_cache(maxsize=16)
def _pattern(own: NumberedMesh, touching: bool, pressed: Surface | None, hidden: bool = False) -> Pattern:
    """Make the pattern with or without contact and a face that is pressed on, of the unknowns or what is hidden."""
    faces = [surface.numbers for _, surface in own.surfaces if touching]
    faces += [] if pressed is None else [pressed.numbers_of_shape]
    return pattern(own.mesh, (own.mesh.dofs, *faces), own.free(hidden), border(own.mesh, own.bonded))


def bonded_block(
    sensor: Sensor, split: int, grading: float = GRADING, guard: float = 0.0, depth: float = 0.0, *,
    whole: bool = False, layers: int = 0, pressed: float = 0.0,
) -> Solid:
    """Return half the pad (y >= 0), or the whole, of a box or cylinder with its target, meshed and scaled.

    `split` parts of each base cell; `grading`: power of the spacing, 1 is uniform; `guard` [shear moduli] as
    in `SectionFineness`; contact `depth` [thicknesses], 0 for none, `pressed` of what presses on a cover; `layers` at
    the target's edge and the faces. A whole pad frees all six components of the motion.
    """
    return solid(sensor, _meshed(pad_shape(sensor), (split, grading, layers), whole), guard, depth, pressed)


def pad_shape(sensor: Sensor) -> PadShape:
    """Return the shape of a scene's pad with its target and cover; refuse one this model cannot hold."""
    return shape_of(*pad_parts(sensor), covering(sensor))


@lru_cache(maxsize=8)
def _meshed(shape: PadShape, fineness: tuple[int, float, int], whole: bool) -> NumberedMesh:
    """Mesh a pad; cached for bodies that differ in law, guard or contact."""
    mesh, division = half_bricks(shape, *fineness)
    if whole:
        mesh, division = both_halves(mesh), division.doubled
    own, basis = solid_mesh(mesh, BRICK)
    _, y, z = own.nodes.T
    top = (z > 1.0 - 1e-9) & inside_outline(shape.plate, own.nodes, 1e-9)
    if shape.cover is not None:
        top &= z < shape.cover.levels[0] + 1e-9
    where = np.stack([z < 1e-9, top, (np.abs(y) < 1e-9) & (not whole)])
    covered = shape.cover is not None
    found = numbered(
        own, where, basis, shape.plate, half=not whole, convex=not shape.middles and not covered, covered=covered
    )
    return replace(found, division=division)


def numbered(
    mesh: MixedMesh, where: Array, basis: Basis, plate: PlateOutline, *, half: bool, convex: bool = True,
    covered: bool = False,
) -> NumberedMesh:
    """Return a mesh, from `solid_mesh`, with its faces under a target's outline `plate` (half sizes) [thicknesses].

    `where` and `half` as in `NumberedMesh`; `convex`: the pad at rest is known to be convex; `covered`: no
    free face can meet the target.
    """
    facets = basis.mesh.boundary_facets()
    corners = basis.nodal_dofs[0][basis.mesh.facets[:, facets]]
    bonded = np.any([group[corners].all(axis=0) for group in where], axis=0)
    facets = np.asarray(facets[~bonded])
    found = basis.get_dofs(facets=facets).all()
    nodes = np.asarray(found[~np.any(where[:2, found], axis=0)])
    around = solid_skin(basis, facets)
    surfaces = (("ground", facets_of(basis, facets)),) if covered else _surfaces(basis, facets, plate)
    below = [own.nodes.ravel() for plane, own in surfaces if plane == "plane"]
    under = np.intersect1d(np.concatenate([np.zeros(0, dtype=np.int64), *below]), nodes)
    mirror = min(0.0, float(mesh.nodes[:, 1].min())) if half else -np.inf
    outer = np.setdiff1d(nodes, nodes if covered else under)
    level = np.asarray(where[2] if half else np.abs(mesh.nodes[:, 1]) < 1e-9)
    middle = _middle_faces(basis, level)
    faces = Faces(nodes, under, outer, plate, (), around, convex, mirror, middle)
    if np.isfinite(mirror) and not convex:
        surfaces = (*surfaces, ("mirror", around.surface))
    top = cache(partial(_top, basis, facets)) if covered else None
    return NumberedMesh(mesh, where, faces, surfaces, half, top=top)


def _top(basis: Basis, facets: Integers, cover: Covering, count: int) -> Surface:
    """Return so many points along each edge of the faces of a cover's top."""
    high = basis.mesh.p[2, basis.mesh.facets[:, facets]].min(axis=0)
    return facets_of(basis, facets[high > cover.levels[1] - 1e-9], 2 * count - 1)


def solid(sensor: Sensor, own: NumberedMesh, guard: float, depth: float, pressed: float = 0.0) -> Solid:
    """Return a pad on its mesh; guard and contact depths as in `bonded_block`."""
    target, elastomer = pad_parts(sensor)
    laws = laws_of(sensor, layer_of_cells(sensor, own.mesh), guard)
    X = _from_centre(sensor, own.mesh.nodes[own.where[1]])
    press = None if own.top is None else press_on(sensor, pressed, own.top)
    top = None if press is None else press.surface
    body = Bonded(
        own.mesh, laws, target.load_height / elastomer.thickness, own.free(), own.bonded, X, own.faces,
        components=3 if own.half else 6, parts=contacts(own.faces, own.surfaces, depth, elastomer.friction),
        shared=partial(_pattern, own, depth > 0.0, top), press=press,
        hidden=partial(_pattern, own, depth > 0.0, top, True) if own.half else None,
    )
    return Solid(body, 0.5 if own.half else 1.0, own.division)


def _from_centre(sensor: Sensor, nodes: Array) -> Array:
    """Return bonded nodes, (n, 3), from the centre of the target's lower face; without a cover all lie on that."""
    return nodes * (1.0, 1.0, 0.0) if sensor.cover is None else nodes - (0.0, 0.0, 1.0)


def as_in(sensor: Sensor, body: Bonded, guard: float) -> Bonded:
    """Return a pad on the same nodes with the laws and height of load of a changed scene."""
    target, elastomer = pad_parts(sensor)
    height = target.load_height / elastomer.thickness
    return replace(body, laws=laws_of(sensor, body.laws.of, guard), height=height)


def mirrored(half: Bonded, whole: Bonded, state: State) -> State:
    """Return the state of a whole pad from that of half of it and its mirror image."""
    u, flip = np.zeros(whole.mesh.nodes.shape), np.array([1.0, -1.0, 1.0])
    own = state.u.reshape(-1, 3)[half.mesh.cells]
    u[whole.mesh.cells] = np.concatenate([own, own * flip])
    q, load = (np.concatenate([part, np.zeros(3)]) for part in (state.q, 2.0 * state.load))
    p = element_forces(whole.mesh, whole.laws, u.ravel()).pressure
    return State(u.ravel(), q, p, load, min_J=state.min_J)


def pad_scales(sensor: Sensor, share: float) -> Scales:
    """Return SI scales of motions and loads, `share` of the pad meshed."""
    _, elastomer = pad_parts(sensor)
    t = elastomer.thickness
    return Scales(t, elastomer.shear_modulus * t**2, elastomer.standoff, share)


def _surfaces(basis: Basis, facets: Integers, plate: PlateOutline) -> tuple[tuple[Plane, Surface], ...]:
    """Return faces before planes: below the top before the ground, under the target before its plane, else its walls.

    A face of the top lies under the target only with all its corners: rims of thin faces beside a disc do not.
    """
    corners = basis.mesh.p[:, basis.mesh.facets[:, facets]]
    top = np.all(corners[2] > 1.0 - 1e-9, axis=0)
    inside = np.all([inside_outline(plate, corner.T, 1e-3) for corner in corners.swapaxes(0, 1)], axis=0)
    under = np.where(top, inside, inside_outline(plate, corners.mean(axis=1).T, 1e-3))
    groups: tuple[tuple[Plane, Array], ...] = (("ground", ~top), ("plane", under), ("wall", ~under))
    return tuple((plane, facets_of(basis, facets[own])) for plane, own in groups if np.any(own))


def _middle_faces(basis: Basis, middle: Array) -> Integers:
    """Return the faces whose nodes are all in the plane y = 0, as `Faces.middle`."""
    mesh = basis.mesh
    every = basis.nodal_dofs[0][mesh.facets].T
    facets = np.flatnonzero(np.all(middle[every], axis=1))
    corners, cells = every[facets], mesh.f2t[0, facets]
    x, z = np.moveaxis(basis.doflocs.T[corners][..., [0, 2]], -1, 0)
    around = np.arctan2(z - z.mean(axis=1, keepdims=True), x - x.mean(axis=1, keepdims=True))
    corners = np.take_along_axis(corners, np.argsort(around, axis=1), axis=1)
    return np.column_stack([cells, corners, *([corners[:, -1]] if corners.shape[1] == 3 else [])])


def pad_parts(sensor: Sensor) -> tuple[Target, Elastomer]:
    """Return target and elastomer of a scene; refuse one this model cannot hold."""
    target, elastomer = layer_parts(sensor)
    if target.loops:
        raise ValueError(f"target.shape: must be 'rectangle' or 'disc' for the model 'block', got '{target.shape}'")
    thin = elastomer.diameter if elastomer.diameter is not None else min(elastomer.extent)
    if elastomer.thickness > HAIR * thin:
        raise SceneError(
            f"elastomer.thickness: must be at most {HAIR:g} times its smallest width ({mm(thin)}) for the "
            f"model 'block', which does not resolve hairs; got {mm(elastomer.thickness)}"
        )
    return target, elastomer


def ignored_edge(sensor: Sensor) -> tuple[Note, ...]:
    """Note that an edge radius is ignored here."""
    if sensor.elastomer is None or sensor.elastomer.edge_radius is None:
        return ()
    return (Note(NoteKind.EDGE_LEFT_OUT),)


def moved_block(body: Bonded, sensor: Sensor, fineness: tuple[int, float, int], guard: float = 0.0) -> Bonded | None:
    """Return a pad without contact with the sizes of a changed scene; None where that takes other cells.

    `body` is from `bonded_block`; `fineness` its parts, grading and layers.
    """
    try:
        bricks, _ = half_bricks(pad_shape(sensor), *fineness)
    except SceneError:
        return None
    nodes = _nodes(bricks if body.components == 3 else both_halves(bricks), body.mesh)
    if nodes is None:
        return None
    X = _from_centre(sensor, nodes[body.bonded[:, 0] // 3])
    mesh = body.mesh if np.array_equal(nodes, body.mesh.nodes) else moved_mesh(body.mesh, nodes)
    return replace(as_in(sensor, body, guard), mesh=mesh, X=X)


def moved_mesh(mesh: MixedMesh, nodes: Array) -> MixedMesh:
    """Return a mesh of bricks with its nodes at other places, shape (n, 3) [thicknesses]."""
    slope, weights = mesh.inside
    e, q, d, _ = slope.shape
    G = kinematics(gradients(mesh, nodes.ravel()))
    new = Points((G.H / G.J[..., None]).reshape(e, q, d, d) @ slope, weights * G.J)
    places = np.moveaxis(_values() @ nodes[mesh.cells], -1, 0)
    return MixedMesh(nodes, mesh.cells, new, pressures(places, new.weights, mesh.chi.shape[1] == 1))


def _nodes(bricks: MeshHex, mesh: MixedMesh) -> Array | None:
    """Return the nodes of bricks in the order of a mesh, corners first in both; None where cells differ."""
    if bricks.t.shape[1] != len(mesh.cells) or not np.array_equal(bricks.t.T, mesh.cells[:, : len(bricks.t)]):
        return None
    if isinstance(bricks, MeshHex2):  # its own nodes
        return np.ascontiguousarray(bricks.doflocs.T)
    nodes = np.empty_like(mesh.nodes)
    nodes[mesh.cells] = _corners() @ bricks.p.T[bricks.t.T]
    return nodes


@cache
def _corners() -> Array:
    """Return the matrix from a brick's corners to its nodes, shape (27, 8)."""
    return shape_values(ElementHex1(), BRICK.doflocs)


@cache
def _values() -> Array:
    """Return the shape functions of a brick at the quadrature points, shape (q, k)."""
    return shape_values(BRICK, get_quadrature(BRICK, ORDER)[0].T)
