"""Does a pose leave the target above the coils? Asked before anything is solved.

The target's section in its own frame is ``|xi| <= a, 0 <= eta <= t``; a clockwise rotation by alpha about the centre
of the bottom face takes it to

    x = d_h + xi cos(alpha) + eta sin(alpha),    z = d_v - xi sin(alpha) + eta cos(alpha),

so its lowest corner is at ``d_v - a |sin(alpha)| + min(t cos(alpha), 0)``. The coil plane is z = 0.
"""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Array, Pose
from sits_mech.sensor import Sensor


class Collision(ValueError):
    """A pose in which the target touches or passes the coil plane."""


def clearance(sensor: Sensor, pose: Pose) -> Array:
    """Return the height of the target's lowest point above the coil plane [m], in the shape of the pose."""
    if sensor.target is None:
        return np.full(np.shape(pose.d_v), np.inf)
    alpha = np.asarray(pose.alpha, dtype=float)
    side = sensor.target.extent[0] / 2 * np.abs(np.sin(alpha))
    return np.asarray(pose.d_v - side + np.minimum(sensor.target.thickness * np.cos(alpha), 0.0))


def check_clearance(sensor: Sensor, pose: Pose) -> None:
    """Raise Collision if any pose brings the target to the coil plane or is not a number."""
    gap = clearance(sensor, pose)
    if np.all(gap > 0.0) and np.all(np.isfinite(pose.d_h)):
        return
    index = int(np.argmin(np.where(np.isnan(gap), -np.inf, gap)))
    d_h, d_v, alpha = (float(np.broadcast_to(v, gap.shape).flat[index]) for v in (pose.d_h, pose.d_v, pose.alpha))
    raise Collision(
        f"pose: the target must stay above the coil plane z = 0, its lowest point is at {gap.flat[index] * 1e3:.4g} mm "
        f"for d_h = {d_h * 1e3:.4g} mm, d_v = {d_v * 1e3:.4g} mm, alpha = {np.degrees(alpha):.4g} deg"
    )
