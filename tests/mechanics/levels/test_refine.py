"""Refinement: levels until it is enough, states from the level before, what further levels say of the target."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from sits_mech.mechanics.element.kernel import deformation, element_forces
from sits_mech.mechanics.element.target import bonded_displacement
from sits_mech.mechanics.equilibrium.body import rest
from sits_mech.mechanics.equilibrium.newton import newton
from sits_mech.mechanics.equilibrium.outcome import Path
from sits_mech.mechanics.equilibrium.path import advance
from sits_mech.mechanics.levels.refine import later_rests, prolonged, refinements
from sits_mech.mechanics.pad.families import pad_family
from sits_mech.scene.sensor import load_sensor

NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'


@pytest.fixture(scope="module")
def levels():
    """The first family of a pad of 20 x 20 x 2 mm under 8 x 8 mm; the force acts at the bonded face."""
    return pad_family(load_sensor("biorob2018", ["target.load_height=0", NEO_HOOKEAN]))[0]


@pytest.mark.parametrize(("most", "held", "there", "found"), [(4, 9, 9, 4), (6, 3, 9, 3), (6, 9, 2, 2), (2, 9, 9, 2)])
def test_levels_are_measured_one_after_the_other(most, held, there, found):
    """Two at first; no more than asked for, than memory holds, or than there are; each is measured when it is taken."""
    family, values = SimpleNamespace(check_memory=lambda level: level >= held), iter(range(there))
    assert [list(each) for each in refinements(family, values, most)] == [list(range(k)) for k in range(2, found + 1)]
    assert next(values, None) == (None if found == there else found)


def test_the_third_level_of_a_pull_is_reached_from_the_second():
    """By 4 N, to 1.4 times the thickness: cells at rims were squeezed to J = 0.006 on their way, and left there."""
    levels, load = pad_family(load_sensor("biorob2018"))[0], np.zeros(3)
    load[1] = -4.0 / (2.0 * 14943.0 * 2e-3**2)  # of half a pad, over the shear modulus and the thickness squared
    state = advance(levels.fine, rest(levels.fine), Path((0.0 * load, load))).state
    start = prolonged(levels, 2, state)
    assert state.q[1] == pytest.approx(0.385, abs=0.01) and start is not None and start.min_J > 0.4
    begun, aim = (rest(levels.coarse), state), (np.zeros(3, dtype=bool), load)
    (there,) = later_rests(replace(levels, rested=3), begun, aim, False)
    assert levels.fine.length(there.off) < 0.05 * state.q[1] and 0.001 < there.state.q[1] - state.q[1] < 0.01


@pytest.mark.slow
def test_a_state_goes_on_where_the_cells_at_edges_stay_as_they_are(levels):
    """Its target stays, and Newton's method is near: a few iterations."""
    load = np.array([0.5, 3.0, 0.1])
    state = advance(levels.maker(2), rest(levels.maker(2)), Path((0.0 * load, load))).state
    start = prolonged(levels, 3, state)
    fine = levels.maker(3)
    np.testing.assert_array_equal(start.q, state.q)
    np.testing.assert_allclose(start.u[fine.bonded], bonded_displacement(fine.X, state.q), atol=1e-12)
    assert deformation(fine.mesh, start.u)[1].min() == pytest.approx(start.min_J)
    found = newton(fine, start, load).state
    assert found.residual < 1e-9 and found.iterations <= 6


def test_a_state_goes_on_where_the_cells_at_edges_are_cut(levels):
    """All but their parts keep its displacements and pressures; these are at rest between them."""
    load = np.array([0.5, 3.0, 0.1])
    state = advance(levels.fine, rest(levels.fine), Path((0.0 * load, load))).state
    start, third, way = prolonged(levels, 2, state), levels.maker(2), levels.carrier(2)
    patch = third.patch
    np.testing.assert_array_equal(start.q, state.q)
    others = np.setdiff1d(np.arange(len(start.u)), [*patch.inner, *third.bonded.ravel()])
    np.testing.assert_array_equal(start.u[others], way.displacements(state.u)[others])
    np.testing.assert_array_equal(start.p[~patch.cells], way.pressures(state.p)[~patch.cells])
    assert deformation(third.mesh, start.u)[1].min() == pytest.approx(start.min_J) and start.min_J > 0.1
    inner = element_forces(third.mesh, third.laws, start.u).forces[patch.inner]
    assert np.linalg.norm(inner) <= 0.01 * np.linalg.norm(load)


@pytest.mark.slow
def test_levels_beyond_the_second_give_the_places_that_rest_gives(levels):
    """Steps end when the target stays, well before the corners do."""
    load, held = np.array([0.5, 3.0, 0.1]), np.zeros(3, dtype=bool)
    states = tuple(advance(levels.maker(k), rest(levels.maker(k)), Path((0.0 * load, load))).state for k in (0, 1))
    there = next(later_rests(levels, states, (held, load), False))
    true = advance(levels.maker(2), rest(levels.maker(2)), Path((0.0 * load, load))).state
    assert np.max(np.abs(there.state.q - true.q)) < 0.1 * np.max(np.abs(true.q - states[1].q))
    assert there.state.iterations <= true.iterations
