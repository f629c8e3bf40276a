"""Plans: what finer answers, and models in space, would gain."""

import math

import numpy as np
import pytest

from sits_mech.chain.models import plan
from sits_mech.chain.prices import cost
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
    assert found.seconds > sum(step.seconds for step in found.steps)  # what the ends cost to be priced


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
