"""Coils of any board: KiCad 5 to 10, every habit, found and taken as they are listed, with the right inductance."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import shapely

from sits_mech.boards.kicad import read_board
from sits_mech.boards.scene import Selection, board_scene
from sits_mech.boards.windings import windings
from sits_mech.geometry.windings import Sections
from sits_mech.magnetics.coils.loops import free_inductances, ring_inductance
from sits_mech.quantities import Array
from sits_mech.scene.sensor import load_sensor

VERSIONS = {5: 20171130, 6: 20211014, 7: 20221018, 8: 20240108, 9: 20241229, 10: 20260206}
HABITS = ("tracks", "net 0", "drawn", "lines of a footprint", "custom pad", "polygon", "on the back", "short steps")
STACK_UP = 0.035, 0.165  # copper and what is between two layers, in millimetres
TURNS, INNER, PITCH, WIDTH = 3, 2.0, 0.4, 0.15  # of a layer; middle of the innermost half turn, rise in a turn [mm]
Place = Sequence[float]


@dataclass(frozen=True)
class Pen:
    """Writes items as a version of KiCad does; places in millimetres, y down."""

    kicad: int

    def word(self, text: str) -> str:
        """Return a name: without quotes in KiCad 5."""
        return text if self.kicad == 5 else f'"{text}"'

    def net(self, number: int) -> str:
        """Return a net: by name from KiCad 10 on."""
        names = ("", "A", "B")
        return f'(net "{names[number]}")' if self.kicad == 10 else f"(net {number})"

    def pad_net(self, number: int) -> str:
        """Return the net of a pad, with its name."""
        name = self.word("AB"[number - 1])
        return f"(net {name})" if self.kicad == 10 else f"(net {number} {name})"

    def stroke(self, width: float) -> str:
        """Return the width of a drawing."""
        return f"(width {width})" if self.kicad < 7 else f"(stroke (width {width}) (type solid))"

    def layer(self, name: str) -> str:
        """Return a layer, in KiCad 5 by the name that its user chose."""
        renamed = {"F.Cu": "Top", "In1.Cu": "Inside"} if self.kicad == 5 else {}
        return self.word(renamed.get(name, name))

    def track(self, kind: str, points: Array, layer: str, net: int) -> list[str]:
        """Return half circles over points: tracks of a net, drawings (gr) or lines of a footprint (fp)."""
        found, on = [], f"(layer {self.layer(layer)})"
        for a, m, b in zip(points[:-2:2], points[1:-1:2], points[2::2], strict=True):
            ends = f"(start {a[0]:.6f} {a[1]:.6f}) (mid {m[0]:.6f} {m[1]:.6f}) (end {b[0]:.6f} {b[1]:.6f})"
            if kind == "track" and self.kicad > 5:
                found.append(f"(arc {ends} (width {WIDTH}) {on} {self.net(net)})")
            elif kind == "track":
                found += [self.segment(*pair, on, net) for pair in halves(a, m, b)]
            elif self.kicad == 5:  # by centre, first point and angle
                centre, sign = (a + b) / 2, 180 if np.linalg.det([m - a, b - a]) > 0 else -180
                old = f"(start {centre[0]:.6f} {centre[1]:.6f}) (end {a[0]:.6f} {a[1]:.6f}) (angle {sign})"
                found.append(f"({kind}_arc {old} {on} {self.stroke(WIDTH)})")
            else:
                found.append(f"({kind}_arc {ends} {self.stroke(WIDTH)} {on})")
        return found

    def segment(self, a: Place, b: Place, on: str, net: int) -> str:
        """Return a straight track."""
        ends = f"(start {a[0]:.6f} {a[1]:.6f}) (end {b[0]:.6f} {b[1]:.6f})"
        return f"(segment {ends} (width {WIDTH}) {on} {self.net(net)})"

    def via(self, at: Place, net: int) -> str:
        """Return a via through the board."""
        both = f"{self.layer('F.Cu')} {self.layer('B.Cu')}"
        return f"(via (at {at[0]:.6f} {at[1]:.6f}) (size 0.4) (drill 0.2) (layers {both}) {self.net(net)})"

    def pad(self, name: str, at: Place, net: int, layers: str, more: str = "rect", angle: float = 0.0) -> str:
        """Return a pad; `more` is its shape, and what follows; `angle` is the board's."""
        shape, _, rest = more.partition(" ")
        sizes = f"(at {at[0]:.6f} {at[1]:.6f} {angle}) (size 0.3 0.3)"
        return f"(pad {self.word(name)} smd {shape} {sizes} (layers {layers}) {self.pad_net(net)} {rest})"

    def footprint(self, items: Sequence[str], at: Place = (0, 0), angle: float = 0.0, side: str = "F.Cu") -> str:
        """Return the footprint L1."""
        head = "module own:coil" if self.kicad == 5 else 'footprint "own:coil"'
        silk = self.word("F.SilkS")
        named = f'(property "Reference" "L1" (at 0 0 0) (layer {silk}))' if self.kicad > 7 else (
            f"(fp_text reference {self.word('L1')} (at 0 0) (layer {silk}))"
        )
        place = f"(at {at[0]} {at[1]} {angle})"
        return f"({head} (layer {self.layer(side)}) (tedit 5F0) {place} {named} {' '.join(items)})"

    def board(self, items: Sequence[str], layers: int) -> str:
        """Return the file of a board."""
        names = ["F.Cu", *(f"In{k}.Cu" for k in range(1, max(layers, 2) - 1)), "B.Cu"]
        numbers = [0, *(range(4, 40, 2) if self.kicad > 8 else range(1, 30))][: len(names) - 1]
        numbers.append(2 if self.kicad > 8 else 31)
        table = " ".join(f"({k} {self.layer(name)} signal)" for k, name in zip(numbers, names, strict=True))
        copper, gap = STACK_UP
        sheets = f' (layer "dielectric" (type "core") (thickness {gap}) (epsilon_r 4.5)) '.join(
            f'(layer "{name}" (type "copper") (thickness {copper}))' for name in names
        )
        setup = "(setup (pad_to_mask_clearance 0))" if self.kicad == 5 else f"(setup (stackup {sheets}))"
        thick = len(names) * copper + (len(names) - 1) * gap
        nets = "" if self.kicad == 10 else f'(net 0 "") (net 1 {self.word("A")}) (net 2 {self.word("B")})'
        head = f"(kicad_pcb (version {VERSIONS[self.kicad]}) (host pcbnew 5) (general (thickness {thick:.4f}))"
        return "\n".join([head, f"(layers {table} (44 {self.word('Edge.Cuts')} user))", setup, nets, *items, ")\n"])


def halves(a: Array, m: Array, b: Array) -> list[tuple[Array, Array]]:
    """Return a half circle as straight steps."""
    centre, first = (a + b) / 2, a - (a + b) / 2
    sign = 1.0 if np.linalg.det([m - a, b - a]) > 0 else -1.0
    angle = sign * np.linspace(0.0, np.pi, 33)
    c, s = np.cos(angle), np.sin(angle)
    points = centre + np.column_stack([c * first[0] - s * first[1], s * first[0] + c * first[1]])
    points[-1] = b
    return list(zip(points[:-1], points[1:], strict=True))


def layer_line(inwards: bool) -> Array:
    """Return the ends and middles of the half circles of a layer: all turn alike, those inwards from the outside [mm].

    Their centres lie on the x axis, a quarter of the rise to either side: each half circle is wider than the last.
    """
    radius = INNER + PITCH / 2 * np.arange(2 * TURNS)
    ends = np.cumsum(np.concatenate([[-INNER], 2 * radius * (-1.0) ** np.arange(2 * TURNS)]))
    points = []
    for k, r in enumerate(radius):
        points += [(ends[k], 0.0), ((ends[k] + ends[k + 1]) / 2, -r if k % 2 == 0 else r)]
    line = np.array([*points, (ends[-1], 0.0)])
    return line[::-1] * (1, -1) if inwards else line


def expected(layers: int) -> float:
    """Return the mean inductance of rings in place of all half circles of one side, which are the nearest [H].

    Every other layer has its wider halves on the other side.
    """
    z, number = -1e-3 * sum(STACK_UP) * np.repeat(np.arange(layers), TURNS), np.tile(np.arange(TURNS), layers)
    wider = np.repeat(np.arange(layers) % 2, TURNS)
    sizes = np.full(z.shape, 1e-3 * WIDTH), np.full(z.shape, 1e-3 * STACK_UP[0])
    sides = [1e-3 * (INNER + PITCH * (number + 0.5 * each)) for each in (wider, 1 - wider)]
    return float(np.mean([ring_inductance(Sections(radius, z, *sizes)).sum() for radius in sides]))


def drawn_board(kicad: int, habit: str, layers: int) -> str:
    """Return a board with one coil that starts outside on the first layer, drawn after a habit."""
    pen = Pen(kicad)
    names = ["F.Cu", *(f"In{k}.Cu" for k in range(1, layers - 1)), *(["B.Cu"] if layers > 1 else [])]
    lines = [layer_line(k % 2 == 0) for k in range(layers)]
    if habit == "on the back":
        names = ["B.Cu", *names[1:-1][::-1], "F.Cu"][:layers] if layers > 1 else ["B.Cu"]
    own = habit in ("lines of a footprint", "custom pad", "on the back")
    at, angle = ((20.0, 30.0), 30.0) if own else ((0.0, 0.0), 0.0)
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn, net = np.array([[c, -s], [s, c]]), 0 if habit in ("net 0", "short steps") else 1
    vias = [
        pen.via(line[-1] @ turn + at, net).replace("(via (", "(via blind (").replace(
            f"(layers {pen.layer('F.Cu')} {pen.layer('B.Cu')})", f"(layers {pen.layer(a)} {pen.layer(b)})"
        ) for line, a, b in zip(lines[:-1], names[:-1], names[1:], strict=True)
    ]
    kind = "fp" if own else "gr" if habit in ("drawn", "polygon") else "track"
    copper = [pen.track(kind, line, name, net) for line, name in zip(lines, names, strict=True)]
    first = pen.pad("1", lines[0][0], 1, pen.layer(names[0]), "rect")
    if habit == "polygon":
        copper = [[strip(pen, line, name)] for line, name in zip(lines, names, strict=True)]
    if habit == "custom pad":
        inside = " ".join(item.split(" (layer ")[0] + f" (width {WIDTH}))" for item in
                          pen.track("gr", lines[0] - lines[0][0], names[0], 0))
        more = f"custom (options (clearance outline) (anchor rect)) (primitives {inside})"
        first = pen.pad("1", lines[0][0], 1, pen.layer(names[0]), more, angle)
        copper[0] = []
    if habit == "short steps":
        copper = [
            [pen.segment(a, b, f"(layer {pen.layer(name)})", 0) for trio in
             zip(line[:-2:2], line[1:-1:2], line[2::2], strict=True) for a, b in halves(*trio)]
            for line, name in zip(lines, names, strict=True)
        ]
    items = [item for each in copper for item in each]
    pads = [first, pen.pad("2", lines[-1][-1], 2, pen.layer(names[-1]))]
    if own:
        return pen.board([pen.footprint([*items, *pads], at, angle, names[0]), *vias], layers)
    both = [pen.footprint(pads)] if habit in ("drawn", "polygon") else []
    lead = [pen.segment((40, 0), (44, 0), f"(layer {pen.layer('F.Cu')})", 2)]  # of the other net, elsewhere
    return pen.board([*items, *both, *vias, *lead], layers)


def strip(pen: Pen, line: Array, layer: str) -> str:
    """Return half circles as the outline of their copper, filled."""
    steps = [a for trio in zip(line[:-2:2], line[1:-1:2], line[2::2], strict=True) for a, _ in halves(*trio)]
    rim = shapely.LineString([*steps, line[-1]]).buffer(WIDTH / 2, cap_style="flat").exterior
    corners = " ".join(f"(xy {x:.6f} {y:.6f})" for x, y in rim.coords[:-1])
    fill = "" if pen.kicad == 5 else "(fill yes)" if pen.kicad > 8 else "(fill solid)"
    return f"(gr_poly (pts {corners}) (layer {pen.layer(layer)}) {pen.stroke(0)} {fill})"


BOARDS = [(5 + k % 6, HABITS[k % 8], 1 + (k + k // 6 + k // 24) % 6) for k in range(40)]


@pytest.mark.parametrize(
    ("kicad", "habit", "layers"), [pytest.param(*each, marks=[pytest.mark.slow] * (each[2] > 3)) for each in BOARDS]
)
def test_a_coil_of_any_board(kicad: int, habit: str, layers: int, tmp_path: Path) -> None:
    """It is the one coil that is listed; taken as the list says, it has the inductance of rings to 1 %."""
    path = tmp_path / "board.kicad_pcb"
    path.write_text(drawn_board(kicad, habit, layers), encoding="utf-8")
    (found,) = windings(read_board(path))
    assert found.refusal == "" and len(found.layers) == layers and found.turns == pytest.approx(TURNS * layers, abs=0.3)
    length = layers * 1e-3 * np.pi * (INNER + PITCH / 2 * np.arange(2 * TURNS)).sum()
    assert found.length == pytest.approx(length, rel=5e-3)
    option, _, value = found.take.partition("=")
    own = {"net 0": "--at", "short steps": "--at", "lines of a footprint": "--footprint", "on the back": "--footprint"}
    assert option == own.get(habit, "--net")
    key = {"--net": "nets", "--footprint": "footprints", "--at": "places"}[option]
    text, _ = board_scene(path, Selection(**{key: (value,)}, chord_error=1e-5))
    (path.parent / "scene.toml").write_text(text, encoding="utf-8")
    coils = load_sensor(path.parent / "scene.toml").coils
    assert free_inductances(coils)[0, 0] == pytest.approx(expected(layers), rel=1e-2)


def test_boards_are_of_all_kinds() -> None:
    """Each version, each habit and each number of layers is among them, and no two are the same."""
    assert len(set(BOARDS)) == len(BOARDS) == 40
    assert [set(column) for column in zip(*BOARDS, strict=True)] == [set(VERSIONS), set(HABITS), set(range(1, 7))]
