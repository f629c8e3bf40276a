"""Read a KiCad board: copper layers, tracks, vias, pads and filled zones of its text file, KiCad 7 or later.

Lengths in metres, y up: the file's millimetres with y down are turned over here, so that the board is seen from its
top. Messages name places as KiCad shows them. A footprint at (x, y) turned by phi counter-clockwise holds its own
lines and pads in its own frame, those on the back too; the angle of a pad is the board's.

Source: the format's description by the KiCad project (dev-docs.kicad.org, "Board File Format"), and files of versions
20221018 (KiCad 7), 20240108 (8), 20241229 (9) and 20260206 (10, where nets go by name and no longer by number).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sits_mech.boards.sexpr import Node, child, children, numbers, read_expression, texts
from sits_mech.boards.stackup import METRES, Layer, stack
from sits_mech.quantities import Array
from sits_mech.units import SceneError, printable

_OLDEST, _NEWEST = 20221018, 20260206  # versions of the file format that are read


@dataclass(frozen=True)
class Track:
    """A straight track from the first to the last of two points, or an arc through three."""

    layer: str
    points: Array  # (2, 2) or (3, 2) x, y [m]
    width: float  # [m]
    net: str  # empty for copper of a footprint
    footprint: int = -1  # whose copper it is; -1 for a track of the board


@dataclass(frozen=True)
class Hole:
    """A via or a pad: what joins copper that ends in it."""

    name: str  # as "J1.2"; empty for a via and a pad without number, which are passed through
    place: Array  # (2,) its middle [m]
    size: tuple[float, float]  # along its own axes [m]
    angle: float  # of those axes, counter-clockwise [rad]
    layers: tuple[str, ...]  # copper layers that it is on
    net: str
    footprint: int = -1  # whose pad it is; -1 for a via

    def holds(self, points: Array) -> Array:
        """Tell which points (n, 2) lie on the hole's copper, a round one where both sizes are the same via's."""
        x, y = (points - self.place).T
        c, s = math.cos(self.angle), math.sin(self.angle)
        a, b = np.abs(c * x + s * y), np.abs(c * y - s * x)
        if self.footprint < 0:
            return np.asarray(np.hypot(a, b) <= self.size[0] / 2)
        return np.asarray((a <= self.size[0] / 2) & (b <= self.size[1] / 2))


@dataclass(frozen=True)
class Zone:
    """A copper zone."""

    net: str
    layers: tuple[str, ...]  # where it may be filled
    fills: tuple[tuple[str, Array], ...]  # layer and polygon (k, 2) [m], holes tied to the rim by bridges of no width


@dataclass(frozen=True)
class Board:
    """A board: its nets and copper, the layers from the top down."""

    name: str  # of its file
    stack: Mapping[str, Layer]
    nets: tuple[str, ...]
    tracks: tuple[Track, ...]
    holes: tuple[Hole, ...]
    zones: tuple[Zone, ...]
    notes: tuple[str, ...]  # what was assumed


def place(point: Iterable[float]) -> str:
    """Return a point as KiCad shows it: millimetres, y down."""
    x, y = point
    return f"({x / METRES:.4f}, {-y / METRES + 0.0:.4f}) mm"


def read_board(path: Path) -> Board:
    """Return what is on a board; raise SceneError for no board, one older than KiCad 7, or unreadable parts."""
    tree, name = read_expression(path), printable(str(path))
    if tree[:1] != ["kicad_pcb"]:
        raise SceneError(f"{name}: must be a board, (kicad_pcb ...); got ({printable(str(tree[:1])[1:-1], 40)} ...)")
    version = int(numbers(tree, "version", 1, name, 1e9)[0])
    if version < _OLDEST:
        raise SceneError(
            f"{name}: must be a board of KiCad 7 or later (version {_OLDEST}); got version {version}: open it in KiCad "
            "and save it"
        )
    newer = f"{name}: version {version} is newer than those known, to KiCad 10 ({_NEWEST}); read as that"
    try:
        layers, notes = stack(tree, name)
        notes += (newer,) * (version > _NEWEST)
        numbered = (node for node in children(tree, "net") if len(node) > 2 and isinstance(node[1], float))
        nets = {node[1]: str(node[2]) for node in numbered}
        return _Reader(name, tuple(layers), nets).board(tree, layers, notes)
    except SceneError:
        raise
    except (IndexError, TypeError, ValueError) as error:
        raise SceneError(f"{name}: must be a board as KiCad writes it; got an entry that is not: {error}") from None


@dataclass(frozen=True)
class _Frame:
    """Where a footprint stands: its number, reference, place [m] and angle [rad]."""

    number: int
    reference: str
    place: Array
    angle: float

    def point(self, node: Node, key: str, where: str) -> Array:
        """Return a point of the footprint on the board."""
        x, y = numbers(node, key, 2, where)
        c, s = math.cos(self.angle), math.sin(self.angle)
        return self.place + METRES * np.array([c * x + s * y, s * x - c * y])


_BOARD = _Frame(-1, "", np.zeros(2), 0.0)


@dataclass(frozen=True)
class _Reader:
    """A file's name, its copper layers and the names of its nets."""

    name: str
    copper: tuple[str, ...]
    nets: Mapping[float, str]

    def board(self, tree: Node, layers: Mapping[str, Layer], notes: tuple[str, ...]) -> Board:
        """Return the board of a file."""
        tracks = self.tracks(children(tree, "segment", "arc", "gr_line", "gr_arc"), _BOARD)
        holes = [self.via(node) for node in children(tree, "via")]
        for number, node in enumerate(children(tree, "footprint")):
            if child(node, "at") is not None:
                frame = self.frame(node, number)
                tracks += self.tracks(children(node, "fp_line", "fp_arc"), frame)
                holes += [self.pad(item, frame) for item in children(node, "pad")]
        zones = [
            self.zone(node) for node in children(tree, "zone")  # of copper, and no teardrop of a pad
            if child(node, "keepout") is None and child(child(node, "attr") or [], "teardrop") is None
        ]
        named = {item.net for part in (tracks, holes, zones) for item in part}
        names = sorted(({*self.nets.values()} | named) - {""})
        return Board(self.name, layers, tuple(names), tuple(tracks), tuple(holes), tuple(zones), notes)

    def frame(self, node: Node, number: int) -> _Frame:
        """Return where a footprint stands."""
        x, y = numbers(node, "at", 2, f"{self.name}: footprint {number + 1}")
        named = [item for item in children(node, "property", "fp_text") if str(item[1]).lower() == "reference"]
        reference = str(named[0][2]) if named else f"footprint {number + 1}"
        return _Frame(number, reference, METRES * np.array([x, -y]), _turn(node, f"{self.name}: {reference}"))

    def net(self, node: Node) -> str:
        """Return the net of an item, by its number or its name."""
        found = (child(node, "net") or ["net", ""])[1]
        return self.nets.get(found, "") if isinstance(found, float) else str(found)

    def on(self, node: Node) -> tuple[str, ...]:
        """Return the copper layers that an item is on."""
        given = texts(node, "layer") + texts(node, "layers")
        if "*.Cu" in given:
            return self.copper
        both = ("F.Cu", "B.Cu") if "F&B.Cu" in given else ()
        return tuple(layer for layer in self.copper if layer in given or layer in both)

    def tracks(self, nodes: list[Node], frame: _Frame) -> list[Track]:
        """Return the lines and arcs of copper among some; drawings without a net are left out."""
        found = []
        for node in nodes:
            layers, net = self.on(node)[:1], self.net(node)
            lost = [layer for layer in texts(node, "layer") if layer.endswith(".Cu") and not layers]
            if lost:
                raise SceneError(f"{self.name}: {node[0]}: must be on one of {', '.join(self.copper)}; got {lost[0]}")
            if not layers or (node[0].startswith("gr_") and not net):
                continue
            keys = ("start", "mid", "end") if node[0].endswith("arc") else ("start", "end")
            points = np.array([frame.point(node, key, f"{self.name}: {node[0]}") for key in keys])
            where = f"{self.name}: {node[0]} at {place(points[0])}"
            (width,) = numbers(child(node, "stroke") or node, "width", 1, where)
            found.append(Track(layers[0], points, METRES * width, net, frame.number))
        return found

    def via(self, node: Node) -> Hole:
        """Return a via, on all layers between the two that it names."""
        where = f"{self.name}: via"
        point, (size,) = _BOARD.point(node, "at", where), numbers(node, "size", 1, where)
        ends = [self.copper.index(layer) for layer in self.on(node)] or [0, len(self.copper) - 1]
        through = self.copper[min(ends) : max(ends) + 1]
        return Hole("", point, (METRES * size, METRES * size), 0.0, through, self.net(node))

    def pad(self, node: Node, frame: _Frame) -> Hole:
        """Return a pad."""
        number = f"{node[1]:g}" if isinstance(node[1], float) else str(node[1])
        where = f"{self.name}: pad {frame.reference}.{number}"
        size, angle = numbers(node, "size", 2, where), _turn(node, where)
        name = f"{frame.reference}.{number}" if number else ""
        extent = (METRES * size[0], METRES * size[1])
        return Hole(name, frame.point(node, "at", where), extent, angle, self.on(node), self.net(node), frame.number)

    def zone(self, node: Node) -> Zone:
        """Return a zone with what is filled of it."""
        fills = []
        for fill in children(node, "filled_polygon"):
            points = child(fill, "pts") or []
            corners = [self.corner(item) for item in children(points, "xy", "arc")]
            layer = (texts(fill, "layer") or texts(node, "layer") or [""])[0]
            if len(corners) > 2 and layer in self.copper:
                fills.append((layer, np.concatenate(corners) * (METRES, -METRES)))
        return Zone(self.net(node) or "".join(texts(node, "net_name")), self.on(node), tuple(fills))

    def corner(self, node: Node) -> list[list[float]]:
        """Return the points of a corner of a polygon, three of an arc, as in the file."""
        where = f"{self.name}: filled_polygon"
        if node[0] == "xy":
            return [numbers([node], "xy", 2, where)]
        return [numbers(node, key, 2, where) for key in ("start", "mid", "end")]


def _turn(node: Node, where: str) -> float:
    """Return the angle that an item is turned by, counter-clockwise [rad]."""
    return math.radians(numbers(node, "at", 3, where)[2]) if len(child(node, "at") or []) > 3 else 0.0
