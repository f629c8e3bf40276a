"""Tracks of rectangles and free paths: lengths, sections, rings that stand for them, what has no section."""

import math
from typing import Any

import numpy as np
import pytest

from sits_mech.geometry.tracks import (
    coil_bars,
    coil_lines,
    coil_tracks,
    path_notes,
    ring_squares,
    section_refusal,
    standing_rings,
    track_length,
    track_squares,
)
from sits_mech.geometry.windings import coil_sections
from sits_mech.notes import NoteKind
from sits_mech.scene.parts.coils import Coil

MM = 1e-3
TRACK: dict[str, Any] = {"name": "C", "track_width": 0.1 * MM, "track_thickness": 35e-6}
WOUND = TRACK | {"centre": (1 * MM, 0.0), "layers": 2, "turns": 4, "track_gap": 0.1 * MM, "layer_pitch": 85e-6}
CIRCLE = Coil(**WOUND, inner_diameter=2 * MM)
SQUARE = Coil(**WOUND, shape="rectangle", inner_width=2 * MM, inner_length=3 * MM)
Z = -17.5e-6


def path(*lines: list[tuple[float, float]], **keys: Any) -> Coil:
    """Return a coil of free tracks in one layer [mm]."""
    points = tuple(tuple((x * MM, y * MM, Z) for x, y in line) for line in lines)
    return Coil(**TRACK | {"shape": "path", "path": points} | keys)


def test_length_of_sharp_and_round_corners() -> None:
    """Sides of 2.1 and 3.1 mm and every 0.2 mm more; an arc takes (2 - pi/2) r of each corner."""
    sides = 2 * sum(2.1 + 3.1 + 2 * 0.4 * k for k in range(4)) * MM
    assert track_length(SQUARE) == pytest.approx(2 * sides, rel=1e-12)
    rounded = SQUARE.model_copy(update={"corner_radius": 0.5 * MM})
    radii = sum(0.5 + 0.2 * k for k in range(4)) * MM
    assert track_length(rounded) == pytest.approx(2 * (sides - (8 - 2 * math.pi) * radii), rel=1e-3)


def test_turns_are_closed_and_counter_clockwise() -> None:
    """As seen from above; the other way where the scene says so."""
    for coil, signs in ((SQUARE, (1, 1)), (SQUARE.model_copy(update={"directions": (1, -1)}), (1, -1))):
        for k, (line, width) in enumerate(coil_lines(coil)):
            x, y = (line[:, :2] - coil.centre).T
            assert np.array_equal(line[0], line[-1]) and width == 0.1 * MM
            area = 0.5 * (x[:-1] * y[1:] - y[:-1] * x[1:]).sum()
            inner, outer = 2 * MM + 0.1 * MM + 0.4 * MM * (k % 4), 3 * MM + 0.1 * MM + 0.4 * MM * (k % 4)
            assert area == pytest.approx(signs[k // 4] * inner * outer, rel=1e-12)


@pytest.mark.parametrize("n, shape", [(6, "hexagon"), (8, "octagon")])
def test_turns_of_polygons(n: int, shape: str) -> None:
    """Sides of 2 r tan(pi / n), closed, counter-clockwise; two of them across the x axis."""
    coil = Coil(**WOUND, shape=shape, inner_diameter=2 * MM)
    radii = [1.05 * MM + 0.2 * MM * k for k in range(4)]
    assert track_length(coil) == pytest.approx(2 * sum(2 * n * r * math.tan(math.pi / n) for r in radii), rel=1e-12)
    for k, (line, _) in enumerate(coil_lines(coil)):
        x, y = (line[:, :2] - coil.centre).T
        area = 0.5 * (x[:-1] * y[1:] - y[:-1] * x[1:]).sum()
        assert np.array_equal(line[0], line[-1]) and area == pytest.approx(n * radii[k % 4]**2 * math.tan(math.pi / n))
    assert section_refusal([coil]) is None
    np.testing.assert_allclose(np.sort(np.abs(coil_bars(coil).x - 1 * MM)), np.sort(np.tile(radii, 4)), rtol=1e-9)


def test_turns_of_a_d() -> None:
    """A rectangle of 0.5 x 3 mm before half a disc of 3 mm, and 0.05 mm and more around both."""
    coil = Coil(**WOUND, shape="D", inner_width=2 * MM, inner_length=3 * MM)
    for k, (line, _) in enumerate(coil_lines(coil)):
        a, b = 1 * MM + 0.05 * MM + 0.2 * MM * (k % 4), 1.5 * MM + 0.05 * MM + 0.2 * MM * (k % 4)
        x, y = (line[:, :2] - coil.centre).T
        area = 0.5 * (x[:-1] * y[1:] - y[:-1] * x[1:]).sum()
        assert area == pytest.approx((2 * a - b) * 2 * b + np.pi / 2 * b**2, rel=1e-3)
        assert (x.min(), y.max(), x.max()) == pytest.approx((-a, b, a), abs=1.5e-3 * b)
    assert section_refusal([coil]) is None


def test_rings_are_polygons_of_their_area() -> None:
    """Where they are taken as straight tracks."""
    line = coil_lines(CIRCLE)[0][0][:, :2] - CIRCLE.centre
    area = 0.5 * (line[:-1, 0] * line[1:, 1] - line[:-1, 1] * line[1:, 0]).sum()
    assert area == pytest.approx(math.pi * (1.05 * MM) ** 2, rel=1e-12)


def test_section_of_a_rectangle_is_that_of_a_circle() -> None:
    """Of the same inner width: same bars, same signs."""
    ours, theirs = coil_bars(SQUARE), coil_bars(CIRCLE)
    first, second = (sorted(zip(np.round(b.x, 12), b.z, b.sign, strict=True)) for b in (ours, theirs))
    np.testing.assert_allclose(first, second, atol=1e-15)
    assert (ours.width, ours.thickness) == (theirs.width, theirs.thickness)


def test_section_of_layers_wound_against_each_other() -> None:
    """The lower layer's signs turn around, of either shape."""
    for coil in (SQUARE, CIRCLE):
        bars = coil_bars(coil.model_copy(update={"directions": (1, -1)}))
        right, upper = bars.x > coil.centre[0], bars.z == coil.heights[0]
        assert np.array_equal(bars.sign, np.where(right == upper, 1.0, -1.0))


def test_what_free_tracks_are_without() -> None:
    """A via of 3 mm along x between two polylines, 6 mm from the end back to the beginning."""
    coil = path([(0, 0), (4, 0)], [(7, 0), (7, 1), (5, 1), (5, 0.5), (6, 0.5), (6, 0)])
    (note,) = path_notes([SQUARE, coil])
    assert note.kind is NoteKind.FREE_TRACKS
    assert note.known == {"coil": "C", "vias": pytest.approx(3 * MM), "back": pytest.approx(6 * MM)}


def test_section_of_a_path() -> None:
    """Up at x = 2 mm, down at x = 0."""
    bars = coil_bars(path([(0, -1), (2, -1), (2, 1), (0, 1), (0, -0.5)]))
    assert bars.x == pytest.approx([2 * MM, 0.0], abs=1e-15) and bars.sign == pytest.approx([1.0, -1.0])


@pytest.mark.parametrize(
    ("coil", "reason"),
    [
        (path([(0, -1), (2, -1), (2.4, 1), (0, 1), (0, -0.5)]), "cross the section y = 0 at right angles"),
        (path([(0, -1), (2, -1), (2, 1)]), "as often there as back; got 1 and 0"),
        (path([(0, 1), (2, 1), (2, 3)]), "got 0 and 0"),
        (path([(0, -1), (2, -1), (2, 1)], [(2, 1), (0, 1), (0, -0.5)], path_widths=(1e-4, 2e-4)), "one width"),
        (CIRCLE.model_copy(update={"centre": (0.0, 1e-3)}), "centre must be on y = 0 .*; got y = 1 mm"),
        (CIRCLE.model_copy(update={"layers": 1000, "turns": 12}), "got 24000 bars, some 85.8 GiB, more"),
    ],
)
def test_coils_without_a_section_are_refused(coil: Coil, reason: str) -> None:
    """By name, in one line."""
    found = section_refusal([SQUARE, coil])
    assert found is not None and "\n" not in found
    with pytest.raises(ValueError, match=reason):
        raise ValueError(found)


def test_rings_that_stand_for_a_coil() -> None:
    """Round ones their own; of a rectangle and a spiral path the turns, the length and the pitch."""
    assert standing_rings(CIRCLE).radius == pytest.approx(coil_sections(CIRCLE).radius)
    rings = standing_rings(SQUARE)
    assert 2 * np.pi * rings.radius.sum() == pytest.approx(track_length(SQUARE), rel=1e-12)
    assert np.diff(rings.radius[:4]) == pytest.approx(np.full(3, 0.2 * MM))
    angle = np.linspace(0.0, 10 * np.pi, 301)
    x, y = (1.0 + 0.2 * angle / (2 * np.pi)) * np.array([np.cos(angle), np.sin(angle)])
    spiral = path(list(zip(x.tolist(), y.tolist(), strict=True)))
    rings = standing_rings(spiral)
    assert rings.radius.size == 5 and np.all(np.asarray(rings.sign) == 1.0)
    assert 2 * np.pi * rings.radius.sum() == pytest.approx(track_length(spiral), rel=1e-3)  # 4.996 turns about its box
    assert np.diff(rings.radius) == pytest.approx(np.full(4, 0.2 * MM), rel=0.05)
    clockwise = path(list(zip(x.tolist(), (-y).tolist(), strict=True)))
    assert np.all(np.asarray(standing_rings(clockwise).sign) == -1.0)


@pytest.mark.parametrize("pieces", [1, 2, 4])
def test_turns_in_pieces_are_the_turns_that_they_make(pieces: int) -> None:
    """Half and quarter turns on two layers in turn, and a way to the middle at the end, which is no turn."""
    lines = []
    for k, start in enumerate(np.arange(0.0, 6.0, 1.0 / pieces)):
        angle = 2 * np.pi * np.linspace(start, start + 1.0 / pieces, 61)
        radius = 2.0 + angle / np.pi / 6.0
        lines.append([(*(r * np.array([np.cos(a), np.sin(a)])).tolist(), -0.1 - 0.2 * (k % 2))
                      for r, a in zip(radius, angle, strict=True)])
    lines.append([(*lines[-1][-1][:2], -0.5), (0.1, 0.0, -0.5)])
    coil = Coil(name="P", shape="path", centre=(0.0, 0.0), track_width=0.1 * MM, track_thickness=35e-6,
                path=tuple(tuple(tuple(MM * x for x in place) for place in line) for line in lines))
    rings = standing_rings(coil)
    assert rings.radius.size == 6 and np.all(np.asarray(rings.sign) == 1.0)
    assert np.unique(rings.z).size == 2
    assert rings.radius.mean() == pytest.approx(3 * MM, rel=0.02)


def test_turns_in_waves_are_rings_in_their_middle() -> None:
    """Of 4 % in 48 waves a turn, they are nearly twice as long as the turns that they make."""
    angle = np.linspace(0.0, 16.0 * np.pi, 4001)
    radius = (2.0 + 0.2 * angle / (2 * np.pi)) * (1.0 + 0.04 * np.cos(48 * angle))
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    rings = standing_rings(path(list(zip(x.tolist(), y.tolist(), strict=True))))
    assert rings.radius.size == 8 and rings.radius.mean() == pytest.approx(2.8 * MM, rel=0.01)
    assert np.diff(rings.radius) == pytest.approx(np.full(7, 0.2 * MM), rel=0.05)


def test_a_meander_has_one_ring_around_it() -> None:
    """It turns about nothing."""
    rings = standing_rings(path([(0, 0), (5, 0), (5, 0.5), (0, 0.5), (0, 1), (5, 1)]))
    assert rings.radius.size == 1 and rings.radius[0] < 3 * MM


def test_a_line_through_the_middle_is_no_turn() -> None:
    """It turns by a half about the middle, at no distance: a ring of no radius stood for it."""
    rings = standing_rings(path([(-2, -1), (2, 1)]))
    assert rings.radius.size == 1 and rings.radius[0] > 1 * MM


def test_a_turn_narrower_than_its_track_stands_for_one_that_has_a_hole() -> None:
    """Of a track 0.1 mm wide around a square of 0.02 mm: rings are no smaller than those of a square around a point."""
    line = path([(0.01, -0.01), (0.01, 0.01), (-0.01, 0.01), (-0.01, -0.01), (0.01, -0.01)])
    rings = standing_rings(line)
    assert rings.radius == pytest.approx([2.0 * line.track_width / np.pi])
    assert np.all(ring_squares(rings.radius, rings.width) > 0.0)


def test_squares_along_tracks() -> None:
    """Each stretch with its own width."""
    coil = path([(0, 0), (4, 0)], [(4, 0), (4, 2)], path_widths=(1e-4, 2e-4))
    assert track_squares(coil) == pytest.approx(40.0 + 10.0, rel=1e-12)


def test_moved_tracks_keep_their_lengths() -> None:
    """Both ends by the same way, along x and y alone."""
    tracks = coil_tracks(SQUARE)
    moved = tracks.moved(1 * MM, -2 * MM)
    for before, after in ((tracks.start, moved.start), (tracks.end, moved.end)):
        np.testing.assert_allclose(after - before, np.tile([1 * MM, -2 * MM, 0.0], (len(before), 1)), atol=1e-15)


def test_strands_share_the_width() -> None:
    """Two Gauss filaments at w / sqrt(12) to each side, half the current each."""
    across = np.array([-1.0, 1.0]) / math.sqrt(3), np.array([0.5, 0.5])
    (left, a), (right, b) = coil_tracks(SQUARE).strands(across, (np.zeros(1), np.ones(1)))
    assert a == b == 0.5
    apart = np.linalg.norm(left.start - right.start, axis=1)  # of corners, along their diagonals
    assert apart == pytest.approx(np.full(len(apart), 0.1 * MM / math.sqrt(3) * math.sqrt(2)), rel=1e-12)
