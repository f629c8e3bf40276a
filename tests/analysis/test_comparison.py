"""A synthetic bench: another silicone, more gap, leads and noise are found again; the command says so."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.bench import free_inductances
from sits_mech.analysis.comparison import compare
from sits_mech.cases import save_table
from sits_mech.chain.calibrate import calibrate
from sits_mech.cli.main import run
from sits_mech.readout.measured import Measured
from sits_mech.report.folder import cases_folder
from sits_mech.scene.sensor import Sensor, changed, load_sensor, save_sensor
from sits_mech.silicone.material import table_of

FACTOR, GAP, LEAD, NOISE = 0.87, 12e-6, 40e-9, 2e-11


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    """The published sensor."""
    return load_sensor("biorob2018-w15")


@pytest.fixture(scope="module")
def data(sensor: Sensor) -> xr.Dataset:
    """Its calibration."""
    return calibrate(sensor, F_x=np.linspace(-1.0, 1.0, 5), F_z=np.linspace(0.0, 4.0, 5), mechanics="planar")


@pytest.fixture(scope="module")
def bench(sensor: Sensor) -> Measured:
    """Loads on a sensor with a softer silicone on a thin film, read through leads, with noise; solved on its own."""
    assert sensor.elastomer is not None
    table = table_of(sensor.elastomer.silicone)
    soft = {key: table[key] * (1.0 if key == "law" else FACTOR) for key in ("c10", "c20", "c30", "bulk_modulus")}
    written = ", ".join(f"{key} = {value!r}" for key, value in soft.items())
    other = changed(sensor, [f'elastomer.material={{law = "yeoh", {written}}}', f"elastomer.standoff={GAP}"])
    F_x, F_z = [-0.7, -0.2, 0.3, 0.8], [0.2, 1.2, 2.2, 3.2]
    shown = calibrate(other, F_x=F_x, F_z=F_z, mechanics="planar")
    L = np.diagonal(shown["L"].to_numpy(), axis1=2, axis2=3) / np.diagonal(shown["L0"]) * free_inductances(sensor)
    loads = np.stack(np.meshgrid(F_x, F_z, indexing="ij"), -1).reshape(-1, 2)
    noise = NOISE * np.random.default_rng(5).standard_normal((16, 2))
    return Measured(loads, L.reshape(-1, 2) + LEAD + noise, "synthetic")


def test_modulus_gap_and_lead_come_back(sensor: Sensor, data: xr.Dataset, bench: Measured) -> None:
    """Each inside its 95 % interval (gap and lead hardly differ: their own intervals are wide); the misfit falls."""
    found = compare(sensor, data, bench)
    for name, value, width, true in zip(
        found.fit.names, found.fit.values, found.fit.half_widths, (FACTOR, GAP, LEAD), strict=True
    ):
        assert abs(value - true) <= width, (name, value, width, true)
    assert found.fit.half_widths[0] < 0.01 and found.fit.rms < 0.1 * found.fit.rms_before
    assert sensor.elastomer is not None
    assert found.shear_modulus == pytest.approx(FACTOR * sensor.elastomer.silicone.shear_modulus, rel=0.01)


def test_what_cannot_be_compared_is_refused(sensor: Sensor, data: xr.Dataset, bench: Measured) -> None:
    """Unknown parameters; forces beyond the table."""
    with pytest.raises(ValueError, match="fit: must be some of modulus, gap, lead; got colour"):
        compare(sensor, data, bench, ["modulus", "colour"])
    far = Measured(1.5 * bench.forces, bench.L, "far")
    with pytest.raises(ValueError, match="table: must reach beyond the measured forces"):
        compare(sensor, data, far, ["gap"])
    with pytest.raises(ValueError, match="modulus: must fit from 0.8 to 10; the best value is at an end, 10"):
        compare(sensor, data, bench, ["modulus"])  # no modulus makes up for leads


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
