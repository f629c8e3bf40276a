"""The layer's section as a body to solve: mesh, bonds, law, scales.

Lines are graded towards both faces and towards the target's and the layer's edges, where bonded corners are singular
(exponent 0.5946 for an incompressible clamped right angle against a free face). Too strong a grading resolves a corner
that finite strain then turns inside out: a nonlinear layer takes a milder one than a linear layer.

Scales: lengths by the thickness t, stresses by the initial shear modulus mu; per depth, forces by mu t and moments by
mu t^2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np

from sits_mech.mechanics.assembly import Pattern, pattern
from sits_mech.mechanics.body import Bonded, Part
from sits_mech.mechanics.contact import Contact, Guard, face_along
from sits_mech.mechanics.energy import plane_energy
from sits_mech.mechanics.fan import fanned
from sits_mech.mechanics.fillet import Fillet, checked, drawn_in, fillet_lines
from sits_mech.mechanics.forms import Indices, Section, entries, section
from sits_mech.meshing.structured import graded_lines, matched_cells
from sits_mech.quantities import Array, Wrench
from sits_mech.sensor import Elastomer, Sensor, Target

_GUARD_SHARE = 0.005  # of the bulk modulus that may act pointwise


@dataclass(frozen=True)
class Fineness:
    """How a layer is divided.

    Attributes
    ----------
    cells : int
        Cells through the thickness, even.
    grading : float
        Power of the lines' spacing towards the corners; 1 is uniform.
    fan : bool
        Whether the cells at the singular corners are split into triangles (fan.py).
    guard : float
        Part of the bulk modulus that acts pointwise against inversion [shear moduli].
    give : float
        Depth over which the pressure of contact builds up; 0 for no contact [thicknesses].
    """

    cells: int
    grading: float
    fan: bool = False
    guard: float = 0.0
    give: float = 0.0


def bonded_body(sensor: Sensor, fineness: Fineness) -> Bonded:
    """Return the layer of a sensor with its target, meshed and scaled."""
    cells, grading = fineness.cells, fineness.grading
    target, elastomer = _parts(sensor)
    t = elastomer.thickness
    half_layer, half_target = elastomer.extent[0] / (2 * t), target.extent[0] / (2 * t)
    edges = Fillet(_radius(elastomer), half_layer, half_target)
    edges = checked(edges, t) if edges.radius > 0.0 else edges
    mesh, (free, bonded, X), (rows, columns) = _numbered(edges, cells, grading, fineness.fan)
    silicone = elastomer.silicone
    K = silicone.bulk_modulus / silicone.shear_modulus
    guard = min(fineness.guard, _GUARD_SHARE * K)
    parts = (*((Guard(mesh, guard),) if guard > 0.0 else ()), *_contacts(mesh, half_target, fineness.give))
    height, law = target.load_height / t, plane_energy(silicone)
    kind = (edges, cells, grading, fineness.fan, guard > 0.0, fineness.give > 0.0)
    return Bonded(
        mesh, law, K - guard, height, free, bonded, X, rows, columns, parts=parts, guarded=guard > 0.0,
        shared=partial(_pattern, kind),
    )


def _bonds(mesh: Section, half_target: float) -> tuple[Indices, Indices, Array]:
    """Free displacements, bonded ones, and these nodes' distances from the target's centre."""
    x, z = mesh.nodes.T
    top = (z > 1.0 - 1e-9) & (np.abs(x) < half_target + 1e-9)
    free = np.flatnonzero(~np.repeat((z < 1e-9) | top, 2))
    return free, 2 * np.flatnonzero(top)[:, None] + np.arange(2), x[top]


def side_faces(mesh: Section) -> list[Indices]:
    """Return the nodes of the left and the right face, from the ground upwards."""
    x, z = mesh.places.T
    faces = (np.flatnonzero(np.abs(x - end) < 1e-9) for end in (mesh.x[0], mesh.x[-1]))
    return [face[np.argsort(z[face])] for face in faces]


def top_faces(mesh: Section, half: float) -> list[Indices]:
    """Return the nodes of the top face left and right of a target of half width `half`, outwards from its edge."""
    x, z = mesh.places.T
    if mesh.x[-1] - half < 1e-9:
        return []
    faces = (np.flatnonzero((z > 1.0 - 1e-9) & (side * x > half - 1e-9)) for side in (-1.0, 1.0))
    return [face[np.argsort(np.abs(x[face]))] for face in faces]


def _mesh(edges: Fillet, cells: int, grading: float, fan: bool) -> Section:
    """Mesh of a layer and a target of some half widths, with an edge radius or with none."""
    _, half_layer, half_target = edges
    if edges.radius > 0.0:
        mesh = section(*fillet_lines(edges, cells, grading), partial(drawn_in, edges))
        corners = [] if edges.flush else [(side * half_target, 1.0) for side in (-1.0, 1.0)]
        return fanned(mesh, np.array(corners)) if fan and corners else mesh
    breaks = [-half_layer, half_layer] if edges.flush else [-half_layer, -half_target, half_target, half_layer]
    counts = [matched_cells(b - a, 1.0, cells, grading) for a, b in zip(breaks[:-1], breaks[1:], strict=True)]
    mesh = section(graded_lines(breaks, counts, grading), graded_lines([0.0, 1.0], [cells], grading))
    corners = [(side * half, z) for half, z in ((half_layer, 0.0), (half_target, 1.0)) for side in (-1.0, 1.0)]
    return fanned(mesh, np.array(corners)) if fan else mesh


@lru_cache(maxsize=32)
def _numbered(
    edges: Fillet, cells: int, grading: float, fan: bool
) -> tuple[Section, tuple[Indices, Indices, Array], tuple[Indices, Indices]]:
    """A mesh with its bonds and the places of its stiffnesses; many bodies share one."""
    mesh = _mesh(edges, cells, grading, fan)
    return mesh, _bonds(mesh, edges.half_target), entries(mesh.dofs)


@lru_cache(maxsize=32)
def _pattern(kind: tuple[Fillet, int, float, bool, bool, bool]) -> Pattern:
    """Pattern of the bodies on one mesh, with a guard or not, in contact or not; many share one.

    Guard and contact of edges couple no displacements that the elements do not: the order of elimination stays.
    """
    edges, cells, grading, fan, guarded, touching = kind
    mesh, (free, bonded, _), places = _numbered(edges, cells, grading, fan)
    zero = np.zeros(mesh.nodes.size)
    parts = (*((Guard(mesh, 1.0),) if guarded else ()), *_contacts(mesh, edges.half_target, float(touching)))
    terms = [part(zero, np.zeros(3)) for part in parts]
    each = (places, *((term.rows, term.columns) for term in terms))
    rows, columns = (np.concatenate(own) for own in zip(*each, strict=True))
    plain = not guarded and not touching
    order = free if plain else _pattern((edges, cells, grading, fan, False, False)).free
    border = np.concatenate([bonded.ravel(), mesh.nodes.size + np.arange(3)])
    return pattern(rows, columns, order, border, ordered=not plain)


def _radius(elastomer: Elastomer) -> float:
    """Edge radius [thicknesses]; 0 for sharp edges."""
    return (elastomer.edge_radius or 0.0) / elastomer.thickness


def _contacts(mesh: Section, half: float, give: float) -> tuple[Part, ...]:
    """Contacts of the free faces; none without a length over which they give."""
    if give == 0.0:
        return ()
    sides, top = side_faces(mesh), top_faces(mesh, half)
    ground = Contact(face_along(mesh, sides), "ground", give, half)
    if top:
        return ground, Contact(face_along(mesh, top), "wall", give, half)
    return ground, Contact(ground.face, "plane", give, half)


def force_unit(sensor: Sensor) -> float:
    """Return the force that is one in the body's scales [N]; moments in it times the thickness."""
    _, elastomer = _parts(sensor)
    return elastomer.silicone.shear_modulus * elastomer.thickness * elastomer.extent[1]


def scaled_load(sensor: Sensor, wrench: Wrench) -> Array:
    """Return F_x, F_z, M per depth in the body's scales."""
    _, elastomer = _parts(sensor)
    return np.array([wrench.F_x, wrench.F_z, wrench.M / elastomer.thickness]) / force_unit(sensor)


def wrench_between(before: Wrench, after: Wrench, part: float) -> Wrench:
    """Return the wrench at a part, from 0 to 1, of the straight path from one to another."""
    if part == 1.0:
        return after
    pairs = zip((before.F_x, before.F_z, before.M), (after.F_x, after.F_z, after.M), strict=True)
    return Wrench(*((1.0 - part) * a + part * b for a, b in pairs))


def _parts(sensor: Sensor) -> tuple[Target, Elastomer]:
    """Target and elastomer of a scene that has both."""
    if sensor.target is None or sensor.elastomer is None:
        missing = "target" if sensor.target is None else "elastomer"
        raise ValueError(f"{missing}: must be given for a force to move the target; it is missing")
    return sensor.target, sensor.elastomer
