"""Show a cyclic load: the loops of the signals, and their width cycle by cycle."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING, Any

import xarray as xr
from rich.table import Table

from sits_mech.analysis.cycle import cycles_of
from sits_mech.analysis.histories.full_cycle import difference
from sits_mech.quantities import POSE, WRENCH
from sits_mech.readout.loads import ends_of, request_of
from sits_mech.readout.signals import shown_signals
from sits_mech.report.notes import kept_sentences
from sits_mech.report.pictures.style import new_figure, strokes
from sits_mech.report.plots.curves import by_models, load_label, signal_label
from sits_mech.report.records import status_record
from sits_mech.report.tables.solves import column_table, figure_text
from sits_mech.status import joined

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ARROW = {"arrowstyle": "-|>,head_length=.5,head_width=.2", "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}


def loop_table(data: xr.Dataset) -> Table:
    """Return the loops of `load_cycle`, a line for each cycle; "-" where the signal's range is within its error."""
    names = shown_signals(data)
    headings = ("cycle", *(f"{name.removesuffix('_percent')} [% of its range]" for name in names))
    found = column_table(f"{data.attrs['name']}: width of the loops", headings, justify="right")
    each = [map(figure_text, data.attrs[f"loop_{name}"], data.attrs[f"error_loop_{name}"]) for name in names]
    for number, widths in enumerate(zip(*each, strict=True), 1):
        found.add_row(str(number), *widths)
    found.caption = "; ".join((f"status: {data.attrs['flags']}", *kept_sentences(data.attrs["notes"])))
    return found


def loop_record(data: xr.Dataset) -> dict[str, Any]:
    """Return the loops for a program, with the request and the ends of pose and signals."""
    ends = ends_of(data, (*POSE, *shown_signals(data)))
    keys = (f"{kind}_{name}" for kind in ("loop", "error_loop") for name in shown_signals(data))
    loops = {key: data.attrs[key] for key in keys}
    own = status_record(joined([data.attrs["flags"]])) | {"request": request_of(data)}
    own["error_of_full_scale"] = float(data.attrs["error"])
    return own | {"ends": ends, "notes": kept_sentences(data.attrs["notes"])} | loops


def difference_table(cheap: xr.Dataset, full: xr.Dataset) -> Table:
    """Return the difference of a fast cycle from a full one, in percent of each quantity's range."""
    title = "the pad as a whole (cycle without --full) against every point of it"
    found = column_table(title, ("", "largest difference [% of its range]"), justify="right")
    for name, share in difference(cheap, full).items():
        found.add_row(name.removesuffix("_percent"), f"{share:.2g}")
    return found


def difference_record(cheap: xr.Dataset, full: xr.Dataset) -> dict[str, Any]:
    """Return that difference for a program, with the loops of the fast cycle."""
    loops = {f"loop_{name}": cheap.attrs[f"loop_{name}"] for name in shown_signals(cheap)}
    return {"difference_percent": difference(cheap, full)} | loops


def loop_curves(data: xr.Dataset) -> Figure:
    """Plot the signals under a cyclic load, each against the largest component of the load."""
    peak, names = request_of(data)["peak"], shown_signals(data)
    force = max((name for name in WRENCH if peak[name]), key=lambda name: abs(peak[name]), default="F_z")
    load, turns = peak[force] * data["share"].to_numpy(), cycles_of(data["share"].to_numpy())
    with new_figure(0.8 if len(names) == 1 else 0.62, columns=len(names)) as (figure, every):
        for axes, name in zip(every, names, strict=True):
            for number, (stroke, span) in enumerate(zip(strokes(len(turns)), turns, strict=True), 1):
                color, values = stroke["color"], data[name].to_numpy()[span]
                axes.plot(load[span], values, linestyle=stroke["linestyle"], color=color, label=f"cycle {number}")
                for k in (len(values) // 4, 3 * len(values) // 4) if number in (1, len(turns)) else ():
                    start, end = ((load[span][j], values[j]) for j in (k, k + len(values) // 10))
                    axes.annotate("", end, start, arrowprops=_ARROW | {"color": color})
            axes.set(xlabel=load_label(force), ylabel=signal_label(name))
        figure.suptitle(f"{fill(data.attrs['name'], 54)}\nloading and unloading{by_models(data)}, along the arrows")
        figure.legend(*every[0].get_legend_handles_labels(), loc="outside lower center", ncols=5)
    return figure
