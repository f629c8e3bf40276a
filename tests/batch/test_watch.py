"""How far a sweep is: told from its table while a run has the folder, and when none has it."""

import os
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.batch.run import TABLE
from sits_mech.batch.watch import is_taken, watched
from sits_mech.cli.main import run
from sits_mech.store import opened, save_table

NOTHING = ["unfinished", ""]


def table(folder: Path, rows: list[list[str]], when: float) -> None:
    """Write a table of cases, status and reason of each, as of a time."""
    states, reasons = np.array(rows).T
    save_table(xr.Dataset({"status": ("case", states), "reason": ("case", reasons)}), folder / TABLE)
    os.utime(folder / TABLE, (when, when))


def test_a_run_is_watched_to_its_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cases, rate, time left by hand; failures that differ in numbers are one kind; nothing is disturbed."""
    with opened(tmp_path):
        lines = watched(tmp_path, 0.0)
        assert next(lines).startswith("no table yet")
        table(tmp_path, [["ok", ""], *[NOTHING] * 99], 1000.0)
        assert next(lines) == "1 of 100 cases"
        failed = [["failed", f"must be above 1e-{k} mm, is -{k}.5"] for k in range(3)] + [["not carried", "rolls over"]]
        table(tmp_path, [["ok", ""]] * 17 + failed + [NOTHING] * 79, 1010.0)
        assert next(lines) == "21 of 100 cases, 2 a second, some 0:00:40 left; 4 failed"
        assert [next(lines), next(lines)] == ["  3 failed: must be above # mm, is #", "  1 not carried: rolls over"]
        assert is_taken(tmp_path)
        table(tmp_path, [["ok", ""]] * 20 + failed + [NOTHING] * 76, 1011.0)
        assert next(lines).startswith("24 of 100 cases, 2.09 a second")
    whole = [["ok", ""]] * 96 + failed  # written just after the file of cases was left
    left = iter([lambda: None, lambda: table(tmp_path, whole, 1020.0)])
    monkeypatch.setattr("time.sleep", lambda pause: next(left)())
    assert not is_taken(tmp_path) and list(lines) == ["100 of 100 cases; 4 failed", "all cases are done"]


def test_groups_that_are_under_way(tmp_path: Path) -> None:
    """Cases of one scene, those that are done in one number; nothing where each case is a scene of its own."""
    states = np.full((4, 5), "unfinished", dtype=object)
    states[1], states[2, :3] = "ok", "failed"
    along = {"target.width": [8e-3, 9e-3, 1e-2, 1.1e-2], "dv": range(5)}
    data = xr.Dataset({"status": (tuple(along), states), "reason": (tuple(along), np.full((4, 5), ""))}, along)
    with opened(tmp_path):
        save_table(data, tmp_path / TABLE)
        lines = watched(tmp_path, 0.0)
        assert next(lines) == "8 of 20 cases; 3 failed"
        assert [next(lines) for _ in range(3)] == ["  target.width: 1 of 4 done", "  0.01: 3 of 5", "  3 failed: "]
        os.utime(tmp_path / TABLE, (1e9, 1e9))
        save_table(data.isel(dv=[0]), tmp_path / TABLE)
        assert next(lines).startswith("2 of 4 cases") and next(lines) == "  1 failed: "


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A sweep that was stopped goes on by its own command; no sweep is refused in one line."""
    with opened(tmp_path):
        pass
    table(tmp_path, [["ok", ""], NOTHING], 1000.0)
    assert run(["sweep", str(tmp_path), "--watch"]) == 0
    assert capsys.readouterr().out == "1 of 2 cases\nno run has this folder: its command goes on from here\n"
    assert run(["sweep", str(tmp_path / "none"), "--watch"]) == 2
    assert "must be the folder of a sweep" in capsys.readouterr().err and not (tmp_path / "none").exists()
