"""Joints: what meets, by places alone, on boards drawn with more or less care."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sits_mech.boards.copper import Track
from sits_mech.boards.joints import Joints, connections
from sits_mech.boards.kicad import read_board
from sits_mech.boards.lines import flattened, thinned
from sits_mech.units import SceneError


def net(draw: Any, items: list[str], nearness: float = 1e-6, four: bool = False) -> Joints:
    """Return the joints of all that is drawn."""
    board = read_board(draw.board(items, four=four))
    return connections(board.tracks, board.holes, nearness)


def degrees(joints: Joints) -> list[int]:
    """Return how many ends meet at each joint, in order of size."""
    return sorted(len(ends) for ends in joints.meeting().values())


def test_ends_within_rounding_are_one(draw: Any) -> None:
    """0.9 um apart they are, on one layer; a via joins layers, only those that it is on."""
    assert degrees(net(draw, [draw.line((0, 0), (1, 0)), draw.line((1.0009, 0), (2, 0))])) == [1, 1, 2]
    two = [draw.line((0, 0), (1, 0)), draw.line((1, 0), (2, 0), "B.Cu")]
    assert degrees(net(draw, two)) == [1, 1, 1, 1]
    assert degrees(net(draw, [*two, draw.via((1, 0))])) == [1, 1, 2]
    inner = [draw.line((0, 0), (1, 0)), draw.line((1, 0), (2, 0), "In2.Cu")]
    for layers, expected in (('"F.Cu" "In1.Cu"', [1, 1, 1, 1]), ('"F.Cu" "In2.Cu"', [1, 1, 2])):
        assert degrees(net(draw, [*inner, draw.via((1, 0), layers, kind="blind")], four=True)) == expected
    stacked = [draw.via((1, 0), '"F.Cu" "In1.Cu"', kind="micro"), draw.via((1, 0), '"In1.Cu" "In2.Cu"', kind="blind")]
    assert degrees(net(draw, [*inner, *stacked], four=True)) == [1, 1, 2]


def test_loose_ends_meet_in_copper(draw: Any) -> None:
    """In the ring of a via, or overlapping another loose end by half a width; beyond that they do not."""
    via = draw.via((1.2, 0.1))
    assert degrees(net(draw, [draw.line((0, 0), (1, 0)), draw.line((1.3, 0), (2, 0), "B.Cu"), via])) == [1, 1, 2]
    assert degrees(net(draw, [draw.line((0, 0), (0.8, 0)), draw.line((1.3, 0), (2, 0), "B.Cu"), via])) == [1, 1, 1, 1]
    for gap, expected in ((0.099, [1, 1, 2]), (0.101, [1, 1, 1, 1])):
        assert degrees(net(draw, [draw.line((0, 0), (1, 0)), draw.line((1 + gap, 0), (2, 0))])) == expected


def test_what_careless_drawing_leaves_does_not_count(draw: Any) -> None:
    """Doubles, tracks of no length, overshoots within a via or a joint: of eleven tracks, four are the path."""
    path = [draw.line((0, 0), (1, 0)), draw.line((1, 0), (2, 0), "B.Cu"), draw.via((1, 0))]
    dirt = [
        draw.line((1, 0), (0, 0)),  # the first one again, backwards
        draw.line((0.5, 0.5), (0.5, 0.5)),
        draw.line((1, 0), (1.0028, 0), "B.Cu"),  # past the via, seen on a published antenna
        draw.line((0.9, 0.1), (1.1, 0.1)),  # begins and ends in the via
        *draw.lines([(0, 0), (-1, -1), (-2, 0)]), draw.line((-1, -1), (-1.09, -1)),  # past a corner, within its copper
        draw.line((2, 0), (2.0002, 0), "B.Cu"),
        draw.line((2, 0), (2.0002, 0), "B.Cu"),
    ]
    found = net(draw, [*path, *dirt])
    assert len(found.tracks) == 4 and degrees(found) == [1, 1, 2, 2, 2]
    np.testing.assert_allclose(found.tracks[0].points, [[0, 0], [1e-3, 0]], atol=1e-12)


def test_arcs_between_the_same_ends_are_two(draw: Any) -> None:
    """Two half circles are a loop, the same arc twice is one."""
    over, under = (draw.arc((0, 0), (1, sign), (2, 0)) for sign in (-1, 1))
    assert degrees(net(draw, [over, under])) == [2, 2] and degrees(net(draw, [over, over])) == [1, 1]


def test_pads_with_a_number_end_the_path(draw: Any) -> None:
    """Three tracks in one pad are three ends with that pad; a pad without number is passed through."""
    star = [draw.line((0, 0), (1, 0)), draw.line((1.2, 0.1), (2, 0)), draw.line((1, -0.3), (1, 2))]
    found = net(draw, [*star, draw.pad("7", (1, 0))])
    holes = [found.hole(number) for number, ends in found.meeting().items() if len(ends) == 1]
    assert degrees(found) == [1] * 6 and [hole.name for hole in holes if hole] == ["J1.7"] * 3
    assert degrees(net(draw, [*star[:2], draw.pad("", (1, 0))])) == [1, 1, 2]


def test_a_pad_between_the_lines_of_its_footprint_is_a_via(draw: Any) -> None:
    """With a number or not; one that joins lines of one layer ends the path."""
    for layer, expected in (("B.Cu", [1, 1, 2]), ("F.Cu", [1, 1, 1, 1])):
        drawn = [
            f'(fp_line (start {a} 0) (end {b} 0) (stroke (width 0.2) (type solid)) (layer "{name}"))'
            for a, b, name in ((0, 5, "F.Cu"), (5, 9, layer))
        ]
        hole = '(pad "3" thru_hole circle (at 5 0) (size 0.6 0.6) (drill 0.3) (layers "*.Cu"))'
        head = '(footprint "x" (layer "F.Cu") (at 0 0) (fp_text reference "L1")'
        assert degrees(net(draw, [f"{head} {' '.join(drawn)} {hole})"])) == expected


def test_nearness_joins_more(draw: Any) -> None:
    """Ends 8 um apart of a parallel pair, too."""
    items = [draw.line((0, 0), (1, 0)), draw.line((1, 0.008), (2, 0)), draw.line((1, 0.004), (1, 3))]
    assert degrees(net(draw, items, 1e-5)) == [1, 1, 1, 3]


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
