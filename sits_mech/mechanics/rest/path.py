"""How does a layer follow a load? Newton's method (newton.py) along an adaptive path.

An increment that does not settle is cut, and the path from the last state at rest goes on with a smaller one, which
grows again where it is easy. A state at rest counts only where

- the volume ratio J is positive at every quadrature point and every node of an element, corners included;
- the target is stable: beyond its critical load a layer buckles, though Newton's method finds it upright. Half a pad
  must withstand what its symmetry hides, too: falling sideways, out of the plane, and turning about z.

What is given may be any mix of forces and places of the target: with a place given, the path goes past the largest
load that the layer carries. Source: P. Wriggers, Nonlinear Finite Element Methods (2008), chapter 5; stability by the
condensed stiffness: J. M. T. Thompson, G. W. Hunt, A General Theory of Elastic Stability (1973), chapter 2.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sits_mech.mechanics.rest.body import Bonded, State, smallest_volume
from sits_mech.mechanics.rest.newton import MOST, SETTLED, Held, Settled, newton, stable, target_stiffness
from sits_mech.quantities import Array

REASONS = {
    "buckled": "beyond this load the layer buckles: its rest is not stable",
    "inverted": "beyond this load the mesh turns inside out at a corner",
    "lost": "every step of at least {smallest:.2g} of the path failed from here; a nearer load may converge",
    "long": "beyond this load more iterations were needed than a mesh this large is given",
}
"""What is said of a path that ended, by the reason of its `Outcome`; see `reason_words`."""

_EASY = 5  # iterations up to which the next increment grows
_STEPS = 400
_LOOKS = 3  # how often a step is solved with more and more faces that meet


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


def reason_words(reason: str, smallest: float) -> str:
    """Return what is known of a path that ended, in words, from its smallest increment as a fraction of the path."""
    return REASONS[reason].format(smallest=smallest)


def follow(
    body: Bonded, start: State, goals: tuple[Array, Array], *, smallest: float = 1e-3, held: Held | None = None,
    beside: Held | None = None, most: float = np.inf,
) -> Outcome:  # fmt: skip
    """Follow the straight path from a state at rest.

    Parameters
    ----------
    body : Bonded
    start : State
        At rest under the first goal.
    goals : tuple of ndarray, shape (k,)
        F_x, F_z, M, ... at the start and at the end; where `held`, d_h, d_z, alpha, ... instead; scaled.
    smallest : float
        Increment, as a fraction of the path, below which the path is given up.
    held : ndarray of bool, shape (k,), optional
        Which of the target's places are given instead of the force.
    beside : ndarray of bool, shape (3,), optional
        Which of the components that leave the plane are given, where a symmetry keeps or hides them; none by default:
        the target must withstand a push on the others.
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
        body, found = _among_faces(body, replace(here, iterations=0), goal, held)
        trial = found.state
        spent += trial.iterations
        least, reason = _verdict(body, found, held, beside)
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


def _among_faces(body: Bonded, start: State, goal: Array, held: Held | None) -> tuple[Bonded, Settled]:
    """Newton's method, and again where free faces met on the way that were not held against each other; the body."""
    body = body.near(start.u)
    for _ in range(_LOOKS):
        found = newton(body, start, goal, held)
        wider = body.near(found.state.u) if found.state.residual <= SETTLED else body
        if wider is body:
            break
        body = wider
    return body, found


def _verdict(body: Bonded, found: Settled, held: Held | None, beside: Held | None) -> tuple[float, str]:
    """Smallest J of a trial, and what speaks against it."""
    trial, stiffness, hidden = found
    if trial.residual > SETTLED or not np.isfinite(trial.residual):
        return trial.min_J, "lost"
    least = smallest_volume(body, trial.u, everywhere=True)
    if not least > 0.0:
        return least, "inverted"
    if stiffness is None:
        stiffness, hidden = target_stiffness(body, trial)
    if held is not None and beside is not None:
        held = np.concatenate([held[:3], beside])[: len(held)]
    upright = held is not None and bool(held.all())
    if not (upright or stable(stiffness, held)) or not (hidden is None or stable(hidden, beside)):
        return least, "buckled"
    return least, ""
