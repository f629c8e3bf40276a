"""Ogden and Roxburgh's constants of made cyclic tests: found exactly, or told as not identified."""

from dataclasses import replace

import pytest

from sits_mech.analysis.material.fitted import fit_law
from sits_mech.analysis.material.softening import fit_softening, virgin_curve

PEAKS = (0.3, 0.6, 1.0)


@pytest.mark.parametrize(("r", "m", "beta"), [(2.5, 800.0, 0.2), (3.0, 0.0, 1.0), (2.0, 2000.0, 0.0), (1.3, 50.0, 0.1)])
@pytest.mark.parametrize("viscous", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_constants_are_found(rubber, prony, measured, cycles, r, m, beta, viscous):
    """Of a specimen 1.2 times as stiff; with the branches in the law, what relaxes is not counted as softened."""
    silicone = rubber(mullins={"r": r, "m": m, "beta": beta}, prony=prony if viscous else [])
    found = fit_softening(measured(silicone, *cycles(PEAKS), factor=1.2), silicone)
    assert found.mullins is not None and found.peaks == 3 and found.factor == pytest.approx(1.2, rel=1e-6)
    exact = {"r": r, "m": m, "beta": beta}
    assert vars(found.mullins) == pytest.approx(exact, rel=1e-5, abs=1e-2 if m == 0.0 else 1e-5)


def test_noise_stays_within_the_intervals(rubber, measured, cycles):
    """A hundredth of the peak stress: constants within twice their half-widths."""
    silicone = rubber(mullins={"r": 2.5, "m": 800.0, "beta": 0.2})
    found = fit_softening(measured(silicone, *cycles(PEAKS), noise=400.0), silicone)
    assert found.mullins is not None and found.notes == ()
    for name, value in vars(silicone.mullins).items():
        assert abs(getattr(found.mullins, name) - value) < 2.0 * found.confidence[name] < value


def test_one_peak_does_not_show_m(rubber, measured, cycles):
    """m + beta W_max alone is seen: with m = 0 it comes out, and the note says so."""
    silicone = rubber(mullins={"r": 2.5, "m": 800.0, "beta": 0.2})
    found = fit_softening(measured(silicone, *cycles((1.0,))), silicone)
    assert found.peaks == 1 and "m is not identified: one peak" in found.notes[0] and found.confidence["m"] is None
    assert found.mullins is not None and found.mullins.m == 0.0
    W = 1.5e4 * 2.0 - 300.0 * 4.0 + 40.0 * 8.0  # I1 - 3 = 2 at a stretch of 2
    assert found.mullins.beta == pytest.approx(0.2 + 800.0 / W, rel=1e-6)
    assert found.mullins.r == pytest.approx(2.5, rel=1e-6)


def test_m_that_the_data_do_not_need_is_not_made_up(rubber, measured, cycles):
    silicone = rubber(mullins={"r": 3.0})
    found = fit_softening(measured(silicone, *cycles(PEAKS), noise=200.0), silicone)
    assert found.mullins is not None and found.mullins.m == 0.0 and "m is not identified" in found.notes[0]


def test_an_elastic_specimen_has_no_softening(rubber, measured, cycles):
    found = fit_softening(measured(rubber(), *cycles(PEAKS), noise=100.0), rubber())
    assert found.mullins is None and "no softening" in found.notes[0] and set(found.confidence.values()) == {None}


def test_the_envelope_is_the_primary_curve(rubber, measured, cycles):
    """Of a softening specimen without viscosity the points beyond all strains before are the law's."""
    silicone = rubber(mullins={"r": 2.0, "m": 300.0, "beta": 0.1})
    record = measured(silicone, *cycles(PEAKS, count=200))
    fit = fit_law(virgin_curve(record), "yeoh")
    assert [fit.constants[name] for name in ("c10", "c20", "c30")] == pytest.approx([1.5e4, -300.0, 40.0], rel=1e-6)
    with pytest.raises(ValueError, match="must have 5 points of tension"):
        virgin_curve(replace(record, strain=-0.5 * record.strain))


def test_what_is_no_cyclic_test_is_refused(rubber, measured, cycles):
    record = measured(rubber(), *cycles(PEAKS))
    with pytest.raises(ValueError, match="must be let go after a peak; its strain rises to 0.285"):
        rise = {key: getattr(record, key)[:28] for key in ("time", "strain", "stress")}
        fit_softening(replace(record, **rise), rubber())
    with pytest.raises(ValueError, match="stress must have the sign of the strain"):
        fit_softening(replace(record, stress=-record.stress), rubber())
