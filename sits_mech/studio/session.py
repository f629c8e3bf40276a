"""What one tab shows: a scene under its loads, previewed at once, solved behind, and the tables that help both."""

from __future__ import annotations

import shlex
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

from sits_mech.quantities import LOAD_ARGUMENTS, UNITS, WRENCH
from sits_mech.scene.files import literal
from sits_mech.scene.parameters import keys_of, numbers_of
from sits_mech.scene.sensor import SceneError, Sensor, changed, load_sensor
from sits_mech.studio.questions import (
    Borne,
    Figures,
    SearchQuestion,
    SlopesQuestion,
    StudioQuestion,
    TableQuestion,
    ends_to,
    grid_of,
)
from sits_mech.studio.solver import Advance, SolverProcess

if TYPE_CHECKING:  # these come with the first table: the first picture does not wait for them
    import xarray as xr

    from sits_mech.studio.asked import Judged
    from sits_mech.studio.previews import SolvedScene
    from sits_mech.synthesis.answer import DesignAnswer
    from sits_mech.synthesis.required.requirements import Requirements

SLIDERS = {
    "elastomer.thickness": "pad thickness", "elastomer.width": "pad width", "elastomer.length": "pad length",
    "elastomer.diameter": "pad diameter", "elastomer.standoff": "gap", "target.width": "target width",
    "target.length": "target length", "target.diameter": "target diameter", "target.thickness": "target thickness",
    "coils.*.turns": "turns", "frequency": "frequency", "temperature": "temperature",
}
"""Keys with a slider, where the scene gives them."""
_SLOPED = ("elastomer.thickness", "elastomer.width", "elastomer.diameter", "target.width", "target.diameter")
_OPTIONS = {name: option for option, name in LOAD_ARGUMENTS.items()}
NEIGHBOURS = (0.88, 1.14)
"""Of a number that was moved: tables made while nobody waits, so that its preview is good."""
Kind = Literal["drawing", "preview", "solved"]


@dataclass(frozen=True)
class View:
    """What is to be seen: a drawing alone, a preview, or what was solved; and what happens behind."""

    kind: Kind
    sensor: Sensor
    data: xr.Dataset | None
    state: str
    judged: Judged | None = None  # where something is required, and known


class Session:
    """The state of a tab; `draw` is called when there is something else to see.

    `models` are the mechanical and the magnetic one and the tolerance of the signals. `later` calls a function with its
    arguments in the thread of the tab; what the solver says comes from another one.
    """

    def __init__(
        self, solver: SolverProcess, tab: str, draw: Callable[[View], None], models: tuple[str, str, float],
        later: Callable[..., Any],
    ) -> None:
        self.solver, self.tab, self.draw, self.models, self.later = solver, tab, draw, models, later
        self.source = "biorob2018-w15"
        self.sensor = self.opened = load_sensor(self.source)
        self.ends = dict[str, tuple[float, float]]()  # ranges of the load [N, N m]; of none those that the pad bears
        self.visited = list[Sensor]()
        self.moved, self.stopped = "", False
        self.asked: Requirements | None = None
        self.search: SearchQuestion | None = None
        self.tried = list[str]()  # designs of the search, in words
        self.found: DesignAnswer | None = None
        self._refused: dict[tuple[Any, ...], str] = {}  # why there are no figures
        self._glances: dict[tuple[Any, ...], Judged | None] = {}  # by the requirements of now
        self._tables: dict[tuple[Any, ...], SolvedScene] = {}
        self._shown: tuple[tuple[Any, ...], View] | None = None
        self._advance = Advance(0.0)

    def open(
        self, source: str, keys: dict[str, str] | None = None, ends: dict[str, tuple[float, float]] | None = None
    ) -> None:
        """Show a scene of the catalogue or a file, with keys changed; SceneError as `load_sensor`."""
        opened = load_sensor(source)
        self.sensor = load_sensor(source, [f"{key}={value}" for key, value in (keys or {}).items()])
        self.source, self.opened, self.ends, self.visited = source, opened, dict(ends or {}), []
        self.asked, self.search, self.found = None, None, None
        self.update()

    def take(self, sensor: Sensor) -> None:
        """Show another scene, written by hand."""
        self.sensor = sensor
        self.update()

    def change(self, key: str, value: str) -> None:
        """Change a key of the scene, a star meaning all entries; SceneError as `changed`, and nothing is changed."""
        keys = keys_of(self.sensor, key) if "*" in key else [key]
        self.sensor, self.moved = changed(self.sensor, [f"{each}={value}" for each in keys]), key
        self.update()

    def bear(self, name: str, most: float) -> None:
        """Ask for another range of a component of the load [N, N m]; zero leaves it out, but for the last one."""
        if most > 0.0:
            ends = self.ends | {name: ends_to(name, most)}
            self.ends = {each: ends[each] for each in WRENCH if each in ends}
        elif len(self.ends) > 1:
            self.ends.pop(name, None)
        self.update()

    def require(self, text: str) -> None:
        """Judge scenes by requirements, the text of their file, and show the loads of these; SceneError as theirs."""
        from sits_mech.studio.asked import read_asked

        self.asked = read_asked(text, self.sensor)
        self._judge()

    def find(self, text: str) -> None:
        """Search the sensor that holds requirements best, of the scenes that they let vary."""
        from sits_mech.studio.asked import read_asked

        self.asked = read_asked(text, self.sensor)
        self.search, self.found = SearchQuestion(self.sensor, (), self.models, self.asked, self.solver.folder), None
        self.tried = []
        self._judge()

    def _judge(self) -> None:
        """Show the loads of what is required, and judge anew."""
        self._glances.clear()
        self._refused.clear()
        if self.asked is not None:
            self.ends = dict(self.asked.loads)
        self.update()

    def stop(self) -> None:
        """Solve nothing until something is asked for again."""
        self.search, self.stopped = None, True
        self.close()
        self.draw(self.view("stopped"))

    def close(self) -> None:
        """Want nothing any more."""
        self.solver.ask(self.tab, [], self._heard)

    @property
    def loads(self) -> tuple[tuple[str, tuple[float, ...]], ...]:
        """The grid of loads; empty where the pad is to say it."""
        return tuple((name, grid_of(*ends)) for name, ends in self.ends.items())

    def question(self, sensor: Sensor, numbers: tuple[str, ...] = ()) -> StudioQuestion:
        """Return what to ask of a scene under the loads: its table, or slopes by numbers."""
        if numbers:
            return SlopesQuestion(sensor, self.loads, self.models, numbers)
        return (TableQuestion if self.loads else Borne)(sensor, self.loads, self.models)

    @property
    def keys(self) -> dict[str, str] | None:
        """What is changed of the scene that was opened, as `--set` takes it; None where that cannot tell it all."""
        before, after = numbers_of(self.opened), numbers_of(self.sensor)
        found = {key: literal(value) for key, value in after.items() if before.get(key) != value}
        with suppress(SceneError):
            if changed(self.opened, [f"{key}={value}" for key, value in found.items()]) == self.sensor:
                return found
        return None  # parts or keys come or go

    @property
    def command(self) -> str:
        """The command that gives the same table, of the scene file that is handed out where keys do not tell it."""
        keys = self.keys
        words = ["sits-mech", "calibrate", "scene.toml" if keys is None else self.source]
        for key, value in (keys or {}).items():
            words += ["--set", f"{key}={value}"]
        words += ["--si"] if keys else []
        for name, values in self.loads:
            unit = UNITS[name].replace(" ", "*")
            words += [f"--{_OPTIONS[name]}", f"{values[0]!r} {unit}:{values[-1]!r} {unit}:{len(values)}"]
        options = zip(("mechanics", "magnetics", "tolerance"), self.models, ("auto", "auto", 0.01), strict=True)
        for option, model, usual in options:
            words += [f"--{option}", str(model)] if model != usual else []
        return shlex.join([*words, "-o", "calibration"])

    def view(self, state: str = "") -> View:
        """Return what is known of the scene now."""
        own, figures = self.question(self.sensor), self._figures
        known = self._known() if self.loads else []
        solved = [each is not None and each.key in self.solver.kept for each in (own, figures)]
        now = own.key, *solved, *map(id, known), id(self.asked)
        if self._shown is None or self._shown[0] != now:
            self._shown = now, self._made(own, known)
        kept = self._shown[1]
        why = "" if figures is None else self._refused.get(figures.key, "")
        usual = kept.kind if kept.data is not None else "waits for its first table"
        return replace(kept, state=state or why or usual)

    def _made(self, own: StudioQuestion, known: list[SolvedScene]) -> View:
        """Return a view of the scene by tables that are known."""
        if self.loads and own.key in self.solver.kept:
            data = self.solver.kept[own.key]
            return View("solved", self.sensor, data, "", self._judged(data))
        for base in sorted(known, key=lambda each: each.slopes is None):
            from sits_mech.studio.previews import preview  # known: it is there

            data = preview(base, known, self.sensor)
            if data is not None:
                return View("preview", self.sensor, data, "", self._judged(data, base))
        return View("drawing", self.sensor, None, "")

    @property
    def _figures(self) -> Figures | None:
        """The question for the figures that are required."""
        return None if self.asked is None else Figures(self.sensor, (), self.models, self.asked)

    def _judged(self, data: xr.Dataset, base: SolvedScene | None = None) -> Judged | None:
        """Return figures of the scene with what is required of them, at a glance where they are not solved."""
        asked, question = self.asked, self._figures
        if asked is None or question is None:
            return None
        from sits_mech.studio.asked import Judged, glanced

        if question.key in self.solver.kept:
            return Judged(True, asked, *self.solver.kept[question.key])
        if base is not None:
            return glanced(asked, self.sensor, data, self._glance(base.sensor, base.data))
        return self._glance(self.sensor, data)

    def _glance(self, sensor: Sensor, data: xr.Dataset) -> Judged | None:
        """Return the figures that a table tells at a glance, kept."""
        key = self.question(sensor).key
        if key not in self._glances and self.asked is not None:
            from sits_mech.studio.asked import glanced

            self._glances[key] = glanced(self.asked, sensor, data)
        return self._glances.get(key)

    def update(self) -> None:
        """Draw what is known, of another tab or a scene that was left as well, and ask for what is not."""
        self.stopped = False
        for _ in range(2):  # the range of the load, then its table
            own = self.question(self.sensor)
            if own.key in self.solver.kept:
                self._take(own, self.solver.kept[own.key])
        wishes = [self.question(self.sensor), self.search, self._figures, *(self._behind() if self.loads else [])]
        known = {*self.solver.kept, *self._refused}
        self.draw(self.view())
        asked = [(each, each is wishes[0]) for each in wishes if each is not None and each.key not in known]
        self.solver.ask(self.tab, asked, self._heard)

    def _behind(self) -> list[StudioQuestion]:
        """Return what may be solved while nobody waits: slopes where there are none, tables beside a slider."""
        numbers, found = self._numbers, []
        base = next((each for each in self._known() if each.slopes is not None), None)
        if base is None:
            found.append(self.question(self.sensor, numbers))
        if self.moved in numbers:
            value = numbers_of(self.sensor)[self.moved]
            start = value if base is None else base.numbers.get(self.moved, value)
            root = self.sensor if base is None else base.sensor
            found += [self.question(changed(root, [f"{self.moved}={share * start!r}"])) for share in NEIGHBOURS]
        return found

    @property
    def _numbers(self) -> tuple[str, ...]:
        """The keys by which slopes are solved."""
        given = numbers_of(self.sensor)
        return tuple(key for key in _SLOPED if isinstance(given.get(key), float))

    def _known(self) -> list[SolvedScene]:
        """Return the tables of the scenes that were seen, under these loads, with their slopes, latest first."""
        if not self.visited:
            return []
        from sits_mech.studio.previews import SolvedScene

        kept, numbers, found = self.solver.kept, self._numbers, []
        for sensor in reversed(self.visited):
            own, by = self.question(sensor).key, self.question(sensor, numbers).key
            if own in kept:
                known = self._tables.get(own)
                if known is None or known.slopes is not kept.get(by):
                    known = self._tables[own] = SolvedScene(sensor, kept[own], kept.get(by))
                found.append(known)
        self._tables = {own: known for own, known in self._tables.items() if own in kept}
        return found

    def _heard(self, question: StudioQuestion, kind: str, what: Any) -> None:
        """Hand over what the solver says in its thread; a tab that is gone hears nothing."""
        with suppress(RuntimeError):
            self.later(self._answered, question, kind, what)

    def _answered(self, question: StudioQuestion, kind: str, what: Any) -> None:
        """Take what the solver says."""
        if isinstance(question, SearchQuestion):
            self._searched(kind, what)
        elif kind == "done":
            self._take(question, what)
            (self.stop if self.stopped else self.update)()
        elif isinstance(question, Figures) and kind == "failed":
            self._refused[question.key] = f"not judged: {what}"
            self.draw(self.view())
        elif question.key == self.question(self.sensor).key and not self.stopped:
            self._advance = self._advance.with_news(kind, what, time.monotonic())
            self.draw(self.view(self._advance.words(time.monotonic())))

    def _take(self, question: StudioQuestion, what: Any) -> None:
        """Take the range of the load that a pad bears, or a scene whose table is known."""
        if isinstance(question, Borne):
            self.ends = what
        elif isinstance(question, TableQuestion) and question.sensor not in self.visited:
            self.visited.append(question.sensor)

    def _searched(self, kind: str, what: Any) -> None:
        """Take what the search says."""
        if self.search is None:
            return
        if kind == "progress":
            self.tried.append(what[2])
        elif kind == "started":
            self.tried.clear()
        elif kind == "failed":
            self.tried.append(what)
        else:
            self.found = what
        if kind in ("done", "failed"):
            self.search = None
        self.draw(self.view(f"searching: {what[0]} of at most {what[1]} designs" if kind == "progress" else ""))
