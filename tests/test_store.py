"""Rows on disk: one file for a sweep, of one run at a time; killed, edited or damaged."""

import os
import shutil
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest

from sits_mech.cases import solve_cases
from sits_mech.store import STORE, claimed, opened
from sits_mech.units import SceneError

ROW = {"status": "ok", "reason": "", "lasting": True, "c": 0.1 + 0.2, "seconds": 1.0}
KILLED = """
import os, signal, sys
from pathlib import Path
from sits_mech.cases import solve_cases

def end(done, of):
    if done == 5:
        os.kill(os.getpid(), signal.SIGKILL)

solve_cases(lambda a: {"c": a / 7.0}, {"a": [float(a) for a in range(9)]}, folder=Path(sys.argv[1]), progress=end)
"""


def test_rows_are_kept_to_the_last_digit(tmp_path: Path) -> None:
    """All of a transaction or none; what another try may give is not kept."""
    with opened(tmp_path / "new") as cases:
        cases.put([("a", ROW), ("b", ROW | {"lasting": False})])
        with pytest.raises(KeyError):
            cases.put([("c", ROW), ("d", {})])
    with opened(tmp_path / "new") as cases:
        assert cases.names == {"a"} and cases.get("a") == ROW and cases.get("b") is None


@pytest.mark.parametrize("change", ["row = replace(row, '0.3', '0.4')", "row = 'torn'", "row = NULL", "sha256 = x'00'"])
def test_a_row_that_was_changed_is_none(change: str, tmp_path: Path) -> None:
    """Whatever was changed of it."""
    with opened(tmp_path) as cases:
        cases.put([("a", ROW), ("b", ROW)])
        cases.file.execute(f"UPDATE cases SET {change} WHERE name = 'a'")
        cases.file.commit()
        assert cases.get("a") is None and cases.get("b") == ROW


def test_a_run_has_its_folder_alone(tmp_path: Path) -> None:
    """The other is told so in one line; with the end of the first, however it ends, it is free."""
    with opened(tmp_path):
        with pytest.raises(SceneError, match=f"{tmp_path}: must be the folder of one run at a time; another"):
            with opened(tmp_path):
                pass
    with opened(tmp_path):
        pass


def test_a_folder_is_one_run_s_and_stays(tmp_path: Path) -> None:
    """A second claim is refused, a later one is not; a run whose folder went stops with its next case."""
    with claimed(tmp_path):
        with pytest.raises(ValueError, match="must be the folder of one run at a time"), claimed(tmp_path):
            pass
    with claimed(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []
    with opened(tmp_path / "out") as cases:
        shutil.rmtree(tmp_path / "out")
        with pytest.raises(ValueError, match="out: must stay while the run goes on; it was removed"):
            cases.put([("a", {"lasting": True})])


def test_what_is_no_store_is_refused(tmp_path: Path) -> None:
    """One line that names the file, which stays as it is."""
    (tmp_path / STORE).write_text("words " * 1000)
    with pytest.raises(SceneError, match="cases.sqlite: must be a file of cases that can be written; got: file is"):
        with opened(tmp_path):
            pass
    assert (tmp_path / STORE).read_text() == "words " * 1000
    with pytest.raises(SceneError, match="must be a file of cases that can be written; got: "):
        with opened(tmp_path / STORE / "within"):
            pass


def test_what_a_killed_process_had_finished_is_there(tmp_path: Path) -> None:
    """After SIGKILL the lock is gone, five rows are kept, and the other four alone are computed."""
    done = subprocess.run([sys.executable, "-c", KILLED, str(tmp_path)], timeout=60, env=os.environ)
    assert done.returncode == -signal.SIGKILL
    asked = list[float]()

    def seventh(a: float) -> dict[str, float]:
        asked.append(a)
        return {"c": a / 7.0}

    found = solve_cases(seventh, {"a": [float(a) for a in range(9)]}, folder=tmp_path)
    assert asked == [5.0, 6.0, 7.0, 8.0] and found["c"].to_numpy().tolist() == [a / 7.0 for a in range(9)]


def test_a_full_disk_is_told(tmp_path: Path) -> None:
    """What was kept before stays, and nothing is half there."""
    with opened(tmp_path) as cases:
        cases.put([("a", ROW)])
        cases.file.execute("PRAGMA max_page_count = 4")
        with pytest.raises(SceneError, match="cases.sqlite: must be a file .* got: database or disk is full"):
            cases.put([("b", ROW), ("c", ROW | {"reason": "long " * 10_000})])
        assert cases.names == {"a"}


def test_a_store_is_an_sqlite_file(tmp_path: Path) -> None:
    """Any program that reads such files reads the rows."""
    with opened(tmp_path) as cases:
        cases.put([("a", ROW)])
    file = sqlite3.connect(tmp_path / STORE)
    assert file.execute("SELECT json_extract(row, '$.c') FROM cases").fetchall() == [(ROW["c"],)]
    file.close()
