"""Arrays of a mesh of mixed elements: nodes, gradients, weights and pressures, independent of the state.

Displacements that make piecewise linear discontinuous pressures inf-sup stable: 9-node quadrilaterals in plane strain,
27-node bricks, or quadratic tetrahedra with a bubble on each face and one inside, 15 nodes. scikit-fem gives their
gradients at the quadrature points. In a plane section the coordinates are x and z.

Pressures are the orthonormal polynomials of degree one on each element (or of degree zero): ``chi`` holds their values
times the quadrature weights, so that ``pi(f)`` has the coefficients ``sum_q chi_mq f_q``.

Unknowns: nodal displacements in thicknesses; those of an element are numbered component by component. Source: D. Boffi,
F. Brezzi, M. Fortin, Mixed Finite Element Methods and Applications (2013), sections 8.6 and 8.7. Valid for cells of any
aspect that are not inverted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, Mesh, MeshQuad, MeshQuad2
from skfem.element import Element, ElementHex2, ElementQuad2, ElementTetCCR

from sits_mech.quantities import Array

Indices = NDArray[np.int64]

SQUARE, BRICK, TETRAHEDRON = ElementQuad2(), ElementHex2(), ElementTetCCR()
"""Elements of the displacements."""
PLANE, SPACE = (0, 2), (0, 1, 2)
"""Axes of a section's nodes and of a solid's, among x, y, z."""

ORDER = 5
"""Degree of polynomials that the quadrature of solids integrates exactly."""
_POINTS, _SHARES = np.polynomial.legendre.leggauss(3)
GAUSS = np.array([(a, b) for a in 0.5 * (_POINTS + 1.0) for b in 0.5 * (_POINTS + 1.0)]).T
"""Quadrature points of the unit square."""
GAUSS_WEIGHTS = 0.25 * np.outer(_SHARES, _SHARES).ravel()
NODES = np.array([(a, b) for a in (0.0, 0.5, 1.0) for b in (0.0, 0.5, 1.0)]).T
"""Nodes of the unit square."""
_SIMPSON = np.outer([1.0, 4.0, 1.0], [1.0, 4.0, 1.0]).ravel() / 36.0


class Points(NamedTuple):
    """Points of every element."""

    slope: Array  # gradients of the shape functions, (e, q, d, k)
    weights: Array  # (e, q)


@dataclass(frozen=True, eq=False)
class MixedMesh:
    """A mesh of mixed elements."""

    nodes: Array  # (n, d), of the displacements [thicknesses]
    cells: Indices  # (e, k), nodes; in a section corners counter-clockwise, side after each, middle
    inside: Points  # quadrature points
    chi: Array  # (e, m, q), orthonormal pressure polynomials times weights
    nodal: Points | None = None  # the elements' nodes with Simpson weights
    flat: Array | None = field(default=None, repr=False)  # (n, d), nodes of a curved section in its rectangle

    @property
    def axes(self) -> tuple[int, ...]:
        """Axes of x, y, z that the coordinates are."""
        return PLANE if self.nodes.shape[1] == 2 else SPACE

    @cached_property
    def dofs(self) -> Indices:
        """Numbers ``d node + component`` of each element's displacements, component by component, shape (e, d k)."""
        d = self.nodes.shape[1]
        return np.asarray((d * self.cells[:, None, :] + np.arange(d)[:, None]).reshape(len(self.cells), -1))

    @property
    def places(self) -> Array:
        """Nodes in the rectangle, shape (n, d) [thicknesses]."""
        return self.nodes if self.flat is None else self.flat

    def part(self, some: slice) -> MixedMesh:
        """Return some of the elements on the same nodes, without their nodal points."""
        inside = Points(*(each[some] for each in self.inside))
        return MixedMesh(self.nodes, self.cells[some], inside, self.chi[some], flat=self.flat)


class DeformedSection(NamedTuple):
    """A deformed layer in an upright plane, for pictures, in the sensor's coordinates."""

    points: Array  # (n, 2), along the plane and up [m]
    quads: Indices  # (m, 4), corners in order; of a triangle one twice
    J: Array  # (m,), smallest in each one's cell
    stretch: Array  # (m,), largest principal stretch or reciprocal in each one's cell
    rest: Array  # (n, 2), undeformed points [m]


def section_mesh(x: Array, z: Array, placed: Callable[[Array], Array] | None = None) -> MixedMesh:
    """Mesh a rectangle on given lines [thicknesses]; `placed` maps its nodes (n, 2), sides become parabolas."""
    straight = MeshQuad.init_tensor(x, z)
    mesh = MeshQuad2.from_mesh(MeshQuad(straight.p, straight.t[[0, 3, 2, 1]]))  # counter-clockwise
    flat = mesh.doflocs.T
    if placed is None:
        return plane_mesh(mesh)
    return plane_mesh(MeshQuad2(np.ascontiguousarray(placed(flat).T), mesh.t), flat)


def plane_mesh(mesh: MeshQuad2, flat: Array | None = None) -> MixedMesh:
    """Return the arrays of a meshed section, corners counter-clockwise [thicknesses]; `flat` as in `MixedMesh`."""
    basis = Basis(mesh, SQUARE, quadrature=(GAUSS, GAUSS_WEIGHTS))
    nodal = _points(Basis(mesh, SQUARE, quadrature=(NODES, _SIMPSON)))
    chi = pressures(np.asarray(basis.global_coordinates()), basis.dx)
    nodes, cells = np.ascontiguousarray(mesh.doflocs.T), np.ascontiguousarray(basis.element_dofs.T)
    return MixedMesh(nodes, cells, _points(basis), chi, nodal, flat)


def solid_mesh(mesh: Mesh, element: Element, constant: bool = False) -> tuple[MixedMesh, Basis]:
    """Return the arrays of a meshed pad [thicknesses], and scikit-fem's basis that names nodes and facets.

    Elements: `BRICK` or `TETRAHEDRON`. `constant`: pressures constant in each element, less accurate on the same nodes.
    """
    basis = Basis(mesh, element, intorder=ORDER)
    chi = pressures(np.asarray(basis.global_coordinates()), basis.dx, constant)
    nodes, cells = np.ascontiguousarray(basis.doflocs.T), np.ascontiguousarray(basis.element_dofs.T)
    return MixedMesh(nodes, cells, _points(basis), chi), basis


def pressures(points: Array, weights: Array, constant: bool = False) -> Array:
    """Return orthonormal linear polynomials times weights, shape (e, d + 1, q), or (e, 1, q) if `constant`.

    Points have the shape (d, e, q), weights (e, q).
    """
    area = weights.sum(axis=1)
    centre = (points * weights).sum(axis=2) / area
    local = (points - centre[..., None]) / area[:, None] ** (1.0 / len(points))
    basis = np.concatenate([np.ones_like(weights)[None], local]).swapaxes(0, 1)[:, : 1 if constant else None]
    weighted = basis * weights[:, None]
    return np.asarray(np.linalg.solve(np.linalg.cholesky(weighted @ basis.swapaxes(1, 2)), weighted))


def _points(basis: Basis) -> Points:
    """Return gradients and weights of a basis."""
    slope = np.empty((*basis.dx.shape, basis.mesh.dim(), len(basis.basis)))
    for k, shape in enumerate(basis.basis):
        slope[..., k] = np.moveaxis(np.asarray(shape[0].grad), 0, -1)
    return Points(slope, np.ascontiguousarray(basis.dx))
