"""Which points of a grid need solving? As many as a smooth map through them takes to predict the others.

A function from d variables to n outputs is solved at 5, 9, 17, ... of its values of each variable, ends included, until
the polynomial through those points (`surrogate`, least squares) predicts them well enough, each line of them left out
in turn. The points between come of cubic splines through the solved ones, a tensor product without free ends, so that
no step stands between both kinds.

A variable of fewer than seven values keeps them all, and has a polynomial for each. With fewer than two variables of
more values nothing is left out, nor is it where a point fails. Numbers only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline

from sits_mech.maps.surrogate import fit_map
from sits_mech.quantities import Array

Axes = Mapping[str, Sequence[float]]
"""The values of each variable, ascending."""
_FEWEST = 7  # values of a variable from which on some may be left out


@dataclass(frozen=True)
class SolvedPart:
    """A grid solved at some of its points, which predict the others.

    Attributes
    ----------
    axes : mapping
        The values that were solved.
    values : ndarray, shape (*sizes, n)
        The outputs there.
    error : ndarray, shape (n,)
        Of the smooth map between them.
    """

    axes: Axes
    values: Array
    error: Array


def solve_part(
    solve: Callable[[Axes], Array], axes: Axes, *, tolerance: float, weights: ArrayLike = 1.0
) -> SolvedPart | None:
    """Return the coarsest part of a grid that predicts the rest, or None where all of it is to be solved.

    Parameters
    ----------
    solve : callable
        Part of the grid to the outputs on it, shape (*sizes, n); NaN where it fails. Each part holds those before it.
    axes : mapping of str to sequence
        The grid.
    tolerance : float
        Of the map, relative to the largest range of an output.
    weights : array_like, shape (n,)
        What makes outputs comparable, such as the lever of an angle.
    """
    for part in coarser(axes):
        values = solve(part)
        if not np.all(np.isfinite(values)):
            return None
        weight = np.broadcast_to(np.asarray(weights, dtype=float), values.shape[-1:])
        ranges = np.ptp(values.reshape(-1, values.shape[-1]), axis=0)
        wanted = tolerance * float(np.max(ranges * weight))
        sizes = np.maximum(ranges, wanted / np.maximum(weight, 1e-300))  # what varies less has no say in the degrees
        error = _prediction_error(part, values, sizes, _long(axes))
        if np.max(error * weight) <= wanted:
            return SolvedPart(part, values, error)
    return None


def coarser(axes: Axes) -> Iterator[dict[str, list[float]]]:
    """Yield the coarser grids, each with nearly twice the values of the one before along every long variable."""
    if len(_long(axes)) < 2:
        return
    count = 5
    while count < max(len(values) for values in axes.values()):
        yield {name: _some(values, count) for name, values in axes.items()}
        count = 2 * count - 1


def interpolated(part: Axes, values: Array, axes: Axes, *, degree: int = 3) -> Array:
    """Return splines through the points of a part of a grid, on all of it.

    Parameters
    ----------
    part : mapping
        The values that are known of each variable.
    values : ndarray, shape (*sizes, ...)
        There.
    axes : mapping
        The whole grid, with the same variables.
    degree : int
        Less along a variable with fewer values than it takes.
    """
    found = np.asarray(values, dtype=float)
    for k, name in enumerate(part):
        if len(part[name]) < len(axes[name]):
            spline = make_interp_spline(part[name], found, k=min(degree, len(part[name]) - 1), axis=k)
            found = spline(axes[name])
    return found


def _prediction_error(part: Axes, values: Array, scale: Array, mapped: Sequence[str]) -> Array:
    """Return how far maps over some variables, one for each point of the others, miss what is left out, shape (n,)."""
    own = [k for k, name in enumerate(part) if name in mapped]
    front = np.moveaxis(values, own, range(len(own)))
    each = front.reshape(int(np.prod(front.shape[: len(own)])), -1)
    points = np.stack(np.meshgrid(*(part[name] for name in mapped), indexing="ij"), -1).reshape(-1, len(mapped))
    found = fit_map(mapped, points, each, scale=np.tile(scale, each.shape[1] // len(scale)))
    return np.asarray(found.error.reshape(-1, len(scale)).max(axis=0))


def _long(axes: Axes) -> list[str]:
    """Return the variables with many values."""
    return [name for name, values in axes.items() if len(values) >= _FEWEST]


def _some(values: Sequence[float], count: int) -> list[float]:
    """Return about evenly chosen values, ends included; of a list that mirrors itself, one that does; of six all."""
    last = len(values) - 1
    half = np.round(np.linspace(0.0, last / 2.0, (min(count, last + 1) + 1) // 2)).astype(int)
    return [values[i] for i in sorted({*half.tolist(), *(last - half).tolist()})]
