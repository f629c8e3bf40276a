"""Families of meshes of the planar layer, and of a half meridian about an axis.

A family of meshes (levels/family.py) has cells at the singular corners that are split into triangles (element/mesh.py),
which follow a corner that opens at finite strain, and lines graded towards it. Where it does not get to a load, a
mildly graded one with a guard on J does (levels/settle.py). The first two levels alone are guarded: finer ones correct
the target's place, and an order is seen on meshes of one kind.

Order. With exponent k of the displacements at the corner and lines graded with beta, poses converge as ``m**(-2 k
beta)``: k = 0.5 at the edge of a target in the middle of a face, 0.5946 at the corner of a flush layer, an
incompressible right angle, and 1.47 at the 30 degrees of a fillet, where the order of the elements limits it. (Sink of
a 20/15/2 mm layer under 1810 N/m, 4, 6, 8, 12, 16 cells, graded 2: extrapolated neighbours 100.54, 100.84, 100.86,
100.95 um. The small rise at the end is a crease at the target's edge, which ever finer cells follow further.)

The effect of `elastomer.edge_radius` (fillet.py) on the pose is that at small strain: the layer's compliance at rest,
with fillets and with sharp edges, each extrapolated from its first three meshes, applied to one load.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.equilibrium.body import Bonded
from sits_mech.mechanics.equilibrium.newton import small_strain_compliance
from sits_mech.mechanics.levels.family import Levels, Line, cache_changes, contact_depth, of_one_pad
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body, layer_parts, layer_scales
from sits_mech.mechanics.pad.stack import PRESSED, widened
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Elastomer, Sensor
from sits_mech.units import checked_tolerance

SIZES = (4.0, 6.0, 8.0, 12.0, 16.0, 24.0)
"""Cells through the thickness, level by level."""
GRADING = 2.0
"""Power of the lines' spacing towards the corners."""
SHARE = 0.05
"""Floor of component errors, as a share of the worst."""

_EDGE, _CORNER, _FILLET = 0.5, 0.5946, 1.47  # exponents of the displacements
_HIGHEST = 4.0  # order that the elements allow
_DEPTH = 1e-5  # thicknesses over which the pressure of contact builds up
_LEVELS = 3  # meshes of each


class _Kind(NamedTuple):
    """Grading and guard; corners are split."""

    grading: float
    guard: float


_KINDS = (_Kind(GRADING, 0.0), _Kind(1.5, 2.0))


def section_families(sensor: Sensor, tolerance: float, *, axial: bool = False) -> Line:
    """Return the families of meshes of a layer, or of a half meridian, in the order they are tried."""
    checked_tolerance(tolerance)
    contact = sensor.elastomer.contact if sensor.elastomer is not None else "never"
    depths = {"never": (0.0,), "always": (_DEPTH,), "auto": (0.0, _DEPTH)}[contact]
    makers = [partial(_family, sensor, kind, depth, axial) for depth in depths for kind in _KINDS]
    makers[0]().maker(0)  # refuses a scene that has no mesh
    return Line(sensor, layer_scales(sensor, axial), makers, tolerance)


def layer_family(sensor: Sensor, axial: bool = False) -> Levels:
    """Return the first family of meshes, without contact."""
    return _family(sensor, _KINDS[0], 0.0, axial)


def order_of(sensor: Sensor, grading: float) -> float:
    """Return the convergence order of poses for a grading."""
    target, elastomer = layer_parts(sensor)
    half_target, half_layer = (0.5 * part.extent[0] / elastomer.thickness for part in (target, elastomer))
    if widened(half_target, half_layer) < half_layer:
        exponent = _EDGE
    else:
        exponent = _CORNER if elastomer.edge_radius is None else _FILLET
    return min(2.0 * exponent * grading, _HIGHEST)


@of_one_pad
def _family(sensor: Sensor, kind: _Kind, depth: float, axial: bool) -> Levels:
    """Make a family of one kind; coarser meshes have a larger contact depth."""

    def made_of(scene: Sensor, level: int) -> Bonded:
        """Make a level of a scene."""
        guard, own = kind.guard if level < 2 else 0.0, contact_depth(depth, SIZES, level)
        pressed = contact_depth(PRESSED, SIZES, level)
        return bonded_body(scene, SectionFineness(int(SIZES[level]), kind.grading, True, guard, own, axial, pressed))

    def changed(other: Sensor, level: int) -> Bonded | None:
        """Make a level of a changed scene."""
        own, body = made_of(sensor, level), made_of(other, level)
        return body if np.array_equal(body.mesh.cells, own.mesh.cells) else None

    _, elastomer = layer_parts(sensor)
    wide = max(1, round(elastomer.extent[0] / elastomer.thickness / (1 + axial)))
    terms = np.array(SIZES)[:, None] ** (-order_of(sensor, kind.grading) * np.array([1.0, 2.0]))

    def cells(level: int) -> tuple[int, ...]:
        """Return the cells along each axis."""
        return wide * int(SIZES[level]), int(SIZES[level])

    return Levels(terms, cells, partial(made_of, sensor), lambda level: None, SHARE, cache_changes(changed))


class Edges(NamedTuple):
    """Scaled compliances with fillets and with sharp edges, (3, 3)."""

    rounded: Array
    sharp: Array
    height: float  # of the force above the bonded face
    flush: bool  # the layer ends with its target
    radius: float  # from the scene [m]


def edge_effect(sensor: Sensor, axial: bool = False) -> Edges | None:
    """Return the effect of the fillets of a sensor's layer; None for sharp edges."""
    elastomer, target = sensor.elastomer, sensor.target
    if elastomer is None or target is None or elastomer.edge_radius is None:
        return None
    plain = Elastomer.model_validate(elastomer.model_dump() | {"edge_radius": None})
    rounded, sharp = (_compliance(scene, axial) for scene in (sensor, sensor.model_copy(update={"elastomer": plain})))
    flush = elastomer.extent[0] - target.extent[0] < 1e-9 * elastomer.thickness
    return Edges(rounded, sharp, target.load_height / elastomer.thickness, flush, elastomer.edge_radius)


def _compliance(sensor: Sensor, axial: bool) -> Array:
    """Return the compliance of a layer at rest, scaled, shape (3, 3)."""
    levels = layer_family(sensor, axial)
    bodies = [levels.maker(level) for level in range(_LEVELS)]
    found = [small_strain_compliance(body)[0].ravel() for body in bodies]
    return levels.limit(found).value.reshape(3, 3)


def edge_notes(edges: Edges, load: Array, thickness: float) -> tuple[Note, ...]:
    """Return notes on the fillets under a load F_x, F_z, M, scaled; thickness in m."""
    force = np.array([load[0], -load[1], load[2] + edges.height * load[0]])
    d_h, d_z, alpha = (edges.rounded - edges.sharp) @ force * [thickness, thickness, 1.0]
    moved = Note.of(NoteKind.EDGE_RADIUS, radius=edges.radius, d_h=float(d_h), d_v=float(d_z), alpha=float(alpha))
    return (moved,) if edges.flush else (moved, Note(NoteKind.EDGE_SHARP))
