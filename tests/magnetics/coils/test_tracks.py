"""Uneven current in tracks under metal: solid turns by another code, three models alike, fields by small loops."""

import benchmarks.tracks_under_target as study
import numpy as np
import pytest
from common.track_losses import track_spectrum
from scipy.constants import mu_0

from sits_mech.chain.derivatives.fixed_pose import at_fixed_poses
from sits_mech.chain.models import magnetic_model
from sits_mech.geometry.collision import placed_plates
from sits_mech.magnetics.answer import serving
from sits_mech.magnetics.axis_fem import axisymmetric_fem
from sits_mech.magnetics.coils.far_field import coil_field
from sits_mech.magnetics.coils.loops import free_inductances
from sits_mech.magnetics.coils.resistance import track_response
from sits_mech.magnetics.coils.tracks import Tracked, Tracks, with_tracks
from sits_mech.magnetics.pose_slopes import pose_slopes
from sits_mech.magnetics.rings import axisymmetric
from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.space.neighbours import field_of
from sits_mech.magnetics.space.sources import Posed
from sits_mech.quantities import Impedance, Pose, SolveReport
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.parameters import TEMPERATURE, parameter
from sits_mech.scene.sensor import load_sensor
from sits_mech.scene.thermal import warmed

MM, MODELS = 1e-3, (axisymmetric, axisymmetric_fem, sheets)
ROWS = {(row["coil"], row["frequency"], row["gap"]): row for row in study.STORED["rows"]}


def answered(make: object, name: str, frequency: float, gap: float) -> tuple[float, float, float, float]:
    """R of the whole coil [ohm] and Delta L [H] over the reference's less 1, and what is told of each."""
    sensor = study.scene(name, frequency, gap)
    found = Tracked(make(sensor, 1e-2), sensor).impedance(Pose(0.0, gap * MM), frequency)  # type: ignore[operator]
    row, free = ROWS[name, frequency, gap], ROWS[name, frequency, None]
    change = row["L"] - free["L"]
    R, dL = float(found.R[0, 0] + found.R_dc[0]), float((found.L - found.L0)[0, 0])
    return R / row["R"] - 1.0, dL / change - 1.0, float(found.error_R[0, 0]) / row["R"], found.error_L[0, 0] / -change


@pytest.mark.parametrize(("name", "frequency", "gap", "off"), [
    ("biorob2018", 5e6, 1.0, 2e-3), ("biorob2018", 5e6, 0.3, 2e-3), ("biorob2018", 1e6, 1.0, 1e-3),
    ("one layer", 5e6, 0.3, 3e-3), ("wide tracks", 5e6, 1.0, 6e-3), ("wide tracks", 1e6, 3.0, 1e-3),
    *(pytest.param(name, 5e6, gap, 1e-2, marks=pytest.mark.slow)
      for name in ("four layers", "thin tracks") for gap in (0.3, 3.0)),
    *(pytest.param(name, 8e6, gap, 4e-3, marks=pytest.mark.slow)
      for name in ("three layers", "heavy copper", "flex") for gap in (0.2, 2.0)),
])
def test_solid_turns_by_another_code(name: str, frequency: float, gap: float, off: float) -> None:
    """R of the whole coil, and Delta L to 1e-3, within what is told; NGSolve, all turns solid copper in series."""
    R, dL, told_R, told_L = answered(axisymmetric, name, frequency, gap)
    assert abs(R) < min(off, told_R) and abs(dL) < max(1e-3, told_L)


@pytest.mark.parametrize("gap", [pytest.param(1.0, marks=pytest.mark.slow), 0.3])
def test_three_models_see_the_same(gap: float) -> None:
    """Rings, finite elements, and sheets away from the coil and close to it: 1 % of what metal changes."""
    sensor, pose = study.scene("biorob2018", 5e6, gap), Pose(0.0, gap * MM)
    each = []
    for make in MODELS:
        model = make(sensor, 1e-2)
        whole, even = Tracked(model, sensor).impedance(pose, 5e6), model.impedance(pose, 5e6)
        alone = with_tracks(Tracks(sensor.coils, 5e6, 5e6), even)
        each.append([float((whole.R - alone.R)[0, 0]), float((whole.L - alone.L)[0, 0])])
    assert each[0][0] < -0.2 and each[0][1] > 5e-9
    np.testing.assert_allclose(each[1:], [each[0]] * 2, rtol=1e-2)


def test_b_off_the_axis_is_that_of_a_small_loop() -> None:
    """The flux through loops of 0.2 mm over their area, under a plate shifted and tilted: within 3 %."""
    sensor, frequency = load_sensor("biorob2018"), 5e6
    pose = Pose.of(np.array([[0.7 * MM, 1.4 * MM, 0.05, 0.3 * MM, 0.03, 0.2]]))
    loops = []
    for k, (x, y) in enumerate(((-4.0, 1.8), (-6.2, 0.4), (-2.3, -1.0))):
        loops.append(sensor.coils[0].model_copy(update={
            "name": f"P{k}", "centre": (x * MM, y * MM), "layers": 1, "turns": 1, "inner_diameter": 0.16 * MM,
            "track_width": 0.04 * MM,
        }))
    more = sensor.model_copy(update={"coils": (sensor.coils[0], *loops)})
    model = sheets(more, 1e-2)
    reaction = model._reaction(pose, frequency).change  # coils that lie in each other have no L0 here
    expected = reaction[0, 0, 1:].imag / (2 * np.pi * frequency * np.pi * (0.1 * MM) ** 2)
    parts = placed_plates(more, rotation_matrix(pose.rotation), pose.centre)
    (*clear, room), top, *_ = next(serving(model._gaps(parts)[0], frequency))
    plate = model._plates(parts, clear, room, (frequency, top))[0][0].divisions[0]
    places = np.array([(*loop.centre, -loop.track_thickness / 2) for loop in loops])
    seen = Posed(sensor.coils, "rings", rotation_matrix(pose.rotation), pose.centre)
    B = field_of(plate, seen, frequency, places)[0, :, 2, 0]
    np.testing.assert_allclose(B.real, expected, rtol=3e-2)


@pytest.mark.parametrize(("apart", "frequency"), [(8.0, 5e6), (14.0, 3e6)])
def test_mutual_inductances_have_an_error(apart: float, frequency: float) -> None:
    """Of two coils in free space: about what the tracks' response is to the other coil's field at every turn."""
    one = load_sensor("biorob2018").coils[0]
    coils = tuple(one.model_copy(update={"name": f"C{x}", "centre": (x * MM, 0.0)}) for x in (0.0, apart))
    tracks, L0 = Tracks(coils, frequency, frequency), free_inductances(coils)
    points = np.split(tracks.points(MM), 2)
    B = np.zeros((1, 2 * len(points[0]), 3, 2), dtype=complex)
    B[0, : len(points[0]), :, 1] = mu_0 * coil_field(coils[1], points[0], 1e-6)
    B[0, len(points[0]) :, :, 0] = mu_0 * coil_field(coils[0], points[1], 1e-6)
    change = tracks.change(MM, B)[0, 0].imag / (2.0 * np.pi * frequency)
    error = with_tracks(tracks, of_even_current(L0, frequency)).error_L0
    assert error is not None and error[0, 1] == pytest.approx(abs(change[0, 1]), rel=0.2)
    assert 3e-3 < error[0, 1] / abs(L0[0, 1]) < 2e-2 and error[0, 0] < 1e-3 * L0[0, 0]


def of_even_current(L0: np.ndarray, frequency: float) -> Impedance:
    """Coils alone by even current."""
    none = np.zeros_like(L0)
    report = SolveReport("rings", 0, 0, 0.0, 0.0, 0.0)
    return Impedance(frequency, L0, none, L0, np.zeros(len(L0)), none, none, "H", report)


def test_mirrored_poses_and_reciprocity() -> None:
    """To rounding: what metal does in the tracks follows the scene's symmetry."""
    sensor = load_sensor("biorob2018")
    model = Tracked(sheets(sensor, 1e-1), sensor)
    one, two = (model.impedance(Pose(sign * 0.3 * MM, 1.5 * MM, sign * 0.02), 5e6) for sign in (1.0, -1.0))
    for name in ("L", "R"):
        np.testing.assert_allclose(getattr(one, name), getattr(two, name)[::-1, ::-1], rtol=1e-9)
        np.testing.assert_allclose(getattr(one, name), getattr(one, name).T, rtol=1e-9)


def test_other_metal_takes_of_it_as_well() -> None:
    """A ground plane below the coils alone lowers R of the tracks; ferrite has no field here, and a size."""
    plane = ('conductors=[{name="G", material="copper", shape="rectangle", centre=["0 mm", "-1 mm"], width="20 mm", '
             'length="12 mm", thickness="35 um"}]')
    sensor = load_sensor("biorob2018", [plane]).model_copy(update={"target": None})
    model, none = sheets(sensor, 1e-1), Pose.of(np.zeros((0, 6)))
    pose = Pose(0.0, 2 * MM)
    shown, change = model.with_tracks(pose, 5e6, Tracks(sensor.coils, 5e6, 5e6))
    assert change is not None and change[0, 0, 0, 0].real < -0.05 and shown.L.shape == (2, 2)
    ferrite = load_sensor("biorob2018", [plane.replace('"copper"', '"ferrite"')])
    assert sheets(ferrite, 1e-1).with_tracks(none, 5e6, Tracks(ferrite.coils, 5e6, 5e6))[1] is None


@pytest.mark.parametrize(("name", "mu", "frequency", "gap"), [
    ("biorob2018", 200.0, 1e6, 2.0), ("biorob2018", 200.0, 3e5, 0.3), ("biorob2018", 20.0, 5e6, 1.0),
    ("biorob2018", 1.0, 5e6, 2.0), ("wide tracks", 200.0, 1e6, 1.0), ("heavy copper", 200.0, 3e6, 0.5),
])
def test_what_is_left_out_over_steel_is_in_the_errors(name: str, mu: float, frequency: float, gap: float) -> None:
    """Its size is about what finite elements, which know the metal's field, find it to be."""
    metal = {"conductivity": 5e6, "relative_permeability": mu, "thickness": 1 * MM}
    copper = study.scene(name, frequency, gap)
    sensor = copper.model_copy(update={"target": copper.target.model_copy(update=metal)})
    tracks = Tracks(sensor.coils, frequency, frequency)
    found, change = axisymmetric_fem(sensor, 1e-2).with_tracks(Pose(0.0, gap * MM), frequency, tracks)
    none, error = tracks.unknown(found)
    assert change is not None
    known = complex(change[0].item())
    assert none.item() == 0.0 and abs(known.real) < error.item().real and abs(known.imag) < error.item().imag
    assert abs(error.item()) < 3.0 * abs(known)


@pytest.mark.parametrize(("frequency", "gap"), [(1e6, 2.0), (3e6, 1.0)])
def test_sheets_over_steel_hold_finite_elements(frequency: float, gap: float) -> None:
    """Within the sum of both errors, where L hardly changes and where R does by more than that of the tracks."""
    copper = study.scene("biorob2018", frequency, gap)
    steel = {"conductivity": 5e6, "relative_permeability": 200.0, "thickness": 1 * MM}
    sensor = copper.model_copy(update={"target": copper.target.model_copy(update=steel)})
    one, other = (
        magnetic_model(sensor, name)[0].impedance(Pose(0.0, gap * MM), frequency)
        for name in ("axisymmetric-fem", "sheets")
    )
    assert abs(one.L - other.L) < one.error_L + other.error_L and abs(one.R - other.R) < one.error_R + other.error_R


def test_conductivity_and_frequency_scale() -> None:
    """Z of tracks of sigma at f is sigma_0/sigma times that of copper at f sigma/sigma_0, and smooth in f."""
    coil = study.scene("biorob2018", 5e6, None).coils[0]
    warm = coil.model_copy(update={"conductivity": 0.8 * study.COPPER})
    one, two = track_spectrum(warm, [5e6]), track_spectrum(coil, [4e6])
    assert one.R[0] == pytest.approx(two.R[0] / 0.8, rel=2e-3) and one.shift[0] == pytest.approx(two.shift[0], rel=1e-2)
    a, b, c = (track_response(coil, f, 5e6).alone for f in (4.99e6, 5e6, 5.01e6))
    assert abs(a - 2.0 * b + c) < 1e-5 * abs(b)


def test_slopes_hold_it() -> None:
    """By the gap: that of the whole, beside differences of whole answers, and not that of even current."""
    sensor, pose = load_sensor("biorob2018"), Pose.of(np.array([[0.0, 1.5 * MM, 0.0, 0.0, 0.0, 0.0]]))
    model, _ = magnetic_model(sensor, "sheets", 1e-1, [pose])
    _, slope, _ = pose_slopes(sensor, model, pose, 5e6, ["d_v"])
    ends = [model.impedance(Pose(0.0, 1.5 * MM + step), 5e6).L for step in (1e-6, -1e-6)]
    exact = (ends[0] - ends[1])[0, 0] / 2e-6
    even = sheets(sensor, 1e-1)
    _, bare, _ = pose_slopes(sensor, even, pose, 5e6, ["d_v"])
    assert slope[0, 0, 0, 0] == pytest.approx(exact, rel=1e-4) and abs(bare[0, 0, 0, 0] / exact - 1.0) > 5e-3


def test_drift_by_the_metal_is_that_of_warmer_scenes() -> None:
    """Tracks and target together, in L and in L0: the slope by conductivity against two scenes 10 K apart."""
    sensor, pose = study.scene("biorob2018", 5e6, 1.0), Pose(0.0, MM)
    copper = {"conductivity": None, "material": "copper"}
    sensor = sensor.model_copy(update={
        "coils": (sensor.coils[0].model_copy(update={"conductivity": None}),),
        "target": sensor.target and sensor.target.model_copy(update=copper),
    })
    model = Tracked(axisymmetric(sensor, 1e-2), sensor)
    number = parameter(sensor, TEMPERATURE + "conductivity")
    found = at_fixed_poses(sensor, (model, "axisymmetric", 1e-2), Pose.of(pose.components[None]), [number])
    ends = []
    for dT in (5.0, -5.0):
        warm = warmed(sensor, {"conductivity": dT})
        ends.append(Tracked(axisymmetric(warm, 1e-2), warm).impedance(pose, 5e6))
    assert found.L[0, 0, 0, 0] == pytest.approx((ends[0].L - ends[1].L)[0, 0] / 10.0, rel=2e-2)
    assert found.L0[0, 0] == pytest.approx((ends[0].L0 - ends[1].L0)[0, 0] / 10.0, rel=1e-2)
    assert found.L0[0, 0] / ends[0].L0[0, 0] > 3e-5  # 38 ppm/K, of which a board has 15 beside it
