"""What a study leaves behind: rows as CSV and Markdown."""

import math
from pathlib import Path

from common.outputs import kept_rows, write_rows


def test_rows_as_csv_and_markdown(tmp_path: Path) -> None:
    """Headings from the first row; digits kept in the one, cut in the other."""
    text = write_rows([{"a": 1.0 / 3.0, "b": "x|y"}, {"a": 2.0, "b": "z"}], tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_text() == "a,b\n0.3333333333333333,x|y\n2.0,z\n"
    assert text == (tmp_path / "t.md").read_text() == "| a | b |\n|---|---|\n| 0.3333 | x/y |\n| 2 | z |\n"
    assert write_rows([{"a": 1}, {"b": 2}], tmp_path / "t.csv", missing=math.nan).endswith("| 1 | nan |\n| nan | 2 |\n")


def test_a_stopped_run_goes_on(tmp_path: Path) -> None:
    """What is done is kept, and not done again."""
    asked: list[int] = []

    def measured(number: int) -> dict[str, float]:
        asked.append(number)
        return {"scene": number, "pose over bar": math.nan}

    rows = kept_rows((3, 4, 3), measured, tmp_path)
    assert asked == [3, 4] and rows[0]["scene"] == rows[2]["scene"] == 3 and math.isnan(rows[2]["pose over bar"])
