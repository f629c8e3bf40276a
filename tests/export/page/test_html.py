"""The page of a sensor in a real browser: the numbers of twin.py, forces that are dragged, nothing from a network."""

import json
import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from sits_mech.cli.main import run
from sits_mech.export.formats import export
from sits_mech.export.page.html import sensor_page
from sits_mech.export.source import Source
from sits_mech.export.twin.arrays import readout_arrays
from sits_mech.export.twin.twin import OUTSIDE, UNSOLVED, Twin
from sits_mech.report.folder import read_calibration
from sits_mech.scene.sensor import SceneError, Sensor, changed

Said = pytest.CaptureFixture[str]
FEW = 300  # wrenches


@pytest.fixture(scope="module")
def source(calibrated: Path) -> Source:
    """The small calibration, of two forces and two coils."""
    return Source(*read_calibration(calibrated))


@pytest.fixture(scope="module")
def pair(source: Source, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its page."""
    return export(source, "page", tmp_path_factory.mktemp("pair") / "sensor.html")[0]


@pytest.fixture(scope="module")
def three(triaxial: tuple[Sensor, xr.Dataset], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of three forces and four coils."""
    return export(Source(*triaxial), "page", tmp_path_factory.mktemp("three") / "sensor.html")[0]


def arrays(value: list[dict[str, Any]]) -> dict[str, np.ndarray]:
    """Return what a browser gives of many rows as arrays, null as NaN."""
    return {name: np.array([row[name] for row in value], dtype=float) for name in value[0]}


def compare(browser: Any, twin: Twin, seed: int) -> float:
    """Hold the open page's evaluator against twin.py; return the largest difference over the range."""
    low, high, columns = (twin.numbers[f"wrench_{name}"] for name in ("low", "high", "columns"))
    random, wrench = np.random.default_rng(seed), np.zeros((FEW, 6))
    wrench[:, columns] = random.uniform(low - 0.1 * (high - low), high + 0.1 * (high - low), (FEW, len(columns)))
    wrench[::9, 5] = 1e-3  # which no calibration here varies
    theirs, found = twin.read(wrench), arrays(browser.run(f"{json.dumps(wrench.tolist())}.map(twin.read)"))
    np.testing.assert_allclose(found["L"], theirs.L, rtol=1e-12)
    assert np.array_equal(found["codes"], theirs.codes) and np.array_equal(found["flags"], theirs.flags)
    wrench = np.zeros((FEW, 6))
    wrench[:, columns] = random.uniform(low, high, (FEW, len(columns)))
    wrong = 1.0 + 1e-3 * (np.arange(FEW) % 5 == 0)[:, None] * random.normal(size=(FEW, 1))
    L, codes = twin.read(wrench).L * wrong, np.rint(twin.read(wrench).codes / np.sqrt(wrong))
    off = 0.0
    for name, given, own in (("estimate", L, twin.estimate), ("estimateCodes", codes, twin.estimate_codes)):
        back, found = own(given), arrays(browser.run(f"{json.dumps(given.tolist())}.map(twin.{name})"))
        assert np.array_equal(found["flags"], back.flags) and set(back.flags) >= {0, OUTSIDE + UNSOLVED}
        assert np.array_equal(np.isnan(found["wrench"]), np.isnan(back.wrench))
        off = max(off, np.nanmax(np.abs(found["wrench"] - back.wrench)[:, columns] / (high - low)))
    return float(off)


def test_the_numbers_are_the_twins(browser: Any, pair: Path, source: Source) -> None:
    """Inductances to 1e-12, codes and flags exactly, forces back to 1e-12 of the range; beyond it and ignored too."""
    browser.open(pair)
    assert compare(browser, Twin(readout_arrays(source, "page", [])[0]), 1) < 1e-12
    none = browser.run("[twin.read([NaN, 1, 0, 0, 0, 0]).flags, twin.estimate([NaN, 2e-6]).flags]")
    assert none == [OUTSIDE, UNSOLVED] and browser.complaints() == []


@pytest.mark.slow
def test_more_coils_than_forces_and_a_fold(
    browser: Any, three: Path, triaxial: tuple[Sensor, xr.Dataset], source: Source, tmp_path: Path
) -> None:
    """Least squares of four coils; no answer where another wrench shows the same."""
    browser.open(three)
    assert compare(browser, Twin(readout_arrays(Source(*triaxial), "page", [])[0]), 2) < 1e-12
    numbers, _ = readout_arrays(source, "page", [])
    numbers["valid"][len(numbers["valid"]) // 2 :] = 0
    (tmp_path / "fold.html").write_text(sensor_page(source, numbers, []))
    browser.open(tmp_path / "fold.html")
    assert compare(browser, Twin(numbers), 3) < 1e-12
    assert "No single wrench" in browser.text("state") and browser.text("b-F_x") == "no answer"


def test_dragged_by_pointer_and_keys(browser: Any, pair: Path) -> None:
    """Right shears, down presses, beyond the range is said; codes, drawing, forces back and the address follow."""
    browser.width(1280)
    browser.open(pair)
    before, at_start = browser.text("v-code0"), browser.run('document.getElementById("plate").getAttribute("d")')
    browser.run('document.getElementById("rest").click()')
    browser.drag("stage", 60.0, 30.0)
    assert browser.text("v-code0") != before and float(browser.text("o-F_x").split()[0]) > 0.2
    assert browser.text("b-F_x") == browser.text("o-F_x") and browser.text("b-F_z") == browser.text("o-F_z")
    assert browser.run('document.getElementById("plate").getAttribute("d")') != at_start
    assert browser.text("state") == "Within the calibrated range."
    browser.run('document.getElementById("stage").focus()')
    force = float(browser.text("o-F_z").split()[0])
    browser.press("ArrowDown", 2)
    browser.press("ArrowLeft")
    assert float(browser.text("o-F_z").split()[0]) == pytest.approx(force + 2 * 3.0 / 40.0, abs=2e-3)
    time.sleep(0.3)
    held = browser.text("o-F_x"), browser.text("o-F_z"), browser.text("v-code1")
    assert browser.run("location.hash").startswith("#F_x=0.") and "&F_z=" in browser.run("location.hash")
    browser.run("location.reload()")
    for _ in range(100):
        time.sleep(0.02)
        if browser.run("document.readyState") == "complete" and browser.run("typeof twin") == "object":
            break
    assert (browser.text("o-F_x"), browser.text("o-F_z"), browser.text("v-code1")) == held
    browser.drag("stage", 900.0, 0.0)
    assert "Beyond the calibrated range" in browser.text("state") and browser.text("o-F_x") == "1.500 N"
    assert browser.text("b-F_x") == "1.000 N" and browser.complaints() == []


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("name", ["pair", "three"])
def test_at_the_width_of_a_desk_and_of_a_phone(
    browser: Any, request: pytest.FixtureRequest, name: str, width: int
) -> None:
    """Nothing to scroll sideways, every drawing with a name, every control with a label; noise moves the codes."""
    browser.width(width)
    browser.open(request.getfixturevalue(name))
    assert browser.run("document.documentElement.scrollWidth") <= width
    assert all(browser.every(".read b, output", "n.scrollWidth <= n.clientWidth"))
    assert all(len(name) > 10 for name in browser.every("svg", 'n.getAttribute("aria-label")'))
    assert all(browser.every("input, select", 'n.labels.length && n.labels[0].textContent.trim()'))
    still, near = int(browser.text("v-code0").replace("\u202f", "")), browser.text("off-F_x")
    browser.run("Math.random = () => 1 - Math.exp(-12.5)")  # five standard deviations
    browser.run('document.getElementById("noise").click()')
    noisy, sigma = int(browser.text("v-code0").replace("\u202f", "")), browser.run("twin.numbers.sigma_L[0]")
    assert noisy == pytest.approx(still * (1.0 - 2.5 * sigma), abs=0.51) and noisy != still
    time.sleep(0.3)
    assert browser.text("off-F_x") != near and browser.text("off-F_x").endswith("N off")
    assert browser.every("#strip path", "n.getAttribute('d').length > 20".replace("'", '"')).count(True) >= 2
    assert browser.complaints() == []


@pytest.mark.slow
def test_a_section_along_y_shears_along_y(browser: Any, three: Path) -> None:
    """Where the section is chosen, the drawing's arrows and the plan move F_y."""
    browser.width(1280)
    browser.open(three)
    browser.run('document.getElementById("rest").click()')
    browser.choose("cut", "x")
    browser.run('document.getElementById("stage").focus()')
    browser.press("ArrowRight")
    assert [browser.text(f"o-F_{k}") for k in "xyz"] == ["0.000 N", "0.025 N", "0.000 N"]
    browser.drag("plan", 0.0, -30.0)
    assert float(browser.text("o-F_y").split()[0]) > 0.1 and browser.complaints() == []


@pytest.mark.slow
def test_without_converter_or_inverse(browser: Any, source: Source, tmp_path: Path) -> None:
    """Inductances alone, forces back from them, no noise; of one coil why no forces come back."""
    plain = Source(changed(source.sensor, ['readout.converter="none"']), source.data)
    browser.open(export(plain, "page", tmp_path / "plain.html")[0])
    assert browser.run('document.getElementById("noise").disabled') and browser.every('[id^="v-code"]', "n.id") == []
    assert browser.text("b-F_x") == browser.text("o-F_x") and browser.complaints() == []
    few = source.sensor.model_copy(update={"coils": source.sensor.coils[:1]})
    data = source.data.isel(coil=[0], coil_2=[0])
    data.attrs.pop("scene")
    one = Source(few, data)
    browser.open(export(one, "page", tmp_path / "one.html")[0])
    assert "No forces back: coils: 1 cannot resolve 2 forces" in browser.text("state") and browser.complaints() == []


@pytest.mark.slow
def test_one_force(browser: Any, source: Source, tmp_path: Path) -> None:
    """Of a table of normal forces alone: a drag sideways moves nothing, a shear in the address is ignored and said."""
    browser.open(export(Source(source.sensor, source.data.isel(F_x=[2])), "page", tmp_path / "line.html")[0])
    before = browser.text("v-code0")
    browser.drag("stage", 60.0, 1.0)
    assert browser.text("o-F_x") == "0.000 N" and browser.text("v-code0") != before
    assert browser.every("#curve0 text", "n.textContent").count("F_z [N]") == 1
    browser.run('location.hash = "F_x=0.5&F_z=1&F_y=x"')
    time.sleep(0.1)
    assert "is ignored" in browser.text("state") and browser.text("b-F_z") == "1.000 N"
    assert browser.complaints() == []


def test_one_file_that_is_small(pair: Path, three: Path) -> None:
    """Below 200 kB, with no address of another file or host, and nothing left of a template."""
    for path in (pair, three):
        whole = path.read_text()
        assert len(whole) < 2e5 and "http" not in whole.replace("http://www.w3.org/2000/svg", "")
        assert not re.search(r"\$[a-z{]", whole) and "src=" not in whole and whole.count("<script") == 2


def test_what_cannot_be_written(source: Source, calibrated: Path, tmp_path: Path, capfd: Said) -> None:
    """A failed corner, one load, another ending, more forces than coils, a folder that is not there: one line each."""
    data = source.data.copy(deep=True)
    data["status"] = data["status"].astype(object)
    data["status"].loc[{"F_x": 1.0, "F_z": 3.0}] = "failed"
    for table, said in (
        (data, r"--to page: must be .* a box; 1 of 20 loads failed, among them F_x = 1 N, F_z = 3 N"),
        (source.data.isel(F_x=[2], F_z=[1]), "--to page: must be of a table with at least two values of a force"),
    ):
        with pytest.raises(SceneError, match=said):
            export(Source(source.sensor, table), "page", tmp_path / "t.html")
    for words, message in (
        ([str(calibrated), "-o", "page.csv"], "must end in .html for --to page; got 'page.csv', as for csv"),
        ([str(calibrated), "-o", str(tmp_path / "no" / "p.html")], "--output: must be in a folder that exists"),
        ([str(tmp_path)], "must be the folder of a finished calibration"),
    ):
        assert run(["export", "--to", "page", *words]) == 2
        error = capfd.readouterr().err
        assert message in error and error.count("\n") == 1
