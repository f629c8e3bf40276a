"""Say how deep a touch presses, and what a pose at a depth is off by.

A depth D stands in place of a force: how far what presses comes down from where it first touches, on a cover its lowest
point below the top at rest. A bare target is rigid: with r the touched point, t its thickness and z_0 the height of its
lower face without load,

    d = z_0 + t - (r_z + rho (n_z - 1)),

whose slope by the pose is g = (0, -1, r_x, 0, -r_y, 0) from its middle. A model whose pose is off by e under a force is
off by d(q + e) - D at the force that is taken for that of D. With s = dq/dd it is off at the depth by

    (1 - s g^T) e - s (d - D)    on the bare target,    e - s (e_d + d - D)    on a cover,

and the force by ``dF/dd (e_d + d - D)``, e_d the depth's error of the meshes that the force was found on: errors add by
their sizes.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.levels.answer import relative
from sits_mech.mechanics.touch import answering, contact_point
from sits_mech.notes import NoteKind
from sits_mech.quantities import Array, Equilibrium, MechanicalModel, Pose, Wrench
from sits_mech.scene.sensor import Sensor


class Depth(NamedTuple):
    """How deep a touch presses in place of a force that is given, and what goes with it near there."""

    depth: float  # D [m]
    rest: float  # height of the target's lower face without load [m]
    per_depth: Array  # dq/dd of the pose (6,) [1, rad/m]
    force: float  # dF/dd [N/m]
    off: float  # of the depth that the force leads to, its error and what is left [m]


class TouchLoad(NamedTuple):
    """The load of a scene's touch by its force, or by its depth.

    Attributes
    ----------
    wrench : Wrench
        About the touched point [N, N m].
    depth : Depth or None
        The depth that it leads to, and what goes with it; None where the force is given.
    found : Equilibrium or None
        The rest that it was found by, its error without what the model leaves out; None where the force is given.
    """

    wrench: Wrench
    depth: Depth | None = None
    found: Equilibrium | None = None


def to_depth(layer: MechanicalModel, sensor: Sensor, depth: Depth) -> MechanicalModel:
    """Return the model of a touch by the force that leads to a depth, with errors at that depth."""
    return answering(layer, sensor, partial(_answered, depth))


def _answered(
    depth: Depth, layer: MechanicalModel, sensor: Sensor, wrench: Wrench, start: Equilibrium | None
) -> Equilibrium:
    """Return the equilibrium of a touch under a force, with its error at the depth; raises as the model."""
    return at_depth(sensor, layer.equilibrium(wrench, start=start), depth)


def depth_of(sensor: Sensor, found: Equilibrium, rest: float) -> tuple[float, float, Array]:
    """Return how deep what presses is pushed in from where it first touches, its error [m], and its slope by the pose.

    `rest`: height of the target's lower face without load [m]. On a cover the depth is no function of the pose.
    """
    if found.sunk is not None:
        return *found.sunk, np.zeros(6)
    r, n = contact_point(sensor, found.wrench, found.pose)
    t = 0.0 if sensor.target is None else sensor.target.thickness
    x, y, _ = r - found.pose.centre
    g = np.array([0.0, -1.0, x, 0.0, -y, 0.0])
    lowest = float(r[2]) + (0.0 if sensor.touch is None else sensor.touch.radius or 0.0) * float(n[2] - 1.0)
    return rest + t - lowest, float(np.abs(g) @ found.error.components), g


def at_depth(sensor: Sensor, found: Equilibrium, aim: Depth) -> Equilibrium:
    """Return an equilibrium whose error is that at a depth, not under a force, and what the force may be off by."""
    d, _, g = depth_of(sensor, found, aim.rest)
    left = abs(d - aim.depth) if g.any() else aim.off
    e = np.abs(np.eye(6) - np.outer(aim.per_depth, g)) @ found.error.components + np.abs(aim.per_depth) * left
    half = 0.0 if sensor.target is None else 0.5 * max(sensor.target.extent)
    lever, way = np.array([1.0, 1.0, half, 1.0, half, half]), found.pose.components - Pose(0.0, aim.rest).components
    missed = NoteKind.TOLERANCE_MISSED
    report = replace(found.report, estimated_error=relative(e, way, lever), notes=tuple(
        note for note in found.report.notes if note.kind is not missed
    ))
    for note in (each for each in found.report.notes if each.kind is missed):
        report = report.judged(float(note.known["tolerance"]))
    return replace(found, error=Pose.of(e), report=report, error_F_z=aim.force * aim.off)
