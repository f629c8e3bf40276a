"""Slopes by the pose: those that are quick beside those of fourth order, far from the coils and close to them."""

from __future__ import annotations

import numpy as np
import pytest

from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.pose_slopes import KnownImpedance, pose_slopes
from sits_mech.magnetics.sheets import sheets
from sits_mech.quantities import POSE, Pose
from sits_mech.scene.sensor import load_sensor

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
