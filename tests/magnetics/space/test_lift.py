"""A plate that bends under its coils: one that is turned by its points is one that is turned."""

import numpy as np
import pytest

from sits_mech.magnetics.pose_slopes import lift_slopes, pose_slopes
from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.space.lift import Lift
from sits_mech.quantities import Array, Pose
from sits_mech.scene.sensor import load_sensor

POSE = Pose(0.3e-3, 1.5e-3)


def rigid(places: Array) -> Array:
    """Rise by 1, and by -x as alpha does."""
    found = np.zeros((6, len(places), 2))
    found[0], found[1, :, 1] = np.stack([np.ones(len(places)), -places[:, 0]], axis=1), -1.0
    return found


@pytest.mark.parametrize("name", ["biorob2018", "biorob2018-w15"])
def test_what_turns_by_its_points_is_seen_as_what_turns(name: str) -> None:
    sensor = load_sensor(name)
    model = sheets(sensor, 1e-2).varied(sensor, single=True)
    turned = Pose.of(POSE.components[None])
    _, slopes, _ = pose_slopes(sensor, model, turned, sensor.frequency, ("d_v", "alpha", "d_h"))
    by = np.diagonal(slopes[0], axis1=0, axis2=1)
    sizes, half = np.array([1.0, 0.5 * sensor.target.width]), 0.5 * sensor.target.thickness
    bottom, middle = (lift_slopes(sensor, POSE, rigid, np.array([0.0, plane]), sizes)[1] for plane in (0.0, half))
    spirals = load_sensor(name, [f'coils.{k}.winding="spiral"' for k in (0, 1)])
    np.testing.assert_array_equal(lift_slopes(spirals, POSE, rigid, np.zeros(2), sizes)[1], bottom)
    np.testing.assert_allclose(bottom, by[1] / by[0], rtol=2e-3)  # a pose turns about the bottom face's middle
    np.testing.assert_allclose(middle, (by[1] - half * by[2]) / by[0], rtol=2e-3)


def test_points_go_with_their_normals() -> None:
    """w = x y: z below the middle plane they move by -z y and -z x, and A = (y, 0, 0) becomes J^T A there."""
    def saddle(p: Array) -> Array:
        """Return x y with its derivatives."""
        (x, y), one = p.T, np.ones(len(p))
        return np.stack([x * y, y, x, 0.0 * one, one, 0.0 * one])[..., None]

    lift = Lift(saddle, np.array([0.1]), np.array([[1e-3]]))
    points = np.array([[0.5, -0.4, 0.0], [0.2, 0.3, 0.2]])
    found, z = lift.at(points), np.array([-0.1, 0.1])
    x, y, _ = points.T
    np.testing.assert_allclose(found.places[0], [x - 1e-3 * z * y, y - 1e-3 * z * x, points[:, 2] + 1e-3 * x * y])
    A = np.stack([y, 0.0 * y, 0.0 * y])[None]
    np.testing.assert_allclose(found.met(A)[0], [y, -1e-3 * z * y, -1e-3 * y * y], atol=1e-15)
