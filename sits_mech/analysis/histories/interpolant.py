"""Choose times of a history to solve, and carry what is known there to times between them, with the error of it.

Monotone cubics carry each quantity y to the others, from corner to corner. The chord between two solved times a, b is
off by y[a, b, t] (t - a)(t - b); the cubic is taken to be no worse, with the divided differences about both ends, of
which one alone may miss a kink between them:

    |y - y_cubic|  <=  (|y[a', a, b]| + |y[a, b, b']|) (t - a)(b - t),        a' < a < b < b' solved

(at a corner twice the other one; on a leg without a time inside, half the change in its middle, what a monotone y may
be off).
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator

from sits_mech.mechanics.histories import LoadHistory
from sits_mech.quantities import Array, Mask

PARTS = 8
"""Steps over the range of a load that lie between two solved times, at most."""
_BEND = 0.5  # over the square of a range's parts: error of interpolation where y goes with the square of the load


class Interpolant(NamedTuple):
    """Values (m, ...) at rising times (m,), monotone cubics from corner to corner of the load, ends held.

    Where the load's rate jumps, or the load itself, the response has a kink.
    """

    time: Array
    corners: Mask  # (m,), as of a `LoadHistory`
    values: Array

    def at(self, times: Array) -> tuple[Array, Array]:
        """Return values and errors of interpolation, (n, ...), at other times (n,)."""
        held, values = np.clip(times, self.time[0], self.time[-1]), self.values
        found, error = (np.empty((*held.shape, *values.shape[1:])) for _ in range(2))
        ends = np.flatnonzero(self.corners)
        leg = np.clip(np.searchsorted(self.time[ends], held, side="right") - 1, 0, len(ends) - 2)
        for number in np.unique(leg):
            part, own = slice(ends[number], ends[number + 1] + 1), leg == number
            found[own], error[own] = _on_leg(self.time[part], values[part], held[own])
        return found, error


def _on_leg(time: Array, values: Array, times: Array) -> tuple[Array, Array]:
    """Return values and errors of interpolation between the times of one leg."""
    h, shape = np.diff(time), (-1, *[1] * (values.ndim - 1))
    if not h.all():  # a sudden change: what comes after it
        last = np.broadcast_to(values[-1], (len(times), *values.shape[1:]))
        return last, np.zeros_like(last)
    if not np.isfinite(values).all():  # an unknown stretch, an unbounded error: the line
        with np.errstate(invalid="ignore"):
            last = np.apply_along_axis(partial(np.interp, times, time), 0, values)
        return last, np.zeros_like(last)
    slope, second = np.diff(values, axis=0) / h.reshape(shape), np.empty_like(values)
    second[1:-1] = np.abs(np.diff(slope, axis=0)) / (h[1:] + h[:-1]).reshape(shape)
    second[[0, -1]] = second[[1, -2]] if len(time) > 2 else np.abs(slope) / h[0]
    left = np.clip(np.searchsorted(time, times, side="right") - 1, 0, len(h) - 1)
    apart = ((times - time[left]) * (time[left + 1] - times)).reshape(shape)
    return PchipInterpolator(time, values, axis=0)(times), (second[left] + second[left + 1]) * apart


def foreseen(history: LoadHistory, most: float) -> tuple[LoadHistory, Mask]:
    """Divide a history for errors of interpolation; return also which times are its own.

    Half is for the load's own course in time, which is interpolated first, the other for what a response adds to it.
    """
    divided, own = history.divided(PARTS, max(PARTS, int(np.ceil(np.sqrt(_BEND / most)))))
    load, corners = divided.shares, divided.corners
    while True:
        known, left = divided.solved, own & ~divided.solved
        _, off = Interpolant(divided.time[known], corners[known], load[known]).at(divided.time[left])
        more = more_times(divided, own, divided.time[known], np.max(off, axis=1) / (0.5 * most))
        if not more.any():
            return divided, own
        divided = replace(divided, solved=known | more)


def more_times(history: LoadHistory, own: Mask, solved: Array, share: Array) -> Mask:
    """Return which times to solve besides, from solved ones and errors of interpolation over their limit, by row."""
    left, found = np.flatnonzero(own & ~history.solved), np.zeros(own.size, dtype=bool)
    inside = np.searchsorted(solved, history.time[left], side="right")
    for number in np.unique(inside[share > 1.0]):
        rows = left[inside == number]
        pieces = int(np.ceil(np.sqrt(share[inside == number].max())))
        found[rows[np.arange(1, pieces) * len(rows) // pieces]] = True
    return found
