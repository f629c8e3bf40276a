"""The report of a sweep: its numbers, commands that repeat failed cases, axes and slices in a browser."""

import html
import json
import re
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sits_mech.batch.run import open_sweep, run_study
from sits_mech.batch.studies.study import read_study
from sits_mech.cli.main import run
from sits_mech.report.page import sweep
from sits_mech.report.tables.cases import case_remarks
from sits_mech.store import read_table, save_table

STUDY = """scene = ["biorob2018", "biorob2018-w15"]
request = "inductance"
[vary]
"target.thickness" = ["0.2 mm", "0.3 mm"]
dv = ["1 mm", "0.2 mm", "3 mm"]
[fixed]
alpha = "4 deg"
model = "planar"
tolerance = 1e-1
frequency = "5 kHz"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep with cases that fail, and its report."""
    place = tmp_path_factory.mktemp("sweep")
    (place / "study.toml").write_text(STUDY)
    run_study(read_study(place / "study.toml"), place / "out")
    assert run(["report", str(place / "out")]) == 0
    return place / "out"


def test_numbers_are_those_of_the_table(folder: Path) -> None:
    """Case by case, keys first, a column for each coil; no address of another file."""
    whole = (folder / "report.html").read_text()
    assert "http" not in re.sub(r"http://www\.w3\.org/2000/svg", "", whole) and "src=" not in whole
    record = json.loads(whole.partition('id="table">')[2].partition("</script>")[0])
    columns = {each["name"]: each for each in record["columns"]}
    assert list(columns)[: record["keys"]] == ["scene", "target.thickness", "dv"] and record["grid"]
    assert columns["dv"]["label"] == "dv [m]" and columns["dv"]["values"] == [1e-3, 2e-4, 3e-3] * 4
    assert columns["scene"]["words"] == ["biorob2018", "biorob2018-w15"] and record["cases"] == list(range(1, 13))
    with open_sweep(folder) as data:
        own = np.array([np.nan if v is None else v for v in columns["relative[C2]"]["values"]])
        np.testing.assert_allclose(own, data["relative"][..., 1].to_numpy().ravel(), rtol=1e-5)
        np.testing.assert_allclose(
            np.array(columns["L[C1]"]["values"], dtype=float), data["L"][..., 0, 0].to_numpy().ravel(), rtol=1e-5
        )


def test_what_planar_models_leave_out_stands_there_with_its_size(folder: Path) -> None:
    """The ends, of how many cases and the largest; netCDF has them case by case."""
    part = (folder / "report.html").read_text().partition('id="left-out"')[2].partition("</section>")[0]
    with open_sweep(folder) as data:
        lines = case_remarks(data)
    ends = next(line for line in lines if "at most: ends along y: " in line)
    assert re.search(r"about [\d.]+ of the change", ends) and all(html.escape(line) in part for line in lines)


def test_failed_cases_are_repeated_by_their_commands(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The message of each comes again; a case that did not fail gives the number of the table."""
    whole = (folder / "report.html").read_text()
    commands = [shlex.split(html.unescape(text)) for text in re.findall("<code>(.*?)</code>", whole)]
    with open_sweep(folder) as data:
        reasons = [text for text in data["reason"].to_numpy().ravel() if text]
        assert len(commands) == len(reasons) >= 2
        for words, reason in zip(commands[::3], reasons[::3], strict=True):
            assert words[0] == "sits-mech" and run(words[1:]) in (2, 3)
            assert reason in " ".join(capsys.readouterr().err.split())
        row = data.isel({"scene": 1, "target.thickness": 1, "dv": 2})
        files = {"biorob2018-w15": folder / "scene-1.toml"}
        assert run([*shlex.split(sweep.command(row, files))[1:], "--json"]) in (0, 4)
        found = json.loads(capsys.readouterr().out)
        np.testing.assert_allclose(np.ravel(found["L"]), row["L"].to_numpy().ravel(), rtol=1e-12)


def test_large_and_unfinished_tables(folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Evenly chosen cases, and a line that says so; cases to come are neither shown nor failed."""
    data = read_table(folder / "result.nc")
    monkeypatch.setattr(sweep, "_MOST", 60)
    assert "of 12 cases are here; result.nc has all" in sweep.sweep_page(data, [], {})
    monkeypatch.undo()
    named = data.assign_coords(scene=["<b>x", "y"])
    whole = sweep.sweep_page(named, [0], {"<b>x": tmp_path / "<b>x.toml"})
    assert "scene = &lt;b&gt;x" in whole and "<b>x" not in whole.partition("</table>")[0]
    data["status"] = data["status"].dims, np.full(data["status"].shape, "unfinished")
    save_table(data, tmp_path / "result.nc")
    assert sweep.columns_of(data)["cases"] == [] and sweep.write_sweep(tmp_path, tmp_path / "report.html") == []


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 390])
def test_axes_and_slices_follow(browser: Any, folder: Path, width: int) -> None:
    """Twelve lines; a part of an axis keeps some; a slice over two keys has the cells at the third's slider."""
    browser.width(width)
    browser.open(folder / "report.html")
    assert browser.run("document.querySelectorAll('#parallel path').length") == 12
    assert browser.run("document.querySelectorAll('#slice rect title').length") == 6
    drag = """(() => {
      const grip = document.querySelector('[data-axis="dv"]'), box = grip.getBoundingClientRect();
      const at = (share) => ({ bubbles: true, clientX: box.x + 5, clientY: box.y + share * box.height });
      grip.dispatchEvent(new PointerEvent("pointerdown", at(FROM)));
      window.dispatchEvent(new PointerEvent("pointerup", at(TO)));
      return document.getElementById("state").textContent;
    })()"""
    assert browser.run(drag.replace("FROM", "0.9").replace("TO", "0.5")) == "4 of 12 cases kept"  # 1 mm, not 0.2 and 3
    assert browser.run(drag.replace("FROM", "0.9").replace("TO", "0.9")) == "12 of 12 cases kept"
    size = browser.run("[document.documentElement.scrollWidth, document.documentElement.clientWidth]")
    assert size[0] <= size[1] and browser.complaints() == []
