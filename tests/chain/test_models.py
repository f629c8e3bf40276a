"""Models by name: what is made for a choice, where it is looked at, and what a load's first meshes tell of it."""

from dataclasses import dataclass

import numpy as np
import pytest

from sits_mech.chain import models
from sits_mech.chain.conductors import AmongFar
from sits_mech.chain.ends import InSection
from sits_mech.chain.goal import Goal
from sits_mech.chain.models import _built, _changed, _chosen, _rest, _seen, _shown_at, loaded_model, magnetic_model
from sits_mech.chain.omissions import Omission
from sits_mech.chain.plan import Choice
from sits_mech.chain.prices import Look
from sits_mech.quantities import Equilibrium, Impedance, Pose, SolveFailed, SolveReport, Wrench
from sits_mech.scene.sensor import Sensor, load_sensor

SENSOR = load_sensor("biorob2018")
REPORT = SolveReport("any", 1, 1, 0.0, 0.07, 0.0)
LOAD, REST = Wrench(F_z=0.5), Pose(0.0, 2e-3)
OPEN = 'readout.idle_coil="open"'
PLATE = (
    'conductors=[{name="P", material="copper", shape="rectangle", centre=["500 mm", "0 mm", "0 mm"], width="2 mm", '
    'length="2 mm", thickness="0.5 mm"}]'
)


@dataclass(frozen=True)
class Coils:
    """Answers with a mark of the scene and the tolerance that it was made for, or fails."""

    sensor: Sensor
    tolerance: float
    fails: bool = False

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        if self.fails:
            raise SolveFailed("no", REPORT)
        n = len(self.sensor.coils)
        L = (2e-6 - 1e-4 * (3e-3 - np.asarray(pose.d_v)))[..., None, None] * np.eye(n)
        return Impedance(frequency, L, 0.0 * L, 2e-6 * np.eye(n), np.ones(n), 0.0 * L, 0.0 * L, "H", REPORT)


@pytest.fixture
def coils(monkeypatch: pytest.MonkeyPatch) -> list[Coils]:
    """The coils that were made, by whatever name."""
    made = list[Coils]()

    def make(sensor: Sensor, tolerance: float) -> Coils:
        made.append(Coils(sensor, tolerance))
        return made[-1]

    monkeypatch.setattr(models, "MAGNETICS", dict.fromkeys(models.MAGNETICS, make))
    return made


@pytest.mark.parametrize(("keys", "name", "needed"), [
    ([], "sheets", True), ([OPEN], "sheets", False), ([OPEN], "planar", True), ([PLATE], "planar-fem", True),
    ([OPEN, *(f'coils.{name}.winding="spiral"' for name in ("C1", "C2"))], "sheets", True), ([PLATE], "sheets", False),
])
def test_a_coarse_answer_at_rest_is_for_sizes_that_need_it(
    coils: list[Coils], keys: list[str], name: str, needed: bool
) -> None:
    """Shorted coils beside, sections and spirals do; in space among other metal it would take seconds."""
    found = _rest(load_sensor("biorob2018", keys), name)
    assert (found is not None) == needed == bool(coils)
    if found is not None:
        assert not found.answered and found.pose == REST and coils[0].tolerance == 0.1


def test_one_coil_alone_shorts_no_other(coils: list[Coils]) -> None:
    one = SENSOR.model_copy(update={"coils": SENSOR.coils[:1]})
    assert _rest(one, "sheets") is None and _rest(one, "planar") is not None
    assert _rest(one.model_copy(update={"target": None}), "planar") is None
    assert _rest(SENSOR.model_copy(update={"target": None}), "planar") is not None
    assert _rest(SENSOR.model_copy(update={"elastomer": None}), "planar") is None


def test_coils_that_cannot_be_solved_at_rest_leave_no_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(models, "MAGNETICS", {"planar": lambda sensor, tolerance: Coils(sensor, tolerance, fails=True)})
    assert _rest(SENSOR, "planar") is None


def test_a_section_that_nobody_asked_for_holds_its_ends(coils: list[Coils]) -> None:
    for name, by_name, keys, ends, inside in (
        ("planar", False, {}, True, True), ("planar", True, {}, True, False), ("planar", False, {}, False, False),
        ("sheets", False, {}, True, False), ("planar", False, {"target": None}, True, False),
    ):
        model, choice = _built(
            SENSOR.model_copy(update=keys), (SENSOR, Choice(name, "", by_name=by_name)), 1e-2, ends=ends
        )
        assert isinstance(model, InSection) == inside and choice.name == name and coils[-1].tolerance == 1e-2


def test_what_was_left_out_or_changed_is_told_by_the_model(coils: list[Coils]) -> None:
    far = Omission("conductors.P", "far away", 1e-3)
    for left_out, notes in (((far,), ()), ((), ("sheets instead of planar",)), ((), ())):
        model, _ = _built(SENSOR, (SENSOR, Choice("sheets", "", notes=notes, left_out=left_out)), 1e-2)
        assert isinstance(model, AmongFar) == bool(left_out or notes)
        if isinstance(model, AmongFar):
            assert model.left_out == tuple(item.text for item in left_out) and model.notes == notes
            assert model.enough == pytest.approx(1e-10)


def test_poses_are_of_given_ones_loads_of_a_tolerance_of_their_own(coils: list[Coils]) -> None:
    """Tables of loads tell ends once; poses have them in their errors, by default at a thousandth."""
    model, choice = magnetic_model(SENSOR)
    assert isinstance(model, InSection) and choice.name == "planar" and coils[-1].tolerance == 1e-3
    model, choice = loaded_model(load_sensor("biorob2018", ["target.length=0.2", "elastomer.length=0.2"]))
    assert isinstance(model, Coils) and choice.name == "planar" and model.tolerance == pytest.approx(1e-3)
    assert isinstance(loaded_model(SENSOR, loads=[LOAD])[0], Coils) and coils[-1].tolerance == 1e-2


def test_far_metal_is_measured_where_the_target_is_known_to_be(coils: list[Coils]) -> None:
    """On flat boards, without a name, by a model of one per cent; a curved one has all of it solved."""
    scene = load_sensor("biorob2018", [PLATE])
    solved, choice = _chosen(scene, "auto", 1e-4, [REST], False)
    assert solved.conductors == () and choice.name == "planar" and len(choice.left_out) == 1 and choice.notes == ()
    assert all(each.tolerance == 1e-2 and each.sensor.conductors == () for each in coils)
    assert _chosen(scene, "planar", 1e-4, [REST], False)[0] is scene
    for changes in ({"substrate_radius": 0.02}, {"elastomer": None}):
        other = scene.model_copy(update=changes)
        assert _chosen(other, "auto", 1e-4, (), False)[0] is other


def test_the_change_asked_for_is_at_known_poses_or_at_rest() -> None:
    both = _shown_at(SENSOR, [REST, Pose(np.array([1e-4, 2e-4]), np.full(2, 1.9e-3))])
    assert both is not None and both.components.shape == (3, 6) and both.d_h.tolist() == [0.0, 1e-4, 2e-4]
    assert _shown_at(SENSOR, [LOAD]) == _shown_at(SENSOR, ()) == REST
    assert _shown_at(SENSOR.model_copy(update={"elastomer": None}), ()) is None


def test_another_kind_of_model_is_named() -> None:
    plain, near, flat = (Choice(name, f"why {name}") for name in ("planar", "sheets", "planar-fem"))
    said = "instead of planar, which the sensor takes without conductors; why"
    assert _changed(plain, near) == f"space instead of section: sheets {said} sheets"
    assert _changed(plain, flat) == f"planar-fem {said} planar-fem"


@pytest.mark.parametrize(("fails", "goal", "error", "magnetics"), [
    (False, Goal(np.array([[0.0, 50.0, 0.0, 0.0, 0.0, 0.0]]), 0.02), 0.05, 0.002), (True, None, 0.07, None),
    (False, Goal(np.array([[0.0, 50.0, 0.0, 0.0, 0.0, 0.0]]), 0.9), 0.05, 0.05), (False, None, 0.07, None),
])
def test_a_load_is_looked_at_by_what_a_coarse_model_shows(
    monkeypatch: pytest.MonkeyPatch, fails: bool, goal: Goal | None, error: float, magnetics: float | None
) -> None:
    """Its error is of the signals, of the pose where there are none; that of the coils grows with their tolerance."""
    rest = Equilibrium(LOAD, REST, Pose(0.0, 1e-3), np.zeros(0), REPORT)
    monkeypatch.setattr(models, "MECHANICS", {"block": lambda sensor, tolerance: (sensor, tolerance)})
    monkeypatch.setattr(models, "MAGNETICS", {"planar": lambda sensor, tolerance: Coils(sensor, tolerance, fails)})
    monkeypatch.setattr(models, "goal_of", lambda sensor, field, poses: field.impedance(poses[0], 1e6) and goal)
    monkeypatch.setattr(models, "look", lambda layer, load, tolerance, measure: Look(measure(rest), 1.0))
    found = _seen(SENSOR, Choice("block", ""), (SENSOR, "planar"), [LOAD], 0.1)
    assert found == Look(pytest.approx(error), 1.0, magnetics=None if magnetics is None else pytest.approx(magnetics))


def test_nothing_is_looked_at_of_many_loads_or_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(models, "look", lambda *_: pytest.fail("looked at"))
    choice, slender = Choice("block", ""), load_sensor("biorob2018", ["elastomer.thickness=0.1"])
    assert _seen(SENSOR, choice, (SENSOR, "planar"), [LOAD, Wrench()], 0.1) is None
    assert _seen(SENSOR, None, (SENSOR, "planar"), [LOAD], 0.1) is None
    assert _seen(slender, choice, (slender, "planar"), [LOAD], 0.1) is None
    monkeypatch.setattr(models, "look", lambda *_: None)
    assert _seen(SENSOR, choice, (SENSOR, "planar"), [LOAD], 0.1) is None
