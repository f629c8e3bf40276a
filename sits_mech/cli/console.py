"""Print answers on stdout, for a program or a reader; progress and warnings on stderr."""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

from sits_mech.status import EXIT_DOUBTFUL, EXIT_NO_ANSWER, counted, exit_code

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure

    from sits_mech.cases import Progress
    from sits_mech.quantities import SolveFailed, Wrench
    from sits_mech.scene.sensor import Sensor

QUIET = ContextVar("QUIET", default=False)
"""Whether notes and progress stay away; answers and errors are printed."""
_ROOT = "sits_mech"  # of all loggers
_EVERY = 2.0  # seconds between lines on how far a load is
_LONG = 10.0  # seconds that a step is to take from which on it is printed before: as long as one waits without a sign


def not_converged(error: SolveFailed, as_json: bool, *, whole: bool) -> int:
    """Print what was reached, of a `whole` chain or of one solve, and say that it is not the answer."""
    from sits_mech.report.records import failure_record
    from sits_mech.report.tables.solves import equilibrium_table

    title = "last converged state" if error.half == "mechanics" else "pose of the target"
    tables = [] if error.last is None else [equilibrium_table(error.last, title)]
    answer(failure_record(error, whole), tables, as_json)
    print_fault(f"not converged ({error.report.status}): {error}")
    return EXIT_NO_ANSWER


def exit_code_of(statuses: Sequence[str], accept: bool, reached: tuple[float, float] | None = None) -> int:
    """Return the exit code of answers, and say on stderr where they are no good without a look.

    `reached` are the largest error of signals and the tolerance, over their full scale.
    """
    code = exit_code(statuses, accept)
    if code == EXIT_DOUBTFUL:
        error, asked = reached or (0.0, 0.0)
        words = f"; error {100.0 * error:.2g} % of the signals' full scale, {100.0 * asked:.2g} % asked"
        more = words if error > asked else ""
        warn(f"status: {counted(statuses)}{more}; exit code {code}, --accept makes it 0")
    return code


def answer(record: dict[str, Any], tables: Sequence[Any], as_json: bool) -> None:
    """Print an answer, for a program or for a reader."""
    if as_json:
        from sits_mech.report.records import json_text

        sys.stdout.write(json_text(record) + "\n")
        return
    for table in tables:
        print_table(table)


def print_table(table: Any) -> None:
    """Print a table on stdout, or text as it is; where it is no terminal nothing is cut, numbers stay on one line."""
    from rich.console import Console

    if isinstance(table, str):
        write(f"{table}\n\n")
        return
    width = None if sys.stdout.isatty() else max(160, Console(width=1000, markup=False).measure(table).maximum)
    console = Console(width=width, markup=False, highlight=False)
    console.print(table)
    console.print()


def terminal_width() -> int | None:
    """Return how many characters a line of the terminal has; None where stdout is none."""
    from rich.console import Console

    return Console().width if sys.stdout.isatty() else None


def write(text: str) -> None:
    """Print a file's text on stdout as it is."""
    sys.stdout.write(text)


def deliver(text: str, output: Path | None) -> None:
    """Print a file's text on stdout, or write it where it is asked for and say so."""
    from sits_mech.scene.files import write_text

    if output is None:
        write(text)
    else:
        write_text(output, text)
        warn(f"written to {output}")


def deliver_picture(path: Path | None, draw: Callable[[], Figure]) -> None:
    """Draw a figure into a file where one is asked for, and say so."""
    from sits_mech.report.pictures.style import save_figure

    if path is not None:
        save_figure(draw(), path)
        warn(f"written to {path}")


def kept_promise(planned: tuple[float, float], took: tuple[float, float], whole: float = 0.0) -> str:
    """Return what was planned and what became of it, seconds of processor time and error over full scale, in words.

    With the `whole` error, which holds what is left out, where it is larger.
    """
    errors = [f"{100.0 * error:.2g} %" for error in (planned[1], took[1], max(took[1], whole))]
    more = f", {errors[2]} with what is left out" if errors[2] != errors[1] else ""
    first, last = f"{planned[0]:.2g} s, error {errors[0]}", f"{took[0]:.2g} s, error {errors[1]}"
    return f"planned: {first} of the signals' full scale; reached: {last}{more}"


def warn(*lines: str) -> None:
    """Print notes on stderr, unless they are not wanted."""
    if not QUIET.get():
        print_fault(*lines)


def print_fault(*lines: str) -> None:
    """Print on stderr why there is no answer."""
    sys.stderr.writelines(f"{line}\n" for line in lines)


def print_written(paths: Sequence[Path], as_json: bool, notes: Sequence[str] = (), **figures: Any) -> None:
    """Answer what was written, with figures of it: a record for a program, notes on stderr for a reader."""
    warn(*notes, *(f"written to {path}" for path in paths))
    if as_json:
        answer({"written": [str(path) for path in paths], "notes": list(notes), **figures}, [], True)


@contextmanager
def progress_bar(what: str) -> Iterator[Progress]:
    """Yield a callable that moves a bar on stderr; where that is no terminal it writes a line now and again."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    console, begun = Console(stderr=True, quiet=QUIET.get()), time.monotonic()
    last = begun
    with Progress(*columns, console=console) as bar:
        task = bar.add_task(what, total=None)

        def moved(done: int, total: int) -> None:
            nonlocal last
            bar.update(task, completed=done, total=total)
            now = time.monotonic()
            if not console.is_terminal and now - last > max(_EVERY, 0.1 * (now - begun)):
                last = now
                warn(f"  {what}: {done} of {total}")

        yield moved


@contextmanager
def solving(
    sensor: Sensor, loads: Sequence[Wrench], tolerance: float, mechanics: str = "auto", magnetics: str | None = "auto"
) -> Iterator[None]:
    """Say on stderr what a load, the last of a path, is to take before it is solved; then, now and again, where it is.

    `magnetics` None: the target's pose alone is asked for.
    """
    from sits_mech.chain.plans.plan import planned_seconds
    from sits_mech.report.tables.plan import taken_words

    warn(taken_words(*planned_seconds(sensor, loads, tolerance=tolerance, mechanics=mechanics, magnetics=magnetics)))
    with announcing():
        yield


@contextmanager
def announcing() -> Iterator[None]:
    """Say on stderr now and again what is solved, and steps that take long before they begin."""
    if any(isinstance(each, _Teller) for each in logging.getLogger(_ROOT).handlers):
        yield
        return
    with _handled(_Teller(_EVERY)):
        yield


@contextmanager
def logged(verbose: bool, path: str | None) -> Iterator[None]:
    """Print what is solved, step by step, on stderr, and write it to a file with the time of each."""
    each: list[logging.Handler] = [_Teller(0.0)] if verbose else []
    if path is not None:
        each.append(file := logging.FileHandler(path, mode="w", encoding="utf-8"))
        file.setFormatter(logging.Formatter("%(asctime)s %(name)s: %(message)s"))
    with _handled(*each):
        yield


@contextmanager
def _handled(*handlers: logging.Handler) -> Iterator[None]:
    """Let handlers have what the package logs."""
    log = logging.getLogger(_ROOT)
    before = log.level
    for each in handlers:
        log.addHandler(each)
    if handlers:
        log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.setLevel(before)
        for each in handlers:
            log.removeHandler(each)
            each.close()


class _Teller(logging.Handler):
    """Print what solvers say, a line in some seconds at most."""

    def __init__(self, every: float) -> None:
        super().__init__()
        self._every, self._last = every, time.monotonic()

    def emit(self, record: logging.LogRecord) -> None:
        """Print a line, unless the last one was a moment ago and the step it announces is short."""
        now, long = time.monotonic(), getattr(record, "seconds", 0.0) > _LONG
        if long or now - self._last >= self._every:
            self._last = now
            warn(f"  {record.getMessage()}")
