"""What is planned of a request: magnetics as fine as the signals take, refusals that name what can be reached."""

import numpy as np
import pytest

from sits_mech.chain.models import loaded_model
from sits_mech.chain.prices.forecast import Look
from sits_mech.chain.propagation import poses_of
from sits_mech.chain.tolerance.goal import HALF
from sits_mech.chain.tolerance.promise import Promise, aim_at
from sits_mech.quantities import Equilibrium, Pose, SolveReport, Wrench
from sits_mech.scene.sensor import SceneError, load_sensor

SENSOR, LOAD = load_sensor("biorob2018-w15"), Wrench(1.0, 3.0)
POSE = Pose(3.7e-4, 1.982e-3, -1.7e-3)


@pytest.mark.slow
def test_magnetics_that_leave_too_much_in_doubt_are_made_finer() -> None:
    """A gentle load changes half a percent of L0: a thousandth of the target's change leaves 1.8 % of that in doubt."""
    found = aim_at(SENSOR, "planar", 1e-2, [LOAD], [POSE])
    assert found is not None and found.name == "planar"
    assert found.goal.magnetics < HALF * 1e-2 and found.asked < 1e-2
    coarse, _ = loaded_model(SENSOR, "planar", 1e-2, [LOAD])
    assert found.field is not coarse
    plenty = aim_at(SENSOR, "planar", 0.3, [LOAD], [POSE])
    assert plenty is not None and plenty.asked == 0.3 and plenty.left > 0.2


def test_a_promise_is_what_the_first_meshes_show() -> None:
    """Half a percent of both lengths: more than is left, so that a mesh more is expected, and the magnetics beside."""
    aim = aim_at(SENSOR, "planar", 1e-2, [LOAD], [POSE])
    assert aim is not None
    report = SolveReport("block", 4000, 10, 0.0, 5e-3, 0.2)
    first = Equilibrium(LOAD, POSE, Pose(5e-6, 1e-6), np.zeros(0), report)
    own = aim.goal.mechanics(poses_of([first]))
    assert own > aim.left
    one, many = aim.promised(first, 1), aim.promised(first, 81, 12)
    assert own * 0.2 <= one.error - aim.goal.magnetics <= own * 0.25 < many.error and 2.0 * one.seconds < many.seconds
    assert Promise(one, 2.0, 0.01).record == {
        "planned_seconds": one.seconds, "planned_error": one.error, "seconds": 2.0, "error": 0.01,
    }


def test_what_is_surely_missed_is_refused_with_what_can_be_had() -> None:
    aim = aim_at(SENSOR, "planar", 1e-2, [LOAD], [POSE])
    assert aim is not None
    aim.refuse_beyond(Look(0.029, 3.0), "F_x = 1 N")
    with pytest.raises(SceneError, match=r"reached at F_x = 1 N; got 0.01: 0.03 .* in about 3.2 s \(--best\)$"):
        aim.refuse_beyond(Look(0.031, 3.2), "F_x = 1 N")


def test_coils_that_show_nothing_are_no_aim() -> None:
    assert aim_at(SENSOR, "planar", 0.1, [LOAD], [Pose(0.0, 2e-3)]) is None
