"""What a pose's error is worth in the signals: against differences of them, and by hand."""

from dataclasses import dataclass

import numpy as np
import pytest

from sits_mech.chain.models import magnetic_model
from sits_mech.chain.plans.goal import Goal, farthest, goal_of, goal_rows
from sits_mech.quantities import Array, Bounded, Impedance, Pose, SolveReport
from sits_mech.scene.sensor import load_sensor

SENSOR = load_sensor("biorob2018-w15")
FAR, NEAR = Pose(4e-4, 1.9e-3, 2e-3), Pose(-2e-4, 1.95e-3, -1e-3)


@dataclass(frozen=True)
class Common:
    """L1, L2 = 1 - 50 (2 mm - d_v) -+ 20 d_h, with an error that all poses share and one of each pose."""

    shared: float
    own: float

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return the closed form."""
        d_h, d_v = np.broadcast_arrays(pose.d_h, pose.d_v)
        both = 1.0 - 50.0 * (2e-3 - d_v)
        L = np.zeros((*d_v.shape, 2, 2))
        L[..., 0, 0], L[..., 1, 1] = both - 20.0 * d_h, both + 20.0 * d_h
        error = np.broadcast_to((self.shared + self.own) * np.eye(2), L.shape)
        parts = np.broadcast_to(self.shared * np.eye(2), (1, *L.shape))
        report = SolveReport("common", 1, 1, 0.0, 1e-3, 0.0)
        return Impedance(frequency, L, L, np.eye(2), np.ones(2), error, error, "H", report, parts)


def test_weights_are_slopes_of_the_signals_over_the_largest_range() -> None:
    field, _ = magnetic_model(SENSOR, "planar", 1e-3)
    found = goal_of(SENSOR, field, [NEAR, FAR])
    assert found is not None

    def shown(pose: Pose) -> Array:
        """L_v and L_h over the mean L0."""
        once = field.impedance(pose, SENSOR.frequency)
        L1, L2 = np.diag(once.L)
        return np.array([L1 + L2, L1 - L2]) / np.mean(np.diag(once.L0))

    size = np.ptp([shown(pose) for pose in (Pose(0.0, 2e-3), NEAR, FAR)], axis=0).max()
    steps = (1e-6, 1e-6, 1e-5)
    for k, step in enumerate(steps):
        up, down = (Pose.of(FAR.components + way * step * np.eye(6)[k]) for way in (1.0, -1.0))
        slopes = (shown(up) - shown(down)) / (2.0 * step * size)
        np.testing.assert_allclose(found.weights[:, k], slopes, rtol=3e-3, atol=1e-3 * np.abs(slopes).max())
    assert not found.weights[:, 3:].any()  # nothing leaves the plane


def test_what_the_poses_share_with_the_rest_is_no_doubt() -> None:
    """L_v goes by 0.01 from rest to 1.9 mm, L_h less; own errors of two coils, at two poses."""
    for shared in (0.0, 1e-3):
        found = goal_of(SENSOR, Common(shared, 1e-5), [FAR])
        assert found is not None
        assert found.magnetics == pytest.approx(4e-5 / 0.016, rel=1e-6)  # L_h = 2 x 20 x 0.4 mm is the largest
        np.testing.assert_allclose(found.weights[0, :2], [0.0, 100.0 / 0.016], atol=1e-3)


def test_shared_parts_of_an_error_cancel_as_far_as_their_signs_say() -> None:
    goal = Goal(np.array([[2.0, -1.0, 0, 0, 0, 0], [0.5, 0.0, 0, 0, 0, 0]]), 1e-3)
    rest, error = np.zeros(6), np.array([1e-3, 2e-3, 0, 0, 0, 0])
    assert goal.mechanics(Bounded.of(rest, error)) == pytest.approx(4e-3)
    assert goal.mechanics(Bounded.of(rest, error, error[None])) == pytest.approx(0.5e-3)  # that of the second signal
    assert goal.mechanics(Bounded.of(rest, error, 0.5 * error[None])) == pytest.approx(2e-3)
    assert goal.of(Bounded.of(rest, error)) == pytest.approx(5e-3)
    assert goal.left(1e-2) == pytest.approx(9e-3) and goal.left(1.5e-3) == pytest.approx(0.75e-3)


def test_signals_that_stay_make_no_goal() -> None:
    field, _ = magnetic_model(SENSOR, "planar", 0.1)
    assert goal_of(SENSOR, field, [Pose(0.0, 2e-3)]) is None
    bare = SENSOR.model_copy(update={"elastomer": None})
    assert goal_of(bare, field, [FAR]) is None


def test_a_disc_on_the_axis_is_not_moved_off_it() -> None:
    """What leaves the axis has no weight where the model holds none."""
    one = load_sensor("biorob2018", [
        'target={material="copper", shape="disc", diameter="7 mm", thickness="0.2 mm"}',
        'coils=[{name="C", centre=["0 mm", "0 mm"], layers=2, turns=12, inner_diameter="2.2 mm", '
        'track_width="0.1 mm", track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}]',
    ])
    found = goal_of(one, magnetic_model(one, "axisymmetric", 1e-2)[0], [Pose(0.0, 1.9e-3)])
    assert found is not None and found.weights[0, 1] > 0.0 and not found.weights[:, [0, 2, 3, 4, 5]].any()


def test_the_farthest_poses_are_the_ends_of_each_component() -> None:
    each = np.array([[0, 2, 0, 0, 0, 0], [3, 1, 0, 0, 0, 0], [1, 2, -1, 0, 0, 0], [1, 1.5, 0, 0, 0, 0]], dtype=float)
    assert [pose.components.tolist() for pose in farthest(Pose.of(each))] == each[[0, 1, 2]].tolist()


def test_a_tolerance_is_of_the_signals_of_a_pair_and_of_all_beyond() -> None:
    assert goal_rows(SENSOR).tolist() == [[1.0, 1.0], [1.0, -1.0]]
    assert len(goal_rows(load_sensor("triaxial-3"))) == len(goal_rows(load_sensor("triaxial-4"))) == 3
