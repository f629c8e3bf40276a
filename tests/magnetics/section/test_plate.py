"""Nested divisions of a section: joined cells are cells, and the extrapolation beats the square of the cells."""

import numpy as np
import pytest

from sits_mech.magnetics.section.kernels import mean_log
from sits_mech.magnetics.section.plate import Lengths, Resolution, bars_of, divisions, prepare_plate

SIZE, LENGTHS = (8.0, 0.5), Lengths(1.0, 1.0, 0.1)
RESOLUTION = Resolution(skin=0.5, growth=1.4, along=0.3, near=0.5, terms=10.0)


def test_coarser_divisions_join_cells_two_by_two():
    levels = divisions(SIZE, RESOLUTION, LENGTHS)
    assert [levels[0].x.size / level.x.size for level in levels] == [1, 4, 16]
    for level in levels:
        assert np.sum(level.width * level.height) == pytest.approx(SIZE[0] * SIZE[1] / 4, rel=1e-12)
        np.testing.assert_allclose(level.share.sum(axis=1), 1.0, rtol=1e-12)


def test_joined_inductances_are_those_of_the_joined_bars():
    fine, middle, _ = divisions(SIZE, RESOLUTION, LENGTHS)
    joined = middle.share @ (middle.share @ _logs(fine)).T
    np.testing.assert_allclose(joined, _logs(middle), rtol=0, atol=1e-7)  # the kernel's own error from afar


def _logs(cells):
    dx, dz = cells.x - cells.x[:, None], cells.z - cells.z[:, None]
    return mean_log(dx, dz, (cells.width[:, None], cells.height[:, None]), (cells.width, cells.height))


def test_error_of_one_division_goes_with_the_square_of_its_cells():
    """The condensed admittance of three nested divisions: differences in the ratio of 4, at 5 kHz in copper."""
    plate = prepare_plate((8e-3, 0.2e-3), 5.8e7, RESOLUTION, Lengths(2e-3, 2e-3, 0.9e-3))
    fine, middle, coarse = (plate.modes[k][0].admittance(2 * np.pi * 5e3) for k in range(3))
    assert np.abs(coarse - middle).max() / np.abs(middle - fine).max() == pytest.approx(4.0, rel=0.25)


def test_currents_are_those_of_a_division_and_the_next_coarser_one():
    """In all four quadrants, each bar once."""
    plate = prepare_plate((8e-3, 0.2e-3), 5.8e7, RESOLUTION, Lengths(2e-3, 2e-3, 0.9e-3))
    for finest in (0, 1):
        places, rows = plate.currents(2 * np.pi * 5e3, finest)
        counts = [4 * plate.cells[level].x.size for level in (finest, finest + 1)]
        assert places.size == len(rows) == sum(counts)
        assert [len(np.unique(part.round(12))) for part in np.split(places, counts[:1])] == counts


@pytest.mark.parametrize("grain", [1.0, 0.2, 0.17])
def test_bars_are_counted_without_dividing(grain):
    lengths = Lengths(grain, grain, 0.3)
    assert bars_of(SIZE, RESOLUTION, lengths) == 4 * divisions(SIZE, RESOLUTION, lengths)[0].x.size


def test_bars_at_a_picometre_are_counted_at_once():
    assert bars_of((8e-3, 2e-4), RESOLUTION, Lengths(1e-12, 1e-12, 3e-5)) > 10**9
