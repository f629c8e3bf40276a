"""Tell what the bending of a target changes of an answer: how far it moves what the coils see of it.

A coil c with 1 A sees a plate move by w(x, y) towards it, to first order, as (J. C. Slater, Microwave Electronics
(1950), section 4.10, of metal thick against its skin depth)

    dL_c = -mu0 int H_t^2 dw dA,        H_t twice that of the coil alone (its image in the plate),

so that what is bent counts as a motion by its mean over the target with the weight H_t^2,

    b_c = mean_c (w - w_rigid),         h_c = mean_c w_rigid.

Both are those of rigid motions, by least squares over the coils (mechanics/bending.py); what the rigid target's answer
leaves out of d_v, alpha and alpha_x is the largest of one over the largest of the other, of all loads that are asked.
The chain makes errors of the inductances of it, as of all that the mechanics leave out. All rigid targets
leave it out alike. Where it takes half of the tolerance, a model that bends the target is taken: `block`, `axisymmetric`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np

from sits_mech.chain.propagation import levers, unloaded_pose
from sits_mech.magnetics.coils.ring_field import coil_potential
from sits_mech.mechanics.bending import Bending, BondedPlate, bonded_plate
from sits_mech.mechanics.touch import on_target
from sits_mech.notes import Omission, OmissionKind, Relative
from sits_mech.quantities import POSE, Array, Pose, Wrench
from sits_mech.scene.sensor import Coil, Sensor

_STEP = 1e-3  # of a height, over which fields are differences of potentials: to 1e-6
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
        plate = bonded_plate(sensor)
    except ValueError:  # no mesh, such as of a hair
        known = (("stiffness", stiffness),)
        return (Omission(OmissionKind.BENDING, math.nan, Relative.DISPLACEMENT, numbers=known),)
    parts, deflection = _changes(sensor, plate, on_target(sensor, loads), stiffness)
    parts *= parts.max() > least
    known, bare = sensor.target.metal.youngs_modulus is not None, sensor.target.bare
    numbers = (("deflection", deflection), ("stiffness", stiffness), ("known", known), ("bare", bare))
    return (Omission(
        OmissionKind.BENDING, float(parts.max()), Relative.DISPLACEMENT, numbers=numbers, parts=tuple(parts.tolist())
    ),)


def _changes(sensor: Sensor, plate: BondedPlate, loads: Sequence[Wrench], stiffness: float) -> tuple[Array, float]:
    """Return what bending changes of a pose, over its components (6,), and the largest deflection under loads [m]."""
    found, weights = plate.bent(loads, stiffness), seen_shares(sensor, plate, unloaded_pose(sensor))
    bend, rigid = (plate.as_motion(part @ weights, weights) for part in (found.bend, found.rigid))
    moved, lever, changes = np.abs(rigid[0]).max(axis=0), levers(sensor), np.abs(bend[0])
    changes[:, POSE.index("d_v")] += bend[1]
    seen = moved * lever > _SEEN * np.abs(found.rigid).max()
    shares = np.divide(changes.max(axis=0), moved, out=np.zeros(len(POSE)), where=seen)
    return shares, float(np.abs(found.bend).max())


def solved_bending(sensor: Sensor) -> Bending:
    """Return what bends a target at its loads; raises as `bonded_plate`."""
    plate = bonded_plate(sensor)
    stiffness = plate.target.bending_stiffness or math.inf  # without one no size is known: it stays rigid
    return Bending(plate, stiffness, partial(seen_shares, sensor, plate))


def seen_shares(sensor: Sensor, plate: BondedPlate, pose: Pose) -> Array:
    """Return what points of a target at a pose count for coils, shape (p, n), each coil's sum one."""
    places, height = plate.places + np.array([pose.d_h, pose.d_y]), float(pose.d_v)
    own = np.stack([plate.areas * _field_squared(coil, places, height) for coil in sensor.coils], axis=1)
    return np.asarray(own / own.sum(axis=0))


def _field_squared(coil: Coil, places: Array, height: float) -> Array:
    """Return H_t^2 of a coil at places (p, 2) in a plane, up to a factor, by the slope of its potential, shape (p,)."""
    ends = np.array([height * (1.0 - _STEP), height * (1.0 + _STEP)])
    points = np.column_stack([np.tile(places, (2, 1)), np.repeat(ends, len(places))])
    low, high = np.split(coil_potential(coil, points, float(ends[0])), 2)
    return np.asarray(((high - low) ** 2).sum(axis=1))
