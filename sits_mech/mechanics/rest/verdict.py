"""Judge a state at rest: J > 0 everywhere and a stable target; describe a path that ended.

It counts where the volume ratio J is positive at every quadrature point and every node of an element, corners
included, and where the target is stable: beyond its critical load a layer buckles, though Newton's method finds it
upright. With S the stiffness that the target has (newton.py), no small push on what is not held of it may do negative
work,

    e > 0,    e the smallest eigenvalue of the symmetric part of S,

and half a pad must withstand what its symmetry hides, too: falling sideways, out of the plane, and turning about z. A
crease that forms at a corner, which hardly moves the target, does not count.

Source: J. M. T. Thompson, G. W. Hunt, A General Theory of Elastic Stability (1973), chapter 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.rest.body import Bonded, smallest_volume
from sits_mech.mechanics.rest.linearisation import Held
from sits_mech.mechanics.rest.newton import SETTLED, Settled, target_stiffness
from sits_mech.quantities import Array

REASONS = {
    "buckled": "beyond this load the layer buckles: its equilibrium is unstable",
    "sideways": "beyond this load the layer buckles out of its plane of symmetry: its equilibrium is unstable",
    "turned": "this is the largest load of its kind that the layer carries: there is no equilibrium nearby beyond it",
    "inverted": "beyond this load the mesh turns inside out at a corner",
    "lost": "beyond this load no equilibrium was found, though the last one is stable: a smaller load may converge",
    "slipping": "beyond this load the contact pressures under friction do not converge",
    "long": "beyond this load the limit of iterations for a mesh of this size is reached",
}
"""Messages by the reason of an `Outcome` (limit.py); see `reason_words`."""


_NONE = np.zeros((0, 0))


@dataclass(frozen=True)
class Way:
    """The straight path from one goal to another, each (k,), scaled."""

    begin: Array  # forces F_x, F_z, M, ...; d_h, d_z, alpha, ... where held
    end: Array
    held: Held  # (k,), components whose places are given
    beside: Held | None = None  # (3,), out-of-plane components that are given; None: none

    @property
    def slope(self) -> Array:
        """Derivative of the goal by the part of the path."""
        return self.end - self.begin

    def goal(self, part: float) -> Array:
        """Return the goal at a part of the path."""
        return (1.0 - part) * self.begin + part * self.end


class Verdict(NamedTuple):
    """Stability of a state; stiffness is the smallest eigenvalue of S, inf if all places are held, nan if unknown."""

    min_J: float
    stiffness: float
    reason: str  # against the state; "" if it counts
    S: Array


def verdict(body: Bonded, way: Way, found: Settled) -> Verdict:
    """Judge a state that Newton's method ended at."""
    trial, stiffness, hidden = found[:3]
    if not trial.residual <= SETTLED:
        return Verdict(trial.min_J, np.nan, "lost", _NONE)
    least = smallest_volume(body, trial.u, everywhere=True)
    if not least > 0.0:
        return Verdict(least, np.nan, "inverted", _NONE)
    if stiffness is None:
        stiffness, hidden = target_stiffness(body, trial)
    value, reason = smallest_stiffness(way, stiffness, hidden)
    return Verdict(least, value, reason, stiffness)


def smallest_stiffness(way: Way, stiffness: Array, hidden: Array | None) -> tuple[float, str]:
    """Return the smallest eigenvalue of the stiffness, hidden motions included, and the reason it stands for."""
    held = way.held
    if held.any() and way.beside is not None:
        held = np.concatenate([held[:3], way.beside])[: len(held)]
    own = np.inf if way.held.all() else smallest_eigenvalue(stiffness, held)
    beside = np.inf if hidden is None else smallest_eigenvalue(hidden, way.beside)
    if own > 0.0 and beside > 0.0:
        return min(own, beside), ""
    return (beside, "sideways") if own > 0.0 else (own, "buckled")


def smallest_eigenvalue(stiffness: Array, held: Held | None = None) -> float:
    """Return the smallest eigenvalue of the symmetric stiffness on free components; nan if not finite."""
    S = stiffness if held is None else stiffness[np.ix_(~held, ~held)]
    if not np.all(np.isfinite(S)):
        return np.nan
    return float(np.linalg.eigvalsh(0.5 * (S + S.T)).min(initial=np.inf))


def stable(stiffness: Array, held: Held | None = None) -> bool:
    """Whether the target withstands any small push on its free components."""
    return smallest_eigenvalue(stiffness, held) > 0.0


def reason_words(reason: str) -> str:
    """Return the reason a path ended, in words."""
    return REASONS[reason]
