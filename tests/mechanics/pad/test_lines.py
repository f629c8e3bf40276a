"""Lines of a pad's mesh: families that keep their grading, thin pads with few cells, edges met."""

from itertools import pairwise

import numpy as np
import pytest

from sits_mech.geometry.meshing.bricks import PlateOutline
from sits_mech.mechanics.pad.shapes import (
    box_lines,
    flush,
    graded,
    lines_through,
    outlines,
    outside_lines,
    ring_lines,
    under_lines,
)
from sits_mech.scene.sensor import load_sensor


def half(size):
    """A square plate, half its size [thicknesses]."""
    return PlateOutline(size, size, False)


@pytest.mark.parametrize("edge", [0.5, 2.0, 3.75, 8.0, 50.0, 500.0])
@pytest.mark.parametrize("split", [1, 2, 3, 4, 6])
def test_lines_rise_from_the_middle_to_the_edge(edge, split):
    lines = under_lines(edge, split, 2.0)
    assert lines[0] == 0.0 and lines[-1] == pytest.approx(edge) and np.all(np.diff(lines) > 0.0)
    assert (len(lines) - 1) % split == 0


@pytest.mark.parametrize("edge", [2.0, 3.75, 8.0, 50.0])
def test_the_spacing_towards_the_edge_keeps_its_power_in_every_member(edge):
    """The i-th line from the edge lies (i/m)^2 times as far as the first base line."""
    base = edge - under_lines(edge, 1, 2.0)[::-1]
    for split in (2, 3, 4, 6):
        away = edge - under_lines(edge, split, 2.0)[::-1]
        np.testing.assert_allclose(away[: split + 1], base[1] * (np.arange(split + 1) / split) ** 2, rtol=1e-9)
        np.testing.assert_allclose(away[::split], base, rtol=1e-9, atol=1e-12)  # the base is in every member


@pytest.mark.parametrize("thinner", [10.0, 100.0, 1000.0])
def test_thin_pads_take_cells_with_the_logarithm_of_their_width(thinner):
    """20 x 20 mm of 2 mm, 0.2, 0.02 and 0.002 mm: cells in the middle grow by three each, on both sides."""
    x, y, z = box_lines(half(3.75 * thinner), half(5.0 * thinner), 1, 2.0)
    first = len(box_lines(half(3.75), half(5.0), 1, 2.0)[0])
    assert len(x) - first <= 2 * np.ceil(np.log(thinner) / np.log(3.0)) + 2
    assert len(z) == 2 and len(y) == (len(x) + 1) // 2
    widths = np.diff(under_lines(3.75 * thinner, 1, 2.0))
    assert np.all(widths[:-1] <= 4.5 * widths[1:] + 1e-9)  # no jumps


def test_a_square_pad_has_the_same_lines_along_x_and_y():
    x, y, _ = box_lines(half(3.75), half(5.0), 3, 2.0)
    np.testing.assert_array_equal(x[len(x) // 2 :], y)
    np.testing.assert_array_equal(x, -x[::-1])


def test_a_flush_pad_has_no_lines_beside_and_both_faces_graded():
    assert flush(half(4.0), half(4.0)) and not flush(half(4.0), half(4.1))
    np.testing.assert_array_equal(outside_lines(0.0, 3, 2.0), [0.0])
    z = lines_through(3, 2.0, True)
    np.testing.assert_allclose(z + z[::-1], 1.0)
    upper = lines_through(3, 2.0, False)
    np.testing.assert_allclose(1.0 - upper[::-1], (np.arange(4) / 3) ** 2)


@pytest.mark.parametrize("gap", [0.1, 1.25, 1.875, 3.0, 100.0])
def test_lines_beside_end_at_the_side(gap):
    for split in (1, 2, 3):
        lines = outside_lines(gap, split, 2.0)
        assert lines[0] == 0.0 and lines[-1] == pytest.approx(gap) and np.all(np.diff(lines) > 0.0)
        assert len(lines) <= 2 * split + 1


def test_layers_cut_the_cells_at_edges_and_meshes_nest():
    """Parts 1, 2, 2 with a layer, 4: each has all lines of the one before; layers stand at the edge alone."""
    each = [box_lines(half(3.75), half(5.0), *way) for way in ((1, 2.0, 0), (2, 2.0, 0), (2, 2.0, 1), (4, 2.0, 0))]
    for coarse, fine in pairwise(each):
        for own, more in zip(coarse, fine, strict=True):
            assert np.all(np.abs(own[:, None] - more).min(axis=1) < 1e-12)
    np.testing.assert_allclose(graded(2, 2.0, 2), [0.0, 1 / 64, 1 / 16, 1 / 4, 1.0])
    assert [len(axes[2]) for axes in each] == [2, 3, 4, 5]


def test_a_near_side_is_graded_at_its_foot():
    """Within a thickness of the target the corner of side and ground is as loaded as the target's edge."""
    near, far = (box_lines(half(2.0), half(2.0 + gap), 2, 2.0) for gap in (0.9, 1.1))
    assert len(near[2]) > len(far[2])
    beside = near[0][near[0] > 2.0 - 1e-9] - 2.0
    np.testing.assert_allclose(beside + beside[::-1], 0.9)


def test_rings_run_from_the_core_to_both_outlines():
    disc, pad = PlateOutline(3.75, 3.75, True), PlateOutline(5.0, 5.0, True)
    inside, beside = ring_lines(disc, pad, 2, 2.0)
    assert (inside[0], inside[-1], beside[0], beside[-1]) == pytest.approx((0.0, 1.0, 0.0, 1.0))
    assert len(ring_lines(disc, disc, 2, 2.0)[1]) == 1


def test_a_disc_that_touches_the_sides_of_its_box_keeps_off_them():
    sensor = load_sensor("triaxial-3")
    plate, pad = outlines(sensor.target, sensor.elastomer)
    assert plate.is_round and pad.half_x >= plate.half_x
