"""Read a KiCad board: copper layers, tracks, vias, pads, filled zones and drawn copper of its text file, KiCad 5 to 10.

Lengths in metres, y up: the file's millimetres with y down are turned over here, so that the board is seen from its
top. Messages name places as KiCad shows them. A footprint at (x, y) turned by phi counter-clockwise holds its own
lines and pads in its own frame, those on the back too; the angle of a pad is the board's. What a custom pad is drawn of
lies in the pad's frame. Lines and arcs drawn on copper are tracks, and so are filled polygons that are strips.

Source: the format's description by the KiCad project (dev-docs.kicad.org, "Board File Format"); versions differ as
`expressions.py` lists.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from sits_mech.boards.copper import Board, Hole, Track, Zone, board_point
from sits_mech.boards.expressions import (
    FOOTPRINTS,
    Node,
    child,
    children,
    copper_layers,
    is_filled,
    numbers,
    pen,
    read_expression,
    texts,
    three_points,
    version_of,
)
from sits_mech.boards.lines import strip
from sits_mech.boards.stackup import METRES, CopperLayer, stack
from sits_mech.quantities import Array
from sits_mech.units import SceneError, printable

_DRAWN = ("line", "arc", "poly")  # that may be tracks; rectangles, circles and curves are none


def read_board(path: Path) -> Board:
    """Return what is on a board; raise SceneError for no board, one older than KiCad 5, or unreadable parts."""
    tree, name = read_expression(path), printable(str(path))
    if tree[:1] != ["kicad_pcb"]:
        raise SceneError(f"{name}: must be a board, (kicad_pcb ...); got ({printable(str(tree[:1])[1:-1], 40)} ...)")
    try:
        version, notes = version_of(tree, name)
        copper = copper_layers(tree)
        layers, assumed = stack(tree, name)
        numbered = (node for node in children(tree, "net") if len(node) > 2 and isinstance(node[1], float))
        nets = {node[1]: _word(node[2]) for node in numbered}
        return _Reader(name, version, copper, nets).board(tree, layers, (*assumed, *notes))
    except SceneError:
        raise
    except (IndexError, TypeError, ValueError) as error:
        raise SceneError(f"{name}: must be a board as KiCad writes it; got an entry that is not: {error}") from None


@dataclass(frozen=True)
class _Frame:
    """Where a footprint or a pad stands: number and reference of the footprint, place [m], angle [rad]."""

    number: int
    reference: str
    place: Array
    angle: float

    def onto(self, points: Array) -> Array:
        """Return points (n, 2) of the frame [mm] on the board [m]."""
        x, y = np.asarray(points, dtype=np.float64).T
        c, s = math.cos(self.angle), math.sin(self.angle)
        return self.place + METRES * np.column_stack([c * x + s * y, s * x - c * y])

    def point(self, node: Node, key: str, where: str) -> Array:
        """Return a point of an item on the board."""
        return np.asarray(self.onto(np.array([numbers(node, key, 2, where)]))[0])


_BOARD = _Frame(-1, "", np.zeros(2), 0.0)


@dataclass(frozen=True)
class _Reader:
    """A file's name and version, its copper layers by the names that items use, and the names of its nets."""

    name: str
    version: int
    layers: Mapping[str, str]
    nets: Mapping[float, str]

    def board(self, tree: Node, layers: Mapping[str, CopperLayer], notes: tuple[str, ...]) -> Board:
        """Return the board of a file."""
        tracks = self.tracks([*children(tree, "segment", "arc"), *_drawings(tree, "gr_")], _BOARD)
        holes = [self.via(node) for node in children(tree, "via")]
        references = []
        for number, node in enumerate(children(tree, *FOOTPRINTS)):
            frame = self.frame(node, number)
            references.append("" if frame.reference == f"footprint {number + 1}" else frame.reference)
            if child(node, "at") is not None:
                tracks += self.tracks(_drawings(node, "fp_"), frame)
                for item in children(node, "pad"):
                    holes += self.pad(item, frame)
                    tracks += self.primitives(item, frame)
        zones = [*map(self.zone, filter(_is_pour, children(tree, "zone"))), *self.areas(children(tree, "gr_poly"))]
        named = {item.net for part in (tracks, holes, zones) for item in part}
        names = tuple(sorted(({*self.nets.values()} | named) - {""}))
        return Board(self.name, layers, names, tuple(tracks), tuple(holes), tuple(zones), notes, tuple(references))

    def frame(self, node: Node, number: int) -> _Frame:
        """Return where a footprint stands; at the board's origin where it does not say so."""
        named = [item for item in children(node, "property", "fp_text") if str(item[1]).lower() == "reference"]
        reference = _word(named[0][2]) if named else f"footprint {number + 1}"
        x, y = numbers(node, "at", 2, f"{self.name}: footprint {number + 1}") if child(node, "at") else (0.0, 0.0)
        return _Frame(number, reference, METRES * np.array([x, -y]), _turn(node, f"{self.name}: {reference}"))

    def net(self, node: Node) -> str:
        """Return the net of an item, by its number or its name."""
        found = (child(node, "net") or ["net", ""])[1]
        return self.nets.get(found, "") if isinstance(found, float) else str(found)

    def on(self, node: Node) -> tuple[str, ...]:
        """Return the copper layers that an item is on."""
        given = texts(node, "layer") + texts(node, "layers")
        more = tuple(self.layers) if "*.Cu" in given else ("F.Cu", "B.Cu") if "F&B.Cu" in given else ()
        return tuple(layer for name, layer in self.layers.items() if name in given or name in more)

    def tracks(
        self, nodes: Sequence[Node], frame: _Frame, layers: tuple[str, ...] = (), net: str = ""
    ) -> list[Track]:
        """Return tracks, lines, arcs and strips of copper among some nodes, those of a pad on its layers and net."""
        found = []
        for node in nodes:
            own, on = net or self.net(node), self.drawn_on(node)
            on = layers or on
            shape = self.shape(node, frame) if on else None
            if shape is not None:
                found += [Track(layer, line, shape[1], own, frame.number) for layer in on for line in shape[0]]
        return found

    def drawn_on(self, node: Node) -> tuple[str, ...]:
        """Return the copper layer that a track or a drawing is on, if any; refuse one that the board has not."""
        on = self.on(node)[:1]
        lost = [layer for layer in texts(node, "layer") if layer.endswith(".Cu") and not on]
        if lost:
            raise SceneError(f"{self.name}: {node[0]}: must be on one of {', '.join(self.layers)}; got {lost[0]}")
        return on

    def shape(self, node: Node, frame: _Frame) -> tuple[list[Array], float] | None:
        """Return lines and width of what a node draws on the board [m]; None of a polygon that is no strip."""
        where = f"{self.name}: {node[0]}"
        if node[0].endswith("poly"):
            corners = self.corners(node, frame)
            found = strip(corners) if len(corners) > 3 and is_filled(node) else None
            return found and ([*map(np.array, pairwise(found[0]))], found[1] + self.border(node))
        points = frame.onto(three_points(node, where))
        (width,) = numbers(child(node, "stroke") or node, "width", 1, f"{where} at {board_point(points[0])}")
        return [points], METRES * width

    def border(self, node: Node) -> float:
        """Return the width of the line round a drawn polygon [m]."""
        stroke = child(node, "stroke") or node
        return METRES * numbers(stroke, "width", 1, f"{self.name}: {node[0]}")[0] if child(stroke, "width") else 0.0

    def primitives(self, node: Node, frame: _Frame) -> list[Track]:
        """Return the tracks that a custom pad is drawn of."""
        drawn = _drawings(child(node, "primitives") or [], "gr_")
        if not drawn:
            return []
        where = f"{self.name}: pad of {frame.reference}"
        own = _Frame(frame.number, frame.reference, frame.point(node, "at", where), _turn(node, where))
        return self.tracks(drawn, own, self.on(node), self.net(node))

    def via(self, node: Node) -> Hole:
        """Return a via, on all layers between the two that it names."""
        where = f"{self.name}: via"
        point, (size,) = _BOARD.point(node, "at", where), numbers(node, "size", 1, where)
        copper = tuple(self.layers.values())
        ends = [copper.index(layer) for layer in self.on(node)] or [0, len(copper) - 1]
        through = copper[min(ends) : max(ends) + 1]
        return Hole("", point, (METRES * size, METRES * size), 0.0, through, self.net(node))

    def pad(self, node: Node, frame: _Frame) -> list[Hole]:
        """Return a pad; none of a hole without copper."""
        if "np_thru_hole" in node[2:3]:
            return []
        number = _word(node[1])
        where = f"{self.name}: pad {frame.reference}.{number}"
        size, angle = numbers(node, "size", 2, where), _turn(node, where)
        name = f"{frame.reference}.{number}" if number else ""
        extent = (METRES * size[0], METRES * size[1])
        return [Hole(name, frame.point(node, "at", where), extent, angle, self.on(node), self.net(node), frame.number)]

    def zone(self, node: Node) -> Zone:
        """Return a zone with what is filled of it."""
        fills = []
        for fill in children(node, "filled_polygon"):
            corners = self.corners(fill)
            layer = self.layers.get((texts(fill, "layer") or texts(node, "layer") or [""])[0], "")
            if len(corners) > 2 and layer:
                fills.append((layer, corners))
        net, border = self.net(node) or "".join(texts(node, "net_name")), pen(node, self.version, f"{self.name}: zone")
        return Zone(net, self.on(node), tuple(fills), METRES * border)

    def areas(self, nodes: Sequence[Node]) -> list[Zone]:
        """Return filled polygons drawn on copper that are no strips, as zones."""
        found = list[Zone]()
        for node in nodes:
            corners, on = self.corners(node), self.on(node)[:1]
            if on and len(corners) > 2 and is_filled(node) and self.shape(node, _BOARD) is None:
                found.append(Zone(self.net(node), on, ((on[0], corners),), self.border(node), drawn=True))
        return found

    def corners(self, node: Node, frame: _Frame = _BOARD) -> Array:
        """Return the corners of a polygon on the board (k, 2), three of an arc [m]."""
        found, where = [np.zeros((0, 2))], f"{self.name}: {node[0]}"
        for item in children(child(node, "pts") or [], "xy", "arc"):
            found.append(np.array([numbers([item], "xy", 2, where)]) if item[0] == "xy" else three_points(item, where))
        return frame.onto(np.vstack(found))


def _word(item: float | str) -> str:
    """Return a name that may have been read as a number."""
    return f"{item:g}" if isinstance(item, float) else str(item)


def _is_pour(zone: Node) -> bool:
    """Tell whether a zone is one of copper, and no teardrop of a pad."""
    return child(zone, "keepout") is None and child(child(zone, "attr") or [], "teardrop") is None


def _drawings(node: Node, prefix: str) -> list[Node]:
    """Return the lines, arcs and polygons that are drawn in a node."""
    return children(node, *(prefix + kind for kind in _DRAWN))


def _turn(node: Node, where: str) -> float:
    """Return the angle that an item is turned by, counter-clockwise [rad]."""
    return math.radians(numbers(node, "at", 3, where)[2]) if len(child(node, "at") or []) > 3 else 0.0
