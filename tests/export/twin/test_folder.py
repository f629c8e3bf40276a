"""The twin's folder: what is in it, what is told, what is refused; and that it works where the package is not."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.readings.bench import self_inductances, sensor_front_end
from sits_mech.cli.main import run
from sits_mech.export.formats import export
from sits_mech.export.source import Source
from sits_mech.export.twin.arrays import ABOUT, twin_arrays
from sits_mech.export.twin.twin import Twin
from sits_mech.mechanics.layer import planar_layer
from sits_mech.quantities import Wrench
from sits_mech.report.folder import read_calibration
from sits_mech.scene.sensor import SceneError, Sensor, changed
from sits_mech.silicone.history import retardation

Said = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def source(calibrated: Path) -> Source:
    """The small calibration."""
    return Source(*read_calibration(calibrated))


def soft(source: Source) -> Sensor:
    """The sensor with a silicone whose relaxation and softening are known."""
    law = 'law = "neo-hookean", shear_modulus = "20 kPa", bulk_modulus = "20 MPa"'
    more = 'prony = [{weight = 0.2, time = "2 s"}], mullins = {r = 2.5}'
    return changed(source.sensor, [f"elastomer.material={{{law}, {more}}}"])


@pytest.fixture(scope="module")
def made(source: Source) -> dict[str, np.ndarray]:
    """The arrays of such a pad."""
    numbers, _ = twin_arrays(Source(soft(source), source.data))
    return numbers


def test_the_command_writes_a_folder_that_works_alone(calibrated: Path, tmp_path: Path, capfd: Said) -> None:
    """Where the package is not: twin.py loads sensor.npz beside it; again into the same folder."""
    out = tmp_path / "robot"
    assert run(["export", str(calibrated), "--to", "twin", "-o", str(out)]) == 0
    said = capfd.readouterr().err
    assert "wrenches: " in said and "poses: " in said and "relaxation: unknown" in said
    assert sorted(path.name for path in out.iterdir()) == ["pad.xml", "sensor.h", "sensor.npz", "twin.h", "twin.py"]
    code = "import numpy as np, sys\nfrom twin import Twin\n"
    code += "print(Twin.load('sensor.npz').read(np.zeros((1, 6))).codes[0, 0])\nassert 'sits_mech' not in sys.modules"
    done = subprocess.run([sys.executable, "-c", code], cwd=out, env={}, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "") and int(done.stdout) > 1e7
    assert run(["export", str(calibrated), "--to", "twin", "-o", str(out)]) == 0


def test_arrays_alone(made: dict[str, np.ndarray]) -> None:
    """Nothing that needs pickle; each name has its line, and the other way round."""
    assert all(np.asarray(value).dtype.kind in "fiuU" for value in made.values())
    known = {name for names in ABOUT for name in names.split(", ")}
    for name in made:
        plain = name
        for part in ("wrench", "pose", "guess_L", "guess_codes"):
            plain = f"MAP{name.removeprefix(part)}" if name.startswith(f"{part}_") else plain
        assert name in known or plain in known, name
    assert {name for name in known if not name.startswith(("MAP", "slope", "thermal"))} <= set(made)


def test_numbers_of_pad_and_converter(made: dict[str, np.ndarray], source: Source) -> None:
    """Those of history.py and front_end.py; the compliance against differences of the model."""
    weights, times = retardation(((0.2, 2.0),))
    assert np.array_equal(made["creep_weights"], weights) and np.array_equal(made["creep_times"], times)
    assert made["relaxation_weights"] == pytest.approx([0.25]) and made["mullins"].tolist() == [2.5, 0.0, 1.0]
    front, _ = sensor_front_end(source.sensor, source.data)
    assert made["reference"] == front.reference and made["channel_time"].sum() == pytest.approx(1.0 / front.rate)
    settling = made["opened"] - [0.0, made["channel_time"][0]]
    switching = made["channel_time"] - made["conversion"] - settling
    assert switching == pytest.approx(692e-9 + 5.0 / front.reference, rel=1e-6)
    assert made["sigma_L"] * made["wrench_base"][:2] == pytest.approx(front.noise, rel=0.05)
    ranges = np.ptp(Twin(made).read(_corners()).L, axis=0)  # noise weighs both coils alike
    assert made["scale_L"] == pytest.approx(ranges.max(), rel=0.02)
    layer, h = planar_layer(soft(source)), 1e-3
    ends = [layer.equilibrium(Wrench(F_x=h * sign)).pose.components for sign in (-1.0, 1.0)]
    slope = (ends[1] - ends[0]) / (2.0 * h)
    assert made["compliance"][:3, 0] == pytest.approx(slope[:3], rel=5e-3, abs=1e-9)  # poses are to 1e-2
    assert np.all(np.isnan(made["compliance"][3:]))
    assert made["temperature_known"] == 0 and "slope_T_L" not in made


def _corners() -> np.ndarray:
    """The corners of the wrenches' box."""
    found = np.zeros((4, 6))
    found[:, 0], found[:, 1] = np.repeat([-1.0, 1.0], 2), np.tile([0.0, 3.0], 2)
    return found


def test_slopes_by_temperature_go_with_it(source: Source) -> None:
    """What the table has of them, under its names, its loads beside; per metre it is the relative slope that holds."""
    causes = ["copper", "pad"]
    share = xr.DataArray([1e-4, 2e-4], {"thermal_cause": causes}, ["thermal_cause"])
    own = xr.DataArray(np.diagonal(source.data["L0"]), dims=["coil"])
    each = (share * own + 0.0 * source.data["d_v"]).transpose("coil", "thermal_cause", "F_z", "F_x")
    by = each.transpose("thermal_cause", "F_z", "F_x", "coil")
    data = source.data.assign(slope_T_L_by=by, slope_T_d_v=1e-6 + 0.0 * source.data["d_v"])
    numbers, _ = twin_arrays(Source(source.sensor, data))
    free = self_inductances(source.sensor)
    assert numbers["temperature_known"] == 1 and np.all(numbers["slope_T_d_v"] == 1e-6)
    assert numbers["slope_T_L_by"] == pytest.approx(np.broadcast_to(np.outer([1e-4, 2e-4], free), (5, 4, 2, 2)))
    assert numbers["thermal_causes"].tolist() == causes and numbers["slope_T_over_F_z"].tolist() == [0.0, 1.0, 2.0, 3.0]


def test_without_converter_or_inverse(source: Source) -> None:
    """No codes, or one coil of two forces: what is left stands, and a note says what is not there."""
    plain = changed(source.sensor, ['readout.converter="none"'])
    numbers, notes = twin_arrays(Source(plain, source.data))
    assert numbers["codes"] == 0 and np.all(np.isnan(numbers["sigma_L"])) and any("no codes" in line for line in notes)
    assert Twin(numbers).read(np.zeros((3, 6))).codes.shape == (3, 0)
    one = source.data.isel(coil=[0], coil_2=[0])
    one.attrs.pop("scene")
    sensor = source.sensor.model_copy(update={"coils": source.sensor.coils[:1]})
    numbers, notes = twin_arrays(Source(sensor, one))
    assert any("no estimate of wrenches: coils: 1 cannot resolve 2 forces" in line for line in notes)
    with pytest.raises(ValueError, match="guess: coils: 1 cannot resolve 2 forces"):
        Twin(numbers).estimate(np.ones((1, 1)))


def test_failed_loads(source: Source) -> None:
    """One at a corner: refused in one line that names it. One inside: the domain is a box all the same."""
    data = source.data.copy(deep=True)
    data["status"] = data["status"].astype(object)
    data["status"].loc[{"F_x": 0.5, "F_z": 1.0}] = "failed"
    assert len(twin_arrays(Source(source.sensor, data))[0]["wrench_low"]) == 2
    data["status"].loc[{"F_x": 1.0, "F_z": 3.0}] = "failed"
    with pytest.raises(SceneError, match=r"--to twin: .* a box; 2 of 20 loads failed, among them F_x = 1 N, F_z = 3 N"):
        twin_arrays(Source(source.sensor, data))
    with pytest.raises(SceneError, match="--to twin: must be of a table with at least two values of a force"):
        twin_arrays(Source(source.sensor, source.data.isel(F_x=[2], F_z=[1])))


def test_what_cannot_be_written(source: Source, calibrated: Path, tmp_path: Path, capfd: Said) -> None:
    """A file, another format's ending, a folder within a file, no calibration: one line, code 2."""
    (tmp_path / "file").write_text("")
    for name, said in (("file", "must name a folder"), ("t.h", "as for c"), ("t.npz", "must name a folder")):
        with pytest.raises(SceneError, match=said):
            export(source, "twin", tmp_path / name)
    with pytest.raises(SceneError, match="must be writable"):
        export(source, "twin", tmp_path / "file" / "in")
    assert run(["export", str(tmp_path), "--to", "twin", "-o", str(tmp_path / "x")]) == 2
    assert "must be the folder of a finished calibration" in capfd.readouterr().err
