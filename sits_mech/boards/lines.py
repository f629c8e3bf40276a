"""Lines of copper as points: arcs as chords, corners that may go, lengths; the track that a filled polygon is.

Arcs are as many chords as keep within a length of them. The arc through a, m, b has its centre c at equal
distances r of the three. A chord over the angle phi is off by

    e = r (1 - cos(phi/2)) = 2 r sin^2(phi/4),    so that   n = ceil(|theta| / (4 arcsin sqrt(e / (2 r))))

equal chords hold e over the whole angle theta, from a over m to b. Corners lie on the arc. Three points in a line
are that line. Of a polyline, corners within e of the line through those that stay go (Ramer 1972, Douglas and Peucker
1973): arcs that a board has as short straight tracks need no more of them than true ones.

A strip of length l and width w has the area A = l w and the rim P = 2 (l + w), so that w^2 - P w / 2 + A = 0. Its
centre line is where the distance from the rim is greatest: of the Voronoi cells of points along the rim, w / 4 apart,
those edges within the strip that are 0.45 w or more from it (Blum 1967), which leaves out what leads into corners; it
is off by (w / 4)^2 / (8 w), 0.8 % of w, and 0.14 w shorter at a right angle. Ends reach half a width further, to the
strip's own. A polygon is a strip where it is more than six times as long as wide and the track found covers it to 5 %.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import Voronoi

from sits_mech.boards.copper import GRID, Track, board_point
from sits_mech.quantities import Array
from sits_mech.units import SceneError

_STRAIGHT = 1e-7  # height of the arc over its chord, below which it is a line
_SLENDER, _COVERED = 6.0, 0.05  # length over width of what is a strip; share of its area that a strip may miss
_STEP, _INSIDE, _OFF = 0.25, 0.45, 0.02  # of the width: points of the rim, middle from the rim, corners left out
_MOST = 200_000  # points of a rim


def flattened(track: Track, chord_error: float, where: str) -> Array:
    """Return the centre line of a track as points (n, 2) [m], the ends as they are, arcs within `chord_error` [m].

    Raise SceneError, naming `where`, when an arc has no radius, or begins where it ends.
    """
    points = track.points
    if len(points) == 2:
        return points
    a, b = points[1] - points[0], points[2] - points[0]
    short = np.hypot(*np.transpose([a, b - a, b])) < GRID
    if short.any():
        came = "three equal points" if short[0] and short[2] else "two equal points"
        raise SceneError(f"{where}: the arc at {board_point(points[0])} must have a radius and two ends; got {came}")
    cross = float(a[0] * b[1] - a[1] * b[0])
    along = float(a @ b) / float(b @ b)
    if abs(cross) <= _STRAIGHT * float(b @ b) and 0.0 < along < 1.0:
        return points[[0, 2]]
    if abs(cross) <= 1e-12 * float(b @ b):
        raise SceneError(
            f"{where}: the arc at {board_point(points[0])} must pass its middle between its ends; got a line"
        )
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


def longest_way(pairs: NDArray[np.int64], lengths: Array, count: int) -> list[int]:
    """Return the longest of the shortest ways between two of `count` places, from pairs (n, 2) that are joined."""
    graph = coo_array((lengths, tuple(pairs.T)), shape=(count, count)).tocsr()
    path, before = [int(pairs[0, 0])], np.zeros((1, 0), dtype=np.int32)
    for _ in range(2):  # the farthest from anywhere, and the farthest from that
        away, before = dijkstra(graph, directed=False, indices=np.array(path), return_predecessors=True)
        path = [int(np.argmax(np.where(np.isfinite(away[0]), away[0], -1.0)))]
    while before[0, path[-1]] >= 0:
        path.append(int(before[0, path[-1]]))
    return path


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


def strip(points: Array) -> tuple[Array, float] | None:
    """Return the centre line (n, 2) and the width of the strip that a polygon (k, 2) is [m]; None if it is none."""
    import shapely

    whole = shapely.Polygon(points)
    half, area = whole.length / 2, whole.area
    if not (whole.is_valid and area > 0.0 and half**2 > 4.0 * area):
        return None
    width = (half - math.sqrt(half**2 - 4.0 * area)) / 2
    if half < (_SLENDER + 1.0) * width or half > _MOST * _STEP * width / 2:
        return None
    line = _middle(whole, width)
    if line is None:
        return None
    shape = shapely.LineString(line).buffer(width / 2, cap_style="flat", join_style="mitre")
    return (line, width) if shape.symmetric_difference(whole).area < _COVERED * area else None


def _middle(whole: Any, width: float) -> Array | None:
    """Return the longest line of places far from a polygon's rim, and half a width more at its ends."""
    import shapely

    rim = shapely.get_coordinates(shapely.segmentize(whole, _STEP * width).exterior)[:-1]
    scale, origin = 1.0 / width, rim[0]
    found = Voronoi((rim - origin) * scale)
    nodes = found.vertices / scale + origin
    inside = shapely.contains_xy(whole, nodes)
    inside[inside] = shapely.distance(whole.exterior, shapely.points(nodes[inside])) >= _INSIDE * width
    pairs = np.array(found.ridge_vertices)
    pairs = pairs[(pairs >= 0).all(axis=1) & inside[pairs].all(axis=1)]
    if not len(pairs):
        return None
    steps = np.hypot(*np.diff(nodes[pairs], axis=1)[:, 0].T) + 1e-12 * width
    line = thinned(nodes[longest_way(pairs, steps, len(nodes))], _OFF * width)
    if len(line) < 2:
        return None
    first, last = line[0] - line[1], line[-1] - line[-2]
    ends = [a + width / 2 * b / np.hypot(*b) for a, b in ((line[0], first), (line[-1], last))]
    return np.vstack([ends[:1], line[1:-1], ends[1:]]) if len(line) > 2 else np.array(ends)
