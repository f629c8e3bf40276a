"""A calibration by models that cost little, what is unknown of it, and a sensor that was built otherwise."""

from collections.abc import Callable
from contextlib import AbstractContextManager

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.built.prior import Prior, prior_of
from sits_mech.analysis.readings.measured import Measured
from sits_mech.chain.calibrate import calibrate
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Sensor, load_sensor

OTHERWISE = {"modulus": 0.85, "gap": 4e-5, "d_h": 1e-4, "alpha": 0.004, "cell": 1.005, "lead": 1e-8}
"""How the built sensor differs from the scene."""
LOADS = np.array([[0.0, 0.0], [0.3, 0.0], [0.3, 1.2], [-0.3, 1.2], [0.0, 0.6]])


@pytest.fixture(scope="package")
def cheap(numerics_alone: Callable[[], AbstractContextManager[None]]) -> tuple[Sensor, xr.Dataset]:
    """The published sensor by the linear layer and the planar model, which make the readings as well."""
    sensor, axes = load_sensor("biorob2018-w15"), {"F_x": np.linspace(-0.5, 0.5, 5), "F_z": np.linspace(0.0, 2.0, 5)}
    with numerics_alone():
        return sensor, calibrate(sensor, **axes, mechanics="linear", magnetics="planar", tolerance=0.02)


@pytest.fixture(scope="package")
def prior(cheap: tuple[Sensor, xr.Dataset]) -> Prior:
    """What is unknown of it, all that may be."""
    return prior_of(*cheap)


def unknowns(prior: Prior, **values: float) -> Array:
    """Return unknowns by name; others as known beforehand."""
    p = prior.start.copy()
    for number, each in enumerate(prior.setup.parameters):
        p[number] = values.get(each.name, p[number])
    return p


def bench_of(prior: Prior, loads: Array = LOADS, *, depth: bool = False, seed: int = 1, **values: float) -> Measured:
    """Return what a sensor shows that was built otherwise, with noise of readings and of the model."""
    shown = prior.bench(loads, depth=depth).model(unknowns(prior, **(values or OTHERWISE))[None])[0]
    noise = np.hypot(prior.noise, prior.model) * np.random.default_rng(seed).standard_normal((len(loads), 2))
    return Measured(loads, shown[:, :2] + noise, "bench.csv", None, shown[:, 2] if depth else None)
