"""Families of meshes: limits of known sequences, states carried along a family, the order that a pad shows."""

from functools import cache

import numpy as np
import pytest

from sits_mech.extrapolation import shown_order
from sits_mech.mechanics.block import pad_family
from sits_mech.mechanics.element.kernel import deformation
from sits_mech.mechanics.element.target import bonded_displacement
from sits_mech.mechanics.levels.family import Levels, _from_rest, extrapolated, prolonged
from sits_mech.mechanics.linear import linear_pad
from sits_mech.mechanics.pad.ladder import layer_family
from sits_mech.mechanics.rest.body import State, rest
from sits_mech.mechanics.rest.newton import newton
from sits_mech.mechanics.rest.path import follow
from sits_mech.scene.sensor import Elastomer, Target, load_sensor

MM = 1e-3
NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'
SIZES = (1.0, 2.0, 3.0, 4.0, 6.0)
LIMIT = np.array([2.0, -1.0, 0.5])
FIRST, SECOND = np.array([0.3, 0.1, -0.2]), np.array([0.05, -0.04, 0.03])


def sequence(p, count, second=0.0):
    """Values with errors of order p and 2 p."""
    return [LIMIT + FIRST * m**-p + second * SECOND * m ** (-2 * p) for m in SIZES[:count]]


@pytest.mark.parametrize("p", [1.2, 2.0, 2.378, 4.0])
@pytest.mark.parametrize("count", [2, 3, 5])
def test_one_power_is_extrapolated_exactly(p, count):
    """What is left is what the order may be off by: a part of what extrapolation adds, all of it of two levels."""
    found = extrapolated(sequence(p, count), SIZES, p)
    np.testing.assert_allclose(found.value, LIMIT, rtol=1e-13)
    added = np.abs(FIRST) * SIZES[count - 1] ** -p
    low, high = (1.0, 1.0) if count == 2 else (0.05, 0.2)
    assert np.all(found.error > (low - 1e-9) * added) and np.all(found.error < (high + 1e-9) * added)
    assert np.isnan(found.order) if count == 2 else found.order == pytest.approx(p, abs=2e-3)
    assert found.words(p) == ()


@pytest.mark.parametrize("p", [1.2, 2.0, 2.378])
@pytest.mark.parametrize("count", [2, 3, 4, 5])
@pytest.mark.parametrize("second", [-2.0, -0.5, 0.5, 2.0])
def test_the_error_covers_what_a_second_power_leaves(p, count, second):
    values = sequence(p, count, second)
    found = extrapolated(values, SIZES, p)
    true = np.max(np.abs(found.value - LIMIT))
    assert true < np.max(found.error)
    assert count == 2 or np.max(found.error) < np.max(np.abs(values[-1] - LIMIT))  # better than not to extrapolate


@pytest.mark.parametrize("count", [2, 3, 5])
def test_the_parts_of_the_error_have_signs_and_make_it_up(count):
    """A sequence from the other side has the opposite parts; what the last level may be off by is no such part."""
    values = sequence(2.0, count, 0.5)
    found, other = (extrapolated([sign * value for value in values], SIZES, 2.0) for sign in (1.0, -1.0))
    np.testing.assert_allclose(np.abs(found.parts).sum(axis=0), found.error, rtol=1e-12)
    np.testing.assert_allclose(other.parts, -found.parts)
    assert np.all(found.parts[0 if count == 2 else 1] * FIRST < 0.0)  # what extrapolation adds takes errors away
    if count > 2:
        assert np.all(extrapolated(values, SIZES, 2.0, 0.1).error > found.error)


def test_a_sequence_that_is_not_there_yet_says_so_and_widens_its_error():
    """Differences that do not shrink: a lower order than expected; the error is all of the two differences."""
    values = [np.array([value]) for value in (1.0, 0.9, 0.82)]
    found = extrapolated(values, SIZES, 2.0)
    assert found.order < 1.0
    (words,) = found.words(2.0)
    assert "too coarse for their order" in words and "2 expected" in words
    assert found.error[0] > abs(values[-1] - values[-2])[0]
    assert found.error[0] > 3.0 * extrapolated(sequence(2.0, 3), SIZES, 2.0).error[0]


@pytest.mark.parametrize("p", [1.2, 2.0, 2.378])
def test_in_contact_one_power_is_owned_to_more_than_once(p):
    """What is added of one power is a m^-p at every level: the largest, carried to the last, is that of the last."""
    for count in (2, 3, 5):
        found = extrapolated(sequence(p, count), SIZES, p, pressed=True)
        np.testing.assert_allclose(found.value, LIMIT, rtol=1e-13)
        np.testing.assert_allclose(found.error, 2.2 * np.abs(FIRST) * SIZES[count - 1] ** -p, rtol=1e-9)
        assert np.isnan(found.order) and found.words(p) == ()


@pytest.mark.parametrize("count", [3, 4, 5])
def test_in_contact_levels_that_agree_by_chance_do_not_narrow_the_error(count):
    """An amplitude of either sign from level to level, those of the last two levels so that the two agree."""
    m = np.array(SIZES[:count])
    amplitude = 0.3 * np.array([1.0, -1.0] * 3)[:count]
    amplitude[-1] = amplitude[-2] * (m[-2] / m[-1]) ** -2.0
    values = [np.array([1.0 + a * size**-2.0]) for a, size in zip(amplitude, m, strict=True)]
    blind, found = (extrapolated(values[-2:], tuple(m[-2:]), 2.0), extrapolated(values, SIZES, 2.0, pressed=True))
    assert blind.error[0] < 1e-12 < abs(found.value[0] - 1.0) < found.error[0]


def test_two_meshes_of_one_fineness_are_told_by_their_difference():
    found = extrapolated([np.array([1.0]), np.array([1.1])], (1.0, 2.0), np.inf)
    assert found.value[0] == 1.1 and found.error[0] == pytest.approx(0.1) and found.words(np.inf) == ()


def test_what_the_last_value_may_be_off_by_is_in_the_error():
    """With the factor of extrapolation, 1 + 1/((3/2)^2 - 1)."""
    plain, off = (extrapolated(sequence(2.0, 3), SIZES, 2.0, part) for part in (0.0, 0.01))
    np.testing.assert_allclose(off.error - plain.error, 0.01 * (1.0 + 1.0 / (1.5**2 - 1.0)), rtol=1e-9)


@pytest.mark.parametrize("sizes", [(1.0, 2.0, 3.0), (2.0, 3.0, 4.0), (4.0, 6.0, 8.0), (3.0, 4.0, 6.0)])
@pytest.mark.parametrize("p", [0.5, 1.0, 2.0, 4.0])
def test_order_of_three_levels(sizes, p):
    a, b, c = (m**-p for m in sizes)
    assert shown_order((a - b) / (b - c), sizes) == pytest.approx(p, abs=2e-3)


def scene(size=15.0, *, disc=False):
    """A pad of 20 x 20 x 2 mm under a square target, or a cylinder under a disc; the force acts at the bonded face."""
    base = load_sensor(
        "biorob2018", ["target.load_height=0", *(f'target.{side}="{size} mm"' for side in ("width", "length")),
                       NEO_HOOKEAN])  # fmt: skip
    if not disc:
        return base
    plate = {"shape": "disc", "material": "copper", "diameter": size * MM, "thickness": 0.2 * MM, "load_height": 0.0}
    layer = {"material": base.elastomer.material, "diameter": size * MM, "thickness": 2 * MM}
    parts = {"target": Target.model_validate(plate), "elastomer": Elastomer.model_validate(layer)}
    return base.model_copy(update=parts)


@cache
def family(name):
    """The first family of a pad."""
    return pad_family(scene(8.0) if name == "box" else scene(disc=True))[0]


def quadratic(nodes):
    """A quadratic displacement of every component."""
    powers = np.column_stack([np.ones(len(nodes)), nodes, *(nodes[:, [i]] * nodes[:, i:] for i in range(3))])
    return (powers @ np.random.default_rng(3).normal(size=(powers.shape[1], 3))).ravel()


@pytest.mark.parametrize("level", [1, 2, 3])
def test_quadratic_displacements_are_carried_exactly(level):
    """From 1 to 2, 2 to 3 and 3 to 4 parts of a base cell: meshes that need not nest."""
    levels = family("box")
    before, after = (levels.maker(each).mesh.nodes for each in (level - 1, level))
    found = levels.carrier(level).displacements(quadratic(before))
    np.testing.assert_allclose(found, quadratic(after), atol=1e-10 * np.abs(quadratic(after)).max())


@pytest.mark.parametrize("level", [1, 2, 3])
def test_places_on_round_meshes_are_carried(level):
    """Lines of a finer mesh bulge by what its finer arcs gain: fourth order in the angle of a cell, pi/4 at first."""
    levels = family("disc")
    before, after = (levels.maker(each).mesh.nodes for each in (level - 1, level))
    away = levels.carrier(level).displacements(before.ravel()).reshape(-1, 3) - after
    assert np.abs(away).max() < 0.02 * np.abs(after).max() / level**4


@pytest.mark.parametrize("name", ["box", "disc"])
def test_constant_pressures_are_carried_exactly(name):
    """Also to cells whose middle lies between two parents."""
    levels = family(name)
    coarse, fine = (levels.maker(each).mesh for each in (1, 2))
    first = np.zeros(coarse.chi.shape[:2])
    first[:, 0] = np.sqrt(coarse.inside.weights.sum(axis=1))
    found = levels.carrier(2).pressures(first)
    np.testing.assert_allclose(found[:, 0], np.sqrt(fine.inside.weights.sum(axis=1)), rtol=1e-9)
    np.testing.assert_allclose(found[:, 1:], 0.0, atol=1e-9)


def test_a_state_goes_on_from_level_to_level():
    """Its target stays, and Newton's method is near: the state of a load comes to rest in a few iterations."""
    levels, load = family("box"), np.array([0.5, 3.0, 0.1])
    state = newton(levels.coarse, rest(levels.coarse), load).state
    start = prolonged(levels, 1, state)
    fine = levels.fine
    np.testing.assert_array_equal(start.q, state.q)
    np.testing.assert_allclose(start.u[fine.bonded], bonded_displacement(fine.X, state.q), atol=1e-12)
    found = newton(fine, start, load).state
    assert found.residual < 1e-9 and found.iterations <= 5


def test_cells_that_would_turn_inside_out_are_drawn_towards_a_safe_state():
    """A node in the middle of a cell pushed through its side; without a way there is no state."""
    levels = family("box")
    state = rest(levels.coarse)
    u = state.u.copy().reshape(-1, 3)
    inner = np.flatnonzero(np.abs(levels.coarse.mesh.nodes[:, 2] - 0.5) < 0.3)[0]
    u[inner, 2] += 1.5
    start = prolonged(levels, 1, State(u.ravel(), state.q, state.p, state.load))
    assert start is not None and start.min_J > 0.15
    assert deformation(levels.fine.mesh, start.u)[1].min() == pytest.approx(start.min_J)
    alone = Levels(levels.sizes, levels.cells, levels.maker, lambda level: None, levels.order, levels.share)
    assert prolonged(alone, 1, state) is None


# d_h, sink, alpha of a pad of 20 x 20 x 2 mm under 15 x 15 mm, K/mu = 1000: NGSolve 6.2 and FElupe 11.3, to 0.1 %.
BOX = np.array([[4.482e3, 0.0, 6.915], [0.0, 120.67e3, 0.0], [6.915, 0.0, 1.0695]])


@pytest.mark.slow
def test_a_pad_shows_its_order_and_its_error_covers_the_truth():
    """Compliances go with m^-2 where displacements go as r^0.5 and lines are graded with 2."""
    pad = linear_pad(scene(), 5e-4)
    assert pad.levels.order == 2.0 and len(pad.compliances) >= 4
    each = np.array([np.diag(C) for C in pad.compliances])
    gone = np.linalg.norm(np.diff(each / each[-1], axis=0), axis=1)
    assert shown_order(gone[-2] / gone[-1], np.array(pad.levels.sizes[len(each) - 3 : len(each)])) == pytest.approx(
        2.0, abs=0.35
    )  # fmt: skip
    unit = np.diag(np.outer(pad.scales.loads[:3], 1.0 / pad.scales.lengths[:3]))
    known = unit * np.diag(np.linalg.inv(BOX))
    for count in range(2, len(each) + 1):
        found = extrapolated(list(each[:count]), pad.levels.sizes, 2.0)
        off = np.abs(found.value / known - 1.0)
        trust = 2.0 if count == 2 else 1.0  # two levels cannot see their order
        assert np.max(off) < trust * np.max(found.error / found.value) + 1.5e-3


def test_a_level_that_no_state_is_carried_to_is_brought_to_rest_by_halved_increments():
    """As along a path that ends at the same load; a load that is not carried gives nothing."""
    sensor = load_sensor("biorob2018", ['target.width="4 mm"', NEO_HOOKEAN])
    body = layer_family(sensor).maker(0)
    held, goal = np.zeros(3, dtype=bool), np.array([2.0, 3.0, 0.0])
    there, path = _from_rest(body, held, goal), follow(body, rest(body), (0.0 * goal, goal))
    assert there is not None and there.state is not None and path.reached == 1.0
    np.testing.assert_allclose(there.q, path.state.q, rtol=1e-7, atol=1e-10)
    assert _from_rest(body, held, 50.0 * goal) is None


def test_what_three_levels_tell_counts_so_many_times():
    """Error and its signed parts alike, the limit itself stays; only pads of cells in space doubt three levels."""
    limit = extrapolated([np.array([1.0, 2.0]), np.array([1.2, 2.1]), np.array([1.25, 2.12])], (1.0, 2.0, 3.0), 2.0)
    wider = limit.times(4.0)
    np.testing.assert_array_equal(wider.value, limit.value)
    np.testing.assert_allclose(wider.error, 4.0 * limit.error)
    np.testing.assert_allclose(wider.parts, 4.0 * limit.parts)
    sensor = load_sensor("biorob2018")
    assert pad_family(sensor)[0].early > 1.0 == layer_family(sensor).early
