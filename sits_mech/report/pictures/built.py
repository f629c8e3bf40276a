"""Draw what readings told of a built sensor: unknowns before and after, what is left, errors of the forces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sits_mech.analysis.built.adaptation import Adaptation
from sits_mech.analysis.built.prior import SURE
from sits_mech.report.pictures.curves import COLUMN, MARKS, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure



def adaptation_figure(found: Adaptation) -> Figure:
    """Return unknowns in deviations of what was known, readings less model, errors of each force over its range."""
    prior = found.prior
    count = len(prior.setup.parameters)
    width = prior.deviations[:count]
    middle = (found.values[:count] - prior.start[:count]) / width
    place = np.arange(count)[::-1]
    with new_figure(height=0.4, columns=3, width=2.0 * COLUMN) as (figure, (known, rest, errors)):
        known.barh(place, 4.0 * np.ones(count), left=-2.0, color="0.9", height=0.8, label="known before")
        known.errorbar(middle, place, xerr=2.0 * found.deviations[:count] / width, fmt="o", markersize=3, label="found")
        known.set_yticks(place, found.names[:count])
        known.set(xlabel="deviations of what was known", title="unknowns, 95 %")
        known.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2))
        rows = np.arange(1, len(found.residual) + 1)
        for k, coil in enumerate(prior.sensor.coil_names):
            mark, colour = MARKS[k % len(MARKS)], f"C{k % 7}"
            rest.semilogy(rows, 1e9 * np.abs(found.before[:, k]), mark, color=colour, markerfacecolor="none",
                          label=f"{coil}, before")
            rest.semilogy(rows, 1e9 * np.maximum(np.abs(found.residual[:, k]), 1e-15), mark, color=colour,
                          label=f"{coil}, adapted")
        rest.axhline(1e9 * float(np.hypot(prior.noise, prior.model).max()), color="black", linewidth=0.5)
        rest.set(xlabel="row of the bench file", ylabel="off [nH]", title="readings and model")
        rest.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2)
        _errors(found, errors)
    return figure


def _errors(found: Adaptation, axes: object) -> None:
    """Draw the errors of each force before and after, along it."""
    prior = found.prior
    for k, name in enumerate(prior.forces):
        ends = prior.table.map.low[k], prior.table.map.high[k]
        loads = np.tile(np.clip(np.zeros(len(prior.forces)), prior.table.map.low, prior.table.map.high), (9, 1))
        loads[:, k] = np.linspace(*ends, 9)
        before, after = found.force_deviations(loads)
        share = (loads[:, k] - ends[0]) / (ends[1] - ends[0])
        for style, each in (("--", before), ("-", after)):
            axes.semilogy(  # type: ignore[attr-defined]
                share, 100.0 * SURE * each[:, k] / (ends[1] - ends[0]), style, color=f"C{k}",
                label=f"{name}, {'before' if style == '--' else 'adapted'}",
            )
    axes.set(xlabel="from least to greatest of the table", ylabel="error [% of range]",  # type: ignore[attr-defined]
             title="forces, 90 %")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2)  # type: ignore[attr-defined]
