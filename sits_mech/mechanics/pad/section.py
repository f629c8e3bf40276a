"""The layer's section as a body to solve: mesh, bonds, law, scales.

Lines are graded towards both faces and towards the target's and the layer's edges, where bonded corners are singular
(exponent 0.5946 for an incompressible clamped right angle against a free face). Too strong a grading resolves a corner
that finite strain then turns inside out: a nonlinear layer takes a milder one than a linear layer. The i-th of m lines
of a half segment of length l lies ``l (i/m)**beta`` from its end; errors that go as ``h**(2 k)`` on uniform cells, k
the exponent of the corner, then go as ``m**(-2 k beta)`` until the order of the element takes over.

A target wider than its layer is bonded over all of it, and the corners above are those below; free faces that rise at
its edge lie on the target's plane, which goes on beyond.

A cover (`[cover]`) goes on above the pad, the target a gap in it whose boundary moves rigidly (stack.py). Lines are
closer to the edges of target and cover; the free faces are one line from the ground over the cover to the ground, or to
the axis.

A cylinder under a coaxial disc that is pressed alone is its section's half at x >= 0, turned about the axis: nodes on
it have no u_r, the target no motion but along it.

Scales: lengths by the thickness t, stresses by the initial shear modulus mu; per depth, forces by mu t and moments by
mu t^2, about an axis by mu t^2 and mu t^3.

A guard keeps the elements from inverting, a part of the bulk modulus that acts pointwise:

    kappa int (J - 1 - ln J)

by Simpson's rule on the elements' nodes, corners included: without bound towards inversion, and nothing at rest.
Energies in shear modulus times thickness squared. Source: the volumetric energy of J. C. Simo, R. L. Taylor, Comput.
Methods Appl. Mech. Engng 85 (1991) 273, here as a barrier. (A solid's guard stands in its law, at quadrature points.)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from sits_mech.geometry.meshing.bricks import PlateOutline
from sits_mech.mechanics.element.assembly import Part, Pattern, Term, pattern
from sits_mech.mechanics.element.kernel import deformation, kinematics, summed, taken, taken_tangents
from sits_mech.mechanics.element.mesh import MixedMesh, about_axis, fanned, section_mesh
from sits_mech.mechanics.equilibrium.body import Bonded, border
from sits_mech.mechanics.equilibrium.control import Scales
from sits_mech.mechanics.faces.contact import Plane
from sits_mech.mechanics.faces.face_contact import Faces, contacts
from sits_mech.mechanics.faces.skin import section_skin
from sits_mech.mechanics.faces.surface import Surface, edge_points
from sits_mech.mechanics.pad.fillet import (
    Fillet,
    divided_lines,
    drawn_in,
    fillet_lines,
    fitting_fillet,
    graded_lines,
    matched_cells,
)
from sits_mech.mechanics.pad.stack import (
    GUARD_SHARE,
    Covering,
    Interface,
    Pressed,
    covering,
    interfaces,
    laws_of,
    layer_of_cells,
    press_on,
    pressed_part,
    top_points,
    widened,
)
from sits_mech.quantities import Array, Integers, Mask
from sits_mech.scene.sensor import Elastomer, Sensor, Target

_ENDLESS = 1e6  # thicknesses of half the target along y


@dataclass(frozen=True)
class SectionFineness:
    """Subdivision of a layer into cells."""

    cells: int  # through the thickness, even
    grading: float  # power of the spacing towards the corners; 1 is uniform
    fan: bool = False  # split the cells at singular corners into triangles (`fanned`)
    guard: float = 0.0  # pointwise part of the bulk modulus [shear moduli]
    depth: float = 0.0  # contact depth; 0: no contact [thicknesses]
    axial: bool = False  # the half of a section at x >= 0, about the axis x = 0
    pressed: float = 0.0  # contact depth of what presses on a cover [thicknesses]


def bonded_body(sensor: Sensor, fineness: SectionFineness) -> Bonded:
    """Return a sensor's layer with its target, meshed and scaled."""
    target, elastomer = layer_parts(sensor)
    if elastomer.kind == "pillars":
        raise ValueError("elastomer.shape: must be 'box' or 'cylinder' for a layer in plane strain, got 'pillars'")
    t = elastomer.thickness
    half_layer = elastomer.extent[0] / (2 * t)
    half_target = min(widened(target.extent[0] / (2 * t), half_layer), half_layer)  # bonded over what both share
    fillet = Fillet((elastomer.edge_radius or 0.0) / t, half_layer, half_target)
    fillet = fitting_fillet(fillet, t) if fillet.radius > 0.0 else fillet
    section = Section(fillet, interfaces(elastomer), covering(sensor), pressed_part(sensor))
    own = _numbered(section, fineness.cells, fineness.grading, fineness.fan, fineness.axial)
    of = layer_of_cells(sensor, own.mesh)
    guard = min(fineness.guard, GUARD_SHARE * float(laws_of(sensor, of).K.min()))
    parts = _parts(own, guard, fineness.depth, elastomer.friction)
    press = press_on(sensor, fineness.pressed, partial(top_points, own.mesh))
    return Bonded(
        own.mesh, laws_of(sensor, of, apart=guard), target.load_height / t, own.free, own.bonded, own.X, own.faces,
        parts=parts, guarded=guard > 0.0, press=press,
        shared=partial(_pattern, own, guard > 0.0, fineness.depth > 0.0, None if press is None else press.surface),
    )


class Section(NamedTuple):
    """A layer and its target in section [thicknesses]."""

    fillet: Fillet
    between: tuple[Interface, ...]
    cover: Covering | None = None
    pressed: Pressed = Pressed()


@dataclass(frozen=True, eq=False)
class _Numbered:
    """A mesh with its bonds and faces."""

    mesh: MixedMesh
    free: Integers  # numbers of the unknown displacements
    bonded: Integers  # numbers of the bonded displacements
    X: Array  # bonded nodes from the target's centre
    faces: Faces
    surfaces: tuple[tuple[Plane, Surface], ...]  # faces before each plane


def side_faces(mesh: MixedMesh) -> list[Integers]:
    """Return the nodes of the left and the right face, from the ground upwards; about an axis the right one alone."""
    x, z = mesh.places.T
    faces = (np.flatnonzero(np.abs(x - end) < 1e-9) for end in (x.min(), x.max())[mesh.hoop :])
    return [face[np.argsort(z[face])] for face in faces]


def top_faces(mesh: MixedMesh, half: float) -> list[Integers]:
    """Return the nodes of the top face left and right of a target of half width `half`, outwards from its edge."""
    x, z = mesh.places.T
    if x.max() - half < 1e-9:
        return []
    faces = (np.flatnonzero((z > 1.0 - 1e-9) & (side * x > half - 1e-9)) for side in (-1.0, 1.0)[mesh.hoop :])
    return [face[np.argsort(np.abs(x[face]))] for face in faces]


def covered_faces(mesh: MixedMesh, half: float, cover: Covering) -> Integers:
    """Return the nodes of a covered layer's free faces, from the ground at the right to that at the left, or the axis.

    `half` is the layer's half width.
    """
    x, z = mesh.nodes.T
    top = cover.levels[1]
    foot = [(half, 1.0), (cover.half_x, 1.0)] if cover.half_x < half else []
    right = [(half, 0.0), *foot, (cover.half_x, top)]
    left = [(0.0, top)] if mesh.hoop else [(-a, b) for a, b in right[::-1]]
    found = list[int]()
    for (a, low), (b, high) in pairwise([*right, *left]):
        along, size = (x - a) * (b - a) + (z - low) * (high - low), (b - a) ** 2 + (high - low) ** 2
        off = np.abs((x - a) * (high - low) - (z - low) * (b - a))
        on = np.flatnonzero((off < 1e-9) & (along > -1e-9) & (along < size + 1e-9))
        found += on[np.argsort(along[on])].tolist()
    return np.array(list(dict.fromkeys(found)))


def _mesh(section: Section, cells: int, grading: float, fan: bool, axial: bool) -> MixedMesh:
    """Mesh layer and target of given half widths, with or without an edge radius, or their half about the axis."""
    fillet, _, cover, _ = section
    (x, z, corners), least = _lines(section, cells, grading), 0.0 if axial else -np.inf
    mesh = section_mesh(
        x[x >= least], z, partial(drawn_in, fillet) if fillet.radius > 0.0 else None,
        None if cover is None else partial(_filled, fillet.half_target, cover),
    )
    own = [corner for corner in corners if corner[0] >= least]
    mesh = fanned(mesh, np.array(own)) if fan and own else mesh
    return about_axis(mesh) if axial else mesh


def _filled(half_target: float, cover: Covering, middles: Array) -> Mask:
    """Whether there is silicone at the middles of cells, (n, 2)."""
    x, z = np.abs(middles.T)
    return np.asarray((z < 1.0) | ((x < cover.half_x) & ((x > half_target) | (z > cover.levels[0]))))


def _lines(section: Section, cells: int, grading: float) -> tuple[Array, Array, list[tuple[float, float]]]:
    """Return lines along x and z, and the singular corners."""
    fillet, between, cover, pressed = section
    _, half_layer, half_target = fillet
    if fillet.radius > 0.0:
        corners = [] if fillet.flush else [(-half_target, 1.0), (half_target, 1.0)]
        return *fillet_lines(fillet, cells, grading), corners
    breaks = [-half_layer, half_layer] if fillet.flush else [-half_layer, -half_target, half_target, half_layer]
    levels = [0.0, *(each.height for each in between), 1.0]
    rims = list[tuple[float, float]]()
    if cover is not None:
        breaks, levels = sorted({*breaks, -cover.half_x, cover.half_x}), [*levels, *cover.levels]
        breaks = pressed.among(breaks)
        rims = [(half_target, cover.levels[0]), (cover.half_x, 1.0)]
    x, z = (
        graded_lines(ends, [matched_cells(b - a, cells, grading) for a, b in pairwise(ends)], grading)
        for ends in (breaks, levels)
    )
    x = divided_lines(x, pressed.near, 2 * cells)
    sides = [(x, each.height) for each in between if each.singular for x in (-half_layer, half_layer)]
    rims += [(half_layer, 0.0), (half_target, 1.0)]
    return x, z, [*((side * a, b) for a, b in rims for side in (-1.0, 1.0)), *sides]


@lru_cache(maxsize=32)
def _numbered(section: Section, cells: int, grading: float, fan: bool, axial: bool) -> _Numbered:
    """Make a mesh with bonds and faces, shared by bodies."""
    mesh, cover = _mesh(section, cells, grading, fan, axial), section.cover
    x, z = mesh.nodes.T
    _, half_layer, half = section.fillet
    top = (z > 1.0 - 1e-9) & (np.abs(x) < half + 1e-9)
    if cover is not None:
        top &= z < cover.levels[0] + 1e-9
    held = np.repeat((z < 1e-9) | top, 2)
    held[::2] |= axial & (x < 1e-9)
    free = np.flatnonzero(~held)
    bonded = 2 * np.flatnonzero(top)[:, None] + np.arange(2)
    X = np.column_stack([x[top], np.zeros((np.count_nonzero(top), 2))])
    outline = PlateOutline(half, half if axial else _ENDLESS, axial)
    if cover is not None:
        X[:, 2] = z[top] - 1.0
        line = covered_faces(mesh, half_layer, cover)
        none = np.zeros(0, dtype=np.int64)  # of the free faces can meet the target
        around = Faces(line[1:] if mesh.hoop else line[1:-1], none, none, outline, (line,), section_skin(mesh, (line,)))
        return _Numbered(mesh, free, bonded, X, around, (("ground", edge_points(mesh, [line])),))
    sides, upper = side_faces(mesh), top_faces(mesh, half)
    inner = np.concatenate([face[1:-1] for face in sides])
    above = np.concatenate([np.zeros(0, dtype=np.int64), *(face[1:] for face in upper)])
    under = inner if not upper else above[:0]
    pairs = zip(sides, upper or sides, strict=True)
    lines = tuple(np.concatenate([side, face[::-1][1:]]) if upper else side for side, face in pairs)
    faces = Faces(inner, under, above, outline, lines, section_skin(mesh, lines))
    ground, other = edge_points(mesh, sides), edge_points(mesh, upper) if upper else edge_points(mesh, sides)
    surfaces: tuple[tuple[Plane, Surface], ...] = (("ground", ground), ("wall" if upper else "plane", other))
    return _Numbered(mesh, free, bonded, X, faces, surfaces)


def _parts(own: _Numbered, guard: float, depth: float, friction: float = 0.0) -> tuple[Part, ...]:
    """Make guard and contacts of a body on a mesh."""
    return (
        *((VolumeBarrier(own.mesh, guard),) if guard > 0.0 else ()),
        *contacts(own.faces, own.surfaces, depth, friction),
    )


@lru_cache(maxsize=32)
def _pattern(own: _Numbered, guarded: bool, touching: bool, pressed: Surface | None) -> Pattern:
    """Make the pattern of bodies on one mesh, with or without guard and contact; cached."""
    zero = np.zeros(own.mesh.nodes.size)
    terms = [part(zero, np.zeros(6)) for part in _parts(own, float(guarded), float(touching))]
    more = () if pressed is None else (pressed.numbers_of_shape,)
    numbers = (own.mesh.dofs, *(term.numbers for term in terms), *more)
    return pattern(own.mesh, numbers, own.free, border(own.mesh, own.bonded))


def layer_scales(sensor: Sensor, axial: bool = False) -> Scales:
    """Return SI scales of motions and loads in plane strain, a force spread over the elastomer's length, or turned."""
    _, elastomer = layer_parts(sensor)
    t = elastomer.thickness
    deep = t if axial else elastomer.extent[1]
    return Scales(t, elastomer.shear_modulus * t * deep, elastomer.standoff)


def layer_parts(sensor: Sensor) -> tuple[Target, Elastomer]:
    """Return target and elastomer of a scene; refuse one without."""
    if sensor.target is None or sensor.elastomer is None:
        missing = "target" if sensor.target is None else "elastomer"
        raise ValueError(f"{missing}: must be given for a force to move the target; it is missing")
    return sensor.target, sensor.elastomer


@dataclass(frozen=True)
class VolumeBarrier:
    """A barrier that keeps J > 0 at the nodes of a section's elements."""

    mesh: MixedMesh
    kappa: float  # part of the bulk modulus [shear moduli]

    def __call__(self, u: Array, q: Array) -> Term:
        """Return energy, forces and stiffness of the guard; `q` is not used."""
        mesh = self.mesh
        if mesh.nodal is None:
            raise ValueError("mesh: must hold the gradients at its nodes")
        slope, weights = mesh.nodal
        F, J = deformation(mesh, u, mesh.nodal)
        state = kinematics(F)
        (e, q_, j, k), d = slope.shape, mesh.nodes.shape[1]
        each = np.zeros((e, q_, d, j, d, k))  # F by an element's displacements
        for i in range(d):
            each[:, :, i, :, i] = slope
        B = each.reshape(e, q_ * d * j, d * k)
        first, second = self.kappa * weights * (1.0 - 1.0 / J), self.kappa * weights / J**2
        forces = summed(mesh.dofs, taken(mesh, first[..., None] * state.H).reshape(e, 1, -1) @ B, len(u) + 6)
        C = second[..., None, None] * state.H[..., :, None] * state.H[..., None, :]
        state.add_L(C, first)
        stiffness = B.swapaxes(1, 2) @ (taken_tangents(mesh, C) @ B.reshape(e, q_, d * j, d * k)).reshape(B.shape)
        energy = self.kappa * float((weights * (J - 1.0 - np.log(J))).sum())
        return Term(energy, forces, mesh.dofs, stiffness)
