"""Free faces of a pad as seen by each other: points that may meet faces, and which of these.

Points are Gauss points of the quadratic faces, more of them than contact with planes needs: what a point presses on the
other face is a load on all of that one's nodes, and what an even pressure leaves there for want of points dents it.
Flat facets through a face's nodes, segments or triangles, say which faces a point is near and about where.

Which facets a point may meet: none that lay behind the point's face at rest or that it lay behind, for that is seen
through the silicone; and of faces that share a node with its own those only that stand before it in an inner corner.

Lengths in thicknesses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from skfem import Basis

from sits_mech.mechanics.element.mesh import MixedMesh
from sits_mech.mechanics.faces.facets import behind, nearest, normals, skin
from sits_mech.mechanics.faces.surface import Surface, edge_points, facet_forms, facets_of
from sits_mech.quantities import Array, Integers, Mask

_ORDER = 9  # of the polynomials that the quadrature on a face integrates
_COUNT = 5  # points on an edge
_SEEN = 0.2  # sine of the angle by which parts of a face may lie behind each other, or before in an inner corner
SAME = 0.7
"""Least cosine between normals at rest of one face, which may fold over."""


@dataclass(frozen=True, eq=False)
class Skin:
    """The free faces of a pad, as points, quadratic faces and flat facets."""

    surface: Surface  # their Gauss points
    form: Array  # (f, k, 3) or (f, k, 3, 3), shape functions by powers of parameters that turn normals outwards
    corner: Array  # (f, k, p), parameters of their nodes
    facets: Integers  # (f, m, d), nodes in the order of outward normals
    nodes: Array  # (n, d), of the mesh [thicknesses]

    def some(self, on: Mask) -> Skin:
        """Return some of the faces."""
        own = self.surface
        points = Surface(own.nodes[on], own.shape[on], own.rest[on], own.weight[on], own.size, own.axes)
        return Skin(points, self.form[on], self.corner[on], self.facets[on], self.nodes)

    @property
    def sides(self) -> int:
        """Number of sides of a face: 1 of a section, 3 or 4."""
        k = self.surface.nodes.shape[1]
        return {3: 1, 7: 3, 9: 4}[k]

    @cached_property
    def corners(self) -> Integers:
        """Nodes of all facets, shape (f m, d)."""
        return self.facets.reshape(-1, self.facets.shape[2])

    @cached_property
    def places(self) -> Array:
        """Parameters of the facets' corners on their faces, shape (f m, d, p)."""
        f, m, d = self.facets.shape
        same = self.facets[..., None] == self.surface.nodes[:, None, None, :]
        return np.asarray(self.corner[np.arange(f)[:, None, None], same.argmax(axis=3)].reshape(f * m, d, -1))

    @cached_property
    def own(self) -> Integers:
        """Facet of its own face that each point lies on, shape (f p,)."""
        f, p, _ = self.surface.shape.shape
        m = self.facets.shape[1]
        x = np.repeat(self.points(np.zeros(self.nodes.size)), m, axis=0)
        facets = (m * np.repeat(np.arange(f), p)[:, None] + np.arange(m)).ravel()
        corners = self.nodes[self.corners[facets]]
        away, _ = behind(x, corners, nearest(x, corners), normals(corners))
        return np.asarray(facets.reshape(-1, m)[np.arange(f * p), away.reshape(-1, m).argmin(axis=1)])

    @cached_property
    def rest(self) -> tuple[Array, Array, Array]:
        """Points, middles of facets and normals of facets at rest, shape (.., d) each."""
        corners = self.nodes[self.corners]
        return self.points(np.zeros(self.nodes.size)), corners.mean(axis=1), normals(corners)

    def points(self, u: Array) -> Array:
        """Return the deformed points, shape (f p, d)."""
        place = self.surface.places(u)[..., list(self.surface.axes)]
        return place.reshape(-1, place.shape[-1])

    def apart(self, points: Integers, facets: Integers) -> Mask:
        """Whether pairs may meet: not through silicone, and with a common node only in an inner corner."""
        p, m = self.surface.shape.shape[1], self.facets.shape[1]
        x, y, n = self.rest
        own = n[self.own[points]]
        least = np.where((own * n[facets]).sum(axis=1) > SAME, -_SEEN, -1e-9)
        open_ = _before(x[points], own, y[facets], n[facets], least)
        found = np.flatnonzero(open_)
        one, other = points[found] // p, facets[found] // m
        common = np.any(self.surface.nodes[one][:, :, None] == self.surface.nodes[other][:, None, :], axis=(1, 2))
        found, one, other = found[common], one[common], other[common]
        middle, out = (each.reshape(-1, m, each.shape[1]).mean(axis=1) for each in (y, n))
        corner = _before(middle[one], out[one], middle[other], out[other], np.full(len(one), _SEEN))
        open_[found] = corner & (one != other)
        return open_


def _before(x: Array, own: Array, y: Array, other: Array, least: Array) -> Mask:
    """Whether points x and y with normals each lie before the other, by at least a sine."""
    way = x - y
    size = least * np.linalg.norm(way, axis=1)
    return np.asarray(((way * other).sum(axis=1) >= size) & (-(way * own).sum(axis=1) >= size))


def section_skin(mesh: MixedMesh, lines: Sequence[Integers]) -> Skin:
    """Return the faces of a section, lines through nodes from the ground on, the left one, if any, first."""
    *left, right = lines
    surface = edge_points(mesh, [*left, right[::-1]], _COUNT)
    every = (len(surface.nodes), 1, 1)
    powers: Array = np.vander([0.0, 0.5, 1.0], increasing=True)
    form: Array = np.tile(np.linalg.inv(powers).T, every)
    corner = np.tile([[0.0], [0.5], [1.0]], every)
    facets = np.stack([surface.nodes[:, :2], surface.nodes[:, 1:]], axis=1)
    return Skin(surface, form, corner, facets, mesh.nodes)


def solid_skin(basis: Basis, facets: Integers) -> Skin:
    """Return the faces of a solid on some facets of its mesh."""
    mesh, nodes = basis.mesh, basis.doflocs.T
    cells = mesh.f2t[0, facets]
    facets = facets[np.argsort(np.argmax(mesh.t2f[:, cells] == facets, axis=0), kind="stable")]  # as `facets_of` goes
    cells, triangles = mesh.f2t[0, facets], skin(basis, facets)
    surface, (form, corner) = facets_of(basis, facets, _ORDER), facet_forms(basis, facets)
    middle = mesh.p[:, mesh.t[:, cells]].mean(axis=1).T
    corners = nodes[triangles.reshape(-1, 3)]
    out = corners.mean(axis=1) - np.repeat(middle, triangles.shape[1], axis=0)
    turned = ((normals(corners) * out).sum(axis=1) < 0.0).reshape(triangles.shape[:2])
    triangles[turned] = triangles[turned][:, [1, 0, 2]]
    a, b = (np.einsum("fk,fkd->fd", form[(..., *power)], nodes[surface.nodes]) for power in ((1, 0), (0, 1)))
    out = nodes[surface.nodes].mean(axis=1) - middle
    turned = (np.cross(a, b) * out).sum(axis=1) < 0.0
    form, corner = form.copy(), corner.copy()
    form[turned], corner[turned] = form[turned].swapaxes(2, 3), corner[turned][..., ::-1]
    return Skin(surface, form, corner, triangles, nodes)
