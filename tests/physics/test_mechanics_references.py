"""Poses beside those of an independent code: the error that an answer says it has is one that it has."""

import pytest
from benchmarks.mechanics_accuracy import judged
from common.references import STORED, stored_references

REFERENCES = {one.name: one for one in stored_references(STORED)}
QUICK = (
    "flush disc 15 x 2, small shear", "layer, sheared 10 %", "square section, pulled", "layer, gent",
)
LATER = ("disc 6 on 12 x 6, sheared little", "disc 10 on 20 x 2, small press", "disc 8 on 12 x 3, ogden, pulled")
CASES = [pytest.param(name, marks=[pytest.mark.slow] * (name in LATER)) for name in QUICK + LATER if name in REFERENCES]


@pytest.mark.parametrize("name", CASES)
def test_the_true_error_is_at_most_three_times_the_estimated_one(name):
    """NGSolve 6.2, Q5 on graded meshes (studies/benchmarks/reference_pads.py), each with an error of its own."""
    one = judged(REFERENCES[name], 1e-2)
    assert one.status == "converged" and one.reference.error < 2e-3
    assert one.true - one.reference.error <= 3.0 * one.estimated
    assert one.estimated < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(REFERENCES))
def test_no_pad_is_three_times_worse_than_it_says(name):
    """Every pad to 1 %; one that has no answer says so, which is no wrong answer."""
    assert not judged(REFERENCES[name], 1e-2).too_small


@pytest.mark.parametrize("name", ["disc 8 on 12 x 3, gent", "disc 8 on 20 x 2, ecoflex"])
def test_what_a_strong_press_leaves_at_edges_is_in_the_error(name):
    """Discs that sink by 0.09 and 0.13 thicknesses, whose edges converge more slowly than at small strain."""
    one = judged(REFERENCES[name], 1e-2)
    assert one.reference.error < 0.1 * one.true
    assert 0.3 * one.estimated < one.true <= one.estimated


@pytest.mark.parametrize("name", [name for name in REFERENCES if "N of shear" in name])
@pytest.mark.parametrize("asked", [1e-2, 3e-3])
def test_corners_that_fold_are_in_the_error(name, asked):
    """Flush squares, sheared 44 and 35 %, of which two levels have J of 0.6."""
    one = judged(REFERENCES[name], asked)
    assert one.true <= one.estimated <= 1e-2
