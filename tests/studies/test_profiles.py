"""Profiles whose answers are known: parabolas of lines, what the data do not hold."""

from dataclasses import replace

import numpy as np
import pytest
from common.profiles import profile, rise

from sits_mech.analysis.built.comparison import Comparison
from sits_mech.analysis.built.fit import Free, fit_parameters
from sits_mech.analysis.readings.measured import Measured
from sits_mech.quantities import Array
from sits_mech.scene.sensor import SceneError

X = np.linspace(0.0, 1.0, 20)[:, None]
LINE = (Free("a", 0.0, -9.0, 9.0, 1.0), Free("b", 0.0, -9.0, 9.0, 1.0))


def line(P: Array) -> Array:
    """a + b x."""
    return P[:, :1, None] + P[:, 1:, None] * X


def test_profiles_are_parabolas_where_the_model_is_a_line() -> None:
    """The slope's rises as ((b - best) / deviation)^2; one that the data do not hold is flat but for its partner."""
    noise, rng = 0.02, np.random.default_rng(7)
    y = 2.0 + 0.3 * X + noise * rng.standard_normal(X.shape)
    found = fit_parameters(line, y, LINE, noise=noise)
    deviation = noise / np.sqrt(np.sum((X - X.mean()) ** 2))
    values = found.values[1] + deviation * np.arange(-2.0, 3.0)
    np.testing.assert_allclose(rise(line, y, LINE, "b", noise, values), [4.0, 1.0, 0.0, 1.0, 4.0], atol=1e-5)
    assert np.isnan(rise(line, y, LINE, "b", noise, np.array([0.3, 30.0]))).tolist() == [False, True]  # a is -13 there
    bench = Comparison(Measured(np.zeros((20, 0)), y, "line"), found, LINE, line, noise, y, np.nan, 0.0)
    there, up = profile(bench, "b", points=3, reach=1.0)
    assert there == pytest.approx(found.values[1] + found.half_widths[1] * np.array([-1.0, 0.0, 1.0]))
    assert up == pytest.approx(np.array([1.96, 0.0, 1.96]) ** 2, rel=1e-3, abs=1e-6)
    with pytest.raises(SceneError, match="b: must have a half-width, and the noise be given"):
        profile(replace(bench, noise=None), "b")
    both = tuple(replace(each, deviation=1.0) for each in LINE)
    shared = rise(
        lambda P: P.sum(axis=1)[:, None, None] * X, 2.0 * X, both, "a", noise, np.array([0.0, 1.0, 2.0])
    )
    np.testing.assert_allclose(shared, [4.0, 1.0, 0.0], atol=2e-3)  # (2 - a)^2: of its partner alone


def test_a_parameter_alone_has_its_own_chi_square() -> None:
    """No other is fitted."""
    assert rise(lambda P: P[:, :, None] * X, X, LINE[:1], "a", 1.0, np.array([1.0, 2.0]))[1] == pytest.approx(
        np.sum(X**2)
    )
