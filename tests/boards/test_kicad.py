"""What is on a board: places, layers, nets and pads, in the variants that versions of KiCad write."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sits_mech.boards.kicad import read_board
from sits_mech.boards.plates import loops
from sits_mech.units import SceneError


def test_places_layers_and_nets(draw: Any) -> None:
    """Millimetres with y down become metres with y up; arcs, blind vias and inner layers; the net by number."""
    items = [
        draw.line((10, 20), (11.5, 20), "In2.Cu", width=0.127),
        draw.arc((0, 0), (1, -1), (2, 0)),
        draw.via((3, 4), '"F.Cu" "In2.Cu"', kind="blind"),
        draw.via((5, 4), net="2"),
    ]
    board = read_board(draw.board(items, four=True))
    line, arc = board.tracks
    np.testing.assert_allclose(line.points, [[0.01, -0.02], [0.0115, -0.02]], rtol=1e-12)
    assert (line.layer, line.width, line.net) == ("In2.Cu", pytest.approx(127e-6), "L1") and arc.points.shape == (3, 2)
    np.testing.assert_allclose(arc.points[1], [1e-3, 1e-3])
    blind, through = board.holes
    assert blind.layers == ("F.Cu", "In1.Cu", "In2.Cu") and len(through.layers) == 4 and through.net == "GND"
    assert board.nets == ("GND", "L1", "L2") and board.notes == ()


def test_nets_by_name_and_copper_drawings(draw: Any) -> None:
    """KiCad 10 names nets in the items; drawings on copper count without a net, too; a mask opening is no layer."""
    items = [
        draw.line((0, 0), (1, 0), net='"/a 1"'),
        '(gr_line (start 1 0) (end 2 0) (stroke (width 0.3) (type solid)) (layer "F.Cu") (net "/a 1"))',
        '(gr_line (start 1 0) (end 2 0) (stroke (width 0.3) (type solid)) (layer "F.Cu"))',
        '(gr_line (start 1 0) (end 2 0) (stroke (width 0.3) (type solid)) (layer "Edge.Cuts"))',
        '(segment (start 2 0) (end 3 0) (width 0.2) (layers "F.Cu" "F.Mask") (net "/a 1"))',
    ]
    board = read_board(draw.board(items, version=20260206, nets=" "))
    assert [track.net for track in board.tracks] == ["/a 1", "/a 1", "/a 1", ""] and board.nets == ("/a 1",)
    assert [track.width for track in board.tracks] == pytest.approx([2e-4, 2e-4, 3e-4, 3e-4])
    assert {track.layer for track in board.tracks} == {"F.Cu"}
    assert "newer" in read_board(draw.board(items, version=20990101)).notes[-1]


@pytest.mark.parametrize(
    ("angle", "place"), [(0, (3, -2)), (90, (-2, -3)), (180, (-3, 2)), (30, (1.598076, -3.232051))]
)
def test_footprints_turn_counter_clockwise_as_seen(draw: Any, angle: float, place: tuple[float, float]) -> None:
    """A pad at (3, -2) of a footprint at (65, 45): the KiCad project's own test board has (63, 42) at 90 degrees."""
    inside = f'(pad "2" smd rect (at 3 -2 {angle}) (size 2 1) (layers "F.Cu" "F.Mask") (net 1 "L1"))'
    drawn = '(fp_line (start 3 -2) (end 0 0) (stroke (width 0.1) (type solid)) (layer "F.Cu"))'
    head = f'(footprint "x:y" (layer "B.Cu") (at 65 45 {angle}) (fp_text reference "R1" (at 0 0) (layer "F.SilkS"))'
    board = read_board(draw.board([f"{head} {inside} {drawn})"]))
    (pad,), (line,) = board.holes, board.tracks
    expected = 1e-3 * np.array([65 + place[0], -45 - place[1]])
    np.testing.assert_allclose(pad.place, expected, atol=1e-9)
    np.testing.assert_allclose(line.points, [expected, [0.065, -0.045]], atol=1e-9)
    assert pad.name == "R1.2" and pad.layers == ("F.Cu",)
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[c, -s], [s, c]])
    corners = pad.place + 1e-3 * np.array([[0.99, 0.49], [1.01, 0.0], [0.0, 0.51]]) @ turn.T
    assert pad.holds(corners).tolist() == [True, False, False]


def test_zones_are_fills_without_keep_outs_and_teardrops(draw: Any) -> None:
    """An arc in a fill counts with its three points."""
    keep = '(zone (net 0) (net_name "") (layer "F.Cu") (keepout (tracks not_allowed)) (polygon (pts (xy 0 0))))'
    drop = draw.zone([(0, 0), (1, 0), (1, 1)]).replace("(fill yes)", "(attr (teardrop (type padvia)))")
    arc = draw.zone([(0, 0), (1, 0), (1, 1)]).replace("(xy 1 1)))", "(arc (start 1 1) (mid 0.8 1.2) (end 0 1))))")
    board = read_board(draw.board([keep, drop, draw.zone([]), draw.zone([(0, 0), (1, 0), (1, 1)], "F.Cu"), arc]))
    assert [len(zone.fills) for zone in board.zones] == [0, 1, 1] and {zone.net for zone in board.zones} == {"GND"}
    layer, points = board.zones[1].fills[0]
    assert layer == "F.Cu" and [len(rims) for rims in loops(points)] == [1]
    np.testing.assert_allclose(points, [[0, 0], [1e-3, 0], [1e-3, -1e-3]])
    np.testing.assert_allclose(board.zones[2].fills[0][1][3], [0.8e-3, -1.2e-3])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("(kicad_pcb (version 20160815))", "KiCad 5 or later (version 20171130); got version 20160815: open it in"),
        ("(kicad_sch (version 20231120))", "must be a board, (kicad_pcb ...); got ('kicad_sch' ...)"),
        ("(kicad_pcb)", "(version ...) must be 1 number or more, up to 1e+09; it is missing"),
        ('(kicad_pcb (version 20240108) (layers (44 "Edge.Cuts" user)))', "must have copper layers, such as F.Cu"),
        (
            '(kicad_pcb (version 20240108) (layers (0 "F.Cu" signal)) (segment (start 1) (layer "F.Cu")))',
            'segment: (start ...) must be 2 numbers or more, up to 2147.5; got "1.0"',
        ),
        (
            '(kicad_pcb (version 20240108) (layers (0 "F.Cu" signal)) (segment (layer "In1.Cu")))',
            "segment: must be on one of F.Cu; got In1.Cu",
        ),
        (
            '(kicad_pcb (version 20240108) (layers (0 "F.Cu" signal)) (zone (layer "F.Cu") '
            '(filled_polygon (layer "F.Cu") (pts (xy 1 a) (xy 1 1) (xy 2 2)))))',
            'filled_polygon: (xy ...) must be 2 numbers or more, up to 2147.5; got "1.0 a"',
        ),
        (
            '(kicad_pcb (version 20240108) (layers (0 "F.Cu" signal)) (footprint "x" (at 1 1) (pad)))',
            "must be a board as KiCad writes it; got an entry that is not",
        ),
    ],
)
def test_boards_that_are_none(tmp_path: Path, text: str, expected: str) -> None:
    """One line: the file, what it must be, what came."""
    path = tmp_path / "board.kicad_pcb"
    path.write_text(text)
    with pytest.raises(SceneError, match=re.escape(expected)) as caught:
        read_board(path)
    assert str(caught.value).startswith(f"{path}: ") and "\n" not in str(caught.value)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_a_broken_file_is_a_board_or_refused(draw: Any, data: st.DataObject) -> None:
    """Whatever words are lost, changed or doubled, nothing but a SceneError comes."""
    items = [*draw.lines([(0, 0), (1, 0)]), draw.arc((1, 0), (2, 1), (3, 0)), draw.via((3, 0)), draw.pad("1", (0, 0))]
    text = draw.board([*items, draw.zone([(0, 0), (1, 0), (1, 1)])], four=True).read_text()
    words = re.findall(r'"[^"]*"|[()]|[^\s()]+|\s+', text)
    for _ in range(data.draw(st.integers(1, 3))):
        k = data.draw(st.integers(0, len(words) - 1))
        words[k] = data.draw(st.sampled_from(["", "-3", '"x"', "nan", "() ", words[k] * 2, "1e200"]))
    draw.path.write_text("".join(words))
    try:
        read_board(draw.path)
    except SceneError as error:
        assert "\n" not in str(error)
