"""Prony series of made relaxation tests: found exactly, within their intervals, no more than the data hold."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.analysis.material.relaxing import fit_relaxation


def hold(last, ramp=0.5, level=0.5, count=4000):
    time = np.r_[0.0, np.linspace(0.05, 1.0, 20) * ramp, ramp + np.geomspace(0.02, last, count)]
    return time, level * np.minimum(time / ramp, 1.0)


def test_a_series_is_found_through_a_ramp_of_its_own_time(rubber, prony, measured):
    """The ramp lasts longer than the first branch: taken as a step, its weight would be far too small."""
    silicone = rubber(prony=prony)
    for level in (0.5, -0.3):
        found = fit_relaxation(measured(silicone, *hold(600.0, level=level), factor=1.3), silicone)
        assert [entry["weight"] for entry in prony] == pytest.approx([w for w, _ in found.prony], rel=1e-4)
        assert [entry["time"] for entry in prony] == pytest.approx([tau for _, tau in found.prony], rel=1e-4)
        assert found.factor == pytest.approx(1.3, rel=1e-6) and found.slow_identified and found.notes == ()
        assert found.strain == pytest.approx(level) and found.rms < 0.01


def test_a_slower_ramp_changes_nothing(rubber, prony, measured):
    """The same series from ramps of 0.1 s and 2 s."""
    silicone = rubber(prony=prony[1:])
    found = [np.array(fit_relaxation(measured(silicone, *hold(600.0, ramp)), silicone).prony) for ramp in (0.1, 2.0)]
    np.testing.assert_allclose(*found, rtol=1e-3)


def test_without_a_law_neo_hooke_stands_for_it(rubber, prony, measured):
    """It plays a part in the ramp alone: weights of slow branches hardly move."""
    silicone = rubber(prony=prony)
    found = fit_relaxation(measured(silicone, *hold(600.0)))
    assert found.factor is None
    assert [w for w, _ in found.prony[1:]] == pytest.approx([0.06, 0.1], rel=3e-3)


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_as_many_branches_as_there_are(rubber, prony, measured, count):
    """With noise of a thousandth of the stress: no branch is made of it."""
    silicone = rubber(prony=prony[3 - count :])
    found = fit_relaxation(measured(silicone, *hold(1000.0), noise=20.0), silicone)
    assert len(found.prony) == count
    assert bool(found.notes) is (count == 0)


def test_no_more_branches_than_decades(rubber, measured):
    """Ten branches in three decades come out as three at most, which follow the stress to two thousandths."""
    many = [{"weight": 0.03, "time": time} for time in np.geomspace(0.5, 300.0, 10)]
    record = measured(rubber(prony=many), *hold(300.0))
    found = fit_relaxation(record, rubber())
    assert 2 <= len(found.prony) <= round(np.log10(found.range[1] / found.range[0]))
    assert found.rms < 2e-3 * record.stress[-1]


def test_a_short_hold_says_that_slow_load_is_not_identified(rubber, prony, measured):
    found = fit_relaxation(measured(rubber(prony=prony), *hold(100.0)), rubber())
    assert not found.slow_identified and "slow load is not identified" in found.notes[0]


@pytest.mark.parametrize(("weights", "rise"), [(0, 4.0), (0, 0.1), (3, 0.3), (0, 0.0), (3, 0.0)])
def test_a_hold_in_which_stress_rises_shows_no_slow_load(rubber, prony, measured, weights, rise):
    """Fivefold, by a tenth, or late after relaxing: silicone under a held strain does not; noise is no rise."""
    silicone = rubber(prony=prony[:weights])
    record = measured(silicone, *hold(1000.0), noise=20.0)
    after = np.maximum(record.time - 0.5, 0.0) / 1000.0
    found = fit_relaxation(replace(record, stress=record.stress * (1.0 + rise * after)), silicone)
    assert found.slow_identified is (rise == 0.0)
    if rise:
        (note,) = found.notes
        assert note.startswith("slow load is not identified: the stress rises by ")
        told = float(note.split("rises by ")[1].split(" %")[0]) / 100.0
        assert 0.5 * rise < told <= rise  # from the least on, which comes late where the specimen relaxes first


@pytest.mark.slow
def test_intervals_hold_the_truth(rubber, prony, measured):
    """White noise: of 40 tests, the 95 % interval of each constant of two branches holds it in 33 or more."""
    silicone = rubber(prony=prony[1:])
    time, strain = hold(600.0, count=400)
    clean, rng = measured(silicone, time, strain), np.random.default_rng(5)
    inside = np.zeros((2, 2))
    for _ in range(40):
        found = fit_relaxation(replace(clean, stress=clean.stress + rng.normal(0.0, 30.0, len(time))), silicone)
        assert len(found.prony) == 2
        inside += np.abs(np.array(found.prony) - np.array(silicone.prony)) <= np.array(found.confidence, dtype=float)
    assert inside.min() >= 33


def test_sampling_plays_no_part(rubber, prony, measured):
    """Even samples, a thousandth of them in the first decade, give the series that logarithmic ones give."""
    silicone = rubber(prony=prony)
    time = np.arange(0.0, 600.0, 0.05)
    found = fit_relaxation(measured(silicone, time, 0.5 * np.minimum(time / 0.5, 1.0)), silicone)
    assert [w for w, _ in found.prony] == pytest.approx([0.08, 0.06, 0.1], rel=1e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t, e, s: (t, 0.0 * e, s), "must strain the specimen"),
        (lambda t, e, s: (t, np.where(t > 5.0, 0.5 * e, e), s), "must hold its strain within 5%"),
        (lambda t, e, s: (t, e, -s), "stress must have the sign of the strain"),
        (lambda t, e, s: (t[:25], e[:25], s[:25]), "must have 8 rows while the strain is held; got"),
        (lambda t, e, s: (t[:40], e[:40], s[:40]), "must be held for longer than its ramp of 0.5"),
    ],
)
def test_what_is_no_relaxation_test_is_refused(rubber, prony, measured, change, message):
    record = measured(rubber(prony=prony), *hold(100.0))
    time, strain, stress = change(record.time, record.strain, record.stress)
    with pytest.raises(ValueError, match=f"made.csv: {message}"):
        fit_relaxation(replace(record, time=time, strain=strain, stress=stress))
