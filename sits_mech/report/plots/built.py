"""Draw a built sensor by its readings: unknowns before and after, residuals, errors of the forces; and a lot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sits_mech.analysis.built.adaptation import Adaptation
from sits_mech.analysis.built.production import Production
from sits_mech.quantities import SURE, UNITS, Array, Integers, tensor_grid
from sits_mech.report.pictures.style import COLUMN, MARKS, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ACROSS = 9  # loads along each force of the plane
_BELOW: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.2)}  # of a legend under its axes


def adaptation_figure(found: Adaptation) -> Figure:
    """Return unknowns in deviations of what was known, readings less model, errors of forces over the plane of two."""
    several = len(found.prior.forces) > 1
    with new_figure(height=0.8 if several else 0.4, columns=3, rows=1 + several, width=2.0 * COLUMN) as (figure, each):
        _unknowns(found, each[0])
        _readings(found, each[3 if several else 1])
        if several:
            _plane(found, (each[1:3], each[4:6]))
        else:
            _along(found, each[2])
    return figure


def _unknowns(found: Adaptation, axes: Axes) -> None:
    """Draw what was known of each unknown and what was found."""
    count = len(found.prior.setup.parameters)
    width, place = found.prior.deviations[:count], np.arange(count)[::-1]
    middle = (found.values[:count] - found.prior.start[:count]) / width
    _known(axes, place, found.names[:count])
    axes.errorbar(middle, place, xerr=2.0 * found.deviations[:count] / width, fmt="o", markersize=3, label="found")
    axes.legend(**_BELOW, ncols=2)


def _known(axes: Axes, place: Integers, names: Sequence[str]) -> None:
    """Draw what was known of unknowns, a bar each."""
    axes.barh(place, 4.0, left=-2.0, color="0.9", height=0.8, label="known before")
    axes.set_yticks(place, names)
    axes.set(xlabel="standard deviations of what was known", title="unknowns, 95 %")


def _readings(found: Adaptation, axes: Axes) -> None:
    """Draw what readings are off the calibration and off the adapted sensor."""
    prior, rows = found.prior, np.arange(1, len(found.residual) + 1)
    for k, coil in enumerate(prior.sensor.coil_names):
        mark, colour = MARKS[k % len(MARKS)], f"C{k % 7}"
        before, after = (1e9 * np.maximum(np.abs(part[:, k]), 1e-15) for part in (found.before, found.residual))
        axes.semilogy(rows, before, mark, color=colour, markerfacecolor="none", label=f"{coil}, before")
        axes.semilogy(rows, after, mark, color=colour, label=f"{coil}, adapted")
    expected = 1e9 * float(np.hypot(prior.noise, prior.model).max())
    axes.axhline(expected, color="black", linewidth=0.5, label="noise and model")
    axes.set(xlabel="row of the bench file", ylabel="|reading \u2212 model| [nH]", title="readings and model")
    axes.legend(**_BELOW, ncols=2)


def _at_rest(found: Adaptation, count: int) -> tuple[Array, Array]:
    """Return `count` loads nearest to none, (count, d), and the ends of the table, (2, d)."""
    ends = np.stack([found.prior.table.map.low, found.prior.table.map.high])
    return np.tile(np.clip(np.zeros(ends.shape[1]), *ends), (count, 1)), ends


def _plane(found: Adaptation, panels: Sequence[Sequence[Axes]]) -> None:
    """Draw the errors of the first two forces over their plane, others at rest, before and adapted."""
    loads, ends = _at_rest(found, _ACROSS**2)
    axes = [np.linspace(ends[0, k], ends[1, k], _ACROSS) for k in (0, 1)]
    loads[:, :2] = tensor_grid(*axes).reshape(-1, 2)
    each = found.force_deviations(loads)
    names = found.prior.forces
    for k, row in enumerate(panels):
        shown = [100.0 * SURE * one[:, k].reshape(_ACROSS, _ACROSS) / np.ptp(ends[:, k]) for one in each]
        levels = np.geomspace(0.999 * min(one.min() for one in shown), 1.001 * max(one.max() for one in shown), 13)
        for panel, values, when in zip(row, shown, ("before, tared", "adapted"), strict=True):
            drawn = panel.contourf(*axes, values.T, levels=levels, norm="log")
            panel.set(xlabel=f"{names[0]} [{UNITS[names[0]]}]", ylabel=f"{names[1]} [{UNITS[names[1]]}]",
                      title=f"error of {names[k]}, {when}")
        bar = row[-1].figure.colorbar(drawn, ax=[*row], format="{x:.2g}", label="90 % within [% of range]")
        bar.set_ticks(levels[::3].tolist())


def _along(found: Adaptation, axes: Axes) -> None:
    """Draw the error of the only force, before and after."""
    loads, ends = _at_rest(found, 4 * _ACROSS)
    loads[:, 0] = np.linspace(ends[0, 0], ends[1, 0], len(loads))
    for style, each, when in zip(("--", "-"), found.force_deviations(loads), ("before", "adapted"), strict=True):
        axes.semilogy(loads[:, 0], 100.0 * SURE * each[:, 0] / np.ptp(ends), style, label=when)
    axes.set(xlabel=f"{found.prior.forces[0]} [{UNITS[found.prior.forces[0]]}]", ylabel="90 % within [% of range]",
             title="error of the force")
    axes.legend()


def production_figure(found: Production, record: dict[str, Any]) -> Figure:
    """Return unknowns in deviations of what was known before, and what the next units are delivered with."""
    count, width = len(found.start.setup.parameters), found.start.deviations
    place, start = np.arange(count)[::-1], found.start.start
    with new_figure(height=0.5, columns=2, width=2.0 * COLUMN) as (figure, (known, errors)):
        _known(known, place, [each.name for each in found.start.known[:count]])
        after = (found.next.start - start)[:count] / width[:count]
        known.errorbar(after, place, xerr=2.0 * (found.next.deviations / width)[:count], fmt="none", ecolor="C1",
                       elinewidth=4, alpha=0.5, label="next unit")
        for number, one in enumerate(found.units.values()):
            known.plot((one.values - start)[:count] / width[:count], place, "C0.", markersize=3,
                       label="units" if number == 0 else None)
        known.legend(**_BELOW, ncols=3)
        rows = record["delivered"]
        for force in rows[0]["force_error"]:
            errors.semilogy([100.0 * row["force_error"][force] for row in rows], "o-", label=force)
        errors.axhline(100.0 * record["limit"], color="black", linewidth=0.5, label="limit")
        errors.set_xticks(range(len(rows)), [f"{row['after']}\nyield {100.0 * row['yield']:.0f} %" for row in rows])
        errors.set(ylabel="error [% of range]", title="error and yield of the next units")
        errors.margins(x=0.1, y=0.15)
        errors.legend()
    return figure
