"""Move rims of a plate inwards, and measure how narrow its metal is."""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Array, Mask
from sits_mech.scene.parts.outlines import edges


def offset(loop: Array, depth: float) -> Array:
    """Return the polygon moved to the left of its direction by `depth`, mitred."""
    before, after = np.roll(loop, 1, axis=0), np.roll(loop, -1, axis=0)
    n1, n2 = (_left(b - a) for a, b in ((before, loop), (loop, after)))
    return np.asarray(loop + depth * (n1 + n2) / (1.0 + (n1 * n2).sum(1, keepdims=True)))


def _left(v: Array) -> Array:
    """Return unit normals to the left."""
    return np.asarray(np.column_stack([-v[:, 1], v[:, 0]]) / np.linalg.norm(v, axis=1, keepdims=True))


def _crossing(start: Array, step: Array, a: Array, b: Array) -> tuple[Array, Array]:
    """Return where lines from `start` along `step` meet edges a-b: parameters on both (n, m), nan where parallel."""
    side = b - a
    cross = step[:, None, 0] * side[:, 1] - step[:, None, 1] * side[:, 0]
    cross = np.where(np.abs(cross) > 1e-12 * np.abs(cross).max(), cross, np.nan)
    gap = a - start[:, None, :]
    s = (gap[..., 0] * side[:, 1] - gap[..., 1] * side[:, 0]) / cross
    t = (gap[..., 0] * step[:, None, 1] - gap[..., 1] * step[:, None, 0]) / cross
    return s, t


def narrowest(loops: list[Array]) -> float:
    """Return the smallest width of metal, looking inwards from every edge; or what an edge loses to its mitres."""
    a, b = edges(loops)
    share = np.array([0.02, 0.25, 0.5, 0.75, 0.98])
    start = (a[:, None, :] + share[:, None] * (b - a)[:, None, :]).reshape(-1, 2)
    s, t = _crossing(start, np.repeat(_left(b - a), share.size, axis=0), a, b)
    scale = float(np.ptp(a, axis=0).max())
    hit = (s > 1e-9 * scale) & (t >= 0.0) & (t <= 1.0) & ~np.repeat(_neighbours(loops), share.size, axis=0)
    width = float(np.min(s[hit])) if hit.any() else scale
    for loop in loops:
        lost = np.linalg.norm(loop - np.roll(loop, -1, axis=0), axis=1)
        inner = offset(loop, 1.0)
        shrink = lost - ((np.roll(inner, -1, axis=0) - inner) * (np.roll(loop, -1, axis=0) - loop)).sum(1) / lost
        width = min(width, float(np.min(np.where(shrink > 1e-9, lost / np.maximum(shrink, 1e-9), np.inf))))
    return width


def _neighbours(loops: list[Array]) -> Mask:
    """Return edges that share a corner: there the mitre, not the width, limits the depth."""
    total = sum(len(loop) for loop in loops)
    near = np.zeros((total, total), dtype=bool)
    start = 0
    for loop in loops:
        here = start + np.arange(len(loop))
        near[here, np.roll(here, 1)] = near[here, np.roll(here, -1)] = True
        start += len(loop)
    return near
