"""Forces misread by tolerances: what follows from the definition, and what symmetry forbids."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.tolerances import force_spread
from sits_mech.cases import save_table
from sits_mech.chain.calibrate import calibrate
from sits_mech.cli.main import run
from sits_mech.scene.sensor import Sensor, load_sensor, save_sensor


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    """The published sensor."""
    return load_sensor("biorob2018-w15")


@pytest.fixture(scope="module")
def data(sensor: Sensor) -> xr.Dataset:
    """Its calibration at small strain, which costs next to nothing."""
    forces = {"F_x": np.linspace(-1.0, 1.0, 5), "F_z": np.linspace(0.0, 4.0, 5)}
    return calibrate(sensor, **forces, mechanics="linear")


def test_a_stiffer_layer_reads_less_force(sensor: Sensor, data: xr.Dataset) -> None:
    """Modulus (1 + d): the pose of F / (1 + d) is read as that force: the error scatters by F s."""
    found = force_spread(sensor, data, {"modulus": 0.02}, [[0.0, 2.0], [0.6, 0.0]], samples=16)
    table = found.table()
    assert float(table["deviation"].sel(load=0, force="F_z")) == pytest.approx(2.0 * 0.02, rel=0.03)
    assert float(table["deviation"].sel(load=1, force="F_x")) == pytest.approx(0.6 * 0.02, rel=0.03)
    assert float(table["deviation"].sel(load=0, force="F_x")) < 1e-6
    np.testing.assert_allclose(table["first"].sel(load=0, force="F_z"), 1.0, atol=0.02)


def test_an_offset_of_the_coils_is_shear(sensor: Sensor, data: xr.Dataset) -> None:
    """Without shear an offset is tared away for F_z; a gap never feigns shear there; shares add up."""
    found = force_spread(sensor, data, {"gap": 1e-5, "offset": 3e-5}, [[0.0, 2.0], [0.5, 2.0]], samples=16).table()
    first = found["first"]
    assert float(first.sel(load=0, force="F_x", cause="offset")) > 0.95
    assert float(first.sel(load=0, force="F_z", cause="gap")) > 0.95
    np.testing.assert_allclose(first.sum("cause").sel(load=1), 1.0, atol=0.05)
    assert np.all(found["low"] < found["high"]) and found["F_z"].to_numpy().tolist() == [2.0, 2.0]


def test_what_has_no_tolerance_is_refused(sensor: Sensor, data: xr.Dataset) -> None:
    """Unknown names, deviations of none, more than there is."""
    with pytest.raises(ValueError, match="must be some of thickness, modulus, gap, offset; got colour"):
        force_spread(sensor, data, {"colour": 1.0}, [[0.0, 1.0]])
    with pytest.raises(ValueError, match="deviations: must be positive"):
        force_spread(sensor, data, {"gap": 0.0}, [[0.0, 1.0]])
    with pytest.raises(ValueError, match="must leave three deviations of modulus and thickness positive"):
        force_spread(sensor, data, {"modulus": 0.5}, [[0.0, 1.0]], samples=16)


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
    assert "modulus 100 %" in said.out and "default noise" in said.err
    assert run(["quality", str(tmp_path), "--gap", "2 N"]) == 2
    assert run(["quality", str(tmp_path), "--period", "0 s"]) == 2
    assert "period must be a positive time" in capsys.readouterr().err
