"""What energy, forces and tangent does a deformed layer have? Plane strain, mixed elements, condensed pressure.

Strong form    div P = 0 in the layer, P = dW/dF; u = 0 on the ground; u rigid on the target; P n = 0 on the free faces.
Weak form      minimise  E(u) = int w(F) + K/2 (pi(J - 1))**2,        F = 1 + grad u, J = det F,

with `pi` the projection onto polynomials of degree one in each element: Q2 displacement, discontinuous P1 pressure
``p = K pi(J - 1)``, inf-sup stable. The pressure is eliminated element by element, so that the discrete problem is a
minimum and its tangent symmetric:

    dE       = int (P_iso + p H) : dF,                                 H = dJ/dF
    d dE     = int dF : (A_iso + p dH/dF) : dF + K int pi(H : dF) pi(H : dF).

Unknowns: nodal displacements in layer thicknesses; energies per depth in shear modulus times thickness squared; K in
shear moduli. Source: D. Boffi, F. Brezzi, M. Fortin, Mixed Finite Element Methods and Applications (2013), section 8.6.
Valid for rectangles of any aspect, and with sides that are parabolas. Neglected: inertia, gravity. Contact stands in
contact.py, what becomes of the elements at bonded corners in fan.py.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sits_mech.mechanics.energy import PlaneEnergy
from sits_mech.quantities import Array

Indices = NDArray[np.int64]

_POINTS, _SHARES = np.polynomial.legendre.leggauss(3)
GAUSS = np.array([(a, b) for a in 0.5 * (_POINTS + 1.0) for b in 0.5 * (_POINTS + 1.0)]).T
"""Quadrature points of the unit square."""
GAUSS_WEIGHTS = 0.25 * np.outer(_SHARES, _SHARES).ravel()
NODES = np.array([(a, b) for a in (0.0, 0.5, 1.0) for b in (0.0, 0.5, 1.0)]).T
"""Nodes of the unit square."""
_SIMPSON = np.outer([1.0, 4.0, 1.0], [1.0, 4.0, 1.0]).ravel() / 36.0
# half steps (along x, along z) of a cell's nodes: corners counter-clockwise, the side after each, the middle
_ORDER = ((0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1))

# dJ/dF = H_J F with F = (F_11, F_12, F_21, F_22): H is linear in F in two dimensions.
H_J = np.array([[0.0, 0, 0, 1], [0, 0, -1, 0], [0, -1, 0, 0], [1, 0, 0, 0]])


@dataclass(frozen=True)
class Section:
    """A meshed cross-section of the layer: arrays that depend on the mesh alone.

    Attributes
    ----------
    x, z : ndarray
        Mesh lines [thicknesses].
    nodes : ndarray, shape (n, 2)
        Q2 nodes, ordered column by column from left to right [thicknesses].
    cells : ndarray, shape (e, 9)
        Nodes of each element: corners counter-clockwise, the side after each, the middle.
    dofs : ndarray, shape (e, 18)
        Displacement numbers ``2 node + component`` of each element.
    B : ndarray, shape (e, 9, 4, 18)
        F - 1 at the quadrature points from an element's displacements.
    weights : ndarray, shape (e, 9)
        Quadrature weights.
    chi : ndarray, shape (e, 3, 9)
        Orthonormal pressure polynomials times the weights, at the quadrature points.
    node_B, node_weights : ndarray, shapes (e, 9, 4, 18) and (e, 9)
        F - 1 at the elements' nodes and the weights of Simpson's rule there; None where not looked at.
    flat : ndarray, shape (n, 2), or None
        Where the nodes of a mesh with curved sides stood in its rectangle; None where they stand there.
    """

    x: Array
    z: Array
    nodes: Array
    cells: Indices
    dofs: Indices
    B: Array
    weights: Array
    chi: Array
    node_B: Array | None = None
    node_weights: Array | None = None
    flat: Array | None = None

    @property
    def places(self) -> Array:
        """Nodes in the rectangle, shape (n, 2) [thicknesses]."""
        return self.nodes if self.flat is None else self.flat


class Tangent(NamedTuple):
    """A linearised layer: energy, forces (2 n,), element stiffnesses (e, 18, 18), pressures (e, 3), smallest J."""

    energy: float
    forces: Array
    stiffness: Array
    pressure: Array
    min_J: float


def section(x: Array, z: Array, placed: Callable[[Array], Array] | None = None) -> Section:
    """Mesh a rectangle with mixed elements on the given lines.

    Parameters
    ----------
    x, z : ndarray
        Mesh lines [thicknesses].
    placed : callable, optional
        Where the nodes of the rectangle, shape (n, 2), come to stand: sides become parabolas.
    """
    flat = np.stack(np.meshgrid(_halved(x), _halved(z), indexing="ij"), axis=-1).reshape(-1, 2)
    nodes = flat if placed is None else placed(flat)
    column = 2 * len(z) - 1
    first = 2 * column * np.arange(len(x) - 1)[:, None] + 2 * np.arange(len(z) - 1)
    cells = first.reshape(-1, 1) + np.array(_ORDER) @ [column, 1]
    dofs = (2 * cells[:, :, None] + np.arange(2)).reshape(len(cells), 18)
    B, area, points = _strains(nodes[cells], *GAUSS)
    weights = area * GAUSS_WEIGHTS
    node_B, node_area, _ = _strains(nodes[cells], *NODES)
    parts = (B, weights, pressures(points, weights), node_B, node_area * _SIMPSON)
    return Section(x, z, nodes, cells, dofs, *parts, flat=None if placed is None else flat)


def pressures(points: Array, weights: Array) -> Array:
    """Return the orthonormal polynomials of degree one times the weights, shape (e, 3, q), of cells' quadrature points.

    Parameters
    ----------
    points : ndarray, shape (e, q, 2)
    weights : ndarray, shape (e, q)
    """
    centre = (points * weights[..., None]).sum(axis=1, keepdims=True) / weights.sum(axis=1)[:, None, None]
    local = np.moveaxis(points - centre, -1, 1)
    basis = np.concatenate([np.ones_like(weights)[:, None], local], axis=1)
    weighted = basis * weights[:, None]
    return np.asarray(np.linalg.solve(np.linalg.cholesky(weighted @ basis.transpose(0, 2, 1)), weighted))


def strains(slope: Array) -> Array:
    """Return F - 1 from the displacements, shape (e, q, 4, 18), of the shape functions' gradients, (e, q, 9, 2)."""
    B = np.zeros((*slope.shape[:2], 4, 18))
    for i in range(2):
        B[:, :, 2 * i : 2 * i + 2, i::2] = slope.swapaxes(2, 3)
    return B


def quadratic(s: Array) -> tuple[Array, Array]:
    """Return values and slopes, shapes (3, n), of the quadratic shape functions of 0, 1/2, 1 at s in 0..1."""
    values = np.stack([(1.0 - s) * (1.0 - 2.0 * s), 4.0 * s * (1.0 - s), s * (2.0 * s - 1.0)])
    return values, np.stack([4.0 * s - 3.0, 4.0 - 8.0 * s, 4.0 * s - 1.0])


def _strains(places: Array, xi: Array, eta: Array) -> tuple[Array, Array, Array]:
    """F - 1 from the displacements, area per unit of xi and eta, and place of points of cells whose nodes are given."""
    (a, da), (b, db) = quadratic(xi), quadratic(eta)
    i, j = np.array(_ORDER).T
    N, N_xi, N_eta = (a[i] * b[j]).T, (da[i] * b[j]).T, (a[i] * db[j]).T
    (x_xi, z_xi), (x_eta, z_eta) = np.moveaxis(N_xi @ places, -1, 0), np.moveaxis(N_eta @ places, -1, 0)
    det = x_xi * z_eta - x_eta * z_xi
    along = N_xi * (z_eta / det)[..., None] - N_eta * (z_xi / det)[..., None]
    upward = N_eta * (x_xi / det)[..., None] - N_xi * (x_eta / det)[..., None]
    return strains(np.stack([along, upward], axis=-1)), det, N @ places


def _halved(lines: Array) -> Array:
    """Lines with the middles between them."""
    return np.insert(lines, np.arange(1, len(lines)), 0.5 * (lines[1:] + lines[:-1]))


def node_volumes(mesh: Section, u: Array) -> Array:
    """Return J at the elements' nodes, shape (e, 9); of shape (0, 9) for a mesh that does not look at them."""
    if mesh.node_B is None:
        return np.ones((0, 9))
    return deformation(replace(mesh, B=mesh.node_B), u)[1]


def deformation(mesh: Section, u: Array) -> tuple[Array, Array]:
    """Return ``F`` as (F_11, F_12, F_21, F_22) and ``J`` at the quadrature points.

    Parameters
    ----------
    mesh : Section
        The mesh.
    u : ndarray, shape (2 n,)
        Nodal displacements [thicknesses].

    Returns
    -------
    F : ndarray, shape (e, 9, 4)
    J : ndarray, shape (e, 9)
    """
    e = len(mesh.cells)
    F = (mesh.B.reshape(e, -1, 18) @ u[mesh.dofs][:, :, None]).reshape(e, -1, 4)
    F = F + np.array([1.0, 0.0, 0.0, 1.0])
    return F, F[..., 0] * F[..., 3] - F[..., 1] * F[..., 2]


def summed(places: Indices, values: Array, size: int) -> Array:
    """Return the sums, shape (size,), of the values that go to each place; both arrays in one order."""
    return np.asarray(np.bincount(places.ravel(), values.ravel(), size), dtype=np.float64)


def entries(numbers: Indices) -> tuple[Indices, Indices]:
    """Return the rows and columns of the stiffnesses of elements with unknowns `numbers`, shape (e, k)."""
    count = numbers.shape[1]
    return np.repeat(numbers, count, axis=1).ravel(), np.tile(numbers, (1, count)).ravel()


def plane_cofactor(F: Array) -> Array:
    """Return ``H = dJ/dF`` of F, both of shape (..., 4)."""
    return np.asarray(F[..., ::-1] * np.array([1.0, -1.0, -1.0, 1.0]))


def stored_energy(mesh: Section, law: PlaneEnergy, K: float, u: Array) -> float:
    """Return the energy of the layer, infinite where a quadrature point is turned inside out.

    Parameters
    ----------
    mesh : Section
        The mesh.
    law : callable
        Isochoric energy (energy.py).
    K : float
        Bulk modulus [shear moduli].
    u : ndarray, shape (2 n,)
        Nodal displacements [thicknesses].
    """
    F, J = deformation(mesh, u)
    if not J.min() > 0.0:
        return np.inf
    w = law((F**2).sum(axis=-1), J).w
    volume = np.einsum("emq,eq->em", mesh.chi, J - 1.0)
    return float((mesh.weights * w).sum() + 0.5 * K * (volume**2).sum())


def tangent(mesh: Section, law: PlaneEnergy, K: float, u: Array, pressure: Array | None = None) -> Tangent:
    """Linearise the layer about a deformed state.

    Parameters
    ----------
    mesh : Section
        The mesh.
    law : callable
        Isochoric energy (energy.py).
    K : float
        Bulk modulus [shear moduli].
    u : ndarray, shape (2 n,)
        Nodal displacements [thicknesses].
    pressure : ndarray, shape (e, 3), optional
        Pressures of the geometric stiffness; by default those of the state, ``K pi(J - 1)``.
    """
    e = len(mesh.cells)
    F, J = deformation(mesh, u)
    d = law((F**2).sum(axis=-1), J)
    H = plane_cofactor(F)
    p = K * np.einsum("emq,eq->em", mesh.chi, J - 1.0)
    p_at = np.einsum("em,emq->eq", p, mesh.chi)  # carries the weights
    P = mesh.weights[..., None] * (2.0 * d.w_s[..., None] * F + d.w_J[..., None] * H) + p_at[..., None] * H
    B = mesh.B.reshape(e, -1, 18)
    forces = summed(mesh.dofs, P.reshape(e, 1, -1) @ B, mesh.nodes.size)
    p_geometric = p_at if pressure is None else np.einsum("em,emq->eq", pressure, mesh.chi)
    C = H_J * (mesh.weights * d.w_J + p_geometric)[..., None, None]
    C = C + np.eye(4) * (2.0 * mesh.weights * d.w_s)[..., None, None]
    F_w, H_w = F * mesh.weights[..., None], H * mesh.weights[..., None]
    left = 4.0 * d.w_ss[..., None] * F_w + 2.0 * d.w_sJ[..., None] * H_w
    right = 2.0 * d.w_sJ[..., None] * F_w + d.w_JJ[..., None] * H_w
    C += left[..., :, None] * F[..., None, :] + right[..., :, None] * H[..., None, :]
    b = (mesh.chi[..., None] * H[:, None]).reshape(e, 3, -1) @ B
    stiffness = B.transpose(0, 2, 1) @ (C @ mesh.B).reshape(e, -1, 18) + K * b.transpose(0, 2, 1) @ b
    volume = p / K
    energy = float((mesh.weights * d.w).sum() + 0.5 * K * (volume**2).sum())
    return Tangent(energy, forces, stiffness, p, float(J.min()))
