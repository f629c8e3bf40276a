"""Fits whose answers are known: intervals, what is known beforehand, what the data do not hold."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.analysis.built.fit import Free, fit_parameters
from sits_mech.quantities import Array

X = np.linspace(0.0, 1.0, 20)[:, None]
LINE = (Free("a", 0.0, -9.0, 9.0, 1.0), Free("b", 0.0, -9.0, 9.0, 1.0))


def line(P: Array) -> Array:
    """a + b x."""
    return P[:, :1, None] + P[:, 1:, None] * X


@pytest.mark.slow
@pytest.mark.parametrize("noise", [None, 0.02])
def test_intervals_hold_the_truth_as_often_as_they_say(noise: float | None) -> None:
    """300 noisy lines: the 95 % interval of the slope holds the true one in 92 to 98 of 100 cases.

    With a known noise it is a little wider, as it never shrinks where the scatter happens to be small.
    """
    rng = np.random.default_rng(4)
    held = 0
    for _ in range(300):
        y = 2.0 + 0.3 * X + 0.02 * rng.standard_normal(X.shape)
        found = fit_parameters(line, y, LINE, noise=noise)
        held += abs(found.values[1] - 0.3) <= found.half_widths[1]
    assert 276 <= held <= 294 or (noise is not None and held <= 297)
    assert found.residual.shape == (20, 1) and 0.03 < found.rms < 0.15 < found.rms_before


def test_what_the_data_do_not_hold() -> None:
    """A parameter without effect has no finite interval; one at its end, or too few data, are refused."""
    x = np.linspace(0.0, 1.0, 9)[:, None]
    free = (Free("a", 1.0, 0.0, 9.0, 1.0), Free("b", 0.0, -1.0, 1.0, 1.0))
    found = fit_parameters(lambda P: P[:, :1, None] * x, 2.0 * x + 1e-3 * x**2, free)
    assert np.isfinite(found.half_widths[0]) and np.isinf(found.half_widths[1])
    near = Free("a", 0.5, 0.0, 1.0, 1.0, beyond=("less", "more is not there"))
    with pytest.raises(ValueError, match="a: must fit .* between 0 and 1; .* upper end, 1: more is not there"):
        fit_parameters(lambda P: P[:, :, None] * x, 2.0 * x, [near])
    with pytest.raises(ValueError, match="must hold more than 1 numbers; got 1"):
        fit_parameters(lambda P: P[:, :, None] * x[:1], x[:1], [near])


def test_what_is_known_beforehand_is_weighed_with_the_data() -> None:
    """One number a + b measured +- 0.1, a = 0 +- 0.3 and b = 1 +- 0.4: the closed form of both; noise is asked for."""
    free = (Free("a", 0.0, -9.0, 9.0, 0.3, 0.3), Free("b", 1.0, -9.0, 9.0, 0.4, 0.4))
    found = fit_parameters(lambda P: P.sum(axis=1)[:, None, None], [[2.0]], free, noise=0.1)
    gain = np.array([0.3**2, 0.4**2]) / (0.3**2 + 0.4**2 + 0.1**2)  # Kalman's, of a miss of one
    np.testing.assert_allclose(found.values, [gain[0], 1.0 + gain[1]], rtol=1e-6)
    covariance = np.diag([0.09, 0.16]) - np.outer(gain, [0.09, 0.16])
    deviation = np.sqrt(np.diagonal(covariance))
    widths = 1.959964 * deviation * np.sqrt(max(found.chi_square, 1.0))
    np.testing.assert_allclose(found.half_widths, widths, rtol=1e-5)
    assert found.correlation[0, 1] == pytest.approx(covariance[0, 1] / deviation.prod(), rel=1e-6)
    with pytest.raises(ValueError, match="noise: must be given where a parameter has a deviation"):
        fit_parameters(lambda P: P.sum(axis=1)[:, None, None], [[2.0]], free)


def test_places_without_an_answer_are_not_taken() -> None:
    """A model that has none above 1.5."""

    def root(P: Array) -> Array:
        """(1.5 - a)^(1/2)."""
        with np.errstate(invalid="ignore"):
            return np.sqrt(1.5 - P)[:, :, None] * X

    free = [Free("a", -2.0, -9.0, 9.0, 1.0)]
    found = fit_parameters(root, np.sqrt(0.2) * X, free)
    assert found.values[0] == pytest.approx(1.3, rel=1e-6)


def slopes(p: Array) -> Array:
    """Derivatives of `line` by a and b."""
    return np.stack([np.ones(X.shape), X], axis=-1)


def test_slopes_of_the_model_find_the_posterior_in_closed_form() -> None:
    """Of a line with prior knowledge, noise of each number and one that was not measured: (J^T J)^-1 and its mean."""
    y, noise = 2.0 + 0.3 * X, np.linspace(0.01, 0.05, 20)[:, None]
    y = np.where(X == X[7], np.nan, y)
    free = (replace(LINE[0], deviation=0.5), replace(LINE[1], deviation=0.1))
    found = fit_parameters(line, y, free, noise=noise, slopes=slopes)
    kept = np.isfinite(y)
    J = np.concatenate([(slopes(np.zeros(2)) / noise[..., None])[kept], np.diag([2.0, 10.0])])
    covariance = np.linalg.inv(J.T @ J)
    mean = covariance @ J.T @ np.concatenate([(y / noise)[kept], [0.0, 0.0]])
    assert found.values == pytest.approx(mean, abs=1e-6)
    assert found.covariance == pytest.approx(covariance * found.variance, rel=1e-6)


def test_a_wall_of_nature_may_hold_a_parameter() -> None:
    """The least in the box: the other parameter is the best for it; an end that is none of nature's is refused."""
    y = 2.0 - 0.3 * X
    free = (LINE[0], replace(LINE[1], low=0.0, wall=True))
    found = fit_parameters(line, y, free, slopes=slopes)
    assert found.values == pytest.approx([np.mean(y), 0.0], abs=1e-6)
    with pytest.raises(ValueError, match="b: must fit the readings between 0 and 9"):
        fit_parameters(line, y, (LINE[0], replace(LINE[1], low=0.0)), slopes=slopes)


def test_a_curved_model_is_followed_downhill() -> None:
    """exp(a x) from far away, with slopes that are ten percent off: steps are halved, and slopes corrected by them."""
    def curve(P: Array) -> Array:
        """exp(a x)."""
        return np.exp(P[:, :, None] * X)

    def rough(p: Array) -> Array:
        """Its slopes, not quite."""
        return 1.1 * (X * np.exp(p[0] * X))[..., None]

    found = fit_parameters(curve, np.exp(-1.5 * X), (Free("a", 4.0, -9.0, 9.0, 1.0, 5.0),), noise=1e-3, slopes=rough)
    assert found.values[0] == pytest.approx(-1.5, abs=1e-3)


def test_a_factor_is_known_by_its_logarithm() -> None:
    """Half and twice are as far; the posterior's mode and width of one number in closed form, by slopes as without."""
    factor = Free("s", 1.0, 0.01, 100.0, 0.5, 0.5, ratio=True)
    assert factor.known(np.array([0.5, 2.0])) == pytest.approx([-2.0 * np.log(2.0), 2.0 * np.log(2.0)])

    def model(P: Array) -> Array:
        """The logarithm of the factor, read once."""
        return np.log(P)[:, :, None]

    y = np.full((1, 1), 1.0)
    for way in (None, lambda p: (1.0 / p)[None, None]):
        found = fit_parameters(model, y, (factor,), noise=0.5, slopes=way)
        assert found.values[0] == pytest.approx(np.exp(0.5), rel=3e-3)
        width = np.sqrt(0.125 * found.variance) * np.exp(0.5)
        assert np.sqrt(found.covariance[0, 0]) == pytest.approx(width, rel=1e-2)


def test_what_is_known_together_is_as_good_as_what_told_it() -> None:
    """Half of the numbers, then the other half with what the first told, correlations and all: as all at once."""
    y = 2.0 + 0.3 * X + 0.02 * np.sin(40.0 * X)
    free = (replace(LINE[0], deviation=0.5), replace(LINE[1], deviation=0.1))
    first = fit_parameters(line, np.where(np.arange(20)[:, None] < 9, y, np.nan), free, noise=0.05, slopes=slopes)
    sizes = np.sqrt(np.diagonal(first.covariance / first.variance))
    alike = first.covariance / first.variance / np.outer(sizes, sizes)
    then = tuple(replace(each, start=value, deviation=size) for each, value, size in
                 zip(free, first.values.tolist(), sizes.tolist(), strict=True))
    root = np.linalg.inv(np.linalg.cholesky(alike))
    rest = np.where(np.arange(20)[:, None] < 9, np.nan, y)
    second = fit_parameters(line, rest, then, noise=0.05, slopes=slopes, root=root)
    whole = fit_parameters(line, y, free, noise=0.05, slopes=slopes)
    assert second.values == pytest.approx(whole.values, abs=1e-5)
    assert second.covariance / second.variance == pytest.approx(whole.covariance / whole.variance, rel=1e-4)
