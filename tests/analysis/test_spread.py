"""Scatter and shares in closed form: linear maps, a product, Ishigami's kind of interaction."""

import numpy as np
import pytest

from sits_mech.analysis.spread import design, spread

NAMES = ("thickness", "modulus", "gap")
S = np.array([0.1, 0.2, 0.05])


def test_a_sum_by_hand() -> None:
    """y = a . x: variance sum (a_i s_i)^2, shares (a_i s_i)^2 over it, first-order and total alike."""
    a = np.array([3.0, -1.0, 4.0])
    x = design(S, 32)
    found = spread(NAMES, S, x, 5.0 + x @ np.stack([a, 0.0 * a], -1))
    variance = np.sum((a * S) ** 2)
    assert found.mean[0] == pytest.approx(5.0, abs=2e-3)
    assert found.deviation[0] == pytest.approx(np.sqrt(variance), rel=0.01)
    np.testing.assert_allclose(found.first[0], (a * S) ** 2 / variance, atol=0.02)
    np.testing.assert_allclose(found.total[0], found.first[0], atol=0.02)
    width = 1.96 * np.sqrt(variance)
    np.testing.assert_allclose(found.interval[0], [5.0 - width, 5.0 + width], atol=0.03 * width)
    assert found.deviation[1] < 1e-12 and np.all(np.isnan(found.first[1]))


def test_a_product_acts_together() -> None:
    """y = x1 x2 has no first-order shares at all, and total shares of one each."""
    x = design(S, 64)
    found = spread(NAMES, S, x, (x[:, :1] * x[:, 1:2]) * 1e-6)
    np.testing.assert_allclose(found.first[0], [0.0, 0.0, 0.0], atol=0.05)
    np.testing.assert_allclose(found.total[0], [1.0, 1.0, 0.0], atol=0.08)
    assert found.deviation[0] == pytest.approx(1e-6 * S[0] * S[1], rel=0.05)


@pytest.mark.slow
def test_plain_drawing_agrees() -> None:
    """200,000 random draws of the function itself."""

    def answer(x: np.ndarray) -> np.ndarray:
        return np.exp(2.0 * x[:, :1] + x[:, 1:2]) / (1.0 + x[:, 2:])

    x = design(S, 128)
    found = spread(NAMES, S, x, answer(x))
    drawn = answer(np.random.default_rng(0).standard_normal((200_000, 3)) * S)
    assert found.mean[0] == pytest.approx(drawn.mean(), rel=0.005)
    assert found.deviation[0] == pytest.approx(drawn.std(), rel=0.03)
    np.testing.assert_allclose(found.interval[0], np.quantile(drawn, [0.025, 0.975]), rtol=0.02)
    assert found.map_error[0] < 0.02 * found.deviation[0]


def test_what_has_no_spread_is_refused() -> None:
    """Deviations, counts and samples that are none."""
    with pytest.raises(ValueError, match="deviations: must be positive"):
        design([0.1, 0.0], 16)
    with pytest.raises(ValueError, match="count: must be at least 8 for 3 tolerances; got 4"):
        design(S, 4)
    x = design(S, 32)
    with pytest.raises(ValueError, match="samples: must be a power of two from 64 on; got 1000"):
        spread(NAMES, S, x, x, samples=1000)
    with pytest.raises(ValueError, match="samples: must be a power of two from 64 on; got 32"):
        spread(NAMES, S, x, x, samples=32)
    assert np.isfinite(spread(NAMES, S, x, x, samples=64).deviation).all()
    failed = np.where(np.arange(32)[:, None] < 20, np.nan, x)
    assert np.isfinite(spread(NAMES, S, x, failed).mean).all()
