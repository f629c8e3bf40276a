"""Lines of eddy current: what they give back against volume finite elements, zero at the rim, mirror, holes."""

import numpy as np
import pytest

from sits_mech.geometry.collision import Collision
from sits_mech.quantities import Pose
from sits_mech.report.pictures.stream import Stream, plate_stream, target_points
from sits_mech.scene.sensor import Sensor, load_sensor

ONE = np.array([0.0, 1.0])


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    return load_sensor("biorob2018")


@pytest.fixture(scope="module")
def stream(sensor: Sensor) -> Stream:
    return plate_stream(sensor, Pose(0.0, 2e-3), 5e3, ONE, cells=16)


def test_gives_back_what_volume_finite_elements_say(sensor: Sensor, stream: Stream) -> None:
    """8 x 8 x 0.2 mm copper at 2 mm: -2.17167 nH and 2.9623e-4 ohm at 5 kHz, -59.013 nH at 5 MHz (NGSolve 3D, 2e-4).

    Even current over the thickness: a few per cent when it is thin, some ten when the skin depth is 29 um.
    """
    omega = 2 * np.pi * 5e3
    assert stream.change.imag / omega == pytest.approx(-2.17167e-9, rel=3e-2)
    assert stream.change.real == pytest.approx(2.9623e-4, rel=3e-2)
    thick = plate_stream(sensor, Pose(0.0, 2e-3), 5e6, ONE, cells=16)
    assert thick.change.imag / (1e3 * omega) == pytest.approx(-59.0134e-9, rel=0.12)


@pytest.mark.slow
def test_a_scene_turned_by_a_quarter_gives_back_the_same(sensor: Sensor) -> None:
    """Coils on y, target moved along y and turned about x: as along x and about y, but for the triangles."""
    across = load_sensor("biorob2018", ["coils.C1.centre=[0, -0.004]", "coils.C2.centre=[0, 0.004]"])
    one = plate_stream(sensor, Pose(1.5e-3, 2.5e-3, 0.3), 5e3, ONE, cells=16)
    other = plate_stream(across, Pose(0.0, 2.5e-3, d_y=1.5e-3, alpha_x=-0.3), 5e3, ONE, cells=16)
    assert other.change == pytest.approx(one.change, rel=3e-2)
    assert abs(plate_stream(across, Pose(0.0, 2.5e-3), 5e3, ONE, cells=16).change / one.change - 1.0) > 0.3


def test_a_slot_is_rim(sensor: Sensor) -> None:
    """An outline from the scene: all of psi is finite, the slot's mouth is rim."""
    target = sensor.target
    assert target is not None
    x, y = (-4e-3, -1e-3, -1e-3, 1e-3, 1e-3, 4e-3, 4e-3, -4e-3), (-4e-3, -4e-3, 0.0, 0.0, -4e-3, -4e-3, 4e-3, 4e-3)
    points = tuple(zip(x, y, strict=True))
    slotted = target.model_copy(update={"shape": "outline", "points": points, "width": None, "length": None})
    found = plate_stream(sensor.model_copy(update={"target": slotted}), Pose(0.0, 2e-3), 5e3, ONE, cells=16)
    mouth = (np.abs(np.abs(found.nodes[:, 0]) - 1e-3) < 1e-9) & (found.nodes[:, 1] < -1e-9)
    assert mouth.sum() > 4 and np.all(found.psi[mouth] == 0.0) and np.all(np.isfinite(found.psi))


def test_rim_carries_no_value(stream: Stream) -> None:
    half = np.max(np.abs(stream.nodes))
    rim = np.isclose(np.abs(stream.nodes).max(axis=1), half, rtol=1e-9)
    assert half == pytest.approx(4e-3) and np.all(stream.psi[rim] == 0.0) and np.all(np.abs(stream.psi[~rim]) > 0.0)


def test_mirror_swaps_the_coils(sensor: Sensor, stream: Stream) -> None:
    """Driving the other coil gives back the same but for the triangles (no mirror); currents oppose the coil's."""
    other = plate_stream(sensor, Pose(0.0, 2e-3), 5e3, ONE[::-1], cells=16)
    assert other.change == pytest.approx(stream.change, rel=3e-2)
    assert stream.change.imag < 0.0 < stream.change.real


def test_points_of_the_target_turn_clockwise() -> None:
    found = target_points(np.array([[4e-3, 1e-3, 0.0], [0.0, 0.0, 2e-4]]), Pose(1e-3, 2e-3, 0.1))
    c, s = np.cos(0.1), np.sin(0.1)
    expected = [[1e-3 + 4e-3 * c, 1e-3, 2e-3 - 4e-3 * s], [1e-3 + 2e-4 * s, 0.0, 2e-3 + 2e-4 * c]]
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_refused(sensor: Sensor) -> None:
    with pytest.raises(ValueError, match="target: must be given"):
        plate_stream(sensor.model_copy(update={"target": None}), Pose(0.0, 2e-3), 5e6, ONE)
    with pytest.raises(ValueError, match="frequency: must be"):
        plate_stream(sensor, Pose(0.0, 2e-3), 0.0, ONE)
    with pytest.raises(Collision):
        plate_stream(sensor, Pose(0.0, 2e-3, 1.0), 5e6, ONE)
