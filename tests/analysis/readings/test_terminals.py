"""Idle coils, leads, capacitance: linear algebra against two-coil closed forms and 3D finite elements."""

import numpy as np
import pytest

from sits_mech.analysis.readings.terminals import pulling, terminal_impedance, with_capacitance
from sits_mech.magnetics.coils.resistance import track_resistance
from sits_mech.readout.converter import tank_frequency
from sits_mech.scene.sensor import Coil, Readout

OMEGA = 2 * np.pi * 5e6
L = np.array([[2507.569757e-9, -47.4298e-9], [-47.4298e-9, 2507.569757e-9]])
R_DC = track_resistance(
    Coil(
        name="C", centre=(0.0, 0.0), layers=2, turns=12, inner_diameter=2.2e-3, track_width=0.1e-3, track_gap=0.1e-3,
        track_thickness=35e-6, layer_pitch=85e-6,
    )
)


def test_shorted_idle_coil_costs_what_finite_elements_say():
    # NGSolve 3D: a shorted idle coil without resistance costs 0.8971 nH of 2507.57 nH; with it the closed form below
    ideal = terminal_impedance(1j * OMEGA * L, [0.0, 0.0], Readout(), OMEGA)
    assert (L[0, 0] - ideal[0].imag / OMEGA) * 1e9 == pytest.approx(0.8971, rel=2e-4)
    real = terminal_impedance(1j * OMEGA * L, [R_DC, R_DC], Readout(), OMEGA)
    square = R_DC**2 + (OMEGA * L[1, 1]) ** 2
    assert L[0, 0] - real[0].imag / OMEGA == pytest.approx(L[0, 1] ** 2 * OMEGA**2 * L[1, 1] / square, rel=1e-8, abs=0)
    assert real[0].real == pytest.approx(R_DC + OMEGA**2 * L[0, 1] ** 2 * R_DC / square, rel=1e-12)


def test_open_idle_coil_costs_nothing_and_leads_add():
    readout = Readout(idle_coil="open", lead_inductance=20e-9, lead_resistance=0.1)
    Z = terminal_impedance(1j * OMEGA * L, [R_DC, 2.0], readout, OMEGA)
    np.testing.assert_allclose(Z, np.array([R_DC, 2.0]) + 0.1 + 1j * OMEGA * (L[0, 0] + 20e-9), rtol=1e-14)


def test_shorted_coils_keep_the_leading_axes_and_match_elimination():
    generator = np.random.default_rng(3)
    A = generator.normal(size=(5, 4, 4))
    Z = A @ A.transpose(0, 2, 1) * 1e-3 + 1j * (A @ A.transpose(0, 2, 1) + 4 * np.eye(4))
    seen = terminal_impedance(Z, np.full(4, 0.1), Readout(), 1.0)
    assert seen.shape == (5, 4)
    whole = Z[2] + 0.1 * np.eye(4)
    idle = [0, 2, 3]
    expected = whole[1, 1] - whole[1, idle] @ np.linalg.solve(whole[np.ix_(idle, idle)], whole[idle, 1])
    assert seen[2, 1] == pytest.approx(expected, rel=1e-12)


def test_capacitance_resonates():
    C = 330e-12
    L1 = 2.5e-6
    omega = 1 / np.sqrt(L1 * C)
    Z = with_capacitance(1.0 + 1j * omega * L1, C, omega)
    assert Z.real == pytest.approx(L1 / (C * 1.0), rel=1e-3)
    assert with_capacitance(5.0 + 1j, 0.0, omega) == 5.0 + 1j


def test_tank_frequency_is_where_the_reactance_vanishes():
    """With damping, by bisection of Im Z / (1 + j omega C Z) at constant L and R."""
    C, L1, R = 330e-12, 2.5e-6, 30.0
    found = float(tank_frequency(L1, C, R))
    low, high = 1e6, 1e7
    for _ in range(60):
        omega = np.pi * (low + high)
        inductive = with_capacitance(R + 1j * omega * L1, C, omega).imag > 0.0
        low, high = ((low + high) / 2, high) if inductive else (low, (low + high) / 2)
    assert found == pytest.approx(low, rel=1e-10)
    assert found < 1 / (2 * np.pi * np.sqrt(L1 * C))
    assert np.isnan(tank_frequency(L1, C, 200.0))


def test_live_tanks_are_coupled_resonators() -> None:
    """Equal ones split by k, whatever the losses; unlike ones shift by M^2 over their difference."""
    live, k = Readout(idle_coil="live"), abs(L[0, 1]) / L[0, 0]
    Z = terminal_impedance(1j * OMEGA * L, [2.0, 2.0], live, OMEGA)
    np.testing.assert_allclose(np.sort(Z.imag / OMEGA / L[0, 0]), [1.0 - k, 1.0 + k], rtol=1e-12)
    np.testing.assert_allclose(Z.real, 2.0, rtol=1e-12)
    apart = L + np.diag([0.0, 0.5e-6])
    two = terminal_impedance(1j * OMEGA * apart, [2.0, 3.0], live, OMEGA)
    shift = L[0, 1] ** 2 / 0.5e-6
    np.testing.assert_allclose(two.imag / OMEGA - np.diag(apart), [-shift, shift], rtol=2e-2)
    batch = terminal_impedance(np.stack([1j * OMEGA * L, 1j * OMEGA * apart]), [2.0, 3.0], live, OMEGA)
    np.testing.assert_allclose(batch[1], two, rtol=1e-12)
    (line,) = pulling(1j * OMEGA * L, ["A", "B"], OMEGA)
    assert "A and B are 0 % apart" in line and "k = 1.9 %" in line and pulling(1j * OMEGA * apart, "AB", OMEGA) == ()
