"""What is said of a ladder: a line as a rung is solved, and one sentence of all."""

import math

import pytest

from sits_mech.analysis.ladder import LadderPoint, LadderStep
from sits_mech.report.tables.plan import ladder_sentence, power, rung_line


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([[(1e-2, 8e-3, 0.3), (3e-3, 2e-3, 1.1), (1e-3, 1.4e-3, 4.0)]],
         "ask 1e-2: 0.3 s; 3e-3: 1.1 s; errors below 1e-3 cannot be reached"),
        ([[(1e-2, 8e-3, 0.3), (3e-3, 2e-3, 1.1)]],
         "ask 1e-2: 0.3 s; 3e-3: 1.1 s; errors below 3e-3 were not requested"),
        ([[(1e-2, 8e-3, 0.3), (3e-3, 4e-3, 1.1)], [(1e-2, 1e-3, 0.5), (3e-3, 1e-3, 0.6)]],
         "ask 1e-2: 0.3 to 0.5 s; 3e-3: 0.6 s (1 of 2); errors below 4e-3 cannot be reached (1 of 2)"),
        ([[(1e-2, 8e-2, 0.3), (3e-3, 6e-2, 1.1)]], "errors below 6e-2 cannot be reached"),
        ([[(1e-2, math.inf, 0.3)]], "no tolerance of the ladder can be reached"),
    ],
)
def test_the_sentence_counts_what_an_estimate_holds(rows: list[list[tuple[float, float, float]]], said: str) -> None:
    """Seconds of what is as exact as asked by its own word; the least estimate of a ladder whose finest rung misses."""
    assert ladder_sentence([[LadderPoint(*one) for one in row] for row in rows]) == said


@pytest.mark.parametrize(("rung", "left", "said"), [
    (LadderStep(3e-3, 1.23, 4.56e-3), 2, "3e-3: error 0.0046, 1.2 s; 2 to come"),
    (LadderStep(1e-1, 20.4, 0.05), 0, "1e-1: error 0.05, 20 s"),
    (LadderStep(1e-2, 0.5, status="SolveFailed: not carried; the last mesh"), 1,
     "1e-2: SolveFailed: not carried, 0.5 s; 1 to come"),
])
def test_a_rung_is_a_line(rung: LadderStep, left: int, said: str) -> None:
    assert rung_line(rung, left) == said


def test_tolerances_are_written_as_they_are_asked() -> None:
    assert [power(value) for value in (1e-1, 3e-3, 1e-10)] == ["1e-1", "3e-3", "1e-10"]
