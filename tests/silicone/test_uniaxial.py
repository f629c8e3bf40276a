"""A bar pulled and let go: closed forms of steps and ramps, an integral by quadrature, limits, order of the steps."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import erf

from sits_mech.analysis.material.uniaxial import subdivided, uniaxial_stress
from sits_mech.silicone.homogeneous import engineering_stress
from sits_mech.silicone.material import Softening

PRONY = ((0.2, 0.5), (0.1, 6.0))


def law(silicone, strain):
    return engineering_stress(silicone.law, silicone.constants, np.asarray(strain))


def test_a_step_that_is_held_relaxes_as_the_series(silicone):
    """P = P_e G(t): of one stretch, the convolution is the series; from the first sample on, or from a sudden one."""
    wet, time = replace(silicone, prony=PRONY), np.array([0.0, 0.0, 0.3, 4.0, 60.0])
    G = 1.0 + (0.2 * np.exp(-time[1:] / 0.5) + 0.1 * np.exp(-time[1:] / 6.0)) / 0.7
    for level in (0.4, -0.2):
        held = uniaxial_stress(wet, time, np.array([0.0, *[level] * 4]), step=1.0)[1:]
        assert held == pytest.approx(law(silicone, [level])[0] * G, rel=1e-12)
        assert uniaxial_stress(wet, time[1:], np.full(4, level)) == pytest.approx(held, rel=1e-12)


def test_sudden_and_slow_paths_are_elastic(silicone):
    """1/(1 - sum w) times the law in no time, the law itself in a very long one."""
    wet, strain = replace(silicone, prony=PRONY), np.array([0.0, 0.3, -0.1, 0.5])
    for duration, factor in ((1e-8, 1.0 / 0.7), (1e8, 1.0)):
        found = uniaxial_stress(wet, duration * np.arange(4.0), strain)
        assert found == pytest.approx(factor * law(silicone, strain), rel=1e-5, abs=1e-3)


def test_softening_alone_is_the_published_formula(silicone):
    """Neo-Hooke, by hand: W = mu/2 (l^2 + 2/l - 3); unloading is softer, loading beyond the peak virgin again."""
    soft = replace(silicone, mullins=Softening(2.5, 500.0, 0.2))
    path = np.array([0.0, 0.4, 0.2, 0.4, 0.6, 0.3])
    found = uniaxial_stress(soft, np.arange(6.0), path) / np.where(path, law(silicone, path), 1.0)
    assert found[[1, 3, 4]] == pytest.approx(1.0) and found[2] < 1.0 and found[5] < 1.0
    if silicone.law == "neo-hookean":
        W = 1.5e4 * ((1.0 + path) ** 2 + 2.0 / (1.0 + path) - 3.0)
        for k, peak in ((2, 1), (5, 4)):
            assert found[k] == pytest.approx(1.0 - erf((W[peak] - W[k]) / (500.0 + 0.2 * W[peak])) / 2.5, rel=1e-12)


def test_the_convolution_is_the_integral_by_quadrature(silicone):
    """Up in 2 s to 50 % and back to 10 % in 1 s, softened: branches by parts, ``Q = g (S - int exp(..) S ds/tau)``."""
    one = replace(silicone, prony=PRONY, mullins=Softening(2.0, 300.0, 0.5))
    time, strain = np.array([0.0, 2.0, 3.0]), np.array([0.0, 0.5, 0.1])
    soft = replace(one, prony=())

    def S(t, k):
        e = np.array([0.0, *[0.5][: t > 2.0], np.interp(t, time, strain)])  # the peak passed, then the point
        P = uniaxial_stress(soft, np.arange(float(len(e))), e, step=9.0)[-1]
        return P * (2.0 / 3.0 / (1.0 + e[-1]), -((1.0 + e[-1]) ** 2) / 3.0)[k]

    def Q(end, tau, k):
        legs = [(a, b) for a, b in ((0.0, min(end, 2.0)), (2.0, end)) if b > a]
        kept = [quad(lambda s: np.exp(-(end - s) / tau) * S(s, k) / tau, a, b, epsrel=1e-9)[0] for a, b in legs]
        return S(end, k) - sum(kept)

    for end in (1.3, 2.6):
        stretch = 1.0 + np.interp(end, time, strain)
        total = S(end, 0) * 1.5 * stretch
        for w, tau in PRONY:
            total += w / 0.7 * (stretch * Q(end, tau, 0) - Q(end, tau, 1) / stretch**2)
        path = np.unique(np.r_[np.clip(time, 0.0, end), end])
        found = uniaxial_stress(one, path, np.interp(path, time, strain), step=1e-3)[-1]
        assert found == pytest.approx(total, rel=1e-5)


def test_long_steps_are_divided_and_cost_the_second_order(silicone):
    """The error of S taken as linear falls by four when its steps are halved: pulled and let go, as one may vanish."""
    wet, time = replace(silicone, prony=PRONY), np.array([0.0, 2.0, 3.0])
    found = [uniaxial_stress(wet, time, np.array([0.0, 0.64, 0.0]), step=h) for h in (0.02, 0.01, 0.005)]
    first, second = np.linalg.norm(np.diff(found, axis=0), axis=1)
    assert first / second == pytest.approx(4.0, rel=0.02)


def test_a_path_that_is_none_is_refused():
    with pytest.raises(ValueError, match="time: must not descend"):
        subdivided(np.array([0.0, 1.0, 0.5]), np.zeros(3))
    with pytest.raises(ValueError, match="time: must not descend"):
        subdivided(np.zeros(2), np.zeros(3))
