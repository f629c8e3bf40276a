"""Divergence-free currents of a plate: a stream function on each sheet, and loops that pass from sheet to sheet.

The plate is its plan's cells times horizontal sheets. Unknowns [A]:

- psi at the plan's nodes, one a sheet: the current across a cell's edge from a to b is ``psi_b - psi_a`` outwards;
  psi = 0 on the outer rim, one value on the rim of each hole; of a ring in sectors only in the class that all turns
  leave as it is;
- loops in vertical planes: out of one cell and into its neighbour in a sheet, back in the sheet above, up and down
  between. They let current out on one face return on the other. They are taken only in the cells next to the
  rim, along a spanning tree of them: everywhere else, and around closed chains, psi spans the same currents or
  the vertical current is negligible (it decays like the thinner of thickness and skin depth).

A cell's face currents F determine its current moment exactly, whatever its shape (the field inside has uniform
divergence): integral of J over the cell = ``sum_i F_i (m_i - c)`` with the faces' centres m_i and the cell's c. The
moments carry the inductance; the resistance adds the linear variation between opposite faces (its square over 12),
without which alternating patterns would cost nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import minimum_spanning_tree

from sits_mech.geometry.sheet_plan import CellPlan, Seams, plan_seams, standing_nodes
from sits_mech.quantities import Array, Complex, Integers, Mask
from sits_mech.scene.parts.outlines import signed_area

_LOOKED_AT, _BLOCK = 10_000_000, 512  # cells by edges of rims; cells at once


@dataclass(frozen=True)
class Loops:
    """Operators from the unknowns of one symmetry class to its cells (sheet fastest), all sparse."""

    moments: tuple[sp.csr_array, sp.csr_array, sp.csr_array]  # x, y, z of the integral of J over a cell [A m per A]
    uneven: sp.csr_array  # squares of rows, summed: dissipation of the linear variation, times conductivity [m^-1/2]
    volume: Array  # of the cells [m^3]

    @property
    def unknowns(self) -> int:
        """Number of unknowns."""
        return int(self.uneven.shape[1])


@dataclass(frozen=True)
class Sums:
    """What all classes of a plan have in common: sums over cells of the outward currents of their edges.

    `of_edges` has x and y moments [m], the net current, and both weighted sums of opposite edges, one below the other.
    """

    plan: CellPlan
    seams: Seams
    area: Array  # (n,) of the cells [m^2]
    at_rim: Mask  # (n,) cells that take vertical loops
    of_edges: sp.csr_array  # (5 n, edges)

    def flows(self, character: Complex) -> Flows:
        """Return the sums of the classes that have a row of `plan.characters`."""
        psi = self.of_edges @ _stream_flux(self.plan, self.seams, character)
        across = self.of_edges @ _tree_flux(self.plan, self.seams, character, self.at_rim)
        return Flows(self.area, psi.tocoo(), across.tocoo())


@dataclass(frozen=True)
class Flows:
    """Sums of a plan, as of `Sums`, by the unknowns of one sheet."""

    area: Array  # (n,) of the cells [m^2]
    psi: sp.coo_array  # (5 n, unknowns) of the stream function, without net current
    across: sp.coo_array  # (5 n, unknowns) of the vertical loops

    def loops(self, heights: Array, mirror: int) -> Loops:
        """Return the loops of one class on sheets of some heights (l,) of the upper half, from the middle plane up [m].

        `mirror` is +1 if the lower half carries the same in-plane currents as the upper, -1 if the opposite.
        """
        n, count = self.area.size, heights.size
        sheets, rises, drops = _interfaces(count, mirror)
        columns = self.psi.shape[1] * count, self.across.shape[1] * sheets.shape[1]
        thin = 1.0 / np.sqrt(12.0 * heights)[:, None]

        def rows(first: int, last: int, psi: Array, across: Array, scale: Array | None = None) -> sp.csr_array:
            """Return rows of the sums first to last of all cells, on the sheets by both operators."""
            parts = [(self.psi, psi, 0), (self.across, across, columns[0])]
            each = [_on_sheets(sums, (first * n, last * n), op, start, scale) for sums, op, start in parts]
            values, places = (np.concatenate(both, axis=-1) for both in zip(*each, strict=True))
            return sp.csr_array((values, (places[0], places[1])), shape=((last - first) * n * count, sum(columns)))

        eye, none = np.eye(count), np.zeros((count, count))
        vertical = np.sqrt(heights / 12.0)[:, None] * drops
        uneven = rows(3, 5, thin * eye, thin * sheets), rows(2, 3, none, vertical, 1.0 / np.sqrt(self.area))
        moments = rows(0, 1, eye, sheets), rows(1, 2, eye, sheets), rows(2, 3, none, -heights[:, None] * rises)
        return Loops(moments, sp.csr_array(sp.vstack(uneven)), np.outer(self.area, heights).ravel())


def plan_sums(plan: CellPlan, depth: float) -> Sums:
    """Return what all classes of a plan have in common.

    Vertical loops are taken in the cells at the rim and those whose middle is no further from it than `depth` [m].
    """
    corners = plan.nodes[plan.cells]
    area, centre = signed_area(corners), _centroids(corners)
    lever = (corners + np.roll(corners, -1, axis=1)) / 2 - centre[:, None, :]
    net = sp.kron(sp.eye_array(area.size), np.ones((1, 4)))
    rows, columns = np.repeat(np.arange(area.size), 4), np.arange(4 * area.size)
    x, y = (sp.csr_array((lever[..., k].ravel(), (rows, columns)), shape=net.shape) for k in (0, 1))
    of_edges = sp.csr_array(sp.vstack([x, y, net, _pair_sums(corners, area)]))
    return Sums(plan, plan_seams(plan), area, _near_rim(plan, centre, depth), of_edges)


def _on_sheets(
    sums: sp.coo_array, within: tuple[int, int], op: Array, start: int, scale: Array | None
) -> tuple[Array, Integers]:
    """Return the Kronecker product of some rows of sums, scaled, and an operator on the sheets: entries, places."""
    some = (sums.row >= within[0]) & (sums.row < within[1])
    row, column, value = sums.row[some] - within[0], sums.col[some], sums.data[some]
    value = value if scale is None else value * scale[row]
    i, j = np.nonzero(op)
    rows, columns = row[:, None] * op.shape[0] + i, column[:, None] * op.shape[1] + j + start
    return (value[:, None] * op[i, j]).ravel(), np.stack([rows.ravel(), columns.ravel()])


def most_unknowns(plan: CellPlan, depth: float) -> int:
    """Return how many currents a sheet of a plan has at most in a class; `depth` as of `plan_sums`.

    Symmetric classes have fewer. Where even to look which cells are near a rim would take long, all count.
    """
    rim = int(((plan.loop[plan.cells] >= 0) & (plan.loop[np.roll(plan.cells, -1, axis=1)] >= 0)).sum())
    few = rim * plan.cells.shape[0] <= _LOOKED_AT
    links = int(_near_rim(plan, _centroids(plan.nodes[plan.cells]), depth).sum()) if few else plan.cells.shape[0]
    return int((plan.loop < 0).sum()) + max(int(plan.loop.max()), 0) + links


def _centroids(corners: Array) -> Array:
    """Return centres of area of polygons (m, k, 2)."""
    after = np.roll(corners, -1, axis=1)
    cross = corners[..., 0] * after[..., 1] - corners[..., 1] * after[..., 0]
    return np.asarray(((corners + after) * cross[..., None]).sum(1) / (3 * cross.sum(1, keepdims=True)))


def _interfaces(count: int, mirror: int) -> tuple[Array, Array, Array]:
    """Return sheets by interfaces: loop current in a sheet, mean and difference of the vertical current in it.

    Odd classes have vertical current through the middle plane: its interface comes first.
    """
    below = np.eye(count)[:, : count - 1]
    above = np.eye(count)[:, 1:]
    if mirror < 0:
        below = np.hstack([np.zeros((count, 1)), below])
        above = np.hstack([np.eye(count)[:, :1], above])
    return below - above, (below + above) / 2, below - above


def _stream_flux(plan: CellPlan, seams: Seams, character: Complex) -> sp.csr_array:
    """Return outward currents of all cells' edges (edge fastest) from the plan's free stream-function values."""
    stands, factor = standing_nodes(plan, seams, character)
    free = (plan.loop < 0) & (factor != 0.0) & (stands == np.arange(stands.size))
    number = np.cumsum(free) - 1
    round_about = bool(np.all(np.abs(character * np.round(np.linalg.det(plan.group)) - 1.0) < 1e-9))
    hole = np.maximum(plan.loop, 0) * round_about
    column = np.where(hole > 0, free.sum() + hole - 1, number[stands])
    used = np.flatnonzero(((plan.loop < 0) & (factor != 0.0) & free[stands]) | (hole > 0))
    size = int(free.sum() + hole.max())
    spread = sp.csr_array((factor[used], (used, column[used])), shape=(stands.size, size))
    edges = plan.cells.size
    ahead = np.roll(plan.cells, -1, axis=1).ravel()
    rows = np.arange(edges)
    ones = np.ones(edges)
    ends = sp.csr_array((np.r_[ones, -ones], (np.r_[rows, rows], np.r_[ahead, plan.cells.ravel()])),
                        shape=(edges, stands.size))
    return sp.csr_array(ends @ spread)


def _near_rim(plan: CellPlan, centre: Array, depth: float) -> Mask:
    """Return cells that touch a rim, or whose middle lies within `depth` of one."""
    touching = (plan.loop[plan.cells] >= 0).any(1)
    after = np.roll(plan.cells, -1, axis=1)
    rim = (plan.loop[plan.cells] >= 0) & (plan.loop[plan.cells] == plan.loop[after])
    start, end = plan.nodes[plan.cells[rim]], plan.nodes[after[rim]]
    along = end - start
    distance = np.full(len(centre), np.inf)
    for k in range(0, len(centre), _BLOCK):
        offset = centre[k : k + _BLOCK, None, :] - start
        share = np.clip((offset * along).sum(-1) / np.maximum((along**2).sum(-1), 1e-300), 0.0, 1.0)
        distance[k : k + _BLOCK] = np.linalg.norm(offset - share[..., None] * along, axis=-1).min(1)
    return touching | (distance < depth)


def _tree_flux(plan: CellPlan, seams: Seams, character: Complex, at_rim: Mask) -> sp.csr_array:
    """Return outward currents of all cells' edges from the vertical loops, one a branch of the tree of rim cells.

    A current of 1 out of edge e enters the image by g of f's cell, so ``conj(chi(g))`` enters f's cell itself. A link
    to the cell's own image with a factor other than 1 feeds it from nowhere: a branch to the ground.
    """
    links = seams.edges[at_rim[seams.edges[:, 1] // 4] & at_rim[seams.edges[:, 2] // 4]]
    phases = character[links[:, 0]].conj()
    cells = plan.cells.shape[0]
    graph: dict[tuple[int, int], int] = {}
    for k, (a, b) in enumerate((links[:, 1:] // 4).tolist()):
        if a != b:
            graph[min(a, b), max(a, b)] = k
        elif abs(phases[k] - 1.0) > 1e-9:
            graph[a, cells] = k
    pairs = np.array(list(graph), dtype=np.int32).reshape(-1, 2)  # scipy before 1.17 makes trees of these alone
    weights = sp.csr_array((np.ones(len(graph)), (pairs[:, 0], pairs[:, 1])), shape=(cells + 1, cells + 1))
    tree = minimum_spanning_tree(weights).tocoo()
    chosen = np.array(
        [graph[min(a, b), max(a, b)] for a, b in zip(tree.row.tolist(), tree.col.tolist(), strict=True)], dtype=int
    )
    rows = links[chosen, 1:].ravel()
    values = np.column_stack([np.ones(chosen.size), -phases[chosen]]).ravel()
    columns = np.repeat(np.arange(chosen.size), 2)
    return sp.csr_array((values, (rows, columns)), shape=(plan.cells.size, chosen.size))


def _pair_sums(corners: Array, area: Array) -> sp.csr_array:
    """Return weighted sums of the outward currents of opposite edges; in a triangle, of all three."""
    length = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    triangle = length[:, 2] == 0.0
    offset = corners - _centroids(corners)[:, None, :]
    gyration = np.sqrt((offset[:, :3] ** 2).sum((1, 2)) / 12)  # rms distance from the centre in a triangle
    cells = area.size
    rows, columns, values = [], [], []
    for pair in (0, 1):
        across = (length[:, pair] + length[:, pair + 2]) / 2
        quad = np.sqrt(area) / across
        whole = np.sqrt(12.0 / area) * gyration / 2 * (pair == 0)
        for edge in range(4):
            rows.append(2 * np.arange(cells) + pair)
            columns.append(4 * np.arange(cells) + edge)
            values.append(np.where(triangle, whole, quad * (edge % 2 == pair)))
    return sp.csr_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
                        shape=(2 * cells, 4 * cells))
