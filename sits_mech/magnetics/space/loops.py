"""Divergence-free currents of a plate: a stream function on each sheet, and loops that pass from sheet to sheet.

The plate is its plan's cells times horizontal sheets. Unknowns [A]:

- psi at the plan's nodes, one a sheet: the current across a cell's edge from a to b is ``psi_b - psi_a`` outwards;
  psi = 0 on the outer rim, one value on the rim of each hole;
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
from numpy.typing import NDArray
from scipy.sparse.csgraph import minimum_spanning_tree

from sits_mech.geometry.sheet_plan import Plan, Seams, standing_nodes
from sits_mech.quantities import Array, Complex
from sits_mech.scene.outlines import signed_area

_LOOKED_AT = 10_000_000  # cells by edges of rims


@dataclass(frozen=True)
class Loops:
    """Operators from the unknowns of one symmetry class to its cells (sheet fastest), all sparse.

    Attributes
    ----------
    moments : tuple of sparse array
        x, y and z components of the integral of J over each cell [A m per A].
    uneven : sparse array
        Rows whose squares, summed, are the dissipation (times conductivity) of the linear variation [m^-1/2].
    volume : ndarray
        Of the cells [m^3].
    """

    moments: tuple[sp.csr_array, sp.csr_array, sp.csr_array]
    uneven: sp.csr_array
    volume: Array

    @property
    def unknowns(self) -> int:
        """Number of unknowns."""
        return int(self.uneven.shape[1])


def class_loops(
    plan: Plan, seams: Seams, heights: Array, symmetry: tuple[Complex, int], *, depth: float = 0.0
) -> Loops:
    """Return the loops of one class.

    Parameters
    ----------
    plan : Plan
    seams : Seams
        Of the plan.
    heights : ndarray, shape (l,)
        Of the sheets of the upper half, from the middle plane up [m].
    symmetry : tuple
        The class's row of `plan.characters`; +1 if the lower half carries the same in-plane currents as the upper,
        -1 if the opposite.
    depth : float
        Vertical loops are taken in the cells at the rim and those whose middle is no further from it [m].
    """
    character, mirror = symmetry
    corners = plan.nodes[plan.cells]
    area, centre = signed_area(corners), _centroids(corners)
    lever = (corners + np.roll(corners, -1, axis=1)) / 2 - centre[:, None, :]
    sheets, rises, drops = _interfaces(heights.size, mirror)
    psi = _stream_flux(plan, seams, character)
    across = _tree_flux(plan, seams, character, _near_rim(plan, centre, depth))
    eye = sp.eye_array(heights.size)
    flat = [sp.hstack([sp.kron(op @ psi, eye), sp.kron(op @ across, sheets)]) for op in _levers(lever)]
    net = sp.kron(sp.eye_array(area.size), np.ones((1, 4))) @ across  # out of each cell
    blank = sp.csr_array((area.size * heights.size, psi.shape[1] * heights.size), dtype=complex)
    up = sp.hstack([blank, -sp.kron(net, sp.diags_array(heights) @ rises)])
    thin = sp.diags_array(1.0 / np.sqrt(12.0 * heights))
    pairs = _pair_sums(corners, area)
    side = sp.hstack([sp.kron(pairs @ psi, thin), sp.kron(pairs @ across, thin @ sheets)])
    spread = sp.diags_array(1.0 / np.sqrt(area)) @ net
    vertical = sp.hstack([blank, sp.kron(spread, sp.diags_array(np.sqrt(heights / 12.0)) @ drops)])
    moments = tuple(sp.csr_array(op) for op in (*flat, up))
    return Loops(
        (moments[0], moments[1], moments[2]), sp.csr_array(sp.vstack([side, vertical])), np.outer(area, heights).ravel()
    )


def most_unknowns(plan: Plan, depth: float) -> int:
    """Return how many currents a sheet of a plan has at most in a class; `depth` as in `class_loops`.

    Symmetric classes have fewer. Where even to look which cells are near a rim would take long, all count.
    """
    rim = int(((plan.loop[plan.cells] >= 0) & (plan.loop[np.roll(plan.cells, -1, axis=1)] >= 0)).sum())
    few = rim * plan.cells.shape[0] <= _LOOKED_AT
    links = int(_near_rim(plan, _centroids(plan.nodes[plan.cells]), depth).sum()) if few else plan.cells.shape[0]
    return int((plan.loop < 0).sum()) + max(int(plan.loop.max()), 0) + links


def _centroids(corners: Array) -> Array:
    """Centres of area of polygons (m, k, 2)."""
    after = np.roll(corners, -1, axis=1)
    cross = corners[..., 0] * after[..., 1] - corners[..., 1] * after[..., 0]
    return np.asarray(((corners + after) * cross[..., None]).sum(1) / (3 * cross.sum(1, keepdims=True)))


def _interfaces(count: int, mirror: int) -> tuple[sp.csr_array, sp.csr_array, sp.csr_array]:
    """Sheets by interfaces: loop current in a sheet, mean and difference of the vertical current in it.

    Odd classes have vertical current through the middle plane: its interface comes first.
    """
    below = np.eye(count)[:, : count - 1]
    above = np.eye(count)[:, 1:]
    if mirror < 0:
        below = np.hstack([np.zeros((count, 1)), below])
        above = np.hstack([np.eye(count)[:, :1], above])
    return sp.csr_array(below - above), sp.csr_array((below + above) / 2), sp.csr_array(below - above)


def _stream_flux(plan: Plan, seams: Seams, character: Complex) -> sp.csr_array:
    """Outward currents of all cells' edges (edge fastest) from the plan's free stream-function values."""
    stands, factor = standing_nodes(plan, seams, character)
    free = (plan.loop < 0) & (factor != 0.0) & (stands == np.arange(stands.size))
    number = np.cumsum(free) - 1
    hole = np.maximum(plan.loop, 0)
    column = np.where(plan.loop > 0, free.sum() + hole - 1, number[stands])
    used = np.flatnonzero(((plan.loop < 0) & (factor != 0.0) & free[stands]) | (plan.loop > 0))
    size = int(free.sum() + hole.max())
    spread = sp.csr_array((factor[used], (used, column[used])), shape=(stands.size, size))
    edges = plan.cells.size
    ahead = np.roll(plan.cells, -1, axis=1).ravel()
    rows = np.arange(edges)
    ones = np.ones(edges)
    ends = sp.csr_array((np.r_[ones, -ones], (np.r_[rows, rows], np.r_[ahead, plan.cells.ravel()])),
                        shape=(edges, stands.size))  # fmt: skip
    return sp.csr_array(ends @ spread)


def _near_rim(plan: Plan, centre: Array, depth: float) -> NDArray[np.bool_]:
    """Cells that touch a rim, or whose middle lies within `depth` of one."""
    touching = (plan.loop[plan.cells] >= 0).any(1)
    after = np.roll(plan.cells, -1, axis=1)
    rim = (plan.loop[plan.cells] >= 0) & (plan.loop[plan.cells] == plan.loop[after])
    start, end = plan.nodes[plan.cells[rim]], plan.nodes[after[rim]]
    along = end - start
    offset = centre[:, None, :] - start
    share = np.clip((offset * along).sum(-1) / np.maximum((along**2).sum(-1), 1e-300), 0.0, 1.0)
    distance = np.linalg.norm(offset - share[..., None] * along, axis=-1).min(1)
    return np.asarray(touching | (distance < depth))


def _tree_flux(plan: Plan, seams: Seams, character: Complex, at_rim: NDArray[np.bool_]) -> sp.csr_array:
    """Outward currents of all cells' edges from the vertical loops, one a branch of the tree of rim cells.

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
    pairs = np.array(list(graph), dtype=int).reshape(-1, 2)
    weights = sp.csr_array((np.ones(len(graph)), (pairs[:, 0], pairs[:, 1])), shape=(cells + 1, cells + 1))
    tree = minimum_spanning_tree(weights).tocoo()
    chosen = np.array(
        [graph[min(a, b), max(a, b)] for a, b in zip(tree.row.tolist(), tree.col.tolist(), strict=True)], dtype=int
    )
    rows = links[chosen, 1:].ravel()
    values = np.column_stack([np.ones(chosen.size), -phases[chosen]]).ravel()
    columns = np.repeat(np.arange(chosen.size), 2)
    return sp.csr_array((values, (rows, columns)), shape=(plan.cells.size, chosen.size))


def _levers(lever: Array) -> tuple[sp.csr_array, sp.csr_array]:
    """Sums over a cell's edges of outward current times the edge middle's x and y from the cell's centre."""
    cells = lever.shape[0]
    rows, columns = np.repeat(np.arange(cells), 4), np.arange(4 * cells)
    x, y = (sp.csr_array((lever[..., k].ravel(), (rows, columns)), shape=(cells, 4 * cells)) for k in (0, 1))
    return x, y


def _pair_sums(corners: Array, area: Array) -> sp.csr_array:
    """Weighted sums of the outward currents of opposite edges; in a triangle, of all three."""
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
                        shape=(2 * cells, 4 * cells))  # fmt: skip
