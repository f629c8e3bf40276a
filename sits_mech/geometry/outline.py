"""Plates of any outline, holes and slots included: polygons, and their division for eddy currents.

Along every rim the cells are quadrilaterals between the polygon and its offsets inwards, graded like those of a
rectangle; each offset edge is divided evenly, so that mitres take care of corners. What is left inside is
triangulated (Delaunay, on a triangular lattice) by the largest cells; pieces of a rim that are no sides are halved. All
are then divided into even parts, which are levels of one family. The narrowest metal bounds the depth of the
quadrilaterals along all rims; where that is little, all cells are smaller.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from sits_mech.geometry.rims import narrowest, offset
from sits_mech.geometry.sheet_plan import CellPlan, Grading, divided_triangles, graded_axis
from sits_mech.quantities import Array, Integers, Mask, integrals
from sits_mech.scene.parts.elastomer import pillar_middles
from sits_mech.scene.parts.outlines import Loop, circle, edges, first_crossing, inside_loops, signed_area
from sits_mech.scene.sensor import Conductor, Elastomer, Target

_DEPTH = 0.3  # of the rim's quadrilaterals together, over the narrowest width of metal
_SHALLOW, _HALVED = 14.0, 0.5  # largest cell over that depth, but no smaller than a share of what is asked
_TRIES = 8  # times at most that pieces of rims are halved
_TRIANGLE = 1.3  # lattice spacing over the largest side of a quadrilateral
_ROWS = 1.4  # the same at most, of a part, over the mean width that rims leave: two rows across in three parts
_LEVELS = 12  # of the lattice, each twice as coarse
_OFF = 0.6 * (1.0 + 1e-6)  # lattice spacings of its points from the border at least, not as rounding says


@dataclass(frozen=True)
class Outline:
    """A plate's outline, from the target's centre."""

    loops: tuple[Loop, ...]  # corners (x, y) of the rim, then of the holes, none closed [m]

    @property
    def rim(self) -> Array:
        """Corners of the outer rim, shape (k, 2) [m]."""
        return np.array(self.loops[0])

    @property
    def turned(self) -> list[Array]:
        """Corners of all loops, with the metal to the left of each, shape (k, 2) [m]."""
        loops = map(np.array, self.loops)
        return [loop if (signed_area(loop) > 0.0) == (k == 0) else loop[::-1] for k, loop in enumerate(loops)]


def target_outline(target: Target | Conductor) -> Outline:
    """Return the outline of a target, or of a fixed plate from its own middle."""
    return Outline(target.loops) if target.loops else _simple_outline(target.extent, target.is_round)


def widest_angles(part: Target | Conductor) -> Array:
    """Return the largest angles at corners of a plate, inside its metal and outside, pi at least, (2,) [rad]."""
    found = [np.zeros(2)]
    for loop in target_outline(part).turned if not part.is_round else ():
        before, after = loop - np.roll(loop, 1, axis=0), np.roll(loop, -1, axis=0) - loop
        cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        turn = np.arctan2(cross, (before * after).sum(axis=1))
        found.append(np.array([(-turn).max(), turn.max()]))
    return np.asarray(np.pi + np.max(found, axis=0))


def fixed_loops(part: Conductor, up: float = 0.0) -> list[Array]:
    """Return the rims of a fixed plate in place, (m, 3) each, so many half thicknesses above its middle [m]."""
    flat, height = map(np.array, target_outline(part).loops), up * part.thickness / 2
    loops = [np.column_stack([loop, np.full(len(loop), height)]) for loop in flat]
    return [loop @ part.turn.T + part.centre for loop in loops]


def from_above(part: Conductor) -> list[Array]:
    """Return the rims of a fixed plate as seen from above, (m, 2) each; of one that is tilted the rim alone [m]."""
    if part.alpha == part.alpha_x == 0.0:
        return [loop[:, :2] for loop in fixed_loops(part)]
    return [hull(np.vstack([fixed_loops(part, up)[0][:, :2] for up in (-1.0, 1.0)]))]


def hull(points: Array) -> Array:
    """Return the corners of the convex hull of points (n, 2), counter-clockwise."""
    from scipy.spatial import ConvexHull  # half as long to come as a scene to be drawn
    return points[ConvexHull(points).vertices]


def pad_outlines(layer: Elastomer, target: Target | None) -> tuple[Outline, ...]:
    """Return the outlines of an elastomer's pieces, from its centre: of a pad in one piece, or of pillars each."""
    if layer.kind != "pillars":
        return (_simple_outline(layer.extent, layer.is_round),)
    extent, is_round = (layer.extent, False) if target is None else (target.extent, target.is_round)
    d = layer.diameter or 0.0
    rim = np.array(_simple_outline((d, d), True).loops[0])
    middles = pillar_middles(layer, extent, is_round)
    return tuple(Outline((tuple(map(tuple, (rim + middle).tolist())),)) for middle in middles)


def _simple_outline(extent: tuple[float, float], is_round: bool) -> Outline:
    """Return the outline of a disc, as a polygon, or of a rectangle."""
    a, b = extent[0] / 2, extent[1] / 2
    if is_round:
        return Outline((circle(a),))
    return Outline((((-a, -b), (a, -b), (a, b), (-a, b)),))


def outline_plan(outline: Outline, grading: Grading) -> CellPlan:
    """Divide a plate of any outline; ValueError if rims cross or touch, or the metal is too narrow to divide."""
    crossing = first_crossing(outline.loops)
    if crossing is not None:
        x, y = crossing
        raise ValueError(f"outline: rims must not cross themselves or each other; they do at ({x:.4g}, {y:.4g}) m")
    loops = outline.turned
    depth = min(_DEPTH * narrowest(loops), 0.8 * grading.largest)
    smaller = max(min(grading.largest, _SHALLOW * depth), _HALVED * grading.largest)
    grading = replace(grading, largest=smaller)
    rim = Grading(min(grading.first, depth / 2), grading.growth, depth, grading.parts)
    layers = depth - graded_axis(depth, rim)
    cores, shares = [offset(loop, depth) for loop in loops], [_shares(loop, grading) for loop in loops]
    for _ in range(_TRIES):
        points, simplices, cut = _triangulated(list(map(_along, cores, shares)), replace(grading, parts=1))
        if not cut.any():
            return _assembled(loops, shares, layers[::-1], grading.parts, (points, simplices))
        halved = iter(cut.tolist())
        shares = [[_halved(e, [next(halved) for _ in e[1:]]) for e in share] for share in shares]
    raise ValueError("outline: could not be triangulated; rims must not touch and corners must not be needle-sharp")


def _halved(share: Array, some: list[bool]) -> Array:
    """Return where an edge is divided when some of its pieces are halved."""
    after = np.flatnonzero(some) + 1
    return np.insert(share, after, (share[after] + share[after - 1]) / 2.0)


def _along(loop: Array, share: list[Array], parts: int = 1) -> Array:
    """Return nodes along a polygon whose edges are divided somewhere, each piece into so many even parts."""
    each = [np.interp(np.arange(parts * (e.size - 1)) / parts, np.arange(e.size), e) for e in share]
    ends = zip(loop, np.roll(loop, -1, axis=0), each, strict=True)
    return np.vstack([a + (b - a) * part[:, None] for a, b, part in ends])


def _assembled(
    loops: list[Array], shares: list[list[Array]], layers: Array, parts: int, inside: tuple[Array, Integers]
) -> CellPlan:
    """Return rim quadrilaterals and inner triangles, divided into parts."""
    nodes: list[Array] = []
    cells: list[Integers] = []
    marks: list[Integers] = []
    inner: list[Integers] = []
    total = 0
    for number, (loop, share) in enumerate(zip(loops, shares, strict=True)):
        rings = [_along(offset(loop, depth), share, parts) for depth in layers]
        size = rings[0].shape[0]
        base = total + size * np.arange(len(rings))
        here = np.arange(size)
        ahead = (here + 1) % size
        cells += [np.column_stack([a + here, a + ahead, a + size + ahead, a + size + here]) for a in base[:-1]]
        nodes += rings
        marks += [np.full(size, number), np.full(size * (len(rings) - 1), -1)]
        inner.append(base[-1] + here)
        total += size * len(rings)
    points, triangles = divided_triangles(*inside, parts, [each.size // parts for each in inner])
    border = np.concatenate(inner)
    number_of = np.concatenate([border, total + np.arange(len(points) - border.size)])
    cells.append(number_of[np.column_stack([triangles, triangles[:, 2]])])
    every = np.vstack([*nodes, points[border.size :]])
    loop_of = np.concatenate([*marks, np.full(len(every) - total, -1)])
    return CellPlan(every, np.vstack(cells), loop_of, np.eye(2)[None], np.ones((1, 1), complex), np.ones(1))


def _triangulated(cores: list[Array], grading: Grading) -> tuple[Array, Integers, Mask]:
    """Return points, those of the cores' rims first, triangles inside, and which sides of rims are of none."""
    points = np.vstack([*cores, _lattice(cores, grading)])
    from scipy.spatial import Delaunay
    simplices = Delaunay(points).simplices
    starts, count = np.cumsum([0, *map(len, cores)]), len(points)
    rims = [np.arange(a, b) for a, b in pairwise(starts)]
    here, ahead = np.concatenate(rims), np.concatenate([np.roll(rim, -1) for rim in rims])
    sides = np.sort(np.stack([simplices, np.roll(simplices, -1, axis=1)]), axis=0)
    cut = ~np.isin(np.minimum(here, ahead) * count + np.maximum(here, ahead), sides[0] * count + sides[1])
    simplices = simplices[inside_loops(cores, points[simplices].mean(1))]
    area = 2.0 * signed_area(points[simplices])
    simplices = np.where((area > 0)[:, None], simplices, simplices[:, ::-1])[np.abs(area) > 1e-12 * np.abs(area).max()]
    return points, simplices, cut


def _shares(loop: Array, grading: Grading) -> list[Array]:
    """Return where each edge is divided, from 0 to 1, so that no piece is longer than cells may be there."""
    found = []
    for a, b in zip(loop, np.roll(loop, -1, axis=0), strict=True):
        length = float(np.hypot(*(b - a)))
        share = np.linspace(0.0, 1.0, 2 + int(length / grading.largest))
        size = grading.size(np.abs(a + (b - a) * share[:, None]).max(axis=1))
        number = integrals(length / size, share)
        count = max(int(np.ceil(number[-1] - 1e-9)), 1)
        found.append(np.interp(np.arange(count + 1) / count, number / number[-1], share))
    return found


def _lattice(cores: list[Array], grading: Grading) -> Array:
    """Return points of a triangular lattice inside, coarser by twos beyond the reach, none close to the border.

    Nor within the circle of which a piece of the border is a diameter: all of these are sides of Delaunay's triangles.
    """
    low, high = cores[0].min(0), cores[0].max(0)
    from scipy.spatial import cKDTree
    border, found = cKDTree(np.vstack(cores)), [np.empty((0, 2))]
    start, end = edges(cores)
    radii = np.linalg.norm(end - start, axis=1) / 2.0
    width = sum(map(signed_area, cores)) / radii.sum()
    for level in range(_LEVELS):
        spacing = min(_TRIANGLE * grading.largest, _ROWS * width) * 2.0**level / grading.parts
        rows = np.arange(low[1], high[1], spacing * np.sqrt(3) / 2)
        columns = np.arange(low[0] - spacing, high[0], spacing)
        x = columns + spacing / 2 * (np.arange(rows.size)[:, None] % 2)
        points = np.column_stack([x.ravel(), np.repeat(rows, columns.size)])
        doublings = np.log2(grading.size(np.abs(points).max(axis=1, initial=0.0)) / grading.largest)
        points = points[(np.floor(doublings) == level) & inside_loops(cores, points)]
        distance, _ = border.query(points) if points.size else (np.zeros(0), None)
        points = points[distance > _OFF * spacing]
        within = cKDTree(points).query_ball_point((start + end) / 2.0, radii * (1.0 + 1e-6))
        found.append(np.delete(points, np.unique(np.concatenate(within).astype(int)), axis=0))
        if doublings.size == 0 or doublings.max() < level + 1:
            break
    return np.vstack(found)
