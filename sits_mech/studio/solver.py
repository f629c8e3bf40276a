"""Solve tables in one process beside the page's: the latest question of each tab first, never one twice.

A question is a scene, its loads and models; its answers are a table (`calibrate`) and, where asked for, derivatives by
numbers of the scene (`gradient_on_grid`). What is no longer wanted is stopped: at its next load, or with its process,
which is started anew. Answers are kept while the studio runs, the last `_KEPT` of them.
"""

from __future__ import annotations

import multiprocessing
import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from sits_mech.scene.sensor import Sensor, scene_hash

SHEAR, NORMAL = 1.0, 4.0
"""Largest forces that are asked for where the pad bears them [N]."""
_ACROSS = 5
_KEPT = 40
_PATIENCE = 0.5  # seconds that a question has to stop by itself
_POLL = 0.05


@dataclass(frozen=True)
class Question:
    """What is to be solved: a table, or derivatives by numbers where there are any."""

    sensor: Sensor
    loads: tuple[tuple[str, tuple[float, ...]], ...]  # of none, those that the pad bears are asked for
    models: tuple[str, str, float]  # mechanical and magnetic one, tolerance of the signals
    numbers: tuple[str, ...] = ()

    @property
    def key(self) -> tuple[Any, ...]:
        """What tells it from others."""
        return scene_hash(self.sensor), self.loads, self.models, self.numbers


@dataclass
class _Wish:
    """A question of a tab, and whom to tell."""

    tab: str
    question: Question
    urgent: bool
    told: Callable[[str, Any], None]
    stopped: threading.Event = field(default_factory=threading.Event)


class _Stopped(Exception):
    """The question is no longer wanted."""


def answered(question: Question, progress: Callable[[int, int], None]) -> Any:
    """Return the table or the derivatives of a question."""
    from sits_mech.chain.calibrate import calibrate
    from sits_mech.chain.gradient_grid import gradient_on_grid

    loads, (mechanics, magnetics, tolerance) = dict(question.loads), question.models
    if not loads:
        return borne(question.sensor, mechanics)
    models: dict[str, Any] = {"mechanics": mechanics, "magnetics": magnetics, "tolerance": tolerance}
    if question.numbers:
        return gradient_on_grid(question.sensor, question.numbers, loads, **models)
    axes: dict[str, Any] = {name: list(values) for name, values in loads.items()}
    return calibrate(question.sensor, **axes, **models, progress=progress)


def borne(sensor: Sensor, mechanics: str) -> tuple[tuple[str, tuple[float, ...]], ...]:
    """Return a grid of the loads that `calibrate` takes by default, no larger than the pad bears."""
    from sits_mech.analysis.envelope import borne_share
    from sits_mech.quantities import Wrench

    along = [name for k, name in enumerate(("F_x", "F_y")) if len({coil.centre[k] for coil in sensor.coils}) > 1]
    corner = dict.fromkeys(along, SHEAR) | {"F_z": NORMAL}
    share = borne_share(sensor, Wrench(**corner), mechanics)
    return tuple((name, grid_of(name, share * most)) for name, most in corner.items())


def grid_of(name: str, most: float) -> tuple[float, ...]:
    """Return the values of a force up to its largest: shear to both sides."""
    return tuple(np.linspace(0.0 if name == "F_z" else -most, most, _ACROSS).tolist())


def work(pipe: Connection, stop: Any) -> None:
    """Answer questions of a pipe until it ends: ("done", answer), ("failed", why), ("stopped", None)."""
    from sits_mech.quantities import SolveFailed

    def progress(done: int, count: int) -> None:
        """Say how far it is; end what is no longer wanted."""
        if stop.is_set():
            raise _Stopped
        pipe.send(("progress", (done, count)))

    with suppress(EOFError, KeyboardInterrupt, BrokenPipeError):
        while True:
            question = pipe.recv()
            try:
                pipe.send(("done", answered(question, progress)))
            except _Stopped:
                pipe.send(("stopped", None))
            except (ValueError, ArithmeticError, MemoryError, OSError, SolveFailed) as error:
                pipe.send(("failed", " ".join(str(error).split())))


class Solver:
    """One process that solves, and the questions that wait for it."""

    def __init__(self) -> None:
        self.kept: OrderedDict[tuple[Any, ...], Any] = OrderedDict()
        self._wishes: list[_Wish] = []
        self._changed = threading.Condition()
        self._ended = False
        self._process: Any = None
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def ask(
        self, tab: str, questions: Sequence[tuple[Question, bool]], told: Callable[[Question, str, Any], None]
    ) -> None:
        """Replace what a tab wants: questions in their order, those that are urgent before others' that are not.

        `told` is called, in a thread of its own, with "started", "progress", "done", "failed" and what there is to say.
        """
        with self._changed:
            wanted = {question.key for question, _ in questions}
            for wish in self._wishes:
                if wish.tab == tab and wish.question.key not in wanted:
                    wish.stopped.set()
            self._wishes = [wish for wish in self._wishes if wish.tab != tab or wish.question.key in wanted]
            there = {wish.question.key for wish in self._wishes if wish.tab == tab}
            self._wishes += [
                _Wish(tab, question, urgent, partial(told, question)) for question, urgent in questions
                if question.key not in there
            ]
            if any(urgent for _, urgent in questions):  # what nobody waits for makes room
                for wish in self._wishes:
                    if not wish.urgent:
                        wish.stopped.set()
            self._changed.notify_all()

    def close(self) -> None:
        """End the process."""
        with self._changed:
            self._ended = True
            for wish in self._wishes:
                wish.stopped.set()
            self._changed.notify_all()
        self._thread.join(10.0)
        self._end()

    def _serve(self) -> None:
        """Answer wishes, one after the other."""
        while True:
            with self._changed:
                while not self._wishes and not self._ended:
                    self._changed.wait()
                if self._ended:
                    return
                wish = min(self._wishes, key=lambda each: not each.urgent)
                wish.stopped.clear()
            kind, what = self._answer(wish)
            with self._changed:
                if kind == "stopped":  # once more, after what made it stop, for those who still want it
                    self._wishes.sort(key=lambda each: each.question.key == wish.question.key)
                    continue
                others = [each for each in self._wishes if each.question.key == wish.question.key]
                self._wishes = [each for each in self._wishes if each.question.key != wish.question.key]
            for each in others:
                each.told(kind, what)

    def _answer(self, wish: _Wish) -> tuple[str, Any]:
        """Return "done", "failed" or "stopped" and what came."""
        key = wish.question.key
        if key in self.kept:
            self.kept.move_to_end(key)
            return "done", self.kept[key]
        wish.told("started", None)
        pipe, stop = self._started()
        stop.clear()
        try:
            pipe.send(wish.question)
            patience = _PATIENCE
            while True:
                if wish.stopped.is_set():
                    stop.set()
                    patience -= _POLL
                if pipe.poll(_POLL):
                    kind, what = pipe.recv()
                    if kind != "progress":
                        break
                    wish.told(kind, what)
                elif patience < 0.0:
                    self._end()
                    return "stopped", None
        except (EOFError, OSError):  # it was killed from outside
            self._end()
            return "failed", "the solving process ended: ask again"
        if kind == "done":
            self.kept[key] = what
            while len(self.kept) > _KEPT:
                self.kept.popitem(last=False)
        return kind, what

    def _started(self) -> tuple[Connection, Any]:
        """Return the process's pipe and what stops it; started where there is none."""
        if self._process is None or not self._process[0].is_alive():
            context = multiprocessing.get_context("spawn")
            ours, theirs = context.Pipe()
            stop = context.Event()
            process = context.Process(target=work, args=(theirs, stop), daemon=True)
            process.start()
            theirs.close()
            self._process = process, ours, stop
        return self._process[1], self._process[2]

    def _end(self) -> None:
        """End the process, if there is one."""
        if self._process is not None:
            self._process[0].kill()
            self._process[0].join()
            self._process[1].close()
            self._process = None
