"""The command line: ``sits-mech COMMAND SCENE ...``; see ``sits-mech --help``.

Answers go to stdout, progress and warnings to stderr. Exit 0 done, 2 bad input (one line), 3 not converged (what was
reached is printed and kept), 4 above the tolerance or beyond the data, 130 interrupted, 141 where who read the answer
has left (`| head`). Of every command: with --quiet stderr has errors alone; with -v also what is solved, step by step,
which --log FILE writes. Each command imports its rooms itself; help comes at once, as it was printed before.
Linear algebra keeps to one thread, unless the environment says otherwise: its systems are small, and sparse
factorisations lose an order of magnitude to a second one. Modules with commands are entry points of the group
`sits_mech.commands`: those of this package, listed in its pyproject.toml, and those of any other installed beside it.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Sequence
from functools import cache, partial
from typing import TYPE_CHECKING

from sits_mech.cli.console import QUIET, logged, not_converged, print_fault, warn
from sits_mech.cli.kept_help import asks_help, keep_help, kept_help
from sits_mech.disk_cache import keep_by_default

if TYPE_CHECKING:
    from cyclopts import App

GROUP = "sits_mech.commands"
_QUIET, _VERBOSE, _LOG = "--quiet", {"-v", "--verbose"}, "--log"
UNREAD = 141
"""Exit code of a command whose answer nobody reads any more, as a shell gives one that ends by SIGPIPE."""


@cache
def commands() -> App:
    """Import all modules with commands, our own first: imported, the app knows them. Tell which cannot be."""
    from importlib.metadata import entry_points

    from cyclopts import CommandCollisionError

    from sits_mech.cli.options import app

    found = entry_points(group=GROUP)
    for each in sorted(found, key=lambda each: (not each.value.startswith("sits_mech."), each.name)):
        try:
            each.load()
        except (ImportError, AttributeError, CommandCollisionError) as error:
            warn(f"{each.name}: must be a module with commands that can be loaded; got {each.value}: {error}")
    return app


def run(tokens: Sequence[str] | None = None) -> int:
    """Run a command, by default of the process's own words, and return its exit code."""
    words = list(sys.argv[1:] if tokens is None else tokens)
    verbose = not _VERBOSE.isdisjoint(words)
    before = QUIET.set(not verbose and _QUIET in words)
    try:
        words, path = _without_log([word for word in words if word not in {*_VERBOSE, _QUIET}])
        with logged(verbose, path):
            code = _answered(words)
        sys.stdout.flush()
    except (BrokenPipeError, SystemExit) as error:  # rich ends by the latter
        if not isinstance(error.__context__ or error, BrokenPipeError):
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left has no reader
        return UNREAD
    except (ValueError, OSError) as error:
        print_fault(f"error: {' '.join(str(error).split())}")
        return 2
    except MemoryError as error:
        print_fault(f"error: memory: must hold what is asked for; {' '.join(str(error).split())}".rstrip("; "))
        return 2
    except KeyboardInterrupt:
        print_fault("interrupted: finished loads, cases and designs are kept; the same command goes on from them")
        return 130
    finally:
        QUIET.reset(before)
    return code


def _without_log(words: list[str]) -> tuple[list[str], str | None]:
    """Return words without --log FILE, and the file; ValueError where it is missing."""
    place = next((k for k, word in enumerate(words) if word.partition("=")[0] == _LOG), None)
    if place is None:
        return words, None
    _, equals, path = words[place].partition("=")
    path, last = (path, place + 1) if equals else ("".join(words[place + 1 : place + 2]), place + 2)
    if not path:
        raise ValueError(f"{_LOG}: must be followed by a file to write; got none")
    return [*words[:place], *words[last:]], path


def _answered(words: list[str]) -> int:
    """Answer a command's words; help from what was printed before, where nothing has changed."""
    text = kept_help(words)
    if text is not None:
        sys.stdout.write(text)
        return 0
    from cyclopts import CycloptsError
    from rich.console import Console

    asked = partial(commands(), words, exit_on_error=False, print_error=False, result_action="return_value")
    try:
        if not asks_help(words):
            code = asked()
            return code if isinstance(code, int) else 0
        console = Console()
        with console.capture() as shown:
            asked(console=console)
    except CycloptsError as error:
        raise ValueError(str(error)) from None
    except Exception as error:
        from sits_mech.quantities import SolveFailed  # numpy comes with it

        if not isinstance(error, SolveFailed):
            raise
        return not_converged(error, "--json" in words, whole=words[0] == "simulate")
    keep_help(words, shown.get())
    sys.stdout.write(shown.get())
    return 0


def main() -> None:
    """Run the command line and leave with its exit code."""
    for library in ("OPENBLAS", "OMP", "MKL"):  # read when numpy is first imported, by a command
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    gc.set_threshold(10_000, 20, 1000)  # what is imported is no garbage: a fifth of its time was the search
    keep_by_default()
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # a scheduler's end of a job is as Ctrl-C
    if sys.stderr is None:  # closed by the shell
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115
    if sys.stdout is None:
        print_fault("error: stdout: must be open, it takes the answer; got a closed one (>/dev/null is open)")
        sys.exit(2)
    code = run()
    gc.freeze()  # else the interpreter's end searches all once more
    sys.exit(code)
