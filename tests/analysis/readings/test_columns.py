"""Rows of numbers in files: their cells, and what is no number."""

from pathlib import Path

import numpy as np
import pytest

from sits_mech.analysis.readings.columns import line_cells, names_found, number_rows, plain, read_tables, titled
from sits_mech.units import SceneError


def test_names_are_found_below_any_header(tmp_path: Path) -> None:
    """By the first separator under which they are known, again further below; a message names what stands there."""
    path = tmp_path / "x.csv"
    path.write_text('Lab, north; 3\nb,"a"\nmm,%\n1,2\n# 5,6\nA (K),b\n3,4\n')
    known = [column.name for column in read_tables(path, "a table", lambda columns: columns)[0][1]]
    assert known == ["lab, north", "3"]
    (first, _), (second, _) = read_tables(path, "a table", lambda columns: "a" in [column.name for column in columns])
    assert [(one.name, one.unit, one.place) for one in first.columns] == [("b", "mm", 0), ("a", "%", 1)]
    assert first.above == [["Lab", "north; 3"]] and first.numbers([1, 0]).tolist() == [[2.0, 1.0]]
    assert second.columns[0].unit == "K" and second.numbers([0]).tolist() == [[3.0]]
    assert read_tables(path, "a table", lambda columns: None) == []
    path.write_text("Lab;3\nZeit;Kraft\ns;N\n1;2\n2;3\n")
    assert names_found(path, "a table") == "Zeit, Kraft"
    path.write_text("nothing\n")
    assert names_found(path, "a table") == "no row of names above rows of numbers"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1252", "cp932"])
def test_letters_of_windows_and_of_spreadsheets(encoding: str, tmp_path: Path) -> None:
    """Names are found in the encoding in which they are known."""
    title = {"cp1252": "Dehnung für µ", "cp932": "応力"}.get(encoding, "応力 für µ")
    (tmp_path / "x.csv").write_bytes("\n".join([title, *["1.5"] * 20]).encode(encoding))
    found = read_tables(tmp_path / "x.csv", "a table", lambda columns: columns[0].title == title)
    assert len(found) == 1


def test_units_stand_in_titles_or_below() -> None:
    """In brackets, after "in" or a stroke where it is a unit; what is none stays in the name."""
    for title, name, unit in (
        ("Kraft in N", "kraft", "N"), ("Weg / mm", "weg", "mm"), ("応力（MPa）", "応力", "MPa"),
        ("L1 [\u00b5H]", "l1", "μH"),
        ("Time (sec)", "time", "s"), ("made in Japan", "made in japan", ""), ("F_x", "f_x", ""),
    ):
        assert titled(title) == (name, unit)
    assert plain("Messlänge") == plain("MESSLAENGE") != plain("Länge")


def test_quotes_belong_to_whole_cells() -> None:
    """A comma between them does not make two numbers of one."""
    assert line_cells(' "a; b" ;c;"";5"', ";") == ["a; b", "c", "", '5"'] and line_cells("x" * 200_000, ",") == []
    with pytest.raises(SceneError, match="must hold plain numbers"):
        number_rows(['"2,5","1,5"'], ",", [0, 1], "x.csv")


def test_rows_of_numbers_are_kept_and_others_passed_over() -> None:
    """Short rows, words and gaps; nan is kept, grouped digits are refused."""
    rows = number_rows(["1;x;2,5", "1;2", "-1e3;;nan", "s;;m", ";;1"], ";", [0, 2], "x.csv")
    np.testing.assert_array_equal(rows, [[1.0, 2.5], [-1e3, np.nan]])
    assert number_rows([], ";", [0, 2], "x.csv").shape == (0, 2)
    for line in ("1.234,5;2", "1 234;2", "1,234.5;2", "1.234,5;1e-6", '"1,5",.9'):
        with pytest.raises(SceneError, match=r"x.csv: rows must hold plain numbers, such as 1234.5; got"):
            number_rows([line], ";" if ";" in line else ",", [0, 1], "x.csv")
