"""Follow a layer to its load: Newton's method (newton.py) along an adaptive path.

The whole load is tried at once, as far as linear theory says that the target moves a thickness or so; increments grow
where it is easy, and end where the stiffness would vanish if it went on as it does. From an increment that does not
come to rest, or to a state that does not count (verdict.py), the path goes on by its length (limit.py), which finds the
largest load, or the one at which stability is lost, as a number.

What is given may be any mix of forces and places of the target: with a place given, the path goes past the largest
load that the layer carries. Source: P. Wriggers, Nonlinear Finite Element Methods (2008), chapter 5.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sits_mech.mechanics.rest.body import Bonded, State
from sits_mech.mechanics.rest.limit import Outcome, pursued
from sits_mech.mechanics.rest.linearisation import Held
from sits_mech.mechanics.rest.newton import LONGEST, SETTLED, Settled, newton
from sits_mech.mechanics.rest.verdict import Way, verdict
from sits_mech.quantities import Array

_EASY = 5  # iterations up to which the next increment grows
_STEPS = 400
_CUT = 0.25  # of an increment that fails, where the path goes on by its length
_LOOKS = 3  # how often a step is solved with more and more faces that meet


def follow(
    body: Bonded, start: State, goals: tuple[Array, Array], *, smallest: float = 1e-3, held: Held | None = None,
    beside: Held | None = None, most: float = np.inf,
) -> Outcome:
    """Follow the straight path between two goals from a state at rest under the first; ``reached == 1`` at the end.

    Goals (k,) are forces F_x, F_z, M, ..., or places d_h, d_z, alpha, ... where `held`, scaled. `beside` (3,): which
    out-of-plane components are given, none by default; the target must withstand a push on the others. `smallest`:
    least step over the path so far; above a quarter the first failed increment ends the path. `most`: limit of
    iterations.
    """
    way = Way(*goals, np.zeros(body.components, dtype=bool) if held is None else held, beside)
    here, at, increment, before = start, 0.0, 1.0, (0.0, np.nan)
    length = 0.0
    for _ in range(_STEPS):
        target = min(1.0, at + increment)
        body, found = among_faces(body, replace(here, iterations=0), way.goal(target), held)
        spent = here.iterations + found.state.iterations
        if found.length > LONGEST:
            increment, here = 0.9 * (target - at) * LONGEST / found.length, replace(here, iterations=spent)
            continue
        said = verdict(body, way, found)
        if said.reason:
            here, length = replace(here, iterations=spent), _CUT * found.length
            break
        here, fallen = replace(found.state, iterations=spent, min_J=said.min_J), before[1] - said.stiffness
        gone, before, at = target - before[0], (target, said.stiffness), target
        increment *= 2.0 if found.state.iterations <= _EASY else 1.0
        if fallen > 0.0:
            increment = min(increment, 1.1 * gone * said.stiffness / fallen)
        if at == 1.0:
            return Outcome(here, at)
        if spent - start.iterations >= most:
            return Outcome(here, at, "long")
    if _CUT < smallest:
        return Outcome(here, at, said.reason)
    left = most - (here.iterations - start.iterations)
    return pursued(body, way, (here, at), length, smallest=smallest, most=left)


def among_faces(body: Bonded, start: State, goal: Array, held: Held | None) -> tuple[Bonded, Settled]:
    """Return a body and its rest under a goal, solved again where free faces it did not hold apart have met.

    Full Newton steps are tried first; where singular edges make them wander, the potential is descended.
    """
    body = body.near(start.u)
    for _ in range(_LOOKS):
        found = newton(body, start, goal, held)
        if not found.state.residual <= SETTLED and not body.slips and not found.length > LONGEST:
            spent, found = found.state.iterations, newton(body, start, goal, held, falling=True)
            found = found._replace(state=replace(found.state, iterations=spent + found.state.iterations))
        wider = body.near(found.state.u) if found.state.residual <= SETTLED else body
        if wider is body:
            break
        body = wider
    return body, found
