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
from itertools import chain
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from sits_mech.geometry.meshing.soundness import FACES
from sits_mech.memory import input_bytes
from sits_mech.quantities import Array
from sits_mech.units import SceneError, printable

_KINDS = {"C3D4": "tetra", "C3D10": "tetra10", "C3D8": "hexahedron", "C3D20": "hexahedron20", "C3D27": "hexahedron27",
          "C3D6": "wedge", "C3D15": "wedge15"}
_SHELL = re.compile(r"(?:CPS|CPE|CAX|M3D|S|R3D|SFM3D|STRI)([3468])")
_SIDE = re.compile(r"s\d+")
_FACES = FACES | {6: ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0))}
CORNERS = {"tetra": 4, "tetra10": 4, "hexahedron": 8, "hexahedron20": 8, "hexahedron27": 8, "wedge": 6, "wedge15": 6}
"""Corners of cells."""
Key = tuple[str, int]  # a part, and a label of a node or an element in it


@dataclass
class Deck:
    """What an input file holds, by the names of its parts or instances, "" outside of them: labels as they stand."""

    nodes: dict[Key, Array] = field(default_factory=dict)
    cells: dict[Key, tuple[str, list[int]]] = field(default_factory=dict)
    shells: dict[Key, list[int]] = field(default_factory=dict)
    nsets: dict[str, set[Key]] = field(default_factory=lambda: defaultdict(set))
    elsets: dict[str, set[Key]] = field(default_factory=lambda: defaultdict(set))
    surfaces: dict[str, list[tuple[str, str]]] = field(default_factory=lambda: defaultdict(list))  # cells, side


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
            elif keyword in _TAKEN:
                instance = options.get("instance", "")  # of which a set of an assembly speaks
                own = next((source for source, name in used.items() if name == instance), part)
                _TAKEN[keyword](deck, options, rows, own)
        except (ValueError, IndexError, KeyError) as error:
            came = printable(f"{type(error).__name__} {error}", 80)
            raise SceneError(f"{path}: line {number}: must be a block *{keyword} of Abaqus; got {came}") from None
    return deck


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
                yield begun, *_heading(head), rows
            head, rows, begun = line.strip(), [], number
        elif head.endswith(","):
            head += line.strip()
        elif line.strip():
            rows.append([each.strip() for each in line.rstrip().rstrip(",").split(",")])


def _heading(line: str) -> tuple[str, dict[str, str]]:
    """Return the keyword and the options of a block's first line."""
    keyword, *options = (each.strip() for each in line.lstrip("*").split(","))
    pairs = (each.partition("=") for each in options)
    return keyword, {name.strip(): value.strip(' "') for name, _, value in pairs}


def _nodes(deck: Deck, options: dict[str, str], rows: list[list[str]], part: str) -> None:
    """Add nodes to a deck."""
    deck.nodes |= {(part, int(label)): np.array([float(x[k]) for k in range(3)]) for label, *x in rows}
    if options.get("nset"):
        deck.nsets[options["nset"]] |= {(part, int(label)) for label, *_ in rows}


def _elements(deck: Deck, options: dict[str, str], rows: list[list[str]], part: str) -> None:
    """Add elements, whose rows may go on in the next line."""
    kind = options["type"].upper()
    plain, shell = kind.rstrip("HIRMTSE"), _SHELL.match(kind)
    solid = _KINDS.get(plain)
    size = int(plain[3:]) if solid else int(shell[1]) if shell else 0
    if not size:
        if kind.startswith("C3D"):
            raise ValueError(f"type {kind}")
        return
    for row in np.array([*chain(*rows)], dtype=np.int64).reshape(-1, size + 1).tolist():
        if solid:
            deck.cells[part, row[0]] = solid, row[1:]
        else:
            deck.shells[part, row[0]] = row[1 : 1 + (3 if size in (3, 6) else 4)]
        if options.get("elset"):
            deck.elsets[options["elset"]].add((part, row[0]))


def _set(deck: Deck, options: dict[str, str], rows: list[list[str]], part: str) -> None:
    """Add members to a set of nodes or elements."""
    sets, name = (deck.nsets, options["nset"]) if "nset" in options else (deck.elsets, options["elset"])
    for row in rows:
        sets[name] |= _members(sets, row, "generate" in options, part)


def _surface(deck: Deck, options: dict[str, str], rows: list[list[str]], _: str) -> None:
    """Add faces of elements to a surface."""
    if options.get("type", "element") == "element":
        deck.surfaces[options["name"]] += [(row[0], "".join(row[1:2])) for row in rows]


_TAKEN = {"node": _nodes, "element": _elements, "nset": _set, "elset": _set, "surface": _surface}


def _members(sets: dict[str, set[Key]], row: list[str], generated: bool, part: str) -> set[Key]:
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
        shift, turn = np.array(row[:3]), np.eye(3)
        if len(row) == 7:
            axis = np.array(row[3:6]) - row[:3]
            turn = Rotation.from_rotvec(row[6] * axis / np.linalg.norm(axis), degrees=True).as_matrix()
            shift = shift - turn @ shift
        for key in [key for key in deck.nodes if key[0] == part]:
            deck.nodes[key] = turn @ deck.nodes[key] + shift


def faces_named(deck: Deck) -> dict[str, list[list[Key]]]:
    """Return the faces of each surface and of each set of shells, by the keys of their corners."""
    shells = {name: [[(key[0], node) for node in deck.shells[key]] for key in sorted(own & deck.shells.keys())]
              for name, own in deck.elsets.items()}
    surfaces = {name: [face for members, side in own for face in _faces(deck, members, side)]
                for name, own in deck.surfaces.items()}
    return {name: faces for name, faces in (*shells.items(), *surfaces.items()) if faces}


def _faces(deck: Deck, members: str, side: str) -> list[list[Key]]:
    """Return the faces of one side, s1 to s6, of the solids of a set or of one label; SceneError for one they lack."""
    if not _SIDE.fullmatch(side):
        return []
    name = members.rsplit(".", 1)[-1]
    cells = deck.elsets.get(name) or {key for key in deck.cells if str(key[1]) == name}
    faces = []
    for part, label in sorted(cells & deck.cells.keys()):
        solid, nodes = deck.cells[part, label]
        own = _FACES[CORNERS[solid]]
        if not 1 <= int(side[1:]) <= len(own):
            raise SceneError(f"surface: must name sides S1 to S{len(own)} of a {solid}; got {side.upper()} of {label}")
        faces.append([(part, nodes[k]) for k in own[int(side[1:]) - 1]])
    return faces
