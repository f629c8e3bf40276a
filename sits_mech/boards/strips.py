"""Find the track that a filled polygon is: the centre line and the width of a strip.

A strip of length l and width w has the area A = l w and the rim P = 2 (l + w), so that w^2 - P w / 2 + A = 0. Its
centre line is where the distance from the rim is greatest: of the Voronoi cells of points along the rim, w / 4 apart,
those edges within the strip that are 0.45 w or more from it (Blum 1967), which leaves out what leads into corners; it
is off by (w / 4)^2 / (8 w), 0.8 % of w. Ends reach half a width further, to the strip's own. A polygon is a strip where
it is more than six times as long as wide and the track that is found covers it to 5 %.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import Voronoi

from sits_mech.boards.lines import thinned
from sits_mech.quantities import Array

_SLENDER, _COVERED = 6.0, 0.05
_STEP, _INSIDE, _OFF = 0.25, 0.45, 0.02  # of the width: points of the rim, middle from the rim, corners left out
_MOST = 200_000  # points of a rim


def strip(points: Array) -> tuple[Array, float] | None:
    """Return the centre line (n, 2) and the width of the strip that a polygon (k, 2) is [m]; None if it is none."""
    return _strip(np.ascontiguousarray(points, dtype=np.float64).tobytes())


@lru_cache(maxsize=256)
def _strip(corners: bytes) -> tuple[Array, float] | None:
    """Return the strip of a polygon's corners; it is asked of the same one twice."""
    import shapely

    whole = shapely.Polygon(np.frombuffer(corners).reshape(-1, 2))
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


def _middle(whole: object, width: float) -> Array | None:
    """Return the longest line of places far from a polygon's rim, and half a width more at its ends."""
    import shapely

    rim = shapely.get_coordinates(shapely.segmentize(whole, _STEP * width).exterior)[:-1]
    scale, origin = 1.0 / width, rim[0]
    found = Voronoi((rim - origin) * scale)
    nodes = found.vertices / scale + origin
    inside = shapely.contains_xy(whole, nodes)
    inside[inside] = shapely.distance(whole.exterior, shapely.points(nodes[inside])) >= _INSIDE * width
    pairs = np.array(found.ridge_vertices)
    pairs = pairs[(pairs >= 0).all(axis=1)]
    i, j = pairs[inside[pairs].all(axis=1)].T
    if not len(i):
        return None
    steps = np.hypot(*(nodes[i] - nodes[j]).T) + 1e-12 * width
    graph = coo_array((steps, (i, j)), shape=(len(nodes),) * 2).tocsr()
    away = dijkstra(graph, directed=False, indices=i[0])
    start = int(np.argmax(np.where(np.isfinite(away), away, -1.0)))
    away, before = dijkstra(graph, directed=False, indices=start, return_predecessors=True)
    path = [int(np.argmax(np.where(np.isfinite(away), away, -1.0)))]
    while path[-1] != start:
        path.append(int(before[path[-1]]))
    line = nodes[path]
    line = thinned(line, _OFF * width)
    if len(line) < 2:
        return None
    first, last = line[0] - line[1], line[-1] - line[-2]
    ends = [a + width / 2 * b / np.hypot(*b) for a, b in ((line[0], first), (line[-1], last))]
    return np.vstack([ends[:1], line[1:-1], ends[1:]]) if len(line) > 2 else np.array(ends)
