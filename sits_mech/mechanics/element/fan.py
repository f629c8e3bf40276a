"""Split the cells at a bonded corner that opens into triangles that meet in the corner.

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

import numpy as np

from sits_mech.mechanics.element.mesh import GAUSS, GAUSS_WEIGHTS, NODES, Indices, MixedMesh, Points, pressures
from sits_mech.quantities import Array

# places (i, j) of the nodes along xi and eta in halves; i = 0 is the corner
_ORDER = ((0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1))


def fanned(mesh: MixedMesh, corners: Array) -> MixedMesh:
    """Return a section whose cells at corners (k, 2) [thicknesses] are split into triangles, new nodes last."""
    if mesh.nodal is None:
        raise ValueError("mesh: must hold the gradients at its nodes")
    at = [int(np.argmin(np.sum((mesh.nodes - corner) ** 2, axis=1))) for corner in corners]
    split, place = np.nonzero(np.isin(mesh.cells[:, :4], at))
    triangles = _triangles(mesh.cells[split], place)
    new = mesh.nodes[triangles[:, [0, 0, 1, 2]]].mean(axis=1)
    tip, A, C, to_A, AC, to_C = triangles.T
    middle = len(mesh.nodes) + np.arange(len(new))
    halves = np.stack([tip, A, C, tip, to_A, AC, to_C, tip, middle], axis=1)
    kept = np.delete(np.arange(len(mesh.cells)), split)
    inside, chi, nodal = _collapsed(mesh.nodes[triangles[:, :3]])
    nodes = np.concatenate([mesh.nodes, new])
    flat = None if mesh.flat is None else np.concatenate([mesh.flat, new])  # cells that are split are rectangles
    both = (
        Points(*(np.concatenate([old[kept], own]) for old, own in zip(olds, owns, strict=True)))
        for olds, owns in ((mesh.inside, inside), (mesh.nodal, nodal))
    )
    cells = np.concatenate([mesh.cells[kept], halves])
    return MixedMesh(nodes, cells, next(both), np.concatenate([mesh.chi[kept], chi]), next(both), flat)


def _triangles(cells: Indices, place: Indices) -> Indices:
    """Return the nodes (O, A, C, middles of OA, AC, OC) of the halves of cells with a corner O at a place in them."""
    around = (place[:, None] + np.arange(4)) % 4
    tip, A, far, C = np.take_along_axis(cells, around, axis=1).T
    to_A, to_far, from_far, to_C = np.take_along_axis(cells, 4 + around, axis=1).T
    middle = cells[:, 8]
    first = np.stack([tip, A, far, to_A, to_far, middle], axis=1)
    return np.concatenate([first, np.stack([tip, far, C, middle, from_far, to_C], axis=1)])


def _collapsed(corners: Array) -> tuple[Points, Array, Points]:
    """Return quadrature points, pressures and nodes of collapsed cells from corners O, A, C, shape (h, 3, 2)."""
    slope, area, places = _gradients(corners, *GAUSS)
    weights = area * GAUSS_WEIGHTS
    nodal = np.repeat(weights.sum(axis=1)[:, None] / 9.0, 9, axis=1)
    chi = pressures(np.moveaxis(places, -1, 0), weights)
    return Points(slope, weights), chi, Points(_gradients(corners, *NODES)[0], nodal)


def _gradients(corners: Array, xi: Array, eta: Array) -> tuple[Array, Array, Array]:
    """Return shape function gradients, area per unit of xi and eta, and places of points of collapsed cells."""
    tip, A, C = (corners[:, None, k] for k in range(3))
    (_, da), (b, db) = _quadratic(xi), _quadratic(eta)
    a_over = np.stack([np.zeros_like(xi), 4.0 * (1.0 - xi), 2.0 * xi - 1.0])  # a / xi; the corner's own cancel
    i, j = np.array(_ORDER).T
    along, across = (da[i] * b[j]).T, (a_over[i] * db[j]).T
    X_xi, X_eta = (A - tip) + eta[:, None] * (C - A), C - A
    det = X_xi[..., 0] * X_eta[..., 1] - X_xi[..., 1] * X_eta[..., 0]
    slope = np.stack([
        along * X_eta[..., 1:] - across * X_xi[..., 1:], across * X_xi[..., :1] - along * X_eta[..., :1]
    ], axis=2)
    return slope / det[..., None, None], det * xi, tip + xi[:, None] * X_xi


def _quadratic(s: Array) -> tuple[Array, Array]:
    """Return values and slopes, (3, n), of the quadratic shape functions of 0, 1/2, 1 at s in 0..1."""
    values = np.stack([(1.0 - s) * (1.0 - 2.0 * s), 4.0 * s * (1.0 - s), s * (2.0 * s - 1.0)])
    return values, np.stack([4.0 * s - 3.0, 4.0 - 8.0 * s, 4.0 * s - 1.0])
