"""The neo-Hookean law: energy of a network of Gaussian chains.

    w = mu/2 (I1 - 3),    mu > 0

Stable at every strain. Source: L. R. G. Treloar, Trans. Faraday Soc. 39 (1943) 241; R. S. Rivlin, Phil. Trans. R. Soc.
A 240 (1948) 459. Good to about 50 % of strain.
"""

from __future__ import annotations

import numpy as np

from sits_mech.silicone.laws.law import Constants, InvariantDerivatives, Invariants, Law, OfInvariants, number


def _energy(constants: Constants, at: Invariants) -> InvariantDerivatives:
    """Return energy and its one derivative."""
    half = 0.5 * number(constants, "shear_modulus")
    return InvariantDerivatives(half * (at.I1 - 3.0), np.full_like(at.I1, half))


def _stiffened(constants: Constants, share: float) -> tuple[str, Constants]:
    """Return Yeoh's law of the same modulus."""
    half = 0.5 * number(constants, "shear_modulus")
    return "yeoh", {"c10": half, "c20": share * half, "c30": 0.0}


NEO_HOOKEAN = Law(
    name="neo-hookean",
    units={"shear_modulus": "Pa"},
    shear_modulus=lambda constants: number(constants, "shear_modulus"),
    energy=OfInvariants(_energy),
    stiffened=_stiffened,
)
