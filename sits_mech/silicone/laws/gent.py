"""Gent's law: neo-Hookean with limited chain extensibility.

    w = -mu j_m/2 ln(1 - (I1 - 3)/j_m),    infinite from I1 = 3 + j_m on,    mu > 0, j_m > 0

Stable until it locks at that invariant. It is fitted by ``1/j_m``, which is zero where the data do not lock and below
one over the data's largest ``I1 - 3``. Source: A. N. Gent, Rubber Chem. Technol. 69 (1996) 59.
"""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Array
from sits_mech.silicone.laws.law import Constants, InvariantDerivatives, Invariants, Law, OfInvariants, TermFit, number

_FLAT = 1e-5  # a 1/j_m below this share of the largest is no locking
_LOCKED = 1.0 - 1e-6  # share of the way to locking that the data's end may have come


def _energy(constants: Constants, at: Invariants) -> InvariantDerivatives:
    """Return energy, slope and curvature along I1; beyond locking the slope is negative, so that no test passes."""
    mu, j_m = number(constants, "shear_modulus"), number(constants, "j_m")
    left = 1.0 - (at.I1 - 3.0) / j_m
    left = np.where(left == 0.0, -1.0, left)
    locked = left < 0.0
    w = np.where(locked, np.inf, -0.5 * mu * j_m * np.log(np.where(locked, 1.0, left)))
    return InvariantDerivatives(w, 0.5 * mu / left, w_11=0.5 * mu / (j_m * left**2))


def _limits(x: Array, reach: float) -> tuple[Array, Array]:
    """Return the range of 1/j_m: from hardly any locking to locking at the data's end."""
    most = np.full_like(x, _LOCKED / reach)
    return _FLAT * most, most


GENT = Law(
    name="gent",
    units={"shear_modulus": "Pa", "j_m": ""},
    shear_modulus=lambda constants: number(constants, "shear_modulus"),
    energy=OfInvariants(_energy),
    # w = mu/2 x + mu/(4 j_m) x^2 + ... of x = I1 - 3
    stiffened=lambda c, share: ("gent", dict(c) | {"j_m": 1.0 / (1.0 / number(c, "j_m") + 2.0 * share)}),
    fit=TermFit(
        constants=lambda m, x: {"shear_modulus": float(m[0]), "j_m": 1.0 / float(x[0])},
        starts=lambda reach: np.array([0.3 * _LOCKED / reach]),
        limits=_limits,
        held=lambda x, reach: x < 1e2 * _FLAT * _LOCKED / reach,
        note="the data show no locking: j_m is at the end of its range",
    ),
    refusal=lambda c: "" if number(c, "j_m") > 0.0 else f"j_m must be positive; got {c['j_m']}",
    fails="locks",
)
