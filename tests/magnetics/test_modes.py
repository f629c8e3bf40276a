"""Eddy-current modes against the direct solution, with and without the net-current constraint."""

import numpy as np
import pytest

from sits_mech.analysis.spectrum import spectrum
from sits_mech.magnetics.modes import Reduced, eddy_modes, factored, reaction_at, reduced
from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.space import divisions
from sits_mech.magnetics.space import modes as preparing
from sits_mech.magnetics.space import near as close
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import load_sensor


@pytest.mark.parametrize("isolated", [False, True])
def test_modes_solve_the_circuit_at_any_frequency(isolated):
    rng = np.random.default_rng(7)
    A, R, B = rng.normal(size=(12, 12)), rng.uniform(0.5, 2.0, 12), rng.normal(size=(3, 12))
    L = A @ A.T + 0.1 * np.eye(12)
    q = rng.uniform(1.0, 2.0, 12)
    modes = eddy_modes(L, R, B, constraint=q if isolated else None)
    for omega in (0.0, 0.3, 40.0):
        Z = np.diag(R) + 1j * omega * L
        found = np.linalg.solve(Z, B.T)
        if isolated:
            y = np.linalg.solve(Z, q)
            found = found - np.outer(y, (q @ found) / (q @ y))
        np.testing.assert_allclose(modes.admittance(omega), omega**2 * B @ found, atol=1e-10 * max(omega**2, 1))


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("n", [1, 2, 90])
def test_reduced_currents_answer_at_any_frequency(n, turned):
    """Time constants over six decades; of complex currents the symmetric part counts, as often as they are there."""
    rng = np.random.default_rng(3)
    weight, other = 2.0, 1j * rng.normal(size=(2, n, n)) if turned else np.zeros((2, n, n))
    Q, P = (np.linalg.qr(rng.normal(size=(n, n)) + each)[0] for each in other)
    L, R = ((X * np.geomspace(1.0, least, n)) @ X.conj().T for X, least in ((Q, 1e-6), (P, 1e-2)))
    B = rng.normal(size=(4, n)) + (1j * rng.normal(size=(4, n)) if turned else 0.0)
    found = reduced(L, R, B, weight=weight)
    for omega in (1e-3, 1.0, 1e4):
        whole = B @ np.linalg.solve(R + 1j * omega * L, B.conj().T)
        exact = omega**2 * ((whole + whole.T) / 2 * (weight if turned else 1.0))
        np.testing.assert_allclose(found.admittance(omega), exact, rtol=0.0, atol=1e-10 * np.abs(exact).max())
        if not turned:
            alone = factored(L, R, omega)
            Y = alone.reaction(alone.induced(B), omega)
            np.testing.assert_allclose(Y, exact, rtol=0.0, atol=1e-10 * np.abs(exact).max())
        part = found.reaction(found.coupling[:1], omega, found.coupling[1:])
        np.testing.assert_allclose(part, exact[:1, 1:], rtol=0.0, atol=1e-10 * np.abs(exact).max())


def test_resistances_that_are_not_positive_are_refused():
    with pytest.raises(np.linalg.LinAlgError, match="^leading minor 2 of the resistances is not positive$"):
        reduced(np.eye(3), np.diag([1.0, -1.0, 1.0]), np.eye(3))


def test_all_frequencies_take_one_reduction(monkeypatch):
    """Each class of each division is reduced once, and of a plate close to the coils where one frequency was asked.

    A pose at a known frequency solves no system; a spectrum takes no factors.
    """
    counts = {"factored": 0, "reduced": 0, "answer": 0}
    for owner, name in ((close, "factored"), (close, "reduced"), (preparing, "reduced"), (Reduced, "answer")):
        made = getattr(owner, name)

        def counted(*given, name=name, made=made, **more):
            counts[name] += 1
            return made(*given, **more)

        monkeypatch.setattr(owner, name, counted)
    sensor, pose = load_sensor("biorob2018", ['target.width="7.83 mm"']), Pose(0.0, 2e-3)
    model, classes = sheets(sensor, 1e-1), 5 * 8 + 8
    for frequency in (5e6, 4e6, 3e6):
        model.impedance(pose, frequency)
    assert counts == {"factored": 0, "reduced": classes, "answer": 3 * 5 * 8}
    model.impedance(Pose(np.array([0.0, 1e-4]), np.array([2e-3, 2.1e-3])), 5e6)
    assert counts == {"factored": 0, "reduced": classes, "answer": 3 * 5 * 8}
    sensor, pose = load_sensor("biorob2018", ['target.width="4.1 mm"', 'target.length="4 mm"']), Pose(0.0, 1e-4)
    model = sheets(sensor, 1e-1)
    spectrum(sensor, model, pose, [4e6, 5e6])
    found = model.impedance(pose, 5e6)
    near = counts["reduced"] - classes
    assert counts["factored"] == 0 and near % 40 == 0 < near
    divisions._asked.cache_clear()
    first = model.impedance(pose, 5e6)
    assert counts["factored"] == near
    np.testing.assert_allclose(found.L, first.L, rtol=1e-13)
    np.testing.assert_allclose(found.R, first.R, rtol=1e-11)


def test_beyond_the_highest_frequency_resistance_goes_like_the_skin_depth():
    """R / omega = c d + e d^2 and L = l + m d, d the skin depth: exactly gone on with, without a step."""
    c, e, m = 0.7, 0.1, 0.3

    def exact(omega):
        d = omega**-0.5
        return omega * np.array([[c * d + e * d**2 - 1j * (1.0 - m * d)]])

    for at in (1.001, 4.0, 1e4):
        found = reaction_at(exact, at, 1.0)
        np.testing.assert_allclose(found, exact(at), rtol=1e-12)
