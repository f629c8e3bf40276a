"""Plans: what finer answers, and models in space, would gain."""

import math

import pytest

from sits_mech.chain.models import plan
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
