"""A synthetic bench: another silicone, more gap, leads and noise are found again; the command says so."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.built import comparison
from sits_mech.analysis.built.comparison import compare
from sits_mech.analysis.readings.bench import sensor_calibration, terminals
from sits_mech.analysis.readings.codes import tank_of
from sits_mech.analysis.readings.measured import Measured, read_measured
from sits_mech.chain.calibrate import calibrate
from sits_mech.cli.main import run
from sits_mech.quantities import POSE, Impedance, Pose, SolveReport
from sits_mech.readout.loads import several
from sits_mech.report.folder import cases_folder
from sits_mech.report.pictures.style import save_figure
from sits_mech.report.plots.measured import comparison_figure
from sits_mech.scene.sensor import Sensor, changed, load_sensor, save_sensor
from sits_mech.silicone.material import table_of
from sits_mech.store import save_table

FACTOR, GAP, LEAD, NOISE = 0.87, 12e-6, 40e-9, 2e-11


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    """The published sensor."""
    return load_sensor("biorob2018-w15")


@pytest.fixture(scope="module")
def data(sensor: Sensor) -> xr.Dataset:
    """Its calibration."""
    return calibrate(sensor, F_x=np.linspace(-1.0, 1.0, 5), F_z=np.linspace(0.0, 4.0, 5), mechanics="linear")


@pytest.fixture(scope="module")
def bench(sensor: Sensor) -> Measured:
    """Loads on a sensor with a softer silicone on a thin film, read through leads, with noise; solved on its own."""
    assert sensor.elastomer is not None
    table = table_of(sensor.elastomer.silicone)
    soft = {key: table[key] * (1.0 if key == "law" else FACTOR) for key in ("c10", "c20", "c30", "bulk_modulus")}
    written = ", ".join(f"{key} = {value!r}" for key, value in soft.items())
    other = changed(sensor, [f'elastomer.material={{law = "yeoh", {written}}}', f"elastomer.standoff={GAP}"])
    F_x, F_z = [-0.7, -0.2, 0.3, 0.8], [0.2, 1.2, 2.2, 3.2]
    shown = calibrate(other, F_x=F_x, F_z=F_z, mechanics="linear")
    L = terminals(other, shown)[0]["L"].transpose("F_x", "F_z", "coil").to_numpy()
    loads = np.stack(np.meshgrid(F_x, F_z, indexing="ij"), -1).reshape(-1, 2)
    noise = NOISE * np.random.default_rng(5).standard_normal((16, 2))
    return Measured(loads, L.reshape(-1, 2) + LEAD + noise, "synthetic")


@pytest.mark.slow
def test_modulus_gap_and_lead_come_back(sensor: Sensor, data: xr.Dataset, bench: Measured) -> None:
    """Each within three sigma, 1.5 of its 95 % interval: one draw of noise; the misfit falls.

    Gap and lead hardly differ: their own intervals are wide.
    """
    found = compare(sensor, data, bench)
    for name, value, width, true in zip(
        found.fit.names, found.fit.values, found.fit.half_widths, (FACTOR, GAP, LEAD), strict=True
    ):
        assert abs(value - true) <= 1.5 * width, (name, value, width, true)
    assert found.fit.half_widths[0] < 0.01 and found.fit.rms < 0.1 * found.fit.rms_before
    assert sensor.elastomer is not None
    assert found.shear_modulus == pytest.approx(FACTOR * sensor.elastomer.silicone.shear_modulus, rel=0.01)


@pytest.mark.slow
def test_loads_that_come_again_are_solved_once(
    sensor: Sensor, data: xr.Dataset, bench: Measured, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three readings of each load, in another order: the same parameters, by the loads of one."""
    sizes, order = list[int](), np.random.default_rng(0).permutation(48) % 16
    bench_of = comparison.LoadedBench

    def told(*given: Any) -> Any:
        sizes.append(len(given[2]))
        return bench_of(*given)

    monkeypatch.setattr(comparison, "LoadedBench", told)
    again = Measured(bench.forces[order], bench.L[order], "again")
    one, three = (compare(sensor, data, each) for each in (bench, again))
    assert sizes == [16, 16]
    assert three.fit.values == pytest.approx(one.fit.values, rel=1e-3) and three.fit.residual.shape == (48, 2)
    np.testing.assert_allclose(three.fit.residual, one.fit.residual[order], atol=1e-12)


@pytest.mark.slow
def test_what_cannot_be_compared_is_refused(sensor: Sensor, data: xr.Dataset, bench: Measured) -> None:
    """Unknown parameters; forces beyond the table."""
    with pytest.raises(ValueError, match="fit: must be modulus, .* or a key of the scene, .* got \"colour\""):
        compare(sensor, data, bench, ["modulus", "colour"])
    far = Measured(1.5 * bench.forces, bench.L, "far")
    with pytest.raises(ValueError, match="table: must reach beyond the measured forces"):
        compare(sensor, data, far, ["gap"])
    with pytest.raises(ValueError, match=r"modulus: must fit .* between 0.7\d+ and 10; .* upper end, 10"):
        compare(sensor, data, bench, ["modulus"])  # no modulus makes up for leads


@pytest.mark.slow
@pytest.mark.parametrize("free", ["modulus", "modulus,gap,lead"])
def test_a_perfect_bench_has_modulus_one(sensor: Sensor, data: xr.Dataset, free: str) -> None:
    """Loads of the whole table, as its terminals show them: the scene itself, though softer ones leave the table."""
    L = terminals(sensor, data)[0]["L"].transpose("F_x", "F_z", "coil").to_numpy()
    loads = np.stack(np.meshgrid(data["F_x"], data["F_z"], indexing="ij"), -1)
    bench = Measured(loads.reshape(-1, 2), L.reshape(-1, 2), "perfect")
    fit = compare(sensor, data, bench, free.split(",")).fit
    for value, width, true in zip(fit.values, fit.half_widths, (1.0, 0.0, 0.0), strict=False):
        assert abs(value - true) <= max(width, 1e-6)
    assert abs(fit.values[0] - 1.0) < 1e-3 and fit.half_widths[0] < 0.01
    with pytest.raises(ValueError, match=r"for F_z from -0.\d+ to 4.\d+ N, the measurement has 5.2 N"):
        compare(sensor, data, Measured(1.3 * bench.forces, bench.L, "far"), ["gap"])


class Corners:
    """Four coils that see the target's height and where it is, by hand [H]."""

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return the closed form."""
        x, y, z = np.moveaxis(pose.centre / 1e-3, -1, 0)
        signs = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        rows = [0.2 * np.exp(-0.5 * z) * (1.0 + 0.1 * np.tanh(a * x + b * y)) for a, b in signs]
        L, one = 2.5e-6 * (1.0 - np.stack(rows, -1))[..., None] * np.eye(4), np.ones(np.shape(x))[..., None, None]
        report = SolveReport("corners", 1, 1, 0.0, 0.0, 0.0)
        return Impedance(frequency, L, one * np.eye(4), 2.5e-6 * np.eye(4), np.ones(4), 1e-5 * L, 0.0 * L, "H", report)


def three_axes() -> tuple[Sensor, xr.Dataset]:
    """A calibration of three forces whose target moves by hand over `Corners`."""
    scene = load_sensor("triaxial-4")
    axes = {"F_x": np.linspace(-0.5, 0.5, 3), "F_z": np.linspace(0.0, 2.0, 5), "F_y": np.linspace(-0.5, 0.5, 3)}
    x, z, y = np.meshgrid(*axes.values(), indexing="ij")
    rest = Pose(4e-4 * x, 2e-3 - 1e-4 * z * (1.0 - 0.1 * z), 0.01 * x, 4e-4 * y, -0.01 * y, 0.0 * x)
    shown, names = Corners().impedance(rest, scene.frequency), [coil.name for coil in scene.coils]
    table, pair = xr.Dataset(coords={**axes, "coil": names, "coil_2": names}), (*axes, "coil", "coil_2")
    for name in ("L", "R", "error_L", "error_R"):
        table[name] = (pair, getattr(shown, name))
    table["L0"] = (pair[-2:], shown.L0)
    for name, values in zip(POSE, np.moveaxis(rest.components, -1, 0), strict=True):
        table[name] = (tuple(axes), values)
    table["status"] = (tuple(axes), np.full(x.shape, "ok", dtype=object))
    request = json.dumps({"magnetics": "corners", "tolerance": 1e-2})
    return scene, table.assign_attrs(unit_L="H", frequency=scene.frequency, request=request)


@pytest.mark.slow
def test_three_axes_by_codes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Codes of four coils at random loads of three forces, from a layer a tenth softer, written and read."""
    scene, table = three_axes()
    monkeypatch.setattr(comparison, "loaded_model", lambda *_: (Corners(), None))
    known = sensor_calibration(scene, table)
    F = np.random.default_rng(6).uniform([-0.44, 0.1, -0.44], [0.44, 1.7, 0.44], (30, 3))
    for true in (1.0, 0.9):
        rows = [",".join(f"{number!r}" for number in row) for row in np.c_[F, np.rint(known.codes(F / true))].tolist()]
        (tmp_path / "bench.csv").write_text("F_x,F_z,F_y,code1,code2,code3,code4\n" + "\n".join(rows))
        tank = tank_of(scene, table)
        bench = read_measured(tmp_path / "bench.csv", several(table), list(known.coils), tank)
        found = compare(scene, table, bench, ["modulus", "lead"])
        assert found.fit.values[0] == pytest.approx(true, abs=0.005)
        assert abs(found.fit.values[0] - true) <= 2.0 * found.fit.half_widths[0]
    figure = comparison_figure(found, list(known.coils))
    save_figure(figure, tmp_path / "rest.png")
    with pytest.raises(ValueError, match=r"column M_x: must be 0 N m, the calibration varies F_x, F_z, F_y alone; got"):
        (tmp_path / "bench.csv").write_text("F_x,F_z,F_y,M_x [N mm],L1,L2,L3,L4\n" + "1,1,1,3,4,4,4,4\n" * 5)
        read_measured(tmp_path / "bench.csv", several(table), list(known.coils))


@pytest.mark.slow
def test_compare_command(
    sensor: Sensor, data: xr.Dataset, bench: Measured, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A CSV in, parameters out, a picture."""
    cases_folder(tmp_path).mkdir()
    save_table(data, tmp_path / "result.nc")
    save_sensor(sensor, tmp_path / "scene.toml")
    rows = [f"{x},{z},{1e6 * a!r},{1e6 * b!r}" for (x, z), (a, b) in zip(bench.forces, bench.L.tolist(), strict=True)]
    (tmp_path / "bench.csv").write_text("F_x [N],F_z [N],L1 [uH],L2 [uH]\n" + "\n".join(rows))
    words = ["compare", str(tmp_path), str(tmp_path / "bench.csv")]
    assert run([*words, "--json", "-o", str(tmp_path / "rest.png")]) == 0
    record = json.loads(capsys.readouterr().out)
    modulus = record["parameters"]["modulus"]
    assert abs(modulus["value"] - FACTOR) <= modulus["half_width"] and record["rows"] == 16
    assert (tmp_path / "rest.png").read_bytes()[:4] == b"\x89PNG"
    assert run([*words, "--free", "modulus, lead"]) == 0
    assert "shear modulus" in capsys.readouterr().out
    assert run([*words, "--free", "x"]) == 2
