"""Find the preparations of a plate that serve a pose at a frequency, and their shares.

A plate is prepared for all clearances g from some c on, and for all frequencies f up to some top. So that one pose has
one answer whatever else is asked, and curves over pose and frequency have no steps, the preparations form two ladders,

    c_k = c_0 2^k,    f_m = f_0 10^m,

and a pose with c_k <= g < c_(k+1) and f_(m-1) < f <= f_m is answered by

    Z = sum of w(x) Z_(k, .) + (1 - w(x)) Z_(k-1, .),    x = log2(g / c_k) / `_NEAR`,
        and of w(y) Z_(., m) + (1 - w(y)) Z_(., m+1),    y = log10(f_m / f) / `_UP`,

with w(s) = s^3 (10 - 15 s + 6 s^2) below s = 1 and 1 beyond: most poses and frequencies need one preparation only, and
where the next one takes over, with two continuous derivatives, both hold.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from sits_mech.quantities import Array, Integers

_NEAR = 0.25  # octaves of clearance over which two preparations share
_UP = 0.15  # decades of frequency
_FREQUENCY = 2.5e7  # a top [Hz]


def clearances(gap: Array, anchor: float) -> list[tuple[Integers, Array]]:
    """Return the two steps k of the ladder that serve each gap (p,) [m], and their shares.

    From the gap `anchor` [m] on step 0 serves alone; see `clearance_of`.
    """
    x = np.log2(gap / anchor) + _NEAR
    step = np.floor(x).astype(np.int64)
    share = _rise((x - step) / _NEAR)
    return [(step, share), (step - 1, 1.0 - share)]


def clearance_of(step: int, anchor: float) -> float:
    """Return the clearance that a step of the ladder is prepared for [m]."""
    return float(anchor * 2.0 ** (step - _NEAR))


def served(step: int, anchor: float) -> tuple[float, float]:
    """Return the smallest and the largest gap of which a step of the ladder has a share [m]."""
    low = clearance_of(step, anchor)
    return low, float(low * 2.0 ** (1.0 + _NEAR))


def lowest_served(top: float) -> float:
    """Return the lowest frequency of which what is prepared up to `top` has a share [Hz]."""
    return float(top * 10.0 ** (-1.0 - _UP))


def tops(frequency: float, *, lowest: float = -math.inf) -> list[tuple[float, float]]:
    """Return the frequencies that are prepared for [Hz], and their shares; those of no share are left out.

    `lowest` is the least m of those that a model prepares: the preparation for that frequency answers all below it.
    """
    y = math.log10(frequency / _FREQUENCY)
    step = int(max(math.ceil(y), lowest))
    share = float(_rise(np.array((step - y) / _UP)))
    found = ((_FREQUENCY * 10.0**step, share), (_FREQUENCY * 10.0 ** (step + 1), 1.0 - share))
    return [(top, own) for top, own in found if own > 0.0]


def together(parts: Sequence[list[tuple[Integers, Array]]]) -> Iterator[tuple[tuple[int, ...], Integers, Array]]:
    """Yield the steps of several plates that serve some poses together, which poses, and their shares.

    `parts` are as of `clearances`, for the same poses.
    """
    for choice in product(*parts):
        steps, share = np.stack([step for step, _ in choice], axis=1), choice[0][1]
        for _, own in choice[1:]:
            share = share * own
        left = share > 0.0
        while left.any():
            kind = steps[np.argmax(left)]
            some = np.flatnonzero(left & (steps == kind).all(axis=1))
            left[some] = False
            yield tuple(kind.tolist()), some, share[some]


def _rise(s: Array) -> Array:
    """Return w of the module docstring."""
    s = np.clip(s, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s**2))
