"""Solve tables in one process beside the page's: the latest question of each tab first, never one twice.

What is no longer wanted is interrupted, or stopped with its process, which is started anew. Answers are kept while the
studio runs, the last `_KEPT` of them.
"""

from __future__ import annotations

import logging
import multiprocessing
import threading
import time
from _thread import interrupt_main
from collections import OrderedDict
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from sits_mech.memory import give_back
from sits_mech.studio.questions import StudioQuestion

_KEPT = 40  # answers in memory, at most
_PATIENCE = 3.0  # seconds that an answer has to be interrupted: no factor of the catalogue's pads takes half of it
_LINE_EVERY = 0.5  # seconds between two lines of what is solved
_POLL = 0.05  # seconds between two looks at the solving process


@dataclass(frozen=True)
class Advance:
    """How far a table is: when it began [s], loads that are done and all, the last step; why there is none."""

    began: float
    loads: Sequence[Any] = (0, 0)
    step: str = ""
    why: str = ""

    def with_news(self, kind: str, what: Any, now: float) -> Advance:
        """Return how far it is after "started", "progress", a "step", or when it has "failed"."""
        match kind:
            case "progress":
                return replace(self, loads=what)
            case "step":
                return replace(self, step=str(what[0]))
            case "failed":
                return replace(self, why=f"not solved: {what}")
        return Advance(now)

    def words(self, now: float) -> str:
        """Return what is solved, and the time left by that of the loads before."""
        if self.why:
            return self.why
        done, count, *_ = self.loads
        left = f", about {(now - self.began) * (count - done) / done:.0f} s left" if 0 < done < count else ""
        return f"solving{f': {done} of {count} loads' if count else ''}{left}{f'; {self.step}' if self.step else ''}"


@dataclass
class _Wish:
    """A question of a tab, and whom to tell."""

    tab: str
    question: StudioQuestion
    urgent: bool
    send: Callable[[str, Any], None]
    stopped: threading.Event = field(default_factory=threading.Event)


def work(pipe: Connection, stops: Connection) -> None:
    """Answer numbered questions of a pipe until it ends: ("done", answer), ("failed", why), ("stopped", None).

    Before that ("progress", done and all) and ("step", a line of what is solved). A number that comes by `stops`
    interrupts its answer, where the answering thread runs Python again.
    """
    from sits_mech.chain.calibrate import calibrate  # noqa: F401  nothing interrupts what imports
    from sits_mech.chain.derivatives.gradient_grid import gradient_on_grid  # noqa: F401
    from sits_mech.quantities import SolveFailed
    from sits_mech.synthesis.run import design  # noqa: F401

    lock, now, dropped = threading.Lock(), [0], [0]  # numbers of what is answered, and of what is wanted no more

    def follow() -> None:
        """Interrupt an answer that is no longer wanted."""
        with suppress(EOFError, OSError):
            while True:
                number = stops.recv()
                with lock:
                    dropped[0] = number
                    if now[0] == number:
                        now[0] = 0
                        interrupt_main()

    def send(*how_far: Any, kind: str = "progress") -> None:
        """Say how far it is."""
        with lock:
            pipe.send((kind, how_far))

    log = logging.getLogger("sits_mech")
    log.setLevel(logging.INFO)
    log.addHandler(_Sender(partial(send, kind="step")))
    threading.Thread(target=follow, daemon=True).start()
    with suppress(EOFError, BrokenPipeError, KeyboardInterrupt):
        while True:
            number, question = pipe.recv()
            try:
                with lock:
                    if dropped[0] == number:  # before it was begun
                        raise KeyboardInterrupt
                    now[0] = number
                found: tuple[str, Any] = "done", question.answer(send)
            except (ValueError, ArithmeticError, MemoryError, OSError, SolveFailed) as error:
                found = "failed", " ".join(str(error).split())
            except KeyboardInterrupt:
                found = "stopped", None
            try:
                with lock:
                    now[0] = 0  # from here on nothing interrupts
            except KeyboardInterrupt:
                found = "stopped", None
            pipe.send(found)
            del found
            give_back()


class _Sender(logging.Handler):
    """Send what solvers log, a line in `_LINE_EVERY` seconds at most."""

    def __init__(self, send: Callable[[str], None]) -> None:
        super().__init__()
        self._send, self._next = send, 0.0

    def emit(self, record: logging.LogRecord) -> None:
        """Send a line, unless the last one was a moment ago."""
        if (now := time.monotonic()) >= self._next:
            self._next = now + _LINE_EVERY
            self._send(record.getMessage())


class SolverProcess:
    """One process that solves, and the questions that wait for it."""

    def __init__(self) -> None:
        self.kept: OrderedDict[tuple[Any, ...], Any] = OrderedDict()
        self._wishes: list[_Wish] = []
        self._changed = threading.Condition()
        self._ended = False
        self._folder = TemporaryDirectory(prefix="sits-mech-")
        self.folder = Path(self._folder.name)
        """Where searches keep what they solved, while this is open."""
        self._process: Any = None
        self._number = 0  # of the question
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def ask(
        self, tab: str, questions: Sequence[tuple[StudioQuestion, bool]],
        send: Callable[[StudioQuestion, str, Any], None]
    ) -> None:
        """Replace what a tab wants: questions in their order, those that are urgent before others' that are not.

        `send` is called, in a thread of its own, with "started", "progress", "step", "done" or "failed" and what there
        is to say.
        """
        with self._changed:
            wanted = {question.key for question, _ in questions}
            for wish in self._wishes:
                if wish.tab == tab and wish.question.key not in wanted:
                    wish.stopped.set()
            self._wishes = [wish for wish in self._wishes if wish.tab != tab or wish.question.key in wanted]
            there = {wish.question.key for wish in self._wishes if wish.tab == tab}
            self._wishes += [
                _Wish(tab, question, urgent, partial(send, question)) for question, urgent in questions
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
        self._folder.cleanup()

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
                each.send(kind, what)

    def _answer(self, wish: _Wish) -> tuple[str, Any]:
        """Return "done", "failed" or "stopped" and what came."""
        key = wish.question.key
        if key in self.kept:
            self.kept.move_to_end(key)
            return "done", self.kept[key]
        wish.send("started", None)
        try:
            kind, what = self._conversed(wish)
        except (EOFError, OSError):  # it was killed from outside
            self._end()
            return "stopped" if wish.stopped.is_set() else "failed", "the solving process ended: ask again"
        if kind == "done":
            self.kept[key] = what
            while len(self.kept) > _KEPT:
                self.kept.popitem(last=False)
        return kind, what

    def _conversed(self, wish: _Wish) -> tuple[str, Any]:
        """Put a question to the process, and return what it says last; EOFError or OSError where it ends."""
        pipe, stops = self._started()
        self._number += 1
        pipe.send((self._number, wish.question))
        asked_to_stop = 0.0
        while True:
            if wish.stopped.is_set() and not asked_to_stop:
                asked_to_stop = time.monotonic()
                stops.send(self._number)
            if pipe.poll(_POLL):
                kind, what = pipe.recv()
                if kind not in ("progress", "step"):
                    return kind, what
                wish.send(kind, what)
            elif asked_to_stop and time.monotonic() > asked_to_stop + _PATIENCE:
                self._end()
                return "stopped", None

    def _started(self) -> tuple[Connection, Connection]:
        """Return the process's pipe, and the one that stops it; started where there is none."""
        if self._process is None or not self._process[0].is_alive():
            context = multiprocessing.get_context("spawn")
            (ours, theirs), (stops, stopped) = context.Pipe(), context.Pipe()
            process = context.Process(target=work, args=(theirs, stopped), daemon=True)
            process.start()
            theirs.close()
            stopped.close()
            self._process = process, ours, stops
        return self._process[1], self._process[2]

    def _end(self) -> None:
        """End the process, if there is one."""
        if self._process is not None:
            self._process[0].kill()
            self._process[0].join()
            self._process[1].close()
            self._process[2].close()
            self._process = None
