"""Families of meshes: limits of known sequences, states carried along a family, the order that a pad shows."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from sits_mech.mechanics.equilibrium.body import rest
from sits_mech.mechanics.levels.family import extrapolated
from sits_mech.mechanics.linear import linear_pad
from sits_mech.mechanics.pad.families import pad_family
from sits_mech.scene.sensor import Elastomer, Target, load_sensor

MM = 1e-3
NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'
SIZES = np.array([1.0, 2.0, 3.0, 4.0, 6.0])
LIMIT = np.array([2.0, -1.0, 0.5])
FIRST, SECOND = np.array([0.3, 0.1, -0.2]), np.array([0.05, -0.04, 0.03])


def terms(p, count=5):
    """Of even division: the powers p and 2 p of the cells' sizes."""
    return SIZES[:count, None] ** -np.array([p, 2.0 * p])


def sequence(p, count, second=0.0):
    """Values with errors of order p and 2 p."""
    return list(LIMIT + terms(p, count) @ np.stack([FIRST, second * SECOND]))


@pytest.mark.parametrize("p", [1.2, 2.0, 2.378, 4.0])
@pytest.mark.parametrize("count", [2, 3, 5])
def test_one_power_is_extrapolated_exactly(p, count):
    """What is left is what the power may be off by: twice what is added of two levels, half of it of more."""
    found = extrapolated(sequence(p, count), terms(p, count))
    np.testing.assert_allclose(found.value, LIMIT, rtol=1e-12)
    if count == 2:
        np.testing.assert_allclose(found.error, 2.0 * np.abs(FIRST) * SIZES[1] ** -p, rtol=1e-9)
    else:
        np.testing.assert_allclose(found.error, 0.5 * np.abs(FIRST) * SIZES[count - 1] ** -p, rtol=1e-8)


@pytest.mark.parametrize("second", [-2.0, -0.5, 0.5, 2.0])
@pytest.mark.parametrize("p", [1.2, 2.0, 2.378])
def test_two_powers_take_three_levels_and_two_cover_what_the_second_leaves(p, second):
    values = sequence(p, 5, second)
    assert np.all(np.abs(extrapolated(values[:2], terms(p, 2)).value - LIMIT) < 2.0 * np.abs(values[1] - LIMIT))
    for count in (3, 4, 5):
        np.testing.assert_allclose(extrapolated(values[:count], terms(p, count)).value, LIMIT, rtol=1e-11)


def test_edges_and_what_is_away_from_them_are_told_apart():
    """Layers at the edges alone leave the other term as it was; three levels give both, four say how sure."""
    split, layers = np.array([1.0, 2.0, 2.0, 4.0]), np.array([0.0, 0.0, 1.0, 0.0])
    phi = np.column_stack([(split * 2.0**layers) ** -2.0, split**-3.0])
    values = list(LIMIT + phi @ np.stack([FIRST, SECOND]))
    for count in (3, 4):
        found = extrapolated(values[:count], phi[:count])
        np.testing.assert_allclose(found.value, LIMIT, rtol=1e-12)
        each = 0.5 * np.abs(phi[count - 1] * np.stack([FIRST, SECOND], axis=1))
        assert np.all(found.error >= each.sum(axis=1) * (1.0 - 1e-9))


@pytest.mark.parametrize("count", [2, 3, 5])
def test_the_parts_of_the_error_have_signs_and_make_it_up(count):
    """A sequence from the other side has the opposite parts; what the last level may be off by is no such part."""
    values = sequence(2.0, count, 0.5)
    found, other = (extrapolated([sign * value for value in values], terms(2.0, count)) for sign in (1.0, -1.0))
    np.testing.assert_allclose(np.abs(found.parts).sum(axis=0), found.error, rtol=1e-12)
    np.testing.assert_allclose(other.parts, -found.parts)
    assert np.all(found.parts[0] * FIRST < 0.0)  # what extrapolation adds takes errors away
    assert np.all(extrapolated(values, terms(2.0, count), 0.1).error > found.error)


def test_a_level_that_moves_the_limit_widens_its_error():
    """By as much as the largest term did not shrink; of three by what the edges' did, and the second one whole."""
    phi = np.array([[1.0, 1.0], [0.25, 0.125], [0.0625, 0.125], [0.0625, 0.016]])
    values = [np.array([value]) for value in (1.0, 0.9, 0.85, 0.86)]
    two, three, four = (extrapolated(values[:count], phi[:count]) for count in (2, 3, 4))
    edge, inside = np.linalg.solve(np.diff(phi[:3], axis=0), [-0.1, -0.05])
    moved = abs(three.value - two.value)[0]
    assert three.error[0] == pytest.approx(0.5 * abs(edge) * 0.0625 + abs(inside) * 0.125 + 0.25 * moved)
    assert moved > 0.0 and four.error[0] > abs(four.value - three.value)[0] > 0.0


def test_edges_that_a_press_opens_add_more_and_are_less_sure():
    """Both by c (sink/t)^2 of what their term adds; a target that is pulled up opens nothing."""
    levels = family("box")
    values = list(LIMIT + levels.terms[:3] @ np.stack([FIRST, SECOND]))
    plain, pressed, pulled = (levels.limit(values, sunk=(sink, sink)) for sink in (0.0, 0.1, -0.1))
    more = -50.0 * 0.1**2 * 0.0625 * FIRST
    np.testing.assert_allclose(pressed.value - plain.value, more, rtol=1e-9)
    np.testing.assert_allclose(pressed.parts[0] - plain.parts[0], more, rtol=1e-9)
    np.testing.assert_allclose([pulled.value, pulled.error], [plain.value, plain.error])
    tilted = levels.limit(values, sunk=(0.1, 0.15))
    np.testing.assert_allclose(tilted.value, pressed.value)
    np.testing.assert_allclose(tilted.parts[0] - plain.parts[0], 1.5**2 * more, rtol=1e-9)


def test_an_edge_of_a_tilted_target_is_deeper_than_its_middle():
    """By the tilt over half its width; by both tilts of a whole pad."""
    half, whole = (pad_family(scene(15.0), whole=each)[0].coarse for each in (False, True))
    x, y = half.reach()[[2, 4]]
    assert half.sunk(np.array([0.3, -0.1, -0.02])) == pytest.approx((0.1, 0.1 + 0.02 * x))
    assert whole.sunk(np.array([0.3, -0.1, 0.02, 0.2, -0.01, 0.4])) == pytest.approx((0.1, 0.1 + 0.02 * x + 0.01 * y))


def test_two_levels_own_to_more_where_the_target_tilts():
    """Of a flush box the third level is 0.021 away where the edge stands 0.197 t deep, the middle 0.059."""
    levels, values = family("box"), [LIMIT, LIMIT]
    even, tilted = (levels.early(values, LIMIT > np.inf, pressed=False, sunk=(0.1, edge)) for edge in (0.1, 0.2))
    np.testing.assert_allclose(tilted.error, even.error * (1.0 + 50.0 * 0.2**2) / (1.0 + 50.0 * 0.1**2))


def test_no_component_owns_to_more_than_the_worst():
    """However far a target sinks: what a press adds to the worst is in its own error."""
    levels = family("box")
    assert levels.least_share(0.05) == pytest.approx(levels.share * (1.0 + 50.0 * 0.05**2) ** 2)
    assert levels.least_share(0.2) == 1.0


@pytest.mark.parametrize(("width", "factor"), [(15.0, 1.0), (20.0, 2.0)])
def test_two_levels_own_to_terms_that_cancel(width, factor):
    """Along z twice what is added, sideways once within a face; values that agree own to 0.03 of an edge's term."""
    levels = pad_family(scene(width))[0]
    values = list(LIMIT + levels.terms[:2, :1] * FIRST)
    found = levels.early(values, np.array([False, True, False]), pressed=False)
    np.testing.assert_allclose(found.value, LIMIT)
    np.testing.assert_allclose(found.error, np.array([factor, 2.0, factor]) * levels.terms[1, 0] * np.abs(FIRST))
    alike = levels.early([LIMIT, LIMIT], np.ones(3, dtype=bool), pressed=False)
    np.testing.assert_allclose(alike.error, 0.03 * levels.terms[1, 0] * np.abs(LIMIT))


def at_least(*each):
    """States of the first two levels whose J is at least so much."""
    return tuple(replace(rest(family("box").coarse), min_J=J) for J in each)


def test_rims_that_crease_take_no_third_level():
    """J that falls from 0.6 to 0.32 is foreseen at 0.17; from 0.84 to 0.45 at 0.24, at a flush corner at 0.03."""
    found = [family("box").creased(at_least(*pair)) for pair in ((0.6, 0.32), (0.84, 0.45), (1.0, 1.0))]
    assert found == [True, False, False] and pad_family(scene(20.0))[0].creased(at_least(0.84, 0.45))


@pytest.mark.parametrize(("x", "order"), [(0.2, 1.189), (0.375, 0.97), (0.9, 0.75)])
def test_corners_of_a_flush_pad_that_fold_converge_more_slowly(x, order):
    """As h^0.75 from x = (ln J_2)^2/-ln J_1 = 0.5 on, as without load to 0.25; not the edges in a face."""
    levels, inside = (pad_family(scene(width))[0] for width in (20.0, 15.0))
    states = at_least(*np.exp([-1.0, -(x**0.5)]))
    values, none = list(LIMIT + levels.terms[:2, :1] ** (order / 1.1892) * FIRST), LIMIT > np.inf
    found, plain = (each.early(values, none, pressed=False) for each in (levels.folding(states), levels))
    np.testing.assert_allclose(found.value, LIMIT, rtol=1e-3)
    np.testing.assert_allclose(found.error, plain.error, rtol=0.02)
    assert inside.folding(states) is inside


@pytest.mark.parametrize("first", [0.996, 0.9998, 1.0, 1.005])
def test_corners_that_a_pull_nearly_undoes_do_not_fold(first):
    """-ln J of 0.04 on the second level does not fold, whatever of the first is left beside a pull."""
    levels = pad_family(scene(20.0))[0]
    states = at_least(first, 0.96)
    assert levels.folding(states) is levels and not levels.creased(states)


def test_levels_that_differ_at_the_edges_alone_own_to_as_much_inside():
    """Those of a family without its first; the third, divided inside, shows the limit of both terms."""
    whole = family("box")
    levels = whole.without_first
    assert levels.coarse is whole.fine and levels.carrier(1) is whole.carrier(2) and levels.rested == whole.rested - 1
    assert levels.edges_alone and not whole.edges_alone
    values = list(LIMIT + levels.terms[:3] @ np.stack([FIRST, SECOND]))
    two, alone = (each.early(values[:2], np.ones(3, dtype=bool), pressed=False) for each in (levels, whole))
    assert np.all(two.error >= 2.0 * levels.terms[1, 0] * np.abs(FIRST) + np.abs(values[1] - values[0]) * (1 - 1e-9))
    assert two.parts[1] == pytest.approx(values[1] - values[0]) and np.all(alone.parts[1] == 0.0)
    np.testing.assert_allclose(levels.limit(values).value, LIMIT)


@pytest.mark.parametrize("level", [2, 3])
def test_what_a_level_promises_is_what_known_terms_leave(level):
    """The fourth level, not divided at the edge, leaves what its term adds.

    Its limit moves by half of what it takes off: so much was wrong inside, and is reduced as what is there.
    """
    levels = family("box")
    values = list(LIMIT + levels.terms[: level + 1] @ np.stack([FIRST, (level - 2) * SECOND]))
    before, there = levels.limit(values[:level]), levels.limit(values)
    foreseen, own = levels.foreseen(before, level), level - 1
    np.testing.assert_allclose(foreseen.parts[own:2], 0.0)
    taken = 0.0 if level == 2 else np.abs(before.parts[:2]).sum(axis=0) - np.abs(foreseen.parts[:2]).sum(axis=0)
    np.testing.assert_allclose(foreseen.parts[2], 0.5 * taken * levels.terms[level, 1] / levels.terms[2, 1], atol=1e-15)
    kept = (before if level == 2 else there).parts[0] * (0.25 if level == 2 else 1.0)
    np.testing.assert_allclose(foreseen.parts[0], kept, rtol=1e-9)
    np.testing.assert_allclose(foreseen.error, np.abs(foreseen.parts).sum(axis=0))


@pytest.mark.parametrize("p", [1.2, 2.0, 2.378])
def test_in_contact_one_power_is_owned_to_more_than_once(p):
    """What is added of one power is a m^-p at every level: the largest, carried to the last, is that of the last."""
    for count in (2, 3, 5):
        found = extrapolated(sequence(p, count), terms(p, count), pressed=True)
        np.testing.assert_allclose(found.value, LIMIT, rtol=1e-13)
        np.testing.assert_allclose(found.error, 2.2 * np.abs(FIRST) * SIZES[count - 1] ** -p, rtol=1e-9)


@pytest.mark.parametrize("count", [3, 4, 5])
def test_in_contact_levels_that_agree_by_chance_do_not_narrow_the_error(count):
    """An amplitude of either sign from level to level, those of the last two levels so that the two agree."""
    m = SIZES[:count]
    amplitude = 0.3 * np.array([1.0, -1.0] * 3)[:count]
    amplitude[-1] = amplitude[-2] * (m[-2] / m[-1]) ** -2.0
    values = [np.array([1.0 + a * size**-2.0]) for a, size in zip(amplitude, m, strict=True)]
    found = extrapolated(values, terms(2.0, count), pressed=True)
    assert 0.0 < abs(found.value[0] - 1.0) < found.error[0]


def test_two_meshes_of_one_fineness_are_told_by_their_difference():
    found = extrapolated([np.array([1.0]), np.array([1.1])], np.full((2, 1), np.nan))
    assert found.value[0] == 1.1 and found.error[0] == pytest.approx(0.1)


def test_what_the_last_value_may_be_off_by_is_in_the_error():
    """With the factor of extrapolation, 1 + 1/((3/2)^2 - 1) of two levels."""
    plain, off = (extrapolated(sequence(2.0, 3)[1:], terms(2.0, 3)[1:, :1], part) for part in (0.0, 0.01))
    np.testing.assert_allclose(off.error - plain.error, 0.01 * (1.0 + 1.0 / (1.5**2 - 1.0)), rtol=1e-9)


def scene(size=15.0, *, disc=False):
    """A pad of 20 x 20 x 2 mm under a square target, or a cylinder under a disc; the force acts at the bonded face."""
    base = load_sensor(
        "biorob2018", ["target.load_height=0", *(f'target.{side}="{size} mm"' for side in ("width", "length")),
                       NEO_HOOKEAN])
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
    """Also where the cells at edges alone are cut."""
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
    assert np.abs(away).max() < 0.02 * np.abs(after).max() / min(level, 2) ** 4


@pytest.mark.parametrize("name", ["box", "disc"])
def test_constant_pressures_are_carried_exactly(name):
    levels = family(name)
    coarse, fine = (levels.maker(each).mesh for each in (1, 2))
    first = np.zeros(coarse.chi.shape[:2])
    first[:, 0] = np.sqrt(coarse.inside.weights.sum(axis=1))
    found = levels.carrier(2).pressures(first)
    np.testing.assert_allclose(found[:, 0], np.sqrt(fine.inside.weights.sum(axis=1)), rtol=1e-9)
    np.testing.assert_allclose(found[:, 1:], 0.0, atol=1e-9)


# d_h, sink, alpha of a pad of 20 x 20 x 2 mm under 15 x 15 mm, K/mu = 1000: NGSolve 6.2 and FElupe 11.3, to 0.1 %.
BOX = np.array([[4.482e3, 0.0, 6.915], [0.0, 120.67e3, 0.0], [6.915, 0.0, 1.0695]])


@pytest.mark.slow
def test_the_error_of_a_pad_covers_the_truth():
    """Compliances of all levels, from two on."""
    pad = linear_pad(scene(), 2e-3)
    each = np.array([np.diag(C) for C in pad.compliances])
    unit = np.diag(np.outer(pad.scales.loads[:3], 1.0 / pad.scales.lengths[:3]))
    known = unit * np.diag(np.linalg.inv(BOX))
    assert len(each) >= 3
    for count in range(2, len(each) + 1):
        found = pad.levels.limit(list(each[:count]))
        off = np.abs(found.value / known - 1.0)
        assert np.max(off) < np.max(found.error / found.value) + 1.5e-3
