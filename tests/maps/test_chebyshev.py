"""Chebyshev polynomials and their products, beside those of numpy."""

import numpy as np
import pytest
from numpy.polynomial.chebyshev import chebder, chebval, chebval2d

from sits_mech.maps.chebyshev import chebyshev, design_matrix, terms


def test_values_and_slopes() -> None:
    """Of each degree, by the recurrence."""
    x = np.linspace(-1.0, 1.0, 7)
    values, slopes = chebyshev(x, 5)
    for degree, (value, slope) in enumerate(zip(values, slopes, strict=True)):
        alone = np.eye(6)[degree]
        assert value == pytest.approx(chebval(x, alone), abs=1e-14)
        assert slope == pytest.approx(chebval(x, chebder(alone)), abs=1e-13)


def test_products() -> None:
    """All of a tensor product, of which a simplex has those of a total degree."""
    powers, x = terms([2, 3], False), np.random.default_rng(0).uniform(-1.0, 1.0, (9, 2))
    assert len(powers) == 12 and len(terms([3, 3], True)) == 10
    each = [chebval2d(*x.T, np.outer(np.eye(4)[a], np.eye(4)[b])) for a, b in powers]
    assert design_matrix(x, powers) == pytest.approx(np.transpose(each), abs=1e-14)
