"""Derivatives at a fixed pose: what metal conducts against differences, and against a coil over a half-space."""

import numpy as np
import pytest
from common.infinite_plate import Layer, reflection
from scipy.constants import mu_0

from sits_mech.chain.derivatives.fixed_pose import at_fixed_poses
from sits_mech.chain.models import MAGNETICS
from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.coils.ring_field import spectrum
from sits_mech.quantities import Pose
from sits_mech.scene.parameters import parameter
from sits_mech.scene.sensor import Sensor, load_sensor
from sits_mech.scene.thermal import warmed

METAL = "temperature.conductivity"


def slope(sensor: Sensor, name: str, pose: Pose, tolerance: float = 1e-3) -> np.ndarray:
    """Return dL/dT and dR/dT of the first coil's own by a model."""
    model = MAGNETICS[name](sensor, tolerance)
    found = at_fixed_poses(sensor, (model, name, tolerance), pose, [parameter(sensor, METAL)])
    return np.array([found.L[0, 0, 0, 0], found.R[0, 0, 0, 0]])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "hertz", "within", "tolerance"),
    [
        ("planar", 5e3, 3e-4, 1e-3),
        ("planar", 5e6, 1e-2, 1e-3),
        pytest.param("sheets", 5e3, 3e-2, 3e-2, marks=pytest.mark.slow),
    ],
)
def test_what_metal_conducts_against_differences(name: str, hertz: float, within: float, tolerance: float) -> None:
    """By frequency alone, against answers for plates 4 and 8 K warmer and colder, divided anew by their skin."""
    sensor = load_sensor("biorob2018", [f"frequency={hertz}"])
    pose = Pose.of(np.array([[1e-3, 2e-3, 0.05, 0.0, 0.0, 0.0]]))
    own, h, each = slope(sensor, name, pose, tolerance), 4.0, {}
    for way in (-2, -1, 1, 2):
        warm = warmed(sensor, {"conductivity": way * h})
        found = MAGNETICS[name](warm, tolerance).impedance(pose, hertz)
        each[way] = np.array([found.L[0, 0, 0], found.R[0, 0, 0]])
    expected = (8.0 * (each[1] - each[-1]) - (each[2] - each[-2])) / (12.0 * h)
    np.testing.assert_allclose(own, expected, rtol=within)


@pytest.mark.slow
def test_the_copper_part_is_that_of_a_coil_over_a_half_space() -> None:
    """A disc of copper, far wider than its coil and some twenty skin depths thick: Dodd and Deeds, differenced."""
    plain = load_sensor("biorob2018")
    base = plain.coils[0].model_copy(update={"centre": (0.0, 0.0)})
    target = plain.target.model_copy(update={"shape": "disc", "width": None, "length": None, "diameter": 40e-3,
                                             "thickness": 0.6e-3, "load_height": 0.6e-3})
    sensor = plain.model_copy(update={"coils": (base,), "target": target, "elastomer": None})
    gap, omega = 2e-3, 2 * np.pi * sensor.frequency
    own = slope(sensor, "axisymmetric", Pose.of(np.array([[0.0, gap, 0.0, 0.0, 0.0, 0.0]])))
    rings = coil_sections(base)
    x, w = np.polynomial.legendre.leggauss(600)
    k = 4e3 * (x + 1.0)
    weight = 4e3 * w * np.pi * mu_0 * spectrum(rings, k) ** 2 * np.exp(-2.0 * k * gap)

    def by(T: float) -> np.ndarray:
        change = complex(weight @ reflection(k, omega, [Layer(5.8e7 / (1.0 + 3.93e-3 * T), np.inf)]))
        return np.array([change.real, -omega * change.imag])

    expected = (by(0.1) - by(-0.1)) / 0.2
    np.testing.assert_allclose(own, expected, rtol=1e-2)
