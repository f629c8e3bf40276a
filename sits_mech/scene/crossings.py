"""Find where tracks of one layer cross or touch; polylines are compared pair by pair."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sits_mech.quantities import Array

_SLACK = 1e-9  # relative: lengths that are equal as written may differ by rounding
_BLOCK = 256  # tracks compared with all others at once


def crossing(lines: list[Array]) -> tuple[float, float] | None:
    """Return a place where polylines of one plane, (m, 2) each, cross or touch; None where they do not.

    They are in series: the end of one may be the beginning of the next.
    """
    a, b = (np.vstack([line[some] for line in lines]) for some in (slice(None, -1), slice(1, None)))
    step, number = b - a, np.arange(len(a))
    for first in range(0, len(a), _BLOCK):
        some = slice(first, first + _BLOCK)
        gap = a - a[some, None]
        turn = step[some, None, 0] * step[..., 1] - step[some, None, 1] * step[..., 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            s = (gap[..., 0] * step[:, 1] - gap[..., 1] * step[:, 0]) / turn
            t = (gap[..., 0] * step[some, None, 1] - gap[..., 1] * step[some, None, 0]) / turn
        later = number[some, None] < number
        joined = np.all(b[some, None] == a, axis=-1) | np.all(a[some, None] == b, axis=-1)
        meets = later & ~joined & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
        found = np.argwhere(meets | later & _folded(a, step, some))
        if len(found):
            i, j = found[0]
            place = a[first + i] + (s[i, j] if np.isfinite(s[i, j]) else 1.0) * step[first + i]
            return float(place[0]), float(place[1])
    return None


def _folded(a: Array, step: Array, some: slice) -> NDArray[np.bool_]:
    """Return whether two stretches lie on one line and overlap."""
    length = np.hypot(step[:, 0], step[:, 1])
    way = step / length[:, None]
    gap = a - a[some, None]
    across = np.abs(gap[..., 0] * way[some, None, 1] - gap[..., 1] * way[some, None, 0])
    end = gap + step
    across = np.maximum(across, np.abs(end[..., 0] * way[some, None, 1] - end[..., 1] * way[some, None, 0]))
    along = [np.einsum("ijk,ik->ij", place, way[some]) for place in (gap, end)]
    low, high = np.minimum(*along), np.maximum(*along)
    inside = np.minimum(high, length[some, None]) - np.maximum(low, 0.0)
    small = _SLACK * (length[some, None] + length)
    return np.asarray((across <= small) & (inside > small), dtype=np.bool_)
