"""The report: one file that needs nothing else; in a real browser its explorer shows the table's own numbers."""

import json
import os
import re
import shutil
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.bench import absolute, table_impedance
from sits_mech.analysis.codes import readings
from sits_mech.cli.main import run
from sits_mech.report.folder import read_calibration
from sits_mech.report.page.html import page
from sits_mech.report.page.parts import inverse_part, words_part
from sits_mech.scene.sensor import changed

NAMES = ("chromium", "chromium-browser", "google-chrome")
CHROMIUM = next((path for name in NAMES if (path := shutil.which(name))), "")
needs_browser = pytest.mark.skipif(not CHROMIUM, reason="no browser: needs chromium (Debian: apt-get install chromium)")


class Browser:
    """A headless Chromium, spoken to over its debugging pipe."""

    def __init__(self, profile: Path) -> None:
        their_in, self.out = os.pipe()
        self.inp, their_out = os.pipe()
        flags = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"]
        words = [CHROMIUM, *flags, f"--user-data-dir={profile}", "--remote-debugging-pipe", "--window-size=1280,1400"]
        wires = f'exec "$@" 3<&{their_in} 4>&{their_out} >/dev/null 2>&1'
        self.process = subprocess.Popen(["bash", "-c", wires, "bash", *words], pass_fds=(their_in, their_out))
        os.close(their_in)
        os.close(their_out)
        self.number, self.rest, self.session = 0, b"", {}
        self.events: list[dict[str, Any]] = []
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self.session = {"sessionId": self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]}
        for part in ("Page", "Runtime", "Log", "Network"):
            self.ask(f"{part}.enable")

    def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """Send a command and return its result; what comes in between is kept as events."""
        self.number += 1
        text = json.dumps({"id": self.number, "method": method, "params": params} | self.session)
        os.write(self.out, text.encode() + b"\0")
        while True:
            found = self.message()
            if found.get("id") == self.number:
                assert "error" not in found, found
                return found["result"]
            self.events.append(found)

    def message(self) -> dict[str, Any]:
        """Return the next message."""
        while b"\0" not in self.rest:
            more = os.read(self.inp, 1 << 20)
            assert more, "the browser has gone"
            self.rest += more
        first, self.rest = self.rest.split(b"\0", 1)
        return json.loads(first)

    def open(self, path: Path) -> None:
        """Open a file and wait until it is loaded."""
        self.ask("Page.navigate", url=path.as_uri())
        for _ in range(200):
            if self.run("document.readyState") == "complete" and self.run("location.protocol") == "file:":
                return
            time.sleep(0.05)
        raise AssertionError("the page does not load")

    def run(self, script: str) -> Any:
        """Return the value of an expression in the page."""
        found = self.ask("Runtime.evaluate", expression=script, returnByValue=True)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def press(self, key: str, times: int = 1) -> None:
        """Press a key."""
        code = {"ArrowRight": 39, "ArrowLeft": 37, "Home": 36, "End": 35}[key]
        for _ in range(times):
            for kind in ("keyDown", "keyUp"):
                self.ask("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code)

    def complaints(self) -> list[str]:
        """Return errors and warnings of the console, and what was asked of a network."""
        self.run("1")
        kinds = ("Runtime.exceptionThrown", "Log.entryAdded", "Runtime.consoleAPICalled")
        found = [json.dumps(event) for event in self.events if event.get("method") in kinds]
        for event in self.events:
            if event.get("method") == "Network.requestWillBeSent":
                url = event["params"]["request"]["url"]
                found += [] if url.startswith(("file:", "data:")) else [url]
        return found

    def close(self) -> None:
        """End the browser."""
        os.close(self.out)
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait(20)
        os.close(self.inp)


@pytest.fixture(scope="module")
def made(calibrated: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report as the command makes it."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    assert run(["report", str(calibrated), "-o", str(path)]) == 0
    return path


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """One browser for all tests."""
    found = Browser(tmp_path_factory.mktemp("profile"))
    yield found
    found.close()


def table(calibrated: Path) -> tuple[xr.Dataset, np.ndarray]:
    """Return the calibration's table and its inductances in henry, shape (F_x, F_z, n)."""
    sensor, data = read_calibration(calibrated)
    found, _ = absolute(sensor, table_impedance(data))
    return data, np.diagonal(found.L, axis1=-2, axis2=-1)


def text(browser: Browser, name: str) -> str:
    """Return what stands in an element of the page."""
    return str(browser.run(f'document.getElementById("{name}").textContent'))


def shown(browser: Browser, name: str) -> float:
    """Return a number that the page shows."""
    return float(text(browser, f"v-{name}").split()[0].replace("\u2212", "-"))


@needs_browser
def test_a_moved_slider_shows_the_table(browser: Browser, made: Path, calibrated: Path) -> None:
    """By keys on the sliders, to loads of the table: inductances, signals, pose are the table's to the digits shown."""
    data, L = table(calibrated)
    browser.open(made)
    codes = readings(*read_calibration(calibrated)).codes
    before = shown(browser, "L0")
    for fx, fz in ((0, 0), (4, 3), (2, 1), (3, 0)):
        for slider, number in (("fx", fx), ("fz", fz)):
            browser.run(f'document.getElementById("{slider}").focus()')
            browser.press("Home")
            browser.press("ArrowRight", 40 * number)
        assert text(browser, "fx-out") == f"{float(data.F_x[fx]):.3f} N".replace("-", "\u2212")
        for k in range(2):
            assert shown(browser, f"L{k}") == pytest.approx(1e6 * L[fx, fz, k], abs=0.5001e-5)
            assert shown(browser, f"code{k}") == pytest.approx(codes[fx, fz, k], abs=0.5001)
        row = data.isel(F_x=fx, F_z=fz)
        assert shown(browser, "L_v_percent") == pytest.approx(float(row["L_v_percent"]), abs=0.5001e-3)
        assert shown(browser, "d_v") == pytest.approx(1e6 * float(row["d_v"]), abs=0.05001)
        assert shown(browser, "alpha") == pytest.approx(1e3 * float(row["alpha"]), abs=0.5001e-3)
        assert "A load of the table" in text(browser, "state")
    assert shown(browser, "L0") != before
    assert browser.complaints() == []


@needs_browser
def test_between_loads_a_cubic_goes_through_four(browser: Browser, made: Path, calibrated: Path) -> None:
    """The page's own function against numpy's polynomial through the four nearest loads; in the plane by a click."""
    data, _ = table(calibrated)
    browser.open(made)
    F_x, F_z = data["F_x"].to_numpy(), data["F_z"].to_numpy()
    values = data["L_v_percent"].to_numpy()
    along = [np.polynomial.Polynomial.fit(F_z, values[i], 3)(1.7) for i in range(5)]
    expected = np.polynomial.Polynomial.fit(F_x[:4], along[:4], 3)(-0.21)
    assert browser.run('sensorAt("L_v_percent", -0.21, 1.7)') == pytest.approx(expected, rel=1e-12)
    place = 'document.getElementById("plate").getAttribute("points")'
    at_start = browser.run(place)
    box = 'document.getElementById("pad").getBoundingClientRect()'
    x, y = browser.run(f"(r => [r.x + 0.2 * r.width, r.y + 0.5 * r.height])({box})")
    for kind in ("mousePressed", "mouseReleased"):
        browser.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1, buttons=1)
    assert float(browser.run('document.getElementById("fx").value')) < -0.5
    assert browser.run(place) != at_start and "interpolated" in text(browser, "state")
    assert browser.complaints() == []


@needs_browser
def test_a_load_without_result_says_so(browser: Browser, calibrated: Path, tmp_path: Path) -> None:
    """The explorer shows a dash and the reason; its neighbours fall back to the loads that are there."""
    sensor, data = read_calibration(calibrated)
    broken = data.copy(deep=True)
    broken["status"], broken["reason"] = (broken[name].astype(object) for name in ("status", "reason"))
    here = {"F_x": 1.0, "F_z": 3.0}
    broken["status"].loc[here], broken["reason"].loc[here] = "load path ended", "the layer </script> folds"
    for name in broken.data_vars:
        if broken[name].dtype == float and "F_x" in broken[name].dims:
            broken[name].loc[here] = np.nan
    (tmp_path / "broken.html").write_text(page(sensor, broken, calibrated))
    browser.open(tmp_path / "broken.html")
    for slider in ("fx", "fz"):
        browser.run(f'document.getElementById("{slider}").focus()')
        browser.press("End")
    assert text(browser, "v-L0") == "–" and "the layer </script> folds" in text(browser, "state")
    browser.press("Home")
    expected = float(data["L_v_percent"].sel(F_x=1.0, F_z=0.0))
    assert shown(browser, "L_v_percent") == pytest.approx(expected, abs=0.5001e-3)
    assert browser.run('document.querySelectorAll("tr.bad").length') == 1
    assert browser.complaints() == []


@needs_browser
def test_one_shear_force_leaves_one_slider(browser: Browser, calibrated: Path, tmp_path: Path) -> None:
    """A table of normal forces alone: no plane of both forces, no curve over shear, no complaint; F_z still moves."""
    sensor, data = read_calibration(calibrated)
    line = data.isel(F_x=[2])
    (tmp_path / "line.html").write_text(page(sensor, line, tmp_path))
    browser.open(tmp_path / "line.html")
    there = {name: f'document.getElementById("{name}") !== null' for name in ("pad", "chart-h", "chart-v")}
    gone = [name for name, script in there.items() if not browser.run(script)]
    assert gone == ["pad", "chart-h"] and browser.run('document.getElementById("fx").disabled') is True
    browser.run('document.getElementById("fz").focus()')
    browser.press("End")
    assert shown(browser, "d_v") == pytest.approx(1e6 * float(line["d_v"][0, -1]), abs=0.05001)
    assert browser.complaints() == []


def test_forces_back(calibrated: Path) -> None:
    """Error of the map, share with an answer, noise in newtons; a sentence where forces are not resolved."""
    sensor, data = read_calibration(calibrated)
    text = inverse_part(sensor, data, readings(sensor, data))
    for word in ("F_x and F_z", "100 % of the calibrated range", "sigma of noise", "mN", "linear sums of all"):
        assert word in text
    few = data.isel(F_x=[0, 1], F_z=[0])
    assert "must" in inverse_part(sensor, few, readings(sensor, few))


def test_one_file_of_a_size_to_send(made: Path) -> None:
    """Below 5 MB, with its pictures; no address of another file."""
    whole = made.read_text()
    assert made.stat().st_size < 5e6 and whole.count("data:image/png;base64,") == 4
    for tag in re.findall(r"<(?:script|link|img|iframe)[^>]*>", whole):
        for address in re.findall(r'(?:src|href)="([^"]*)"', tag):
            assert address.startswith("data:")
    assert "http" not in re.sub(r"http://www\.w3\.org/2000/svg", "", whole) and "$" not in whole


def test_every_load_and_figure_has_its_error(made: Path, calibrated: Path) -> None:
    """Twenty loads with five errors each; figures, settings and scene are there."""
    whole = made.read_text()
    loads = whole[whole.index('<section id="loads">') : whole.index('<section id="scene">')]
    assert loads.count("±") == 5 * 20 and loads.count("<tr>") == 21
    for word in ("crosstalk of F_x into L_v", "RCOUNT0", "ecoflex-00-30", "relative error of a pose", "All 20 loads"):
        assert word in whole


def test_warnings_are_in_plain_words(calibrated: Path) -> None:
    """A capacitance that the converter cannot follow, strong crosstalk, a target shorter than its pad."""
    sensor, data = read_calibration(calibrated)
    slow = changed(sensor, ["readout.parallel_capacitance=1e-9", "readout.lead_resistance=10"])
    words = words_part(slow, data, readings(slow, data))
    for word in ("too lossy", "read both forces from both signals", "per metre of depth", "8 mm long"):
        assert word in words
    assert "too lossy" not in words_part(sensor, data, readings(sensor, data))


def test_other_loads_have_no_explorer(three_forces: Path, tmp_path: Path) -> None:
    """What is not shown is named; every load and figure is there."""
    text = page(*read_calibration(three_forces), three_forces)
    assert "Not shown: the explorer, the converter" in text and "<script" not in text
    assert 'id="explorer"' not in text and "under M = 0.001 N m" in text and "dL_v/dF_y" in text
    assert text.count('class="n"') > 60 and "$" not in text.partition("</style>")[2]


def test_without_converter_or_pictures(calibrated: Path, tmp_path: Path) -> None:
    """The page still stands, without codes."""
    sensor, data = read_calibration(calibrated)
    whole = page(changed(sensor, ['readout.converter="none"']), data, tmp_path)
    assert "The scene has no converter." in whole and "The folder has no pictures" in whole and "code of" not in whole


def test_coils_that_no_converter_follows(calibrated: Path, tmp_path: Path) -> None:
    """Tracks whose losses cannot be told at the frequency: the page stands and says why it has no codes."""
    sensor, data = read_calibration(calibrated)
    reason = "tracks: none of the kind"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sits_mech.analysis.bench.at_terminals", lambda *_: (None, (reason,)))
        whole = page(sensor, data, tmp_path)
    assert reason in whole and "code of" not in whole


def test_what_cannot_be_reported(calibrated: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No calibration, another ending, a folder that is not there: one line each."""
    for words, message in (
        ([str(tmp_path)], "must be the folder of a finished calibration"),
        ([str(calibrated), "-o", "report.pdf"], "--output: must end in .html; got 'report.pdf'"),
        ([str(calibrated), "-o", str(tmp_path / "no" / "r.html")], "must be writable; got: No such file"),
    ):
        assert run(["report", *words]) == 2
        error = capsys.readouterr().err
        assert message in error and error.count("\n") == 1
