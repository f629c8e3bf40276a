"""What is an `ok` that a finer answer does not confirm? It is counted as wrong, and no other is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from benchmarks.statuses import LATE, compared, scene, summary

Row = dict[str, Any]


def answer(change: float, status: str = "ok", error: float = 0.002) -> Row:
    """An answer of one signal beside one that changes by 1."""
    return {
        "status": status, "error": error, "stretch": 1.5, "changes": np.array([-1.0, change]),
        "told": {"d_v": (np.array(change), np.array(error))},
    }


@pytest.mark.parametrize(
    ("finer", "wrong"),
    [(answer(0.011), False), (answer(-0.013), True), (answer(0.013, "above tolerance", 0.004), False),
     (answer(0.0, "beyond data"), True), ({"status": "not carried"}, True), ({"status": "failed"}, True),
     ({"status": LATE}, False)],
)
def test_an_ok_is_wrong_beyond_the_tolerance_and_the_finer_error(finer: Row, wrong: bool) -> None:
    """By the share of the full scale; a finer answer that does not exist says so as well, one that is late nothing."""
    assert compared(answer(0.0), finer)["wrong"] == wrong


def test_figures_are_told_over_both_errors() -> None:
    """And what is the same without an error is no difference."""
    assert compared(answer(0.0), answer(0.01))["d_v over bars"] == pytest.approx(2.5)
    assert compared(answer(0.5, error=0.0), answer(0.5, error=0.0))["d_v over bars"] == 0.0


def test_the_summary_names_the_wrong() -> None:
    """Beside how many there are of each status."""
    rows = [{"scene": 0, "status": "failed"}, {"scene": 1, "status": "ok", "finer": LATE},
            {"scene": 2, "status": "ok", "finer": "beyond data", "wrong": True}]
    said = summary(rows)
    assert said.startswith("3 scenes: 2 ok") and "1 failed" in said
    assert said.endswith("1 ok not judged in time, 1 wrong (scenes 2)")


def test_scenes_are_drawn_alike_under_loads() -> None:
    """By their number alone, whatever kind they are of."""
    assert [scene(number)[1:] for number in range(6)] == [scene(number)[1:] for number in range(6)]
    assert len({scene(2 * number)[0] for number in range(10)}) > 1


def test_slender_pads_are_loaded_as_well() -> None:
    """Scene 18 is a disc narrower than its pad is thick: no strip stands for it, and its strain bound is infinite."""
    assert abs(scene(18)[2].F_z) > 0.0
