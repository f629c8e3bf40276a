"""The command for a built sensor: a plan, readings of five lines, the corrected calibration that others read."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.built.prior import prior_of
from sits_mech.cases import save_table
from sits_mech.chain.calibrate import calibrate
from sits_mech.cli.main import run
from sits_mech.report.folder import read_calibration
from sits_mech.scene.sensor import Sensor, load_sensor, save_sensor

LOADS = np.array([[0.0, 0.0], [0.3, 0.0], [0.3, 1.2], [-0.3, 1.2], [0.0, 0.6]])
Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A calibration by models that cost little, and beside it readings of a softer sensor whose target is turned."""
    folder = tmp_path_factory.mktemp("built") / "calibration"
    folder.mkdir()
    sensor = load_sensor("biorob2018-w15")
    axes = {"F_x": np.linspace(-0.5, 0.5, 5), "F_z": np.linspace(0.0, 2.0, 5)}
    data = calibrate(sensor, **axes, mechanics="linear", magnetics="planar", tolerance=0.02)
    save_table(data, folder / "result.nc")
    save_sensor(sensor, folder / "scene.toml")
    _written(folder.parent / "bench.csv", sensor, data)
    return folder


def _written(path: Path, sensor: Sensor, data: xr.Dataset, *, factor: float = 1.0) -> None:
    """Write the readings; forces times a factor, as of another unit."""
    prior = prior_of(sensor, data)
    p, names = prior.start.copy(), [each.name for each in prior.setup.parameters]
    for name, value in {"modulus": 0.85, "gap": 4e-5, "alpha": 0.01, "lead": 1e-8}.items():
        p[names.index(name)] = value
    L = prior.bench(LOADS).model(p[None])[0]
    rows = ["F_x [N], F_z [N], L1 [uH], L2 [uH]"]
    rows += [", ".join(f"{value:.7f}" for value in row) for row in np.column_stack([factor * LOADS, 1e6 * L])]
    path.write_text("\n".join(rows) + "\n")


def test_a_plan_says_what_its_loads_bring(made: Path, capsys: Capture) -> None:
    """As JSON and in words; a rig has its own loads."""
    assert run(["adapt", str(made), "--plan", "3", "--rig", "weights", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert len(found["loads"]) == 3 and all(load["F_x"] == 0.0 for load in found["loads"])
    assert found["errors"]["F_z"][0] > found["errors"]["F_z"][-1] >= found["error_twice"]["F_z"]
    assert run(["adapt", str(made), "--plan", "2"]) == 0
    assert "These 2 loads bring the error of F_x from" in capsys.readouterr().out


def test_five_lines_make_a_corrected_calibration(made: Path, capsys: Capture, tmp_path: Path) -> None:
    """The sensor is found; its folder is one that is read as a calibration, with a picture of what was found."""
    bench, built = made.parent / "bench.csv", tmp_path / "built"
    assert run(["adapt", str(made), "--bench", str(bench), "-o", str(built), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["unknowns"]["modulus"]["value"] == pytest.approx(0.85, abs=0.1)
    assert found["p_value"] > 0.05 and found["mistake"] == ""
    assert found["force_error"]["F_z"] < 0.3 * found["force_error_before"]["F_z"]
    sensor, data = read_calibration(built)
    assert (built / "adapted.png").stat().st_size > 10_000
    assert sensor.elastomer.silicone.source == "adapted to readings" and float(data["F_z"].max()) < 2.0
    assert run(["adapt", str(made), "--bench", str(bench)]) == 0
    assert "such a sensor" in capsys.readouterr().out


def test_readings_of_another_sensor_are_told(made: Path, capsys: Capture, tmp_path: Path) -> None:
    """What probably went wrong is named; refused where that is asked for."""
    bench = tmp_path / "kilograms.csv"
    _written(bench, *read_calibration(made), factor=1.0 / 9.80665)
    assert run(["adapt", str(made), "--bench", str(bench), "--strict"]) == 2
    out = capsys.readouterr()
    assert "kilograms" in out.err and ("hardly" in out.err or "must fit" in out.err)


@pytest.mark.parametrize(
    ("more", "what"),
    [((), "either --bench FILE or --plan N; got none"), (("--plan", "3", "--bench", "{bench}"), "got both"),
     (("--plan", "0"), "plan: must be one or more loads"), (("--bench", "nowhere.csv"), "nowhere.csv"),
     (("--plan", "2", "--free", "colour"), "fit: must be modulus")],
)
def test_bad_input_is_one_line(made: Path, capsys: Capture, more: tuple[str, ...], what: str) -> None:
    """What must be given, and what came."""
    assert run(["adapt", str(made), *(part.format(bench=made.parent / "bench.csv") for part in more)]) == 2
    err = capsys.readouterr().err
    assert what in err and err.count("\n") == 1
