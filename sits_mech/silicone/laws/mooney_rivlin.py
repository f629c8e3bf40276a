"""The Mooney-Rivlin law: linear in both invariants.

    w = c10 (I1 - 3) + c01 (I2 - 3),    mu = 2 (c10 + c01)

Stable at every strain where both constants are positive. Tension sees I2 little and takes any softening for it (c01 of
1.7 c10 by Treloar's pull), compression sees it most. So tension alone is fitted with ``0 <= c01 <= c10/2``: laws fitted
to Treloar's tests of several modes have w_2/w_1 of 0.18 (Carroll) and 0.28 (Gent-Gent) at small strain, less beyond.
Source: M. Mooney, J. Appl. Phys. 11 (1940) 582; R. S. Rivlin, Phil. Trans. R. Soc. A 241 (1948) 379; M. M. Carroll, J.
Elasticity 103 (2011) 173; R. W. Ogden, G. Saccomandi, I. Sgura, Comput. Mech. 34 (2004) 484.
"""

from __future__ import annotations

import numpy as np

from sits_mech.silicone.laws.law import (
    Constants,
    InvariantDerivatives,
    Invariants,
    Law,
    LinearFit,
    OfInvariants,
    number,
)
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
    fit=LinearFit(tension_alone=((1.0, -2.0), (0.0, 1.0))),
    # by Ogden's law, of which this one is the terms alpha = 2 and -2
    stiffened=lambda c, share: stiffer_terms(
        2.0 * np.array([number(c, "c10"), number(c, "c01")]), np.array([2.0, -2.0]), share
    ),
)
