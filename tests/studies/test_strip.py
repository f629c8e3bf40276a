"""The exact planar answers against independent numbers and against their own limits."""

import numpy as np
import pytest
from common.strip import pair_over_half_space, strip_reaction

from sits_mech.quantities import Pose


@pytest.mark.parametrize(
    ("frequency", "dL", "dR"), [(5e3, -1.1488152e-07, 0.001015553), (5e6, -1.6194157e-07, 0.050466572)]
)
def test_pair_over_half_space(frequency, dL, dR):
    """Values by two independent quadratures (spacing 4.5 mm, height 2 mm, 5.96e7 S/m)."""
    found = pair_over_half_space(0.0045, 0.002, 5.96e7, frequency)
    np.testing.assert_allclose(found, (dL, dR), rtol=1e-6)


def test_wide_strip_is_a_perfect_plane():
    """Images: Delta L = -(mu0 / 2 pi) ln(1 + (s / 2h)^2) of a pair; here -1.6357013e-07 H/m."""
    places = np.array([-0.00225 - 0.002j, 0.00225 - 0.002j])
    change = np.array([1, -1]) @ strip_reaction(places, places, Pose(0.0, 0.0, 0.0), 20.0) @ np.array([1, -1])
    assert change == pytest.approx(-1.6357013e-07, rel=1e-6, abs=0)


def test_strip_reaction_is_reciprocal_and_turns_with_the_scene():
    places = np.array([0.001 - 0.003j, -0.004 - 0.002j, 0.002 - 0.001j])
    pose = Pose(0.0005, 0.001, 0.2)
    change = strip_reaction(places, places, pose, 0.008)
    np.testing.assert_allclose(change, change.T, rtol=1e-12)
    turned = strip_reaction((places - (0.0005 + 0.001j)) * np.exp(0.2j), places * 0 + 0.0, Pose(0.0, 0.0, 0.0), 0.008)
    again = strip_reaction(places, np.full(3, 0.0005 + 0.001j), pose, 0.008)
    np.testing.assert_allclose(turned, again, rtol=1e-12)
