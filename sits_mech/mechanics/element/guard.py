"""Keep the elements of a section from inverting: a part of the bulk modulus that acts pointwise.

    kappa int (J - 1 - ln J)

by Simpson's rule on the elements' nodes, corners included: without bound towards inversion, and nothing at rest.
Energies in shear modulus times thickness squared. Source: the volumetric energy of J. C. Simo, R. L. Taylor, Comput.
Methods Appl. Mech. Engng 85 (1991) 273, here as a barrier. (A solid's guard stands in its law, at quadrature points.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sits_mech.mechanics.element.assembly import Term
from sits_mech.mechanics.element.kernel import deformation, kinematics, summed
from sits_mech.mechanics.element.mesh import MixedMesh
from sits_mech.quantities import Array


@dataclass(frozen=True)
class Guard:
    """A barrier that keeps J > 0 at the nodes of a section's elements."""

    mesh: MixedMesh
    kappa: float  # part of the bulk modulus [shear moduli]

    def __call__(self, u: Array, q: Array) -> Term:
        """Return energy, forces and stiffness of the guard; `q` is not used."""
        mesh = self.mesh
        if mesh.nodal is None:
            raise ValueError("mesh: must hold the gradients at its nodes")
        slope, weights = mesh.nodal
        F, J = deformation(mesh, u, mesh.nodal)
        state = kinematics(F)
        e, q_, d, k = slope.shape
        each = np.zeros((e, q_, d, d, d, k))  # F by an element's displacements
        for i in range(d):
            each[:, :, i, :, i] = slope
        B = each.reshape(e, q_ * d * d, d * k)
        first, second = self.kappa * weights * (1.0 - 1.0 / J), self.kappa * weights / J**2
        forces = summed(mesh.dofs, (first[..., None] * state.H).reshape(e, 1, -1) @ B, len(u) + 6)
        C = second[..., None, None] * state.H[..., :, None] * state.H[..., None, :]
        state.add_L(C, first)
        stiffness = B.swapaxes(1, 2) @ (C @ B.reshape(e, q_, d * d, d * k)).reshape(B.shape)
        energy = self.kappa * float((weights * (J - 1.0 - np.log(J))).sum())
        return Term(energy, forces, mesh.dofs, stiffness)
