"""The second level: by its own path, and from the first level's rest."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.equilibrium.control import Control, under
from sits_mech.mechanics.equilibrium.newton import SETTLED
from sits_mech.mechanics.equilibrium.outcome import PathEnd
from sits_mech.mechanics.levels.pair import (
    beyond_first,
    first_look,
    from_first,
    last_rest,
    own_start,
    refined_answer,
    second_look,
)
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor


@pytest.fixture(scope="module")
def line():
    return block_pad(load_sensor("biorob2018"), 2e-2).half


def test_the_second_level_rests_where_its_own_path_leads(line):
    """From the first level's rest, under a load that its path reaches."""
    control, n = under(Wrench(F_x=0.2, F_z=1.0)), line[0].fine.mesh.nodes.size
    look = first_look(line, 0, None, control)
    found = from_first(line, 0, control, look)
    assert found.part == 1.0 and found.states[1].residual <= SETTLED
    pair = second_look(line, 0, None, control, look, 1e-2)
    np.testing.assert_allclose(found.states[1].q, pair.states[1].q, rtol=1e-3, atol=1e-5)
    solved = refined_answer(line, pair, control)
    assert solved.found.state[0] == 0 and np.array_equal(solved.found.state[1 + n : 4 + n], pair.states[1].q)


def test_a_first_level_that_is_unstable_leaves_the_answer_to_the_next_two(line):
    """Of a load that the first level carries as well, and is said to carry half of: the answer is the same."""
    line, control = replace(line, deepest=2), under(Wrench(F_z=-0.5))
    look, half = (first_look(line, 0, None, control, share) for share in (1.0, 0.5))
    stopped = replace(half, reached=0.5, reason=PathEnd.BUCKLED, limit_point=(0.5, 1e-3))
    pair = second_look(line, 0, None, control, stopped, 1e-2)
    assert (pair.part, pair.reason, pair.second.reached) == (0.5, PathEnd.BUCKLED, 1.0)
    there = beyond_first(line, control, pair)
    assert there.part == 1.0 and there.number == len(line.makers) and not line.in_contact(there.number)
    finer, usual = (
        refined_answer(line, each, control).found for each in (there, second_look(line, 0, None, control, look, 1e-2))
    )
    assert finer.state[0] == there.number and own_start(line, there.number, finer) is finer
    assert finer.error.d_v < 0.05 * abs(finer.pose.d_v - 2e-3)
    assert abs(finer.pose.d_v - usual.pose.d_v) < finer.error.d_v + usual.error.d_v
    assert beyond_first(line, control, there) is None  # no third of its own


def test_a_share_of_a_path_is_that_of_its_load(line):
    control = under(Wrench(F_z=2.0))
    half, whole = (first_look(line, 0, None, control, share) for share in (0.5, 1.0))
    assert half.state.load[1] == pytest.approx(0.5 * whole.state.load[1]) and half.reached == 1.0


def test_a_last_rest_has_an_error_as_large_as_its_displacement(line):
    look = first_look(line, 0, None, Control(sink=1e-4))
    found = last_rest(line, 0, replace(look.state, iterations=3))
    assert found.error.d_v == pytest.approx(1e-4) and found.report.iterations == 3 and found.report.stretch > 1.0
    assert own_start(line, 0, found) is None
