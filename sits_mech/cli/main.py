"""The command line: ``sits-mech COMMAND SCENE ...``; see ``sits-mech --help``.

Answers go to stdout, progress and warnings to stderr. Exit 0 done, 2 bad input (one line), 3 not converged (what was
reached is printed and kept), 4 above the tolerance or beyond the data, 130 interrupted, 141 where who read the answer
has left (`| head`). With --quiet, of every command,
stderr has errors alone. Each command imports its rooms itself, so that help comes at once.
Linear algebra keeps to one thread, unless the environment says otherwise: its systems are small, and sparse
factorisations lose an order of magnitude to a second one. Modules with commands are entry points of the group
`sits_mech.commands`: those of this package, listed in its pyproject.toml, and those of any other installed beside it.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib.metadata import entry_points

from cyclopts import CommandCollisionError, CycloptsError

from sits_mech.cli.console import QUIET, fault, warn
from sits_mech.cli.options import app
from sits_mech.disk_cache import keep_by_default

GROUP = "sits_mech.commands"
QUIET_WORD = "--quiet"
UNREAD = 141
"""Exit code of a command whose answer nobody reads any more, as a shell gives one that ends by SIGPIPE."""


def load_commands() -> None:
    """Import all modules with commands, our own first: imported, the app knows them. Tell which cannot be."""
    found = entry_points(group=GROUP)
    for each in sorted(found, key=lambda each: (not each.value.startswith("sits_mech."), each.name)):
        try:
            each.load()
        except (ImportError, AttributeError, CommandCollisionError) as error:
            warn(f"{each.name}: must be a module with commands that can be loaded; got {each.value}: {error}")


load_commands()


def run(tokens: Sequence[str] | None = None) -> int:
    """Run a command, by default of the process's own words, and return its exit code."""
    words = list(sys.argv[1:] if tokens is None else tokens)
    quiet = QUIET.set(QUIET_WORD in words)
    try:
        asked = [word for word in words if word != QUIET_WORD]
        code = app(asked, exit_on_error=False, print_error=False, result_action="return_value")
        sys.stdout.flush()
    except (BrokenPipeError, SystemExit) as error:  # rich ends by the latter
        if not isinstance(error.__context__ or error, BrokenPipeError):
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left has no reader
        return UNREAD
    except (CycloptsError, ValueError, OSError) as error:
        fault(f"error: {' '.join(str(error).split())}")
        return 2
    except MemoryError as error:
        fault(f"error: memory: must hold what is asked for; {' '.join(str(error).split()) or 'it does not'}")
        return 2
    except KeyboardInterrupt:
        fault("interrupted: finished loads are kept; the same command goes on from them")
        return 130
    finally:
        QUIET.reset(quiet)
    return code if isinstance(code, int) else 0


def main() -> None:
    """Run the command line and leave with its exit code."""
    for library in ("OPENBLAS", "OMP", "MKL"):  # read when numpy is first imported, by a command
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    keep_by_default()
    if sys.stderr is None:  # closed by the shell
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115
    if sys.stdout is None:
        fault("error: stdout: must be open, it takes the answer; got a closed one (>/dev/null is open)")
        sys.exit(2)
    sys.exit(run())
