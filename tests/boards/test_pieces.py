"""Copper by net, by footprint, at a place: which is meant, and what is said where there is none."""

import re
from typing import Any

import numpy as np
import pytest

from sits_mech.boards.kicad import read_board
from sits_mech.boards.pieces import at_place, of_footprint, of_net, pieces
from sits_mech.boards.scene import Selection, board_scene
from sits_mech.boards.windings import windings
from sits_mech.scene.sensor import load_sensor
from sits_mech.units import SceneError

LOOP = [(0, 0), (10, 0), (10, 10), (0, 10), (0, 1)]


def footprint(draw: Any, at: tuple[float, float], reference: str, nets: tuple[str, str]) -> str:
    """Return a footprint of a loop between two pads."""
    pairs = zip(LOOP[:-1], LOOP[1:], strict=True)
    lines = [
        f'(fp_line (start {a[0]} {a[1]}) (end {b[0]} {b[1]}) (stroke (width 0.2) (type solid)) (layer "F.Cu"))'
        for a, b in pairs
    ]
    pads = [
        f'(pad "{k}" smd rect (at {p[0]} {p[1]}) (size 0.5 0.5) (layers "F.Cu") (net {net}))'
        for k, p, net in ((1, LOOP[0], nets[0]), (2, LOOP[-1], nets[1]))
    ]
    head = f'(footprint "x:l" (layer "F.Cu") (at {at[0]} {at[1]}) (property "Reference" "{reference}" (at 0 0))'
    return f"{head} {' '.join([*lines, *pads])})"


def test_a_footprint_by_its_reference(draw: Any) -> None:
    """Two on the same two nets: neither net is one coil, each reference is, and so is a place on it or within."""
    both = [footprint(draw, at, name, ('1 "L1"', '3 "L2"')) for at, name in (((0, 0), "T1"), ((20, 0), "T2"))]
    path = draw.board(both)
    board = read_board(path)
    assert len(pieces(board)) == 2 and {each.take for each in windings(board)} == {"--footprint=T1", "--footprint=T2"}
    assert all(each.nets == ("L1", "L2") for each in windings(board))
    scene = path.with_suffix(".toml")
    scene.write_text(board_scene(path, Selection(footprints=("T2",), places=("10,3",)))[0])
    assert [(coil.name, coil.centre[0]) for coil in load_sensor(scene).coils] == [
        ("T2", pytest.approx(10e-3)), ("T1", pytest.approx(-10e-3))
    ]
    with pytest.raises(SceneError, match="net L1: must have one track much longer than others between pads; got two"):
        board_scene(path, Selection(nets=("L1",)))
    with pytest.raises(SceneError, match='--footprint: .*: must be a footprint of the board; got "T3"; what looks'):
        board_scene(path, Selection(footprints=("T3",)))


def test_two_coils_over_each_other(draw: Any) -> None:
    """The layer tells which; without one, the upper of the file; a place off the board takes the nearest that turns."""
    upper, lower = draw.lines(LOOP, net="0"), draw.lines(LOOP, "B.Cu", net="0")
    board = read_board(draw.board([*upper, *lower, draw.line((30, 0), (31, 0), net="2")]))
    middle = np.array([10e-3, -5e-3])
    assert {track.layer for track in at_place(board, middle, "B.Cu").tracks} == {"B.Cu"}
    assert len(at_place(board, np.array([29e-3, 0.0]), "").tracks) == 4
    assert [each.take for each in windings(board)] == ["--at=0,0,F.Cu", "--at=0,0,B.Cu"]


@pytest.mark.parametrize("text", ["", "1", "1,2,3", "1,2,In1.Cu", "a,b", "1 s,2", "nan,1", "1,2,F.Cu,4", "1e3,2"])
def test_places_that_are_none(draw: Any, text: str) -> None:
    """One line, with what looks like a coil."""
    with pytest.raises(SceneError, match="--at: must be X,Y in mm as KiCad shows.*; what looks like a coil: --at=0,0"):
        board_scene(draw.board(draw.lines(LOOP, net="0")), Selection(places=(text,)))


def test_drawn_copper_goes_with_the_net_of_its_pads(draw: Any) -> None:
    """Lines without a net that end in a pad of L1 are its coil; a branch is told with where, in the list, too."""
    drawn = [
        f'(gr_line (start {a[0]} {a[1]}) (end {b[0]} {b[1]}) (stroke (width 0.2) (type solid)) (layer "F.Cu"))'
        for a, b in zip(LOOP[:-1], LOOP[1:], strict=True)
    ]
    board = read_board(draw.board([*drawn, draw.pad("1", LOOP[0])]))
    assert len(of_net(board, "L1").tracks) == 4 and windings(board)[0].take == "--net=L1"
    with pytest.raises(SceneError, match="--footprint"):
        of_footprint(board, "J9")
    branched = draw.board([*drawn, draw.pad("1", LOOP[0]), draw.line((10, 10), (15, 10))])
    (found,) = windings(read_board(branched))
    assert re.match("must be one path without branches; got 3 tracks that meet at .10.0000, 10.0000. mm", found.refusal)
    with pytest.raises(SceneError, match="no single path of its copper looks like a coil"):  # and is not offered again
        board_scene(branched, Selection(places=(found.take.removeprefix("--at="),)))


def test_nothing_looks_like_a_coil(draw: Any) -> None:
    """A board without tracks, and one with a bend."""
    for items in ([], draw.lines([(0, 0), (5, 0), (5, 5)], net="0")):
        with pytest.raises(SceneError, match="must name a coil.*; no single path of its copper looks like a coil"):
            board_scene(draw.board(items), Selection())
