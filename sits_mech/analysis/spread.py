"""Propagate tolerances to an answer: quasi-Monte Carlo over a smooth map, with shares of the variance.

Independent normal deviations x_i of size s_i. A costly function y(x) is asked at a few points of a Sobol sequence
within three s_i, a polynomial (`surrogate`) goes through them, and of the polynomial, at 2^12 points of a sequence,

    mean, standard deviation, 2.5 % and 97.5 % quantiles of y;
    Sobol's shares: first-order V(E(y | x_i)) / V(y), total 1 - V(E(y | all but x_i)) / V(y)      (Saltelli 2010)

Shares add up to one where the deviations act apart; total over first-order says how much they act together. What the
polynomial misses stands beside them. Numbers only, no physics.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import norm, qmc, sobol_indices

from sits_mech.maps.surrogate import SmoothMap, fit_map
from sits_mech.quantities import Array

_WIDTH = 3.0  # standard deviations that the design covers
_STILL = 1e-9  # of an answer: what scatters less may be rounding


@dataclass(frozen=True)
class Spread:
    """Scatter of q answers under p tolerances."""

    names: tuple[str, ...]  # of the tolerances
    deviations: Array  # standard, (p,)
    mean: Array  # (q,)
    deviation: Array  # standard, (q,)
    interval: Array  # (q, 2), 2.5 % and 97.5 % quantiles
    first: Array  # (q, p), shares of the variance; nan if it is zero
    total: Array  # (q, p)
    map_error: Array  # (q,), root mean square at points left out


def design(deviations: ArrayLike, count: int) -> Array:
    """Return the deviations at which to evaluate, (count, p), the first zero; a power of two fills the box evenly.

    Raise ValueError for a deviation that is not positive, or fewer than two points a tolerance.
    """
    s = np.asarray(deviations, dtype=float)
    if s.ndim != 1 or not np.all(s > 0.0):
        raise ValueError(f"deviations: must be positive numbers; got {s.tolist()}")
    if count < 2 * len(s) + 2:
        raise ValueError(f"count: must be at least {2 * len(s) + 2} for {len(s)} tolerances; got {count}")
    power = int(np.ceil(np.log2(count)))
    unit = qmc.Sobol(len(s), rng=np.random.default_rng(0)).random_base2(power)[: count - 1]
    return np.vstack([np.zeros((1, len(s))), _WIDTH * s * (2.0 * unit - 1.0)])


def spread(
    names: Sequence[str], deviations: ArrayLike, points: ArrayLike, values: ArrayLike, *, samples: int = 4096
) -> Spread:
    """Return mean, scatter and shares of answers (m, q) known at points (m, p) from `design`.

    Rows that are not finite are left out; `samples` of the quasi-Monte Carlo. Raise ValueError for too few points, or
    if `samples` is no power of two.
    """
    s, x, y = (np.asarray(item, dtype=float) for item in (deviations, points, values))
    if samples < 64 or samples & (samples - 1):
        raise ValueError(f"samples: must be a power of two from 64 on; got {samples}")
    good = np.isfinite(y).all(axis=1)
    found = fit_map(names, x[good], y[good], simplex=len(s) > 2)
    unit = qmc.Sobol(len(s), rng=np.random.default_rng(0)).random_base2(int(np.log2(samples)))
    drawn = found.at(_within(found, norm.ppf(np.clip(unit, 1e-9, 1.0 - 1e-9)) * s))
    first, total = _shares(found, s, samples)
    return Spread(
        tuple(names), s, drawn.mean(axis=0), drawn.std(axis=0),
        np.quantile(drawn, [0.025, 0.975], axis=0).T, first, total, found.rms,
    )


def _within(found: SmoothMap, points: Array) -> Array:
    """Clip points (m, p) to the box of the map: 0.3 % of a normal deviation lie beyond it."""
    return np.clip(points, found.low, found.high)


def _shares(found: SmoothMap, s: Array, samples: int) -> tuple[Array, Array]:
    """Return first-order and total shares, shape (q, p) each."""
    q = found.coefficients.shape[1]
    first, total = np.full((2, q, len(s)), np.nan)
    scale = np.ptp(found.at(_within(found, design(s, 64))), axis=0)
    moves = np.flatnonzero(scale > _STILL * np.maximum(np.abs(found.at(np.zeros(len(s)))), 1e-300))
    if moves.size == 0:
        return first, total

    def answers(x: Array) -> Array:
        """Return answers (q, m) at deviations (p, m)."""
        return np.asarray((found.at(_within(found, x.T))[:, moves] / scale[moves]).T)

    dists = [norm(scale=size) for size in s]
    indices = sobol_indices(func=answers, n=samples, dists=dists, rng=np.random.default_rng(0))
    first[moves] = np.asarray(indices.first_order).reshape(len(moves), -1)
    total[moves] = np.asarray(indices.total_order).reshape(len(moves), -1)
    return first, total
