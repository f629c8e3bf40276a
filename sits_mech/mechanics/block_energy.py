"""What a silicone stores in three dimensions: the laws of energy.py as functions of F, with exact derivatives.

An isotropic isochoric energy of the invariants ``I1 = J**(-2/3) s`` and ``I2 = J**(-4/3) r`` depends on F by

    s = F : F,        r = H : H,        J = det F,        H = cof F = dJ/dF.

With ``L(F) = dH/dF``, linear in F and symmetric, ``dr/dF = 2 L(F) H`` and ``d2r/dF2 = 2 L(F) L(F) + 2 L(H)``, so that

    P = w_s 2 F + w_r 2 L H + w_J H
    A = 2 w_s 1 + w_r (2 L L + 2 L(H)) + w_J L + sum_xy w_xy v_x x v_y,        v = (2 F, 2 L H, H)

for any such law. Ogden's is a function of the principal stretches: with ``F = U diag(lambda) V^T`` and derivatives w_i,
w_ij by the stretches, in the frame of U and V

    P_ii = w_i,    dP_ii = sum_j w_ij dF_jj,    2 dP_ij = (s + t) dF_ij + (s - t) dF_ji for i != j,
    s = (w_i - w_j)/(lambda_i - lambda_j),      t = (w_i + w_j)/(lambda_i + lambda_j).

With ``beta_i = lambda_i w_i``, s is ``((beta_i - beta_j)/(lambda_i - lambda_j) - w_j)/lambda_i``, and the quotient of
powers ``(x**a - 1)/(x - 1) = expm1(a ln x)/expm1(ln x)`` is a at equal stretches: nothing is divided by what vanishes.

Energies are scaled by the initial shear modulus; the volumetric part belongs to the mixed element (block_forms.py).
Source: G. A. Holzapfel, Nonlinear Solid Mechanics (2000), chapter 6. Neglected: viscosity, stress softening,
temperature.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from sits_mech.materials import Silicone
from sits_mech.mechanics.energy import InvariantEnergy, invariant_energy
from sits_mech.quantities import Array


class SolidDerivatives(NamedTuple):
    """An energy density of (s, r, J): value (...), slope (..., 3), curvature (..., 3, 3) [shear moduli]."""

    w: Array
    slope: Array
    curvature: Array


class SolidState(NamedTuple):
    """A deformation: F and ``H = dJ/dF``, shape (..., 9), ``L = dH/dF``, shape (..., 9, 9), and J, shape (...)."""

    F: Array
    H: Array
    L: Array
    J: Array


SolidEnergy = Callable[[SolidState], tuple[Array, Array, Array]]
"""Energy density (...), stress P (..., 9) and tangent A (..., 9, 9) of a deformation [shear moduli]."""


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
    """Return the isochoric energy of a law, with stress and tangent.

    Parameters
    ----------
    silicone : Silicone
        Law and constants; the energy comes out in units of its initial shear modulus.
    guard : float
        Part of the bulk modulus that acts pointwise, as ``guard (J - 1 - ln J)``, without bound
        towards inversion [shear moduli].

    Returns
    -------
    callable
        ``SolidState -> (w, P, A)``.
    """
    isochoric = _ogden(silicone) if silicone.law == "ogden" else _of_invariants(invariant_energy(silicone))

    def energy(state: SolidState) -> tuple[Array, Array, Array]:
        w, P, A = isochoric(state)
        J, H = state.J, state.H
        slope = guard * (1.0 - 1.0 / J)
        A += slope[..., None, None] * state.L + (guard / J**2)[..., None, None] * H[..., :, None] * H[..., None, :]
        return w + guard * (J - 1.0 - np.log(J)), P + slope[..., None] * H, A

    return energy


def stress_and_tangent(law: SolidEnergy, F: Array) -> tuple[Array, Array, Array, SolidState]:
    """Return energy density, stress P and tangent A of a law at F, and the deformation's `SolidState`.

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
    A : ndarray, shape (..., 9, 9)
    state : SolidState
    """
    H = cofactor(F)
    state = SolidState(F, H, turning(F), (F[..., :3] * H[..., :3]).sum(axis=-1))
    return *law(state), state


def _of_invariants(law: InvariantEnergy) -> SolidEnergy:
    """Chain rule from s, r and J to F."""

    def energy(state: SolidState) -> tuple[Array, Array, Array]:
        F, H, L, J = state
        d = _by_invariants(law, (F**2).sum(axis=-1), (H**2).sum(axis=-1), J)
        v = np.stack([2.0 * F, 2.0 * (L @ H[..., None])[..., 0], H], axis=-1)
        A = v @ d.curvature @ np.swapaxes(v, -1, -2)
        A += d.slope[..., 2, None, None] * L
        A[..., np.arange(9), np.arange(9)] += 2.0 * d.slope[..., 0, None]
        if np.any(d.slope[..., 1]):
            A += 2.0 * d.slope[..., 1, None, None] * (L @ L + turning(H))
        return d.w, (v @ d.slope[..., None])[..., 0], A

    return energy


def _by_invariants(law: InvariantEnergy, s: Array, r: Array, J: Array) -> SolidDerivatives:
    """Chain rule from the isochoric invariants to s, r and J."""
    a, b, zero = J ** (-2.0 / 3.0), J ** (-4.0 / 3.0), np.zeros_like(J)
    d1 = np.stack([a, zero, -2.0 / 3.0 * a * s / J], axis=-1)
    d2 = np.stack([zero, b, -4.0 / 3.0 * b * r / J], axis=-1)
    d = law(a * s, b * r)
    slope = d.w_1[..., None] * d1 + d.w_2[..., None] * d2
    mixed = d1[..., :, None] * d2[..., None, :]
    curvature = d.w_11[..., None, None] * (d1[..., :, None] * d1[..., None, :])
    curvature += d.w_12[..., None, None] * (mixed + np.swapaxes(mixed, -1, -2))
    curvature += d.w_22[..., None, None] * (d2[..., :, None] * d2[..., None, :])
    for place, part in ((0, -2.0 / 3.0 * d.w_1 * a / J), (1, -4.0 / 3.0 * d.w_2 * b / J)):
        curvature[..., place, 2] += part
        curvature[..., 2, place] += part
    curvature[..., 2, 2] += (10.0 * d.w_1 * a * s + 28.0 * d.w_2 * b * r) / (9.0 * J**2)
    return SolidDerivatives(d.w, slope, curvature)


def _ogden(silicone: Silicone) -> SolidEnergy:
    """Ogden's law in the frame of the principal directions."""
    mu = np.atleast_1d(silicone.constants["mu"]) / silicone.shear_modulus
    terms = list(zip(mu.tolist(), np.atleast_1d(silicone.constants["alpha"]).tolist(), strict=True))

    def energy(state: SolidState) -> tuple[Array, Array, Array]:
        U, stretch, V = np.linalg.svd(state.F.reshape(*state.F.shape[:-1], 3, 3))
        w, beta, slope, quotient = _ogden_terms(terms, stretch, stretch * np.cbrt(1.0 / state.J)[..., None])
        by, across = stretch[..., :, None], stretch[..., None, :]
        first = beta / stretch
        second = (slope / by - np.eye(3) * first[..., None]) / across
        s = (quotient - first[..., None, :]) / by
        t = (first[..., :, None] + first[..., None, :]) / (by + across)
        local = np.zeros((*state.J.shape, 9, 9))
        local[..., ::4, ::4] = second
        for i, j in ((0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)):
            local[..., 3 * i + j, 3 * i + j] = 0.5 * (s + t)[..., i, j]
            local[..., 3 * i + j, 3 * j + i] = 0.5 * (s - t)[..., i, j]
        turn = np.einsum("...ia,...bj->...ijab", U, V).reshape(*state.J.shape, 9, 9)
        P = (turn[..., ::4] @ first[..., None])[..., 0]
        return w, P, turn @ local @ np.swapaxes(turn, -1, -2)

    return energy


def _ogden_terms(terms: list[tuple[float, float]], stretch: Array, scaled: Array) -> tuple[Array, Array, Array, Array]:
    """w, beta, d beta_i / d ln lambda_j and (beta_i - beta_j)/(lambda_i - lambda_j); `scaled` are isochoric."""
    w, beta = np.zeros(stretch.shape[:-1]), np.zeros_like(stretch)
    slope, quotient = np.zeros((*stretch.shape, 3)), np.zeros((*stretch.shape, 3))
    ratio = np.log(stretch[..., :, None] / stretch[..., None, :])
    same = ratio == 0.0
    apart = np.where(same, 1.0, ratio)
    for m, a in terms:
        x = scaled**a
        mean = x.mean(axis=-1, keepdims=True)
        w += 6.0 * m / a**2 * (mean[..., 0] - 1.0)
        beta += 2.0 * m / a * (x - mean)
        slope += 2.0 * m * (x[..., None] * np.eye(3) - (x[..., :, None] + x[..., None, :] - mean[..., None]) / 3.0)
        power = np.where(same, a, np.expm1(a * apart) / np.expm1(apart))
        quotient += 2.0 * m / a * power * (x / stretch)[..., None, :]
    return w, beta, slope, quotient
