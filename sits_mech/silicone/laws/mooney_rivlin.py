"""The Mooney-Rivlin law: linear in both invariants.

    w = c10 (I1 - 3) + c01 (I2 - 3),    mu = 2 (c10 + c01)

Stable at every strain where both constants are positive. Source: M. Mooney, J. Appl. Phys. 11 (1940) 582; R. S. Rivlin,
Phil. Trans. R. Soc. A 241 (1948) 379.
"""

from __future__ import annotations

import numpy as np

from sits_mech.silicone.laws.law import Constants, InvariantDerivatives, Invariants, Law, OfInvariants, number
from sits_mech.silicone.laws.ogden import stiffer_terms


def _energy(constants: Constants, at: Invariants) -> InvariantDerivatives:
    """Return energy and its two slopes."""
    c10, c01 = number(constants, "c10"), number(constants, "c01")
    w = c10 * (at.I1 - 3.0) + c01 * (at.I2 - 3.0)
    return InvariantDerivatives(w, np.full_like(at.I1, c10), np.full_like(at.I1, c01))


MOONEY_RIVLIN = Law(
    name="mooney-rivlin",
    units={"c10": "Pa", "c01": "Pa"},
    shear_modulus=lambda constants: 2.0 * (number(constants, "c10") + number(constants, "c01")),
    energy=OfInvariants(_energy),
    # by Ogden's law, of which this one is the terms alpha = 2 and -2
    stiffened=lambda c, share: stiffer_terms(
        2.0 * np.array([number(c, "c10"), number(c, "c01")]), np.array([2.0, -2.0]), share
    ),
)
