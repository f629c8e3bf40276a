"""Slopes by differences: exact on polynomials, converging, and honest about a jump."""

from __future__ import annotations

import numpy as np
import pytest

from sits_mech.maps.differences import BACKWARD, CENTRAL, FIRST, FORWARD, SECOND_ORDER, WIDE, Stencil
from sits_mech.quantities import Array

FOURTH_ORDER = [CENTRAL, WIDE, FORWARD, BACKWARD]


def values(stencil: Stencil, h: float, jump: float = 0.0, at: float = 0.0) -> dict[int, Array]:
    """Of an exponential at two growths, with a jump at some place."""
    return {m: np.exp(np.array([1.0, 0.5]) * m * h) + jump * (m > at) for m in stencil.places}


@pytest.mark.parametrize("stencil", FOURTH_ORDER)
def test_exact_on_polynomials_of_degree_four(stencil: Stencil) -> None:
    found = {m: np.array([(0.1 * m) ** k for k in range(5)]) for m in stencil.places}
    np.testing.assert_allclose(stencil.slope(found, 0.1), [0.0, 1.0, 0.0, 0.0, 0.0], atol=1e-13)


@pytest.mark.parametrize(("stencil", "order"), [*((one, 4.0) for one in FOURTH_ORDER), (FIRST, 1.0)])
def test_order(stencil: Stencil, order: float) -> None:
    off = [abs(stencil.slope(values(stencil, h), h) - [1.0, 0.5]).max() for h in (0.04, 0.02)]
    assert np.log2(off[0] / off[1]) == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize("stencil", FOURTH_ORDER)
def test_the_error_holds_a_jump_anywhere(stencil: Stencil) -> None:
    h = 1e-3
    for at in np.arange(-4.5, 5.0):
        found = values(stencil, h, 1e-6, at)
        off = np.abs(stencil.slope(found, h) - [1.0, 0.5])
        assert np.all(off <= stencil.error(found, h) + 1e-10)


def test_a_jump_on_one_side_leaves_the_other() -> None:
    h = 1e-3
    assert np.all(BACKWARD.error(values(BACKWARD, h, 1e-6, 0.5), h) < 1e-8)
    assert np.all(FORWARD.error(values(FORWARD, h, 1e-6, 0.5), h) > 1e-3)


@pytest.mark.parametrize("stencil", SECOND_ORDER)
def test_three_places_are_exact_on_parabolas(stencil: Stencil) -> None:
    """On both sides and on each."""
    found = {m: np.array([(0.1 * m) ** k for k in range(3)]) for m in stencil.places}
    np.testing.assert_allclose(stencil.slope(found, 0.1), [0.0, 1.0, 0.0], atol=1e-13)
    assert [stencil.places for stencil in SECOND_ORDER] == [(-1, 0, 1), (0, 1, 2), (0, -1, -2)]
