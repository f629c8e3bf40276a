"""The folder of a calibration: what was written is read back; anything else is refused with one line."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from sits_mech.report.folder import read_calibration
from sits_mech.sensor import changed, load_sensor, save_sensor
from sits_mech.sweep import read_table, save_table


@pytest.fixture
def copied(calibrated: Path, tmp_path: Path) -> Path:
    """A copy that may be spoiled."""
    return Path(shutil.copytree(calibrated, tmp_path / "copied"))


def test_read_back(calibrated: Path) -> None:
    """Scene and table as they were written."""
    sensor, data = read_calibration(calibrated)
    assert sensor == load_sensor("biorob2018-w15") and dict(data.sizes) == {"F_x": 5, "F_z": 4, "coil": 2, "coil_2": 2}
    assert np.all(data["status"] == "converged")


def test_what_is_no_calibration(copied: Path, tmp_path: Path) -> None:
    """Nothing, a stopped run, a file cut short, a table of something else."""
    with pytest.raises(ValueError, match=r"nowhere: must be the folder of a finished calibration.*got none"):
        read_calibration(tmp_path / "nowhere")
    table = copied / "result.nc"
    whole = table.read_bytes()
    table.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ValueError, match="result.nc: must be a table of this package"):
        read_calibration(copied)
    table.write_bytes(whole)
    save_table(read_table(table).drop_vars("alpha"), table)
    with pytest.raises(ValueError, match="must be the table of a calibration; alpha is missing"):
        read_calibration(copied)
    table.unlink()
    (copied / "cases").mkdir(exist_ok=True)
    with pytest.raises(ValueError, match="a calibration that was stopped: repeat its command"):
        read_calibration(copied)


def test_of_another_version_or_scene(copied: Path) -> None:
    """A table is read by the version that wrote it, with the scene it was made for."""
    data = read_table(copied / "result.nc")
    save_table(data.assign_attrs(version="0.0.9"), copied / "result.nc")
    with pytest.raises(ValueError, match="must be a calibration by version .*; got 0.0.9: calibrate anew"):
        read_calibration(copied)
    save_table(data, copied / "result.nc")
    save_sensor(changed(load_sensor(copied / "scene.toml"), ['target.width="14 mm"']), copied / "scene.toml")
    with pytest.raises(ValueError, match="scene.toml must be the scene of result.nc"):
        read_calibration(copied)


def test_without_a_load_that_converged(copied: Path) -> None:
    """Nothing can be made of it."""
    data = read_table(copied / "result.nc")
    data["status"][:] = "stalled"
    save_table(data, copied / "result.nc")
    with pytest.raises(ValueError, match="at least one load that converged"):
        read_calibration(copied)
