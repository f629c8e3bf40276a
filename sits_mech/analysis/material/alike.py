"""Find the laws that fit a silicone's tests as well, and how far a law is from them where a pad is strained.

A pad is pressed and sheared, a specimen pulled. At one deformation laws differ in energy, and so in load, by the factor

    s = exp max |ln(w_k(l)/w(l))|,    over the laws k, and states l of uniaxial compression and shear with I1 - 3 <= 1

(pressed to half, or sheared by 1); at small strain it is that of moduli. The laws k are all of the registry, fitted to
the points with I1 - 3 <= 1 of all modes, whose residual is at most twice the least one or 2 % of the largest stress:
what a strain from the crosshead, or one specimen for others, is worth. By tension alone those of I1 (which no condition
of other modes holds) are fitted once more, with a share of I2 - 3 besides: laws that stiffen have none. So s counts
what a law misses of the pull itself at a pad's strains, too.

ln s is taken as a half-width of 90 %. Study: tests/analysis/material/test_alike.py, with laws that others fitted to
tests of several modes as truths; all of rubber, none of a silicone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from sits_mech.analysis.material.least_squares import fit_constants
from sits_mech.analysis.material.points import MeasuredPoints
from sits_mech.silicone.homogeneous import energy_density, principal_stretches, state_stress
from sits_mech.silicone.laws import LAWS, Constants

REACH = 1.0
"""Largest I1 - 3 of the states that are compared."""
_FACTOR, _FLOOR = 2.0, 0.02  # of the least residual, and of the largest stress
_SECOND = 1.0 / 6.0  # of mu: w_2 = w_1/2, the most that mooney_rivlin.py allows
_ENDS = {"uniaxial": 0.5392, "planar": 1.618}  # stretches at `REACH`
_LEAST = 5  # points, where few are so near
_FIRST = 1e-3  # of the way to them in ln: moduli at small strain


class LawWithConstants(NamedTuple):
    """A law with its constants, and what its energy has of I2 - 3 besides [Pa]."""

    law: str
    constants: Constants
    second: float = 0.0

    @property
    def name(self) -> str:
        """Name of the law with its number of terms, and of I2."""
        terms = [len(value) for value in self.constants.values() if isinstance(value, tuple)]
        words = f"{self.law} of {terms[0]} term{'s' * (terms[0] > 1)}" if terms else self.law
        return words + " with I2" * bool(self.second)


def as_good(points: MeasuredPoints) -> tuple[LawWithConstants, ...]:
    """Return the laws that fit points within a pad's strains as well as the best, by their residuals."""
    near = points.excess <= max(REACH, np.sort(points.excess)[_LEAST - 1])
    points = MeasuredPoints(points.stretches[near], points.stress[near], points.weight[near], points.specimen[near])
    tries = [(law, points, terms) for law in LAWS.values() for terms in ((1, 2) if law.lists else (1,))]
    found = sorted(((fit_constants(*each), each[0].name) for each in tries), key=lambda pair: pair[0].rms)
    most = max(_FACTOR * found[0][0].rms, _FLOOR * float(points.stress.max()))
    good = [LawWithConstants(name, fit.constants) for fit, name in found if fit.rms <= most]
    if points.tension_alone:
        second = _SECOND * LAWS[good[0].law].shear_modulus(good[0].constants)
        pulled = state_stress("mooney-rivlin", {"c10": 0.0, "c01": second}, points.stretches)
        rest = replace(points, stress=points.stress - pulled)
        of_I1 = [known.law for known in good if LAWS[known.law].fit.tension_alone in ((), -np.inf)]
        more = {name: fit_constants(LAWS[name], rest, 1) for name in of_I1}
        good += [LawWithConstants(name, fit.constants, second) for name, fit in more.items() if fit.rms <= most]
    return tuple(good)


def largest_factor(one: LawWithConstants, others: Sequence[LawWithConstants]) -> float:
    """Return the largest factor s between the energies of a law and of others, at least 1."""
    states = np.vstack([
        principal_stretches(mode, end ** np.geomspace(_FIRST, 1.0, 30)) for mode, end in _ENDS.items()
    ])
    I2 = (states**-2).sum(axis=1)
    w = [energy_density(*each[:2], states) + each.second * (I2 - 3.0) for each in (one, *others)]
    with np.errstate(divide="ignore", invalid="ignore"):  # a law that locks or falls has no energy there
        apart = np.abs(np.log(np.stack(w[1:]) / w[0]))
    return float(np.exp(np.nan_to_num(apart, nan=np.inf, posinf=np.inf).max()))


def central_law(laws: Sequence[LawWithConstants]) -> tuple[LawWithConstants, float]:
    """Return the law of least largest factor to the others, and that."""
    return min(((each, largest_factor(each, laws)) for each in laws if not each.second), key=lambda found: found[1])
