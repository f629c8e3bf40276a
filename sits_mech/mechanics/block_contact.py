"""What keeps the free faces of a pad off ground and target in three dimensions? A part of its energy, frictionless.

As in the plane (contact.py) a point at depth d behind a rigid surface costs phi(d) per reference area, and the mesh of
the error estimate gives over twice the length. With y = (a, e, b) the place in the target's frame, a and e along its
bottom face from the centre and b above it, lengths in thicknesses:

    ground      d = -z
    plane       d = b, on faces under the target; the plane goes on beyond it
    wall        d = depth inside the target's outline, and phi(d) s(b), on faces beside the target

The outline is a rectangle whose corners are rounded with a small radius r, or a disc, which is one with r its own:

    d = r - |max(w, 0)| - min(max(w_1, w_2), 0),        w = (|a| - half_x + r, |e| - half_y + r).

The target stands at c and is turned by R: y = R^T r, r = x - c. With g and H the slope and curvature of the energy in
y, and h = R g, a point x, the target's centre and its turning on by a small w (from the left) are pushed with

    A^T h,    A = (1, -1, [r]),        dy = R^T A (dx, dc, w),        [r] w = r x w,

and since dh = R H dy + w x h, the stiffness in (x, c, w) is

    A^T R H R^T A  -  A^T [h] e_w^T  +  e_w [h] (1, -1, 0),         e_w = (0, 0, 1)^T,

which is not symmetric where w has three components: finite turns do not commute. Of half a pad, whose target moves by
q = (d_h, d_z, alpha), the part in c_x, c_z and w_y is taken; that one is.

Unknowns: nodal displacements and the target's place; energies in shear modulus times thickness cubed. Neglected:
friction, adhesion, the target's top face (its sides go on upwards), faces that touch themselves.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from skfem import Basis
from skfem.element import Element
from skfem.quadrature import get_quadrature

from sits_mech.geometry.turns import cross_matrix
from sits_mech.mechanics.body import Part, Term
from sits_mech.mechanics.contact import Jet, Plane, pressed
from sits_mech.mechanics.forms import Indices, entries, summed
from sits_mech.meshing.bricks import Outline
from sits_mech.quantities import Array

_CORNER = 0.05  # thicknesses of radius at a rectangle's vertical corners
_ORDER = 5  # of the polynomials that the quadrature on a face integrates
_PLACED = np.array([0, 2, 4])  # of (c, w): what the target of half a pad moves by


@dataclass(frozen=True)
class Surface:
    """Gauss points of some faces.

    Attributes
    ----------
    nodes : ndarray, shape (f, k)
        Nodes of each face.
    shape : ndarray, shape (f, p, k)
        Their shape functions at its points.
    rest : ndarray, shape (f, p, 3)
        Places at rest [thicknesses].
    weight : ndarray, shape (f, p)
        Reference areas [thicknesses squared].
    size : int
        Number of nodes of the mesh.
    """

    nodes: Indices
    shape: Array
    rest: Array
    weight: Array
    size: int

    @cached_property
    def numbers(self) -> Indices:
        """Numbers of each face's displacements and of (c, w), shape (f, 3 k + 6); the first three of these are q's."""
        own = (3 * self.nodes[:, :, None] + np.arange(3)).reshape(len(self.nodes), -1)
        return np.concatenate([own, np.tile(3 * self.size + np.arange(6), (len(own), 1))], axis=1)

    @cached_property
    def entries(self) -> tuple[Indices, Indices]:
        """Rows and columns of the faces' stiffnesses in the displacements and q."""
        return entries(self.numbers[:, :-3])


class Push(NamedTuple):
    """What presses on some faces: which, energy, forces (f, 3 k + 6), stiffnesses (f, 3 k + 6, 3 k + 6)."""

    on: Indices
    energy: float
    forces: Array
    stiffness: Array


def surface(basis: Basis, facets: Indices) -> Surface:
    """Return the Gauss points of some boundary faces of a mesh; `basis` as of `solid_mesh`, its nodes all nodal."""
    nodes, cells = basis.doflocs.T, basis.mesh.f2t[0, facets]
    found = []
    for local in range(len(basis.mesh.t2f)):
        own = cells[basis.mesh.t2f[local, cells] == facets]
        shape, slope, weight = _reference_face(basis.elem, local)
        there = np.abs(shape).max(axis=0) > 1e-9
        each = basis.element_dofs[there][:, own].T
        along = np.einsum("dpk,fki->dfpi", slope[:, :, there], nodes[each])
        area = np.linalg.norm(np.cross(along[0], along[1]), axis=-1)
        found.append((each, np.broadcast_to(shape[:, there], (len(own), *shape[:, there].shape)), area * weight))
    own_nodes, shapes, weights = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return Surface(own_nodes, shapes, shapes @ nodes[own_nodes], weights, len(nodes))


def _reference_face(element: Element, local: int) -> tuple[Array, Array, Array]:
    """Shape functions (p, n), slopes along the face (2, p, n), weights (p,) at an element's face's Gauss points."""
    corners = element.doflocs[element.refdom.facets[local]]
    way = corners[[1, -1]] - corners[0]  # a triangle's sides, or two of a parallelogram's
    points, weight = get_quadrature(element.refdom.brefdom, _ORDER)
    X = corners[0][:, None] + way.T @ points
    values = [element.lbasis(X, i) for i in range(len(element.doflocs))]
    shape = np.stack([np.broadcast_to(value, weight.shape) for value, _ in values], axis=-1)
    slope = np.stack([way @ np.asarray(each) for _, each in values], axis=-1)
    return shape, slope, weight


@dataclass(frozen=True)
class SolidContact:
    """Free faces before a rigid surface.

    Attributes
    ----------
    surface : Surface
    plane : str
        "ground", "plane" (the target's) or "wall" (the target's sides).
    give : float
        Depth over which the pressure builds up [thicknesses].
    plate : Outline
        Half the target's sizes [thicknesses].
    """

    surface: Surface
    plane: Plane
    give: float
    plate: Outline

    def __call__(self, u: Array, q: Array) -> Term:
        """Return energy, forces and stiffness of the contact at displacements `u` and target's place `q`."""
        on, energy, forces, bent = self.push(u, *placed(q))
        faces = self.surface
        numbers, nodal = faces.numbers[:, :-3], 3 * faces.nodes.shape[1]
        own = np.concatenate([np.arange(nodal), nodal + _PLACED])
        stiffness = np.zeros((len(numbers), len(own), len(own)))
        stiffness[on] = bent[:, own[:, None], own]
        return Term(energy, summed(numbers[on], forces[:, own], len(u) + 3), *faces.entries, stiffness.ravel())

    def push(self, u: Array, centre: Array, turn: Array) -> Push:
        """Return what presses on the faces, in the faces' displacements, the target's centre and its turning.

        Parameters
        ----------
        u : ndarray, shape (3 n,)
            Nodal displacements [thicknesses].
        centre, turn : ndarray, shape (3,) and (3, 3)
            How far the target's centre moved [thicknesses], and its rotation.
        """
        faces, held = self.surface, self.plane == "ground"
        place = faces.rest + faces.shape @ u[3 * faces.nodes[:, :, None] + np.arange(3)]
        r, R = (place, np.eye(3)) if held else (place - centre - (0.0, 0.0, 1.0), turn)
        f, p, k = faces.shape.shape
        energy, g, H = (each.reshape(f, p, *each.shape[1:]) for each in self._of_place((r @ R).reshape(-1, 3)))
        on = np.flatnonzero(energy.any(axis=1))
        h, bent = g[on] @ R.T, R @ H[on] @ R.T
        A = np.zeros((len(on), p, 3, 9))
        A[..., :3] = np.eye(3)
        stiffness = np.zeros((len(on), p, 9, 9))
        if not held:
            A[..., 3:6], A[..., 6:] = -np.eye(3), cross_matrix(r[on])
            twist = cross_matrix(h)
            stiffness[..., 6:] -= A.swapaxes(-1, -2) @ twist
            stiffness[..., 6:, :3] += twist
            stiffness[..., 6:, 3:6] -= twist
        stiffness += A.swapaxes(-1, -2) @ bent @ A
        spread = np.zeros((len(on), p, 9, 3 * k + 6))  # of the displacements, c and w on (x, c, w)
        for i in range(3):
            spread[:, :, i, i : 3 * k : 3] = faces.shape[on]
        spread[:, :, 3:, 3 * k :] = np.eye(6)
        weight, across = faces.weight[on], spread.reshape(len(on), 9 * p, 3 * k + 6)
        forces = (weight[..., None, None] * (h[..., None, :] @ A)).reshape(len(on), 1, 9 * p) @ across
        stiffness = (weight[..., None, None] * stiffness) @ spread
        total = across.swapaxes(1, 2) @ stiffness.reshape(len(on), 9 * p, 3 * k + 6)
        return Push(on, float((weight * energy[on]).sum()), forces[:, 0], total)

    def _of_place(self, y: Array) -> Jet:
        """Energy per area in the place, (x, y, z) before the ground and (a, e, b) before the target, of every point."""
        if self.plane == "ground":
            return pressed(_linear(-y[:, 2], (0.0, 0.0, -1.0)), self.give)
        above = _linear(y[:, 2], (0.0, 0.0, 1.0))
        if self.plane == "plane":
            return pressed(above, self.give)
        return pressed(_depth_inside(self.plate, y), self.give, above)


def placed(q: Array) -> tuple[Array, Array]:
    """Return how far the target of half a pad moved, shape (3,) [thicknesses], and its rotation, at q."""
    cos, sin = np.cos(q[2]), np.sin(q[2])
    return np.array([q[0], 0.0, q[1]]), np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])


def contacts(surfaces: tuple[tuple[Plane, Surface], ...], give: float, plate: Outline) -> tuple[Part, ...]:
    """Return the contacts of a pad's faces; none without a length over which they give."""
    return tuple(SolidContact(own, plane, give, plate) for plane, own in surfaces if give > 0.0)


def softened(parts: tuple[Part, ...], factor: float) -> tuple[Part, ...]:
    """Return contacts that give over `factor` times their length."""
    return tuple(replace(part, give=factor * part.give) if isinstance(part, SolidContact) else part for part in parts)


def _linear(value: Array, slope: tuple[float, float, float]) -> Jet:
    """A function of constant slope."""
    return value, np.tile(slope, (len(value), 1)), np.zeros((len(value), 3, 3))


def _depth_inside(plate: Outline, y: Array) -> Jet:
    """Depth inside the target's outline of places (a, e, b) in its frame."""
    r = plate.half_x if plate.is_round else _CORNER
    w = np.abs(y[:, :2]) - (plate.half_x, plate.half_y) + r
    corner = np.all(w >= 0.0, axis=1)
    away = np.maximum(np.hypot(*w.T), 1e-12)
    flat = np.stack([w[:, 0] > w[:, 1], w[:, 0] <= w[:, 1]], axis=1)
    n = np.where(corner[:, None], w / away[:, None], flat) * np.sign(y[:, :2])
    slope, curvature = np.zeros_like(y), np.zeros((len(y), 3, 3))
    slope[:, :2] = -n
    along = np.stack([-n[:, 1], n[:, 0]], axis=1)  # the rounded corner
    curvature[:, :2, :2] = -np.where(corner, 1.0 / away, 0.0)[:, None, None] * along[:, :, None] * along[:, None, :]
    return r - np.where(corner, away, w.max(axis=1)), slope, curvature
