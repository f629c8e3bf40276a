"""Show an envelope as a record for a program, as a table, and as a picture of each plane of forces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table
from scipy.interpolate import CubicSpline

from sits_mech.analysis.envelope import Envelope, Ray
from sits_mech.notes import Note
from sits_mech.quantities import Wrench, shown_unit
from sits_mech.report.notes import sentence
from sits_mech.report.pictures.style import MARKS, new_figure
from sits_mech.report.plots.curves import load_label
from sits_mech.report.tables.solves import key_table, with_error

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def envelope_record(found: Envelope) -> dict[str, Any]:
    """Return an envelope for a program, SI; what is not known, and a force without limit, is not a number."""
    rays = [
        {
            "plane": list(ray.plane),
            "angle": ray.angle,
            "force": {name: getattr(ray.force, name) for name in ray.plane},
            "error": ray.error * force_size(ray.force),
            "limit": sentence(ray.limit),
        }
        for ray in found.rays
    ]
    return {"rays": rays} | {name: getattr(found, name) for name in ("model", "known_stretch", "tolerance")}


def envelope_table(found: Envelope) -> Table:
    """Return an envelope for a reader: a line a ray; of rays that differ by the sign of a shear alone the first."""
    rows, first = [], dict[tuple[str, ...], Ray]()
    for ray in found.rays:
        alike = (f"{(v if name == 'F_z' else abs(v)) + 0.0:.9g}" for name, v in vars(ray.force).items())
        apart = "" if math.isfinite(force_size(ray.force)) else f"{ray.plane}{ray.angle}"
        first.setdefault((sentence(ray.limit), *alike, apart), ray)
    for ray in first.values():
        each = ((name, v, v * ray.error) for name, v in vars(ray.force).items() if v)
        words = (f"{name} = {with_error(v, e) if math.isfinite(v) else v} {shown_unit(name)}" for name, v, e in each)
        rows.append((", ".join(words) or "no force", sentence(ray.limit)))
    return key_table("forces within all limits, and the limit that comes next; mirror images left out", rows)


def _draw_plane(axes: Axes, own: Sequence[Ray], limits: Sequence[Note]) -> None:
    """Draw the rays of a plane of forces, in a colour for each limit, and the curve through their ends."""
    plane, around = own[0].plane, [*(ray.angle for ray in own), own[0].angle + 2.0 * math.pi]
    ends = np.array([[float(getattr(ray.force, each)) for each in plane] for ray in own])
    curve = CubicSpline(around, np.vstack([ends, ends[:1]]), bc_type="periodic")
    axes.fill(*curve(np.linspace(around[0], around[-1], 181)).T, color="0.92", ec="0.6", lw=0.8, zorder=0)
    for k, limit in enumerate(limits):
        here = [n for n, ray in enumerate(own) if ray.limit == limit]
        for n in here:
            axes.plot(*np.outer([1.0 - own[n].error, 1.0 + own[n].error], ends[n]).T, color=f"C{k}", lw=0.8)
        axes.plot(*ends[here].T, f"C{k}{MARKS[k % len(MARKS)]}", label=sentence(limit))
    axes.plot(0.0, 0.0, "k+")
    axes.set(xlabel=load_label(plane[0]), ylabel=f"{load_label(plane[1])}, positive: pressing")


def envelope_figure(found: Envelope, name: str) -> Figure:
    """Plot an envelope in each plane of forces, its limits by kind, with error bars."""
    planes = list(dict.fromkeys(ray.plane for ray in found.rays))
    limits = list(dict.fromkeys(ray.limit for ray in found.rays))
    with new_figure(0.95 * len(planes), rows=len(planes)) as (figure, every):
        for plane, axes in zip(planes, every, strict=True):
            own = [ray for ray in found.rays if ray.plane == plane and math.isfinite(force_size(ray.force))]
            if own:
                _draw_plane(axes, own, limits)
        figure.suptitle(f"{name}\nforces within all limits; bars along rays: estimated error")
        figure.legend(*every[0].get_legend_handles_labels(), loc="outside lower center", fontsize="x-small")
        return figure


def force_size(force: Wrench) -> float:
    """Return the size of a force [N]."""
    return math.hypot(force.F_x, force.F_y, force.F_z)
