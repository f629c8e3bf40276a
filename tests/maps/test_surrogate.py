"""The smooth map: exact for polynomials, converging for the rest, its predicted error held by unseen points."""

import numpy as np
import pytest

from sits_mech.maps.surrogate import _uncertainty, fit_map


def grid(*sizes: int) -> np.ndarray:
    """Points of a regular grid over [0, 2] x [-1, 3] x ..."""
    axes = [np.linspace(-1.0 * (i % 2), 2.0 + i, size) for i, size in enumerate(sizes)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(sizes))


def bent(points: np.ndarray) -> np.ndarray:
    """Two outputs, analytic, none a polynomial."""
    x, y = points.T
    return np.stack([np.exp(-0.4 * x + 0.2 * y), 1.0 / (3.0 + x + 0.5 * y**2)], -1)


def test_polynomials_come_back_exactly() -> None:
    """Degree 3 by 2, values and slopes, in units far from one; a degree that is not needed is not taken."""
    points = grid(6, 5)
    x, y = points.T
    found = fit_map(("x", "y"), points, np.stack([1e-6 * (x**3 * y**2 - x), 1e-6 * y], -1))
    assert found.degrees == (3, 2)
    p = np.random.default_rng(1).uniform([0.0, -1.0], [2.0, 3.0], (50, 2))
    u, v = p.T
    np.testing.assert_allclose(found.at(p), 1e-6 * np.stack([u**3 * v**2 - u, v], -1), atol=1e-18)
    expected = [[3.0 * u**2 * v**2 - 1.0, 2.0 * u**3 * v], [0.0 * u, 1.0 + 0.0 * u]]
    np.testing.assert_allclose(found.slopes(p), 1e-6 * np.moveaxis(np.array(expected), -1, 0), atol=1e-17)
    assert found.at(p.reshape(5, 10, 2)).shape == (5, 10, 2) and found.slopes(p[0]).shape == (2, 2)


def test_error_falls_geometrically_and_is_predicted() -> None:
    """Chebyshev maps of analytic functions: more points, exponentially less error, within `error`."""
    new = np.random.default_rng(2).uniform([0.0, -1.0], [2.0, 3.0], (500, 2))
    last = np.inf
    for size in (7, 9, 11):
        found = fit_map(("x", "y"), grid(size, size), bent(grid(size, size)))
        true = np.max(np.abs(found.at(new) - bent(new)), axis=0)
        assert np.all(true <= found.error) and np.max(true) < 0.3 * last
        last = float(np.max(true))
    assert last < 1e-4


@pytest.mark.parametrize(
    "sizes",
    [(5, 5, 5), (6, 6, 6), (7, 5, 6), *(pytest.param(n, marks=pytest.mark.slow) for n in ((9, 9, 9), (5, 5, 5, 5)))],
)
def test_the_error_of_many_variables_holds(sizes: tuple[int, ...]) -> None:
    """Each variable's share adds up: random points of smooth functions, odd, even and mixed, are within `error`."""
    points, rng = grid(*sizes), np.random.default_rng(8)
    weights = rng.normal(size=(len(sizes), 4)) / (2.0 + np.arange(len(sizes)))[:, None]
    middle = points.mean(axis=0)

    def smooth(p: np.ndarray) -> np.ndarray:
        """Exponential, odd and even."""
        a, b, c, d = (0.5 * (p - middle) @ weights).T
        return np.stack([np.exp(a), np.sin(b) + np.sin(c), np.cosh(d) * (1.0 + 0.1 * (p - middle)[:, 0])], -1)

    found = fit_map("abcd"[: len(sizes)], points, smooth(points))
    new = rng.uniform(points.min(axis=0), points.max(axis=0), (5000, len(sizes)))
    assert np.all(np.max(np.abs(found.at(new) - smooth(new)), axis=0) <= found.error)


def test_noise_is_not_followed() -> None:
    """White noise of 1e-3 on a plane: the predicted error is its size, the map has few terms."""
    points = grid(9, 9)
    rng = np.random.default_rng(3)
    found = fit_map(("x", "y"), points, points @ [[1.0], [2.0]] + 1e-3 * rng.standard_normal((81, 1)))
    assert found.error[0] < 5e-3 and found.rms[0] == pytest.approx(1e-3, rel=0.3) and found.powers.shape[0] <= 12


def test_leaving_out_is_leaving_out() -> None:
    """The closed form of the error equals fitting anew without each inner line of the grid."""
    points, values = grid(7, 6), bent(grid(7, 6))
    found = fit_map(("x", "y"), points, values)
    x = found.scaled(points)
    design = np.prod([np.cos(found.powers[:, i] * np.arccos(np.clip(x[:, i : i + 1], -1, 1))) for i in (0, 1)], axis=0)
    off = []
    for column in points.T:
        for value in np.unique(column)[1:-1]:
            out = column == value
            off.append(design[out] @ np.linalg.lstsq(design[~out], values[~out], rcond=None)[0] - values[out])
    mean = np.sqrt(np.mean(np.concatenate(off) ** 2, axis=0))
    np.testing.assert_allclose(mean, found.rms, rtol=1e-6)
    assert np.all(np.max(np.abs(np.concatenate(off)), axis=0) <= (1.0 + 1e-6) * found.error)


@pytest.mark.parametrize("seed", range(6))
def test_rounding_does_not_choose_the_degrees(seed: int) -> None:
    """Changes in the last digits, as between processors, leave polynomials, even and symmetric maps as they are."""
    rng = np.random.default_rng(seed)
    points = grid(9, 7)
    x, y = points[:, 0] - 1.0, 0.5 * (points[:, 1] - 1.0)
    values = {
        (3, 2): np.stack([x**3 * y**2 - x, y, 1.0 + 0.0 * x], -1),
        (4, 2): (x**4 + 1e-3 * y**2)[:, None],
        (1, 1): np.stack([5.0 + x, 1e3 + 1e-12 * x], -1),
    }
    for degrees, each in values.items():
        places = points * (1.0 + 2e-16 * rng.standard_normal(points.shape))
        found = fit_map(("x", "y"), places, each * (1.0 + 4e-16 * rng.standard_normal(each.shape)))
        assert found.degrees == degrees
    even = np.cosh(3.0 * x)[:, None] + np.cosh(2.0 * y)[:, None]
    plain = fit_map(("x", "y"), points, even)
    shaken = fit_map(("x", "y"), points, even * (1.0 + 4e-16 * rng.standard_normal(even.shape)))
    assert shaken.degrees == plain.degrees


def test_the_simplest_of_maps_as_good_is_taken() -> None:
    """A plane with noise, and with a wave in x of a fifth of it: no term is spent on less than a tenth of the error."""
    points = grid(9, 9)
    x, y = points.T
    noise = 1e-3 * np.random.default_rng(7).standard_normal(81)
    for shape in (0.0, 2e-4):
        found = fit_map(("x", "y"), points, (x + y + shape * np.cos(3.0 * x) + noise)[:, None])
        assert found.degrees == (1, 1)


def test_few_lines() -> None:
    """Three lines are all taken, with the error of a straight line; of two lines nothing can be told."""
    points = grid(3, 5)
    found = fit_map(("x", "y"), points, bent(points))
    assert found.degrees == (2, 4)
    np.testing.assert_allclose(found.at(points), bent(points), rtol=1e-12)
    assert np.all(found.error > np.max(np.abs(found.at(grid(9, 9)) - bent(grid(9, 9))), axis=0))
    assert np.all(np.isinf(fit_map(("x", "y"), grid(2, 4), bent(grid(2, 4))).error))


@pytest.mark.slow
@pytest.mark.parametrize("count", [4, 5])
def test_the_error_of_few_lines_is_that_of_the_whole_map(count: int) -> None:
    """Not that of the map of fewer degrees which it is compared with: within it, by less than the decay of a degree."""
    x = np.linspace(0.0, 1.0, count)
    found = fit_map(["F_z"], x[:, None], np.exp(-0.8 * x / (1.0 + 0.5 * x))[:, None])
    fine = np.linspace(0.0, 1.0, 201)
    off = np.abs(found.at(fine[:, None])[:, 0] - np.exp(-0.8 * fine / (1.0 + 0.5 * fine)))
    assert found.degrees == (count - 1,)
    assert off.max() < found.error[0] < 50.0 * off.max()


def test_scattered_points_and_many_variables() -> None:
    """Four variables, 120 scattered points: the simplex of terms."""
    p = np.random.default_rng(4).uniform(-1.0, 1.0, (120, 4))
    y = np.exp(0.3 * p @ [1.0, -0.5, 0.2, 0.1])[:, None]
    found = fit_map(tuple("abcd"), p, y, simplex=True)
    q = np.random.default_rng(5).uniform(-0.9, 0.9, (200, 4))
    assert np.max(np.abs(found.at(q)[:, 0] - np.exp(0.3 * q @ [1.0, -0.5, 0.2, 0.1]))) < 2e-4


def test_what_cannot_be_fitted_is_refused() -> None:
    """Too few, not finite, of one value, of other shapes."""
    with pytest.raises(ValueError, match="at least 4; got 3"):
        fit_map(("x", "y"), np.eye(3)[:, :2], np.ones((3, 1)))
    with pytest.raises(ValueError, match="y: must take at least two values; got 1 alone"):
        fit_map(("x", "y"), np.c_[np.arange(6.0), np.ones(6)], np.ones((6, 1)))
    some, gap = np.arange(4.0)[:, None], np.array([[1.0], [2.0], [np.nan], [3.0]])
    for points, values in ((some, gap), (gap, some)):
        with pytest.raises(ValueError, match="must be finite"):
            fit_map(("x",), points, values)
    with pytest.raises(ValueError, match=r"must be of shapes \(m, 2\) and \(m, n\); got"):
        fit_map(("x", "y"), np.ones((5, 3)), np.ones((5, 1)))


def test_doubts_of_three_variables_add_up() -> None:
    """A cubic of each that a square map leaves out: 1.5 times one of them, or 1.25 times all where there are three."""
    nodes = np.cos(np.pi * (np.arange(7) + 0.5) / 7)
    for count, expected in ((1, 1.5), (2, 1.5), (3, 3.75)):
        x = np.stack(np.meshgrid(*[nodes] * count, indexing="ij"), -1).reshape(-1, count)
        y = (4.0 * x**3 - 3.0 * x).sum(axis=1, keepdims=True)
        assert _uncertainty(x, y, [2] * count, [7] * count, False) == pytest.approx(expected, rel=1e-9)
