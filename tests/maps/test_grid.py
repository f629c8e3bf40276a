"""Grids of any dimension: solved at some of their points where those predict the others, whole where they do not."""

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from scipy.interpolate import RectBivariateSpline

from sits_mech.maps.grid import SolvedPart, interpolated, likely_part, solve_part

Axes = dict[str, list[float]]
Function = Callable[[np.ndarray], np.ndarray]


def points_of(axes: Axes) -> np.ndarray:
    """All points of a grid, shape (*sizes, d)."""
    return np.stack(np.meshgrid(*axes.values(), indexing="ij"), -1)


def box(*sizes: int) -> Axes:
    """A grid from -1 to 1 in each variable; of one value 0.3."""
    return {f"x{k}": np.linspace(-1.0, 1.0, size).tolist() if size > 1 else [0.3] for k, size in enumerate(sizes)}


def gentle(points: np.ndarray) -> np.ndarray:
    """Two outputs of any number of variables, analytic, no polynomials."""
    slopes = np.array([0.5, -0.3, 0.2, 0.4, 0.1, -0.4])[: points.shape[-1]]
    return np.stack([np.exp(points @ slopes), np.sin(points @ slopes[::-1])], -1)


def solved(
    function: Function, axes: Axes, tolerance: float = 1e-2, *, asked_of: Callable[[], float] | None = None,
    **more: object,
) -> SolvedPart | None:
    """Solve a part of a grid; every point is asked for at most once, and the part holds what the function gave."""
    asked: list[tuple[float, ...]] = []

    def solve(points: list[tuple[float, ...]]) -> np.ndarray:
        asked.extend(points)
        return function(np.array(points))

    found = solve_part(solve, axes, tolerance=asked_of or (lambda: tolerance), **more)  # type: ignore[arg-type]
    assert len(set(asked)) == len(asked)
    if found is not None:
        known = ~np.isnan(found.values[..., 0])
        assert np.count_nonzero(known) == len(asked)
        np.testing.assert_array_equal(found.values[known], function(points_of(axes)[known]))
    return found


def count(part: SolvedPart | None) -> int:
    """How many points are solved."""
    assert part is not None
    return int(np.count_nonzero(~np.isnan(part.values[..., 0])))


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3])
@pytest.mark.parametrize(
    ("sizes", "most"),
    [((40,), 0.4), ((9, 9), 0.4), ((5, 5, 5), 0.7), ((9, 9, 9), 0.13), ((3, 9, 2, 9), 0.4), ((5, 5, 5, 5, 1), 0.5)],
)
def test_a_smooth_function_is_solved_at_a_part_of_its_points(
    sizes: tuple[int, ...], most: float, tolerance: float
) -> None:
    """In one to four variables: all is within the stated error of the truth, and that within the tolerance."""
    axes = box(*sizes)
    found = solved(gentle, axes, tolerance)
    assert found is not None and count(found) < most * np.prod(sizes)
    truth = gentle(points_of(axes))
    off = np.abs(interpolated(found, found.values) - truth)
    assert np.all(off.reshape(-1, 2).max(axis=0) <= found.error)
    assert np.all(found.error <= tolerance * np.ptp(truth.reshape(-1, 2), axis=0))
    known = ~np.isnan(found.values[..., 0])
    np.testing.assert_allclose(interpolated(found, found.values)[known], found.values[known], atol=1e-14)


def test_on_solved_lines_the_error_is_of_what_is_left_along_them() -> None:
    """At no solved point there is one, at each other one it holds the truth, and most of them are far less."""
    axes = box(17, 17)
    found = solved(lambda points: np.exp(points @ [1.5, 0.4])[..., None], axes)
    assert found is not None
    off = np.abs(interpolated(found, found.values) - np.exp(points_of(axes) @ [1.5, 0.4])[..., None])
    known = ~np.isnan(found.values)
    assert np.all(found.error_at[known] == 0.0) and np.all(off <= found.error_at + 1e-14)
    assert found.error_at.max() == found.error[0] > 3.0 * found.error_at[8][~known[8]].max()


def test_figures_of_outputs_are_within_the_tolerance_as_well() -> None:
    """A figure that hangs on a small output alone: more points, until what its error makes of the figure is small."""
    axes = box(9, 9)

    def outputs(points: np.ndarray) -> np.ndarray:
        return np.stack([np.exp(points @ [0.5, -0.3]), 0.02 * np.sin(points @ [0.9, 1.3])], -1)

    goal = np.array([[0.0, 1.0 / np.ptp(outputs(points_of(axes))[..., 1])]])
    without, found = solved(outputs, axes), solved(outputs, axes, goal=goal)
    assert without is not None and found is not None
    assert goal @ without.error > 1e-2 >= goal @ found.error and count(found) > count(without)
    off = np.abs(interpolated(found, found.values) - outputs(points_of(axes))).reshape(-1, 2).max(axis=0)
    assert np.all(off <= found.error)


def test_beside_a_limit_fewer_points_suffice() -> None:
    """Each is on its side of it: what map and error leave open is solved; of a constant next to nothing."""
    axes = box(33, 33)

    def bent(points: np.ndarray) -> np.ndarray:
        return np.tanh(2.0 * points[..., :1] + points[..., 1:2] ** 2)

    truth = bent(points_of(axes))
    everywhere = solved(bent, axes, 1e-4)
    for limit in (0.0, 0.7, 2.0):
        found = solved(bent, axes, 1e-4, limit=limit)
        assert found is not None and count(found) < 0.9 * count(everywhere)
        whole = np.where(np.isnan(found.values), interpolated(found, found.values), found.values)
        np.testing.assert_array_equal(whole > limit, truth > limit)
        between = np.isnan(found.values)
        assert np.all(np.abs(whole - limit)[between] > found.error)
        assert np.all(np.abs(interpolated(found, found.values) - truth) <= found.error)
    assert count(solved(lambda points: np.ones_like(points[..., :1]), axes)) < 20


def test_many_variables_need_few_points() -> None:
    """Of six variables of five values: some hundreds of 15625 points, not a power of six."""
    axes = box(5, 5, 5, 5, 5, 5)
    found = solved(lambda points: gentle(points)[..., :1], axes)
    assert found is not None and count(found) < 900
    off = np.abs(interpolated(found, found.values) - gentle(points_of(axes))[..., :1])
    assert off.max() <= found.error[0]


@pytest.mark.parametrize(
    "bent",
    [
        lambda points: np.tanh(2.5 * points[..., :1]),
        lambda points: np.tanh(2.0 * (points[..., :1] + points[..., 1:2])),
        lambda points: np.maximum(np.abs(points[..., :1]) - 0.4, 0.0) + 0.1 * points[..., 1:2],
    ],
    ids=["front", "oblique front", "kinks"],
)
def test_more_points_where_it_bends(bent: Function) -> None:
    """As many along each variable as it takes: a front, an oblique one, a kink at no point of the grid."""
    axes = box(17, 17)
    smooth, found = solved(gentle, axes), solved(bent, axes)
    assert found is not None and count(found) > count(smooth)
    assert np.abs(interpolated(found, found.values) - bent(points_of(axes))).max() <= found.error[0] + 1e-12


def test_what_is_odd_bends_beside_zero() -> None:
    """An output that vanishes with one variable, or with either of two, shows its curvature in the last beside zero."""

    def odd(points: np.ndarray) -> np.ndarray:
        x, y, z = points[..., 0], points[..., 1], points[..., -1]
        return np.stack([x / (1.3 + z), y * np.exp(-0.7 * z) + 0.3 * x * y / (1.6 + z)], -1)

    for axes in (box(9, 1, 9), box(9, 5, 9)):
        found = solved(odd, axes)
        assert found is not None
        off = np.abs(interpolated(found, found.values) - odd(points_of(axes)))
        assert np.all(off.reshape(-1, 2).max(axis=0) <= found.error)


def test_levels_are_nested_and_mirror_themselves() -> None:
    """Whatever the length of a mirrored list, with every solved point its mirror image is; ends included."""
    for size, other in itertools.product((5, 6, 7, 8, 11, 12, 20), (9, 40)):
        axes = {"x": np.linspace(-1.0, 1.0, size).tolist(), "y": np.linspace(0.0, 1.0, other).tolist()}
        found = solved(lambda points: np.tanh(3.0 * points[..., :1] + points[..., 1:]), axes, 3e-2)
        assert found is not None
        known = ~np.isnan(found.values[..., 0])
        np.testing.assert_array_equal(known, known[::-1])
        assert known[0, 0] and known[-1, -1]
        likely = likely_part(axes)
        assert sorted((round(-x, 9), y) for x, y in likely) == sorted((round(x, 9), y) for x, y in likely)
        assert len(likely) < known.size


def test_nothing_is_put_beside_a_failed_point() -> None:
    """NaN at one solved point: the grid is to be solved whole."""

    def cornered(points: np.ndarray) -> np.ndarray:
        return np.where(np.all(points == 1.0, axis=-1, keepdims=True), np.nan, gentle(points))

    assert solve_part(lambda points: cornered(np.array(points)), box(9, 9), tolerance=lambda: 1e-2) is None


@pytest.mark.parametrize("sizes", [(5, 5), (9, 1), (9,), (3, 3, 3), (2, 2, 2, 2, 2)])
def test_small_grids_are_solved_whole(sizes: tuple[int, ...]) -> None:
    """There is little to save."""
    axes = box(*sizes)
    assert solved(gentle, axes) is None and len(likely_part(axes)) == np.prod(sizes)


def test_what_varies_little_has_no_say() -> None:
    """An output that scatters by 1e-6 of the other's range asks for no more points; what it misses is said of it."""
    axes = box(9, 9, 3)

    def scattered(points: np.ndarray) -> np.ndarray:
        own = gentle(points)[..., :1]
        return np.concatenate([own, 1e-6 * np.sin(1e3 * points.sum(axis=-1, keepdims=True))], -1)

    found, plain = solved(scattered, axes), solved(lambda points: gentle(points)[..., :1], axes)
    assert found is not None and plain is not None and found.blocks == plain.blocks
    assert found.error[0] == pytest.approx(plain.error[0], rel=1e-12) and 1e-7 < found.error[1] < 1e-5


def test_an_output_counts_by_its_weight() -> None:
    """A kink in an angle matters by its lever."""

    def both(points: np.ndarray) -> np.ndarray:
        return np.stack([points[..., 0], np.abs(points[..., 0] - 0.2)], -1)

    plain, light = solved(both, box(17, 17)), solved(both, box(17, 17), weights=[1.0, 1e-2])
    assert count(light) < count(plain)


def test_a_full_product_has_the_splines_of_two_variables() -> None:
    """As FITPACK's interpolating surface of degree five, to rounding; or lines throughout; of few values parabolas."""
    axes = {"x": np.linspace(-1.0, 1.0, 17).tolist(), "y": np.linspace(0.0, 4.0, 17).tolist()}
    values = gentle(points_of(axes))
    blocks = tuple(itertools.product(range(4), range(5)))  # every second value of each
    part = SolvedPart(axes, blocks, values, np.zeros(2), {})
    found = interpolated(part, values)
    for k in (0, 1):
        surface = RectBivariateSpline(axes["x"][::2], axes["y"][::2], values[::2, ::2, k], kx=5, ky=5)
        np.testing.assert_allclose(found[..., k], surface(axes["x"], axes["y"]), rtol=0.0, atol=1e-13)
    straight = interpolated(part, values, degree=1)
    np.testing.assert_allclose(straight[1, 0], 0.5 * (values[0, 0] + values[2, 0]), rtol=1e-14)
    few = {"x": [0.0, 1.0, 2.0], "y": [0.0, 0.5, 1.0, 1.5, 2.0]}
    bent = points_of(few)[..., :1] + points_of(few)[..., 1:] ** 2
    lines = SolvedPart(few, tuple(itertools.product(range(2), range(3))), bent, np.zeros(1), {})
    np.testing.assert_allclose(interpolated(lines, bent), bent, atol=1e-14)


@pytest.mark.parametrize(("sizes", "whole"), [((4, 8), True), ((32,), True), ((3, 11), False), ((33,), False)])
def test_a_part_of_a_grid_begins_beyond_32_points(sizes: tuple[int, ...], whole: bool) -> None:
    """The smallest grid of which some points are left out has 33."""
    found = solved(gentle, box(*sizes), 3e-2)
    assert (found is None) is whole
    assert (len(likely_part(box(*sizes))) == int(np.prod(sizes))) is whole


def test_points_that_are_off_themselves_are_not_followed_closer_than_that() -> None:
    """A percent from point to point; how far they are off is asked for when some are solved."""
    asked = list[tuple[float, ...]]()

    def jumping(points: np.ndarray) -> np.ndarray:
        asked.extend(map(tuple, points))
        return gentle(points) * (1.0 + 0.01 * np.round(np.sin(7.0 * points.sum(axis=-1)))[..., None])

    whole, part = solved(jumping, box(9, 9)), solved(jumping, box(9, 9), asked_of=lambda: 0.04 * bool(asked))
    assert count(part) < 20 < count(whole)
