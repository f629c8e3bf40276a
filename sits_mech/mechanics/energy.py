"""What a silicone stores: hyperelastic laws in plane strain, with their exact first and second derivatives.

Every law is split into an isochoric part and ``K/2 (J - 1)**2``; the latter belongs to the mixed element (forms.py),
the former is here. In plane strain (``F_33 = 1``) an isotropic energy depends on two numbers only,

    s = F : F = lambda_1**2 + lambda_2**2,        J = det F = lambda_1 lambda_2,

so that stress and tangent follow from five derivatives, for any law:

    P = 2 w_s F + w_J H,        H = cof F = dJ/dF
    A = 2 w_s 1 + 4 w_ss F x F + 2 w_sJ (F x H + H x F) + w_JJ H x H + w_J dH/dF.

The isochoric invariants are ``I1 = J**(-2/3) (s + 1)`` and ``I2 = J**(-4/3) s + J**(2/3)``.

    neo-Hookean     w = mu/2 (I1 - 3)
    Mooney-Rivlin   w = c10 (I1 - 3) + c01 (I2 - 3)
    Yeoh            w = sum_k c_k0 (I1 - 3)**k, k = 1..3
    Gent            w = -mu j_m/2 ln(1 - (I1 - 3)/j_m), infinite from I1 = 3 + j_m on
    Ogden           w = sum_p 2 mu_p/alpha_p**2 (sum_j lambda_j**alpha_p - 3), isochoric stretches

For Ogden, ``lambda_1**a + lambda_2**a = 2 J**(a/2) T(c)`` with ``c = s/(2 J)`` and ``T(c) = cosh(a/2 arccosh c)``, a
Chebyshev function of real order: smooth through equal stretches, where principal directions are undefined.

Energies are scaled by the initial shear modulus. Sources: G. A. Holzapfel, Nonlinear Solid Mechanics (2000), chapter 6;
O. H. Yeoh, Rubber Chem. Technol. 66 (1993) 754; A. N. Gent, Rubber Chem. Technol. 69 (1996) 59; R. W. Ogden, Proc. R.
Soc. A 326 (1972) 565. Neglected: viscosity, stress softening, temperature.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from sits_mech.quantities import Array
from sits_mech.silicone.material import Silicone


class PlaneDerivatives(NamedTuple):
    """An energy density of ``s`` and ``J`` with its derivatives, each of the arguments' shape [shear moduli]."""

    w: Array
    w_s: Array
    w_J: Array
    w_ss: Array
    w_sJ: Array
    w_JJ: Array


class InvariantDerivatives(NamedTuple):
    """An energy density of the isochoric invariants ``I1``, ``I2`` with its derivatives [shear moduli]."""

    w: Array
    w_1: Array
    w_2: Array
    w_11: Array
    w_12: Array
    w_22: Array


PlaneEnergy = Callable[[Array, Array], PlaneDerivatives]
InvariantEnergy = Callable[[Array, Array], InvariantDerivatives]


def invariant_energy(silicone: Silicone) -> InvariantEnergy:
    """Return the isochoric energy of a law that is a function of ``I1`` and ``I2`` (all but Ogden's).

    Parameters
    ----------
    silicone : Silicone
        Law and constants; the energy comes out in units of its initial shear modulus.

    Returns
    -------
    callable
        ``(I1, I2) -> InvariantDerivatives``, arrays in, arrays out.

    Raises
    ------
    ValueError
        For a law that is no function of the invariants.
    """
    constants = {key: np.asarray(value) / silicone.shear_modulus for key, value in silicone.constants.items()}
    if silicone.law == "gent":
        return _gent(1.0, float(np.asarray(silicone.constants["j_m"])))
    if silicone.law == "neo-hookean":
        return _polynomial((0.5,), 0.0)
    if silicone.law == "mooney-rivlin":
        return _polynomial((float(constants["c10"]),), float(constants["c01"]))
    if silicone.law == "yeoh":
        return _polynomial(tuple(float(constants[key]) for key in ("c10", "c20", "c30")), 0.0)
    raise ValueError(f"material law: must be neo-hookean, mooney-rivlin, yeoh, gent or ogden, not {silicone.law!r}")


def plane_energy(silicone: Silicone) -> PlaneEnergy:
    """Return the isochoric energy in plane strain as a function of ``s = F:F`` and ``J``.

    Parameters
    ----------
    silicone : Silicone
        Law and constants; the energy comes out in units of its initial shear modulus.

    Returns
    -------
    callable
        ``(s, J) -> PlaneDerivatives``, arrays in, arrays out.
    """
    if silicone.law == "ogden":
        mu = np.atleast_1d(silicone.constants["mu"]) / silicone.shear_modulus
        return _ogden(mu.tolist(), np.atleast_1d(silicone.constants["alpha"]).tolist())
    return _plane_of_invariants(invariant_energy(silicone))


def _polynomial(c: Sequence[float], c01: float) -> InvariantEnergy:
    """Sum of ``c[k-1] (I1 - 3)**k`` plus ``c01 (I2 - 3)``."""
    law = np.polynomial.Polynomial([0.0, *c])
    slope, curvature = law.deriv(1), law.deriv(2)

    def energy(I1: Array, I2: Array) -> InvariantDerivatives:
        zero, x = np.zeros_like(I1), I1 - 3.0
        return InvariantDerivatives(law(x) + c01 * (I2 - 3.0), slope(x), zero + c01, curvature(x), zero, zero)

    return energy


def _gent(mu: float, j_m: float) -> InvariantEnergy:
    """Gent's law; infinite energy from the locking stretch on."""

    def energy(I1: Array, I2: Array) -> InvariantDerivatives:
        zero = np.zeros_like(I1)
        left = 1.0 - (I1 - 3.0) / j_m
        locked = left <= 0.0
        left = np.where(locked, 1.0, left)
        w = np.where(locked, np.inf, -0.5 * mu * j_m * np.log(left))
        return InvariantDerivatives(w, 0.5 * mu / left, zero, 0.5 * mu / (j_m * left**2), zero, zero)

    return energy


def _plane_of_invariants(law: InvariantEnergy) -> PlaneEnergy:
    """Chain rule from the isochoric invariants to ``s`` and ``J``."""

    def energy(s: Array, J: Array) -> PlaneDerivatives:
        a = J ** (-2.0 / 3.0)
        b = a * a
        I1, I1_s, I1_J = a * (s + 1.0), a, -2.0 / 3.0 * a / J * (s + 1.0)
        I2, I2_s, I2_J = b * s + 1.0 / a, b, -4.0 / 3.0 * b / J * s + 2.0 / 3.0 / (a * J)
        I1_sJ, I1_JJ = -2.0 / 3.0 * a / J, 10.0 / 9.0 * a / J**2 * (s + 1.0)
        I2_sJ, I2_JJ = -4.0 / 3.0 * b / J, 28.0 / 9.0 * b / J**2 * s - 2.0 / 9.0 / (a * J**2)
        d = law(I1, I2)
        return PlaneDerivatives(
            d.w,
            d.w_1 * I1_s + d.w_2 * I2_s,
            d.w_1 * I1_J + d.w_2 * I2_J,
            d.w_11 * I1_s**2 + 2.0 * d.w_12 * I1_s * I2_s + d.w_22 * I2_s**2,
            d.w_11 * I1_s * I1_J + d.w_12 * (I1_s * I2_J + I1_J * I2_s) + d.w_22 * I2_s * I2_J
            + d.w_1 * I1_sJ + d.w_2 * I2_sJ,
            d.w_11 * I1_J**2 + 2.0 * d.w_12 * I1_J * I2_J + d.w_22 * I2_J**2 + d.w_1 * I1_JJ + d.w_2 * I2_JJ,
        )

    return energy


def _chebyshev(order: float, c: Array) -> tuple[Array, Array, Array]:
    """``T(c) = cosh(order arccosh c)`` for ``c >= 1`` with its first two derivatives; a series next to ``c = 1``."""
    n2, d = order**2, np.maximum(c - 1.0, 0.0)
    near = d < 1e-3
    theta = np.arccosh(1.0 + np.where(near, 1.0, d))
    T, T1 = np.cosh(order * theta), order * np.sinh(order * theta) / np.sinh(theta)
    T2 = (n2 * T - np.cosh(theta) * T1) / np.sinh(theta) ** 2
    terms = [1.0]
    for k in range(8):
        terms.append(terms[-1] * (n2 - k**2) / ((k + 1) * (2 * k + 1)))
    series = np.polynomial.Polynomial(terms)
    return (
        np.where(near, series(d), T),
        np.where(near, series.deriv(1)(d), T1),
        np.where(near, series.deriv(2)(d), T2),
    )


def _power(J: Array, n: float) -> tuple[Array, Array, Array]:
    """``J**n`` with its first two derivatives."""
    return J**n, n * J ** (n - 1.0), n * (n - 1.0) * J ** (n - 2.0)


def _ogden(mu: Sequence[float], alpha: Sequence[float]) -> PlaneEnergy:
    """Ogden's law through ``c = s/(2 J)``: each term is ``2 mu/alpha**2 (2 J**(alpha/6) T(c) + J**(-alpha/3) - 3)``."""

    def energy(s: Array, J: Array) -> PlaneDerivatives:
        total = [np.zeros_like(J) for _ in range(6)]
        c, c_s, c_J, c_sJ, c_JJ = s / (2.0 * J), 0.5 / J, -0.5 * s / J**2, -0.5 / J**2, s / J**3
        for m, a in zip(mu, alpha, strict=True):
            T, T1, T2 = _chebyshev(0.5 * a, c)
            g, g_J, g_JJ = _power(J, a / 6.0)
            h, h_J, h_JJ = _power(J, -a / 3.0)
            parts = (
                2.0 * g * T + h - 3.0,
                2.0 * g * T1 * c_s,
                2.0 * (g_J * T + g * T1 * c_J) + h_J,
                2.0 * g * T2 * c_s**2,
                2.0 * (g_J * T1 * c_s + g * (T2 * c_s * c_J + T1 * c_sJ)),
                2.0 * (g_JJ * T + 2.0 * g_J * T1 * c_J + g * (T2 * c_J**2 + T1 * c_JJ)) + h_JJ,
            )
            total = [t + 2.0 * m / a**2 * part for t, part in zip(total, parts, strict=True)]
        return PlaneDerivatives(*total)

    return energy
