"""Is any malformed input one line or an answer: no traceback, nothing above 2 GiB or 10 s of processor time?"""

from __future__ import annotations

import contextlib
import importlib
import io
import os
import pkgutil
import sys
from pathlib import Path

import pytest
from common.children import GIB, asked_apart
from extreme.malformed import malformed

import sits_mech
from sits_mech.cli.main import run

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits of a process as Linux has them")
SECONDS, MEMORY = 10.0, 2.0  # processor time, GiB
FAST, ALL, PART = 24, 2000, 104


@pytest.fixture(scope="module", autouse=True)
def imported() -> None:
    """Import what commands import, so that children need not."""
    for module in pkgutil.walk_packages(sits_mech.__path__, "sits_mech."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)


def answered(number: int, folder: Path) -> tuple[int, str, str]:
    """Return exit code, what was said, and what was raised, of an input."""
    folder.mkdir()
    os.chdir(folder)
    said = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
        try:
            return run(malformed(number, folder)), said.getvalue(), ""
        except BaseException as error:  # whatever comes through is what is looked for
            return -1, said.getvalue(), repr(error)


def fault(number: int, folder: Path) -> str:
    """Return what is wrong with the answer to an input; empty where it is as it must be."""
    end = asked_apart(lambda: answered(number, folder), seconds=2.0 * SECONDS, gib=64.0)
    code, said, raised = end.value or (-2, "", "")
    lines = sum(line.startswith("error: ") for line in said.splitlines())
    found = {
        end.killed: bool(end.killed), raised: bool(raised), f"{end.seconds:.1f} s": end.seconds > SECONDS,
        f"{end.peak / GIB:.1f} GiB": end.peak > MEMORY * GIB, f"exit {code}": code not in (0, 2, 3, 4),
        f"{lines} lines of errors": code == 2 and lines != 1,
    }  # fmt: skip
    return ", ".join(what for what, is_so in found.items() if is_so)


def faults(numbers: range, folder: Path) -> dict[int, str]:
    """Return what is wrong with the answers to inputs, by number."""
    return {number: why for number in numbers if (why := fault(number, folder / str(number)))}


def test_sample_of_malformed_inputs(tmp_path: Path) -> None:
    assert faults(range(FAST), tmp_path) == {}


@pytest.mark.slow
@pytest.mark.parametrize("first", range(FAST, ALL, PART))
def test_malformed_inputs(first: int, tmp_path: Path) -> None:
    assert faults(range(first, min(first + PART, ALL)), tmp_path) == {}
