"""Convert errors of a pose to errors of the signals, as shares of the full scale of a tolerance, and what is flagged.

With s_i the signals of a sensor, i of those of a pair or of all, over the mean L0, p_k the components of the pose,

    S = max_i (max s_i - min s_i) over the poses asked for and the one at rest,      G_ik = (d s_i/d p_k)/S.

A pose whose error has signed parts m_jk that all loads share and own parts a_k leaves an uncertainty of max_i (sum_j
|sum_k G_ik m_jk| + sum_k |G_ik| a_k) of full scale, the magnetics what they do not share between load and
rest. The mechanics are given what the magnetics leave of the tolerance, no less than half of it, and stop at the mesh
where the first of these sums is within it: a component that no signal depends on is not solved for.

Source: R. Becker, R. Rannacher, Acta Numerica 10 (2001) 1: error control by quantities of interest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sits_mech.chain.omitted.conductors import is_coaxial
from sits_mech.chain.propagation import diagonals, own_inductances, poses_of, signal_weights, unloaded_pose
from sits_mech.description import sized
from sits_mech.magnetics.pose_slopes import inner_model, pose_slopes
from sits_mech.notes import Note, NoteKind, Omission
from sits_mech.quantities import (
    POSE,
    Array,
    Bounded,
    Equilibrium,
    Impedance,
    MagneticModel,
    Mask,
    Pose,
    SolveFailed,
    SolveReport,
)
from sits_mech.readout.signals import rows_of
from sits_mech.scene.sensor import Sensor, known_stretch
from sits_mech.status import flags_of, marked

HALF = 0.5  # of the tolerance: the mechanics have that at least, bending and omissions count from it on


@dataclass(frozen=True)
class Goal:
    """Signals as shares of the full scale of the one that changes most."""

    weights: Array  # (s, 6), G at the pose that moves the target farthest [1/m, 1/rad]
    magnetics: float  # error of the magnetic model, of full scale
    left_out: float = 0.0  # what the mechanical model leaves out, of full scale

    def left(self, tolerance: float) -> float:
        """Return the part of a tolerance that is left to the numerics of the mechanics."""
        return tolerance_left(self.left_out, max(tolerance - self.magnetics, HALF * tolerance))

    def of(self, poses: Bounded) -> float:
        """Return the largest error of poses, (..., 6), in all, of full scale."""
        return self.mechanics(poses) + self.magnetics

    def mechanics(self, poses: Bounded) -> float:
        """Return what the errors of poses, (..., 6), are of full scale at most."""
        return float(np.max(poses.mapped(self.weights).error, initial=0.0))


def tolerance_left(left_out: float, tolerance: float) -> float:
    """Return what a tolerance leaves to numerics beside what is left out; all of it where that takes half or more."""
    return tolerance - left_out if left_out < HALF * tolerance else tolerance


def goal_of(sensor: Sensor, field: MagneticModel, poses: Sequence[Pose]) -> Goal | None:
    """Return the goal of a request; None where no signal changes over its poses.

    `poses` are those asked for, or some of the farthest, clear of the coils; what the model leaves out is not in it.
    Raises SolveFailed when the coils cannot be solved there.
    """
    if sensor.elastomer is None:
        return None
    at_rest, field = unloaded_pose(sensor), inner_model(field)
    away = [np.hypot(np.hypot(pose.d_h, pose.d_y), pose.d_v - at_rest.d_v) for pose in poses]
    far, some = int(np.argmax(away)), Pose.of(np.array([pose.components for pose in (*poses, at_rest)]))
    names = ("d_v",) if is_coaxial(field) else POSE if some.out_of_plane else POSE[:3]
    first, slopes, _ = pose_slopes(sensor, field, Pose.of(some.components[[far]]), sensor.frequency, names, quick=True)
    found = field.impedance(some, sensor.frequency)
    rows = goal_rows(sensor)
    scale = float(np.mean(np.diag(first.L0)))
    shown = diagonals(found.L) @ rows.T / scale
    size = float(np.max(np.ptp(shown, axis=0)))
    if size <= 0.0:
        return None
    weights, own = np.zeros((len(rows), len(POSE))), [POSE.index(name) for name in names]
    weights[:, own] = rows @ np.diagonal(slopes[0], axis1=0, axis2=1).T / (scale * size)
    change = own_inductances(found).mapped(rows)
    return Goal(weights, float(np.max((change[far] - change[-1]).error)) / (scale * size))


def goal_rows(sensor: Sensor) -> Array:
    """Return the weights of the signals that a tolerance is of, shape (s, n): of a pair, or of all."""
    rows = rows_of(signal_weights(sensor))
    return rows[3:] if len(rows) > 3 else rows


def farthest(poses: Pose) -> list[Pose]:
    """Return those of many poses where a component is least or largest."""
    each = poses.components
    return [Pose(*each[k].tolist()) for k in dict.fromkeys([*each.argmin(axis=0), *each.argmax(axis=0)])]


def goal_at(sensor: Sensor, field: MagneticModel, poses: Sequence[Pose]) -> Goal | None:
    """Return `goal_of` the poses; None also where there are none or the coils cannot be solved."""
    try:
        return goal_of(sensor, field, poses) if poses else None
    except SolveFailed:  # the answer says why
        return None


def answer_error(goal: Goal | None, rest: Equilibrium, left_out: Sequence[Omission]) -> float:
    """Return the error of an answer over the signals' full scale, with all that is left out; 0 without a goal.

    `left_out` is what the magnetic model leaves out; the errors of the pose hold what the mechanics do.
    """
    return 0.0 if goal is None else goal.of(poses_of([rest])) + sized(left_out)


def missed_by(goal: Goal, rest: Equilibrium, shown: Impedance, coils: Sequence[str]) -> SolveReport:
    """Return the report of a reading, shapes (n, n), with what makes its signals miss their tolerance."""
    poses = poses_of([rest])
    note = Note.of(
        NoteKind.SIGNALS_MISSED, pose=100.0 * goal.mechanics(poses), model=100.0 * goal.magnetics,
        left_out=100.0 * sized(shown.report.left_out), coil=coils[int(np.argmax(np.diag(shown.error_L)))],
        component=POSE[np.argmax(np.max(np.abs(goal.weights) * poses.error, axis=0))],
    )
    return replace(shown.report, notes=(*shown.report.notes, note))


def flags_over(
    sensor: Sensor, goal: Goal | None, poses: Bounded, stretch: Array, tolerance: float,
    left_out: Sequence[Omission] = (), *, interpolated: Mask | bool = False,
) -> tuple[dict[str, list[str]], float]:
    """Return status and flags over time, as `marked`, from poses (p, 6), stretches (p,) and which are `interpolated`.

    With the largest error over the signals' full scale. `left_out` is what both halves leave out; errors of poses hold
    what the mechanics do.
    """
    known, count, bounded = known_stretch(sensor), len(stretch), not any(item.unbounded for item in left_out)
    more = sized(item for item in left_out if item.half == "magnetics")
    errors = [0.0 if goal is None else goal.of(poses[k]) + more for k in range(count)]
    each = [
        marked(flags_of(own, tolerance, most, known, interpolated=between, bounded=bounded))
        for own, most, between in zip(errors, stretch.tolist(), np.broadcast_to(interpolated, count), strict=True)
    ]
    return {name: [row[name] for row in each] for name in ("status", "flags")}, max(errors, default=0.0)


def rest_flags(
    sensor: Sensor, found: Equilibrium, tolerance: float, error: float | None = None, left_out: Sequence[Omission] = (),
) -> tuple[str, ...]:
    """Return the flags of an equilibrium by an error, by default that of its pose, and by the silicone's data.

    They are as of `flags_of`; `left_out` is what the magnetic model leaves out.
    """
    report = found.report
    error = report.estimated_error if error is None else error
    return flags_of(
        error, tolerance, report.stretch, known_stretch(sensor), changed=report.error_stretch,
        bounded=not any(item.unbounded for item in (*report.left_out, *left_out)),
    )
