"""Fit a smooth map through scattered values: Chebyshev polynomials, degrees chosen by prediction.

    y_c(p) = sum_k a_kc prod_i T_{k_i}(x_i),    x_i = (2 p_i - high_i - low_i) / (high_i - low_i),    a by least squares

The set of indices k is the tensor product 0..P_i, or, for many variables, the simplex sum_i k_i / P_i <= 1. The degrees
P_i are raised one after the other for as long as the map predicts its own points better, all of one value of a
variable (a line of a grid, a single scattered point) left out in turn, except the outermost:

    e_G = (1 - H_GG)^-1 r_G,    r the residual, H the hat matrix, G the points left out  (exact, without fitting anew).

Of all maps tried the one of the fewest terms is taken whose e is within a tenth of the least, root mean square over the
outputs' ranges, where 1e-9 of a range counts as exact: neither noise is followed, nor does rounding, which differs from
processor to processor, choose the degrees. `error` of each output is the largest e; on a grid, if it is more, 1.5 times
the largest difference over the box to the maps of two degrees more, or for three and more variables 1.25 the sum of
these differences: near the edge no line can be left out, and an odd map hides the error of an even degree. P_i stays
three below the number of lines for that. Of up to five lines the map may take all, and what k = 2 degrees less change
is the error of these: the map's own is smaller, by what one degree gains as far as the degrees taken tell,

    e = delta_1 (delta_1 / delta_0)^(1/k),    delta_0 what two degrees less again change, at least delta_1.

Of 400 maps by chance of 5 x 5 values of what a coil over a compressed and sheared layer shows, 98.8 % are within it, of
those of 5 values all, with medians of 0.20 and 0.03 of it; beside the map of fewer degrees 99.5 %, 0.16 and 0.01. With
two lines there is no estimate: the error is infinite. Numbers only, no physics.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sits_mech.maps.chebyshev import chebyshev, design_matrix, terms
from sits_mech.quantities import Array, tensor_grid

_HIGHEST = 12  # degree: beyond it a map over loads has no use
_EXACT = 1e-9  # of an output's range, or of its size: what is smaller may be rounding, and no map is better than that
_SAME = 1e-9  # of half the box: values of a variable that are closer are one
_TIE = 1.001  # of errors: maps that symmetry makes alike differ by less, by rounding
_AS_GOOD = 1.1  # of the least error: within it the fewest terms win
_CACHED = 2**17  # numbers that are summed at a time: they stay in the processor's cache
_FINE = {1: 33, 2: 33, 3: 16, 4: 6, 5: 6}  # values of each of so many variables, among which maps are compared
_LEAST_FREEDOM = 1e-6  # of points left out: below it the others do not decide the map there


@dataclass(frozen=True)
class SmoothMap:
    """A polynomial map from d variables to n outputs over a box."""

    names: tuple[str, ...]
    low: Array  # (d,), of the box
    high: Array  # (d,)
    powers: NDArray[np.int_]  # (k, d), degrees of each term
    coefficients: Array  # (k, n), in units of the outputs
    error: Array  # (n,), largest, of predicting a point left out
    rms: Array  # (n,), root mean square of the same

    @property
    def degrees(self) -> tuple[int, ...]:
        """Highest degree in each variable."""
        return tuple(int(degree) for degree in self.powers.max(axis=0))

    def scaled(self, points: ArrayLike) -> Array:
        """Map points (..., d) of the box to coordinates x in -1..1."""
        return (2.0 * np.asarray(points, dtype=float) - self.high - self.low) / (self.high - self.low)

    def unscaled(self, x: ArrayLike) -> Array:
        """Map coordinates x to the variables' units."""
        return 0.5 * (np.asarray(x, dtype=float) * (self.high - self.low) + self.high + self.low)

    def at(self, points: ArrayLike) -> Array:
        """Return the outputs at points, (..., d) to (..., n); extrapolated outside the box."""
        x = self.scaled(points)
        return np.ascontiguousarray(self._evaluated(x.reshape(-1, len(self.low)), False)[0].T).reshape(
            *x.shape[:-1], -1
        )

    def slopes(self, points: ArrayLike) -> Array:
        """Return the derivatives of outputs by variables at points, (..., d) to (..., n, d)."""
        x = self.scaled(points)
        found = self.value_and_slopes(x.reshape(-1, len(self.low)))[1] * (2.0 / (self.high - self.low))
        return found.reshape(*x.shape[:-1], *found.shape[1:])

    def value_and_slopes(self, x: Array) -> tuple[Array, Array]:
        """Return outputs (m, n) and their derivatives by x (m, n, d), at x (m, d)."""
        found = self._evaluated(x, True)
        return found[0].T, np.moveaxis(found[1:], (0, 2), (2, 0))

    def _evaluated(self, x: Array, slopes: bool) -> Array:
        """Return outputs and, if asked, derivatives at x (m, d), shape (1 or 1 + d, n, m).

        Each point is summed by itself in one order: its digits do not depend on the other points.
        """
        joins, (m, d), n = self._joins, x.shape, self.coefficients.shape[1]
        found = np.empty((1 + slopes * d, n, m))
        block = max(_CACHED // (joins[0][0] * n * (1 + slopes)), 16)
        for first in range(0, m, block):
            here = np.ascontiguousarray(x[first : first + block].T)
            values, rates = self.coefficients[..., None], list[Array]()
            for (count, parts), degree, each in zip(joins, self.degrees, here, strict=True):
                table, rate = chebyshev(each, degree)
                rates = [_joined(old, table, count, parts) for old in rates]
                rates += [_joined(values, rate[1:], count, parts[1:])] if slopes else []
                values = _joined(values, table, count, parts)
            found[:, :, first : first + block] = np.concatenate([values, *rates])
        return found

    @cached_property
    def _joins(self) -> list[tuple[int, list[tuple[slice, Any]]]]:
        """Products of the later variables, and the places of terms of each degree, for each variable."""
        found, powers = [], self.powers
        for _ in range(len(self.low)):
            rest, place = np.unique(powers[:, 1:], axis=0, return_inverse=True)
            ends = np.searchsorted(powers[:, 0], np.arange(powers[:, 0].max() + 2))
            rows = [slice(int(first), int(last)) for first, last in pairwise(ends)]
            whole = [row.stop - row.start == len(rest) for row in rows]
            parts = [(row, slice(None) if all_ else place[row]) for row, all_ in zip(rows, whole, strict=True)]
            found.append((len(rest), parts))
            powers = rest
        return found


def fit_map(names: Sequence[str], points: ArrayLike, values: ArrayLike, *, simplex: bool = False) -> SmoothMap:
    """Fit the smooth map through values (m, n) at points (m, d), on a grid or scattered, over their box.

    `simplex`: fewer terms, for three and more variables. Raise ValueError for unequal shapes, a value that is not
    finite, a variable with one value, or too few points for a plane.
    """
    p, y = np.asarray(points, dtype=float), np.asarray(values, dtype=float)
    _check(names, p, y)
    low, high = p.min(axis=0), p.max(axis=0)
    x = (2.0 * p - high - low) / (high - low)
    size = np.maximum(np.abs(y).max(axis=0), 1e-300)
    sizes = np.ptp(y, axis=0)
    sizes = np.where(sizes > _EXACT * size, sizes, size)
    groups, counts = _lines(x), [int(_numbered(column).max()) + 1 for column in x.T]
    highest = [min(_HIGHEST, n - 3 if n > 5 else max(1, n - 2)) for n in counts]
    degrees = _chosen(x, y / sizes, groups, highest, simplex)
    off = _predicted(design_matrix(x, terms(degrees, simplex)), y, groups)
    if off is None:
        raise ValueError(f"points: must be more, or in general position, for a map of {len(names)}; got {len(p)}")
    error = np.max(np.abs(off), axis=0, initial=0.0)
    if np.prod(counts) == len(p):
        degrees = [n - 1 if n <= 5 and degree >= n - 2 else degree for degree, n in zip(degrees, counts, strict=True)]
        error = np.maximum(error, _uncertainty(x, y, degrees, counts, simplex))
    rms = np.sqrt(np.mean(off**2, axis=0)) if min(counts) > 2 else np.full_like(sizes, np.inf)
    error = np.where(np.isfinite(rms), error, np.inf)
    powers = terms(degrees, simplex)
    coefficients = np.linalg.lstsq(design_matrix(x, powers), y, rcond=None)[0]
    return SmoothMap(tuple(names), low, high, powers, coefficients, error, rms)


def _check(names: Sequence[str], points: Array, values: Array) -> None:
    """Refuse points and values that no map fits."""
    if points.ndim != 2 or values.ndim != 2 or len(points) != len(values) or points.shape[1] != len(names):
        form = f"(m, {len(names)}) and (m, n)"
        raise ValueError(f"points and values: must be of shapes {form}; got {points.shape} and {values.shape}")
    if not (np.all(np.isfinite(points)) and np.all(np.isfinite(values))):
        raise ValueError("points and values: must be finite; got some that are not")
    if len(points) < len(names) + 2:
        raise ValueError(f"points: must be at least {len(names) + 2}; got {len(points)}")
    for name, column in zip(names, points.T, strict=True):
        if np.ptp(column) == 0.0:
            raise ValueError(f"{name}: must take at least two values; got {column[0]:g} alone")


def _lines(x: Array) -> list[NDArray[np.int_]]:
    """Return the points of each value of each variable, except the outermost values."""
    each = map(_numbered, x.T)
    return [np.flatnonzero(numbers == number) for numbers in each for number in range(1, int(numbers.max()))]


def _numbered(column: Array) -> NDArray[np.int_]:
    """Return the index of each point's value among a variable's different values, ascending."""
    order = np.argsort(column, kind="stable")
    numbers = np.zeros(len(column), dtype=int)
    numbers[order[1:]] = np.cumsum(np.diff(column[order]) > _SAME)
    return numbers


def _chosen(x: Array, y: Array, groups: Sequence[NDArray[np.int_]], highest: Sequence[int], simplex: bool) -> list[int]:
    """Return the fewest degrees that predict well, raised by up to two at once for even or odd maps."""
    at = (1,) * x.shape[1]
    tried = {at: _score(x, y, groups, terms(at, simplex))}
    while True:
        raised = [(*at[:i], at[i] + step, *at[i + 1 :]) for i in range(len(at)) for step in (1, 2)]
        raised += [tuple(degree + 1 for degree in at)] if simplex else []  # products need two degrees at once
        raised = [trial for trial in raised if np.all(np.less_equal(trial, highest))]
        scores = {trial: _score(x, y, groups, terms(trial, simplex)) for trial in raised}
        if not scores or not min(scores.values()) < 0.98 * tried[at]:
            return list(_simplest(tried | scores, _AS_GOOD, simplex))
        at, tried = _simplest(scores, _TIE, simplex), tried | scores


def _simplest(scores: Mapping[tuple[int, ...], float], margin: float, simplex: bool) -> tuple[int, ...]:
    """Return the degrees of fewest terms whose error is within a margin of the least; the first of several."""
    least = min(scores.values())
    return min((trial for trial in scores if scores[trial] <= margin * least), key=lambda t: len(terms(t, simplex)))


def _uncertainty(x: Array, y: Array, degrees: Sequence[int], counts: Sequence[int], simplex: bool) -> Array:
    """Return the largest difference over the box to maps of other degrees, summed for many variables."""
    axes = [np.linspace(-1.0, 1.0, _FINE.get(len(degrees), 4))] * len(degrees)
    fine = tensor_grid(*axes).reshape(-1, len(degrees))

    def fitted(i: int, degree: int) -> Array:
        """Return the outputs of the map of another degree in one variable."""
        powers = terms([*degrees[:i], degree, *degrees[i + 1 :]], simplex)
        return design_matrix(fine, powers) @ np.linalg.lstsq(design_matrix(x, powers), y, rcond=None)[0]

    each, whole = list[Array](), fitted(0, degrees[0])
    for i, (degree, count) in enumerate(zip(degrees, counts, strict=True)):
        other = fitted(i, degree + 2 if degree + 2 < count else _fewer(degree))
        each.append(np.abs(whole - other))
        if degree + 2 >= count:
            most = each[i].max(axis=0)
            before = np.maximum(np.abs(other - fitted(i, _fewer(_fewer(degree)))).max(axis=0), most)
            each[i] *= (most / np.maximum(before, 1e-300)) ** (1.0 / max(degree - _fewer(degree), 1))
    together = 1.25 * np.sum(each, axis=0).max(axis=0) if len(degrees) > 2 else 0.0
    return np.asarray(np.maximum(1.5 * np.max(each, axis=(0, 1)), together))


def _fewer(degree: int) -> int:
    """Return two degrees less, one at least of a map that is not constant."""
    return max(degree - 2, min(1, degree - 1), 0)


def _score(x: Array, y: Array, groups: Sequence[NDArray[np.int_]], powers: NDArray[np.int_]) -> float:
    """Return the root mean square error of predicting, at least what counts as exact; inf with too many terms."""
    off = _predicted(design_matrix(x, powers), y, groups)
    return np.inf if off is None or not len(off) else max(float(np.sqrt(np.mean(off**2))), _EXACT)


def _predicted(A: Array, y: Array, groups: Sequence[NDArray[np.int_]]) -> Array | None:
    """Return each point's error when its group is left out; None if a term depends on one group."""
    if A.shape[1] > A.shape[0]:
        return None
    q, r = np.linalg.qr(A)
    diagonal = np.abs(np.diagonal(r))
    if diagonal.min() < 1e-10 * diagonal.max():
        return None
    residual = y - q @ (q.T @ y)
    off = [np.zeros((0, y.shape[1]))]
    for group in groups:
        left = np.eye(len(group)) - q[group] @ q[group].T
        if np.linalg.eigvalsh(left)[0] < _LEAST_FREEDOM:
            return None
        off.append(np.linalg.solve(left, residual[group]))
    return np.concatenate(off)


def _joined(factors: Array, table: Array, count: int, parts: Sequence[tuple[slice, Any]]) -> Array:
    """Sum over one variable's degrees: factors (k, n, 1 or m), a table (P + 1, m), to (count, n, m)."""
    found = np.zeros((count, factors.shape[1], table.shape[1]))
    for k, ((rows, places), factor) in enumerate(zip(parts, table, strict=True)):
        found[places] += factors[rows] * factor if k else factors[rows]  # the first factor is one
    return found
