"""Numbers with their errors, to the digits that the error leaves."""

import math

import pytest

from sits_mech.report.tables.solves import with_error


@pytest.mark.parametrize(("value", "error", "expected"), [
    (12.3456, 0.21, "12.35 +- 0.21"), (12.3456, 3.4, "12.3 +- 3.4"), (1234.5, 56.0, "1234 +- 56"),
    (0.0, 0.0, "0 +- 0"), (2000.0, 0.0, "2000 +- 0"), (math.nan, 0.1, "-"), (1.5, math.inf, "1.5 +- ?"),
    (-0.00123, 0.000045, "-0.001230 +- 0.000045"),
])  # fmt: skip
def test_digits_follow_the_error(value: float, error: float, expected: str) -> None:
    """Two digits of the error; neither invented nor lost."""
    assert with_error(value, error) == expected
