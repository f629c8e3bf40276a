"""Read a KiCad file as nested lists of words, numbers and quoted text; their meaning is in `kicad.py`.

An expression ``(key item item ...)`` becomes a list; its items are lists, numbers, words and quoted texts. A word that
is no number and a quoted text are both strings, so that ``(net 1)`` and ``(net "1")`` stay apart.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from sits_mech.memory import input_text
from sits_mech.units import SceneError, printable, shown

Node = list[Any]
_TOKEN = re.compile(r'"((?:[^"\\]|\\.)*)"|([()])|([^\s()"]+)', re.DOTALL)
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?")
_LONGEST = 256  # MiB of a board
_LARGEST = 2147.5  # in millimetres, what KiCad's integers of nanometres hold
_ESCAPED = re.compile(r"\\(.)", re.DOTALL)


def read_expression(path: Path) -> Node:
    """Return the one expression of a file; raise SceneError where unreadable or parentheses do not match."""
    try:
        text = input_text(path, "a readable board file", _LONGEST)
    except SceneError:
        raise
    except ValueError:  # not UTF-8, or a path that cannot be
        raise SceneError(f"{_name(path)}: must be a board file of KiCad in text; got something else") from None
    if not text.lstrip().startswith("("):
        start = shown(text.lstrip()[:40]) if text.strip() else "nothing"
        raise SceneError(f"{_name(path)}: must be a board file of KiCad, which starts with (kicad_pcb; got {start}")
    found = parse_expression(text)
    if found is None:
        raise SceneError(f"{_name(path)}: must be one expression with matching parentheses; got a file that is cut off")
    return found


def _name(path: Path) -> str:
    """Return a path for a message."""
    return printable(str(path))


def parse_expression(text: str) -> Node | None:
    """Return the expression that a text holds, None where its parentheses do not match."""
    stack: list[Node] = [[]]
    for quoted, bracket, word in _TOKEN.findall(text):
        if bracket == "(":
            stack.append([])
        elif bracket == ")":
            if len(stack) == 1:
                return None
            done = stack.pop()
            stack[-1].append(done)
        elif word:
            stack[-1].append(float(word) if _NUMBER.fullmatch(word) else word)
        else:
            stack[-1].append(_ESCAPED.sub(r"\1", quoted))
    whole = len(stack) == 1 and len(stack[0]) == 1 and isinstance(stack[0][0], list)
    return stack[0][0] if whole else None


def children(node: Node, *keys: str) -> list[Node]:
    """Return the expressions within a node that start with one of `keys`."""
    return [item for item in node if isinstance(item, list) and item and item[0] in keys]


def child(node: Node, key: str) -> Node | None:
    """Return the first expression within a node that starts with `key`, None without one."""
    return next(iter(children(node, key)), None)


def texts(node: Node, key: str) -> list[str]:
    """Return the strings behind a key of a node; none where the key is missing."""
    return [item for item in child(node, key) or [] if isinstance(item, str)][1:]


def numbers(node: Node, key: str, count: int, where: str, largest: float = _LARGEST) -> list[float]:
    """Return the first `count` numbers behind a key, none above `largest` in size; raise SceneError for fewer."""
    inside = child(node, key) or []
    found = [item for item in inside if isinstance(item, float) and abs(item) <= largest]
    if len(found) < count:
        came = "it is missing" if not inside else f"got {shown(' '.join(map(str, inside[1:])))}"
        must = f"must be {count} number{'s' * (count > 1)} or more, up to {largest:g}"
        raise SceneError(f"{where}: ({key} ...) {must}; {came}")
    return found[:count]
