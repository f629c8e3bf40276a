"""Arcs: their chords hold the error that is asked, whatever the arc."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sits_mech.boards.arcs import flattened, thinned
from sits_mech.boards.kicad import Track
from sits_mech.units import SceneError


def arc(*points: tuple[float, float]) -> Track:
    """Return a track through points [m]."""
    return Track("F.Cu", np.array(points), 1e-4, "L1")


@settings(max_examples=50, deadline=None)
@given(
    st.floats(1e-4, 0.1), st.floats(-3.0, 3.0), st.floats(0.05, 6.2), st.sampled_from([1, -1]),
    st.sampled_from([1e-7, 1e-6, 2e-5]),
)
def test_chords_hold_the_error(r: float, first: float, theta: float, way: int, error: float) -> None:
    """All corners on the circle, all chords within the error and the last fewer would not be; length 2 r sin."""
    angles = first + way * theta * np.array([0.0, 0.4, 1.0])
    centre = np.array([0.12, -0.08])
    points = centre + r * np.column_stack([np.cos(angles), np.sin(angles)])
    found = flattened(arc(*map(tuple, points)), error, "net")
    np.testing.assert_array_equal(found[[0, -1]], points[[0, 2]])
    np.testing.assert_allclose(np.hypot(*(found - centre).T), r, rtol=1e-7)
    middles = (found[1:] + found[:-1]) / 2
    assert r - np.hypot(*(middles - centre).T).min() <= error * (1 + 1e-6) + 1e-12
    n = len(found) - 1
    assert np.hypot(*np.diff(found, axis=0).T).sum() == pytest.approx(2 * n * r * np.sin(theta / 2 / n), rel=1e-6)
    assert n == 1 or r * (1 - np.cos(theta / 2 / (n - 1))) > error * (1 - 1e-6)


def test_straight_tracks_and_straight_arcs() -> None:
    """A track of two points is as it was, an arc through three points in a line is the line."""
    two = np.array([[0.0, 0.0], [1e-3, 1e-3]])
    np.testing.assert_array_equal(flattened(arc((0.0, 0.0), (1e-3, 1e-3)), 1e-6, "net"), two)
    np.testing.assert_array_equal(flattened(arc((0.0, 0.0), (4e-4, 4e-4), (1e-3, 1e-3)), 1e-6, "net"), two)


@pytest.mark.parametrize(
    ("points", "expected"),
    [
        (((1e-3, 0.0),) * 3, "three equal points"),
        (((0.0, 0.0), (1e-3, 0.0), (0.0, 0.0)), "two equal points"),
        (((0.0, 0.0), (0.0, 0.0), (1e-3, 0.0)), "two equal points"),
        (((0.0, 0.0), (2e-3, 0.0), (1e-3, 0.0)), "must pass its middle between its ends"),
    ],
)
def test_arcs_that_are_none(points: tuple[tuple[float, float], ...], expected: str) -> None:
    """Of zero radius, or of any."""
    with pytest.raises(SceneError, match=expected):
        flattened(arc(*points), 1e-6, "net L1")


@pytest.mark.parametrize("error", [1e-6, 1e-5])
def test_corners_that_play_no_part_go(error: float) -> None:
    """Of 4000 corners on a circle of 5 mm, and a straight way out; all lie within the error of what stays."""
    angle = np.linspace(0.0, 2 * np.pi, 4001)
    circle = 5e-3 * np.column_stack([np.cos(angle), np.sin(angle)])
    points = np.vstack([circle, np.column_stack([np.linspace(5e-3, 9e-3, 50)[1:], np.zeros(49)])])
    found = thinned(points, error)
    least = np.pi / np.arccos(1.0 - error / 5e-3)
    assert least <= len(found) - 2 <= 2.1 * least
    a, b = found[:-1], found[1:]
    share = np.clip(((points[:, None] - a) * (b - a)).sum(-1) / ((b - a) ** 2).sum(-1), 0.0, 1.0)
    away = np.linalg.norm(points[:, None] - a - share[..., None] * (b - a), axis=-1).min(axis=1)
    assert away.max() <= error * (1 + 1e-9)
    np.testing.assert_array_equal(found[[0, -1]], points[[0, -1]])
    np.testing.assert_array_equal(thinned(points[:2], error), points[:2])
