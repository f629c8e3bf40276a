"""Eddy-current modes against the direct solution, with and without the net-current constraint."""

import numpy as np
import pytest

from sits_mech.magnetics.modes import Modes, eddy_modes, few_modes


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


@pytest.mark.parametrize("turned", [False, True])
def test_few_modes_answer_as_all(turned):
    """Time constants over six decades; promised 1e-3 of what is largest, up to the highest frequency."""
    rng = np.random.default_rng(3)
    n, weight = 240, 2.0
    Q = np.linalg.qr(rng.normal(size=(n, n)) + (1j * rng.normal(size=(n, n)) if turned else 0.0))[0]
    L, B = (Q * np.geomspace(1e-5, 10.0, n)) @ Q.conj().T, rng.normal(size=(4, n)) @ Q.conj().T
    few = few_modes(L, np.eye(n, dtype=Q.dtype), B, 2.25, weight=weight if turned else 1.0)
    assert few.tau.size < n
    for omega in (1e-3, 0.1, 1.0):
        solved = B @ np.linalg.solve(np.eye(n) + 1j * omega * L, B.conj().T)
        exact = omega**2 * ((solved + solved.T) / 2 * weight if turned else solved)
        np.testing.assert_allclose(few.admittance(omega), exact, rtol=0.0, atol=1e-3 * np.abs(exact).max())


def test_few_modes_where_single_precision_loses_the_resistances():
    """R is 1e-11 of omega L there: the sum is positive in double precision only."""
    n = 240
    rng = np.random.default_rng(5)
    Q = np.linalg.qr(rng.normal(size=(n, n)))[0]
    L, B = (Q * np.r_[np.full(n - 200, 1e11), np.full(200, 1e-9)]) @ Q.T, rng.normal(size=(2, n)) @ Q.T
    L = (L + L.T) / 2
    with pytest.raises(np.linalg.LinAlgError):
        np.linalg.cholesky((np.eye(n) + L).astype(np.float32))
    assert np.all(np.isfinite(few_modes(L, np.eye(n), B, 1.0).admittance(1.0)))


def test_beyond_the_highest_frequency_resistance_goes_like_the_skin_depth():
    """R / omega = c d + e d^2 and L = l + m d, d the skin depth: exactly gone on with, without a step."""
    c, e, m = 0.7, 0.1, 0.3

    def exact(omega):
        d = omega**-0.5
        return omega * np.array([[c * d + e * d**2 - 1j * (1.0 - m * d)]])

    class Plate(Modes):
        def reaction(self, induced, omega):
            return exact(omega) if omega <= 1.0 else super().reaction(induced, omega)

    for at in (1.001, 4.0, 1e4):
        found = Plate(np.zeros(0), np.zeros((1, 0)), highest=1.0).admittance(at)
        np.testing.assert_allclose(found, exact(at), rtol=1e-12)
