"""Mean logarithm between rectangles: quadrature, a known mean distance, the two branches against each other."""

import numpy as np
import pytest

from sits_mech.magnetics.section.kernels import _far, _near, mean_log


def quadrature(dx, dz, first, second, n=24):
    g, w = np.polynomial.legendre.leggauss(n)
    x = (dx + g * second[0] / 2)[None, :] - (g * first[0] / 2)[:, None]
    z = (dz + g * second[1] / 2)[None, :] - (g * first[1] / 2)[:, None]
    r = np.hypot(x[:, None, :, None], z[None, :, None, :])
    return np.einsum("i,j,k,l,ijkl", w, w, w, w, np.log(r)) / 16


@pytest.mark.parametrize(("dx", "dz", "first", "second"), [
    (1.0, 0.3, (0.5, 0.1), (0.2, 0.4)), (2.5, 0.3, (1.0, 0.1), (0.9, 0.05)), (0.0, 9.0, (0.1, 1.0), (2.0, 0.01)),
])
def test_mean_log_is_the_quadruple_integral(dx, dz, first, second):
    assert float(mean_log(dx, dz, first, second)) == pytest.approx(quadrature(dx, dz, first, second), rel=0, abs=1e-7)


def test_square_on_itself():
    """Geometric mean distance of a square from itself: 0.44705 of its side (Gray; Grover)."""
    assert np.exp(float(mean_log(0.0, 0.0, (2.0, 2.0), (2.0, 2.0)))) == pytest.approx(2 * 0.44705, rel=1e-5)


def test_both_branches_meet():
    args = (np.array([3.5]), np.array([0.4]), (np.array([1.0]), np.array([0.3])), (np.array([0.8]), np.array([0.02])))
    np.testing.assert_allclose(_near(*args), _far(*args), rtol=0, atol=1e-7)
