"""Read solids of Abaqus' input files, which meshio reads in part: parts and instances, sets, surfaces of elements.

Of keywords *Node, *Element, *Nset, *Elset, *Surface, *Part, *Instance (moved and turned), in any case; others are
passed over. C3D4H and C3D8H, the hybrid elements that silicone is meshed with, are tetrahedra and hexahedra. Names are
in small letters, without the instance's; a surface is faces S1, S2, ... of elements or of sets of them, a set of shells
its faces.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from sits_mech.memory import input_bytes
from sits_mech.quantities import Array
from sits_mech.units import SceneError, printable

_KINDS = {"C3D4": "tetra", "C3D10": "tetra10", "C3D8": "hexahedron", "C3D20": "hexahedron20", "C3D27": "hexahedron27",
          "C3D6": "wedge", "C3D15": "wedge15"}
_SHELL = re.compile(r"(?:CPS|CPE|CAX|M3D|S|R3D|SFM3D|STRI)([3468])")
_NODES = {"tetra": 4, "tetra10": 10, "hexahedron": 8, "hexahedron20": 20, "hexahedron27": 27, "wedge": 6, "wedge15": 15}
_FACES = {
    4: ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    6: ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    8: ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
}
CORNERS = {"tetra": 4, "tetra10": 4, "hexahedron": 8, "hexahedron20": 8, "hexahedron27": 8, "wedge": 6, "wedge15": 6}
"""Corners of cells."""


@dataclass
class Deck:
    """What an input file holds, by the names of its parts or instances, "" outside of them: labels as they stand."""

    nodes: dict[tuple[str, int], Array] = field(default_factory=dict)
    cells: dict[tuple[str, int], tuple[str, list[int]]] = field(default_factory=dict)
    shells: dict[tuple[str, int], list[int]] = field(default_factory=dict)
    nsets: dict[str, set[tuple[str, int]]] = field(default_factory=lambda: defaultdict(set))
    elsets: dict[str, set[tuple[str, int]]] = field(default_factory=lambda: defaultdict(set))
    surfaces: dict[str, list[tuple[str, str, str]]] = field(default_factory=lambda: defaultdict(list))


def read_deck(path: str | Path) -> Deck:
    """Return what a file holds, the parts in their instances' places; SceneError, one line, where it is damaged."""
    deck, part, used = Deck(), "", dict[str, str]()
    for number, keyword, options, rows in _blocks(path):
        try:
            if keyword in ("part", "instance"):
                part = options.get("name", "")
                if keyword == "instance" and (source := options.get("part")):
                    used[source] = part
                    _move(deck, source, rows)
                    part = source
            elif keyword.startswith("end"):
                part = ""
            else:
                _take(deck, keyword, options, rows, used_part(options, part, used))
        except (ValueError, IndexError, KeyError) as error:
            came = printable(f"{type(error).__name__} {error}", 80)
            raise SceneError(f"{path}: line {number}: must be a block *{keyword} of Abaqus; got {came}") from None
    return deck


def used_part(options: dict[str, str], part: str, used: dict[str, str]) -> str:
    """Return the part that a set of an assembly speaks of, by its instance."""
    instance = options.get("instance", "")
    return next((source for source, name in used.items() if name == instance), part)


def _blocks(path: str | Path) -> Iterator[tuple[int, str, dict[str, str], list[list[str]]]]:
    """Return line, keyword, options and rows of cells of each block, in small letters."""
    text = input_bytes(path, "a readable mesh", 512).decode("utf-8", "replace").casefold()
    head, rows, begun = "", list[list[str]](), 0
    for number, line in enumerate([*text.splitlines(), "*"], 1):
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            if head.endswith(","):
                head += line.lstrip("*")
                continue
            if head:
                keyword, *options = (each.strip() for each in head.lstrip("*").split(","))
                pairs = (each.partition("=") for each in options)
                yield begun, keyword, {name.strip(): value.strip(' "') for name, _, value in pairs}, rows
            head, rows, begun = line.strip(), [], number
        elif head.endswith(","):
            head += line.strip()
        elif line.strip():
            rows.append([each.strip() for each in line.rstrip().rstrip(",").split(",")])


def _take(deck: Deck, keyword: str, options: dict[str, str], rows: list[list[str]], part: str) -> None:
    """Add a block to a deck."""
    if keyword == "node":
        for label, *x in rows:
            deck.nodes[part, int(label)] = np.array([float(x[k]) for k in range(3)])
            if options.get("nset"):
                deck.nsets[options["nset"]].add((part, int(label)))
    elif keyword == "element":
        _elements(deck, options, [int(each) for row in rows for each in row], part)
    elif keyword in ("nset", "elset"):
        sets = deck.nsets if keyword == "nset" else deck.elsets
        for row in rows:
            sets[options[keyword]] |= _members(sets, row, "generate" in options, part)
    elif keyword == "surface":
        kind = options.get("type", "element")
        deck.surfaces[options["name"]] += [(kind, row[0], row[1] if len(row) > 1 else "") for row in rows]


def _elements(deck: Deck, options: dict[str, str], values: list[int], part: str) -> None:
    """Add elements, whose rows may go on in the next line."""
    kind = options["type"].upper()
    solid, shell = _KINDS.get(kind.rstrip("HIRMTSE")), _SHELL.match(kind)
    size = _NODES[solid] if solid else int(shell[1]) if shell else 0
    if not size:
        if kind.startswith("C3D"):
            raise ValueError(f"type {kind}")
        return
    for row in np.array(values).reshape(-1, size + 1).tolist():
        if solid:
            deck.cells[part, row[0]] = solid, row[1:]
        else:
            deck.shells[part, row[0]] = row[1 : 1 + (3 if size in (3, 6) else 4)]
        if options.get("elset"):
            deck.elsets[options["elset"]].add((part, row[0]))


def _members(sets: dict[str, set[tuple[str, int]]], row: list[str], generated: bool, part: str) -> set[tuple[str, int]]:
    """Return the members that a row of a set names: labels, other sets, or first, last and step."""
    if generated:
        first, last, step = (*map(int, row), 1)[:3]
        return {(part, label) for label in range(first, last + 1, step)}
    labels = {(part, int(each)) for each in row if each.isdecimal()}
    return labels.union(*(sets[each] for each in row if each and not each.isdecimal() and "." not in each))


def _move(deck: Deck, part: str, rows: list[list[str]]) -> None:
    """Put the nodes of a part where its instance is: a shift, then a turn about two points by degrees."""
    numbers = [[float(each) for each in row] for row in rows if len(row) in (3, 7)]
    for row in numbers:
        a, shift = np.array(row[:3]), np.zeros(3)
        turn = np.eye(3)
        if len(row) == 3:
            shift = a
        else:
            axis = (np.array(row[3:6]) - a) / np.linalg.norm(np.array(row[3:6]) - a)
            cross, angle = np.cross(np.eye(3), axis), np.deg2rad(row[6])
            turn = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
            shift = a - turn @ a
        for key in [key for key in deck.nodes if key[0] == part]:
            deck.nodes[key] = turn @ deck.nodes[key] + shift


def faces_named(deck: Deck) -> dict[str, list[list[tuple[str, int]]]]:
    """Return the faces of each surface and of each set of shells, by the keys of their corners."""
    found: dict[str, list[list[tuple[str, int]]]] = {}
    for name, own in deck.elsets.items():
        if faces := [[(key[0], node) for node in deck.shells[key]] for key in sorted(own) if key in deck.shells]:
            found[name] = faces
    for name, lines in deck.surfaces.items():
        faces = []
        for kind, members, side in lines:
            key = members.rsplit(".", 1)[-1]
            if kind != "element" or not side.startswith("s") or not side[1:].isdecimal():
                continue
            cells = deck.elsets.get(key) or {each for each in deck.cells if str(each[1]) == key}
            for cell in sorted(cells & deck.cells.keys()):
                solid, nodes = deck.cells[cell]
                corners = _FACES[CORNERS[solid]][int(side[1:]) - 1]
                faces.append([(cell[0], nodes[k]) for k in corners])
        if faces:
            found[name] = faces
    return found
