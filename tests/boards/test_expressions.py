"""Expressions: what is text, word and number; what is refused in one line; what versions of KiCad write differently."""

from pathlib import Path

import numpy as np
import pytest

from sits_mech.boards.expressions import (
    Node,
    child,
    children,
    copper_layers,
    is_filled,
    numbers,
    parse_expression,
    pen,
    read_expression,
    texts,
    three_points,
)
from sits_mech.units import SceneError


def test_words_numbers_and_texts_stay_apart() -> None:
    """Nested, with quoted brackets and escapes; a quoted number is a text."""
    tree = parse_expression('(a 1 -.5e3 "1" word (b "x (y) \\"z\\" \\\\") (b (c)) 0041e8ea-52)')
    assert tree == ["a", 1.0, -500.0, "1", "word", ["b", 'x (y) "z" \\'], ["b", ["c"]], "0041e8ea-52"]
    assert children(tree, "b") == [["b", 'x (y) "z" \\'], ["b", ["c"]]] and child(tree, "d") is None
    assert texts(tree, "b") == ['x (y) "z" \\'] and texts(tree, "d") == []
    assert numbers(tree[6], "c", 0, "here") == []


@pytest.mark.parametrize("text", ["(a", "(a))", "(a) (b)", "a", "", "(a) b"])
def test_what_is_no_expression(text: str) -> None:
    """Brackets that do not match, more than one expression, or none."""
    assert parse_expression(text) is None


@pytest.mark.parametrize(
    ("content", "expected"),
    [(b"(kicad_pcb", "cut off"), (b"\xff\xfe\x00", "in text"), (b"", "got nothing"), (b"name = 1", 'got "name = 1"')],
)
def test_files_that_are_none(tmp_path: Path, content: bytes, expected: str) -> None:
    """One line with the file."""
    path = tmp_path / "x.kicad_pcb"
    path.write_bytes(content)
    with pytest.raises(SceneError, match=expected) as caught:
        read_expression(path)
    assert "x.kicad_pcb: must be" in str(caught.value) and "\n" not in str(caught.value)
    with pytest.raises(SceneError, match="No such file"):
        read_expression(tmp_path / "y.kicad_pcb")


def test_missing_numbers_are_named() -> None:
    """Where, key, how many, what came."""
    with pytest.raises(SceneError, match=r'via: \(at ...\) must be 2 numbers or more, up to 2147.5; got "1.0 x"'):
        numbers(["via", ["at", 1.0, "x"]], "at", 2, "via")
    with pytest.raises(SceneError, match=r"via: \(size ...\) must be 1 number or more, up to 2147.5; it is missing"):
        numbers(["via"], "size", 1, "via")


def node(text: str) -> Node:
    """Return an expression."""
    found = parse_expression(text)
    assert found is not None
    return found


@pytest.mark.parametrize(("angle", "mid", "end"), [(90, (5.70711, 0.70711), (5, 1)), (-180, (5, -1), (4, 0))])
def test_arcs_of_old_drawings(angle: float, mid: tuple[float, float], end: tuple[float, float]) -> None:
    """About (5, 0) from (6, 0): as KiCad shows them, y down, positive angles turn clockwise."""
    old = three_points(node(f"(gr_arc (start 5 0) (end 6 0) (angle {angle}) (layer F.Cu) (width 0.2))"), "b")
    np.testing.assert_allclose(old, [(6, 0), mid, end], atol=1e-5)
    new = node(f"(gr_arc (start 6 0) (mid {mid[0]} {mid[1]}) (end {end[0]} {end[1]}))")
    np.testing.assert_allclose(three_points(new, "b"), old, atol=1e-5)


def test_layers_by_number_and_by_name() -> None:
    """Users' names count in KiCad 5, whose items use them; later the second name is for show."""
    old = "(kicad_pcb (layers (0 Top signal) (1 GND power) (2 In2.Cu signal) (31 Bottom mixed) (44 Edge.Cuts user)))"
    assert copper_layers(node(old)) == {"Top": "F.Cu", "GND": "In1.Cu", "In2.Cu": "In2.Cu", "Bottom": "B.Cu"}
    new = '(kicad_pcb (layers (0 "F.Cu" signal "Top") (2 "B.Cu" signal) (4 "In1.Cu" power "GND") (39 "User.1" user)))'
    assert list(copper_layers(node(new)).values()) == ["F.Cu", "In1.Cu", "B.Cu"]


@pytest.mark.parametrize(
    ("text", "filled"),
    [("", True), ("(fill solid)", True), ("(fill yes)", True), ("(fill none)", False), ("(fill no)", False)],
)
def test_polygons_are_filled_where_nothing_is_said(text: str, filled: bool) -> None:
    """As KiCad 5 wrote them."""
    assert is_filled(node(f"(gr_poly (pts) {text})")) is filled


@pytest.mark.parametrize(
    ("version", "text", "width"),
    [(20171130, "", 0.25), (20250209, "", 0.25), (20250210, "", 0.0), (20171130, "(filled_areas_thickness no)", 0.0)],
)
def test_fills_with_a_pen(version: int, text: str, width: float) -> None:
    """Before 20250210 where nothing is said, as KiCad's own parser takes it."""
    assert pen(node(f"(zone (min_thickness 0.25) {text})"), version, "b") == width
