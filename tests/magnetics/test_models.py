"""What each magnetic model holds and leaves out, and the answers of coils that only one of them has."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from common.infinite_plate import Layer, coil_change
from common.track_losses import track_spectrum

from sits_mech.chain.models import MAGNETICS, Why, choose_magnetics, magnetic_model
from sits_mech.description import Description, Question, total
from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.coils.loops import ring_inductance
from sits_mech.magnetics.models import MODELS
from sits_mech.magnetics.sheets import sheets
from sits_mech.notes import Omission, OmissionKind, Relative
from sits_mech.quantities import Impedance, Pose, SolveReport
from sits_mech.scene.sensor import Coil, Sensor, Target, load_sensor

MM, HERTZ = 1e-3, 3e6
K = OmissionKind
REST = Pose(0.0, 2 * MM)


def coil(name: str = "C", x: float = 0.0, y: float = 0.0) -> Coil:
    """Ten turns in one layer, 11.6 mm wide, at a place in millimetres."""
    return Coil(
        name=name, centre=(x * MM, y * MM), layers=1, turns=10, inner_diameter=4 * MM, track_width=0.2 * MM,
        track_gap=0.2 * MM, track_thickness=35e-6,
    )


def scene(*coils: Coil, target: Target | None = None) -> Sensor:
    """Coils and a target."""
    return Sensor(name="scene", frequency=HERTZ, coils=coils, target=target)


def steel(shape: str, size: float = 60) -> Target:
    """A plate of a size [mm]."""
    sides = {"diameter": size * MM} if shape == "disc" else {"width": size * MM, "length": size * MM}
    return Target(conductivity=5e6, relative_permeability=100.0, shape=shape, thickness=0.8 * MM, **sides)


def kinds(name: str, sensor: Sensor, **question: object) -> list[OmissionKind]:
    """Kinds of what a model leaves out."""
    return [item.kind for item in MAGNETICS[name].omissions(sensor, Question(**question))]  # type: ignore[arg-type]


def test_a_coil_alone_is_answered_in_henry() -> None:
    """By rings, of each other and of themselves, 0.8077 uH, less what uneven current takes; nothing is left out."""
    rings = coil_sections(coil())
    model, choice = magnetic_model(scene(coil()))
    found = model.impedance(REST, HERTZ)
    assert (choice.name, found.unit_L, found.report.left_out) == ("axisymmetric", "H", ())
    even = found.L[0, 0] - track_spectrum(coil(), [HERTZ]).shift[0]
    assert even == pytest.approx(0.8077e-6, abs=5e-11) and even > found.L[0, 0] + 4e-9
    assert even == pytest.approx(float(ring_inductance(rings).sum()), rel=1e-3)
    assert found.error_L0 is not None and 0.0 < found.error_L0[0, 0] < 1e-3 * even


def test_a_pair_is_the_same_along_x_and_y() -> None:
    """M/L = -1.67 % at 14 mm, whichever way it lies."""
    found = []
    for away in ((7.0, 0.0), (0.0, 7.0), (7.0 / math.sqrt(2.0), 7.0 / math.sqrt(2.0))):
        pair = scene(coil("A", *away), coil("B", *(-each for each in away)))
        model, _ = magnetic_model(pair)
        answer = model.impedance(REST, HERTZ)
        assert answer.unit_L == "H"
        found.append(answer.L)
    assert found[0][0, 1] / found[0][0, 0] == pytest.approx(-1.67e-2, abs=1e-4)
    for other in found[1:]:
        np.testing.assert_allclose(other, found[0], rtol=1e-9)


def test_a_steel_disc_far_larger_than_the_coil_is_a_plate() -> None:
    """-23.5 % of L0 by Dodd and Deeds, within its own error; a section knows no size of what it would leave out."""
    pose, sensor = Pose(0.0, 1 * MM), scene(coil(), target=steel("disc"))
    model, choice = magnetic_model(sensor, "auto", 1e-2, [pose])
    found = model.impedance(pose, HERTZ)
    assert choice.name == "axisymmetric-fem" and choice.why == Why.WITHIN and total(found.report.left_out) == 0.0
    plate = coil_change(coil_sections(coil()), 1 * MM, HERTZ, [Layer(5e6, 0.8 * MM, 100.0)])
    change = (found.L - found.L0)[0, 0]
    assert change / found.L0[0, 0] == pytest.approx(-0.2342, abs=1e-3)
    assert abs(change - float(plate.delta_L)) < 2.0 * found.error_L[0, 0] + 1e-3 * abs(change)
    assert found.report.estimated_error < 2e-2


@pytest.mark.parametrize("frequency", [1e3, 5e6])
def test_what_lies_far_from_the_coil_costs_little(frequency: float) -> None:
    """60 mm of copper take no more currents than 20 mm, and are an infinite plate, moved too: within stated errors."""
    def answer(size: float, d_h: float) -> Impedance:
        plate = steel("rectangle", size).model_copy(update={"conductivity": 5.8e7, "relative_permeability": 1.0})
        return sheets(scene(coil(), target=plate), 1e-1).impedance(Pose(d_h, 2 * MM), frequency)

    wide, moved = answer(60.0, 0.0), answer(60.0, 8 * MM)
    assert wide.report.unknowns <= answer(20.0, 0.0).report.unknowns
    exact = coil_change(coil_sections(coil()), 2 * MM, frequency, [Layer(5.8e7, 0.8 * MM)])
    for found in (wide, moved):
        assert np.abs(found.L - found.L0 - exact.delta_L) < found.error_L < 5e-2 * np.abs(exact.delta_L)
        assert np.abs(found.R - exact.R) < found.error_R < 0.15 * exact.R


def test_a_steel_rectangle_is_solved_in_space() -> None:
    """In henry, within an error; nothing that it leaves out is without a size."""
    pose, sensor = Pose(0.0, 1 * MM), scene(coil(), target=steel("rectangle", 12))
    model, choice = magnetic_model(sensor, "auto", 3e-2, [pose])
    found = model.impedance(pose, HERTZ)
    assert choice.name == "sheets" and found.unit_L == "H"
    assert not any(item.unbounded for item in found.report.left_out) and found.report.estimated_error < 3e-2


LONG_COIL = (
    'coils=[{name="C", shape="rectangle", centre=["0 mm", "0 mm"], layers=1, turns=10, inner_width="4 mm", '
    'inner_length="200 mm", track_width="0.2 mm", track_gap="0.2 mm", track_thickness="35 um"}]'
)
LONG_PLATE = 'target={material="copper", shape="rectangle", width="8 mm", length="200 mm", thickness="0.2 mm"}'


def test_ends_of_straight_tracks_have_a_size_beforehand() -> None:
    """(D + 2 g)/l of tracks or plate, whichever is shorter; of round coils none, nor without a place."""
    sensor = load_sensor("biorob2018", [LONG_COIL, LONG_PLATE])
    (coil_,) = sensor.coils

    def size(scene: Sensor, **question: object) -> float:
        (item,) = (each for each in MAGNETICS["planar"].omissions(scene, Question(**question))  # type: ignore[arg-type]
                   if each.kind == K.PLATE_ENDS)
        return item.size

    wide, straight = coil_.extent[0], 200 * MM
    assert size(sensor) == pytest.approx((wide + 4 * MM) / straight, rel=0.03)
    assert size(sensor, pose=Pose(0.0, 5 * MM)) == pytest.approx((wide + 10 * MM) / straight, rel=0.03)
    short = load_sensor("biorob2018", [LONG_COIL])
    assert size(short) == pytest.approx((wide + 4 * MM) / (8 * MM))
    assert math.isnan(size(load_sensor("biorob2018"), pose=REST))
    assert math.isnan(size(sensor.model_copy(update={"elastomer": None})))


def test_long_coils_under_a_long_plate_are_a_section_in_henry() -> None:
    """Cheaper than space and within the tolerance; below it space is taken. By name it is per metre."""
    sensor = load_sensor("biorob2018", [LONG_COIL, LONG_PLATE])
    choices = [choose_magnetics(sensor, "auto", [REST], tolerance)[1] for tolerance in (0.2, 1e-2)]
    assert [(choice.name, choice.why) for choice in choices] == [("planar", Why.WITHIN), ("sheets", Why.WITHIN)]
    assert [item.kind for item in choices[0].left_out] == [K.PLATE_ENDS, K.TRACKS] and choices[0].tolerance < 0.2
    whole, metre = (magnetic_model(sensor, name, 0.2, [REST])[0].impedance(REST, 1e6) for name in ("auto", "planar"))
    assert (whole.unit_L, metre.unit_L) == ("H", "H/m")
    share = [(each.L / each.L0)[0, 0] for each in (whole, metre)]
    assert 1.0 - share[0] == pytest.approx(1.0 - share[1], rel=2e-2)  # L0 has uneven current


@pytest.mark.slow
def test_the_error_of_a_section_holds_what_space_has() -> None:
    sensor = load_sensor("biorob2018", [LONG_COIL, LONG_PLATE])
    section, space = (magnetic_model(sensor, name, 0.1, [REST])[0].impedance(REST, 1e6) for name in ("auto", "sheets"))
    off = np.abs(section.L - section.L0 - (space.L - space.L0))
    assert np.all(off <= section.error_L + space.error_L)


def test_what_is_left_out_of_coils_alone() -> None:
    """Eddy currents are none; a section leaves out the coil's own ends, without a size; of henry nothing."""
    bare = load_sensor("biorob2018").model_copy(update={"target": None, "elastomer": None})
    for name in ("axisymmetric", "sheets"):
        items = MAGNETICS[name].omissions(bare, Question())
        assert K.NO_TARGET in [item.kind for item in items] and total(items) == 0.0
    (ends,) = (item for item in MAGNETICS["planar"].omissions(bare, Question()) if item.kind == K.PLATE_ENDS)
    assert ends.relative_to == Relative.FREE and ends.unbounded


@pytest.mark.parametrize("section", ["planar", "planar-fem"])
def test_parts_that_no_section_cuts_have_no_size(section: str) -> None:
    plate = (
        'conductors=[{name="aside", material="copper", shape="rectangle", centre=["0 mm", "30 mm", "0 mm"], '
        'width="2 mm", length="2 mm", thickness="0.5 mm"}]'
    )
    sensor = load_sensor("biorob2018", [plate])
    (item,) = (each for each in MAGNETICS[section].omissions(sensor, Question()) if each.kind == K.NOT_CUT)
    assert item.unbounded and item.known == {"name": "aside"} and K.NOT_CUT not in kinds("sheets", sensor)


def test_a_free_net_current_is_left_out_in_space() -> None:
    free = load_sensor("biorob2018", ['target.net_current="free"', 'target.planar_boundary_radius="0.1 m"'])
    assert K.RETURN_CURRENT in kinds("sheets", free) and K.RETURN_CURRENT not in kinds("planar", free)
    assert K.RETURN_CURRENT not in kinds("sheets", load_sensor("biorob2018"))


def test_idle_coils_are_no_error_and_have_a_size_by_an_answer() -> None:
    """None that is not known for shorted ones without an answer, nothing of open ones; of one coil no item."""
    shorted, open_ = load_sensor("biorob2018"), load_sensor("biorob2018", ['readout.idle_coil="open"'])
    (item,), (none,) = (
        [each for each in MAGNETICS["sheets"].omissions(sensor, Question()) if each.kind == K.IDLE]
        for sensor in (shorted, open_)
    )
    assert math.isnan(item.size) and not item.counts and item.known == {"open": False}
    assert none.size == 0.0 and none.known == {"open": True}
    assert K.IDLE not in kinds("axisymmetric", scene(coil()))


def test_rings_leave_out_the_pitch_of_spirals_alone() -> None:
    """Beforehand by the inductance that both have; also finite elements on the axis; not sheets."""
    turned = coil().model_copy(update={"winding": "spiral"})
    sensor = scene(turned, target=Target(material="copper", shape="disc", diameter=8 * MM, thickness=0.2 * MM))
    for name in ("axisymmetric", "axisymmetric-fem"):
        (item,) = (each for each in MAGNETICS[name].omissions(sensor, Question()) if each.kind == K.PITCH)
        assert 1e-5 < item.size < 3e-2 and item.counts
        assert K.PITCH not in kinds(name, sensor.model_copy(update={"coils": (coil(),)}))
    assert K.PITCH not in kinds("sheets", sensor) and K.AIR not in kinds("axisymmetric-fem", sensor)


def test_a_model_on_the_axis_holds_what_keeps_to_it() -> None:
    """Loads that sink or twist the disc under a coil in its middle; poses on the axis."""
    disc = Target(material="copper", shape="disc", diameter=8 * MM, thickness=0.2 * MM)
    middle, aside = (scene(coil("C", x), target=disc) for x in (0.0, 1.0))
    for name in ("axisymmetric", "axisymmetric-fem"):
        for sensor, question, held in (
            (middle, Question(moves=("d_v", "alpha_z")), True), (middle, Question(moves=("d_v", "d_h")), False),
            (aside, Question(moves=("d_v",)), False), (middle, Question(pose=REST), True), (aside, Question(), True),
            (aside, Question(pose=Pose(1 * MM, 2 * MM)), True), (aside, Question(pose=REST), False),
            (middle, Question(pose=Pose(0.0, 2 * MM, 1e-3)), False),
        ):
            assert (MAGNETICS[name].refusal(sensor, question) is None) == held


@pytest.mark.parametrize(("keys", "name", "said"), [
    (["target.relative_permeability=100"], "planar", "target.relative_permeability must be 1 for planar; got 100"),
    (['substrate_radius="20 mm"'], "sheets", "substrate_radius must be left out for sheets, of flat coils; got 20 mm"),
    ([], "axisymmetric", "coils must be one over coaxial discs for axisymmetric; got 2"),
    (["target={material=\"copper\", shape=\"outline\", points=[[-4e-3, -4e-3], [4e-3, -4e-3], [0.0, 4e-3]], "
      "thickness=2e-4}"], "planar-fem", "target.shape must be a rectangle or a disc for a section; got an outline"),
])
def test_a_refusal_names_the_input(keys: list[str], name: str, said: str) -> None:
    assert str(MAGNETICS[name].refusal(load_sensor("biorob2018", keys), Question())) == said


def test_models_that_hold_a_scene_are_made_and_no_others() -> None:
    """Of some thirty scenes: what a description says is what the model itself takes."""
    targets = (None, *(Target(material="copper", thickness=0.2 * MM, **sides) for sides in (
        {"shape": "disc", "diameter": 8 * MM}, {"shape": "rectangle", "width": 8 * MM, "length": 8 * MM},
        {"shape": "outline", "points": ((-4 * MM, -4 * MM), (4 * MM, -4 * MM), (0.0, 4 * MM))},
    )), steel("disc"), steel("rectangle"))
    coils = (coil(),), (coil("A", -7.0), coil("B", 7.0)), (coil("A", 0.0, -7.0), coil("B", 0.0, 7.0))
    for target, some in itertools.product(targets, coils):
        sensor = scene(*some, target=target)
        for model in MAGNETICS.values():
            if model.refusal(sensor, Question()) is None:
                model(sensor, 0.1)
            else:
                with pytest.raises(ValueError, match="must"):
                    model(sensor, 0.1)


def test_an_omission_of_a_report_is_a_value() -> None:
    """It is compared and copied like one."""
    report = replace(SolveReport("any", 0, 0, 0.0, 0.0, 0.0), left_out=(Omission(K.AIR),))
    assert report.left_out == (Omission(K.AIR),) and report.left_out[0].half == "magnetics"
    assert Omission(K.PAD_ENDS, 1.0, Relative.DISPLACEMENT).half == "mechanics"


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_finer_rungs_take_more(model: Description) -> None:
    """Down to any tolerance: unknowns, factorisations and seconds of an answer."""
    rungs = np.array(model.rungs)
    assert rungs[-1, 0] == 0.0 and np.all(np.diff(rungs[:, 0]) < 0.0) and np.all(np.diff(rungs[:, 1:3], axis=0) >= 0.0)
    assert np.all(np.diff(rungs[:, 3] + rungs[:, 4]) > 0.0)
