"""Commands answered by one process: as if each was started by itself."""

import os
import subprocess
from pathlib import Path

import pytest
from warm import started


@pytest.mark.slow
def test_a_command_is_answered_as_by_itself(tmp_path: Path) -> None:
    """In its folder, its streams apart, with its exit code; twice the same, and the path is as before afterwards."""
    asked = 'sits-mech pose mine.toml --json > out.json 2> err.txt; echo "$?"; sits-mech catalog | head -n 1'
    before, printed = os.environ["PATH"], []
    with started():
        for _ in range(2):
            printed.append(subprocess.run(["bash", "-c", asked], cwd=tmp_path, capture_output=True, text=True).stdout)
    assert os.environ["PATH"] == before
    assert printed[0] == printed[1]
    code, title = printed[0].splitlines()
    assert (code, title.strip()) == ("2", "sensors")
    assert (tmp_path / "err.txt").read_text().startswith("error: mine.toml: must be a readable scene file")
    assert (tmp_path / "out.json").read_text() == ""
