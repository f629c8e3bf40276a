"""The command for a built sensor: a plan, readings of five lines, the corrected calibration that others read."""

import contextlib
import io
import json
import re
import shutil
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from sits_mech.analysis.built.prior import prior_of
from sits_mech.chain.calibrate import calibrate
from sits_mech.cli.main import run
from sits_mech.disk_cache import VARIABLE
from sits_mech.report.folder import read_calibration
from sits_mech.scene.sensor import Sensor, load_sensor, save_sensor
from sits_mech.store import save_table

LOADS = np.array([[0.0, 0.0], [0.3, 0.0], [0.3, 1.2], [-0.3, 1.2], [0.0, 0.6]])
Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module", autouse=True)
def kept(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep what a layer does as it is changed from command to command, as they do for a user."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, str(tmp_path_factory.mktemp("kept")))
        yield


@pytest.fixture(scope="module")
def made(
    tmp_path_factory: pytest.TempPathFactory, numerics_alone: Callable[[], AbstractContextManager[None]]
) -> Path:
    """A calibration by models that cost little, and beside it readings of a softer sensor whose target is turned."""
    folder = tmp_path_factory.mktemp("built") / "calibration"
    folder.mkdir()
    sensor = load_sensor("biorob2018-w15")
    axes = {"F_x": np.linspace(-0.5, 0.5, 5), "F_z": np.linspace(0.0, 2.0, 5)}
    with numerics_alone():  # the readings are of the same models
        data = calibrate(sensor, **axes, mechanics="linear", magnetics="planar", tolerance=0.02)
    save_table(data, folder / "result.nc")
    save_sensor(sensor, folder / "scene.toml")
    _written(folder.parent / "bench.csv", sensor, data)
    return folder


def _written(
    path: Path, sensor: Sensor, data: xr.Dataset, *, factor: float = 1.0, modulus: float = 0.85, loads: Any = LOADS
) -> None:
    """Write the readings; forces times a factor, as of another unit."""
    prior = prior_of(sensor, data)
    p, names = prior.start.copy(), [each.name for each in prior.setup.parameters]
    for name, value in {"modulus": modulus, "gap": 4e-5, "alpha": 0.01, "lead": 1e-8}.items():
        p[names.index(name)] = value
    L = prior.bench(loads).model(p[None])[0]
    rows = ["F_x [N], F_z [N], L1 [uH], L2 [uH]"]
    rows += [", ".join(f"{value:.7f}" for value in row) for row in np.column_stack([factor * loads, 1e6 * L])]
    path.write_text("\n".join(rows) + "\n")


@pytest.fixture(scope="module")
def adapted(made: Path) -> tuple[Path, dict[str, Any]]:
    """The folder that the command writes of the readings, and the JSON object that it prints."""
    built, printed = made.parent / "adapted", io.StringIO()
    with contextlib.redirect_stdout(printed):
        assert run(["adapt", str(made), "--bench", str(made.parent / "bench.csv"), "-o", str(built), "--json"]) == 0
    return built, json.loads(printed.getvalue())


def test_a_plan_says_what_its_loads_bring(made: Path, capsys: Capture) -> None:
    """As JSON and in words; a rig has its own loads."""
    assert run(["adapt", str(made), "--plan", "3", "--rig", "weights", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert len(found["loads"]) == 3 and all(load["F_x"] == 0.0 for load in found["loads"])
    assert found["errors"]["F_z"][0] > found["errors"]["F_z"][-1] >= found["error_twice"]["F_z"]
    assert run(["adapt", str(made), "--plan", "2"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "These 2 loads bring the error of F_x from" in said and "one 1.4 times softer" in said
    assert run(["adapt", str(made), "--plan", "2", "--weights", "50 g, 100 g", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["rig"] == "weights" and found["softest"] < 0.7 and found["grow"] == ""
    assert {round(load["F_z"], 3) for load in found["loads"]} <= {0.49, 0.981}
    assert run(["adapt", str(made), "--bench", "b.csv", "--weights", "50 g"]) == 2
    assert "--weights, --step: must be given with --plan" in capsys.readouterr().err


def test_five_lines_make_a_corrected_calibration(
    made: Path, adapted: tuple[Path, dict[str, Any]], capsys: Capture
) -> None:
    """The sensor is found; its folder is one that is read as a calibration, with a picture of what was found."""
    built, found = adapted
    assert found["unknowns"]["modulus"]["value"] == pytest.approx(0.85, abs=0.1)
    assert found["p_value"] > 0.05 and found["mistake"] == ""
    assert found["force_error"]["F_z"] < 0.3 * found["force_error_before"]["F_z"]
    sensor, data = read_calibration(built)
    assert (built / "adapted.png").stat().st_size > 10_000
    assert sensor.elastomer.silicone.source == "adapted to readings" and float(data["F_z"].max()) < 2.0
    assert run(["adapt", str(made), "--bench", str(made.parent / "bench.csv")]) == 0
    assert "such a sensor" in capsys.readouterr().out


def test_constants_of_the_unit_are_written(
    made: Path, adapted: tuple[Path, dict[str, Any]], tmp_path: Path
) -> None:
    """With the adapted calibration, for the header of the one that was adapted."""
    assert run(["export", str(made), "--to", "c", "-o", str(tmp_path / "sensor.h")]) == 0
    identity = re.search(r"SITS_ID UINT32_C\((0x[0-9A-F]{8})\)", (tmp_path / "sensor.h").read_text())[1]
    text = (adapted[0] / "unit.h").read_text()
    assert f"#define SITS_UNIT {{UINT32_C({identity}), " in text and "on 90 % of loads: F_x 0." in text


@pytest.mark.slow
def test_a_softer_sensor_makes_the_table_longer(
    made: Path, capsys: Capture, tmp_path: Path, numerics_alone: Callable[[], AbstractContextManager[None]]
) -> None:
    """1.4 times softer, under loads up to the table's end: refused with the load that it needs, or solved there."""
    sensor, data = read_calibration(made)
    shutil.copytree(made, tmp_path / "own")
    with numerics_alone():
        wide = calibrate(sensor, F_x=1.6 * data["F_x"].to_numpy(), F_z=1.6 * data["F_z"].to_numpy(),
                         mechanics="linear", magnetics="planar", tolerance=0.02)
        _written(tmp_path / "soft.csv", sensor, wide, modulus=1.0 / 1.4, loads=np.array([1.3, 1.6]) * LOADS)
        words = ["adapt", str(tmp_path / "own"), "--bench", str(tmp_path / "soft.csv")]
        assert run(words) == 2
        assert re.search(r"modulus: .* calibrate to at least \S+ N of F_z\n", capsys.readouterr().err)
        assert run([*words, "--grow", "--json", "-o", str(tmp_path / "built")]) == 0
    printed = capsys.readouterr()
    assert json.loads(printed.out)["unknowns"]["modulus"]["value"] == pytest.approx(1.0 / 1.4, rel=0.05)
    assert "calibrated further, to F_x = " in printed.err and (tmp_path / "built" / "unit.h").exists()
    assert float(read_calibration(tmp_path / "own")[1]["F_z"].max()) > 2.6


def units_of(made: Path) -> str:
    """Return the lines of two units that show the readings."""
    rows = (made.parent / "bench.csv").read_text().splitlines()
    return "\n".join([f"unit, {rows[0]}", *(f"A{k}, {row}" for k in (1, 2) for row in rows[1:])])


@pytest.mark.slow
def test_units_of_a_lot_tell_of_the_next(made: Path, capsys: Capture, tmp_path: Path) -> None:
    """Shared unknowns, each unit, errors and yields; files that adapt and firmware go on from."""
    bench, lot = tmp_path / "units.csv", tmp_path / "lot"
    bench.write_text(units_of(made) + "\nB, 0.3, 0.5, 9.9, 9.9\n")
    assert run(["lot", str(made), "--bench", str(bench), "--within", "modulus=2 %", "-o", str(lot), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["unknowns"]["modulus"]["deviation"] < 0.2 * found["unknowns"]["modulus"]["known_deviation"]
    assert found["units"]["A1"]["p_value"] > 0.05 and (found["units"]["B"]["refused"] or
                                                       found["units"]["B"]["p_value"] < 0.01)
    assert [row["after"] for row in found["delivered"]] == ["as computed", "tared", "and 1 load", "and 2 loads"]
    assert found["delivered"][-1]["yield"] >= found["delivered"][0]["yield"]
    table = pd.read_csv(lot / "units.csv")
    assert list(table["unit"])[:2] == ["A1", "A2"] and {"gain1", "factor22", "id", "left_F_z"} <= {*table.columns}
    assert (lot / "lot.png").stat().st_size > 10_000
    assert run(["adapt", str(made), "--plan", "1", "--json"]) == 0
    alone = json.loads(capsys.readouterr().out)
    assert run(["adapt", str(made), "--plan", "1", "--lot", str(lot / "lot.json"), "--json"]) == 0
    helped = json.loads(capsys.readouterr().out)
    assert helped["errors"]["F_z"][0] < 0.5 * alone["errors"]["F_z"][0]


@pytest.mark.slow
def test_a_lot_is_told_to_a_reader(made: Path, capsys: Capture, tmp_path: Path) -> None:
    """Two units alike; what share of units stays within a limit."""
    bench = tmp_path / "units.csv"
    bench.write_text(units_of(made) + "\n")
    assert run(["lot", str(made), "--bench", str(bench), "--limit", "5 %"]) == 0
    assert "within 5 %" in capsys.readouterr().out


@pytest.mark.slow
def test_what_is_read_in_use(made: Path, capsys: Capture) -> None:
    """A look at rest, weights, a press to the stop: what each brings after a drift."""
    drift = "modulus=1+-0.1, lead=0+-10 nH"
    assert run(["adapt", str(made), "--plan", "2", "--rig", "use", "--free", drift, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {*found["kinds"]} <= {"rest", "weight", "stop"} and found["errors"]["F_z"][-1] < found["errors"]["F_z"][0]
    assert run(["adapt", str(made), "--plan", "2", "--rig", "use", "--free", drift]) == 0
    assert "drifted" in capsys.readouterr().out


@pytest.mark.slow
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
     (("--plan", "2", "--grow"), "--grow, --idle, -o, which are of readings"),
     (("--plan", "0"), "plan: must be one or more loads"), (("--bench", "nowhere.csv"), "nowhere.csv"),
     (("--plan", "2", "--idle", "open"), "must be given without --strict, --grow, --idle, -o"),
     (("--plan", "2", "--free", "colour"), "fit: must be modulus"),
     (("--plan", "2", "--lot", "{bench}"), "must be a lot.json of sits-mech lot")],
)
def test_bad_input_is_one_line(made: Path, capsys: Capture, more: tuple[str, ...], what: str) -> None:
    """What must be given, and what came."""
    assert run(["adapt", str(made), *(part.format(bench=made.parent / "bench.csv") for part in more)]) == 2
    err = capsys.readouterr().err
    assert what in err and err.count("\n") == 1


@pytest.mark.parametrize(
    ("more", "what"),
    [(("--limit", "0"), "--limit between 0 and 100 %"), (("--within", "gap"), "must be name=deviation"),
     ((), "must have columns unit and F_x")],
)
def test_bad_input_of_a_lot_is_one_line(made: Path, capsys: Capture, more: tuple[str, ...], what: str) -> None:
    """What must be given, and what came."""
    assert run(["lot", str(made), "--bench", str(made.parent / "bench.csv"), *more]) == 2
    err = capsys.readouterr().err
    assert what in err and err.count("\n") == 1
