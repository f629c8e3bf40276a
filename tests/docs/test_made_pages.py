"""Pages made of what stands in the source."""

from pathlib import Path

from made_pages import numbers_of

SOURCE = '''# Lengths [m]
_A = 1.0
B: float = 2.0  # two
C = 3


D, E = 4, 5
"""Both."""
'''


def test_words_of_a_number_stand_behind_below_or_above_it() -> None:
    assert list(numbers_of(SOURCE)) == [
        ("_A", "1.0", "Lengths [m]"), ("B", "2.0", "two"), ("C", "3", ""), ("D, E", "4, 5", "Both."),
    ]


def test_numbers_that_decide_say_what_they_are() -> None:
    """None of the package is without words: the reference shows each."""
    files = (Path(__file__).parents[2] / "sits_mech").rglob("*.py")
    found = {path: numbers_of(path.read_text(encoding="utf-8")) for path in files}
    assert [(path.name, name) for path, rows in found.items() for name, _, words in rows if not words] == []
