"""What two and four coils resolve, by slopes made by hand."""

import numpy as np
import pytest

from sits_mech.readout.observability import observability

FIVE = ("F_x", "F_z", "M", "F_y", "M_x")
FULL = [1.0, 4.0, 0.01, 1.0, 0.01]


def cross() -> np.ndarray:
    """Four coils, left, right, front, back: sum by F_z, differences by F_x with M_y, and by F_y with M_x."""
    a, b, c = 2e-8, -3e-9, 5e-7
    return np.array([[a, b, c, 0, 0], [-a, b, -c, 0, 0], [0, b, 0, a, c], [0, b, 0, -a, -c]])


def test_two_coils_resolve_shear_and_normal() -> None:
    """By hand: resolution noise / (sqrt(2) slope); the rest is unseen and named."""
    found = observability(("F_x", "F_z", "F_y"), cross()[:2, [0, 1, 3]], [1e-12, 1e-12], [1.0, 4.0, 1.0])
    assert found.resolved == ("F_x", "F_z") and found.unseen == ("F_y",)
    np.testing.assert_allclose(found.resolution[:2], 1e-12 / np.sqrt(2.0) / np.array([2e-8, 3e-9]), rtol=1e-9)
    assert np.isinf(found.resolution[2]) and found.signal[2] == 0.0
    np.testing.assert_allclose(found.alone, np.sqrt(2.0) * np.array([2e-8, 4 * 3e-9, 0.0]) / 1e-12, rtol=1e-9)


def test_four_coils_resolve_three_forces_but_no_moments() -> None:
    """Shear and its moment move the same two coils: without the moments all three forces, with them only F_z."""
    forces = observability(("F_x", "F_z", "F_y"), cross()[:, [0, 1, 3]], [1e-12] * 4, [1.0, 4.0, 1.0])
    assert forces.resolved == ("F_x", "F_z", "F_y") and forces.unseen == ()
    all_five = observability(FIVE, cross(), [1e-12] * 4, FULL)
    assert all_five.resolved == ("F_z",) and len(all_five.unseen) == 2
    # a F_x + c M = 0
    assert sorted(all_five.unseen) == ["(F_x = -0.25 N, M = 0.01 N m)", "(F_y = -0.25 N, M_x = 0.01 N m)"]


def test_a_direction_below_the_noise_is_unseen() -> None:
    """The same slopes under a thousand times the noise."""
    slopes, full = cross()[:2, :2], [1.0, 4.0]
    assert observability(("F_x", "F_z"), slopes, [1.1e-8 * 2] * 2, full).resolved == ("F_x",)
    with pytest.raises(ValueError, match=r"slopes: must be of shape \(2, 2\); got \(2, 3\)"):
        observability(("F_x", "F_z"), cross()[:2, :3], [1.0, 1.0], full)
    with pytest.raises(ValueError, match="must be positive"):
        observability(("F_x", "F_z"), slopes, [1.0, 0.0], full)
