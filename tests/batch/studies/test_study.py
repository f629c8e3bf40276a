"""Stages of a study: read and refused, run one after the other, and what is not solved twice."""

from pathlib import Path

import numpy as np
import pytest

from sits_mech.batch import requests
from sits_mech.batch.run import open_sweep, run_study
from sits_mech.batch.studies.study import read_study
from sits_mech.cli.main import run
from sits_mech.report.folder import read_calibration
from sits_mech.store import read_table
from sits_mech.units import SceneError

FIRST = """scene = "biorob2018"
request = "calibrate"
[vary]
"elastomer.thickness" = ["2 mm", "3 mm", "4 mm"]
[fixed]
fx = "-0.2 N:0.2 N:3"
fz = "0 N:1 N:3"
tolerance = 0.1
mechanics = "linear"
magnetics = "planar"
"readout.converter" = "LDC1614"
"""
STAGES = """[[then]]
where = ["failed_loads < 1", "elastomer.thickness < 3.5 mm"]
request = "quality"
[[then]]
least = "resolution.F_z"
count = 1
export = ["csv", "netcdf"]
"""


def written(folder: Path, text: str) -> Path:
    """Return the path of a study file with a text."""
    path = folder / "study.toml"
    path.write_text(text)
    return path


@pytest.mark.slow
def test_a_funnel_from_calibrations_to_exports(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Quality is that of a study of its own, without another calibration; a repeated run solves nothing."""
    calibrate, count = requests.calibrate, []

    def counted(*words: object, **more: object) -> object:
        count.append(1)
        return calibrate(*words, **more)  # type: ignore[arg-type]

    monkeypatch.setattr("sits_mech.chain.calibrate.calibrate", counted)
    path, out = written(tmp_path, FIRST + STAGES), tmp_path / "out"
    assert run(["sweep", str(path), "-o", str(out), "--accept"]) == 0 and len(count) == 3
    said = capsys.readouterr()
    assert "then.1: 2 of 3 cases go on to quality" in said.err and "then.2: 1 of 2 cases go on to export" in said.err
    assert "calibrate: 3 cases" in said.out and "quality: 2 cases" in said.out
    assert run(["sweep", str(path), "-o", str(out), "--accept"]) == 0 and len(count) == 3
    with open_sweep(out / "then-1") as data:
        found = data.load()
    alone = FIRST.replace("calibrate", "quality").replace(', "4 mm"', "").replace("[vary]", 'combine = "zip"\n[vary]')
    other = run_study(read_study(written(tmp_path, alone)), tmp_path / "alone")
    assert len(count) == 5
    for name in ("resolution", "error_by_model", "L", "crosstalk_after", "condition", "largest_stretch"):
        np.testing.assert_array_equal(found[name], other[name])
    assert found["status"].equals(other["status"]) and found["flags"].equals(other["flags"])
    best = 1 + int(np.argmin(found["resolution"].sel(force="F_z").to_numpy()))
    place = out / "then-2" / f"case-{best}"
    sensor, data = read_calibration(place)
    np.testing.assert_array_equal(data["L"], found["L"][best - 1])
    assert sensor.elastomer is not None and sensor.elastomer.thickness == float(found["elastomer.thickness"][best - 1])
    names = {file.suffix for file in place.iterdir()}
    assert names >= {".nc", ".csv", ".toml"} and len([*place.glob("*.nc")]) == 2


@pytest.mark.slow
def test_a_stage_may_change_what_is_fixed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of the scene too; what the next request does not know is left out; with none left the exit code is 3."""
    text = 'scene = "biorob2018"\nrequest = "pose"\n[vary]\nfz = ["0.5 N", "1 N"]\n[fixed]\n"target.width" = "20 mm"\n'
    text += 'model = "closed-form"\n'
    text += '[[then]]\nlargest = "d_v"\ncount = 1\nrequest = "pose"\nfixed."elastomer.thickness" = "4 mm"\n'
    text += '[[then]]\nrequest = "simulate"\nfixed = { mechanics = "closed-form", magnetics = "planar" }\n'
    path, out = written(tmp_path, text), tmp_path / "out"
    assert run(["sweep", str(path), "-o", str(out), "--accept"]) == 0
    first, second, third = (read_table(out / place / "result.nc") for place in (".", "then-1", "then-2"))
    assert second["fz"].to_numpy().tolist() == [0.5] and third["fz"].to_numpy().tolist() == [0.5]
    assert float(second["d_v"][0]) > 1.5 * float(first["d_v"].max())
    assert float(third["d_v"][0]) == pytest.approx(float(second["d_v"][0]), rel=1e-9)
    path = written(tmp_path, text.replace("[[then]]", '[[then]]\nwhere = ["d_v < 1 um"]', 1))
    capsys.readouterr()
    assert run(["sweep", str(path), "-o", str(out), "--accept"]) == 3
    assert "then.1: 0 of 2 cases go on to pose" in capsys.readouterr().err
    path = written(tmp_path, text.replace('largest = "d_v"', 'largest = "dv"'))
    assert run(["sweep", str(path), "-o", str(out), "--accept"]) == 2
    said = capsys.readouterr().err
    assert 'then.1.largest: must be one of' in said and 'did you mean "d_v"' in said
    assert run(["sweep", str(path), "--plan"]) == 0 and "then: later stages" in capsys.readouterr().err


REFUSED = {
    STAGES.replace("[[then]]\nwhere", "[[then]]\nwehre"): 'then.1.wehre: the key must be .*did you mean "where"',
    STAGES.replace("< 1", "<"): "then.1.where: must be a comparison",
    STAGES.replace("failed_loads", "2"): "then.1.where: must name a column",
    STAGES.replace("count = 1", 'count = "1"'): "then.2.count: must be a whole number",
    STAGES.replace('least = "resolution.F_z"', ""): "then.2: must have least or largest, beside a count",
    STAGES.replace('"quality"', '"qualty"'): 'then.1.request: must be one of .*did you mean "quality"',
    STAGES.replace('"quality"', '"inductance"'): "then.1: dv: must be given under vary or fixed for inductance",
    STAGES.replace('"quality"', '"pose"\nfixed = { fx = 0, fz = 1 }'): "then.2: export: must follow .* it follows pose",
    STAGES.replace('"quality"', '"quality"\nfixed.tolerance = 2'): "then.1: tolerance: must be .* 1; got 2",
    STAGES.replace('"quality"', '"quality"\nfixed.tolerence = 2'): 'then.1: argument of quality .*did you mean "tol',
    STAGES.replace('"quality"', '"quality"\nfixed."elastomer.thickness" = 2'): "then.1: fixed.elastomer.thi",
    STAGES + "[[then]]\nrequest = 'quality'\n": "then.3: must not follow an export",
    "[then]\nrequest = 'quality'\n": r"then: must be a list of tables, as under \[\[then",
}


@pytest.mark.parametrize("text", REFUSED, ids=list(REFUSED.values()))
def test_what_is_no_stage(text: str, tmp_path: Path) -> None:
    """One line: which stage, which key, what it must be, what came."""
    with pytest.raises(SceneError, match=REFUSED[text]) as refused:
        read_study(written(tmp_path, FIRST + text))
    assert "\n" not in str(refused.value)


def test_formats_are_known_before_a_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Nothing is solved for an export that cannot be."""
    path = written(tmp_path, FIRST + STAGES.replace('"netcdf"', '"netcdff"'))
    assert run(["sweep", str(path), "-o", str(tmp_path / "out")]) == 2
    assert "then.2.export: must be one of" in capsys.readouterr().err and not (tmp_path / "out").exists()
