"""What do creases next to a pressed target's edge hide from the meshes of a family? An estimate beside theirs.

Silicone that is pressed to less than some two thirds of a length may fold into a crease, which meshes follow only
where their cells are smaller than it. Meshes that are not show differences that shrink as if nothing was missing: their
extrapolation (family.py) is too stiff by up to 1 % of the displacement. With W the energy of the silicone, w that of
the part of it which is under pressure and whose smallest principal stretch is below 0.55, and n cells through the
thickness,

    error = x (1 - x)/(4 n),        x = w/W,

of each component of the pose: what lies in few places is what a crease may release. Creases begin at 0.65; the singular
edges of pads that carry moderate loads without any are pressed as far at a few points, not to 0.55. Both numbers are
measured on the references of an independent code (studies/mechanics_accuracy.py), on pressed discs of three cells: a
rule for them, no theory. Layers in the plane have eight cells and more, and show what they miss: none is added there.
Stiffening laws crease less; the estimate does not see that.

Source: M. A. Biot, Appl. Sci. Res. A 12 (1963) 168, and E. Hohlfeld, L. Mahadevan, Phys. Rev. Lett. 106 (2011) 105702:
creases of an incompressible neo-Hookean half-space in plane strain from a stretch of 0.65 on.
"""

from __future__ import annotations

import numpy as np

from sits_mech.mechanics.element.kernel import deformation, kinematics
from sits_mech.mechanics.element.mesh import MixedMesh
from sits_mech.mechanics.rest.body import Bonded, State
from sits_mech.quantities import Array

_CREASED = 0.55  # stretch at points within the silicone
_HIDDEN = 0.25  # of the energy there, a cell through the thickness


def hidden_by_creases(body: Bonded, state: State, cells: int) -> float:
    """Return how far creases may move the target beyond what a family of meshes shows, over its displacement.

    Parameters
    ----------
    body : Bonded
    state : State
        At rest.
    cells : int
        Through the thickness on the finest mesh of the family that was solved.
    """
    if len(body.mesh.axes) == 2:
        return 0.0
    smallest, _ = outer_stretches(body.mesh, state.u)
    if not np.any(smallest < _CREASED):
        return 0.0
    F, _ = deformation(body.mesh, state.u)
    energy = body.law.stress(kinematics(F))[0] * body.mesh.inside.weights
    pressed = (state.p[:, None] @ body.mesh.chi)[:, 0] < 0.0
    share = float(energy[(smallest < _CREASED) & pressed].sum() / energy.sum())
    return _HIDDEN * share * (1.0 - share) / cells


def outer_stretches(mesh: MixedMesh, u: Array) -> tuple[Array, Array]:
    """Return the smallest and the largest principal stretch at the quadrature points, shape (e, q) each."""
    F, J = deformation(mesh, u)
    if F.shape[-1] == 4:
        half = 0.5 * (F**2).sum(axis=-1)
        greater = np.sqrt(half + np.sqrt(np.maximum(half**2 - J**2, 0.0)))
        return np.asarray(J / greater), np.asarray(greater)
    stretches = np.linalg.svd(F.reshape(*J.shape, 3, 3), compute_uv=False).astype(np.float64)
    return stretches[..., 2], stretches[..., 0]
