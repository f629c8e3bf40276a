"""Is any malformed input, and any command line, an answer or one line? No traceback, no hang, no wrong exit code.

Inputs (extreme/malformed.py): scenes at the ends of what the loader accepts and beyond, random ones, files of every
kind damaged (extreme/damaged.py: cut short, swapped, enormous), odd options, studies, requirements. Command lines
(extreme/command_lines.py): the examples of all commands with words left out, repeated, swapped, added or odd. Each runs
in a forked child of one process that has all imported, so that it costs what it costs. What is a fault:

    raised, warned    an exception that comes through, a warning of Python
    stopped, late     more than 20 s of processor time, or fifteen times that by the clock; more than 2 GiB, where
                      steps are asked to keep to 3 s and 1 GiB (SITS_MECH_SECONDS, SITS_MECH_MEMORY)
    exit code         none of 0, 2, 3, 4; one that is not that of the status; 2 without one line of error
    answer            not JSON where that was asked for

Run ``python -m benchmarks.malformed [--coarse] [--seed 0] [--first 0] [--inputs 2000] [--lines 1000] --output DIR``:
`malformed.csv` by kind (how many, how many of them came to a solver, exit codes, the worst seconds and memory) and
`faults.csv` with the command that repeats each: the same with ``--case input-17``, which leaves its files in DIR. One
that is stopped keeps the cases until then; ``--first`` goes on. A fault that is not known (`OPEN`) ends
it with exit code 1.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import mmap
import os
import pkgutil
import shlex
import shutil
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any
from unittest.mock import patch

from common.children import GIB, asked_apart
from common.outputs import write_rows
from extreme.malformed import malformed
from extreme.sound import sound_files

import sits_mech
from sits_mech.cli.main import run
from sits_mech.status import exit_code

SECONDS, MEMORY = 20.0, 2.0  # processor time, GiB
LIMITS = {"SITS_MECH_SECONDS": "3", "SITS_MECH_MEMORY": "1", "SITS_MECH_CACHE": "off"}
"""What is asked of the program; the seconds are of a step, of which an answer may have six."""
COARSE = 6  # of each
OPEN: set[tuple[int, str]] = set()
"""Faults that are known and not mended, by seed and case: they are told and do not end it with code 1."""
CODES = (0, 2, 3, 4)
SOLVES = {"equilibrium": "mechanics", "impedance": "magnetics"}  # methods of models, and their rooms
EXTRAS = ("matplotlib.backends.backend_agg", "matplotlib.backends.backend_svg", "openpyxl", "pandas")
_reached = mmap.mmap(-1, 1)
"""One byte that children share: whether a model was asked."""


@dataclass(frozen=True)
class Outcome:
    """How a case ended: its kind and words, its exit code, whether it came to a solver, what it took, what is wrong."""

    case: str
    kind: str
    words: tuple[str, ...]
    code: int
    reached: bool
    seconds: float
    gib: float
    fault: str


@dataclass(frozen=True)
class Reply:
    """What a command left: exit code, stdout, stderr, and what was raised."""

    code: int = -1
    out: str = ""
    err: str = ""
    raised: str = ""


@contextlib.contextmanager
def warm() -> Iterator[Path]:
    """Yield a folder of sound files; what commands import is imported then, and models tell that they are asked."""
    own = (found.name for found in pkgutil.walk_packages(sits_mech.__path__, "sits_mech."))
    for name in (*own, *EXTRAS):
        if not name.endswith("__main__"):
            import_module(name)
    with contextlib.ExitStack() as kept:  # what is changed here is as it was afterwards
        kept.enter_context(patch.dict(os.environ, LIMITS))
        kept.enter_context(patch("sits_mech.studio.page.serve", lambda *words, **more: None))  # it serves until Ctrl-C
        place = kept.enter_context(tempfile.TemporaryDirectory())
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            sound = sound_files(Path(place))
        for model, method in _asked_models():
            kept.enter_context(patch.object(model, method, _telling(getattr(model, method))))
        yield sound


def _asked_models() -> set[tuple[type, str]]:
    """Return the models of both physics, each with the method that asks it."""
    return {
        (each, method) for module in list(sys.modules.values()) for each in list(vars(module).values())
        for method, room in SOLVES.items()
        if isinstance(each, type) and str(each.__module__).startswith(f"sits_mech.{room}.") and method in vars(each)
    }


def _telling(method: Any) -> Any:
    """Return a method that sets the shared byte."""

    def counted(*words: Any, **more: Any) -> Any:
        _reached[0] = 1
        return method(*words, **more)

    return counted


def reply_to(words: Sequence[str], folder: Path) -> Reply:
    """Return what a command leaves that runs in a folder."""
    os.chdir(folder)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code, raised = run(words), ""
        except BaseException as error:  # whatever comes through is what is looked for
            code, raised = -1, repr(error)[:300]
    return Reply(code, out.getvalue(), err.getvalue(), raised)


def outcome(case: str, seed: int, folder: Path, sound: Path) -> Outcome:
    """Return how a case ends in a process of its own; its files come into a folder, which is made."""
    folder.mkdir()
    half, number = case.split("-")
    kind, words = malformed(int(number), folder, sound, seed=seed, lines=half == "line")
    _reached[0] = 0
    end = asked_apart(lambda: reply_to(words, folder), seconds=SECONDS, gib=4.0 * MEMORY)
    reply = end.value or Reply()
    found = {
        end.killed: bool(end.killed), f"raised {reply.raised}": bool(reply.raised),
        f"{end.seconds:.1f} s": end.seconds > SECONDS, f"{end.peak / GIB:.1f} GiB": end.peak > MEMORY * GIB,
        **({} if end.killed or reply.raised else answer_faults(words, reply)),
    }
    fault = ", ".join(what for what, is_so in found.items() if is_so)
    return Outcome(case, kind, tuple(words), reply.code, bool(_reached[0]), end.seconds, end.peak / GIB, fault)


def answer_faults(words: Sequence[str], reply: Reply) -> dict[str, bool]:
    """Return what may be wrong with exit code and words, each with whether it is."""
    errors = sum(line.startswith("error: ") for line in reply.err.splitlines())
    faults = {
        f"exit code {reply.code}": reply.code not in CODES,
        f"{errors} lines of error with exit code {reply.code}": errors != (reply.code == 2),
        "warning": "Warning: " in reply.err or "Traceback" in reply.err + reply.out,
    }
    if "--json" in words and reply.code in (0, 4) and not {"--help", "-h", "--version"} & set(words):
        try:
            record = json.loads(reply.out, parse_constant=float.fromhex)
        except ValueError:
            return {**faults, "no JSON": True}
        flags = record.get("flags") if isinstance(record, dict) else None
        if flags:
            right = exit_code(flags if isinstance(flags, list) else flags.split("; "), "--accept" in words)
            faults[f"exit code {reply.code} of {flags}"] = reply.code != right
    return faults


def by_kind(outcomes: Sequence[Outcome]) -> list[dict[str, Any]]:
    """Return a row for each kind, and one for each half of the cases."""
    rows = []
    halves = {"all inputs": "input", "all command lines": "line"}
    for kind in [*sorted({each.kind for each in outcomes}), *halves]:
        some = [each for each in outcomes if kind == each.kind or each.case.split("-")[0] == halves.get(kind)]
        if not some:
            continue
        codes = Counter(each.code for each in some)
        rows.append({
            "kind": kind, "cases": len(some), "to a solver": sum(each.reached for each in some),
            **{f"exit {code}": codes[code] for code in CODES}, "faults": sum(bool(each.fault) for each in some),
            "seconds": sum(each.seconds for each in some), "worst s": max(each.seconds for each in some),
            "worst GiB": max(each.gib for each in some),
        })
    return rows


def main() -> int:
    """Ask all cases, or one; write the tables; say whether any is at fault."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--coarse", action="store_true", help=f"{COARSE} inputs and as many command lines")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first input and command line")
    parser.add_argument("--inputs", type=int, default=2000, help="number of inputs, those before the first too")
    parser.add_argument("--lines", type=int, default=1000)
    parser.add_argument(
        "--case", action="append", help="one of them, such as input-17: its files stay in DIR/input-17; may be repeated"
    )
    parser.add_argument("--output", type=Path, required=True)
    asked = parser.parse_args()
    output = asked.output.resolve()
    output.mkdir(parents=True, exist_ok=True)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    counts = {"input": COARSE, "line": COARSE} if asked.coarse else {"input": asked.inputs, "line": asked.lines}
    numbers = [(kind, k) for kind, count in counts.items() for k in range(asked.first, count)]
    cases = asked.case or [f"{kind}-{k}" for kind, k in numbers]
    outcomes, faults, table = [], [], ""
    with warm() as sound, tempfile.TemporaryDirectory() as place, contextlib.suppress(KeyboardInterrupt):
        for case in cases:
            one = outcome(case, asked.seed, (output if asked.case else Path(place)) / case, sound)
            outcomes.append(one)
            table = write_rows(by_kind(outcomes), output / "malformed.csv")
            if asked.case:
                print(shlex.join(["sits-mech", *one.words]), one, sep="\n")
            elif one.fault:
                again = f"python -m benchmarks.malformed --seed {asked.seed} --case {case} --output {asked.output}"
                words = shlex.join(one.words)[:500]
                faults.append({"fault": one.fault, "kind": one.kind, "command": words, "again": again})
                write_rows(faults, output / "faults.csv")
                print(f"{one.fault}\n    {words}\n    {again}", flush=True)
            shutil.rmtree(Path(place) / case, ignore_errors=True)
    print(*(each.case for each in outcomes[-1:]), table, sep="\n")
    return 1 if any(each.fault and (asked.seed, each.case) not in OPEN for each in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
