"""Compare a measurement with the model, and fit the few physical parameters that bring them together.

What a bench of loads shows is modelled in `loaded`; where stages have set poses, the model is evaluated there. What may
be moved and changed, and what leads and tank add, is in `setup`. What is per metre of depth is taken relative to free
space (`bench`): its scale then is part of the misfit. Inductances are those at the terminals, with leads and idle
coils; with nothing moved they are the table's own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from sits_mech.analysis.bench.force_maps import force_maps_of, layer_slopes
from sits_mech.analysis.bench.loaded import LoadedBench
from sits_mech.analysis.bench.setup import Setup
from sits_mech.analysis.bench.unknowns import LAYER, parameters_of
from sits_mech.analysis.built.fit import Free, Model, ParameterFit, fit_parameters
from sits_mech.analysis.readings.measured import Measured
from sits_mech.chain.models import loaded_model, magnetic_model
from sits_mech.quantities import POSE, Array, MagneticModel, Pose
from sits_mech.readout.loads import points, request_of, several, wrench_of
from sits_mech.scene.sensor import SceneError, Sensor

USUAL = ("modulus", "gap", "lead")
"""What is fitted of a bench of loads by default."""


@dataclass(frozen=True)
class Comparison:
    """A measurement beside the model, with the fitted parameters."""

    measured: Measured
    fit: ParameterFit  # in SI
    free: tuple[Free, ...]  # with what was known of each beforehand
    model: Model  # parameters (k, p) to inductances (k, m, n) [H]
    noise: float | None  # of a reading [H]
    predicted: Array  # (m, n), by the scene as it is [H]
    shear_modulus: float  # at small strain, as fitted [Pa]
    map_error: float  # between the table's loads, over each coil's range; 0 for measured poses
    other_idle: str = ""  # what idle coils may be as well: the readings fit both ways


def compare(
    sensor: Sensor, data: xr.Dataset | None, measured: Measured, free: Sequence[str] = USUAL, *,
    noise: float | None = None, magnetics: str = "auto", tolerance: float = 1e-3,
) -> Comparison:
    """Return a measurement with what the model predicts, and the parameters that bring them together.

    `data` is from `calibrate` and reaches as far as the measured loads over the modulus to be found, or nearly; None
    for measured poses. `free` are names of `setup` or keys of the scene with what is known: ``"gap = 0 +- 0.3 mm"``; it
    is weighed against `noise`, the deviation of a reading [H]. Raises SceneError for an unknown parameter, a table that
    is too small, or a value at the end of its reach.
    """
    measured.check()
    known = parameters_of(sensor, free, measured.poses is not None)
    setup = Setup(sensor, known, _maker(data, measured, magnetics, tolerance))
    if measured.poses is not None:
        return _of_poses(setup, measured, measured.poses, noise)
    if data is None:
        raise SceneError(f"{measured.source}: loads must come with a calibration; got a scene alone")
    return _of_loads(setup, data, measured, noise)


def _maker(
    data: xr.Dataset | None, measured: Measured, magnetics: str, tolerance: float
) -> Callable[[Sensor], MagneticModel]:
    """Return a function that makes the magnetic model of a scene: the table's, or that of the poses."""
    if data is not None:
        request = request_of(data)
        loads = [wrench_of(row) for row in points(data)]
        return lambda scene: loaded_model(scene, request["magnetics"], request["tolerance"], loads)[0]
    poses = np.zeros((0, len(POSE))) if measured.poses is None else measured.poses
    there = [Pose.of(row) for row in poses if np.all(np.isfinite(row))]
    return lambda scene: magnetic_model(scene, magnetics, tolerance, there)[0]


def _of_poses(setup: Setup, measured: Measured, poses: Array, noise: float | None) -> Comparison:
    """Compare readings at poses that stages have set."""
    if not np.any(np.isfinite(poses[:, POSE.index("d_v")])):
        raise SceneError(f"{measured.source}: must hold a row with a target; got d_v = inf in all")

    once, row = np.unique(poses, axis=0, return_inverse=True)

    def model(P: Array) -> Array:
        """Return the inductances for values of the parameters."""
        return setup.readings(np.tile(once, (len(P), 1, 1)), P)[:, row]

    free = setup.free(poses, {})
    fit = fit_parameters(model, measured.L, free, noise=noise)
    bare = replace(setup, parameters=())
    return Comparison(measured, fit, free, model, noise, bare.readings(poses[None], np.zeros((1, 0)))[0], np.nan, 0.0)


def _of_loads(setup: Setup, data: xr.Dataset, measured: Measured, noise: float | None) -> Comparison:
    """Compare readings under loads."""
    sensor, names = setup.sensor, several(data)
    table = force_maps_of(sensor, data, names)
    columns = setup.names
    layer = None
    if {*columns} & {*LAYER}:
        request = request_of(data)
        layer = layer_slopes(sensor, data, names, request["mechanics"], request["tolerance"])
    once, row = np.unique(measured.forces, axis=0, return_inverse=True)
    bench = LoadedBench(setup, table, once, layer)
    free = bench.free()

    def model(P: Array) -> Array:
        """Return the inductances for values of the parameters."""
        return bench.model(P)[:, row]

    fit = fit_parameters(model, measured.L, free, noise=noise, own=table.own, slopes=lambda p: bench.slopes(p)[row])
    factor = float(fit.values[columns.index("modulus")]) if "modulus" in columns else 1.0
    stiffness = np.nan if sensor.elastomer is None else factor * sensor.elastomer.shear_modulus
    bare = table.at(measured.forces[None])[0][0]
    return Comparison(measured, fit, free, model, noise, bare, stiffness, table.error)
