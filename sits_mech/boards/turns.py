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
from sits_mech.scene.outlines import distances

_APART = 6.0  # along the path, over the width
_ROUNDING = 1e-6  # of places on a board [m]
_BLOCK = 256  # stretches compared with all others at once


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
    a, b = (np.vstack([run.points[some] for run in runs]) for some in (slice(None, -1), slice(1, None)))
    width = np.concatenate([np.full(len(run.points) - 1, run.width) for run in runs])
    length, half = np.hypot(*(b - a).T), width[:, None] / 2
    low, high = np.minimum(a, b) - half, np.maximum(a, b) + half
    for first in range(0, len(a), _BLOCK):
        some = slice(first, first + _BLOCK)
        near = ((low[some, None] <= high) & (high[some, None] >= low)).all(axis=-1)
        between = along - along[some, None] - (length + length[some, None]) / 2
        i, j = np.nonzero(near & (between > _APART * np.maximum(width, width[some, None])))
        gap = distances(a[some][i], b[some][i], a[j], b[j]) - (width[some][i] + width[j]) / 2
        if (gap < -_ROUNDING).any():
            return np.asarray(a[some][i[int(np.argmax(gap < -_ROUNDING))]])
    return None
