"""Is any malformed input, and any command line, one line or an answer: no traceback, no hang, no wrong exit code?"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

import malformed
import pytest

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits of a process as Linux has them")
FAST, ALL, PART = {"input": 16, "line": 10}, {"input": 2000, "line": 1000}, 100
PARTS = [(half, first) for half, count in ALL.items() for first in range(FAST[half], count, PART)]


@pytest.fixture(scope="module")
def sound() -> Iterator[Path]:
    """Sound files in a process that has imported what commands import."""
    with malformed.warm() as folder:
        yield folder


def faults(half: str, numbers: Iterable[int], folder: Path, sound: Path) -> dict[str, str]:
    """Return what is wrong with the ends of cases, by their names; of those that are not known to be at fault."""
    cases = [case for case in (f"{half}-{number}" for number in numbers) if (0, case) not in malformed.OPEN]
    ends = (malformed.outcome(case, 0, folder / case, sound) for case in cases)
    return {end.case: end.fault for end in ends if end.fault}


@pytest.mark.slow
@pytest.mark.parametrize("half", FAST)
def test_sample(half: str, tmp_path: Path, sound: Path) -> None:
    assert faults(half, range(FAST[half]), tmp_path, sound) == {}


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "case"), [(0, "input-5"), (2, "input-19"), (2, "input-31"), (2, "input-37")])
def test_mended(seed: int, case: str, tmp_path: Path, sound: Path) -> None:
    """A target 995 m thick, of which near matrices took 7 GiB; straight tracks summed for a minute."""
    assert malformed.outcome(case, seed, tmp_path / case, sound).fault == ""


@pytest.mark.slow
@pytest.mark.parametrize(("half", "first"), PARTS)
def test_all(half: str, first: int, tmp_path: Path, sound: Path) -> None:
    assert faults(half, range(first, min(first + PART, ALL[half])), tmp_path, sound) == {}


@pytest.mark.parametrize(
    ("said", "fault"),
    [
        (malformed.Said(0, '{"flags": ["ok"]}'), ""), (malformed.Said(2, "", "error: x\n"), ""),
        (malformed.Said(4, '{"flags": ["above tolerance"]}'), ""), (malformed.Said(130), "exit code 130"),
        (malformed.Said(2), "0 lines of error with exit code 2"), (malformed.Said(0, "x"), "no JSON"),
        (malformed.Said(0, '{"flags": ["beyond data"]}'), "exit code 0 of ['beyond data']"),
        (malformed.Said(3, "", "RuntimeWarning: overflow"), "warning"),
    ],
)
def test_what_is_a_fault(said: malformed.Said, fault: str) -> None:
    """The reader of exit codes and words sees each fault, and none in a good end."""
    found = malformed.answer_faults(["pose", "biorob2018", "--json"], said)
    assert [what for what, is_so in found.items() if is_so] == [fault] * bool(fault)
