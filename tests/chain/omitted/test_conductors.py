"""Conductors near the sensor: far ones are left out by a bound, near ones solved, and in the errors."""

import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest

from sits_mech.analysis.cycle import load_cycle, triangle
from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.models import choose_magnetics, loaded_model, magnetic_model
from sits_mech.chain.omitted import conductors
from sits_mech.chain.omitted.conductors import AmongFar, _shares, _small_together, negligible, without_far
from sits_mech.chain.plans.plan import plan
from sits_mech.chain.simulate import simulate
from sits_mech.magnetics.bars import planar_bars
from sits_mech.notes import Omission, OmissionKind, unpacked_omissions
from sits_mech.quantities import Impedance, Pose, SolveReport, Wrench
from sits_mech.report.left_out import line
from sits_mech.report.tables.loads import remarks
from sits_mech.scene.sensor import Conductor, Sensor, load_sensor

MM = 1e-3
REST = Pose(0.0, 2 * MM)
LOAD = Wrench(0.3, 1.0)
SENSOR = load_sensor("biorob2018")
ROUND = (
    'coils=[{name="C", centre=["0 mm", "0 mm"], layers=2, turns=12, inner_diameter="2.2 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}]',
    'target={material="copper", shape="disc", diameter="8 mm", thickness="0.2 mm"}',
)


def nut(x: float, z: float, material: str = "copper", name: str = "nut") -> Conductor:
    """A plate of 2 x 2 x 0.5 mm, at places in millimetres."""
    return Conductor(
        name=name, material=material, shape="rectangle", centre=(x * MM, 0.0, z * MM), width=2 * MM, length=2 * MM,
        thickness=0.5 * MM,
    )


def steel(x: float, z: float) -> Conductor:
    """The same of steel: permeable, and it conducts."""
    metal = {"material": None, "conductivity": 7e6, "relative_permeability": 100.0}
    return nut(x, z).model_copy(update=metal)


def far_of(items: Sequence[Omission]) -> list[Omission]:
    """Conductors among what is left out."""
    return [item for item in items if item.kind == OmissionKind.FAR]


def among(*parts: Conductor, sensor: Sensor = SENSOR) -> Sensor:
    """The published sensor with plates around."""
    return sensor.model_copy(update={"conductors": parts})


def test_a_nut_half_a_metre_away_is_left_out_by_name() -> None:
    """The bare sensor's numbers to the last digit, the bound in the error and in the plan, no other model."""
    bare, far = (magnetic_model(sensor, "auto", 0.1, [REST]) for sensor in (SENSOR, among(nut(500.0, -500.0))))
    assert (bare[1].name, bare[1].why) == (far[1].name, far[1].why) and far_of(bare[1].left_out) == []
    one, two = (model.impedance(REST, 5e6) for model, _ in (bare, far))
    np.testing.assert_array_equal(one.L, two.L)
    assert np.all(two.error_L > one.error_L) and np.all(two.error_L < 1.001 * one.error_L)
    (item,) = far_of(two.report.left_out)
    assert item.known["name"] == "nut" and item.bound and "nut is far away, at (500, 0, -500) mm (at most" in line(item)
    made, other = (plan(scene, [LOAD], tolerance=0.1) for scene in (among(nut(500.0, -500.0)), SENSOR))
    assert (made.magnetics.name, made.notes) == (other.magnetics.name, ())
    (item,) = far_of(made.left_out)
    assert 0.0 < item.size < 1e-6 and item.half == "magnetics" and item.counts and made.error > other.error - 1e-12


@pytest.mark.slow
def test_the_chain_with_a_nut_far_away_and_close_by() -> None:
    """Far: the bare sensor's signals. Close by: what sheets say where they are asked for; both in space."""
    bare, far = simulate(SENSOR, LOAD), simulate(among(nut(500.0, -500.0)), LOAD)
    assert bare.signals.L_v_percent == far.signals.L_v_percent and bare.signals.L_h_percent == far.signals.L_h_percent
    for x, z in ((14.0, -1.0), (10.0, -1.0)):
        near, asked = (simulate(among(nut(x, z)), LOAD, magnetics=name) for name in ("auto", "sheets"))
        assert near.impedance.report.model == "sheets" and near.impedance.unit_L == "H"
        assert abs(near.signals.L_v_percent - asked.signals.L_v_percent) < asked.signals.error_L_v_percent


def test_what_is_left_out_is_worth_less_than_its_bound() -> None:
    """The same nut by the same model, asked for; and its bound is below what was asked."""
    sensor = among(nut(30.0, -3.0))
    alone, (item,) = without_far(sensor, lambda scene: planar_bars(scene, 1e-2), REST, 1e-2, section=True)
    assert alone.conductors == () and 0.0 < item.size < 5e-3
    solved, bare = (planar_bars(scene, 1e-2).impedance(REST, 5e6) for scene in (sensor, SENSOR))
    found = AmongFar(planar_bars(alone, 1e-2), sensor, alone, True).impedance(REST, 5e6)
    missed = np.abs(solved.L - found.L).max()
    assert missed < item.size * np.abs(bare.L - bare.L0).max()
    assert missed < (found.error_L - bare.error_L).max()
    assert np.all(found.error_R > bare.error_R)


@pytest.mark.slow
def test_a_near_nut_is_solved_in_space() -> None:
    """By a pose or a load, and nothing of it is left out."""
    for _, choice in (
        magnetic_model(among(nut(0.0, -3.0)), tolerance=1e-2, poses=[REST]),
        loaded_model(among(nut(0.0, -3.0)), loads=[LOAD]),
    ):
        assert choice.name == "sheets" and choice.left_out == ()


def test_steel_is_left_out_where_it_is_far_and_solved_where_it_is_near() -> None:
    """In space, with all forces."""
    near, far = among(steel(0.0, -3.0)), among(steel(60.0, -3.0))
    solved, choice = choose_magnetics(far, "auto", [REST], 1e-2)
    assert choice.name == "sheets" and solved.conductors == () and len(far_of(choice.left_out)) == 1
    solved, choice = choose_magnetics(near, "auto", [REST], 1e-2)
    assert choice.name == "sheets" and solved is near and not any(item.unbounded for item in choice.left_out)
    assert choose_magnetics(near, "auto", [Wrench(0.0, 1.0, F_y=0.1)], loaded=True)[1].name == "sheets"


@pytest.mark.slow
def test_a_calibration_says_what_is_left_out_of_conductors() -> None:
    """Among its remarks, from its attributes; the bound of the far one is in every error."""
    long = load_sensor("biorob2018", ['elastomer.length="400 mm"'])
    asked = {"F_x": [0.0], "F_z": [0.5], "mechanics": "linear", "tolerance": 0.1}
    data = calibrate(among(steel(0.0, -3.0), nut(300.0, 0.0, name="far"), sensor=long), **asked)
    assert json.loads(data.attrs["request"])["magnetics"] == "sheets"
    (item,) = far_of(unpacked_omissions(data.attrs["left_out"]))
    assert item.known["name"] == "far" and line(item) in "\n".join(remarks(data))
    assert str(data["status"][0, 0].item()) == "above tolerance"  # the pad's ends; the far one has a bound
    assert far_of(unpacked_omissions(calibrate(long, **asked).attrs["left_out"])) == []


def test_only_those_that_matter_are_solved() -> None:
    """One near, one far."""
    model, choice = magnetic_model(among(nut(0.0, -3.0), nut(500.0, 0.0, name="far")), "auto", 1e-2, [REST])
    assert [item.known["name"] for item in choice.left_out] == ["far"] and choice.name == "sheets"
    assert 0.0 < choice.left_out[0].size < 1e-4
    assert magnetic_model(among(nut(0.0, -3.0), nut(500.0, 0.0, name="far")), "sheets")[1].left_out == ()


def test_small_ones_are_small_together() -> None:
    """Ten of a third of the tolerance are not."""
    parts = [nut(0.0, -10.0 * (k + 1), name=f"n{k}") for k in range(10)]

    def shares(some):
        return np.array([0.3 + 0.001 * parts.index(part) for part in some])

    assert _small_together(parts, shares, 1.0) == parts[:3]
    assert _small_together(parts, shares, 0.1) == []


def test_without_a_change_to_compare_with_all_are_solved() -> None:
    """No target, or no place for it."""
    far = nut(500.0, 0.0)
    for changes in ({"target": None, "elastomer": None}, {"elastomer": None}):
        sensor = among(far).model_copy(update=changes)
        choice = magnetic_model(sensor, tolerance=0.1)[1]
        assert choice.left_out == () and choice.name == "sheets"
    high = Pose(0.0, 0.2)
    assert magnetic_model(among(nut(20.0, 0.0), sensor=SENSOR), "auto", 0.1, [high])[1].left_out == ()


def test_a_target_that_comes_near_to_what_was_left_out() -> None:
    """Beyond the poses that were known nothing bounds the nut: refused, by name."""
    model, choice = magnetic_model(among(nut(60.0, 4.0)), "auto", 0.1, [REST])
    assert choice.left_out != ()
    with pytest.raises(ValueError, match=r"must stay far from conductors\.nut, left out for that"):
        model.impedance(Pose(53 * MM, 4 * MM), 5e6)


@pytest.mark.parametrize(
    ("given", "loaded", "name"),
    [
        ([Wrench(0.0, 1.0)], True, "axisymmetric"), ([Wrench(0.0, 1.0, M_z=1e-4)], True, "axisymmetric"),
        ([Wrench(0.3, 1.0)], True, "sheets"), ([Wrench(0.0, 1.0, 1e-4)], True, "sheets"),
        ([Wrench(0.0, 1.0), Wrench(0.3, 1.0)], True, "sheets"), ([Wrench(0.0, 1.0, F_y=0.1)], True, "sheets"),
        ([], True, "sheets"), ([], False, "axisymmetric"), ([REST], False, "axisymmetric"),
        ([Pose(1 * MM, 2 * MM)], False, "sheets"), ([Pose(0.0, 2 * MM, 0.01)], False, "sheets"),
        ([Pose(0.0, 2 * MM, d_y=1 * MM)], False, "sheets"), ([Pose(0.0, 2 * MM, alpha_z=0.3)], False, "axisymmetric"),
        ([Pose(np.array([0.0, 1 * MM]), np.full(2, 2 * MM))], False, "sheets"),
    ],
)
def test_a_disc_over_one_coil_is_axisymmetric_on_its_axis_alone(given, loaded, name) -> None:
    """Pressed and turned about z it stays; under shear or tilt it takes sheets."""
    sensor = load_sensor("biorob2018", ROUND)
    model = loaded_model(sensor, loads=given) if loaded else magnetic_model(sensor, poses=given)
    assert model[1].name == name


def test_a_coil_beside_the_targets_axis_is_not_coaxial() -> None:
    """Pressed down, the disc is off it all the time; at a pose above it, not."""
    sensor = load_sensor("biorob2018", [*ROUND, 'coils.C.centre=["1 mm", "0 mm"]'])
    assert loaded_model(sensor, loads=[Wrench(0.0, 1.0)])[1].name == "sheets"
    assert magnetic_model(sensor, poses=[Pose(1 * MM, 2 * MM)])[1].name == "axisymmetric"


@pytest.mark.slow
def test_a_turned_disc_is_the_same_disc() -> None:
    """The pad sinks a little more when twisted; the coil sees where the disc is, not how it is turned."""
    sensor = load_sensor("biorob2018", ROUND)
    found = simulate(sensor, Wrench(0.0, 1.0, M_z=2e-4))
    pose = found.equilibrium.pose
    assert found.impedance.report.model == "axisymmetric" and pose.alpha_z > 0.01
    assert (pose.d_h, pose.d_y, pose.alpha, pose.alpha_x) == (0.0, 0.0, 0.0, 0.0)
    flat = magnetic_model(sensor, "axisymmetric", 1e-3)[0].impedance(Pose(0.0, pose.d_v), sensor.frequency)
    assert found.impedance.L[0, 0] == pytest.approx(flat.L[0, 0], rel=1e-12)
    data = load_cycle(sensor, Wrench(0.0, 0.5), triangle(1.0, 1), mechanics="linear")
    assert json.loads(data.attrs["request"])["magnetics"] == "axisymmetric"


def test_a_change_of_nothing_has_no_share_that_is_small() -> None:
    """A target too far to change anything: what is beside counts, and no division by zero is told of."""
    assert np.all(np.isinf(_shares(SENSOR, REST, np.zeros(1), False, [nut(500.0, 0.0)])))


AIR = Omission(OmissionKind.AIR)


@dataclass(frozen=True)
class Coils:
    """A model whose first coil changes by a tenth of L0 at the first pose, by a hundredth at the second."""

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        L0, none = np.diag([2e-6, 1e-6]), np.zeros((2, 2, 2))
        L = L0 - np.array([0.2e-6, 0.02e-6])[:, None, None] * np.diag([1.0, 0.0])
        report = SolveReport("coils", 0, 0, 0.0, 1e-3, 0.0, left_out=(AIR,))
        return Impedance(frequency, L, none, L0, np.zeros(2), none + 1e-9, none + 1e-3, "H", report)


def test_bounds_of_far_conductors_are_added_to_the_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two, summed, as shares of the larger L0; R's at the frequency asked for; the worst pose's share is told."""
    sensor = SENSOR.model_copy(update={"conductors": (nut(200.0, 0.0), nut(0.0, 200.0, name="other"))})
    shares = np.array([[1e-4, 2e-4], [1e-4, 1e-4]])
    monkeypatch.setattr(conductors, "remote_bounds", lambda *_, **__: shares)
    model = AmongFar(Coils(), sensor, SENSOR)
    found = model.impedance(Pose.of([[0.0, 2 * MM, 0.0, 0.0, 0.0, 0.0], [0.0, 3 * MM, 0.0, 0.0, 0.0, 0.0]]), 1e6)
    bound = 2e-6 * np.array([3e-4, 2e-4])
    np.testing.assert_allclose(found.error_L[:, 0, 1], 1e-9 + bound)
    np.testing.assert_allclose(found.error_R[:, 1, 1], 1e-3 + 2.0 * np.pi * 1e6 * bound)
    assert found.report.estimated_error == pytest.approx(1e-3 + 2e-2)
    assert found.report.left_out[0] == AIR and found.report.notes == ()
    sizes = {item.known["name"]: item.size for item in far_of(found.report.left_out)}
    assert sizes == {"nut": pytest.approx(1e-4 * 2e-6 / 0.02e-6), "other": pytest.approx(1e-4 * 2e-6 / 0.02e-6)}
    monkeypatch.setattr(conductors, "remote_bounds", lambda *_, **__: np.full((2, 2), np.inf))
    with pytest.raises(ValueError, match="must stay far from conductors.nut, conductors.other"):
        model.impedance(Pose.of(np.array([[0.0, 2 * MM, 0.0, 0.0, 0.0, 0.0]] * 2)), 1e6)


@dataclass(frozen=True)
class Still:
    """Two unlike coils of which a target takes 5 % of the larger L0."""

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        L0 = np.diag([4e-6, 2e-6])
        L = np.broadcast_to(L0 - [[2e-7, 1e-7], [1e-7, 0.0]], (*np.shape(pose.d_v), 2, 2))
        report = SolveReport("still", 0, 0, 0.0, 0.0, 0.0)
        return Impedance(frequency, L, 0.0 * L, L0, np.ones(2), 0.0 * L, 0.0 * L, "H", report)


def test_what_no_change_can_show_is_left_out_without_a_look(monkeypatch: pytest.MonkeyPatch) -> None:
    """Together below 1e-8 of a tolerance, of L0, at every pose; sizes are the worst of them, of a change of 1e-6."""
    sensor, poses = among(nut(200.0, 0.0), nut(300.0, 0.0, name="other")), Pose(np.zeros(2), np.full(2, 2e-3))
    assert negligible(1e-2) == pytest.approx(1e-10)
    asked = []
    for bounds, looks in (([[1e-11, 2e-11], [3e-11, 1e-11]], False), ([[1e-11, 0.0], [6e-11, 5e-11]], True)):
        monkeypatch.setattr(conductors, "remote_bounds", lambda *_, bounds=bounds, **more: np.array(bounds))
        monkeypatch.setattr(conductors, "_shares", lambda *_: np.zeros(2))
        solved, left_out = without_far(sensor, lambda scene: asked.append(scene) or Still(), poses, 1e-2)
        assert bool(asked) == looks and solved.conductors == ()
        if not looks:
            assert [item.size for item in left_out] == [pytest.approx(3e-5), pytest.approx(2e-5)]
    assert asked[0].conductors == ()


def test_what_counts_whatever_the_change_is_needs_no_look(monkeypatch: pytest.MonkeyPatch) -> None:
    """A change is L0 at most: where each alone may be as much at some pose, the bare sensor is not solved."""
    sensor, poses = among(nut(5.0, -0.02), nut(0.0, -3.0, name="below")), Pose(np.zeros(2), np.full(2, 2e-3))
    asked = []
    for below, looks in ([0.1, 1.0], False), ([0.1, 0.99], True):

        def bounds(solved: Sensor, far: list[Conductor], pose: Pose, *, below=below, **more: object) -> np.ndarray:
            return np.array([{"nut": [0.2, np.inf], "below": below}[part.name] for part in far]).reshape(-1, 2).T

        monkeypatch.setattr(conductors, "remote_bounds", bounds)
        solved, left_out = without_far(sensor, lambda scene: asked.append(scene) or Still(), poses, 1e-2)
        assert bool(asked) == looks and solved.conductors == sensor.conductors and left_out == ()


@pytest.mark.parametrize("section", [False, True])
def test_far_ones_are_measured_by_the_change_of_the_bare_sensor(
    monkeypatch: pytest.MonkeyPatch, section: bool
) -> None:
    """The largest entry of the change over the larger L0; a section has endless conductors, in henry as well."""
    sections = []

    def bounds(solved: Sensor, far: list[Conductor], pose: Pose, *, section: bool, enough: float = 0.0) -> np.ndarray:
        sections.append(section)
        return np.full((1, len(far)), 1e-4)

    monkeypatch.setattr(conductors, "remote_bounds", bounds)
    sensor = among(nut(200.0, 0.0))
    solved, (item,) = without_far(sensor, lambda _: Still(), REST, 1e-2, section=section)
    assert solved.conductors == () and item.size == pytest.approx(1e-4 / 0.05) and item.bound and item.counts
    assert dict(item.numbers) == {"name": "nut", "x": 0.2, "y": 0.0, "z": 0.0}
    assert set(sections) == {section}
    found = AmongFar(Still(), sensor, solved, section).impedance(REST, 1e6)
    assert sections[-1] == section and found.error_L[0, 0] == pytest.approx(1e-4 * 4e-6)


def test_what_is_left_out_takes_half_of_the_tolerance_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two of a third of the tolerance each: one is solved."""
    sensor = among(nut(200.0, 0.0), nut(300.0, 0.0, name="other"))
    monkeypatch.setattr(
        conductors, "remote_bounds", lambda solved, far, pose, **_: np.full((1, len(far)), 0.05 * 1e-2 / 3.0)
    )
    solved, left_out = without_far(sensor, lambda _: Still(), REST, 1e-2)
    assert len(solved.conductors) == len(left_out) == 1 and left_out[0].size == pytest.approx(1e-2 / 3.0)
