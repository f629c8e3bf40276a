"""Products of Chebyshev polynomials of many variables, prod_i T_{k_i}(x_i): which there are, and their values."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

from sits_mech.quantities import Array


def terms(degrees: Sequence[int], simplex: bool) -> NDArray[np.int_]:
    """Return the degrees of every term, shape (k, d)."""
    found = np.array(list(product(*(range(degree + 1) for degree in degrees))), dtype=int)
    return found[(found / np.maximum(degrees, 1)).sum(axis=1) <= 1.0 + 1e-9] if simplex else found


def design_matrix(x: Array, powers: NDArray[np.int_]) -> Array:
    """Return every term at every point, shape (m, k)."""
    tables = [chebyshev(x[:, i], int(powers[:, i].max()))[0] for i in range(x.shape[1])]
    return np.asarray(np.prod([values[powers[:, i]].T for i, values in enumerate(tables)], axis=0))


def chebyshev(x: Array, degree: int) -> tuple[Array, Array]:
    """Return T_0..T_degree and their derivatives at x, shape (degree + 1, m) each."""
    values, slopes = np.ones((degree + 1, len(x))), np.zeros((degree + 1, len(x)))
    if degree > 0:
        values[1], slopes[1] = x, 1.0
    for k in range(2, degree + 1):
        values[k] = 2.0 * x * values[k - 1] - values[k - 2]
        slopes[k] = 2.0 * values[k - 1] + 2.0 * x * slopes[k - 1] - slopes[k - 2]
    return values, slopes
