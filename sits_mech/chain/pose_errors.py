"""What do the coils show at poses that are known within errors? Impedance and signals, all errors with them.

The error of a result is the magnetic model's own plus what the error of the pose makes of it, added without sign:

    error(y) = error_magnetics(y) + sum_k |y(p + s_k) - y(p - s_k)| / 2  e_k / s_k

with steps s_k = e_k, or less near a collision; places that no pose of a batch has an error in are not evaluated (a
symmetric load is neither sheared nor turned).

For a signal the pose's part is taken of the signal itself: what moves all coils alike leaves their differences.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sits_mech.geometry.collision import room as room_around
from sits_mech.quantities import POSE, Array, Impedance, MagneticModel, Pose
from sits_mech.readout.signals import Signals, combine, rows_of, signals, weights_of
from sits_mech.scene.sensor import Sensor

_ROUNDING = 1e-12  # a pose, or an error of it, that is none [m, rad]
_SMALLEST = 1e-9  # step of a difference quotient [m, rad]: far below any pose, far above rounding


@dataclass(frozen=True)
class Reading:
    """Impedance and signals of many poses with all errors; ``untilted`` are the signals there unrotated."""

    impedance: Impedance
    signals: Signals
    untilted: Signals


def stacked(poses: Sequence[Pose]) -> Pose:
    """Return many poses as one."""
    return Pose.of(np.array([pose.components for pose in poses]).reshape(-1, len(POSE)))


def signals_at(found: Signals, index: int) -> Signals:
    """Return one of many signals."""
    return Signals(**{name: float(np.asarray(value)[index]) for name, value in found.known.items()})


def read_poses(sensor: Sensor, model: MagneticModel, pose: Pose, error: Pose) -> Reading:
    """Return impedance and signals of many poses in one call of the model, their errors by the errors of the poses.

    Parameters
    ----------
    sensor : Sensor
        The scene; its frequency is used.
    model : MagneticModel
        Of the sensor.
    pose, error : Pose of ndarray, shape (p,)
        Poses above the coil plane, and their estimated absolute errors [m, rad].

    Returns
    -------
    Reading
        With leading axis (p,).
    """
    tilted = bool(np.any(np.abs(pose.rotation) > _ROUNDING))
    shifted, gain = _shifted(sensor, pose, error, tilted)
    found = model.impedance(shifted, sensor.frequency)
    level = np.diagonal(found.L[-1 if tilted else 0], axis1=-2, axis2=-1)
    untilted = signals(level, np.diagonal(found.L0), signal_weights(sensor))
    return Reading(*with_pose_errors(sensor, found, gain), untilted)


def with_pose_errors(sensor: Sensor, found: Impedance, gain: Array) -> tuple[Impedance, Signals]:
    """Return impedance and signals of poses, with what the errors of the poses make of them.

    Parameters
    ----------
    sensor : Sensor
        The scene.
    found : Impedance
        With leading axes (1 + 2 k or more, p): the poses, and then shifted up and down along one component after the
        other; what follows plays no part.
    gain : ndarray, shape (k, p)
        Errors of the components over the shifts.
    """
    weights = signal_weights(sensor)
    own, L0 = np.diagonal(found.L, axis1=-2, axis2=-1), np.diagonal(found.L0)
    by_pose = [_spread(values, gain) for values in (found.L, found.R, combine(own, weights))]
    error_L, error_R = found.error_L[0] + by_pose[0], found.error_R[0] + by_pose[1]
    by_model = np.diagonal(found.error_L[0], axis1=-2, axis2=-1) @ np.abs(rows_of(weights)).T
    shown = signals(own[0], L0, weights, by_model + by_pose[2])
    return replace(found, L=found.L[0], R=found.R[0], error_L=error_L, error_R=error_R), shown


def signal_weights(sensor: Sensor) -> Array:
    """Return the weights of the signals of a sensor, as `weights_of`."""
    radius = 0.5 * max(coil.outer_diameter for coil in sensor.coils)
    return weights_of([coil.centre for coil in sensor.coils], radius)


def _shifted(sensor: Sensor, pose: Pose, error: Pose, tilted: bool) -> tuple[Pose, Array]:
    """Return the poses, shifted both ways along each component with an error, and untilted; errors over steps.

    The shapes are (1 + 2 k + tilted, p) and (k, p); the last ones, untilted, are there only where poses are `tilted`.
    """
    centre, errors = pose.components.T, error.components.T
    room = 0.1 * room_around(sensor, pose)
    reach = 1.0 if sensor.target is None else max(sensor.target.extent)
    aside, turn = np.full_like(room, 0.1 * reach), room / reach
    steps = np.minimum(np.maximum(errors, _SMALLEST), np.stack([aside, room, turn, aside, turn, turn]))
    count = len(POSE) if pose.beside or error.beside else 3
    uncertain = [k for k in range(count) if np.any(errors[k] > _ROUNDING)]
    stack = np.repeat(centre[None], 1 + 2 * len(uncertain) + tilted, axis=0)
    for row, k in enumerate(uncertain):
        stack[1 + 2 * row, k] += steps[k]
        stack[2 + 2 * row, k] -= steps[k]
    if tilted:
        stack[-1, [2, 4, 5]] = 0.0
    return Pose.of(np.moveaxis(stack, 1, -1)), (errors / steps)[uncertain]


def _spread(values: Array, gain: Array) -> Array:
    """Return what the pose's error makes of values on the shifted poses, shape (p, ...)."""
    end = 1 + 2 * len(gain)
    half = np.abs(values[1:end:2] - values[2:end:2]) / 2.0
    return np.asarray(np.einsum("kp...,kp->p...", half, gain))
