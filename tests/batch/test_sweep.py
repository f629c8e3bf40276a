"""One name for functions and for studies, and what it refuses."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import xarray as xr

import sits_mech as sm
from sits_mech.batch.run import run_study
from sits_mech.batch.studies.study import read_study

STUDY = 'scene = "biorob2018"\nrequest = "pose"\nvary.fz = ["0 N", "1 N"]\nfixed.model = "linear"\n'


def test_a_study_is_run_as_the_command_does(tmp_path: Path) -> None:
    """By its path, in this process and in others, with its table in the folder; kept cases are taken again."""
    path, seen = tmp_path / "study.toml", []
    path.write_text(STUDY)
    with ThreadPoolExecutor(2) as executor:
        data = sm.sweep(str(path), folder=tmp_path / "out", executor=executor, progress=lambda *done: seen.append(done))
    assert seen == [(1, 2), (2, 2)]
    alone = run_study(read_study(path), tmp_path / "alone")
    xr.testing.assert_identical(data.drop_vars("seconds"), alone.drop_vars("seconds"))
    with sm.open_sweep(tmp_path / "out") as table:
        xr.testing.assert_identical(table.load(), sm.sweep(path, folder=str(tmp_path / "out")))


def test_what_is_neither_is_refused(tmp_path: Path) -> None:
    """In one line, before anything is written."""
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    with pytest.raises(sm.SceneError, match="folder: must be given for a study"):
        sm.sweep(path)
    with pytest.raises(sm.SceneError, match="grid, chunk: must be said by the study file; got both"):
        sm.sweep(path, {"fz": [1.0]}, folder=tmp_path / "out", chunk=2)
    with pytest.raises(sm.SceneError, match="grid: must be given for a function"):
        sm.sweep(lambda: {})
    with pytest.raises(sm.SceneError, match=r"none\.toml"):
        sm.sweep(tmp_path / "none.toml", folder=tmp_path / "out")
    assert not (tmp_path / "out").exists()
