"""Derivatives by pose, frequency and lengths against closed forms, symmetry, scaling, fresh answers and splines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from common.infinite_plate import Layer, coil_change
from scipy.interpolate import make_interp_spline

from sits_mech.chain.omitted.conductors import AmongFar
from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.rings import axisymmetric
from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.slopes import Slopes, slopes
from sits_mech.maps.differences import CENTRAL
from sits_mech.quantities import POSE, Array, Impedance, MagneticModel, Pose, SolveFailed, SolveReport
from sits_mech.scene.parameters import parameter
from sits_mech.scene.sensor import Conductor, SceneError, Sensor, Target, load_sensor

MM = 1e-3
TRACKS = tuple(f"coils.*.{key}" for key in ("inner_diameter", "track_width", "track_gap", "track_thickness"))
COILS = (*TRACKS, "coils.*.layer_pitch", "coils.0.centre.0", "coils.1.centre.0")
TARGET = ("target.width", "target.length", "target.thickness")
PLACE = {"d_h": 0.4 * MM, "d_v": 2.1 * MM, "alpha": 0.03, "d_y": 0.2 * MM, "alpha_x": -0.02, "alpha_z": 0.1}


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    return load_sensor("biorob2018")


@pytest.mark.parametrize("name", POSE)
def test_as_a_spline_through_poses(sensor: Sensor, name: str) -> None:
    """A spline of degree 7 through poses along one component, differentiated."""
    model = sheets(sensor, 1e-2)
    found = slopes(sensor, model, Pose(**PLACE), 5e6)
    way = np.linspace(-1.0, 1.0, 41) * (0.2 * MM if name.startswith("d") else 0.05)
    along = Pose(**{key: value + way * (key == name) for key, value in PLACE.items()})
    Z, k = model.impedance(along, 5e6), POSE.index(name)
    for curve, slope in ((Z.L, found.L), (Z.R, found.R)):
        exact = make_interp_spline(way, curve.reshape(len(way), -1), k=7).derivative()(0.0).reshape(2, 2)
        np.testing.assert_allclose(slope[..., k], exact, rtol=0, atol=1e-6 * np.abs(exact).max())


def test_symmetry(sensor: Sensor) -> None:
    """Over the middle of two coils: equal and opposite by shift, equal by height, none by what leaves the plane."""
    found = slopes(sensor, sheets(sensor, 1e-2), Pose(0.0, 2 * MM), 5e6)
    own = np.diagonal(found.L, axis1=0, axis2=1)  # component by coil
    largest = np.abs(own).max(axis=1)
    for k, sign in ((0, -1.0), (1, 1.0), (2, -1.0)):
        assert own[k, 0] == pytest.approx(sign * own[k, 1], rel=1e-6)
    assert largest[3] < 1e-7 * largest[0] and largest[4] < 1e-7 * largest[2] and largest[5] < 1e-7 * largest[2]
    assert np.all(own[1] > 0.0)  # the plate goes away, the inductance comes back


def test_frequency(sensor: Sensor) -> None:
    """At low frequency R goes with the square of the frequency, and so does the change of L."""
    model, pose = sheets(sensor, 1e-2), Pose(0.0, 2 * MM)
    found, Z = slopes(sensor, model, pose, 200.0, components=("d_v",)), model.impedance(pose, 200.0)
    assert found.R_frequency[0, 0] == pytest.approx(2.0 * Z.R[0, 0] / 200.0, rel=2e-3)
    assert found.L_frequency[0, 0] == pytest.approx(2.0 * (Z.L - Z.L0)[0, 0] / 200.0, rel=1e-2)


def test_many_poses_and_the_planar_model(sensor: Sensor) -> None:
    model: MagneticModel = planar_bars(sensor, 1e-2)
    gap = np.array([[1.5, 2.0, 2.5], [3.0, 3.5, 4.0]]) * MM
    found = slopes(sensor, model, Pose(0.0 * gap, gap, 0.0 * gap), 5e6, components=POSE[:3])
    assert found.L.shape == (2, 3, 2, 2, 3) and found.R_frequency.shape == (2, 3, 2, 2)
    one = slopes(sensor, model, Pose(0.0, 3.5 * MM), 5e6, components=("d_v",))
    np.testing.assert_allclose(found.L[1, 1, ..., 1], one.L[..., 0], rtol=1e-9)


def test_refused(sensor: Sensor) -> None:
    with pytest.raises(ValueError, match="components: must be of d_h.*got 'x'"):
        slopes(sensor, sheets(sensor, 1e-2), Pose(0.0, 2 * MM), 5e6, components=("x",))
    bare = load_sensor("biorob2018").model_copy(update={"target": None, "elastomer": None})
    with pytest.raises(ValueError, match="target: the scene has none"):
        slopes(bare, sheets(sensor, 1e-2), Pose(0.0, 2 * MM), 5e6)


def by_all(found: Slopes, sensor: Sensor, pose: Pose, name: str) -> Array:
    """Sum of all lengths, the pose's with them, times the derivatives of L or R by them."""
    sizes = np.array([parameter(sensor, key).value for key in found.lengths])
    place = np.array([getattr(pose, one) * one.startswith("d") for one in found.components])
    return np.asarray(getattr(found, f"{name}_lengths") @ sizes + getattr(found, name) @ place)


@pytest.mark.slow
def test_scaling_of_coils_alone(sensor: Sensor) -> None:
    """Euler: L0 is homogeneous of degree one in all lengths, per metre of depth of degree none."""
    bare = sensor.model_copy(update={"target": None, "elastomer": None})
    pose = Pose(0.0, 2 * MM)
    for model, degree in ((sheets(bare), 1.0), (planar_bars(bare), 0.0)):
        found, L0 = slopes(bare, model, pose, 5e6, components=(), lengths=COILS), model.impedance(pose, 5e6).L0
        np.testing.assert_allclose(by_all(found, bare, pose, "L"), degree * L0, rtol=0, atol=1e-8 * L0.max())


@pytest.mark.slow
def test_scaling_of_a_section(sensor: Sensor) -> None:
    """L(s x, f/s^2) = L and R(s x, f/s^2) = R/s^2 per metre of depth, to what the division of the plate holds."""
    model, pose, f = planar_bars(sensor, 1e-4), Pose(0.2 * MM, 2 * MM, 0.02), 1e6
    found = slopes(sensor, model, pose, f, components=POSE[:3], lengths=(*COILS, *TARGET))
    Z = model.impedance(pose, f)
    L = by_all(found, sensor, pose, "L") - 2 * f * found.L_frequency
    R = by_all(found, sensor, pose, "R") - 2 * f * found.R_frequency + 2 * Z.R
    assert np.abs(L).max() < 2e-3 * np.abs(Z.L - Z.L0).max() and np.abs(R).max() < 1e-2 * Z.R.max()
    assert np.abs(found.L_lengths[..., -2]).max() < 1e-12 * np.abs(found.L_lengths).max()  # a section does not see it


@pytest.mark.slow
def test_scaling_in_space(sensor: Sensor) -> None:
    """L(s x, f/s^2) = s L, to the tolerance of the change: the division is not scaled."""
    model, pose, f = sheets(sensor, 5e-3), Pose(0.2 * MM, 2 * MM, 0.02), 5e6
    found = slopes(sensor, model, pose, f, lengths=(*COILS, *TARGET))
    Z = model.impedance(pose, f)
    miss = by_all(found, sensor, pose, "L") - 2 * f * found.L_frequency - Z.L
    assert np.abs(miss).max() < 5e-3 * np.abs(Z.L - Z.L0).max()


def test_coils_moved_are_a_target_moved_back(sensor: Sensor) -> None:
    """One coil and the other along x or y, as the target the other way: preparations are held, and all hold to 1e-6."""
    keys, place = [f"coils.{name}.centre.{k}" for k in (0, 1) for name in ("C1", "C2")], Pose(**PLACE)
    found = slopes(sensor, sheets(sensor, 1e-2), place, 5e6, components=("d_h", "d_y"), lengths=keys)
    for name in ("L", "R"):
        by_pose, by_length = getattr(found, name), getattr(found, f"{name}_lengths")
        both = by_length[..., ::2] + by_length[..., 1::2]
        np.testing.assert_allclose(both, -by_pose, rtol=0, atol=1e-6 * np.abs(by_pose).max())
    assert abs(found.L_lengths[1, 1, 0]) < 1e-9 * np.abs(found.L_lengths).max()


FRESH = [(planar_bars, 1e-4), pytest.param(sheets, 1e-3, marks=pytest.mark.slow)]


@pytest.mark.parametrize(("make", "share"), FRESH)
def test_coils_as_fresh_answers(
    sensor: Sensor, make: Callable[[Sensor, float], MagneticModel], share: float
) -> None:
    """Richardson's differences of answers of other scenes, to what their plates, divided anew for other coils, change.

    Which is far below the tolerance: a coil's length moves the other coil's inductance in fresh answers only.
    """
    pose, key = Pose(0.3 * MM, 2.1 * MM, 0.02), "coils.0.inner_diameter"
    model = make(sensor, 1e-2)
    found, Z = slopes(sensor, model, pose, 5e6, components=(), lengths=[key]), model.impedance(pose, 5e6)
    h, size = 0.01 * sensor.coils[0].inner_diameter, np.abs(Z.L - Z.L0).max() / sensor.coils[0].inner_diameter
    fresh = {m: make(parameter(sensor, key).changed(m * h), 1e-2).impedance(pose, 5e6).L for m in CENTRAL.places}
    np.testing.assert_allclose(found.L_lengths[..., 0], CENTRAL.slope(fresh, h), rtol=0, atol=share * size)
    assert found.error_L_lengths.max() < 1e-5 * size and abs(found.L_lengths[1, 1, 0]) < 1e-9 * size


def test_mirrored(sensor: Sensor) -> None:
    """Mirrored poses swap the coils, with their lengths; those of the target stay."""
    model, keys = planar_bars(sensor, 1e-2), ("coils.0.track_width", "coils.1.track_width", "target.thickness")
    here, there = (
        slopes(sensor, model, Pose(way * 0.3 * MM, 2 * MM, way * 0.02), 5e6, components=(), lengths=keys)
        for way in (1.0, -1.0)
    )
    for name in ("L_lengths", "R_lengths"):
        one, other = getattr(here, name), getattr(there, name)[::-1, ::-1]
        np.testing.assert_allclose(one, other[..., [1, 0, 2]], rtol=0, atol=1e-6 * np.abs(one).max(axis=(0, 1)).min())


@pytest.mark.slow
def test_disc_over_a_coil_as_the_infinite_plate() -> None:
    """Dodd and Deeds: a disc of 40 mm at 2 mm over a coil of 7 mm, by the gap and by a length of the coil."""
    coil = load_sensor("biorob2018").coils[0].model_copy(update={"centre": (0.0, 0.0)})
    target = Target(conductivity=5.8e7, shape="disc", diameter=40 * MM, thickness=0.2 * MM)
    disc = Sensor(name="disc", frequency=5e6, coils=(coil,), target=target)
    found = slopes(
        disc, axisymmetric(disc, 1e-3), Pose(0.0, 2 * MM), 5e6, components=("d_v",), lengths=["coils.0.track_gap"]
    )

    def plate(gap: float, by: float) -> tuple[float, float]:
        one = parameter(disc, "coils.0.track_gap").changed(by).coils[0]
        change = coil_change(coil_sections(one), gap, 5e6, [Layer(5.8e7, 0.2 * MM)])
        L0 = axisymmetric(disc.model_copy(update={"coils": (one,), "target": None})).impedance(Pose(0.0, MM), 5e6).L0
        return float(change.delta_L + L0[0, 0]), float(change.R)

    for k, h in ((0, 1e-5), (1, 1e-6)):
        values = {m: plate(2 * MM + m * h * (k == 0), m * h * (k == 1)) for m in CENTRAL.places}
        for name, part in (("L", 0), ("R", 1)):
            slope = getattr(found, name if k == 0 else f"{name}_lengths")[0, 0, 0]
            exact = CENTRAL.slope({m: np.array(value[part]) for m, value in values.items()}, h)
            assert slope == pytest.approx(float(exact), rel=5e-3)


@pytest.mark.parametrize("make", [planar_bars, pytest.param(sheets, marks=pytest.mark.slow)])
def test_all_coils_aside_are_the_target_moved_back(make) -> None:  # type: ignore[no-untyped-def]
    """Minus the derivative by d_h; fresh answers of shifted coils are those of the target moved back, to rounding."""
    wide, h = load_sensor("biorob2018-w15"), 2e-5
    model, number = make(wide, 1e-2), parameter(wide, "coils.*.centre.0")

    def pose(m: float) -> Pose:
        return Pose(0.5 * MM - m * h, 1.7 * MM, 0.03)

    found = slopes(wide, model, pose(0), 5e6, components=["d_h"], lengths=["coils.*.centre.0", "coils.*.centre.1"])
    for m in CENTRAL.places:
        fresh, moved = make(number.changed(m * h), 1e-2).impedance(pose(0), 5e6), model.impedance(pose(m), 5e6)
        np.testing.assert_allclose(fresh.L, moved.L, rtol=1e-11)
        np.testing.assert_allclose(fresh.R, moved.R, rtol=1e-9)
    for name in ("L", "R"):
        by_length, by_pose = getattr(found, f"{name}_lengths"), getattr(found, name)[..., 0]
        size = np.abs(by_pose).max()
        np.testing.assert_allclose(by_length[..., 0], -by_pose, rtol=0, atol=1e-7 * size)
        assert np.abs(by_length[..., 1]).max() < 1e-6 * size  # along y the scene is its mirror image


def test_all_coils_aside_of_fixed_metal_are_no_target_moved(sensor: Sensor) -> None:
    """They move over the plate as well, by 1e-2 of what the target's motion changes."""
    plate = Conductor(  # type: ignore[call-arg]
        name="plate", material="copper", shape="rectangle", width=8 * MM, length=8 * MM, thickness=0.2 * MM,
        centre=(3 * MM, 0.0, -2 * MM),
    )
    among, pose = sensor.model_copy(update={"conductors": (plate,)}), Pose(0.5 * MM, 2.0 * MM)
    model, key, h = planar_bars(among, 1e-2), "coils.*.centre.0", 2e-5
    found = slopes(among, model, pose, 5e6, components=["d_h"], lengths=[key])
    by_pose, by_length = found.L[..., 0], found.L_lengths[..., 0]
    assert np.abs(by_length + by_pose).max() > 1e-2 * np.abs(by_pose).max()
    moved = {m: parameter(among, key).changed(m * h) for m in CENTRAL.places}
    fresh = {m: planar_bars(scene, 1e-2).impedance(pose, 5e6).L for m, scene in moved.items()}
    np.testing.assert_allclose(by_length, CENTRAL.slope(fresh, h), rtol=0, atol=1e-4 * np.abs(by_length).max())


def test_the_layer_and_what_is_left_out_change_nothing(sensor: Sensor) -> None:
    nut = {"name": "nut", "material": "copper", "shape": "disc", "diameter": 2 * MM, "thickness": MM}
    far = Conductor(**nut, centre=(0.0, 0.0, -0.3))  # type: ignore[arg-type]
    scene = sensor.model_copy(update={"conductors": (far,)})
    model = AmongFar(planar_bars(sensor, 1e-2), scene, sensor)
    keys = ("elastomer.thickness", "conductors.nut.diameter", "readout.parallel_capacitance")
    found = slopes(scene, model, Pose(0.0, 2 * MM), 5e6, components=(), lengths=keys)
    assert np.all(found.L_lengths == 0.0) and np.all(found.R_lengths == 0.0)


@dataclass(frozen=True)
class Stepped:
    """L = square of the target's width in metres, with a jump at some width, or one at every place."""

    sensor: Sensor
    at: float
    jump: float
    rough: bool = False

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        width = self.sensor.target.width if self.sensor.target is not None else None
        shape = pose.components.shape[:-1]
        step = self.jump * (hash(width) % 7) if self.rough else self.jump * float(width is not None and width > self.at)
        L, zero = np.broadcast_to(((width or 0.0) ** 2 + step) * np.eye(2), (*shape, 2, 2)), np.zeros((*shape, 2, 2))
        report = SolveReport("stepped", 0, 0, 0.0, 0.0, 0.0)
        return Impedance(frequency, L, zero, np.zeros((2, 2)), np.zeros(2), zero, zero, "H", report)


@pytest.mark.parametrize("at", [7.985, 7.999, 8.001, 8.055])
def test_a_preparation_that_jumps(sensor: Sensor, at: float) -> None:
    """One side of the jump, or a wider step: the slope is right, and where it is not its error tells."""
    model = Stepped(sensor, at * MM, 1e-3 * 64e-6)
    found = slopes(sensor, model, Pose(0.0, 2 * MM), 5e6, components=(), lengths=["target.width"])
    off = abs(found.L_lengths[0, 0, 0] - 16e-3)
    assert off < 1e-6 * 16e-3 and off <= found.error_L_lengths[0, 0, 0] + 1e-12


def test_no_slope_where_answers_are_noise(sensor: Sensor) -> None:
    with pytest.raises(SolveFailed, match="slopes: by target.width the answers of Stepped jump") as failed:
        rough = Stepped(sensor, 0.0, 1e-5, True)
        slopes(sensor, rough, Pose(0.0, 2 * MM), 5e6, components=(), lengths=["target.width"])
    assert failed.value.half == "magnetics"


def test_lengths_refused(sensor: Sensor) -> None:
    model, pose = planar_bars(sensor, 1e-2), Pose(0.0, 2 * MM)
    with pytest.raises(SceneError, match="coils.C1.turns: must be a number that can go up and down"):
        slopes(sensor, model, pose, 5e6, components=(), lengths=["coils.*.turns"])

    class Other:
        def impedance(self, pose: Pose, frequency: float) -> Impedance:
            return model.impedance(pose, frequency)

    with pytest.raises(ValueError, match="lengths: need a model that can be made for another scene, got Other"):
        slopes(sensor, Other(), pose, 5e6, components=(), lengths=["target.width"])


@pytest.mark.parametrize("key", ["target.width", pytest.param("target.thickness", marks=pytest.mark.slow)])
def test_cells_that_stretch_have_smooth_answers(sensor: Sensor, key: str) -> None:
    """The coarsest division alone: differences over steps of one and four agree to what the steps leave, h^2."""
    model, pose, number = sheets(sensor, 5e-2), Pose(0.3 * MM, 2 * MM, 0.02), parameter(sensor, key)
    found = []
    for h in (2e-3 * number.value, 8e-3 * number.value):
        ends = [model.varied(number.changed(way * h), single=True).impedance(pose, 5e6).L for way in (-1, 1)]
        found.append((ends[1] - ends[0]) / (2 * h))
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=2e-3 * np.abs(found[0]).max())


def test_plates_that_answer_each_other_are_divided_anew(sensor: Sensor) -> None:
    """And a target of another shape; a scene that is the same has the same answer."""
    part = {"name": "plate", "material": "copper", "shape": "disc", "diameter": MM, "thickness": MM}
    plate = Conductor(**part, centre=(0.0, 0.0, -5 * MM))  # type: ignore[arg-type]
    among = sensor.model_copy(update={"conductors": (plate,)})
    assert sheets(among, 5e-2).varied(among, single=True).like is None
    disc = sensor.model_copy(update={"target": Target(material="copper", shape="disc", diameter=MM, thickness=MM)})
    assert sheets(sensor, 5e-2).varied(disc, single=True).single is False


@pytest.mark.slow
@pytest.mark.parametrize("key", ["target.width", "target.length", "target.thickness"])
def test_a_single_division_for_a_coarse_tolerance(sensor: Sensor, key: str) -> None:
    """A slope by all divisions of a finer tolerance is within the error told, which is below the tolerance for L."""
    pose, size = Pose(0.3 * MM, 2 * MM, 0.02), parameter(sensor, key).value
    fine, found = (slopes(sensor, sheets(sensor, own), pose, 5e6, components=(), lengths=[key]) for own in (5e-3, 5e-2))
    Z = sheets(sensor, 5e-3).impedance(pose, 5e6)
    for name, change in (("L", Z.L - Z.L0), ("R", Z.R)):
        off = np.abs(getattr(found, f"{name}_lengths") - getattr(fine, f"{name}_lengths")).max()
        assert off <= getattr(found, f"error_{name}_lengths").max()
        assert name == "R" or found.error_L_lengths.max() * size < 5e-2 * np.abs(change).max()
