"""Poses beside those of an independent code: the error that an answer says it has is one that it has."""

import numpy as np
import pytest
from benchmarks.mechanics_accuracy import judged
from common.reference_cases import Case
from common.references import STORED, Reference, stored_references

from sits_mech.quantities import Wrench

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


@pytest.mark.parametrize(("wide", "t", "load", "moved"), [
    (8.0, 2.0, (0.768, 0.0), (879.59e-6, -16.51e-6, 0.0290775)),
    (5.0, 1.5, (0.225, 0.141), (525.88e-6, -50.18e-6, 0.03826)),
])
@pytest.mark.parametrize("asked", [1e-2, 3e-3])
def test_corners_that_fold_are_in_the_error(wide, t, load, moved, asked):
    """Flush squares of nu 0.49, sheared 44 and 35 %, of which two levels have J of 0.6.

    NGSolve 6.2, Q4 with pressures of order 2: sections of triangles that meet in the four corners, within one ring of
    bricks of factor 0.3, drawn along y. The ring adds 8e-4 and 1.6e-3, twice as many triangles change 8e-4.
    """
    case = Case("", "box", (wide, wide), (wide, wide), t, (*load, 0.0), bulk=49.67)
    reference = Reference("", "block", tuple(case.changes), Wrench(*load), np.pad(moved, (0, 3)), 1e-3, "")
    one = judged(reference, asked)
    assert one.true <= one.estimated <= 1e-2
