"""What keeps free faces from passing through one another? A part of the pad's energy, frictionless: walls of slots,
neighbouring pillars, folds.

Strong form: of two points of the boundary that meet, y the nearest to x, the gap is g = n . (x - y) >= 0 with n the
outward normal at y, the traction t = -p n on x and p n on y with p >= 0, p g = 0. Weak form, both faces being the one
and the other in turn, so that neither is preferred:

    int phi(-g) dA  over all free faces,        g(x) from the nearest facet of the other face (closest.py),

phi that of contact.py, regularised over the depth h and with exact forces, tangent and work; the tangent is symmetric.
A pair of faces is pressed from both sides, so that half a depth holds what contact with a plane holds at one. x runs
over the Gauss points of the curved faces, y over flat facets with corners in their nodes: what faces sag between
them is missed, s^2/8 times the curvature for facets of size s, nothing where faces are flat. The loads on the corners
of facets are not those of an even pressure on a quadratic face: where elements of both faces do not match they dent
each other. Measured on two confined blocks, K = 50 shear moduli, pressed by 0.7 of one: matching meshes are 1.2 % too
soft, others of 2 and 3 cells 40 %, of 4 and 5 cells 20 %. Users' pads must be fine where their faces touch.

Which facets a point may meet: none of its own element or of one that shares a node with it; none that lay behind the
point's face at rest or that it lay behind, for that is seen through the silicone; none that faces the same way. What
presses faced each other at rest, as walls of a slot do, or is one face that has folded over: faces that meet in an
inner corner do not press, for what the mesh makes of a corner that closes is no contact. Behind a facet counts what is
behind the nearest one, and no deeper than `_DEEPEST`. Which faces are near each other
changes as the pad moves, and the stiffness with it: `near` finds them in a state, with a margin, and the part holds
these and no others.

Unknowns: nodal displacements; energies in shear modulus times thickness to the power of the dimension. Neglected:
friction, corners that close, folds sharper than two elements. Source: P. Wriggers, Computational Contact Mechanics
(2006), chapters 6 and 9.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from skfem import Basis

from sits_mech.mechanics.element.assembly import Term
from sits_mech.mechanics.element.kernel import summed
from sits_mech.mechanics.element.mesh import Indices, MixedMesh
from sits_mech.mechanics.faces.closest import behind, gaps, nearest, normals
from sits_mech.mechanics.faces.contact import pressure
from sits_mech.mechanics.faces.self_contact import skin
from sits_mech.mechanics.faces.surface import Surface, edges, facets_of
from sits_mech.quantities import Array

Flags = NDArray[np.bool_]

_MARGIN = 0.1  # thicknesses between faces that are looked at
_AT_ONCE = 0.02  # thicknesses between faces that must be looked at
_DEEPEST = 0.3  # thicknesses behind a facet that a point may have come
_ASIDE = 0.3  # cosine between normals of faces that are looked at; those of faces that press are opposed
_SEEN = 0.2  # sine of the angle behind a face at rest from which another is seen through the silicone
_CORNER, _SAME = 0.3, 0.7  # cosines between normals at rest: those of faces of a corner lie between -0.3 and 0.7
_OPPOSED = -0.1  # cosine between normals of faces that press


class _Meeting(NamedTuple):
    """Points with the facet nearest to each: numbers of points and facets, distance, place along the facet's normal."""

    points: Indices
    facets: Indices
    away: Array
    before: Array

    def some(self, which: Indices) -> _Meeting:
        """Return some of them."""
        return _Meeting(self.points[which], self.facets[which], self.away[which], self.before[which])


@dataclass(frozen=True, eq=False)
class Skin:
    """The free faces of a pad, as points and as facets.

    Attributes
    ----------
    surface : Surface
        Their Gauss points.
    facets : ndarray, shape (f, m, d)
        Nodes of the flat facets of each face, in the order that turns their normals outwards.
    nodes : ndarray, shape (n, d)
        Of the mesh [thicknesses].
    """

    surface: Surface
    facets: Indices
    nodes: Array

    @cached_property
    def corners(self) -> Indices:
        """Nodes of all facets, shape (f m, d)."""
        return self.facets.reshape(-1, self.facets.shape[2])

    @cached_property
    def local(self) -> Indices:
        """Which of their face's nodes they are, shape (f m, d)."""
        same = self.facets[..., None] == self.surface.nodes[:, None, None, :]
        return np.asarray(same.argmax(axis=3).reshape(self.corners.shape))

    @cached_property
    def own(self) -> Indices:
        """The facet of its own face that each point lies on, shape (f p,)."""
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
        """Return where the points are, shape (f p, d)."""
        place = self.surface.places(u)[..., list(self.surface.axes)]
        return np.asarray(place.reshape(-1, place.shape[-1]))

    def apart(self, points: Indices, facets: Indices) -> Flags:
        """Say of pairs whether they may meet: by no common node, and not through the silicone."""
        p, m = self.surface.shape.shape[1], self.facets.shape[1]
        x, y, n = self.rest
        way = x[points] - y[facets]
        least = -_SEEN * np.linalg.norm(way, axis=1)
        open_ = ((way * n[facets]).sum(axis=1) >= least) & (-(way * n[self.own[points]]).sum(axis=1) >= least)
        found = np.flatnonzero(open_)
        one, other = self.surface.nodes[points[found] // p], self.surface.nodes[facets[found] // m]
        open_[found] = ~np.any(one[:, :, None] == other[:, None, :], axis=(1, 2))
        return np.asarray(open_)


@dataclass(frozen=True, eq=False)
class SelfContact:
    """Free faces before each other.

    Attributes
    ----------
    skin : Skin
    depth : float
        Over which the pressure builds up [thicknesses].
    pairs : ndarray, shape (n, 2), or None
        Faces that are held against each other, those of the points first; None for those near in each state.
    """

    skin: Skin
    depth: float
    pairs: Indices | None = None

    def __call__(self, u: Array, q: Array) -> Term:
        """Return energy, forces and stiffness of the contact at displacements `u`; `q` plays no part."""
        here = self if self.pairs is not None else self.near(u)
        faces, size = self.skin.surface, len(u) + 6
        numbers = here._numbers
        met = here._met(u)
        on = np.flatnonzero(met.before < 0.0)
        met = met.some(on)
        pair = here._pair_of(met)
        p, k = faces.shape.shape[1:]
        shape = np.zeros((len(on), 2 * k))
        shape[:, :k] = faces.shape.reshape(-1, k)[met.points]
        x, corners = self.skin.points(u)[met.points], _placed(self.skin, u)[met.facets]
        found = gaps(x, corners, nearest(x, corners), shape, k + self.skin.local[met.facets])
        phi, push, slope = pressure(-found.value / self.depth)
        weight = faces.weight.ravel()[met.points]
        forces = (-weight * push)[:, None] * found.slope
        square = found.slope[:, :, None] * found.slope[:, None, :]
        stiffness = (weight * slope / self.depth)[:, None, None] * square
        stiffness -= (weight * push)[:, None, None] * found.curvature
        values = np.zeros((len(numbers), *stiffness.shape[1:]))
        np.add.at(values, pair, stiffness)
        energy = self.depth * float((weight * phi).sum())
        return Term(energy, summed(numbers[pair], forces, size), numbers, values)

    def near(self, u: Array) -> SelfContact:
        """Return the contact of the faces that are near each other in a state: itself, where it holds them already."""
        skin = self.skin
        met, every = _meetings(skin, u, *_in_reach(skin, u))
        at_once = (met.away < _AT_ONCE) | (met.before < 0.0)
        needed = _faces(skin, met.points[at_once], met.facets[at_once])
        if self.pairs is not None and np.all(_within(needed, self.pairs)):
            return self
        close = every.away < _MARGIN
        wider = _faces(skin, every.points[close], every.facets[close])
        kept = np.zeros((0, 2), dtype=np.int64) if self.pairs is None else self.pairs
        return replace(self, pairs=np.unique(np.concatenate([needed, wider, kept]), axis=0))

    def deepest(self, u: Array) -> float:
        """Return how deep the faces stand behind one another [thicknesses]."""
        return float(np.maximum(-self.near(u)._met(u).before, 0.0).max(initial=0.0))

    @cached_property
    def _numbers(self) -> Indices:
        """Numbers of each pair's displacements, shape (n, 2 k d)."""
        faces = self.skin.surface
        d = len(faces.axes)
        nodes = np.concatenate([faces.nodes[own] for own in self._of_pairs.T], axis=1)
        return np.asarray((d * nodes[:, :, None] + np.arange(d)).reshape(len(nodes), d * nodes.shape[1]))

    @cached_property
    def _candidates(self) -> tuple[Indices, Indices]:
        """Points and facets of the pairs that may meet."""
        p, m = self.skin.surface.shape.shape[1], self.skin.facets.shape[1]
        one, other = self._of_pairs.T
        points = (p * one[:, None, None] + np.arange(p)[:, None] + 0 * np.arange(m)).ravel()
        facets = (m * other[:, None, None] + 0 * np.arange(p)[:, None] + np.arange(m)).ravel()
        apart = self.skin.apart(points, facets)
        return points[apart], facets[apart]

    @property
    def _of_pairs(self) -> Indices:
        """The pairs; none where they are not found."""
        return np.zeros((0, 2), dtype=np.int64) if self.pairs is None else self.pairs

    def _met(self, u: Array) -> _Meeting:
        """The facet nearest to each point of the pairs."""
        return _meetings(self.skin, u, *self._candidates)[0]

    def _pair_of(self, met: _Meeting) -> Indices:
        """The pair that each meeting is one of."""
        key = np.array([len(self.skin.facets), 1])
        found = _faces(self.skin, met.points, met.facets, unique=False)
        return np.asarray(np.searchsorted(self._of_pairs @ key, found @ key))


def section_skin(mesh: MixedMesh, lines: Sequence[Indices]) -> Skin:
    """Return the faces of a section, lines through nodes from the ground on, the left one first."""
    left, right = lines
    surface = edges(mesh, [left, right[::-1]])
    return Skin(surface, np.stack([surface.nodes[:, :2], surface.nodes[:, 1:]], axis=1), mesh.nodes)


def solid_skin(basis: Basis, facets: Indices) -> Skin:
    """Return the faces of a solid, on some facets of its mesh; `basis` as of `solid_mesh`."""
    mesh, nodes = basis.mesh, basis.doflocs.T
    cells = mesh.f2t[0, facets]
    facets = facets[np.argsort(np.argmax(mesh.t2f[:, cells] == facets, axis=0), kind="stable")]  # as `facets_of` goes
    cells, triangles = mesh.f2t[0, facets], skin(basis, facets)
    corners = nodes[triangles.reshape(-1, 3)]
    out = corners.mean(axis=1) - np.repeat(mesh.p[:, mesh.t[:, cells]].mean(axis=1).T, triangles.shape[1], axis=0)
    turned = ((normals(corners) * out).sum(axis=1) < 0.0).reshape(triangles.shape[:2])
    triangles[turned] = triangles[turned][:, [1, 0, 2]]
    return Skin(facets_of(basis, facets), triangles, nodes)


def _placed(skin: Skin, u: Array) -> Array:
    """Corners of all facets, shape (f m, d, d)."""
    return np.asarray((skin.nodes + u.reshape(skin.nodes.shape))[skin.corners])


def _in_reach(skin: Skin, u: Array) -> tuple[Indices, Indices]:
    """Pairs of points and facets that may meet, at most `_DEEPEST` apart."""
    x, corners = skin.points(u), _placed(skin, u)
    centre = corners.mean(axis=1)
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    near = cKDTree(x).query_ball_point(centre, radius + _DEEPEST, return_sorted=False)
    facets, points = np.repeat(np.arange(len(near)), list(map(len, near))), np.concatenate(near).astype(np.int64)
    n = normals(corners)
    turned = (n[skin.own[points]] * n[facets]).sum(axis=1) < _ASIDE
    points, facets = points[turned], facets[turned]
    apart = skin.apart(points, facets)
    return points[apart], facets[apart]


def _meetings(skin: Skin, u: Array, points: Indices, facets: Indices) -> tuple[_Meeting, _Meeting]:
    """The facet nearest to each point of some pairs, that press or may; and all pairs that do not face one way.

    Of facets with one nearest point the one that it is most nearly before or behind says on which side it is.
    """
    corners = _placed(skin, u)
    n = normals(corners)
    facing = (n[skin.own[points]] * n[facets]).sum(axis=1)
    points, facets, facing = (each[facing < _ASIDE] for each in (points, facets, facing))
    x, own = skin.points(u)[points], corners[facets]
    away, before = behind(x, own, nearest(x, own), n[facets])
    every = _Meeting(points, facets, away, before)
    order = np.lexsort((away - 1e-7 * np.abs(before), points))
    first = order[np.flatnonzero(np.diff(points[order], prepend=-1))]
    at_rest = (skin.rest[2][skin.own[points[first]]] * skin.rest[2][facets[first]]).sum(axis=1)
    pressing = (at_rest < -_CORNER) | (at_rest > _SAME)
    first = first[pressing & (facing[first] < _OPPOSED) & (away[first] < _DEEPEST)]
    return every.some(first), every


def _faces(skin: Skin, points: Indices, facets: Indices, unique: bool = True) -> Indices:
    """Faces of points and of facets, shape (n, 2), each pair once."""
    both = np.stack([points // skin.surface.shape.shape[1], facets // skin.facets.shape[1]], axis=1)
    return np.unique(both, axis=0) if unique else both


def _within(some: Indices, pairs: Indices) -> Flags:
    """Say of some pairs whether they are among others."""
    size = 1 + max(int(some.max(initial=0)), int(pairs.max(initial=0)))
    return np.isin(some @ np.array([size, 1]), pairs @ np.array([size, 1]))
