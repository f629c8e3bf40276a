"""Tables over any components of a load: against single loads, mirror images, and by models known by hand."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from sits_mech.chain import models
from sits_mech.chain.calibrate import _marks, _promised, calibrate
from sits_mech.chain.interpolate import checked_values, loads_of
from sits_mech.chain.models import loaded_model, mechanical_model
from sits_mech.chain.omitted import mechanical as leaving
from sits_mech.chain.plans import aimed
from sits_mech.chain.plans.aimed import AimedLoads
from sits_mech.chain.plans.goal import Goal, answer_error
from sits_mech.chain.plans.prices import MeshForecast
from sits_mech.chain.propagation import poses_of
from sits_mech.chain.simulate import simulate
from sits_mech.cli.console import kept_promise
from sits_mech.description import Description, Rung
from sits_mech.mechanics import touch
from sits_mech.mechanics.loads import Settled
from sits_mech.notes import Note, NoteKind, Omission, OmissionKind, Relative, packed, unpacked, unpacked_omissions
from sits_mech.quantities import POSE, WRENCH, Array, Equilibrium, Impedance, Pose, SolveReport, Wrench
from sits_mech.readout.calibration import calibration
from sits_mech.readout.loads import wrench_of
from sits_mech.report.tables.loads import figures
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor
from sits_mech.store import read_table, save_table

GRID = {"F_x": [-0.3, 0.3], "F_z": [0.5, 1.0], "F_y": [-0.2, 0.0, 0.2]}
SLOPES = np.array([4e-4, -1e-4, 1.0, 4e-4, 1.0, 1.0])  # of the pose by the load
REST = np.array([0.0, 2e-3, 0.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True)
class Springs:
    """Six springs, one for each component; errors of a thousandth."""

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the pose in closed form."""
        moved, report = SLOPES * wrench.components, SolveReport("springs", 6, 1, 0.0, 1e-3, 0.0, min_J=0.9)
        return Equilibrium(wrench, Pose.of(REST + moved), Pose.of(np.abs(moved) / 1000), np.zeros(1), report)


@dataclass(frozen=True)
class Linear:
    """L1, L2 = 1 + 100 d_v + alpha_x +- (20 d_h + d_y + alpha_z)."""

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return the closed form."""
        d_h, d_v, _, d_y, alpha_x, alpha_z = np.moveaxis(pose.components, -1, 0)
        common, odd = 1.0 + 100.0 * d_v + alpha_x, 20.0 * d_h + d_y + alpha_z
        zero = np.zeros_like(common)
        L = np.stack([np.stack([common + odd, zero], -1), np.stack([zero, common - odd], -1)], -2)
        error, report = np.full(L.shape, 1e-6), SolveReport("linear", 1, 1, 0.0, 1e-6, 0.0)
        return Impedance(frequency, L, np.zeros_like(L), 2.0 * np.eye(2), np.ones(2), error, error, "H", report)


def described(name: str, model: object, left_out: tuple[Omission, ...] = ()) -> Description:
    """A model that holds every scene."""
    return Description(name, lambda *_: model, lambda *_: None, lambda *_: left_out, (Rung(0.0, 1, 1, 0.0, 0.0),), 0.0)


def put(monkeypatch: pytest.MonkeyPatch, mechanics: Description, magnetics: Description) -> None:
    """Put models in place of all others, with a rigid target."""
    monkeypatch.setattr(leaving, "bending", lambda *_: ())
    for module in (models, leaving):
        monkeypatch.setattr(module, "MECHANICS", {mechanics.name: mechanics})
    for module in (models, aimed):
        monkeypatch.setattr(module, "MAGNETICS", {magnetics.name: magnetics})


@pytest.fixture
def fakes(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Put the models by hand behind the names."""
    put(monkeypatch, described("springs", Springs()), described("straight", Linear()))
    yield


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    """The published sensor."""
    return load_sensor("biorob2018")


@pytest.fixture(scope="module")
def table(sensor: Sensor) -> xr.Dataset:
    """The real chain on a small grid that leaves the plane, its tolerance a number of numpy's."""
    return calibrate(sensor, **GRID, tolerance=np.float32(5e-2))


@pytest.mark.parametrize(
    "load", [pytest.param((0.3, 1.0, 0.2), marks=pytest.mark.slow), (-0.3, 0.5, -0.2), (0.3, 0.5, 0.0)]
)
def test_a_table_holds_what_single_loads_show(sensor: Sensor, table: xr.Dataset, load: tuple[float, ...]) -> None:
    """The same models: to a hundredth of the stated errors, mirror images and loads in the plane included."""
    F_x, F_z, F_y = load
    single, row = simulate(sensor, Wrench(F_x, F_z, F_y=F_y), tolerance=5e-2), table.sel(F_x=F_x, F_z=F_z, F_y=F_y)
    for name in POSE:
        found, error = float(getattr(single.equilibrium.pose, name)), float(row[f"error_{name}"])
        assert abs(float(row[name]) - found) <= 1e-2 * error + 1e-15
    for name in ("L", "R"):
        off = np.abs(row[name].to_numpy() - getattr(single.impedance, name))
        assert np.all(off <= 1e-2 * row[f"error_{name}"].to_numpy())
    assert float(row["L_h"]) == pytest.approx(float(single.signals.L_h), abs=1e-2 * float(row["error_L_h"]))


def test_both_mirrors_hold(table: xr.Dataset) -> None:
    """Shear along -y shows the same and moves the other way; along -x it swaps the coils; without it, straight."""
    assert np.all(table["status"] == "ok")
    L = table["L"].transpose("F_x", "F_z", "F_y", "coil", "coil_2", ...).to_numpy()
    np.testing.assert_allclose(L[:, :, ::-1], L, rtol=1e-9)
    np.testing.assert_allclose(L[::-1, ..., ::-1, ::-1], L, rtol=1e-9)
    for name, in_x, in_y in zip(POSE, (-1, 1, -1, 1, 1, -1), (1, 1, 1, -1, -1, -1), strict=True):
        values = table[name].transpose("F_x", "F_z", "F_y").to_numpy()
        np.testing.assert_array_equal(values[::-1], in_x * values)
        np.testing.assert_array_equal(values[:, :, ::-1], in_y * values)
    assert np.all(table["d_y"].sel(F_y=0.2) > 0.0) and np.all(table["error_d_y"].sel(F_y=0.0) == 0.0)


@pytest.mark.slow
def test_a_table_beside_the_plane_comes_back_from_its_file(table: xr.Dataset, tmp_path: Path) -> None:
    """netCDF holds every dimension and variable."""
    save_table(table, tmp_path / "result.nc")
    assert read_table(tmp_path / "result.nc").identical(table)


@pytest.mark.usefixtures("fakes")
@pytest.mark.slow
def test_every_component_at_its_place(sensor: Sensor, tmp_path: Path) -> None:
    """Sequences are dimensions in the order of a wrench, numbers coordinates where they are not zero."""
    data = calibrate(sensor, F_z=[1.0, 0.0], M_z=[2e-3], F_x=[-0.3, 0.3], F_y=[-0.2, 0.2], M=1e-3, M_x=0.0)
    assert data["status"].dims == ("F_x", "F_z", "F_y", "M_z") and data["L"].dims[-2:] == ("coil", "coil_2")
    assert float(data["M"]) == 1e-3 and data["M"].dims == () and "M_x" not in data.coords
    for F_x, F_z, F_y in itertools.product(*(data[name].to_numpy() for name in ("F_x", "F_z", "F_y"))):
        row = data.sel(F_x=F_x, F_z=F_z, F_y=F_y, M_z=2e-3)
        pose: Array = REST + SLOPES * [F_x, F_z, 1e-3, F_y, 0.0, 2e-3]
        np.testing.assert_allclose([float(row[name]) for name in POSE], pose, rtol=1e-14, atol=0.0)
        odd = 20.0 * pose[0] + pose[3] + pose[5]
        assert float(row["L"].sel(coil="C1", coil_2="C1")) == pytest.approx(1.0 + 100.0 * pose[1] + odd, rel=1e-14)
    save_table(data, tmp_path / "result.nc")
    assert read_table(tmp_path / "result.nc").identical(data)
    cal = calibration(data)
    assert cal.forces == ("F_x", "F_z", "F_y")


@pytest.mark.usefixtures("fakes")
def test_a_table_in_the_plane_knows_nothing_beside_it(sensor: Sensor) -> None:
    """Neither dimensions nor variables, with a moment in the plane either; one number of F_x is a dimension as well."""
    data = calibrate(sensor, F_x=0.1, F_z=[0.0, 1.0], M=[-1e-3, 1e-3])
    assert data["status"].dims == ("F_x", "F_z", "M") and dict(data.sizes)["F_x"] == 1
    assert not {*POSE[3:], *(f"error_{name}" for name in POSE[3:]), *WRENCH[3:]} & set(data.variables)


def test_what_cannot_leave_the_plane_is_refused_by_name(sensor: Sensor) -> None:
    """The model that can is named; values that are none likewise, with their unit."""
    with pytest.raises(SceneError, match="mechanics planar: F_y, M_z must be zero for planar, .*; block would$"):
        calibrate(sensor, F_x=[0.0], F_z=[1.0], F_y=[0.0, 0.1], M_z=1e-3, mechanics="planar")
    with pytest.raises(SceneError, match="magnetics planar: F_y must be zero for planar, .*; sheets would$"):
        calibrate(sensor, F_x=[0.0], F_z=[1.0], F_y=0.1, magnetics="planar")
    with pytest.raises(SceneError, match=r"M_x must be one or more different finite moments \[N m\]"):
        calibrate(sensor, F_x=[0.0], F_z=[1.0], M_x=[1e-3, 1e-3])


def test_more_loads_than_a_table_can_hold_are_refused(sensor: Sensor) -> None:
    """Before anything is made of them."""
    many = np.linspace(0.0, 1.0, 1000)
    with pytest.raises(SceneError, match="^loads: must be at most 100000 of a table; got 1000000000: take fewer"):
        calibrate(sensor, F_x=many, F_z=many, F_y=many)


@pytest.mark.parametrize(
    "values",
    [
        [], [0.1, 0.2, 0.1], [0.1 * 3, 0.3], np.repeat(np.linspace(0.0, 1.0, 99), 2), [np.nan], [0.0, np.inf],
        "1 N", ["a"], None, [[0.0, 1.0], [2.0, 3.0]],
    ],
)
def test_what_is_no_list_of_forces_is_refused_in_one_line(sensor: Sensor, values: Any) -> None:
    """Empty, with a value twice, if only but for rounding, not finite, no numbers, nested: name and what came."""
    for name, what in (("F_y", r"forces \[N\]"), ("M_z", r"moments \[N m\]")):
        with pytest.raises(SceneError, match=f"^{name} must be one or more different finite {what}; got ") as caught:
            calibrate(sensor, F_x=[0.0, 0.1], **{name: values})
        assert "\n" not in str(caught.value) and len(str(caught.value)) < 130


@pytest.mark.usefixtures("fakes")
def test_one_force_alone_makes_a_table(sensor: Sensor) -> None:
    """F_x and F_z need not be given: they are dimensions of one value, zero."""
    data, other = calibrate(sensor, F_z=[0.0, 1.0, 2.0]), calibrate(sensor, M_z=[-1e-3, 0.0, 1e-3])
    assert dict(data.sizes)["F_x"] == 1 and float(data["F_x"][0]) == 0.0
    np.testing.assert_allclose(data["d_v"].to_numpy(), [[2e-3, 1.9e-3, 1.8e-3]], rtol=1e-14)
    assert other["status"].dims == ("F_x", "F_z", "M_z") and other["status"].size == 3
    assert calibration(data).forces == ("F_z",) and calibration(other).forces == ("M_z",)


def test_a_range_and_its_image_are_solved_once() -> None:
    """A range rounds: -0.45 stands beside 0.45000000000000007; what is written otherwise stays."""
    found = checked_values("F_x", np.linspace(-0.9, 0.9, 9))
    assert found == [-value for value in reversed(found)] and found[2] == -0.45
    assert checked_values("F_x", [-1 / 3, 0.0, 1 / 3]) == [-1 / 3, 0.0, 1 / 3]
    assert checked_values("F_x", [-0.2, 0.1, 0.3]) == [-0.2, 0.1, 0.3]


@pytest.mark.slow
def test_a_table_to_strong_loads_holds_what_another_code_finds() -> None:
    """`biorob2018` by NGSolve, Q2 with P1, base cells in 1 and 2 parts, order 2; 1 N, 2 N of reference_pads.json."""
    data = calibrate(load_sensor("biorob2018"), F_x=np.linspace(-1.0, 1.0, 9), F_z=np.linspace(0.0, 4.0, 9))
    assert data.attrs["reached"] < 0.025
    assert sum("interpolated" in str(mark) for mark in data["flags"].values.ravel()) > 50
    found = {
        (0.0, 4.0): (0.0, 336.7), (0.25, 3.5): (273.8, 304.6), (0.75, 2.5): (820.5, 230.9), (0.5, 3.0): (548.8, 269.4),
        (1.0, 3.5): (1062.0, 295.7), (1.0, 2.0): (1098.4, 185.0),
    }
    for (F_x, F_z), (d_h, sink) in found.items():
        row = data.sel(F_x=F_x, F_z=F_z)
        assert abs(float(row.d_h) - 1e-6 * d_h) <= float(row.error_d_h) + 1e-9
        assert abs(2e-3 - float(row.d_v) - 1e-6 * sink) <= float(row.error_d_v)


@pytest.mark.slow
def test_few_loads_stand_for_a_real_grid() -> None:
    """Loads amid 4 x 4 x 4 solved on the whole pad: the table of sparse and turned ones is within both errors."""
    sensor, shear, normal = load_sensor("triaxial-4"), [-0.5, -0.2, 0.2, 0.5], [0.0, 0.6, 1.3, 2.0]
    data = calibrate(sensor, F_x=shear, F_y=shear, F_z=normal, tolerance=1e-2)
    between = [text for text in data["notes"].to_numpy().ravel() if Note(NoteKind.INTERPOLATED) in unpacked(text)]
    assert len(between) > 10
    loads = loads_of({"F_x": shear[2:], "F_z": normal[1:3], "F_y": shear[2:]})
    layer, field = (choose(sensor, "auto", 1e-2, loads)[0] for choose in (mechanical_model, loaded_model))
    found = [layer.equilibrium(load) for load in loads]
    L = field.impedance(Pose.of(poses_of(found).value), sensor.frequency).L
    for load, one, own in zip(loads, found, L, strict=True):
        row = data.sel(F_x=load.F_x, F_z=load.F_z, F_y=load.F_y)
        for name in POSE:
            both = float(row[f"error_{name}"]) + getattr(one.error, name)
            assert abs(float(row[name]) - getattr(one.pose, name)) <= both + 1e-11
        full = np.ptp(np.diagonal(data["L"].to_numpy(), axis1=-2, axis2=-1).reshape(-1, 4), axis=0)
        assert np.all(np.abs(np.diagonal(row["L"].to_numpy() - own)) <= 3e-3 * full)


@pytest.mark.slow
def test_figures_are_within_their_errors_at_a_tenth_of_the_tolerance() -> None:
    """What loads share of their errors cancels in crosstalk, slopes and rotation, and no more than that."""
    sensor, shear, normal = load_sensor("biorob2018-w15"), [-0.5, 0.0, 0.5], [0.0, 2.0, 4.0]
    whole = calibrate(sensor, F_x=np.linspace(-1.0, 1.0, 9), F_z=np.linspace(0.0, 4.0, 9))
    rough, fine = whole.sel(F_x=shear, F_z=normal), calibrate(sensor, F_x=shear, F_z=normal, tolerance=1e-3)
    for (name, value, error, _), (_, true, unsure, _) in zip(figures(rough), figures(fine), strict=True):
        assert abs(value - true) <= error + unsure + 1e-12, name  # some are zero by symmetry, to rounding
    ends = {name: (value, error) for name, value, error, _ in figures(whole)}
    for name in ("crosstalk of F_x into L_v", "crosstalk of F_z into L_h", "rotation read as displacement"):
        assert ends[name][1] < 0.2 * abs(ends[name][0])  # the errors of all loads in full would be 0.2 to 0.7 of them


NOTHING = Linear().impedance(Pose(0.0, 0.0), 1e6)
NOTES = tuple(Note.of(NoteKind.STATED, text=text) for text in "ab")
BETWEEN = (Note(NoteKind.INTERPOLATED),)


def rest_of(error: float = 1e-6, stretch: float | None = 1.2, notes: tuple[Note, ...] = NOTES) -> Settled:
    """A rest whose d_v has an error [m]."""
    report = SolveReport("springs", 6, 1, 0.0, 1e-3, 0.0, min_J=0.9, stretch=stretch, notes=notes)
    return Settled(Equilibrium(Wrench(), Pose.of(REST), Pose(0.0, error), np.zeros(0), report))


def test_a_load_is_marked_by_its_error_its_stretch_and_how_it_was_found(sensor: Sensor) -> None:
    """Without a goal no error counts; of a load without an answer its status does, with the notes that it has."""
    goal = Goal(np.array([[0.0, 1e4, 0.0, 0.0, 0.0, 0.0]]), 0.0)
    known = sensor.elastomer.silicone.known_stretch
    for settled, own, flags, notes in (
        (rest_of(), goal, "ok", NOTES), (rest_of(3e-6), goal, "above tolerance", NOTES),
        (rest_of(3e-6), None, "ok", NOTES), (rest_of(stretch=None), goal, "ok", NOTES),
        (rest_of(notes=BETWEEN), goal, "interpolated", BETWEEN),
    ):
        error = answer_error(own, settled.rest, ())
        found = _marks(sensor, settled, "ok", error, (2e-2, NOTHING))
        assert (found["status"], found["flags"], unpacked(found["notes"])) == (flags, flags, notes)
    far = _marks(sensor, rest_of(stretch=1.5 * known), "ok", 0.0, (2e-2, NOTHING))
    assert far["status"] == "beyond data"
    ended = unpacked(far["notes"])[-1]
    assert ended.kind is NoteKind.DATA_END and ended.known["reached"] == 1.5 * known
    failed = _marks(sensor, Settled(None, status="failed"), "failed", 0.0, (2e-2, NOTHING))
    assert failed == {"status": "failed", "flags": "failed", "notes": ""}
    kept = _marks(sensor, rest_of(), "failed", 0.0, (2e-2, NOTHING))
    assert kept == {"status": "failed", "flags": "failed", "notes": packed(NOTES)}


@pytest.mark.parametrize(("size", "rest_size", "flags"), [
    (5e-3, 0.0, "ok"), (2e-2, 0.0, "above tolerance"), (np.nan, 0.0, "not bounded"), (0.0, np.nan, "not bounded"),
    (5.0, np.nan, "not bounded; above tolerance"),
])
def test_a_load_is_marked_by_what_both_halves_leave_out(
    sensor: Sensor, size: float, rest_size: float, flags: str
) -> None:
    """Of the coils' model it adds to the error; of the other's its pose holds it already."""
    goal = Goal(np.array([[0.0, 1e4, 0.0, 0.0, 0.0, 0.0]]), 0.0)  # 0.01 of the pose's error
    ends = Omission(OmissionKind.PLATE_ENDS, size)
    shown = replace(NOTHING, report=replace(NOTHING.report, left_out=(ends,)))
    settled = rest_of()
    assert settled.rest is not None
    pad = Omission(OmissionKind.PAD_ENDS, rest_size, Relative.DISPLACEMENT)
    report = replace(settled.rest.report, left_out=(pad,))
    error = answer_error(goal, settled.rest, (ends,))
    found = _marks(sensor, Settled(replace(settled.rest, report=report)), "ok", error, (2e-2, shown))
    assert found["flags"] == flags and found["status"] == flags.partition(";")[0]


def test_a_table_keeps_what_its_models_leave_out(sensor: Sensor, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the mechanics in the errors of every pose, by its displacement, which differences of loads do not have."""
    half = Omission(OmissionKind.PAD_ENDS, 0.5, Relative.DISPLACEMENT)
    put(monkeypatch, described("springs", Springs(), (half,)), described("straight", Linear()))
    data = calibrate(sensor, F_x=[-0.1, 0.0, 0.1], F_z=[0.0, 1.0])
    assert unpacked_omissions(data.attrs["left_out"]) == (half,)
    moved = data["d_v"] - 2e-3
    np.testing.assert_allclose(data["error_d_v"], 0.501 * abs(moved), rtol=1e-9)
    assert set(data["status"].sel(F_z=1.0).to_numpy()) == {"above tolerance"}
    assert data.attrs["notes"] == ""


def test_what_was_planned_is_told_where_it_was() -> None:
    assert _promised(AimedLoads({}, Linear(), 1e-2), 0.03) == {}
    found = _promised(AimedLoads({}, Linear(), 1e-2, MeshForecast(0.03, 4.0), 0.02), 0.05)
    assert found == {"planned": [4.0, 0.03], "reached": 0.02, "error": 0.05}
    words = "planned: 4 s, error 3 % of the signals' full scale; reached: 5 s, error 2 %"
    assert kept_promise((4.0, 0.03), (5.0, 0.02), 0.0201) == words
    assert kept_promise((4.0, 0.03), (5.0, 0.02), 0.05) == f"{words}, 5 % with what is left out"


TOUCHED = 'touch={shape="sphere", radius="3 mm", x="0.5 mm"}'
PLANE: dict[str, Any] = {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}


def test_a_table_over_places_holds_what_single_touches_show() -> None:
    """Each load of the table is that of the scene with the touch there; nothing depends on the scene's own place."""
    sensor, F_z, places = load_sensor("biorob2018-w15", [TOUCHED]), [0.2, 0.5], [-1e-3, 0.0, 2e-3]
    data = calibrate(sensor, F_z=F_z, touch_x=places, **PLANE)
    assert dict(data["status"].sizes) == {"F_x": 1, "F_z": 2, "touch_x": 3}
    for force, place in itertools.product(F_z, places):
        row = data.sel(F_x=0.0, F_z=force, touch_x=place)
        there = load_sensor("biorob2018-w15", [TOUCHED, f"touch.x={place}"])
        layer, _ = mechanical_model(there, "linear", 0.1)
        single = layer.equilibrium(Wrench(F_z=force)).pose
        assert [float(row[name]) for name in POSE[:3]] == pytest.approx(
            [single.d_h, single.d_v, single.alpha], abs=2.0 * float(row["error_d_h"]) + 1e-12
        )
        load = wrench_of(row)
        assert load.F_z == force and load.M == pytest.approx((place - 0.5e-3) * force)


def test_mirrored_places_of_a_touch_in_the_middle_are_images(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of five places three are solved."""
    sensor, solved = load_sensor("biorob2018-w15", ['touch={shape="sphere", radius="3 mm"}']), []
    own = touch._followed
    monkeypatch.setattr(touch, "_followed", lambda *asked: solved.append(asked[2]) or own(*asked))
    data = calibrate(sensor, F_z=[0.5], touch_x=[-2e-3, -1e-3, 0.0, 1e-3, 2e-3], **PLANE)
    assert len(set(solved)) == 3
    alpha = data["alpha"].to_numpy().ravel()
    assert np.array_equal(alpha, -alpha[::-1]) and alpha[-1] > 0.0


@pytest.mark.parametrize(("scene", "asked", "words"), [
    ((), {"touch_x": [0.0, 1e-3]}, "touch: must be a table of the scene for touch_x; it is missing"),
    ((TOUCHED,), {"touch_x": [0.0, 8e-3]}, "touch: must lie on the target, .* at x = 8 mm"),
    ((TOUCHED,), {"touch_x": [0.0], "M": 1e-3}, "M: must be left out with a touch's places"),
    ((TOUCHED,), {"F_x": [0.0, 0.1]}, 'touch.friction: must be "sticking" for shear'),
    ((TOUCHED, 'touch.friction="sticking"'), {"F_z": [0.0, 1.0], "F_x": 0.1, "touch_x": [0.0]}, "F_z: must not be 0"),
    ((TOUCHED,), {"drift": True}, "touch: must be left out of the scene for drift"),
])
def test_places_that_a_touch_cannot_have_are_refused(scene: tuple[str, ...], asked: Any, words: str) -> None:
    """In one line, with key and numbers."""
    with pytest.raises(SceneError, match=words):
        calibrate(load_sensor("biorob2018-w15", scene), **{"F_z": [0.5], **asked}, **PLANE)
