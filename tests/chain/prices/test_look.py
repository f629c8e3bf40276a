"""A look at a load before it is planned: what it says of error and seconds against the answer itself."""

import math

import pytest

from sits_mech.chain.models import plan
from sits_mech.chain.prices.look import look
from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.linear import linear_pad
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor


@pytest.mark.parametrize(("load", "tolerance"), [((0.5, 1.0), 1e-2), ((0.5, 2.0), 1e-2), ((0.3, 0.6), 5e-2)])
def test_the_error_to_expect_is_the_answers_within_three(load: tuple[float, float], tolerance: float) -> None:
    sensor = load_sensor("biorob2018", ['elastomer.contact="never"'])
    pad, wrench = block_pad(sensor, tolerance), Wrench(*load)
    seen, found = look(pad, wrench, tolerance), pad.equilibrium(wrench)
    assert seen is not None
    assert 1 / 3 < seen.error / found.report.estimated_error < 3 and 0.1 < seen.seconds < 5.0


def test_a_tolerance_that_is_not_to_be_had_and_data_that_end_come_first() -> None:
    found = plan(load_sensor("biorob2018"), [Wrench(F_z=4.0)])
    assert "is known up to stretch 2" in found.notes[0] and "is not to be had at this load" in found.notes[1]
    assert found.error > 0.015 and found.error == plan(load_sensor("biorob2018"), [Wrench(F_z=4.0)]).error


def test_a_load_that_is_not_carried_has_no_error() -> None:
    seen = look(block_pad(load_sensor("biorob2018"), 1e-2), Wrench(F_z=400.0), 1e-2)
    assert seen is not None and math.isinf(seen.error) and seen.notes[0].startswith("a large load for this pad: wrench")


def test_models_of_one_mesh_are_not_looked_at() -> None:
    assert look(linear_pad(load_sensor("biorob2018"), 0.1), Wrench(F_z=1.0), 1e-2) is None
