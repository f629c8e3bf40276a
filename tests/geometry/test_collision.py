"""The guard: the lowest point of the tilted plate."""

import numpy as np
import pytest

from sits_mech.geometry.collision import Collision, check_clearance, clearance
from sits_mech.quantities import Pose
from sits_mech.sensor import load_sensor


@pytest.mark.parametrize(("name", "hits"), [("biorob2018", False), ("biorob2018-w15", True), ("biorob2018-w22", True)])
def test_wide_plates_hit_the_coils_at_20_degrees(name, hits):
    sensor, pose = load_sensor(name), Pose(0.0, 2e-3, np.radians(20.0))
    assert (clearance(sensor, pose) <= 0.0) == hits
    if hits:
        with pytest.raises(Collision, match="alpha = 20 deg"):
            check_clearance(sensor, pose)


def test_clearance_is_the_lowest_corner():
    sensor = load_sensor("biorob2018")
    alpha = np.linspace(-3.0, 3.0, 25)
    corners = np.array([[xi, eta] for xi in (-4e-3, 4e-3) for eta in (0.0, 2e-4)])
    z = 5e-3 - corners[:, :1] * np.sin(alpha) + corners[:, 1:] * np.cos(alpha)
    np.testing.assert_allclose(clearance(sensor, Pose(0.0, 5e-3, alpha)), z.min(axis=0), rtol=1e-12)


def test_a_pose_that_is_no_number_is_refused():
    with pytest.raises(Collision):
        check_clearance(load_sensor("biorob2018"), Pose(0.0, np.nan, 0.0))
