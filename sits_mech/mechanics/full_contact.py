"""What is the contact worth that the whole pad leaves out? An estimate from the half pad, which solves it.

A load of all six components is laid into a plane of symmetry: the horizontal force F_h and the moment that turns the
target along it, or where there is none the whole horizontal moment, along x or, where more of it goes along y, along y;

    F_h = |(F_x, F_y)|,    M = |(M_x, M_y)|, signed as M_y F_x - M_x F_y;    F_z as it is;    M_z left out.

The half pad (block.py) is solved for that load without contact and with it. The differences in d_h, d_v and alpha are
the worth for both horizontal places, the height and both tilts; the twist's is the same share of itself as the
difference is of the displacement. An estimate, no bound: folds on the sides that the plane does not see are not in it.
"""

from __future__ import annotations

import numpy as np

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.block_mesh import pad_parts
from sits_mech.quantities import Array, SolveFailed, Wrench
from sits_mech.sensor import Sensor


def contact_worth(sensor: Sensor, forces: Array, pose: Array, tolerance: float) -> tuple[Array, str]:
    """Return how far contact would move a target, and a sentence about it.

    Parameters
    ----------
    sensor : Sensor
        With a target and an elastomer.
    forces : ndarray, shape (6,)
        F_x, F_y, F_z, M_x, M_y, M_z of the load, F_z downwards [N, N m].
    pose : ndarray, shape (6,)
        Displacement of the target's centre and its rotation vector without contact [m, rad].
    tolerance : float
        Of the half pad's pose.

    Returns
    -------
    worth : ndarray, shape (6,)
        Sizes of the changes of the pose [m, rad]; all of the displacement where the half pad tells none.
    note : str
    """
    target, elastomer = pad_parts(sensor)
    reach = float(max(target.extent)) / 2.0
    wrench, turned = _in_plane(forces)
    own = _turned(sensor) if turned else sensor
    try:
        free, held = (_moved(own, contact, wrench, tolerance) for contact in ("never", "auto"))
    except SolveFailed:
        lever = np.repeat([1.0, reach], 3)
        note = "what its contact is worth could not be found: the estimated error is the whole displacement"
        return np.max(np.abs(pose) * lever) / lever, note
    lever = np.array([1.0, 1.0, reach])
    along, up, tilt = np.abs(held - free)
    share = float(np.max(np.abs(held - free) * lever) / np.max(np.abs(free) * lever))
    note = f"contact would move the target by about {share:.2g} of this, which is in the estimated error"
    return np.array([along, along, up, tilt, tilt, share * abs(float(pose[5]))]), note


def _in_plane(forces: Array) -> tuple[Wrench, bool]:
    """The load laid into a plane, and whether that is the one along y."""
    (F_x, F_y, F_z), (M_x, M_y) = forces[:3], forces[3:5]
    sign = -1.0 if M_y * F_x < M_x * F_y else 1.0
    F_h, M = float(np.hypot(F_x, F_y)), sign * float(np.hypot(M_x, M_y))
    return Wrench(F_h, float(F_z), M), bool(abs(F_y) > abs(F_x) if F_h > 0.0 else abs(M_x) > abs(M_y))


def _turned(sensor: Sensor) -> Sensor:
    """A sensor whose pad and target are turned by a quarter."""
    target, elastomer = pad_parts(sensor)
    parts = {
        name: part.model_copy(update={"width": part.length, "length": part.width})
        for name, part in (("target", target), ("elastomer", elastomer))
    }
    return sensor.model_copy(update=parts)


def _moved(sensor: Sensor, contact: str, wrench: Wrench, tolerance: float) -> Array:
    """How far the target moves, d_h, d_v, alpha [m, rad]."""
    _, elastomer = pad_parts(sensor)
    own = sensor.model_copy(update={"elastomer": elastomer.model_copy(update={"contact": contact})})
    pose = block_pad(own, tolerance).equilibrium(wrench).pose
    return np.array([pose.d_h, pose.d_v - elastomer.standoff - elastomer.thickness, pose.alpha], dtype=float)
