"""Bring a deformed layer to rest: Newton's method on displacement, pressure, and the target's motion.

Steps are those of linearisation.py. Near the rest, where steps are small, a factor serves several of them. The
stiffness S that the target has says whether it stands stable: where its symmetric part is positive definite no small
push does negative work. Hopeless iterations end early: a first step beyond the range of linear theory, or a residual
that does not fall.

Source: P. Wriggers, Nonlinear Finite Element Methods (2008), chapter 5.

A state at rest counts where the volume ratio J is positive at every quadrature point and every node of an element,
corners included, and where the target is stable: beyond its critical load a layer buckles, though Newton's method finds
it upright. With S the stiffness that the target has, no small push on what is not held of it may do negative work,

    e > 0,    e the smallest eigenvalue of the symmetric part of S,

and half a pad must withstand what its symmetry hides, too: falling sideways, out of the plane, and turning about z. A
crease that forms at a corner, which hardly moves the target, does not count.

Source: J. M. T. Thompson, G. W. Hunt, A General Theory of Elastic Stability (1973), chapter 2.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.equilibrium.body import (
    ROUNDING,
    Bonded,
    State,
    deformed_state,
    remembered,
    rest,
    smallest_volume,
)
from sits_mech.mechanics.equilibrium.elimination import eliminated
from sits_mech.mechanics.equilibrium.linearisation import (
    Aim,
    Arc,
    Factor,
    Gradient,
    Held,
    aim_of,
    bordered,
    factored,
    gradient,
    hidden_stiffness,
    stepped,
    way_of,
)
from sits_mech.mechanics.equilibrium.outcome import Outcome, PathEnd
from sits_mech.quantities import Array

SETTLED = 1e-9
"""Residual, over the load's size or the share of K below which rounding would rule, of a state at rest."""
MOST = 16
"""Iterations after which an increment is given up; twice as many of a descent, which took 12 to 25 (test_limit.py)."""
LONGEST = 1.5
"""Largest displacement of the target's edge in the first step of an increment [thicknesses]."""

_LOG = logging.getLogger(__name__)
_NEAR = 3e-3  # residual from which one more step leaves the target's stiffness as it is
_AGAIN = 0.1  # share of the residual that a step with an older factor must leave at most for the factor to serve on
_PATIENCE = 8  # iterations after which the residual must lie below its first value
_LEAST_CLEAR = 0.1  # of the target's way, by which a place that is no better tells nothing
_LEAST_SWELLING = 0.05  # part of it


_NONE = np.zeros((0, 0))


class Iterated(NamedTuple):
    """The end of Newton's method, with the target's stiffness there or nearby."""

    state: State
    stiffness: Array | None  # S; None if unknown
    hidden: Array | None = None  # S on motions hidden by symmetry; None if nothing is hidden
    length: float = 0.0  # displacement of the target's edge in the first step [thicknesses]
    part: float = 0.0  # distance along the path, if it was to be found


def newton(
    body: Bonded, start: State, goal: Array, held: Held | None = None, *, arc: Arc | None = None, falling: bool = False
) -> Iterated:
    """Iterate to rest under one goal; the result's residual says whether it settled.

    Goal and `held` as in `follow`. With an `arc` the part of the path is found, too. `falling`: descend the potential,
    surer at singular edges and slower elsewhere.
    """
    held = np.zeros(body.components, dtype=bool) if held is None else held
    here = replace(start, load=np.where(held, start.load, goal), known=deformed_state(body, start))
    near, left = np.inf, list[float]()
    factor: Factor | None = None
    length = part = 0.0
    found = gradient(body, here)
    most = 2 * MOST if falling else MOST
    for count in range(most + 1):
        aim = aim_of(here, goal if arc is None else goal + part * arc.slope, held, arc)
        left.append(_residual(body, here, found, aim))
        here = replace(here, residual=left[-1], iterations=count)
        _LOG.info("%d unknowns: forces out of balance by %.1g after %d iterations", len(body.free), left[-1], count)
        if left[-1] <= SETTLED or count == most or _hopeless(left, body.slips):
            break
        if factor is None or near > _NEAR or left[-1] > _AGAIN * left[-2]:
            factor = None  # its memory is needed for the next one
            factor, near = factored(body, here, found), left[-1]
        way = None if factor is None else way_of(body, here, found, factor, aim)
        length = body.length(way.q) if way is not None and not count else length
        gone = None if factor is None or way is None or length > LONGEST else stepped(
            body, here, found, factor, way, held, falling=falling
        )
        if gone is None or way is None:
            here = replace(here, residual=np.inf, iterations=count + 1)
            break
        here, part, found = gone[0], part + gone[1] * way.part, gone[2]
    if factor is None or near > _NEAR:
        return Iterated(here, None, None, length, part)
    stiffness, made, factor = factor.stiffness, factor.made, None
    return Iterated(here, stiffness, hidden_stiffness(body, made), length, part)


@remembered
def approached(
    body: Bonded, start: State, goal: Array, held: Held, enough: float, *, eliminating: bool = False
) -> Outcome | None:
    """Return the target nearly at rest, or None where that does not show.

    Steps end where one moves the target's edge by at most `enough` [thicknesses], long before the last corner is at
    rest; that last move is the error. `eliminating`: with the cells at rims at rest by themselves after each step, and
    forces small at the end; without, the potential is descended.
    """
    here = replace(start, load=np.where(held, start.load, goal), known=deformed_state(body, start))
    found, off = gradient(body, here), np.full(body.components, np.inf)
    take = eliminated if eliminating else partial(stepped, held=held, falling=True)
    for count in range(1, MOST + 1):
        factor = None  # its memory is needed for the next one
        factor, aim = factored(body, here, found), aim_of(here, goal, held, None)
        way = None if factor is None else way_of(body, here, found, factor, aim)
        gone = None if factor is None or way is None else take(body, here, found, factor, way)
        if way is None or gone is None:
            break
        here, off, found = replace(gone[0], iterations=count), np.abs(way.q), gone[2]
        stays = gone[1] == 1.0 and body.length(off) <= enough
        if stays and (not eliminating or _residual(body, here, found, aim) <= _NEAR):
            break
    if not body.length(off) <= _LEAST_CLEAR * body.length(here.q):
        return None
    return Outcome(here, off=off)


def unloaded(body: Bonded) -> State:
    """Return the state without load: undeformed, or swollen at once or by parts; undeformed where a part fails."""
    state, at, part, none = rest(body), 0.0, 1.0, np.zeros(body.components)
    while at < 1.0 and body.swelling != 1.0:
        some = replace(body, swelling=1.0 + min(at + part, 1.0) * (body.swelling - 1.0))
        found = newton(some, replace(state, iterations=0), none)
        if found.state.residual <= SETTLED and found.state.min_J > 0.0:
            state, at = found.state, at + part
        elif (part := 0.5 * part) < _LEAST_SWELLING:
            return rest(body)
    return replace(state, iterations=0)


def small_strain(body: Bonded) -> tuple[Array, Array]:
    """Return compliance (k, k) and unloaded motion (k,) of the undeformed state."""
    here = rest(body)
    found = gradient(body, here)
    factor = factored(body, here, found)
    try:
        if factor is not None:
            C = np.asarray(np.linalg.inv(factor.stiffness))
            return C, np.asarray(-C @ (found.target + factor.side.T @ factor.step))
    except np.linalg.LinAlgError:
        pass
    return np.full((body.components, body.components), np.nan), np.full(body.components, np.nan)


def target_stiffness(body: Bonded, state: State) -> tuple[Array, Array | None]:
    """Return d(forces on q)/dq, nan if there is none, and that on motions hidden by symmetry or None."""
    factor = factored(body, state, gradient(body, state))
    if factor is None:
        none = np.full((body.components, body.components), np.nan)
        return none, None if body.hidden is None else none
    stiffness, made, factor = factor.stiffness, factor.made, None
    return stiffness, hidden_stiffness(body, made)


def rate(body: Bonded, state: State, stiffness: Array, held: Held, slope: Array) -> Array:
    """Return dq by the part of the path from a state at rest; nan where it does not exist."""
    k = body.components
    matrix = bordered(body, state.q, stiffness, held, (slope, np.zeros(k)))
    try:
        return np.linalg.solve(matrix, np.eye(2 * k + 1)[-1])[:k]
    except np.linalg.LinAlgError:
        return np.full(k, np.nan)


def correction(body: Bonded, load: Array) -> tuple[Array, float]:
    """Return how far a second Newton step from rest moves q, and the smallest J before it; inf if inverted."""
    here, aim = replace(rest(body), load=load), Aim(np.zeros(3, dtype=bool), np.zeros(3))
    for again in (False, True):
        found = gradient(body, here)
        factor = factored(body, here, found)
        if factor is None:
            break
        way = way_of(body, here, found, factor, aim)
        if way is None:
            break
        if again:
            return way.q, here.min_J
        after = stepped(body, here, found, factor, way, aim.held)
        if after is None or after[1] < 1.0:
            break
        here = after[0]
    return np.full(3, np.inf), 0.0


def _residual(body: Bonded, here: State, found: Gradient, aim: Aim) -> float:
    """Return the norm of the gradient over the size of the load; inf beyond the law's locking stretch."""
    size = max(float(np.linalg.norm(here.load)), ROUNDING * body.K)
    left = float(np.hypot(np.linalg.norm(found.free), np.linalg.norm(found.target))) / size
    left += float(np.abs(aim.gap).max()) + abs(aim.ahead)
    return left if left > SETTLED or np.isfinite(found.energy) else np.inf


def _hopeless(left: list[float], slips: bool) -> bool:
    """Whether residuals do not converge: not finite or, unless points slip, no smaller after some steps."""
    return not np.isfinite(left[-1]) or (not slips and len(left) > _PATIENCE and left[-1] > left[0])


@dataclass(frozen=True)
class Way:
    """The straight path from one goal to another, each (k,), scaled."""

    begin: Array  # forces F_x, F_z, M, ...; d_h, d_z, alpha, ... where held
    end: Array
    held: Held  # (k,), components whose places are given
    out_of_plane: Held | None = None  # (3,), out-of-plane components that are given; None: none

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
    reason: PathEnd  # against the state
    S: Array
    hidden: float = np.nan  # smallest eigenvalue on motions hidden by symmetry; inf if none are


def verdict(body: Bonded, way: Way, found: Iterated) -> Verdict:
    """Judge a state that Newton's method ended at."""
    trial, stiffness, hidden = found[:3]
    if not trial.residual <= SETTLED:
        return Verdict(trial.min_J, np.nan, PathEnd.LOST, _NONE)
    least = smallest_volume(body, trial.u, everywhere=True)
    if not least > 0.0:
        return Verdict(least, np.nan, PathEnd.INVERTED, _NONE)
    if stiffness is None:
        stiffness, hidden = target_stiffness(body, trial)
    beside = np.inf if hidden is None else smallest_eigenvalue(hidden, way.out_of_plane)
    value, reason = smallest_stiffness(way, stiffness, beside)
    return Verdict(least, value, reason, stiffness, beside)


def smallest_stiffness(way: Way, stiffness: Array, hidden: float) -> tuple[float, PathEnd]:
    """Return the smallest eigenvalue of the stiffness, of hidden motions, too, and the reason it stands for."""
    held = way.held
    if held.any() and way.out_of_plane is not None:
        held = np.concatenate([held[:3], way.out_of_plane])[: len(held)]
    own = np.inf if way.held.all() else smallest_eigenvalue(stiffness, held)
    if own > 0.0 and hidden > 0.0:
        return min(own, hidden), PathEnd.NONE
    return (hidden, PathEnd.SIDEWAYS) if own > 0.0 else (own, PathEnd.BUCKLED)


def smallest_eigenvalue(stiffness: Array, held: Held | None = None) -> float:
    """Return the smallest eigenvalue of the symmetric stiffness on free components; nan if not finite.

    `held` may go on to components that the body has not.
    """
    free = np.ones(len(stiffness), dtype=bool) if held is None else ~held[: len(stiffness)]
    S = stiffness[np.ix_(free, free)]
    if not np.all(np.isfinite(S)):
        return np.nan
    return float(np.linalg.eigvalsh(0.5 * (S + S.T)).min(initial=np.inf))
