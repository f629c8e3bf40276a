"""Lines of copper as points: arcs as chords, corners that may go, lengths.

Arcs are as many chords as keep within a length of them. The arc through a, m, b has its centre c at equal
distances r of the three. A chord over the angle phi is off by

    e = r (1 - cos(phi/2)) = 2 r sin^2(phi/4),    so that   n = ceil(|theta| / (4 arcsin sqrt(e / (2 r))))

equal chords hold e over the whole angle theta, from a over m to b. Corners lie on the arc. Three points in a line
are that line. Of a polyline, corners within e of the line through those that stay go (Ramer 1972, Douglas and Peucker
1973): arcs that a board has as short straight tracks need no more of them than true ones.
"""

from __future__ import annotations

import math

import numpy as np

from sits_mech.boards.copper import Track, place
from sits_mech.quantities import Array
from sits_mech.units import SceneError

_STRAIGHT = 1e-7  # height of the arc over its chord, below which it is a line
_SAME = 1e-9  # points closer than this are one: the board's own step is 1 nm [m]


def flattened(track: Track, chord_error: float, where: str) -> Array:
    """Return the centre line of a track as points (n, 2) [m], the ends as they are, arcs within `chord_error` [m].

    Raise SceneError, naming `where`, when an arc has no radius, or begins where it ends.
    """
    points = track.points
    if len(points) == 2:
        return points
    a, b = points[1] - points[0], points[2] - points[0]
    short = np.hypot(*np.transpose([a, b - a, b])) < _SAME
    if short.any():
        came = "three equal points" if short[0] and short[2] else "two equal points"
        raise SceneError(f"{where}: the arc at {place(points[0])} must have a radius and two ends; got {came}")
    cross = float(a[0] * b[1] - a[1] * b[0])
    along = float(a @ b) / float(b @ b)
    if abs(cross) <= _STRAIGHT * float(b @ b) and 0.0 < along < 1.0:
        return points[[0, 2]]
    if abs(cross) <= 1e-12 * float(b @ b):
        raise SceneError(f"{where}: the arc at {place(points[0])} must pass its middle between its ends; got a line")
    squares = np.array([a @ a, b @ b])
    arm = np.array([b[1] * squares[0] - a[1] * squares[1], a[0] * squares[1] - b[0] * squares[0]]) / (2.0 * cross)
    radius, first = float(np.hypot(*arm)), math.atan2(-arm[1], -arm[0])
    last = math.atan2(b[1] - arm[1], b[0] - arm[0])
    theta = (last - first) % (2.0 * math.pi) if cross > 0.0 else -((first - last) % (2.0 * math.pi))
    step = 4.0 * math.asin(math.sqrt(min(chord_error / (2.0 * radius), 0.5)))
    angle = first + theta * np.linspace(0.0, 1.0, math.ceil(abs(theta) / step) + 1)
    found = points[0] + arm + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    found[[0, -1]] = points[[0, 2]]
    return np.asarray(found)


def thinned(points: Array, error: float) -> Array:
    """Return a polyline's (n, 2) ends and as many of its corners as keep all others within `error` of it [m]."""
    kept = np.zeros(len(points), dtype=bool)
    kept[[0, -1]] = True
    left = [(0, len(points) - 1)]
    while left:
        first, last = left.pop()
        inside, step = points[first + 1 : last] - points[first], points[last] - points[first]
        if not len(inside):
            continue
        share = np.clip((inside @ step) / max(float(step @ step), 1e-30), 0.0, 1.0)
        away = np.hypot(*(inside - share[:, None] * step).T)
        farthest = int(np.argmax(away))
        if away[farthest] > error:
            middle = first + 1 + farthest
            kept[middle] = True
            left += [(first, middle), (middle, last)]
    return points[kept]


def length_of(points: Array) -> float:
    """Return the length of a polyline [m]."""
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def spaced(points: Array, least: float) -> Array:
    """Return the points of a line without those nearer than `least` to the one before, its ends kept [m]."""
    kept = [points[0]]
    for point in points[1:-1]:
        if np.hypot(*(point - kept[-1])) > least:
            kept.append(point)
    if len(kept) > 1 and np.hypot(*(points[-1] - kept[-1])) <= least:
        kept.pop()
    return np.array([*kept, points[-1]])


def turns_of(points: Array, least: float) -> float:
    """Return how often a polyline (n, 2) turns in steps above `least` [m]: the reach of its direction over 2 pi.

    A meander turns by a half. Shorter steps, as at a via, may lead back.
    """
    steps = np.diff(spaced(points, least), axis=0) if len(points) > 1 else np.zeros((0, 2))
    steps = steps[np.hypot(*steps.T) > 0.0]
    angle = np.unwrap(np.arctan2(*steps.T[::-1])) if len(steps) else np.zeros(1)
    return float(np.ptp(angle)) / (2.0 * math.pi)
