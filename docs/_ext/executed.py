"""Do the commands on a page still print what the page says? Blocks run in order, in a folder of the page's own.

A page of Markdown has two kinds of block that count here:

    ```{file} scene.toml        the block is written to that file of the folder
    ```{run}                    lines that start with "$ " are commands, what follows each is expected of it

A command with `:exit: 3` above it must end with that code. Expected is what it prints on stdout, and on stderr where it
ends with another code than 0. Words must be the same; numbers may differ by 2 %, those after "+-" by 30 %, for other
processors round otherwise; "..." stands for any words, on a line of its own for any lines. Seconds are not compared. A
command without expected lines is only run. What several pages begin with, in a folder that is still empty, runs once.

``python docs/_ext/executed.py PAGE ...`` runs pages and puts what was printed in the place of what no longer holds, and
of a single "...".
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

from warm import started

_FENCE = re.compile(
    r"^(?P<fence>`{3,})\{(?P<kind>file|run)\} ?(?P<argument>[^\n]*)\n(?P<text>.*?)^(?P=fence)$", re.M | re.S
)
_WORD = re.compile(r"\.\.\.|[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?|\+-|[^\s\d.+-]+|\S")
_NUMBER = re.compile(r"[-+]?\d")
_STATUSES = "ok|interpolated|above tolerance|not bounded|beyond data|not carried|failed"
_SECONDS = re.compile(rf"[\d.e+-]+ +(?=s\b|│ +(?:{_STATUSES})\b)")
_NEAR, _NEAR_ERROR, _NOTHING = 0.02, 0.3, 1e-6
_LIMIT = 300  # seconds of one command
_BEGUN = defaultdict[str, "_Begun"](lambda: _Begun(Lock()))  # by command


class Mismatch(Exception):
    """A command that ended otherwise, or printed something else, than its page says."""


@dataclass
class _Begun:
    """A command that is some page's first: what it has printed and left, once it has run."""

    lock: Lock
    printed: str = ""
    left: dict[Path, bytes] | None = None


@dataclass(frozen=True)
class Block:
    """A block of a page: what it is, its argument, its text, and where that starts in the page."""

    kind: str
    argument: str
    text: str
    start: int


@dataclass(frozen=True)
class Step:
    """A command of a block: its text, the code it ends with, what is expected, and where that stands in the page."""

    command: str
    code: int
    expected: str
    start: int
    end: int


def blocks(page: str) -> Iterator[Block]:
    """Yield the blocks of a page in order."""
    for found in _FENCE.finditer(page):
        yield Block(found["kind"], found["argument"].strip(), found["text"], found.start("text"))


def steps(block: Block) -> Iterator[Step]:
    """Yield the commands of a block in order."""
    option = re.match(r":exit: (\d+)\n+", block.text)
    code, at = (int(option[1]), option.end()) if option else (0, 0)
    for found in re.finditer(r"^\$ ((?:.*\\\n)*.*)\n((?:(?!\$ ).*\n)*)", block.text[at:], re.M):
        first = block.start + at
        yield Step(found[1], code, found[2], first + found.start(2), first + found.end(2))


def same(expected: str, printed: str) -> bool:
    """Tell whether what was printed is what was expected."""
    return _lines_match([_words(line) for line in _lines(expected)], [_words(line) for line in _lines(printed)])


def _lines(text: str) -> list[str]:
    """Return the lines that say something."""
    return [line.rstrip() for line in text.splitlines() if line.strip()]


def _words(line: str) -> list[str]:
    """Return words, numbers and signs of a line; rules of tables, which are as long as their columns, count once."""
    return _WORD.findall(re.sub(r"([━─])\1+", r"\1", _SECONDS.sub("", line)))


def _lines_match(expected: list[list[str]], printed: list[list[str]]) -> bool:
    """Match lines, those of "..." alone standing for any number of them."""
    if not expected:
        return not printed
    if expected[0] == ["..."]:
        return any(_lines_match(expected[1:], printed[k:]) for k in range(len(printed) + 1))
    return bool(printed) and _words_match(expected[0], printed[0]) and _lines_match(expected[1:], printed[1:])


def _words_match(expected: list[str], printed: list[str], near: float = _NEAR) -> bool:
    """Match the words of a line."""
    if not expected:
        return not printed
    if expected[0] == "...":
        return any(_words_match(expected[1:], printed[k:]) for k in range(len(printed) + 1))
    if not printed or not _one_matches(expected[0], printed[0], near):
        return False
    return _words_match(expected[1:], printed[1:], _NEAR_ERROR if expected[0] == "+-" else _NEAR)


def _one_matches(expected: str, printed: str, near: float) -> bool:
    """Match a word, or a number within what rounding may change."""
    if _NUMBER.match(expected) and _NUMBER.match(printed):
        a, b = float(expected), float(printed)
        return abs(a - b) <= max(near * max(abs(a), abs(b)), _NOTHING)
    return expected == printed


def run_page(page: Path, folder: Path, update: bool = False) -> float:
    """Run a page's blocks in a folder, which is emptied, and return the seconds it took.

    Raises
    ------
    Mismatch
        At the first command that does not do what the page says; with `update` only for another exit code.
    """
    text, start = page.read_text(encoding="utf-8"), time.monotonic()
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    changes: list[tuple[int, int, str]] = []
    for block in blocks(text):
        if block.kind == "file":
            (folder / block.argument).write_text(block.text, encoding="utf-8")
            continue
        for step in steps(block):
            run = _run if any(folder.iterdir()) else _first
            printed = run(step, folder, f"{page}:{text.count(chr(10), 0, step.start)}")
            unknown = update and step.expected.strip() == "..."
            if step.expected.strip() and (unknown or not same(step.expected, printed)):
                if not update:
                    where = f"{page}:{text.count(chr(10), 0, step.start)}: $ {step.command}"
                    raise Mismatch(f"{where}\nmust print\n{step.expected}\nand printed\n{printed}")
                changes.append((step.start, step.end, "\n".join(_lines(printed)) + "\n"))
    for first, last, printed in reversed(changes):
        text = text[:first] + printed + text[last:]
    if changes:
        page.write_text(text, encoding="utf-8")
    return time.monotonic() - start


def _run(step: Step, folder: Path, where: str) -> str:
    """Return what a command prints."""
    done = subprocess.run(
        ["bash", "-c", step.command], cwd=folder, env=os.environ | {"MPLBACKEND": "Agg"}, capture_output=True,
        text=True, timeout=_LIMIT, stdin=subprocess.DEVNULL,
    )
    if done.returncode != step.code:
        said = f"{done.stdout[-2000:]}\n{done.stderr[-2000:]}"
        raise Mismatch(f"{where}: $ {step.command}\nmust end with {step.code}; it ended with {done.returncode}\n{said}")
    said = done.stdout + (done.stderr if step.code else "")
    return said.replace(f"{folder.resolve()}{os.sep}", "")  # pages name files as their readers do


def _first(step: Step, folder: Path, where: str) -> str:
    """Return what a command prints in an empty folder, and leave there what it leaves."""
    begun = _BEGUN[f"{step.code} {step.command}"]
    with begun.lock:
        if begun.left is None:
            begun.printed = _run(step, folder, where)
            begun.left = {each.relative_to(folder): each.read_bytes() for each in folder.rglob("*") if each.is_file()}
        for path, content in begun.left.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_bytes(content)
    return begun.printed


def stamp(page: Path, package: Path) -> str:
    """Return what a page's run depends on, as a hash: its blocks and the package's files."""
    return package_stamp(repr([(each.kind, each.argument, each.text) for each in blocks(page.read_text())]), package)


def package_stamp(text: str, package: Path) -> str:
    """Return a text and the package's files as a hash."""
    found = hashlib.sha256(text.encode())
    for path in sorted(package.rglob("*")):
        if path.suffix in (".py", ".toml", ".in", ".h", ".js", ".css", ".html"):
            found.update(path.read_bytes())
    return found.hexdigest()


def main(pages: list[str]) -> int:
    """Run pages and put what they print in them."""
    with started():
        for name in pages:
            page = Path(name)
            folder = Path(__file__).parents[1] / "_made" / page.stem
            sys.stdout.write(f"{run_page(page, folder, update=True):6.1f} s  {page}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
