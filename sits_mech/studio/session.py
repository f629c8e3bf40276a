"""What one tab shows: a scene under its loads, previewed at once, solved behind, and the tables that help both."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import xarray as xr

from sits_mech.readout.signals import told
from sits_mech.scene.parameters import keys_of
from sits_mech.scene.sensor import Sensor, changed, load_sensor
from sits_mech.studio.previews import Solved, numbers_of, preview
from sits_mech.studio.solver import Question, Solver, grid_of

SLIDERS = {
    "elastomer.thickness": "pad thickness", "elastomer.width": "pad width", "elastomer.length": "pad length",
    "elastomer.diameter": "pad diameter", "elastomer.standoff": "gap", "target.width": "target width",
    "target.length": "target length", "target.diameter": "target diameter", "target.thickness": "target thickness",
    "coils.*.turns": "turns", "frequency": "frequency", "temperature": "temperature",
}
"""Keys with a slider, where the scene gives them."""
_SLOPED = ("elastomer.thickness", "elastomer.width", "elastomer.diameter", "target.width", "target.diameter")
BESIDE = (0.88, 1.14)
"""Of a number that was moved: tables made while nobody waits, so that its preview is good."""
Kind = Literal["drawing", "preview", "solved"]


@dataclass(frozen=True)
class View:
    """What is to be seen: a drawing alone, a preview, or what was solved; and what happens behind."""

    kind: Kind
    sensor: Sensor
    data: xr.Dataset | None
    state: str


class Session:
    """The state of a tab; `draw` is called when there is something else to see.

    `models` are the mechanical and the magnetic one and the tolerance of the signals. `later` calls a function with its
    arguments in the thread of the tab; what the solver says comes from another one.
    """

    def __init__(
        self, solver: Solver, tab: str, draw: Callable[[View], None], models: tuple[str, str, float],
        later: Callable[..., Any],
    ) -> None:
        self.solver, self.tab, self.draw, self.models, self.later = solver, tab, draw, models, later
        self.source, self.keys = "biorob2018-w15", dict[str, str]()
        self.sensor = load_sensor(self.source)
        self.most = dict[str, float]()  # largest forces [N]; of none those that the pad bears
        self.visited = list[Sensor]()
        self.moved = ""

    def open(self, source: str, keys: dict[str, str] | None = None, most: dict[str, float] | None = None) -> None:
        """Show a scene of the catalogue or a file, with keys changed; SceneError as `load_sensor`."""
        keys = keys or {}
        sensor = load_sensor(source, [f"{key}={value}" for key, value in keys.items()])
        self.source, self.keys, self.sensor, self.most, self.visited = source, dict(keys), sensor, dict(most or {}), []
        self.update()

    def take(self, sensor: Sensor) -> None:
        """Show another scene, written by hand."""
        before, after = numbers_of(self.sensor), numbers_of(sensor)
        for key, value in after.items():
            if before.get(key) != value:
                self.keys[key] = repr(value)
        self.sensor = sensor
        self.update()

    def change(self, key: str, value: str) -> None:
        """Change a key of the scene, a star meaning all entries; SceneError as `changed`, and nothing is changed."""
        keys = keys_of(self.sensor, key) if "*" in key else [key]
        sensor = changed(self.sensor, [f"{each}={value}" for each in keys])
        self.sensor, self.moved = sensor, key
        self.keys |= dict.fromkeys(keys, value)
        self.update()

    def bear(self, name: str, most: float) -> None:
        """Ask for another range of a force [N]."""
        self.most[name] = most
        self.update()

    def close(self) -> None:
        """Want nothing any more."""
        self.solver.ask(self.tab, [], self._heard)

    @property
    def loads(self) -> tuple[tuple[str, tuple[float, ...]], ...]:
        """The grid of loads; empty where the pad is to say it."""
        return tuple((name, grid_of(name, most)) for name, most in self.most.items())

    def question(self, sensor: Sensor, numbers: tuple[str, ...] = ()) -> Question:
        """Return what to ask of a scene under the loads."""
        return Question(sensor, self.loads, self.models, numbers)

    @property
    def command(self) -> str:
        """The command that gives the same table."""
        keys = "".join(f" --set {key}={value!r}" for key, value in self.keys.items())
        loads = "".join(
            f' --f{name[2]} "{values[0]!r} N:{values[-1]!r} N:{len(values)}"' for name, values in self.loads
        )
        options = zip(("mechanics", "magnetics", "tolerance"), self.models, ("auto", "auto", 0.01), strict=True)
        models = "".join(f" --{name} {value}" for name, value, usual in options if value != usual)
        return f"sits-mech calibrate {self.source}{keys}{loads}{models} -o calibration"

    def view(self, state: str = "") -> View:
        """Return what is known of the scene now."""
        own = self.question(self.sensor)
        if own.key in self.solver.kept and self.loads:
            return View("solved", self.sensor, self.solver.kept[own.key], state or "solved")
        known = self._known()
        for base in sorted(known, key=lambda each: each.slopes is None):
            data = preview(base, known, self.sensor)
            if data is not None:
                return View("preview", self.sensor, data, state or "preview")
        return View("drawing", self.sensor, None, state or "waits for its first table")

    def update(self) -> None:
        """Draw what is known, and ask for what is not."""
        view = self.view()
        wishes = []
        if view.kind != "solved":
            wishes.append((self.question(self.sensor), True))
        if self.loads:
            wishes += [(question, False) for question in self._behind()]
        self.draw(view)
        self.solver.ask(self.tab, wishes, self._heard)

    def _behind(self) -> list[Question]:
        """Return what may be solved while nobody waits: slopes where there are none, tables beside a slider."""
        numbers, found = self._numbers, list[Question]()
        base = next((each for each in self._known() if each.slopes is not None), None)
        if base is None:
            found.append(self.question(self.sensor, numbers))
        if self.moved in numbers:
            value = numbers_of(self.sensor)[self.moved]
            start = value if base is None else base.numbers.get(self.moved, value)
            root = self.sensor if base is None else base.sensor
            found += [self.question(changed(root, [f"{self.moved}={share * start!r}"])) for share in BESIDE]
        return [each for each in found if each.key not in self.solver.kept]

    @property
    def _numbers(self) -> tuple[str, ...]:
        """The keys by which slopes are solved."""
        given = numbers_of(self.sensor)
        return tuple(key for key in _SLOPED if isinstance(given.get(key), float))

    def _known(self) -> list[Solved]:
        """Return the tables of the scenes that were seen, under these loads, with their slopes, latest first."""
        kept, numbers, found = self.solver.kept, self._numbers, []
        for sensor in reversed(self.visited):
            own, by = self.question(sensor), self.question(sensor, numbers)
            if own.key in kept:
                found.append(Solved(sensor, kept[own.key], kept.get(by.key)))
        return found

    def _heard(self, question: Question, kind: str, what: Any) -> None:
        """Hand over what the solver says in its thread; a tab that is gone hears nothing."""
        with suppress(RuntimeError):
            self.later(self._told, question, kind, what)

    def _told(self, question: Question, kind: str, what: Any) -> None:
        """Take what the solver says."""
        asked = question.key == self.question(self.sensor).key
        if kind == "done":
            if not question.loads:
                self.most = {name: max(values) for name, values in what}
                self.update()
                return
            if not question.numbers and question.sensor not in self.visited:
                self.visited.append(question.sensor)
            self.update()
        elif asked and kind == "progress":
            self.draw(self.view(f"solving: {what[0]} of {what[1]} loads"))
        elif asked and kind == "started":
            self.draw(self.view("solving"))
        elif asked and kind == "failed":
            self.draw(self.view(f"not solved: {what}"))


def open_share(data: xr.Dataset) -> float:
    """Return the largest error of a signal of a table, over the range of all."""
    names = [name for name in told(data) if name in data]
    ranges = max(float(np.nanmax(data[name]) - np.nanmin(data[name])) for name in names)
    return max(float(np.nanmax(data[f"error_{name}"])) for name in names) / ranges
