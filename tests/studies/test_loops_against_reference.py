"""References of loops: the stored histories, their figures, the comparison and its picture."""

import json

import numpy as np
import pytest
from benchmarks.loops_against_reference import STORED, draw, loop_of, row_of, stored_histories
from common.history_cases import PADS, PATHS, takes, wrenches

HISTORIES = {one.name: one for one in stored_histories()}


def test_stored_histories_are_those_of_the_cases():
    """Scene, times and loads of each row are what pad and path say now: what changes asks for its reference again."""
    cases = {f"{pad.name}: {name}": (pad, path) for pad in PADS for name, path in PATHS.items() if takes(pad, path)}
    assert set(HISTORIES) <= set(cases) and json.loads(STORED.read_text("utf-8"))["what"]
    for name, one in HISTORIES.items():
        pad, path = cases[name]
        assert list(one.changes) == pad.changes and one.lever == pytest.approx(0.5e-3 * pad.target[0])
        assert one.time == pytest.approx(path.times(), abs=1e-9)
        assert one.load == pytest.approx(wrenches(pad, path, path.times())[:, :2], rel=1e-8, abs=1e-12)
        most = 6e-3 if name.startswith("5 x 5") else 3e-3  # of the box there are two meshes alone
        assert one.moved.shape == (one.time.size, 3) and 0.0 < one.error < most


def test_times_meet_the_corners_and_steps_are_divided():
    """Corners are among the times, also of divided steps, and each recorded time among those."""
    for path in PATHS.values():
        times = path.times()
        assert np.isin(np.round(path.time, 9), np.round(times, 9)).all() and np.diff(times).min() > 0.0
        assert path.times(4)[::4] == pytest.approx(times, abs=1e-12)


def test_a_spring_loses_nothing_and_a_lag_its_area():
    """Force and motion in phase: no area; a quarter of a turn apart: pi times both sizes, counter-clockwise."""
    one = next(iter(HISTORIES.values()))
    phase = np.linspace(0.0, 2.0 * np.pi, 2001)
    load = np.stack([0.0 * phase, np.sin(phase)], axis=1)
    circle = type(one)(**{**vars(one), "time": phase, "load": load, "moved": np.zeros((phase.size, 3)), "height": 0.0})
    for moved, area in ((np.sin(phase), 0.0), (-np.cos(phase), np.pi)):
        motion = np.stack([0.0 * phase, moved, 0.0 * phase], axis=1)
        named = type(one)(**{**vars(circle), "moved": motion})
        found = loop_of(named, motion)
        assert found.area == pytest.approx(area, abs=1e-5) and found.peak == pytest.approx(1.0, abs=1e-6)
        assert found.residual == pytest.approx(moved[-1])


def test_a_turn_moves_the_point_of_the_load():
    """F_x at a height works on ``d_h + height sin(alpha)``, F_z on ``sink + height (1 - cos(alpha))``."""
    one = next(iter(HISTORIES.values()))
    times = np.array([0.0, 1.0])
    turned = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.3]])
    for load, work in (((2.0, 0.0), 2.0 * 0.1 * np.sin(0.3)), ((0.0, 2.0), 0.2 * (1.0 - np.cos(0.3)))):
        held = type(one)(**{**vars(one), "time": times, "load": np.array([load, load]), "moved": turned, "height": 0.1})
        assert loop_of(held, turned).area == pytest.approx(work)


@pytest.mark.slow
def test_the_first_press_of_a_softened_layer(tmp_path):
    """Half of a history, loaded and let go: within its error and the reference's of NGSolve, and drawn."""
    one = HISTORIES["layer 10 x 5, Yeoh, softened: two triangles"].first(21)
    row, found = row_of(one, 1e-2)
    assert row["pose off"] < 5e-3 and abs(row["area off"]) < 0.02 and row["status"] == ""
    draw([(one, found)], tmp_path / "loops.png")
    assert (tmp_path / "loops.png").stat().st_size > 10_000
