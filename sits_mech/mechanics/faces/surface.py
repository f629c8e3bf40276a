"""Gauss points of a layer's free faces: edges of a section, facets of a solid."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from skfem import Basis
from skfem.element import Element
from skfem.quadrature import get_quadrature

from sits_mech.mechanics.element.mesh import PLANE, SPACE, MixedMesh, quadratic
from sits_mech.mechanics.element.target import ORDER
from sits_mech.quantities import Array, Integers

_ORDER = 5  # of the polynomials that the quadrature on a face integrates


@dataclass(frozen=True, eq=False)
class Surface:
    """Gauss points of faces."""

    nodes: Integers  # (f, k), of each face
    shape: Array  # (f, p, k), shape functions at its points
    rest: Array  # (f, p, 3), places x, y, z at rest [thicknesses]
    weight: Array  # (f, p), reference area, length in a section [thicknesses to that power]
    size: int  # number of nodes of the mesh
    axes: tuple[int, ...] = SPACE  # of x, y, z, of the displacements

    @cached_property
    def numbers(self) -> Integers:
        """Numbers of each face's displacements and of q, shape (f, d k + 6)."""
        own = self._nodal.reshape(len(self.nodes), -1)
        q = len(self.axes) * self.size + np.arange(6)
        return np.concatenate([own, np.tile(q, (len(own), 1))], axis=1)

    @cached_property
    def numbers_of_shape(self) -> Integers:
        """The same with the height of a shape in place of q's, which follows q; nothing in place of the others."""
        found, beyond = self.numbers.copy(), len(self.axes) * self.size + 6
        found[:, -6:] = beyond + 1
        found[:, 1 - 6] = beyond
        return found

    @cached_property
    def spread(self) -> Array:
        """Place x, centre c and rotation w of points by displacements and q, shape (f, p, 9, d k + 6)."""
        (f, p, k), d = self.shape.shape, len(self.axes)
        found = np.zeros((f, p, 9, d * k + 6))
        for i, axis in enumerate(self.axes):
            found[:, :, axis, i : d * k : d] = self.shape
        found[:, :, 3 + ORDER, d * k + np.arange(6)] = 1.0
        return found

    def places(self, u: Array) -> Array:
        """Return the points at nodal displacements (d n,), shape (f, p, 3) [thicknesses]."""
        found = self.rest.copy()
        found[..., list(self.axes)] += self.shape @ u[self._nodal]
        return found

    @property
    def _nodal(self) -> Integers:
        """Numbers of the displacements of each face's nodes, shape (f, k, d)."""
        d = len(self.axes)
        return d * self.nodes[:, :, None] + np.arange(d)


def edge_points(mesh: MixedMesh, lines: list[Integers], count: int = 3) -> Surface:
    """Return `count` points on each edge of faces of a section, nodes in order: every other one ends an edge.

    About an axis they stand for full circles.
    """
    own = np.concatenate([np.stack([line[:-2:2], line[1:-1:2], line[2::2]], axis=1) for line in lines])
    points, weights = np.polynomial.legendre.leggauss(count)
    s = 0.5 * (points + 1.0)
    shape, slope = (np.stack(list(part), axis=1) for part in quadratic(s))
    length = np.linalg.norm(slope @ mesh.nodes[own], axis=2)
    rest = np.zeros((len(own), len(s), 3))
    rest[..., list(PLANE)] = shape @ mesh.nodes[own]
    every, weight = np.broadcast_to(shape, (len(own), *shape.shape)), length * (0.5 * weights)
    weight = 2.0 * np.pi * rest[..., 0] * weight if mesh.hoop else weight
    return Surface(own, every, rest, weight, len(mesh.nodes), PLANE)


def facets_of(basis: Basis, facets: Integers, order: int = _ORDER) -> Surface:
    """Return the points of boundary faces of a solid, for polynomials of an order; all nodes of its basis are nodal."""
    kind: Any = type(basis.elem)
    nodes, cells = basis.doflocs.T, basis.mesh.f2t[0, facets]
    found = []
    for local in range(len(basis.mesh.t2f)):
        own = cells[basis.mesh.t2f[local, cells] == facets]
        shape, slope, weight = _reference_face(kind, local, order)
        there = np.abs(shape).max(axis=0) > 1e-9
        each = basis.element_dofs[there][:, own].T
        along = np.einsum("dpk,fki->dfpi", slope[:, :, there], nodes[each])
        area = np.linalg.norm(np.cross(along[0], along[1]), axis=-1)
        found.append((each, np.broadcast_to(shape[:, there], (len(own), *shape[:, there].shape)), area * weight))
    own_nodes, shapes, weights = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return Surface(own_nodes, shapes, shapes @ nodes[own_nodes], weights, len(nodes))


def facet_forms(basis: Basis, facets: Integers) -> tuple[Array, Array]:
    """Return shape functions of boundary faces, by powers (f, k, 3, 3), and parameters of their nodes, (f, k, 2).

    Faces and nodes are in the order of `facets_of`.
    """
    kind: Any = type(basis.elem)
    cells, forms, places = basis.mesh.f2t[0, facets], [], []
    for local in range(len(basis.mesh.t2f)):
        own = int(np.count_nonzero(basis.mesh.t2f[local, cells] == facets))
        form, place = _reference_forms(kind, local)
        forms.append(np.tile(form, (own, 1, 1, 1)))
        places.append(np.tile(place, (own, 1, 1)))
    return np.concatenate(forms), np.concatenate(places)


def _parameters(element: Element, local: int) -> tuple[Array, Array]:
    """Return origin and directions (2, 3) of an element face's parameters: a triangle's sides, or two."""
    corners = element.doflocs[element.refdom.facets[local]]
    return corners[0], corners[[1, -1]] - corners[0]  # of a parallelogram


@lru_cache(maxsize=64)
def _reference_face(kind: type[Element], local: int, order: int) -> tuple[Array, Array, Array]:
    """Return values (p, n), slopes (2, p, n), weights (p,) at the Gauss points of an element's face."""
    element = kind()
    origin, way = _parameters(element, local)
    points, weight = get_quadrature(element.refdom.brefdom, order)
    X = origin[:, None] + way.T @ points
    values = [element.lbasis(X, i) for i in range(len(element.doflocs))]
    shape = np.stack([np.broadcast_to(value, weight.shape) for value, _ in values], axis=-1)
    slope = np.stack([way @ np.asarray(each) for _, each in values], axis=-1)
    return shape, slope, weight


@lru_cache(maxsize=16)
def _reference_forms(kind: type[Element], local: int) -> tuple[Array, Array]:
    """Return shape functions by powers (k, 3, 3), and parameters of nodes (k, 2), of an element's face."""
    element, powers = kind(), np.vander([0.0, 0.5, 1.0], increasing=True)
    origin, way = _parameters(element, local)
    a, b = (each.ravel() for each in np.meshgrid([0.0, 0.5, 1.0], [0.0, 0.5, 1.0], indexing="ij"))
    X, inverse = origin[:, None] + way.T @ np.stack([a, b]), np.linalg.inv(powers)
    values = np.stack([np.broadcast_to(element.lbasis(X, i)[0], 9) for i in range(len(element.doflocs))])
    there = np.abs(values).max(axis=1) > 1e-9
    form = inverse @ values[there].reshape(-1, 3, 3) @ inverse.T
    return form, (element.doflocs[there] - origin) @ np.linalg.pinv(way)
