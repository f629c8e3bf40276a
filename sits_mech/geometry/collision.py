"""Does a pose leave the target above the coils? Asked before anything is solved.

A box |xi| <= a, |eta| <= b, 0 <= zeta <= t around the target, in its own frame, is turned by R about the centre of its
bottom face, which stands at height d_v; so its lowest corner is at

    d_v - a |R_zx| - b |R_zy| + min(t R_zz, 0),        of a disc of radius a    d_v - a |(R_zx, R_zy)| + min(t R_zz, 0).

The coil plane is z = 0.
"""

from __future__ import annotations

import numpy as np

from sits_mech.geometry.turns import rotation_matrix
from sits_mech.quantities import POSE, Array, Pose
from sits_mech.sensor import Sensor


class Collision(ValueError):
    """A pose in which the target touches or passes the coil plane."""


def clearance(sensor: Sensor, pose: Pose) -> Array:
    """Return the height of the target's lowest point above the coil plane [m], in the shape of the pose."""
    if sensor.target is None:
        return np.full(pose.components.shape[:-1], np.inf)
    down = rotation_matrix(pose.rotation)[..., 2, :]
    half = np.array(sensor.target.extent) / 2.0
    sides = np.abs(down[..., :2]) * half
    side = np.hypot(*np.moveaxis(sides, -1, 0)) if sensor.target.shape == "disc" else sides.sum(axis=-1)
    return np.asarray(pose.centre[..., 2] - side + np.minimum(sensor.target.thickness * down[..., 2], 0.0))


def check_clearance(sensor: Sensor, pose: Pose) -> None:
    """Raise Collision if any pose brings the target to the coil plane or is not a number."""
    gap = clearance(sensor, pose)
    places = pose.components
    if np.all(gap > 0.0) and np.all(np.isfinite(places)):
        return
    index = np.unravel_index(int(np.argmin(np.where(np.isnan(gap), -np.inf, gap))), gap.shape)
    named = [(name, float(value)) for name, value in zip(POSE, places[index], strict=True)]
    shown = [(name, value) for k, (name, value) in enumerate(named) if k < 3 or value != 0.0]
    words = (
        f"{name} = {1e3 * value:.4g} mm" if name.startswith("d") else f"{name} = {np.degrees(value):.4g} deg"
        for name, value in shown
    )
    raise Collision(
        f"pose: the target must stay above the coil plane z = 0, its lowest point is at {gap[index] * 1e3:.4g} mm "
        f"for {', '.join(words)}"
    )
