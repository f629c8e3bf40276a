"""The studio in a browser: sliders, previews and solves, wrong input, two tabs, who is let in, what is asked for."""

import os
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from sits_mech.chain.calibrate import calibrate
from sits_mech.scene.sensor import changed, load_sensor
from sits_mech.studio.questions import ends_to, grid_of
from tests.conftest import CHROMIUM, Browser

pytestmark = pytest.mark.skipif(not CHROMIUM, reason="no browser: needs chromium (Debian: apt-get install chromium)")
MODELS = ("--mechanics", "linear", "--magnetics", "planar", "--tolerance", "0.05")
CHIP = '(document.querySelector("[role=status]")?.textContent ?? "")'
IN_FRAME = 'document.querySelector("#sits-frames iframe.shown")?.contentDocument'


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """A studio that runs by models that cost little."""
    words = [sys.executable, "-m", "sits_mech", "studio", "biorob2018-w15", "--no-browser", *MODELS]
    own = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}  # NiceGUI heeds these
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=own | {"SITS_MECH_CACHE": "off"})
    assert process.stdout is not None
    yield process.stdout.readline().strip()
    process.terminate()
    process.wait(20)
    process.stdout.close()


@pytest.fixture(scope="module")
def page(address: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """A tab of it, solved."""
    found = Browser(tmp_path_factory.mktemp("profile"))
    opened(found, address)
    yield found
    found.close()


def opened(browser: Browser, address: str) -> None:
    """Open an address and wait for its first table."""
    for _ in range(40):  # until the server is there
        try:
            browser.ask("Page.navigate", url=address)
            break
        except AssertionError:
            time.sleep(0.25)
    until(browser, f"{CHIP}.startsWith('solved')")


def until(browser: Browser, script: str, seconds: float = 120.0) -> Any:
    """Return an expression of the page as soon as it is true."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = browser.run(script)
        if found:
            return found
        time.sleep(0.05)
    raise AssertionError(f"{script}: {browser.run(f'[document.body, {IN_FRAME}?.body].map(n => n?.innerText)')}")


def slid(browser: Browser, label: str, share: float) -> None:
    """Click on a slider at a share of its length."""
    box = f"document.querySelector('[aria-label=\"{label}\"]').getBoundingClientRect()"
    x, y = browser.run(f"(r => [r.x + {share} * r.width, r.y + r.height / 2])({box})")
    for kind in ("mousePressed", "mouseReleased"):
        browser.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)


@pytest.mark.slow
def test_a_slider_is_previewed_then_solved(page: Browser) -> None:
    """First dashed with what is left open, then the digits of `calibrate`; what was seen is there at once."""
    most = [float(page.run(f'document.querySelector("[aria-label=\\"largest {name} [N]\\"]").value'))
            for name in ("F_x", "F_z")]
    number = "document.querySelector('.sits-number').textContent"
    for share, words in ((0.4, "2.2 mm"), (0.5, "2.5 mm")):  # the first one brings slopes
        slid(page, "pad thickness", share)
        until(page, f"{number} === '{words}'")
        until(page, f"{CHIP} === 'solved'")
    thickness = 2.5e-3
    sensor = changed(load_sensor("biorob2018-w15"), [f"elastomer.thickness={thickness!r}"])
    loads = {name: grid_of(*ends_to(name, value)) for name, value in zip(("F_x", "F_z"), most, strict=True)}
    data = calibrate(sensor, **loads, mechanics="linear", magnetics="planar", tolerance=0.05)
    value = float(data["L_v_percent"][3, 3])
    until(page, f'Math.abs(parseFloat({IN_FRAME}.getElementById("v-L_v_percent").textContent) - {value}) < 1e-3')
    slid(page, "pad thickness", 0.4)
    until(page, f"{number} === '2.2 mm' && {CHIP} === 'solved'", 20.0)


def pressed(browser: Browser, words: str, kind: str = "button") -> None:
    """Press the first button, or open the part, of some words."""
    browser.run(f'[...document.querySelectorAll("{kind}")].find(n => n.innerText.trim().startsWith("{words}")).click()')


@pytest.mark.slow
def test_keys_move_a_slider_and_a_solve_is_stopped(page: Browser) -> None:
    """By the keyboard alone; stopped, nothing is solved until it is asked for: the last move is followed by then."""
    number = "[...document.querySelectorAll('.sits-number')].map(n => n.innerText).join()"
    page.run("document.querySelector('[aria-label=\"target width\"] [tabindex]').focus()")
    page.press("ArrowRight", 8)
    until(page, f"{number}.includes('15.6 mm')")  # 8 of 300 steps from 7.5 mm to 30 mm
    pressed(page, "stop")
    until(page, f"{CHIP}.endsWith(', stopped')")
    time.sleep(1.0)
    assert page.run(CHIP).endswith(", stopped")
    pressed(page, "solve")
    until(page, f"{CHIP} === 'solved'")


@pytest.mark.slow
def test_tab_walks_from_slider_to_slider(page: Browser) -> None:
    """From the scene on in the order of the page; the arrow keys move what has the focus, to the next preview."""
    page.run("document.querySelector('.sits-scene input').focus()")
    named = "document.activeElement.closest('[aria-label]')?.getAttribute('aria-label')"
    seen = []
    for _ in range(5):
        page.press("Tab")
        seen.append(page.run(named))
    assert seen == ["pad thickness", "pad width", "pad length", "gap", "target width"]
    number = "document.querySelectorAll('.sits-number')[4].textContent"
    before = float(page.run(number).split()[0])
    page.press("ArrowRight", 4)
    until(page, f"parseFloat({number}) > {before}")


@pytest.mark.slow
def test_no_move_of_a_slider_is_lost(page: Browser) -> None:
    """Keys that come while the page answers earlier ones all count, and none is taken back."""
    number = "parseFloat(document.querySelectorAll('.sits-number')[4].textContent)"
    slider = "document.querySelector('[aria-label=\"target width\"]')"
    ends = (f"{slider}.getAttribute('aria-value{name}')" for name in ("min", "max", "now"))
    low, high, before = (float(page.run(each)) for each in ends)
    page.run(f"{slider}.querySelector('[tabindex]').focus()")
    for _ in range(3):
        page.press("ArrowRight", 4)
        page.press("ArrowLeft", 6)
    wanted = before - 6.0 * (high - low) / 300.0
    until(page, f"Math.abs({number} - {wanted}) < 6e-3", 20.0)
    time.sleep(0.5)  # answers that are late
    assert float(page.run(f"{slider}.getAttribute('aria-valuenow')")) == pytest.approx(wanted, abs=6e-3)


@pytest.mark.slow
def test_required_and_found(page: Browser) -> None:
    """Limits beside figures and as lines over the curves; a search shows its designs, and opens what it found."""
    pressed(page, "required", ".q-item")
    area = "[...document.querySelectorAll('.sits-text textarea')].at(-1)"
    until(page, f"{area}?.value.includes('[require]')")
    text = (
        '[loads]\\nF_z = ["0 N", "1 N"]\\n[vary]\\n"elastomer.thickness" = ["2 mm", "2.5 mm"]\\n'
        '[require]\\nheight = "2.5 mm"\\n'
    )
    page.run(f"(t => {{t.value = `{text}`; t.dispatchEvent(new Event('input'))}})({area})")
    time.sleep(0.3)
    pressed(page, "find")
    until(page, "document.querySelector('.sits-search').innerText.includes('every limit holds')")
    until(page, f"!!{IN_FRAME}.querySelector('.sits-asked.solved')")
    assert "at most 2.5 mm" in page.run(f"{IN_FRAME}.querySelector('.sits-asked').innerText")
    assert page.run(f"{IN_FRAME}.querySelectorAll('.asked').length") >= 3
    page.run("document.querySelector('.sits-search button').click()")
    until(page, "document.querySelector('.sits-number').textContent === '2 mm'")


@pytest.mark.slow
def test_wrong_input_is_said_and_nothing_lost(page: Browser) -> None:
    """The message of the command line, at the field where it was typed; the last table stays."""
    pressed(page, "all keys", ".q-item")
    until(page, "[...document.querySelectorAll('.sits-part .q-item')].length > 3")
    pressed(page, "target", ".sits-part .q-item")
    field = "document.querySelector('.sits-part input[aria-label=\"thickness\"]')"
    until(page, f"{field}?.offsetHeight > 0")
    page.run(f"(t => {{t.focus(); t.select()}})({field})")
    page.ask("Input.insertText", text="-1")
    page.press("Tab")
    assert "must be a length" in until(page, "document.querySelector('.q-field--error')?.innerText")
    pressed(page, "scene file", ".q-item")
    until(page, "document.querySelector('.sits-text textarea')?.offsetHeight > 0")
    page.run(
        '(t => {t.value = t.value.replace("thickness = 0.0002", "thickness = -1.0");'
        't.dispatchEvent(new Event("input"))})(document.querySelector(".sits-text textarea"))'
    )
    time.sleep(0.3)
    pressed(page, "take over")
    assert "target.thickness: must be a length" in until(page, "document.querySelector('.sits-wrong').textContent")
    assert page.run(f"{IN_FRAME}.getElementById('v-L_v_percent').textContent")


@pytest.mark.slow
def test_phone_and_console(page: Browser) -> None:
    """At 390 and 1280 px nothing is wider than the window; no error in the console, no request elsewhere."""
    for width in (390, 1280):
        page.width(width)
        time.sleep(0.3)
        assert page.run("document.documentElement.scrollWidth <= innerWidth")
        tops = [page.run(f"document.querySelector('.sits-{part}').getBoundingClientRect().top")
                for part in ("sensor", "scene")]
        assert tops[0] < tops[1] if width < 800 else tops[0] == tops[1]  # what comes out first
    elsewhere = [each for each in page.complaints() if not each.startswith(("http://127.0.0.1:", "data:"))]
    assert elsewhere == []


def test_who_is_let_in(address: str) -> None:
    """Nobody without the token, by whatever path; who has it but no tab gets a page on which nothing is made yet."""
    root = address.partition("?")[0]
    for _ in range(200):  # until the server is there
        try:
            urllib.request.urlopen(root, timeout=10)
        except urllib.error.HTTPError:
            break
        except urllib.error.URLError:
            time.sleep(0.1)
    for path in ("", "_nicegui/", "../etc/passwd", "?token=wrong"):
        with pytest.raises(urllib.error.HTTPError, match="403"):
            urllib.request.urlopen(root + path, timeout=10)
    with urllib.request.urlopen(address, timeout=10) as answer:
        assert answer.status == 200 and b"sitsDraw" in (html := answer.read()) and b"pad thickness" not in html


@pytest.mark.slow
def test_another_tab_of_another_scene(page: Browser, address: str, tmp_path: Path) -> None:
    """Each keeps its own; an address restores a state."""
    other = Browser(tmp_path)
    try:
        where = address.replace("scene=biorob2018-w15", "scene=biorob2018&target.width=0.009&F_x=0.3&F_z=1.0")
        opened(other, where)
        assert other.run('document.querySelector("[aria-label=\\"target width\\"]").closest(".sits-scene").innerText') \
            .count("9 mm") == 1
    finally:
        other.close()
    assert page.run("document.querySelector('.sits-scene input').value ?? ''") is not None
    assert page.run(CHIP) == "solved"


@pytest.mark.slow
def test_files_are_handed_out(page: Browser, tmp_path: Path) -> None:
    """Scene, table, report and pictures of what is solved; the scene makes the same sensor."""
    page.ask("Page.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    pressed(page, "out", ".q-item")
    until(page, "document.querySelector('a.sits-command')?.offsetHeight > 0")
    for name in ("scene.toml", "table.csv", "report.html", "picture"):
        pressed(page, name)
    end = time.monotonic() + 30.0
    names = {"scene.toml", "table.csv", "report.html", "drawing.svg"}
    while time.monotonic() < end and {each.name for each in tmp_path.iterdir()} != names:
        time.sleep(0.1)
    assert {each.name for each in tmp_path.iterdir()} == names
    width = page.run("[...document.querySelectorAll('.sits-number')][4].innerText").split()[0]
    assert 1e3 * load_sensor(tmp_path / "scene.toml").target.width == pytest.approx(float(width), rel=1e-3)
    assert b"<svg" in (tmp_path / "drawing.svg").read_bytes() and b"explorer" in (tmp_path / "report.html").read_bytes()
