"""What ends along y of coils and plates are worth, by space, and whose errors hold it."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.chain.models import MAGNETICS, magnetic_model
from sits_mech.description import Question
from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.models import PLANAR, SHEETS
from sits_mech.magnetics.omitted import ends
from sits_mech.magnetics.omitted.ends import Ends, Whole, _three_digits, ends_of_plates, pitch_of_spirals
from sits_mech.magnetics.sheets import sheets
from sits_mech.notes import Omission, OmissionKind
from sits_mech.quantities import Impedance, MagneticModel, Pose, SolveFailed, SolveReport
from sits_mech.scene.sensor import Sensor, load_sensor

MM = 1e-3


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    return load_sensor("biorob2018")


def own(values: np.ndarray) -> np.ndarray:
    """Diagonals."""
    return np.diagonal(values, axis1=-2, axis2=-1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("keys", "tilt"),
    [
        ([], 0.0), (["target.width=0.015"], 0.05), (["frequency=5e4"], 0.0),
    ],
    ids=["8", "15", "5e4"],
)
def test_ends_are_what_space_has_more(keys: list[str], tilt: float) -> None:
    """Against sheets a rung finer: relative to the free-space inductances of each, within a few percent."""
    scene = load_sensor("biorob2018", keys)
    pose = Pose(np.array([20 * tilt * MM]), np.array([(2 - 10 * tilt) * MM]), np.array([tilt]))
    section = planar_bars(scene, 1e-3).impedance(pose, scene.frequency)
    found, fine = ends_of_plates(scene, pose, section), sheets(scene, 1e-2).impedance(pose, scene.frequency)
    assert found is not None
    scale = own(section.L0) / own(fine.L0)
    true = own(fine.L) * scale - own(section.L)
    assert np.all(np.abs(own(found.L) - true) <= own(found.error_L) + 1.5 * own(fine.error_L) * scale)
    assert np.all(own(found.error_L) < 0.2 * np.abs(true).max())
    size = np.abs(true).max(axis=1) / np.abs(section.L - section.L0).max(axis=(1, 2))
    assert found.size == pytest.approx(size.max(), rel=0.1)


@pytest.mark.slow
def test_a_long_target_ends_where_no_coil_sees_it(sensor: Sensor) -> None:
    """The same size from 40 mm as from 200 mm of plate."""
    pose, found = Pose(0.0, 2 * MM), []
    for length in (0.04, 0.2):
        scene = load_sensor("biorob2018", [f"target.length={length}"])
        ends = ends_of_plates(scene, pose, planar_bars(scene, 1e-2).impedance(pose, scene.frequency))
        assert ends is not None
        found.append(ends.size)
    assert found[1] == pytest.approx(found[0], rel=0.02)


@pytest.mark.slow
def test_a_pose_has_its_own_price(sensor: Sensor) -> None:
    """Digit by digit what it has alone, whatever poses are beside it; within the coarse answer of space's."""
    poses = Pose(np.linspace(0.0, 4.0, 9) * MM, np.linspace(1.5, 6.0, 9) * MM)
    section = planar_bars(sensor, 1e-2)
    found, whole = (each.impedance(poses, sensor.frequency) for each in (section, sheets(sensor, 0.1)))
    ends = ends_of_plates(sensor, poses, found)
    assert ends is not None
    true = own(whole.L / whole.L0 - found.L / found.L0)[:, 0] * found.L0[0, 0]
    np.testing.assert_allclose(own(ends.L)[:, 0], true, rtol=0.06, atol=1e-6 * found.L0[0, 0])
    wide = load_sensor("biorob2018", ["target.width=0.05", "target.length=0.05"])
    for scene in (sensor, wide):
        every = planar_bars(scene, 1e-2).impedance(poses, scene.frequency)
        both = ends_of_plates(scene, poses, every)
        for k in (0, 8):
            pose = Pose.of(poses.components[k])
            alone = ends_of_plates(scene, pose, planar_bars(scene, 1e-2).impedance(pose, scene.frequency))
            assert both is not None and alone is not None
            np.testing.assert_array_equal(both.L[k], alone.L)
            np.testing.assert_array_equal(both.error_R[k], alone.error_R)


@pytest.mark.slow
def test_the_pitch_of_spirals_is_worth_something() -> None:
    """A true spiral under a disc against rings of it: a percent of the change or less, and no exact nothing."""
    coil = (
        'coils=[{name="C", centre=["0 mm", "0 mm"], layers=2, turns=12, inner_diameter="2.2 mm", track_width="0.1 mm", '
        'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um", winding="spiral"}]'
    )
    scene = load_sensor(
        "biorob2018", [coil, 'target={material="copper", shape="disc", diameter="8 mm", thickness="0.2 mm"}']
    )
    pose = Pose(0.0, 2 * MM)
    rings = magnetic_model(scene, "axisymmetric", 1e-2)[0].impedance(pose, scene.frequency)
    assert 1e-5 < pitch_of_spirals(scene, pose, rings) < 3e-2


def answer(L0: float, L: np.ndarray, R: np.ndarray, unit: str, errors: tuple[float, float] = (0.0, 0.0)) -> Impedance:
    """Two alike coils at p poses: their own L and R as given (p, 2), none of each other."""
    L, R = (values[..., None] * np.eye(2) for values in (L, R))
    error_L, error_R = (np.full(L.shape, error) for error in errors)
    report = SolveReport("any", 0, 0, 0.0, 1e-3, 0.0)
    return Impedance(5e6, L, R, L0 * np.eye(2), np.ones(2), error_L, error_R, unit, report)


def test_what_space_has_more_is_scaled_to_the_section(sensor: Sensor, monkeypatch: pytest.MonkeyPatch) -> None:
    """By both L0; its own errors and 2 % of its change are added, and the size is of the section's largest change."""
    section = answer(4.0, np.array([[3.0, 3.5], [3.8, 3.9]]), np.array([[2.0, 3.0], [1.0, 1.0]]), "H/m")
    space = answer(2.0, np.array([[1.6, 1.7], [1.9, 1.9]]), np.array([[1.5, 1.5], [0.5, 0.7]]), "H", (0.01, 0.03))
    monkeypatch.setattr(ends, "_in_space", lambda *_: space)
    found = ends_of_plates(sensor, Pose(np.zeros(2), np.array([2.0, 2.5]) * MM), section)
    assert found is not None
    np.testing.assert_allclose(own(found.L), [[0.2, -0.1], [0.0, -0.1]], atol=1e-12)
    np.testing.assert_allclose(own(found.R), [[1.0, 0.0], [0.0, 0.4]], atol=1e-12)
    np.testing.assert_allclose(own(found.error_L), [[0.036] * 2, [0.024] * 2])
    np.testing.assert_allclose(own(found.error_R), [[0.12] * 2, [0.088] * 2])
    assert found.size == pytest.approx(max(0.236 / 1.0, 0.124 / 0.2))
    for changes in ({"substrate_radius": 0.02}, {"target": None}):
        assert ends_of_plates(sensor.model_copy(update=changes), Pose(0.0, 2 * MM), section) is None


def test_the_published_sensor_in_section_is_half_off(sensor: Sensor, monkeypatch: pytest.MonkeyPatch) -> None:
    """0.52 of the change in space is 0.34 of the section's own, and 0.03; the answer's error holds it, of one solve."""
    asked = []

    def counted(scene: Sensor, tolerance: float) -> MagneticModel:
        asked.append(tolerance)
        return sheets(scene, tolerance)

    monkeypatch.setattr(ends, "sheets", counted)
    pose = Pose(1e-7, 2 * MM)
    found = magnetic_model(sensor, "planar", 1e-2, [pose])[0].impedance(pose, sensor.frequency)
    narrow = planar_bars(sensor, 1e-2).impedance(pose, sensor.frequency)
    np.testing.assert_array_equal(found.L, narrow.L)
    change = abs(narrow.L - narrow.L0)[0, 0]
    assert found.error_L[0, 0] / change == pytest.approx(0.37, abs=0.01)
    assert found.report.estimated_error == pytest.approx(0.37, abs=0.01) and narrow.report.estimated_error < 2e-3
    item, tracks = found.report.left_out
    assert (item.kind, item.unbounded, item.included) == (OmissionKind.PLATE_ENDS, False, False)
    assert tracks.kind == OmissionKind.TRACKS and tracks.included and 0.015 < tracks.size < 0.025
    both = found.report.estimated_error - narrow.report.estimated_error
    assert both - item.size == pytest.approx(tracks.size, rel=0.25)  # of L alone
    assert found.shared_L is not None and found.shared_L[-1, 0, 0] > 0.0  # endless plates take more
    again = PLANAR.omissions(sensor, Question(pose=pose, answer=(pose, found)))
    assert item in again and asked == [0.1]


def test_what_has_no_size_is_in_no_error() -> None:
    """Steel with a hole: no model in space, the answer lists it and says that it is not bounded."""
    points = "points=[[-4e-3, -4e-3], [4e-3, -4e-3], [4e-3, 4e-3], [-4e-3, 4e-3]]"
    shape = f'shape="outline", {points}, holes=[[[1e-3, 1e-3], [2e-3, 1e-3], [1e-3, 2e-3]]], thickness=2e-4'
    steel = load_sensor("biorob2018", [f"target={{conductivity=7e6, relative_permeability=100, {shape}}}"])
    pose, section = Pose(0.0, 2 * MM), answer(4.0, np.array([3.0, 3.5]), np.array([2.0, 3.0]), "H/m", (0.1, 0.2))
    assert ends_of_plates(steel, pose, section) is None
    found = Whole(Given(section), steel, MAGNETICS["planar-fem"]).impedance(pose, 5e6)
    assert found.report.estimated_error == 1e-3 and found.error_L[0, 0] == pytest.approx(0.1)
    assert [item.kind for item in found.report.left_out if item.unbounded] == [OmissionKind.PLATE_ENDS]


class Given:
    """A model whose answer is given."""

    def __init__(self, found: Impedance) -> None:
        self.found = found

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        return self.found


def test_an_answer_in_section_holds_its_ends(sensor: Sensor, monkeypatch: pytest.MonkeyPatch) -> None:
    section = answer(4.0, np.array([3.0, 3.5]), np.array([2.0, 3.0]), "H/m", (0.1, 0.2))
    parts = [np.full((2, 2), value) for value in (-0.3, -0.5, 0.01, 0.02)]
    monkeypatch.setattr(ends, "ends_of_plates", lambda *_: Ends(*parts, size=0.31))
    found = Whole(Given(section), sensor, PLANAR).impedance(Pose(0.0, 2 * MM), 5e6)
    assert found.error_L[0, 0] == pytest.approx(0.41) and found.error_R[0, 0] == pytest.approx(0.72)
    assert found.report.estimated_error == pytest.approx(0.311)
    assert found.shared_L.tolist() == [parts[0].tolist()]


@pytest.mark.parametrize(("item", "error", "listed"), [
    (Omission(OmissionKind.STATED, 0.1), 0.1, 1), (Omission(OmissionKind.STATED, 0.1, counts=False), 0.0, 0),
    (Omission(OmissionKind.STATED), 0.0, 0), (Omission(OmissionKind.STATED, np.nan), 0.0, 1),
    (Omission(OmissionKind.STATED, 0.1, included=True), 0.0, 1),
])
def test_what_else_a_model_leaves_out_is_of_the_largest_change(
    sensor: Sensor, item: Omission, error: float, listed: int
) -> None:
    """Of each pose its own; what the model's own error holds is not added again, what does not count is not listed."""
    space = answer(4.0, np.array([[3.0, 3.5], [3.8, 3.9]]), np.array([[2.0, 3.0], [1.0, 1.0]]), "H", (0.01, 0.02))
    asked = list[Question]()

    def omissions(scene: Sensor, question: Question) -> tuple[Omission, ...]:
        asked.append(question)
        return (item,)

    pose = Pose(np.zeros(2), np.array([2.0, 2.5]) * MM)
    found = Whole(Given(space), sensor, replace(SHEETS, omissions=omissions)).impedance(pose, 5e6)
    assert found.report.estimated_error == pytest.approx(1e-3 + error) and len(found.report.left_out) == listed
    held = 0.0 if item.included else error
    np.testing.assert_allclose(own(found.error_L)[:, 0], 0.01 + held * np.array([1.0, 0.2]))
    np.testing.assert_allclose(own(found.error_R)[:, 0], 0.02 + held * np.array([3.0, 1.0]))
    assert asked[0].closely and asked[0].answer is not None and asked[0].answer[1] is space


def test_estimates_have_three_digits() -> None:
    told = _three_digits(np.array([0.0, 1.23456e-7, -98765.0, 9.996]))
    np.testing.assert_allclose(told, [0.0, 1.23e-7, -98800.0, 10.0], rtol=1e-12)


def test_the_pitch_is_the_worst_of_all_poses(sensor: Sensor, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of each the largest difference over the largest change; none where space fails or holds no such scene."""
    kinds = {"rings": np.array([[1.6, 1.8], [1.9, 1.9]]), "spiral": np.array([[1.61, 1.82], [1.9, 1.895]])}

    class Space:
        def __init__(self, windings: str) -> None:
            self.windings = windings

        def impedance(self, pose: Pose, frequency: float) -> Impedance:
            assert pose.components.shape == (2, 6) and frequency == 5e6
            return answer(2.0, kinds[self.windings], kinds[self.windings], "H")

    monkeypatch.setattr(ends, "sheets", lambda scene, tolerance, windings: Space(windings))
    poses, rings = Pose(np.zeros(2), np.full(2, 2 * MM)), answer(2.0, kinds["rings"], kinds["rings"], "H")
    assert pitch_of_spirals(sensor, poses, rings) == pytest.approx(max(0.01 / 0.2, 0.0025 / 0.05))
    assert np.isnan(pitch_of_spirals(sensor.model_copy(update={"target": None}), poses, rings))
    assert np.isnan(pitch_of_spirals(sensor.model_copy(update={"substrate_radius": 0.02}), poses, rings))

    def failed(*_: object, **more: object) -> None:
        raise SolveFailed("no", rings.report)

    monkeypatch.setattr(ends, "sheets", failed)
    assert np.isnan(pitch_of_spirals(sensor, poses, rings))
