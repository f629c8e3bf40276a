"""One name for functions and for studies, and what it refuses."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
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


def loose(n: float) -> dict[str, object]:
    """A number where n is one; what no table holds beside it elsewhere, or at all."""
    results = {1.0: 2.0, 2.0: "none", 3.0: ("k", np.arange(3.0)), 4.0: 1j, 5.0: [1, 2, 3], 6.0: np.arange(3.0)}
    return {"n": 1.0} if n == 7.0 else {"x": results[n]}


@pytest.mark.parametrize("kept", [True, False])
def test_results_that_no_table_holds_are_rows(kept: bool, tmp_path: Path) -> None:
    """With a reason, whatever else was solved stays."""
    data = sm.sweep(loose, {"n": [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]}, folder=tmp_path if kept else None)
    assert data["status"].values.tolist() == ["ok"] + 6 * ["failed"] and data["x"].values[0] == 2.0
    reasons = data["reason"].values.tolist()
    assert all(reason.startswith("results must be of one kind and shape: ") for reason in reasons[1:3])
    assert all(reason.startswith("x: must be a number, a text, or (dims, array) of such;") for reason in reasons[3:6])
    assert reasons[6].startswith("n: must have another name than the grid")


def test_a_grid_holds_any_values_under_names_of_its_own(tmp_path: Path) -> None:
    """Tuples are labels; long arrays that differ in their middle are two points; columns of all tables are refused."""
    found = sm.sweep(lambda pair: {"sum": sum(pair)}, {"pair": [(1, 2), (3, 4)]})
    assert found["sum"].values.tolist() == [3.0, 7.0] and found["pair"].values.tolist() == [(1, 2), (3, 4)]
    for combine in ("product", "zip"):
        found = sm.sweep(lambda x: {"twice": 2.0 * x}, {"x": (1.0, 2.0)}, combine=combine)
        assert found["twice"].values.tolist() == [2.0, 4.0] and found["x"].values.tolist() == [1.0, 2.0]
    heights = np.full((2, 1201), 1e-3)
    heights[1, 600] += 1e-12
    poses = [sm.Pose(0.0, row) for row in heights]
    data = sm.sweep(lambda pose: {"d_v": float(np.max(pose.d_v))}, {"pose": poses}, folder=tmp_path)
    assert np.diff(data["d_v"].values) > 0.0
    with pytest.raises(sm.SceneError, match="grid: must have other names than the table's reason, .*; got status"):
        sm.sweep(loose, {"status": [1.0]})
    with pytest.raises(sm.SceneError, match="grid: n: must be a list of values; got 3"):
        sm.sweep(loose, {"n": 3})
