"""Where must a function be known for a smooth map of it to hold? Points are added where two maps of it disagree most.

Any function from d variables to n outputs over a box. After a first grid of Chebyshev points, in each round

    fit      the polynomial map P (`surrogate`) and a rival Q, cubic radial functions through all points
    choose   of a fine grid the points where |P - Q|, over each output's range, is largest, a distance apart
    test     P foretells them; then they are solved: what P was off by is an honest error, of points thought the worst
    stop     when that is under the tolerance for two rounds one after the other, or under half of it, and so is the
             root mean square of what P is off by at points that are left out

A point that fails (NaN) is left out and not asked again. Where the function is its own mirror image, every point gives
a second one for nothing. Numbers only, no physics.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import RBFInterpolator

from sits_mech.maps.surrogate import SmoothMap, fit_map
from sits_mech.quantities import Array

_FINE = 25  # candidates along each variable
_APART = 0.15  # between points of one round, of half the box
_TIE = 0.99  # of the largest disagreement: points that symmetry makes alike differ by less, by rounding


@dataclass(frozen=True)
class Sampling:
    """What was asked of a function, and the map through it.

    Attributes
    ----------
    points : ndarray, shape (m, d)
        Where it is known, mirror images included.
    values : ndarray, shape (m, n)
    solves : int
        How often the function was called for, points that failed included.
    failed : ndarray, shape (k, d)
        Points without a value.
    map : SmoothMap
    error : float
        Largest error over each output's range, of the last points before they were known, one or two rounds of them.
    reached : bool
        Whether it is under the tolerance.
    history : tuple of (int, float)
        Solves so far and error, for each round.
    """

    points: Array
    values: Array
    solves: int
    failed: Array
    map: SmoothMap
    error: float
    reached: bool
    history: tuple[tuple[int, float], ...]


@dataclass(frozen=True)
class Mirror:
    """How a function answers the mirrored point: signs of the variables, order and signs of the outputs."""

    variables: tuple[int, ...]
    order: tuple[int, ...]
    signs: tuple[int, ...]

    def point(self, points: Array) -> Array:
        """Return the mirrored points (m, d)."""
        return np.asarray(points * np.array(self.variables))

    def value(self, values: Array) -> Array:
        """Return the values (m, n) at the mirrored points."""
        return np.asarray(values[:, list(self.order)] * np.array(self.signs))


def sample(
    function: Callable[[Array], Array], names: Sequence[str], box: tuple[Sequence[float], Sequence[float]], *,
    tolerance: float = 1e-3, most: int = 100, mirror: Mirror | None = None, batch: int = 3,
) -> Sampling:  # fmt: skip
    """Return a map of a function to a tolerance, from as few points as it takes.

    Parameters
    ----------
    function : callable
        Points (m, d) to values (m, n); NaN where it fails.
    names : sequence of str
        Of the d variables.
    box : tuple
        Their least and greatest values.
    tolerance : float
        Of the map, over each output's range.
    most : int
        Points asked for at most; `reached` tells whether they were enough.
    mirror : Mirror, optional
        For a function that is its own mirror image over a box that is, too.
    batch : int
        Points of one round.

    Raises
    ------
    ValueError
        When the box is empty, the tolerance not positive, or too few points have a value.
    """
    low, high = (np.asarray(end, dtype=float) for end in box)
    if not (np.all(high > low) and tolerance > 0.0):
        raise ValueError(f"box and tolerance: must be low < high and positive; got {low}, {high}, {tolerance}")
    if mirror is not None and not np.allclose(sum(mirror.point(end) - end for end in (low, high)), 0.0):
        raise ValueError(f"box: must be its own mirror image; got {low} to {high}")
    asked = _first(low, high, mirror)
    state = _answered(function, asked, mirror)
    history: list[tuple[int, float]] = []
    while True:
        found = fit_map(names, state[0], state[1])
        scale = np.ptp(state[1], axis=0)
        wanted = _worst(found, state, asked, (low, high), mirror)[: min(batch, most - len(asked))]
        off = _settled([error for _, error in history], float(np.max(found.rms / scale)), tolerance)
        if off <= tolerance or not len(wanted):
            return Sampling(*state[:2], len(asked), state[2], found, off, off <= tolerance, tuple(history))
        more = _answered(function, wanted, mirror)
        missed = np.abs(found.at(more[0]) - more[1]) / scale if len(more[0]) else np.full((1, 1), np.inf)
        asked = np.vstack([asked, wanted])
        state = np.vstack([state[0], more[0]]), np.vstack([state[1], more[1]]), np.vstack([state[2], more[2]])
        history.append((len(asked), float(missed.max())))


def _settled(errors: Sequence[float], rms: float, tolerance: float) -> float:
    """Return the error to report: over the tolerance until the last rounds are under it."""
    if not errors:
        return np.inf
    if errors[-1] <= 0.5 * tolerance and rms <= tolerance:
        return errors[-1]
    return max(*errors[-2:], errors[-1], rms) if len(errors) > 1 else max(errors[-1], 2.0 * tolerance)


def _first(low: Array, high: Array, mirror: Mirror | None) -> Array:
    """Return the first points: three Chebyshev points along each variable, five along a mirrored one."""
    turned = (1,) * len(low) if mirror is None else mirror.variables
    axes = [_nodes(5 if sign < 0 else 4) for sign in turned]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(low))
    return _half(0.5 * (x * (high - low) + high + low), mirror)


def _nodes(count: int) -> Array:
    """Return Chebyshev points from -1 to 1, exactly symmetric."""
    x = np.cos(np.linspace(np.pi, 0.0, count))
    return np.asarray(0.5 * (x - x[::-1]))


def _half(points: Array, mirror: Mirror | None) -> Array:
    """Return the points whose mirror image is not among them."""
    if mirror is None:
        return points
    turned = np.flatnonzero(np.array(mirror.variables) < 0)[0]
    return points[points[:, turned] >= -1e-12]


def _answered(function: Callable[[Array], Array], points: Array, mirror: Mirror | None) -> tuple[Array, Array, Array]:
    """Return the points that have values, with their mirror images, the values, and the points that failed."""
    values = np.asarray(function(points), dtype=float)
    good = np.isfinite(values).all(axis=1)
    known, found = points[good], values[good]
    if mirror is not None:
        image = mirror.point(known)
        new = np.max(np.abs(image - known), axis=1, initial=0.0) > 0.0
        known, found = np.vstack([known, image[new]]), np.vstack([found, mirror.value(found)[new]])
    return known, found, points[~good]


def _worst(
    found: SmoothMap, state: tuple[Array, Array, Array], asked: Array, box: tuple[Array, Array], mirror: Mirror | None
) -> Array:
    """Return points of a fine grid where two maps disagree most, apart from each other and from the known."""
    low, high = box
    axes = [_nodes(_FINE)] * len(low)
    fine = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(low))
    fine = _half(0.5 * (fine * (high - low) + high + low), mirror)
    scale = np.ptp(state[1], axis=0)
    rival = RBFInterpolator(found.scaled(state[0]), state[1] / scale, kernel="cubic", degree=1)
    doubt = np.max(np.abs(found.at(fine) / scale - rival(found.scaled(fine))), axis=1)
    half = 0.5 * (high - low)
    free = np.array([np.max(np.abs((asked - spot) / half), axis=1).min() for spot in fine]) > _APART
    chosen: list[Array] = []
    while np.any(free):
        spot = fine[np.argmax(free & (doubt >= _TIE * doubt[free].max()))]
        chosen.append(spot)
        free &= np.max(np.abs((fine - spot) / half), axis=1) > _APART
    return np.array(chosen).reshape(-1, len(low))
