"""What does a mesh of mixed elements hold? Nodes, gradients, weights and pressures: arrays that the mesh alone decides.

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
"""The displacements' elements."""
PLANE, SPACE = (0, 2), (0, 1, 2)
"""The coordinates of a section's nodes and of a solid's, among x, y, z."""

ORDER = 5
"""Of the polynomials that the quadrature of solids integrates."""
_POINTS, _SHARES = np.polynomial.legendre.leggauss(3)
GAUSS = np.array([(a, b) for a in 0.5 * (_POINTS + 1.0) for b in 0.5 * (_POINTS + 1.0)]).T
"""Quadrature points of the unit square."""
GAUSS_WEIGHTS = 0.25 * np.outer(_SHARES, _SHARES).ravel()
NODES = np.array([(a, b) for a in (0.0, 0.5, 1.0) for b in (0.0, 0.5, 1.0)]).T
"""Nodes of the unit square."""
_SIMPSON = np.outer([1.0, 4.0, 1.0], [1.0, 4.0, 1.0]).ravel() / 36.0


class Points(NamedTuple):
    """Points of every element: gradients of its shape functions (e, q, d, k), and weights (e, q)."""

    slope: Array
    weights: Array


@dataclass(frozen=True, eq=False)
class MixedMesh:
    """A mesh of mixed elements.

    Attributes
    ----------
    nodes : ndarray, shape (n, d)
        Of the displacements [thicknesses].
    cells : ndarray, shape (e, k)
        Nodes of each element: in a section corners counter-clockwise, the side after each, the middle.
    inside : Points
        Quadrature points.
    chi : ndarray, shape (e, m, q)
        Orthonormal pressure polynomials times the weights, at the quadrature points.
    nodal : Points or None
        The elements' nodes, with the weights of Simpson's rule; None where they are not looked at.
    flat : ndarray, shape (n, d), or None
        Where the nodes of a section with curved sides stood in its rectangle; None where they stand there.
    """

    nodes: Array
    cells: Indices
    inside: Points
    chi: Array
    nodal: Points | None = None
    flat: Array | None = field(default=None, repr=False)

    @property
    def axes(self) -> tuple[int, ...]:
        """Which of x, y, z the coordinates are."""
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
        """Return some of the elements, on the same nodes, without what is looked at there."""
        inside = Points(*(each[some] for each in self.inside))
        return MixedMesh(self.nodes, self.cells[some], inside, self.chi[some], flat=self.flat)


class DeformedSection(NamedTuple):
    """A deformed layer in an upright plane, for pictures, in the sensor's coordinates.

    Attributes
    ----------
    points, rest : ndarray, shape (n, 2)
        Places along the plane and up, deformed and before [m].
    quads : ndarray, shape (m, 4)
        Corners, in order; of a triangle one of them twice.
    J, stretch : ndarray, shape (m,)
        Smallest volume ratio, and largest principal stretch or reciprocal of one, at any point of each one's cell.
    """

    points: Array
    quads: Indices
    J: Array
    stretch: Array
    rest: Array


def section_mesh(x: Array, z: Array, placed: Callable[[Array], Array] | None = None) -> MixedMesh:
    """Mesh a rectangle on the given lines.

    Parameters
    ----------
    x, z : ndarray
        Mesh lines [thicknesses].
    placed : callable, optional
        Where the nodes of the rectangle, shape (n, 2), come to stand: sides become parabolas.
    """
    straight = MeshQuad.init_tensor(x, z)
    mesh = MeshQuad2.from_mesh(MeshQuad(straight.p, straight.t[[0, 3, 2, 1]]))  # counter-clockwise
    flat = mesh.doflocs.T
    if placed is None:
        return plane_mesh(mesh)
    return plane_mesh(MeshQuad2(np.ascontiguousarray(placed(flat).T), mesh.t), flat)


def plane_mesh(mesh: MeshQuad2, flat: Array | None = None) -> MixedMesh:
    """Return the arrays of a meshed section.

    Parameters
    ----------
    mesh : skfem.MeshQuad2
        Corners counter-clockwise [thicknesses].
    flat : ndarray, shape (n, 2), optional
        As of `MixedMesh`.
    """
    basis = Basis(mesh, SQUARE, quadrature=(GAUSS, GAUSS_WEIGHTS))
    nodal = _points(Basis(mesh, SQUARE, quadrature=(NODES, _SIMPSON)))
    chi = pressures(np.asarray(basis.global_coordinates()), basis.dx)
    nodes, cells = np.ascontiguousarray(mesh.doflocs.T), np.ascontiguousarray(basis.element_dofs.T)
    return MixedMesh(nodes, cells, _points(basis), chi, nodal, flat)


def solid_mesh(mesh: Mesh, element: Element, constant: bool = False) -> tuple[MixedMesh, Basis]:
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
    basis = Basis(mesh, element, intorder=ORDER)
    chi = pressures(np.asarray(basis.global_coordinates()), basis.dx, constant)
    nodes, cells = np.ascontiguousarray(basis.doflocs.T), np.ascontiguousarray(basis.element_dofs.T)
    return MixedMesh(nodes, cells, _points(basis), chi), basis


def pressures(points: Array, weights: Array, constant: bool = False) -> Array:
    """Return the orthonormal polynomials of degree one times the weights, shape (e, d + 1, q), of cells' points.

    Parameters
    ----------
    points : ndarray, shape (d, e, q)
    weights : ndarray, shape (e, q)
    constant : bool
        Whether the polynomials are of degree zero, shape (e, 1, q).
    """
    area = weights.sum(axis=1)
    centre = (points * weights).sum(axis=2) / area
    local = (points - centre[..., None]) / area[:, None] ** (1.0 / len(points))
    basis = np.concatenate([np.ones_like(weights)[None], local]).swapaxes(0, 1)[:, : 1 if constant else None]
    weighted = basis * weights[:, None]
    return np.asarray(np.linalg.solve(np.linalg.cholesky(weighted @ basis.swapaxes(1, 2)), weighted))


def _points(basis: Basis) -> Points:
    """Gradients and weights of a basis."""
    slope = np.empty((*basis.dx.shape, basis.mesh.dim(), len(basis.basis)))
    for k, shape in enumerate(basis.basis):
        slope[..., k] = np.moveaxis(np.asarray(shape[0].grad), 0, -1)
    return Points(slope, np.ascontiguousarray(basis.dx))
