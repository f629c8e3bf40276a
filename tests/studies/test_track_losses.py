"""Track losses against Bessel's wire, Dowell's foil, the direct-current limit, invariants."""

import numpy as np
import pytest
from common.track_losses import (
    coil_losses,
    filament_impedance,
    foil_resistance_ratio,
    round_wire_impedance,
    turn_impedance,
)
from scipy.constants import mu_0

from sits_mech.geometry.windings import Sections, coil_sections
from sits_mech.magnetics.coils.loops import ring_inductance
from sits_mech.magnetics.coils.resistance import track_resistance
from sits_mech.scene.sensor import Coil

MM = 1e-3
COPPER = 5.8e7


def coil(turns: int = 12, layers: int = 2) -> Coil:
    return Coil(
        name="C", centre=(0.0, 0.0), layers=layers, turns=turns, inner_diameter=2.2 * MM, track_width=0.1 * MM,
        track_gap=0.1 * MM, track_thickness=35e-6, layer_pitch=85e-6,
    )


def staircase_wire(radius: float, loop: float, n: int) -> Sections:
    """A round wire bent to a large loop, as equal square filaments of its total area."""
    centres = (np.arange(n) + 0.5) / n * 2 - 1
    x, z = np.meshgrid(centres, centres)
    inside = x**2 + z**2 < 1
    count = int(inside.sum())
    side = np.sqrt(np.pi / count)
    scale = side * n / 2
    sides = np.full(count, side * radius)
    return Sections(loop + scale * radius * x[inside], scale * radius * z[inside], sides, sides)


@pytest.mark.parametrize("frequency", [1e5, 1e6])
def test_filaments_converge_to_the_bessel_wire(frequency):
    radius, loop = 0.1 * MM, 0.1
    exact = round_wire_impedance(radius, frequency, COPPER)
    errors = []
    for n in (10, 20):
        wire = staircase_wire(radius, loop, n)
        Z = filament_impedance(wire, np.zeros(wire.radius.size, dtype=int), frequency, COPPER)[0, 0]
        errors.append(abs(Z.real / (2 * np.pi * loop) / exact.real - 1))
    external = mu_0 * (np.log(8 * loop / radius) - 2) / (2 * np.pi)
    internal = Z.imag / (2 * np.pi * frequency) / (2 * np.pi * loop) - external
    assert errors[0] < 3e-3 and errors[1] < errors[0] / 3
    assert internal == pytest.approx(exact.imag / (2 * np.pi * frequency), rel=2e-2)


def test_bessel_wire_limits():
    a = 0.1 * MM
    dc = 1 / (COPPER * np.pi * a**2)
    low = round_wire_impedance(a, 1.0, COPPER)
    assert low.real == pytest.approx(dc, rel=1e-9)
    assert low.imag / (2 * np.pi) == pytest.approx(mu_0 / (8 * np.pi), rel=1e-6, abs=0)
    f = 1e12
    delta = 1 / np.sqrt(np.pi * f * mu_0 * COPPER)
    assert round_wire_impedance(a, f, COPPER).real == pytest.approx(1 / (2 * np.pi * a * delta * COPPER), rel=1e-3)


def test_close_strips_with_opposite_currents_tend_to_the_foil():
    # the field is between the strips but for their edges, whose share falls as gap / width
    loop, h, gap, frequency = 0.1, 20e-6, 5e-6, 3e7
    ratios = []
    for w in (1 * MM, 2 * MM):
        pair = Sections(np.full(2, loop), np.array([0.0, h + gap]), np.full(2, w), np.full(2, h))
        Z = turn_impedance(pair, frequency, COPPER, cells=(14, 12))
        there_and_back = np.array([1.0, -1.0])
        dc = 2 * 2 * np.pi * loop / (COPPER * w * h)
        ratios.append(float((there_and_back @ Z @ there_and_back).real / dc))
    exact = foil_resistance_ratio(h, frequency, COPPER)
    assert abs(ratios[1] - exact) < abs(ratios[0] - exact)
    assert ratios[1] == pytest.approx(exact, rel=3e-2)


def test_direct_current_limit():
    # 2 layers of turns from 1.1 + 0.2 i to 1.2 + 0.2 i mm, one voltage around each: J falls as 1 / r
    squares = 2 * sum(2 * np.pi / np.log((1.2 + 0.2 * i) / (1.1 + 0.2 * i)) for i in range(12))
    expected = squares / (COPPER * 35e-6)
    assert track_resistance(coil()) == pytest.approx(expected, rel=1e-12)
    low = coil_losses(coil(), 1.0)
    assert low.R == pytest.approx(expected, rel=1e-9)
    assert low.L == pytest.approx(ring_inductance(coil_sections(coil())).sum(), rel=1e-3)


def test_resistance_rises_and_inductance_falls_with_frequency():
    runs = [coil_losses(coil(turns=4, layers=1), f) for f in (1e4, 1e6, 1e7)]
    assert runs[0].R < runs[1].R < runs[2].R
    assert runs[0].L > runs[1].L > runs[2].L
    assert all(run.error_R < 0.02 * run.R and run.error_L < 1e-3 * run.L for run in runs)


@pytest.mark.slow
def test_error_estimate_covers_a_finer_division():
    rings, f = coil_sections(coil(turns=3, layers=1)), 5e6
    run = coil_losses(coil(turns=3, layers=1), f)
    finer = turn_impedance(rings, f, COPPER, cells=(24, 16)).sum()
    assert abs(run.R - finer.real) < run.error_R + 1e-3 * run.R
    assert abs(run.L - finer.imag / (2 * np.pi * f)) < run.error_L + 1e-5 * run.L


def test_turn_impedance_is_reciprocal_and_passive():
    Z = turn_impedance(coil_sections(coil(turns=3)), 5e6, COPPER, cells=(4, 3))
    np.testing.assert_allclose(Z, Z.T, rtol=1e-9)
    assert np.linalg.eigvalsh(Z.real).min() > 0


@pytest.mark.parametrize("frequency", [0.0, -1.0, float("nan"), float("inf")])
def test_frequency_must_be_positive(frequency):
    with pytest.raises(ValueError, match="frequency"):
        coil_losses(coil(), frequency)


def test_too_fine_a_skin_is_refused():
    with pytest.raises(ValueError, match="filaments"):
        coil_losses(coil(), 1e12)
