"""Pictures for a paper: every one of a calibration that its loads allow, as vectors; a file is no folder."""

from pathlib import Path

import pytest

from sits_mech.cli.main import run


@pytest.mark.parametrize(("form", "start"), [pytest.param("pdf", b"%PDF", marks=pytest.mark.slow), ("svg", b"<?xml")])
def test_curves_and_crosstalk(
    calibrated: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], form: str, start: bytes
) -> None:
    """Named as the pictures in the calibration's folder; where that of the layer comes from is said."""
    path = tmp_path / "made" / "pictures"
    assert run(["export", str(calibrated), "--to", form, "-o", str(path)]) == 0
    assert {file.name for file in path.iterdir()} == {f"{name}.{form}" for name in ("L_v", "L_h", "crosstalk")}
    assert all(file.read_bytes().startswith(start) for file in path.iterdir())
    told = capsys.readouterr().err
    assert "sits-mech view SCENE" in told and f"written to {path}" in told
    assert run(["export", str(calibrated), "--to", form, "-o", str(path / f"L_v.{form}")]) == 2
    assert f"must name a folder for --to {form}" in capsys.readouterr().err


@pytest.mark.slow
def test_what_a_table_has_no_loads_for_is_said(
    three_forces: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Slices of three forces can all be drawn; of a file that is in the way one line says so."""
    assert run(["export", str(three_forces), "--to", "svg", "-o", str(tmp_path / "all")]) == 0
    assert "no picture" not in capsys.readouterr().err
    (tmp_path / "taken").write_text("")
    assert run(["export", str(three_forces), "--to", "svg", "-o", str(tmp_path / "taken")]) == 2
    assert "must name a folder" in capsys.readouterr().err
