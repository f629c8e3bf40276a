"""How does a layer follow a load? Newton's method (newton.py) along an adaptive path.

An increment that does not settle is cut, and the path from the last state at rest goes on with a smaller one, which
grows again where it is easy. A state at rest counts only where

- the volume ratio J is positive at every quadrature point and every node of an element, corners included;
- the target is stable: beyond its critical load a layer buckles, though Newton's method finds it upright.

What is given may be any mix of forces and places of the target: with a place given, the path goes past the largest
load that the layer carries.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sits_mech.mechanics.body import Bonded, Element, State, packed, rest, smallest_volume
from sits_mech.mechanics.newton import FREE, MOST, SETTLED, Held, compliance, felt, newton, stable
from sits_mech.quantities import Array

__all__ = ["REASONS", "Bonded", "Element", "Outcome", "State", "compliance", "follow", "packed", "rest"]

REASONS = {
    "buckled": "beyond this load the layer buckles: its rest is not stable",
    "inverted": "beyond this load the mesh turns inside out at a corner",
    "lost": "beyond this load no state at rest was found nearby",
    "long": "beyond this load more iterations were needed than a mesh this large is given",
}
"""What is said of a path that ended, by the reason of its `Outcome`."""

_EASY = 5  # iterations up to which the next increment grows
_STEPS = 400


@dataclass(frozen=True)
class Outcome:
    """Where a load path ended.

    Attributes
    ----------
    state : State
        The last state at rest.
    reached : float
        Fraction of the path it stands at; 1 is the whole load.
    reason : str
        What ended a path before its goal: "buckled", "inverted" (only with J <= 0 somewhere could it go on),
        "lost" (Newton's method found no state at rest nearby) or "long" (it takes too many iterations); empty
        where the goal is reached.
    """

    state: State
    reached: float
    reason: str = ""

    @property
    def buckled(self) -> bool:
        """Whether the path ended where the target is not stable."""
        return self.reason == "buckled"


def follow(
    body: Bonded, start: State, goals: tuple[Array, Array], *, smallest: float = 1e-3, held: Held = FREE,
    most: float = np.inf,
) -> Outcome:  # fmt: skip
    """Follow the straight path from a state at rest.

    Parameters
    ----------
    body : Bonded
    start : State
        At rest under the first goal.
    goals : tuple of ndarray, shape (3,)
        F_x, F_z, M at the start and at the end; where `held`, d_h, d_z, alpha instead; scaled.
    smallest : float
        Increment, as a fraction of the path, below which the path is given up.
    held : ndarray of bool, shape (3,)
        Which of the target's places are given instead of the force.
    most : float
        Iterations from which on no other step is begun.

    Returns
    -------
    Outcome
        With ``reached == 1`` where the goal is reached.
    """
    here, at, increment = start, 0.0, 1.0
    spent, reason = start.iterations, ""
    for _ in range(_STEPS):
        target = min(1.0, at + increment)
        goal = (1.0 - target) * goals[0] + target * goals[1]
        trial, stiffness = newton(body, replace(here, iterations=0), goal, held)
        spent += trial.iterations
        least, reason = _verdict(body, trial, stiffness, held)
        if not reason:
            here, at = replace(trial, iterations=spent, min_J=least), target
            increment *= 2.0 if trial.iterations <= _EASY else 1.0
            if at == 1.0:
                break
        else:
            increment *= 0.25 if trial.iterations < MOST else 0.5
            if increment < smallest:
                break
        if spent - start.iterations >= most:
            reason = "long"
            break
    return Outcome(replace(here, iterations=spent), at, reason)


def _verdict(body: Bonded, trial: State, stiffness: Array | None, held: Held) -> tuple[float, str]:
    """Smallest J of a trial, and what speaks against it."""
    if trial.residual > SETTLED or not np.isfinite(trial.residual):
        return trial.min_J, "lost"
    least = smallest_volume(body, trial.u, everywhere=True)
    if not least > 0.0:
        return least, "inverted"
    if held.all() or stable(felt(body, trial) if stiffness is None else stiffness, held):
        return least, ""
    return least, "buckled"
