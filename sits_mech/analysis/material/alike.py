"""Find the laws that fit a silicone's tests as well, and how far a law is from them where a pad is strained.

A pad is pressed and sheared, a specimen pulled. At one deformation laws differ in energy, and so in load, by the factor

    s = exp max |ln(w_k(l)/w(l))|,    over the laws k, and states l of uniaxial compression and shear with I1 - 3 <= 1

(pressed to half, or sheared by 1); at small strain it is that of moduli. The laws k are all of the registry, fitted to
the points with I1 - 3 <= 1 of all modes, whose residual is at most twice the least one or 2 % of the largest stress:
what a strain from the crosshead, or one specimen for others, is worth. So s counts what a law misses of the pull itself
at a pad's strains, too. Laws are held as in least_squares.py.

ln s is taken as a half-width of 90 %. Study: tests/analysis/material/test_alike.py, with laws fitted by others to
several modes as truths.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sits_mech.analysis.material.least_squares import Points, fit_constants
from sits_mech.silicone.homogeneous import energy_density, principal_stretches
from sits_mech.silicone.laws import LAWS, Constants

REACH = 1.0
"""Largest I1 - 3 of the states that are compared."""
_FACTOR, _FLOOR = 2.0, 0.02  # of the least residual, and of the largest stress
_ENDS = {"uniaxial": 0.5392, "planar": 1.618}  # stretches at `REACH`
_LEAST = 5  # points, where few are so near
_FIRST = 1e-3  # of the way to them in ln: moduli at small strain


class Known(NamedTuple):
    """A law with its constants."""

    law: str
    constants: Constants

    @property
    def name(self) -> str:
        """Name of the law with its number of terms."""
        terms = [len(value) for value in self.constants.values() if isinstance(value, tuple)]
        return self.law if not terms else f"{self.law} of {terms[0]} terms" if terms[0] > 1 else f"{self.law} of 1 term"


def as_good(points: Points) -> tuple[Known, ...]:
    """Return the laws that fit points within a pad's strains as well as the best, by their residuals."""
    near = points.excess <= max(REACH, np.sort(points.excess)[_LEAST - 1])
    points = Points(points.stretches[near], points.stress[near], points.weight[near])
    tries = [(law, terms) for law in LAWS.values() for terms in ((1, 2) if law.lists else (1,))]
    found = [(fit_constants(law, points, terms), law.name) for law, terms in tries]
    most = max(_FACTOR * min(answer.rms for answer, _ in found), _FLOOR * float(points.stress.max()))
    good = sorted((each for each in found if each[0].rms <= most), key=lambda each: each[0].rms)
    return tuple(Known(name, answer.constants) for answer, name in good)


def factor(one: Known, others: Sequence[Known]) -> float:
    """Return the largest factor s between the energies of a law and of others, at least 1."""
    states = np.vstack([
        principal_stretches(mode, end ** np.geomspace(_FIRST, 1.0, 30)) for mode, end in _ENDS.items()
    ])
    w = [energy_density(*each, states) for each in (one, *others)]
    with np.errstate(divide="ignore", invalid="ignore"):  # a law that locks or falls has no energy there
        apart = np.abs(np.log(np.stack(w[1:]) / w[0]))
    return float(np.exp(np.nan_to_num(apart, nan=np.inf, posinf=np.inf).max()))


def nearest(laws: Sequence[Known]) -> tuple[Known, float]:
    """Return the law of least largest factor to the others, and that."""
    return min(((each, factor(each, laws)) for each in laws), key=lambda found: found[1])
