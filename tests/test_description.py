"""Descriptions of models: costs by counts, what counts of omissions, how they enter a report."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sits_mech.chain.models import MAGNETICS, MECHANICS
from sits_mech.description import Description, Question, Refusal, Rung, added, by_component, function, sized, total
from sits_mech.notes import Omission, OmissionKind, Relative
from sits_mech.quantities import Pose, SolveReport, Wrench
from sits_mech.scene.sensor import Sensor, load_sensor

SENSOR = load_sensor("biorob2018")
RUNGS = Rung(1e-1, 10, 2, 0.5, 0.1), Rung(1e-2, 20, 3, 1.0, 0.2), Rung(0.0, 40, 4, 2.0, 0.4)


def described(**changes: object) -> Description:
    """A model that holds all, and leaves nothing out."""
    own = Description("any", lambda *_: "made", lambda *_: None, lambda *_: (), RUNGS, 1e-3)
    return replace(own, **changes)  # type: ignore[arg-type]


@pytest.mark.parametrize(("tolerance", "unknowns", "times"), [(0.3, 10, 2), (0.1, 10, 2), (0.05, 20, 3), (1e-9, 40, 4)])
def test_a_cost_is_that_of_the_rung_of_a_tolerance(tolerance: float, unknowns: int, times: int) -> None:
    """Operations of each factorisation by a power of the unknowns; of every answer where each takes its own."""
    once = described(fresh=False).cost(Question(tolerance, (Wrench(),) * 7))
    each = described(power=2.0).cost(Question(tolerance, (Wrench(),) * 7))
    assert (once.unknowns, once.factorisations, once.answers) == (unknowns, times, 7)
    assert once.operations == times * unknowns**3 and each.operations == 7 * times * unknowns**2
    rung = next(rung for rung in RUNGS if rung.unknowns == unknowns)
    assert once.seconds == each.seconds == pytest.approx(rung.once + 7 * rung.each)


def test_answers_are_loads_or_poses_and_one_at_least() -> None:
    poses = Pose(np.zeros((2, 3)), np.ones((2, 3)))
    assert [each.answers for each in (Question(), Question(pose=poses), Question(loads=(Wrench(),) * 4))] == [1, 6, 4]


def test_what_leaves_the_plane_is_named_once() -> None:
    """Of loads and of poses, those that are zero not."""
    question = Question(loads=(Wrench(1.0, 2.0), Wrench(F_y=0.1, M_z=1.0)), pose=Pose(0.0, 1.0, d_y=np.array([0, 1.0])))
    assert set(question.out_of_plane) == {"F_y", "M_z", "d_y"} and Question().out_of_plane == ()


def test_no_numerics_are_better_than_the_finest_rung() -> None:
    assert [described().reached(tolerance) for tolerance in (1e-2, 1e-6)] == [1e-2, 1e-3]


def test_a_refusal_is_one_line() -> None:
    said = str(Refusal("target.shape", "be disc for rings", "outline"))
    assert said == "target.shape must be disc for rings; got outline"


def test_a_model_is_made_when_it_is_called() -> None:
    """By its function, or by where that is."""
    assert described()(SENSOR, 0.1) == "made"
    assert function("sits_mech.description:total") is total
    with pytest.raises(AttributeError):
        described(factory="sits_mech.description:nothing")(SENSOR, 0.1)


ITEMS = (
    Omission(OmissionKind.PAD_ENDS, 0.1), Omission(OmissionKind.PITCH, 0.2, included=True), Omission(OmissionKind.AIR),
    Omission(OmissionKind.IDLE, 0.4, counts=False), Omission(OmissionKind.HISTORY, math.nan, counts=False),
)
UNKNOWN = Omission(OmissionKind.NOT_CUT, math.nan)


def test_only_what_counts_is_summed() -> None:
    """What has no size makes the sum none; beside it the others have one."""
    assert total(ITEMS) == pytest.approx(0.3) and math.isnan(total((*ITEMS, UNKNOWN)))
    assert sized((*ITEMS, UNKNOWN)) == pytest.approx(0.3) and total(()) == sized(()) == 0.0


def test_a_report_lists_all_and_its_error_holds_what_it_did_not() -> None:
    report = SolveReport("any", 1, 1, 0.0, 0.01, 0.0, left_out=(ITEMS[2],))
    found = added(report, (ITEMS[0], ITEMS[1], UNKNOWN))
    assert found.estimated_error == pytest.approx(0.11) and found.left_out == (ITEMS[2], ITEMS[0], ITEMS[1], UNKNOWN)


def test_an_omission_is_of_each_component_of_a_pose() -> None:
    """As it says of each, else of all alike; with the sign of the displacement."""
    moved = np.array([[1.0, -2.0, 3.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0, 0.0, 5.0]])
    alike = by_component(Omission(OmissionKind.PAD_ENDS, 0.5, Relative.DISPLACEMENT), moved)
    np.testing.assert_allclose(alike, 0.5 * moved)
    parts = Omission(OmissionKind.PAD_ENDS, 2.0, Relative.DISPLACEMENT, parts=(1.0, 2.0, 0.0, 0.0, 0.0, 0.0))
    np.testing.assert_allclose(by_component(parts, moved)[:, :3], [[1.0, -4.0, 0.0], [2.0, 0.0, 0.0]])


@pytest.mark.parametrize("model", [*MECHANICS.values(), *MAGNETICS.values()], ids=lambda model: str(model.name))
def test_every_model_has_rungs_and_a_place(model: Description) -> None:
    """From coarse to fine, the last from zero on; finer ones take no less; its function is there."""
    tolerances = [rung.tolerance for rung in model.rungs]
    assert tolerances == sorted(set(tolerances), reverse=True) and tolerances[-1] == 0.0 < model.least < 0.1
    sizes = [(rung.unknowns * rung.factorisations, rung.once + rung.each) for rung in model.rungs]
    assert sizes == sorted(sizes) and 0.0 < model.share <= 1.0 and callable(function(model.factory))
    assert all(cost.operations >= 0.0 for cost in (model.cost(Question(at)) for at in (1e-1, 1e-9)))


def holds(model: Description, sensor: Sensor) -> bool:
    """Whether a model holds a scene where nothing is asked."""
    return model.refusal(sensor, Question()) is None


def test_what_is_held_is_made() -> None:
    """A model that says that it holds the published scene is made of it; of others it raises what it says."""
    for model in (*MECHANICS.values(), *MAGNETICS.values()):
        if holds(model, SENSOR):
            assert model(SENSOR, 0.1) is not None
        else:
            with pytest.raises(ValueError, match="must"):
                model(SENSOR, 0.1)
