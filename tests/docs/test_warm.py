"""Commands answered by one process: as if each was started by itself."""

import os
import subprocess
import time
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


@pytest.mark.slow
def test_a_file_of_python_is_answered_as_by_itself(tmp_path: Path) -> None:
    """It finds what lies beside it and on PYTHONPATH; what it raises is told, and Python without a file is Python."""
    (tmp_path / "more").mkdir()
    (tmp_path / "more" / "far.py").write_text("here = 2\n")
    (tmp_path / "near.py").write_text("here = 1\n")
    (tmp_path / "own.py").write_text(
        "import sys, near, far\nprint(__name__, sys.argv, near.here + far.here)\nsys.exit(5)\n"
    )
    (tmp_path / "bad.py").write_text("raise ValueError('so')\n")
    asked = 'PYTHONPATH=more python own.py a; echo "$?"; python bad.py; echo "$?"; python -c "print(7)"'
    with started():
        done = subprocess.run(["bash", "-c", asked], cwd=tmp_path, capture_output=True, text=True)
    words = [str(tmp_path / "own.py"), "a"]  # by its whole path, which processes that it starts ask for
    assert done.stdout.splitlines() == [f"__main__ {words} 3", "5", "1", "7"]
    assert done.stderr.endswith("ValueError: so\n")


@pytest.mark.slow
def test_a_file_that_is_stopped_ends(tmp_path: Path) -> None:
    """What answers for it ends with it."""
    left = tmp_path / "left"
    tells = f"open({str(left)!r}, 'w').write(f'{{os.getpid()}};')"
    (tmp_path / "long.py").write_text(f"import os, time\n{tells}\ntime.sleep(60)\n")
    with started(), subprocess.Popen(["python", "long.py"], cwd=tmp_path) as process:
        while not (left.exists() and left.read_text().endswith(";")):
            time.sleep(0.1)
        process.terminate()
        assert process.wait(10) != 0
        time.sleep(0.5)
        with pytest.raises(ProcessLookupError):
            os.kill(int(left.read_text()[:-1]), 0)
