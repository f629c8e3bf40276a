"""The scene as a form: sliders of what is changed most, a field for each key as the scene's schema describes it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Set
from functools import cache, partial
from itertools import groupby
from typing import Any

from nicegui import ui

from sits_mech.quantities import shown_unit
from sits_mech.scene.materials import silicones
from sits_mech.scene.parameters import numbers_of
from sits_mech.scene.parts.coils import resolved_shear
from sits_mech.scene.sensor import SceneError
from sits_mech.studio.session import SLIDERS, Session

_THROTTLE = 0.08  # seconds between moves of a slider that are followed
_UNITS = {"frequency": (1e-6, "MHz"), "temperature": (1.0, "K"), "coils.*.turns": (1.0, "")}
_LONG = 60  # letters of a value that has no field: outlines and paths are changed in the scene file


class _Slider(ui.element, component="slider.js"):
    """A slider of the page's own; it tells its moves."""


class Form:
    """Sliders, largest forces and fields of the scene of a session, in the element that is open."""

    def __init__(self, session: Session, tried: Callable[[Callable[[], None]], None]) -> None:
        self.session, self.tried = session, tried
        self.bears: Set[str] = set()  # components of the load with a range, as they are shown
        self.controls = ui.column().classes("w-full gap-1")
        with ui.expansion("all keys").classes("w-full") as self.keys:
            self.every = ui.column().classes("w-full gap-0")
        self.keys.on_value_change(lambda event: self._fill_keys() if event.value else None)

    def fill(self) -> None:
        """Make the controls anew."""
        sensor = self.session.sensor
        numbers, self.bears = numbers_of(sensor), set(self.session.ends)
        self.controls.clear()
        with self.controls:
            for key, words in SLIDERS.items():
                value = numbers.get(key.replace("*", "0"), sensor.temperature if key == "temperature" else None)
                if isinstance(value, float | int):
                    self._slider(key, words, float(value))
            if sensor.elastomer is not None and isinstance(sensor.elastomer.material, str):
                ui.select(sorted(silicones()), label="silicone", value=sensor.elastomer.material,
                          on_change=lambda event: self._changes("elastomer.material", json.dumps(event.value)))
            for name in dict.fromkeys((*self.session.ends, *resolved_shear(sensor.coils), "F_z")):
                ends = self.session.ends.get(name)
                words, most = f"largest {name} [{shown_unit(name)}]", ends and max(map(abs, ends))
                field = ui.number(words, value=most, format="%.4g")
                field.on("change", partial(self._bears, name, field)).classes("w-full").props("dense")
        if self.keys.value:
            self._fill_keys()

    def _fill_keys(self) -> None:
        """Make a field for each key, by parts of the scene."""
        self.every.clear()
        with self.every:
            for part, each in groupby(numbers_of(self.session.sensor).items(), lambda item: item[0].rpartition(".")[0]):
                with ui.expansion(part or "sensor", value=not part).classes("w-full sits-part").props("dense"):
                    for key, value in each:
                        self._field(key, value)

    def _field(self, key: str, value: Any) -> None:
        """Make the field of a key: a choice where there is one, its unit beside it, what it means on top."""
        about, name = form_entry(key), key.rpartition(".")[2]
        written = json.dumps(value) if isinstance(value, str) else str(value)
        if len(written) > _LONG:
            return
        if "enum" in about and isinstance(value, str):
            field: Any = ui.select(list(about["enum"]), label=name, value=value)
            field.on_value_change(lambda event: self._types(key, field, json.dumps(event.value)))
        else:
            field = ui.input(name, value=written).props(f'suffix="{about.get("x-unit", "")}"')
            field.on("change", lambda: self._types(key, field, str(field.value)))
        field.classes("w-full").props("dense")
        ends = f" From {about['minimum']:g} to {about['maximum']:g}." if {"minimum", "maximum"} <= about.keys() else ""
        if about.get("description") or ends:
            field.tooltip(f"{about.get('description', '')}{ends}")

    def _slider(self, key: str, words: str, value: float) -> None:
        """Make a slider from half of a number to twice of it."""
        scale, unit = _UNITS.get(key, (1e3, "mm"))
        low, high, step = slider_range(key, value)
        with ui.row().classes("w-full justify-between items-center no-wrap gap-2"):
            ui.label(words).classes("sits-words")
            shown = ui.label(f"{value * scale:.4g} {unit}").classes("sits-number")
        slider = _Slider().props(f'aria-label="{words}" dense')
        slider.props.update(start=value * scale, min=low * scale, max=high * scale, step=step * scale)

        def moved(event: Any) -> None:
            """Follow the slider."""
            now = float(event.args)
            shown.set_text(f"{now:.4g} {unit}")
            self._changes(key, str(round(now)) if key.endswith("turns") else repr(now / scale))

        slider.on("moved", moved, throttle=_THROTTLE)

    def _changes(self, key: str, value: str) -> None:
        """Change a key."""
        self.tried(lambda: self.session.change(key, value))

    def _types(self, key: str, field: Any, value: str) -> None:
        """Take a key as it was typed; mark it there where no scene may have it."""

        def act() -> None:
            """Change the key, and say at the field what was wrong with it."""
            field.props(remove="error error-message")
            try:
                self.session.change(key, value)
            except SceneError as error:
                field.props["error"], field.props["error-message"] = True, " ".join(str(error).split())
                field.update()
                raise

        self.tried(act)

    def _bears(self, name: str, field: ui.number) -> None:
        """Take another range of a component of the load; none where it is empty or zero."""
        self.tried(lambda: self.session.bear(name, abs(float(field.value or 0.0))))


def slider_range(key: str, value: float) -> tuple[float, float, float]:
    """Return lowest and highest value and step of a slider: half of a number to twice of it, turns by ones."""
    if key.endswith("turns"):
        return max(value // 2.0, 1.0), 2.0 * value, 1.0
    low, high = (250.0, 350.0) if key == "temperature" else (0.5 * value, 2.0 * value) if value else (0.0, 5e-4)
    return low, high, (high - low) / 300.0


@cache
def _schema() -> dict[str, Any]:
    """Return the scene's schema."""
    from sits_mech.schemas.scene import scene_schema

    return scene_schema()


def form_entry(key: str) -> dict[str, Any]:
    """Return what the scene's schema says of a dotted key: description, x-unit, minimum, maximum, enum."""
    found = [_schema()]
    for part in key.split("."):
        nodes = [node for each in found for node in _nodes(each)]
        found = [node["items"] for node in nodes if "items" in node] if part.isdigit() else [
            node["properties"][part] for node in nodes if part in node.get("properties", {})
        ]
    about: dict[str, Any] = {}
    for node in (node for each in found for node in _nodes(each)):
        about = node | about
    return about


def _nodes(node: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield an entry of the schema, and what it refers to or chooses from."""
    yield node
    if "$ref" in node:
        yield from _nodes(_schema()["$defs"][node["$ref"].rpartition("/")[2]])
    for each in node.get("anyOf", ()):
        yield from _nodes(each)
