"""The posterior of a built sensor: what is found again, how sure, what is doubted."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace

import numpy as np
import pytest

from sits_mech.analysis.bench.load_plan import plan_loads
from sits_mech.analysis.built.adaptation import Adaptation, adapt
from sits_mech.analysis.built.constants import constants_of
from sits_mech.analysis.built.corrected import corrected
from sits_mech.analysis.built.prior import Prior, prior_of
from sits_mech.analysis.readings.bench import loads_over, terminal_calibration
from sits_mech.analysis.readings.measured import Measured
from sits_mech.quantities import SURE, Array
from sits_mech.readout.budget import budget
from sits_mech.scene.sensor import SceneError
from tests.analysis.conftest import LOADS, OTHERWISE, bench_of, unknowns


def test_five_readings_find_the_sensor(prior: Prior) -> None:
    """Each unknown within three deviations of what it is; forces far better known than by the calibration, tared."""
    found = adapt(prior, bench_of(prior))
    true = unknowns(prior, **OTHERWISE)
    assert np.all(np.abs(found.values - true) <= 3.0 * found.deviations)
    assert {"modulus", "alpha"} <= {*found.identified} and "cell" not in found.identified
    before, after = found.force_deviations(np.array([[0.2, 1.0], [-0.2, 0.5]]))
    assert np.all(after < 0.2 * before) and found.p_value > 0.01
    assert np.abs(found.residual).max() < 0.05 * np.abs(found.before).max()


@pytest.mark.slow
def test_the_posterior_is_as_wide_as_it_errs(prior: Prior) -> None:
    """Sensors drawn from what is known: chi^2 of N numbers is N, and errors of forces are as large as said."""
    rng, chi, off, at = np.random.default_rng(3), [], [], np.array([[0.1, 0.8]])
    root = np.linalg.cholesky(prior.covariance)
    names = [each.name for each in prior.setup.parameters]
    for seed in range(12):
        true = prior.start + 0.7 * root @ rng.uniform(-1.7, 1.7, len(prior.start))
        true[names.index("lead")] = abs(true[names.index("lead")])
        true[0] = np.clip(true[0], 0.85, 1.3)  # loads of the table
        shown = prior.bench(LOADS).model(true[None])[0]
        noise = np.hypot(prior.noise, prior.model) * np.random.default_rng(seed).standard_normal(shown.shape)
        found = adapt(prior, Measured(LOADS, shown + noise, "twin"))
        chi.append(found.chi_square)
        answers, by = prior.force_slopes(found.values, at)
        wrong = np.einsum("mdn,mnp,p->md", answers, by, found.values - true)
        off.append((wrong / np.sqrt(np.einsum("mdd->md", prior.force_covariance(
            found.values, found.covariance, at))))[0])
    assert 0.3 * LOADS.size < np.mean(chi) < 1.6 * LOADS.size
    assert 0.2 < np.sqrt(np.mean(np.square(off))) < 1.6


def test_a_press_of_known_depth_needs_no_scale(prior: Prior) -> None:
    """Loads that were not measured are found from the readings and the way down; the modulus then stays unknown."""
    loads = np.array([[0.0, 0.0], [0.0, 0.7], [0.0, 1.4]])
    bench = bench_of(prior, loads, depth=True)
    blind = replace(bench, forces=np.where([[0, 0], [0, 1], [0, 1]], np.nan, loads))
    both, alone = (adapt(prior, one, depth_noise=2e-6) for one in (bench, blind))
    assert "modulus" in both.identified and both.deviations[0] < 0.5 * alone.deviations[0]
    assert np.all(np.abs(alone.values - unknowns(prior, **OTHERWISE)) <= 4.0 * alone.deviations)


def test_foreign_readings_are_doubted(prior: Prior) -> None:
    """Hysteresis of a tenth up and down; nothing is left to test where unknowns are as many as readings."""
    way = np.concatenate([LOADS, LOADS[::-1]])
    share = np.repeat([0.95, 1.05], len(LOADS))[:, None]
    shown = bench_of(prior, share * way)
    found = adapt(prior, Measured(way, shown.L, "loop"))
    assert found.p_structured < 1e-3 and found.freedom > 0
    few = adapt(prior, bench_of(prior, LOADS[:2]))
    assert few.freedom == 0 and few.p_structured == 1.0


def test_what_cannot_be_adapted_is_refused(prior: Prior) -> None:
    """Loads that the table does not reach; an unknown modulus of none."""
    with pytest.raises(SceneError, match="modulus|table"):
        adapt(prior, Measured(20.0 * LOADS, bench_of(prior).L, "far"))
    held = prior_of(prior.sensor, prior.data, ["gap"])
    with pytest.raises(SceneError, match="table: must reach beyond the measured forces"):
        adapt(held, Measured(3.0 * LOADS, bench_of(prior).L, "far"))


def test_loads_beyond_the_table_leave_what_was_known(prior: Prior) -> None:
    """They bound the modulus from below, above the one that is known: it stays known as it was, and costs its share."""
    known = prior_of(prior.sensor, prior.data, ["modulus=1+-0.3", "gap=0+-50 um"], noise=1e-10)
    loads = np.array([[0.0, 0.0], [0.0, 1.3], [0.0, 2.8], [0.2, 2.8], [-0.2, 2.8]])
    shown = known.bench(loads).model(unknowns(known, modulus=1.5)[None])[0]
    found = adapt(known, Measured(loads, shown, "stiff"))
    assert found.known.free[0].low > 1.0
    assert found.values[0] == pytest.approx(1.5, rel=0.01)
    assert found.chi_square == pytest.approx((np.log(1.5) / 0.3) ** 2, rel=0.05)


@pytest.mark.slow
def test_samples_agree_with_the_approximation(prior: Prior) -> None:
    """Nearly linear in a few unknowns that readings determine: means and widths are those of 200 samples."""
    few = prior_of(prior.sensor, prior.data, ["modulus", "gap=0+-30 um", "alpha"])
    found = adapt(few, bench_of(few, modulus=0.9, gap=2e-5, alpha=0.004))
    sizes, P = np.sqrt(np.diagonal(found.fit.covariance)), _samples(found, 200)
    assert len(P) == 200
    assert np.max(np.abs(P.mean(axis=0) - found.fit.values)[:3] / sizes[:3]) < 0.3
    assert np.max(np.abs(P.std(axis=0, ddof=1) / sizes - 1.0)[:3]) < 0.25
    assert _force_width(found, P) < 0.25
    whole = adapt(prior, bench_of(prior))
    P = _samples(whole, 50)
    assert len(P) > 25 and _force_width(whole, P) < 0.6


def _samples(found: Adaptation, count: int) -> Array:
    """Return those of `count` samples of a posterior that settle, (k, p), by randomised maximum likelihood.

    Each is the least of chi^2 with all its terms off by normal numbers (P. K. Kitanidis, Water Resour. Res. 31 (1995)
    2411): exact where readings are linear in the unknowns, and along the posterior's bends where they are not.
    """
    prior, p, free = found.prior, found.fit.values, found.known.free
    bench, noise = prior.bench(found.measured.forces, loose=True), np.hypot(prior.noise, prior.model)

    def terms(P: Array) -> Array:
        data = ((bench.model(P) - found.measured.L) / noise).reshape(len(P), -1)
        return np.concatenate([data, found.known.terms(P)], axis=1)

    at_least = terms(p[None])[0]
    assert at_least @ at_least == pytest.approx(found.chi_square)
    units = np.array([each.deviation for each in free])
    slopes = (bench.slopes(p) / noise[:, None]).reshape(-1, len(p))
    Q, R = np.linalg.qr(np.concatenate([slopes, found.known.slopes(p)]) * units)
    off = np.random.default_rng(0).standard_normal((count, len(Q)))
    P, left = np.tile(p, (count, 1)), np.zeros((count, len(p)))
    for _ in range(8):
        left = (terms(P) - off) @ Q
        low, high = (np.array([getattr(each, key) for each in free]) for key in ("low", "high"))
        P = np.clip(P - units * np.linalg.solve(R, left.T).T, low, high)
    return P[np.max(np.abs(left), axis=1) < 0.3]


def _force_width(found: Adaptation, P: Array) -> float:
    """Return the largest difference of a force's deviation by samples from the approximation's, over it."""
    prior, P = found.prior, P[:, : len(found.values)]
    ends = loads_over(prior.table.map.low, prior.table.map.high, 2)
    answers, by = prior.force_slopes(found.values, ends)
    approximate = np.sqrt(np.einsum("mdn,mnp,pq,moq,mdo->md", answers, by, found.covariance, by, answers))
    L = prior.bench(ends).model(prior.used(np.vstack([found.values, P])))
    forces = np.einsum("mdn,kmn->kmd", answers, L[1:] - L[0])
    return float(np.max(np.abs(np.nanstd(forces, axis=0, ddof=1) / approximate - 1.0)))


def test_a_table_of_one_force_is_adapted(prior: Prior) -> None:
    """Whose other force has one value; two weights tell of it."""
    single = prior_of(prior.sensor, prior.data.isel(F_x=[2]))
    assert single.forces == ("F_z",) and single.table.L.shape == (5, 2)
    loads = np.array([[0.0], [1.0]])
    found = adapt(single, bench_of(single, loads, modulus=0.9))
    assert found.p_value > 0.01 and found.deviations[0] < 0.5 * np.sqrt(single.covariance[0, 0])


def test_a_bench_that_is_known_stays_on_the_bench(prior: Prior) -> None:
    """A load cell known to be turned and off scale, as a lot tells: what is read in use is not turned."""
    stated = {"cell": 1.03, "frame": 0.05}
    known = [replace(each, value=stated.get(each.name, each.value)) for each in prior.known]
    turned = prior.known_together(known, np.eye(len(known)))
    p = unknowns(prior, **OTHERWISE)
    for ours, theirs in zip(turned.force_slopes(p, LOADS), prior.force_slopes(p, LOADS), strict=True):
        assert ours == pytest.approx(theirs, rel=1e-9, abs=1e-9 * np.abs(theirs).max())
    found = adapt(turned, bench_of(turned, **OTHERWISE | stated))
    unit, same = constants_of(found), constants_of(replace(found, prior=prior))
    assert unit.factor == pytest.approx(same.factor) and unit.gain == pytest.approx(same.gain)


def test_nothing_changed_shows_the_table(prior: Prior) -> None:
    """The set-up's changes are read by the table's own model: none of its errors scatters about them."""
    table = prior.table
    shown = prior.setup.readings(table.poses[None], unknowns(prior)[None, : len(prior.setup.parameters)])[0]
    assert shown == pytest.approx(table.L, rel=1e-12)


def test_what_readings_take_up_is_counted_once(
    prior: Prior, numerics_alone: Callable[[], AbstractContextManager[None]]
) -> None:
    """Errors that loads share are unknowns, as a gap is: of a force the adapted table says no more than `adapt`.

    It says less where own errors of poses move all coils alike, which `adapt` takes as independent.
    """
    assert prior.table.shared > 0
    found, at = adapt(prior, bench_of(prior)), np.array([[0.1, 0.8], [-0.2, 1.1], [0.2, 0.5]])
    with numerics_alone():
        known = terminal_calibration(*corrected(found))
    ratio = budget(known, at).total / SURE / found.force_deviations(at)[1]
    assert np.all(ratio > 0.5) and np.all(ratio < 1.05)


@pytest.mark.parametrize("wrong", [-1.0, 0.0, np.nan, "1 N"])
def test_deviations_are_above_zero(prior: Prior, wrong: object) -> None:
    """Of loads, depths and readings, before anything is fitted."""
    for name in ("load_noise", "depth_noise"):
        with pytest.raises(SceneError, match=f"^{name}: must be a number above 0 .*; got "):
            adapt(prior, bench_of(prior), **{name: wrong})
        with pytest.raises(SceneError, match=f"^{name}: must be a number above 0 .*; got "):
            plan_loads(prior, 2, **{name: wrong})
    with pytest.raises(SceneError, match="^noise: must be a number above 0 .*; got "):
        prior_of(prior.sensor, prior.data, noise=wrong)
