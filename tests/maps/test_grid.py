"""Grids of any dimension: solved at some of their points where those predict the others, whole where they do not."""

import itertools

import numpy as np
import pytest
from scipy.interpolate import RectBivariateSpline

from sits_mech.maps.grid import coarser, interpolated, solve_part

NINE = np.linspace(-1.0, 1.0, 9).tolist()


def points_of(axes: dict[str, list[float]]) -> np.ndarray:
    """All points of a grid, shape (*sizes, d)."""
    return np.stack(np.meshgrid(*axes.values(), indexing="ij"), -1)


def gentle(points: np.ndarray) -> np.ndarray:
    """Two outputs of any number of variables, analytic, no polynomials."""
    slopes = np.array([0.5, -0.3, 0.2, 0.4])[: points.shape[-1]]
    return np.stack([np.exp(points @ slopes), np.sin(points @ slopes[::-1])], -1)


@pytest.mark.parametrize(
    ("sizes", "solved"), [((9, 9), 25), ((9, 9, 9), 125), ((9, 9, 6), 150), ((1, 9, 9), 25), ((3, 9, 2, 9), 150)]
)
def test_a_smooth_function_is_solved_at_every_second_value(sizes: tuple[int, ...], solved: int) -> None:
    """In two to four variables, of which short ones keep their values: all is within the stated error of the truth."""
    axes = {f"x{k}": np.linspace(-1.0, 1.0, size).tolist() if size > 1 else [0.3] for k, size in enumerate(sizes)}
    asked: list[int] = []

    def solve(part: dict[str, list[float]]) -> np.ndarray:
        asked.append(points_of(part)[..., 0].size)
        return gentle(points_of(part))

    found = solve_part(solve, axes, tolerance=1e-2)
    assert found is not None and asked == [solved]
    off = np.abs(interpolated(found.axes, found.values, axes) - gentle(points_of(axes)))
    assert np.all(off.reshape(-1, 2).max(axis=0) <= found.error) and np.max(found.error) < 2e-2
    known = points_of(found.axes).reshape(-1, len(sizes)).tolist()
    whole = points_of(axes).reshape(-1, len(sizes)).tolist()
    again = interpolated(found.axes, found.values, axes).reshape(-1, 2)[[whole.index(point) for point in known]]
    np.testing.assert_allclose(again, found.values.reshape(-1, 2), atol=1e-14)


def test_finer_parts_where_it_bends() -> None:
    """A front needs nine values of seventeen, a kink all of them; each part holds the one before."""
    axes = {"x": np.linspace(-1.0, 1.0, 17).tolist(), "y": np.linspace(-1.0, 1.0, 17).tolist()}
    parts = list(coarser(axes))
    assert [len(part["x"]) for part in parts] == [5, 9] and set(parts[0]["x"]) < set(parts[1]["x"]) < set(axes["x"])
    front = solve_part(lambda part: np.tanh(2.5 * points_of(part)[..., :1]), axes, tolerance=5e-2)
    assert front is not None and len(front.axes["x"]) == 9
    assert solve_part(lambda part: np.abs(points_of(part)[..., :1] - 0.21), axes, tolerance=1e-2) is None


def test_nothing_is_put_beside_a_failed_point() -> None:
    """NaN at one solved point: the grid is to be solved whole."""

    def cornered(part: dict[str, list[float]]) -> np.ndarray:
        values = gentle(points_of(part))
        values[-1, -1] = np.nan
        return values

    assert solve_part(cornered, {"x": NINE, "y": NINE}, tolerance=1e-2) is None


@pytest.mark.parametrize("sizes", [(6, 9), (9, 1), (9,), (6, 6, 9)])
def test_small_grids_are_solved_whole(sizes: tuple[int, ...]) -> None:
    """With fewer than two variables of seven values there is little to save."""
    axes = {f"x{k}": NINE[:size] for k, size in enumerate(sizes)}
    assert list(coarser(axes)) == [] and solve_part(lambda part: gentle(points_of(part)), axes, tolerance=1e-2) is None


def test_what_varies_little_has_no_say() -> None:
    """An output that scatters by 1e-6 of the other's range neither raises the degrees nor stops the map."""
    scatter = np.random.default_rng(1)
    axes = {"x": NINE, "y": NINE, "z": NINE[::4]}

    def solve(part: dict[str, list[float]]) -> np.ndarray:
        points = points_of(part)
        own = gentle(points)[..., :1]
        return np.concatenate([own, 1e-6 * scatter.standard_normal(own.shape)], -1)

    found = solve_part(solve, axes, tolerance=1e-2)
    plain = solve_part(lambda part: gentle(points_of(part))[..., :1], axes, tolerance=1e-2)
    assert found is not None and plain is not None
    assert found.error[0] == pytest.approx(plain.error[0], rel=1e-6) and found.error[1] < 2e-5


def test_an_output_counts_by_its_weight() -> None:
    """A kink in an angle matters by its lever."""

    def solve(part: dict[str, list[float]]) -> np.ndarray:
        points = points_of(part)
        return np.stack([points[..., 0], np.abs(points[..., 0] - 0.2)], -1)

    axes = {"x": NINE, "y": NINE}
    assert solve_part(solve, axes, tolerance=1e-2) is None
    assert solve_part(solve, axes, tolerance=1e-2, weights=[1.0, 1e-2]) is not None


def test_splines_are_those_of_two_variables() -> None:
    """As FITPACK's interpolating surface, to rounding; of few values lines and parabolas."""
    some = {"x": NINE[::2], "y": [0.0, 0.5, 1.5, 3.0, 4.0]}
    axes = {"x": NINE, "y": np.linspace(0.0, 4.0, 17).tolist()}
    values = gentle(points_of(some))
    found = interpolated(some, values, axes)
    for k in (0, 1):
        surface = RectBivariateSpline(some["x"], some["y"], values[..., k])(axes["x"], axes["y"])
        np.testing.assert_allclose(found[..., k], surface, rtol=0.0, atol=1e-13)
    straight = interpolated(some, values, axes, degree=1)
    np.testing.assert_allclose(straight[1, 0], 0.5 * (values[0, 0] + values[1, 0]), rtol=1e-14)
    few = {"x": [0.0, 2.0], "y": [0.0, 1.0, 2.0]}
    more = {"x": [0.0, 1.0, 2.0], "y": [0.0, 0.5, 1.0, 2.0]}
    bent = np.array([[x + y**2 for y in few["y"]] for x in few["x"]])
    expected = [[x + y**2 for y in more["y"]] for x in more["x"]]
    np.testing.assert_allclose(interpolated(few, bent, more), expected, atol=1e-14)


def test_parts_of_a_mirrored_list_are_mirrored() -> None:
    """Whatever its length, ends included."""
    for count, other in itertools.product((7, 8, 11, 12, 20), (9, 40)):
        axes = {"x": np.linspace(-1.0, 1.0, count).tolist(), "y": np.linspace(0.0, 1.0, other).tolist()}
        for part in coarser(axes):
            np.testing.assert_allclose(part["x"], -np.array(part["x"])[::-1], atol=1e-15)
            assert part["x"][0] == -1.0 and part["y"][-1] == 1.0
