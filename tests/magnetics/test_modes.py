"""Eddy-current modes against the direct solution, with and without the net-current constraint."""

import numpy as np
import pytest

from sits_mech.magnetics.modes import eddy_modes


@pytest.mark.parametrize("isolated", [False, True])
def test_modes_solve_the_circuit_at_any_frequency(isolated):
    rng = np.random.default_rng(7)
    A, R, B = rng.normal(size=(12, 12)), rng.uniform(0.5, 2.0, 12), rng.normal(size=(3, 12))
    L = A @ A.T + 0.1 * np.eye(12)
    q = rng.uniform(1.0, 2.0, 12)
    modes = eddy_modes(L, R, B, constraint=q if isolated else None)
    for omega in (0.0, 0.3, 40.0):
        Z = np.diag(R) + 1j * omega * L
        solved = np.linalg.solve(Z, B.T)
        if isolated:
            y = np.linalg.solve(Z, q)
            solved = solved - np.outer(y, (q @ solved) / (q @ y))
        np.testing.assert_allclose(modes.admittance(omega), omega**2 * B @ solved, atol=1e-10 * max(omega**2, 1))
