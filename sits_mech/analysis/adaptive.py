"""How few loads does a calibration take? Loads are solved only where the map of the inductances still bends.

The loads of `readout.sampling`, each from the nearest settled one; a sensor that is its own mirror image gives two
loads at once: F_x -> -F_x swaps the coils. The result is the same `Calibration` that a regular table gives. Its error
is told by the last loads alone: where the solver scatters it can be passed elsewhere (a 3D pad at tolerance
1e-2, 15 loads: told 0.4e-3 of full scale, 1.4e-3 at the worst of 81). `chain.calibrate` leaves out loads of a grid too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from sits_mech.analysis.bench import free_inductances
from sits_mech.cases import Progress
from sits_mech.chain.models import loaded_model, mechanical_model
from sits_mech.chain.pose_errors import read_poses
from sits_mech.geometry.collision import Collision, check_clearance
from sits_mech.quantities import Array, Equilibrium, MagneticModel, MechanicalModel, Pose, SolveFailed, Wrench
from sits_mech.readout.calibration import Calibration, calibration_of
from sits_mech.readout.sampling import Mirror, Sampling, sample
from sits_mech.sensor import Coil, SceneError, Sensor

_NAMES = ("F_x", "F_z")


@dataclass(frozen=True)
class AdaptiveCalibration:
    """A calibration from as few loads as it took.

    Attributes
    ----------
    calibration : Calibration
        In henry.
    sampling : Sampling
        The loads [N], L of each coil over its free-space value, and how the error fell.
    reasons : tuple of str
        One line for each load that failed.
    """

    calibration: Calibration
    sampling: Sampling
    reasons: tuple[str, ...]


@dataclass
class _Loads:
    """Solves loads, each from the nearest settled one, which it remembers; lives for one calibration."""

    sensor: Sensor
    layer: MechanicalModel
    magnetics: MagneticModel
    progress: Progress | None
    most: int
    settled: list[Equilibrium] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)
    count: int = 0

    def __call__(self, loads: Array) -> Array:
        """Return L over L0 of each coil at loads (m, 2); NaN where a load fails."""
        found = np.full((len(loads), len(self.sensor.coils)), np.nan)
        order = np.argsort(np.sum((loads / np.maximum(np.abs(loads).max(axis=0), 1e-300)) ** 2, axis=1))
        for k in order:
            found[k] = self._solved(Wrench(*(float(force) for force in loads[k])))
            self.count += 1
            if self.progress is not None:
                self.progress(self.count, self.most)
        return found

    def _solved(self, wrench: Wrench) -> Array:
        """Return L over L0 at one load."""
        start = min(self.settled, key=lambda near: _distance(near.wrench, wrench), default=None)
        try:
            rest = self.layer.equilibrium(wrench, start=start)
            check_clearance(self.sensor, rest.pose)
            self.settled.append(rest)
            reading = read_poses(self.sensor, self.magnetics, _row(rest.pose), _row(rest.error)).impedance
        except (SolveFailed, Collision) as error:
            self.reasons.append(f"F_x = {wrench.F_x:.4g} N, F_z = {wrench.F_z:.4g} N: {error}")
            return np.full(len(self.sensor.coils), np.nan)
        return np.asarray(np.diagonal(reading.L[0]) / np.diagonal(reading.L0))


def _row(pose: Pose) -> Pose:
    """Return one pose as an array of one."""
    return Pose(np.array([pose.d_h]), np.array([pose.d_v]), np.array([pose.alpha]))


def _distance(first: Wrench, second: Wrench) -> float:
    """Return how far two loads are apart [N]."""
    return float(np.hypot(first.F_x - second.F_x, first.F_z - second.F_z))


def calibrate_adaptively(
    sensor: Sensor, *, F_x: tuple[float, float], F_z: tuple[float, float], error: float = 1e-3, tolerance: float = 1e-2,
    models: tuple[str, str] = ("auto", "auto"), most: int = 100, progress: Progress | None = None,
) -> AdaptiveCalibration:  # fmt: skip
    """Return a calibration whose map holds to an error, from as few loads as it takes.

    Parameters
    ----------
    sensor : Sensor
        With target and elastomer.
    F_x, F_z : tuple of float
        Least and greatest force [N].
    error : float
        Of the map between the loads, over each coil's range.
    tolerance : float
        Of each solve, as for `calibrate`.
    models : tuple of str
        Mechanical and magnetic.
    most : int
        Loads solved at most; ``sampling.reached`` tells whether they were enough.
    progress : callable, optional
        Called with the number of loads done and allowed.

    Raises
    ------
    SceneError
        When a model cannot hold the scene, or a range is empty.
    """
    for name, (low, high) in zip(_NAMES, (F_x, F_z), strict=True):
        if not low < high:
            raise SceneError(f"{name}: must be a range from low to high [N]; got {low} to {high}")
    field_model, _ = loaded_model(sensor, models[1], tolerance)
    layer, _ = mechanical_model(sensor, models[0], tolerance)
    solve = _Loads(sensor, layer, field_model, progress, most)
    mirror = _mirror(sensor) if F_x[0] == -F_x[1] else None
    box = ((F_x[0], F_z[0]), (F_x[1], F_z[1]))
    found = sample(solve, _NAMES, box, tolerance=error, most=most, mirror=mirror)
    L0 = free_inductances(sensor)
    coils = [coil.name for coil in sensor.coils]
    cal = calibration_of(found.points, found.values * L0, forces=_NAMES, coils=coils, free=("H", L0))
    return AdaptiveCalibration(cal, found, tuple(solve.reasons))


def _mirror(sensor: Sensor) -> Mirror | None:
    """Return how the coils answer the mirrored shear; None where the sensor is not its own mirror image."""
    if sensor.target is None or sensor.target.shape == "outline" or sensor.conductors:
        return None
    order = [_image(sensor.coils, k) for k in range(len(sensor.coils))]
    if any(k is None for k in order):
        return None
    return Mirror((-1, 1), tuple(k for k in order if k is not None), (1,) * len(order))


def _image(coils: Sequence[Coil], k: int) -> int | None:
    """Return which coil is the mirror image of coil k."""
    shapes = [coil.model_dump(exclude={"name"}) for coil in coils]
    x, y = shapes[k]["centre"]
    wanted = shapes[k] | {"centre": (-x if x else x, y)}
    return next((i for i, shape in enumerate(shapes) if shape == wanted), None)
