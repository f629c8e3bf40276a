"""Plates: what a scene can hold of a board's pours, and what is told of the rest."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from sits_mech.boards.kicad import read_board
from sits_mech.boards.pieces import of_net
from sits_mech.boards.plates import loops, plates, pours, simplified
from sits_mech.boards.route import route
from sits_mech.scene.apart import from_windings
from sits_mech.scene.parts.outlines import first_crossing, polygon, signed_area
from sits_mech.scene.sensor import Conductor, Sensor, sensor_from
from sits_mech.units import SceneError

COIL = {
    "name": "L1", "shape": "path", "track_width": 2e-4, "track_thickness": 35e-6,
    "path": [[[-2e-3, -2e-3, -17.5e-6], [2e-3, -2e-3, -17.5e-6], [2e-3, 2e-3, -17.5e-6], [-2e-3, 2e-3, -17.5e-6]]],
}


def made(draw: Any, *zones: str, **options: Any) -> tuple[list[dict[str, Any]], tuple[str, ...], Sensor]:
    """Return the plates of zones beside a coil of 4 mm about (10, 10), what is told, and the scene with them."""
    scene: dict[str, Any] = {"name": "x", "frequency": 1e6, "coils": [COIL]}
    board = read_board(draw.board(list(zones), **options))
    found, notes = plates(sensor_from(scene), pours(board, [])[0], board.stack, np.array([0.01, -0.01]), 0.0)
    return found, notes, sensor_from(scene | {"conductors": found})


def rounded(a: float, b: float, width: float, length: float, radius: float) -> list[tuple[float, float]]:
    """Return a rectangle with rounded corners, as a fill leaves them."""
    turn = np.linspace(0, np.pi / 2, 9)
    corners = []
    for k, (x, y) in enumerate([(a + width, b + length), (a, b + length), (a, b), (a + width, b)]):
        sx, sy = (-1 if k in (0, 3) else 1), (-1 if k in (0, 1) else 1)
        angle = turn + k * np.pi / 2
        points = np.column_stack([x + sx * radius + radius * np.cos(angle), y + sy * radius + radius * np.sin(angle)])
        corners += [tuple(point) for point in points.tolist()]
    return corners


def test_a_rectangle_is_whole(draw: Any) -> None:
    """Of 18 x 16 mm with corners of 0.125 mm on the lower side; its place in the scene's frame, y up."""
    found, notes, sensor = made(draw, draw.zone(rounded(2, 3, 18, 16, 0.125)), four=True)
    assert notes == () and found == [
        {
            "name": "GND B.Cu", "material": "copper", "shape": "rectangle",
            "centre": [pytest.approx(1e-3), pytest.approx(-1e-3), pytest.approx(-1.4875e-3)],
            "width": pytest.approx(18e-3), "length": pytest.approx(16e-3), "thickness": pytest.approx(35e-6),
        }
    ]
    assert sensor.conductors[0].centre[2] == pytest.approx(-1.4875e-3)


def test_a_disc_is_a_disc(draw: Any) -> None:
    """A polygon of 64 corners."""
    angle = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    found, notes, _ = made(draw, draw.zone([(10 + 5 * np.cos(t), 10 + 5 * np.sin(t)) for t in angle]))
    assert notes == () and found[0]["shape"] == "disc" and found[0]["diameter"] == pytest.approx(10e-3, rel=1e-6)


def test_a_disc_with_a_round_hole_is_a_ring(draw: Any) -> None:
    """Two polygons of 64 corners about one middle, tied by a bridge; with the hole aside it is an outline."""
    t = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    for aside, shape in ((0.0, "ring"), (1.0, "outline")):
        rim, hole = ([(10 + x + r * np.cos(a), 10 + r * np.sin(a)) for a in way] for r, x, way in
                     ((5, 0.0, t), (2, aside, t[::-1])))
        first = int(np.argmax([x for x, _ in hole]))
        hole = hole[first:] + hole[: first + 1]
        found, _, _ = made(draw, draw.zone([rim[0], *hole, *rim]))
        assert found[0]["shape"] == shape
        if shape == "ring":
            assert found[0]["diameter"] == pytest.approx(10e-3) and found[0]["inner_diameter"] == pytest.approx(4e-3)


def test_notches_and_slits_stay(draw: Any) -> None:
    """An L of three quarters of its box, and a plate that a slit of 1 % of its area all but parts; names stay apart."""
    ell = [(0, 0), (20, 0), (20, 10), (10, 10), (10, 20), (0, 20)]
    slit = [(30, 0), (50, 0), (50, 20), (40.1, 20), (40.1, 1), (39.9, 1), (39.9, 20), (30, 20)]
    found, notes, sensor = made(draw, draw.zone(ell), draw.zone(slit))
    assert [(item["name"], item["shape"]) for item in found] == [("GND B.Cu", "outline"), ("GND B.Cu 2", "outline")]
    assert len(notes) == 2 and "396.2 mm2: outline of 8 corners, to 0.042 mm" in notes[0]
    assert area(sensor.conductors[0]) == pytest.approx(396.2e-6) and sensor.conductors[0].extent == (20e-3, 20e-3)
    assert area(sensor.conductors[1]) == pytest.approx(300e-6)


def test_chamfered_plates_and_squares_on_their_corner_are_outlines(draw: Any) -> None:
    """All corners on the box, or on the circle, are not enough."""
    cut = [(4, 0), (20, 0), (20, 16), (16, 20), (0, 20), (0, 4)]
    found, _, _ = made(draw, draw.zone(cut), draw.zone([(40, 10), (50, 0), (60, 10), (50, 20)]))
    assert [item["shape"] for item in found] == ["outline", "outline"]


def test_holes_stay_but_for_small_ones(draw: Any) -> None:
    """Of 1.41 and 0.4 mm across their corners; a disc of 1 % of 4.2 x 4.2 mm is 0.474 mm across."""
    plate, sizes = [(0, 0), (20, 0), (20, 20), (0, 20)], ((5, 0.5), (10, 0.14))
    holes = [[(x - a, 5 - a), (x - a, 5 + a), (x + a, 5 + a), (x + a, 5 - a)] for x, a in sizes]
    tied = [*holes[0], holes[0][0], *holes[1], holes[1][0], holes[0][0], plate[0], *plate[1:]]
    found, notes, sensor = made(draw, draw.zone([plate[0], *tied]))
    assert notes == (
        "pour of GND on B.Cu, 398.9 mm2: outline of 8 corners, to 0.042 mm, 1 hole among them, "
        "without 1 hole less than 0.474 mm across",
    )
    assert area(sensor.conductors[0]) == pytest.approx(399e-6) and len(found[0]["holes"]) == 1


@given(st.integers(0, 2**32 - 1))
def test_simplified_rims_are_near(seed: int) -> None:
    """Every corner that is left out is within the tolerance of the rims that stand for it, and those have no others."""
    some = np.random.default_rng(seed)
    angle = np.sort(some.uniform(0, 2 * np.pi, 60))
    rim = (1.0 + some.uniform(-0.05, 0.05, 60))[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    (found,) = simplified([rim], 0.04)
    assert 3 <= len(found) < 60 and {*map(tuple, found)} <= {*map(tuple, rim)}
    assert polygon([found]).boundary.distance(shapely.points(rim)).max() <= 0.04 * (1 + 1e-9)


def test_rims_that_would_cross_keep_more_corners() -> None:
    """A hole within a bend of the rim that is flatter than the tolerance; below it the bend goes."""
    bent = np.array([(0, 0), (1, 0), (1, 1), (0.5, 1.04), (0, 1)])
    inside = np.array([(0.45, 1.01), (0.5, 1.03), (0.55, 1.01), (0.5, 0.8)])
    below = inside - (0.0, 0.1)
    assert [len(found) for found in simplified([bent, below], 0.05)] == [4, 3]
    found = simplified([bent, inside], 0.05)
    assert len(found[0]) == 5 and first_crossing(found) is None


def area(plate: Conductor) -> float:
    """Return the area of an outline's metal [m^2]."""
    rims = (plate.points or (), *plate.holes)
    sizes = [abs(float(signed_area(np.array(rim)))) for rim in rims]
    return sizes[0] - sum(sizes[1:])


def test_islands_are_left_out_together(draw: Any) -> None:
    """Below 1 % of 4.2 x 4.2 mm: of 0.16 and 0.09 mm2, one of 0.2025 mm2 stays."""
    sizes = enumerate((0.4, 0.45, 0.3), start=30)
    islands = [draw.zone([(x, 0), (x + a, 0), (x + a, a), (x, a)]) for x, a in sizes]
    found, notes, _ = made(draw, *islands)
    assert [item["width"] for item in found] == [pytest.approx(0.45e-3)]
    assert notes == ("2 pours of less than 0.176 mm2: left out, 0.25 mm2 together",)


def test_pours_side_by_side_are_one_plate(draw: Any) -> None:
    """A square of 5 mm, corners of 0.1 mm, in the notch of an L, 2 mm away, and one around the coil in its own layer.

    The bridge is 0.084 mm wide and 2 mm long, and reaches as far into both as it is wide: 300 + 24.99 + 0.17 mm2.
    """
    inner = [(12.5, 20), (12.5, 13), (13, 13), (13, 7), (7, 7), (7, 13), (11.5, 13), (11.5, 20)]
    around = [(0, 0), (20, 0), (20, 20), *inner, (0, 20)]
    ell = [(0, 0), (20, 0), (20, 10), (10, 10), (10, 20), (0, 20)]
    square = draw.zone(rounded(12, 12, 5, 5, 0.1), net='(net 3) (net_name "L2")')
    found, notes, sensor = made(draw, draw.zone(around, "F.Cu"), square, draw.zone(ell))
    assert [item["name"] for item in found] == ["GND F.Cu", "GND, L2 B.Cu"]
    assert not any("left out" in note for note in notes)
    assert "2 side by side, of 300, 24.99 mm2, as one: bridges between them carry no current" in notes[1]
    assert area(sensor.conductors[1]) == pytest.approx(325.16e-6, rel=2e-3)
    assert from_windings(sensor.conductors[0], sensor.coils) == pytest.approx(0.9e-3)


def test_a_pour_that_no_bridge_reaches_is_left_out(draw: Any) -> None:
    """A frame around the coil in its own layer, and an island within: the bridge would cross the track."""
    inner = [(10, 19), (19, 19), (19, 1), (1, 1), (1, 19), (9, 19)]
    frame = [(0, 0), (20, 0), (20, 20), (10, 20), *inner, (9, 20), (0, 20)]
    found, notes, _ = made(draw, draw.zone(frame, "F.Cu"), draw.zone([(9, 9), (11, 9), (11, 11), (9, 11)], "F.Cu"))
    assert [item["name"] for item in found] == ["GND F.Cu"]
    assert "its box must be clear of that around conductors.GND F.Cu" in notes[-1] and "left out" in notes[-1]


def test_a_coil_may_end_in_a_pour(draw: Any) -> None:
    """The pour of the pad's net is cut 0.2 mm clear of the track, 0.2 mm wide, which lies in it over 3 mm."""
    pad = draw.pad("1", (3, 5), '2 "GND"').replace('"J1"', '"J2"')
    lines = [*draw.lines([(3, 5), (-2, 5), (-2, 8)]), draw.pad("2", (-2, 8))]
    board = read_board(draw.board([*lines, pad, draw.zone([(0, 0), (9, 0), (9, 9), (0, 9)], "F.Cu")]))
    found, notes = pours(board, [route(of_net(board, "L1"), 1e-6)])
    assert len(notes) == 1 and "cut 0.2 mm clear of net L1, which ends in it" in notes[0]
    assert found[0].area == pytest.approx(81e-6 - 3 * 0.6e-6 - np.pi * 0.09e-6 / 2, rel=1e-3)


def test_fills_of_old_boards_have_a_pen(draw: Any) -> None:
    """A square of 20 mm with a line of 0.25 mm round it is 20.25 mm wide, less four corners; told or not."""
    for version, said, width in ((20171130, "", 20.25), (20241229, "", 20.25), (20260206, "", 20.0),
                                 (20211014, "(filled_areas_thickness no)", 20.0),
                                 (20260206, "(filled_areas_thickness yes)", 20.25)):
        zone = draw.zone(SQUARE).replace("(filled_areas_thickness no)", said)
        (found,), _ = pours(read_board(draw.board([zone], version=version)), [])
        corners = (4 - np.pi) * ((width - 20.0) / 2) ** 2
        assert found.area == pytest.approx(1e-6 * (width**2 - corners), rel=1e-5)


def test_drawn_areas_are_pours(draw: Any) -> None:
    """A filled square on copper is a plate; one that touches the coil is left out."""
    text = '(gr_poly (pts (xy {0} 0) (xy {1} 0) (xy {1} 4) (xy {0} 4)) (layer "F.Cu") (width 0) (fill solid))'
    board = read_board(draw.board([*draw.lines([(0, 5), (9, 5), (9, 9)]), text.format(0, 4), text.format(8, 12)]))
    track = read_board(draw.board([*draw.lines([(0, 3), (9, 3), (9, 9)]), text.format(0, 4)]))
    assert [pour.area for pour in pours(board, [route(of_net(board, "L1"), 1e-6)])[0]] == pytest.approx([16e-6, 16e-6])
    assert "it is drawn and touches net L1" in pours(track, [route(of_net(track, "L1"), 1e-6)])[1][0]


SQUARE = [(0, 0), (20, 0), (20, 20), (0, 20)]
# from the left side at (0, 6) to a hole, and from that hole's right side at (8, 7) on to a second one, and back
HOLES = [
    (0, 0), (20, 0), (20, 20), (0, 20), (0, 6), (4, 6), (4, 8), (8, 8), (8, 7), (12, 7), (12, 9), (15, 9), (15, 5),
    (12, 5), (12, 7), (8, 7), (8, 4), (4, 4), (4, 6), (0, 6),
]


@pytest.mark.parametrize("start", range(0, 20, 3))
@pytest.mark.parametrize("way", [1, -1])
def test_holes_come_out_of_their_bridges(start: int, way: int) -> None:
    """A square of 20 mm with holes of 4 x 4 and 3 x 4 mm: 400 - 16 - 12; corners on the bridges are gone."""
    ((rim, *holes),) = loops(1e-3 * np.roll(np.array(HOLES), start, axis=0)[::way])
    assert {tuple(p) for p in np.round(1e3 * rim, 6).tolist()} == {tuple(map(float, p)) for p in SQUARE}
    assert sorted(len(hole) for hole in holes) == [4, 4]
    areas = [abs(float(signed_area(loop))) for loop in (rim, *holes)]
    assert areas == pytest.approx([400e-6, 16e-6, 12e-6], rel=1e-9)
    assert areas[0] - sum(areas[1:]) == pytest.approx(abs(float(signed_area(1e-3 * np.array(HOLES)))), rel=1e-12)


def test_a_polygon_without_holes_is_itself() -> None:
    """Turned, closed twice or with corners on its sides."""
    corners = 1e-3 * np.array([(0, 0), (10, 0), (20, 0), (20, 20), (20, 20), (0, 20), (0, 0)])
    ((rim,),) = loops(corners)
    assert len(rim) == 4 and abs(signed_area(rim)) == pytest.approx(400e-6, rel=1e-9)


def test_which_zones_are_plates(draw: Any) -> None:
    """Those of other nets that are filled; the others are told."""
    zones = [
        draw.zone(HOLES), draw.zone(SQUARE, net='(net 1) (net_name "L1")'), draw.zone([]),
        draw.zone([(30, 0), (31, 0), (31, 1)], "F.Cu", net='(net 0) (net_name "")'),
    ]
    board = read_board(draw.board([*draw.lines([(0, 0), (10, 0)]), *zones]))
    found, notes = pours(board, [route(of_net(board, "L1"), 1e-6)])
    assert [(pour.net, pour.layer, len(pour.holes)) for pour in found] == [("GND", "B.Cu", 2), ("", "F.Cu", 0)]
    assert found[0].area == pytest.approx(372e-6, rel=1e-9) and found[1].area == pytest.approx(0.5e-6, rel=1e-9)
    assert signed_area(found[0].rim) > 0
    assert [re.split("[,:]", note)[0] for note in notes] == ["zone L1 on B.Cu", "zone GND on B.Cu"]
    assert "own net" in notes[0] and "fill all zones in KiCad" in notes[1]


@pytest.mark.parametrize(
    ("track", "touches"),
    [
        ([(4.5, 6), (7.5, 6)], False),  # in the first hole
        ([(4.5, 6), (7.89, 6)], False),
        ([(4.5, 6), (7.91, 6)], True),  # half a width is 0.1 mm
        ([(4.5, 6), (10, 6)], True),
        ([(17, 10), (18, 12)], True),  # in the copper, far from every rim
        ([(-1, 6), (-1, 9)], False),
        ([(-5, 5), (30, 5)], True),  # across, from outside to outside
        ([(-0.09, 6), (-0.09, 9)], True),
    ],
)
def test_pours_keep_off_the_tracks(draw: Any, track: list[tuple[float, float]], touches: bool) -> None:
    """On one layer; on the other they may lie where they like."""
    for layer in ("B.Cu", "F.Cu"):
        path = draw.board([*draw.lines(track), draw.zone(HOLES, layer)])
        board = read_board(path)
        if touches and layer == "F.Cu":
            expected = "net L1: its track must be clear of the pour of GND on F.Cu; got one that touches it at ("
            with pytest.raises(SceneError, match=re.escape(f"{path}: {expected}")):
                pours(board, [route(of_net(board, "L1"), 1e-6)])
        else:
            assert len(pours(board, [route(of_net(board, "L1"), 1e-6)])[0]) == 1


def test_a_fill_that_touches_itself_in_a_point_has_two_pieces() -> None:
    """5 x 5 and 4 x 5 mm that meet at a corner: neither is lost, and both are held against the tracks."""
    bow = 1e-3 * np.array([(0, 0), (5, 0), (5, 5), (9, 5), (9, 10), (5, 10), (5, 5), (0, 5)])
    areas = sorted(abs(float(signed_area(rim))) for (rim,) in loops(bow))
    assert areas == pytest.approx([20e-6, 25e-6], rel=1e-9)
