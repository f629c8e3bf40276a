"""What does an incompressible law show where the strain is uniform: in a pull, in planar tension, in biaxial tension?

Principal stretches with ``lambda_1 lambda_2 lambda_3 = 1``; the third direction is free of stress:

    uniaxial   (lambda, lambda^-1/2, lambda^-1/2)
    planar     (lambda, 1, 1/lambda)                 also called pure shear
    biaxial    (lambda, lambda, lambda^-2)           equal in both directions

In logarithmic strains ``e_i = ln lambda_i`` the energy has the gradient g and the Hessian h,

    of I1, I2 (w_1 = dW/dI1 ...)   g_i = 2 w_1 lambda_i^2 - 2 w_2 lambda_i^-2
                                   h_ij = 4 (w_1 lambda_i^2 + w_2 lambda_i^-2) delta_ij + 4 w_11 lambda_i^2 lambda_j^2
    Ogden                          g_i = sum_p 2 mu_p/alpha_p lambda_i^alpha_p
                                   h_ij = sum_p 2 mu_p lambda_i^alpha_p delta_ij

Engineering stress ``P = (g_1 - g_3)/lambda_1``. The constraint is linear in e (their sum is zero), so that the tangent
of the incompressible law is h on the plane of increments without change of volume.

Source: R. W. Ogden, Non-linear Elastic Deformations (1984), chapter 7. The laws are those of `sits_mech.materials`.
Neglected: change of volume, rate, history.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sits_mech.quantities import Array
from sits_mech.silicone.laws import LAWS, Constants

MODES: Mapping[str, tuple[float, float, float]] = {
    "uniaxial": (1.0, -0.5, -0.5),
    "planar": (1.0, 0.0, -1.0),
    "biaxial": (1.0, 1.0, -2.0),
}
"""The exponents of the controlled stretch in each test's three principal stretches."""

PLANE = np.array([[2.0, 0.0], [-1.0, 1.0], [-1.0, -1.0]]) / np.sqrt([6.0, 2.0])
"""Two orthonormal increments of logarithmic strain that keep the volume, as columns."""


def principal_stretches(mode: str, stretch: Array) -> Array:
    """Return the three principal stretches of a test, shape (n, 3).

    Parameters
    ----------
    mode : str
        A key of `MODES`.
    stretch : ndarray, shape (n,)
        The controlled stretch, positive [-].

    Raises
    ------
    ValueError
        When the test is none of the three.
    """
    if mode not in MODES:
        raise ValueError(f'mode: must be one of {", ".join(MODES)}; got "{mode}"')
    powers: Array = np.asarray(stretch, dtype=np.float64)[:, None] ** np.array(MODES[mode])
    return powers


def state_stress(law: str, constants: Constants, stretches: Array) -> Array:
    """Return the engineering stress in the first direction, shape (n,) [Pa].

    Parameters
    ----------
    law : str
        A key of `sits_mech.materials.LAWS`.
    constants : mapping
        By the names that `LAWS` has for it [Pa; alpha and j_m: -].
    stretches : ndarray, shape (n, 3)
        Principal stretches of product one; the third direction is free of stress.

    Raises
    ------
    ValueError
        When the law is unknown.
    """
    if law == "ogden":
        mu, alpha = ogden_terms(constants)
        force = (2.0 * mu / alpha * stretches[:, :, None] ** alpha).sum(axis=2)
    else:
        w_1, w_2, _ = _invariant_slopes(law, constants, stretches)
        force = 2.0 * w_1[:, None] * stretches**2 - 2.0 * w_2[:, None] * stretches**-2.0
    stress: Array = (force[:, 0] - force[:, 2]) / stretches[:, 0]
    return stress


def engineering_stress(law: str, constants: Constants, strain: Array, mode: str = "uniaxial") -> Array:
    """Return the engineering stress of an incompressible law in a uniform test.

    Parameters
    ----------
    law : str
        A key of `sits_mech.materials.LAWS`.
    constants : mapping
        By the names that `LAWS` has for it [Pa; alpha and j_m: -].
    strain : ndarray, shape (n,)
        Engineering strain, above -1 [-].
    mode : str
        "uniaxial", "planar" or "biaxial".

    Returns
    -------
    ndarray, shape (n,)
        [Pa].

    Raises
    ------
    ValueError
        When law or mode is unknown.
    """
    return state_stress(law, constants, principal_stretches(mode, 1.0 + strain))


def tangent(law: str, constants: Constants, stretches: Array) -> Array:
    """Return the incompressible law's tangent in logarithmic strain, on increments that keep the volume.

    Parameters
    ----------
    law, constants, stretches
        As for `state_stress`.

    Returns
    -------
    ndarray, shape (n, 2, 2)
        Symmetric, of an orthonormal pair of increments; twice the shear modulus times the unit matrix at rest [Pa].

    Raises
    ------
    ValueError
        When the law is unknown.
    """
    if law == "ogden":
        mu, alpha = ogden_terms(constants)
        diagonal = (2.0 * mu * stretches[:, :, None] ** alpha).sum(axis=2)
        curvature = np.zeros(len(stretches))
    else:
        w_1, w_2, w_11 = _invariant_slopes(law, constants, stretches)
        diagonal = 4.0 * (w_1[:, None] * stretches**2 + w_2[:, None] * stretches**-2.0)
        curvature = 4.0 * w_11
    along = stretches**2 @ PLANE
    plane: Array = np.einsum("ia,ni,ib->nab", PLANE, diagonal, PLANE)
    return plane + curvature[:, None, None] * along[:, :, None] * along[:, None, :]


def ogden_terms(constants: Constants) -> tuple[Array, Array]:
    """Return mu [Pa] and alpha [-] of Ogden's law, shape (terms,) each."""
    return np.atleast_1d(constants["mu"]).astype(np.float64), np.atleast_1d(constants["alpha"]).astype(np.float64)


def _invariant_slopes(law: str, constants: Constants, stretches: Array) -> tuple[Array, Array, Array]:
    """Return dW/dI1, dW/dI2 and d2W/dI1^2; the other second derivatives are zero in these laws."""
    if law not in LAWS:
        raise ValueError(f'law: must be one of {", ".join(LAWS)}; got "{law}"')
    c = {name: float(np.sum(value)) for name, value in constants.items()}
    excess = (stretches**2).sum(axis=1) - 3.0
    one, zero = np.ones_like(excess), np.zeros_like(excess)
    if law == "neo-hookean":
        return 0.5 * c["shear_modulus"] * one, zero, zero
    if law == "mooney-rivlin":
        return c["c10"] * one, c["c01"] * one, zero
    if law == "yeoh":
        slope = c["c10"] + 2.0 * c["c20"] * excess + 3.0 * c["c30"] * excess**2
        return slope, zero, 2.0 * c["c20"] + 6.0 * c["c30"] * excess
    left = 1.0 - excess / c["j_m"]  # at locking and beyond, the law has no state: any sign but a positive one will do
    left = np.where(left == 0.0, -1.0, left)
    return 0.5 * c["shear_modulus"] / left, zero, 0.5 * c["shear_modulus"] / (c["j_m"] * left**2)
