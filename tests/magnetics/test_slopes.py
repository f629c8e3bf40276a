"""Derivatives by pose and frequency against closed forms, symmetry and splines through the same model."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.slopes import slopes
from sits_mech.quantities import POSE, MagneticModel, Pose
from sits_mech.scene.sensor import Sensor, load_sensor

MM = 1e-3
PLACE = {"d_h": 0.4 * MM, "d_v": 2.1 * MM, "alpha": 0.03, "d_y": 0.2 * MM, "alpha_x": -0.02, "alpha_z": 0.1}


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    return load_sensor("biorob2018")


@pytest.mark.parametrize("name", POSE)
def test_as_a_spline_through_poses(sensor: Sensor, name: str) -> None:
    """A spline of degree 7 through poses along one component, differentiated."""
    model = sheets(sensor, 1e-2)
    found = slopes(sensor, model, Pose(**PLACE), 5e6)
    way = np.linspace(-1.0, 1.0, 41) * (0.2 * MM if name.startswith("d") else 0.05)
    along = Pose(**{key: value + way * (key == name) for key, value in PLACE.items()})
    Z, k = model.impedance(along, 5e6), POSE.index(name)
    for curve, slope in ((Z.L, found.L), (Z.R, found.R)):
        exact = make_interp_spline(way, curve.reshape(len(way), -1), k=7).derivative()(0.0).reshape(2, 2)
        np.testing.assert_allclose(slope[..., k], exact, rtol=0, atol=1e-6 * np.abs(exact).max())


def test_symmetry(sensor: Sensor) -> None:
    """Over the middle of two coils: equal and opposite by shift, equal by height, none by what leaves the plane."""
    found = slopes(sensor, sheets(sensor, 1e-2), Pose(0.0, 2 * MM), 5e6)
    own = np.diagonal(found.L, axis1=0, axis2=1)  # component by coil
    largest = np.abs(own).max(axis=1)
    for k, sign in ((0, -1.0), (1, 1.0), (2, -1.0)):
        assert own[k, 0] == pytest.approx(sign * own[k, 1], rel=1e-6)
    assert largest[3] < 1e-7 * largest[0] and largest[4] < 1e-7 * largest[2] and largest[5] < 1e-7 * largest[2]
    assert np.all(own[1] > 0.0)  # the plate goes away, the inductance comes back


def test_frequency(sensor: Sensor) -> None:
    """At low frequency R goes with the square of the frequency, and so does the change of L."""
    model, pose = sheets(sensor, 1e-2), Pose(0.0, 2 * MM)
    found, Z = slopes(sensor, model, pose, 200.0, components=("d_v",)), model.impedance(pose, 200.0)
    assert found.R_frequency[0, 0] == pytest.approx(2.0 * Z.R[0, 0] / 200.0, rel=2e-3)
    assert found.L_frequency[0, 0] == pytest.approx(2.0 * (Z.L - Z.L0)[0, 0] / 200.0, rel=1e-2)


def test_many_poses_and_the_planar_model(sensor: Sensor) -> None:
    model: MagneticModel = planar_bars(sensor, 1e-2)
    gap = np.array([[1.5, 2.0, 2.5], [3.0, 3.5, 4.0]]) * MM
    found = slopes(sensor, model, Pose(0.0 * gap, gap, 0.0 * gap), 5e6, components=POSE[:3])
    assert found.L.shape == (2, 3, 2, 2, 3) and found.R_frequency.shape == (2, 3, 2, 2)
    one = slopes(sensor, model, Pose(0.0, 3.5 * MM), 5e6, components=("d_v",))
    np.testing.assert_allclose(found.L[1, 1, ..., 1], one.L[..., 0], rtol=1e-9)


def test_refused(sensor: Sensor) -> None:
    with pytest.raises(ValueError, match="components: must be of d_h.*got 'x'"):
        slopes(sensor, sheets(sensor, 1e-2), Pose(0.0, 2 * MM), 5e6, components=("x",))
    bare = load_sensor("biorob2018").model_copy(update={"target": None, "elastomer": None})
    with pytest.raises(ValueError, match="target: the scene has none"):
        slopes(bare, sheets(sensor, 1e-2), Pose(0.0, 2 * MM), 5e6)
