"""What all tests share: one BLAS thread, no display, the same hypothesis profile in every run, a browser for pages."""

import gc
import json
import os
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("PYVISTA_OFF_SCREEN", "true")

NAMES = ("chromium", "chromium-browser", "google-chrome")
CHROMIUM = next((path for name in NAMES if (path := shutil.which(name))), "")


def pytest_configure(config: pytest.Config) -> None:
    """Keep what takes seconds to prepare in a folder of this run, for all its processes and the commands they start.

    A process that dies ends the run.
    """
    if "PYTEST_XDIST_WORKER" not in os.environ:
        os.environ["SITS_MECH_CACHE"] = folder = tempfile.mkdtemp(prefix="sits-mech-")
        config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))
        if getattr(config.option, "maxworkerrestart", "none") is None:  # xdist waits for ever for what one had left
            config.option.maxworkerrestart = "0"


@cache
def _same_in_every_run() -> None:
    """Load the profile; hypothesis takes seconds to come."""
    from hypothesis import settings

    settings.register_profile("same", derandomize=True, deadline=None, database=None)
    settings.load_profile("same")


def pytest_runtest_setup() -> None:
    """Ignore broken pipes, as Python does, also after a test that drew a mesh by gmsh itself."""
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)


def pytest_collectstart() -> None:
    """Load it before any test is imported, in the processes that import tests: the one that deals them out does not."""
    _same_in_every_run()


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Search for no garbage among what is collected, then or later: tests and modules stay to the end."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Give each process whole files: what the tests of a file share is made once."""
    from xdist.scheduler import LoadFileScheduling

    return LoadFileScheduling(config, log)


@pytest.fixture(scope="session")
def three_forces(calibrated: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a calibration over F_x, F_z, F_y under a moment, made of the small one: L_v grows with F_y^2."""
    import numpy as np

    from sits_mech.readout.loads import over_loads
    from sits_mech.report.folder import read_calibration
    from sits_mech.report.written import write_calibration

    sensor, data = read_calibration(calibrated)
    data = data.drop_dims(["part", "cause"])  # a table that tells no parts of its errors
    F_y = np.array([-0.4, 0.0, 0.4])
    each = {name: data[name].expand_dims({"F_y": F_y}, data[name].get_axis_num("F_z") + 1) for name in over_loads(data)}
    wide = data.drop_vars(list(each)).assign(each).assign_coords(M=1e-3)
    wide["L_v_percent"] = wide["L_v_percent"] + wide["F_y"] ** 2
    for name, slope in (("d_y", 1e-4), ("alpha_x", -1e-2), ("alpha_z", 1e-3)):
        wide[name] = slope * wide["F_y"] + 0.0 * wide["d_v"]
        wide[f"error_{name}"] = wide["error_d_h"]
    folder = tmp_path_factory.mktemp("three") / "made"
    (folder / "cases").mkdir(parents=True)
    write_calibration(sensor, wide.transpose("F_x", "F_z", "F_y", "coil", "coil_2"), folder)
    return folder


@pytest.fixture(scope="session")
def calibrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a small calibration of biorob2018-w15, as the command leaves it: 5 shears, 4 normal forces.

    One for all processes of a run: who comes first makes it, others wait.
    """
    from sits_mech.cli.main import run

    own = tmp_path_factory.getbasetemp()
    root = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    folder, ended = root / "calibrated", root / "calibrated.ended"
    try:
        (root / "calibrated.begun").mkdir()
    except FileExistsError:
        while not ended.exists():
            time.sleep(0.05)
    else:
        loads = ("--fx", "-1 N:1 N:5", "--fz", "0 N:3 N:4", "--mechanics", "planar")
        try:
            words = ("--magnetics", "planar", "--accept", "-o", str(folder))  # above the tolerance: plane strain
            assert run(["calibrate", "biorob2018-w15", *loads, *words]) == 0
        finally:
            ended.touch()
    assert (folder / "result.nc").exists()
    return folder


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
        """Open a file and wait until it is loaded; what was complained of before is forgotten."""
        self.events = []
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
        code = {"ArrowRight": 39, "ArrowLeft": 37, "ArrowDown": 40, "ArrowUp": 38, "Home": 36, "End": 35, "Tab": 9}[key]
        for _ in range(times):
            for kind in ("keyDown", "keyUp"):
                self.ask("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code)

    def click(self, name: str, across: float, down: float) -> None:
        """Click on an element, at shares of its width and height."""
        self.run(f'document.getElementById("{name}").scrollIntoView({{block: "center", behavior: "instant"}})')
        box = f'document.getElementById("{name}").getBoundingClientRect()'
        x, y = self.run(f"(r => [r.x + {across} * r.width, r.y + {down} * r.height])({box})")
        for kind in ("mousePressed", "mouseReleased"):
            self.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1, buttons=1)

    def drag(self, name: str, right: float, down: float) -> None:
        """Drag an element from its middle by pixels, in two moves."""
        self.run(f'document.getElementById("{name}").scrollIntoView({{block: "center", behavior: "instant"}})')
        box = f'document.getElementById("{name}").getBoundingClientRect()'
        x, y = self.run(f"(r => [r.x + 0.5 * r.width, r.y + 0.5 * r.height])({box})")
        for kind, share in (("mousePressed", 0.0), ("mouseMoved", 0.5), ("mouseMoved", 1.0), ("mouseReleased", 1.0)):
            at = {"x": x + share * right, "y": y + share * down}
            self.ask("Input.dispatchMouseEvent", type=kind, button="left", clickCount=1, buttons=1, **at)

    def slide(self, **values: float) -> None:
        """Move sliders to values, one after the other as a hand does."""
        for name, value in values.items():
            slider = f'document.getElementById("s-{name}")'
            self.run(f'(s => {{s.value = {float(value)}; s.dispatchEvent(new Event("input"))}})({slider})')

    def width(self, pixels: int) -> None:
        """Make the window so wide."""
        size = {"height": 900, "deviceScaleFactor": 1, "mobile": pixels < 600}
        self.ask("Emulation.setDeviceMetricsOverride", width=pixels, **size)

    def choose(self, name: str, value: str) -> None:
        """Choose one of a list."""
        script = f's.value = "{value}"; s.dispatchEvent(new Event("change"))'
        self.run(f'(s => {{{script}}})(document.getElementById("{name}"))')

    def every(self, chosen: str, what: str) -> list[Any]:
        """Return an expression of each node n that a selector chooses."""
        return list(self.run(f"Array.from(document.querySelectorAll('{chosen}')).map(n => {what})"))

    def text(self, name: str) -> str:
        """Return what stands in an element of the page."""
        return str(self.run(f'document.getElementById("{name}").textContent'))

    def shown(self, name: str) -> float:
        """Return a number that the page shows."""
        return float(self.text(f"v-{name}").split()[0].replace("\u2212", "-"))

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


@pytest.fixture(scope="session")
def one_browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """One browser for all tests."""
    if not CHROMIUM:
        pytest.skip("no browser: needs chromium (Debian: apt-get install chromium)")
    found = Browser(tmp_path_factory.mktemp("profile"))
    yield found
    found.close()


@pytest.fixture
def browser(one_browser: Browser) -> Iterator[Browser]:
    """That browser; no page stays open after a test, which might go on drawing through all those that follow."""
    yield one_browser
    one_browser.ask("Page.navigate", url="about:blank")


@pytest.fixture(scope="session")
def triaxial() -> tuple[Any, Any]:
    """A table over F_x, F_z, F_y of triaxial-4, polynomials of degree two: its target follows, tilts and turns."""
    import numpy as np
    import xarray as xr

    from sits_mech.readout.signals import signals, weights_of
    from sits_mech.scene.sensor import load_sensor

    sensor = load_sensor("triaxial-4")
    nodes = {"F_x": np.linspace(-0.5, 0.5, 5), "F_z": np.linspace(0.0, 2.0, 4), "F_y": np.linspace(-0.5, 0.5, 3)}
    x, z, y = np.meshgrid(*nodes.values(), indexing="ij")
    pose = {
        "d_h": 8e-4 * x, "d_v": 2e-3 - 5e-5 * z, "alpha": -5e-3 * x, "d_y": 8e-4 * y, "alpha_x": 5e-3 * y,
        "alpha_z": 1e-2 * x * y,
    }
    places = np.array([coil.centre for coil in sensor.coils])
    rise = 2.0 * (x[..., None] * places[:, 0] + y[..., None] * places[:, 1]) / 4e-3 - 0.15 * z[..., None]
    L0 = np.full(4, 2.5e-6)
    L = L0 * (0.97 + 0.01 * rise - 1e-3 * rise**2)
    shown = signals(L, L0, weights_of(places, sensor.coils[0].outer_diameter / 2), 1e-10)
    dims = tuple(nodes)
    variables = {name: (dims, values) for name, values in (*pose.items(), *shown.known.items())}
    variables |= {f"error_{name}": (dims, np.full(x.shape, 1e-6)) for name in pose}
    variables |= {name: (dims, np.full(x.shape, 1e-3)) for name in ("error_mechanics", "error_magnetics", "seconds")}
    sizes = {"R": 0.05, "error_L": 1e-10, "error_R": 1e-3}
    matrix = {"L": L} | {name: np.full(L.shape, size) for name, size in sizes.items()}
    variables |= {name: ((*dims, "coil", "coil_2"), own[..., None] * np.eye(4)) for name, own in matrix.items()}
    variables |= {"L0": (("coil", "coil_2"), np.diag(L0)), "min_J": (dims, np.full(x.shape, 0.9))}
    words = {"status": "ok", "flags": "ok", "reason": "", "notes": ""}
    variables |= {name: (dims, np.full(x.shape, word)) for name, word in words.items()}
    names = [coil.name for coil in sensor.coils]
    request = json.dumps({"mechanics": "block", "magnetics": "sheets", "tolerance": 1e-2})
    about = {"name": sensor.name, "frequency": 5e6, "unit_L": "H", "notes": "", "version": "0", "scene_hash": "0"}
    return sensor, xr.Dataset(variables, {**nodes, "coil": names, "coil_2": names}, about | {"request": request})


@pytest.fixture(scope="session")
def numerics_alone() -> Callable[[], AbstractContextManager[None]]:
    """Models that leave nothing out: for readings that are made by the same models, and errors of numerics."""
    from sits_mech.chain import models
    from sits_mech.chain.omitted import mechanical as left_out
    from sits_mech.chain.plans import aimed, plan
    from sits_mech.magnetics.coils.tracks import Tracks

    @contextmanager
    def alone() -> Iterator[None]:
        with pytest.MonkeyPatch.context() as patch:
            for half in ("MECHANICS", "MAGNETICS"):
                bare = {name: replace(each, omissions=lambda *_: ()) for name, each in getattr(models, half).items()}
                for module in (aimed, models, plan, left_out):
                    patch.setattr(module, half, bare, raising=False)
            patch.setattr(left_out, "bending", lambda *_: ())
            patch.setattr(Tracks, "unknown", lambda _, found: found.L[None].repeat(2, axis=0) * 0j)
            yield

    return alone


@pytest.fixture
def collisions(monkeypatch: pytest.MonkeyPatch) -> Callable[[Any], list[str]]:
    """Return what names the pairs of texts of a figure that overlap, and the texts that leave it."""
    from matplotlib.text import Text

    slack = 1.0  # pixels that boxes may share

    def found(figure: Any) -> list[str]:
        figure.set_dpi(300)
        drawn: dict[int, Any] = {}
        plain = Text.draw

        def noted(self: Any, *args: object, **options: object) -> None:
            """Draw a text, and note that it is drawn."""
            drawn[id(self)] = self
            plain(self, *args, **options)

        with monkeypatch.context() as patch:
            patch.setattr(Text, "draw", noted)
            figure.canvas.draw()
        boxes = [(text.get_text(), Text.get_window_extent(text)) for text in drawn.values() if text.get_text().strip()]
        assert boxes
        (width, height), low = figure.bbox.size + slack, -slack
        out = [f"{words!r} is cut off" for words, box in boxes
               if box.x0 < low or box.y0 < low or box.x1 > width or box.y1 > height]
        return out + [
            f"{one!r} over {other!r}" for (one, a), (other, b) in combinations(boxes, 2)
            if min(a.x1, b.x1) - max(a.x0, b.x0) > slack and min(a.y1, b.y1) - max(a.y0, b.y0) > slack
        ]

    return found
