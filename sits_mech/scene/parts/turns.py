"""Draw the turns of coils that are no circles: lines about the middle, at a distance outwards of the inner edge.

A turn a away from the inner edge has, about the middle of its sides and before it is turned by `alpha_z`,

    rectangle           half sizes  inner_width / 2 + a,  inner_length / 2 + a,  corners sharp or of the radius
                        corner_radius + a - track_width / 2
    hexagon, octagon    n corners at  (inner_diameter / 2 + a) / cos(pi / n),  two sides across the x axis
    D                   the rectangle's side at -x, at +x half a circle of the radius  inner_length / 2 + a

counter-clockwise from above. Arcs are facets between points a little outside of them, at the radius ``r sqrt(2 x / sin
2x)``, x half the angle of a facet, which keeps the area; one of half a circle's lies across the x axis.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sits_mech.quantities import Array

Coil = Any  # of `coils`, which draws itself by this file
SIDES = {"hexagon": 6, "octagon": 8}
"""Regular polygons."""
_FACETS, _ROUND = 8, 17  # of a quarter of a circle at a corner, of half a circle


def outside(x: float) -> float:
    """Return the radius of a polygon's corners over that of the circle of its area; x half the angle of a facet."""
    return math.sqrt(2.0 * x / math.sin(2.0 * x))


def turn(coil: Coil, away: float) -> Array:
    """Return the corners of a turn in order, not closed, shape (m, 2) [m]."""
    if coil.shape == "rectangle":
        return _rectangle(coil, away)
    flat = _bullet(coil, away) if coil.shape == "D" else _polygon(coil, away)
    c, s = math.cos(coil.alpha_z), math.sin(coil.alpha_z)
    return np.asarray(flat @ np.array([[c, s], [-s, c]])) if coil.alpha_z else flat


def spiral_turns(coil: Coil, angle: float) -> Array:
    """Return the spiral of one layer of a coil of sharp turns about the middle, counter-clockwise from inside, (k, 2).

    It starts half a pitch inwards of the innermost turn and ends half a pitch outwards of the outermost, both at an
    angle [rad], and moves outwards evenly with the angle.
    """
    pitch, first = coil.track_width + coil.track_gap, -coil.track_gap / 2
    x, y = turn(coil, first + pitch * coil.turns / 2).T
    share = np.mod((np.arctan2(y, x) - angle) / (2 * np.pi), 1.0)
    corners = [
        turn(coil, first + pitch * (k + float(share[j])))[j] for k in range(coil.turns) for j in np.argsort(share)
    ]
    ends = [_at_angle(turn(coil, first + pitch * k), angle) for k in (0, coil.turns)]
    return np.vstack([ends[0], *corners, ends[1]])


def _at_angle(rim: Array, angle: float) -> Array:
    """Return where a ray from the middle meets a turn (m, 2) around it, shape (2,)."""
    way, after = np.array([np.cos(angle), np.sin(angle)]), np.roll(rim, -1, axis=0)
    side = way[0] * rim[:, 1] - way[1] * rim[:, 0]
    other = way[0] * after[:, 1] - way[1] * after[:, 0]
    k = int(np.flatnonzero((side <= 0.0) & (other > 0.0))[0])
    return np.asarray(rim[k] - side[k] / (other[k] - side[k]) * (after[k] - rim[k]))


def reach(coil: Coil, away: float) -> tuple[float, float, float]:
    """Return how far a polygon or D reaches from the middle along x, along y and at all [m]."""
    if coil.shape != "D":
        corners = np.abs(turn(coil, away))
        x, y = corners.max(axis=0).tolist()
        return x, y, float(np.hypot(*corners.T).max())
    a, b = coil.inner_width / 2 + away, coil.inner_length / 2 + away
    c, s = math.cos(coil.alpha_z), math.sin(coil.alpha_z)
    x, y = (max((a - b) * abs(u) + b, a * abs(u) + b * abs(v)) for u, v in ((c, s), (s, c)))  # the arc, the corners
    return x, y, math.hypot(a, b)


def _rectangle(coil: Coil, away: float) -> Array:
    """Return a rectangle's turn."""
    half = np.array([coil.inner_width, coil.inner_length]) / 2 + away
    radius = coil.corner_radius + (away - coil.track_width / 2) if coil.corner_radius else 0.0
    corners = []
    for quarter, signs in enumerate(((1, -1), (1, 1), (-1, 1), (-1, -1))):
        corners.append(np.array(signs) * (half - radius) + _arc(radius, (quarter - 1) * np.pi / 2))
    line = np.vstack(corners)
    return np.asarray(line[np.linalg.norm(line - np.roll(line, 1, axis=0), axis=1) > 1e-9 * half.max()])


def _arc(radius: float, start: float, angle: float = np.pi / 2, facets: int = _FACETS) -> Array:
    """Return points of an arc from an angle on; one point where the radius is zero."""
    if radius == 0.0:
        return np.zeros((1, 2))
    theta = start + angle * np.arange(facets + 1) / facets
    out = np.full(theta.size, radius * outside(angle / 2 / facets))
    out[[0, -1]] = radius
    return np.column_stack([out * np.cos(theta), out * np.sin(theta)])


def _polygon(coil: Coil, away: float) -> Array:
    """Return a regular polygon's turn."""
    n = SIDES[coil.shape]
    angle, radius = np.pi * (2 * np.arange(n) - 1) / n, (coil.inner_diameter / 2 + away) / math.cos(math.pi / n)
    return np.asarray(radius * np.column_stack([np.cos(angle), np.sin(angle)]))


def _bullet(coil: Coil, away: float) -> Array:
    """Return a D's turn."""
    a, b = coil.inner_width / 2 + away, coil.inner_length / 2 + away
    round_ = _arc(b, -np.pi / 2, np.pi, _ROUND) + (a - b, 0.0)
    return np.vstack([[[-a, -b]], round_, [[-a, b]]])
