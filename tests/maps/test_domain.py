"""Where a map can be turned around: parts that symmetry makes alike, directions that nothing is seen in."""

import numpy as np
import pytest

from sits_mech.maps.domain import Domain, _whitening, domain_of, hull_of
from sits_mech.maps.surrogate import SmoothMap, fit_map


def grid_of(size: int) -> np.ndarray:
    """Points of a regular grid over [-1, 1] x [0, 2]."""
    return np.stack(np.meshgrid(np.linspace(-1, 1, size), np.linspace(0, 2, size), indexing="ij"), -1).reshape(-1, 2)


def shaken(values: np.ndarray, seed: int) -> SmoothMap:
    """The map of values on `grid_of(9)` whose last digits are off."""
    rng = np.random.default_rng(seed)
    return fit_map(("x", "z"), grid_of(9), values * (1.0 + 4e-16 * rng.standard_normal(values.shape)))


def of_values(values: np.ndarray, seed: int) -> tuple[Domain, tuple[np.ndarray, ...]]:
    """The domain of a map whose last digits are off."""
    found = shaken(values, seed)
    return domain_of(found, np.ones(2), hull_of(found.scaled(grid_of(9))))


def fit_of_a_plane() -> SmoothMap:
    """A linear map of both forces."""
    x, z = grid_of(9).T
    return fit_map(("x", "z"), grid_of(9), np.stack([x + 0.1 * z, z], -1))


@pytest.mark.parametrize("seed", range(6))
def test_of_two_halves_that_look_alike_the_larger_forces_are_valid(seed: int) -> None:
    """An even map folds at x = 0; which half has the inverse is not left to rounding."""
    x, z = grid_of(9).T
    domain, seeds = of_values(np.stack([x**2 + 0.1 * z, z], -1), seed)
    asked = np.array([[0.7, 0.1], [-0.7, 0.1]])
    assert domain.valid(asked).tolist() == [True, False] and np.all(seeds[0][:, 0] > 0.0)
    assert domain.share == pytest.approx(0.5, abs=0.02) and len(domain.regions) >= 1


@pytest.mark.parametrize("seed", range(3))
def test_what_varies_by_rounding_is_no_direction(seed: int) -> None:
    """Two coils that show the same, to 1e-8 of their range: one direction for two forces."""
    x, z = grid_of(9).T
    scatter = 1e-8 * np.random.default_rng(seed).standard_normal(81)
    domain, _ = of_values(np.stack([x + z, x + z + scatter], -1), seed)
    assert domain.share == 0.0


def test_a_map_that_is_one_to_one_is_valid_everywhere() -> None:
    """A gentle bend."""
    x, z = grid_of(9).T
    domain, seeds = of_values(np.stack([x + 0.1 * z**2, z - 0.1 * x * z], -1), 0)
    assert domain.regions == () and domain.share == 1.0 and len(seeds) == 1


@pytest.mark.parametrize(("turns", "crosses"), [(0.9, False), (1.1, True)])
def test_a_map_of_one_sign_may_cross_itself(turns: float, crosses: bool) -> None:
    """Round a ring, whose radius grows with z: beyond a whole turn two loads show the same."""
    x, z = grid_of(9).T
    radius, angle = 1.0 + 0.3 * z, np.pi * turns * x
    domain, seeds = of_values(np.stack([radius * np.cos(angle), radius * np.sin(angle)], -1), 0)
    assert domain.share == 1.0 and [" crosses itself" in each for each in domain.regions] == [True] * crosses
    assert (len(seeds) > 1) is crosses


def test_the_hull_ends_at_its_edges() -> None:
    """Of a triangle: within, on the edge but for rounding, beyond by as much as is let pass and no more."""
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]])
    domain, _ = domain_of(fit_of_a_plane(), np.ones(2), hull_of(corners))
    away = np.array([-0.5, 0.0, 5e-10, 1e-7, 0.02 - 1e-7, 0.02 + 1e-7])
    asked = np.outer(away, [1.0, 1.0]) / np.sqrt(2.0)  # the edge goes through the middle of the box
    assert domain.holds(asked, 0.0).tolist() == [True, True, True, False, False, False]
    assert domain.holds(asked, 0.02).tolist() == [True, True, True, True, True, False]
    assert domain.holds(corners + 0.01, 0.0).tolist() == [True, False, False]
    assert domain.share == 1.0 and domain.labels.shape == (65, 65)
    k = np.arange(65)
    np.testing.assert_array_equal(domain.labels, (k[:, None] + k <= 64).astype(int))


@pytest.mark.parametrize("x", [np.linspace(-1, 1, 5)[:, None], np.linspace(-1, 1, 5)[:, None] * [1.0, 1.0]])
def test_loads_along_a_line_are_held_by_their_box(x: np.ndarray) -> None:
    """Of one force, and of two that go together: -1 to 1 of each, and nothing beyond either end."""
    hull, d = hull_of(x), x.shape[1]
    for way in np.vstack([np.eye(d), -np.eye(d)]):
        assert np.max(hull[:, :-1] @ way + hull[:, -1]) == 0.0
        assert np.max(hull[:, :-1] @ (1.1 * way) + hull[:, -1]) == pytest.approx(0.1)
    assert np.all(hull[:, -1] == -1.0) and len(hull) == 2 * d


def test_units_of_coils_and_their_weights_do_not_count() -> None:
    """Of three coils over two forces: coils read in other units, with their weights, give the same directions."""
    rng, units = np.random.default_rng(3), np.array([1.0, 20.0, 0.3])
    values, slopes, weights = rng.normal(size=(9, 3)), rng.normal(size=(9, 3, 2)), np.array([1.0, 2.0, 0.5])
    middle, directions = _whitening(values, slopes, weights)
    other, turned = _whitening(values * units, slopes * units[:, None], weights / units)
    np.testing.assert_allclose(other, middle * units, rtol=1e-12)
    spread, same = (values - middle) @ directions, (values * units - other) @ turned
    assert directions.shape == (3, 2)
    np.testing.assert_allclose(np.abs(same), np.abs(spread), rtol=1e-9, atol=1e-12)


def test_directions_have_size_one_about_the_middle() -> None:
    """Inductances far from zero, as they are: what they all have in common is none of their directions."""
    dice = np.random.default_rng(3)
    slopes = dice.normal(size=(200, 2, 2))
    values = np.array([50.0, -80.0]) + dice.normal(size=(200, 2)) @ np.array([[1.0, 0.3], [0.0, 0.2]])
    middle, directions = _whitening(values, slopes, np.ones(2))
    seen = (values - middle) @ directions
    np.testing.assert_allclose(seen.T @ seen / 200, np.eye(2), atol=1e-12)
