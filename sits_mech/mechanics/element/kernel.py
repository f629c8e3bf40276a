"""Energy, forces and tangent of a deformed layer: mixed elements with a condensed pressure, plane or solid.

Strong form    div P = 0 in the layer, P = dW/dF; u = 0 on the ground; u rigid on the target; P n = 0 on the free faces.
Weak form      minimise  E(u) = int w(F) + K/2 (pi(J - J_0))**2,      F = 1 + grad u, J = det F,

with `pi` the projection onto the elements' pressure polynomials (mesh.py): ``p = K pi(J - J_0)``. The pressure is
eliminated element by element, so that the discrete problem is a minimum and its tangent symmetric:

    dE       = int (P_iso + p H) : dF,                                 H = dJ/dF
    d dE     = int dF : (A_iso + p dH/dF) : dF + K int pi(H : dF) pi(H : dF).

J_0 is the volume that the silicone would fill if nothing held it, over the one that it is meshed in: 1, or the cube of
`elastomer.free_stretch`, where ``K/2 (J/J_0 - 1)**2`` makes K that of the silicone over J_0**2.

A pad of layers has w, K and J_0 by cell, each of one silicone i: ``w = mu_i/mu w_i``, w_i in its own shear moduli; its
layers are bonded, as u is continuous, and no cell lies in two of them (pad/shapes.py).

Plane strain is the same with ``F_yy = 1``: F has four components then, nine in space (silicone/kinematics.py). With the
gradients g of the shape functions, ``dF_ij = sum_a g_ja du_ia``, everything is a product of stresses and gradients.

About an axis u = (u_r, u_z) and F is one of space that has five components, the hoop among them,

    F_rr = 1 + u_r,r     F_rz = u_r,z     F_zr = u_z,r     F_zz = 1 + u_z,z     F_tt = 1 + u_r/r,     dV = 2 pi r dr dz:

the mesh of a half meridian has N_a/r as the gradients along t, between those along r and z, for u_r alone.

Unknowns: nodal displacements in thicknesses; energies in shear modulus mu, of layers that in series, times thickness to
the power of the dimension; K in shear moduli. Source: D. Boffi, F. Brezzi, M. Fortin, Mixed Finite Element Methods and
Applications (2013), section 8.6. Neglected: inertia, gravity.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.element.mesh import MixedMesh, Points
from sits_mech.quantities import Array, Integers, Mask
from sits_mech.silicone.energy import Energy, Stress, isochoric_energy, isochoric_stress
from sits_mech.silicone.kinematics import POINTS, Kinematics, in_plane, in_space
from sits_mech.silicone.material import Silicone
from sits_mech.silicone.points import TimeStep

_AMONG_NINE, _AMONG_SIX = [0, 4, 2, 6, 8], [0, 1, 2, 3, 5]
"""F_rr, F_tt, F_rz, F_zr, F_zz among the components in space, and among those of u_r, u_z by r, t, z."""


class CellLaw(NamedTuple):
    """A silicone's isochoric energy [its shear moduli], and what else its elements have."""

    tangent: Energy
    stress: Stress
    silicone: Silicone
    K: float  # bulk modulus over swelling squared, without the guard [its shear moduli]
    modulus: float = 1.0  # its shear modulus over that of the pad
    swelling: float = 1.0  # volume of the unconstrained silicone over that of the mesh
    guard: float = 0.0  # [its shear moduli]
    past: TimeStep | None = None  # of its points, if any

    def after(self, past: TimeStep) -> CellLaw:
        """Return the law of points with a past, one at each quadrature point (silicone/points.py)."""
        own = self.silicone, self.guard, past
        return self._replace(tangent=isochoric_energy(*own), stress=isochoric_stress(*own), past=past)

    def part(self, some: slice | Mask) -> CellLaw:
        """Return the law of some of its elements."""
        return self if self.past is None else self.after(self.past.of_elements(some))


def law_of(
    silicone: Silicone, guard: float = 0.0, modulus: float | None = None, swelling: float = 1.0, *,
    share: float = 1.0, apart: float = 0.0,
) -> CellLaw:
    """Return the law of a silicone with a guard on J [its shear moduli], at most a share of K.

    `modulus`: shear modulus of the pad [Pa], its own by default; `apart`: part of K that acts elsewhere [of the pad's].
    """
    mu = silicone.shear_modulus
    ratio, K = mu / (modulus or mu), silicone.bulk_modulus / mu / swelling**2
    guard = min(guard, share * K)
    own = isochoric_energy(silicone, guard), isochoric_stress(silicone, guard)
    return CellLaw(*own, silicone, K - guard - apart / ratio, ratio, swelling, guard)


@dataclass(frozen=True, eq=False)
class Laws:
    """The laws of a mesh's elements: of one silicone, or of the layers that the elements lie in."""

    each: tuple[CellLaw, ...]
    of: Integers | None = None  # (e,), number of each element's law; None where there is one

    @cached_property
    def K(self) -> Array:
        """Bulk modulus of each element, or of all, (e, 1) or (1, 1) [shear moduli]."""
        return self._by_element([law.modulus * law.K for law in self.each])

    @cached_property
    def swelling(self) -> Array:
        """J_0 alike."""
        return self._by_element([law.swelling for law in self.each])

    @property
    def guarded(self) -> bool:
        """Whether a guard acts in a law."""
        return any(law.guard > 0.0 for law in self.each)

    @property
    def swell(self) -> bool:
        """Whether a silicone would fill another volume if nothing held it."""
        return any(law.swelling != 1.0 for law in self.each)

    def swollen(self, part: float) -> Laws:
        """Return the laws with a part of their swelling."""
        return replace(self, each=tuple(law._replace(swelling=1.0 + part * (law.swelling - 1.0)) for law in self.each))

    def _by_element(self, values: Sequence[float]) -> Array:
        """Return values of the laws by element."""
        found = np.array(values)[:, None]
        return found if self.of is None else found[self.of]

    def elements(self, number: int) -> slice | Integers:
        """Return the elements of a law."""
        return slice(None) if self.of is None else np.flatnonzero(self.of == number)

    def part(self, some: slice | Mask) -> Laws:
        """Return the laws of some of the elements."""
        if self.of is None:
            return Laws(tuple(law.part(some) for law in self.each))
        taken = np.zeros(len(self.of), dtype=bool)
        taken[some] = True
        return Laws(tuple(law.part(taken[self.of == k]) for k, law in enumerate(self.each)), self.of[some])

    def after(self, pasts: Sequence[TimeStep]) -> Laws:
        """Return the laws of elements whose points have a past, one for each law."""
        return replace(self, each=tuple(law.after(past) for law, past in zip(self.each, pasts, strict=True)))

    def stress(self, state: Kinematics) -> tuple[Array, Array]:
        """Return energy density and stress of all elements [shear moduli]."""
        w, P = self._joined(state, lambda law, own: law.stress(own))
        return w, P

    def tangent(self, state: Kinematics) -> Array:
        """Return the tangents of all elements [shear moduli]."""
        (A,) = self._joined(state, lambda law, own: law.tangent(own)[2:])
        return A

    def _joined(self, state: Kinematics, found: Callable[[CellLaw, Kinematics], Sequence[Array]]) -> Sequence[Array]:
        """Return what each law finds for its elements, in moduli of the pad."""
        if self.of is None:
            return found(self.each[0], state)
        here = [(law, own) for k, law in enumerate(self.each) if len(own := np.flatnonzero(self.of == k))]
        several = [
            [law.modulus * each for each in found(law, Kinematics(state.F[own], state.H[own], state.J[own]))]
            for law, own in here
        ]
        order = np.argsort(np.concatenate([own for _, own in here]))
        return [np.concatenate(each)[order] for each in zip(*several, strict=True)]


class Deformed(NamedTuple):
    """Nodal displacements with the deformation at the quadrature points."""

    u: Array  # (d n,) [thicknesses]
    F: Array  # (e, q, c), c = 4 components in plane strain, 9 in space and about an axis
    J: Array  # (e, q)


class Forces(NamedTuple):
    """Energy and forces of a deformed layer."""

    energy: float
    forces: Array  # on the nodes, (d n,)
    pressure: Array  # (e, m)
    min_J: float  # smallest J


def deformation(mesh: MixedMesh, u: Array, at: Points | None = None) -> tuple[Array, Array]:
    """Return F, row by row (e, q, c), and J (e, q) of nodal displacements, at the quadrature points by default."""
    F = gradients(mesh, u, at)
    F = F + _one(F)
    if F.shape[-1] == 4:
        return F, F[..., 0] * F[..., 3] - F[..., 1] * F[..., 2]
    a, b, c, d, e, f, g, h, i = np.moveaxis(F, -1, 0)
    return F, np.asarray(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g))


def deformed(mesh: MixedMesh, u: Array) -> Deformed:
    """Return nodal displacements with the deformation at the quadrature points."""
    return Deformed(u, *deformation(mesh, u))


def gradients(mesh: MixedMesh, u: Array, at: Points | None = None) -> Array:
    """Return the gradients of nodal displacements, shape (e, q, c)."""
    (e, q, j, k), d = (slope := (at or mesh.inside).slope).shape, mesh.nodes.shape[1]
    each = u[mesh.dofs].reshape(e, d, k).swapaxes(1, 2)
    found = (slope.reshape(e, q * j, k) @ each).reshape(e, q, j, d).swapaxes(2, 3).reshape(e, q, d * j)
    if not mesh.hoop:
        return found
    every = np.zeros((e, q, 9))
    every[..., _AMONG_NINE] = found[..., _AMONG_SIX]
    return every


def taken(mesh: MixedMesh, P: Array) -> Array:
    """Return stresses (..., c), or columns of tangents, by displacements' components and directions, (..., d j)."""
    if not mesh.hoop:
        return P
    found = np.zeros((*P.shape[:-1], 6))
    found[..., _AMONG_SIX] = P[..., _AMONG_NINE]
    return found


def taken_tangents(mesh: MixedMesh, A: Array) -> Array:
    """Return tangents (..., c, c) alike."""
    return taken(mesh, taken(mesh, A).swapaxes(-1, -2)) if mesh.hoop else A


def kinematics(F: Array) -> Kinematics:
    """Return the kinematics of F, shape (..., 4) in plane strain or (..., 9)."""
    return in_plane(F) if F.shape[-1] == 4 else in_space(F)


def element_forces(mesh: MixedMesh, laws: Laws, u: Array, known: Deformed | None = None) -> Forces:
    """Return energy, forces and pressures at nodal displacements (d n,); `known` is their deformation if available."""
    _, F, J = known or deformed(mesh, u)
    if not J.min() > 0.0:
        return Forces(np.inf, np.full(len(u), np.nan), np.full(mesh.chi.shape[:2], np.nan), float(J.min()))
    state = kinematics(F)
    w, P = laws.stress(state)
    p = laws.K * volumes(mesh, J - laws.swelling)
    P = mesh.inside.weights[..., None] * P + (p[:, None] @ mesh.chi)[:, 0, :, None] * state.H
    forces = summed(mesh.dofs, _along(mesh, P), mesh.nodes.size)
    energy = float((mesh.inside.weights * w).sum() + 0.5 * (p**2 / laws.K).sum())
    return Forces(energy, forces, p, float(J.min()))


def small_strain_forces(mesh: MixedMesh, laws: Laws, u: Array) -> Array:
    """Return the forces (d n,) of small displacements by the laws' tangents at rest."""
    strains = gradients(mesh, u)
    one = _one(strains)
    A = laws.tangent(kinematics(np.tile(one, (len(laws.K), 1, 1))))[:, 0]
    p = laws.K * volumes(mesh, strains @ one + 1.0 - laws.swelling)
    P = mesh.inside.weights[..., None] * (strains @ A.swapaxes(1, 2)) + (p[:, None] @ mesh.chi)[:, 0, :, None] * one
    return summed(mesh.dofs, _along(mesh, P), mesh.nodes.size)


def element_stiffness(mesh: MixedMesh, laws: Laws, u: Array, pressure: Array, known: Deformed | None = None) -> Array:
    """Return element stiffnesses (e, d k, d k), with pressures (e, m) in the geometric stiffness."""
    (_, F, _), (e, q, _, _), n = known or deformed(mesh, u), mesh.inside.slope.shape, mesh.dofs.shape[1]
    stiffness, count = np.empty((e, n, n)), max(1, POINTS * 81 // (q * F.shape[-1] ** 2))
    for start in range(0, e, count):
        some = slice(start, start + count)
        _write_stiffness(stiffness[some], mesh.part(some), laws.part(some), (F[some], pressure[some]))
    return stiffness


def most_stretched(mesh: MixedMesh, u: Array) -> Array:
    """Return the largest principal stretch or reciprocal at the quadrature points, (e, q)."""
    F, J = deformation(mesh, u)
    if F.shape[-1] == 4:
        half = 0.5 * (F**2).sum(axis=-1)
        greater = np.sqrt(half + np.sqrt(np.maximum(half**2 - J**2, 0.0)))
        smaller = J / greater
    else:
        F = F.reshape(*J.shape, 3, 3)
        smaller, _, greater = np.moveaxis(np.sqrt(np.linalg.eigvalsh(F.swapaxes(-1, -2) @ F)), -1, 0)
    return np.asarray(np.maximum(greater, 1.0 / smaller))


def volumes(mesh: MixedMesh, values: Array) -> Array:
    """Return the coefficients of ``pi`` of values at the quadrature points, (e, q) -> (e, m)."""
    return (mesh.chi @ values[..., None])[..., 0]


def summed(places: Integers, values: Array, size: int) -> Array:
    """Sum values into their places, shape (size,); both arrays in one order."""
    return np.asarray(np.bincount(places.ravel(), values.ravel(), size), dtype=np.float64)


def _one(F: Array) -> Array:
    """Return the components of 1 as F has them."""
    return np.eye(2 if F.shape[-1] == 4 else 3).ravel()


def _along(mesh: MixedMesh, P: Array) -> Array:
    """Return ``int P : dF`` by element displacements, (e, d k), of stresses times weights, (e, q, c)."""
    (e, q, j, k), d = mesh.inside.slope.shape, mesh.nodes.shape[1]
    rows = taken(mesh, P).reshape(e, q, d, j).swapaxes(1, 2).reshape(e, d, q * j)
    return (rows @ mesh.inside.slope.reshape(e, q * j, k)).reshape(e, d * k)


def _write_stiffness(stiffness: Array, mesh: MixedMesh, laws: Laws, at: tuple[Array, Array]) -> None:
    """Write element stiffnesses at F and pressures, block by block: components i and j >= i, mirrored."""
    (e, q, j, k), slope, state = mesh.inside.slope.shape, mesh.inside.slope, kinematics(at[0])
    d = mesh.nodes.shape[1]
    A = laws.tangent(state)
    A *= mesh.inside.weights[..., None, None]
    state.add_L(A, (at[1][:, None] @ mesh.chi)[:, 0])
    A = taken_tangents(mesh, A)
    b = mesh.chi @ (taken(mesh, state.H).reshape(e, q, d, j) @ slope).reshape(e, q, d * k)  # pi(H : dF) by du
    left, volume, by_pressure = slope.reshape(e, q * j, k).swapaxes(1, 2), b.swapaxes(1, 2), laws.K[..., None] * b
    for i in range(d):
        own, after = slice(i * k, (i + 1) * k), slice((i + 1) * k, None)
        stress = A[:, :, j * i : j * i + j, j * i :].reshape(e, q, -1, j) @ slope  # component i of P by later ones
        blocks = left @ stress.reshape(e, q * j, -1)
        blocks += volume[:, own] @ by_pressure[:, :, i * k :]
        stiffness[:, own, i * k :] = blocks
        stiffness[:, after, own] = blocks[:, :, k:].swapaxes(1, 2)
