"""Rows of numbers in files: their cells, and what is no number."""

import numpy as np
import pytest

from sits_mech.analysis.columns import cells_of, headed, number_rows
from sits_mech.units import SceneError


def test_names_are_found_below_any_header() -> None:
    """By the first separator under which they are known; None without."""
    lines = ["Lab, north; 3", 'b,"a"', "1,2"]
    found = headed(lines, lambda names: names.index("a") if "a" in names else None)
    assert found == (lines[1:], ",", 1) and headed(lines, lambda names: None) is None


def test_quotes_belong_to_whole_cells() -> None:
    """A comma between them does not make two numbers of one."""
    assert cells_of(' "a; b" ;c;"";5"', ";") == ["a; b", "c", "", '5"'] and cells_of("x" * 200_000, ",") == []
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
