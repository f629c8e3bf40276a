"""What energy, forces and tangent does a deformed pad have in three dimensions? Mixed elements, condensed pressure.

Strong form    div P = 0 in the pad, P = dW/dF; u = 0 on the ground; u rigid on the target; P n = 0 on the free faces;
               u_y = 0 and no shear on the plane of symmetry y = 0.
Weak form      minimise  E(u) = int w(F) + K/2 (pi(J - 1))**2,        F = 1 + grad u, J = det F,

with `pi` the projection onto polynomials of degree one in each element: four discontinuous pressures
``p = K pi(J - 1)``, eliminated in the element. Displacements that make them inf-sup stable: 27-node bricks, or
quadratic tetrahedra with a bubble on each face and one inside, 15 nodes. First and second variation as in forms.py.

Unknowns: nodal displacements in thicknesses; energies in shear modulus times thickness cubed; K in shear moduli.
Source: D. Boffi, F. Brezzi, M. Fortin, Mixed Finite Element Methods and Applications (2013), sections 8.6 and
8.7. Valid for cells of any aspect that are not inverted. Neglected: inertia, gravity.
"""

from __future__ import annotations

import numpy as np
from skfem import Basis, Mesh
from skfem.element import Element, ElementHex2, ElementTetCCR

from sits_mech.mechanics.block_energy import SolidEnergy, cofactor, stress_and_tangent
from sits_mech.mechanics.forms import Section, Tangent, summed
from sits_mech.quantities import Array

BRICK, TETRAHEDRON = ElementHex2(), ElementTetCCR()
"""The displacements' elements."""
_ORDER = 5  # of the polynomials that the quadrature integrates


def solid_mesh(mesh: Mesh, element: Element, constant: bool = False) -> tuple[Section, Basis]:
    """Return the arrays of a meshed pad, and scikit-fem's basis that names its nodes and facets.

    Parameters
    ----------
    mesh : skfem.Mesh
        Hexahedra or tetrahedra, straight or curved [thicknesses].
    element : skfem.Element
        Of the displacements: `BRICK` or `TETRAHEDRON`.
    constant : bool
        Whether pressures are constant in each element: a poorer answer on the same nodes.
    """
    basis = Basis(mesh, element, intorder=_ORDER)
    cells, nodes = basis.element_dofs.T, basis.doflocs.T
    count = cells.shape[1]
    B = np.zeros((*basis.dx.shape, 9, 3 * count))
    for a in range(count):
        gradient = np.moveaxis(basis.basis[a][0].grad, 0, -1)  # e, q, j
        for i in range(3):
            B[:, :, 3 * i : 3 * i + 3, i * count + a] = gradient
    dofs = (3 * cells[:, None, :] + np.arange(3)[:, None]).reshape(len(cells), -1)  # by component
    points = np.asarray(basis.global_coordinates())
    size = np.cbrt(basis.dx.sum(axis=1))
    local = (points - points.mean(axis=2, keepdims=True)) / size[:, None]
    chi = np.concatenate([np.ones((1, *basis.dx.shape)), local]).swapaxes(0, 1)[:, : 1 if constant else 4]
    gram = np.einsum("emq,enq,eq->emn", chi, chi, basis.dx)
    chi = np.linalg.solve(np.linalg.cholesky(gram), chi) * basis.dx[:, None, :]
    x, z = (np.unique(np.round(nodes[:, axis], 12)) for axis in (0, 2))
    return Section(x, z, nodes, cells, dofs, B, basis.dx.copy(), chi), basis


def solid_deformation(mesh: Section, u: Array) -> tuple[Array, Array]:
    """Return F, shape (e, q, 9), and J, shape (e, q), at the quadrature points of nodal displacements (3 n,)."""
    e = len(mesh.cells)
    slope = _gradients(mesh)
    each = u[mesh.dofs].reshape(e, 3, -1).transpose(0, 2, 1)
    F = (slope.reshape(e, -1, slope.shape[-1]) @ each).reshape(e, -1, 3, 3).swapaxes(2, 3).reshape(e, -1, 9)
    F = F + np.eye(3).ravel()
    return F, (F[..., :3] * cofactor(F)[..., :3]).sum(axis=-1)


def solid_tangent(mesh: Section, law: SolidEnergy, K: float, u: Array, pressure: Array | None = None) -> Tangent:
    """Linearise the pad about a deformed state.

    Parameters
    ----------
    mesh : Section
        The mesh, from `solid_mesh`.
    law : callable
        Isochoric energy (block_energy.py).
    K : float
        Bulk modulus [shear moduli].
    u : ndarray, shape (3 n,)
        Nodal displacements [thicknesses].
    pressure : ndarray, shape (e, 4) or (e, 1), optional
        Pressures of the geometric stiffness; by default those of the state, ``K pi(J - 1)``.
    """
    e = len(mesh.cells)
    F, J = solid_deformation(mesh, u)
    w, P, A, (_, H, L, _) = stress_and_tangent(law, F)
    p = K * np.einsum("emq,eq->em", mesh.chi, J - 1.0)
    p_at = np.einsum("em,emq->eq", p, mesh.chi)  # carries the weights
    P = mesh.weights[..., None] * P + p_at[..., None] * H
    slope = _gradients(mesh)
    along = slope.reshape(e, -1, slope.shape[-1])
    forces = summed(mesh.dofs, _by_component(P) @ along, mesh.nodes.size)
    p_geometric = p_at if pressure is None else np.einsum("em,emq->eq", pressure, mesh.chi)
    A *= mesh.weights[..., None, None]
    A += p_geometric[..., None, None] * L
    b = (_by_component(mesh.chi[..., None] * H[:, None]) @ along[:, None]).reshape(e, mesh.chi.shape[1], -1)
    stiffness = K * b.transpose(0, 2, 1) @ b
    _add_stiffness(stiffness, slope, A)
    energy = float((mesh.weights * w).sum() + 0.5 * (p**2).sum() / K)
    return Tangent(energy, forces, stiffness, p, float(J.min()))


def _gradients(mesh: Section) -> Array:
    """Slopes of the shape functions at the quadrature points, shape (e, q, 3, nodes): B holds them three times."""
    return np.ascontiguousarray(mesh.B[:, :, :3, : mesh.dofs.shape[1] // 3])


def _by_component(P: Array) -> Array:
    """Stresses (..., q, 9) as rows of a component each, (..., 3, 3 q), to go with slopes as (..., 3 q, nodes)."""
    return P.reshape(*P.shape[:-1], 3, 3).swapaxes(-3, -2).reshape(*P.shape[:-2], 3, -1)


def _add_stiffness(stiffness: Array, slope: Array, A: Array) -> None:
    """Add ``int dF : A : dF`` of symmetric tangents A, shape (e, q, 9, 9), block by block, to element stiffnesses."""
    e, q, _, count = slope.shape
    left = slope.reshape(e, 3 * q, count).transpose(0, 2, 1)
    for i in range(3):
        own, after = slice(i * count, (i + 1) * count), slice((i + 1) * count, None)
        stress = A[:, :, 3 * i : 3 * i + 3, 3 * i :].reshape(e, q, -1, 3) @ slope  # component i of P by later ones
        blocks = left @ stress.reshape(e, 3 * q, -1)
        stiffness[:, own, i * count :] += blocks
        stiffness[:, after, own] += blocks[:, :, count:].transpose(0, 2, 1)
