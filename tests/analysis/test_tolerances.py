"""Forces misread by tolerances: what follows from the definition, and what symmetry forbids."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis import tolerances
from sits_mech.analysis.readings.bench import sensor_calibration
from sits_mech.analysis.tolerances import evaluation_points, force_spread, loads_inside, spread
from sits_mech.chain.calibrate import calibrate
from sits_mech.cli.main import run
from sits_mech.quantities import Equilibrium, Impedance, Pose, SolveReport, Wrench
from sits_mech.readout.calibration import calibration_of
from sits_mech.scene.sensor import Coil, SceneError, Sensor, changed, load_sensor, save_sensor, scene_hash, scene_text
from sits_mech.store import save_table

REPORT = SolveReport("by hand", 1, 1, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Spring:
    """1e-4 m/N along x and y, 2e-5 m/N down; keeps what it bore."""

    borne: list[Wrench] = field(default_factory=list)

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the closed form."""
        self.borne.append(wrench)
        pose = Pose(1e-4 * wrench.F_x, 2e-3 - 2e-5 * wrench.F_z, 0.0, 1e-4 * wrench.F_y)
        return Equilibrium(wrench, pose, Pose(0.0, 0.0), np.zeros(3), REPORT)


@dataclass(frozen=True)
class Near:
    """A coil at (x, y) sees 1 + 50 d_v - 1e4 (x d_h + y d_y) of 2 H."""

    coils: tuple[Coil, ...]

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return the closed form."""
        x, y = np.array([coil.centre for coil in self.coils]).T
        d_h, d_v, _, d_y, *_ = np.moveaxis(pose.components, -1, 0)[..., None]
        L, one = (1.0 + 50.0 * d_v - 1e4 * (x * d_h + y * d_y))[..., None] * np.eye(len(x)), np.eye(len(x))
        return Impedance(frequency, L, 0 * L, 2.0 * one, np.zeros(len(x)), 0 * L, 0 * L, "H", REPORT)


def three_axes(sensor: Sensor, near: type[Near] = Near) -> xr.Dataset:
    """Return the table of `Spring` and `near` over F_x, F_z and F_y, M_z beside them of one value."""
    axes = {"F_x": np.linspace(-0.5, 0.5, 3), "F_z": np.linspace(0.0, 2.0, 3), "F_y": np.linspace(-0.5, 0.5, 3)}
    F_x, F_z, F_y = np.meshgrid(*axes.values(), indexing="ij")
    found = near(sensor.coils).impedance(Pose(1e-4 * F_x, 2e-3 - 2e-5 * F_z, 0.0, 1e-4 * F_y), 5e6)
    coils = [coil.name for coil in sensor.coils]
    dims, request = (*axes, "coil", "coil_2"), {"mechanics": "block", "magnetics": "sheets", "tolerance": 0.01}
    data = xr.Dataset({"L": (dims, found.L), "L0": (dims[3:], found.L0)}, axes | {"coil": coils, "coil_2": coils})
    data = data.assign({name: 0.0 * data["L"] for name in ("R", "error_L", "error_R")})
    data["status"] = (dims[:3], np.full(F_x.shape, "ok"))
    return data.assign_coords(M_z=1e-3).assign_attrs(unit_L="H", frequency=5e6, request=json.dumps(request))


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    """The published sensor."""
    return load_sensor("biorob2018-w15")


@pytest.fixture(scope="module")
def data(sensor: Sensor) -> xr.Dataset:
    """Its calibration at small strain, which costs next to nothing."""
    forces = {"F_x": np.linspace(-1.0, 1.0, 5), "F_z": np.linspace(0.0, 4.0, 5)}
    return calibrate(sensor, **forces, mechanics="linear", magnetics="planar")


@pytest.mark.slow
def test_a_stiffer_layer_reads_less_force(sensor: Sensor, data: xr.Dataset) -> None:
    """Modulus (1 + d): the pose of F / (1 + d) is read as that force: the error scatters by F s."""
    found = force_spread(sensor, data, {"modulus": 0.02}, [[0.0, 2.0], [0.6, 0.0]], samples=16)
    table = found.table()
    assert float(table["deviation"].sel(load=0, force="F_z")) == pytest.approx(2.0 * 0.02, rel=0.03)
    assert float(table["deviation"].sel(load=1, force="F_x")) == pytest.approx(0.6 * 0.02, rel=0.03)
    assert float(table["deviation"].sel(load=0, force="F_x")) < 1e-6
    np.testing.assert_allclose(table["first"].sel(load=0, force="F_z"), 1.0, atol=0.02)


@pytest.mark.slow
def test_an_offset_of_the_coils_is_shear(sensor: Sensor, data: xr.Dataset) -> None:
    """Without shear an offset is tared away for F_z; a gap never feigns shear there; shares add up."""
    found = force_spread(sensor, data, {"gap": 1e-5, "offset": 3e-5}, [[0.0, 2.0], [0.5, 2.0]], samples=16).table()
    first = found["first"]
    assert float(first.sel(load=0, force="F_x", cause="offset")) > 0.95
    assert float(first.sel(load=0, force="F_z", cause="gap")) > 0.95
    np.testing.assert_allclose(first.sum("cause").sel(load=1), 1.0, atol=0.05)
    assert np.all(found["low"] < found["high"]) and found["F_z"].to_numpy().tolist() == [2.0, 2.0]


def test_three_forces_of_a_stiffer_layer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each is read as what it is, less by the modulus; an offset along x is tared away, it feigns no F_y."""
    sensor = load_sensor("triaxial-3", ['readout.converter="none"'])
    spring = Spring()
    monkeypatch.setattr(tolerances, "mechanical_model", lambda *_: (spring, None))
    monkeypatch.setattr(tolerances, "loaded_model", lambda scene, *_: (Near(scene.coils), None))
    data = three_axes(sensor)
    loads = loads_inside(sensor_calibration(sensor, data))
    np.testing.assert_allclose(loads, [[0.0, 1.0, 0.0], [0.25, 1.0, 0.25], [0.25, 2.0, 0.25]], atol=1e-12)
    found = force_spread(sensor, data, {"modulus": 0.02}, loads.tolist(), samples=16).table()
    np.testing.assert_allclose(found["deviation"], 0.02 * np.abs(loads), rtol=0.03, atol=1e-9)
    moved = force_spread(sensor, data, {"offset": 1e-4}, loads.tolist(), samples=16).table()
    np.testing.assert_allclose(moved["deviation"], 0.0, atol=1e-9)
    assert all(load.M_z == pytest.approx(1e-3, rel=0.1) for load in spring.borne)


def test_forces_are_read_as_the_calibration_reads_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three coils that disagree on two forces are weighed by their noise: one that is hardly trusted misleads less."""
    sensor, bend = load_sensor("triaxial-3", ['readout.converter="none"']), np.array([1.0, 0.0, 0.0])

    @dataclass(frozen=True)
    class Bent(Near):
        """The first coil bends with the distance."""

        def impedance(self, pose: Pose, frequency: float) -> Impedance:
            found = super().impedance(pose, frequency)
            return replace(found, L=found.L + 1e4 * np.asarray(pose.d_v)[..., None, None] ** 2 * np.diag(bend))

    monkeypatch.setattr(tolerances, "mechanical_model", lambda *_: (Spring(), None))
    monkeypatch.setattr(tolerances, "loaded_model", lambda scene, *_: (Bent(scene.coils), None))
    data = three_axes(sensor, Bent).isel(F_y=[1])
    cal = replace(sensor_calibration(sensor, data), weights=np.array([0.2, 1.0, 1.0]))
    monkeypatch.setattr(tolerances, "sensor_calibration", lambda *_: cal)
    found = force_spread(sensor, data, {"gap": 1e-4}, [[0.1, 1.5]], samples=16).table()
    shown = 2e4 * 1e-4 * -2e-5 * 1.5 * bend  # of one deviation, tared
    expected = np.abs(cal.answers(np.array([[0.1, 1.5]]))[0] @ shown)
    assert float(found["deviation"].sel(force="F_z")[0]) == pytest.approx(expected[1], rel=0.02)


def test_loads_around_the_middle() -> None:
    """F_z at its end last; where there is no F_z two loads are one."""
    points = np.stack(np.meshgrid([-1.0, 0.0, 1.0], [0.0, 2.0, 4.0], indexing="ij"), -1).reshape(-1, 2)
    expected = {"F_z": [[0.0, 2.0], [0.5, 2.0], [0.5, 4.0]], "M": [[0.0, 2.0], [0.5, 3.0]]}
    for other, loads in expected.items():
        words = {"forces": ("F_x", other), "coils": ("C1", "C2"), "free": ("H", [1.0, 1.0])}
        cal = calibration_of(points, 1.0 + points @ [[1, 2], [3, 4]], **words)
        np.testing.assert_allclose(loads_inside(cal), loads)


def test_what_has_no_tolerance_is_refused(
    sensor: Sensor, data: xr.Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Unknown names, deviations of none, more than there is."""
    with pytest.raises(ValueError, match="must be some of thickness, modulus, gap, offset; got colour"):
        force_spread(sensor, data, {"colour": 1.0}, [[0.0, 1.0]])
    with pytest.raises(SceneError, match="gap: must be a positive deviation; got 0"):
        force_spread(sensor, data, {"gap": 0.0}, [[0.0, 1.0]])
    with pytest.raises(SceneError, match=r"modulus: must be a positive deviation below 0\.3; got 0\.31"):
        force_spread(sensor, data, {"modulus": 0.31}, [[0.0, 1.0]], samples=16)
    with pytest.raises(SceneError, match=r"thickness: must be a positive deviation below 0\.000667; got 0\.0007"):
        force_spread(sensor, data, {"thickness": 7e-4}, [[0.0, 1.0]], samples=16)
    with pytest.raises(SceneError, match="samples: must be at least 4 for 1 tolerances; got 2"):
        force_spread(sensor, data, {"gap": 1e-5}, [[0.0, 1.0]], samples=2)
    monkeypatch.setattr(tolerances, "mechanical_model", lambda *_: (Spring(), None))
    with pytest.raises(SceneError, match="gap, thickness: three deviations must leave the target clear; pose: "):
        force_spread(sensor, data, {"gap": 2e-3}, [[0.0, 1.0]], samples=8)


@pytest.mark.slow
def test_quality_command(
    sensor: Sensor, data: xr.Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Figures with and without tolerances, for a program and for a reader; noise doubled, resolution doubled."""
    save_table(data, tmp_path / "result.nc")
    save_sensor(sensor, tmp_path / "scene.toml")
    found = []
    for noise in ("10 fH", "20 fH"):
        assert run(["quality", str(tmp_path), "--noise", noise, "--json"]) == 0
        found.append(json.loads(capsys.readouterr().out))
    fine, coarse = (np.array(record["resolution"]["F_z"]) for record in found)
    np.testing.assert_allclose(coarse, 2.0 * fine, rtol=1e-9)
    assert found[0]["full_scale"] == {"F_x": [-1.0, 1.0], "F_z": [0.0, 4.0]} and found[0]["no_inverse"] == []
    assert found[0]["crosstalk"]["F_z"]["F_x"] > 0.0 and found[0]["hysteresis"] == {"F_x": None, "F_z": None}
    assert run(["quality", str(tmp_path), "--modulus", "2 %", "--samples", "8"]) == 0
    said = capsys.readouterr()
    assert "modulus 100 %" in said.out and "by default the converter's" in said.err
    assert "below its error" in said.out and "error (90 %)" in said.out
    assert run(["quality", str(tmp_path), "--modulus", "2 %", "--samples", "7"]) == 2
    assert "--samples: must be a power of two, such as 32; got 7" in capsys.readouterr().err
    assert run(["quality", str(tmp_path), "--gap", "2 N"]) == 2
    assert run(["quality", str(tmp_path), "--period", "0 s"]) == 2
    assert "period must be a positive time" in capsys.readouterr().err
    bare = changed(sensor, ['readout.converter="none"'])
    save_table(data.assign_attrs(scene=scene_text(bare), scene_hash=scene_hash(bare)), tmp_path / "result.nc")
    save_sensor(bare, tmp_path / "scene.toml")
    assert run(["quality", str(tmp_path), "--noise", "10 fH"]) == 0
    assert run(["quality", str(tmp_path)]) == 2
    assert "--noise: must be given" in capsys.readouterr().err


@pytest.mark.slow
def test_quality_of_forces_that_two_coils_cannot_resolve(
    three_forces: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """F_y is named; what needs an inverse, or loads that start from none, says so in one line."""
    assert run(["quality", str(three_forces), "--noise", "10 fH"]) == 0
    said = capsys.readouterr().out
    assert "F_y: moves the coils by less than their noise" in said and "infinite: more forces than coils" in said
    assert run(["converter", str(three_forces)]) == 0 and "RCOUNT0" in capsys.readouterr().out
    assert run(["quality", str(three_forces), "--modulus", "5 %"]) == 2
    assert "the coils do not resolve all of F_x, F_z, F_y" in capsys.readouterr().err
    assert run(["quality", str(three_forces), "--period", "1 s"]) == 2
    assert "loads start from none; this one holds M = 0.001 N m" in capsys.readouterr().err


NAMES = ("thickness", "modulus", "gap")
S = np.array([0.1, 0.2, 0.05])


def test_a_sum_by_hand() -> None:
    """y = a . x: variance sum (a_i s_i)^2, shares (a_i s_i)^2 over it, first-order and total alike."""
    a = np.array([3.0, -1.0, 4.0])
    x = evaluation_points(S, 32)
    found = spread(NAMES, S, x, 5.0 + x @ np.stack([a, 0.0 * a], -1))
    variance = np.sum((a * S) ** 2)
    assert found.mean[0] == pytest.approx(5.0, abs=2e-3)
    assert found.deviation[0] == pytest.approx(np.sqrt(variance), rel=0.01)
    np.testing.assert_allclose(found.first[0], (a * S) ** 2 / variance, atol=0.02)
    np.testing.assert_allclose(found.total[0], found.first[0], atol=0.02)
    width = 1.96 * np.sqrt(variance)
    np.testing.assert_allclose(found.interval[0], [5.0 - width, 5.0 + width], atol=0.03 * width)
    assert found.deviation[1] < 1e-12 and np.all(np.isnan(found.first[1]))


def test_a_product_acts_together() -> None:
    """y = x1 x2 has no first-order shares at all, and total shares of one each."""
    x = evaluation_points(S, 64)
    found = spread(NAMES, S, x, (x[:, :1] * x[:, 1:2]) * 1e-6)
    np.testing.assert_allclose(found.first[0], [0.0, 0.0, 0.0], atol=0.05)
    np.testing.assert_allclose(found.total[0], [1.0, 1.0, 0.0], atol=0.08)
    assert found.deviation[0] == pytest.approx(1e-6 * S[0] * S[1], rel=0.05)


@pytest.mark.slow
def test_plain_drawing_agrees() -> None:
    """200,000 random draws of the function itself."""

    def answer(x: np.ndarray) -> np.ndarray:
        return np.exp(2.0 * x[:, :1] + x[:, 1:2]) / (1.0 + x[:, 2:])

    x = evaluation_points(S, 128)
    found = spread(NAMES, S, x, answer(x))
    drawn = answer(np.random.default_rng(0).standard_normal((200_000, 3)) * S)
    assert found.mean[0] == pytest.approx(drawn.mean(), rel=0.005)
    assert found.deviation[0] == pytest.approx(drawn.std(), rel=0.03)
    np.testing.assert_allclose(found.interval[0], np.quantile(drawn, [0.025, 0.975]), rtol=0.02)
    assert found.map_error[0] < 0.02 * found.deviation[0]


def test_points_without_answers_are_counted() -> None:
    """They are left out of the map."""
    x = evaluation_points(S, 32)
    failed = np.where(np.arange(32)[:, None] < 20, np.nan, x)
    found = spread(NAMES, S, x, failed)
    assert np.isfinite(found.mean).all() and found.failed == 20 and spread(NAMES, S, x, x).failed == 0
