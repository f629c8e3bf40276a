"""Tell what the bending of a target changes of an answer: how far it moves what the coils see of it.

Coils see a plate whose points rise by w(x, y), to first order, as a flat one in the field that its points meet: what
its currents do to each other, bent up or down, is of second order. What they see of a shape phi_m over what they see of
the whole plate rising is, by differences of the model in space (magnetics/pose_slopes.py),

    b_c = dL_c(phi_m)/dL_c(1),

so that what is bent counts as a motion. A permeable plate is taken as one of copper.

All are those of rigid motions, by least squares over the coils (mechanics/foil/bending.py); what the rigid target's
answer leaves out of d_v, alpha and alpha_x is the largest of one over the largest of the other, of all loads that are
asked. The chain makes errors of the inductances of it, as of all that the mechanics leave out. All rigid targets
leave it out alike. Where it takes half of the tolerance, a model that bends the target is taken, `block` or
`axisymmetric`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache, partial

import numpy as np

from sits_mech.chain.propagation import levers, unloaded_pose
from sits_mech.magnetics.pose_slopes import lift_slopes
from sits_mech.mechanics.foil.bending import BondedPlate, CoilView, bonded_plate
from sits_mech.mechanics.foil.bent import Bending
from sits_mech.mechanics.touch import on_target
from sits_mech.notes import Omission, OmissionKind, Relative
from sits_mech.quantities import POSE, Array, Mask, Pose, SolveFailed, Wrench
from sits_mech.scene.sensor import Sensor

_MISSED, _OFF = 0.01, 0.2  # of mean |w|: a bowl shows 0.009 of it, by the square of fields 0.13; of permeable plates
_COPPER = {"material": "copper", "conductivity": None, "relative_permeability": None}
_SEEN = 1e-6  # of what the target moves at most: coils that see less of a part of a load see none of it


def bending(sensor: Sensor, loads: Sequence[Wrench], least: float = 0.0) -> tuple[Omission, ...]:
    """Return what the bending of the target leaves out of loads; without a size of no metal, or of no mesh.

    Up to `least`, the error that the finest meshes of a model have, it is none.
    """
    if sensor.target is None or sensor.elastomer is None or not any(load.components.any() for load in loads):
        return ()
    stiffness = sensor.target.bending_stiffness
    if stiffness is None:
        return (Omission(OmissionKind.BENDING, math.nan, Relative.DISPLACEMENT),)
    try:
        bonded_plate(sensor)
    except ValueError:  # no mesh, such as of a hair
        known = (("stiffness", stiffness),)
        return (Omission(OmissionKind.BENDING, math.nan, Relative.DISPLACEMENT, numbers=known),)
    parts, deflection = _changes(sensor, tuple(loads), least)
    given, bare = sensor.target.metal.youngs_modulus is not None, sensor.target.bare
    numbers = (("deflection", deflection), ("stiffness", stiffness), ("known", given), ("bare", bare))
    return (Omission(
        OmissionKind.BENDING, float(parts.max()), Relative.DISPLACEMENT, numbers=numbers, parts=tuple(parts.tolist())
    ),)


@lru_cache(maxsize=2)
def _changes(sensor: Sensor, loads: tuple[Wrench, ...], least: float) -> tuple[Array, float]:
    """Return what bending changes of a pose, over its components (6,), and the largest deflection under loads [m].

    Up to `least` it is zero.
    """
    plate = bonded_plate(sensor)
    found = plate.answers(on_target(sensor, loads), plate.target.bending_stiffness or math.inf)
    rises, bends = (np.abs(plate.upwards @ each).max() for each in found)
    if bends <= least * rises:
        return np.zeros(len(POSE)), float(bends)
    seen = seen_shapes(sensor, plate, unloaded_pose(sensor))
    rigid, bend = (plate.as_motion(each.T, seen) for each in found)
    moved, lever, changes = np.abs(rigid[0]).max(axis=0), levers(sensor), np.abs(bend[0])
    changes[:, POSE.index("d_v")] += bend[1]
    some = moved * lever > _SEEN * rises
    shares = np.divide(changes.max(axis=0), moved, out=np.zeros(len(POSE)), where=some)
    return shares * (shares.max() > least), float(bends)


def solved_bending(sensor: Sensor) -> Bending:
    """Return what bends a target at its loads; raises as `bonded_plate`."""
    plate = bonded_plate(sensor)
    stiffness = plate.target.bending_stiffness or math.inf  # without one no size is known: it stays rigid
    return Bending(plate, stiffness, partial(seen_shapes, sensor, plate))


def seen_shapes(sensor: Sensor, plate: BondedPlate, pose: Pose, asked: Mask | None = None) -> CoilView:
    """Return how coils see a target's motions and shapes at a pose; zero of those that are not `asked` for."""
    sizes = np.abs(plate.upwards).max(axis=0)
    some = np.flatnonzero((sizes > 0.0) & (True if asked is None else asked | (np.arange(len(sizes)) < len(POSE))))
    target, off = sensor.target or plate.target, _MISSED
    if target.metal.relative_permeability != 1.0:
        target, off = target.model_copy(update=_COPPER), _OFF
    flat = sensor.model_copy(update={"target": target, "substrate_radius": None})
    seen = np.zeros((len(sizes), len(sensor.coils)))
    try:
        planes = np.where(some < len(POSE), 0.0, plate.target.neutral_plane)  # poses turn about its lower face
        seen[some] = lift_slopes(flat, pose, lambda places: plate.lifts(places)[..., some], planes, sizes[some])
    except (SolveFailed, ValueError):  # at the coils, or too fine to be divided
        return CoilView(np.tile(plate.areas @ plate.upwards / plate.areas.sum(), (len(sensor.coils), 1)).T, 1.0)
    return CoilView(seen, off)
