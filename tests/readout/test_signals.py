"""Signals by hand, and what is refused."""

import numpy as np
import pytest

from sits_mech.readout.signals import shear_weights, signals


def test_a_pair_by_hand() -> None:
    """Sum and difference; percentages of the mean L0 (definitions of the published paper, equations 3 and 4)."""
    shown = signals(np.array([[2.0, 1.5], [1.5, 2.0]]), np.array([2.0, 3.0]), shear_weights([-4e-3, 4e-3]), (0.1, 0.05))
    np.testing.assert_allclose(shown.L_v, [3.5, 3.5], rtol=1e-15)
    np.testing.assert_allclose(shown.L_h, [0.5, -0.5], rtol=1e-15)
    np.testing.assert_allclose(shown.L_v_percent, [140.0, 140.0], rtol=1e-15)
    np.testing.assert_allclose(shown.L_h_percent, [20.0, -20.0], rtol=1e-15)
    assert (shown.error_L_v_percent, shown.error_L_h_percent) == pytest.approx((4.0, 2.0))


def test_weights_of_other_numbers_of_coils() -> None:
    """Left minus right; a coil in the middle does not answer shear."""
    np.testing.assert_array_equal(shear_weights([0.0]), [0.0])
    np.testing.assert_array_equal(shear_weights([-1.0, 1.0, -1.0, 1.0]), [1.0, -1.0, 1.0, -1.0])
    np.testing.assert_array_equal(shear_weights([1.0, -1.0]), [1.0, -1.0])  # a pair goes by its order: L1 - L2


def test_what_does_not_fit_is_refused() -> None:
    """Counts that differ; a free-space inductance that is not positive."""
    with pytest.raises(ValueError, match="one number of coils; got 2, 3 and 2"):
        signals(np.ones(2), np.ones(3), np.ones(2))
    with pytest.raises(ValueError, match="L0 must be positive"):
        signals(np.ones(2), np.array([1.0, 0.0]), np.ones(2))
