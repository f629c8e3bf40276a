"""Blocks of pages: read in order, run in a folder of their own, held against what the page says."""

from pathlib import Path

import pytest
from executed import Mismatch, blocks, run_page, same, steps

PAGE = """# A page

```{file} numbers.txt
1.00
```
Some words.

```{run}
$ cat numbers.txt
1.001
$ echo one \\
  two
one two
```

```{run}
:exit: 3

$ echo wrong >&2; exit 3
wrong
```
"""


def written(tmp_path: Path, text: str) -> Path:
    """Return a page of some text."""
    path = tmp_path / "page.md"
    path.write_text(text)
    return path


def test_blocks_and_commands_are_found_in_order() -> None:
    """With their arguments, codes, and continued lines."""
    found = list(blocks(PAGE))
    assert [(each.kind, each.argument) for each in found] == [("file", "numbers.txt"), ("run", ""), ("run", "")]
    first, second = steps(found[1])
    assert (first.command, first.expected) == ("cat numbers.txt", "1.001\n")
    assert second.command == "echo one \\\n  two" and PAGE[second.start : second.end] == "one two\n"
    assert [step.code for step in steps(found[2])] == [3]


def test_a_page_that_says_what_is_printed_passes(tmp_path: Path) -> None:
    """Its files are there for its commands."""
    assert run_page(written(tmp_path, PAGE), tmp_path / "run") > 0.0


@pytest.mark.parametrize(
    ("old", "new"), [("1.00\n`", "1.10\n`"), ("two\none two", "two\none three"), (":exit: 3", ":exit: 0")]
)
def test_a_page_that_says_otherwise_fails(old: str, new: str, tmp_path: Path) -> None:
    """For a number, a word, an exit code."""
    assert old in PAGE
    with pytest.raises(Mismatch, match="page.md"):
        run_page(written(tmp_path, PAGE.replace(old, new)), tmp_path / "run")


def test_a_page_takes_what_is_printed(tmp_path: Path) -> None:
    """Where it says "..." alone, or what no longer holds; the rest stays."""
    page = written(tmp_path, PAGE.replace("one two\n", "...\n").replace("1.001", "7"))
    run_page(page, tmp_path / "run", update=True)
    assert page.read_text() == PAGE.replace("1.001", "1.00")


@pytest.mark.parametrize(
    ("expected", "printed", "alike"),
    [
        ("d_v │ 1909.55 +- 0.27 um", "d_v │  1910.1 +- 0.30 um", True),
        ("d_v │ 1909.55 +- 0.27 um", "d_v │ 1909.55 +- 0.47 um", False),
        ("d_v │ 1909.55 +- 0.27 um", "d_v │ 1999.55 +- 0.27 um", False),
        ("model │ 1.3 s, converged", "model │ 9.7 s, converged", True),
        ("1 │ 0.02 │ ok", "1 │ 3.99 │ ok", True),
        ("a ... z", "a b c z", True),
        ("a ... z", "a b c", False),
        ("a\n...\nz", "a\nb\nc\nz", True),
        ("a\n...\nz", "a\nb", False),
        ("━━━━╇━━", "━━╇━━━━━", True),
        ("0 +- 0", "1.2e-14 +- 0", True),
        ("one", "two", False),
        ("one", "one\ntwo", False),
    ],
)
def test_numbers_may_round_otherwise_and_words_may_not(expected: str, printed: str, alike: bool) -> None:
    """Errors are less sure than what they are errors of, seconds are anything."""
    assert same(expected, printed) == alike
