"""What two ends of a way say together."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.mechanics.equilibrium.outcome import REASONS, Outcome, Path, PathEnd, carried


def test_what_two_meshes_say_of_a_limit():
    """Both found it: they differ by the error. One alone: by how far the other got; not followed to its end: nan."""
    state = object.__new__(type("Nothing", (), {}))
    coarse, fine = (Outcome(state, t, PathEnd.BUCKLED, (t, 1e-3)) for t in (0.50, 0.46))
    assert carried(coarse, fine) == pytest.approx((0.46, 0.042))
    assert carried(coarse, Outcome(state, 0.4, PathEnd.LOST)) == pytest.approx((0.5, 0.101))
    assert carried(Outcome(state, 1.0), fine) == pytest.approx((0.46, 0.541))
    assert np.isnan(carried(coarse, Outcome(state, 0.1, PathEnd.LONG))[1])
    assert carried(Outcome(state, 0.3, PathEnd.LOST), Outcome(state, 0.2, PathEnd.LOST)) is None
    assert replace(coarse, limit_point=(0.5, 0.1)).over(0.5, 1.0).limit_point == pytest.approx((0.75, 0.05))


def test_a_path_goes_straight_from_goal_to_goal():
    """Its legs are counted; the last one has the slope of a path by its length; no place is held by default."""
    corners = np.zeros(3), np.array([0.0, 2.0, 0.0]), np.array([1.0, 2.0, 0.0])
    path = Path(corners)
    assert path.legs == 2 and not path.held.any() and len(path.held) == 3
    for part, end in enumerate((corners[0], 0.5 * corners[1], corners[1], [0.5, 2.0, 0.0], corners[2])):
        np.testing.assert_array_equal(path.at(0.5 * part), end)
    np.testing.assert_array_equal(path.slope, [1.0, 0.0, 0.0])


def test_every_end_has_its_words():
    assert set(REASONS) == set(PathEnd) - {PathEnd.NONE}
