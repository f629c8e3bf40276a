"""What does the sensor show under all six components of a load? The chain where it leaves the plane y = 0.

    F, M --(block_full)--> c +- e, w +- e --(sheets)--> L(c, exp [w]), R(c, exp [w]) --> signals

c is the place of the centre of the target's bottom face, w its rotation vector: the target has turned about the axis w
by the angle |w|, by the right hand, so that ``w_y`` alone is alpha. What the errors of the pose make of the answer is
told component by component, as in reading.py. The other models are plane, and do not see such a load or such a pose.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sits_mech.geometry.solids import lowest_points
from sits_mech.magnetics.sheets import sheets
from sits_mech.mechanics.block_full import FullPose, FullWrench, full_equilibrium
from sits_mech.mechanics.full_newton import rotation_matrix
from sits_mech.quantities import Array, Impedance
from sits_mech.reading import signals_at, with_pose_errors
from sits_mech.readout.signals import Signals
from sits_mech.sensor import SceneError, Sensor

_SMALLEST = 1e-9  # step of a difference quotient [m, rad]
_ROOM = 0.1  # of what a target may sink, or of its size, that a step takes at most


@dataclass(frozen=True)
class FullSimulation:
    """What the sensor shows under one load.

    Attributes
    ----------
    pose : FullPose
        Where the target comes to rest.
    impedance : Impedance
        What the coils show; its errors include what the pose's error makes of them.
    signals : Signals
        Combined, with errors.
    """

    pose: FullPose
    impedance: Impedance
    signals: Signals


def full_pose(sensor: Sensor, wrench: FullWrench, *, tolerance: float = 1e-2, mechanics: str = "auto") -> FullPose:
    """Return where the target rests under all six components of a load.

    Parameters
    ----------
    sensor : Sensor
        With a target on a pad that `full_equilibrium` holds.
    wrench : FullWrench
        [N, N m].
    tolerance : float
        Asked relative error of the pose.
    mechanics : str
        "auto" or "block": no other model leaves the plane.

    Raises
    ------
    SceneError
        For another model, or a tolerance that is none.
    ValueError
        For a scene that the model does not hold.
    SolveFailed
        When the pad has no equilibrium that could be reached.
    """
    _check("mechanics", mechanics, "block")
    if not 0.0 < tolerance < 1.0:
        raise SceneError(f"tolerance must lie between 0 and 1; got {tolerance}")
    return full_equilibrium(sensor, wrench, tolerance)


def simulate_full(
    sensor: Sensor, wrench: FullWrench, *, tolerance: float = 1e-2, mechanics: str = "auto", magnetics: str = "auto"
) -> FullSimulation:
    """Return what the sensor shows under all six components of a load.

    Parameters
    ----------
    sensor, wrench, mechanics
        As of `full_pose`.
    tolerance : float
        Asked relative error of the pose, and of the change of inductance.
    magnetics : str
        "auto" or "sheets": no other model leaves the plane.

    Raises
    ------
    SceneError, ValueError, SolveFailed
        As of `full_pose`, and for what `sheets` does not hold.
    Collision
        When the target comes to the coil plane.
    """
    _check("magnetics", magnetics, "sheets")
    _check("mechanics", mechanics, "block")
    field = sheets(sensor, tolerance)
    rest = full_pose(sensor, wrench, tolerance=tolerance, mechanics=mechanics)
    turns, places, gain = _shifted(sensor, rest)
    impedance, signals = with_pose_errors(sensor, field.impedance_at(turns, places, sensor.frequency), gain)
    single = {name: getattr(impedance, name)[0] for name in ("L", "R", "error_L", "error_R")}
    return FullSimulation(rest, replace(impedance, **single), signals_at(signals, 0))


def _check(half: str, asked: str, known: str) -> None:
    """Refuse a plane model."""
    if asked not in ("auto", known):
        raise SceneError(f"model ({half}) must be auto or {known} for F_y, M_x or M_z; got {asked}")


def _shifted(sensor: Sensor, rest: FullPose) -> tuple[Array, Array, Array]:
    """Rotations and places of a pose and of it shifted both ways along each component, and errors over steps."""
    pose = np.concatenate([rest.centre, rest.rotation])
    target, size = sensor.target, 1.0 if sensor.target is None else max(sensor.target.extent)
    gap = np.inf
    if target is not None:  # refuses a pose that touches the coil plane
        gap = float(lowest_points(target, None, rotation_matrix(rest.rotation)[None], rest.centre[None])[0])
    room = _ROOM * min(gap, size)
    limit = np.array([_ROOM * size, _ROOM * size, room, room / size, room / size, room / size])
    steps = np.minimum(np.maximum(rest.error, _SMALLEST), limit)
    poses = np.repeat(pose[None], 1 + 2 * len(pose), axis=0)
    poses[1::2] += np.diag(steps)
    poses[2::2] -= np.diag(steps)
    turns = np.stack([rotation_matrix(each) for each in poses[:, 3:]])
    return turns[:, None], poses[:, None, :3], (rest.error / steps)[:, None]
