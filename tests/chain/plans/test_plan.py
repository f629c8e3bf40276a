"""Plans: what is solved and why, what is left out, the error to expect, what finer answers would take."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sits_mech.chain.interpolate import solved_likely
from sits_mech.chain.models import MAGNETICS, MECHANICS, Candidate, Choice, Why, choose_magnetics, mechanical_model
from sits_mech.chain.plans import plan as planning
from sits_mech.chain.plans.goal import Goal
from sits_mech.chain.plans.plan import (
    PlannedHalf,
    _at_rest,
    _better,
    _forecast,
    _notes,
    _overhang,
    magnetic_omissions,
    plan,
)
from sits_mech.chain.plans.prices import MeshForecast
from sits_mech.chain.propagation import poses_of, read_poses
from sits_mech.description import Cost, Description, Question, Refusal
from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.modes import skin_depths
from sits_mech.mechanics.layer import planar_layer
from sits_mech.notes import Note, NoteKind, Omission, OmissionKind, Relative
from sits_mech.quantities import Bounded, Equilibrium, Pose, SolveReport, Wrench
from sits_mech.report.notes import sentence, sentences
from sits_mech.scene.sensor import load_sensor
from tests.chain.stand_ins import BACKING, COAXIAL, LONG, Coils, coils_for_all

K = OmissionKind
SENSOR, REST, LOAD = load_sensor("biorob2018"), Pose(0.0, 2e-3), Wrench(F_z=0.5)
OPEN = 'readout.idle_coil="open"'
REPORT = SolveReport("any", 1, 1, 0.0, 0.07, 0.0)
SEEN = Note.of(NoteKind.STATED, text="seen")
MANY = [Wrench(0.05 * x, 0.1 * z) for x in range(-2, 3) for z in range(7)]
SECTION = {"mechanics": "linear", "magnetics": "planar"}


def kinds(items: tuple[Omission, ...]) -> list[OmissionKind]:
    """Kinds of omissions."""
    return [item.kind for item in items]


@pytest.fixture
def not_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    """Plans of one load without its first meshes, and without coils solved at rest."""
    monkeypatch.setattr(planning, "_forecast", lambda *_: None)
    monkeypatch.setattr(planning, "_at_rest", lambda sensor, question, field: question)


@pytest.mark.slow
def test_five_scenes_have_five_plans() -> None:
    """No target, one coil under a disc, a symmetric load, ferrite behind the coils, thin and thick skin."""
    bare = SENSOR.model_copy(update={"target": None})
    requests = [
        (bare, []), (load_sensor("biorob2018", COAXIAL), []), (SENSOR, [Wrench(0.0, 2.0)]),
        (load_sensor("biorob2018", BACKING), []), (SENSOR, [Wrench(0.5, 2.0)]),
    ]
    plans = [plan(scene, loads) for scene, loads in requests]
    told = [(found.mechanics, found.magnetics, found.left_out) for found in plans]
    assert len({str(item) for item in told}) == 5
    names = ["axisymmetric", "axisymmetric", "sheets", "sheets", "sheets"]
    assert [found.magnetics.name for found in plans] == names
    whats = [set(kinds(found.left_out)) for found in plans]
    assert K.NO_TARGET in whats[0] and K.SYMMETRY in whats[2] and K.TRACKS in whats[3] and K.POSE_GIVEN in whats[1]
    assert skin_depths(SENSOR) > 6.0 > 1.0 > skin_depths(load_sensor("biorob2018", ["frequency=5e3"]))
    assert all(found.seconds > 0.0 and found.error > 0.0 for found in plans)
    assert not any(found.unbounded for found in plans)


def test_a_plan_without_loads_is_of_given_poses(not_looked_at: None) -> None:
    """Nothing is solved of the mechanics; its error is that of the coils' model and of what that leaves out."""
    found = plan(SENSOR)
    assert found.mechanics is None and [step.half for step in found.steps] == ["magnetics"]
    assert found.magnetics.name == "sheets" and found.error == pytest.approx(1e-2) and found.unbounded == ()
    assert kinds(found.left_out)[0] == K.POSE_GIVEN and found.rungs == ("sheets at 0.01",)
    assert [step.tolerance for step in found.finer] == [5e-3, 2e-3]


def test_a_section_has_its_ends_in_the_error_to_expect() -> None:
    """Measured at rest; space is first among what is finer, and the section's own rungs gain next to nothing."""
    found = plan(SENSOR, magnetics="planar")
    ends, tracks = (item.size for item in found.left_out if item.kind in (K.PLATE_ENDS, K.TRACKS))
    assert 0.3 < ends < 0.4 and 0.015 < tracks < 0.025 and found.unbounded == ()
    assert found.error == pytest.approx(ends + tracks + found.steps[0].error)
    space, *rungs = found.finer
    assert space.model == "sheets" and space.whole == pytest.approx(1e-2, rel=1e-9)
    assert [step.model for step in rungs] == ["planar", "planar"]
    assert all(found.error - 1e-2 < step.whole < found.error for step in rungs)


@pytest.mark.slow
def test_plane_strain_of_a_pad_is_in_the_error_to_expect() -> None:
    """Pressed 8.12 um where the pad in space is pressed 34.97: 3.3 displacements, no less beforehand; in space none."""
    found = plan(SENSOR, [Wrench(F_z=0.3)], mechanics="planar")
    (ends,) = (item for item in found.left_out if item.kind == K.PAD_ENDS)
    assert 34.97 / 8.12 - 1.0 < ends.size < 1.3 * (34.97 / 8.12 - 1.0) and ends.counts and found.error > ends.size
    block = next(step for step in found.finer if step.model == "block")
    assert block.whole < 0.1


def test_what_has_no_size_is_named() -> None:
    """Where no pose is known; no sum hides it. Steel is solved in space, and has none."""
    steel = load_sensor("biorob2018", ["target.relative_permeability=100", "target.conductivity=7e6"])
    found = plan(steel)
    assert found.unbounded == () and math.isfinite(found.error)
    bare = plan(SENSOR.model_copy(update={"elastomer": None}), magnetics="planar")
    assert found.magnetics.name == "sheets" and kinds(bare.unbounded) == [K.PLATE_ENDS]


@pytest.mark.usefixtures("not_looked_at")
def test_a_grid_is_planned_by_what_is_solved_of_it() -> None:
    """Of 9 x 9 loads some 19, of which mirror images leave 12; a small grid, or loads on no grid, are solved whole."""
    forces = np.linspace(-1.0, 1.0, 9).tolist()
    loads = [Wrench(x, z + 1.0) for x in forces for z in forces]
    whole, some = plan(SENSOR, loads), plan(SENSOR, [load for load in loads if load.F_x in forces[::4]])
    assert len(solved_likely(loads)) == 19 and len(solved_likely(loads[1:])) == 80
    (between,) = (item for item in whole.left_out if item.kind == K.BETWEEN)
    assert between.known == {"solved": 19, "all": 81} and between.size == 1e-2 and between.included
    assert K.BETWEEN not in kinds(some.left_out)

    def seconds(pads: int, poses: int) -> float:
        parts = (MECHANICS["block"], pads), (MAGNETICS["sheets"], poses)
        return sum(model.cost(Question(1e-2, (Wrench(),) * count)).seconds for model, count in parts)

    assert whole.seconds == pytest.approx(seconds(12, 81)) and some.seconds == pytest.approx(seconds(18, 27))


@pytest.mark.usefixtures("not_looked_at")
def test_steps_follow_the_tolerance() -> None:
    """The rung asked for and two finer ones of each half; of loads a share of the tolerance for the coils."""
    found = plan(SENSOR, [Wrench(0.5, 1.0)], mechanics="block", magnetics="planar")
    assert [step.half for step in found.steps] == ["mechanics", "magnetics"]
    assert [step.tolerance for step in found.steps] == [1e-2, pytest.approx(1e-3)]
    own = [step for step in found.finer if step.model == "block"]
    assert [step.tolerance for step in own] == [1e-3, MECHANICS["block"].least]
    assert all(step.whole < found.error for step in found.finer)
    assert found.rungs == ("block at 0.01", "planar at 0.001")


@pytest.mark.usefixtures("not_looked_at")
def test_nothing_is_finer_than_the_finest() -> None:
    """A tolerance below all rungs is not reached, and the error to expect says so."""
    found = plan(SENSOR, [Wrench(0.5, 1.0)], tolerance=1e-9, mechanics="block", magnetics="sheets")
    assert found.error >= MECHANICS["block"].least + MAGNETICS["sheets"].least
    assert not any(step.model in ("block", "sheets") for step in found.finer)


@pytest.mark.usefixtures("not_looked_at")
def test_conductors_cost_where_they_are_solved_in_space() -> None:
    """A plate in space costs its time, of any outline more; one far away nothing."""
    plate = 'conductors=[{name="P", material="%s", centre=["0 mm", "%s mm"], thickness="0.5 mm", %s}]'
    square = 'shape="rectangle", width="18 mm", length="18 mm"'
    drawn = 'shape="outline", points=[[-4e-3, -4e-3], [4e-3, -4e-3], [0.0, 4e-3]]'
    bare, space, outline = (
        plan(load_sensor("biorob2018", keys))
        for keys in ([], [plate % ("ferrite", "-1", square)], [plate % ("copper", "-1", drawn)])
    )
    assert [found.magnetics.name for found in (space, outline)] == ["sheets", "sheets"]
    assert space.seconds == pytest.approx(bare.seconds + 1.0)
    assert outline.seconds == pytest.approx(bare.seconds + 16.0)


@pytest.mark.slow
def test_a_far_conductor_costs_nothing() -> None:
    nut = 'conductors=[{name="nut", material="copper", shape="rectangle", centre=["0 mm", "-3 mm"], width="2 mm", '
    near = load_sensor("biorob2018", [nut + 'length="2 mm", thickness="0.5 mm"}]'])
    far = near.model_copy(update={"conductors": (near.conductors[0].model_copy(update={"centre": (0.3, 0.0, 0.0)}),)})
    bare, some, more = (plan(sensor, [Wrench(0.3, 1.0)]) for sensor in (SENSOR, far, near))
    assert bare.seconds == some.seconds < more.seconds - 0.5
    assert kinds(some.left_out).count(K.FAR) == 1 and K.FAR not in kinds(more.left_out)


@pytest.mark.parametrize(("magnetics", "error"), [(None, 1e-2), (3e-3, 3e-3)])
def test_what_was_seen_of_a_load_replaces_what_is_usual(
    monkeypatch: pytest.MonkeyPatch, magnetics: float | None, error: float
) -> None:
    """Its error and seconds, of its half; no finer rungs of it are offered, and its notes come first."""
    monkeypatch.setattr(planning, "_at_rest", lambda sensor, question, field: question)
    monkeypatch.setattr(planning, "_forecast", lambda *_: MeshForecast(0.07, 9.0, (SEEN,), magnetics))
    found = plan(SENSOR, MANY[-1:], tolerance=0.1, **SECTION)
    mechanics, other = found.steps
    assert (mechanics.error, mechanics.seconds, other.error) == (0.07, 9.0, pytest.approx(error))
    assert found.notes[0] == SEEN and not any(step.model == "linear" for step in found.finer)


@pytest.mark.usefixtures("not_looked_at")
def test_the_error_to_expect_is_of_steps_and_of_what_counts() -> None:
    """Thirty-five loads: images and those between are left out; idle coils do not count."""
    found = plan(SENSOR, MANY, tolerance=0.1, **SECTION)
    sizes = sum(item.size for item in found.left_out if item.counts and item.size > 0.0)
    assert found.error == pytest.approx(sizes + sum(step.error for step in found.steps)) and sizes > 0.1
    (between,) = (item for item in found.left_out if item.kind == K.BETWEEN)
    assert between.known == {"solved": len(solved_likely(MANY)), "all": 35}
    assert K.IDLE in kinds(found.left_out) and kinds(found.unbounded) == [K.PLATE_ENDS]


def test_other_models_are_offered_with_the_whole_error() -> None:
    """Without the step of their half and what that leaves out, with their own and the other half's."""
    cheap, better = (Description(name, "", lambda *_: None, lambda *_: (), MAGNETICS["planar"].rungs, 0.0)
                     for name in ("cheap", "better"))
    cost = cheap.cost(Question(0.1))
    candidates = tuple(
        candidate(model, error, price)
        for model, error, price in (
            (cheap, 0.5, cost), (better, 0.02, cost), (replace(cheap, name="no"), math.nan, None),
        )
    )
    own, other = PlannedHalf("magnetics", "cheap", 0.1, 0.1, 1.0), PlannedHalf("mechanics", "pad", 0.1, 0.1, 1.0)
    field, layer = Choice("cheap", Why.NAMED, candidates), Choice("pad")
    ends = Omission(K.PLATE_ENDS, 0.4), Omission(K.PAD_ENDS, 0.3, Relative.DISPLACEMENT)
    counted = [*ends, Omission(K.NOT_CUT, math.nan)]
    (found,) = _better((layer, field), [(other, []), (own, [])], counted, 0.9)
    assert (found.half, found.model, found.error) == ("magnetics", "better", 0.02)
    assert found.whole == pytest.approx(0.1 + 0.3 + 0.02)


def candidate(model: Description, error: float, cost: Cost | None) -> Candidate:
    """What a model would be."""
    return Candidate(model, None if cost else Refusal("a", "b", "c"), 0.01, error, (), cost)


@pytest.fixture
def coils(monkeypatch: pytest.MonkeyPatch) -> list[Coils]:
    """The coils that were made, by whatever name."""
    made, every = coils_for_all(0.07)
    monkeypatch.setattr(planning, "MAGNETICS", every)
    return made


PLATE = (
    'conductors=[{name="P", material="copper", shape="rectangle", centre=["500 mm", "0 mm", "0 mm"], width="2 mm", '
    'length="2 mm", thickness="0.5 mm"}]'
)


@pytest.mark.parametrize(("keys", "left_out", "name", "needed"), [
    ([], (), "sheets", True), ([OPEN], (), "sheets", False), ([PLATE], (), "planar-fem", True),
    ([OPEN], (Omission(K.PLATE_ENDS, math.nan),), "planar", True), ([PLATE], (), "sheets", False),
    ([OPEN], (Omission(K.PITCH, 0.1),), "sheets", True),
])
def test_a_coarse_answer_at_rest_is_for_sizes_that_need_it(
    coils: list[Coils], keys: list[str], left_out: tuple[Omission, ...], name: str, needed: bool
) -> None:
    """Shorted coils beside, and what is left out, do; in space among other metal it would take seconds."""
    question = Question(0.1)
    found = _at_rest(load_sensor("biorob2018", keys), question, Choice(name, left_out=left_out))
    assert (found.answer is not None) == needed == bool(coils) and (found == question) == (not needed)
    if found.answer is not None:
        assert found.answer[0] == REST and coils[0].tolerance == 0.1 and not found.closely


def test_without_a_place_or_an_answer_sizes_are_those_beforehand(monkeypatch: pytest.MonkeyPatch) -> None:
    failing = replace(MAGNETICS["planar"], factory=lambda *given: Coils(*given, fails=True, error=0.07))
    fails = {"planar": failing}
    monkeypatch.setattr(planning, "MAGNETICS", fails)
    for sensor in (SENSOR, SENSOR.model_copy(update={"elastomer": None})):
        assert _at_rest(sensor, Question(0.1), Choice("planar")).answer is None


@pytest.mark.parametrize(("fails", "goal", "error", "magnetics"), [
    (False, Goal(np.array([[0.0, 50.0, 0.0, 0.0, 0.0, 0.0]]), 0.02), 0.05, 0.002), (True, None, 0.07, None),
    (False, Goal(np.array([[0.0, 50.0, 0.0, 0.0, 0.0, 0.0]]), 0.9), 0.05, 0.05), (False, None, 0.07, None),
])
def test_a_load_is_looked_at_by_what_a_coarse_model_shows(
    monkeypatch: pytest.MonkeyPatch, fails: bool, goal: Goal | None, error: float, magnetics: float | None
) -> None:
    """Its error is of the signals, of the pose where there are none; that of the coils grows with their tolerance."""
    rest = Equilibrium(LOAD, REST, Pose(0.0, 1e-3), np.zeros(0), REPORT)
    field = replace(MAGNETICS["planar"], factory=lambda sensor, tolerance: Coils(sensor, tolerance, fails, error=0.07))
    monkeypatch.setattr(planning, "MECHANICS", {"block": lambda sensor, tolerance: (sensor, tolerance)})
    monkeypatch.setattr(planning, "MAGNETICS", {"planar": field})
    monkeypatch.setattr(planning, "goal_of", lambda sensor, field, poses: field.impedance(poses[0], 1e6) and goal)
    monkeypatch.setattr(planning, "first_rest", lambda *_: rest)
    monkeypatch.setattr(planning, "predicted", lambda report, off, asked: MeshForecast(off, 1.0))
    found = _forecast(SENSOR, Choice("block"), (SENSOR, "planar"), [LOAD], 0.1)
    assert found == MeshForecast(pytest.approx(error), 1.0, magnetics=magnetics and pytest.approx(magnetics))


def test_nothing_is_looked_at_of_many_loads_or_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planning, "first_rest", lambda *_: pytest.fail("looked at"))
    choice, slender = Choice("block"), load_sensor("biorob2018", ["elastomer.thickness=0.1"])
    assert _forecast(SENSOR, choice, (SENSOR, "planar"), [LOAD, Wrench()], 0.1) is None
    assert _forecast(SENSOR, None, (SENSOR, "planar"), [LOAD], 0.1) is None
    assert _forecast(slender, choice, (slender, "planar"), [LOAD], 0.1) is None
    monkeypatch.setattr(planning, "first_rest", lambda *_: None)
    assert _forecast(SENSOR, choice, (SENSOR, "planar"), [LOAD], 0.1) is None


def test_omissions_are_those_of_both_halves_and_of_far_conductors() -> None:
    """Of the coils alone where a pose is given; sizes by an answer where there is one."""
    far = Omission(K.FAR, 1e-3, bound=True, numbers=(("name", "P"),))
    field = choose_magnetics(SENSOR, "planar", [LOAD], loaded=True)[1]
    both = plan(SENSOR, [LOAD], mechanics="linear", magnetics="planar").left_out
    assert kinds(both)[0] == K.FINITE_STRAIN and K.PLATE_ENDS in kinds(both)
    assert magnetic_omissions(SENSOR, replace(field, left_out=(*field.left_out, far)), [LOAD])[-1] == far
    (ends,) = (item for item in magnetic_omissions(SENSOR, field) if item.kind == K.PLATE_ENDS)
    assert kinds(plan(SENSOR, magnetics="planar").left_out)[0] == K.POSE_GIVEN and ends.unbounded
    found = planar_bars(SENSOR, 1e-2).impedance(REST, SENSOR.frequency)
    seen = magnetic_omissions(SENSOR, field, (), (REST, found))
    assert next(item.size for item in seen if item.kind == K.PLATE_ENDS) == pytest.approx(0.357, abs=0.01)


@pytest.mark.slow
def test_a_plan_promises_no_more_than_there_is() -> None:
    """Not below the finest rungs; loads beyond what pads have held, and slips of unit, are named."""
    fine = plan(SENSOR, [Wrench(0.1, 0.5)], tolerance=1e-9)
    assert fine.error >= MECHANICS["block"].least
    assert len(fine.notes) == 1 and "the tolerance 1e-09 cannot be reached at this load" in sentence(fine.notes[0])
    assert "a large load for this pad" in sentence(plan(SENSOR, [Wrench(0.0, 400.0)]).notes[0])
    assert "a large load for this pad" in sentence(plan(SENSOR, [Wrench(F_y=30.0)]).notes[0])
    material = 'elastomer.material={law="neo-hookean", shear_modulus="30 GPa", bulk_modulus="30 TPa"}'
    glassy = load_sensor("biorob2018", [material])
    assert "unit" in sentence(plan(glassy, [Wrench(0.1, 0.5)]).notes[0])


def test_large_loads_are_told_where_no_solve_has_seen_them() -> None:
    """Small strain off by 0.35, 0.47 and, of a slender layer, by no number."""
    small, large = [Wrench(F_z=1.0)], [Wrench(F_z=1.3)]
    forecast = MeshForecast(0.1, 1.0)
    assert _notes(SENSOR, small, None) == _notes(SENSOR, [], None) == _notes(SENSOR, large, forecast) == ()
    (note,) = _notes(SENSOR, large, None)
    assert note.kind is NoteKind.LARGE_LOAD and note.known == {"bound": pytest.approx(0.473, abs=1e-3), "held": 0.4}
    slender = load_sensor("biorob2018", ["elastomer.thickness=0.1"])
    assert _notes(slender, large, None) == () and _notes(SENSOR.model_copy(update={"elastomer": None}), [], None) == ()


def test_what_reaches_over_the_elastomer_is_measured_on_each_side() -> None:
    flush, wide, long = (load_sensor("biorob2018", [size]) for size in (
        'target.width="20 mm"', 'target.width="26 mm"', 'target.length="30 mm"',
    ))
    assert _overhang(flush) == _overhang(flush.model_copy(update={"target": None})) == ()
    assert _overhang(wide.model_copy(update={"elastomer": None})) == ()
    assert [_overhang(one)[0].known["over"] for one in (wide, long)] == [pytest.approx(3e-3), pytest.approx(5e-3)]


@pytest.mark.slow
def test_a_target_wider_than_its_elastomer_says_what_reaches_over() -> None:
    """Of the layer's answer it is no part, of the coils' it is; a target within its elastomer says nothing."""
    flush, wide = (load_sensor("biorob2018", [f'target.width="{width} mm"']) for width in (20, 26))
    told = [sentences(plan(one).notes) for one in (flush, wide)]
    said = [any("reaches 3 mm over its elastomer" in words for words in each) for each in told]
    assert said == [False, True] and not plan(SENSOR).notes
    rests = [planar_layer(one, 0.1).equilibrium(Wrench(0.2, 1.0)).pose for one in (flush, wide)]
    np.testing.assert_allclose(rests[0].components, rests[1].components, rtol=1e-9, atol=1e-15)
    L = [planar_bars(one, 1e-2).impedance(rests[0], one.frequency).L[0, 0] for one in (flush, wide)]
    assert L[1] < L[0]


def test_a_symmetric_load_needs_no_places_beside() -> None:
    """The same answer with and without them, from fewer poses."""
    sensor = load_sensor("biorob2018", LONG)
    poses = poses_of([mechanical_model(sensor, "linear", 3e-2)[0].equilibrium(Wrench(0.0, 1.0))])
    few, more = (
        read_poses(sensor, planar_bars(sensor, 1e-2), Bounded.of(poses.value, np.array([error])))
        for error in ([0.0, 1e-6, 0.0, 0.0, 0.0, 0.0], [1e-11, 1e-6, 1e-11, 0.0, 0.0, 0.0])
    )
    assert len(few.alone) == 1 and len(more.alone) == 3
    assert few.signals.L_v_percent == pytest.approx(more.signals.L_v_percent, rel=1e-12)
    assert few.signals.error_L_v_percent == pytest.approx(more.signals.error_L_v_percent, rel=1e-6)
