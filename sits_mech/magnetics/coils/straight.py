"""Inductance of straight tracks in planes z = const: every pair in closed form, their sections by mean distances.

Two tracks with the unit vectors t and t', s and s' along them, in planes a height h apart:

    M = mu0 / (4 pi) t . t' int int ds ds' / sqrt(r^2 + e),    e = GMD^2 - (u^2 + h^2),

r between the centre lines, GMD the geometric mean distance of the two sections at (u, h) (`section.kernels`), u half
the difference of how far the middle of each is to the left of the other's line: on one line, or one smooth curve, it is
zero, along the next turn of a curve the pitch. Parallel tracks, with ``G(x) = x asinh(x / d) - sqrt(x^2 + d^2)``,
d = GMD, ends at 0, l and at a, b:

    int int = G(b) - G(a) - G(b - l) + G(a - l).

At an angle with cosine c and sine n, s and s' from where the lines cross in the plan, ``d^2 = h^2 + e``,
``R^2 = d^2 + s^2 + s'^2 - 2 s s' c``, over both ends of both with signs:

    int int = [s asinh((s' - s c) / p) + s' asinh((s - s' c) / p') - (d / n) atan((d^2 c + s s' n^2) / (d R n))],
    p^2 = d^2 + s^2 n^2,    p'^2 = d^2 + s'^2 n^2,

continued to squares below zero (e of tracks side by side is).

Tracks at right angles have none. A coil's tracks in series: the sum over all pairs. The potential of 1 A, the points at
R1 and R2 from the ends of a track of length l:

    A = t mu0 / (4 pi) ln[(R1 + R2 + l) / (R1 + R2 - l)].

Neglected: vias and the way back between the ends; uneven current (`resistance`); at corners the sections overlap.
Units: H, V s / (A m). Source: F. W. Grover, Inductance Calculations (1946), ch. 6 and 7; the geometric mean distance in
place of the sections leaves out some (width / length) / 20 of a track, and (width / radius)^2 / 30 of a curve.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.constants import mu_0

from sits_mech.geometry.tracks import TrackBars
from sits_mech.magnetics.section.kernels import mean_log
from sits_mech.memory import check_seconds
from sits_mech.quantities import Array, Integers

Potential = Callable[[Array], Array]
PAIRS = 200_000  # at once
_PAIR = 1e-6  # s that one takes: 0.4 to 1.0e-6 seen
_PARALLEL, _ACROSS = 3e-6, 1e-12  # sine and cosine of an angle that is none, or a right one
CACHED = 100_000  # distances of points and ends, or points, held at once: as many as a cache holds
_PRODUCT = 12  # ratios multiplied before their logarithm is taken
_SMALL = 1e-12  # least square of a distance, over that of a length


def linkage(first: TrackBars, second: TrackBars) -> float:
    """Return the flux of 1 A in the first tracks through the second [H]; of the same ones, their self-inductance."""
    total, own = 0.0, first is second
    count = len(first.start), len(second.start)
    check_seconds(
        _PAIR * count[0] * count[1] / (2 if own else 1), f"coils: the inductance of {count[0]} and {count[1]} tracks"
    )
    step = max(1, PAIRS // count[1])
    for begin in range(0, count[0], step):
        rows = np.arange(begin, min(begin + step, count[0]))
        columns = np.arange(begin if own else 0, count[1])
        i, j = (pair.ravel() for pair in np.meshgrid(rows, columns, indexing="ij"))
        if own:
            i, j = i[j >= i], j[j >= i]
        cosine = np.einsum("pk,pk->p", first.way[i], second.way[j])
        kept = np.abs(cosine) > _ACROSS
        i, j, cosine = i[kept], j[kept], cosine[kept]
        M = _pairs(first, second, (i, j), cosine)
        total += float((M * np.where(i == j, 1.0, 2.0)).sum() if own else M.sum())
    return total


def _pairs(first: TrackBars, second: TrackBars, index: tuple[Array, Array], cosine: Array) -> Array:
    """Return M of some pairs [H]."""
    i, j = index
    way, other = first.way[i], second.way[j]
    gap = second.start[j] - first.start[i]
    lengths = first.length[i], second.length[j]
    sine = way[:, 0] * other[:, 1] - way[:, 1] * other[:, 0]
    middle = gap[:, :2] + 0.5 * (lengths[1][:, None] * other - lengths[0][:, None] * way)
    u = np.abs(_left(middle, way) + np.sign(cosine) * _left(middle, other)) / 2
    sections = [(each.width[k], each.thickness[k]) for each, k in ((first, i), (second, j))]
    square = np.exp(2.0 * mean_log(u, gap[:, 2], *sections))
    e = square - u**2 - gap[:, 2] ** 2
    M, flat = np.empty(len(i)), np.abs(sine) < _PARALLEL
    along = np.einsum("pk,pk->p", gap[:, :2], way)
    a, b = along[flat], (along + cosine * lengths[1])[flat]
    d, end = np.sqrt(square[flat]), lengths[0][flat]
    M[flat] = _G(b, d) - _G(a, d) - _G(b - end, d) + _G(a - end, d)
    skew = ~flat
    d2 = gap[skew, 2] ** 2 + e[skew]
    n, c = sine[skew], cosine[skew]
    s = (gap[skew, 0] * other[skew, 1] - gap[skew, 1] * other[skew, 0]) / n
    t = (gap[skew, 0] * way[skew, 1] - gap[skew, 1] * way[skew, 0]) / n
    ends = (-s, lengths[0][skew] - s), (-t, lengths[1][skew] - t)
    M[skew] = c * sum(
        (1.0 if p == q else -1.0) * _corner(ends[0][p], ends[1][q], d2, (c, np.abs(n)))
        for p in (0, 1) for q in (0, 1)
    )
    return mu_0 / (4.0 * np.pi) * M


def _left(place: Array, way: Array) -> Array:
    """Return the distance of places to the left of lines through the origin."""
    return way[:, 0] * place[:, 1] - way[:, 1] * place[:, 0]


def _G(x: Array, d: Array) -> Array:
    """Return G of the module docstring."""
    return x * np.arcsinh(x / d) - np.hypot(x, d)


def _corner(s: Array, t: Array, d2: Array, angle: tuple[Array, Array]) -> Array:
    """Return the bracket of the module docstring, real for d^2 < 0 as well."""
    c, n = angle
    least = _SMALL * (s * s + t * t) + np.finfo(float).tiny
    R = np.sqrt(np.maximum(d2 + s * s + t * t - 2.0 * s * t * c, least))
    d, X = np.sqrt(np.abs(d2)), (d2 * c + s * t * n * n) / (R * n)
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.where(d2 < 0.0, 0.5 * np.log(np.abs((X + d) / (X - d))), np.arctan2(X, d))
    turn = np.where(d > 0.0, turn, 0.0)
    logs = [end * _area(other - end * c, d2 + (end * n) ** 2, least) for end, other in ((s, t), (t, s))]
    return logs[0] + logs[1] - d / n * turn


def _area(x: Array, square: Array, least: Array) -> Array:
    """Return asinh(x / p) by the square of p, or where that is negative what continues it, sign(x) acosh(|x| / |p|)."""
    ratio = x / np.sqrt(np.maximum(np.abs(square), least))
    return np.where(square < 0.0, np.sign(x) * np.arccosh(np.maximum(np.abs(ratio), 1.0)), np.arcsinh(ratio))


def track_potential(tracks: TrackBars, across: tuple[Array, Array], through: tuple[Array, Array]) -> Potential:
    """Return a function that gives A_x and A_y of 1 A in all tracks, (p, 3, q) to (p, 2, q), as their `strands`."""
    strands = [(_strand(strand), share) for strand, share in tracks.strands(across, through)]

    def potential(points: Array) -> Array:
        """Return A at points [m], [V s / (A m)]."""
        p, _, q = points.shape
        flat = np.swapaxes(points, 0, 1).reshape(3, -1)
        A = np.sum([share * _strand_potential(strand, flat) for strand, share in strands], axis=0)
        return np.asarray(mu_0 / (4.0 * np.pi) * np.swapaxes(A.reshape(2, p, q), 0, 1))

    return potential


@dataclass(frozen=True)
class _Strand:
    """Filaments, those of one direction in a row and all one way, and groups of them whose ratios are multiplied."""

    places: Array  # (v, 3) their ends
    start: Integers  # (f,) which ends
    end: Integers
    length: Array  # negative of filaments that were turned
    first: Integers  # (g,) of each group
    ways: Array  # (2, g)


def _strand(tracks: TrackBars) -> _Strand:
    """Return filaments sorted by direction; those that run against it turned, with a negative length."""
    places, number = np.unique(np.vstack([tracks.start, tracks.end]), axis=0, return_inverse=True)
    x, y = np.where(np.abs(tracks.way) > _ACROSS, tracks.way, 0.0).T
    upward = np.where((y > 0.0) | ((y == 0.0) & (x > 0.0)), 1.0, -1.0)
    ways, group, counts = np.unique(
        np.round(upward[:, None] * tracks.way, 12), axis=0, return_inverse=True, return_counts=True
    )
    order = np.argsort(group.ravel(), kind="stable")
    start, end = (part[order] for part in np.split(number.ravel(), 2))
    begins = np.cumsum(counts) - counts
    first = np.concatenate([np.arange(b, b + count, _PRODUCT) for b, count in zip(begins, counts, strict=True)])
    return _Strand(places, start, end, (upward * tracks.length)[order], first, ways[group.ravel()[order][first]].T)


def _strand_potential(strand: _Strand, points: Array) -> Array:
    """Return A over mu0 / (4 pi) at points (3, m), shape (2, m); filaments of one direction share their logarithms."""
    places, length, A = strand.places.T[..., None], strand.length[:, None], np.empty((2, points.shape[1]))
    step = max(1, CACHED // len(strand.places))
    for first in range(0, points.shape[1], step):
        some = slice(first, first + step)
        R = np.sqrt(sum((points[k, some] - places[k]) ** 2 for k in range(3)))
        both = R[strand.start] + R[strand.end]
        ratio = np.multiply.reduceat((both + length) / (both - length), strand.first, axis=0)
        np.einsum("kg,gp->kp", strand.ways, np.log(ratio), out=A[:, some])
    return A
