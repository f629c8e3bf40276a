"""Viscosity and softening: closed forms of creep, relaxation undone by it, energy lost, paths retraced."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.special import erf

from sits_mech.quantities import Equilibrium, Pose, SolveReport, Wrench
from sits_mech.rotations import rotation_matrix, rotation_vector
from sits_mech.silicone.history import elastic_curve, left_share, loop_width, relaxed_share, retardation, softened_share
from sits_mech.silicone.material import Silicone, Softening, silicone_from

BRANCHES = [(0.2, 0.1), (0.15, 2.0), (0.1, 40.0), (0.05, 40.0)]


def silicone(*branches: tuple[float, float]) -> Silicone:
    prony = [{"weight": weight, "time": time} for weight, time in branches]
    return silicone_from({"law": "neo-hookean", "shear_modulus": 3e4, "bulk_modulus": 3e7, "prony": prony})


@dataclass(frozen=True)
class Spring:
    """Sinks by sqrt(F_z)/1000, shears by F_x/2500: stores ``F_z**1.5/3000 + F_x**2/5000``."""

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        pose = Pose(wrench.F_x / 2500, 2e-3 - np.sqrt(wrench.F_z) / 1000, 0.0)
        return Equilibrium(wrench, pose, Pose(0.0, 0.0), np.zeros(3), SolveReport("spring", 3, 1, 0.0, 0.0, 0.0))


@dataclass(frozen=True)
class Turning:
    """Turns about x by 20 M_x and then about its own z by 30 M_z, moves along y by F_y/1000: a path in space."""

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        about_x, about_z = np.array([20.0 * wrench.M_x, 0.0, 0.0]), np.array([0.0, 0.0, 30.0 * wrench.M_z])
        turn = rotation_vector(rotation_matrix(about_x) @ rotation_matrix(about_z))
        pose = Pose(0.0, 2e-3, turn[1], wrench.F_y / 1000, turn[0], turn[2])
        return Equilibrium(wrench, pose, Pose(0.0, 0.0), np.zeros(3), SolveReport("turning", 6, 1, 0.0, 0.0, 0.0))


def test_work_of_a_load_in_space_adds_up_along_the_way() -> None:
    """Force: F_y d_y and its lever; moment: ``int M . omega``, here M_x 20 M_x + int M_z cos(20 M_x s) 30 M_z ds."""
    peak, height = Wrench(F_y=0.4, M_x=0.03, M_z=0.02), 1e-3
    curve = elastic_curve(Turning(), peak, height=height, points=33)
    assert curve.found[-1].wrench == peak
    s = np.linspace(0.0, 1.0, 20001)
    tilt = 20.0 * peak.M_x * s
    lever = -height * np.sin(tilt)  # of the load's point along y: the bottom's centre moves by d_y alone
    way = peak.F_y * (peak.F_y * s / 1000 + lever) + peak.M_x * tilt
    spin = 30.0 * peak.M_z * np.cos(tilt)
    way += peak.M_z * np.concatenate([[0.0], np.cumsum(0.5 * (spin[1:] + spin[:-1]) * np.diff(s))])
    stored = way[-1] - np.sum(0.5 * (way[1:] + way[:-1]) * np.diff(s))
    assert curve.energy(1.0) == pytest.approx(stored, rel=1e-4)


def creep(rubber: Silicone, time: ArrayLike) -> np.ndarray:
    """Elastic share of a step of load, C."""
    weights, times = retardation(rubber.prony)
    return 1.0 - np.exp(-np.asarray(time)[..., None] / times) @ weights


def relaxation(rubber: Silicone, time: ArrayLike) -> np.ndarray:
    """Load of a step of place over that of slow load, G."""
    w, tau = np.reshape(rubber.prony, (-1, 2)).T
    return 1.0 + np.exp(-np.asarray(time)[..., None] / tau) @ w / (1.0 - w.sum())


def test_one_branch_creeps_as_the_standard_linear_solid() -> None:
    """J(t) = 1 - w exp(-t/lambda), lambda = tau/(1 - w): Fung, Biomechanics (1993), section 2.11."""
    time = np.linspace(0.0, 20.0, 9)
    rubber = silicone((0.3, 2.0))
    np.testing.assert_allclose(creep(rubber, time), 1.0 - 0.3 * np.exp(-0.7 * time / 2.0), rtol=1e-14)
    np.testing.assert_allclose(relaxation(rubber, time), 1.0 + 0.3 / 0.7 * np.exp(-time / 2.0), rtol=1e-14)


def test_one_branch_under_a_ramp() -> None:
    """A load that grows by one a second lags by ``w lambda (1 - exp(-t/lambda))``."""
    time, lag = np.array([0.0, 0.3, 1.0, 7.0, 50.0]), 2.0 / 0.7
    found = relaxed_share(silicone((0.3, 2.0)), time, time)
    np.testing.assert_allclose(found, time - 0.3 * lag * (1.0 - np.exp(-time / lag)), rtol=1e-13)


def test_limits_of_creep() -> None:
    """At once all springs carry, at last the slow one alone; c_j positive, as much as the branches' weights."""
    rubber = silicone(*BRANCHES)
    weights, times = retardation(rubber.prony)
    assert weights.sum() == pytest.approx(0.5, rel=1e-12) and np.all(weights > -1e-14) and np.all(times > 0.0)
    assert creep(rubber, np.array(1e-9)) == pytest.approx(0.5, rel=1e-7)
    assert creep(rubber, np.array(1e5)) == pytest.approx(1.0, rel=1e-12)
    assert np.all(np.diff(creep(rubber, np.geomspace(1e-3, 1e3, 50))) > 0.0)
    assert retardation(())[0].size == 0 and creep(silicone(), np.array(3.0)) == 1.0


def test_creep_undoes_relaxation() -> None:
    """Under the elastic share of a constant load the stress stays constant: ``int G(t - s) dC(s) = 1``."""
    rubber, time = silicone(*BRANCHES), np.linspace(0.0, 10.0, 20_001)
    C, G = creep(rubber, time), relaxation(rubber, time)[::-1]
    assert G[0] * C[0] + np.sum(0.5 * (G[1:] + G[:-1]) * np.diff(C)) == pytest.approx(1.0, abs=1e-6)


def test_samples_of_a_load_cost_no_accuracy() -> None:
    """A load that is linear between samples is integrated exactly: more samples on the way change nothing."""
    rubber = silicone(*BRANCHES)
    coarse, share = np.array([0.0, 0.0, 3.0, 3.0, 9.0]), np.array([0.0, 0.4, 1.0, 0.2, 0.2])
    fine = np.concatenate([[0.0], np.linspace(0.0, 3.0, 301), np.linspace(3.0, 9.0, 301)])
    found = relaxed_share(rubber, fine, np.concatenate([[0.0], np.linspace(0.4, 1.0, 301), np.full(301, 0.2)]))
    np.testing.assert_allclose(found[[0, 1, 301, 302, -1]], relaxed_share(rubber, coarse, share), rtol=1e-11)


def test_energy_lost_in_a_sine() -> None:
    """A linear pad under ``sin(omega t)``: the loop loses ``pi |C''|``, C the creep's transform at omega."""
    rubber, omega = silicone(*BRANCHES), 1.5
    time = np.linspace(0.0, 100 * 2 * np.pi / omega, 100 * 400 + 1)
    weights, times = retardation(rubber.prony)
    share = np.sin(omega * time)
    found = relaxed_share(rubber, time, share)[-401:]
    loss = float(np.sum(weights * omega * times / (1.0 + (omega * times) ** 2)))
    load = share[-401:]
    assert np.sum(0.5 * (load[1:] + load[:-1]) * np.diff(found)) == pytest.approx(np.pi * loss, rel=1e-3)


@pytest.mark.slow
def test_softening_loses_a_known_share_of_the_stored_energy_whatever_the_pad() -> None:
    """``int (1 - eta) dU = U_max/r int_0^1 erf(1 - x) dx`` (Ogden and Roxburgh 1999), here of a nonlinear pad."""
    curve = elastic_curve(Spring(), Wrench(F_x=2.0), points=33)
    down = np.linspace(1.0, 0.0, 2001)
    virgin = softened_share(Softening(2.5), curve.energy, np.concatenate([[1.0], down]))[1:]
    stored = np.array([curve.energy(s) for s in virgin])
    eta = 1.0 - erf(1.0 - stored / stored[0]) / 2.5
    lost = -np.sum(0.5 * ((1.0 - eta)[1:] + (1.0 - eta)[:-1]) * np.diff(stored))
    share = erf(1.0) - (1.0 - np.exp(-1.0)) / np.sqrt(np.pi)  # of U_max/r: what softening loses once
    assert lost == pytest.approx(share * stored[0] / 2.5, rel=1e-5)
    work = -np.sum(0.5 * (down[1:] + down[:-1]) * np.diff(2.0 * 2.0 / 2500 * virgin))  # load times way of the spring
    assert stored[0] - work == pytest.approx(lost, rel=1e-5)


def test_the_second_loading_follows_the_first_unloading() -> None:
    """Up to the former peak; beyond it the pad is virgin again."""
    up, more = np.linspace(0.0, 0.6, 61), np.linspace(0.6, 1.0, 41)
    found = softened_share(Softening(2.0), lambda s: s**1.7, np.concatenate([up, up[::-1], up, more]))
    first, down, second, beyond = np.split(found, [61, 122, 183])
    np.testing.assert_array_equal(first, up)
    np.testing.assert_allclose(second, down[::-1], atol=1e-12)
    np.testing.assert_array_equal(beyond, more)
    assert np.all(down[1:-1] > up[::-1][1:-1]) and down[-1] == 0.0 and np.all(np.diff(down) < 0.0)


def test_the_loop_of_a_load_that_comes_and_goes() -> None:
    """``q(t) = Q(t) - sum c_j int exp(-(t - s)/lambda_j) Q'(s) ds`` with ``Q' = +-2``, integrated leg by leg."""
    rubber, period = silicone((0.1, 0.3), (0.05, 2.0)), 0.8
    weights, times = retardation(rubber.prony)

    def lag(now: float) -> float:
        """What is missing at a time."""
        legs = [(k * period / 2, (-1.0) ** k * 2.0 / period) for k in range(4)]
        found = 0.0
        for begin, slope in legs:
            if now > begin:
                end = min(now, begin + period / 2)
                found += slope * np.sum(weights * times * (np.exp((end - now) / times) - np.exp((begin - now) / times)))
        return float(found)

    phase = np.linspace(0.0, 0.5, 101)
    width = max(abs(lag((1.0 + x) * period) - lag((2.0 - x) * period)) for x in phase)
    assert loop_width(rubber, period) == pytest.approx(width, rel=1e-9)
    assert loop_width(rubber, 1e-4) < 0.1 * width > loop_width(rubber, 1e4)  # neither sudden nor slow loads lag
    assert np.isnan(loop_width(silicone()))


def test_softening_alone_retraces_what_it_has_softened() -> None:
    """The second rise follows the first fall, so that there is no loop; with viscosity it widens one."""
    wet = silicone((0.1, 0.3))
    assert loop_width(replace(silicone(), mullins=Softening(2.0))) == pytest.approx(0.0, abs=1e-9)
    assert loop_width(replace(wet, mullins=Softening(2.0))) > loop_width(wet)


def test_the_loop_of_softening_that_fades_over_m_alone_is_the_limit_of_a_large_load() -> None:
    """Where m is left out, what beta = 0 fades over is as short as with a beta that vanishes."""
    wet = silicone((0.1, 0.3))
    each = Softening(2.0, m=1e3, beta=0.0), Softening(2.0, m=0.0, beta=1e-9)
    own, limit = (loop_width(replace(wet, mullins=one)) for one in each)
    assert own == pytest.approx(limit, rel=1e-6)


def test_what_is_left_of_a_displacement() -> None:
    """As the history of a load that was held for long and is gone says; all of the viscous share at first."""
    rubber = silicone(*BRANCHES)
    for after in (0.1, 3.0, 100.0):
        time, share = np.array([0.0, 0.0, 1e6, 1e6, 1e6 + after]), np.array([0.0, 1.0, 1.0, 0.0, 0.0])
        assert left_share(rubber, after) == pytest.approx(relaxed_share(rubber, time, share)[-1], abs=1e-9)
    assert left_share(rubber, 0.0) == pytest.approx(0.5)  # sum of the weights
    assert np.isnan(left_share(silicone(), 1.0))


@pytest.mark.parametrize(("m", "beta"), [(0.0, 1.0), (30.0, 0.0), (50.0, 0.3), (200.0, 0.1)])
def test_softening_of_a_scale_of_its_own(m: float, beta: float) -> None:
    """A spring ``Q = s``, ``U = s^2/2`` [J] of 2 cm3: what it pushes with, by hand."""
    for peak in (1e-2, 0.3):
        shares = peak * np.array([1.0, 0.8, 0.4, 0.1])
        eta = 1.0 - erf((peak**2 - shares**2) / 2.0 / (m * 2e-6 + beta * peak**2 / 2.0)) / 3.0
        found = softened_share(Softening(3.0, m, beta), lambda s: 0.5 * s**2, eta * shares, volume=2e-6)
        np.testing.assert_allclose(found, shares, rtol=1e-9)
    assert Softening(3.0).factor(0.0, 0.0) == 1.0
    np.testing.assert_allclose(Softening(3.0, m, beta).factor([2.0, 2.0], [2.0, 7.0])[0], 1.0)


def test_stored_energy_of_a_curve() -> None:
    """Work of the load on its way; the spring's is known."""
    shear = elastic_curve(Spring(), Wrench(F_x=2.0), points=5)
    assert shear.energy(1.0) == pytest.approx(2.0**2 / 5000, rel=1e-12)
    assert shear.energy(0.5) == pytest.approx(1.0**2 / 5000, rel=1e-12)
    press = elastic_curve(Spring(), Wrench(F_z=4.0), points=257)
    assert press.energy(1.0) == pytest.approx(4.0**1.5 / 3000, rel=1e-3)
    with pytest.raises(ValueError, match="points must be an odd number"):
        elastic_curve(Spring(), Wrench(F_z=4.0), points=16)
