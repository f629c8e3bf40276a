"""Keep the help of commands as it was printed: from the second time on it comes without what makes it.

A text is kept beside what is prepared (`disk_cache`), and printed again while all that it depends on is as it was: the
words, what the terminal shows, the package's version, the folders that Python imports from, whose times change with
what is installed there, and the times of the modules with commands.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from sits_mech.disk_cache import folder
from sits_mech.version import __version__

_HELP = "--help", "-h"
_SHOWN = "COLUMNS", "NO_COLOR", "FORCE_COLOR", "TERM", "COLORTERM"  # what a terminal's text depends on
_COMMANDS = "sits_mech.cli"


def asks_help(words: Sequence[str]) -> bool:
    """Whether a command line asks for help alone."""
    return not words or words[-1] in _HELP


def kept_help(words: Sequence[str]) -> str | None:
    """Return the help that was printed for these words; None where there is none, or anything has changed."""
    where = folder()
    if where is None or not asks_help(words):
        return None
    try:
        with open(os.path.join(where, _name(words)), encoding="utf-8") as file:
            head, *modules = file.readline().rstrip("\n").split("\0")
            parted = (module.rpartition("|") for module in modules)  # path and time
            same = head == _head(words) and all(_time(path) == time for path, _, time in parted)
            return file.read() if same else None
    except (OSError, ValueError):
        return None


def keep_help(words: Sequence[str], text: str) -> None:
    """Keep the help of a command line, where anything is kept."""
    where = folder()
    if where is None:
        return
    files = {vars(own).get("__file__") for name, own in list(sys.modules.items()) if _has_commands(name, own)}
    modules = [f"{path}|{_time(path)}" for path in sorted(filter(None, files))]
    try:
        os.makedirs(where, exist_ok=True)
        path = os.path.join(where, _name(words))
        with open(f"{path}.{os.getpid()}", "w", encoding="utf-8") as file:
            file.write("\0".join([_head(words), *modules]) + "\n" + text)
        os.replace(f"{path}.{os.getpid()}", path)
    except OSError:  # a folder that cannot be written keeps nothing
        return


def _has_commands(name: str, module: object) -> bool:
    """Whether a module is of our command line, or holds the app: it has commands of its own."""
    app = getattr(sys.modules.get(f"{_COMMANDS}.options"), "app", None)
    return name.startswith(_COMMANDS) or (app is not None and vars(module).get("app") is app)


def _name(words: Sequence[str]) -> str:
    """Return the name of the file of some words."""
    return f"help-{'-'.join(word.strip('-') for word in words if word.strip('-').isalnum())}.txt"


def _head(words: Sequence[str]) -> str:
    """Return what a kept help depends on besides modules, in one line."""
    size = tuple(os.get_terminal_size(1)) if os.isatty(1) else ()
    shown = [os.environ.get(name) for name in _SHOWN]
    return repr((__version__, sys.version, list(words), size, shown, [_time(path) for path in sys.path]))


def _time(path: str) -> str:
    """Return when a file or folder was changed last."""
    try:
        return str(os.stat(path or ".").st_mtime_ns)
    except OSError:
        return ""
