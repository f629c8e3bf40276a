"""What keeps free faces off the rigid planes, and elements from turning inside out? Parts of the layer's energy.

**Contact**, frictionless, of the free faces with the ground, with the target's plane (of a layer that ends flush with
its target; the plane is taken to go on beyond it) or with the target's side walls (of a layer that is wider). A point
at depth d behind the plane is pressed back, per reference area, with

    p(d) = mu (d/give)**2/2    up to d = give,        mu (d/give - 1/2)    beyond,        p(d <= 0) = 0,

the derivative of an energy phi(d): forces, tangent, work and moments stay exact. True contact has no depth; the answer
is off by O(give). The mesh of the error estimate takes twice the length, so that the estimate holds it. With (a, b)
the place in the target's frame, a along its bottom face from the centre and b above it, lengths in thicknesses:

    ground      d = -z
    plane       d = b
    wall        d = half width -+ a, and phi(d) s(b): s rises smoothly from 0 at b = 0, the edge, to 1 a little above

**Guard**: kappa int (J - 1 - ln J) by Simpson's rule on the elements' nodes, a small part of the bulk modulus that acts
pointwise, corners included, and grows without bound towards inversion.

Source: P. Wriggers, Computational Contact Mechanics (2006), chapter 6. Neglected: friction, adhesion, the target's top
face (a wall goes on upwards), faces that touch themselves (folds.py finds them).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from sits_mech.mechanics.body import Term
from sits_mech.mechanics.forms import H_J, Indices, Section, deformation, entries, plane_cofactor, summed
from sits_mech.quantities import Array

Plane = Literal["ground", "plane", "wall"]
Jet = tuple[Array, Array, Array]
"""A function at m points: value (m,), slope (m, k) and curvature (m, k, k) in k variables."""

_RISE = 0.02  # thicknesses above the target's edge over which its side wall sets in
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True)
class Face:
    """Gauss points of a free face.

    Attributes
    ----------
    nodes : ndarray, shape (m, 3)
        Nodes of each point's edge.
    shape : ndarray, shape (m, 3)
        Their shape functions there.
    rest : ndarray, shape (m, 2)
        Places x, z at rest [thicknesses].
    weight : ndarray, shape (m,)
        Reference lengths [thicknesses].
    """

    nodes: Indices
    shape: Array
    rest: Array
    weight: Array


def face_along(mesh: Section, lines: list[Indices]) -> Face:
    """Return the points of a face that runs through nodes in order: every other node is the end of an edge."""
    edges = np.concatenate([np.stack([line[:-2:2], line[1:-1:2], line[2::2]], axis=1) for line in lines])
    s = 0.5 * (_POINTS + 1.0)
    shape = np.stack([(1.0 - s) * (1.0 - 2.0 * s), 4.0 * s * (1.0 - s), s * (2.0 * s - 1.0)], axis=1)
    slope = np.stack([4.0 * s - 3.0, 4.0 - 8.0 * s, 4.0 * s - 1.0], axis=1)
    length = np.linalg.norm(np.einsum("pa,eai->epi", slope, mesh.nodes[edges]), axis=2)
    rest = np.einsum("pa,eai->epi", shape, mesh.nodes[edges])
    weight = length * (0.5 * _WEIGHTS)
    return Face(np.repeat(edges, 3, axis=0), np.tile(shape, (len(edges), 1)), rest.reshape(-1, 2), weight.ravel())


@dataclass(frozen=True)
class Contact:
    """A free face before a plane.

    Attributes
    ----------
    face : Face
    plane : str
        "ground", "plane" (the target's) or "wall" (the target's sides).
    give : float
        Depth over which the pressure builds up [thicknesses].
    half : float
        Half the target's width [thicknesses].
    """

    face: Face
    plane: Plane
    give: float
    half: float

    def __call__(self, u: Array, q: Array) -> Term:
        """Return energy, forces and stiffness of the contact at displacements `u` and target's place `q`."""
        n = len(u)
        dofs = 2 * self.face.nodes[:, :, None] + np.arange(2)
        place = self.face.rest + np.einsum("ma,mai->mi", self.face.shape, u[dofs])
        energy, slope, curvature = self._of_place(place, q)
        weight, shape = self.face.weight, self.face.shape
        spread = np.zeros((len(place), 5, 9))  # on (x, z, q): 5
        spread[:, 0, 0:6:2] = spread[:, 1, 1:6:2] = shape
        spread[:, [2, 3, 4], [6, 7, 8]] = 1.0
        numbers = np.concatenate([dofs.reshape(-1, 6), np.tile(n + np.arange(3), (len(place), 1))], axis=1)
        on = (weight[:, None, None] * slope[:, None]) @ spread
        forces = summed(numbers, on, n + 3)
        stiffness = spread.transpose(0, 2, 1) @ (weight[:, None, None] * curvature) @ spread
        return Term(float(weight @ energy), forces, *entries(numbers), stiffness.ravel())

    def _of_place(self, place: Array, q: Array) -> Jet:
        """Energy per length, its slope and curvature in (x, z, d_h, d_z, alpha) of every point."""
        along, above = in_frame(place, q)
        if self.plane == "ground":
            return pressed(before_ground(place), self.give)
        if self.plane == "plane":
            return pressed(above, self.give)
        side = np.sign(self.face.rest[:, 0])
        depth = (self.half - side * along[0], -side[:, None] * along[1], -side[:, None, None] * along[2])
        return pressed(depth, self.give, above)


def _pressure(d: Array) -> tuple[Array, Array, Array]:
    """Energy, pressure and its slope at depths in units of the length over which the pressure builds up."""
    d = np.maximum(d, 0.0)
    small = d < 1.0
    energy = np.where(small, d**3 / 6.0, 0.5 * d**2 - 0.5 * d + 1.0 / 6.0)
    return energy, np.where(small, 0.5 * d**2, d - 0.5), np.where(small, d, 1.0)


def pressed(depth: Jet, give: float, above: Jet | None = None) -> Jet:
    """Return the energy per area at depths behind a plane; behind a wall, above the edge at which it sets in.

    Parameters
    ----------
    depth : Jet
        d [thicknesses], in any variables.
    give : float
        Depth over which the pressure builds up [thicknesses].
    above : Jet, optional
        b, in the same variables: phi(d) s(b) instead of phi(d).
    """
    phi, p, k = _pressure(depth[0] / give)
    phi, k = phi * give, k / give
    square = depth[1][:, :, None] * depth[1][:, None, :]
    if above is None:
        return phi, p[:, None] * depth[1], k[:, None, None] * square + p[:, None, None] * depth[2]
    r = np.clip(above[0] / _RISE, 0.0, 1.0)
    s = r**3 * (10.0 - 15.0 * r + 6.0 * r**2)
    s_b, s_bb = 30.0 * r**2 * (1.0 - r) ** 2 / _RISE, 60.0 * r * (1.0 - r) * (1.0 - 2.0 * r) / _RISE**2
    mixed = depth[1][:, :, None] * above[1][:, None, :]
    curvature = (k * s)[:, None, None] * square + (p * s)[:, None, None] * depth[2]
    curvature += (p * s_b)[:, None, None] * (mixed + mixed.transpose(0, 2, 1))
    curvature += (phi * s_bb)[:, None, None] * above[1][:, :, None] * above[1][:, None, :]
    curvature += (phi * s_b)[:, None, None] * above[2]
    return phi * s, (p * s)[:, None] * depth[1] + (phi * s_b)[:, None] * above[1], curvature


def before_ground(place: Array) -> Jet:
    """Return the depth of places (x, z) behind the ground in (x, z, d_h, d_z, alpha)."""
    m = len(place)
    return -place[:, 1], np.tile([0.0, -1.0, 0.0, 0.0, 0.0], (m, 1)), np.zeros((m, 5, 5))


def in_frame(place: Array, q: Array) -> tuple[Jet, Jet]:
    """Return the places (x, z) along and above the target's bottom face in (x, z, d_h, d_z, alpha)."""
    cos, sin = float(np.cos(q[2])), float(np.sin(q[2]))
    x, z = place[:, 0] - q[0], place[:, 1] - 1.0 - q[1]
    along, above = x * cos - z * sin, x * sin + z * cos
    one, m = np.ones(len(place)), len(place)
    slope_a = np.stack([cos * one, -sin * one, -cos * one, sin * one, -above], axis=1)
    slope_b = np.stack([sin * one, cos * one, -sin * one, -cos * one, along], axis=1)
    curved_a, curved_b = np.zeros((m, 5, 5)), np.zeros((m, 5, 5))
    curved_a[:, 4, :4] = curved_a[:, :4, 4] = [-sin, -cos, sin, cos]
    curved_b[:, 4, :4] = curved_b[:, :4, 4] = [cos, -sin, -cos, sin]
    curved_a[:, 4, 4], curved_b[:, 4, 4] = -along, -above
    return (along, slope_a, curved_a), (above, slope_b, curved_b)


@dataclass(frozen=True)
class Guard:
    """What holds J above zero at the elements' nodes.

    Attributes
    ----------
    mesh : Section
    kappa : float
        Its share of the bulk modulus [shear moduli].
    """

    mesh: Section
    kappa: float

    def __call__(self, u: Array, q: Array) -> Term:
        """Return energy, forces and stiffness of the guard; `q` plays no part."""
        mesh = self.mesh
        if mesh.node_B is None or mesh.node_weights is None:
            raise ValueError("mesh: must hold the strains at its nodes")
        e = len(mesh.cells)
        F, J = deformation(replace(mesh, B=mesh.node_B), u)
        H, B = plane_cofactor(F), mesh.node_B.reshape(e, -1, 18)
        first, second = self.kappa * mesh.node_weights * (1.0 - 1.0 / J), self.kappa * mesh.node_weights / J**2
        on = (first[..., None] * H).reshape(e, 1, -1) @ B
        forces = summed(mesh.dofs, on, len(u) + 3)
        C = H_J * first[..., None, None] + second[..., None, None] * H[..., :, None] * H[..., None, :]
        stiffness = B.transpose(0, 2, 1) @ (C @ mesh.node_B).reshape(e, -1, 18)
        energy = self.kappa * float((mesh.node_weights * (J - 1.0 - np.log(J))).sum())
        return Term(energy, forces, *entries(mesh.dofs), stiffness.ravel())
