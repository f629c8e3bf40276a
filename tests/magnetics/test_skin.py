"""Skin effect: the depth by hand, the round wire and the foil in both limits."""

import numpy as np
import pytest
from common.track_losses import foil_resistance_ratio, round_wire_impedance
from scipy.constants import mu_0

from sits_mech.magnetics.modes import skin_depth

COPPER, RADIUS = 5.8e7, 1e-3


def test_depth_by_hand() -> None:
    """Copper at 5 MHz: 29.6 um; four times the frequency or the permeability halves it."""
    assert skin_depth(5e6, COPPER) == pytest.approx(29.55e-6, rel=1e-3)
    assert skin_depth(2e7, COPPER) == skin_depth(5e6, COPPER, 4.0) == pytest.approx(skin_depth(5e6, COPPER) / 2)


def test_round_wire_in_both_limits() -> None:
    """Slow: direct current and mu_0 / (8 pi). Fast: a skin as deep as delta, its curvature corrected to first order."""
    slow = round_wire_impedance(RADIUS, 1.0, COPPER)
    assert slow.real == pytest.approx(1.0 / (COPPER * np.pi * RADIUS**2), rel=1e-6)
    assert slow.imag == pytest.approx(2.0 * np.pi * mu_0 / (8.0 * np.pi), rel=1e-6)
    fast, depth = round_wire_impedance(RADIUS, 1e9, COPPER), skin_depth(1e9, COPPER)
    expected = (1.0 / (2.0 * np.pi * RADIUS * COPPER)) * (1.0 / depth + 1.0 / (2.0 * RADIUS))
    assert fast.real == pytest.approx(expected, rel=(depth / RADIUS) ** 2)


def test_foil_in_both_limits() -> None:
    """Thin: as direct current, but for 4/45 (t / delta)^4. Thick: t / delta, its two faces do not see each other."""
    depth = skin_depth(5e6, COPPER)
    assert foil_resistance_ratio(0.1 * depth, 5e6, COPPER) - 1.0 == pytest.approx(4.0 / 45.0 * 1e-4, rel=1e-3)
    assert foil_resistance_ratio(12.0 * depth, 5e6, COPPER) == pytest.approx(12.0, rel=1e-9)
