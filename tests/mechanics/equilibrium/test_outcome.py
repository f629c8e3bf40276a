"""What two ends of a way say together."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.mechanics.equilibrium.body import State
from sits_mech.mechanics.equilibrium.outcome import REASONS, Outcome, PathEnd, carried


def test_what_two_meshes_say_of_a_limit():
    """Both found it: they differ by the error. One alone: by how far the other got; not followed to its end: nan."""
    state = object.__new__(type("Nothing", (), {}))
    coarse, fine = (Outcome(state, t, PathEnd.BUCKLED, (t, 1e-3)) for t in (0.50, 0.46))
    assert carried(coarse, fine) == pytest.approx((0.46, 0.042))
    assert carried(coarse, Outcome(state, 0.4, PathEnd.LOST)) == pytest.approx((0.5, 0.101))
    assert carried(Outcome(state, 1.0), fine) == pytest.approx((0.46, 0.541))
    assert np.isnan(carried(coarse, Outcome(state, 0.1, PathEnd.LONG))[1])
    assert carried(Outcome(state, 0.3, PathEnd.LOST), Outcome(state, 0.2, PathEnd.LOST)) is None
    assert replace(coarse, limit=(0.5, 0.1)).over(0.5, 1.0).limit == pytest.approx((0.75, 0.05))


def test_iterations_are_those_of_all_increments():
    state = State(np.zeros(0), np.zeros(3), np.zeros(0), np.zeros(3), iterations=4)
    assert Outcome(state).iterations == 4
    assert Outcome(state, states=(replace(state, iterations=0), replace(state, iterations=3), state)).iterations == 7


def test_every_end_has_its_words():
    assert set(REASONS) == set(PathEnd) - {PathEnd.NONE}
