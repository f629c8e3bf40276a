"""Draw what units of a production share: unknowns of each and of the next one, errors and yield of the next ones."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from sits_mech.analysis.built.production import Production
from sits_mech.report.pictures.style import COLUMN, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def production_figure(found: Production, record: dict[str, Any]) -> Figure:
    """Return unknowns in deviations of what was known before, and what the next units are delivered with."""
    count, width = len(found.start.setup.parameters), found.start.deviations
    place, start = np.arange(count)[::-1], found.start.start
    with new_figure(height=0.5, columns=2, width=2.0 * COLUMN) as (figure, (known, errors)):
        known.barh(place, 4.0 * np.ones(count), left=-2.0, color="0.9", height=0.8, label="known before")
        after = (found.next.start - start)[:count] / width[:count]
        known.errorbar(after, place, xerr=2.0 * (found.next.deviations / width)[:count], fmt="none", ecolor="C1",
                       elinewidth=4, alpha=0.5, label="next unit")
        for number, one in enumerate(found.units.values()):
            known.plot((one.values - start)[:count] / width[:count], place, "C0.", markersize=3,
                       label="units" if number == 0 else None)
        known.set_yticks(place, [each.name for each in found.start.known[:count]])
        known.set(xlabel="deviations of what was known", title="unknowns, 95 %")
        known.legend(loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=3)
        rows = record["delivered"]
        for force in rows[0]["force_error"]:
            errors.semilogy([100.0 * row["force_error"][force] for row in rows], "o-", label=force)
        errors.axhline(100.0 * record["limit"], color="black", linewidth=0.5)
        for number, row in enumerate(rows):
            errors.annotate(f"{100.0 * row['yield']:.0f} %", (number, 100.0 * max(row["force_error"].values())),
                            textcoords="offset points", xytext=(0, 5), ha="center")
        errors.set_xticks(range(len(rows)), [row["after"] for row in rows])
        errors.set(ylabel="error [% of range]", title="next units: error, yield")
        errors.margins(x=0.1, y=0.15)
        errors.legend()
    return figure
