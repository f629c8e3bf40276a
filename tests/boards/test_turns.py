"""Turns that touch: told where, and nothing said of bends, corners and turns that keep apart."""

from typing import Any

import numpy as np
import pytest

from sits_mech.boards.kicad import read_board
from sits_mech.boards.pieces import of_net
from sits_mech.boards.route import route
from sits_mech.boards.scene import touching


def told(draw: Any, items: list[str]) -> tuple[str, ...]:
    """Return what is told of the coil of a board."""
    return touching(route(of_net(read_board(draw.board(items)), "L1"), 1e-6))


@pytest.mark.parametrize(("pitch", "touches"), [(0.25, False), (0.202, False), (0.198, True), (0.1, True)])
def test_a_spiral_with_too_small_a_pitch(draw: Any, pitch: float, touches: bool) -> None:
    """Tracks of 0.2 mm: the turns are apart by the pitch; 2 % of curvature are no gap."""
    angle = np.linspace(0.0, 6 * np.pi, 301)
    r = 5.0 - pitch * angle / (2 * np.pi)
    notes = told(draw, draw.lines(np.column_stack([r * np.cos(angle), r * np.sin(angle)]).tolist()))
    assert len(notes) == touches and all("net L1: its turns touch on F.Cu at (" in note for note in notes)


def test_corners_bends_and_vias_are_no_touch(draw: Any) -> None:
    """A corner of 30 degrees, a hairpin of 0.15 mm radius, a way back on the other layer, straight above."""
    corner = [(0, 0), (10, 0), (10 - 5 * np.cos(np.pi / 6), 5 * np.sin(np.pi / 6))]
    assert told(draw, draw.lines(corner)) == ()
    hairpin = [*draw.lines([(0, 0), (5, 0)]), draw.arc((5, 0), (5.15, 0.15), (5, 0.3)), draw.line((5, 0.3), (0, 0.3))]
    assert told(draw, hairpin) == ()
    back = [draw.line((0, 0), (5, 0)), draw.line((5, 0), (0, 0), "B.Cu"), draw.via((5, 0))]
    assert told(draw, back) == ()


def test_an_end_on_another_turn(draw: Any) -> None:
    """The inner end overlaps the first side by half of its width, without a joint: each layer is told."""
    turn = [(0, 0), (10, 0), (10, 10), (0, 10), (0, 0.15)]
    (note,) = told(draw, draw.lines(turn))
    assert "a short circuit of the board, not of the scene" in note
    assert told(draw, draw.lines([*turn[:-1], (0, 0.25)])) == ()
