"""Strips are tracks, ways are the longest there are."""

import numpy as np
import pytest
import shapely

from sits_mech.boards.lines import length_of, longest_way, spaced, strip
from sits_mech.quantities import Array


def rim(line: list[tuple[float, float]], width: float) -> Array:
    """Return the outline of a track with flat ends."""
    shape = shapely.LineString(line).buffer(width / 2, cap_style="flat", join_style="mitre")
    return np.array(shape.exterior.coords)[:-1]


@pytest.mark.parametrize("start", [0, 3, 7])
def test_a_strip_is_its_track(start: int) -> None:
    """A bent track of w = 0.3 mm, half of that apart from itself: 0.14 w shorter at each of four corners."""
    line = [(0.0, 0.0), (5e-3, 0.0), (5e-3, 4e-3), (0.45e-3, 4e-3), (0.45e-3, 0.45e-3), (4e-3, 0.45e-3)]
    found = strip(np.roll(rim(line, 0.3e-3), start, axis=0))
    assert found is not None and found[1] == pytest.approx(0.3e-3, rel=1e-3)
    assert length_of(found[0]) == pytest.approx(length_of(np.array(line)) - 4 * 0.14 * 0.3e-3, abs=0.02e-3)
    ends = sorted(map(tuple, found[0][[0, -1]].tolist()))
    np.testing.assert_allclose(ends, sorted([line[0], line[-1]]), atol=5e-6)


def test_other_polygons_are_none() -> None:
    """A square, a cross, a ring with a cut of no width, a bow tie."""
    cross = shapely.union(shapely.box(-5, -0.1, 5, 0.1), shapely.box(-0.1, -5, 0.1, 5)).exterior.coords
    for corners in ([(0, 0), (1, 0), (1, 1), (0, 1)], cross[:-1], [(0, 0), (1, 1), (1, 0), (0, 1)]):
        assert strip(np.array(corners, dtype=float)) is None


def test_the_longest_way() -> None:
    """Of a tree of arms 1, 2 and 3 it leads over the two longest; places apart do not count."""
    pairs = np.array([[0, 1], [0, 2], [0, 3], [4, 5]])
    assert longest_way(pairs, np.array([1.0, 2.0, 3.0, 9.0]), 6) in ([2, 0, 3], [3, 0, 2])


def test_points_are_spaced() -> None:
    """The ends stay, points nearer than asked to the one before do not."""
    line = np.array([[0.0, 0.0], [0.1, 0.0], [1.0, 0.0], [1.05, 0.0], [2.0, 0.0]])
    np.testing.assert_array_equal(spaced(line, 0.2)[:, 0], [0.0, 1.0, 2.0])
