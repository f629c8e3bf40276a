"""Turn poses into impedances and signals, with the errors of the poses in theirs.

The error of the component k of a pose has signed parts m_jk that neighbouring loads share, up to one factor each, and
an own part a_k = e_k - sum_j |m_jk|. With the magnetic model's error, of which b is shared with its sign, and the
slopes y_k of the model's answer (`magnetics.slopes`),

    error(y) = error_magnetics(y) + sum_j |sum_k y_k m_jk| + sum_k |y_k| a_k;

slopes by components that no pose of a batch has an error in are not evaluated (a symmetric load is neither sheared nor
turned). sum_k y_k m_jk and b are returned beside the error: where loads are compared, shared parts cancel as far as
they are alike (readout/crosstalk.py).

For a signal both parts are those of the signal itself: an error common to all coils cancels in their differences. To
first order, inductances at the unrotated pose have the same derivatives by the target's place, none by its rotation.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from sits_mech.magnetics.pose_slopes import KnownImpedance, pose_slopes
from sits_mech.mechanics.closed_form import free_rise
from sits_mech.quantities import POSE, Array, Bounded, Equilibrium, Impedance, MagneticModel, Pose
from sits_mech.readout.signals import Signals, combine, rows_of, signals, weights_of
from sits_mech.scene.sensor import Sensor
from sits_mech.scene.thermal import at_temperature

_LOG = logging.getLogger(__name__)
_ROUNDING = 1e-12  # a pose, or an error of it, that is none [m, rad]
_ROTATION = tuple(POSE.index(name) for name in ("alpha", "alpha_x", "alpha_z"))


@dataclass(frozen=True)
class PoseReadings:
    """Impedance and signals of many poses with all errors; signed parts of errors of each coil's own inductance."""

    impedance: Impedance
    signals: Signals
    untilted: Signals  # without rotation and without errors
    shared: Array  # (m, p, n), each shared by all poses up to one factor [unit]
    shared_untilted: Array
    alone: Array  # (k, p, n), of each pose for itself, by component [unit]
    turned: Array  # (p, r), errors of `combine` of L less the unrotated L, beside what is shared
    known: KnownImpedance  # the impedance with its slopes by components of poses that have errors


class Direct(NamedTuple):
    """What readings of a sensor have shown of each coil's own inductance [unit]."""

    parts: Array  # (m, p, n), what it is off by with the shared parts of the poses, these included
    moved: Array  # (p, n), what the model is off by


@dataclass(frozen=True)
class _Uncertain:
    """Components of poses that have an error, the errors, and the shares of them that are shared."""

    components: tuple[int, ...]  # (k,)
    errors: Array  # (k, p)
    shares: Array  # (m, k, p)

    def parts(self, slopes: Array) -> Array:
        """Return the signed change by each component's error, shape (k, p, ...), from slopes (p, ..., k)."""
        slopes = np.moveaxis(slopes, -1, 0)
        return slopes * self.errors.reshape(*self.errors.shape, *[1] * (slopes.ndim - 2))

    def shared(self, parts: Array, direct: Array | float = 0.0) -> Array:
        """Return the shared signed parts of the errors, shape (m, p, ...); `direct` is what they are besides poses."""
        return np.asarray(np.einsum("kp...,mkp->mp...", parts, self.shares) + direct)

    def alone(self, parts: Array) -> Array:
        """Return the rest of the errors by each component, signed, shape (k, p, ...)."""
        left = np.maximum(1.0 - np.abs(self.shares).sum(axis=0), 0.0)
        return np.asarray(np.einsum("kp...,kp->kp...", parts, left))

    def total(self, parts: Array, direct: Array | float = 0.0) -> Array:
        """Return the errors, shape (p, ...)."""
        return np.asarray(np.abs(self.shared(parts, direct)).sum(axis=0) + np.abs(self.alone(parts)).sum(axis=0))


def unloaded_pose(sensor: Sensor) -> Pose:
    """Return the pose without load, of warm or swollen silicone by closed form; at the coil plane without a layer."""
    warm = at_temperature(sensor)
    layer = warm.elastomer
    rise = 0.0 if layer is None or layer.free_stretch == 1.0 else free_rise(warm)
    return Pose(0.0, 0.0 if layer is None else layer.standoff + layer.thickness + rise)


def levers(sensor: Sensor) -> Array:
    """Return the factors that turn components of a pose into displacements, half the target's sides for angles [m]."""
    width, length = (0.0, 0.0) if sensor.target is None else sensor.target.extent
    return np.array([1.0, 1.0, 0.5 * width, 1.0, 0.5 * length, 0.5 * max(width, length)])


def poses_of(rests: Sequence[Equilibrium]) -> Bounded:
    """Return the poses of p rests, shape (p, 6), with the parts of their errors that all share."""
    count = min((len(rest.shared) for rest in rests), default=0)
    parts = np.array([rest.shared[:count] for rest in rests]).reshape(len(rests), count, len(POSE))
    each = np.array([(rest.pose.components, rest.error.components) for rest in rests]).reshape(-1, 2, len(POSE))
    return Bounded.of(each[:, 0], each[:, 1], parts.swapaxes(0, 1))


def read_poses(
    sensor: Sensor, model: MagneticModel, poses: Bounded, *, direct: Direct | None = None, separate: bool = True
) -> PoseReadings:
    """Return impedance and signals at p poses, (p, 6), in one call of the model, with the errors of poses in theirs.

    `direct` is in place of what the model's errors share, its parts those of the first shared ones of the poses: known
    as a whole, as what poses and leads do may cancel to less than slopes are known to. Without `separate` the
    untilted signals are those that are read, without another call.
    """
    unsure, weights, pose = _uncertain(poses), signal_weights(sensor), Pose.of(poses.value)
    names = [POSE[k] for k in unsure.components]
    found, *by_pose = pose_slopes(sensor, model, pose, sensor.frequency, names, quick=True)
    report, untilted = found.report, _untilted(model, found, pose) if separate else found
    if direct is not None:
        matrices = direct.moved[:, None, :] * np.eye(direct.moved.shape[-1])
        found, untilted = (replace(own, L=own.L + matrices) for own in map(_own_alone, (found, untilted)))
    _LOG.info("%s: inductances at %d poses, %d unknowns, error %.2g", report.model, len(poses.value), report.unknowns,
              report.estimated_error)
    L, L0, L_untilted = own_inductances(found), np.diagonal(found.L0), own_inductances(untilted)
    shown = L.mapped(rows_of(weights))
    whole_L, whole_R = (unsure.parts(slope) for slope in by_pose)
    parts, n = diagonals(whole_L), len(L0)
    own = np.zeros((len(poses.shared), len(L.value), n))
    if direct is not None:
        own[: len(direct.parts)] = direct.parts - unsure.shared(parts)[: len(direct.parts)]
    each, turns = combine(parts, weights), np.isin(unsure.components, _ROTATION)
    error_L = found.error_L + unsure.total(whole_L, own[..., None] * np.eye(n))
    error_R = found.error_R + unsure.total(whole_R)
    impedance = replace(found, error_L=error_L, error_R=error_R, shared_L=None)
    parts_untilted = np.where(turns[:, None, None], 0.0, parts)
    return PoseReadings(
        impedance, signals(L.value, L0, weights, shown.error + unsure.total(each, combine(own, weights))),
        signals(L_untilted.value, L0, weights), np.concatenate([unsure.shared(parts, own), L.shared]),
        np.concatenate([unsure.shared(parts_untilted, own), L_untilted.shared]),
        unsure.alone(parts), shown.own + np.abs(unsure.alone(each)[turns]).sum(axis=0),
        KnownImpedance(impedance, {name: (by_pose[0][..., k], by_pose[1][..., k]) for k, name in enumerate(names)}),
    )


def _own_alone(found: Impedance) -> Impedance:
    """Return an impedance without what its errors share."""
    if found.shared_L is None:
        return found
    return replace(found, error_L=np.maximum(found.error_L - np.abs(found.shared_L).sum(axis=0), 0.0), shared_L=None)


def own_inductances(found: Impedance) -> Bounded:
    """Return the inductance of each coil itself by the magnetic model, shape (p, n) [unit]."""
    shared = None if found.shared_L is None else diagonals(found.shared_L)
    return Bounded.of(diagonals(found.L), diagonals(found.error_L), shared)


def diagonals(matrices: Array) -> Array:
    """Return the diagonals of matrices (..., n, n)."""
    return np.diagonal(matrices, axis1=-2, axis2=-1)


def signal_weights(sensor: Sensor) -> Array:
    """Return the weights of the signals of a sensor, as `weights_of`."""
    radius = 0.5 * max(coil.outer_diameter for coil in sensor.coils)
    return weights_of([coil.centre for coil in sensor.coils], radius)


def _uncertain(poses: Bounded) -> _Uncertain:
    """Return the components of poses that have errors, and these."""
    errors = poses.error.T
    chosen = np.flatnonzero(np.any(errors > _ROUNDING, axis=1)).tolist()
    ratios = np.moveaxis(poses.shared, -1, 1) / np.maximum(errors, 1e-300)
    return _Uncertain(tuple(chosen), errors[chosen], ratios[:, chosen])


def _untilted(model: MagneticModel, found: Impedance, pose: Pose) -> Impedance:
    """Return the impedance at the same places without rotation; `found` where there is none."""
    if not np.any(np.abs(pose.rotation) > _ROUNDING):
        return found
    places = pose.components.copy()
    places[:, list(_ROTATION)] = 0.0
    return model.impedance(Pose.of(places), found.frequency)
