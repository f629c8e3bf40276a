"""Plates: what a scene can hold of a board's pours, and what is told of the rest."""

from typing import Any

import numpy as np
import pytest

from sits_mech.boards.kicad import read_board
from sits_mech.boards.plates import plates
from sits_mech.boards.pours import pours
from sits_mech.scene.sensor import Sensor, sensor_from

COIL = {
    "name": "L1", "shape": "path", "track_width": 2e-4, "track_thickness": 35e-6,
    "path": [[[-2e-3, -2e-3, -17.5e-6], [2e-3, -2e-3, -17.5e-6], [2e-3, 2e-3, -17.5e-6], [-2e-3, 2e-3, -17.5e-6]]],
}  # fmt: skip


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
    ]  # fmt: skip
    assert sensor.conductors[0].centre[2] == pytest.approx(-1.4875e-3)


def test_a_disc_is_a_disc(draw: Any) -> None:
    """A polygon of 64 corners."""
    angle = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    found, notes, _ = made(draw, draw.zone([(10 + 5 * np.cos(t), 10 + 5 * np.sin(t)) for t in angle]))
    assert notes == () and found[0]["shape"] == "disc" and found[0]["diameter"] == pytest.approx(10e-3, rel=1e-6)


def test_slots_are_told(draw: Any) -> None:
    """An L of three quarters of its box; names stay apart."""
    ell = [(0, 0), (20, 0), (20, 10), (10, 10), (10, 20), (0, 20)]
    found, notes, _ = made(draw, draw.zone(ell), draw.zone(rounded(30, 0, 5, 5, 0.1)))
    assert [item["name"] for item in found] == ["GND B.Cu", "GND B.Cu 2"]
    assert len(notes) == 1 and "of which it fills 75%; notches are lost" in notes[0]


def test_islands_are_left_out_together(draw: Any) -> None:
    """Below 1 % of 4.2 x 4.2 mm: of 0.16 and 0.09 mm2, one of 0.2025 mm2 stays."""
    sizes = enumerate((0.4, 0.45, 0.3), start=30)
    islands = [draw.zone([(x, 0), (x + a, 0), (x + a, a), (x, a)]) for x, a in sizes]
    found, notes, _ = made(draw, *islands)
    assert [item["width"] for item in found] == [pytest.approx(0.45e-3)]
    assert notes == ("2 pours of less than 0.176 mm2: left out, 0.25 mm2 together",)


def test_what_does_not_fit_is_left_out(draw: Any) -> None:
    """A pour around the coil on its layer, one within the box of another; the larger stays."""
    inner = [(11, 20), (11, 13), (13, 13), (13, 7), (7, 7), (7, 13), (9, 13), (9, 20)]
    around = [(0, 0), (20, 0), (20, 20), *inner, (0, 20)]
    ell = [(0, 0), (20, 0), (20, 10), (10, 10), (10, 20), (0, 20)]
    found, notes, _ = made(draw, draw.zone(around, "F.Cu"), draw.zone(rounded(12, 12, 5, 5, 0.1)), draw.zone(ell))
    assert [(item["name"], item["width"]) for item in found] == [("GND B.Cu", pytest.approx(20e-3))]
    left = [note for note in notes if "left out" in note]
    assert len(left) == 2 and "must be clear of coils.L1" in left[0] and "clear of conductors.GND B.Cu" in left[1]
