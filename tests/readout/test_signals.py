"""Signals by hand, continuous in the places of the coils, and what is refused."""

import numpy as np
import pytest

from sits_mech.readout.signals import changes, combine, shown_signals, signals, weights_of

RADIUS = 3.5e-3


def corners(moved: float = 0.0) -> np.ndarray:
    """Return four coils at the corners of a square, the first moved along x [m]."""
    return np.array([[-4e-3 + moved, -4e-3], [4e-3, -4e-3], [4e-3, 4e-3], [-4e-3, 4e-3]])


def test_a_pair_by_hand() -> None:
    """Sum and difference; percentages of the mean L0 (definitions of the published paper, equations 3 and 4)."""
    weights = weights_of([[-4e-3, 0.0], [4e-3, 0.0]], RADIUS)
    L, L0 = np.array([[2.0, 1.5], [1.5, 2.0]]), np.array([2.0, 3.0])
    shown = signals(L, L0, weights, [0.05, 0.05, 0.0, 0.1, 0.05])
    np.testing.assert_allclose(shown.L_v, [3.5, 3.5], rtol=1e-15)
    np.testing.assert_allclose(shown.L_h, [0.5, -0.5], rtol=1e-15)
    np.testing.assert_allclose(shown.L_v_percent, [140.0, 140.0], rtol=1e-15)
    np.testing.assert_allclose(shown.L_h_percent, [20.0, -20.0], rtol=1e-15)
    np.testing.assert_allclose(shown.error_L_v_percent, [4.0, 4.0])
    np.testing.assert_allclose(shown.error_L_h_percent, [2.0, 2.0])
    np.testing.assert_allclose(shown.dL_v, [-30.0, -30.0], rtol=1e-14)  # (3.5 - 5) / 5
    np.testing.assert_allclose(shown.dL_x, [60.0, 20.0], rtol=1e-14)  # L_h less that of free space, -1 over 2.5
    np.testing.assert_array_equal(shown.dL_y, 0.0)
    np.testing.assert_allclose(shown.error_dL_v, [2.0, 2.0])


def test_first_moments_of_four_coils_by_hand() -> None:
    """Left minus right and near minus far over the mean L0; equal changes move the mean alone; no pair's signals."""
    weights, L0 = weights_of(corners(), RADIUS), np.full(4, 2.0)
    shown = signals(L0 - [[0.1] * 4, [0.2, 0.1, 0.1, 0.2], [0.2, 0.2, 0.1, 0.1]], L0, weights)
    np.testing.assert_allclose(shown.dL_v, [-5.0, -7.5, -7.5], rtol=1e-13)
    np.testing.assert_allclose(shown.dL_x, [0.0, -10.0, 0.0], atol=1e-13)
    np.testing.assert_allclose(shown.dL_y, [0.0, 0.0, -10.0], atol=1e-13)
    assert shown.L_v is None and not {"L_v", "L_h_percent"} & set(shown.known)
    assert shown_signals(shown.known) == ("dL_v", "dL_x", "dL_y")
    assert shown_signals({"L_v_percent": 1.0, "L_h_percent": 0.0, "dL_v": 0.0}) == ("L_v_percent", "L_h_percent")


@pytest.mark.parametrize(
    "centres",
    [corners(), corners()[:1], corners()[[0, 3]], corners()[:2], np.array([[0.0, -4e-3], [0.0, 4e-3], [7e-3, 0.0]])],
)
@pytest.mark.parametrize("axis", [0, 1])
def test_a_coil_moved_by_a_nanometre_changes_no_signal(centres: np.ndarray, axis: int) -> None:
    """Weights go with the places, by at most a millionth a nanometre; coils that share a place along x have no dL_x."""
    aside = centres.copy()
    aside[0, axis] += 1e-9
    L0 = np.linspace(2.0, 2.2, len(centres))
    L = L0 * np.linspace(0.8, 0.9, len(centres))
    here, there = (signals(L, L0, weights_of(each, RADIUS)) for each in (centres, aside))
    size = abs(here.dL_v)
    for name in ("dL_v", "dL_x", "dL_y"):
        assert abs(getattr(here, name) - getattr(there, name)) < 1e-6 * size
    if len(set(centres[:, axis])) == 1:
        assert weights_of(centres, RADIUS)[1 + axis] == pytest.approx(0.0, abs=0)


def test_one_coil_has_a_sum_alone() -> None:
    """A coil in the middle does not answer shear, wherever rounding puts it."""
    for place in (0.0, 2.4e-19):
        found = combine(np.array([3.0]), weights_of([[place, 0.0]], RADIUS))
        np.testing.assert_array_equal(found, [3.0, 0.0, 0.0, 3.0, 0.0])


def test_what_symmetry_cancels_does_not_move() -> None:
    """Rounding that no error covers is no signal; a small one beyond its errors is."""
    values = np.array([0.0, 1e-13, -2e-13])
    assert not changes(values, 0.0 * values) and not changes(1e8 * values, np.full(3, 1e-4))
    assert changes(1e8 * values, 0.0 * values)


def test_what_does_not_fit_is_refused() -> None:
    """Counts that differ; a free-space inductance that is not positive."""
    weights = weights_of([[-1.0, 0.0], [1.0, 0.0]], 0.1)
    for L, L0 in ((2, 3), (3, 2), (3, 3)):
        with pytest.raises(ValueError, match=f"one number of coils; got {L}, {L0} and 2"):
            signals(np.ones(L), np.ones(L0), weights)
    with pytest.raises(ValueError, match="L0 must be positive"):
        signals(np.ones(2), np.array([1.0, 0.0]), weights)
