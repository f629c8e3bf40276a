"""The folder of a calibration: what was written is read back; anything else is refused with one line."""

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from sits_mech.cli.main import run
from sits_mech.mechanics.block import BlockPad
from sits_mech.mechanics.layer import PlanarLayer
from sits_mech.notes import unpacked_omissions
from sits_mech.report.folder import read_calibration
from sits_mech.report.written import write_calibration
from sits_mech.scene.sensor import changed, load_sensor, save_sensor
from sits_mech.store import read_table, save_table


@pytest.fixture
def copied(calibrated: Path, tmp_path: Path) -> Path:
    """A copy that may be spoiled."""
    return Path(shutil.copytree(calibrated, tmp_path / "copied"))


def test_read_back(calibrated: Path) -> None:
    """Scene and table as they were written."""
    sensor, data = read_calibration(calibrated)
    sizes = {"F_x": 5, "F_z": 4, "coil": 2, "coil_2": 2, "cause": 3, "part": 6}  # three shared are of what is left out
    assert sensor == load_sensor("biorob2018-w15") and dict(data.sizes) == sizes
    assert np.all(data["status"] == "above tolerance") and len(unpacked_omissions(data.attrs["left_out"])) == 4


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
    for name in ("alpha", "error_L"):
        save_table(read_table(table).drop_vars(name), table)
        with pytest.raises(ValueError, match=f"must be the table of a calibration; {name} is missing"):
            read_calibration(copied)
        table.write_bytes(whole)
    table.unlink()
    (copied / "cases").mkdir(exist_ok=True)
    with pytest.raises(ValueError, match="a calibration that was stopped: repeat its command"):
        read_calibration(copied)


@pytest.mark.parametrize(
    ("name", "value"), [("request", "{damaged"), ("request", '{"tolerance": 0.1}'), ("frequency", "often"),
                        ("unit_L", "mH"), ("magnetics_tolerance", "fine")],
)
def test_a_damaged_attribute_is_named(copied: Path, name: str, value: str, capsys: pytest.CaptureFixture[str]) -> None:
    """In one line, of whatever command."""
    table = copied / "result.nc"
    save_table(read_table(table).assign_attrs({name: value}), table)
    for words in (["quality"], ["export", "--to", "csv", "-o", str(copied / "t.csv")]):
        assert run([words[0], str(copied), *words[1:]]) == 2
        assert f"result.nc: must have {name} as it was written; got {value}: calib" in capsys.readouterr().err


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
    data["status"][:] = "failed"
    save_table(data, copied / "result.nc")
    with pytest.raises(ValueError, match="at least one load that converged"):
        read_calibration(copied)


def test_a_table_of_three_forces_has_what_can_be_drawn(three_forces: Path) -> None:
    """Curves and crosstalk as slices; no picture of a layer that the model keeps no section of."""
    sensor, data = read_calibration(three_forces)
    assert dict(data.sizes) == {"F_x": 5, "F_z": 4, "F_y": 3, "coil": 2, "coil_2": 2} and float(data["M"]) == 1e-3
    assert {path.name for path in three_forces.glob("*.png")} >= {"L_v.png", "L_h.png", "crosstalk.png"}


def test_without_matplotlib_a_folder_has_the_numbers(
    copied: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With one line in place of pictures; pictures that are asked for are refused before anything is solved."""
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    sensor, data = read_calibration(copied)
    for path in copied.glob("*.png"):
        path.unlink()
    (said,) = write_calibration(sensor, data, copied)
    assert said.startswith("no pictures: they need matplotlib") and not list(copied.glob("*.png"))
    monkeypatch.setattr(BlockPad, "controlled", None)
    for words in (["cycle", "biorob2018", "--picture"], ["view", "biorob2018", "-o"]):
        assert run([*words, str(copied / "a.png")]) == 2
        assert "pictures need matplotlib" in capsys.readouterr().err


@pytest.mark.parametrize("form", ["csv", "netcdf", "xlsx", "kicad"])
def test_what_holds_any_loads(three_forces: Path, tmp_path: Path, form: str) -> None:
    """Tables for other programs, and the board."""
    path = tmp_path / f"table.{dict(netcdf='nc', kicad='kicad_mod').get(form, form)}"
    assert run(["export", str(three_forces), "--to", form, "-o", str(path)]) == 0
    assert path.stat().st_size > 0
    if form == "netcdf":
        data = read_table(path)
        assert {name: data[name].attrs["units"] for name in ("d_y", "F_y", "M")} == {"d_y": "m", "F_y": "N", "M": "N m"}


@pytest.mark.slow
def test_the_layer_is_drawn_as_it_was_solved(
    calibrated: Path, copied: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The largest load's kept state makes the picture; nothing is solved for it."""
    (copied / "layer.png").unlink()
    for model in (BlockPad, PlanarLayer):
        monkeypatch.setattr(model, "controlled", lambda *_, **__: pytest.fail("solved again"))
    sensor, data = read_calibration(copied)
    assert write_calibration(sensor, data, copied) == []
    assert (copied / "layer.png").read_bytes() == (calibrated / "layer.png").read_bytes()
