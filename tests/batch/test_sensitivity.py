"""Sobol' indices of a table against closed forms; what is no such table is refused."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.batch.sensitivity import sensitivity
from sits_mech.batch.studies.samples import cube
from sits_mech.cli.main import run
from sits_mech.store import save_table
from sits_mech.units import SceneError

COUNT = 1024


@pytest.fixture(scope="module")
def table() -> xr.Dataset:
    """A sum of uniform keys x + 2 y, and Ishigami's function with three, as two coils would show them."""
    share = cube("saltelli", COUNT, 0, 3)
    x, y, z = (2.0 * share - 1.0).T
    ishigami = np.sin(np.pi * x) + 7.0 * np.sin(np.pi * y) ** 2 + 0.1 * (np.pi * z) ** 4 * np.sin(np.pi * x)
    values = np.stack([x + 2.0 * y, ishigami], axis=-1)
    data = xr.Dataset({"status": ("case", np.full(len(x), "ok")), "q": (("case", "coil"), values)})
    data = data.assign(sum=data["q"][:, 0].drop_vars("coil", errors="ignore"))
    data = data.assign_coords(coil=["C1", "C2"], x=("case", x), y=("case", y), z=("case", z), twice=("case", 2 * x))
    return data.assign_attrs(combine="saltelli", samples=COUNT, derive=json.dumps({"twice": "2 * x"}))


def test_indices_are_those_of_the_closed_forms(table: xr.Dataset) -> None:
    """1/5 and 4/5 of the sum; Ishigami's 0.3139, 0.4424, 0 and 0.5576, 0.4424, 0.2437 (Sobol' and Levitan, 1999)."""
    found = sensitivity(table, "q")
    assert found.parts == ("C1", "C2") and found.keys == ("x", "y", "z") and found.design_rows == (COUNT, COUNT)
    for exact, got, (low, high) in (
        ([[0.2, 0.8, 0.0], [0.3139, 0.4424, 0.0]], found.first_order, found.first_interval),
        ([[0.2, 0.8, 0.0], [0.5576, 0.4424, 0.2437]], found.total_order, found.total_interval),
    ):
        np.testing.assert_allclose(got, exact, atol=0.03)
        assert np.all(low <= got + 1e-12) and np.all(got <= high + 1e-12) and np.all(high - low < 0.25)
    again = sensitivity(table, "sum")
    assert again.parts == ("",) and np.array_equal(again.first_order[0], found.first_order[0])


def test_rows_with_a_failed_case_are_left_out(table: xr.Dataset) -> None:
    """All cases of the row; and what is over a power of two."""
    data = table.copy(deep=True)
    data["q"][COUNT + 7] = np.nan
    found = sensitivity(data, "q")
    assert found.design_rows == (COUNT // 2, COUNT)
    np.testing.assert_allclose(found.first_order[0], [0.2, 0.8, 0.0], atol=0.05)


def test_what_has_no_indices(table: xr.Dataset) -> None:
    """Another design; a name that is none, with the nearest; no numbers."""
    with pytest.raises(SceneError, match='combine = "saltelli"; got sobol'):
        sensitivity(table.assign_attrs(combine="sobol"), "q")
    with pytest.raises(SceneError, match=r'--of must be one of q, sum; got "summ" \(did you mean "sum"\?\)'):
        sensitivity(table, "summ")
    with pytest.raises(SceneError, match="two rows of the design at least; got 0 of 1024"):
        sensitivity(table.assign(q=table["q"] * np.nan), "q")


@pytest.mark.slow
def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """From study to table and JSON: pressed straight, depth goes with the force, not with the target's thickness."""
    monkeypatch.chdir(tmp_path)
    text = 'scene = "biorob2018"\nrequest = "pose"\ncombine = "saltelli"\nsamples = 32\n[vary]\n'
    text += 'fz = { from = "0.5 N", to = "1.5 N" }\n"target.thickness" = { from = 2e-4, to = 3e-4 }\n'
    Path("study.toml").write_text(text + '[fixed]\nmodel = "closed-form"\n"target.width" = "20 mm"\n')
    assert run(["sweep", "study.toml", "-o", "out", "--accept"]) == 0
    capsys.readouterr()
    assert run(["sensitivity", "out", "--of", "d_v"]) == 0
    assert "Sobol' indices of d_v" in capsys.readouterr().out
    assert run(["sensitivity", "out", "--of", "d_v", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["keys"] == ["fz", "target.thickness"] and found["total_order"][0][1] == pytest.approx(0.0, abs=1e-9)
    assert found["total_order"][0][0] == pytest.approx(1.0, abs=0.3)
    assert run(["sensitivity", "nowhere", "--of", "d_v"]) == 2
    data = xr.load_dataset("out/result.nc", engine="netcdf4")
    assert data["target.thickness"].units == "m"
    save_table(data.assign_attrs(combine="zip"), Path("out/result.nc"))
    assert run(["sensitivity", "out", "--of", "d_v"]) == 2
