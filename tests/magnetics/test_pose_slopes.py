"""Slopes by the pose: those that are quick beside those of fourth order, far from the coils and close to them."""

from __future__ import annotations

import numpy as np
import pytest

from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.pose_slopes import KnownImpedance, pose_slopes
from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.slopes import by_lengths
from sits_mech.quantities import POSE, Pose
from sits_mech.scene.sensor import Sensor, load_sensor

MM = 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("height", [1.9, 0.5])
def test_one_answer_a_component_for_errors(height: float) -> None:
    """By one division, to a percent of the largest of each component, and steeper towards the coils."""
    sensor = load_sensor("biorob2018")
    model, pose = sheets(sensor, 3e-2), Pose(*np.array([[0.3 * MM], [height * MM], [0.01]]))
    (found, L, R), (same, exact, exact_R) = (
        pose_slopes(sensor, model, pose, 5e6, POSE[:3], quick=quick) for quick in (True, False)
    )
    np.testing.assert_allclose(found.L, same.L, rtol=1e-12)
    assert np.all(np.abs(L - exact) < 1e-2 * np.abs(exact).max(axis=(0, 1, 2)))
    assert np.all(np.abs(R - exact_R) < 3e-2 * np.abs(exact_R).max(axis=(0, 1, 2)))
    assert np.all(np.abs(L[0, [0, 1], [0, 1], 1]) > 0.99 * np.abs(exact[0, [0, 1], [0, 1], 1]))


def test_known_slopes_are_not_solved_for() -> None:
    """Of two components the known ones come back, wrong as they may be; of the third those that are evaluated alone."""
    sensor = load_sensor("biorob2018")
    model, pose = planar_bars(sensor, 1e-2), Pose(*np.array([[0.3 * MM], [1.5 * MM], [0.01]]))
    found, L, R = pose_slopes(sensor, model, pose, 5e6, POSE[:3], quick=True)
    known = KnownImpedance(found, {name: (2.0 * L[..., k], R[..., k]) for k, name in enumerate(POSE[:2])})
    same, both, other = pose_slopes(sensor, model, pose, 5e6, POSE[:3], quick=True, known=known)
    assert same is found
    np.testing.assert_allclose(both, L * [2.0, 2.0, 1.0], rtol=1e-12)
    np.testing.assert_allclose(other, R, rtol=1e-12)


def beside_a_plate(x: float) -> Sensor:
    """A plate whose middle is at x [mm], its rim 1.6 mm from the target's where x = 9.6."""
    plate = 'name="S", material="copper", shape="rectangle", width="8 mm", length="10 mm", thickness="0.3 mm"'
    return load_sensor("biorob2018", [f'conductors=[{{{plate}, centre=["{x} mm", "0 mm", "2.3 mm"]}}]'])


@pytest.mark.slow
def test_slopes_beside_a_plate_hold_no_change_of_preparations() -> None:
    """Two preparations share the answer at this gap: long steps of a finer model, and the coils' sum, a tenth of each.

    By d_h the sum was half as steep, by the plate's place that of the coil near it 4 % less.
    """
    sensor, pose, h = beside_a_plate(9.6), Pose(*np.array([[0.0], [2.0 * MM]])), 0.05 * MM
    model, fine = sheets(sensor, 1e-1), sheets(sensor, 1e-2).prepared_at(pose)
    _, L, _ = pose_slopes(sensor, model, pose, 5e6, ("d_h",))
    moved = fine.impedance(Pose(np.array([h, -h]), np.full(2, 2.0 * MM)), 5e6).L
    own, by_hand = (np.diagonal(each) for each in (L[0, ..., 0], (moved[0] - moved[1]) / (2.0 * h)))
    np.testing.assert_allclose([*own, own.sum()], [*by_hand, by_hand.sum()], rtol=2e-2)
    by_place, *_ = by_lengths(sensor, model, pose.components, 5e6, ("conductors.S.centre.0",))
    far, near = (fine.varied(beside_a_plate(x)).impedance(pose, 5e6).L[0, 1, 1] for x in (9.8, 9.4))
    assert by_place[0, 1, 1, 0] == pytest.approx((far - near) / (0.4 * MM), rel=2e-2)
