"""The study of true and estimated errors: its rows and its picture."""

import numpy as np
import pytest
from benchmarks.mechanics_accuracy import draw, judged, row_of
from common.references import Judged, Reference

from sits_mech.quantities import Wrench


def solved(true, error=1e-5):
    reference = Reference("pad", "block", (), Wrench(F_x=1.0), np.array([1e-3, 0.0, 0.0, 0.0, 0.0, 0.0]), error, "")
    return Judged(reference, 1e-2, true, 2.0 * true, 0.5, 100, "converged")


def test_points_that_the_reference_judges_are_drawn(tmp_path):
    """A true error five times the reference's own is a point; without one there is no picture."""
    draw([solved(1e-3)], ["pad"], tmp_path / "one.png")
    draw([solved(1e-3, 3e-4), solved(np.nan)], ["pad"], tmp_path / "none.png")
    assert (tmp_path / "one.png").stat().st_size > 10_000 and not (tmp_path / "none.png").exists()
    assert row_of(solved(1e-3))["true/estimated"] == pytest.approx(0.5)


def test_a_pad_without_an_answer_is_a_row(tmp_path):
    """What the model refuses stands in the table by its words, without an error."""
    reference = Reference("pad", "block", ("target.length=0",), Wrench(F_x=1.0), np.ones(6), 0.0, "")
    one = judged(reference, 1e-2)
    assert np.isnan(one.true) and "target.length" in one.status
