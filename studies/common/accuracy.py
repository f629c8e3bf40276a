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
from textwrap import fill
from typing import Any

from common.references import FINER
from threadpoolctl import threadpool_info

from sits_mech.analysis.ladder import Asked
from sits_mech.analysis.ladder import forget as forget
from sits_mech.mechanics.models import strain_bound
from sits_mech.quantities import Wrench
from sits_mech.report.ladder import power, sentence
from sits_mech.report.pictures.style import COLUMN, MARKS, new_figure, save_figure
from sits_mech.scene.sensor import Sensor

_LEAST = 1e-12  # an error of zero on a logarithmic axis


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
    rows = [[Asked(one.tolerance, one.estimated, one.seconds) for one in row] for row in curves]
    points = [one for row in curves for _, one in merged(row)]
    judged = [one for one in points if one.judged]
    held = sum(one.honest for one in judged)
    return f"{sentence(rows)}. Estimates within a factor of 5: {held} of {len(judged)} judged points, of {len(points)}."


def merged(row: Sequence[Rung]) -> list[tuple[str, Rung]]:
    """Return the points of a curve with their labels: tolerances with one and the same answer are one point."""
    found: list[tuple[list[float], Rung]] = []
    for one in row:
        if found and (one.error, one.estimated) == (found[-1][1].error, found[-1][1].estimated):
            least = min(one.seconds, found[-1][1].seconds)
            found[-1] = ([*found[-1][0], one.tolerance], replace(one, seconds=least))
        else:
            found.append(([one.tolerance], one))
    return [(" to ".join(dict.fromkeys((power(asked[0]), power(asked[-1])))), one) for asked, one in found]


def draw_ladders(panels: Mapping[str, Sequence[Rung]], path: Path) -> None:
    """Write error against seconds, a figure a question, with the sentence that its points come to below it.

    A point is the true error, hollow where its reference cannot judge it; a bar goes from there to the estimate.

    Parameters
    ----------
    panels : mapping
        Rungs by the question that they answer; in each one curve for each problem and model, in the order given.
    path : Path
        The PNG to write.
    """
    columns = min(2, len(panels))
    rows = -(-len(panels) // columns)
    with new_figure(height=0.9 * rows / columns, columns=columns, rows=rows, width=1.15 * columns * COLUMN) as (
        figure,
        axes,
    ):
        for spot, (title, rungs) in zip(axes, panels.items(), strict=False):
            _draw(spot, title, rungs)
        for spot in axes[len(panels) :]:
            spot.set_axis_off()
            words = (
                "point: true error, labelled with what was asked",
                "hollow: the reference is not five times better,\nnot counted",
                "thin line: from the true error to the\nestimated one (dash)",
            )
            spot.text(0.1, 0.9, "\n\n".join(words), va="top", fontsize=9, transform=spot.transAxes)
        save_figure(figure, path)


def _draw(axes: Any, title: str, rungs: Sequence[Rung]) -> None:
    """Draw one question."""
    for number, (model, row) in enumerate(curves_of(rungs).items()):
        colour, mark = f"C{number % 7}", MARKS[number % len(MARKS)]
        points = [(label, one) for label, one in merged(row) if math.isfinite(one.error)]
        seconds = [one.seconds for _, one in points]
        errors = [max(one.error, _LEAST) for _, one in points]
        axes.plot(seconds, errors, f"{colour}-", lw=0.8)
        axes.plot([], [], f"{colour}{mark}-", lw=0.8, ms=4.5, label=model)
        for (label, one), error in zip(points, errors, strict=True):
            axes.plot(one.seconds, error, f"{colour}{mark}", ms=4.5, mfc=colour if one.judged else "white")
            axes.plot([one.seconds] * 2, [error, max(one.estimated, _LEAST)], f"{colour}:", lw=0.6)
            axes.plot(one.seconds, max(one.estimated, _LEAST), f"{colour}_", ms=5)
            axes.annotate(label, (one.seconds, error), (3, 3), textcoords="offset points", fontsize=5.5, color=colour)
    axes.set(xscale="log", yscale="log", ylabel="relative error [-]")
    axes.margins(x=0.12)
    axes.xaxis.set_minor_formatter("")
    axes.set_title(title, fontsize=9)
    words = said(rungs).replace(" s", "\N{NO-BREAK SPACE}s").replace(" of ", "\N{NO-BREAK SPACE}of\N{NO-BREAK SPACE}")
    axes.set_xlabel("processor time [s]\n" + fill(words, 84), fontsize=5.5)
    axes.legend(loc="best", fontsize=6, handlelength=1.2, framealpha=0.6)


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
