"""Adaptive points against a regular grid, on functions known in closed form."""

import numpy as np
import pytest

from sits_mech.maps.sampling import Mirror, sample
from sits_mech.maps.surrogate import fit_map

BOX = ((-1.0, 0.0), (1.0, 4.0))
NAMES = ("F_x", "F_z")


def sensor(points: np.ndarray) -> np.ndarray:
    """Two coils that mirror each other, as bent as the published sensor."""
    x, z = points.T
    common = 0.85 * np.exp(-0.02 * z) * (1.0 + 0.01 * x**2)
    odd = 0.02 * np.sin(1.2 * x) * (1.0 + 0.1 * z)
    return np.stack([common + odd, common - odd], -1)


def worst(found, points: int = 41) -> float:
    """The true error of a map over the box, in parts of the range."""
    axes = np.linspace(-1.0, 1.0, points), np.linspace(0.0, 4.0, points)
    fine = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 2)
    return float(np.max(np.abs(found.at(fine) - sensor(fine)) / np.ptp(sensor(fine), axis=0)))


def test_a_third_of_the_grid() -> None:
    """To 1e-3 of the range with at most a third of a 9 by 9 grid's points, without help by symmetry."""
    found = sample(sensor, NAMES, BOX, tolerance=1e-3)
    assert found.reached and found.solves <= 27 and len(found.points) == found.solves
    assert worst(found.map) < 1e-3


def test_a_mirror_halves_it() -> None:
    """Points at F_x < 0 are not asked for; the map is symmetric to rounding; 45 such a grid takes."""
    seen: list[np.ndarray] = []

    def watched(points: np.ndarray) -> np.ndarray:
        seen.append(points)
        return sensor(points)

    found = sample(watched, NAMES, BOX, tolerance=1e-3, mirror=Mirror((-1, 1), (1, 0), (1, 1)))
    asked = np.vstack(seen)
    assert np.all(asked[:, 0] >= 0.0) and len(asked) == found.solves <= 18 and worst(found.map) < 1e-3
    p = np.random.default_rng(1).uniform(*BOX, (20, 2))
    np.testing.assert_allclose(found.map.at(p * [-1, 1])[:, ::-1], found.map.at(p), atol=1e-12)


def test_points_go_where_the_map_bends() -> None:
    """A front at F_x = 0.6: half of the points go to the two fifths of the box around it, and the error falls."""

    def front(points: np.ndarray) -> np.ndarray:
        x, z = points.T
        return np.stack([np.tanh(4.0 * (x - 0.6)) + 0.1 * z, x], -1)

    found = sample(front, NAMES, BOX, tolerance=5e-3, most=40)
    errors = [error for _, error in found.history]
    assert np.mean(np.abs(found.points[16:, 0] - 0.6) < 0.4) > 0.45
    assert min(errors[-3:]) < 0.6 * max(errors[:3])


@pytest.mark.parametrize("seed", range(3))
def test_rounding_does_not_choose_the_points(seed: int) -> None:
    """A function that its own mirror image, asked without saying so: last digits do not move the points."""
    rng = np.random.default_rng(seed)
    shaken = sample(lambda p: sensor(p) * (1.0 + 4e-16 * rng.standard_normal((len(p), 2))), NAMES, BOX, tolerance=1e-3)
    np.testing.assert_array_equal(shaken.points, sample(sensor, NAMES, BOX, tolerance=1e-3).points)


def test_not_reached_is_said() -> None:
    """A kink is not smooth: the points run out and the error is reported as it is."""
    found = sample(lambda p: np.abs(p[:, :1] - 0.21) + p, NAMES, BOX, tolerance=1e-6, most=30)
    assert not found.reached and found.error > 1e-6 and found.solves <= 30


def test_failed_points_are_left_out() -> None:
    """A corner without a solution: no value there, asked once, the rest holds."""

    def cornered(points: np.ndarray) -> np.ndarray:
        values = sensor(points)
        values[(points[:, 0] > 0.9) & (points[:, 1] > 3.5)] = np.nan
        return values

    found = sample(cornered, NAMES, BOX, tolerance=1e-3)
    assert len(found.failed) >= 1 and found.reached and found.solves == len(found.points) + len(found.failed)
    assert len(np.unique(np.vstack([found.points, found.failed]), axis=0)) == found.solves
    left = found.points[found.points[:, 0] < 0.5]
    np.testing.assert_allclose(found.map.at(left), sensor(left), atol=1e-3)


def test_the_same_map_on_a_regular_grid() -> None:
    """What it replaces: the regular grid of as many points is no better at its worst."""
    found = sample(sensor, NAMES, BOX, tolerance=1e-3)
    side = int(np.sqrt(found.solves))
    axes = np.linspace(-1.0, 1.0, side), np.linspace(0.0, 4.0, side)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 2)
    assert worst(found.map) < 2.0 * worst(fit_map(NAMES, grid, sensor(grid)))


def test_what_cannot_be_sampled_is_refused() -> None:
    """An empty box, a tolerance of none, a mirror that the box has not."""
    with pytest.raises(ValueError, match="box and tolerance: must be low < high and positive"):
        sample(sensor, NAMES, ((1.0, 0.0), (1.0, 4.0)))
    with pytest.raises(ValueError, match="box and tolerance"):
        sample(sensor, NAMES, BOX, tolerance=0.0)
    with pytest.raises(ValueError, match="box: must be its own mirror image"):
        sample(sensor, NAMES, ((-1.0, 0.0), (2.0, 4.0)), mirror=Mirror((-1, 1), (1, 0), (1, 1)))
