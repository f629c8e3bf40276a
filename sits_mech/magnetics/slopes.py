"""How do L and R change with the pose and with the frequency? Derivatives of any model of the magnetics.

A model's answer is a smooth function of pose and frequency down to rounding (`stages`), so that differences of a fourth
order over steps h far above rounding and far below the lengths on which the field changes hold to some 1e-8:

    y' = [8 (y(h) - y(-h)) - (y(2 h) - y(-2 h))] / (12 h),

h a share of the room around the target, for a turn of what moves its rim as far; for the frequency in ln f. All poses
of all components are one batch of warm poses, four for each component.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.geometry.collision import room
from sits_mech.quantities import POSE, Array, MagneticModel, Pose
from sits_mech.scene.sensor import Sensor

_STEP = 0.01  # of the room around the target; of ln f
_PLACES = np.array([1.0, -1.0, 2.0, -2.0])
_WEIGHTS = np.array([8.0, -8.0, -1.0, 1.0]) / 12.0


@dataclass(frozen=True)
class Slopes:
    """Derivatives of the impedance matrices.

    Attributes
    ----------
    components : tuple of str
        k components of the pose, of `POSE`.
    L, R : ndarray, shape (..., n, n, k)
        By each of them [H/m or H/rad, ohm/m or ohm/rad; per metre of depth for a planar model].
    L_frequency, R_frequency : ndarray, shape (..., n, n)
        By the frequency [H/Hz, ohm/Hz].
    """

    components: tuple[str, ...]
    L: Array
    R: Array
    L_frequency: Array
    R_frequency: Array


def slopes(
    sensor: Sensor, model: MagneticModel, pose: Pose, frequency: float, *, components: Sequence[str] = POSE
) -> Slopes:
    """Return the derivatives of L and R at one pose or many.

    Parameters
    ----------
    sensor : Sensor
        With a target.
    model : MagneticModel
        Of the sensor.
    pose : Pose
    frequency : float
        [Hz]
    components : sequence of str
        Of the pose: those that the model takes; a planar one the first three.

    Raises
    ------
    ValueError
        If a component has no such name; as the model's `impedance`.
    """
    for name in components:
        if name not in POSE:
            raise ValueError(f"components: must be of {', '.join(POSE)}, got {name!r}")
    places = pose.components
    shape, rows = places.shape[:-1], places.reshape(-1, len(POSE))
    steps = _steps(sensor, Pose.of(rows))
    moved = [rows]
    for name in components:
        k = POSE.index(name)
        for place in _PLACES:
            moved.append(rows.copy())
            moved[-1][:, k] += place * steps[k]
    found = model.impedance(Pose.of(np.stack(moved)), frequency)
    h = np.stack([steps[POSE.index(name)] for name in components])[:, :, None, None]
    by_pose, by_frequency = [], []
    around = [model.impedance(Pose.of(rows), frequency * np.exp(_STEP * place)) for place in _PLACES]
    for name in ("L", "R"):
        values = getattr(found, name)
        each = values[1:].reshape(len(components), len(_PLACES), *values.shape[1:])
        slope = np.einsum("j,kjp...->kp...", _WEIGHTS, each) / h
        by_pose.append(np.moveaxis(slope, 0, -1).reshape(*shape, *values.shape[-2:], len(components)))
        change = sum(w * getattr(one, name) for w, one in zip(_WEIGHTS, around, strict=True)) / (_STEP * frequency)
        by_frequency.append(np.asarray(change).reshape(*shape, *values.shape[-2:]))
    return Slopes(tuple(components), *by_pose, *by_frequency)


def _steps(sensor: Sensor, pose: Pose) -> Array:
    """Steps h of all components, shape (6, p) [m, rad]."""
    if sensor.target is None:
        raise ValueError("target: the scene has none whose pose could change")
    way = _STEP * room(sensor, pose)
    turn = way / (0.5 * max(sensor.target.extent))
    return np.stack([way, way, turn, way, turn, turn])
