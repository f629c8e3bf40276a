"""Check whether a coil's own turns touch: KiCad asks for no clearance within a net, so a board may short its coil.

Two stretches touch where their centre lines are nearer than half of both widths together. Neighbours on the path do so
by nature: in a bend, or at a corner of theta they overlap over w / (2 sin(theta/2)). Only those that are further apart
along the path than six widths count, which corners sharper than 20 degrees exceed.
"""

from __future__ import annotations

import numpy as np

from sits_mech.boards.kicad import place
from sits_mech.boards.route import Route, Run
from sits_mech.quantities import Array

_APART = 6.0  # along the path, over the width
_ROUNDING = 1e-6  # of places on a board [m]


def touching(found: Route) -> tuple[str, ...]:
    """Return where turns of a coil touch, for a reader: the first such place on each layer."""
    lengths = [np.hypot(*np.diff(run.points, axis=0).T) for run in found.runs]
    starts = np.cumsum([0.0, *(each.sum() for each in lengths)])
    notes = []
    for layer in dict.fromkeys(run.layer for run in found.runs):
        mine = [k for k, run in enumerate(found.runs) if run.layer == layer]
        along = [starts[k] + np.cumsum(lengths[k]) - lengths[k] / 2 for k in mine]
        at = _first([found.runs[k] for k in mine], np.concatenate(along))
        if at is not None:
            where = f"on {layer} at {place(at)}"
            notes.append(f"net {found.net}: its turns touch {where}: a short circuit of the board, not of the scene")
    return tuple(notes)


def _first(runs: list[Run], along: Array) -> Array | None:
    """Return a place where stretches of one layer touch, else None; `along` are their middles on the path [m]."""
    import shapely

    a, b = (np.vstack([run.points[some] for run in runs]) for some in (slice(None, -1), slice(1, None)))
    width = np.concatenate([np.full(len(run.points) - 1, run.width) for run in runs])
    length, pieces = np.hypot(*(b - a).T), shapely.linestrings(np.stack([a, b], axis=1))
    i, j = shapely.STRtree(pieces).query(pieces, "dwithin", width)
    between = np.abs(along[j] - along[i]) - (length[i] + length[j]) / 2
    gap = shapely.distance(pieces[i], pieces[j]) - (width[i] + width[j]) / 2
    met = (between > _APART * np.maximum(width[i], width[j])) & (gap < -_ROUNDING)
    return np.asarray(a[np.minimum(i, j)[met].min()]) if met.any() else None
