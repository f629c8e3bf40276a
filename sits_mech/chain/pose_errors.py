"""Read impedance and signals at poses that are known within errors, all errors with them.

The error of the component k of a pose has signed parts m_jk that neighbouring loads share, up to one factor each, and
an own part a_k = e_k - sum_j |m_jk|. With the magnetic model's error, of which b is shared with its sign, and the
slopes y_k of the model's answer (`magnetics.slopes`),

    error(y) = error_magnetics(y) + sum_j |sum_k y_k m_jk| + sum_k |y_k| a_k;

slopes by components that no pose of a batch has an error in are not evaluated (a symmetric load is neither sheared nor
turned). sum_k y_k m_jk and b are told beside the error: where loads are compared, what they share cancels as far as it
is alike (readout/crosstalk.py).

For a signal both parts are taken of the signal itself: what moves all coils alike leaves their differences. What is
left unrotated has the same derivatives by the target's place, and none by its rotation, to first order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sits_mech.cases import Row
from sits_mech.magnetics.pose_slopes import pose_slopes
from sits_mech.mechanics.loads import shared_of
from sits_mech.quantities import POSE, Array, Impedance, MagneticModel, Pose
from sits_mech.readout.signals import Signals, combine, rows_of, signals, weights_of
from sits_mech.scene.sensor import Sensor

_ROUNDING = 1e-12  # a pose, or an error of it, that is none [m, rad]
_ROTATION = tuple(POSE.index(name) for name in ("alpha", "alpha_x", "alpha_z"))


@dataclass(frozen=True)
class Reading:
    """Impedance and signals of many poses with all errors; signed parts of errors of each coil's own inductance."""

    impedance: Impedance
    signals: Signals
    untilted: Signals  # without rotation and without errors
    shared: Array  # (m, p, n), each shared by all poses up to one factor [unit]
    shared_untilted: Array
    alone: Array  # (k, p, n), of each pose for itself, by component [unit]
    turned: Array  # (p, r), errors of `combine` of L less the unrotated L, beside what is shared


@dataclass(frozen=True)
class _Uncertain:
    """Components of poses that have an error, the errors, and the shares of them that are shared."""

    components: tuple[int, ...]  # (k,)
    errors: Array  # (k, p)
    shares: Array  # (m, k, p)

    def parts(self, slopes: Array) -> Array:
        """Return the signed change by each component's error, shape (k, p, ...), from slopes (p, ..., k)."""
        slopes = np.moveaxis(slopes, -1, 0)
        return np.asarray(slopes * self.errors.reshape(*self.errors.shape, *[1] * (slopes.ndim - 2)))

    def shared(self, parts: Array) -> Array:
        """Return the shared signed parts of the errors, shape (m, p, ...)."""
        return np.asarray(np.einsum("kp...,mkp->mp...", parts, self.shares))

    def alone(self, parts: Array) -> Array:
        """Return the rest of the errors by each component, signed, shape (k, p, ...)."""
        left = np.maximum(1.0 - np.abs(self.shares).sum(axis=0), 0.0)
        return np.asarray(np.einsum("kp...,kp->kp...", parts, left))

    def total(self, parts: Array) -> Array:
        """Return the errors, shape (p, ...)."""
        return np.asarray(np.abs(self.shared(parts)).sum(axis=0) + np.abs(self.alone(parts)).sum(axis=0))


def unloaded(sensor: Sensor) -> Pose:
    """Return the pose without load; at the coil plane without a layer."""
    layer = sensor.elastomer
    return Pose(0.0, 0.0 if layer is None else layer.standoff + layer.thickness)


def levers(sensor: Sensor) -> Array:
    """Return the factors that turn components of a pose into displacements, half the target's sides for angles [m]."""
    width, length = (0.0, 0.0) if sensor.target is None else sensor.target.extent
    return np.array([1.0, 1.0, 0.5 * width, 1.0, 0.5 * length, 0.5 * max(width, length)])


def stacked(poses: Sequence[Pose]) -> Pose:
    """Return many poses as one."""
    return Pose.of(np.array([pose.components for pose in poses]).reshape(-1, len(POSE)))


def pose_of(row: Row, prefix: str = "") -> Pose:
    """Return the pose of a row, or its error by the prefix; missing components are zero."""
    return Pose(*(float(row.get(f"{prefix}{name}", 0.0)) for name in POSE))


def poses_of(rows: Sequence[Row]) -> tuple[Pose, Pose, Array]:
    """Return poses of p rows of loads, their errors, and the signed parts that all share, shape (m, p, 6)."""
    count = min((len(shared_of(row)) for row in rows), default=0)
    parts = np.array([shared_of(row)[:count] for row in rows]).reshape(len(rows), count, len(POSE))
    pose, error = (stacked([pose_of(row, prefix) for row in rows]) for prefix in ("", "error_"))
    return pose, error, parts.swapaxes(0, 1)


def signals_at(found: Signals, index: int) -> Signals:
    """Return one of many signals."""
    return Signals(**{name: float(np.asarray(value)[index]) for name, value in found.known.items()})


def read_poses(
    sensor: Sensor, model: MagneticModel, pose: Pose, error: Pose, shared: Array | None = None
) -> Reading:
    """Return impedance and signals at p poses in one call of the model, with the errors of poses in their errors.

    `pose` and `error` have shape (p,) [m, rad]; `shared`, shape (m, p, 6), are signed parts of the errors, each shared
    by all poses up to one factor.
    """
    unsure, weights = _uncertain(pose, error, shared), signal_weights(sensor)
    names = [POSE[k] for k in unsure.components]
    found, *by_pose = pose_slopes(sensor, model, pose, sensor.frequency, names, quick=True)
    flat = _untilted(model, found, pose)
    L, L0, last = diagonals(found.L), np.diagonal(found.L0), diagonals(flat.L)
    none = np.zeros((0, *found.L.shape))
    known, known_last = (diagonals(none if one.shared_L is None else one.shared_L) for one in (found, flat))
    alone = np.maximum(diagonals(found.error_L) - np.abs(known).sum(axis=0), 0.0) @ np.abs(rows_of(weights)).T
    whole_L, whole_R = (unsure.parts(slope) for slope in by_pose)
    parts = diagonals(whole_L)
    each, turns = combine(parts, weights), np.isin(unsure.components, _ROTATION)
    errors = np.abs(combine(known, weights)).sum(axis=0) + alone + unsure.total(each)
    error_L, error_R = found.error_L + unsure.total(whole_L), found.error_R + unsure.total(whole_R)
    impedance = replace(found, error_L=error_L, error_R=error_R, shared_L=None)
    return Reading(
        impedance, signals(L, L0, weights, errors), signals(last, L0, weights),
        np.concatenate([unsure.shared(parts), known]),
        np.concatenate([unsure.shared(np.where(turns[:, None, None], 0.0, parts)), known_last]),
        unsure.alone(parts), alone + np.abs(unsure.alone(each)[turns]).sum(axis=0),
    )


def diagonals(matrices: Array) -> Array:
    """Return the diagonals of matrices (..., n, n)."""
    return np.asarray(np.diagonal(matrices, axis1=-2, axis2=-1))


def signal_weights(sensor: Sensor) -> Array:
    """Return the weights of the signals of a sensor, as `weights_of`."""
    radius = 0.5 * max(coil.outer_diameter for coil in sensor.coils)
    return weights_of([coil.centre for coil in sensor.coils], radius)


def _uncertain(pose: Pose, error: Pose, shared: Array | None) -> _Uncertain:
    """Return the components of poses that have errors, and these."""
    errors = error.components.T
    parts = np.zeros((0, *errors.T.shape)) if shared is None else shared
    count = len(POSE) if pose.beside or error.beside else 3
    chosen = [k for k in range(count) if np.any(errors[k] > _ROUNDING)]
    ratios = np.moveaxis(parts, -1, 1) / np.maximum(errors, 1e-300)
    return _Uncertain(tuple(chosen), errors[chosen], ratios[:, chosen])


def _untilted(model: MagneticModel, found: Impedance, pose: Pose) -> Impedance:
    """Return the impedance at the same places without rotation; `found` where there is none."""
    if not np.any(np.abs(pose.rotation) > _ROUNDING):
        return found
    places = pose.components.copy()
    places[:, list(_ROTATION)] = 0.0
    return model.impedance(Pose.of(places), found.frequency)
