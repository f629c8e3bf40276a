"""Derivatives at a fixed pose: what metal conducts against differences, and against a coil over a half-space."""

import numpy as np
import pytest
from common.infinite_plate import Layer, reflection
from scipy.constants import mu_0

from sits_mech.chain.derivatives.fixed_pose import _cause, _growth, at_fixed_poses
from sits_mech.chain.models import MAGNETICS
from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.coils.ring_field import source_spectrum
from sits_mech.quantities import Pose
from sits_mech.scene.parameters import parameter
from sits_mech.scene.sensor import Sensor, changed, load_sensor
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
    weight = 4e3 * w * np.pi * mu_0 * source_spectrum(rings, k) ** 2 * np.exp(-2.0 * k * gap)

    def by(T: float) -> np.ndarray:
        change = complex(weight @ reflection(k, omega, [Layer(5.8e7 / (1.0 + 3.93e-3 * T), np.inf)]))
        return np.array([change.real, -omega * change.imag])

    expected = (by(0.1) - by(-0.1)) / 0.2
    np.testing.assert_allclose(own, expected, rtol=1e-2)


def test_numbers_of_coils_and_plates_against_differences() -> None:
    """By one model of another scene each; what is not magnetic, and the coils of which it is no number, have none."""
    sensor = load_sensor("biorob2018", ['target.load_height="1 mm"'])
    pose = Pose.of(np.array([[1e-3, 2e-3, 0.05, 0.0, 0.0, 0.0], [0.0, 1.8e-3, 0.0, 0.0, 0.0, 0.0]]))
    names = [
        "frequency", "target.width", "coils.C1.inner_diameter", "coils.C1.centre.0", "target.load_height",
        "elastomer.thickness",
    ]
    numbers = [parameter(sensor, name) for name in names]
    found = at_fixed_poses(sensor, (MAGNETICS["planar"](sensor, 1e-2), "planar", 1e-2), pose, numbers)
    for k, number in enumerate(numbers):
        h, each = 1e-3 * abs(number.value), []
        for way in (1.0, -1.0):
            scene = changed(sensor, [f"{number.name}={number.value + way * h!r}"])
            other = MAGNETICS["planar"](scene, 1e-2).impedance(pose, scene.frequency)
            each.append((other.L, other.R, np.diagonal(other.L0)))
        L, R, L0 = ((up - down) / (2.0 * h) for up, down in zip(*each, strict=True))
        for own, expected in ((found.L, L), (found.R, R), (found.L0, L0)):
            np.testing.assert_allclose(own[..., k], expected, rtol=1e-4, atol=1e-4 * np.abs(expected).max() + 1e-12)
        assert np.all(found.error_L[..., k] <= 1e-4 * np.abs(L).max() + 1e-12)
    assert not any(part[..., 4:].any() for part in found)
    plain = at_fixed_poses(sensor, (MAGNETICS["planar"](sensor, 1e-2), "planar", 1e-2), pose, numbers[4:])
    assert [part.shape for part in plain] == 4 * [(2, 2, 2, 2)] + [(2, 2)] and not any(part.any() for part in plain)


def test_what_metal_conducts_is_told_by_the_frequency_of_one_plate() -> None:
    """dL = g f dL/df and dR = g (f dR/df - R) for a relative growth g of the conductivity by a kelvin."""
    sensor, pose = load_sensor("biorob2018"), Pose.of(np.array([[1e-3, 2e-3, 0.05, 0.0, 0.0, 0.0]]))
    model, metal = MAGNETICS["planar"](sensor, 1e-2), parameter(sensor, METAL)
    found = at_fixed_poses(sensor, (model, "planar", 1e-2), pose, [parameter(sensor, "frequency"), metal])
    ends = [warmed(sensor, {"conductivity": way}).target.metal.conductivity for way in (1.0, 0.0, -1.0)]
    grown, f = (ends[0] - ends[2]) / (2.0 * ends[1]), sensor.frequency
    assert _growth(metal) == pytest.approx(grown, rel=1e-4) and grown == pytest.approx(-3.93e-3, rel=0.1)
    np.testing.assert_allclose(found.L[..., 1], grown * f * found.L[..., 0], rtol=1e-4)
    R = model.impedance(pose, f).R
    np.testing.assert_allclose(found.R[..., 1], grown * (f * found.R[..., 0] - R), rtol=1e-4)
    assert _growth(parameter(sensor.model_copy(update={"target": None}), METAL)) == 0.0


def test_the_cause_of_a_change_is_of_the_number_and_the_model() -> None:
    """Steel and metal beside are differenced; on an axis no coil is moved."""
    sensor, section = load_sensor("biorob2018"), MAGNETICS["planar"](load_sensor("biorob2018"), 0.1)
    steel = load_sensor("biorob2018", ["target.relative_permeability=100", "target.conductivity=7e6"])
    beside = load_sensor("biorob2018", [
        'conductors=[{name="P", material="copper", shape="disc", centre=["0 mm", "-3 mm"], diameter="8 mm", '
        'thickness="0.5 mm"}]',
    ])
    bare = sensor.model_copy(update={"target": None})
    for scene, cause in ((sensor, "metal"), (bare, "metal"), (steel, "length"), (beside, "length")):
        assert _cause(parameter(scene, METAL), section) == cause
    assert _cause(parameter(sensor, "coils.C1.centre.0"), section) == "length"
    coil = sensor.coils[0].model_copy(update={"centre": (0.0, 0.0)})
    disc = sensor.target.model_copy(update={"shape": "disc", "width": None, "length": None, "diameter": 8e-3})
    round_ = sensor.model_copy(update={"coils": (coil,), "target": disc})
    axis = MAGNETICS["axisymmetric"](round_, 0.1)
    assert _cause(parameter(round_, "coils.C1.centre.0"), axis) == ""
    assert _cause(parameter(round_, "coils.C1.inner_diameter"), axis) == "length"
