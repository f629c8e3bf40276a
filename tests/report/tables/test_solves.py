"""Numbers with their errors, to the digits that the error leaves."""

import math

import pytest

from sits_mech.report.tables.solves import figure_text, short, with_error


@pytest.mark.parametrize(("value", "error", "expected"), [
    (12.3456, 0.21, "12.35 +- 0.21"), (12.3456, 3.4, "12.3 +- 3.4"), (1234.5, 56.0, "1234 +- 56"),
    (0.0, 0.0, "0"), (2000.0, 0.0, "2000 +- 0"), (math.nan, 0.1, "-"), (1.5, math.inf, "1.5 +- ?"),
    (-0.00123, 0.000045, "-0.001230 +- 0.000045"),
])  # fmt: skip
def test_digits_follow_the_error(value: float, error: float, expected: str) -> None:
    """Two digits of the error; neither invented nor lost."""
    assert with_error(value, error) == expected


@pytest.mark.parametrize(("value", "error", "expected"), [
    (0.5, 3.4, "below its error, 3.4 N"), (-0.5, 0.5, "below its error, 0.50 N"), (0.0, 55.0, "below its error, 55 N"),
    (0.5, 0.021, "0.500 +- 0.021 N"), (0.0, 0.0, "0 N"), (math.nan, 0.1, "-"), (0.4521, math.nan, "0.452 N"),
    (0.5, math.inf, "not determined: within the errors of the signals"),
])  # fmt: skip
def test_a_figure_that_its_error_exceeds_is_not_quoted(value: float, error: float, expected: str) -> None:
    """The error is, instead; scaled alike."""
    assert figure_text(value, error, unit="N") == expected
    assert figure_text(1e-3 * value, 1e-3 * error, 1e3, "N") == expected


def test_three_digits_without_an_exponent() -> None:
    """As a reader writes them."""
    numbers = (0.00351, 22.84, 1234.5, 0.0000012345, 1.5e7)
    assert [short(x) for x in numbers] == ["0.00351", "22.8", "1234", "1.23e-06", "1.5e+07"]
    assert [short(x, 2) for x in (123.4, 0.00351)] == ["123", "0.0035"]
