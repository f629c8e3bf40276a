"""Yeoh's law: a cubic of the first invariant, for rubbers that soften a little and then stiffen.

    w = c10 (I1 - 3) + c20 (I1 - 3)^2 + c30 (I1 - 3)^3,    mu = 2 c10

Stable up to a strain where c20 < 0 and c30 is small. In a fit ``c30 >= 0``: the law must not fall for ever beyond the
data. Source: O. H. Yeoh, Rubber Chem. Technol. 66 (1993) 754.
"""

from __future__ import annotations

from sits_mech.silicone.laws.law import (
    Constants,
    InvariantDerivatives,
    Invariants,
    Law,
    LinearFit,
    OfInvariants,
    number,
)


def _energy(constants: Constants, at: Invariants) -> InvariantDerivatives:
    """Return energy, slope and curvature along I1."""
    c10, c20, c30 = (number(constants, name) for name in ("c10", "c20", "c30"))
    x = at.I1 - 3.0
    return InvariantDerivatives(
        w=x * (c10 + x * (c20 + x * c30)),
        w_1=c10 + x * (2.0 * c20 + x * (3.0 * c30)),
        w_11=2.0 * c20 + x * (6.0 * c30),
    )


YEOH = Law(
    name="yeoh",
    units={"c10": "Pa", "c20": "Pa", "c30": "Pa"},
    shear_modulus=lambda constants: 2.0 * number(constants, "c10"),
    energy=OfInvariants(_energy),
    stiffened=lambda c, share: ("yeoh", dict(c) | {"c20": number(c, "c20") + share * number(c, "c10")}),
    fit=LinearFit(not_negative=("c30",)),
)
