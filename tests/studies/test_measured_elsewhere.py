"""Others' numbers beside ours: rows, closed forms, sweeps over plates, the probe's curve, forces on rubber."""

from dataclasses import replace

import numpy as np
import pytest
from elsewhere.coils_alone import WINDINGS, bundle, bundles, closed_forms, spiral, wired
from elsewhere.discs import apparent, compressed, pulled, tension
from elsewhere.plates import HERTZ, sweep, swept, team
from elsewhere.pressed import FITTED, factor, pressed
from elsewhere.pressed import rows as pressed_rows
from elsewhere.rows import Row
from elsewhere.rubber import modulus
from elsewhere.steel_probe import HEIGHT, drift, fitted, frequency
from elsewhere.steel_probe import HERTZ as CURVE
from scipy.constants import mu_0

from sits_mech.magnetics.coils.loops import free_inductances, series_inductance


def test_a_row_is_within_tolerance_and_error_together() -> None:
    row = Row("case", "L", "uH", 1.0, 1.25, 0.125, "source", error=0.125)
    assert row.within and row.tabled()["within"] == "yes"
    assert not replace(row, computed=1.26).within
    assert not replace(row, computed=float("nan")).within


def test_measured_coils_by_bundles() -> None:
    """Two coils measured with a Solartron 1260A, sizes to 0.01 mm: within 1 %; finer rings change nothing."""
    rows = {row.quantity: row for row in bundles()}
    assert rows["L of coil m1"].within and rows["L of coil pp1"].within
    one, few, many = (series_inductance(bundle(WINDINGS[0], *parts)) for parts in ((1, 1), (2, 5), (5, 7)))
    assert one == pytest.approx(many, rel=1e-3) and few == pytest.approx(many, rel=1e-5)


def test_wires_of_a_winding() -> None:
    """Turn by turn, TEAM problem 15's coil A has the 225.9 mH of another's finite elements; insulation adds
    mu0 N a (ln(pitch/d) + 0.138) to uniform current, the lattice's rounding to whole turns 3e-4.
    """
    coil = WINDINGS[4]
    assert wired(coil, 0.8) == pytest.approx(0.2259, abs=2e-4)
    for one in WINDINGS[:3]:
        uniform, a = series_inductance(bundle(one, 6, 6)), (one.inner + one.outer) / 2 * 1e-3
        for share in (0.5, 0.8):
            more = mu_0 * one.turns * a * (np.log(1 / share) + 0.138)
            assert wired(one, share) == pytest.approx(uniform + more, rel=3e-4)


def test_designers_figures_of_a_square_spiral() -> None:
    """The ECAS-8 README's table: 14 turns 1.555 uH, 18 turns 1.654 uH by the modified Wheeler formula."""
    for turns, L in ((14, 1.555e-6), (18, 1.654e-6)):
        found = closed_forms("square", turns, 10e-3, 0.127e-3, 0.127e-3)
        assert found["modified Wheeler"] == pytest.approx(L, abs=6e-10)


def test_closed_forms_of_a_usual_spiral() -> None:
    """Mohan et al. state 1 to 3 %."""
    for shape in ("square", "circle"):
        L = free_inductances((spiral(shape, 6, 300e-6, 10e-6, 5e-6, 1e-6),))[0, 0]
        for value in closed_forms(shape, 6, 300e-6, 10e-6, 5e-6).values():
            assert value == pytest.approx(L, rel=0.03)


@pytest.mark.slow
def test_swept_coil_over_blocks() -> None:
    """One gap fitted at contact; the predictions for three distances and for another metal are within the scatter."""
    found = sweep(coarse=True)
    assert 1.1e-3 < found.gap < 1.6e-3  # 1.16 mm by the coil's sizes, 1.4 mm by the fit
    assert found.inductance == pytest.approx(345.85e-6, rel=5e-3)
    assert all(row.within for row in swept(found) if "steel" not in row.quantity)
    assert found.computed["P057"].shape == HERTZ.shape


def test_coil_over_a_plate_as_by_another_code() -> None:
    """Dodd and Deeds against finite elements in space: 178.63 mH and 120.67 ohm, see `coils_alone.TEAM`."""
    assert [row.published for row in team()] == [178.63, 120.67] and all(row.within for row in team())


def test_probe_over_steel() -> None:
    """A lone coil's four parameters leave 3 um of height; far away its tank is at f_0; near steel heats: f falls."""
    fit = fitted(1.0, np.array([3.174, 1.0, 5.0, 2.5, 4.0]))
    assert fit.rms < 3.0 and np.abs(fit.um).max() < 7.5
    assert frequency(fit.p, np.array([1e3]))[0] == pytest.approx(1e6 * fit.p[0], rel=1e-6)
    assert HEIGHT.size == CURVE.size and np.all(np.diff(CURVE) < 0.0)
    found = drift(fit)
    assert np.all(np.abs(found.computed - found.measured[:, 0]) < found.open) and np.all(found.computed < 0.0)
    near_far = [1e6 * (own[0] / found.hertz[0] - own[-1] / found.hertz[-1]) for own in
                (found.measured[:, 0], found.steel, found.board)]
    assert near_far[0] == pytest.approx(-80.0, abs=1.0)  # ppm/K: 83 near, 3 far
    assert 0.5 < near_far[1] / near_far[0] < 1.0 and abs(near_far[2]) < 1.0  # by the steel alone


def test_modulus_of_a_bonded_disc() -> None:
    """Gent and Lindley's 1 + 2 S^2 at S = 2 to 5 %, in units of E = 90 kPa."""
    value, error = modulus("disc", 10.0, 1.25, 0.05)
    assert value + error > 0 and value / 90e3 == pytest.approx(9.0, rel=0.05)


def test_moduli_from_readings() -> None:
    """Readings that are exactly 1.5 times the law's give 1.5; one reading of ten times the noise moves ln s by the
    prior's share: 1/(1 + (noise/deviation)^2).
    """
    law = np.array([1.0, 3.0])
    assert factor(law, 1.5 * law, 1e-3, 0.5) == pytest.approx(1.5, rel=1e-4)
    s = factor(law[:1], 1.05 * law[:1], 0.1, 0.1)
    assert np.log(s) / np.log(1.05) == pytest.approx(0.5, abs=0.03)


@pytest.mark.slow
def test_pressed_cylinder_after_two_of_its_points() -> None:
    """Ecoflex 00-30: repeated tests differ by 2.6 %; a cylinder that slides freely, adapted alike, misses by more."""
    one = pressed("ecoflex-00-30")
    found = list(pressed_rows([one]))
    adapted = [row for row in found if "after two" in row.quantity]
    assert len(found) == 2 * len(adapted) == 2 * (one.u.size - FITTED) and all(row.within for row in adapted)
    s, free = one.factors
    bonded, sliding = (np.abs(each / one.measured - 1)[FITTED:] for each in (s * one.bonded, free * one.sliding))
    assert np.all(bonded < sliding) and np.all(bonded < 0.04)
    assert 1.0 < s < 1.0 + one.spread  # the law is the softest of its sources


@pytest.mark.slow
def test_compressed_discs_by_their_shear_modulus() -> None:
    """E_c of the softest rubber from G alone within the 8 % of 2 IRHD; the table's E is E_c where S = 0."""
    one = compressed(30, 0.05)
    assert one.given == pytest.approx(one.published, rel=0.08)
    assert one.adapted[2:] == pytest.approx(one.published[2:], rel=0.05)
    assert apparent(30, np.zeros(1)) == pytest.approx(0.92, rel=1e-3)


@pytest.mark.slow
def test_pulled_disc_with_its_machine() -> None:
    """Two points give the machine's compliance, which another gives as 1/(1930 N/mm); two more are predicted to 2 %."""
    one, compliance = pulled()
    assert all(row.within == ("as given" not in row.quantity) for row in tension(one, compliance))
    assert 1e-3 / compliance == pytest.approx(1930.0, rel=0.1)
