"""What a study leaves behind: rows as CSV and Markdown."""

from pathlib import Path

from common.outputs import write_rows


def test_rows_as_csv_and_markdown(tmp_path: Path) -> None:
    """Headings from the first row; digits kept in the one, cut in the other."""
    text = write_rows([{"a": 1.0 / 3.0, "b": "x|y"}, {"a": 2.0, "b": "z"}], tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_text() == "a,b\n0.3333333333333333,x|y\n2.0,z\n"
    assert text == (tmp_path / "t.md").read_text() == "| a | b |\n|---|---|\n| 0.3333 | x/y |\n| 2 | z |\n"
