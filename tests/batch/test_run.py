"""Studies: what a file may ask, cases that are kept and shared, runs that are killed and go on, clusters."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.bench import coil_table, sensor_calibration, sensor_front_end
from sits_mech.batch import requests
from sits_mech.batch.executors import workers
from sits_mech.batch.run import run_study
from sits_mech.batch.study import read_study
from sits_mech.cases import read_table
from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.models import magnetic_model, mechanical_model
from sits_mech.cli.main import run
from sits_mech.quantities import Pose, Wrench
from sits_mech.readout.quality import quality
from sits_mech.report.folder import read_calibration
from sits_mech.scene.sensor import load_sensor
from sits_mech.units import SceneError

HEAD = 'scene = "biorob2018"\nrequest = "inductance"\n'
GAPS = 'dv = { from = "1 mm", to = "5 mm", count = 5 }\n'
COARSE = "[fixed]\ntolerance = 1e-2\n"


def written(folder: Path, text: str) -> Path:
    """Return the path of a study file with a text."""
    path = folder / "study.toml"
    path.write_text(text)
    return path


@pytest.mark.slow
def test_magnetic_cases_stand_at_their_place(tmp_path: Path) -> None:
    """As the model itself gives them, a section, which the status tells; a target may be wider than the layer."""
    text = HEAD + "[vary]\n" + '"target.width" = ["8 mm", "22 mm"]\n' + GAPS + COARSE.replace("1e-2", "0.1")
    data = run_study(read_study(written(tmp_path, text)), tmp_path / "out")
    assert data["L"].dims == ("target.width", "dv", "coil", "coil_2") and np.all(data["status"] == "above tolerance")
    np.testing.assert_allclose(data["target.width"], [0.008, 0.022])
    np.testing.assert_allclose(data["dv"], [1e-3, 2e-3, 3e-3, 4e-3, 5e-3])
    sensor = load_sensor("biorob2018")
    model, _ = magnetic_model(sensor, tolerance=0.1)
    alone = model.impedance(Pose(0.0, 3e-3), sensor.frequency)
    np.testing.assert_allclose(data["L"].sel({"target.width": 8e-3, "dv": 3e-3}, method="nearest"), alone.L, rtol=1e-12)
    assert read_table(tmp_path / "out" / "result.nc").identical(data)
    assert len(list((tmp_path / "out" / "cases").iterdir())) == 10


def test_zipped_values_go_side_by_side(tmp_path: Path) -> None:
    """One dimension, the names along it; a failed case is a row with its reason."""
    text = HEAD + 'combine = "zip"\n[vary]\ndv = ["1 mm", "0.2 mm", "3 mm"]\nalpha = ["0 deg", "10 deg", "1 deg"]\n'
    data = run_study(read_study(written(tmp_path, text + COARSE)), tmp_path / "out")
    assert data["L"].dims == ("case", "coil", "coil_2") and data["alpha"].dims == ("case",)
    assert data["status"].to_numpy().tolist() == ["above tolerance", "failed", "above tolerance"]
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
        found = xr.Dataset({"L_v_percent": (("F_z", "F_y"), np.zeros((2, 3)))}, attrs={"unit_L": "H"})
        status = np.full((2, 3), "ok", dtype=object)
        return found.assign(status=(("F_z", "F_y"), status), flags=(("F_z", "F_y"), status))

    monkeypatch.setattr(requests, "calibrate", calibrated)
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
    keys = '[fixed]\n"elastomer.length" = "250 mm"\n"target.length" = "250 mm"\n'
    text = f'scene = "biorob2018"\nrequest = "pose"\n[vary]\nfz = ["0.1 N", "50 N"]\n{keys}'
    data = run_study(read_study(written(tmp_path, text)), tmp_path / "small")
    assert data["mechanics"].to_numpy().ravel().tolist() == ["linear", "planar"]
    assert not data["d_h"].any() and not data["error_alpha"].any()


REFUSED = {
    HEAD + "[vary]\n": "vary: must be a table of keys",
    HEAD + "[vary]\ndv = []\n": "dv: must be a list of values that is not empty",
    HEAD + "[vary]\ndv = { from = 1, to = 1, count = 3 }\n": "dv: must be a list",
    HEAD + '[vary]\ndv = { from = "1 mm", to = "1 cm", count = 3 }\n': "dv: must be a list",
    HEAD + '[vary]\ndv = ["1 mm", "1 N"]\n': "dv: must be a length",
    HEAD + '[vary]\ndvv = ["1 mm"]\n': "argument of inductance must be one of .*; got dvv|argument of inductance .*dvv",
    HEAD + '[vary]\ndh = ["1 mm"]\n': "dv: must be given",
    HEAD + '[vary]\ndv = ["1 mm"]\n[fixed]\ndv = "2 mm"\n': "it stands under both",
    HEAD + '[vary]\ndv = ["1 mm"]\n"target.widht" = [1]\n': "target.widht",
    HEAD + '[vary]\ndv = ["1 mm"]\ntolerance = [0.01, -1]\n': "tolerance must lie between 0 and 1; got -1",
    HEAD + '[vary]\ndv = ["1 mm"]\ntolerance = ["1 %"]\n': "tolerance must be a plain number",
    HEAD + '[vary]\ndv = ["1 mm"]\nmodel = ["planar", "plnar"]\n': "model must be one of auto, planar, .*plnar",
    HEAD + '[vary]\ndv = ["1 mm"]\n[fixed]\nmodel = "linear"\n': "model must be one of auto, planar, .*linear",
    HEAD + '[vary]\ndv = ["1 mm"]\n"target.material" = ["copper", "coper"]\n': "coper.*did you mean",
    HEAD + '[vary]\ndv = ["1 mm"]\n"target.width" = ["8 mm", "2 N"]\n': "target.width = .*must be a length",
    HEAD + '[vary]\ndv = ["1 mm"]\n"coils.C9.turns" = [9]\n': "C9",
    HEAD.replace("inductance", "calibrate") + '[vary]\nfy = ["1 N"]\n[fixed]\nfx = "1 N"\nfz = "1 N"\n': "fy",
    HEAD + 'sceen = 1\n[vary]\ndv = ["1 mm"]\n': "sceen",
    HEAD + 'combine = "zip"\n[vary]\ndv = ["1 mm"]\ndh = [0, 1]\n': "equally many",
    HEAD.replace("inductance", "guess") + "[vary]\n": "request",
    HEAD.replace("biorob2018", "nowhere") + '[vary]\ndv = ["1 mm"]\n': "nowhere",
    HEAD.replace("inductance", "calibrate") + '[vary]\nfx = ["1 N"]\n[fixed]\nfz = "1 N"\n': "fx: must be a range",
    'request = "pose"\n': "scene: must be given",
    "vary = ": "must be a TOML file",
}


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
    path, out = written(tmp_path, HEAD + '[vary]\ndv = ["2 mm"]\n' + COARSE), str(tmp_path / "out")
    assert [run(["sweep", str(path), "-o", out, *more]) for more in ([], ["--accept"])] == [4, 0]
    written(tmp_path, HEAD + '[vary]\ndv = ["2 mm", "3 mm"]\n' + COARSE)
    assert run(["sweep", str(path), "-o", out, "--accept"]) == 0
    assert read_table(tmp_path / "out" / "result.nc").sizes["dv"] == 2
    shown = capsys.readouterr()
    assert all(heading in shown.out for heading in ("dv [m]", "L [H/m]", "R [ohm/m]"))
    assert "not in this table" not in shown.err
    written(tmp_path, HEAD + '[vary]\ndv = ["0.003 m"]\n' + COARSE)
    assert run(["sweep", str(path), "-o", out, "--accept"]) == 0
    assert "not in this table: 1 finished case(s) of other values" in capsys.readouterr().err
    written(tmp_path, HEAD + '[vary]\ndv = ["2 mm"]\n[fixed]\ntolerance = 0.1\n')
    capsys.readouterr()
    assert run(["sweep", str(path), "-o", out]) == 2 and "another study" in capsys.readouterr().err
    assert run(["sweep", str(path), "-o", out, "-j", "0"]) == 2 and "processes" in capsys.readouterr().err


def test_a_full_disk_leaves_whole_cases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One clear line, nothing half-written; with room again only the missing cases are computed."""
    study, out = read_study(written(tmp_path, HEAD + "[vary]\n" + GAPS + COARSE)), tmp_path / "out"
    real, room = os.replace, [3]

    def full(source: str, target: str) -> None:
        room[0] -= 1
        if room[0] < 0:
            raise OSError(28, "No space left on device")
        real(source, target)

    with monkeypatch.context() as patch:
        patch.setattr("os.replace", full)
        with pytest.raises(SceneError, match="must be writable; got: No space left on device"):
            run_study(study, out)
    assert len(os.listdir(out / "cases")) == 2 and not (out / "result.nc").exists()
    kept = {name: (out / "cases" / name).stat().st_mtime_ns for name in os.listdir(out / "cases")}
    assert run_study(study, out).identical(run_study(study, tmp_path / "again").assign(seconds=read_seconds(out)))
    assert all((out / "cases" / name).stat().st_mtime_ns == when for name, when in kept.items())


def read_seconds(folder: Path) -> xr.DataArray:
    """Return the run times of a result, which no two runs share."""
    return read_table(folder / "result.nc")["seconds"]


@pytest.mark.slow
@pytest.mark.parametrize("words", [[], ["-j", "2"]], ids=["alone", "two processes"])
def test_a_killed_run_goes_on(words: list[str], tmp_path: Path) -> None:
    """kill -9 in the middle: no case is lost or torn, the resumed result is that of a run without a stop."""
    text = HEAD + '[vary]\n"target.width" = ["8 mm", "9 mm", "10 mm"]\n' + GAPS.replace("5 }", "50 }") + COARSE
    text += 'model = "planar"\n'
    path, cases = written(tmp_path, text), tmp_path / "out" / "cases"
    begin = [sys.executable, "-c", "from sits_mech.cli.main import main; main()", "sweep", str(path), "-o"]
    words = [*begin, str(cases.parent), *words]
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while len(list(cases.glob("[!.]*.json"))) < 20 and process.poll() is None:  # however long a busy machine takes
        time.sleep(0.005)
    process.send_signal(signal.SIGKILL)
    process.wait()
    kept = {path.name: path.stat().st_mtime_ns for path in cases.glob("[!.]*.json")}
    assert 20 <= len(kept) < 150
    assert run(["sweep", str(path), "-o", str(cases.parent)]) == 0
    assert all((cases / name).stat().st_mtime_ns == when for name, when in kept.items())
    whole = run_study(read_study(path), tmp_path / "whole")
    assert read_table(cases.parent / "result.nc").assign(seconds=whole["seconds"]).identical(whole)


PROBE = """
def threads():
    import numpy, scipy.linalg, threadpoolctl
    return [library["num_threads"] for library in threadpoolctl.threadpool_info()]

if __name__ == "__main__":
    from sits_mech.batch.executors import workers
    with workers(2) as executor:
        print(*executor.submit(threads).result())
"""


def test_a_worker_keeps_to_one_thread(tmp_path: Path) -> None:
    """Also of libraries that come after it was started; the environment here asks for two."""
    path = tmp_path / "probe.py"
    path.write_text(PROBE)
    asked = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "2")
    words = [sys.executable, str(path)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=True, env=os.environ | asked)
    assert set(done.stdout.split()) == {"1"}


@pytest.mark.slow
def test_a_cluster_that_loses_a_worker(tmp_path: Path) -> None:
    """Two worker processes, one killed in the middle: nothing is lost, and the result is that of one process."""
    distributed = pytest.importorskip("distributed")
    text = HEAD + '[vary]\n"target.width" = ["8 mm", "9 mm"]\n' + GAPS.replace("5 }", "150 }") + COARSE
    study, killed = read_study(written(tmp_path, text)), []
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster:
        victim = next(iter(cluster.workers.values())).pid

        def kill(done: int, total: int) -> None:
            if done > total // 4 and not killed:
                os.kill(victim, signal.SIGKILL)
                killed.append(done)

        with workers(address=cluster.scheduler_address) as executor:
            data = run_study(study, tmp_path / "out", executor=executor, progress=kill)
    assert killed and np.all(data["status"] == "above tolerance")
    alone = run_study(study, tmp_path / "alone")
    xr.testing.assert_allclose(data.drop_vars("seconds"), alone.drop_vars("seconds"), rtol=1e-9)


def test_no_cluster_at_an_address(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line that names the address."""
    pytest.importorskip("distributed")
    monkeypatch.setattr("sits_mech.batch.executors._ANSWER_TIMEOUT", 1)
    path = written(tmp_path, HEAD + '[vary]\ndv = ["2 mm"]\n' + COARSE)
    assert run(["sweep", str(path), "-o", str(tmp_path / "out"), "--dask", "tcp://127.0.0.1:1"]) == 2
    assert "tcp://127.0.0.1:1" in capsys.readouterr().err


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


def test_quality_needs_a_converter_and_says_so(tmp_path: Path) -> None:
    text = 'scene = "biorob2018"\nrequest = "quality"\n[vary]\n"elastomer.thickness" = ["2 mm"]\n'
    text += '[fixed]\nfx = "-0.2 N:0.2 N:3"\nfz = "0 N:1 N:3"\n"readout.converter" = "none"\n'
    data = run_study(read_study(written(tmp_path, text)), tmp_path / "out")
    assert "readout.converter" in str(data["reason"][0].item())
    with pytest.raises(SceneError, match="it has none: readout.converter"):
        read_calibration(tmp_path / "out", 1)
