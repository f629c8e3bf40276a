"""Graded lines: ends, symmetry, the power law, matched neighbours."""

import numpy as np
import pytest

from sits_mech.mechanics.pad.fillet import graded_lines, graded_segment, matched_cells


def test_segment_follows_its_power_law():
    lines = graded_segment(1.0, 3.0, 8, 2.0)
    np.testing.assert_allclose(lines[:5] - 1.0, (np.arange(5) / 4) ** 2, atol=1e-14)
    np.testing.assert_allclose(lines + lines[::-1], 4.0)


def test_lines_hold_every_break_once():
    lines = graded_lines([-2.0, -1.0, 1.0, 2.0], [4, 6, 4], 1.5)
    assert len(lines) == 15 and np.all(np.diff(lines) > 0.0)
    for point in (-2.0, -1.0, 1.0, 2.0):
        assert np.min(np.abs(lines - point)) < 1e-14


def test_matched_cells_have_the_reference_size_at_the_ends():
    cells = matched_cells(7.5, 8, 2.0)
    long, short = (np.diff(graded_segment(0.0, length, n, 2.0))[0] for length, n in ((7.5, cells), (1.0, 8)))
    assert long <= short < 1.5 * long


@pytest.mark.parametrize("arguments", [(0.0, 1.0, 3, 2.0), (1.0, 0.0, 4, 2.0), (0.0, 1.0, 4, 0.5)])
def test_impossible_segments_are_refused(arguments):
    with pytest.raises(ValueError, match="segment"):
        graded_segment(*arguments)
