"""The page of the studio: the scene at the left, sensor, curves and maps at the right, made with NiceGUI."""

from __future__ import annotations

import asyncio
import json
import secrets
import socket
import sys
import tomllib
import webbrowser
from collections.abc import Callable, Mapping
from functools import partial
from importlib import resources
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import numpy as np
import xarray as xr
from nicegui import app, ui

from sits_mech.quantities import WRENCH
from sits_mech.report.page.html import page as report_page
from sits_mech.report.shown import Shown, calibration_page, merit
from sits_mech.report.tables.loads import csv_text
from sits_mech.scene.plausible import slips
from sits_mech.scene.sensor import SceneError, Sensor, catalogue, scene_hash, scene_text, sensor_from
from sits_mech.studio.asked import lines, rows_html
from sits_mech.studio.form import Form
from sits_mech.studio.guard import Guard
from sits_mech.studio.questions import ends_asked
from sits_mech.studio.session import Session, View
from sits_mech.studio.solver import SolverProcess


def frame(view: View, data: xr.Dataset) -> str:
    """Return the page of a view's table, as the report's explorer shows it, with what is required.

    Figures of merit take three times as long as the rest, and wait for a solved one.
    """
    asked, below = None, ""
    if view.judged is not None:
        asked, below = lines(view.judged, view.sensor, data), f"<h2>Required</h2>{rows_html(view.judged)}"
    return calibration_page(view.sensor, data, "", asked, below + (merit(data) if view.kind == "solved" else ""))


def pictures(view: View) -> tuple[str, ...]:
    """Return the names of the pictures that a view has, as files: of a solved table its curves too."""
    names = Shown(view.sensor, view.data if view.kind == "solved" else None).pictures()
    return tuple(f"{name}.{format}" for name in names for format in ("svg", "png"))


def cost(data: xr.Dataset) -> str:
    """Return in words what a table took, beside what was planned; nothing where neither is known."""
    took, planned = float(np.nansum(data["seconds"])) if "seconds" in data else 0.0, data.attrs.get("planned")
    words = "" if planned is None else f", planned {float(planned[0]):.2g} s"
    return f"; took {took:.2g} s{words}" if took else ""


def file_of(view: View, name: str) -> bytes:
    """Return a file of what is shown, by its name; SceneError where a table must be solved for it."""
    if name == "scene.toml":
        return scene_text(view.sensor).encode()
    if name in pictures(view):
        stem, _, format = name.rpartition(".")
        return Shown(view.sensor, view.data if view.kind == "solved" else None).picture(stem, format)
    if view.data is None or view.kind != "solved":
        raise SceneError(f"{name}: must be of a solved table; this one is a {view.kind}")
    if name == "table.csv":
        return csv_text(view.data).encode()
    return report_page(view.sensor, view.data).encode()


_COLOURS = {"drawing": "grey", "preview": "orange", "solved": "green"}
_STALE = "document.querySelectorAll('#sits-frames iframe').forEach(one => one.classList.add('stale'))"
_RESTS = 0.15  # seconds without another move, until a drawing is made: it takes as long
_FILES = ("scene.toml", "table.csv", "report.html")
_AWAY = 60.0  # seconds that a tab may be silent, as one whose machine is busy or sleeps, before its page is dropped


def serve(
    source: str, models: tuple[str, str, float], port: int = 0, *, browser: bool = True, required: str = ""
) -> None:
    """Serve the studio on this machine alone until it is interrupted; `port` 0 takes a free one.

    `models` are the mechanical and the magnetic one and the tolerance of the signals, `required` the text of a
    requirement file.
    """
    token, solver = secrets.token_urlsafe(24), SolverProcess()
    if not port:
        with socket.socket() as found:
            found.bind(("127.0.0.1", 0))
            port = int(found.getsockname()[1])
    query = urlencode({"token": token, "scene": source})
    address = f"http://127.0.0.1:{port}/?{query}"
    app.add_middleware(Guard, token=token)
    app.on_shutdown(solver.close)
    ui.page("/", title="sits-mech studio", favicon="data:,")(partial(_opened, solver, models, required))
    sys.stdout.write(f"{address}\n")
    sys.stdout.flush()
    if browser:
        app.on_startup(lambda: webbrowser.open(address))
    ui.run(host="127.0.0.1", port=port, show=False, reload=False, show_welcome_message=False,
           uvicorn_logging_level="error", reconnect_timeout=_AWAY)


async def _opened(solver: SolverProcess, models: tuple[str, str, float], required: str) -> None:
    """Make the page of a tab, of the scene and the keys that its address names, once the tab is there to show it.

    A request that no tab follows, as of a script or a page that is fetched ahead, has no session and no drawing.
    """
    query = dict(ui.context.client.request.query_params)
    ui.add_head_html(f"<style>{(_file('studio.css'))}</style><script>{_file('frame.js')}</script>")
    try:
        await ui.context.client.connected(_AWAY)
    except TimeoutError:
        return
    asked = {key: value for key, value in query.items() if key not in ("token", "scene")}
    _Page(solver, models, query.get("scene", ""), asked, required)


class _Page:
    """The elements of a tab, and what they do."""

    def __init__(
        self, solver: SolverProcess, models: tuple[str, str, float], source: str, asked: Mapping[str, str],
        required: str
    ) -> None:
        self.client = ui.context.client
        self.loop = asyncio.get_running_loop()
        self.session = Session(solver, self.client.id, self._show, models, self.loop.call_soon_threadsafe)
        self.drawn: tuple[Any, ...] = ()
        self.searched = 0, 0
        self.framed = False
        self.drawing_soon = self.loop.call_later(0.0, lambda: None)
        with ui.row().classes("sits-page"):
            with ui.column().classes("sits-scene"):
                self._left(source, required)
            with ui.column().classes("sits-sensor"):
                with ui.row().classes("items-center w-full"):
                    self.state = ui.badge("", color="grey").props('role="status"')
                    self.stops = _button("stop", self._stops_or_solves)
                    self.open = ui.label()
                self.drawing = ui.html(sanitize=False).classes("sits-drawing")
                ui.html('<div id="sits-frames"></div>', sanitize=False).classes("w-full")
        self.client.on_disconnect(self.session.close)
        keys = {key: value for key, value in asked.items() if key not in WRENCH}
        self._tried(lambda: self.session.open(str(self.scene.value), keys, ends_asked(asked)))
        if required:
            self._tried(lambda: self.session.require(required))
        self.form.fill()

    def _left(self, source: str, required: str) -> None:
        """Make the column of the scene: which, its controls, its file, what is required of it, what comes out."""
        names = list(catalogue())
        others = [] if source in names or not source else [source]
        if source.endswith("recommended.toml"):  # of a design, whose front stands beside it
            others += sorted(map(str, (Path(source).parent / "front").glob("*.toml")))
        options = [*others, *names]
        self.scene = ui.select(
            options, label="scene", value=source or names[0],
            on_change=lambda event: self._does(lambda: self.session.open(str(event.value))),
        )
        self.wrong = ui.label().classes("sits-wrong").props('role="alert"')
        self.form = Form(self.session, self._tried)
        with ui.expansion("scene file").classes("w-full"):
            self.text = ui.textarea().classes("w-full sits-text").props("outlined dense")
            _button("take over", lambda: self._does(lambda: self.session.take(sensor_from_text(str(self.text.value)))))
        with ui.expansion("required", value=bool(required), on_value_change=self._begins_to_require).classes("w-full"):
            self.required = ui.textarea(value=required).classes("w-full sits-text").props("outlined dense")
            with ui.row():
                _button("judge", lambda: self._does(lambda: self.session.require(str(self.required.value))))
                _button("find", lambda: self._does(lambda: self.session.find(str(self.required.value))))
            self.search = ui.column().classes("w-full sits-search gap-0").props('role="log"')
        with ui.expansion("out").classes("w-full"):
            self.command = ui.label().classes("sits-command")
            with ui.row():
                for name in _FILES:
                    _button(name, partial(self._hands_out, name))
            self.picture = ui.select(["drawing.svg", "drawing.png"], label="picture", value="drawing.svg")
            _button("picture", lambda: self._hands_out(str(self.picture.value)))
            self.link = ui.link("this state").classes("sits-command")

    def _tried(self, act: Callable[[], None]) -> None:
        """Do what a hand asked for; say in one line what was wrong with it."""
        try:
            act()
            self.wrong.set_text("; ".join(slips(self.session.sensor)))  # what is allowed, but hardly meant
        except SceneError as error:
            self.wrong.set_text(" ".join(str(error).split()))

    def _does(self, act: Callable[[], None]) -> None:
        """Do what a hand asked for, and show it in the form."""
        self._tried(act)
        self.form.fill()

    def _stops_or_solves(self) -> None:
        """Stop what is solved, or go on."""
        (self.session.update if self.session.stopped else self.session.stop)()

    def _begins_to_require(self, event: Any) -> None:
        """Write requirements to begin with, where there are none."""
        if event.value and not self.required.value and self.session.ends:
            from sits_mech.studio.asked import first_words

            self.required.set_value(first_words(self.session.ends, self.session.sensor))

    def _show(self, view: View) -> None:
        """Show what is known now."""
        if self.client.id not in type(self.client).instances:
            return
        with self.client:
            self.state.set_text(view.kind if view.state == view.kind else f"{view.kind}, {view.state}")
            self.state.props(f"color={_COLOURS[view.kind]}")
            self.stops.set_text("solve" if self.session.stopped else "stop")
            self.command.set_text(self.session.command)
            keys, ends = self.session.keys, self.session.ends
            loads = {name: f"{low!r}:{high!r}" for name, (low, high) in ends.items()}
            query = urlencode({"scene": self.session.source, **(keys or {}), **loads})
            self.link.props(f'href="/?{query}"').set_visibility(keys is not None)
            self._show_search()
            if self.session.ends.keys() != self.form.bears:
                self.form.fill()
            now = view.kind, scene_hash(view.sensor), id(view.data), id(view.judged)
            if now != self.drawn:
                self.drawn = now
                self._draw(view)

    def _draw(self, view: View) -> None:
        """Draw a scene that changed, or more that is known of it; a plain drawing once its sliders rest."""
        self.text.set_value(scene_text(view.sensor))
        self.drawing_soon.cancel()
        if view.data is None:
            self.open.set_text("")
            if not self.drawing.content and not self.framed:  # the first one, before anything is solved
                self._draw_plainly(view.sensor)
                return
            self.drawing_soon = self.loop.call_later(_RESTS, self._draw_plainly, view.sensor)
            return
        self.framed = True
        from sits_mech.studio.previews import open_share

        words = f"signals within {100.0 * open_share(view.data):.3g} % of their range"
        self.open.set_text(words + (cost(view.data) if view.kind == "solved" else ""))
        self.drawing.set_content("")
        self.picture.set_options([*pictures(view)], value=self.picture.value)
        ui.run_javascript(f"sitsDraw({json.dumps(frame(view, view.data))}, {json.dumps(view.kind)})")

    def _draw_plainly(self, sensor: Sensor) -> None:
        """Draw plan and section of a scene of which no table is known; the last table stays, pale."""
        from sits_mech.report.pictures.drawing import scene_drawing
        from sits_mech.report.pictures.style import figure_bytes

        if self.client.id in type(self.client).instances:
            with self.client:
                self.drawing.set_content(figure_bytes(scene_drawing(sensor), "svg").decode())
                ui.run_javascript(_STALE)

    def _show_search(self) -> None:
        """Show the designs of the search, and what it found."""
        session = self.session
        now = len(session.tried), id(session.found)
        if now == self.searched:
            return
        self.searched = now
        self.search.clear()
        with self.search:
            if session.found is not None and session.asked is not None:
                best, space = session.found.best, session.asked.space
                ui.label(session.found.verdict)
                for each in dict.fromkeys((best.design, *(one.design for one in session.found.front))):
                    _button(space.words(each), partial(self._does, partial(self.session.take, space.sensor(each))))
            for line in reversed(session.tried):
                ui.label(line).classes("sits-command")

    def _hands_out(self, name: str) -> None:
        """Give a file of what is shown."""
        self._tried(lambda: ui.download(file_of(self.session.view(), name), name))


def _button(words: str, act: Callable[[], None]) -> ui.button:
    """Make a button in a line of others."""
    return ui.button(words, on_click=act).props("dense flat no-caps")


def sensor_from_text(text: str) -> Sensor:
    """Return the sensor of a scene file's text; SceneError for anything wrong."""
    try:
        return sensor_from(tomllib.loads(text), "scene file")
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"scene file: must be TOML; got: {error}") from None


def _file(name: str) -> str:
    """Return the text of a file of the studio."""
    return (resources.files("sits_mech.studio") / name).read_text(encoding="utf-8")
