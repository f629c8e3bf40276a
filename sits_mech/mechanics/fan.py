"""How does a mesh follow a bonded corner that opens? Its cells are split into triangles that meet in the corner.

At a bonded corner the displacement goes as ``r f(theta)`` with a strain that is finite but differs from direction to
direction; under compression the angle between plate and free face opens from 90 towards 180 degrees. A square with
one node in the corner cannot follow: at its own corner J falls below zero while its quadrature points look healthy.
So every cell at such a corner is halved along its diagonal, and each half is a quadratic square with one side, its
three nodes, drawn together in the corner O:

    X = O + xi (A - O + eta (C - A)),        0 <= xi, eta <= 1.

Its shape functions hold ``xi g(eta)``: strains that depend on the direction under which the corner is left. Gradients
stay finite for xi -> 0, where ``dN/deta / xi`` has the limit used below. The split adds one node, the middle of a
triangle, for each half; the cell's own middle becomes that of the diagonal.

Source: R. S. Barsoum, Int. J. Numer. Meth. Engng 11 (1977) 85, collapsed elements at crack tips.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.forms import Indices, Section
from sits_mech.quantities import Array

# places (i, j) of the nodes along xi and eta in halves; i = 0 is the corner
_ORDER = ((0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1))
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(3)


class _Half(NamedTuple):
    """A triangle: its nodes (9,), and what `Section` holds of a cell."""

    nodes: list[int]
    B: Array
    weights: Array
    chi: Array
    node_B: Array
    node_weights: Array


def fanned(mesh: Section, corners: Array) -> Section:
    """Return a mesh whose cells at some corners are split into triangles.

    Parameters
    ----------
    mesh : Section
        Of rectangles, with what it holds at its nodes.
    corners : ndarray, shape (k, 2)
        Places of nodes [thicknesses].

    Returns
    -------
    Section
        The old nodes first, then the new ones.
    """
    if mesh.node_B is None or mesh.node_weights is None:
        raise ValueError("mesh: must hold the strains at its nodes")
    halves: list[_Half] = []
    new: list[Array] = []
    kept = np.ones(len(mesh.cells), dtype=bool)
    for corner in corners:
        at = int(np.argmin(np.sum((mesh.nodes - corner) ** 2, axis=1)))
        for cell in np.flatnonzero((mesh.cells[:, :4] == at).any(axis=1)):
            kept[cell] = False
            for triangle in _triangles(mesh, mesh.cells[cell], at):
                halves.append(_half(mesh, triangle, len(mesh.nodes) + len(new)))
                new.append(mesh.nodes[triangle[[0, 0, 1, 2]]].mean(axis=0))
    cells = np.vstack([mesh.cells[kept], [half.nodes for half in halves]])
    joined = {
        name: np.concatenate([getattr(mesh, name)[kept], np.stack([getattr(half, name) for half in halves])])
        for name in ("B", "weights", "chi", "node_B", "node_weights")
    }
    dofs = (2 * cells[:, :, None] + np.arange(2)).reshape(len(cells), 18)
    nodes = np.vstack([mesh.nodes, *new])
    flat = None if mesh.flat is None else np.vstack([mesh.flat, *new])  # cells that are split are rectangles
    return replace(mesh, nodes=nodes, cells=cells, dofs=dofs, flat=flat, **joined)


def _triangles(mesh: Section, cell: Indices, corner: int) -> list[Indices]:
    """Nodes (O, A, C, middle of OA, of AC, of OC) of a cell's two halves, counter-clockwise."""
    places = mesh.nodes[cell]
    far = int(cell[np.argmin(np.sum((places - (2.0 * places[8] - mesh.nodes[corner])) ** 2, axis=1))])
    found = []
    for other in (int(node) for node in cell[:4] if node not in (corner, far)):
        A, C = other, far
        (a, b), (c, d) = mesh.nodes[A] - mesh.nodes[corner], mesh.nodes[C] - mesh.nodes[corner]
        if a * d - b * c < 0.0:
            A, C = C, A
        pairs = ((corner, A), (A, C), (corner, C))
        halfway = [mesh.nodes[list(pair)].mean(axis=0) for pair in pairs]
        middles = [cell[np.argmin(np.sum((places - place) ** 2, axis=1))] for place in halfway]
        found.append(np.array([corner, A, C, *middles]))
    return found


def _half(mesh: Section, triangle: Indices, middle: int) -> _Half:
    """One collapsed cell."""
    tip, A, C, to_A, AC, to_C = (int(node) for node in triangle)
    corners = mesh.nodes[[tip, A, C]]
    unit, share = 0.5 * (_POINTS + 1.0), 0.5 * _WEIGHTS
    xi, eta = (line.ravel() for line in np.meshgrid(unit, unit, indexing="ij"))
    B, area, places = _strains(corners, xi, eta)
    weights = area * np.outer(share, share).ravel()
    local = (places - np.average(places, axis=0, weights=weights)).T
    basis = np.stack([np.ones_like(weights), *local])
    lower = np.linalg.cholesky((basis * weights) @ basis.T)
    chi = np.linalg.solve(lower, basis) * weights
    ends = np.array([0.0, 0.5, 1.0])
    node_B, _, _ = _strains(corners, *(line.ravel() for line in np.meshgrid(ends, ends, indexing="ij")))
    nodes = [tip, A, C, tip, to_A, AC, to_C, tip, middle]
    return _Half(nodes, B, weights, chi, node_B, np.full(9, weights.sum() / 9.0))


def _strains(corners: Array, xi: Array, eta: Array) -> tuple[Array, Array, Array]:
    """F - 1 from the displacements, area per unit of xi and eta, and place of points of a collapsed cell."""
    tip, A, C = corners
    a, da = _quadratic(xi)
    b, db = _quadratic(eta)
    a_over = np.stack([np.zeros_like(xi), 4.0 * (1.0 - xi), 2.0 * xi - 1.0])  # a / xi; the corner's own cancel
    along = np.stack([da[i] * b[j] for i, j in _ORDER], axis=1)
    across = np.stack([a_over[i] * db[j] for i, j in _ORDER], axis=1)
    X_xi, X_eta = (A - tip) + eta[:, None] * (C - A), np.broadcast_to(C - A, (len(xi), 2))
    det = X_xi[:, 0] * X_eta[:, 1] - X_xi[:, 1] * X_eta[:, 0]
    B = np.zeros((len(xi), 4, 18))
    slope = (
        (along * X_eta[:, 1:] - across * X_xi[:, 1:]) / det[:, None],
        (across * X_xi[:, :1] - along * X_eta[:, :1]) / det[:, None],
    )
    for i in range(2):
        for j in range(2):
            B[:, 2 * i + j, i::2] = slope[j]
    return B, det * xi, tip + xi[:, None] * X_xi


def _quadratic(s: Array) -> tuple[Array, Array]:
    """Values and slopes of the three quadratic shape functions on 0..1."""
    values = np.stack([(1.0 - s) * (1.0 - 2.0 * s), 4.0 * s * (1.0 - s), s * (2.0 * s - 1.0)])
    return values, np.stack([4.0 * s - 3.0, 4.0 - 8.0 * s, 4.0 * s - 1.0])
