"""Routes: one path, whatever the order of the tracks; the project's own footprints come back as they were drawn."""

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from sits_mech.boards.copper import Board
from sits_mech.boards.kicad import read_board
from sits_mech.boards.pieces import of_net
from sits_mech.boards.route import Route, route
from sits_mech.export.kicad import layers_of_coil, winding, write_kicad
from sits_mech.export.source import Source
from sits_mech.scene.sensor import Sensor, changed, load_sensor
from sits_mech.units import SceneError

SENSOR = load_sensor("biorob2018-w15")


def length(found: Route) -> float:
    """Return the length of a route's tracks [m]."""
    return float(sum(np.hypot(*np.diff(run.points, axis=0).T).sum() for run in found.runs))


def drawn(draw: Any, sensor: Sensor, number: int, net: str) -> list[str]:
    """Return the tracks, arcs and vias of a coil of the export."""
    coil, items = winding(sensor, number), []
    for track in coil.tracks:
        points = 1e3 * track.points * (1, -1)
        if track.arcs:
            threes = zip(points[:-2:2], points[1:-1:2], points[2::2], strict=True)
            items += [draw.arc(*three, track.layer, net, 0.1) for three in threes]
        else:
            items += draw.lines(points, track.layer, net, 0.1)
    items += [draw.via(1e3 * hole.place * (1, -1), net=net) for hole in coil.holes]
    return items


def spiral(draw: Any, order: Sequence[int] | None = None) -> list[str]:
    """Return a square spiral of two turns on F.Cu, a way out on B.Cu, in an order and with directions of its own."""
    corners = [(0, 0), (10, 0), (10, 10), (0, 10), (0, 1), (9, 1), (9, 9), (1, 9)]
    out = [(1, 9), (-2, 9)]
    sides = zip(corners[:-1], corners[1:], strict=True)
    items = [draw.line(*(ends if k % 3 else ends[::-1])) for k, ends in enumerate(sides)]
    items += [draw.line(*out, "B.Cu"), draw.via((1, 9))]
    return [items[k] for k in order] if order is not None else items


@pytest.mark.parametrize("seed", range(5))
def test_a_spiral_in_any_order(draw: Any, seed: int) -> None:
    """Corners as drawn, from the pad of the lesser number, through the via; 10 + 10 + 10 + 9 + 9 + 8 + 8 and 3 mm."""
    items = spiral(draw, np.random.default_rng(seed).permutation(9).tolist())
    board = read_board(draw.board([*items, draw.pad("10", (-2, 9), layers='"B.Cu"'), draw.pad("9", (0, 0))]))
    found = route(of_net(board, "L1"), 1e-6)
    assert found.ends == ("J1.9", "J1.10") and [run.layer for run in found.runs] == ["F.Cu", "B.Cu"]
    expected = [(0, 0), (10, 0), (10, 10), (0, 10), (0, 1), (9, 1), (9, 9), (1, 9)]
    np.testing.assert_allclose(found.runs[0].points, 1e-3 * np.array(expected) * (1, -1), atol=1e-12)
    assert length(found) == pytest.approx(67e-3, rel=1e-12) and found.notes == ()


def test_without_pads_from_outside(draw: Any) -> None:
    """The end farther from the middle, named by its place as KiCad shows it."""
    found = route(of_net(read_board(draw.board(spiral(draw))), "L1"), 1e-6)
    assert found.ends == ("(-2.0000, 9.0000) mm on B.Cu", "(0.0000, 0.0000) mm on F.Cu")


@pytest.mark.parametrize("layers", [1, 2, 3, 4])
def test_the_exported_coil_comes_back(draw: Any, layers: int) -> None:
    """Each layer of the export is a run; its points lie on the exported spiral r(theta), which falls by r each turn.

    The arcs of the export leave the spiral by less than 1 um; they are taken with chords of 1 um.
    """
    sensor = changed(SENSOR, [f"coils.{coil.name}.layers={layers}" for coil in SENSOR.coils])
    items = drawn(draw, sensor, 0, "1")
    path = draw.board(items)
    if layers > 2:
        names = " ".join(f'({k} "{name}" signal)' for k, name in enumerate(layers_of_coil(layers)))
        path.write_text(re.sub(r"\(layers \(0.*\n", f"(layers {names})\n", path.read_text()))
    found = route(of_net(read_board(path), "L1"), 1e-6)
    sequence = [run.layer for run in found.runs]
    assert sequence in (list(layers_of_coil(layers)), list(layers_of_coil(layers))[::-1])
    coil, centre = sensor.coils[0], np.asarray(sensor.coils[0].centre)
    pitch = coil.track_width + coil.track_gap
    for run in found.runs:
        x, y = (run.points - centre).T
        r, theta = np.hypot(x, y), np.unwrap(np.arctan2(y, x))
        inside = (r > coil.inner_diameter / 2 + pitch) & (r < coil.outer_diameter / 2 - pitch)
        fall = np.polynomial.Polynomial.fit(theta[inside], r[inside], 1)
        assert np.ptp(theta[inside]) > 2 * np.pi * (coil.turns - 4)
        assert abs(fall.convert().coef[1]) == pytest.approx(pitch / (2 * np.pi), rel=1e-2)
        assert np.abs(r[inside] - fall(theta[inside])).max() < 2.5e-6


def test_a_placed_footprint_is_a_coil(draw: Any, tmp_path: Any) -> None:
    """Lines of a footprint belong to no net: those of coil 1 go with the net of pad 1, from pad 1 to pad 2."""
    write_kicad(Source(SENSOR, None), tmp_path / "coils.kicad_mod")  # type: ignore[arg-type]
    text = (tmp_path / "coils.kicad_mod").read_text()
    text = text.replace("(version 20221018) (generator sits_mech)", "")
    text = text.replace('(layer "F.Cu")\n', '(layer "F.Cu") (at 100 50 30) (property "Reference" "L7" (at 0 0))\n', 1)
    for number, net in ((1, 1), (2, 2), (3, 3)):
        start = text.index(f'(pad "{number}"')
        end = text.index("\n", start)
        text = text[: end - 1] + f" (net {net}))" + text[end:]
    lead = draw.line((60, 50), (100, 50))  # elsewhere on the net, not joined: another footprint's business
    board = read_board(draw.board([text]))
    found = route(of_net(board, "L1"), 1e-6)
    assert found.ends == ("L7.1", "L7.2") and [run.layer for run in found.runs] == ["F.Cu", "B.Cu"]
    items = drawn(draw, SENSOR, 0, "1")
    alone = route(of_net(read_board(draw.board(items)), "L1"), 1e-6)
    assert length(found) == pytest.approx(length(alone), rel=1e-7)
    turn = np.radians(30)
    c, s = np.cos(turn), np.sin(turn)
    middle = found.runs[0].points[200:-200].mean(axis=0)
    centre = (0.1, -0.05) + np.array([[c, -s], [s, c]]) @ np.asarray(SENSOR.coils[0].centre)
    np.testing.assert_allclose(middle, centre, atol=1e-4)
    with pytest.raises(SceneError, match="2 pieces"):
        route(of_net(read_board(draw.board([text, lead])), "L1"), 1e-6)


def test_widths_part_runs_and_the_rest_beyond_pads_is_told(draw: Any) -> None:
    """Widths that differ by a tenth of a percent are one run, of their mean by length; leads go with their pads."""
    tracks = [draw.line((0, 0), (10, 0), width=0.29997), draw.line((10, 0), (10, 20), width=0.3)]
    thick = draw.line((10, 20), (0, 20), width=0.4)
    leads = [draw.line((0, 0), (0, -3)), draw.line((0, 0), (-4, 0))]
    path = draw.board([*tracks, thick, *leads, draw.pad("1", (0, 0)), draw.pad("2", (0, 20))])
    found = route(of_net(read_board(path), "L1"), 1e-6)
    assert [run.width for run in found.runs] == pytest.approx([(0.29997e-3 + 0.6e-3) / 3, 0.4e-3], rel=1e-12)
    np.testing.assert_array_equal(found.runs[0].points[-1], found.runs[1].points[0])
    assert found.notes == (f"{path}: net L1: left out beyond pads: 2 pieces of 7 mm together",)


def test_runs_meet_in_the_middle_of_a_via(draw: Any) -> None:
    """An end 0.04 mm off is moved there, one 0.15 mm off led there: a quarter of the width is 0.05 mm."""
    items = [draw.line((0, 0), (4.96, 0)), draw.line((5, 0.2), (5, 9), "B.Cu"), draw.via((5, 0))]
    runs = route(of_net(read_board(draw.board(items)), "L1"), 1e-6).runs
    first, second = sorted(runs, key=lambda run: run.layer != "F.Cu")
    assert {tuple(p) for p in np.round(1e3 * first.points, 6).tolist()} == {(0, 0), (5, 0)}
    assert {tuple(p) for p in np.round(1e3 * second.points, 6).tolist()} == {(5, 0), (5, -9)}
    bent = [items[0], draw.line((5.15, 0), (5.15, 9), "B.Cu"), items[2]]
    second = next(run for run in route(of_net(read_board(draw.board(bent)), "L1"), 1e-6).runs if run.layer == "B.Cu")
    assert {tuple(p) for p in np.round(1e3 * second.points, 6).tolist()} == {(5, 0), (5.15, 0), (5.15, -9)}


def test_straight_tracks_keep_their_lines(draw: Any) -> None:
    """Arcs between them that end 9 nm aside do not tilt them: parallel tracks stay so, to the last digit."""
    arc = draw.arc((9, 0.000009), (9.7071, 0.29289), (10.000009, 1))
    board = read_board(draw.board([draw.line((0, 0), (9, 0)), arc, draw.line((10, 1), (10, 8))]))
    points = route(of_net(board, "L1"), 1e-6).runs[0].points
    np.testing.assert_array_equal(np.round(1e3 * points[[0, 1, -2, -1]], 9), [[0, 0], [9, 0], [10, -1], [10, -8]])


def test_two_coils_of_one_net_are_not_guessed(draw: Any) -> None:
    """Of 20 and of 15 mm, on one pad."""
    path = draw.board([draw.line((0, 0), (20, 0)), draw.line((0, 0), (0, 15)), draw.pad("1", (0, 0))])
    expected = (
        "must have one track much longer than others between pads; got two, from (20.0000, 0.0000) mm on F.Cu to J1.1 "
        "and from (0.0000, 15.0000) mm on F.Cu to J1.1"
    )
    with pytest.raises(SceneError, match=re.escape(expected)):
        route(of_net(read_board(path), "L1"), 1e-6)


def test_careless_boards_are_joined_where_they_must(draw: Any) -> None:
    """As on a published antenna: arcs 3 um long beside the track that they should join, ends 8 um off, in copper."""
    careful = [draw.line((0, 0), (10, 0), width=0.3), draw.line((10, 0), (20, 5), width=0.3)]
    dirt = [
        draw.line((10, 0), (10.003, 0.0011), width=0.3),
        draw.arc((10, 0), (10.0013, 0.0006), (10.0028, 0.001), width=0.3),
        draw.arc((10.0028, 0.001), (10.0053, 0.002), (10.008, 0.003), width=0.3),
    ]
    found = route(of_net(read_board(draw.board([*careful, *dirt])), "L1"), 1e-6)
    assert length(found) == pytest.approx(1e-3 * (10 + np.hypot(10, 5)), rel=1e-3)
    assert len(found.runs) == 1 and len(found.runs[0].points) <= 4


def test_short_steps_do_not_shrink_to_a_point(draw: Any) -> None:
    """A circle in steps of 8 um beside a branch, tracks of 0.2 mm: refused, not taken for the branch alone."""
    angle = np.linspace(0, 2 * np.pi * 0.99, 800)
    ring = np.column_stack([np.cos(angle), np.sin(angle)]).tolist()
    items = [*draw.lines(ring), draw.line((1, 0), (9, 0)), draw.line((1, 0), (9, 5))]
    with pytest.raises(SceneError, match="without branches; got 3 tracks"):
        route(of_net(read_board(draw.board(items)), "L1"), 1e-6)


T = [(0, 0), (5, 0), (9, 0)]


@pytest.mark.parametrize(
    ("items", "expected"),
    [
        (lambda d: [], "net L1: must have tracks, or copper drawn to its pads; got none"),
        (lambda d: [d.line((3, 4), (3, 4))], "net L1: must have tracks; got none that leads from one place to another"),
        (
            lambda d: [*d.lines(T), d.line((5, 0), (5, 4))],
            "net L1: must be one path without branches; got 3 tracks that meet at (5.0000, 0.0000) mm on F.Cu",
        ),
        (
            lambda d: d.lines([(0, 0), (5, 0), (5, 5), (0, 0)]),
            "net L1: must be one path with two ends; got a loop through (0.0000, 0.0000) mm on F.Cu",
        ),
        (
            lambda d: [*d.lines(T), d.line((5, 0), (5, 4), "B.Cu"), d.via((5, 0))],
            "got 3 tracks that meet at (5.0000, 0.0000) mm",
        ),
        (
            lambda d: [d.line((0, 0), (5, 0)), d.line((6, 1), (9, 1))],
            "net L1: must be one track from end to end; got 2 pieces, apart between (5.0000, 0.0000) mm "
            "and (6.0000, 1.0000) mm",
        ),
        (lambda d: [d.arc((3, 4), (3, 4), (3, 4))], "net L1: the arc at (3.0000, 4.0000) mm must have a radius"),
        (lambda d: [d.line((0, 0), (5, 0), width=0)], "net L1: the track at (0.0000, 0.0000) mm must have a width"),
    ],
)
def test_what_is_no_coil(draw: Any, items: Any, expected: str) -> None:
    """One line: the board, the net, what it must be, where it is not."""
    path = draw.board(items(draw))
    with pytest.raises(SceneError, match=re.escape(f"{path}: ") + ".*" + re.escape(expected)) as caught:
        route(of_net(read_board(path), "L1"), 1e-6)
    assert "\n" not in str(caught.value)


def test_the_nearest_nets_are_named(draw: Any) -> None:
    """Those most like it."""
    few: Board = read_board(draw.board([]))
    with pytest.raises(SceneError, match='--net: .* must be a net of the board, such as L1; got "l1"'):
        route(of_net(few, "l1"), 1e-6)
    many = " ".join(f'(net {k} "/sheet/N{k}")' for k in range(1, 40)) + '(net 50 "/Probe/COIL_A")'
    with pytest.raises(SceneError, match="must be a net of the board, such as /Probe/COIL_A; got \"coil_a\""):
        route(of_net(read_board(draw.board([], nets=many)), "coil_a"), 1e-6)
