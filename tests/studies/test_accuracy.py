"""Ladders: which rungs are on the front, whose estimates hold."""

from pathlib import Path

import pytest
from common.accuracy import Rung, draw_ladders, machine, pareto_front, rung_rows


def test_the_front_is_what_nothing_beats() -> None:
    """Slower and worse is off; slower and better, or faster and worse, stays."""
    fast, slow = Rung("a", "1", 0.1, 1e-1, 1e-1), Rung("a", "2", 1.0, 1e-3, 1e-3)
    beaten, best = Rung("b", "1", 0.5, 2e-1, 1e-1), Rung("b", "2", 2.0, 1e-4, 1e-4)
    assert pareto_front([best, beaten, slow, fast]) == [fast, slow, best]


@pytest.mark.parametrize(
    ("error", "estimated", "resolved", "honest"),
    [(1e-3, 4e-3, 0.0, True), (1e-3, 6e-3, 0.0, False), (1e-3, 1.9e-4, 0.0, False), (1e-3, 2.1e-4, 0.0, True),
     (1e-3, 2e-5, 1e-3, True), (0.0, 4e-3, 1e-3, True), (0.0, 6e-3, 1e-3, False)],
)  # fmt: skip
def test_an_estimate_holds_within_a_factor_of_five(
    error: float, estimated: float, resolved: float, honest: bool
) -> None:
    """Too small and too large both fail; what the reference cannot tell is not held against it."""
    assert Rung("a", "1", 1.0, error, estimated, resolved).honest is honest


def test_tables_and_pictures(tmp_path: Path) -> None:
    """One row a rung with its panel; an error of zero can be drawn; the machine is named."""
    panels = {"one": [Rung("a", "1", 0.1, 0.0, 1e-3)], "two": [Rung("b", "1", 0.1, 1e-2, 1e-2)]}
    draw_ladders(panels, tmp_path / "ladders.png")
    assert (tmp_path / "ladders.png").stat().st_size > 10_000
    rows = rung_rows(panels)
    assert [row["part"] for row in rows] == ["one", "two"] and rows[1]["front"] == "yes"
    assert "cores" in machine() and "BLAS thread" in machine()
