"""Small gaps under wide plates: the infinite plate's integral, exactness of the carrying, rings, and larger gaps."""

from __future__ import annotations

import numpy as np
import pytest
from common.infinite_plate import coil_change

from sits_mech.geometry.solids import lowest_points
from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.axis.dodd_deeds import Layer
from sits_mech.magnetics.rings import axisymmetric
from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.space.near import FACTORS, averaged, carried_down, infinite_plate, under_plate
from sits_mech.quantities import Pose
from sits_mech.scene.materials import metals
from sits_mech.scene.sensor import Sensor, load_sensor

MM = 1e-3
OMEGA = 2 * np.pi * 5e6


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    return load_sensor("biorob2018")


def disc(diameter: float) -> Sensor:
    """One coil, outer diameter 6.8 mm, under a coaxial disc; the other out of the way."""
    target = f'target={{material="copper", shape="disc", diameter={diameter}, thickness="0.2 mm"}}'
    return load_sensor("biorob2018", [target, 'coils.C1.centre=["0 mm","0 mm"]', 'coils.C2.centre=["30 mm","0 mm"]'])


def test_infinite_plate_as_the_adaptive_integral(sensor: Sensor) -> None:
    """Panels and a spline over heights against `coil_change`; far from each other the coils' mutual one is small."""
    target = sensor.target
    assert target is not None
    heights = np.array([0.05, 0.11, 0.7, 3.0]) * MM
    D = infinite_plate(sensor.coils, target, (heights[0], 2 * heights[-1]), 5e6)(heights, slice(None))
    plate = [Layer(metals()["copper"].conductivity, target.thickness)]
    exact = coil_change(coil_sections(sensor.coils[0]), heights, 5e6, plate)
    assert D[:, 0, 0].imag / OMEGA == pytest.approx(exact.delta_L, rel=1e-5, abs=0)
    assert D[:, 1, 1].real == pytest.approx(exact.R, rel=1e-5)
    np.testing.assert_allclose(D, np.swapaxes(D, 1, 2), rtol=0)
    assert np.all(np.abs(D[:, 0, 1]) < 0.5 * np.abs(D[:, 0, 0]))


def test_a_share_that_is_a_polynomial_is_carried_exactly() -> None:
    rng = np.random.default_rng(1)
    below, lowest = np.array([0.1, 0.6]), 1.0
    heights = np.hstack([below[:, None], np.tile(FACTORS * lowest, (2, 1))])
    base = rng.normal(size=(2, 3, 3))
    D = np.exp(-heights)[..., None, None] * (np.eye(3) * 4 + (base[0] + base[0].T)) + 3j * np.eye(3)
    P = np.eye(3) + 0.1 * (heights[..., None, None] ** 3 - heights[..., None, None]) * (base[1] + base[1].T)
    Z = sum(unit * (P @ part + part @ P) / 2 for unit, part in ((1, D.real), (1j, D.imag)))
    found, error = carried_down(Z[:, 1:], (D[:, 1:], D[:, 0]), below, lowest)
    np.testing.assert_allclose(found, Z[:, 0], rtol=1e-10)
    assert np.abs(error).max() < 1e-10 * np.abs(Z).max()  # of the third degree: the fourth adds nothing


def test_heights_over_the_windings(sensor: Sensor) -> None:
    target = sensor.target
    assert target is not None
    c, s = np.cos(0.1), np.sin(0.1)
    turn = np.array([[[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]])  # right edge down
    place = np.array([[0.0, 0.0, 1.0 * MM]])
    gap = lowest_points(target, None, turn, place)
    for turned, placed in ((turn, place), (turn @ np.diag([-1.0, 1.0, -1.0]), place + 0.2 * MM * turn[:, :, 2])):
        height, weight = under_plate(sensor.coils, target, None, (turned, placed), gap)
        mean = (height * weight).sum(-1)[0]
        assert mean[0] - 1.0 * MM == pytest.approx(1.0 * MM - mean[1], rel=1e-9)  # coils mirrored about the middle
        assert mean[0] > 1.1 * MM and height.min() >= gap[0]
        assert weight.sum(-1) == pytest.approx(1.0)
    own = lambda h, rows: (h[..., None, None] * np.eye(2) * (1 + 1j))[..., rows, :]  # noqa: E731
    flat = averaged(own, (height, weight), np.array([2 * MM]))
    np.testing.assert_allclose(np.diagonal(flat[0]), (mean + 2 * MM) * (1 + 1j), rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("diameter, gap", [(4.6 * MM, 0.05 * MM), (15 * MM, 0.05 * MM)])
def test_discs_as_rings(diameter: float, gap: float) -> None:
    """A disc whose edge lies above the windings, and one wider than the coil: promised 1 % of Delta L, 5 % of R."""
    scene = disc(diameter)
    z = sheets(scene, 1e-2).impedance(Pose(0.0, gap), 5e6)
    alone = scene.model_copy(update={"coils": scene.coils[:1]})
    exact = axisymmetric(alone, 2e-3).impedance(Pose(0.0, gap), 5e6)
    assert any("carried down" in note for note in z.report.notes)
    difference, change = abs(z.L - exact.L[0, 0])[0, 0], abs(exact.L - exact.L0)[0, 0]
    assert difference < 1e-2 * change and difference < z.error_L[0, 0] + 2e-3 * change
    assert z.R[0, 0] == pytest.approx(exact.R[0, 0], rel=5e-2)


@pytest.mark.slow
def test_wide_plate_as_infinite(sensor: Sensor) -> None:
    """40 mm wide at 0.3 mm: Dodd and Deeds, less what the plate lacks of infinity."""
    wide = [f'{part}.{side}="40 mm"' for part in ("elastomer", "target") for side in ("width", "length")]
    z = sheets(load_sensor("biorob2018", wide), 1e-2).impedance(Pose(0.0, 0.3 * MM), 5e6)
    plate = [Layer(metals()["copper"].conductivity, 0.2 * MM)]
    exact = coil_change(coil_sections(sensor.coils[0]), 0.3 * MM, 5e6, plate)
    assert (z.L - z.L0)[0, 0] == pytest.approx(float(exact.delta_L), rel=1e-2)
    assert z.R[0, 0] == pytest.approx(float(exact.R), rel=1e-1)


@pytest.mark.slow
def test_no_step_where_the_carrying_begins(sensor: Sensor) -> None:
    model = sheets(sensor, 1e-2)
    lowest = 2.0**-11
    poses = Pose(np.full(2, 0.5 * MM), lowest * np.array([1.0 - 1e-6, 1.0 + 1e-6]) + 4 * MM * np.sin(0.02), 0.02)
    z = model.impedance(poses, 5e6)
    change = z.L - z.L0
    assert any("carried down" in note for note in z.report.notes)
    np.testing.assert_allclose(change[0], change[1], rtol=0, atol=2e-5 * np.abs(change).max())
    assert np.abs(change[0] - change[1]).max() > 0.0
