"""The folder of an answer: scenes that open, a table, pictures, a page; what a reader and a program are told."""

import csv
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from sits_mech.cli.main import run
from sits_mech.report.design import worst_load, write_design
from sits_mech.report.plots.design import design_pictures
from sits_mech.report.tables.design import design_record, figure_table
from sits_mech.scene.sensor import load_sensor
from sits_mech.store import read_table
from sits_mech.synthesis.required.kinds import STRAIN
from sits_mech.synthesis.required.requirements import requirements_of
from sits_mech.synthesis.required.space import Design
from sits_mech.synthesis.run import design
from sits_mech.synthesis.solved.answered import Answered
from sits_mech.synthesis.solved.figures import Table
from sits_mech.synthesis.solved.solve import Solver

ASKED: dict[str, Any] = {
    "scene": "biorob2018", "loads": {"F_z": ["0 N", "0.4 N"]},
    "vary": {
        "elastomer.thickness": {"from": "1.5 mm", "to": "3 mm"}, "target.width": {"from": "7 mm", "to": "9 mm"},
        "elastomer.material": ["ecoflex-00-30", "dragon-skin-10"],
    },
    "require": {"error": {"F_z": "9 %"}, "height": "3 mm"}, "tolerance": {"modulus": "10 %"},
    "goal": {"minimise": "resolution.F_z"},
}
TEXT = """scene = "biorob2018"
[loads]
F_z = ["0 N", "0.4 N"]
[vary]
"elastomer.thickness" = { from = "1.5 mm", to = "3 mm" }
[require]
height = "2.6 mm"
"""


def bent(self: Solver, wanted: Design) -> Answered:
    """Answer a design in closed form: two coils that both bend with the force."""
    x, y = wanted.x
    F, k = self.operator.loads.axes[0], (1.0, 5.0)[wanted.choice[0]]

    def table(x: float, y: float, k: float) -> np.ndarray:
        """Inductances."""
        sink = F * (1.0 + x) / (k * (1.0 + 0.2 * y))
        return np.column_stack([2e-6 - 1e-7 * (sink + side * sink**2) for side in (0.2, 0.3)])

    L, h = table(x, y, k), 1e-6
    by_x = np.array([(table(x + h, y, k) - L) / h, (table(x, y + h, k) - L) / h])
    plain = {"height": 1.8e-3 + 1.5e-3 * x, STRAIN: 0.3 / k}
    slopes = {"height": np.array([1.5e-3, 0.0]), STRAIN: np.zeros(2)}
    by_tolerance = ((table(x, y, k * (1 + h)) - L) / h)[None]
    return Answered(wanted, "", Table(L, by_tolerance, np.full(2, 1e-12)), by_x, plain, slopes, {"error.F_z": 1e-3})


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of an answer."""
    place = tmp_path_factory.mktemp("design")
    asked = requirements_of(ASKED)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Solver, "answered", bent)
        found = design(asked)
    assert write_design(asked, found, place) == []
    record = design_record(found)
    assert set(record) >= {"feasible", "recommended", "figures", "binding", "yield", "front", "solves"}
    assert figure_table(found).row_count == len(found.figures)
    assert "front" in design_pictures(asked, found) and "front" not in design_pictures(asked, replace(found, front=()))
    (axes,) = design_pictures(asked, found)["front"]().axes
    assert axes.get_xlabel() == "height [mm]", "the limit that the recommended design is nearest to"
    bare = replace(found, task=replace(found.task, minimised={}, limits={STRAIN: 1.0}))
    assert "front" not in design_pictures(asked, bare), "nothing that can be drawn is asked for"
    return place


def test_scenes_open(folder: Path) -> None:
    """The recommended one has the answer's values; those of the front are others."""
    answer = json.loads((folder / "answer.json").read_text())
    sensor = load_sensor(folder / "recommended.toml")
    assert sensor.elastomer is not None
    thickness = float(str(answer["recommended"]["elastomer.thickness"]).split()[0])
    assert sensor.elastomer.thickness == pytest.approx(thickness * 1e-3) and "recommended" in sensor.name
    assert [load_sensor(path) for path in sorted((folder / "front").iterdir())]


def test_tables_hold_every_design(folder: Path) -> None:
    """CSV and netCDF alike, one row each, figures in SI."""
    data = read_table(folder / "designs.nc")
    with (folder / "designs.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == data.sizes["design"] > 3
    np.testing.assert_allclose([float(row["height"]) for row in rows], data["height"])


def test_the_page_stands_alone(folder: Path) -> None:
    """Pictures inside, no address of a network, the requirement's words."""
    text = (folder / "report.html").read_text()
    assert text.count("data:image/png;base64,") == 4 and "http" not in text.replace("http://www.w3.org", "")
    for words in ("why not", "by a tenth of its range", "effect of 10 % more of each", "what the figures mean"):
        assert words in text
    assert text.count('<div class="pictures">') == 1, "pictures in the page's width"
    for name in ("front", "landscape", "limits", "worst_load"):
        assert (folder / f"{name}.png").stat().st_size > 5000


@pytest.mark.slow
def test_nothing_is_written_over_another(
    collisions: Callable[[Figure], list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the front, the landscape and the limits; what hollow marks, dashes, dots and the star are stands above."""
    asked = requirements_of(ASKED)
    monkeypatch.setattr(Solver, "answered", bent)
    drawn = {name: draw() for name, draw in design_pictures(asked, design(asked)).items()}
    assert [collisions(drawn[name]) for name in ("front", "landscape", "limits")] == [[], [], []]
    assert "hollow" in drawn["front"].get_suptitle() and "star: recommended" in drawn["landscape"].get_suptitle()


def test_the_largest_load_is_a_corner() -> None:
    """Of the plane's components, with signs."""
    loads = {"F_x": ["-1 N", "0.5 N"], "F_z": ["0 N", "4 N"]}
    load = worst_load(requirements_of(ASKED | {"loads": loads, "require": {}}))
    assert (load.F_x, load.F_z) == (-1.0, 4.0)


def test_the_command_plans_and_previews(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A plan solves none and writes nothing; a preview solves one, as a height is known, and the answer keeps it."""
    solved, path, out = list[Design](), tmp_path / "flat.toml", tmp_path / "out"
    path.write_text(TEXT)

    def flat(self: Solver, wanted: Design) -> Answered:
        """Answer a design by its height."""
        solved.append(wanted)
        plain = {"height": 1.8e-3 + 1.5e-3 * wanted.x[0], STRAIN: 0.3}
        return Answered(wanted, "", None, np.zeros((1, 0, 0)), plain, {"height": np.array([1.5e-3])}, {STRAIN: 0.1})

    monkeypatch.setattr(Solver, "answered", flat)
    assert run(["design", str(path), "--plan", "--json"]) == 0
    planned = json.loads(capsys.readouterr().out)
    assert planned["designs"] == 3 and 0.0 < planned["seconds"] < 60.0 and planned["not_solved"] == {}
    assert planned["least"]["height"] == pytest.approx(1.82e-3, rel=1e-3) and not solved and not out.exists()
    assert run(["design", str(path), "--plan"]) == 0 and "designs to solve" in capsys.readouterr().out
    assert run(["design", str(path), "--preview"]) == 2 and "--output: must be a folder" in capsys.readouterr().err
    assert run(["design", str(path), "--preview", "--json", "-o", str(out)]) == 0
    seen = json.loads(capsys.readouterr().out)
    assert seen["solves"] == len(solved) == 1 and seen["recommended"] == {"elastomer.thickness": "2.25 mm"}
    assert seen["figures"]["strain"] == pytest.approx({"value": 0.3, "error": 0.1}) and seen["exceeded"] == []
    assert run(["design", str(path), "--preview", "-o", str(out)]) == 0 and len(solved) == 1
    assert "1 solved designs, within the limits" in capsys.readouterr().out


@pytest.mark.slow
def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """From a file to JSON and a folder; height alone is asked, no inductance is solved."""
    path = tmp_path / "flat.toml"
    path.write_text(TEXT)
    assert run(["design", str(path), "-o", str(tmp_path / "flat"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["feasible"] and found["figures"]["height"]["value"] <= 2.6e-3 and found["figures"].keys() >= {"strain"}
    assert (tmp_path / "flat" / "recommended.toml").is_file()
    path.write_text(TEXT.replace("height", "heigth"))
    assert run(["design", str(path), "-o", str(tmp_path / "bad")]) == 2
    assert "require.heigth: the key must be one of" in capsys.readouterr().err
