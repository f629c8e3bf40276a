"""How much error for how much time? Points of one question on logarithmic axes, each with the tolerance it was asked.

Full points are those that their reference can judge: it is five times better. Drawn with matplotlib through `curves`,
which alone imports it.
"""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from common.references import FINER
from threadpoolctl import threadpool_info

from sits_mech.analysis.ladder import LadderPoint
from sits_mech.analysis.ladder import forget as forget
from sits_mech.mechanics.models import strain_bound
from sits_mech.quantities import Wrench
from sits_mech.report.ladder import ladder_sentence
from sits_mech.report.pictures.style import COLUMN, MARKS, new_figure, save_figure
from sits_mech.scene.sensor import Sensor

if TYPE_CHECKING:
    from matplotlib.axes import Axes

End = tuple[str, str, float, float]
"""Of a curve: its name, its colour, seconds and error of its last point."""
_LEAST = 1e-12  # an error of zero on a logarithmic axis
_WIDE, _HIGH, _LETTER = 110.0, 10.0, 4.2  # a name of 8 point takes, and a letter of it [pt]
_CLEAR, _FAR = 6.5, 60  # how far a name stands from a mark at least, and from its own at most [pt]
_DECADE = 10.0  # of seconds, what a panel shows at least


def first_strain(sensor: Sensor, load: Wrench) -> float:
    """Return what a load is bounded to strain a layer to first order: a thousand times what a thousandth of it does."""
    return 1e3 * strain_bound(sensor, [Wrench(*(1e-3 * load.components))])


@dataclass(frozen=True)
class Rung:
    """One solve of a ladder.

    Attributes
    ----------
    model : str
        The curve it belongs to: a problem and what solves it.
    tolerance : float
        Asked.
    seconds : float
        Processor time.
    error, estimated : float
        Relative error against the reference, not a number where none is finer; what the solve itself said. Both
        infinite where there is no answer.
    resolved : float
        Error of the reference itself: where `error` is below five times that, it does not judge.
    """

    model: str
    tolerance: float
    seconds: float
    error: float
    estimated: float
    resolved: float = 0.0

    @property
    def judged(self) -> bool:
        """Whether the reference is five times better than the point."""
        return math.isfinite(self.error) and FINER * self.resolved <= self.error

    @property
    def honest(self) -> bool:
        """Whether the estimate brackets the true error within a factor of five, as far as the reference can tell."""
        highest, lowest = self.error + self.resolved, max(self.error - self.resolved, 0.0)
        return lowest / 5.0 <= self.estimated <= 5.0 * highest


def curves_of(rungs: Sequence[Rung]) -> dict[str, list[Rung]]:
    """Return the rungs of each curve, in the order given."""
    return {name: [one for one in rungs if one.model == name] for name in dict.fromkeys(one.model for one in rungs)}


def said(rungs: Sequence[Rung]) -> str:
    """Return what a user wants of one figure: what asking costs, what cannot be reached, how judged estimates did."""
    curves = curves_of(rungs).values()
    rows = [[LadderPoint(one.tolerance, one.estimated, one.seconds) for one in row] for row in curves]
    points = [one for row in curves for one in distinct(row)]
    judged = [one for one in points if one.judged]
    held = sum(one.honest for one in judged)
    shares = f"{held} of {len(judged)} judged points, of {len(points)}"
    return f"{ladder_sentence(rows)}. Estimates within a factor of 5: {shares}."


def distinct(row: Sequence[Rung]) -> list[Rung]:
    """Return the points of a curve: tolerances with one and the same answer are one, of the least seconds."""
    found: list[Rung] = []
    for one in row:
        if found and (one.error, one.estimated) == (found[-1].error, found[-1].estimated):
            found[-1] = replace(found[-1], seconds=min(one.seconds, found[-1].seconds))
        else:
            found.append(one)
    return found


def draw_ladders(panels: Mapping[str, Sequence[Rung]], path: Path) -> None:
    """Write error against seconds, a panel a question.

    A point is the true error, hollow where its reference is not five times better, absent where it is worse; a bar goes
    from there to the estimate.

    Parameters
    ----------
    panels : mapping
        Rungs by the question that they answer; in each one curve for each problem and model, in the order given.
    path : Path
        The PNG to write.
    """
    with new_figure(height=0.4 * len(panels), rows=len(panels), width=2.0 * COLUMN) as (figure, axes):
        ends = [_draw(spot, title, rungs) for spot, (title, rungs) in zip(axes, panels.items(), strict=True)]
        axes[-1].set_xlabel("processor time [s]")
        figure.suptitle("marks: true error, hollow by a reference less than five times better; bars: to the estimate")
        figure.canvas.draw()
        for spot, own in zip(axes, ends, strict=True):
            label_ends(spot, own)
        save_figure(figure, path)


def _draw(axes: Axes, title: str, rungs: Sequence[Rung]) -> list[End]:
    """Draw one question and return where its curves end."""
    ends = list[End]()
    for number, (model, row) in enumerate(curves_of(rungs).items()):
        colour, mark = f"C{number % 7}", MARKS[number % len(MARKS)]
        points = [one for one in distinct(row) if one.resolved <= one.error < math.inf]
        if not points:
            continue
        errors = [max(one.error, _LEAST) for one in points]
        axes.plot([one.seconds for one in points], errors, color=colour, lw=1.0)
        for one, error in zip(points, errors, strict=True):
            axes.plot(one.seconds, error, mark, color=colour, ms=5, mfc=colour if one.judged else "white")
            axes.plot([one.seconds] * 2, [error, max(one.estimated, _LEAST)], color=colour, lw=2.5, alpha=0.25)
        last = int(np.argmax([one.seconds for one in points]))
        ends.append((model, colour, points[last].seconds, errors[last]))
    axes.set(xscale="log", yscale="log", ylabel="relative error [-]")
    axes.set_title(title, fontsize=9)
    axes.margins(x=0.05, y=0.2)
    left, right = axes.get_xlim()
    spread = max(1.0, _DECADE * left / right) ** 0.5  # a decade at least
    axes.set_xlim(left / spread, spread * right * (spread**2 * right / left) ** 0.5)
    return ends


def label_ends(axes: Axes, ends: Sequence[End]) -> None:
    """Write the name of each curve at its end, clear of names and marks that stand there; the figure has been drawn."""
    dots, taken = axes.figure.dpi, list[tuple[float, float]]()
    marked = [line.get_xydata() for line in axes.lines if line.get_marker() not in ("", "None", None)]
    marks = axes.transData.transform(np.vstack(marked)) * 72.0 / dots if marked else np.zeros((0, 2))
    for words, colour, seconds, error in sorted(ends, key=lambda end: -end[3]):
        x, y = axes.transData.transform((seconds, error)) * 72.0 / dots
        along = marks[(marks[:, 0] > x + 4.0) & (marks[:, 0] < x + 12.0 + _LETTER * len(words)), 1]
        stand = [(at, _HIGH) for left, at in taken if abs(left - x) < _WIDE] + [(at, _CLEAR) for at in along.tolist()]
        steps = (y + sign * step for step in range(_FAR) for sign in (-1.0, 1.0))
        low = next((at for at in steps if all(abs(each - at) >= clear for each, clear in stand)), y)
        taken.append((x, low))
        axes.annotate(
            words, (seconds, error), (7.0, low - y), textcoords="offset points", color=colour, fontsize=8, va="center",
            bbox={"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.7},
        )


def rung_rows(panels: Mapping[str, Sequence[Rung]]) -> list[dict[str, object]]:
    """Return the rungs as rows of a table."""
    rows: list[dict[str, object]] = []
    for title, rungs in panels.items():
        for rung in rungs:
            row: dict[str, object] = {"question": title, "model": rung.model, "asked": rung.tolerance}
            row |= {"seconds": rung.seconds, "true error": rung.error, "estimated": rung.estimated}
            honest = ("yes" if rung.honest else "no") if rung.judged else ""
            row |= {"error of reference": rung.resolved, "judged": "yes" if rung.judged else "no"}
            rows.append(row | {"within 5": honest})
    return rows


def machine() -> str:
    """Return the kind of processor, its cores, and the threads that linear algebra may use, for a table's caption."""
    threads = max((library["num_threads"] for library in threadpool_info()), default=1)
    return f"{_processor()}, {os.cpu_count()} cores, {threads} BLAS thread{'s' * (threads != 1)}"


def _processor() -> str:
    """Return the name of the processor as far as the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
