"""How much error for how much time? Points of any models on logarithmic axes, the estimated error beside the true one.

Drawn with matplotlib through `curves`, which alone imports it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from sits_mech.report.curves import new_figure, save_figure


@dataclass(frozen=True)
class Rung:
    """One solve of a ladder.

    Attributes
    ----------
    model, label : str
        The curve it belongs to, and what distinguishes it there.
    seconds : float
        Wall time.
    error, estimated : float
        Relative error against the reference, and what the solve itself said.
    """

    model: str
    label: str
    seconds: float
    error: float
    estimated: float


def draw_ladders(rungs: Sequence[Rung], path: Path) -> None:
    """Write error against seconds as a picture: full marks the true error, hollow ones the estimate.

    Parameters
    ----------
    rungs : sequence of Rung
        One curve for each model, in the order given.
    path : Path
        The PNG to write.
    """
    with new_figure(height=1.0) as (figure, (axes,)):
        for number, model in enumerate(dict.fromkeys(rung.model for rung in rungs)):
            own = [rung for rung in rungs if rung.model == model]
            seconds = [rung.seconds for rung in own]
            axes.plot(seconds, [rung.error for rung in own], f"C{number}o-", label=model)
            axes.plot(seconds, [rung.estimated for rung in own], f"C{number}o:", mfc="none", lw=0.6)
        axes.set(xscale="log", yscale="log", xlabel="wall time of one solve [s]", ylabel="relative error [-]")
        figure.legend(loc="outside lower center", ncols=2, title="full: true error, hollow: estimated")
        save_figure(figure, path)


def markdown(rungs: Sequence[Rung]) -> str:
    """Return the rungs as a Markdown table."""
    lines = ["| model | rung | seconds | true error | estimated |", "|---|---|---|---|---|"]
    row = "| {0.model} | {0.label} | {0.seconds:.3g} | {0.error:.2e} | {0.estimated:.2e} |"
    return "\n".join([*lines, *(row.format(rung) for rung in rungs)]) + "\n"
