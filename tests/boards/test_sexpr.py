"""Expressions: what is text, word and number; what is refused in one line."""

from pathlib import Path

import pytest

from sits_mech.boards.sexpr import child, children, numbers, parse_expression, read_expression, texts
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
