"""How much error for how much time? Points of any models on logarithmic axes, the estimated error beside the true one.

Drawn with matplotlib through `curves`, which alone imports it.
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from threadpoolctl import threadpool_info

from sits_mech.report.pictures.curves import new_figure, save_figure

_LEAST = 1e-12  # an error of zero on a logarithmic axis


@dataclass(frozen=True)
class Rung:
    """One solve of a ladder.

    Attributes
    ----------
    model, label : str
        The curve it belongs to, and what distinguishes it there.
    seconds : float
        Processor time.
    error, estimated : float
        Relative error against the reference, and what the solve itself said.
    resolved : float
        Error of the reference itself: where `error` is below it, only that much is known.
    """

    model: str
    label: str
    seconds: float
    error: float
    estimated: float
    resolved: float = 0.0

    @property
    def honest(self) -> bool:
        """Whether the estimate brackets the true error within a factor of five, as far as the reference can tell."""
        highest, lowest = self.error + self.resolved, max(self.error - self.resolved, 0.0)
        return lowest / 5.0 <= self.estimated <= 5.0 * highest


def pareto_front(rungs: Sequence[Rung]) -> list[Rung]:
    """Return the rungs that no other one beats in both time and error, in the order of their times."""
    front: list[Rung] = []
    for rung in sorted(rungs, key=lambda rung: (rung.seconds, rung.error)):
        if not front or rung.error < front[-1].error:
            front.append(rung)
    return front


def draw_ladders(panels: Mapping[str, Sequence[Rung]], path: Path) -> None:
    """Write error against seconds: full marks the true error, hollow ones the estimate, a grey line the Pareto front.

    A bar upwards from a true error: the error of the reference, below which no more is known.

    Parameters
    ----------
    panels : mapping
        Rungs by the title of their panel; in each one curve for each model, in the order given.
    path : Path
        The PNG to write.
    """
    with new_figure(height=0.8 * len(panels), rows=len(panels)) as (figure, axes):
        for spot, (title, rungs) in zip(axes, panels.items(), strict=True):
            front = pareto_front(rungs)
            seconds, errors = [rung.seconds for rung in front], [max(rung.error, _LEAST) for rung in front]
            spot.step(seconds, errors, "0.8", where="post", lw=3)
            for number, model in enumerate(dict.fromkeys(rung.model for rung in rungs)):
                own = [rung for rung in rungs if rung.model == model]
                seconds = [rung.seconds for rung in own]
                errors = [max(rung.error, _LEAST) for rung in own]
                spot.plot(seconds, errors, f"C{number}o-", label=model)
                spread = [rung.resolved for rung in own]
                spot.errorbar(seconds, errors, ([0.0] * len(own), spread), fmt="none", ecolor=f"C{number}", lw=0.6)
                spot.plot(seconds, [rung.estimated for rung in own], f"C{number}o:", mfc="none", lw=0.6)
            spot.set(xscale="log", yscale="log", ylabel="relative error [-]")
            spot.set_title(title, fontsize=8)
            spot.set_xlabel("processor time [s]")
            spot.legend(loc="upper center", bbox_to_anchor=(0.5, -0.24), ncols=3, fontsize=5.5, handlelength=1.5)
        figure.suptitle("full: true error, bar: its reference's own, hollow: estimated, grey: Pareto front", fontsize=6)
        save_figure(figure, path)


def rung_rows(panels: Mapping[str, Sequence[Rung]]) -> list[dict[str, object]]:
    """Return the rungs as rows of a table, each with whether it is on its panel's Pareto front."""
    rows: list[dict[str, object]] = []
    for title, rungs in panels.items():
        front = pareto_front(rungs)
        for rung in rungs:
            row: dict[str, object] = {"part": title, "model": rung.model, "rung": rung.label, "seconds": rung.seconds}
            row |= {"true error": rung.error, "estimated": rung.estimated, "error of reference": rung.resolved}
            rows.append(row | {"within 5": "yes" if rung.honest else "no", "front": "yes" if rung in front else ""})
    return rows


def forget() -> None:
    """Empty all caches of the package, so that a solve pays for everything."""
    for name, module in list(sys.modules.items()):
        if name.startswith("sits_mech."):
            for item in vars(module).values():
                if hasattr(item, "cache_clear"):
                    item.cache_clear()


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
