"""What is planned of a request and what of its table is solved, reached and refused."""

from __future__ import annotations

import numpy as np
import pytest

from sits_mech.chain.interpolate import LayerGrid
from sits_mech.chain.models import MAGNETICS, Choice, Why, loaded_model
from sits_mech.chain.plans import aimed
from sits_mech.chain.plans.aimed import Promise, aim_at, aimed_loads, aimed_mechanics, readable_poses, status_of
from sits_mech.chain.plans.goal import HALF
from sits_mech.chain.plans.prices import MeshForecast, predicted
from sits_mech.chain.propagation import poses_of
from sits_mech.description import Question
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.linear import linear_layer
from sits_mech.mechanics.loads import Settled
from sits_mech.mechanics.symmetry import symmetry_of
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
    mechanical = [predicted(report, own, aim.left, count).seconds for count in (1, 12)]
    assert [one.seconds, many.seconds] == [
        seconds + MAGNETICS["planar"].cost(Question(0.1 * aim.asked, (LOAD,) * loads)).seconds
        for seconds, loads in zip(mechanical, (1, 81), strict=True)
    ]
    assert Promise(one, 2.0, 0.01, 0.02).record == {
        "planned_seconds": one.seconds, "planned_error": one.error, "seconds": 2.0, "reached": 0.01, "error": 0.02,
    }


class Missing:
    """One mesh, always as far off, whatever it says of it."""

    def __init__(self, said: float) -> None:
        self.report = SolveReport("one", 1, 1, 0.0, said, 0.0)

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        return Equilibrium(wrench, POSE, Pose(5e-6, 1e-6), np.zeros(0), self.report)


@pytest.mark.parametrize(
    ("said", "why", "again"), [(5e-3, Why.WITHIN, 5e-3), (0.1, Why.WITHIN, 1e-2), (0.0, Why.WITHIN, 0.0),
                               (5e-3, Why.NAMED, 0.0)]
)
def test_what_no_goal_refines_is_chosen_once_more(
    monkeypatch: pytest.MonkeyPatch, said: float, why: Why, again: float
) -> None:
    """As much nearer as the coils' rest is missed by, than what it says or was asked; not by name or without error."""
    asked = list[float]()

    def choose(_: object, name: str, tolerance: float, loads: object) -> tuple[Missing, Choice]:
        asked.append(tolerance)
        return Missing(said), Choice("one", why)

    monkeypatch.setattr(aimed, "mechanical_model", choose)
    aimed_mechanics(SENSOR, "auto", 1e-2, [Wrench(), LOAD], "planar")
    aim = aim_at(SENSOR, "planar", 1e-2, [LOAD], [POSE])
    assert aim is not None
    off = aim.goal.mechanics(poses_of([Missing(said).equilibrium(LOAD)]))
    assert off > aim.left and asked == [1e-2, *([pytest.approx(again * aim.left / off)] if again else [])]


def test_what_is_surely_missed_is_refused_with_what_can_be_had() -> None:
    aim = aim_at(SENSOR, "planar", 1e-2, [LOAD], [POSE])
    assert aim is not None
    aim.refuse_beyond(MeshForecast(0.029, 3.0), "F_x = 1 N")
    with pytest.raises(SceneError, match=r"reached at F_x = 1 N; got 0.01: 0.03 .* in about 3.2 s, which best takes$"):
        aim.refuse_beyond(MeshForecast(0.031, 3.2), "F_x = 1 N")


def test_coils_that_show_nothing_are_no_aim() -> None:
    assert aim_at(SENSOR, "planar", 0.1, [LOAD], [Pose(0.0, 2e-3)]) is None


SENSOR = load_sensor("biorob2018-w15")
GRID = {"F_x": [-0.3, 0.0, 0.3], "F_z": [0.5, 2.0]}
BY = symmetry_of(SENSOR)


def test_what_is_planned_is_reached() -> None:
    """Within a factor of two; of a coarse tolerance the first meshes are enough, and a finer one is better for more."""
    reached, seconds = [], []
    for tolerance in (3e-3, 1e-1):
        found = aimed_loads(LayerGrid(SENSOR, planar_layer(SENSOR, tolerance), GRID, BY, tolerance), "planar")
        assert found.planned is not None and found.planned.seconds > 0.0
        assert 0.5 < found.reached / found.planned.error < 2.0
        assert set(found.settled) >= {Wrench(F_x, F_z) for F_x in GRID["F_x"] for F_z in GRID["F_z"]}
        reached.append(found.reached)
        seconds.append(found.planned.seconds)
    assert reached[0] < reached[1] and seconds[0] > seconds[1]


@pytest.mark.slow
def test_a_tolerance_that_is_not_to_be_had_is_refused_or_answered() -> None:
    layer = planar_layer(SENSOR, 1e-7)
    with pytest.raises(SceneError, match=r"must be one that can be reached at F_x = 0.3 N, F_z = 2 N, .*best takes"):
        aimed_loads(LayerGrid(SENSOR, layer, GRID, BY, 1e-7), "planar", best=False)


def test_models_of_one_mesh_plan_nothing() -> None:
    found = aimed_loads(LayerGrid(SENSOR, linear_layer(SENSOR), GRID, BY, 0.1), "planar")
    assert found.planned is None and np.isnan(found.reached) and found.asked <= 0.1


def test_a_target_among_the_coils_has_no_reading() -> None:
    def at(d_v: float) -> Settled:
        report = SolveReport("formula", 1, 1, 0.0, 0.0, 0.0)
        return Settled(Equilibrium(Wrench(), Pose(0.0, d_v), Pose(0.0, 0.0), np.zeros(0), report))

    assert status_of(SENSOR, at(-1e-3))[0] == "failed" and "coil plane" in status_of(SENSOR, at(-1e-3))[1]
    assert status_of(SENSOR, at(2e-3)) == ("ok", "") and len(readable_poses(SENSOR, [at(-1e-3), at(2e-3)])) == 1
    assert status_of(SENSOR, Settled(None, status="failed", reason="why")) == ("failed", "why")
