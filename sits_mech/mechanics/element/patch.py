"""Some cells of a layer with the displacements that no other cell touches: those at its rims.

A rim is where a free face meets a bonded one, ground or target; strains are singular there. The displacements inside of
a patch form a problem of their own with the boundary held, with a pattern of its own (assembly.py),

    K_II du_I = -f_I,        I: free displacements of the patch's cells alone,

assembled from the patch's cells, and from parts of the energy beside them as far as they touch I. L is the stiffness of
``int grad v : grad u`` on the same cells, by which steps are damped (equilibrium/elimination.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sits_mech.mechanics.element.assembly import Pattern, pattern
from sits_mech.mechanics.element.mesh import MixedMesh
from sits_mech.quantities import Array, Integers, Mask


@dataclass(frozen=True, eq=False)
class Patch:
    """Some cells of a layer's mesh."""

    cells: Mask  # (c,), which of the layer's
    mesh: MixedMesh  # these e cells alone, on all nodes of the layer
    inner: Integers  # (m,), numbers of the displacements I
    own: Mask  # which of the layer's free displacements they are

    @cached_property
    def pattern(self) -> Pattern:
        """Assembly pattern of the cells."""
        return pattern(self.mesh, (self.mesh.dofs,), self.inner, np.zeros(0, dtype=np.int64))

    @cached_property
    def laplacian(self) -> Array:
        """L of each cell, (e, d k, d k)."""
        slope, weights = self.mesh.inside
        (e, _, _, k), d = slope.shape, self.mesh.nodes.shape[1]
        each, found = np.einsum("eq,eqda,eqdb->eab", weights, slope, slope, optimize=True), np.zeros((e, d, k, d, k))
        for i in range(d):
            found[:, i, :, i] = each
        return found.reshape(e, d * k, d * k)


def at_rims(mesh: MixedMesh, faces: Integers, free: Integers) -> Mask:
    """Whether each cell touches a rim: a held node of the free faces, whose nodes are given; (c,)."""
    nodes = np.unique(faces)
    held = nodes[~np.isin(nodes * mesh.nodes.shape[1], free)]
    return np.asarray(np.isin(mesh.cells, held).any(axis=1))


def patch_of(mesh: MixedMesh, free: Integers, cells: Mask) -> Patch | None:
    """Return the patch of some cells of a layer with free displacements; None of no cell and of all."""
    if not cells.any() or cells.all():
        return None
    inside = np.zeros(mesh.nodes.size, dtype=bool)
    inside[mesh.dofs[cells]] = True
    inside[mesh.dofs[~cells]] = False
    own = inside[free]
    return Patch(cells, mesh.part(cells), free[own], own)
