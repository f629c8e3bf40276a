"""Names in the syntax of the programs that read exports: each reader finds the names, and no more."""

from __future__ import annotations

import csv
import json
import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from pathlib import Path

import pytest
import xarray as xr

from sits_mech.boards.expressions import read_expression
from sits_mech.cli.main import run
from sits_mech.report.folder import read_calibration
from sits_mech.report.written import write_calibration
from sits_mech.scene.sensor import load_sensor, save_sensor, scene_text
from sits_mech.store import save_table

NAMES = {
    "spice, xml": (".end ]]>-->", "+ R1 0 1 {x} '&amp;</script>"), "mathtext, format": ("$\\frac{$", "{0}%s%n ${x} $x"),
}
FIRST = ('<!--<script>") (pad "\\', '=HYPERLINK("a";"b"),-1+1*/ #error /*??/')  # html, c, kicad, sheet
CASES = [pytest.param(FIRST, id="first"), *(pytest.param(v, marks=pytest.mark.slow, id=k) for k, v in NAMES.items())]


@pytest.fixture(scope="module", params=CASES)
def named(request: pytest.FixtureRequest, calibrated: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the small calibration with other names of scene and coils."""
    coils = request.param
    sets = [f"coils.{k}.name={json.dumps(name)}" for k, name in enumerate(coils)]
    sensor = load_sensor(str(calibrated / "scene.toml"), [*sets, f"name={json.dumps(' '.join(coils))}"])
    _, data = read_calibration(calibrated)
    folder = tmp_path_factory.mktemp("named") / "made"
    shutil.copytree(calibrated, folder)
    renamed = data.assign_coords(coil=list(coils), coil_2=list(coils)).assign_attrs(scene=scene_text(sensor))
    save_sensor(sensor, folder / "scene.toml")
    save_table(renamed, folder / "result.nc")
    return folder


@pytest.mark.slow
def test_pictures_of_a_calibration(named: Path, tmp_path: Path) -> None:
    """All are drawn."""
    (tmp_path / "cases").mkdir()
    assert write_calibration(*read_calibration(named), tmp_path) == []


def exported(folder: Path, to: str, path: Path) -> Path:
    """Write an export and return its path."""
    assert run(["export", str(folder), "--to", to, "-o", str(path)]) == 0
    return path


def names_of(folder: Path) -> tuple[str, list[str]]:
    """Return the names of scene and coils."""
    sensor, _ = read_calibration(folder)
    return sensor.name, [coil.name for coil in sensor.coils]


def test_tables(named: Path, tmp_path: Path) -> None:
    """Columns of CSV, coordinates of netCDF, texts of a workbook: a name stays a text, and no cell is a formula."""
    openpyxl = pytest.importorskip("openpyxl")
    _, coils = names_of(named)
    with exported(named, "csv", tmp_path / "a.csv").open(newline="") as stream:
        heading, *rows = csv.reader(stream)
    assert {f"L[{a}][{b}] [H/m]" for a in coils for b in coils} <= set(heading)
    assert all(len(row) == len(heading) for row in rows) and not any(cell[0] in "=+@" for cell in heading)
    with xr.open_dataset(exported(named, "netcdf", tmp_path / "a.nc"), engine="netcdf4") as data:
        assert data["coil"].to_numpy().tolist() == coils
    book = openpyxl.load_workbook(exported(named, "xlsx", tmp_path / "a.xlsx"))
    assert not any(cell.data_type == "f" for sheet in book for row in sheet for cell in row)
    assert [cell.value for cell in book["loads"][1]] == [re.sub(r" \[[^\]]*\]$", "", name) for name in heading]


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_headers_compile(named: Path, tmp_path: Path) -> None:
    """The firmware's header and the twin's, as strictly as there is."""
    exported(named, "twin", tmp_path / "twin")
    header = exported(named, "c", tmp_path / "sensor.h")
    for std in ("c99", "c11"):  # c99 has trigraphs
        strict = ["cc", f"-std={std}", "-Wall", "-Wextra", "-Wcomment", "-Wno-unused", "-Werror", "-c", "-x", "c"]
        for path in (header, tmp_path / "twin" / "twin.h"):
            words = [*strict, str(path), "-o", str(tmp_path / "o")]
            done = subprocess.run(words, capture_output=True, text=True, timeout=60)
            assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_netlist(named: Path, tmp_path: Path) -> None:
    """Names stand in comments alone; one subcircuit begins and ends."""
    lines = exported(named, "spice", tmp_path / "a.cir").read_text(encoding="utf-8").splitlines()
    bare = [line for line in lines if not line.startswith("*")]
    assert all(line[0] in ".VRLKH" for line in bare)
    assert [line.split()[0] for line in bare if line[0] == "."] == [".subckt", ".ends"]


def test_footprint(named: Path, tmp_path: Path) -> None:
    """A file with the name of a coil, on a board: one footprint, whose own name is a text."""
    name = names_of(named)[1][0].replace("/", "_")
    kept = read_expression(exported(named, "kicad", tmp_path / f"{name}.kicad_mod"))
    assert kept[0] == "footprint" and [each[0] for each in kept[2:5]] == ["version", "generator", "layer"]


@pytest.mark.slow
def test_pictures_and_models(named: Path, tmp_path: Path) -> None:
    """Drawings are XML, and say the names; so is the pad for MuJoCo."""
    exported(named, "svg", tmp_path / "drawn")
    pad = exported(named, "twin", tmp_path / "twin") / "pad.xml"
    for path in [*(tmp_path / "drawn").glob("*.svg"), pad]:
        assert ET.parse(path).getroot() is not None
    assert ET.parse(pad).getroot().attrib["model"] == names_of(named)[0]


class Page(HTMLParser):
    """The scripts of a page, its title, and its tags."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.inside, self.scripts, self.tags, self.title = "", [""], list[str](), ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.inside = tag
        self.tags.append(tag)
        self.scripts.append("")

    def handle_data(self, data: str) -> None:
        if self.inside == "script":
            self.scripts[-1] += data
        if self.inside == "title":
            self.title += data

    def handle_endtag(self, tag: str) -> None:
        self.inside = ""


def test_report(named: Path, calibrated: Path, tmp_path: Path) -> None:
    """The page has the tags that it has with plain names; its JSON holds the names, and nothing for HTML."""
    pages = []
    for folder in (named, calibrated):
        assert run(["report", str(folder), "-o", str(tmp_path / "report.html")]) == 0
        pages.append((tmp_path / "report.html").read_text(encoding="utf-8"))
    page, plain = map(Page, pages)
    assert page.tags == plain.tags
    assert page.title.startswith(names_of(named)[0])
    (table,) = [text for text in page.scripts if text.startswith("{")]
    assert "<" not in table
    assert all(json.dumps(name)[1:-1] in json.dumps(json.loads(table)) for name in names_of(named)[1])
