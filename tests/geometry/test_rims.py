"""Rims moved inwards, and the narrowest metal between them."""

import numpy as np
import pytest

from sits_mech.geometry.rims import narrowest, offset

SQUARE = np.array([[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]])


def test_mitres_of_a_square_and_the_metal_beside_its_hole() -> None:
    np.testing.assert_allclose(offset(SQUARE, 0.5), SQUARE * 2.5 / 3.0, rtol=1e-12)
    assert narrowest([SQUARE]) == pytest.approx(3.0, rel=1e-12)  # what mitres leave: half of the width
    assert narrowest([SQUARE, SQUARE[::-1] * 2.0 / 3.0]) == pytest.approx(1.0, rel=1e-12)
