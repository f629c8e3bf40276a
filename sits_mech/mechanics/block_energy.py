"""What a silicone stores in three dimensions: the laws of energy.py as functions of F, with exact derivatives.

An isotropic isochoric energy of the invariants ``I1 = J**(-2/3) s`` and ``I2 = J**(-4/3) r`` depends on F by

    s = F : F,        r = H : H,        J = det F,        H = cof F = dJ/dF.

With ``L(F) = dH/dF``, linear in F and symmetric, ``dr/dF = 2 L(F) H`` and ``d2r/dF2 = 2 L(F) L(F) + 2 L(H)``, so that

    P = w_s 2 F + w_r 2 L H + w_J H
    A = 2 w_s 1 + w_r (2 L L + 2 L(H)) + w_J L + sum_xy w_xy v_x x v_y,        v = (2 F, 2 L H, H)

for any such law. Energies are scaled by the initial shear modulus; the volumetric part belongs to the mixed element
(block_forms.py). Source: G. A. Holzapfel, Nonlinear Solid Mechanics (2000), chapter 6. Neglected: viscosity, stress
softening, temperature. Ogden's law, a function of principal stretches, is not of this kind and is refused by name.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from sits_mech.materials import Silicone
from sits_mech.mechanics.energy import invariant_energy
from sits_mech.quantities import Array


class SolidDerivatives(NamedTuple):
    """An energy density of (s, r, J): value (...), slope (..., 3), curvature (..., 3, 3) [shear moduli]."""

    w: Array
    slope: Array
    curvature: Array


SolidEnergy = Callable[[Array, Array, Array], SolidDerivatives]


def _third_derivative() -> Array:
    """``d3 J / dF dF dF``, shape (9, 9, 9), components numbered ``3 i + j``."""
    epsilon: Array = np.zeros((3, 3, 3))
    for i in range(3):
        epsilon[i, (i + 1) % 3, (i + 2) % 3], epsilon[i, (i + 2) % 3, (i + 1) % 3] = 1.0, -1.0
    return np.asarray(np.einsum("abc,ijk->aibjck", epsilon, epsilon).reshape(9, 9, 9))


_THIRD = _third_derivative()


def turning(F: Array) -> Array:
    """Return ``L(F) = dH/dF``, shape (..., 9, 9), of F with components numbered ``3 i + j``, shape (..., 9)."""
    return np.asarray((F @ _THIRD.reshape(9, 81)).reshape(*F.shape, 9))


def cofactor(F: Array) -> Array:
    """Return ``H = dJ/dF`` of F, both of shape (..., 9)."""
    a, b, c = F[..., 0:3], F[..., 3:6], F[..., 6:9]
    return np.concatenate([_cross(b, c), _cross(c, a), _cross(a, b)], axis=-1)


def _cross(a: Array, b: Array) -> Array:
    """Vector product along the last axis."""
    first = a[..., [1, 2, 0]] * b[..., [2, 0, 1]]
    return np.asarray(first - a[..., [2, 0, 1]] * b[..., [1, 2, 0]])


def solid_energy(silicone: Silicone, guard: float = 0.0) -> SolidEnergy:
    """Return the isochoric energy of a law as a function of ``s``, ``r`` and ``J``.

    Parameters
    ----------
    silicone : Silicone
        Law and constants; the energy comes out in units of its initial shear modulus.
    guard : float
        Part of the bulk modulus that acts pointwise, as ``guard (J - 1 - ln J)``, see energy.py [shear moduli].

    Returns
    -------
    callable
        ``(s, r, J) -> SolidDerivatives``, arrays of one shape in.

    Raises
    ------
    ValueError
        For Ogden's law.
    """
    if silicone.law == "ogden":
        raise ValueError("material law: must be one of the invariants I1 and I2 for a 3D pad, not 'ogden'")
    law = invariant_energy(silicone)

    def energy(s: Array, r: Array, J: Array) -> SolidDerivatives:
        a, b, zero = J ** (-2.0 / 3.0), J ** (-4.0 / 3.0), np.zeros_like(J)
        d1 = np.stack([a, zero, -2.0 / 3.0 * a * s / J], axis=-1)
        d2 = np.stack([zero, b, -4.0 / 3.0 * b * r / J], axis=-1)
        d = law(a * s, b * r)
        slope = d.w_1[..., None] * d1 + d.w_2[..., None] * d2
        slope[..., 2] += guard * (1.0 - 1.0 / J)
        mixed = d1[..., :, None] * d2[..., None, :]
        curvature = d.w_11[..., None, None] * (d1[..., :, None] * d1[..., None, :])
        curvature += d.w_12[..., None, None] * (mixed + np.swapaxes(mixed, -1, -2))
        curvature += d.w_22[..., None, None] * (d2[..., :, None] * d2[..., None, :])
        for place, part in ((0, -2.0 / 3.0 * d.w_1 * a / J), (1, -4.0 / 3.0 * d.w_2 * b / J)):
            curvature[..., place, 2] += part
            curvature[..., 2, place] += part
        curvature[..., 2, 2] += (10.0 * d.w_1 * a * s + 28.0 * d.w_2 * b * r) / (9.0 * J**2) + guard / J**2
        return SolidDerivatives(d.w + guard * (J - 1.0 - np.log(J)), slope, curvature)

    return energy


def stress_and_tangent(law: SolidEnergy, F: Array) -> tuple[Array, Array, Array, Array]:
    """Return energy density, stress P and tangent A of a law at F, and ``L(F)``.

    Parameters
    ----------
    law : callable
        From `solid_energy`.
    F : ndarray, shape (..., 9)
        Deformation gradient, components numbered ``3 i + j``; ``det F > 0``.

    Returns
    -------
    w : ndarray, shape (...)
    P : ndarray, shape (..., 9)
    A, L : ndarray, shape (..., 9, 9)
    """
    H, L = cofactor(F), turning(F)
    d = law((F**2).sum(axis=-1), (H**2).sum(axis=-1), (F[..., :3] * H[..., :3]).sum(axis=-1))
    LH = (L @ H[..., None])[..., 0]
    v = np.stack([2.0 * F, 2.0 * LH, H], axis=-1)
    P = (v @ d.slope[..., None])[..., 0]
    A = v @ d.curvature @ np.swapaxes(v, -1, -2)
    A += d.slope[..., 2, None, None] * L
    A[..., np.arange(9), np.arange(9)] += 2.0 * d.slope[..., 0, None]
    if np.any(d.slope[..., 1]):
        A += 2.0 * d.slope[..., 1, None, None] * (L @ L + turning(H))
    return d.w, P, A, L
