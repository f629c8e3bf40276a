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

from common.references import FINER
from threadpoolctl import threadpool_info

from sits_mech.analysis.ladder import LadderPoint
from sits_mech.analysis.ladder import forget as forget
from sits_mech.mechanics.models import strain_bound
from sits_mech.quantities import Wrench
from sits_mech.report.pictures.style import COLUMN, MARKS, new_figure
from sits_mech.report.tables.plan import ladder_sentence
from sits_mech.scene.sensor import Sensor

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LEAST = 1e-12  # an error of zero on a logarithmic axis
_TITLE = 1e-2  # the tolerance whose seconds a title says


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


def verdict(rungs: Sequence[Rung]) -> str:
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


def ladder_figure(panels: Mapping[str, Sequence[Rung]]) -> Figure:
    """Draw error against seconds, a panel a question.

    A mark is the true error, absent where its reference is worse than that; thin bars are the reference's own error, a
    wide one goes to the estimate.

    Parameters
    ----------
    panels : mapping
        Rungs by the question that they answer; in each one curve for each problem and model, in the order given.
    """
    with new_figure(height=0.36 * len(panels) + 0.1, rows=len(panels), width=2.0 * COLUMN) as (figure, axes):
        for spot, (title, rungs) in zip(axes, panels.items(), strict=True):
            _draw(spot, title, rungs)
        hint = "marks: true error; thin bars: of the reference"
        hint += "\nwide bars: to the estimated error, none where both are alike"
        axes[-1].set_xlabel(f"processor time [s]\n{hint}")
    return figure


def _draw(axes: Axes, title: str, rungs: Sequence[Rung]) -> None:
    """Draw one question; up to two curves are named at their ends, more of them beside the axes."""
    from matplotlib.ticker import LogLocator

    curves, lowest = curves_of(rungs), list[float]()
    for number, (model, row) in enumerate(curves.items()):
        colour, mark = f"C{number % 7}", MARKS[number % len(MARKS)]
        points = [one for one in distinct(row) if one.resolved <= one.error < math.inf]
        errors = [max(one.error, _LEAST) for one in points]
        lowest += errors
        style = {"fmt": f"{mark}-", "color": colour, "lw": 1.0, "ms": 5, "elinewidth": 0.6}
        resolved = [min(one.resolved, 0.999 * error) for one, error in zip(points, errors, strict=True)]
        drawn = axes.errorbar([one.seconds for one in points], errors, resolved, **style)
        drawn.lines[0].set_label(model)
        for one, error in zip(points, errors, strict=True):
            axes.plot([one.seconds] * 2, [error, max(one.estimated, _LEAST)], color=colour, lw=2.5, alpha=0.3)
        if points and len(curves) < 3:
            place, style = (points[-1].seconds, errors[-1]), {"ha": "right", "va": "top", "color": colour}
            axes.annotate(model, place, (-8, -6), textcoords="offset points", **style)
    axes.set(xscale="log", yscale="log", ylabel="relative error [-]")
    axes.set_ylim(0.3 * min(lowest, default=1.0), None)
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter("")
    axes.set_title(f"{title}{took_words(curves)}", fontsize=9)
    if len(curves) > 2:
        name_curves(axes)


def took_words(curves: Mapping[str, Sequence[Rung]]) -> str:
    """Say what answers within the tolerance of a title took, by curve where there are two; "" where it was not asked.

    As in `verdict` an answer counts whose own estimate is within the tolerance that it was asked.
    """
    asked = {name: one for name, row in curves.items() for one in row if one.tolerance == _TITLE}
    took = {name: f"{one.seconds:.2g} s" for name, one in asked.items() if one.estimated <= _TITLE}
    if not asked:
        return ""
    if len(curves) < 3:
        missed = {name: f"not reached ({100.0 * one.estimated:.2g} %)" for name, one in asked.items()}
        words = ", ".join(f"{name} {seconds}" for name, seconds in (missed | took).items())
        return f", asked to {100.0 * _TITLE:g} %: {words}"
    seconds = sorted(asked[name].seconds for name in took)
    span = " to ".join(dict.fromkeys(f"{end:.2g}" for end in (seconds[0], seconds[-1]))) + " s" if took else "none"
    few = f" ({len(took)} of {len(asked)} reach it)" if len(took) < len(asked) else ""
    return f", asked to {100.0 * _TITLE:g} %: {span}{few}"


def name_curves(axes: Axes) -> None:
    """Name the curves to the right of the axes, in the order of the errors at which they end."""
    every = list(zip(*axes.get_legend_handles_labels(), strict=True))
    named = sorted((each for each in every if len(each[0].get_ydata())), key=lambda each: -each[0].get_ydata()[-1])
    if named:
        axes.legend(*zip(*named, strict=True), loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=8)


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
