"""What units share: closed forms of the hierarchy, a production that is found, units of which readings tell nothing."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.analysis.built.adaptation import adapt
from sits_mech.analysis.built.prior import Prior
from sits_mech.analysis.built.production import Evidence, evidence_of, produced, shared_by
from sits_mech.scene.sensor import SceneError
from tests.analysis.conftest import LOADS, bench_of


def test_one_number_read_of_many_units_in_closed_form() -> None:
    """With A = 1 - w^2, readings z_j of deviation r: m is their mean against A, with scatter w^2 + r^2."""
    z, r, w = np.array([0.3, 0.5, 0.1]), 0.2, 0.4
    units = [Evidence(np.array([[1.0 / r**2]]), np.array([value / r**2])) for value in z]
    found = shared_by(units, np.array([1.0 - w**2]), np.array([w]), settled=True)
    weight = 1.0 / (w**2 + r**2)
    precision = 1.0 / (1.0 - w**2) + 3.0 * weight
    assert found.covariance[0, 0] == pytest.approx(1.0 / precision)
    assert found.mean[0] == pytest.approx(weight * z.sum() / precision)


def test_units_tell_how_much_they_differ() -> None:
    """Of a hundred exactly read units the scatter is their own; of none it is what was stated; shared it stays zero."""
    z = np.random.default_rng(0).normal([0.5, -0.2], [0.1, 0.0], (100, 2))
    units = [Evidence(1e8 * np.eye(2), 1e8 * value) for value in z]
    found = shared_by(units, np.array([0.5, 1.0]), np.array([np.sqrt(0.5), 0.0]))
    assert found.within[0] == pytest.approx(np.sqrt((4.0 * 0.5 + 99.0 * z[:, 0].var(ddof=1)) / 104.0), rel=0.02)
    assert found.within[1] == 0.0 and found.mean == pytest.approx([z[:, 0].mean(), -0.2], abs=2e-3)
    alone = shared_by([], np.array([0.5, 1.0]), np.array([0.7, 0.0]))
    assert alone.within == pytest.approx([0.7, 0.0]) and alone.covariance == pytest.approx(np.diag([0.5, 1.0]))


def test_what_a_unit_tells_is_without_what_was_known(prior: Prior) -> None:
    """What was known and what is told make the posterior again."""
    found = adapt(prior, bench_of(prior))
    told = evidence_of(found)
    size, fit = prior.deviations, found.fit
    free = found.known.free[: len(size)]
    slopes = np.array([each.known_slope(value) for each, value in zip(free, found.values.tolist(), strict=True)])
    again = np.linalg.inv(fit.variance * told.information + np.eye(len(size)))
    expected = found.covariance / fit.variance * np.outer(slopes, slopes)
    assert np.diagonal(again) == pytest.approx(np.diagonal(expected), rel=0.05)


@pytest.mark.slow
def test_a_production_is_found(prior: Prior) -> None:
    """Of six units of one mix and one load cell: the next one is known far better, with that mix; each one's readings
    are of such a sensor, and one of another sensor does not count.
    """
    moduli = 0.8 * np.exp(0.03 * np.random.default_rng(2).standard_normal(6))
    units = {
        f"u{k}": bench_of(prior, seed=20 + k, modulus=value, gap=2e-5 * k, cell=1.006) for k, value in enumerate(moduli)
    }
    units["other"] = replace(bench_of(prior, LOADS[[0, 0, 1, 0, 2]], seed=9, modulus=0.8), forces=LOADS)
    found = produced(prior, units, {"modulus": 0.03})
    place = prior.setup.names.index("modulus")
    assert found.next.start[place] == pytest.approx(0.8, abs=0.03)
    assert found.next.deviations[place] < 0.15 * prior.deviations[place]
    assert found.within[place] == pytest.approx(np.log(moduli).std(ddof=1), abs=0.01)
    kept = [one for name, one in found.units.items() if name != "other"]
    assert np.array([one.values[place] for one in kept]) == pytest.approx(moduli, abs=0.05)
    assert min(one.p_value for one in kept) > 0.01
    assert "other" in found.refused or found.units["other"].p_value < 0.01


def test_what_has_no_production(prior: Prior) -> None:
    """Scatter of what is not unknown; units none of which is such a sensor."""
    with pytest.raises(SceneError, match="within: must be of modulus, .*; got colour"):
        produced(prior, {"a": bench_of(prior)}, {"colour": 0.1})
    wrong = bench_of(prior)
    with pytest.raises(SceneError, match="units: must have one or more that are such sensors; got none"):
        produced(prior, {"a": replace(wrong, L=wrong.L + 1e-6)}, {})
