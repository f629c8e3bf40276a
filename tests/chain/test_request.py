"""Plans: what finer answers, and models in space, would gain."""

import math

import numpy as np
import pytest

from sits_mech.chain.ends import ROUGH
from sits_mech.chain.interpolate import solved_likely
from sits_mech.chain.models import plan
from sits_mech.chain.omissions import Omission
from sits_mech.chain.plan import Choice
from sits_mech.chain.prices import Look, Step, cost
from sits_mech.chain.request import Plan, _gains, _notes, _overhang
from sits_mech.magnetics.bars import planar_bars
from sits_mech.mechanics.layer import planar_layer
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor


def test_a_section_has_its_ends_in_the_asked_error() -> None:
    """And the model in space first among what is finer, without them."""
    found = plan(load_sensor("biorob2018"))
    ends = next(item.size for item in found.left_out if item.what == "ends along y")
    assert found.error == pytest.approx(ends + 1e-2, rel=1e-12) and 0.3 < ends < 0.4 and found.not_estimated == ()
    space, *rungs = found.finer
    assert (space.model, space.tolerance) == ("sheets", 1e-2) and space.whole == pytest.approx(1e-2, rel=1e-9)
    assert [step.model for step in rungs] == ["planar", "planar"]
    assert all(found.error - 1e-2 < step.whole < found.error for step in rungs)
    priced = cost("magnetics", "sheets", ROUGH, 1)
    assert found.seconds == pytest.approx(sum(step.seconds for step in found.steps) + priced)


@pytest.mark.slow
def test_plane_strain_of_a_pad_is_priced_by_its_stiffness() -> None:
    """4.4 times too stiff in compression, as the factors say: 3.4 displacements are left out."""
    found = plan(load_sensor("biorob2018"), [Wrench(F_z=0.3)], mechanics="planar")
    ends = next(item for item in found.left_out if item.what.startswith("ends of pad"))
    assert ends.size == pytest.approx(3.41, abs=0.02) and not ends.in_error and found.error > 3.4
    assert found.finer[0].model == "block" and found.finer[0].whole < 0.1


def test_what_has_no_size_is_named() -> None:
    """Steel in section: no model in space, no sum that hides it."""
    shape = 'shape="rectangle", width=8e-3, length=8e-3, thickness=2e-4'
    found = plan(load_sensor("biorob2018", [f"target={{conductivity=7e6, relative_permeability=100, {shape}}}"]))
    assert found.not_estimated == ("ends along y",) and math.isfinite(found.error)
    bare = plan(load_sensor("biorob2018").model_copy(update={"elastomer": None}))
    assert found.magnetics.name == "planar-fem" and bare.not_estimated == ("ends along y",)  # no pose is known


@pytest.mark.slow
def test_a_target_wider_than_its_elastomer_says_what_reaches_over() -> None:
    """Of the layer's answer it is no part, of the coils' it is; a target within its elastomer says nothing."""
    flush, wide = (load_sensor("biorob2018", [f'target.width="{width} mm"']) for width in (20, 26))
    said = [any("reaches 3 mm over its elastomer" in note for note in plan(one).notes) for one in (flush, wide)]
    assert said == [False, True] and not plan(load_sensor("biorob2018")).notes
    rests = [planar_layer(one, 0.1).equilibrium(Wrench(0.2, 1.0)).pose for one in (flush, wide)]
    np.testing.assert_allclose(rests[0].components, rests[1].components, rtol=1e-9, atol=1e-15)
    L = [planar_bars(one, 1e-2).impedance(rests[0], one.frequency).L[0, 0] for one in (flush, wide)]
    assert L[1] < L[0]


def test_conductors_cost_where_they_are_solved_in_space() -> None:
    """A plan's seconds are those of its steps: a plate in section costs nothing more, in space its time."""
    plate = 'conductors=[{name="P", material="ferrite", centre=["0 mm", "-1 mm"], thickness="0.5 mm", %s}]'
    shapes = 'shape="disc", diameter="18 mm"', 'shape="rectangle", width="18 mm", length="18 mm"'
    section, space = (plan(load_sensor("biorob2018", [plate % shape])) for shape in shapes)
    assert (section.magnetics.name, space.magnetics.name) == ("planar-fem", "sheets")
    alone = [cost("magnetics", found.magnetics.name, found.steps[0].tolerance, 1) for found in (section, space)]
    assert section.steps[0].seconds == alone[0] and space.steps[0].seconds == pytest.approx(alone[1] + 1.0)


SENSOR = load_sensor("biorob2018")
LINEAR, PLANAR = Choice("linear", "asked for", by_name=True), Choice("planar", "asked for", by_name=True)
MANY = [Wrench(0.05 * x, 0.1 * z) for x in range(-2, 3) for z in range(7)]


def test_a_grid_is_solved_in_part_and_says_so() -> None:
    """Thirty-five loads: images and those between are left out; of one load nothing is."""
    found, one = (Plan.of(SENSOR, loads, 0.1, LINEAR, PLANAR) for loads in (MANY, MANY[:1]))
    between = [item for item in found.left_out if item.what == "loads between solved ones"]
    assert len(between) == 1 and between[0].in_error and between[0].size == 0.1
    assert all(item.what != "loads between solved ones" for item in one.left_out)
    sizes = sum(item.size for item in found.left_out if item.counts and item.size > 0.0)
    assert found.error == pytest.approx(sizes + sum(step.error for step in found.steps)) and sizes > 0.1
    solved = solved_likely(MANY)
    assert between[0].reason.startswith(f"interpolated between about {len(solved)} of 35 solved loads")
    apart = len({(abs(load.F_x), load.F_z) for load in solved})
    assert apart < len(solved) and [step.seconds for step in found.steps] == [
        cost("mechanics", "linear", 0.1, apart), cost("magnetics", "planar", found.steps[1].tolerance, 35),
    ]


def test_what_was_seen_of_a_load_replaces_what_is_usual() -> None:
    """Its error and seconds, of its half; no finer steps of it are offered, and its notes come first."""
    for magnetics, error in ((None, 1e-2), (3e-3, 3e-3)):
        found = Plan.of(SENSOR, MANY[-1:], 0.1, LINEAR, PLANAR, seen=Look(0.07, 9.0, ("seen",), magnetics))
        mechanics, other = found.steps
        assert (mechanics.error, mechanics.seconds, other.error) == (0.07, 9.0, pytest.approx(error))
        assert found.notes[0] == "seen" and all(step.half == "magnetics" for step in found.finer)
    assert any(step.half == "mechanics" for step in Plan.of(SENSOR, MANY[-1:], 0.1, LINEAR, PLANAR).finer)


def test_finer_steps_are_those_that_gain() -> None:
    """By the error of their half that they replace; a model in space also by the half's ends, and by no other's."""
    asked = Step("mechanics", "planar", 0.1, 0.1, 1.0), Step("magnetics", "planar", 0.01, 0.01, 1.0)
    missing = [
        Omission("ends of pad", "", 0.5, half="mechanics"), Omission("ends along y", "", 0.3),
        Omission("finite strain", "", 0.2, half="mechanics"),
    ]
    finer = (
        Step("mechanics", "block", 0.1, 0.1, 9.0), Step("magnetics", "sheets", 0.1, 0.1, 9.0),
        Step("mechanics", "planar", 0.02, 0.02, 9.0), Step("magnetics", "planar", 0.005, 0.01, 9.0),
    )
    found = _gains(asked, finer, missing, 1.11)
    assert [step.model for step in found] == ["block", "sheets", "planar"]  # the last gains nothing
    assert [step.whole for step in found] == [pytest.approx(each) for each in (0.61, 0.9, 1.03)]


def test_large_loads_are_told_where_no_solve_has_seen_them() -> None:
    """Small strain off by 0.35, 0.47 and, of a slender layer, by no number."""
    small, large = [Wrench(F_z=1.0)], [Wrench(F_z=1.3)]
    assert _notes(SENSOR, small, None) == _notes(SENSOR, [], None) == _notes(SENSOR, large, Look(0.1, 1.0)) == ()
    (note,) = _notes(SENSOR, large, None)
    assert note.startswith("a large load for this pad: small strain would be off by 0.47; some pads became unstable")
    slender = load_sensor("biorob2018", ["elastomer.thickness=0.1"])
    assert _notes(slender, large, None) == () and _notes(SENSOR.model_copy(update={"elastomer": None}), [], None) == ()


def test_what_reaches_over_the_elastomer_is_measured_on_each_side() -> None:
    flush, wide, long = (load_sensor("biorob2018", [size]) for size in (
        'target.width="20 mm"', 'target.width="26 mm"', 'target.length="30 mm"',
    ))
    assert _overhang(flush) == _overhang(flush.model_copy(update={"target": None})) == ()
    assert _overhang(wide.model_copy(update={"elastomer": None})) == ()
    assert [_overhang(one)[0].split(" over ")[0] for one in (wide, long)] == [
        "the target reaches 3 mm", "the target reaches 5 mm"
    ]
