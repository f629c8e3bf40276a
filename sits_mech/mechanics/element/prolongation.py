"""Carry a state to a refined mesh: the same displacements and pressures by other unknowns.

A node of the fine mesh takes the displacement that the coarse mesh has there, by the shape functions of the cell in
which it lies; a fine cell takes the coarse linear pressure, by its coefficients in the fine cell's polynomials:

    u_f = P u,     P_ab = N_b(xi_a),          p_fm = int_cell p_c psi_m.

For 9-node quadrilaterals and 27-node bricks, curved ones too, both are exact: the coarse functions are among the fine
ones. The face and inner bubbles of tetrahedra are cubic and quartic: their children hold no cubics, so that these are
interpolated, and quadratic displacements are exact. Pressures are linear in the place, which refinement keeps.

Between meshes of one family (geometry/meshing/bricks.py) whose cells do not nest both are interpolated, for a start.

Unknowns as in mesh.py. Source: multigrid, W. Hackbusch, Multi-Grid Methods and Applications (1985), section 3.4.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy import sparse
from skfem.element import Element, ElementQuad2
from skfem.quadrature import get_quadrature

from sits_mech.geometry.meshing.bricks import Subdivision
from sits_mech.geometry.meshing.refinement import Refinement, shape_values
from sits_mech.mechanics.element.mesh import BRICK, GAUSS, ORDER, MixedMesh
from sits_mech.quantities import Array, Integers


@dataclass(frozen=True, eq=False)
class Prolongation:
    """The map from a mesh to its refinement; made by `prolongation`."""

    nodes: sparse.csr_matrix  # (n_fine, n_coarse)
    linear: Array  # (s, f, m_fine, m_coarse), pressures of a fine cell from s parents of equal weight
    parents: Integers  # (s, f)

    def displacements(self, u: Array) -> Array:
        """Return nodal displacements of the fine mesh, (d n_fine,) or with columns, from the coarse mesh's."""
        fine, coarse = self.nodes.shape
        return np.asarray(self.nodes @ u.reshape(coarse, -1)).reshape(len(u) // coarse * fine, *u.shape[1:])

    def pressures(self, p: Array) -> Array:
        """Return the fine cells' pressures (f, m) from the coarse ones' (e, m)."""
        return np.asarray((self.linear @ p[self.parents, :, None])[..., 0].mean(axis=0))


def prolongation(coarse: MixedMesh, fine: MixedMesh, refinement: Refinement, element: Element) -> Prolongation:
    """Return the map from a mesh to one refined from it.

    Both are made from scikit-fem meshes with `element`, `fine` from `refinement.mesh`, in the order of its cells.
    """
    values = np.stack([shape_values(element, points) for points in refinement.within(element.doflocs)])
    numbers, first = np.unique(fine.cells, return_index=True)
    cell, local = np.divmod(first, fine.cells.shape[1])
    shape = (len(fine.nodes), len(coarse.nodes))
    columns = coarse.cells[refinement.parents[cell]]
    nodes = _nodal(values[refinement.kinds[cell], local], numbers, columns, shape)
    parents = refinement.parents[None]
    return Prolongation(nodes, _linear(coarse, fine, parents, element), parents)


def along_family(coarse: MixedMesh, fine: MixedMesh, divisions: tuple[Subdivision, Subdivision]) -> Prolongation:
    """Return the map from one mesh of a family of bricks to a finer one, whose cells need not nest."""
    own, new = divisions
    numbers, first = np.unique(fine.cells, return_index=True)
    cell, local = np.divmod(first, fine.cells.shape[1])
    size = new.high[cell] - new.low[cell]
    owner, at = _located(own, new.base[cell], new.low[cell] + BRICK.doflocs[local] * size)
    nodes = _nodal(shape_values(BRICK, at), numbers, coarse.cells[owner], (len(fine.nodes), len(coarse.nodes)))
    nudges = 1e-6 * np.array(list(product((-1.0, 1.0), repeat=own.low.shape[1])))  # a middle may lie between parents
    middle = 0.5 * (new.low + new.high)
    parents = np.stack([_located(own, new.base, middle + away)[0] for away in nudges])
    return Prolongation(nodes, _linear(coarse, fine, parents, BRICK), parents)


def _nodal(weights: Array, rows: Integers, columns: Integers, shape: tuple[int, int]) -> sparse.csr_matrix:
    """Return the map of nodal values by weights (f, k) of nodes `columns` (f, k) for each of f nodes `rows`."""
    weights[np.abs(weights) < 1e-13] = 0.0
    nodes = sparse.csr_matrix((weights.ravel(), (np.repeat(rows, weights.shape[1]), columns.ravel())), shape=shape)
    nodes.eliminate_zeros()
    return nodes


def _located(own: Subdivision, base: Integers, places: Array) -> tuple[Integers, Array]:
    """Return the cells of a division that hold places in base cells, and reference coordinates there (n, d)."""
    count, d = int(own.part.max()) + 1, own.part.shape[1]
    cells = np.zeros((own.bases, *[count] * d), dtype=np.int64)
    cells[own.base, *own.part.T] = np.arange(len(own.base))
    starts = np.full((own.bases, d, count), np.inf)  # base cells need not have as many parts along each axis
    for axis in range(d):
        starts[own.base, axis, own.part[:, axis]] = own.low[:, axis]
    part = np.sum(places[..., None] >= starts[base][..., 1:] - 1e-9, axis=-1)
    found = np.asarray(cells[base, *part.T])
    return found, (places - own.low[found]) / (own.high[found] - own.low[found])


def _linear(coarse: MixedMesh, fine: MixedMesh, own: Integers, element: Element) -> Array:
    """Return a fine cell's pressure coefficients from its parents', both affine functions of place."""
    points = GAUSS if isinstance(element, ElementQuad2) else get_quadrature(element, ORDER)[0]
    values = shape_values(element, points.T)
    here, there = (values @ mesh.nodes[mesh.cells] for mesh in (coarse, fine))
    centre = coarse.nodes[coarse.cells].mean(axis=1, keepdims=True)
    size = np.ptp(coarse.nodes[coarse.cells], axis=1).max(axis=1)[:, None, None]
    basis = _affine((here - centre) / size)
    moments = (basis * coarse.inside.weights[..., None]).swapaxes(1, 2) @ basis
    affine = np.linalg.solve(moments, basis.swapaxes(1, 2) @ coarse.chi.swapaxes(1, 2))
    each = [fine.chi @ _affine((there - centre[cell]) / size[cell]) @ affine[cell] for cell in own]
    return np.stack(each)


def _affine(places: Array) -> Array:
    """Return 1 and the coordinates, shape (..., d + 1)."""
    return np.concatenate([np.ones_like(places[..., :1]), places], axis=-1)
