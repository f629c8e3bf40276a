"""Estimate what a section leaves out, the ends along y of coils and plates, from a coarse answer in space.

A section's L [H/m] describes a sensor relative to its inductances without target alone. With s_cd = sqrt(L0_cc L0_dd)
of each model,

    e_L,cd = |(L_cd/s_cd)_space - (L_cd/s_cd)_section| s_cd,section,    e_R of R/s alike,

at the same pose and frequency, is what the section leaves out of each entry: the ends of tracks and plates, the
roundness of coils and targets, the pitch of spirals. The space's comes of `sheets` on its coarsest rung, within a few
percent of the change in about a second; its own error is added.

Range: no size is known where `sheets` does not hold the scene (permeable targets, curved substrates) or takes long
(among other metal).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from sits_mech.description import Description, Question, added, sized
from sits_mech.magnetics.answer import largest
from sits_mech.magnetics.sheets import not_representable, sheets
from sits_mech.notes import OmissionKind
from sits_mech.quantities import POSE, Array, Impedance, MagneticModel, Pose, SolveFailed
from sits_mech.scene.sensor import Sensor

ROUGH = 0.1
"""Tolerance of the answers in space."""
_MISSED = 0.02  # of space's change, what its coarsest rung was seen to miss beyond its own estimate
_KEPT = 16  # coarse answers: errors and tables ask for the same


@dataclass(frozen=True)
class Ends:
    """What a section leaves out of inductances and resistances."""

    L: Array  # (..., n, n), space less section [unit_L of the section]
    R: Array  # alike [its resistance]
    error_L: Array
    error_R: Array
    size: float  # largest of coils' own L with its error, over the section's largest change of L


def ends_of_plates(sensor: Sensor, pose: Pose, found: Impedance) -> Ends | None:
    """Return what a section leaves out; None where space has no model of the scene, or a slow one.

    `found` is of the section at `pose`, one or many; each pose is estimated independently of the others.
    """
    if sensor.target is None or sensor.conductors or not_representable(sensor) is not None:
        return None
    rows, n = pose.components.reshape(-1, len(POSE)), len(sensor.coils)
    L, R = (values.reshape(-1, n, n) for values in (found.L, found.R))
    try:
        space = _in_space(sensor, tuple(rows.ravel().tolist()), found.frequency)
    except (SolveFailed, ValueError):
        return None
    scale, other = (np.sqrt(np.outer(np.diag(L0), np.diag(L0))) for L0 in (found.L0, space.L0))
    errors = (space.error_L + _MISSED * largest(space.L - space.L0), space.error_R + _MISSED * largest(space.R))
    ratio = scale / other
    more = _three_digits(np.stack([space.L * ratio - L, space.R * ratio - R, *(each * ratio for each in errors)]))
    change = np.abs(L - found.L0).max(axis=(1, 2))
    own_L = np.diagonal(np.abs(more[0]) + more[2], axis1=1, axis2=2).max(axis=1)
    size = float(np.max(own_L / np.where(change > 0.0, change, np.inf), initial=0.0))
    by_L, by_R, error_L, error_R = (each.reshape(found.L.shape) for each in more)
    return Ends(by_L, by_R, error_L, error_R, size)


@lru_cache(maxsize=_KEPT)
def _in_space(sensor: Sensor, poses: tuple[float, ...], frequency: float) -> Impedance:
    """Return the coarse answer in space at poses; kept, for errors and tables ask the same."""
    return sheets(sensor, ROUGH).impedance(Pose.of(np.array(poses).reshape(-1, len(POSE))), frequency)


def _three_digits(values: Array) -> Array:
    """Round to three digits: the estimate has no more, and rounding of a batch does not show."""
    scale = 10.0 ** (np.floor(np.log10(np.where(values == 0.0, 1.0, np.abs(values)))) - 2.0)
    return np.round(values / scale) * scale


@dataclass(frozen=True)
class Whole:
    """A magnetic model whose errors hold what it leaves out, and whose report lists that."""

    model: MagneticModel
    sensor: Sensor
    description: Description

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return the model's impedance; what has no size is listed without one, and is in no error."""
        found = self.model.impedance(pose, frequency)
        if not found.L.size:
            return found
        sensor = self.sensor.model_copy(update={"frequency": frequency})
        every = self.description.omissions(sensor, Question(pose=pose, answer=(pose, found), closely=True))
        counted = tuple(item for item in every if item.weighs)
        report = added(found.report, counted)
        ends = ends_of_plates(sensor, pose, found) if self.description.per_metre else None
        known = OmissionKind.PLATE_ENDS if ends is not None else None
        size = sized(item for item in counted if not item.included and item.kind != known)
        error_L, error_R = (size * largest(values) for values in (found.L - found.L0, found.R))
        found = replace(found, error_L=found.error_L + error_L, error_R=found.error_R + error_R, report=report)
        if ends is None:
            return found
        shared = np.zeros((0, *found.L.shape)) if found.shared_L is None else found.shared_L
        return replace(
            found, error_L=found.error_L + np.abs(ends.L) + ends.error_L,
            error_R=found.error_R + np.abs(ends.R) + ends.error_R, shared_L=np.concatenate([shared, ends.L[None]]),
        )


def pitch_of_spirals(sensor: Sensor, pose: Pose, found: Impedance) -> float:
    """Return the error of rings for spirals, over the largest change of inductance at the pose [-].

    From the difference of both in space at the coarsest rung, whose errors they share; NaN where space has no model.
    `found` is in henry.
    """
    if not_representable(sensor) is not None or sensor.target is None:
        return float("nan")
    some = Pose.of(pose.components.reshape(-1, len(POSE)))
    try:
        each = [sheets(sensor, ROUGH, windings=kind).impedance(some, found.frequency) for kind in ("rings", "spiral")]
    except (SolveFailed, ValueError):
        return float("nan")
    rings, spirals = (np.diagonal(one.L, axis1=1, axis2=2) / np.diag(one.L0) - 1.0 for one in each)
    return float((np.abs(spirals - rings).max(axis=1) / np.abs(rings).max(axis=1)).max())
