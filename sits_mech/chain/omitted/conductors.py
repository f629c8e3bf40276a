"""Choose the fixed conductors that a request needs solved; the others are left out by a bound.

A conductor's effect is bounded beforehand (`remote`) and compared with the change of inductance that is asked for: what
the target does at the poses that are known, or at rest, by the model that the bare sensor takes. Conductors whose
effects stay together below the tolerance are left out, named with their bounds, and the answer's errors hold these.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import count

import numpy as np

from sits_mech.description import added
from sits_mech.geometry.collision import check_clearance
from sits_mech.magnetics.axis_fem import AxisymmetricFem
from sits_mech.magnetics.omitted.remote import remote_bounds
from sits_mech.magnetics.pose_slopes import inner_model
from sits_mech.magnetics.rings import Axisymmetric
from sits_mech.notes import Omission, OmissionKind
from sits_mech.quantities import Array, Impedance, MagneticModel, Pose, SolveFailed
from sits_mech.scene.sensor import Conductor, Sensor

_LEAST = 1e-6  # of L0: the change of inductance is taken as more than that; of what is then worth less than
_NOTHING = 1e-2  # of the tolerance nothing more is asked
_Shares = Callable[[Sequence[Conductor]], Array]  # of conductors together, over the change asked for
_WHOLE = 1.0  # of the change: conductors that count whatever the target changes


@dataclass(frozen=True)
class AmongFar:
    """A magnetic model of a scene without its far conductors, whose bounds are in its errors."""

    model: MagneticModel  # of `solved`
    sensor: Sensor  # the whole scene
    solved: Sensor
    section: bool = False  # whether what the plane y = 0 cuts counts as endless
    enough: float = 0.0  # of L0: bounds below this are not refined

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return the model's impedance with the far conductors in errors and report.

        Raises Collision if the target touches the coil plane or a conductor, ValueError if nothing bounds a far one.
        """
        check_clearance(self.sensor, pose)
        found = self.model.impedance(pose, frequency)
        far = [part for part in self.sensor.conductors if part not in self.solved.conductors]
        each = remote_bounds(self.solved, far, pose, section=self.section, enough=self.enough)
        share = each.sum(axis=1)
        if not np.all(np.isfinite(share)):
            names = ", ".join(f"conductors.{part.name}" for part in far)
            raise ValueError(f"pose: the target must stay far from {names}, left out for that; ask for a model by name")
        free, shape = float(np.diag(found.L0).max()), pose.components.shape[:-1]
        bound = free * share.reshape(shape)[..., None, None]
        change = np.abs(found.L - found.L0).max(axis=(-2, -1)).reshape(-1, 1)
        sizes = np.max(free * each / np.where(change > 0.0, change, np.inf), axis=0, initial=0.0)
        error_R = found.error_R + 2.0 * np.pi * frequency * bound
        report = added(found.report, tuple(map(_omission, far, sizes.tolist())))
        return replace(found, error_L=found.error_L + bound, error_R=error_R, report=report)


def without_far(
    sensor: Sensor, model: Callable[[Sensor], MagneticModel], pose: Pose, tolerance: float, *, section: bool = False
) -> tuple[Sensor, tuple[Omission, ...]]:
    """Return the scene with the conductors that matter, and the omissions of the others.

    `model` makes the model of the bare sensor, `pose` is where the change of inductance is asked for to `tolerance`;
    with `section` what the plane cuts counts as endless. What is left out together takes half of the tolerance at most.
    """
    bare, spared = _with(sensor, ()), 0.5 * tolerance
    worth = remote_bounds(bare, sensor.conductors, pose, section=section, enough=negligible(tolerance))
    if worth.sum(axis=1).max() <= negligible(tolerance):  # whatever the change is
        return bare, tuple(map(_omission, sensor.conductors, (worth.max(axis=0) / _LEAST).tolist()))
    at_least = partial(_shares, bare, pose, np.ones(len(worth)), section)  # no change is more than L0
    if min(_alone(at_least, sensor.conductors)) >= _WHOLE:
        return sensor, ()
    try:
        found = model(bare).impedance(pose, sensor.frequency)
    except SolveFailed:
        return sensor, ()
    change = np.abs(found.L - found.L0).max(axis=(-2, -1)).ravel() / np.diag(found.L0).max()
    kept = list[Conductor]()
    while True:
        solved, far = _with(sensor, kept), [part for part in sensor.conductors if part not in kept]
        shares = partial(_shares, solved, pose, change, section)
        left = _small_together(far, shares, spared)
        if len(left) == len(far):
            return solved, tuple(map(_omission, far, shares(far).tolist()))
        kept += [part for part in far if part not in left]


def negligible(tolerance: float) -> float:
    """Return the change of inductances over L0 that conductors may make without a look at the change asked for."""
    return _LEAST * _NOTHING * tolerance


def _shares(solved: Sensor, pose: Pose, change: Array, section: bool, far: Sequence[Conductor]) -> Array:
    """Return the largest effect of each far conductor over the change asked for; infinite where that is zero."""
    bounds = remote_bounds(solved, far, pose, section=section)
    each = np.divide(bounds, change[:, None], out=np.full_like(bounds, np.inf), where=change[:, None] > 0.0)
    return np.asarray(each.max(axis=0))


def _alone(shares: _Shares, parts: Sequence[Conductor]) -> list[float]:
    """Return the share of each conductor by itself."""
    return [float(shares([part])[0]) for part in parts]


def _small_together(parts: Sequence[Conductor], shares: _Shares, tolerance: float) -> list[Conductor]:
    """Return the conductors that together stay below a tolerance, largest effects dropped first."""
    left = [parts[k] for size, k in sorted(zip(_alone(shares, parts), count())) if size <= tolerance]
    while left and float(shares(left).sum()) > tolerance:
        left.pop()
    return left


def _with(sensor: Sensor, parts: Sequence[Conductor]) -> Sensor:
    """Return a scene with only the given conductors."""
    return sensor.model_copy(update={"conductors": tuple(parts)})


def _omission(part: Conductor, size: float) -> Omission:
    """Return the omission of a far conductor."""
    place = zip("xyz", part.centre, strict=True)
    return Omission(OmissionKind.FAR, size, bound=True, numbers=(("name", part.name), *place))


def is_coaxial(field: MagneticModel) -> bool:
    """Return whether the model keeps a disc on its coil's axis: shifts and tilts change nothing there."""
    return isinstance(inner_model(field), Axisymmetric | AxisymmetricFem)
