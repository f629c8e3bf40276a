"""Ogden's law: a sum of powers of the principal stretches.

    w = sum_p 2 mu_p/alpha_p^2 (sum_i lambda_i^alpha_p - 3),    mu = sum_p mu_p,    isochoric stretches

so that ``f = 2 mu/alpha^2 (exp(alpha e) - 1)`` a term. The quotient of powers ``(x^a - 1)/(x - 1)`` is
``expm1(a ln x)/expm1(ln x)``, which is a at equal stretches: nothing is divided by what vanishes.

Stable at every strain where all ``mu_p > 0`` (in the notation ``w = sum mu_p/alpha_p ...`` that is ``mu_p alpha_p >
0``). It is fitted with ``mu_p > 0`` and ``alpha_p >= 1`` or ``alpha_p <= -2``, so that the engineering stress of a pull
rises at every strain. Tension hardly sees terms of negative exponents and compression sees them most, so tension alone
is fitted without them: they are 2 % of the modulus in the terms that Ogden gives for Treloar's tests of three modes.
Source: R. W. Ogden, Proc. R. Soc. A 326 (1972) 565.
"""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Array, Mask
from sits_mech.silicone.laws.law import Constants, Law, OfStretches, StretchDerivatives, TermFit

_EXPONENTS = (-16.0, -10.0, -6.5, -4.0, -2.5, 1.2, 1.8, 2.6, 4.0, 6.5, 10.0, 16.0)  # where a search for alpha starts
_REACH = 30.0  # largest size of a fitted exponent


def _terms(constants: Constants) -> list[tuple[float, float]]:
    """Return mu and alpha of each term."""
    mu, alpha = (np.atleast_1d(constants[name]).tolist() for name in ("mu", "alpha"))
    return list(zip(mu, alpha, strict=True))


def _energy(constants: Constants, e: Array) -> StretchDerivatives:
    """Sum the energies of the terms."""
    f, f_1, f_11, quotient = (np.zeros_like(e) for _ in range(4))
    first, second = e[..., [1, 2, 0]], e[..., [2, 0, 1]]
    ratio = first - second
    same = ratio == 0.0
    apart = np.where(same, 1.0, ratio)
    grown = np.expm1(apart)
    for mu, alpha in _terms(constants):
        x = np.exp(alpha * e)
        f += 2.0 * mu / alpha**2 * (x - 1.0)
        f_1 += 2.0 * mu / alpha * x
        f_11 += 2.0 * mu * x
        power = np.where(same, alpha, np.expm1(alpha * apart) / grown)
        quotient += 2.0 * mu / alpha * power * np.exp((alpha - 1.0) * second)
    return StretchDerivatives(f, f_1, f_11, quotient)


def _refusal(constants: Constants) -> str:
    """Refuse lists of different lengths, and powers of zero."""
    mu, alpha = constants["mu"], constants["alpha"]
    if mu and isinstance(mu, tuple) and isinstance(alpha, tuple) and len(mu) == len(alpha) and 0.0 not in alpha:
        return ""
    return f"mu and alpha must be lists of one length, without a zero alpha; got {mu} and {alpha}"


def _held(x: Array, reach: float) -> Mask:
    """Return which exponents stand at an end of their range."""
    inner = np.isclose(np.abs(x), np.where(x > 0.0, 1.0, 2.0), rtol=1e-5)
    return np.asarray(inner | (np.abs(x) > 0.9999 * _REACH), dtype=np.bool_)


def stiffer_terms(mu: Array, alpha: Array, share: float) -> tuple[str, Constants]:
    """Return Ogden's law with terms that add share mu/2 (I1 - 3)^2, to lowest order, and nothing at small strain.

    With sum_i e_i = 0, sum_i (cosh 4 e_i - 1)/16 - (cosh 2 e_i - 1)/4 = sum_i e_i^4/2 + ... = (I1 - 3)^2/16 + ...
    """
    more = 2.0 * share * float(mu.sum())
    return "ogden", {"mu": (*mu.tolist(), more, more, -more, -more), "alpha": (*alpha.tolist(), 4.0, -4.0, 2.0, -2.0)}


def _stiffened(constants: Constants, share: float) -> tuple[str, Constants]:
    """Return the terms with those of stiffening."""
    mu, alpha = (np.atleast_1d(constants[name]) for name in ("mu", "alpha"))
    return stiffer_terms(mu, alpha, share)


OGDEN = Law(
    name="ogden",
    units={"mu": "Pa", "alpha": ""},
    shear_modulus=lambda constants: sum(mu for mu, _ in _terms(constants)),
    energy=OfStretches(_energy),
    stiffened=_stiffened,
    fit=TermFit(
        constants=lambda m, x: {"mu": tuple(m.tolist()), "alpha": tuple(x.tolist())},
        starts=lambda reach: np.array(_EXPONENTS),
        limits=lambda x, reach: (np.where(x > 0.0, 1.0, -_REACH), np.where(x > 0.0, _REACH, -2.0)),
        held=_held,
        note="an exponent is held at the end of its range",
        several=True,
        tension_alone=1.0,
    ),
    refusal=_refusal,
    lists=True,
)
