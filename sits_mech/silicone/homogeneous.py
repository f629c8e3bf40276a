"""Uniform states of an incompressible law: uniaxial, planar and biaxial tension.

Principal stretches with ``lambda_1 lambda_2 lambda_3 = 1``; the third direction is free of stress:

    uniaxial   (lambda, lambda^-1/2, lambda^-1/2)
    planar     (lambda, 1, 1/lambda)                 also called pure shear
    biaxial    (lambda, lambda, lambda^-2)           equal in both directions

In logarithmic strains ``e_i = ln lambda_i`` the energy has the gradient g and the Hessian h,

    of invariants   g_i = w_1 a_i + w_2 b_i,      a_i = dI1/de_i = 2 lambda_i^2,  b_i = dI2/de_i = -2 lambda_i^-2
                    h_ij = 2 (w_1 a_i - w_2 b_i) delta_ij + w_11 a_i a_j + w_12 (a_i b_j + b_i a_j) + w_22 b_i b_j
    of stretches    g_i = f'(e_i),  h_ij = f''(e_i) delta_ij

Engineering stress ``P = (g_1 - g_3)/lambda_1``. The constraint is linear in e (their sum is zero), so that the tangent
of the incompressible law is h on the plane of increments without change of volume.

Source: R. W. Ogden, Non-linear Elastic Deformations (1984), chapter 7. The derivatives are the laws' own (laws/).
Neglected: change of volume, rate, history.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from sits_mech.quantities import Array
from sits_mech.silicone.laws import Constants, known_law
from sits_mech.silicone.laws.law import Invariants, OfInvariants

MODES: Mapping[str, tuple[float, float, float]] = {
    "uniaxial": (1.0, -0.5, -0.5),
    "planar": (1.0, 0.0, -1.0),
    "biaxial": (1.0, 1.0, -2.0),
}
"""Exponents of the controlled stretch in the three principal stretches of each test."""

PLANE = np.array([[2.0, 0.0], [-1.0, 1.0], [-1.0, -1.0]]) / np.sqrt([6.0, 2.0])
"""Two orthonormal increments of logarithmic strain that keep the volume, as columns."""


def principal_stretches(mode: str, stretch: Array) -> Array:
    """Return the principal stretches (n, 3) of a test at stretches (n,); raise ValueError for an unknown mode."""
    if mode not in MODES:
        raise ValueError(f'mode: must be one of {", ".join(MODES)}; got "{mode}"')
    powers: Array = np.asarray(stretch, dtype=np.float64)[:, None] ** np.array(MODES[mode])
    return powers


def state_stress(law: str, constants: Constants, stretches: Array) -> Array:
    """Return the engineering stress along the first direction, shape (n,) [Pa], the third free of stress.

    `stretches` (n, 3) have product one. Raise ValueError for an unknown law.
    """
    force, _ = _log_derivatives(law, constants, stretches)
    stress: Array = (force[:, 0] - force[:, 2]) / stretches[:, 0]
    return stress


def engineering_stress(law: str, constants: Constants, strain: Array, mode: str = "uniaxial") -> Array:
    """Return the engineering stress (n,) [Pa] at engineering strain (n,) > -1 in a test of `MODES`.

    Raise ValueError for an unknown law or mode.
    """
    return state_stress(law, constants, principal_stretches(mode, 1.0 + strain))


def shear_secant(law: str, constants: Constants, strain: float) -> float:
    """Return stress over strain in simple shear at a strain above zero, stretches (lambda, 1, 1/lambda) [Pa]."""
    stretch = 0.5 * (strain + math.hypot(strain, 2.0))
    pure = engineering_stress(law, constants, np.array([stretch - 1.0]), "planar").item()
    return pure * stretch / (strain * (stretch + 1.0 / stretch))


def energy_density(law: str, constants: Constants, stretches: Array) -> Array:
    """Return the energy density at stretches (n, 3) of product one, zero without strain, shape (n,) [Pa]."""
    energy = known_law(law).energy
    if not isinstance(energy, OfInvariants):
        return np.asarray(energy.derivatives(constants, np.log(stretches)).f.sum(axis=1))
    square = stretches**2
    return energy.derivatives(constants, Invariants(square.sum(axis=1), lambda: (1.0 / square).sum(axis=1))).w


def tangent(law: str, constants: Constants, stretches: Array) -> Array:
    """Return the tangent (n, 2, 2) [Pa] in logarithmic strain on an orthonormal pair of isochoric increments.

    Symmetric; twice the shear modulus times the unit matrix at rest.
    """
    _, curvature = _log_derivatives(law, constants, stretches)
    return PLANE.T @ curvature @ PLANE


def shear_band_stiffness(law: str, constants: Constants, stretches: Array) -> Array:
    """Return the smallest stiffness against shear bands in principal planes, (n,) [Pa]; mu at rest.

    In a principal plane (i, j) a band of normal (cos a, sin a) that shears along itself meets

        A cos^4 a + 2 B cos^2 a sin^2 a + C sin^4 a > 0    for every a  <=>  A > 0, C > 0, B + sqrt(A C) > 0,
        A = l_i^2 Q,  C = l_j^2 Q,  Q = (g_i - g_j)/(l_i^2 - l_j^2),
        2 B = h_ii + h_jj - 2 h_ij - g_i - g_j - 2 (l_j^2 Q - g_j)

    with principal stretches l. Where it fails the equations of equilibrium are not elliptic: strain localises, and no
    mesh converges. Source: M. A. Dowaikh, R. W. Ogden, IMA J. Appl. Math. 44 (1990) 261, for A, B, C.
    """
    (g, h), square = _log_derivatives(law, constants, stretches), stretches**2
    found = []
    for i, j in ((0, 1), (1, 2), (2, 0)):
        apart = square[:, i] - square[:, j]
        same = np.abs(apart) < 1e-6 * square[:, i]
        limit = 0.5 * (h[:, i, i] - h[:, i, j]) / square[:, i]
        Q = np.where(same, limit, (g[:, i] - g[:, j]) / np.where(same, 1.0, apart))
        A, C = square[:, i] * Q, square[:, j] * Q
        B = 0.5 * (h[:, i, i] + h[:, j, j] - g[:, i] + g[:, j]) - h[:, i, j] - C
        found.append(np.minimum(np.minimum(A, C), 0.5 * (B + np.sqrt(np.maximum(A * C, 0.0)))))
    return np.asarray(np.min(found, axis=0))


def _log_derivatives(law: str, constants: Constants, stretches: Array) -> tuple[Array, Array]:
    """Return gradient g, shape (n, 3), and Hessian h, shape (n, 3, 3), of the energy by the logarithmic strains."""
    energy = known_law(law).energy
    if not isinstance(energy, OfInvariants):
        d = energy.derivatives(constants, np.log(stretches))
        return d.f_1, d.f_11[..., None] * np.eye(3)
    square = stretches**2
    at = Invariants(square.sum(axis=1), lambda: (1.0 / square).sum(axis=1))
    found = energy.derivatives(constants, at)
    a, b, one = 2.0 * square, -2.0 / square, np.eye(3)
    force = found.w_1[:, None] * a
    curvature = 2.0 * force[..., None] * one
    if found.w_2 is not None:
        force = force + found.w_2[:, None] * b
        curvature -= 2.0 * (found.w_2[:, None] * b)[..., None] * one
    for w, x, y in ((found.w_11, a, a), (found.w_12, a, b), (found.w_12, b, a), (found.w_22, b, b)):
        if w is not None:
            curvature += w[:, None, None] * x[:, :, None] * y[:, None, :]
    return force, curvature
