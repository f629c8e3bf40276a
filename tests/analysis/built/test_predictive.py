"""What a sensor may show before it is fitted: in closed form where all is linear, and by samples."""

import numpy as np
import pytest

from sits_mech.analysis.built.predictive import Predictive
from sits_mech.analysis.built.prior import Prior, prior_of
from tests.analysis.conftest import LOADS


def test_readings_of_one_unknown_spread_as_its_deviation(cheap) -> None:
    """A lead adds itself to each reading, and what the first one shows of it is known of the others."""
    known = Predictive(prior_of(*cheap, ["lead=0+-10 nH"], noise=1e-12))
    loads = np.zeros((2, 2))
    L, _, _ = known.expected(loads, 0.0)
    found = known.likeliest(loads, L + 5e-9)
    first, own = 1e-8, np.hypot(1e-12, known.prior.model.max())
    assert np.isclose(found.deviation[0, 0], np.hypot(first, 1e-12), rtol=1e-2)
    assert np.all(found.deviation[1] < 2.0 * np.sqrt(2.0) * own)
    assert np.allclose(found.mean[1], L[1] + 5e-9, atol=0.1e-9)


@pytest.mark.slow
def test_units_drawn_as_known_are_likely_and_within_their_ends(prior: Prior) -> None:
    """Softer, stiffer and moved ones, by the model itself: none is far below one of their number."""
    known, rng = Predictive(prior), np.random.default_rng(2)
    units = np.clip(rng.standard_normal((12, len(prior.start))), -2.0, 2.0)
    P = prior.start + prior.deviations * units
    place = prior.setup.names.index("modulus")
    P[:, place] = np.exp(P[:, place] - 1.0)
    L = prior.bench(LOADS).model(P)
    noise = np.hypot(prior.noise, prior.model) * rng.standard_normal(L.shape)
    p = np.array([known.likeliest(LOADS, one).p for one in L + noise])
    assert p.min() > 1e-4
    low, high = known.ends(LOADS, 6.0)
    assert np.all((low < L) & (L < high))
    assert not known.likeliest(LOADS, 1.2 * L[0]).p > 1e-12
