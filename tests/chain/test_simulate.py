"""The bridge: with models whose answers are known by hand, and with the real ones."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
import xarray as xr

from sits_mech.chain import models
from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.models import magnetic_model, mechanical_model
from sits_mech.chain.omitted import mechanical as leaving
from sits_mech.chain.omitted.mechanical import with_omissions
from sits_mech.chain.plans import aimed
from sits_mech.chain.plans.goal import answer_error, rest_flags
from sits_mech.chain.propagation import levers, poses_of, read_poses
from sits_mech.chain.rests import at_rest, image_at_rest
from sits_mech.chain.simulate import simulate
from sits_mech.description import Description, Rung, sized
from sits_mech.geometry.collision import Collision
from sits_mech.magnetics.bars import planar_bars
from sits_mech.mechanics.loads import kept_key, kept_rest, outward, settle
from sits_mech.mechanics.symmetry import Symmetry
from sits_mech.notes import NoteKind, Omission, OmissionKind, Relative
from sits_mech.quantities import POSE, Array, Bounded, Equilibrium, Impedance, Pose, SolveFailed, SolveReport, Wrench
from sits_mech.report.records import failure_record
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor, sensor_from
from sits_mech.store import read_table, save_table

REPORT = SolveReport("spring", 3, 1, 0.0, 1e-3, 0.0, min_J=0.9)
SECTION = {"mechanics": "planar", "magnetics": "planar"}
LIMIT = 6.0  # load that the spring carries [N]
SOLVED: list[Wrench] = []


@dataclass(frozen=True)
class Spring:
    """d_h = F_x / 2500, sink = F_z / 5000, alpha = F_x / 200; errors of a thousandth."""

    height: float

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the pose in closed form."""
        SOLVED.append(wrench)
        if abs(wrench.F_z) > LIMIT:
            report = SolveReport("spring", 3, 9, 1.0, 1.0, 0.0, "load path ended")
            raise SolveFailed("beyond what the spring carries", report)
        d_h, sink, alpha = wrench.F_x / 2500, wrench.F_z / 5000, wrench.F_x / 200
        error = Pose(abs(d_h) / 1000, abs(sink) / 1000, abs(alpha) / 1000)
        return Equilibrium(wrench, Pose(d_h, self.height - sink, alpha), error, np.array([d_h, sink, alpha]), REPORT)


@dataclass(frozen=True)
class Linear:
    """L1, L2 = 1 + 100 d_v +- (20 d_h - alpha / 10), own error 1e-6; R = 3 - d_v."""

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return the closed form."""
        common = 1.0 + 100.0 * np.asarray(pose.d_v)
        odd = 20.0 * np.asarray(pose.d_h) - np.asarray(pose.alpha) / 10.0
        zero = np.zeros_like(common)
        L = np.stack([np.stack([common + odd, zero], -1), np.stack([zero, common - odd], -1)], -2)
        R = np.broadcast_to(3.0 - np.asarray(pose.d_v)[..., None, None], L.shape)
        error = np.full(L.shape, 1e-6)
        report = SolveReport("linear", 1, 1, 0.0, 1e-6, 0.0)
        return Impedance(frequency, L, R, 2.0 * np.eye(2), np.ones(2), error, error, "H", report)


def put(monkeypatch: pytest.MonkeyPatch, half: str, model: object, *left_out: Omission) -> None:
    """Put a model that holds every scene behind the name "planar", alone; one of the mechanics with a rigid target."""
    if half == "MECHANICS":
        monkeypatch.setattr(leaving, "bending", lambda *_: ())
    rungs = (Rung(0.0, 1, 1, 0.0, 0.0),)
    own = Description("planar", lambda *_: model, lambda *_: None, lambda *_: left_out, rungs, 0.0)
    for module in (models, leaving) if half == "MECHANICS" else (models, aimed):
        monkeypatch.setattr(module, half, {"planar": own})


@pytest.fixture
def fakes(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Put the models by hand behind the names."""
    put(monkeypatch, "MECHANICS", Spring(2e-3))
    put(monkeypatch, "MAGNETICS", Linear())
    SOLVED.clear()
    yield


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    """The published sensor."""
    return load_sensor("biorob2018")


@pytest.mark.usefixtures("fakes")
def test_simulate_by_hand(sensor: Sensor) -> None:
    """Pose, inductance, signals and their errors of a linear chain: |slope| times error, plus the model's own."""
    found = simulate(sensor, Wrench(1.0, 2.0), mechanics="planar")  # by name: its errors are its own
    assert (found.equilibrium.pose.d_h, found.equilibrium.pose.alpha) == (4e-4, 5e-3)
    odd = 20.0 * 4e-4 - 5e-4
    np.testing.assert_allclose(np.diagonal(found.impedance.L), [1.16 + odd, 1.16 - odd], rtol=1e-14)
    by_pose = 100.0 * 4e-7 + 20.0 * 4e-7 + 5e-6 / 10.0
    np.testing.assert_allclose(np.diagonal(found.impedance.error_L), 1e-6 + by_pose, rtol=1e-6)
    assert found.signals.L_v == pytest.approx(2.32, rel=1e-14)
    assert found.signals.L_h_percent == pytest.approx(100.0 * 2.0 * odd / 2.0, rel=1e-12)
    assert found.signals.error_L_v == pytest.approx(2e-6 + 2.0 * 100.0 * 4e-7, rel=1e-6)
    assert found.signals.error_L_h == pytest.approx(2e-6 + 2.0 * (20.0 * 4e-7 + 5e-7), rel=1e-6)


@pytest.mark.usefixtures("fakes")
def test_coils_that_fail_leave_the_pose(sensor: Sensor, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was reached is where the target rests; the report of either half is in its place."""
    stalled = SolveReport("planar", 9, 1, 1.0, 0.5, 0.1, "stalled")

    def fails(*_: object) -> None:
        raise SolveFailed("no field", stalled)

    monkeypatch.setattr(Linear, "impedance", fails)
    with pytest.raises(SolveFailed, match="no field") as caught:
        simulate(sensor, Wrench(1.0, 2.0))
    record = failure_record(caught.value, whole=True)
    assert record["pose"]["d_h"] == 4e-4 and record["wrench"]["F_z"] == 2.0
    assert record["report"]["mechanics"]["status"] == "converged"
    assert record["report"]["magnetics"]["status"] == "stalled"


@pytest.mark.usefixtures("fakes")
def test_calibrate_by_hand(sensor: Sensor, tmp_path: Path) -> None:
    """Every load at its place; mirrored loads are not solved; a failure and a collision are rows."""
    done: list[tuple[int, int]] = []
    loads = {"F_x": [1.0, -1.0, 0.0], "F_z": [0.0, 2.0, 7.0]}
    data = calibrate(sensor, **loads, progress=lambda n, of: done.append((n, of)))
    assert data["L"].dims == ("F_x", "F_z", "coil", "coil_2") and data["coil"].to_numpy().tolist() == ["C1", "C2"]
    row = data.sel(F_x=-1.0, F_z=2.0)
    assert float(row["d_h"]) == -4e-4 and float(row["alpha"]) == -5e-3 and float(row["d_v"]) == 1.6e-3
    assert float(row["L_h_untilted_percent"]) == pytest.approx(-100.0 * 20.0 * 4e-4, rel=1e-12)
    assert float(row["min_J"]) == 0.9 and float(row["error_mechanics"]) == 1e-3
    assert data["status"].sel(F_z=7.0).to_numpy().tolist() == ["not carried"] * 3
    assert "beyond" in data["reason"].sel(F_x=0.0, F_z=7.0).item()
    assert np.isnan(data["L_v"].sel(F_z=7.0)).all() and np.isfinite(data["L_v"].sel(F_z=[0.0, 2.0])).all()
    assert SOLVED[0] == Wrench(0.0, 0.0) and all(wrench.F_x >= 0.0 for wrench in SOLVED) and len(SOLVED) == 6
    assert done[-1] == (9, 9) and len(done) == 9
    request = json.loads(data.attrs["request"])
    assert request["F_x"] == [-1.0, 0.0, 1.0] and request["mechanics"] == "planar" and data.attrs["unit_L"] == "H"
    save_table(data, tmp_path / "result.nc")
    assert read_table(tmp_path / "result.nc").identical(data)


@pytest.mark.usefixtures("fakes")
def test_a_load_says_what_its_error_is_to_the_tolerance(sensor: Sensor, monkeypatch: pytest.MonkeyPatch) -> None:
    """Errors of the spring are a thousandth: within a hundredth of the signals, not within a hundred thousandth."""
    errors: list[float] = []

    def noted(*given: Any) -> float:
        errors.append(answer_error(*given))
        return errors[-1]

    monkeypatch.setattr("sits_mech.chain.simulate.answer_error", noted)
    for tolerance, word in ((1e-2, "ok"), (1e-5, "above tolerance")):
        data = calibrate(sensor, F_x=[0.0, 1.0], F_z=[0.0, 2.0], tolerance=tolerance)
        assert data["status"].sel(F_x=1.0, F_z=2.0).item() == data["flags"].sel(F_x=1.0, F_z=2.0).item() == word
        found = simulate(sensor, Wrench(1.0, 2.0), tolerance=tolerance)
        assert found.flags == (word,)
        missed = [note for note in found.impedance.report.notes if note.kind is NoteKind.SIGNALS_MISSED]
        assert len(missed) == (word != "ok")
        for note in missed:  # the parts are the error, and the coil is the one with the largest
            parts = [note.known[part] for part in ("pose", "model", "left_out")]
            assert min(parts) >= 0.0 and sum(parts) == pytest.approx(100.0 * errors[-1], rel=1e-12)
            assert errors[-1] > tolerance and note.known["component"] in POSE[:3]
            off = np.diag(found.impedance.error_L)
            assert note.known["coil"] == sensor.coil_names[int(np.argmax(off))]


@pytest.mark.usefixtures("fakes")
def test_the_scene_comes_back_from_a_calibration(sensor: Sensor) -> None:
    """The attributes hold all that is needed to do it again."""
    import tomllib

    data = calibrate(sensor, F_x=[0.0], F_z=[1.0])
    assert sensor_from(tomllib.loads(data.attrs["scene"])) == sensor


@pytest.mark.usefixtures("fakes")
def test_collision_is_a_row_and_an_error(sensor: Sensor, monkeypatch: pytest.MonkeyPatch) -> None:
    """The target is never taken through the coils: named at one load, a row in a calibration."""
    put(monkeypatch, "MECHANICS", Spring(1e-3))
    with pytest.raises(Collision, match="above the coil plane"):
        simulate(sensor, Wrench(0.0, 5.5))
    data = calibrate(sensor, F_x=[0.0], F_z=[1.0, 5.5])
    assert data["status"].to_numpy().tolist() == [["ok", "failed"]]
    assert "coil plane" in data["reason"].sel(F_z=5.5).item() and np.isnan(data["L_v"].sel(F_z=5.5)).all()


@pytest.mark.usefixtures("fakes")
def test_a_stopped_calibration_goes_on(sensor: Sensor, tmp_path: Path) -> None:
    """What is finished is not solved again, and the answer is the same."""
    loads = {"F_x": [-1.0, 0.0, 1.0], "F_z": [0.0, 2.0]}

    def stop(n: int, of: int) -> None:
        if n == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        calibrate(sensor, **loads, progress=stop, folder=tmp_path)
    assert len(SOLVED) == 3
    resumed = calibrate(sensor, **loads, folder=tmp_path)
    assert len(SOLVED) == 4
    xr.testing.assert_equal(resumed.drop_vars("seconds"), calibrate(sensor, **loads).drop_vars("seconds"))


def test_a_settled_load_is_kept_as_a_start(sensor: Sensor, tmp_path: Path) -> None:
    """A picture of it takes no second solve; of a load that was not asked for, or mirrored, nothing is kept."""
    data = calibrate(sensor, F_x=[-0.5, 0.5], F_z=[1.0], mechanics="planar", magnetics="planar", folder=tmp_path)
    keep, wrench = (tmp_path, kept_key(sensor, "planar", 1e-2)), Wrench(0.5, 1.0)
    kept = kept_rest(keep, wrench)
    assert kept is not None and kept.pose.d_v == float(data["d_v"].sel(F_x=0.5, F_z=1.0))
    again = mechanical_model(sensor, "planar", 1e-2)[0].equilibrium(wrench, start=kept)
    assert again.pose.d_h == pytest.approx(kept.pose.d_h, rel=1e-9)
    assert kept_rest(keep, Wrench(-0.5, 1.0)) is None and kept_rest((None, ""), wrench) is None


def test_a_kept_touch_is_as_deep_as_it_was(tmp_path: Path) -> None:
    """What acts on the target and how deep a shape stands come back from disk, for pictures and tables."""
    load, keep = Wrench(F_z=1.0), (tmp_path, "key")
    rest = Equilibrium(load, Pose(0.0, 1e-3), Pose(0.0, 0.0), np.zeros(0), SolveReport("", 1, 1, 0.0, 0.0, 0.0),
                       acting=Wrench(0.1, 1.0), sunk=(1.5e-4, 1e-6))

    class Layer:
        def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
            return rest

    first, again = settle(Layer(), [load], symmetry=Symmetry(), keep=keep)[load].rest, kept_rest(keep, load)
    assert first is not None and again is not None
    assert (again.acting, again.sunk) == (first.acting, first.sunk) == (rest.acting, rest.sunk)


def test_what_cannot_be_asked_is_refused(sensor: Sensor) -> None:
    """Unknown model, no layer, tolerance, forces: one line each."""
    words = 'mechanics.*one of auto, closed-form, linear, planar, axisymmetric, block; got "blok"'
    with pytest.raises(SceneError, match=words):
        mechanical_model(sensor, "blok")
    with pytest.raises(SceneError, match="magnetics.*must be one of auto, axisymmetric, planar"):
        magnetic_model(sensor, "sheet")
    with pytest.raises(SceneError, match="elastomer: must be given"):
        mechanical_model(sensor.model_copy(update={"elastomer": None}))
    for tolerance in (0.0, 2.0, float("nan")):
        with pytest.raises(SceneError, match="tolerance must lie between 0 and 1"):
            simulate(sensor, Wrench(), tolerance=tolerance)
    for forces in ([], [1.0, 1.0], [float("nan")]):
        with pytest.raises(SceneError, match="F_x must be one or more different finite forces"):
            calibrate(sensor, F_x=forces, F_z=[0.0])


def test_error_of_the_pose_reaches_the_inductance(sensor: Sensor) -> None:
    """Real magnetics: the reported error covers what a pose off by its error changes, without being ten times it."""
    model = planar_bars(sensor, 1e-3)
    pose, error = Pose(3e-4, 1.7e-3, 4e-3), Pose(2e-6, 2e-6, 2e-6)
    found = read_poses(sensor, model, Bounded.of(pose.components[None], error.components[None]))
    worst: Array = np.zeros((2, 2))
    for signs in np.ndindex(2, 2, 2):
        shift = [2e-6 * (2 * sign - 1) for sign in signs]
        moved = model.impedance(Pose(3e-4 + shift[0], 1.7e-3 + shift[1], 4e-3 + shift[2]), sensor.frequency)
        worst = np.maximum(worst, np.abs(moved.L - found.impedance.L[0]))
    assert np.all(found.impedance.error_L[0] >= worst) and np.all(found.impedance.error_L[0] < 10.0 * worst)


@pytest.fixture(scope="module")
def calibration(sensor: Sensor) -> xr.Dataset:
    """The chain on a small grid, in the section; that in space is in test_calibrate.py."""
    return calibrate(sensor, F_x=[-0.5, 0.0, 0.5], F_z=[0.0, 2.0], **SECTION)


@pytest.mark.slow
def test_mirrored_shear_swaps_the_coils(sensor: Sensor, calibration: xr.Dataset) -> None:
    """F_x -> -F_x swaps L1 and L2 to rounding, in a calibration and with both loads solved on their own."""
    L = calibration["L"].to_numpy()
    np.testing.assert_allclose(L[::-1, :, ::-1, ::-1], L, rtol=1e-12)
    right, left = (simulate(sensor, Wrench(F_x, 2.0), **SECTION) for F_x in (0.5, -0.5))
    np.testing.assert_allclose(left.impedance.L[::-1, ::-1], right.impedance.L, rtol=1e-9)


def test_a_grid_and_a_single_load_agree(sensor: Sensor, calibration: xr.Dataset) -> None:
    """The way to a load does not matter beyond the reported error."""
    single = simulate(sensor, Wrench(0.5, 2.0), **SECTION)
    row = calibration.sel(F_x=0.5, F_z=2.0)
    for name in ("d_h", "d_v", "alpha"):
        assert abs(float(row[name]) - float(getattr(single.equilibrium.pose, name))) <= float(row[f"error_{name}"])
    assert abs(float(row["L_v"]) - float(single.signals.L_v)) <= float(row["error_L_v"])


def test_the_signals_answer_as_the_sensor_was_made_to(calibration: xr.Dataset) -> None:
    """Pressing lowers both inductances; shear to the right covers C2 more, so that L1 - L2 rises."""
    assert np.all(calibration["status"] == "above tolerance")  # what plane strain and the section leave out
    assert np.all(calibration["L_v"].diff("F_z") < 0.0) and np.all(calibration["L_h"].diff("F_x") > 0.0)
    assert np.all(calibration["d_h"].sel(F_x=0.5) > 0.0)
    assert np.all(calibration["error_L_v"] > 0.0)


def test_without_load_the_layer_rests(sensor: Sensor, calibration: xr.Dataset) -> None:
    """No force, no motion: d_v is thickness plus stand-off."""
    rest = calibration.sel(F_x=0.0, F_z=0.0)
    assert sensor.elastomer is not None
    assert float(rest["d_v"]) == pytest.approx(sensor.elastomer.thickness + sensor.elastomer.standoff, abs=1e-12)
    assert abs(float(rest["d_h"])) < 1e-12 and abs(float(rest["alpha"])) < 1e-12


@dataclass(frozen=True)
class Sliding:
    """A spring that remembers where it was drawn first: d_h of the first load of the way stays."""

    height: float

    def along(self, loads: Sequence[Wrench]) -> Equilibrium:
        """Return the spring's pose under the last load, d_h under the first."""
        spring = Spring(self.height)
        first, last = spring.equilibrium(loads[0]), spring.equilibrium(loads[-1])
        return replace(last, pose=replace(last.pose, d_h=first.pose.d_h))

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the pose straight from rest."""
        return self.along([wrench])


def test_the_way_of_the_load_is_asked_of_a_layer_with_friction_alone() -> None:
    """What is left of shear that has gone is not taken for rounding by the symmetry of the last load."""
    rough = load_sensor("biorob2018", ["elastomer.friction=0.3"])
    via, load = [Wrench(F_x=0.5)], Wrench(F_z=1.0)
    found = at_rest(rough, Sliding(2e-3), load, (), via)
    assert found.wrench == load and found.pose.d_h == 0.5 / 2500
    assert at_rest(rough, Sliding(2e-3), load, ()).pose.d_h == 0.0
    assert at_rest(rough, Sliding(2e-3), Wrench(F_z=2.0), (), [load]).pose.d_h == 0.0
    for sensor, layer in ((load_sensor("biorob2018"), Sliding(2e-3)), (rough, Spring(2e-3))):
        with pytest.raises(SceneError, match=r"via: must be left out without elastomer\.friction"):
            at_rest(sensor, layer, load, (), via)


@dataclass(frozen=True)
class Ending:
    """A spring that carries half of any load."""

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Fail at half of the load, known to a tenth of it."""
        half = Wrench(*(wrench.components / 2).tolist())
        carried = half, Wrench(*(wrench.components / 20).tolist())
        raise SolveFailed("ended", REPORT, Spring(2e-3).equilibrium(half), carried=carried)


@pytest.mark.parametrize("kind", ["rectangle", "disc"])
def test_a_failure_is_that_of_the_load_and_not_of_its_image(kind: Literal["rectangle", "disc"]) -> None:
    """What was carried lies along the load, whichever image of it was solved; errors have no sign."""
    load = Wrench(F_x=-1.0, F_z=2.0, F_y=-0.5)
    with pytest.raises(SolveFailed, match=r"ended \(an image of the load was solved\)") as caught:
        image_at_rest(Symmetry(kind), Ending(), load)
    last, (most, off) = caught.value.last, caught.value.carried
    np.testing.assert_allclose([last.wrench.components, most.components], 2 * [load.components / 2], atol=1e-15)
    assert last.pose.d_h < 0.0 and np.all(off.components >= 0.0) and off.F_x > 0.0
    with pytest.raises(SolveFailed, match="ended$"):
        image_at_rest(Symmetry(kind), Ending(), Wrench(F_x=1.0))


def test_a_frequency_of_waves_is_refused_before_the_layer_is_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sits_mech.chain.plans.aimed.mechanical_model", None)
    with pytest.raises(ValueError, match="frequency: must be below"):
        simulate(load_sensor("biorob2018", ['frequency="10 GHz"']), Wrench(F_z=0.1))


HALF = Omission(OmissionKind.PAD_ENDS, 0.5, Relative.DISPLACEMENT)
OF_D_V = Omission(OmissionKind.PAD_ENDS, 0.2, Relative.DISPLACEMENT, parts=(0.0, 0.2, 0.1, 0.0, 0.0, 0.0))


def rest(F_x: float, F_z: float, model: str = "planar") -> Equilibrium:
    """The spring under a load, by a model's name."""
    found = Spring(2e-3).equilibrium(Wrench(F_x, F_z))
    return replace(found, report=replace(found.report, model=model))


@pytest.mark.parametrize(("item", "shares"), [(HALF, (0.5, 0.5, 0.5)), (OF_D_V, (0.0, 0.2, 0.1))])
def test_what_the_mechanics_leave_out_is_a_shared_part_of_the_poses_error(
    sensor: Sensor, monkeypatch: pytest.MonkeyPatch, item: Omission, shares: tuple[float, ...]
) -> None:
    """Errors grow by it, with the displacement from rest; of the difference of two loads it is that of theirs.

    The error over the displacement grows by its largest part over that: half of a small sink under shear is little.
    """
    put(monkeypatch, "MECHANICS", Spring(2e-3), item)
    before, lever = [rest(1.0, 2.0), rest(1.0, 2.5), rest(1.0, 0.2)], levers(sensor)
    after = with_omissions(sensor, before, before[0].report.model)
    for old, new in zip(before, after, strict=True):
        moved = new.pose.components - [0.0, 2e-3, 0.0, 0.0, 0.0, 0.0]
        own = np.array([*shares, 0.0, 0.0, 0.0])
        np.testing.assert_allclose(new.error.components - old.error.components, own * np.abs(moved), atol=1e-18)
        np.testing.assert_allclose(new.shared[-1], own * moved, atol=1e-18)
        assert new.report.left_out == (item,)
        share = np.max(own * np.abs(moved) * lever) / np.max(np.abs(moved) * lever)
        assert new.report.estimated_error == pytest.approx(old.report.estimated_error + share)
    apart = poses_of(after)[1] - poses_of(after)[0]
    numerics = poses_of(before)[1] - poses_of(before)[0]
    np.testing.assert_allclose(
        apart.error[:3] - numerics.error[:3], np.array(shares) * np.abs(apart.value[:3]), atol=1e-18
    )
    assert apart.error[1] < 0.6 * after[0].error.d_v or shares[1] == 0.0


@pytest.mark.parametrize(("item", "listed", "flags"), [
    (replace(HALF, size=np.nan), True, ("not bounded",)), (replace(HALF, counts=False), False, ("ok",)),
    (replace(HALF, included=True), True, ("ok",)), (replace(HALF, size=0.0), False, ("ok",)),
    (HALF, True, ("above tolerance",)),
])
def test_what_has_no_size_or_does_not_count_is_in_no_error(
    sensor: Sensor, monkeypatch: pytest.MonkeyPatch, item: Omission, listed: bool, flags: tuple[str, ...]
) -> None:
    """What the model's own error holds is listed, and not added again."""
    put(monkeypatch, "MECHANICS", Spring(2e-3), item)
    (found,) = with_omissions(sensor, [rest(1.0, 2.0)], rest(1.0, 2.0).report.model)
    assert (found.report.left_out == (item,)) == listed
    grown = found.error.d_v > rest(1.0, 2.0).error.d_v
    assert grown == (flags == ("above tolerance",)) and rest_flags(sensor, found, 1e-2) == flags


def test_a_model_without_a_description_leaves_nothing_out(sensor: Sensor) -> None:
    found = rest(1.0, 2.0, "spring")
    assert with_omissions(sensor, [found], "spring")[0] is found
    assert with_omissions(sensor, [], "spring") == []


class Named(Spring):
    """The spring, under the name of a model that is described."""

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        found = super().equilibrium(wrench)
        return replace(found, report=replace(found.report, model="planar"))


@pytest.mark.usefixtures("fakes")
def test_a_simulation_is_flagged_by_what_both_halves_leave_out(
    sensor: Sensor, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And lists it: of the mechanics in the pose's report, of the coils in the other; alike in a table."""
    air = Omission(OmissionKind.NOT_CUT, np.nan, numbers=(("name", "nut"),))
    for items, flags in (
        ((), ("ok",)), ((HALF,), ("above tolerance",)), ((HALF, air), ("not bounded", "above tolerance")),
    ):
        put(monkeypatch, "MECHANICS", Named(2e-3), *items[:1])
        put(monkeypatch, "MAGNETICS", Linear(), *items[1:])
        found = simulate(sensor, Wrench(1.0, 2.0))
        assert found.flags == flags and found.status == flags[0]
        assert found.equilibrium.report.left_out + found.impedance.report.left_out == items
        row = calibrate(sensor, F_x=[0.0, 1.0], F_z=[0.0, 2.0]).sel(F_x=1.0, F_z=2.0)
        assert row["flags"].item() == "; ".join(flags)


STIFF = ['target.backing_thickness="5 mm"', 'target.backing_modulus="70 GPa"']  # a target that hardly bends


@pytest.mark.slow
def test_plane_strain_and_a_section_hold_what_space_has() -> None:
    """A plate of 15 mm under 2 N: 90.5 um in space, 12 in plane strain, whose error holds the difference.

    By closed forms, as so much is left out: they say 1.04 to 1.8 times of it.
    """
    sensor = load_sensor("biorob2018", ['target.width="15 mm"', *STIFF])
    flat = simulate(sensor, Wrench(F_z=2.0), **SECTION)
    pose, error = flat.equilibrium.pose, flat.equilibrium.error
    left = abs(2e-3 - 90.5e-6 - pose.d_v)
    assert 2e-3 - pose.d_v < 15e-6 and 1.04 * left < error.d_v < 1.8 * left
    assert flat.status == "above tolerance"
    kinds = [[item.kind for item in report.left_out] for report in (flat.equilibrium.report, flat.impedance.report)]
    assert kinds == [[OmissionKind.PAD_ENDS], [OmissionKind.PLATE_ENDS, OmissionKind.TRACKS]]


@pytest.mark.slow
@pytest.mark.parametrize("F_z", [0.5, 2.0])
def test_plane_strain_holds_what_space_finds(F_z: float) -> None:
    """The whole chain in space, against its quick stand-in."""
    sensor = load_sensor("biorob2018", ['target.width="15 mm"', *STIFF])
    flat, space = simulate(sensor, Wrench(F_z=F_z), **SECTION), simulate(sensor, Wrench(F_z=F_z))
    assert space.status == "ok" and flat.status == "above tolerance"
    off = np.abs(flat.equilibrium.pose.components - space.equilibrium.pose.components)
    assert np.all(off <= flat.equilibrium.error.components + space.equilibrium.error.components + 1e-15)
    if F_z == 2.0:
        assert 2e-3 - space.equilibrium.pose.d_v == pytest.approx(90.5e-6, rel=0.02)


RUBBER = [
    *STIFF,
    'elastomer.material={law="neo-hookean", shear_modulus="466822 Pa", bulk_modulus="4.6667e8 Pa"}',
    *(f'{part}.{side}="20 mm"' for part in ("elastomer", "target") for side in ("width", "length")),
    'elastomer.thickness="2 mm"',
]


@pytest.mark.slow
@pytest.mark.parametrize("F_z", [10.0, 15.0, 20.0, 25.0, 30.0])
def test_a_flush_rubber_pad_is_answered_within_a_hundredth(F_z: float) -> None:
    """Whatever model is the cheapest for its load."""
    assert simulate(load_sensor("biorob2018", RUBBER), Wrench(F_z=F_z)).status == "ok"


@pytest.mark.slow
def test_a_promise_is_planned_kept_and_told() -> None:
    """Of a layer with meshes, over the signals' full scale; it holds the magnetics as well."""
    found = simulate(load_sensor("biorob2018-w15"), Wrench(0.5, 2.0), **SECTION)
    assert found.promise is not None
    planned, seconds, reached, error = found.promise
    assert 1 / 3 < planned.error / reached < 3 and reached < 1e-2 < error and seconds > 0.0  # ends of plane strain
    assert simulate(load_sensor("biorob2018"), Wrench(0.1), mechanics="linear", magnetics="planar").promise is None


@pytest.mark.slow
def test_a_tolerance_that_is_not_to_be_had_is_refused_or_answered_with_what_is() -> None:
    sensor, load, asked = load_sensor("biorob2018-w15"), Wrench(0.5, 2.0), 1e-5
    with pytest.raises(SceneError, match=r"one that can be reached at F_x = 0.5 N, F_z = 2 N, .* s, which best takes$"):
        simulate(sensor, load, tolerance=asked, best=False, **SECTION)
    for tolerance, kept in ((1e-3, True), (asked, False)):  # the flags hold the ends of plane strain as well
        found = simulate(sensor, load, tolerance=tolerance, **SECTION)
        assert found.promise is not None and (found.promise.reached < tolerance) is kept
        assert found.flags == ("above tolerance",)


@dataclass(frozen=True)
class Meshes(Spring):
    """The spring on meshes: ten times as far off on the first ones, on finer ones as far as is asked."""

    coarse: float = 10.0
    asked: tuple[float, ...] = ()

    @property
    def rough(self) -> "Meshes":
        return replace(self, coarse=10.0 * self.coarse)

    def towards(self, goal: Array, tolerance: float, deepest: int = 99) -> "Meshes":
        """Errors are those of d_v, which moves L1 and L2 alike, within what is asked of the goal."""
        TOWARDS.append((goal, tolerance))
        return replace(self, coarse=1.0)

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        found = super().equilibrium(wrench)
        STARTS.append(start)
        error = Pose.of(self.coarse * found.error.components)
        return replace(found, error=error, report=replace(found.report, estimated_error=1e-3 * self.coarse))


@dataclass(frozen=True)
class OneMesh(Spring):
    """The spring so many times as far off."""

    coarse: float

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        found = super().equilibrium(wrench)
        error = Pose.of(self.coarse * found.error.components)
        return replace(found, error=error, report=replace(found.report, estimated_error=1e-3 * self.coarse))


class NamedMeshes(Meshes):
    """The same under the name of a model that is described."""

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        found = super().equilibrium(wrench, start=start)
        return replace(found, report=replace(found.report, model="planar"))


TOWARDS: list[tuple[Array, float]] = []
STARTS: list[Equilibrium | None] = []


@dataclass(frozen=True)
class Curved(Meshes):
    """The same with a state of the second degree in the load, after the number of its family."""

    family: int = 0

    def state(self, F_x: float, F_z: float) -> Array:
        """Return the state under a load."""
        return np.array([self.family, 3.0 + F_x - 2.0 * F_z, F_x**2 + F_x * F_z - 0.5 * F_z**2])

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        return replace(super().equilibrium(wrench, start=start), state=self.state(wrench.F_x, wrench.F_z))


@pytest.mark.parametrize(("family", "ahead"), [(0, True), (2, False)])
def test_loads_start_from_where_states_near_them_lead(family: int, ahead: bool) -> None:
    """Exactly, of the second degree, from the tenth load of 4 x 3 on; in contact from the nearest one."""
    STARTS.clear()
    loads = [Wrench(F_x, F_z) for F_x in (0.0, 0.4, 0.7, 1.0) for F_z in (0.5, 1.0, 1.5)]
    model = Curved(2e-3, family=family)
    settle(model, loads, symmetry=Symmetry("none"))
    began = [start for start in STARTS if start is not None]
    assert len(began) == 11 and all(start.wrench in loads for start in began)
    led = [np.allclose(start.state, model.state(load.F_x, load.F_z), rtol=1e-9)
           for start, load in zip(began, outward(loads)[1:], strict=True)]
    assert all(led[8:]) if ahead else not any(led)
    for start in began if not ahead else began[:1]:
        np.testing.assert_allclose(start.state, model.state(start.wrench.F_x, start.wrench.F_z))


@pytest.fixture
def meshes(monkeypatch: pytest.MonkeyPatch, fakes: None) -> None:
    """Put the spring on meshes behind the name."""
    put(monkeypatch, "MECHANICS", Meshes(2e-3))
    TOWARDS.clear()
    STARTS.clear()


@pytest.mark.usefixtures("meshes")
def test_first_meshes_tell_what_the_signals_need(sensor: Sensor) -> None:
    """Solved once on them and once as far as the goal asks, from there; promised and reached are told."""
    found = simulate(sensor, Wrench(1.0, 2.0), tolerance=5e-2)
    assert SOLVED == [Wrench(1.0, 2.0)] * 2 and STARTS[0] is None and STARTS[1] is not None
    assert STARTS[1].error.d_v == pytest.approx(100.0 * 4e-7) and found.equilibrium.error.d_v == pytest.approx(4e-7)
    ((goal, left),) = TOWARDS
    sizes = np.ptp([[2.4, 0.0], [2.32, 0.015]], axis=0)  # of L_v and L_h from rest on
    np.testing.assert_allclose(goal[:, :3], np.array([[0.0, 200.0, 0.0], [40.0, 0.0, -0.2]]) / sizes.max(), atol=1e-6)
    assert left == pytest.approx(5e-2 - 4e-6 / sizes.max(), rel=1e-3)
    promise, first = found.promise, 100.0 * 4e-7 * 200.0 / sizes.max()
    assert promise is not None and promise.planned.error == pytest.approx(first, rel=0.01)
    assert promise.reached == pytest.approx(4e-7 * 200.0 / sizes.max() + 4e-6 / sizes.max(), rel=0.05)
    assert promise.seconds < 5.0 and found.flags == ("ok",)


@pytest.mark.usefixtures("meshes")
@pytest.mark.parametrize(("share", "given"), [(0.0, 1.0), (0.1, 0.9), (0.3, 0.7), (0.7, 1.0)])
def test_numerics_are_given_what_omissions_leave_of_a_tolerance(
    sensor: Sensor, monkeypatch: pytest.MonkeyPatch, share: float, given: float
) -> None:
    """Where at least half of it is left: in one solve."""
    tolerance = 1.25 * 200.0 * 4e-7 / 0.08  # numerics take 0.8 of it, and a little for the coils
    size = share * tolerance
    item = Omission(OmissionKind.BENDING, size, Relative.DISPLACEMENT, parts=(0.0, size, 0.0, 0.0, 0.0, 0.0))
    put(monkeypatch, "MECHANICS", NamedMeshes(2e-3))
    monkeypatch.setattr(leaving, "bending", lambda *_: (item,))
    report = simulate(sensor, Wrench(1.0, 2.0), tolerance=tolerance).equilibrium.report
    ((_, left),) = TOWARDS
    assert left == pytest.approx(given * tolerance - 4e-6 / 0.08) and item.size == sized(report.left_out)


@pytest.mark.usefixtures("fakes")
@pytest.mark.parametrize(("missed", "name"), [(0.5, "planar"), (0.97, "block")])
def test_one_mesh_is_chosen_again_to_what_the_coils_leave(
    sensor: Sensor, monkeypatch: pytest.MonkeyPatch, missed: float, name: str
) -> None:
    """The coils take a twentieth: more of the mesh where that will do, else the next model; by name it stays."""
    tolerance, load = 1e-3, Wrench(F_z=2.0)
    item = Omission(OmissionKind.FINITE_STRAIN, missed * tolerance, Relative.DISPLACEMENT, included=True)

    def described(own: str, work: int, *left_out: Omission) -> Description:
        """A model whose errors are a little less than asked, with what it leaves out."""
        def made(_: Sensor, asked: float) -> OneMesh:
            return OneMesh(2e-3, 1e3 * (0.99 * asked + sum(one.size for one in left_out)))
        return Description(own, made, lambda *_: None, lambda *_: left_out, (Rung(0.0, work, work, 0.0, 0.0),), 0.0)

    known = {"planar": described("planar", 1, item), "block": described("block", 9)}
    for module in (models, leaving):
        monkeypatch.setattr(module, "MECHANICS", known)
    found = simulate(sensor, load, tolerance=tolerance)
    assert found.flags == ("ok",) and [kind.kind for kind in found.left_out] == [item.kind] * (name == "planar")
    table = calibrate(sensor, F_x=[0.0], F_z=[2.0], tolerance=tolerance)
    assert set(table["status"].values.ravel()) == {"ok"} and json.loads(table.attrs["request"])["mechanics"] == name
    assert simulate(sensor, load, tolerance=tolerance, mechanics="planar").flags == ("above tolerance",)


@pytest.mark.usefixtures("meshes")
def test_a_tolerance_below_what_meshes_promise_is_refused_where_that_is_asked(sensor: Sensor) -> None:
    """The first meshes are a tenth off, and nothing tells that finer ones get further."""
    said = "tolerance: must be one that can be reached at F_x = 1 N, F_z = 2 N, M = 0 N m; got 0.01: 0.1 can be reached"
    with pytest.raises(SceneError, match=said):
        simulate(sensor, Wrench(1.0, 2.0), best=False)
    with pytest.raises(SceneError, match=said):
        calibrate(sensor, F_x=[0.0, 1.0], F_z=[1.0, 2.0], best=False, **SECTION)
    assert len(SOLVED) == 2 and TOWARDS == []
    assert simulate(sensor, Wrench(1.0, 2.0)).promise is not None and len(TOWARDS) == 1


@pytest.mark.usefixtures("meshes")
def test_without_a_change_of_signals_all_meshes_are_solved(sensor: Sensor, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sits_mech.chain.rests.aim_at", lambda *_: None)
    found = simulate(sensor, Wrench(1.0, 2.0))
    assert found.promise is None and found.equilibrium.error.d_v == pytest.approx(10.0 * 4e-7) and TOWARDS == []


@pytest.mark.usefixtures("meshes")
def test_a_table_is_looked_at_under_the_load_whose_components_are_largest(sensor: Sensor) -> None:
    """Each by its own largest, of images one; what was planned and reached is in the table."""
    table = calibrate(sensor, F_x=[-1.0, 0.5], F_z=[5.0], tolerance=5e-2, **SECTION)
    near, far = Wrench(0.5, 5.0), Wrench(1.0, 5.0)
    assert SOLVED == [far, near, near, far] and len(TOWARDS) == 2
    assert table.attrs["planned"][1] > 5e-2 > table.attrs["reached"] and table.attrs["planned"][0] > 0.0
    SOLVED.clear()
    calibrate(sensor, F_x=[-1.0, 0.5], F_z=[1.0, 5.0], tolerance=5e-2, **SECTION)
    assert SOLVED[0] == far
