"""Choices: all descriptions are asked alike, the cheapest that is exact enough is taken, and advice is true."""

import itertools
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import EntryPoint

import numpy as np
import pytest

from sits_mech.chain import models
from sits_mech.chain.models import (
    MAGNETICS,
    MECHANICS,
    Candidate,
    Choice,
    Why,
    candidates,
    choose_magnetics,
    choose_mechanics,
    chosen,
    loaded_model,
    magnetic_model,
    magnetic_question,
    mechanical_model,
)
from sits_mech.chain.omitted.conductors import AmongFar
from sits_mech.chain.simulate import simulate
from sits_mech.description import Description, Question, Refusal, Rung
from sits_mech.magnetics.bars import PlanarBars
from sits_mech.magnetics.coils.tracks import Tracked
from sits_mech.magnetics.omitted.ends import Whole
from sits_mech.magnetics.pose_slopes import inner_model
from sits_mech.notes import Omission, OmissionKind
from sits_mech.quantities import POSE, Equilibrium, Impedance, Pose, SolveReport, Wrench
from sits_mech.scene.sensor import SceneError, load_sensor

from .stand_ins import BACKING, COAXIAL, LONG, Coils, coils_for_all

SENSOR = load_sensor("biorob2018")
LOAD, REST, BESIDE = Wrench(F_z=0.5), Pose(0.0, 2e-3), Pose(1e-4, 2e-3)
PRESSED, SHEARED = Wrench(F_z=1.0), Wrench(F_x=0.1)
SHEET = (BACKING[0].replace('"disc"', '"rectangle"').replace("diameter", 'width="18 mm", length'),)
METAL = (BACKING[0].replace("ferrite", "copper"),)
FREE = ('target.net_current="free"', 'target.planar_boundary_radius="0.1 m"')
STEEL = ("target.relative_permeability=100", "target.conductivity=7e6")
OUTLINE = (
    'target={shape="outline", points=[[-4e-3, -4e-3], [4e-3, -4e-3], [0.0, 4e-3]], thickness=2e-4, material="copper"}',
)
PILLARS = ('elastomer.shape="pillars"', 'elastomer.pitch="2.5 mm"', 'elastomer.diameter="1.5 mm"')
FLUSH = tuple(f"{part}.{side}=0.02" for part in ("target", "elastomer") for side in ("width", "length"))
ROUGH = ("elastomer.friction=0.5",)
CURVED = ('substrate_radius="20 mm"',)
PLATE = (
    'conductors=[{name="P", material="copper", shape="rectangle", centre=["500 mm", "0 mm", "0 mm"], width="2 mm", '
    'length="2 mm", thickness="0.5 mm"}]',
)


def described(
    name: str, *, cost: int = 1, least: float = 0.0, left_out: tuple[Omission, ...] = (),
    refusal: Refusal | None = None, model: object = None, share: float = 0.1,
) -> Description:
    """A model of one rung."""
    return Description(
        name, lambda *_: model, lambda *_: refusal, lambda *_: left_out, (Rung(0.0, cost, 1, 0.0, 0.0),), least,
        share=share,
    )


def known(*each: Description) -> Mapping[str, Description]:
    """Models by name."""
    return {model.name: model for model in each}


def size(value: float, **more: bool) -> tuple[Omission, ...]:
    """Something that is left out."""
    return (Omission(OmissionKind.STATED, value, **more),)  # type: ignore[arg-type]


@pytest.mark.parametrize(("each", "name", "why"), [
    ((described("dear", cost=9), described("cheap", cost=2)), "cheap", Why.WITHIN),
    ((described("cheap", least=0.1), described("dear", cost=9)), "dear", Why.WITHIN),
    ((described("cheap", left_out=size(0.1)), described("dear", cost=9)), "dear", Why.WITHIN),
    ((described("cheap", left_out=size(math.nan)), described("dear", cost=9, least=0.5)), "dear", Why.LEAST),
    ((described("cheap", left_out=size(0.3)), described("dear", cost=9, least=0.2)), "dear", Why.LEAST),
    ((described("cheap", left_out=size(math.nan)), described("dear", cost=9, left_out=size(math.nan))), "cheap",
     Why.LEAST),
    ((described("cheap", left_out=size(0.1, counts=False)), described("dear", cost=9)), "cheap", Why.WITHIN),
    ((described("cheap", refusal=Refusal("a", "b", "c")), described("dear", cost=9, left_out=size(math.nan))), "dear",
     Why.ONLY),
    *(((described("cheap", left_out=size(left)), described("dear", cost=9)), "cheap", Why.WITHIN)
      for left in (0.009, 0.001, 0.0037)),  # sums that round
])
def test_the_cheapest_within_the_tolerance_is_taken(each: Sequence[Description], name: str, why: Why) -> None:
    """Else the one with the least error, without a size the last of all; whatever their order."""
    for order in (each, each[::-1]):
        found = chosen("half", known(*order), SENSOR, Question(1e-2))
        assert (found.name, found.why, found.by_name) == (name, why, False)


def test_numerics_have_what_omissions_leave() -> None:
    """Of loads a share of that; where too little is left, what is asked is the tolerance."""
    each = known(*(
        described(name, left_out=size(left), least=1e-3) for name, left in (("some", 0.004), ("most", 0.0095))
    ))
    found = {one.model.name: one for one in candidates(each, SENSOR, Question(1e-2))}
    assert found["some"].tolerance == pytest.approx(0.006) and found["some"].error == pytest.approx(1e-2)
    assert found["most"].tolerance == 1e-2 and found["most"].error == pytest.approx(0.0195)
    loaded = {one.model.name: one for one in candidates(each, SENSOR, Question(1e-2), loaded=True)}
    assert loaded["some"].tolerance == pytest.approx(6e-4) and loaded["some"].error == pytest.approx(0.005)


def test_candidates_stand_by_their_cost_and_those_that_do_not_hold_last() -> None:
    each = known(described("no", refusal=Refusal("a", "b", "c")), described("dear", cost=9), described("cheap"))
    assert [one.model.name for one in candidates(each, SENSOR, Question())] == ["cheap", "dear", "no"]
    assert Candidate(each["no"], None).rank == (math.inf, math.inf)


def test_a_model_asked_for_is_taken_or_refused_with_those_that_hold() -> None:
    """However bad it is."""
    refusal = Refusal("part", "be so", "this")
    each = known(described("bad", left_out=size(math.nan)), described("no", refusal=refusal), described("good", cost=9))
    found = chosen("half", each, SENSOR, Question(), "bad")
    assert found.name == "bad" and found.by_name and found.left_out == size(math.nan)
    with pytest.raises(SceneError, match="half no: part must be so; got this; bad or good would$"):
        chosen("half", each, SENSOR, Question(), "no")
    with pytest.raises(SceneError, match="part must be so; got this; no other model would$"):
        chosen("half", known(each["no"]), SENSOR, Question(), "no")
    with pytest.raises(SceneError, match="half must have a model that holds the scene; got none: no: part must be so"):
        chosen("half", known(each["no"]), SENSOR, Question())
    with pytest.raises(SceneError, match=r"model \(half\) must be one of auto, bad, no, good; got \"nn\""):
        chosen("half", each, SENSOR, Question(), "nn")


SCENES = {
    "published": (), "long": LONG, "coaxial": COAXIAL, "disc": COAXIAL[1:], "backing": BACKING, "sheet": SHEET,
    "metal": METAL, "free": FREE, "steel": STEEL, "outline": OUTLINE, "pillars": PILLARS, "flush": FLUSH,
    "rough": ROUGH,
    "curved": CURVED, "coaxial backing": (*COAXIAL, *BACKING), "coaxial curved": (*COAXIAL, *CURVED),
    "outline among": (*OUTLINE, *METAL), "free among": (*FREE, *METAL), "steel among": (*STEEL, *SHEET),
}
LOADS = ((), (PRESSED,), (PRESSED, SHEARED), (Wrench(F_y=0.1),))
POSES = ((), (REST,), (REST, BESIDE), (Pose(0.0, 2e-3, d_y=1e-4),))


@pytest.mark.parametrize("scene", SCENES)
def test_all_advice_is_true(scene: str) -> None:
    """What a refusal says that would hold the scene does, and no other model; "no other" is none; auto says so too."""
    sensor = load_sensor("biorob2018", SCENES[scene])
    refused = 0
    for choose, every, known_ in (
        (lambda name, given: choose_mechanics(sensor, name, given), LOADS, MECHANICS),
        (lambda name, given: choose_magnetics(sensor, name, given, 0.1)[1], POSES, MAGNETICS),
        (lambda name, given: choose_magnetics(sensor, name, given, 0.1, loaded=True)[1], LOADS, MAGNETICS),
    ):
        for given in every:
            held, told = set(), list[set[str]]()
            for name in known_:
                try:
                    assert choose(name, given).name == name
                    held.add(name)
                except SceneError as error:
                    said, refused = str(error), refused + 1
                    assert "\n" not in said and re.search(r" must .*; got ", said)
                    advice = said.rpartition("; ")[2]
                    assert advice.endswith(" would")
                    told.append({*advice.removesuffix(" would").split(" or ")} - {"no other model"})
            assert all(each == held for each in told)
            if held:
                assert choose("auto", given).name in held
            else:
                with pytest.raises(SceneError, match="must have a model that holds the scene; got none: "):
                    choose("auto", given)
    assert refused > 0


@pytest.mark.parametrize(("keys", "given", "loaded", "name"), [
    (COAXIAL, [PRESSED], True, "axisymmetric"), (COAXIAL, [], True, "sheets"), (COAXIAL, [], False, "axisymmetric"),
    (COAXIAL, [PRESSED, SHEARED], True, "sheets"), (COAXIAL, [REST, BESIDE], False, "sheets"),
    (COAXIAL, [REST], False, "axisymmetric"), (COAXIAL[1:], [REST], False, "sheets"),
    ((*COAXIAL, 'coils.C.centre=["0.1 mm", "0 mm"]'), [PRESSED], True, "sheets"), (OUTLINE, [REST], False, "sheets"),
    ((*COAXIAL, *CURVED), [REST], False, "planar-fem"), ((), [PRESSED], True, "sheets"), ((), [REST], False, "sheets"),
    (LONG, [PRESSED], True, "sheets"), (FREE, [PRESSED], True, "planar"), (SHEET, [PRESSED], True, "sheets"),
    ((*COAXIAL, *BACKING), [REST], False, "axisymmetric-fem"),
    ((*COAXIAL, *BACKING), [REST, BESIDE], False, "sheets"), (BACKING, [REST], False, "sheets"),
    ((*FREE, *METAL), [], False, "planar-fem"), (STEEL, [REST], False, "sheets"),
    ((*SHEET, 'conductors.0.conductivity="1 MS/m"'), [REST], False, "sheets"), (METAL, [], False, "sheets"),
    ((), [Wrench(F_y=0.1)], True, "sheets"),
])
def test_the_magnetic_model_of_a_scene(
    keys: tuple[str, ...], given: list[Wrench] | list[Pose], loaded: bool, name: str
) -> None:
    """On an axis where nothing leaves it, in section where no other holds the metal; round coils have no section."""
    found = choose_magnetics(load_sensor("biorob2018", keys), "auto", given, 1e-2, loaded=loaded)[1]
    assert found.name == name and not found.by_name


@pytest.mark.parametrize(("keys", "load", "tolerance", "name"), [
    ((), PRESSED, 1e-2, "block"), ((), Wrench(F_z=1e-3), 1e-2, "linear"), (ROUGH, Wrench(F_z=1e-3), 1e-2, "block"),
    (LONG, Wrench(0.3, 1.0), 1e-2, "block"), (LONG, Wrench(0.3, 1.0), 0.04, "planar"), (LONG, PRESSED, 0.1, "linear"),
    ((), None, 1e-2, "block"),  # loads that are not known
    (OUTLINE, PRESSED, 0.1, "linear"), (PILLARS, Wrench(F_z=1e-6), 0.1, "block"),
    (("elastomer.length=0.2",), PRESSED, 0.1, "block"),  # a target twenty times shorter than its layer
])
def test_the_mechanical_model_of_a_scene(
    keys: tuple[str, ...], load: Wrench | None, tolerance: float, name: str
) -> None:
    """One compliance for small loads, plane strain where that is within the tolerance, else space."""
    loads = [] if load is None else [load]
    assert choose_mechanics(load_sensor("biorob2018", keys), "auto", loads, tolerance).name == name


def test_a_pad_needs_a_target_and_a_layer() -> None:
    for part in ("target", "elastomer"):
        with pytest.raises(SceneError, match=f"{part}: must be given for a force to move the target; it is missing"):
            choose_mechanics(SENSOR.model_copy(update={part: None}))


def test_a_choice_depends_on_counts_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever seconds a machine takes for the rungs, the same models are taken for the same reasons."""
    requests = [
        (load_sensor("biorob2018", keys), load, tolerance)
        for keys, load, tolerance in itertools.product(
            ((), LONG, COAXIAL, FLUSH), (PRESSED, Wrench(F_z=0.01)), (0.1, 1e-2)
        )
    ]

    def names() -> list[tuple[object, ...]]:
        found = []
        for sensor, load, tolerance in requests:
            both = choose_mechanics(sensor, "auto", [load], tolerance), choose_magnetics(
                sensor, "auto", [load], tolerance, loaded=True)[1]
            found += [(one.name, one.why, one.tolerance, [each.model.name for each in one.candidates]) for one in both]
        return found

    before = names()
    assert len({name for name, *_ in before}) >= 4
    for turn in (lambda k, value: 1e6 / (1.0 + value), lambda k, value: 1e3 * k, lambda k, value: 0.0):
        for half in ("MECHANICS", "MAGNETICS"):
            other = {}
            for k, (name, model) in enumerate(getattr(models, half).items()):
                rungs = tuple(rung._replace(once=turn(k, rung.once), each=turn(k, rung.each)) for rung in model.rungs)
                other[name] = replace(model, rungs=rungs)
            monkeypatch.setattr(models, half, other)
        assert names() == before


@dataclass(frozen=True)
class Stranger:
    """Where a load of F_z = 1 N presses by 10 um."""

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        report = SolveReport("stranger", 1, 1, 0.0, 1e-6, 0.0, stretch=1.1)
        return Equilibrium(wrench, Pose(0.0, 2e-3 - 1e-5 * wrench.F_z), Pose(0.0, 1e-11), np.zeros(0), report)


@dataclass(frozen=True)
class Seen:
    """L = 1 uH + 1e-4 H/m d_v."""

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        L = (1e-6 + 1e-4 * np.asarray(pose.d_v))[..., None, None] * np.eye(2)
        zero = 0.0 * L
        report = SolveReport("seen", 1, 1, 0.0, 1e-6, 0.0)
        return Impedance(frequency, L, zero, 2e-6 * np.eye(2), np.ones(2), 1e-14 + zero, zero, "H", report)


@pytest.mark.parametrize(("mechanics", "magnetics", "flags"), [
    ((), (), ("ok",)), (size(math.nan), (), ("not bounded",)), ((), size(math.nan), ("not bounded",)),
    (size(1e-3), (), ("ok",)), ((), size(1e-3), ("ok",)),
])
def test_models_of_other_packages_take_part(
    monkeypatch: pytest.MonkeyPatch, mechanics: tuple[Omission, ...], magnetics: tuple[Omission, ...],
    flags: tuple[str, ...],
) -> None:
    """Registered as entry points, cheapest and exact they are taken; alone where nothing is said to be better."""
    own = {
        "sits_mech.mechanics": described("stranger", model=Stranger(), left_out=mechanics),
        "sits_mech.magnetics": described("seen", model=Seen(), left_out=magnetics),
    }

    class Given(EntryPoint):
        def load(self) -> Description:
            return own[self.group]

    def given(half: str) -> list[EntryPoint]:
        group = f"sits_mech.{half}"
        return [Given(own[group].name, "nowhere:nothing", group)]

    monkeypatch.setattr(models, "plugged", given)
    for half, each in (("MECHANICS", models.MECHANICAL), ("MAGNETICS", models.MAGNETIC)):
        found = models._registered(each if flags == ("ok",) else (), half.lower())
        assert ("block" in found or "sheets" in found) == (flags == ("ok",))
        for module in ("models", "omitted.mechanical", "plans.aimed"):
            monkeypatch.setattr(f"sits_mech.chain.{module}.{half}", found, raising=False)
    answer = simulate(SENSOR, PRESSED)
    assert answer.equilibrium.pose.d_v == 2e-3 - 1e-5 and answer.impedance.report.model == "seen"
    assert answer.flags == flags
    listed = (*answer.equilibrium.report.left_out, *answer.impedance.report.left_out)
    assert tuple(item for item in listed if item.kind is not OmissionKind.BENDING) == (*mechanics, *magnetics)


def test_our_own_models_keep_their_names(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another package cannot replace one."""
    class Given(EntryPoint):
        def load(self) -> Description:
            return described("planar", model="theirs")

    monkeypatch.setattr(models, "plugged", lambda half: [Given("planar", "nowhere:nothing", f"sits_mech.{half}")])
    assert models._registered(models.MECHANICAL, "mechanics")["planar"] is MECHANICS["planar"]


def test_a_model_that_cannot_be_loaded_is_passed_by(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a warning that names it; the others stay."""
    broken = [EntryPoint("theirs", "nowhere:nothing", "sits_mech.mechanics")]
    monkeypatch.setattr(models, "plugged", lambda half: broken)
    with pytest.warns(UserWarning, match="mechanics theirs: nowhere:nothing cannot be loaded: No module named"):
        assert list(models._registered(models.MECHANICAL, "mechanics")) == [each.name for each in models.MECHANICAL]


def test_the_question_of_loads_knows_what_moves() -> None:
    """Pressed alone where that is symmetric, twisted with it, all in the plane, or all."""
    for loads, moves in (
        ([PRESSED], ("d_v",)), ([PRESSED, Wrench(M_z=1e-3)], ("d_v", "alpha_z")), ([PRESSED, SHEARED], POSE[:3]),
        ([], POSE[:3]), ([Wrench(F_y=0.1)], POSE),
    ):
        question = magnetic_question(SENSOR, 0.1, loads, loaded=True)
        assert question.moves == moves and question.loads == tuple(loads) and question.pose is None
    given = magnetic_question(SENSOR, 0.1, [REST, Pose(np.array([1e-4, 2e-4]), np.full(2, 1.9e-3))])
    assert given.moves is None and given.pose is not None and given.pose.d_h.tolist() == [0.0, 1e-4, 2e-4]
    assert magnetic_question(SENSOR, 0.1).pose is None


@pytest.fixture
def coils(monkeypatch: pytest.MonkeyPatch) -> list[Coils]:
    """The coils that were made, by whatever name."""
    made, every = coils_for_all(0.0)
    monkeypatch.setattr(models, "MAGNETICS", every)
    return made


def test_a_model_is_made_as_fine_as_its_choice_says(coils: list[Coils]) -> None:
    """By name of the tolerance, under loads of a share of it; else what omissions leave, of loads a share."""
    for make, options, tolerance in (
        (magnetic_model, ("sheets",), 1e-3), (magnetic_model, ("planar", 0.1), 0.1),
        (loaded_model, ("planar", 0.1), 1e-2), (loaded_model, ("sheets", 0.1), 0.1),
        (loaded_model, ("auto", 1e-2, [LOAD]), 1e-2),
    ):
        assert isinstance(make(SENSOR, *options)[1], Choice) and coils[-1].tolerance == pytest.approx(tolerance)


def test_a_model_that_leaves_something_out_holds_it(coils: list[Coils]) -> None:
    """Whole where something counts, whoever asked for it; else the model itself."""
    assert isinstance(magnetic_model(SENSOR, "planar", 0.1, [REST])[0], Whole)
    tracked = magnetic_model(SENSOR, "sheets", 0.1, [REST])[0]
    assert isinstance(tracked, Tracked) and isinstance(tracked.model, Coils)
    assert isinstance(magnetic_model(load_sensor("biorob2018", FREE), "sheets", 0.1)[0], Whole)


def test_a_section_that_nobody_asked_for_answers_in_henry(coils: list[Coils]) -> None:
    """Where coils have an inductance in henry: not by name, on a curve, or with a free net current."""
    for keys, name, absolute in (
        (STEEL, "planar-fem", False), ((*FREE, *METAL), "auto", False), (CURVED, "auto", False),
    ):
        magnetic_model(load_sensor("biorob2018", keys), name, 0.1, [REST])
        made = magnetic_model(load_sensor("biorob2018", keys), name, 0.1, [REST])[0]
        inner = inner_model(made)
        assert isinstance(inner, Coils) and inner.absolute == absolute


def test_far_metal_is_measured_where_the_target_is_known_to_be(coils: list[Coils]) -> None:
    """On flat boards, without a name, by a model of one per cent; a curved one has all of it solved."""
    scene = load_sensor("biorob2018", PLATE)
    solved, choice = choose_magnetics(scene, "auto", [REST], 1e-4)
    assert solved.conductors == () and choice.name == "sheets" and len(choice.left_out) == 1
    assert all(each.tolerance == 1e-2 and each.sensor.conductors == () for each in coils)
    assert choose_magnetics(scene, "planar", [REST], 1e-4)[0] is scene
    for changes in ({"substrate_radius": 0.02}, {"elastomer": None}):
        other = scene.model_copy(update=changes)
        assert choose_magnetics(other, "auto", (), 1e-2)[0] is other
    made = magnetic_model(scene, "auto", 1e-2, [REST])[0]
    assert isinstance(made, AmongFar) and made.enough == pytest.approx(1e-10)


def test_by_name_a_section_is_per_metre() -> None:
    model = magnetic_model(SENSOR, "planar", 0.1, [REST])[0]
    inner = inner_model(model)
    assert isinstance(model, Whole) and isinstance(inner, PlanarBars) and not inner.absolute


def test_a_mechanical_model_has_its_own_errors() -> None:
    """What it leaves out is for the chain to add."""
    layer, choice = mechanical_model(load_sensor("biorob2018", FLUSH), "closed-form", 0.1, [Wrench(F_z=0.1)])
    found = layer.equilibrium(Wrench(F_z=0.1))
    assert choice.by_name and found.report.left_out == () and any(item.size > 1.0 for item in choice.left_out)
    assert found.report.estimated_error < 0.2
