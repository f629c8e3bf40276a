"""Limits of sequences whose order, limit and faults are known."""

from __future__ import annotations

import numpy as np
import pytest

from sits_mech.magnetics.space.rungs import extrapolated_rest

SIZES = (3.0, 4.0, 5.0)
EXACT = np.array([[-3.0, 0.4], [0.4, -2.0]])
FAULT = np.array([[1.0, -0.3], [-0.3, 0.5]])


def levels(order: float, sizes: tuple[float, ...] = SIZES) -> list[np.ndarray]:
    return [EXACT + FAULT * m**-order for m in sizes]


@pytest.mark.parametrize("order", [2.0, 3.3, 6.0])
def test_limit_of_a_power_is_exact(order: float) -> None:
    values = levels(order)
    more, error = extrapolated_rest(*np.diff(values, axis=0), SIZES, order)
    np.testing.assert_allclose(values[-1] + more, EXACT, rtol=1e-12)
    np.testing.assert_allclose(error, 0.0, atol=1e-12)


@pytest.mark.parametrize("faults", [(-0.2, 0.1, -0.05), (0.3, 0.1, 0.06), (0.1, 0.06, 0.045)])
def test_a_sequence_of_another_order_owns_to_it(faults: tuple[float, ...]) -> None:
    """Within four times the estimate."""
    values = [EXACT + FAULT * fault for fault in faults]
    more, error = extrapolated_rest(*np.diff(values, axis=0), SIZES, 2.0)
    assert (4.0 * error >= np.abs(values[-1] + more - EXACT)).all()


def test_levels_that_are_one_lack_nothing() -> None:
    more, error = extrapolated_rest(EXACT - EXACT, EXACT - EXACT, SIZES, 2.0)
    assert not more.any() and not error.any()
