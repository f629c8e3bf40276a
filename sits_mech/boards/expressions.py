"""Read a KiCad file as nested lists of words, numbers and quoted text; their meaning is in `kicad.py`.

An expression ``(key item item ...)`` becomes a list; its items are lists, numbers, words and quoted texts. A word that
is no number and a quoted text are both strings, so that ``(net 1)`` and ``(net "1")`` stay apart.

What the formats of KiCad 5 to 10 do differently, as far as it is read here:

    version   KiCad  what changes                                                                     read by
    20171130  5      the oldest that is read: words without quotes, (module ...), layers by number    `copper_layers`
                     under names that users change, drawn arcs by centre, first point and angle,      `three_points`
                     drawn polygons always filled, fills with a pen of min_thickness round them       `is_filled`, `pen`
    20190905         (stackup ...) in (setup ...)                                                     `stackup.stack`
    20200119         arcs of tracks: (start) (mid) (end)                                              `three_points`
    20200625         a zone on several layers: each fill names its own                                `kicad.zone`
    20201115         (footprint ...) for (module ...); (fill solid), (fill none) of drawn polygons    `FOOTPRINTS`
    20211014  6      drawn arcs: (start) (mid) (end); the former (start) was the centre               `three_points`
    20211229         (stroke (width ...)) for (width ...) of drawings                                 `kicad.tracks`
    20220609         teardrops are zones with (attr (teardrop ...))                                   `kicad.board`
    20221018  7
    20230620         the reference is a property, no (fp_text reference ...)                          `kicad.frame`
    20230730         drawings on copper may have a net                                                `kicad.tracks`
    20240108  8
    20241129         (fill yes), (fill no) of drawn polygons                                          `is_filled`
    20241229  9      layers are numbered anew, with the same names; tracks with (layers "F.Cu" "F.Mask")
    20250210         fills have no pen but where (filled_areas_thickness yes) stands                  `pen`
    20260206  10     nets by name, (net "GND"), and no table of them; the newest that is known        `kicad.net`

KiCad writes (filled_areas_thickness no) from 6 on. What has a key is read by that, whatever the version.

Source: comments to SEXPR_BOARD_FILE_VERSION in pcbnew/pcb_io/kicad_sexpr/pcb_io_kicad_sexpr.h of KiCad's source, and
its parser (isStrokedFill, LEGACY_ARC_FORMATTING, SetArcAngleAndEnd in pcb_io_kicad_sexpr_parser.cpp).
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np

from sits_mech.memory import input_text
from sits_mech.quantities import Array
from sits_mech.units import SceneError, printable, shown

Node = list[Any]
_TOKEN = re.compile(r'"((?:[^"\\]|\\.)*)"|([()])|([^\s()"]+)', re.DOTALL)
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?")
_LONGEST = 256  # MiB of a board
_LARGEST = 2147.5  # in millimetres, what KiCad's integers of nanometres hold
_ESCAPED = re.compile(r"\\(.)", re.DOTALL)
OLDEST, NEWEST = 20171130, 20260206  # versions of files: KiCad 5 and 10
FOOTPRINTS = ("footprint", "module")
_SOLID_FILLS = 20250210  # from here on a fill has no pen by default
_NUMBERED = {0: "F.Cu", **{k: f"In{k}.Cu" for k in range(1, 31)}, 31: "B.Cu"}  # before KiCad 9, where users named them
_COPPER = ("signal", "power", "mixed", "jumper")


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


def version_of(tree: Node, name: str) -> tuple[int, tuple[str, ...]]:
    """Return a board's version and what to say of it; raise SceneError where it has none or is older than KiCad 5."""
    version = int(numbers(tree, "version", 1, name, 1e9)[0])
    if version < OLDEST:
        raise SceneError(
            f"{name}: must be a board of KiCad 5 or later (version {OLDEST}); got version {version}: open it in KiCad "
            "and save it"
        )
    newer = f"{name}: version {version} is newer than those known, to KiCad 10 ({NEWEST}); read as that"
    return version, (newer,) * (version > NEWEST)


def copper_layers(tree: Node) -> dict[str, str]:
    """Return KiCad's own name of each copper layer by the name that items use, from the top down."""
    found = {}
    for item in [item for item in child(tree, "layers") or [] if isinstance(item, list)]:
        number, name, kind = [*item, "", "", ""][:3]
        if name in _NUMBERED.values():
            found[name] = name
        elif kind in _COPPER and number in _NUMBERED:
            found[str(name)] = _NUMBERED[number]
    order = [*_NUMBERED.values()]
    return dict(sorted(found.items(), key=lambda pair: order.index(pair[1])))


def three_points(node: Node, where: str) -> Array:
    """Return the ends of a line, or three points of an arc, as in the file: (2, 2) or (3, 2) [mm]."""
    if not str(node[0]).endswith("arc"):
        return np.array([numbers(node, key, 2, where) for key in ("start", "end")])
    if child(node, "angle") is None:
        return np.array([numbers(node, key, 2, where) for key in ("start", "mid", "end")])
    centre, first = (np.array(numbers(node, key, 2, where)) for key in ("start", "end"))
    angle = math.radians(numbers(node, "angle", 1, where)[0]) * np.array([0.0, 0.5, 1.0])
    (x, y), c, s = first - centre, np.cos(angle), np.sin(angle)
    return np.asarray(centre + np.column_stack([c * x - s * y, s * x + c * y]))


def is_filled(node: Node) -> bool:
    """Return whether a drawn polygon is filled, as it is by default."""
    return "none" not in (entries := texts(node, "fill")) and "no" not in entries


def pen(zone: Node, version: int, where: str) -> float:
    """Return the width of the pen round a zone's fills, which is copper as well [mm]."""
    entries = texts(zone, "filled_areas_thickness")
    stroked = "no" not in entries if entries else version < _SOLID_FILLS
    has_width = stroked and child(zone, "min_thickness") is not None
    return numbers(zone, "min_thickness", 1, where)[0] if has_width else 0.0
