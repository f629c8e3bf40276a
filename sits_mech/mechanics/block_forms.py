"""What energy, forces and tangent does a deformed pad have in three dimensions? Mixed bricks, condensed pressure.

Strong form    div P = 0 in the pad, P = dW/dF; u = 0 on the ground; u rigid on the target; P n = 0 on the free faces;
               u_y = 0 and no shear on the plane of symmetry y = 0.
Weak form      minimise  E(u) = int w(F) + K/2 (pi(J - 1))**2,        F = 1 + grad u, J = det F,

with `pi` the projection onto polynomials of degree one in each element: 27-node bricks, four discontinuous pressures
``p = K pi(J - 1)``, inf-sup stable, eliminated in the element. First and second variation as in forms.py.

Unknowns: nodal displacements in thicknesses; energies in shear modulus times thickness cubed; K in shear moduli.
Source: D. Boffi, F. Brezzi, M. Fortin, Mixed Finite Element Methods and Applications (2013), section 8.6. Valid for
boxes of any aspect. Neglected: inertia, gravity, contact of the free faces.
"""

from __future__ import annotations

import numpy as np
from skfem import Basis, ElementHex2, MeshHex

from sits_mech.mechanics.block_energy import SolidEnergy, cofactor, stress_and_tangent
from sits_mech.mechanics.forms import Section, Tangent
from sits_mech.quantities import Array


def brick_mesh(x: Array, y: Array, z: Array) -> Section:
    """Mesh a box with mixed elements on the given lines [thicknesses]; nodes are ordered by x, then y, then z."""
    basis = Basis(MeshHex.init_tensor(x, y, z), ElementHex2(), intorder=5)
    nodes = basis.doflocs.T
    order = np.lexsort(np.round(nodes.T[::-1], 12))
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    cells = rank[basis.element_dofs.T]
    gradients = np.stack([basis.basis[a][0].grad for a in range(27)])  # a, j, e, q
    B = np.zeros((*basis.dx.shape, 9, 81))
    for i in range(3):
        for j in range(3):
            B[:, :, 3 * i + j, i::3] = np.moveaxis(gradients[:, j], 0, -1)
    dofs = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), 81)
    points = np.asarray(basis.global_coordinates())
    centre = nodes[basis.element_dofs].mean(axis=0).T  # (3, e)
    chi = np.concatenate([np.ones((1, *basis.dx.shape)), points - centre[:, :, None]]).swapaxes(0, 1)
    norm = np.sqrt(np.einsum("emq,eq->em", chi**2, basis.dx))
    chi = chi / norm[:, :, None] * basis.dx[:, None, :]
    return Section(x, z, nodes[order], cells, dofs, B, basis.dx.copy(), chi)


def brick_deformation(mesh: Section, u: Array) -> tuple[Array, Array]:
    """Return F, shape (e, q, 9), and J, shape (e, q), at the quadrature points of nodal displacements (3 n,)."""
    e = len(mesh.cells)
    F = (mesh.B.reshape(e, -1, 81) @ u[mesh.dofs][:, :, None]).reshape(e, -1, 9)
    F = F + np.eye(3).ravel()
    return F, (F[..., :3] * cofactor(F)[..., :3]).sum(axis=-1)


def brick_tangent(mesh: Section, law: SolidEnergy, K: float, u: Array, pressure: Array | None = None) -> Tangent:
    """Linearise the pad about a deformed state.

    Parameters
    ----------
    mesh : Section
        The mesh, of bricks.
    law : callable
        Isochoric energy (block_energy.py).
    K : float
        Bulk modulus [shear moduli].
    u : ndarray, shape (3 n,)
        Nodal displacements [thicknesses].
    pressure : ndarray, shape (e, 4), optional
        Pressures of the geometric stiffness; by default those of the state, ``K pi(J - 1)``.
    """
    e = len(mesh.cells)
    F, J = brick_deformation(mesh, u)
    w, P, A, L = stress_and_tangent(law, F)
    H = cofactor(F)
    p = K * np.einsum("emq,eq->em", mesh.chi, J - 1.0)
    p_at = np.einsum("em,emq->eq", p, mesh.chi)  # carries the weights
    P = mesh.weights[..., None] * P + p_at[..., None] * H
    B = mesh.B.reshape(e, -1, 81)
    forces = np.zeros(mesh.nodes.size)
    np.add.at(forces, mesh.dofs, (P.reshape(e, 1, -1) @ B)[:, 0])
    p_geometric = p_at if pressure is None else np.einsum("em,emq->eq", pressure, mesh.chi)
    A *= mesh.weights[..., None, None]
    A += p_geometric[..., None, None] * L
    b = (mesh.chi[..., None] * H[:, None]).reshape(e, 4, -1) @ B
    stiffness = B.transpose(0, 2, 1) @ (A @ mesh.B).reshape(e, -1, 81) + K * b.transpose(0, 2, 1) @ b
    energy = float((mesh.weights * w).sum() + 0.5 * (p**2).sum() / K)
    return Tangent(energy, forces, stiffness, p, float(J.min()))
