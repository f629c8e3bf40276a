"""Which components of a load do the coils tell apart? Singular values of the slopes, over noise and full scale.

    W = diag(1 / noise) dL/dF diag(full scale) = U diag(s) V^T

A direction v of V with s >= 1 moves the coils by more than their noise at full scale; the rest is hidden, as are more
components than coils. A component is told when its unit vector lies in the seen directions; its resolution is then the
standard deviation of the least-squares answer. Numbers only: slopes by any model, or measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from sits_mech.quantities import Array

_TOLD = 1e-2  # part of a component that may lie in hidden directions


@dataclass(frozen=True)
class Observability:
    """What n coils tell of p components.

    Attributes
    ----------
    names : tuple of str
    told : tuple of str
        Components that the coils tell on their own.
    resolution : ndarray, shape (p,)
        Standard deviation of each, infinite where it is not told [as the full scale].
    signal : ndarray, shape (p,)
        Singular values s, largest first; zero for those that no coil is left for.
    hidden : tuple of str
        In words: combinations that the coils do not see.
    """

    names: tuple[str, ...]
    told: tuple[str, ...]
    resolution: Array
    signal: Array
    hidden: tuple[str, ...]


def observability(
    names: Sequence[str], slopes: ArrayLike, noise: ArrayLike, full_scale: ArrayLike
) -> Observability:
    """Return which components of a load the coils tell.

    Parameters
    ----------
    names : sequence of str
        Of the p components.
    slopes : array_like, shape (n, p)
        Of the inductances by the components.
    noise : array_like, shape (n,)
        Standard deviation of each inductance, positive.
    full_scale : array_like, shape (p,)
        Of each component, positive.

    Raises
    ------
    ValueError
        When shapes differ, or noise or full scale are not positive.
    """
    J, s, F = (np.asarray(item, dtype=float) for item in (slopes, noise, full_scale))
    if J.shape != (s.size, F.size) or F.size != len(names):
        raise ValueError(f"slopes: must be of shape ({s.size}, {len(names)}); got {J.shape}")
    if not (np.all(s > 0.0) and np.all(F > 0.0)):
        raise ValueError("noise and full_scale: must be positive; got some that are not")
    _, found, rows = np.linalg.svd(J * F / s[:, None], full_matrices=True)
    signal = np.zeros(F.size)
    signal[: min(found.size, F.size)] = found[: F.size]
    seen = signal >= 1.0
    blind = np.sum(rows[~seen] ** 2, axis=0)
    spread = np.sqrt(np.sum((rows[seen] / signal[seen, None]) ** 2, axis=0)) * F
    resolution = np.where(blind <= _TOLD**2, spread, np.inf)
    told = tuple(name for name, size in zip(names, resolution, strict=True) if np.isfinite(size))
    hidden = tuple(_words(names, row / F) for row in rows[~seen])
    return Observability(tuple(names), told, resolution, signal, hidden)


def _words(names: Sequence[str], direction: Array) -> str:
    """Name a direction by its components, the largest taken as one."""
    unit = direction / direction[int(np.argmax(np.abs(direction)))]
    parts = [f"{part:+.3g} {name}" for name, part in zip(names, unit, strict=True) if abs(part) > 1e-3]
    return " ".join(parts).replace("+1 ", "", 1) if len(parts) == 1 else " ".join(parts)
