"""Errors of what the coils show, by those of the poses: a model that is linear in the pose gives them by hand."""

import numpy as np
import pytest

from sits_mech.chain.models import mechanical_model
from sits_mech.chain.propagation import _untilted, levers, poses_of, read_poses, signal_weights, unloaded_pose
from sits_mech.quantities import Bounded, Equilibrium, Impedance, Pose, SolveReport, Wrench
from sits_mech.readout.signals import combine
from sits_mech.scene.sensor import load_sensor

SLOPES = np.array([[2e-5, 3e-5, -4e-7], [-2e-5, 3e-5, 4e-7]])  # of two coils by d_h, d_v [H/m] and alpha [H/rad]
POSES = np.array([[0.0, 1.9e-3, 0.0, 0.0, 0.0, 0.0], [2e-4, 1.8e-3, -2e-3, 0.0, 0.0, 0.0]])
ERRORS = np.array([[1e-6, 1e-6, 1e-6, 0.0, 0.0, 0.0]] * 2)
SHARED = np.array([[[6e-7, 0, 0, 0, 0, 0], [6e-7, 5e-7, -1e-6, 0, 0, 0]]])  # one part of the errors at two poses


class Linear:
    """L = L0 + slopes p; its own error is 5 pH a coil, of which 2 pH, of either sign, are shared."""

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        own = np.einsum("...k,ck->...c", pose.components[..., :3], SLOPES)
        L = 2.5e-6 * np.eye(2) + own[..., None] * np.eye(2)
        shared = np.broadcast_to(np.diag([2e-12, -2e-12]), (1, *L.shape))
        zero, error, report = np.zeros_like(L), np.full(L.shape, 5e-12), SolveReport("linear", 0, 0, 0.0, 0.0, 0.0)
        return Impedance(frequency, L, zero, 2.5e-6 * np.eye(2), np.zeros(2), error, zero, "H", report, shared)


@pytest.fixture(scope="module")
def sensor():
    return load_sensor("biorob2018")


def test_what_loads_share_has_its_sign_and_the_rest_is_by_component(sensor):
    found = read_poses(sensor, Linear(), Bounded.of(POSES, ERRORS, SHARED))
    parts = SHARED[..., :3] @ SLOPES.T
    np.testing.assert_allclose(found.shared[0], parts[0], atol=1e-18)
    np.testing.assert_allclose(found.shared[1], [[2e-12, -2e-12]] * 2)
    left = (1e-6 - np.abs(SHARED[0, :, :3])) * [[1.0, 1.0, 1.0]]
    np.testing.assert_allclose(found.alone, np.einsum("pk,ck->kpc", left, SLOPES), atol=1e-18)
    total = 5e-12 + np.abs(parts[0]) + np.einsum("pk,ck->pc", left, np.abs(SLOPES))
    np.testing.assert_allclose(np.diagonal(found.impedance.error_L, axis1=1, axis2=2), total, rtol=1e-9)


def test_without_shared_parts_every_component_counts_in_full(sensor):
    found = read_poses(sensor, Linear(), Bounded.of(POSES, ERRORS))
    total = 5e-12 + np.abs(SLOPES).sum(axis=1) * 1e-6
    np.testing.assert_allclose(np.diagonal(found.impedance.error_L, axis1=1, axis2=2), [total] * 2, rtol=1e-9)
    assert found.shared.shape == (1, 2, 2)  # the magnetic model's alone


def test_signals_have_the_errors_of_their_combinations(sensor):
    """What both coils share cancels in their sum, their slopes by d_h do; out of the plane as well, where poses go."""
    one, two = (read_poses(sensor, Linear(), Bounded.of(POSES, ERRORS + more)) for more in (0.0, [0, 0, 0, 1e-6, 0, 0]))
    for found in (one, two):
        np.testing.assert_allclose(found.signals.error_L_v, 6e-12 + 6e-5 * 1e-6, rtol=1e-9)
        np.testing.assert_allclose(found.signals.error_L_h, 1e-11 + 4e-5 * 1e-6 + 8e-7 * 1e-6, rtol=1e-9)
    assert len(one.alone) == 3 and len(two.alone) == 4 and not two.alone[3].any()


def test_poses_share_as_many_parts_as_all_of_them_have():
    report = SolveReport("any", 0, 0, 0.0, 0.0, 0.0)
    places, errors = np.arange(12.0).reshape(2, 6), 100.0 + np.arange(12.0).reshape(2, 6)
    rests = [
        Equilibrium(Wrench(), Pose(*place), Pose(*error), np.zeros(0), report, np.full((2 + k, 6), k + 1.0))
        for k, (place, error) in enumerate(zip(places, errors, strict=True))
    ]
    found, none = poses_of(rests), poses_of([])
    np.testing.assert_array_equal(found.value, places)
    assert found.shared.tolist() == [[[1.0] * 6, [2.0] * 6]] * 2
    np.testing.assert_allclose(found.error, errors)
    assert none.value.shape == (0, 6) and none.shared.shape == (0, 0, 6)


def test_weights_of_signals_know_the_largest_coil(sensor):
    """Two coils nearly about one axis: their distance counts as no less than a quarter of the larger one's diameter."""
    small, large = sensor.coils[0], sensor.coils[1].model_copy(update={"turns": 24})
    near = [coil.model_copy(update={"centre": (x, 0.0)}) for coil, x in ((small, -1e-4), (large, 1e-4))]
    weights = signal_weights(sensor.model_copy(update={"coils": tuple(near)}))
    assert large.outer_diameter > small.outer_diameter
    np.testing.assert_allclose(weights[1], np.array([1e-4, -1e-4]) / (0.25 * large.outer_diameter))


def test_a_place_does_not_count_for_what_the_rotation_does(sensor):
    """Unrotated a coil's error is by the place alone; the difference of both by the angle, and the model's own rest."""
    found, weights = read_poses(sensor, Linear(), Bounded.of(POSES, ERRORS, SHARED)), signal_weights(sensor)
    np.testing.assert_allclose(found.shared_untilted[0], SHARED[0, :, :2] @ SLOPES[:, :2].T, atol=1e-18)
    angle = np.array([1e-6, 0.0])  # what the shared part leaves of the error of alpha
    rest = np.full(2, 3e-12) @ np.abs(combine(np.eye(2), weights))
    expected = rest + angle[:, None] * np.abs(combine(SLOPES[:, 2], weights))
    np.testing.assert_allclose(found.turned, expected, atol=1e-18)


def test_a_pose_without_rotation_is_not_solved_twice(sensor):
    """Neither is one whose rotation is rounding; any other is solved at its place, the rotation left out."""
    model, flat, rounded, turned = Linear(), *(Pose.of([[1e-4, 2e-3, angle, 0, 0, 0]]) for angle in (0.0, 1e-18, 1e-3))
    for pose in (flat, rounded):
        found = model.impedance(pose, sensor.frequency)
        assert _untilted(model, found, pose) is found
    placed = _untilted(model, model.impedance(turned, 1e6), turned)
    np.testing.assert_array_equal(placed.L, model.impedance(flat, 1e6).L)


@pytest.mark.parametrize(("keys", "within"), [
    ([f"{part}.{side}=0.008" for part in ("target", "elastomer") for side in ("width", "length")], 0.03), ([], 0.2),
])
def test_warm_silicone_lifts_the_target(keys, within):
    """At rest about where the model in space has it, not where it was made; at 20 degC where it was made."""
    warm = load_sensor("biorob2018", [*keys, 'temperature="60 degC"'])
    made = unloaded_pose(load_sensor("biorob2018", keys)).d_v
    rest = mechanical_model(warm, "block", 0.1)[0].equilibrium(Wrench()).pose.d_v
    assert made == 2e-3 and unloaded_pose(warm).d_v - made == pytest.approx(rest - made, rel=within)
    assert rest - made > 5e-5


def test_levers_are_half_the_sides():
    """An angle moves an end of the target by half its side, one about z by half the longer."""
    sensor = load_sensor("biorob2018", ["target.width=0.006", "target.length=0.01"])
    assert levers(sensor).tolist() == [1.0, 1.0, 0.003, 1.0, 0.005, 0.005]
    assert levers(sensor.model_copy(update={"target": None})).tolist() == [1.0, 1.0, 0.0, 1.0, 0.0, 0.0]
