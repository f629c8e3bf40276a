"""Help that was printed before: the same text, until something that it depends on has changed."""

import os
import sys
from pathlib import Path

import pytest

from sits_mech.cli import kept_help
from sits_mech.cli.main import run
from sits_mech.disk_cache import VARIABLE


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where help is kept."""
    monkeypatch.setenv(VARIABLE, str(tmp_path / "kept"))
    return tmp_path / "kept"


@pytest.mark.parametrize("words", [[], ["--help"], ["adapt", "--help"]])
def test_the_second_time_it_is_the_same(folder: Path, words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """To the letter, from a file; of other words nothing is known."""
    assert kept_help.kept_help(words) is None and run(words) == 0
    first = capsys.readouterr().out
    assert "sits-mech" in first and kept_help.kept_help(words) == first
    assert run(words) == 0 and capsys.readouterr().out == first
    assert kept_help.kept_help(["lot", "--help"]) is None and len(list(folder.iterdir())) == 1


@pytest.mark.parametrize("change", ["width", "path", "module", "damage"])
def test_what_has_changed_is_made_anew(folder: Path, monkeypatch: pytest.MonkeyPatch, change: str) -> None:
    """Another terminal, packages installed since, a module with commands that was written anew, a broken file."""
    monkeypatch.syspath_prepend(str(folder.parent))
    assert run(["adapt", "--help"]) == 0 and kept_help.kept_help(["adapt", "--help"])
    path = folder / "help-adapt-help.txt"
    if change == "width":
        monkeypatch.setenv("COLUMNS", "60")
    elif change == "path":
        os.utime(sys.path[0], (1.0, 1.0))
    elif change == "module":
        path.write_text(path.read_text().replace("built.py|", "built.py|1"))
    else:
        path.write_bytes(b"\xff" + path.read_bytes())
    assert kept_help.kept_help(["adapt", "--help"]) is None


def test_nothing_is_kept_where_nothing_may_be(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Switched off, or a folder that cannot be made."""
    (tmp_path / "file").write_text("")
    for where in ("off", str(tmp_path / "file" / "kept")):
        monkeypatch.setenv(VARIABLE, where)
        assert run(["--help"]) == 0 and kept_help.kept_help(["--help"]) is None


def test_no_help_is_no_answer(folder: Path) -> None:
    """An unknown command is refused, and not kept."""
    assert run(["nothing", "--help"]) == 2 and not folder.exists()
