"""Boards in KiCad's text format, drawn for the tests."""

from collections.abc import Sequence
from pathlib import Path

import pytest

LAYERS = '(layers (0 "F.Cu" signal) (31 "B.Cu" signal "Bottom") (44 "Edge.Cuts" user))'
FOUR = '(layers (0 "F.Cu" signal) (2 "B.Cu" signal) (4 "In1.Cu" power) (6 "In2.Cu" mixed) (25 "Edge.Cuts" user))'
STACK = """(setup (stackup
  (layer "F.SilkS" (type "Top Silk Screen")) (layer "F.Mask" (type "Top Solder Mask") (thickness 0.01))
  (layer "F.Cu" (type "copper") (thickness 0.035))
  (layer "dielectric 1" (type "prepreg") (thickness 0.2) (material "FR4") (epsilon_r 4.5))
  (layer "In1.Cu" (type "copper") (thickness 0.0175))
  (layer "dielectric 2" (type "core") (thickness 0.6 locked) (epsilon_r 4.8) addsublayer (thickness 0.4)
    (epsilon_r 4))
  (layer "In2.Cu" (type "copper") (thickness 0.0175))
  (layer "dielectric 3" (type "prepreg") (thickness 0.2))
  (layer "B.Cu" (type "copper") (thickness 0.035)) (copper_finish "None")))"""
Place = Sequence[float]


class Drawing:
    """A pen for boards; places in the board's millimetres, y down."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def line(self, a: Place, b: Place, layer: str = "F.Cu", net: str = "1", width: float = 0.2) -> str:
        """Return a track."""
        ends = f"(start {a[0]:.7g} {a[1]:.7g}) (end {b[0]:.7g} {b[1]:.7g})"
        return f'(segment {ends} (width {width}) (layer "{layer}") (net {net}) (uuid "0-1"))'

    def lines(self, points: Sequence[Place], layer: str = "F.Cu", net: str = "1", width: float = 0.2) -> list[str]:
        """Return the tracks from point to point."""
        return [self.line(a, b, layer, net, width) for a, b in zip(points[:-1], points[1:], strict=True)]

    def arc(self, a: Place, m: Place, b: Place, layer: str = "F.Cu", net: str = "1", width: float = 0.2) -> str:
        """Return an arc of track."""
        ends = f"(start {a[0]:.9g} {a[1]:.9g}) (mid {m[0]:.9g} {m[1]:.9g}) (end {b[0]:.9g} {b[1]:.9g})"
        return f'(arc {ends} (width {width}) (layer "{layer}") (net {net}) (tstamp 0041e8ea-5200))'

    def via(self, at: Place, layers: str = '"F.Cu" "B.Cu"', net: str = "1", kind: str = "") -> str:
        """Return a via of 0.6 mm."""
        return f"(via {kind} (at {at[0]:.9g} {at[1]:.9g}) (size 0.6) (drill 0.3) (layers {layers}) (net {net}))"

    def pad(self, name: str, at: Place, net: str = '1 "L1"', layers: str = '"F.Cu" "F.Mask"') -> str:
        """Return a footprint J1 of one pad of 1 mm."""
        inside = f'(pad "{name}" smd rect (at 0 0) (size 1 1) (layers {layers}) (net {net}))'
        return f'(footprint "Pad" (layer "F.Cu") (at {at[0]} {at[1]}) (property "Reference" "J1" (at 0 0)) {inside})'

    def zone(self, points: Sequence[Place], layer: str = "B.Cu", net: str = '(net 2) (net_name "GND")') -> str:
        """Return a zone, filled where points are given."""
        corners = " ".join(f"(xy {x:.9g} {y:.9g})" for x, y in points)
        fill = f'(filled_polygon (layer "{layer}") (pts {corners}))' if points else ""
        outline = "(polygon (pts (xy 0 0) (xy 1 0) (xy 1 1)))"
        how = "(min_thickness 0.25) (filled_areas_thickness no) (fill yes)"
        return f'(zone {net} (layer "{layer}") (hatch edge 0.5) {how} {outline} {fill})'

    def board(self, items: Sequence[str], four: bool = False, version: int = 20241229, nets: str = "") -> Path:
        """Write a board with the nets L1, GND and L2: two layers without a stack-up, or four with one."""
        head = f'(kicad_pcb (version {version}) (generator "test") (general (thickness 1.6))'
        named = nets or '(net 0 "") (net 1 "L1") (net 2 "GND") (net 3 "L2")'
        layers = (FOUR, STACK) if four else (LAYERS, "(setup (pad_to_mask_clearance 0))")
        self.path.write_text("\n".join([head, *layers, named, *items]) + ")\n")
        return self.path


@pytest.fixture
def draw(tmp_path: Path) -> Drawing:
    """Return a pen for one board."""
    return Drawing(tmp_path / "board.kicad_pcb")
