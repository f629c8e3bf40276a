"""Is any malformed input, and any command line, one line or an answer: no traceback, no hang, no wrong exit code?"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from benchmarks import malformed

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits of a process as Linux has them")
STUDIES = Path(malformed.__file__).parents[1]


@pytest.mark.slow
@pytest.mark.parametrize(
    "asked",
    [
        pytest.param("--inputs 16 --lines 10", id="sample"),
        pytest.param("--seed 2 --case input-19 --case input-31 --case input-37", id="mended"),
    ],
)
def test_no_case_is_at_fault(asked: str, tmp_path: Path) -> None:
    """A sample of the study's cases, and those mended since: straight tracks summed for a minute, 7 GiB of matrices.

    In a process of its own: what this one holds by then counts as memory of its children.
    """
    command = [sys.executable, "-m", "benchmarks.malformed", *asked.split(), "--output", str(tmp_path / "made")]
    done = subprocess.run(command, cwd=STUDIES, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    ("said", "fault"),
    [
        (malformed.Reply(0, '{"flags": ["ok"]}'), ""), (malformed.Reply(2, "", "error: x\n"), ""),
        (malformed.Reply(4, '{"flags": ["above tolerance"]}'), ""), (malformed.Reply(130), "exit code 130"),
        (malformed.Reply(2), "0 lines of error with exit code 2"), (malformed.Reply(0, "x"), "no JSON"),
        (malformed.Reply(0, '{"flags": ["beyond data"]}'), "exit code 0 of ['beyond data']"),
        (malformed.Reply(3, "", "RuntimeWarning: overflow"), "warning"),
    ],
)
def test_what_is_a_fault(said: malformed.Reply, fault: str) -> None:
    """The reader of exit codes and words sees each fault, and none in a good end."""
    found = malformed.answer_faults(["pose", "biorob2018", "--json"], said)
    assert [what for what, is_so in found.items() if is_so] == [fault] * bool(fault)
