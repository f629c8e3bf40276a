"""Ladders: what a reference can judge, whose estimates hold, which points are one, what is said of a figure."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from common.accuracy import Rung, distinct, ladder_figure, machine, rung_rows, verdict

from sits_mech.report.pictures.style import save_figure


@pytest.mark.parametrize(
    ("error", "resolved", "judged"), [(5e-3, 1e-3, True), (4.9e-3, 1e-3, False), (math.inf, 1e-3, False)]
)
def test_a_reference_judges_what_is_five_times_its_error(error: float, resolved: float, judged: bool) -> None:
    """No answer is not judged either."""
    assert Rung("a", 1e-2, 1.0, error, 1e-3, resolved).judged is judged


@pytest.mark.parametrize(
    ("error", "estimated", "resolved", "honest"),
    [(1e-3, 4e-3, 0.0, True), (1e-3, 6e-3, 0.0, False), (1e-3, 1.9e-4, 0.0, False), (1e-3, 2.1e-4, 0.0, True),
     (1e-3, 2e-5, 1e-3, True), (0.0, 4e-3, 1e-3, True), (0.0, 6e-3, 1e-3, False)],
)
def test_an_estimate_holds_within_a_factor_of_five(
    error: float, estimated: float, resolved: float, honest: bool
) -> None:
    """Too small and too large both fail; what the reference cannot tell is not held against it."""
    assert Rung("a", 1.0, 1.0, error, estimated, resolved).honest is honest


def test_tolerances_with_one_answer_are_one_point() -> None:
    """At the least of their times; another answer is another point."""
    first, last = Rung("a", 1e-1, 0.4, 5e-3, 8e-3), Rung("a", 1e-3, 2.0, 1e-4, 5e-4)
    found = distinct([first, replace(first, tolerance=3e-2, seconds=0.3), last])
    assert [(one.tolerance, one.seconds) for one in found] == [(1e-1, 0.3), (1e-3, 2.0)]


def test_only_judged_points_are_counted() -> None:
    """The hollow one has an estimate that nobody can hold against it; both were solved, and have their seconds."""
    first = Rung("a", 1e-2, 0.3, 5e-3, 8e-3, 1e-4)
    rungs = [first, replace(first, tolerance=3e-3), Rung("a", 1e-3, 1.1, 1e-4, 9e-4, 1e-4)]
    words = "ask 1e-2: 0.3 s; 1e-3: 1.1 s; errors below 1e-3 were not requested. "
    assert verdict(rungs) == words + "Estimates within a factor of 5: 1 of 1 judged points, of 2."


@pytest.mark.slow
def test_tables_and_pictures(tmp_path: Path) -> None:
    """One row a rung with its question; an error of zero and a missing answer can be drawn; the machine is named."""
    panels = {
        "one": [Rung("a", 1e-2, 0.1, 0.0, 1e-3), Rung("a", 1e-3, 0.2, math.inf, math.inf)],
        "two": [Rung("b", 1e-2, 0.1, 1e-2, 1e-2)],
        "three": [Rung("b", 1e-2, 0.1, 1e-2, 1e-2, 1e-2)],
    }
    save_figure(ladder_figure(panels), tmp_path / "ladders.png")
    assert (tmp_path / "ladders.png").stat().st_size > 10_000
    rows = rung_rows(panels)
    assert [row["question"] for row in rows] == ["one", "one", "two", "three"]
    assert [row["judged"] for row in rows] == ["yes", "no", "yes", "no"]
    assert "cores" in machine() and "BLAS thread" in machine()


@pytest.mark.parametrize(("estimates", "words"), [
    ((5e-3,), "curve 0 1 s"), ((2e-2,), "curve 0 not reached (2 %)"), ((5e-3, 2e-2), "curve 1 not reached (2 %)"),
    ((5e-3, 2e-2, 9e-3), "1 to 3 s (2 of 3 reach it)"), ((2e-2, 2e-2, math.inf), "none (0 of 3 reach it)"),
])
def test_a_title_counts_the_seconds_of_answers_within_their_tolerance(estimates: tuple[float, ...], words: str) -> None:
    """As the sentence of a study does: an estimate above what was asked is no answer to it."""
    rungs = [Rung(f"curve {k}", 1e-2, 1.0 + k, 1e-3, own) for k, own in enumerate(estimates)]
    assert ladder_figure({"any": rungs}).axes[0].get_title().endswith(words)


@pytest.mark.parametrize("curves", [1, 2, 6])
def test_names_of_curves_lie_over_nothing(curves: int, collisions: Callable[[Any], list[str]]) -> None:
    """One or two stand at their ends, more beside the axes; the title says what each takes that is asked to 1 %."""
    rungs = [
        Rung(f"a calibration of {k} loads", asked, (0.3 + k) / asked**0.3, 0.3 * asked, asked, 0.03 * asked)
        for k in range(curves) for asked in (1e-1, 1e-2, 1e-3)
    ]
    figure = ladder_figure({"biorob2018-w15": rungs})
    assert collisions(figure) == [] and "asked to 1 %: " in figure.axes[0].get_title()
