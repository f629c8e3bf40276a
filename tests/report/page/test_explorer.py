"""The explorer in a real browser: the table's own numbers at its loads, polynomials between them, drawings that follow.

At the width of a desk and of a phone: nothing cut off, every chart with a name, no complaint, nothing from a network.
"""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.readings.bench import absolute, readings, table_impedance
from sits_mech.report.folder import read_calibration
from sits_mech.report.page import explorer
from sits_mech.report.page.html import page
from sits_mech.scene.sensor import Sensor, load_sensor
from sits_mech.status import OK

Case = tuple[Sensor, xr.Dataset]


@pytest.fixture(scope="module")
def pair(calibrated: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of two forces and two coils."""
    path = tmp_path_factory.mktemp("pair") / "report.html"
    path.write_text(page(*read_calibration(calibrated), calibrated))
    return path


@pytest.fixture(scope="module")
def three(triaxial: Case, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of three forces and four coils."""
    path = tmp_path_factory.mktemp("three") / "report.html"
    path.write_text(page(*triaxial, path.parent))
    return path


def test_straight_tracks_are_drawn_as_lines() -> None:
    """Turns of a square, closed, in millimetres; a round coil has radii."""
    (square,), (round_, _) = (explorer.parts_of(load_sensor(name))["coils"] for name in ("square-4", "biorob2018"))
    assert len(square["lines"]) == 4 * 8 and square["radii"] == [] == round_["lines"] and len(round_["radii"]) == 12
    assert square["lines"][0][0] == square["lines"][0][-1] and square["reach"] == pytest.approx(3.25 * 2**0.5)


def test_a_cover_has_its_outline_and_what_is_over_the_target() -> None:
    cover = 'cover={material="dragon-skin-30", thickness="1 mm", overhang="1.5 mm"}'
    found = explorer.parts_of(load_sensor("biorob2018", [cover]))["cover"]
    assert found == {"loops": [[[-5.5, -5.5], [5.5, -5.5], [5.5, 5.5], [-5.5, 5.5]]], "thickness": 1.0}
    assert explorer.parts_of(load_sensor("biorob2018"))["cover"] is None


def test_fixed_plates_keep_their_holes() -> None:
    """Rim and hole in the scene's places, in millimetres."""
    hole = "holes=[[[2e-3, -1e-3], [4e-3, -1e-3], [3e-3, 0]]]"
    points = "points=[[-9e-3, -9e-3], [9e-3, -9e-3], [9e-3, 9e-3]]"
    ground = f'name="GND", material="copper", shape="outline", centre=[1e-3, 0, -2e-3], thickness=35e-6, {points}, '
    (part,) = explorer.parts_of(load_sensor("biorob2018", [f"conductors=[{{{ground}{hole}}}]"]))["fixed"]
    assert part["loops"] == [[[-8.0, -9.0], [10.0, -9.0], [10.0, 9.0]], [[3.0, -1.0], [5.0, -1.0], [4.0, 0.0]]]


def table_of(whole: str) -> dict[str, Any]:
    """Return the table within a page."""
    return json.loads(whole.partition('id="table">')[2].partition("</script>")[0])


def fitted(nodes: np.ndarray, values: np.ndarray, x: float) -> float:
    """Return the cubic through the four values nearest to the right of the first, or all of fewer."""
    return float(np.polynomial.Polynomial.fit(nodes[:4], values[:4], min(3, len(nodes) - 1))(x))


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 1000, 390])
@pytest.mark.parametrize("name", ["pair", "three"])
def test_nothing_cut_off(browser: Any, request: pytest.FixtureRequest, name: str, width: int) -> None:
    """The page is as wide as the window, every chart has a name, every control a label; no complaint."""
    browser.width(width)
    browser.open(request.getfixturevalue(name))
    size = browser.run("[document.documentElement.scrollWidth, document.documentElement.clientWidth]")
    assert size[0] <= size[1] <= width
    right = "n.closest('svg') && n.tagName !== 'svg' ? 0 : n.getBoundingClientRect().right".replace("'", '"')
    assert max(browser.every(".explorer *, .charts *, .tile", right)) <= width
    assert all(browser.every(".read b, .tile b, output", "n.scrollWidth <= n.clientWidth"))
    names = browser.every("svg", 'n.getAttribute("role") === "img" && n.getAttribute("aria-label")')
    names += browser.every("img", "n.alt")
    assert len(names) >= 5 and all(name and len(name) > 10 for name in names)
    labels = browser.every("input, select", 'n.labels.length ? n.labels[0].textContent.trim() : ""')
    assert all(len(label) >= 2 for label in labels)
    assert browser.complaints() == []


def test_a_moved_slider_shows_the_table(browser: Any, pair: Path, calibrated: Path) -> None:
    """By keys on the sliders, to loads of the table: inductances, signals, pose are the table's to the digits shown."""
    sensor, data = read_calibration(calibrated)
    L = np.diagonal(absolute(sensor, table_impedance(data))[0].L, axis1=-2, axis2=-1)
    codes = readings(sensor, data).codes
    browser.open(pair)
    before = browser.shown("L0")
    for fx, fz in ((0, 0), (1, 3), (2, 1)):
        for name, number in (("F_x", fx), ("F_z", fz)):
            browser.run(f'document.getElementById("s-{name}").focus()')
            browser.press("Home")
            browser.press("ArrowRight", 40 * number)
        assert browser.text("o-F_x") == f"{float(data.F_x[fx]):.3f} N".replace("-", "\u2212")
        for k in range(2):
            assert browser.shown(f"L{k}") == pytest.approx(1e6 * L[fx, fz, k], abs=0.5001e-5)
            assert browser.shown(f"code{k}") == pytest.approx(codes[fx, fz, k], abs=0.5001)
        row = data.isel(F_x=fx, F_z=fz)
        assert browser.shown("L_v_percent") == pytest.approx(float(row["L_v_percent"]), abs=0.5001e-3)
        assert browser.shown("d_v") == pytest.approx(1e6 * float(row["d_v"]), abs=0.05001)
        assert browser.shown("alpha") == pytest.approx(1e3 * float(row["alpha"]), abs=0.5001e-3)
        assert "A load of the table" in browser.text("state")
    assert browser.shown("L0") != before
    assert browser.complaints() == []


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 390])
def test_each_of_three_sliders_shows_the_table(browser: Any, three: Path, triaxial: Case, width: int) -> None:
    """Four inductances and codes, three signals, six components of the pose, at loads of the table."""
    sensor, data = triaxial
    codes = readings(sensor, data).codes
    browser.width(width)
    browser.open(three)
    scales = {"dL_v": (1, 3), "dL_x": (1, 3), "dL_y": (1, 3), "d_h": (1e6, 1), "d_y": (1e6, 1), "d_v": (1e6, 1)}
    scales |= dict.fromkeys(("alpha", "alpha_x", "alpha_z"), (1e3, 3))
    for place in ((0, 0, 0), (4, 3, 2), (1, 2, 0)):
        row = data[dict(zip(("F_x", "F_z", "F_y"), place, strict=True))]
        browser.slide(F_x=row.F_x, F_z=row.F_z, F_y=row.F_y)
        for k in range(4):
            assert browser.shown(f"L{k}") == pytest.approx(1e6 * float(data["L"][*place, k, k]), abs=0.5001e-5)
            assert browser.shown(f"code{k}") == pytest.approx(codes[*place, k], abs=0.5001)
        for name, (scale, digits) in scales.items():
            value = scale * float(data[name][*place])
            assert browser.shown(name) == pytest.approx(value, abs=0.501 * 10.0**-digits), name
        assert "A load of the table" in browser.text("state")
    assert browser.complaints() == []


@pytest.mark.slow
def test_between_loads_a_cubic_goes_through_four(browser: Any, pair: Path, three: Path, calibrated: Path) -> None:
    """The page's own function against numpy's polynomials through the nearest loads, of two and of three forces."""
    data = read_calibration(calibrated)[1]
    values, F_x, F_z = data["L_v_percent"].to_numpy(), data["F_x"].to_numpy(), data["F_z"].to_numpy()
    browser.open(pair)
    expected = fitted(F_x, np.array([fitted(F_z, row, 1.7) for row in values]), -0.21)
    assert browser.run('sensorAt("L_v_percent", -0.21, 1.7)') == pytest.approx(expected, rel=1e-8)
    browser.open(three)
    found = browser.run('[sensorAt("d_h", -0.3, 0.7, 0.1), sensorAt("alpha_z", -0.3, 0.7, 0.1)]')
    assert found == pytest.approx([-0.3 * 8e-4, 1e-2 * -0.3 * 0.1], rel=1e-8)


@pytest.mark.slow
def test_the_map(browser: Any, three: Path, triaxial: Case) -> None:
    """Of any readout over any two forces: its scale ends at the table's numbers, a click moves the sliders."""
    data = triaxial[1]
    browser.width(1280)
    browser.open(three)
    browser.choose("map-item", "alpha_z")
    browser.choose("map-y", "F_y")
    label = browser.run('document.getElementById("map").getAttribute("aria-label")')
    most = 1e3 * float(data["alpha_z"].max())
    assert label == f"Map of turn alpha_z over F_x and F_y, from \u2212{most:.3f} to {most:.3f} mrad"
    browser.choose("map-x", "F_y")  # both alike: the other one gives way
    assert browser.run('document.getElementById("map-y").value') != "F_y"
    at_start = browser.run('document.getElementById("plate").getAttribute("d")')
    browser.click("map", 0.25, 0.6)
    values = browser.run('["F_x", "F_y"].map(name => Number(document.getElementById("s-" + name).value))')
    assert values[1] < -0.2 and "interpolated" in browser.text("state")
    assert browser.run('document.getElementById("plate").getAttribute("d")') != at_start
    assert browser.complaints() == []


def corners(path: str) -> np.ndarray:
    """Return the first points of a path."""
    return np.array(re.findall(r"[ML](-?[\d.e-]+) (-?[\d.e-]+)", path), dtype=float)


@pytest.mark.slow
def test_the_target_moves_and_turns(browser: Any, three: Path, triaxial: Case) -> None:
    """From above to scale: shifted by d_h, d_y and turned by alpha_z; in section along the shear tilted."""
    row = triaxial[1].isel(F_x=4, F_z=3, F_y=2)
    browser.open(three)
    browser.choose("grow", "1")
    browser.slide(F_x=0.5, F_z=2.0, F_y=0.5)
    rim = corners(browser.run('document.getElementById("plate-plan").getAttribute("d")'))
    middle = rim.mean(axis=0) * [1, -1]
    np.testing.assert_allclose(middle, 1e3 * np.array([row["d_h"], row["d_y"]]), atol=1e-3)
    first = rim[0] * [1, -1] - middle  # it was at (6, 0) mm
    assert np.arctan2(first[1], first[0]) == pytest.approx(float(row["alpha_z"]), abs=1e-4)
    left, right = corners(browser.run('document.getElementById("plate").getAttribute("d")'))[:2]
    slope = (float(row["alpha_x"]) - float(row["alpha"])) / np.sqrt(2.0)  # rises along the diagonal
    assert -(right - left)[1] / (right - left)[0] == pytest.approx(slope, rel=1e-2)
    x, y = browser.every("#plan line", '["x1", "y1"].map(k => Number(n.getAttribute(k)))')[0]
    assert y == pytest.approx(-x)  # the section runs along the diagonal, y upwards
    tracks = '#stage path[fill="#c0392b"]', 'Boolean(n.getAttribute("d"))'
    assert browser.every(*tracks) == [True, False, True, False]  # C1 and C3 are cut
    browser.choose("cut", "y")
    assert not any(browser.every(*tracks))
    assert browser.complaints() == []


@pytest.mark.slow
def test_by_keyboard_alone(browser: Any, three: Path) -> None:
    """Tab reaches each slider, list and button of the explorer, and shows where it is."""
    browser.open(three)
    browser.run('document.getElementById("s-F_x").focus()')
    reached = []
    for _ in range(9):
        reached.append(browser.run("document.activeElement.id"))
        assert browser.run("getComputedStyle(document.activeElement).outlineStyle") == "solid"
        browser.press("Tab")
    assert reached == ["s-F_x", "s-F_z", "s-F_y", "grow", "cut", "snap", "rest", "map-item", "map-x"]


@pytest.mark.slow
def test_a_load_without_result_says_so(browser: Any, calibrated: Path, tmp_path: Path) -> None:
    """The explorer shows a dash and the reason; its neighbours fall back to the loads that are there.

    Its row alone is marked: the others are within the tolerance, as those of plane strain would not be.
    """
    sensor, data = read_calibration(calibrated)
    broken = data.copy(deep=True)
    for name in ("status", "flags", "reason"):
        broken[name] = broken[name].astype(object)
    broken["status"][:] = broken["flags"][:] = OK
    here = {"F_x": 1.0, "F_z": 3.0}
    broken["status"].loc[here] = broken["flags"].loc[here] = "not carried"
    broken["reason"].loc[here] = "the layer </script> folds"
    for name in broken.data_vars:
        if broken[name].dtype == float and "F_x" in broken[name].dims:
            broken[name].loc[here] = np.nan
    (tmp_path / "broken.html").write_text(page(sensor, broken, calibrated))
    browser.open(tmp_path / "broken.html")
    for name in ("F_x", "F_z"):
        browser.run(f'document.getElementById("s-{name}").focus()')
        browser.press("End")
    assert browser.text("v-L0") == "–" and "the layer </script> folds" in browser.text("state")
    browser.press("Home")
    expected = float(data["L_v_percent"].sel(F_x=1.0, F_z=0.0))
    assert browser.shown("L_v_percent") == pytest.approx(expected, abs=0.5001e-3)
    assert browser.run('document.querySelectorAll("tr.bad").length') == 1
    assert browser.complaints() == []


@pytest.mark.slow
def test_one_shear_force_leaves_one_slider(browser: Any, calibrated: Path, tmp_path: Path) -> None:
    """A table of normal forces alone: no map, no curve over shear, no complaint; F_z still moves."""
    sensor, data = read_calibration(calibrated)
    line = data.isel(F_x=[2])
    (tmp_path / "line.html").write_text(page(sensor, line, tmp_path))
    browser.open(tmp_path / "line.html")
    there = {name: f'document.getElementById("{name}") !== null' for name in ("map", "chart0", "chart1")}
    assert [name for name, script in there.items() if not browser.run(script)] == ["map", "chart1"]
    assert browser.run('document.getElementById("s-F_x").disabled') is True
    browser.run('document.getElementById("s-F_z").focus()')
    browser.press("End")
    assert browser.shown("d_v") == pytest.approx(1e6 * float(line["d_v"][0, -1]), abs=0.05001)
    assert browser.complaints() == []


@pytest.mark.slow
def test_a_single_load(browser: Any, triaxial: Case, tmp_path: Path) -> None:
    """Sliders that stand still, no curve and no map; forces and moments that are the same throughout are drawn."""
    sensor, data = triaxial
    one = data.isel(F_x=[4], F_z=[3], F_y=2)
    (tmp_path / "one.html").write_text(page(sensor, one, tmp_path))
    browser.open(tmp_path / "one.html")
    assert browser.every("input", "n.disabled") == [True, True] and browser.every(".charts svg, #map", "n.id") == []
    assert browser.shown("d_y") == pytest.approx(1e6 * float(one["d_y"].item()), abs=0.0501)
    assert browser.every("#cut-box", "n.hidden") == [False] and browser.complaints() == []


def test_a_large_table_has_six_digits(triaxial: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Beyond the most numbers of a page: no errors, six digits, and a word that says so; below it eleven."""
    small = page(*triaxial, tmp_path)
    monkeypatch.setattr(explorer, "_MOST", 100)
    large = page(*triaxial, tmp_path)
    exact = triaxial[1]["dL_v"].to_numpy().ravel()
    for whole, digits in ((small, 11), (large, 6)):
        values = table_of(whole)["values"]
        np.testing.assert_allclose(values["dL_v"], exact, rtol=0.51 * 10.0 ** (1 - digits))
        assert ("error_dL_v" in values) == (digits == 11)
        assert ("six digits and without errors" in whole) == (digits == 6)
