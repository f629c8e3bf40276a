"""Arrays of a mesh of mixed elements: nodes, gradients, weights and pressures, independent of the state.

Displacements that make piecewise linear discontinuous pressures inf-sup stable: 9-node quadrilaterals in plane strain,
27-node bricks, or quadratic tetrahedra with a bubble on each face and one inside, 15 nodes. scikit-fem gives their
gradients at the quadrature points. In a plane section the coordinates are x and z. The half of one at x >= 0 is that of
a body about the axis x = 0, too: with N_a/x as gradients along the hoop, dN_a/dx in its place on the axis where no node
moves sideways, and weights times 2 pi x (`about_axis`).

Pressures are the orthonormal polynomials of degree one on each element (or of degree zero): ``chi`` holds their values
times the quadrature weights, so that ``pi(f)`` has the coefficients ``sum_q chi_mq f_q``.

Unknowns: nodal displacements in thicknesses; those of an element are numbered component by component. Source: D. Boffi,
F. Brezzi, M. Fortin, Mixed Finite Element Methods and Applications (2013), sections 8.6 and 8.7. Valid for cells of any
aspect that are not inverted.

Cells at a bonded corner that opens may be split into triangles that meet in the corner (`fanned`).

There the displacement goes as ``r f(theta)`` with a strain that is finite but differs from direction to
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

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from skfem import Basis, Mesh, MeshQuad, MeshQuad2
from skfem.element import Element, ElementHex2, ElementQuad2, ElementTetCCR

from sits_mech.geometry.meshing.refinement import shape_values
from sits_mech.quantities import Array, Integers, Mask

SQUARE, BRICK, TETRAHEDRON = ElementQuad2(), ElementHex2(), ElementTetCCR()
"""Elements of the displacements."""
PLANE, SPACE = (0, 2), (0, 1, 2)
"""Axes of a section's nodes and of a solid's, among x, y, z."""

ORDER = 5
"""Degree of polynomials that the quadrature of solids integrates exactly."""
_POINTS, _SHARES = np.polynomial.legendre.leggauss(3)
GAUSS = np.array([(a, b) for a in 0.5 * (_POINTS + 1.0) for b in 0.5 * (_POINTS + 1.0)]).T
"""Quadrature points of the unit square."""
GAUSS_WEIGHTS = 0.25 * np.outer(_SHARES, _SHARES).ravel()  # of these points
NODES = np.array([(a, b) for a in (0.0, 0.5, 1.0) for b in (0.0, 0.5, 1.0)]).T
"""Nodes of the unit square."""
_SIMPSON = np.outer([1.0, 4.0, 1.0], [1.0, 4.0, 1.0]).ravel() / 36.0
# places (i, j) of the nodes along xi and eta in halves; i = 0 is the corner
_ORDER = ((0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1))


class Points(NamedTuple):
    """Points of every element."""

    slope: Array  # gradients of the shape functions, (e, q, d, k); about an axis by r, t, z, (e, q, 3, k)
    weights: Array  # (e, q)


@dataclass(frozen=True, eq=False)
class MixedMesh:
    """A mesh of mixed elements."""

    nodes: Array  # (n, d), of the displacements [thicknesses]
    cells: Integers  # (e, k), nodes; in a section corners counter-clockwise, side after each, middle
    inside: Points  # quadrature points
    chi: Array  # (e, m, q), orthonormal pressure polynomials times weights
    nodal: Points | None = None  # the elements' nodes with Simpson weights
    flat: Array | None = field(default=None, repr=False)  # (n, d), nodes of a curved section in its rectangle

    @property
    def axes(self) -> tuple[int, ...]:
        """Axes of x, y, z that the coordinates are."""
        return PLANE if self.nodes.shape[1] == 2 else SPACE

    @property
    def hoop(self) -> bool:
        """Whether a section is that of a body about an axis."""
        return bool(self.inside.slope.shape[2] != self.nodes.shape[1])

    @cached_property
    def dofs(self) -> Integers:
        """Numbers ``d node + component`` of each element's displacements, component by component, shape (e, d k)."""
        d = self.nodes.shape[1]
        return np.asarray((d * self.cells[:, None, :] + np.arange(d)[:, None]).reshape(len(self.cells), -1))

    @property
    def places(self) -> Array:
        """Nodes in the rectangle, shape (n, d) [thicknesses]."""
        return self.nodes if self.flat is None else self.flat

    def part(self, some: slice | Mask) -> MixedMesh:
        """Return some of the elements on the same nodes, without their nodal points."""
        inside = Points(*(each[some] for each in self.inside))
        return MixedMesh(self.nodes, self.cells[some], inside, self.chi[some], flat=self.flat)


class DeformedSection(NamedTuple):
    """A deformed layer in an upright plane, for pictures, in the sensor's coordinates."""

    points: Array  # (n, 2), along the plane and up [m]
    quads: Integers  # (m, 4), corners in order; of a triangle one twice
    J: Array  # (m,), smallest in each one's cell
    stretch: Array  # (m,), largest principal stretch or reciprocal in each one's cell
    rest: Array  # (n, 2), undeformed points [m]

    @property
    def mirrored(self) -> DeformedSection:
        """That of a half meridian with its mirror image."""
        points, rest = (np.concatenate([each, each * (-1.0, 1.0)]) for each in (self.points, self.rest))
        quads = np.concatenate([self.quads, len(self.points) + self.quads[:, ::-1]])
        return DeformedSection(points, quads, np.tile(self.J, 2), np.tile(self.stretch, 2), rest)


def section_mesh(
    x: Array, z: Array, placed: Callable[[Array], Array] | None = None, filled: Callable[[Array], Mask] | None = None
) -> MixedMesh:
    """Mesh a rectangle on given lines [thicknesses]; `placed` maps its nodes (n, 2), sides become parabolas.

    `filled` tells of the middles of cells, (e, 2), which there are.
    """
    straight = MeshQuad.init_tensor(x, z)
    if filled is not None:
        straight = straight.restrict(np.flatnonzero(filled(straight.p[:, straight.t].mean(axis=1).T)))
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


def about_axis(mesh: MixedMesh) -> MixedMesh:
    """Return a section at x >= 0, its nodal points included, as the half meridian of a body about the axis x = 0."""
    values = shape_values(SQUARE, GAUSS.T)
    if mesh.nodal is None:
        raise ValueError("mesh: must hold the gradients at its nodes")
    inside, nodal = (
        _turned(points, each @ mesh.nodes[mesh.cells][..., 0, None], each)
        for points, each in ((mesh.inside, values), (mesh.nodal, shape_values(SQUARE, NODES.T)))
    )
    chi = pressures(np.moveaxis(values @ mesh.nodes[mesh.cells], -1, 0), inside.weights)
    return replace(mesh, inside=inside, chi=chi, nodal=nodal)


def _turned(points: Points, r: Array, values: Array) -> Points:
    """Return points at distances r, (e, q, 1), with the hoop's gradients and the weights of full turns."""
    along = points.slope[:, :, 0]
    hoop = np.where(r > 0.0, values / np.where(r > 0.0, r, 1.0), along)
    return Points(np.stack([along, hoop, points.slope[:, :, 1]], axis=2), 2.0 * np.pi * r[..., 0] * points.weights)


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


def fanned(mesh: MixedMesh, corners: Array) -> MixedMesh:
    """Return a section whose cells at corners (k, 2) [thicknesses] are split into triangles, new nodes last."""
    if mesh.nodal is None:
        raise ValueError("mesh: must hold the gradients at its nodes")
    at = [int(np.argmin(np.sum((mesh.nodes - corner) ** 2, axis=1))) for corner in corners]
    split, place = np.nonzero(np.isin(mesh.cells[:, :4], at))
    around, cells = (place[:, None] + np.arange(4)) % 4, mesh.cells[split]
    tip, A, far, C = np.take_along_axis(cells, around, axis=1).T
    to_A, to_far, from_far, to_C = np.take_along_axis(cells, 4 + around, axis=1).T
    first = np.stack([tip, A, far, to_A, to_far, cells[:, 8]], axis=1)  # tip, both ends, and the middles between them
    triangles = np.concatenate([first, np.stack([tip, far, C, cells[:, 8], from_far, to_C], axis=1)])
    new = mesh.nodes[triangles[:, [0, 0, 1, 2]]].mean(axis=1)
    tip, A, C, to_A, AC, to_C = triangles.T
    middle = len(mesh.nodes) + np.arange(len(new))
    halves = np.stack([tip, A, C, tip, to_A, AC, to_C, tip, middle], axis=1)
    kept = np.delete(np.arange(len(mesh.cells)), split)
    ends = mesh.nodes[triangles[:, :3]]
    slope, area, places = _gradients(ends, *GAUSS)
    inside = Points(slope, area * GAUSS_WEIGHTS)
    chi = pressures(np.moveaxis(places, -1, 0), inside.weights)
    even = np.repeat(inside.weights.sum(axis=1)[:, None] / 9.0, 9, axis=1)
    nodal = Points(_gradients(ends, *NODES)[0], even)
    nodes = np.concatenate([mesh.nodes, new])
    flat = None if mesh.flat is None else np.concatenate([mesh.flat, new])  # cells that are split are rectangles
    both = (
        Points(*(np.concatenate([old[kept], own]) for old, own in zip(olds, owns, strict=True)))
        for olds, owns in ((mesh.inside, inside), (mesh.nodal, nodal))
    )
    cells = np.concatenate([mesh.cells[kept], halves])
    return MixedMesh(nodes, cells, next(both), np.concatenate([mesh.chi[kept], chi]), next(both), flat)


def _gradients(corners: Array, xi: Array, eta: Array) -> tuple[Array, Array, Array]:
    """Return shape function gradients, area per unit of xi and eta, and places of points of collapsed cells."""
    tip, A, C = (corners[:, None, k] for k in range(3))
    (_, da), (b, db) = quadratic(xi), quadratic(eta)
    a_over = np.stack([np.zeros_like(xi), 4.0 * (1.0 - xi), 2.0 * xi - 1.0])  # a / xi; the corner's own cancel
    i, j = np.array(_ORDER).T
    along, across = (da[i] * b[j]).T, (a_over[i] * db[j]).T
    X_xi, X_eta = (A - tip) + eta[:, None] * (C - A), C - A
    det = X_xi[..., 0] * X_eta[..., 1] - X_xi[..., 1] * X_eta[..., 0]
    slope = np.stack([
        along * X_eta[..., 1:] - across * X_xi[..., 1:], across * X_xi[..., :1] - along * X_eta[..., :1]
    ], axis=2)
    return slope / det[..., None, None], det * xi, tip + xi[:, None] * X_xi


def quadratic(s: Array) -> tuple[Array, Array]:
    """Return values and slopes, (3, n), of the quadratic shape functions of 0, 1/2, 1 at s in 0..1."""
    values = np.stack([(1.0 - s) * (1.0 - 2.0 * s), 4.0 * s * (1.0 - s), s * (2.0 * s - 1.0)])
    return values, np.stack([4.0 * s - 3.0, 4.0 - 8.0 * s, 4.0 * s - 1.0])
