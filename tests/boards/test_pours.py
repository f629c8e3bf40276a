"""Pours: holes out of bridges, by areas known beforehand; what touches a track is refused with where."""

import re
from typing import Any

import numpy as np
import pytest

from sits_mech.boards.kicad import read_board
from sits_mech.boards.pours import loops, pours
from sits_mech.boards.route import route
from sits_mech.scene.outlines import signed_area
from sits_mech.units import SceneError

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
    rim, *holes = loops(1e-3 * np.roll(np.array(HOLES), start, axis=0)[::way])
    assert {tuple(p) for p in np.round(1e3 * rim, 6).tolist()} == {tuple(map(float, p)) for p in SQUARE}
    assert sorted(len(hole) for hole in holes) == [4, 4]
    areas = [abs(float(signed_area(loop))) for loop in (rim, *holes)]
    assert areas == pytest.approx([400e-6, 16e-6, 12e-6], rel=1e-9)
    assert areas[0] - sum(areas[1:]) == pytest.approx(abs(float(signed_area(1e-3 * np.array(HOLES)))), rel=1e-12)


def test_a_polygon_without_holes_is_itself() -> None:
    """Turned, closed twice or with corners on its sides."""
    corners = 1e-3 * np.array([(0, 0), (10, 0), (20, 0), (20, 20), (20, 20), (0, 20), (0, 0)])
    (rim,) = loops(corners)
    assert len(rim) == 4 and abs(signed_area(rim)) == pytest.approx(400e-6, rel=1e-9)


def test_which_zones_are_plates(draw: Any) -> None:
    """Those of other nets that are filled; the others are told."""
    zones = [
        draw.zone(HOLES), draw.zone(SQUARE, net='(net 1) (net_name "L1")'), draw.zone([]),
        draw.zone([(30, 0), (31, 0), (31, 1)], "F.Cu", net='(net 0) (net_name "")'),
    ]
    board = read_board(draw.board([*draw.lines([(0, 0), (10, 0)]), *zones]))
    found, notes = pours(board, [route(board, "L1", 1e-6)])
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
                pours(board, [route(board, "L1", 1e-6)])
        else:
            assert len(pours(board, [route(board, "L1", 1e-6)])[0]) == 1
