"""Keep free faces from passing through one another, without friction: walls of slots, neighbouring pillars, folds. The
contact is a part of the pad's energy.

Strong form: of two points of the boundary that meet, y the nearest to x, the gap is g = n . (x - y) >= 0 with n the
outward normal at y, the traction t = -p n on x and p n on y with p >= 0, p g = 0. Weak form, both faces being the one
and the other in turn, so that neither is preferred:

    int phi(-g) dA  over all free faces,        g(x) from the nearest place of the other quadratic face (curved.py),

phi that of contact.py, regularised over the depth h and with exact forces, tangent and work; the tangent is symmetric.
A pair of faces is pressed from both sides, so that half a depth holds what contact with a plane holds at one. What a
point presses on the other face is a load on all of its nodes, so that an even pressure stays one where meshes do not
match, but for its 5 Gauss points along an edge: up to 7 % of the loads of single nodes. Measured on two confined
blocks, K = 50 shear moduli, pressed by 0.7 of one, against uniaxial strain: matching meshes 1e-9, others of 2 and 3
cells 0.16 %, of 4 and 5 cells 0.025 % too soft (flat facets in the place of the faces: 40 and 20 %). Error of the depth
itself: face_contact.py.

Which faces a point may meet: skin.py. Walls of a slot and its roof press each other, and so does one face that has
folded over; two flanks of a bulge, which stand behind each other with silicone between, are distinguished from a fold
by their distance, `_THINNEST` of that at rest. Behind a face counts what is behind the nearest one, and no deeper than
`_DEEPEST`. Which faces are near each other changes as the pad moves, and the stiffness with it: `near` finds them in a
state, with a margin, and the part holds these and no others.

Unknowns: nodal displacements; energies in shear modulus times thickness to the power of the dimension. Neglected:
friction, folds sharper than two elements. Source: P. Wriggers, Computational Contact Mechanics (2006), chapters 6, 9.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from sits_mech.mechanics.element.assembly import Term
from sits_mech.mechanics.element.kernel import summed
from sits_mech.mechanics.faces.contact import pressure
from sits_mech.mechanics.faces.curved import Jet, Nearest, before, gaps, nearest_on, shapes
from sits_mech.mechanics.faces.facets import behind, nearest, normals
from sits_mech.mechanics.faces.skin import SAME, Skin
from sits_mech.quantities import Array, Integers, Mask

_MARGIN = 0.1  # thicknesses between faces that are looked at
_AT_ONCE = 0.02  # thicknesses between faces that must be looked at
_DEEPEST = 0.3  # thicknesses behind a facet that a point may have come
_ASIDE = 0.3  # cosine between normals of faces that are looked at; those of faces that press are opposed
_SLACK = 0.1  # of a facet's size, by which a curved face may be nearer than another whose facets are
_THINNEST = 0.1  # of their distance at rest, how near points of one face come through the silicone of a bulge
_OPPOSED = -0.1  # cosine between normals of faces that press


class _Meeting(NamedTuple):
    """Points with the facet nearest to each."""

    points: Integers
    facets: Integers
    away: Array  # distance
    before: Array  # height along the facet's normal

    def some(self, which: Integers) -> _Meeting:
        """Return some of them."""
        return _Meeting(self.points[which], self.facets[which], self.away[which], self.before[which])


class _Met(NamedTuple):
    """Points with the curved face nearest to each."""

    points: Integers
    faces: Integers
    near: Nearest  # nearest places
    jet: Jet  # shape functions there
    before: Array  # height along the normal

    def some(self, which: Integers) -> _Met:
        """Return some of them."""
        jet = Jet(*(each[which] for each in self.jet))
        return _Met(self.points[which], self.faces[which], self.near.some(which), jet, self.before[which])


@dataclass(frozen=True, eq=False)
class SelfContact:
    """Contact of free faces with each other."""

    skin: Skin
    depth: float  # over which the pressure builds up [thicknesses]
    pairs: Integers | None = None  # (n, 2), held faces, the points' first; None: those near in each state

    def __call__(self, u: Array, q: Array) -> Term:
        """Return energy, forces and stiffness of the contact at displacements `u`; `q` plays no part."""
        here = self if self.pairs is not None else self.near(u)
        faces, size, numbers = self.skin.surface, len(u) + 6, here._numbers
        met = _curved(self.skin, u, *here._candidates)
        met = met.some(np.flatnonzero(met.before < 0.0))
        p, k = faces.shape.shape[1:]
        nodes = _nodes(self.skin, u)[faces.nodes[met.faces]]
        found = gaps(self.skin.points(u)[met.points], met.jet, met.near, nodes, faces.shape.reshape(-1, k)[met.points])
        phi, push, slope = pressure(-found.value / self.depth)
        weight = faces.weight.ravel()[met.points]
        forces = (-weight * push)[:, None] * found.slope
        square = found.slope[:, :, None] * found.slope[:, None, :]
        stiffness = (weight * slope / self.depth)[:, None, None] * square
        stiffness -= (weight * push)[:, None, None] * found.curvature
        values = np.zeros((len(numbers), *stiffness.shape[1:]))
        key = np.array([len(self.skin.facets), 1])
        pair = np.searchsorted(here._of_pairs @ key, np.stack([met.points // p, met.faces], axis=1) @ key)
        np.add.at(values, pair, stiffness)
        energy = self.depth * float((weight * phi).sum())
        return Term(energy, summed(numbers[pair], forces, size), numbers, values)

    def near(self, u: Array) -> SelfContact:
        """Return the contact of the faces near each other in a state; itself if it holds these already."""
        skin, every = self.skin, _meetings(self.skin, u, *_in_reach(self.skin, u))
        behind_ = _curved(skin, u, every.points, every.facets)
        behind_ = behind_.some(np.flatnonzero(behind_.before < 0.0))
        at_once = every.away < _AT_ONCE
        needed = _faces(skin, every.points[at_once], every.facets[at_once])
        met = np.stack([behind_.points // skin.surface.shape.shape[1], behind_.faces], axis=1)
        needed = np.unique(np.concatenate([needed, met]), axis=0)
        key = np.array([len(skin.facets), 1])
        if self.pairs is not None and np.isin(needed @ key, self.pairs @ key).all():
            return self
        close = every.away < _MARGIN
        wider = _faces(skin, every.points[close], every.facets[close])
        return replace(self, pairs=np.unique(np.concatenate([needed, wider, self._of_pairs]), axis=0))

    @cached_property
    def _numbers(self) -> Integers:
        """Return the numbers of each pair's displacements, shape (n, 2 k d)."""
        faces = self.skin.surface
        d = len(faces.axes)
        nodes = np.concatenate([faces.nodes[own] for own in self._of_pairs.T], axis=1)
        return (d * nodes[:, :, None] + np.arange(d)).reshape(len(nodes), d * nodes.shape[1])

    @cached_property
    def _candidates(self) -> tuple[Integers, Integers]:
        """Return the points and facets of pairs that may meet."""
        p, m = self.skin.surface.shape.shape[1], self.skin.facets.shape[1]
        one, other = self._of_pairs.T
        points = (p * one[:, None, None] + np.arange(p)[:, None] + 0 * np.arange(m)).ravel()
        facets = (m * other[:, None, None] + 0 * np.arange(p)[:, None] + np.arange(m)).ravel()
        apart = self.skin.apart(points, facets)
        return points[apart], facets[apart]

    @property
    def _of_pairs(self) -> Integers:
        """Return the pairs, none if they are found in each state."""
        return np.zeros((0, 2), dtype=np.int64) if self.pairs is None else self.pairs


def _nodes(skin: Skin, u: Array) -> Array:
    """Return the deformed nodes, shape (n, d)."""
    return skin.nodes + u.reshape(skin.nodes.shape)


def _placed(skin: Skin, u: Array) -> Array:
    """Return the corners of all facets, shape (f m, d, d)."""
    return _nodes(skin, u)[skin.corners]


def _in_reach(skin: Skin, u: Array) -> tuple[Integers, Integers]:
    """Return pairs of points and facets that may meet, at most `_DEEPEST` apart."""
    x, corners = skin.points(u), _placed(skin, u)
    centre = corners.mean(axis=1)
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    near = cKDTree(x).query_ball_point(centre, radius + _DEEPEST, return_sorted=False)
    facets, points = np.repeat(np.arange(len(near)), list(map(len, near))), np.concatenate(near).astype(np.int64)
    points, facets = _turned(skin, normals(corners), points, facets)
    apart = skin.apart(points, facets)
    return points[apart], facets[apart]


def _turned(skin: Skin, n: Array, points: Integers, facets: Integers) -> tuple[Integers, Integers]:
    """Return the pairs whose normals, n of all facets, do not point the same way."""
    turned = (n[skin.own[points]] * n[facets]).sum(axis=1) < _ASIDE
    return points[turned], facets[turned]


def _meetings(skin: Skin, u: Array, points: Integers, facets: Integers) -> _Meeting:
    """Return the pairs whose normals do not point the same way."""
    corners = _placed(skin, u)
    n = normals(corners)
    points, facets = _turned(skin, n, points, facets)
    x, own = skin.points(u)[points], corners[facets]
    away, front = behind(x, own, nearest(x, own), n[facets])
    return _Meeting(points, facets, away, front)


def _pressing(skin: Skin, u: Array, met: _Meeting) -> Mask:
    """Whether points and facets may press: they are opposed, without silicone between."""
    own = skin.own[met.points]
    n, (x, y, at_rest) = normals(_placed(skin, u)), skin.rest
    opposed = (n[own] * n[met.facets]).sum(axis=1) < _OPPOSED
    folded = (at_rest[own] * at_rest[met.facets]).sum(axis=1) > SAME
    thin = met.away < _THINNEST * np.linalg.norm(x[met.points] - y[met.facets], axis=1)
    return np.asarray(opposed & (thin | ~folded))


def _curved(skin: Skin, u: Array, points: Integers, facets: Integers) -> _Met:
    """Return the face nearest to each point of pairs that may press.

    Of faces with the same nearest point the one that the point is most nearly before or behind decides the side.
    """
    flat, m = _meetings(skin, u, points, facets), skin.facets.shape[1]
    flat = flat.some(np.lexsort((flat.away, flat.facets // m, flat.points)))
    first = (np.diff(flat.points, prepend=-1) != 0) | (np.diff(flat.facets // m, prepend=-1) != 0)
    flat = flat.some(np.flatnonzero(first))
    corners = _placed(skin, u)[flat.facets]
    size = _SLACK * np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)
    least, lowest = np.full((2, len(skin.own)), np.inf)
    np.minimum.at(least, flat.points, flat.away)
    np.minimum.at(lowest, flat.points, flat.before - size)
    close = (flat.away < least[flat.points] + size) & (flat.away < _DEEPEST) & (lowest[flat.points] < 0.0)
    flat = flat.some(np.flatnonzero(close))
    corners, faces, x = _placed(skin, u)[flat.facets], flat.facets // m, skin.points(u)[flat.points]
    start = (nearest(x, corners)[:, None] @ skin.places[flat.facets])[:, 0]
    form, nodes = skin.form[faces], _nodes(skin, u)[skin.surface.nodes[faces]]
    near = nearest_on(x, form, nodes, start, skin.sides)
    jet = shapes(form, near.place)
    away, front, _ = before(x, jet, nodes)
    order = np.lexsort((away - 1e-7 * np.abs(front), flat.points))
    order = order[np.flatnonzero(np.diff(flat.points[order], prepend=-1))]
    order = order[_pressing(skin, u, flat.some(order))]
    return _Met(flat.points, faces, near, jet, front).some(order)


def _faces(skin: Skin, points: Integers, facets: Integers) -> Integers:
    """Return the faces of points and of facets, shape (n, 2), each pair once."""
    both = np.stack([points // skin.surface.shape.shape[1], facets // skin.facets.shape[1]], axis=1)
    return np.unique(both, axis=0)
