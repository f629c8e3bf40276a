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
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import urlencode

import numpy as np
import xarray as xr
from nicegui import app, ui

from sits_mech.report.page.html import page as report_page
from sits_mech.report.shown import Shown, calibration_page, drawing
from sits_mech.report.tables.loads import csv_text
from sits_mech.scene.materials import silicones
from sits_mech.scene.plausible import slips
from sits_mech.scene.sensor import SceneError, Sensor, catalogue, scene_hash, scene_text, sensor_from
from sits_mech.studio.guard import Guard
from sits_mech.studio.previews import numbers_of
from sits_mech.studio.session import SLIDERS, Session, View, open_share
from sits_mech.studio.solver import Solver

_THROTTLE = 0.08  # seconds between moves of a slider that are followed
_UNITS = {"frequency": (1e-6, "MHz"), "temperature": (1.0, "K"), "coils.*.turns": (1.0, "")}
_COLOURS = {"drawing": "grey", "preview": "orange", "solved": "green"}
_STALE = "document.querySelectorAll('#sits-frames iframe').forEach(one => one.classList.add('stale'))"


def serve(source: str, models: tuple[str, str, float], port: int = 0, *, browser: bool = True) -> None:
    """Serve the studio on this machine alone until it is interrupted; `port` 0 takes a free one.

    `models` are the mechanical and the magnetic one and the tolerance of the signals.
    """
    token, solver = secrets.token_urlsafe(24), Solver()
    port = port or _free_port()
    query = urlencode({"token": token, "scene": source})
    address = f"http://127.0.0.1:{port}/?{query}"
    app.add_middleware(Guard, token=token)
    app.on_shutdown(solver.close)
    ui.page("/", title="sits-mech studio", favicon="data:,")(partial(_opened, solver, models))
    sys.stdout.write(f"{address}\n")
    sys.stdout.flush()
    if browser:
        app.on_startup(lambda: webbrowser.open(address))
    ui.run(host="127.0.0.1", port=port, show=False, reload=False, show_welcome_message=False,
           uvicorn_logging_level="error")


def _free_port() -> int:
    """Return a free port."""
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def _opened(solver: Solver, models: tuple[str, str, float]) -> None:
    """Make the page of a tab, of the scene and the keys that its address names."""
    query = dict(ui.context.client.request.query_params)
    _Page(solver, models, query.pop("scene", ""), {key: value for key, value in query.items() if key != "token"})


class _Page:
    """The elements of a tab, and what they do."""

    def __init__(self, solver: Solver, models: tuple[str, str, float], source: str, asked: Mapping[str, str]) -> None:
        self.client = ui.context.client
        later = asyncio.get_running_loop().call_soon_threadsafe
        self.session = Session(solver, self.client.id, self._show, models, later)
        self.drawn: tuple[Any, ...] = ()
        ui.add_head_html(f"<style>{(_file('studio.css'))}</style><script>{_file('frame.js')}</script>")
        with ui.row().classes("sits-page"):
            with ui.column().classes("sits-scene"):
                names = list(catalogue())
                options = names if source in names or not source else [source, *names]
                self.scene = ui.select(options, label="scene", value=source or names[0], on_change=self._opens)
                self.wrong = ui.label().classes("sits-wrong").props('role="alert"')
                self.controls = ui.column().classes("w-full gap-1")
                with ui.expansion("all keys").classes("w-full"):
                    self.every = ui.column().classes("w-full gap-0")
                with ui.expansion("scene file").classes("w-full"):
                    self.text = ui.textarea().classes("w-full sits-text").props("outlined dense")
                    ui.button("take over", on_click=self._takes).props("dense flat")
                with ui.expansion("out").classes("w-full"):
                    self.command = ui.label().classes("sits-command")
                    with ui.row():
                        for name in ("scene.toml", "table.csv", "report.html", "drawing.svg"):
                            ui.button(name, on_click=partial(self._hands_out, name)).props("dense flat no-caps")
                    self.link = ui.link("this state").classes("sits-command")
            with ui.column().classes("sits-sensor"):
                with ui.row().classes("items-center w-full"):
                    self.state = ui.badge("", color="grey").props('role="status"')
                    self.open = ui.label()
                self.drawing = ui.html(sanitize=False).classes("sits-drawing")
                ui.html('<div id="sits-frames"></div>', sanitize=False).classes("w-full")
        self.client.on_disconnect(self.session.close)
        most = {key: float(value) for key, value in asked.items() if key in ("F_x", "F_y", "F_z") and _is_number(value)}
        keys = {key: value for key, value in asked.items() if key not in ("F_x", "F_y", "F_z")}
        self._tried(lambda: self.session.open(str(self.scene.value), keys, most))
        self._fill()

    def _tried(self, act: Callable[[], None]) -> None:
        """Do what a hand asked for; say in one line what was wrong with it."""
        try:
            act()
            self.wrong.set_text("; ".join(slips(self.session.sensor)))  # what is allowed, but hardly meant
        except SceneError as error:
            self.wrong.set_text(" ".join(str(error).split()))

    def _opens(self, event: Any) -> None:
        """Open another scene."""
        self._tried(lambda: self.session.open(str(event.value)))
        self._fill()

    def _takes(self) -> None:
        """Take the scene file over as it was written."""
        self._tried(lambda: self.session.take(sensor_of(str(self.text.value))))
        self._fill()

    def _fill(self) -> None:
        """Make sliders and fields of the scene anew."""
        numbers = numbers_of(self.session.sensor)
        self.controls.clear()
        with self.controls:
            for key, words in SLIDERS.items():
                own = key.replace("*", "0")
                value = numbers.get(own, self.session.sensor.temperature if key == "temperature" else None)
                if isinstance(value, float | int):
                    self._slider(key, words, float(value))
            layer = self.session.sensor.elastomer
            if layer is not None and isinstance(layer.material, str):
                ui.select(sorted(silicones()), label="silicone", value=layer.material,
                          on_change=lambda event: self._changes("elastomer.material", json.dumps(event.value)))
            for name in ("F_x", "F_y", "F_z"):
                if name in self.session.most or name == "F_z":
                    field = ui.number(f"largest {name} [N]", value=self.session.most.get(name), min=1e-4, format="%.4g")
                    field.on("change", partial(self._bears, name, field)).classes("w-full").props("dense")
        self.every.clear()
        with self.every:
            for key, value in numbers.items():
                text = ui.input(key, value=_written(value)).classes("w-full").props("dense")
                text.on("change", partial(self._types, key, text))

    def _slider(self, key: str, words: str, value: float) -> None:
        """Make a slider from half of a number to twice of it."""
        scale, unit = _UNITS.get(key, (1e3, "mm"))
        whole = key.endswith("turns")
        low, high = (250.0, 350.0) if key == "temperature" else (0.5 * value, 2.0 * value) if value else (0.0, 5e-4)
        step = 1.0 if whole else (high - low) * scale / 300.0
        with ui.row().classes("w-full justify-between items-center no-wrap gap-2"):
            ui.label(words).classes("sits-words")
            shown = ui.label(f"{value * scale:.4g} {unit}").classes("sits-number")
        slider = ui.slider(min=low * scale, max=high * scale, step=step, value=value * scale).props(
            f'aria-label="{words}" dense'
        )

        def moved(event: Any) -> None:
            """Follow the slider."""
            now = float(event.args)
            shown.set_text(f"{now:.4g} {unit}")
            self._changes(key, str(round(now)) if whole else repr(now / scale))

        slider.on("update:model-value", moved, throttle=_THROTTLE)

    def _changes(self, key: str, value: str) -> None:
        """Change a key."""
        self._tried(lambda: self.session.change(key, value))

    def _types(self, key: str, field: ui.input) -> None:
        """Take a key as it was typed."""
        self._changes(key, str(field.value))

    def _bears(self, name: str, field: ui.number) -> None:
        """Take another range of a force."""
        if field.value and field.value > 0.0:
            self._tried(lambda: self.session.bear(name, float(field.value)))

    def _show(self, view: View) -> None:
        """Show what is known now."""
        if self.client.id not in type(self.client).instances:
            return
        with self.client:
            self.state.set_text(view.kind if view.state == view.kind else f"{view.kind}, {view.state}")
            self.state.props(f"color={_COLOURS[view.kind]}")
            share = None if view.data is None else open_share(view.data)
            words = "" if share is None else f"signals within {100.0 * share:.3g} % of their range"
            self.open.set_text(words + (cost(view.data) if view.kind == "solved" and view.data is not None else ""))
            self.command.set_text(self.session.command)
            query = urlencode({"scene": self.session.source, **self.session.keys, **self.session.most})
            self.link.props(f'href="/?{query}"')
            if self.session.most and not any(isinstance(each, ui.number) and each.value for each in
                                             self.controls.descendants()):
                self._fill()
            now = view.kind, scene_hash(view.sensor), id(view.data)
            if now == self.drawn:
                return
            self.drawn = now
            self.text.set_value(scene_text(view.sensor))
            if view.data is None:
                self.drawing.set_content(drawing(view.sensor))
                ui.run_javascript(_STALE)
            else:
                self.drawing.set_content("")
                text = calibration_page(view.sensor, view.data)
                ui.run_javascript(f"sitsDraw({json.dumps(text)}, {json.dumps(view.kind)})")

    def _hands_out(self, name: str) -> None:
        """Give a file of what is shown."""
        view = self.session.view()
        if name == "scene.toml":
            ui.download(scene_text(view.sensor).encode(), name)
        elif name == "drawing.svg":
            ui.download(Shown(view.sensor).picture("drawing"), name)
        elif view.kind != "solved" or view.data is None:
            self.wrong.set_text(f"{name}: must be of a solved table; this one is a {view.kind}")
        elif name == "table.csv":
            ui.download(csv_text(view.data).encode(), name)
        else:
            with TemporaryDirectory() as empty:
                ui.download(report_page(view.sensor, view.data, Path(empty)).encode(), name)


def sensor_of(text: str) -> Sensor:
    """Return the sensor of a scene file's text; SceneError for anything wrong."""
    try:
        return sensor_from(tomllib.loads(text), "scene file")
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"scene file: must be TOML; got: {error}") from None


def cost(data: xr.Dataset) -> str:
    """Return in words what a table took, beside what was planned; nothing where neither is known."""
    took, planned = float(np.nansum(data["seconds"])) if "seconds" in data else 0.0, data.attrs.get("planned")
    words = "" if planned is None else f", planned {float(planned[0]):.2g} s"
    return f"; took {took:.2g} s{words}" if took else ""


def _file(name: str) -> str:
    """Return the text of a file of the studio."""
    return (resources.files("sits_mech.studio") / name).read_text(encoding="utf-8")


def _written(value: Any) -> str:
    """Return a value of a scene as it is written for --set."""
    return json.dumps(value) if isinstance(value, str) else str(value)


def _is_number(text: str) -> bool:
    """Return whether a text is a positive number."""
    try:
        return float(text) > 0.0
    except ValueError:
        return False
