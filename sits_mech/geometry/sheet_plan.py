"""Divide a plate's outline into cells for its eddy currents: quadrilaterals, or triangles, fine at the rim.

A plan may be the fundamental part of a symmetric outline: a quadrant of a rectangle (two mirrors), a sector of a disc
or of a ring (n turns). `group` are the plane's isometries g that take the part to the whole, `characters` the ways in
which a field may go with them,

    J(g x) = chi(g) g J(x),

one class a row; classes never mix. Of a pair of complex-conjugate classes only one is listed, with weight 2.

Triangles repeat their last corner. Corners go counter-clockwise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sits_mech.quantities import Array, Complex, Integers, integrals, tensor_grid

_BEYOND = 0.4  # growth of cells per length beyond the reach
_FAR, _FAR_RIM = 5.0, 0.5  # more of it far off, and that of cells at a rim there: `test_models`, discs of 60 mm
_SMALLEST, _SAMPLES = 1e-3, 2000  # of the integral of their density
_SECTORS = 8, 16  # of a disc, at least and at most, times the parts


@dataclass(frozen=True)
class Grading:
    """Sizes of a plate's cells.

    At a distance d from the rim a cell has the size ``h = 1 / (1/h_in + 1/(a + b d))``, with ``b = ln(growth)`` and a
    such that the cell at the rim is `first`, or far off grows with its distance; nodes stand at equal steps of the
    integral of 1/h. That is a smooth map, on which cells are divided further: the levels of one family.
    """

    first: float  # smallest cell, at the rim [m]
    growth: float  # ratio of neighbouring cells, inwards from the rim
    largest: float  # h_in [m]
    parts: int = 1  # of each cell along each axis, on the same map
    turns: int = 1  # times as many sectors of a disc, the same along its radius
    reach: float = np.inf  # from the middle; cells beyond may slowly outgrow the largest [m]
    far: float = np.inf  # the same; cells beyond grow like their distance, those at a rim too [m]

    def coarser(self, factor: float, parts: int = 1) -> Grading:
        """Return the sizes of cells so many times coarser on the same map, divided into parts."""
        first = self.first * (self.growth**factor - 1.0) / (self.growth - 1.0)
        return replace(self, first=first, growth=self.growth**factor, largest=factor * self.largest, parts=parts)

    def size(self, away: Array) -> Array:
        """Return the size that cells must not exceed some way from the middle [m]."""
        slow, fast = np.maximum(0.0, away - self.reach), np.maximum(0.0, away - self.far)
        return self.largest + _BEYOND * slow + _FAR * fast


@dataclass(frozen=True)
class CellPlan:
    """Cells of a plate's outline, or of the part of it that its symmetry repeats."""

    nodes: Array  # (n, 2) [m]
    cells: Integers  # (m, 4) corners
    loop: Integers  # (n,) -1 inside, 0 on the outer rim, 1, 2, ... on the rims of holes
    group: Array  # (g, 2, 2) isometries, the identity first
    characters: Complex  # (c, g), one class a row
    weights: Array  # (c,) 1 for a class of its own, 2 for a complex-conjugate pair
    tensor: tuple[Array, Array] | None = None  # half-axis nodes of a rectangle's quadrant [m]


def rectangle_plan(width: float, length: float, grading: Grading) -> CellPlan:
    """Return a quadrant of a rectangle, `width` along x and `length` along y [m]."""
    x, y = (graded_axis(size / 2, grading) for size in (width, length))
    nodes = tensor_grid(x, y).reshape(-1, 2)
    i, j = tensor_grid(np.arange(x.size - 1), np.arange(y.size - 1)).reshape(-1, 2).T  # y fastest
    cells = i[:, None] * y.size + j[:, None] + np.array([0, y.size, y.size + 1, 1])
    rim = np.isclose(nodes[:, 0], x[-1], rtol=1e-12, atol=0) | np.isclose(nodes[:, 1], y[-1], rtol=1e-12, atol=0)
    group = np.array([np.diag(signs) for signs in ((1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0))])
    characters = np.array([[1, p, q, p * q] for p in (1, -1) for q in (1, -1)], dtype=complex)
    return CellPlan(nodes, cells, np.where(rim, 0, -1), group, characters, np.ones(4), (x, y))


def disc_plan(diameter: float, grading: Grading, *, orders: int, inner: float = 0.0) -> CellPlan:
    """Return one of n equal sectors of a disc, or of a ring of an inner diameter [m]; classes are the angular orders.

    n is from the largest cell. The polygon has the disc's area. Classes above `orders` are left out.
    """
    radius = diameter / 2
    n = int(np.clip(2 * round(np.pi * radius / grading.largest), *_SECTORS)) * grading.parts * grading.turns
    step = 2 * np.pi / n
    r = _radii(inner / 2, radius, grading) * np.sqrt(step / np.sin(step))
    edges = [np.column_stack([r * np.cos(angle), r * np.sin(angle)]) for angle in (-step / 2, step / 2)]
    m, nodes = r.size, np.vstack(edges)
    low, high = np.arange(m - 1), np.arange(1, m)
    cells, loop = np.column_stack([low, high, m + high, m + low]), np.full(2 * m, -1)
    loop[[m - 1, -1]] = 0
    loop[[0, m]] = -1 if inner == 0.0 else 1
    if inner == 0.0:  # a triangle in the middle
        cells, nodes, loop = np.where(cells > m, cells - 1, cells), np.delete(nodes, m, axis=0), np.delete(loop, m)
        cells[0] = 0, 1, m, m
    turns = step * np.arange(n)
    group = np.array([[[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]] for a in turns])
    order = np.arange(min(orders, n // 2) + 1)
    weights = np.where((order == 0) | (2 * order == n), 1.0, 2.0)
    return CellPlan(nodes, cells, loop, group, np.exp(1j * np.outer(order, turns)), weights)


def _radii(inner: float, outer: float, grading: Grading) -> Array:
    """Return the nodes across a disc, or a ring, finest at its rims [m]."""
    if inner == 0.0:
        return graded_axis(outer, grading)
    middle, half = (outer + inner) / 2, (outer - inner) / 2
    reach, far = (max(each - middle, 0.0) for each in (grading.reach, grading.far))
    out = graded_axis(half, replace(grading, reach=reach, far=far))
    back = graded_axis(half, replace(grading, reach=np.inf, far=np.inf))
    return middle + np.concatenate([-back[:0:-1], out])


def with_rim(plan: CellPlan, growth: tuple[float, float], rim: float) -> CellPlan:
    """Return a rectangle's or disc's plan with its rim moved and the same cells, unchanged within `rim` [m] of it.

    `growth` is of the half sides along x and y, or twice that of the radius [m]; `rim` at most half way to the middle.
    """
    if plan.tensor is not None:
        axes = tuple(axis + own * _moved(axis, rim) for axis, own in zip(plan.tensor, growth, strict=True))
        return replace(plan, nodes=tensor_grid(*axes).reshape(-1, 2), tensor=(axes[0], axes[1]))
    r = np.linalg.norm(plan.nodes, axis=1)
    along = plan.nodes / np.where(r > 0.0, r, 1.0)[:, None]
    return replace(plan, nodes=plan.nodes + growth[0] * _moved(r, rim)[:, None] * along)


def _moved(place: Array, rim: float) -> Array:
    """Return the share of the motion of the rim, the farthest of some places from the middle."""
    end = float(place.max())
    return np.minimum(1.0, place / max(end - rim, 0.5 * end))


def graded_axis(length: float, grading: Grading) -> Array:
    """Return the nodes of ``[0, length]``, finest at the end; their number is a multiple of `parts` [m]."""
    slope = np.log(grading.growth)
    first = grading.first * slope / (grading.growth - 1.0) + _FAR_RIM * max(0.0, length - grading.far)
    d = np.concatenate([[0.0], np.geomspace(_SMALLEST * min(first, length), length, _SAMPLES)])
    number = integrals(1.0 / grading.size(length - d) + 1.0 / (first + slope * d), d)
    count = max(1, round(number[-1])) * grading.parts
    inside = np.interp(np.arange(1, count) * (number[-1] / count), number, d)
    return np.concatenate([[0.0], length - inside[::-1], [length]])


@dataclass(frozen=True)
class Seams:
    """Where a plan meets itself and its images by isometries g; edges count four a cell."""

    nodes: Integers  # (k, 3) g, node a, node b with g a = b, g not the identity
    edges: Integers  # (k, 3) g, edge e, edge f: the cell of e borders the image by g of that of f


def plan_seams(plan: CellPlan) -> Seams:
    """Find the nodes and edges that a plan shares with its images and the edges between its own cells."""
    tolerance = 1e-8 * float(np.abs(plan.nodes).max())
    a, b = plan.nodes[plan.cells].reshape(-1, 2), plan.nodes[np.roll(plan.cells, -1, axis=1)].reshape(-1, 2)
    real = np.flatnonzero(np.abs(a - b).max(1) > 0)
    middle = ((a + b) / 2)[real]
    nodes, edges = [], []
    for k, g in enumerate(plan.group):
        pairs = _meetings(middle, middle @ g.T, tolerance)
        pairs = pairs[pairs[:, 0] < pairs[:, 1]] if k == 0 else pairs
        edges.append(np.column_stack([np.full(len(pairs), k), real[pairs]]))
        if k > 0:
            met = _meetings(plan.nodes, plan.nodes @ g.T, tolerance)
            nodes.append(np.column_stack([np.full(len(met), k), met[:, ::-1]]))
    return Seams(np.vstack([np.empty((0, 3), dtype=int), *nodes]), np.vstack(edges))


def _meetings(points: Array, images: Array, tolerance: float) -> Integers:
    """Return pairs of a point and an image at one place."""
    from scipy.spatial import cKDTree
    found = cKDTree(points).sparse_distance_matrix(cKDTree(images), tolerance, output_type="ndarray")
    return np.column_stack([found["i"], found["j"]]).astype(int)


def standing_nodes(plan: CellPlan, seams: Seams, character: Complex) -> tuple[Integers, Complex]:
    """Return, for each node, the node that stands for it and the factor on that node's stream function.

    ``psi(g x) = chi(g) det(g) psi(x)``, as the current turns; a node that is its own image otherwise has factor 0.
    """
    turn = character * np.round(np.linalg.det(plan.group))
    stands = np.arange(plan.nodes.shape[0])
    factor = np.ones(stands.size, dtype=complex)
    for g, node, image in seams.nodes.tolist():
        if image == node and abs(turn[g] - 1.0) > 1e-9:
            factor[node] = 0.0
        elif image > node and stands[image] == image:
            stands[image], factor[image] = node, turn[g]
    return stands, factor


def divided_triangles(points: Array, simplices: Integers, parts: int, rims: list[int]) -> tuple[Array, Integers]:
    """Return nodes and triangles, where each side of some triangles is divided into so many even parts.

    Nodes along rims of some numbers of corners come first, in their order.
    """
    j, i = (each.ravel() for each in np.meshgrid(*2 * [np.arange(parts + 1)]))
    i, j = i[i + j <= parts], j[i + j <= parts]
    place = np.full((parts + 2, parts + 2), -1)
    place[i, j] = np.arange(i.size)
    up, down = i + j < parts, i + j < parts - 1
    a, b, c, d = place[i, j], place[i + 1, j], place[i, j + 1], place[i + 1, j + 1]
    small = np.vstack([np.column_stack([a, b, c])[up], np.column_stack([b, d, c])[down]])
    corner, steps, first = list[Integers](), np.arange(parts), 0
    for size in rims:
        here = first + np.arange(size)
        corner.append(np.column_stack([here, np.roll(here, -1), np.roll(here, -1)]).repeat(parts, axis=0))
        first += size
    weights = np.vstack([np.tile(np.column_stack([parts - steps, steps, 0 * steps]), (first, 1)),
                         np.tile(np.column_stack([parts - i - j, i, j]), (len(simplices), 1))])
    corners = np.vstack([*corner, simplices.repeat(i.size, axis=0)])
    keys = np.sort(np.where(weights > 0, corners * (parts + 1) + weights, -1), axis=1)
    _, one, which = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(one)  # as they come
    number = np.argsort(order)[which.ravel()][first * parts :]
    nodes = np.einsum("ik,ikx->ix", weights[one[order]] / parts, points[corners[one[order]]])
    return nodes, number.reshape(len(simplices), -1)[:, small].reshape(-1, 3)
