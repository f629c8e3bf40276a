"""Find the forces of readings: Gauss-Newton from the nearest load of a fine grid, many readings at once.

    x <- x + (W J)^+ W (L - L(x)),    J = dL/dx, W the weights, (W J)^+ = R^-1 Q^T from W J = Q R by Gram-Schmidt

The first step starts at the grid's load whose inductances are nearest, with the slopes that are known there. As many
coils as forces: Newton's method, the residual goes to rounding. Readings lie along the last axis and every number is
made of its own reading alone, sums in one order: an answer does not depend on what else is asked.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sits_mech.maps.domain import Domain, times
from sits_mech.maps.surrogate import SmoothMap
from sits_mech.quantities import Array, Mask

OK, OUTSIDE, AMBIGUOUS, NO_SOLUTION = "ok", "outside", "ambiguous", "no solution"
INCONSISTENT = 0.02
"""Residual of more coils than forces, of the largest range of a coil, beyond which a reading has no solution."""
MARGIN = 0.02
"""Beyond the table, of half its range: noise at rest reads a little below zero."""
REACH = 1.2
"""Of half the range: no force beyond it is tried."""
EXACT = 1e-6
"""The same of as many coils as forces, which is zero but for rounding and the last step."""
HOPELESS = 10
"""Times the residual of an answer; a reading that is further off, and gets no nearer by half, is given up."""
_EDGE = 1e-6  # of half the range: forces as near the reach are at it
_ROUNDING = 1e-6  # of a sum of squares: by less a step does not lead away
_STEPS, _MORE = 25, 100  # of Newton's method, and of least squares, which settle slowly where loads look alike
LONGEST = 0.3
"""Of a step, of half the range."""
_SMALL = 1e-11  # error of an answer, of half the range
APART = 1e-3
"""Two answers, of half the range."""
_SINGULAR = 1e-10  # of the longest column: what is left of a shorter one has no direction
_BLOCK = 4096  # readings at a time
_LOST = 4.0  # errors of a force, in halves of its range
_ILL_CONDITIONED = 1e3  # condition of the slopes, below which large errors are given with the answer

Statuses = NDArray[np.str_]


@dataclass(frozen=True)
class Inverse:
    """Forces from inductances.

    Attributes
    ----------
    forces : ndarray, shape (..., d)
        In the order of `Calibration.forces` [N, N m]; NaN where the status is not "ok".
    status : ndarray of str, shape (...)
        "ok", "outside" (of the table), "ambiguous" (more than one force shows this), "no solution".
    error : ndarray, shape (..., d)
        What the error of the map makes of each force [N, N m].
    error_by_model : ndarray, shape (..., d)
        What the errors of the table's own inductances make of it, at most; NaN where they are not known.
    error_by_noise : ndarray, shape (..., d)
        Standard deviation by the coils' noise; NaN where it is not known.
    residual : ndarray, shape (...)
        Largest remaining difference of a coil, relative to `Calibration.full_scale`; noise or a wrong reading where
        there are more coils than forces.
    """

    forces: Array
    status: Statuses
    error: Array
    error_by_model: Array
    error_by_noise: Array
    residual: Array


@dataclass(frozen=True)
class InverseSearch:
    """The inverse of a map in scaled forces; fields as of `Calibration`."""

    map: SmoothMap
    domain: Domain
    weights: Array
    full_scale: Array
    seeds: tuple[Array, ...]

    @property
    def tolerance(self) -> float:
        """Residual of an answer, of the largest range of a coil: nothing but rounding for as many coils as forces."""
        return INCONSISTENT if len(self.weights) > len(self.map.low) else EXACT

    def solved(self, L: Array, spreads: Array) -> tuple[Array, Array, Statuses, Array]:
        """Return scaled forces (m, d), relative residual (m), status (m) and errors (3, m, d) of readings (m, n).

        The errors are of scaled forces, by `spreads` (3, n) of the inductances: two at most, and a standard deviation.
        """
        blocks = range(0, max(len(L), 1), _BLOCK)
        each = [self._block(np.ascontiguousarray(L[k : k + _BLOCK].T), spreads) for k in blocks]
        x, residual, status, errors = (np.concatenate(parts, axis=-1) for parts in zip(*each, strict=True))
        return x.T, residual, status, np.moveaxis(errors, 1, 2)

    def answers(self, x: Array) -> Array:
        """Return the derivatives of the inverse by the inductances (m, d, n), of scaled forces [1/unit]."""
        return np.moveaxis(self._inverse(self._seen(x.T)[1]), 2, 0)

    def lost(self, x: Array, off: Array) -> Mask:
        """Return whether each force is unknown at most of some loads (m, d), with inductances off by errors (n,).

        There the slopes are nearly singular, and the error of the force is several times its range, or no inductance
        depends on it.
        """
        slopes = self._seen(x.T)[1]
        answers = self._inverse(slopes)
        singular = np.linalg.cond(np.moveaxis(slopes * self.weights[:, None, None], 2, 0)) > _ILL_CONDITIONED
        blind = np.all(answers == 0.0, axis=1) | (times(np.abs(answers), off[:, None]) > _LOST)
        return np.asarray((blind & singular).mean(axis=1) > 0.5)

    def _inverse(self, slopes: Array) -> Array:
        """Return the least-squares inverses (d, n, m) of slopes (n, d, m) [1/unit]."""
        return pseudo_inverse(slopes * self.weights[:, None, None]) * self.weights[:, None]

    def _block(self, L: Array, spreads: Array) -> tuple[Array, Array, Statuses, Array]:
        """Return what `solved` does of readings (n, m), these along the last axes."""
        x, settled, residual, answers = self._newton(L, 0)
        status = np.full(L.shape[1], OK, dtype="<U12")
        shown, inside = settled & (residual <= self.tolerance), self.domain.holds(x.T, MARGIN)
        status[~(shown & inside)] = NO_SOLUTION
        far = (len(L) == len(x)) | self.domain.beyond(L.T)  # nothing else can be wrong, or more than any load shows
        status[(shown & ~inside) | ((status != OK) & far & np.isfinite(residual))] = OUTSIDE
        status[(status == OK) & ~self.domain.valid(x.T)] = AMBIGUOUS
        for part in range(1, len(self.seeds)):
            open_ = np.flatnonzero((status != AMBIGUOUS) & np.isfinite(L).all(axis=0))
            other, settled, left, there = self._newton(L[:, open_], part)
            shown = settled & (left <= self.tolerance) & self.domain.holds(other.T, 0.0)
            known = (status[open_] == OK) & self.domain.holds(x[:, open_].T, 0.0)
            second = known & (np.max(np.abs(other - x[:, open_]), axis=0) > APART)
            status[open_[shown & second]] = AMBIGUOUS
            first = np.flatnonzero(shown & ~known)
            x[:, open_[first]], residual[open_[first]] = other[:, first], left[first]
            answers[..., open_[first]] = there[..., first]
            status[open_[first]] = np.where(self.domain.valid(other[:, first].T), OK, AMBIGUOUS)
        most = [times(np.abs(answers), size) for size in spreads[:2]]
        return x, residual, status, np.array([*most, np.sqrt(times(answers**2, spreads[2] ** 2))])

    def _newton(self, L: Array, part: int) -> tuple[Array, Mask, Array, Array]:
        """Return where Gauss-Newton ends (d, m), whether it settled, the residual and the `answers` (d, n, m) there.

        A step that leads away is halved. Residual and derivatives are those before the last step, which is small, the
        residual less what it takes away.
        """
        (n, m), d = L.shape, len(self.map.low)
        (origin, step, least), settled = self._started(L, part), np.zeros(m, dtype=bool)
        residual, answers = np.full(m, np.nan), np.full((d, n, m), np.nan)
        small = _SMALL if n > d else np.sqrt(_SMALL)  # Newton's next step is this one's square
        active = np.flatnonzero(np.isfinite(L).all(axis=0))
        for _ in range(_MORE if n > d else _STEPS):
            if active.size == 0:
                break
            x = origin[:, active] + step[:, active]
            value, slopes = self._seen(x)
            off = L[:, active] - value
            size = self._size(off)
            nearer = size <= least[active] * (1.0 + _ROUNDING)
            inverse = self._inverse(slopes if n == d else self._free(slopes, off, x))
            step[:, active] = np.where(nearer, _step(x, inverse, off), 0.5 * step[:, active])
            origin[:, active] = np.where(nearer, x, origin[:, active])
            least[active] = np.where(nearer, size, least[active])
            hopeless = self._hopeless(off, off - times(slopes, times(inverse, off)))
            off -= times(slopes, origin[:, active] + step[:, active] - x)
            residual[active] = np.max(np.abs(off) / self.full_scale[:, None], axis=0)
            done = np.max(np.abs(step[:, active]), axis=0) < small
            settled[active[done]], answers[..., active[done]] = True, inverse[..., done]
            active = active[~(done | hopeless)]
        return origin + step, settled, residual, answers

    def _size(self, off: Array) -> Array:
        """Return the weighted sum of squares of differences (n, m)."""
        return _dot(off * self.weights[:, None], off * self.weights[:, None])

    def _hopeless(self, off: Array, left: Array) -> Mask:
        """Return which readings stay far from any load's: differences (n, m), and those after a whole step."""
        if len(off) == len(self.map.low):
            return np.zeros(off.shape[1], dtype=bool)
        far = np.max(np.abs(off) / self.full_scale[:, None], axis=0) > HOPELESS * INCONSISTENT
        return np.asarray(far & (self._size(left) > 0.5 * self._size(off)))

    def _free(self, slopes: Array, off: Array, x: Array) -> Array:
        """Return slopes without those of forces at the reach that would lead beyond it: the least squares within."""
        edge = np.abs(x) > REACH - _EDGE
        at = np.flatnonzero(np.any(edge, axis=0))
        x, off, here, edge, slopes = x[:, at], off[:, at], slopes[..., at], edge[:, at], slopes.copy()
        down = times(np.moveaxis(here, 0, 1), off * self.weights[:, None] ** 2)
        for _ in range(len(x) if at.size else 0):  # first those that lead down beyond, then those that step there
            here = np.where(edge & (down * x > 0.0), 0.0, here)
            down = times(self._inverse(here), off)
        slopes[..., at] = here
        return slopes

    def _seen(self, x: Array) -> tuple[Array, Array]:
        """Return inductances (n, m) and their slopes (n, d, m) at scaled forces (d, m)."""
        value, slopes = self.map.value_and_slopes(x.T)
        return value.T, np.moveaxis(slopes, 0, 2)

    @cached_property
    def _starts(self) -> list[tuple[Any, Array, Array, Array]]:
        """Of each part: images of its seeds to look among, the seeds, their inductances and inverse slopes."""
        found = []
        for seeds in self.seeds:
            value, slopes = self._seen(seeds.T)
            found.append((cKDTree(self.domain.whitened(value.T)), seeds.T, value, self._inverse(slopes)))
        return found

    def _started(self, L: Array, part: int) -> tuple[Array, Array, Array]:
        """Return the seed whose inductances are nearest, along what the map varies in, its first step and its size."""
        tree, seeds, value, inverse = self._starts[part]
        asked = np.nan_to_num(self.domain.whitened(L.T), nan=0.0, posinf=1e6, neginf=-1e6)
        near = tree.query(np.clip(asked, -1e6, 1e6))[1]
        off = np.nan_to_num(L - value[:, near])
        return seeds[:, near], _step(seeds[:, near], inverse[..., near], off), self._size(off)


def _step(x: Array, inverse: Array, off: Array) -> Array:
    """Return inverses (d, n, m) times differences (n, m) as steps from x (d, m), shortened to end within the reach."""
    step = times(inverse, off)
    step = step / np.maximum(np.max(np.abs(step), axis=0) / LONGEST, 1.0)
    if np.all(np.abs(x + step) <= REACH):
        return np.asarray(step)
    room = REACH - np.sign(step) * x
    step = np.where(room > _EDGE, step, 0.0)
    share = np.min(room / np.maximum(np.abs(step), 1e-300), axis=0)
    return np.asarray(step * np.minimum(share, 1.0))


def pseudo_inverse(A: Array) -> Array:
    """Return the least-squares inverses (d, n, m) of many small matrices (n, d, m); zero along singular directions."""
    columns = A.shape[1]
    Q, R = np.array(np.moveaxis(A, 1, 0)), np.zeros((columns, columns, A.shape[2]))
    least = _SINGULAR * np.sqrt(np.max([_dot(column, column) for column in Q], axis=0))
    for i in range(columns):
        size = np.sqrt(_dot(Q[i], Q[i]))
        R[i, i] = np.where(size > least, size, np.inf)
        Q[i] /= R[i, i]
        for j in range(i + 1, columns):
            R[i, j] = _dot(Q[i], Q[j])
            Q[j] -= R[i, j] * Q[i]
    for i in reversed(range(columns)):  # R X = Q^T from the last row on, in the place of Q
        for j in range(i + 1, columns):
            Q[i] -= R[i, j] * Q[j]
        Q[i] /= R[i, i]
    return Q


def _dot(a: Array, b: Array) -> Array:
    """Return the sums of products of columns (n, m) in one order, shape (m)."""
    return np.asarray(times(a[None], b)[0])
