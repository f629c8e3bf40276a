"""What do the coils show at poses that are known within errors? Impedance and signals, all errors with them.

The error of the component k of a pose has signed parts m_jk that neighbouring loads share, up to one factor each, and
an own part a_k = e_k - sum_j |m_jk|. With the magnetic model's error, of which b is shared with its sign,

    y_jk = (y(p + s_k) - y(p - s_k)) / 2  m_jk / s_k,

    error(y) = error_magnetics(y) + sum_j |sum_k y_jk| + sum_k |y(p + s_k) - y(p - s_k)| / 2  a_k / s_k

with steps s_k = e_k, or less near a collision; places that no pose of a batch has an error in are not evaluated (a
symmetric load is neither sheared nor turned). sum_k y_jk and b are told beside the error: where loads are compared,
what they share cancels as far as it is alike (readout/crosstalk.py).

For a signal both parts are taken of the signal itself: what moves all coils alike leaves their differences. What is
left unrotated has the same derivatives by the target's place, and none by its rotation, to first order.
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
_ROTATION = tuple(POSE.index(name) for name in ("alpha", "alpha_x", "alpha_z"))
_SMALLEST = 1e-9  # step of a difference quotient [m, rad]: far below any pose, far above rounding


@dataclass(frozen=True)
class Reading:
    """Impedance and signals of many poses with all errors.

    Attributes
    ----------
    impedance : Impedance
    signals, untilted : Signals
        Those there, and those unrotated, without errors.
    shared, shared_untilted : ndarray, shape (m, p, n)
        Signed parts of the errors of each coil's own inductance, each of which all poses share up to one factor [unit].
    alone : ndarray, shape (k, p, n)
        Signed parts of them that each pose has for itself, by what is left of the errors of its components [unit].
    turned : ndarray, shape (p, r)
        Errors of what `combine` makes of the inductances less the unrotated ones, beside what is shared [unit].
    """

    impedance: Impedance
    signals: Signals
    untilted: Signals
    shared: Array
    shared_untilted: Array
    alone: Array
    turned: Array


@dataclass(frozen=True)
class _Uncertain:
    """What poses are shifted by: numbers of the components, shape (k,); errors over shifts, (k, p); of the errors what
    is shared, (m, k, p).
    """

    components: tuple[int, ...]
    gain: Array
    shares: Array

    def parts(self, values: Array) -> Array:
        """Return half of what the errors of each component change of values on the shifted poses, shape (k, p, ...)."""
        end = 1 + 2 * len(self.components)
        half = (values[1:end:2] - values[2:end:2]) / 2.0
        return np.asarray(half * self.gain.reshape(*self.gain.shape, *[1] * (half.ndim - 2)))

    def shared(self, parts: Array) -> Array:
        """Return the shared parts of the errors, with their signs, shape (m, p, ...)."""
        return np.asarray(np.einsum("kp...,mkp->mp...", parts, self.shares))

    def alone(self, parts: Array) -> Array:
        """Return the rest of the errors by each component, with their signs, shape (k, p, ...)."""
        left = np.maximum(1.0 - np.abs(self.shares).sum(axis=0), 0.0)
        return np.asarray(np.einsum("kp...,kp->kp...", parts, left))

    def total(self, values: Array) -> Array:
        """Return the errors of values on the shifted poses, shape (p, ...)."""
        parts = self.parts(values)
        return np.asarray(np.abs(self.shared(parts)).sum(axis=0) + np.abs(self.alone(parts)).sum(axis=0))


def stacked(poses: Sequence[Pose]) -> Pose:
    """Return many poses as one."""
    return Pose.of(np.array([pose.components for pose in poses]).reshape(-1, len(POSE)))


def signals_at(found: Signals, index: int) -> Signals:
    """Return one of many signals."""
    return Signals(**{name: float(np.asarray(value)[index]) for name, value in found.known.items()})


def read_poses(
    sensor: Sensor, model: MagneticModel, pose: Pose, error: Pose, shared: Array | None = None
) -> Reading:  # fmt: skip
    """Return impedance and signals of many poses in one call of the model, their errors by the errors of the poses.

    Parameters
    ----------
    sensor : Sensor
        The scene; its frequency is used.
    model : MagneticModel
        Of the sensor.
    pose, error : Pose of ndarray, shape (p,)
        Poses above the coil plane, and their estimated absolute errors [m, rad].
    shared : ndarray, shape (m, p, 6), optional
        Signed parts of those errors, each of which all poses share up to one factor [m, rad].

    Returns
    -------
    Reading
        With leading axis (p,).
    """
    tilted = bool(np.any(np.abs(pose.rotation) > _ROUNDING))
    parts = np.zeros((0, *error.components.shape)) if shared is None else shared
    shifted, unsure = _shifted(sensor, pose, error, parts)
    found, weights = model.impedance(shifted, sensor.frequency), signal_weights(sensor)
    L, L0, last = _own(found.L), np.diagonal(found.L0), -1 if tilted else 0
    known = np.zeros((0, *L.shape)) if found.shared_L is None else _own(found.shared_L)
    alone = np.maximum(_own(found.error_L)[0] - np.abs(known[:, 0]).sum(axis=0), 0.0) @ np.abs(rows_of(weights)).T
    parts, each = unsure.parts(L), unsure.parts(combine(L, weights))
    turns = np.isin(unsure.components, _ROTATION)
    by_model = np.abs(combine(known[:, 0], weights)).sum(axis=0) + alone
    errors = by_model + unsure.total(combine(L, weights))
    error_L, error_R = found.error_L[0] + unsure.total(found.L), found.error_R[0] + unsure.total(found.R)
    impedance = replace(found, L=found.L[0], R=found.R[0], error_L=error_L, error_R=error_R, shared_L=None)
    return Reading(
        impedance, signals(L[0], L0, weights, errors), signals(L[last], L0, weights),
        np.concatenate([unsure.shared(parts), known[:, 0]]),
        np.concatenate([unsure.shared(np.where(turns[:, None, None], 0.0, parts)), known[:, last]]),
        unsure.alone(parts), alone + np.abs(unsure.alone(each)[turns]).sum(axis=0),
    )  # fmt: skip


def _own(matrices: Array) -> Array:
    """Return the diagonals of matrices (..., n, n)."""
    return np.asarray(np.diagonal(matrices, axis1=-2, axis2=-1))


def signal_weights(sensor: Sensor) -> Array:
    """Return the weights of the signals of a sensor, as `weights_of`."""
    radius = 0.5 * max(coil.outer_diameter for coil in sensor.coils)
    return weights_of([coil.centre for coil in sensor.coils], radius)


def _shifted(sensor: Sensor, pose: Pose, error: Pose, shared: Array) -> tuple[Pose, _Uncertain]:
    """Return the poses, shifted both ways along each component with an error, and untilted where any is tilted.

    The shape is (1 + 2 k + tilted, p).
    """
    centre, errors = pose.components.T, error.components.T
    tilted = bool(np.any(np.abs(pose.rotation) > _ROUNDING))
    room = 0.1 * room_around(sensor, pose)
    reach = 1.0 if sensor.target is None else max(sensor.target.extent)
    aside, turn = np.full_like(room, 0.1 * reach), room / reach
    steps = np.minimum(np.maximum(errors, _SMALLEST), np.stack([aside, room, turn, aside, turn, turn]))
    count = len(POSE) if pose.beside or error.beside else 3
    uncertain = tuple(k for k in range(count) if np.any(errors[k] > _ROUNDING))
    stack = np.repeat(centre[None], 1 + 2 * len(uncertain) + tilted, axis=0)
    for row, k in enumerate(uncertain):
        stack[1 + 2 * row, k] += steps[k]
        stack[2 + 2 * row, k] -= steps[k]
    if tilted:
        stack[-1, list(_ROTATION)] = 0.0
    ratios = np.moveaxis(shared, -1, 1) / np.maximum(errors, 1e-300)
    chosen = list(uncertain)
    return Pose.of(np.moveaxis(stack, 1, -1)), _Uncertain(uncertain, (errors / steps)[chosen], ratios[:, chosen])
