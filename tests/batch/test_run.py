"""Studies: what a file may ask, cases that are kept and shared, runs that are killed and go on, clusters."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech import store
from sits_mech.analysis.readings.bench import coil_table, sensor_calibration, sensor_front_end
from sits_mech.batch import run as batch_run
from sits_mech.batch.funnel import following
from sits_mech.batch.run import claim, keep_known, open_sweep, run_study
from sits_mech.batch.studies.study import read_study
from sits_mech.batch.tables import case_calibration, table_row
from sits_mech.cases import Columns
from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.models import magnetic_model, mechanical_model
from sits_mech.cli.main import run
from sits_mech.notes import OmissionKind, unpacked_omissions
from sits_mech.quantities import Pose, Wrench
from sits_mech.readout.loads import point
from sits_mech.readout.quality import quality
from sits_mech.report.folder import read_calibration
from sits_mech.scene.sensor import Sensor, load_sensor, provenance
from sits_mech.store import read_table
from sits_mech.units import SceneError

HEAD = 'scene = "biorob2018"\nrequest = "inductance"\n'
GAPS = 'dv = { from = "1 mm", to = "5 mm", count = 5 }\n'
COARSE = "[fixed]\ntolerance = 1e-2\n"
PLANAR = COARSE + 'model = "planar"\n'


def written(folder: Path, text: str) -> Path:
    """Return the path of a study file with a text."""
    path = folder / "study.toml"
    path.write_text(text)
    return path


@pytest.mark.slow
def test_magnetic_cases_stand_at_their_place(tmp_path: Path) -> None:
    """As the model itself gives them, in space; a target may be wider than the layer."""
    text = HEAD + "[vary]\n" + '"target.width" = ["8 mm", "22 mm"]\n' + GAPS + COARSE.replace("1e-2", "0.1")
    data = run_study(read_study(written(tmp_path, text)), tmp_path / "out")
    assert data["L"].dims == ("target.width", "dv", "coil", "coil_2") and np.all(data["status"] == "ok")
    np.testing.assert_allclose(data["target.width"], [0.008, 0.022])
    np.testing.assert_allclose(data["dv"], [1e-3, 2e-3, 3e-3, 4e-3, 5e-3])
    sensor = load_sensor("biorob2018")
    model, _ = magnetic_model(sensor, tolerance=0.1)
    alone = model.impedance(Pose(0.0, 3e-3), sensor.frequency)
    np.testing.assert_allclose(data["L"].sel({"target.width": 8e-3, "dv": 3e-3}, method="nearest"), alone.L, rtol=1e-12)
    assert read_table(tmp_path / "out" / "result.nc").identical(data)
    assert sorted(os.listdir(tmp_path / "out")) == ["cases.sqlite", "result.nc", "study.json"]


@pytest.mark.slow
def test_zipped_values_go_side_by_side(tmp_path: Path) -> None:
    """One dimension, the names along it; a failed case is a row with its reason."""
    text = HEAD + 'combine = "zip"\n[vary]\ndv = ["1 mm", "0.2 mm", "3 mm"]\nalpha = ["0 deg", "10 deg", "1 deg"]\n'
    data = run_study(read_study(written(tmp_path, text + COARSE)), tmp_path / "out")
    assert data["L"].dims == ("case", "coil", "coil_2") and data["alpha"].dims == ("case",)
    assert data["status"].to_numpy().tolist() == ["ok", "failed", "ok"]
    assert "target" in str(data["reason"][1].item()) and np.isnan(data["L"][1]).all()


def test_whole_calibrations_are_cases(tmp_path: Path) -> None:
    """Loads are inner dimensions with their forces; the numbers are those of the chain."""
    text = 'scene = "biorob2018"\nrequest = "calibrate"\n[vary]\n"elastomer.thickness" = ["2 mm", "3 mm"]\n'
    text += '[fixed]\nfx = "-0.2 N:0.2 N:2"\nfz = "0 N:1 N:2"\ntolerance = 0.1\n'
    text += '"target.width" = "10 mm"\nmechanics = "linear"\nmagnetics = "planar"\n'
    data = run_study(read_study(written(tmp_path, text)), tmp_path / "out")
    assert data["L_v_percent"].dims == ("elastomer.thickness", "F_x", "F_z") and not data["failed_loads"].any()
    sensor = load_sensor("biorob2018", ['target.width="10 mm"', 'elastomer.thickness="3 mm"'])
    alone = calibrate(sensor, F_x=[-0.2, 0.2], F_z=[0.0, 1.0], tolerance=0.1, mechanics="linear", magnetics="planar")
    np.testing.assert_allclose(data["L_v_percent"][1], alone["L_v_percent"], rtol=1e-12)
    np.testing.assert_allclose(data["F_z"], [0.0, 1.0])


def test_a_case_may_be_a_grid_of_any_components(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All six reach the calibration, ranges as dimensions of the table, single values as numbers, zeros not at all."""
    asked = []

    def calibrated(sensor: object, **words: object) -> xr.Dataset:
        asked.append(words)
        found = xr.Dataset({"L_v_percent": (("F_z", "F_y"), np.zeros((2, 3)))}, attrs={"unit_L": "H", "left_out": "[]"})
        status = np.full((2, 3), "ok", dtype=object)
        return found.assign(status=(("F_z", "F_y"), status), flags=(("F_z", "F_y"), status))

    monkeypatch.setattr("sits_mech.chain.calibrate.calibrate", calibrated)
    text = 'scene = "biorob2018"\nrequest = "calibrate"\n[vary]\n"elastomer.thickness" = ["2 mm", "3 mm"]\n'
    text += '[fixed]\nfx = "0 N"\nfz = "0 N:1 N:2"\nfy = "-1 N:1 N:3"\nmz = "1 N*mm"\n'
    data = run_study(read_study(written(tmp_path, text)), tmp_path / "out")
    assert asked == [{"F_z": [0.0, 1.0], "F_y": [-1.0, 0.0, 1.0], "M_z": 1e-3}] * 2
    assert data["L_v_percent"].dims == ("elastomer.thickness", "F_z", "F_y")
    np.testing.assert_array_equal(data["F_y"], [-1.0, 0.0, 1.0])


def test_forces_and_poses_are_requests(tmp_path: Path) -> None:
    """A load's pose, and the whole chain at a load."""
    text = 'scene = "biorob2018"\nrequest = "pose"\n[vary]\nfz = ["0 N", "1 N"]\n'
    text += '[fixed]\ntolerance = 0.1\nmodel = "linear"\n'
    data = run_study(read_study(written(tmp_path, text)), tmp_path / "pose")
    assert float(data["d_v"][1]) < float(data["d_v"][0]) == pytest.approx(2e-3)
    text = text.replace('"pose"', '"simulate"').replace("model", "mechanics") + 'magnetics = "planar"\n'
    assert float(run_study(read_study(written(tmp_path, text)), tmp_path / "chain")["L_v_percent"].diff("fz")[0]) < 0.0


@pytest.mark.slow
def test_loads_beside_the_plane_and_small_ones_take_the_commands_models(tmp_path: Path) -> None:
    """All cases of a study that varies fy are solved in space; a small load on a long pad takes one compliance."""
    text = 'scene = "biorob2018"\nrequest = "pose"\n[vary]\nfy = ["-0.2 N", "0.2 N"]\n[fixed]\nfz = "1 N"\n'
    data = run_study(read_study(written(tmp_path, text)), tmp_path / "beside")
    load = Wrench(F_y=0.2, F_z=1.0)
    full = mechanical_model(load_sensor("biorob2018"), loads=[load])[0].equilibrium(load).pose
    for name, value in (("d_y", full.d_y), ("d_v", full.d_v), ("alpha_x", full.alpha_x)):
        assert float(data[name][1]) == pytest.approx(value, rel=1e-9)
    assert float(data["d_y"][0]) == pytest.approx(-full.d_y, rel=1e-6)
    keys = '[fixed]\ntolerance = 0.1\n"elastomer.length" = "250 mm"\n"target.length" = "250 mm"\n'
    text = f'scene = "biorob2018"\nrequest = "pose"\n[vary]\nfz = ["0.1 N", "50 N"]\n{keys}'
    data = run_study(read_study(written(tmp_path, text)), tmp_path / "small")
    assert data["mechanics"].to_numpy().ravel().tolist() == ["linear", "planar"]
    assert not data["d_h"].any() and not data["error_alpha"].any()


REFUSED = {
    HEAD + "[vary]\n": "vary: must not be empty; got {}",
    HEAD + "[vary]\ndv = []\n": "vary.dv: must be a list of values that is not empty",
    HEAD + "[vary]\ndv = { from = 1, to = 1, count = 3 }\n": "dv: must be a list",
    HEAD + '[vary]\ndv = { from = "1 mm", to = "1 cm", count = 3 }\n': "dv: must be a list",
    HEAD + '[vary]\ndv = ["1 mm", "1 N"]\n': "dv: must be a length",
    HEAD + '[vary]\ndvv = ["1 mm"]\n': "argument of inductance must be one of .*; got dvv|argument of inductance .*dvv",
    HEAD + '[vary]\nDv = ["1 mm"]\n': 'got Dv|argument of inductance .*"Dv" .did you mean "dv"',
    HEAD + '[vary]\ndv = ["1 mm"]\nd_v = ["2 mm"]\n': "vary: dv must be given once; got d_v beside it",
    HEAD + '[vary]\ndh = ["1 mm"]\n': "dv: must be given",
    HEAD + '[vary]\ndv = ["1 mm"]\n[fixed]\ndv = "2 mm"\n': "it stands under both",
    HEAD + '[vary]\ndv = ["1 mm"]\n"target.widht" = [1]\n': "target.widht",
    HEAD + '[vary]\ndv = ["1 mm"]\ntolerance = [0.01, -1]\n': "tolerance: must be a share .*between 0 and 1; got -1",
    HEAD + '[vary]\ndv = ["1 mm"]\ntolerance = ["1 mm"]\n': "tolerance: must be a plain number",
    HEAD + '[vary]\ndv = ["1 mm"]\nmodel = ["planar", "plnar"]\n': "model: must be one of auto, axisymm.*plnar",
    HEAD + '[vary]\ndv = ["1 mm"]\n[fixed]\nmodel = "linear"\n': "model: must be one of auto, axisymm.*linear",
    HEAD + '[vary]\ndv = ["1 mm"]\n"target.material" = ["copper", "coper"]\n': "coper.*did you mean",
    HEAD + '[vary]\ndv = ["1 mm"]\n"target.width" = ["8 mm", "2 N"]\n': "target.width = .*must be a length",
    HEAD + '[vary]\ndv = ["1 mm"]\n"coils.C9.turns" = [9]\n': "C9",
    HEAD.replace("inductance", "calibrate") + '[vary]\nfy = ["1 N"]\n[fixed]\nfx = "1 N"\nfz = "1 N"\n': "fy",
    HEAD + 'sceen = 1\n[vary]\ndv = ["1 mm"]\n': "sceen: the key must be one of scene, .*did you mean .scene",
    HEAD + 'combine = "zip"\n[vary]\ndv = ["1 mm"]\ndh = [0, 1]\n': "equally many",
    HEAD.replace("inductance", "guess") + "[vary]\n": "request: must be one of pose, .*guess",
    HEAD.replace("biorob2018", "nowhere") + '[vary]\ndv = ["1 mm"]\n': "nowhere",
    HEAD.replace("inductance", "calibrate") + '[vary]\nfx = ["1 N"]\n[fixed]\nfz = "1 N"\n': "fx: must be a range",
    'request = "pose"\n': "scene: must be given",
    "vary = ": "must be a TOML file",
}


def test_components_have_their_names_in_python_too(tmp_path: Path) -> None:
    """The same study, whichever is written."""
    text = 'scene = "biorob2018"\nrequest = "pose"\n[vary]\nfz = ["1 N"]\nmoment = [0.0]\n[fixed]\nfx = "1 N"\n'
    other = text.replace("fz", "F_z").replace("moment", "M").replace("fx", "F_x")
    assert read_study(written(tmp_path, text)) == read_study(written(tmp_path, other))


@pytest.mark.parametrize("text", REFUSED, ids=list(REFUSED.values()))
def test_what_is_no_study(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line on stderr that names file and key, exit 2, no folder left."""
    monkeypatch.chdir(tmp_path)
    path = written(Path(), text)
    with pytest.raises(SceneError, match=REFUSED[text]):
        read_study(path)
    assert run(["sweep", str(path), "-o", "out"]) == 2
    shown = capsys.readouterr()
    assert shown.out == "" and shown.err.count("\n") == 1 and str(path) in shown.err
    assert not (tmp_path / "out").exists()


def test_folders_and_clusters_that_are_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The folder of another study is left alone; more values of the same one are welcome; no scheduler, no run."""
    path, out = written(tmp_path, HEAD + '[vary]\ndv = ["2 mm"]\n' + PLANAR), str(tmp_path / "out")
    assert [run(["sweep", str(path), "-o", out, *more]) for more in ([], ["--accept"])] == [4, 0]
    written(tmp_path, HEAD + '[vary]\ndv = ["2 mm", "3 mm"]\n' + PLANAR)
    assert run(["sweep", str(path), "-o", out, "--accept"]) == 0
    assert read_table(tmp_path / "out" / "result.nc").sizes["dv"] == 2
    shown = capsys.readouterr()
    assert all(heading in shown.out for heading in ("dv [m]", "L [H/m]", "R [ohm/m]"))
    assert "not in this table" not in shown.err
    assert "left out: 2 of 2 cases, at most: ends along y: " in shown.out + shown.err
    kept = read_table(tmp_path / "out" / "result.nc")["left_out_magnetics"]
    for k in range(2):
        item, tracks = unpacked_omissions(str(kept[k].item()))
        assert item.kind == OmissionKind.PLATE_ENDS and item.size > 0.1
        assert tracks.kind == OmissionKind.TRACKS and 0.015 < tracks.size < 0.025
    written(tmp_path, HEAD + '[vary]\ndv = ["0.003 m"]\n' + PLANAR)
    assert run(["sweep", str(path), "-o", out, "--accept"]) == 0
    assert "not in this table: 1 finished case(s) of other values" in capsys.readouterr().err
    written(tmp_path, HEAD + '[vary]\ndv = ["2 mm"]\n[fixed]\ntolerance = 0.1\n')
    capsys.readouterr()
    assert run(["sweep", str(path), "-o", out]) == 2
    assert "that of another study: fixed." in capsys.readouterr().err
    assert run(["sweep", str(path), "-o", out, "-j", "0"]) == 2 and "processes" in capsys.readouterr().err


def test_a_folder_is_that_of_its_study_in_any_order(tmp_path: Path) -> None:
    """Of fixed keys; a study.json that is none is another study's."""
    text, fixed = HEAD + '[vary]\ndv = ["2 mm"]\n[fixed]\n', ("tolerance = 0.1\n", 'model = "planar"\n')
    first, second = (read_study(written(tmp_path, text + "".join(own))) for own in (fixed, fixed[::-1]))
    claim(tmp_path / "out", first)
    claim(tmp_path / "out", second)
    for damaged in (b"\xff\xfe\x00", b"[", b"1"):
        (tmp_path / "out" / "study.json").write_bytes(damaged)
        with pytest.raises(SceneError, match="it is that of another study"):
            claim(tmp_path / "out", first)


def test_a_full_disk_leaves_whole_cases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One clear line, nothing half-written; with room again only the missing cases are computed."""
    study, out = read_study(written(tmp_path, HEAD + "[vary]\n" + GAPS + PLANAR)), tmp_path / "out"
    real, room = store.Cases.put, [2]

    def full(self: store.Cases, rows: Iterable[tuple[str, dict[str, object]]]) -> None:
        room[0] -= 1
        if room[0] < 0:
            self.file.execute("PRAGMA max_page_count = 1")
        real(self, [(name, row | {"more": "x" * 20_000 * (room[0] < 0)}) for name, row in rows])

    with monkeypatch.context() as patch:
        patch.setattr(store.Cases, "put", full)
        with pytest.raises(SceneError, match="got: database or disk is full"):
            run_study(study, out)
    assert not (out / "result.nc").exists()
    with store.opened(out) as cases:
        before = {name: cases.get(name) for name in cases.names}
    assert len(before) == 2
    run_study(study, out)
    with store.opened(out) as cases:
        assert {name: cases.get(name) for name in before} == before and len(cases.names) == 5


KILLED = """
import os, signal, sys
from pathlib import Path
from sits_mech.batch.executors import workers
from sits_mech.batch import run as batch_run
from sits_mech.batch.funnel import following
from sits_mech.batch.run import claim, keep_known, open_sweep, run_study
from sits_mech.batch.studies.study import read_study
from sits_mech.batch.tables import case_calibration, table_row
from sits_mech.cases import Columns

def end(done, of):
    if done >= 20:
        os.kill(os.getpid(), signal.SIGKILL)

if __name__ == "__main__":
    with workers(int(sys.argv[3])) as executor:
        run_study(read_study(Path(sys.argv[1])), Path(sys.argv[2]), executor=executor, progress=end)
"""


@pytest.mark.slow
@pytest.mark.parametrize("processes", [1, 2], ids=["alone", "two processes"])
def test_a_killed_run_goes_on(processes: int, tmp_path: Path) -> None:
    """kill -9 in the middle: no case is lost or torn, the resumed result is that of a run without a stop."""
    text = HEAD + '[vary]\n"target.width" = ["8 mm", "9 mm", "10 mm"]\n' + GAPS.replace("5 }", "50 }") + PLANAR
    path, out = written(tmp_path, text), tmp_path / "out"
    (tmp_path / "killed.py").write_text(KILLED)
    words = [sys.executable, str(tmp_path / "killed.py"), str(path), str(out), str(processes)]
    assert subprocess.run(words, timeout=120).returncode == -signal.SIGKILL
    with store.opened(out) as cases:
        before = {name: cases.get(name) for name in cases.names}
    assert 20 <= len(before) < 150
    assert run(["sweep", str(path), "-o", str(out), "--accept"]) == 0  # bars leave out ends
    with store.opened(out) as cases:
        assert {name: cases.get(name) for name in before} == before
    whole = run_study(read_study(path), tmp_path / "whole")
    assert read_table(out / "result.nc").assign(seconds=whole["seconds"]).identical(whole)


def test_a_sweep_is_opened_while_it_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each snapshot is a whole table with units, read when it is asked for; another run is refused meanwhile."""
    monkeypatch.setattr("sits_mech.cases._FIRST", 0.0)
    monkeypatch.setattr("sits_mech.cases._APART", 0.0)
    study = read_study(written(tmp_path, HEAD + '[vary]\ndv = ["2 mm", "3 mm"]\n' + PLANAR))
    out, seen = tmp_path / "out", []

    def look(done: int, of: int) -> None:
        if done > 1:
            with open_sweep(out) as data:
                assert not data["L"].variable._in_memory and data["L"].units == "H/m" and data["dv"].units == "m"
                seen.append((data["status"].values.tolist(), np.isnan(data["L"][:, 0, 0]).values.tolist()))
            with pytest.raises(SceneError, match="one run at a time"):
                run_study(study, out)

    run_study(study, out, progress=look)
    assert seen == [(["above tolerance", "unfinished"], [False, True])]
    with open_sweep(out) as data:
        assert "unfinished" not in data["status"]
    with pytest.raises(SceneError, match="must be a table of this package"):
        open_sweep(tmp_path / "nowhere")


@pytest.mark.slow
def test_cases_of_quality_are_calibrations(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A case is the calibration that the command makes, to the last digit; its figures are those of that."""
    text = 'scene = "biorob2018"\nrequest = "quality"\n[vary]\n"elastomer.thickness" = ["1 mm", "2 mm", "3 mm"]\n'
    text += '[fixed]\nfx = "-0.2 N:0.2 N:3"\nfz = "0 N:1 N:3"\nmoment = "1 N*mm"\n'
    text += 'tolerance = 0.1\nmechanics = "planar"\nmagnetics = "planar"\n"target.width" = "10 mm"\n'
    out = tmp_path / "out"
    data = run_study(read_study(written(tmp_path, text)), out)
    assert data["resolution"].dims == ("elastomer.thickness", "force") and list(data["force"]) == ["F_x", "F_z"]
    sensor, found = read_calibration(out, 3)
    alone = load_sensor("biorob2018", ['target.width="10 mm"', 'elastomer.thickness="3 mm"'])
    words = {"tolerance": 0.1, "mechanics": "planar", "magnetics": "planar"}
    direct = calibrate(alone, F_x=[-0.2, 0.0, 0.2], F_z=[0.0, 0.5, 1.0], M=1e-3, **words)
    assert sensor == alone and found.attrs == direct.attrs
    xr.testing.assert_identical(found.drop_vars("seconds"), direct.drop_vars("seconds"))
    noise = sensor_front_end(alone, direct)[0].noise
    figures = quality(sensor_calibration(alone, direct), noise, table=coil_table(alone, direct))
    np.testing.assert_allclose(data["resolution"][2], figures.resolution[:, 2], rtol=1e-9)
    np.testing.assert_allclose(data["error_by_model"][2], figures.by_model[:, 2], rtol=1e-9)
    assert float(data["condition"][2]) == pytest.approx(figures.condition[1], rel=1e-9)
    assert float(data["crosstalk"][2, 1]) == pytest.approx(abs(figures.crosstalk[1, 0]), rel=1e-9)
    assert run(["quality", str(out), "--case", "3", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["limits"]["hysteresis"] is None
    assert run(["report", str(out), "--case", "2"]) == 0 and (out / "report-2.html").exists()
    capsys.readouterr()
    for words, message in ((["quality", str(out)], "--case 1 to --case 3"), (["report", str(out), "--case", "4"], "4")):
        assert run(words) == 2
        shown = capsys.readouterr()
        assert shown.out == "" and shown.err.count("\n") == 1 and message in shown.err


def as_calibrated(sensor: Sensor) -> xr.Dataset:
    """A calibration of no loads' numbers, with the signals that so many coils have."""
    count, status = len(sensor.coils), np.full((2, 2), "ok", dtype=object)
    loads = "F_x", "F_z"
    columns = {"status": (loads, status), "flags": (loads, status)}
    signals = ("dL_v", "L_v", "error_L_v") if count < 3 else ("dL_v",)
    columns |= {name: (loads, np.ones((2, 2))) for name in signals}
    columns["L"] = ((*loads, "coil", "coil_2"), np.full((2, 2, count, count), float(count)))
    request = json.dumps({name: [0.0, 1.0] for name in loads})
    return xr.Dataset(columns, attrs={**provenance(sensor), "request": request, "unit_L": "H", "left_out": "[]"})


def test_calibrations_of_other_coils_are_cases_beside_each_other() -> None:
    """Each comes back with its own coils and signals, though the table has room for the most."""
    pair = load_sensor("biorob2018")
    third = pair.coils[0].model_copy(update={"name": "C3", "centre": (0.02, 0.0)})
    sensors = [pair.model_copy(update={"coils": coils}) for coils in (pair.coils[:1], pair.coils, (*pair.coils, third))]
    columns = Columns({"case": range(3)})
    for number, sensor in enumerate(sensors):
        columns.put(number, table_row(as_calibrated(sensor)))
    for number, sensor in enumerate(sensors):
        found, data = case_calibration(point(columns.table(), number))
        assert found == sensor and {*data} == {*as_calibrated(sensor)}
        assert data["L"].shape == (2, 2, number + 1, number + 1) and np.all(data["L"] == number + 1.0)


def test_failures_are_not_kept_for_a_stage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What does not follow from a case of the stage before, such as of an interpolated one, is calibrated."""
    text = 'scene = "biorob2018"\nrequest = "calibrate"\nvary."elastomer.thickness" = ["2 mm", "3 mm"]\n'
    text += '[fixed]\nfx = "0 N:1 N:2"\nfz = "0 N:1 N:2"\n[[then]]\nleast = "failed_loads"\nrequest = "quality"\n'
    first = read_study(written(tmp_path, text))
    monkeypatch.setattr("sits_mech.chain.calibrate.calibrate", lambda sensor, **words: as_calibrated(sensor))
    data = run_study(first, tmp_path / "out")
    data["attributes"][1] = ""
    monkeypatch.setattr(batch_run, "with_quality", lambda sensor, data: table_row(data))
    stage = following(first.then[0].study, first, [0, 1])
    keep_known(stage, tmp_path / "then", (first, data), [0, 1])
    with store.opened(tmp_path / "then") as cases:
        assert len(cases.names) == 1


def test_quality_needs_a_converter_and_says_so(tmp_path: Path) -> None:
    text = 'scene = "biorob2018"\nrequest = "quality"\n[vary]\n"elastomer.thickness" = ["2 mm"]\n'
    text += '[fixed]\nfx = "-0.2 N:0.2 N:3"\nfz = "0 N:1 N:3"\n"readout.converter" = "none"\n'
    data = run_study(read_study(written(tmp_path, text)), tmp_path / "out")
    assert "readout.converter" in str(data["reason"][0].item())
    with pytest.raises(SceneError, match="it has none: readout.converter"):
        read_calibration(tmp_path / "out", 1)
