"""What keeps the free faces of a pad off ground and target in three dimensions? A part of its energy, frictionless.

As in the plane (contact.py) a point at depth d behind a rigid surface costs phi(d) per reference area, and the mesh of
the error estimate gives over twice the length. With (a, b) the place in the target's frame, a along and b above its
bottom face, y unturned, lengths in thicknesses:

    ground      d = -z
    plane       d = b, on the side faces under a target that ends flush with the pad; the plane goes on beyond it
    wall        d = depth inside the target's outline, and phi(d) s(b), on the upper face beside the target

The outline is a rectangle whose corners are rounded with a small radius r, or a disc, which is one with r its own:

    d = r - |max(w, 0)| - min(max(w_1, w_2), 0),        w = (|a| - half_x + r, |y| - half_y + r).

Unknowns: nodal displacements and the target's q = (d_h, d_z, alpha); energies in shear modulus times thickness cubed.
Neglected: friction, adhesion, the target's top face (its sides go on upwards), faces that touch themselves.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from skfem import Basis
from skfem.element import Element, ElementHex1

from sits_mech.mechanics.body import Part, Term
from sits_mech.mechanics.contact import Jet, Plane, before_ground, in_frame, pressed
from sits_mech.mechanics.forms import Indices, summed
from sits_mech.meshing.bricks import Outline
from sits_mech.quantities import Array

_CORNER = 0.05  # thicknesses of radius at a rectangle's vertical corners
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(3)
_PLACED = [0, 2, 3, 4, 5]  # of (x, y, z, d_h, d_z, alpha): what a place in the plane y = 0 depends on


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
        """Numbers of each face's displacements and of q, shape (f, 3 k + 3)."""
        own = (3 * self.nodes[:, :, None] + np.arange(3)).reshape(len(self.nodes), -1)
        return np.concatenate([own, np.tile(3 * self.size + np.arange(3), (len(own), 1))], axis=1)

    @cached_property
    def entries(self) -> tuple[Indices, Indices]:
        """Rows and columns of the faces' stiffnesses."""
        count = self.numbers.shape[1]
        return np.repeat(self.numbers, count, axis=1).ravel(), np.tile(self.numbers, (1, count)).ravel()


def surface(basis: Basis, facets: Indices) -> Surface:
    """Return the Gauss points of some boundary faces of a mesh of bricks; `basis` as of `solid_mesh`."""
    nodes, cells = basis.doflocs.T, basis.mesh.f2t[0, facets]
    found = []
    for local in range(6):
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
    """Shape functions (p, n), slopes along the face (2, p, n), weights (p,) at a brick's face's Gauss points."""
    corners = ElementHex1().doflocs[element.refdom.facets[local]]
    across = int(np.argmin(np.ptp(corners, axis=0)))
    s, t = (0.5 * (each.ravel() + 1.0) for each in np.meshgrid(_POINTS, _POINTS, indexing="ij"))
    X = np.insert(np.stack([s, t]), across, corners[0, across], axis=0)
    values = [element.lbasis(X, i) for i in range(element.doflocs.shape[0])]
    shape = np.stack([np.broadcast_to(value, s.shape) for value, _ in values], axis=-1)
    slope = np.stack([np.delete(np.asarray(each), across, axis=0) for _, each in values], axis=-1)
    return shape, slope, 0.25 * np.outer(_WEIGHTS, _WEIGHTS).ravel()


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
        faces = self.surface
        f, p, k = faces.shape.shape
        place = faces.rest + faces.shape @ u[3 * faces.nodes[:, :, None] + np.arange(3)]
        energy, slope, curvature = (each.reshape(f, p, *each.shape[1:]) for each in self._of_place(place, q))
        on = np.flatnonzero(energy.any(axis=1))
        count, weight = 3 * k + 3, faces.weight[on]
        spread = np.zeros((len(on), p, 6, count))  # of the displacements and q on (x, y, z, q)
        for i in range(3):
            spread[:, :, i, i : 3 * k : 3] = faces.shape[on]
            spread[:, :, 3 + i, 3 * k + i] = 1.0
        spread = spread.reshape(len(on), 6 * p, count)
        forces = (weight[..., None] * slope[on]).reshape(len(on), 1, 6 * p) @ spread
        bent = (weight[..., None, None] * curvature[on]) @ spread.reshape(len(on), p, 6, count)
        stiffness = np.zeros((f, count, count))
        stiffness[on] = spread.transpose(0, 2, 1) @ bent.reshape(len(on), 6 * p, count)
        total = summed(faces.numbers[on], forces, len(u) + 3)
        return Term(float((weight * energy[on]).sum()), total, *faces.entries, stiffness.ravel())

    def _of_place(self, place: Array, q: Array) -> Jet:
        """Energy per area in (x, y, z, d_h, d_z, alpha) of every point."""
        points = place.reshape(-1, 3)
        if self.plane == "ground":
            return _with_y(pressed(before_ground(points[:, [0, 2]]), self.give))
        along, above = in_frame(points[:, [0, 2]], q)
        if self.plane == "plane":
            return _with_y(pressed(above, self.give))
        return pressed(_depth_inside(self.plate, points[:, 1], _with_y(along)), self.give, _with_y(above))


def contacts(surfaces: tuple[tuple[Plane, Surface], ...], give: float, plate: Outline) -> tuple[Part, ...]:
    """Return the contacts of a pad's faces; none without a length over which they give."""
    return tuple(SolidContact(own, plane, give, plate) for plane, own in surfaces if give > 0.0)


def softened(parts: tuple[Part, ...], factor: float) -> tuple[Part, ...]:
    """Return contacts that give over `factor` times their length."""
    return tuple(replace(part, give=factor * part.give) if isinstance(part, SolidContact) else part for part in parts)


def _with_y(jet: Jet) -> Jet:
    """A function of (x, z, d_h, d_z, alpha) as one of (x, y, z, d_h, d_z, alpha)."""
    m = len(jet[0])
    slope, curvature = np.zeros((m, 6)), np.zeros((m, 6, 6))
    slope[:, _PLACED] = jet[1]
    curvature[:, np.array(_PLACED)[:, None], _PLACED] = jet[2]
    return jet[0], slope, curvature


def _depth_inside(plate: Outline, y: Array, along: Jet) -> Jet:
    """Depth inside the target's outline, of places `along` it and y."""
    r = plate.half_x if plate.is_round else _CORNER
    a, slope_a, curved_a = along
    w = np.abs([a, y]) - np.array([[plate.half_x], [plate.half_y]]) + r
    corner = np.all(w >= 0.0, axis=0)
    away = np.maximum(np.hypot(*w), 1e-12)
    n = np.where(corner, w / away, [w[0] > w[1], w[0] <= w[1]]) * np.sign([a, y])
    depth = r - np.where(corner, away, w.max(axis=0))
    e_y = np.zeros_like(slope_a)
    e_y[:, 1] = 1.0
    slope = -n[0][:, None] * slope_a - n[1][:, None] * e_y
    across = n[1][:, None] * slope_a - n[0][:, None] * e_y  # along the rounded corner
    bend = np.where(corner, 1.0 / away, 0.0)
    curvature = -n[0][:, None, None] * curved_a - bend[:, None, None] * across[:, :, None] * across[:, None, :]
    return depth, slope, curvature
