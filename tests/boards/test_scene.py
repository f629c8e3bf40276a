"""From a board to a scene that loads: frame, heights, coils, plates, what is told; and the command."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.constants import mu_0

from sits_mech.boards.scene import Selection, board_scene
from sits_mech.cli.main import run
from sits_mech.scene.sensor import Sensor, load_sensor
from sits_mech.units import SceneError

GND = [(90, 90), (130, 90), (130, 130), (90, 130)]


def coil(draw: Any, at: float = 100.0, net: str = "1") -> list[str]:
    """Return a coil of two turns on F.Cu and In2.Cu with a blind via: 8 x 6 mm, its middle at (at + 4, 103)."""
    x, y = at, 100.0
    top = [(x, y - 0.5), (x, y), (x + 8, y), (x + 8, y + 6), (x, y + 6), (x, y + 1)]
    below = [(x, y + 1), (x + 7, y + 1), (x + 7, y + 5), (x + 1, y + 5), (x + 1, y + 2)]
    via = draw.via(top[-1], '"F.Cu" "In2.Cu"', net, kind="blind")
    return [*draw.lines(top, net=net), *draw.lines(below, "In2.Cu", net, 0.15), via]


def loaded(path: Path, text: str) -> Sensor:
    """Return the scene of a text, as a file beside the board."""
    scene = path.with_suffix(".toml")
    scene.write_text(text)
    return load_sensor(scene)


def test_a_board_of_four_layers(draw: Any) -> None:
    """Heights by hand: copper from 0 to -35 um and from -1.2525 to -1.27 mm; GND on B.Cu in the middle at -1.4875 mm.

    The frame: the middle of the box around the tracks' centre lines, y up; widths one for each polyline.
    """
    path = draw.board([*coil(draw), draw.zone(GND)], four=True)
    text, notes = board_scene(path, Selection(("L1",), frequency=2e6))
    sensor = loaded(path, text)
    (found,) = sensor.coils
    assert (found.name, found.shape, sensor.frequency) == ("L1", "path", 2e6)
    first, second = (np.array(line) for line in found.path)
    # lengths: 0.5 + 8 + 6 + 8 + 5 mm of 35 um, 7 + 4 + 6 + 3 mm of 17.5 um
    mean = (27.5 * 35e-6 + 20 * 17.5e-6) / 47.5
    assert found.track_thickness == pytest.approx(mean, abs=1e-10)
    np.testing.assert_allclose(first[0], [-4e-3, 3.25e-3, -17.5e-6], atol=1e-9)
    np.testing.assert_allclose(first[[1, 2, 3], :2], 1e-3 * np.array([[-4, 2.75], [4, 2.75], [4, -3.25]]), atol=1e-9)
    assert second[0, 2] == pytest.approx(-1.26125e-3, abs=1e-9)
    np.testing.assert_array_equal(first[-1, :2], second[0, :2])
    assert found.path_widths == pytest.approx((2e-4, 1.5e-4)) and found.track_width == pytest.approx(2e-4)
    assert found.board_permittivity == pytest.approx(1.2 / (0.225 + 0.2 / 4.5), abs=1e-4)
    (plate,) = sensor.conductors
    assert plate.centre == pytest.approx((6e-3, -7.25e-3, -1.4875e-3), abs=1e-9)
    assert plate.extent == pytest.approx((40e-3, 40e-3)) and plate.thickness == pytest.approx(35e-6)
    assert len(notes) == 1 and "47.5 mm of track on F.Cu, In2.Cu" in notes[0] and "copper of 17.5, 35 um" in notes[0]
    assert "1 via of 1.244 mm is no part of the coil" in notes[0]
    assert "# [target]" in text and f"# {notes[0]}" in text


def test_a_target_to_add_is_a_scene(draw: Any) -> None:
    """The commented tables load once their signs are gone."""
    path = draw.board(coil(draw), four=True)
    text, _ = board_scene(path, Selection(("L1",)))
    head, tail = text.split("# The board has no target")
    sensor = loaded(path, head + re.sub(r"(?m)^# ", "", "# # " + tail))
    assert sensor.target is not None and sensor.target.extent == pytest.approx((8.2e-3, 6.7e-3), rel=1e-2)
    assert sensor.elastomer is not None


def test_two_coils_keep_their_distance(draw: Any) -> None:
    """The middle is that of both; the board's own origin leaves places as they are; no pours where none are wanted."""
    path = draw.board([*coil(draw), *coil(draw, 115.0, "3"), draw.zone(GND)], four=True)
    both = loaded(path, board_scene(path, Selection(("L1", "L2"), with_pours=False))[0])
    assert [one.name for one in both.coils] == ["L1", "L2"] and both.conductors == ()
    assert [one.centre[0] for one in both.coils] == pytest.approx([-7.5e-3, 7.5e-3], abs=1e-9)
    board = loaded(path, board_scene(path, Selection(("L2",), origin="board"))[0])
    assert board.coils[0].centre == pytest.approx((0.119, -0.10275), abs=1e-9)


def test_the_uppermost_track_is_at_zero(draw: Any) -> None:
    """A coil on In1.Cu has its own top face at z = 0; a pour on F.Cu is above it, 0.2 mm and half its copper."""
    path = draw.board([*draw.lines([(0, 0), (5, 0), (5, 5)], "In1.Cu"), draw.zone(GND, "F.Cu")], four=True)
    sensor = loaded(path, board_scene(path, Selection(("L1",)))[0])
    assert sensor.coils[0].heights == (-8.75e-6,)
    assert sensor.conductors[0].centre[2] == pytest.approx(0.2e-3 + 17.5e-6, abs=1e-9)


@pytest.mark.parametrize("side", [3.3, 4.1, 5.7])
def test_a_coil_on_layers_of_unlike_copper_is_a_scene(draw: Any, side: float) -> None:
    """Its mean thickness, thicker than its uppermost track, is told to a digit, and its half to the same."""
    inner = draw.lines([(0, 0), (9.3, 0), (9.3, 9.3)], "In1.Cu")
    outer = draw.lines([(9.3, 9.3), (0, 9.3), (0, 9.3 - side)], "B.Cu")
    path = draw.board([*inner, draw.via((9.3, 9.3), '"In1.Cu" "B.Cu"'), *outer], four=True)
    (coil,) = loaded(path, board_scene(path, Selection(("L1",)))[0]).coils
    assert coil.heights[0] == -coil.track_thickness / 2


@pytest.mark.parametrize(
    ("choice", "expected"),
    [
        (Selection(()), "must name a coil of the board; it is missing; what looks like a coil: --net=L1 (47.5 mm, "),
        (Selection(("L1", "L1")), "--net: must name each once; got L1 twice"),
        (Selection(("L1",), chord_error=0.0), "--chord-error: must be a length from 1 nm to 1 mm; got 0 mm"),
        (Selection(("L3",)), 'must be a net of the board; got "L3"; what looks like a coil: --net=L1 (47.5 mm'),
        (Selection(("L1",), frequency=-1.0), "frequency: must be a frequency"),
    ],
)
def test_what_cannot_be_chosen(draw: Any, choice: Selection, expected: str) -> None:
    """One line each."""
    with pytest.raises(SceneError, match=re.escape(expected)):
        board_scene(draw.board(coil(draw), four=True), choice)


def test_turns_that_touch_are_refused(draw: Any) -> None:
    """A net that crosses itself on one layer, without a joint, is short-circuited: the scene says where."""
    path = draw.board(draw.lines([(0, 0), (10, 0), (10, 10), (5, 10), (5, -5)]))
    with pytest.raises(SceneError, match=f"{path}: coils.L1: path: tracks must not cross in one layer"):
        board_scene(path, Selection(("L1",)))


def test_the_command(draw: Any, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A scene in a file, or on stdout; what is told on stderr; one line and 2 for what cannot be."""
    board, scene = str(draw.board([*coil(draw), draw.zone(GND)])), tmp_path / "probe.toml"
    assert run(["import", board, "--net", "L1", "--frequency", "3 MHz", "-o", str(scene)]) == 2
    err = capsys.readouterr().err  # In2.Cu is no layer of this board
    assert err.count("\n") == 1 and not scene.exists()
    board = str(draw.board([*coil(draw), draw.zone(GND)], four=True))
    assert run(["import", board, "--net", "L1", "--frequency", "3 MHz", "-o", str(scene)]) == 0
    out, err = capsys.readouterr()
    assert out == "" and err.splitlines()[-1] == f"written to {scene}" and load_sensor(scene).frequency == 3e6
    assert run(["import", board, "--net", "L1", "--no-pours"]) == 0
    assert "[[conductors]]" not in capsys.readouterr().out
    for words in (["L9"], ["L1", "--chord-error", "1 m"], ["L1", "--frequency", "soon"]):
        assert run(["import", board, "--net", *words]) == 2
        out, err = capsys.readouterr()
        assert out == "" and err.count("\n") == 1 and err.startswith("error: --")


def test_an_imported_loop_has_its_inductance(draw: Any, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A square of side a: L0 = (2 mu0 a / pi) (ln(a / g) - 0.77401), with g = 0.2235 (w + t) of its track.

    Source: Grover, Inductance Calculations (1946), squares of wire; g is the geometric mean distance of a rectangle.
    It neglects the width beside the side, a hundredth here, and the gap of 0.1 mm of 80 mm.
    """
    side, scene = 20.0, tmp_path / "loop.toml"
    corners = [(0.1, 0), (side, 0), (side, side), (0, side), (0, 0.1)]
    board = draw.board(draw.lines(corners, width=0.2))
    assert run(["import", str(board), "--net", "L1", "-o", str(scene)]) == 0
    capsys.readouterr()
    assert run(["inductance", str(scene), "--model", "sheets", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    expected = 2.0 * mu_0 * 1e-3 * side / np.pi * (np.log(side / (0.2235 * 0.235)) - 0.77401)
    assert found["L0"][0][0] == pytest.approx(expected, rel=1e-2)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_a_broken_board_is_a_scene_or_refused(draw: Any, data: st.DataObject) -> None:
    """Whatever numbers and words are changed, nothing but a SceneError comes, without warnings."""
    items = [*coil(draw), draw.arc((102, 102), (103, 103), (104, 102)), draw.zone(GND)]
    text = draw.board(items, four=True).read_text()
    words = re.findall(r'"[^"]*"|[()]|[^\s()]+|\s+', text)
    for _ in range(data.draw(st.integers(1, 3))):
        k = data.draw(st.integers(0, len(words) - 1))
        words[k] = data.draw(st.sampled_from(["", "-3", "0", '"x"', "nan", "() ", words[k] * 2, "1e200", "1e-200"]))
    draw.path.write_text("".join(words))
    try:
        board_scene(draw.path, Selection(("L1",)))
    except SceneError as error:
        assert "\n" not in str(error)


def test_coils_over_each_other_are_clear_by_layers(draw: Any) -> None:
    """Each on both layers, one's lead under the other's turns: clear in F.Cu and in B.Cu, crossing in the plan alone.

    The same lead in F.Cu would cross, and is refused with its height and place.
    """
    first = [*draw.lines([(0, 0), (10, 0), (10, 10), (0, 10), (0, 2)]), draw.via((0, 2))]
    lead = draw.lines([(0, 2), (-4, 2)], "B.Cu")
    second = [*draw.lines([(20, 0), (30, 0), (30, 10), (20, 10), (20, 5)], net="3"), draw.via((20, 5), net="3")]
    for layer in ("B.Cu", "F.Cu"):
        board = draw.board([*first, *lead, *second, *draw.lines([(20, 5), (5, 5)], layer, net="3")])
        if layer == "B.Cu":
            one, other = loaded(board, board_scene(board, Selection(("L1", "L2")))[0]).coils
            assert (one.name, other.name) == ("L1", "L2") and one.heights == other.heights
        else:
            with pytest.raises(SceneError, match="tracks must not cross in one layer; those at z = -0.0175 mm do at"):
                board_scene(board, Selection(("L1", "L2")))
