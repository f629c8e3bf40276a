"""Quality figures of sensors whose figures are known."""

import numpy as np
import pytest

from sits_mech.readout.calibration import Calibration, calibration_of
from sits_mech.readout.quality import quality

A = np.array([[2e-8, -3e-9], [-2e-8, -3e-9]])  # dL/d(F_x, F_z) [H/N]


def made(bend: float = 0.0) -> Calibration:
    """L = 2 uH + A F, with a bend of L_v along F_z."""
    x, z = np.meshgrid(np.linspace(-1, 1, 7), np.linspace(0, 4, 7), indexing="ij")
    F = np.stack([x, z], -1).reshape(-1, 2)
    L = 2e-6 + F @ A.T - bend * F[:, 1:] ** 2
    return calibration_of(F, L, forces=("F_x", "F_z"), coils=("C1", "C2"), free=("H", [2.1e-6, 2.1e-6]))


def test_a_linear_sensor_by_hand() -> None:
    """No crosstalk, no bend; slopes; resolution = noise / (sqrt(2) slope) by sum and difference."""
    found = quality(made(), [1e-12, 1e-12])
    np.testing.assert_allclose(found.full_scale, [[-1, 1], [0, 4]])
    np.testing.assert_allclose(found.sensitivity, A / 2.1e-6, rtol=1e-9)
    np.testing.assert_allclose(found.signal_range, (2 * 2e-8 + 4 * 3e-9) / 2.1e-6, rtol=1e-9)
    assert np.all(found.linearity < 1e-9) and np.all(found.crosstalk < 1e-9)
    expected = 1e-12 / np.sqrt(2.0) / np.array([2e-8, 3e-9])
    np.testing.assert_allclose(found.resolution, np.repeat(expected[:, None], 3, axis=1), rtol=1e-6)
    condition = (2.0 * 2e-8) / (4.0 * 3e-9)  # columns of A over full scale are at right angles
    assert found.condition == pytest.approx((condition, condition), rel=1e-6)
    assert found.valid_share == 1.0 and found.no_inverse == () and np.all(np.isnan(found.hysteresis))


def test_resolution_by_drawing() -> None:
    """The scatter of inverted noisy readings is what is reported."""
    cal = made(2e-10)
    F = np.tile([0.3, 2.0], (4000, 1))
    noisy = cal.forward(*F.T) + 1e-11 * np.random.default_rng(1).standard_normal((4000, 2))
    reported = cal.force_noise([0.3, 2.0], [1e-11, 1e-11])
    np.testing.assert_allclose(cal.inverse(noisy).forces.std(axis=0), reported, rtol=0.05)


def test_a_bend_and_its_crosstalk() -> None:
    """A parabola over 0..4 N lies an eighth of 16 b from its line; a linear readout misreads F_z, not F_x."""
    b = 2e-10
    found = quality(made(b), [1e-12, 1e-12])
    chord, least_squares = 16.0 * b / 8.0, 16.0 * b / 6.0  # best in the largest distance; by squares, at an end
    span = 4 * 3e-9 + 16 * b
    assert chord / span <= found.linearity[1] <= 1.01 * least_squares / span
    assert found.linearity[0] < 1e-9 and found.crosstalk[0, 1] < 1e-9 < found.crosstalk[1, 1]


def test_hysteresis_of_two_branches() -> None:
    """Unloading shows the inductances of 0.1 N more: 2.5 % of the full scale of F_z."""
    cal = made()
    F = np.array([[0.0, 1.0], [0.5, 2.0], [-0.5, 3.0]])
    branches = (cal.forward(*F.T), cal.forward(F[:, 0], F[:, 1] + 0.1))
    found = quality(cal, [1e-12, 1e-12], branches=branches)
    np.testing.assert_allclose(found.hysteresis, [0.0, 0.025], atol=1e-9)


def test_what_has_no_figures_is_refused() -> None:
    """Noise of another shape, or none."""
    for noise in ([1e-12], [1e-12, 0.0]):
        with pytest.raises(ValueError, match=r"noise: must be 2 positive numbers \[H\]"):
            quality(made(), noise)
