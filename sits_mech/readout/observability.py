"""Tell which components of a load the coils resolve, by singular values of the slopes over noise and full scale.

    W = diag(1 / noise) dL/dF diag(full scale) = U diag(s) V^T

A direction v of V with s >= 1 moves the coils by more than their noise at full scale; the others are unseen, and there
are always such where there are more components than coils. A component is resolved when its unit vector lies in the
seen directions; its resolution is then the standard deviation of the least-squares answer. Numbers only: slopes by any
model, or measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import qr, solve_triangular

from sits_mech.quantities import Array
from sits_mech.readout.loads import load_words

_SHARE = 1e-2  # of a component that may lie in unseen directions


@dataclass(frozen=True)
class Observability:
    """What n coils say of p components."""

    names: tuple[str, ...]
    resolved: tuple[str, ...]  # components that the coils read whatever the others are
    resolution: Array  # (p,) standard deviation, infinite where not resolved [as the full scale]
    alone: Array  # (p,) how far each, alone at full scale, moves the coils: root of the sum of squares, in noise
    signal: Array  # (p,) singular values s, largest first; zero for those that no coil is left for
    unseen: tuple[str, ...]  # in words: loads that do not move the coils, the largest component at full scale


def observability(names: Sequence[str], slopes: ArrayLike, noise: ArrayLike, full_scale: ArrayLike) -> Observability:
    """Return which of p components the coils resolve, by slopes (n, p), noise (n,) and full scale (p,).

    ValueError when shapes differ, or noise or full scale are not positive.
    """
    J, s, F = (np.asarray(item, dtype=float) for item in (slopes, noise, full_scale))
    if J.shape != (s.size, F.size) or F.size != len(names):
        raise ValueError(f"slopes: must be of shape ({s.size}, {len(names)}); got {J.shape}")
    if not (np.all(s > 0.0) and np.all(F > 0.0)):
        raise ValueError("noise and full_scale: must be positive; got some that are not")
    W = J * F / s[:, None]
    _, found, rows = np.linalg.svd(W, full_matrices=True)
    signal = np.zeros(F.size)
    signal[: min(found.size, F.size)] = found[: F.size]
    seen = signal >= 1.0
    lost = np.sum(rows[~seen] ** 2, axis=0)
    spread = np.sqrt(np.sum((rows[seen] / signal[seen, None]) ** 2, axis=0)) * F
    resolution = np.where(lost <= _SHARE**2, spread, np.inf)
    resolved = tuple(name for name, size in zip(names, resolution, strict=True) if np.isfinite(size))
    unseen = tuple(_words(names, share, F) for share in _loads(rows[~seen]))
    return Observability(tuple(names), resolved, resolution, np.linalg.norm(W, axis=0), signal, unseen)


def _loads(rows: Array) -> Array:
    """Return loads that span the same directions (k, p), each with one component of its own, which is one."""
    if not len(rows):
        return rows
    triangle, order = qr(rows, mode="r", pivoting=True)
    found = np.zeros_like(rows)
    found[:, order] = solve_triangular(triangle[: len(rows), : len(rows)], triangle[: len(rows)])
    return found


def _words(names: Sequence[str], share: Array, full_scale: Array) -> str:
    """Name a load by its components, given as shares of full scale."""
    named = zip(names, share * full_scale, share, strict=True)
    parts = {name: float(size) for name, size, part in named if abs(part) > _SHARE}
    return next(iter(parts)) if len(parts) == 1 else f"({load_words(parts)})"
