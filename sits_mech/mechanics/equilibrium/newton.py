"""Bring a deformed layer to rest: Newton's method on displacement, pressure, and the target's motion.

Steps are those of linearisation.py. Near the rest, where steps are small, a factor serves several of them. The
stiffness S that the target has says whether it stands stable: where its symmetric part is positive definite no small
push does negative work. Hopeless iterations end early: a first step beyond the range of linear theory, or a residual
that does not fall.

A state at rest counts where the volume ratio J is positive at every quadrature point and every node of an element,
corners included, and where the target is stable: beyond its critical load a layer buckles, though Newton's method finds
it upright. With S the stiffness that the target has, no small push on what is not held of it may do negative work,

    e > 0,    e the smallest eigenvalue of the symmetric part of S,

and half a pad must withstand what its symmetry hides, too: falling sideways, out of the plane, and turning about z. A
crease that forms at a corner, which hardly moves the target, does not count.

Source: P. Wriggers, Nonlinear Finite Element Methods (2008), chapter 5; J. M. T. Thompson, G. W. Hunt, A General Theory
of Elastic Stability (1973), chapter 2.
"""

from __future__ import annotations

import logging
import math
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.equilibrium.body import Bonded, State, deformed_state, rest, smallest_volume
from sits_mech.mechanics.equilibrium.elimination import eliminated
from sits_mech.mechanics.equilibrium.linearisation import (
    Factor,
    Residuals,
    factored,
    factored_shapes,
    hidden_stiffness,
    residuals_of,
    stepped,
    way_of,
)
from sits_mech.mechanics.equilibrium.outcome import Arc, Outcome, Path, PathEnd, StepTarget, aim_of, bordered
from sits_mech.memory import SECONDS
from sits_mech.quantities import Array, Mask

SETTLED = 1e-9
"""Residual, over the load's size or the share of K below which rounding would rule, of a state at rest."""
MOST = 16
"""Iterations after which an increment is given up; twice as many of a descent, 12 to 25 taken (test_limit_point.py)."""
LONGEST = 1.5
"""Largest displacement of the target's edge in the first step of an increment [thicknesses]."""

EASY = 5
"""Iterations up to which the next increment grows."""
STANDS = "%d unknowns: at rest under %.0f %% of the load after %d iterations"

_LOG = logging.getLogger(__name__)
_NEAR = 3e-3  # residual below which the target's stiffness by the last factor is taken as that at rest
_AGAIN = 0.1  # share of the residual that a step with an older factor must leave at most for the factor to serve on
_PATIENCE = 8, 4  # iterations after which the residual must lie below its first value, and at a point of a path without
# contact: there of 21 loads on five pads 191 of 195 that came to rest lay below, of those that were lost 47 of 52 above
_PACE = (1e-5, 3.3e-5)  # s that an iteration takes for an unknown, of sections and solids: 0.6 to 1.5, 1.1 to 3.2 seen
_GIVEN = 1.0 / 3.0  # of the limit of time, what a path is given before its pace is looked at
_LEAST_CLEAR = 0.1  # last step over the displacement beyond which a target that is nearly at rest is lost


class Steps(NamedTuple):
    """How Newton's method steps, and when it ends."""

    falling: bool = False  # the potential is descended, surer at singular edges and slower elsewhere
    eliminating: bool = False  # the cells at rims are brought to rest by themselves after each step
    enough: float | None = None  # step of the target's edge that ends it [thicknesses]; None: small forces do


PLAIN, DESCENT = Steps(), Steps(falling=True)


def newton(
    body: Bonded, start: State, end: Array, held: Mask | None = None, *, arc: Arc | None = None, steps: Steps = PLAIN
) -> Outcome:
    """Iterate to rest under given loads and places; the result's reason says whether it settled.

    `end` (k,) and `held` as of a `Path`. With an `arc` the part of the path is found, too. With `steps.enough` the
    target comes nearly to rest, long before the last corner: its last move is its error, `off`, and a step that no
    other can follow is the last.
    """
    held = np.zeros(body.components, dtype=bool) if held is None else held
    take = eliminated if steps.eliminating else partial(stepped, held=held, falling=steps.falling)
    load = np.where(held, start.load, end)
    here = replace(start, load=load, height=body.stands(start.u, load), known=deformed_state(body, start))
    found, off, near, left = residuals_of(body, here), np.full(body.components, np.inf), np.inf, list[float]()
    factor: Factor | None = None
    length = part = taken = lift = 0.0
    nearly, way_on = steps.enough is not None, (body.slips | body.meets(end), arc is not None and not body.parts)
    most = 2 * MOST if steps.falling and not nearly else MOST
    for count in range(most + 1):
        aim = aim_of(here, end if arc is None else end + part * arc.slope, held, arc)
        left.append(_residual(body, here, found, aim))
        here = replace(here, residual=left[-1], iterations=count)
        _LOG.info("%d unknowns: forces out of balance by %.1g after %d iterations", len(body.free), left[-1], count)
        moved = max(body.length(off), lift)
        if count == most or _done(steps, left, (moved, taken), way_on):
            break
        if factor is None or nearly or near > _NEAR or left[-1] > _AGAIN * left[-2]:
            factor = None  # its memory is needed for the next one
            factor, near = factored(body, here, found), left[-1]
        way = None if factor is None else way_of(body, here, found, factor, aim)
        length = body.length(way.q) if way is not None and not count else length
        far = length > LONGEST and not nearly
        gone = None if factor is None or way is None or far else take(body, here, found, factor, way)
        if gone is None or way is None:
            here = here if nearly else replace(here, residual=np.inf, iterations=count + 1)
            break
        here, taken, found = gone
        part, off, lift = part + taken * way.part, np.abs(way.q), abs(way.height)
    clear = body.length(off) <= _LEAST_CLEAR * body.length(here.q) if nearly else here.residual <= SETTLED
    ended = Outcome(here, 1.0 if arc is None else part, PathEnd.NONE if clear else PathEnd.LOST, length=length, off=off)
    if factor is None or near > _NEAR or nearly or not clear:
        return ended
    stiffness, made, factor = factor.stiffness, factor.made, None
    return replace(ended, S=stiffness, odd=hidden_stiffness(body, made))


def small_strain_compliance(body: Bonded) -> tuple[Array, Array]:
    """Return compliance (k, k) and unloaded motion (k,) of the undeformed state."""
    here = rest(body)
    found = residuals_of(body, here)
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
    factor = factored(body, state, residuals_of(body, state))
    if factor is None:
        none = np.full((body.components, body.components), np.nan)
        return none, None if body.hidden is None else none
    stiffness, made, factor = factor.stiffness, factor.made, None
    return stiffness, hidden_stiffness(body, made)


def rate(body: Bonded, state: State, stiffness: Array, held: Mask, slope: Array) -> Array:
    """Return dq by the part of the path from a state at rest; nan where it does not exist."""
    k = body.components
    matrix = bordered(body, state.q, stiffness, held, (slope, np.zeros(k)))
    try:
        return np.linalg.solve(matrix, np.eye(2 * k + 1)[-1])[:k]
    except np.linalg.LinAlgError:
        return np.full(k, np.nan)


def bonded_stiffness(body: Bonded, shapes: Array, even: Mask) -> Array:
    """Return the stiffness at rest on the motion and on `shapes` (n, d, m), which are `even` in y, (6 + m, 6 + m).

    What a body neither frees nor hides is zero.
    """
    k, K = body.components, np.zeros((6 + len(even), 6 + len(even)))
    own, odd = [*range(k), *(6 + np.flatnonzero(even | (k == 6)))], [*range(3, 6), *(6 + np.flatnonzero(~even))]
    parts = [(body.pattern, own), *([] if body.hidden is None else [(body.hidden(), odd)])]
    for (_, some), found in zip(parts, factored_shapes(body, rest(body), shapes, parts), strict=True):
        K[np.ix_(some, some)] = found.stiffness
    return K


def correction(body: Bonded, load: Array) -> tuple[Array, float]:
    """Return how far a second Newton step from rest moves q, 0 if none is left; the smallest J before it, or inf."""
    here, aim = replace(rest(body), load=load), StepTarget(np.zeros(3, dtype=bool), np.zeros(3))
    for again in (False, True):
        found = residuals_of(body, here)
        if _residual(body, here, found, aim) <= SETTLED:
            return np.zeros(3), here.min_J
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


def _residual(body: Bonded, here: State, found: Residuals, aim: StepTarget) -> float:
    """Return the norm of the gradient over the size of the load; inf beyond the law's locking stretch.

    A load above the rounding of stresses that has moved nothing yet is not at rest, however small.
    """
    size, still = float(np.linalg.norm(here.load)), not here.q.any()
    size = size if still and size > np.finfo(float).eps * body.laws.K.max() else max(size, body.rounding)
    left = math.hypot(np.linalg.norm(found.free), np.linalg.norm(found.target), found.shape) / size
    left += float(np.abs(aim.gap).max()) + abs(aim.ahead)
    return left if left > SETTLED or np.isfinite(found.energy) else np.inf


def _done(steps: Steps, left: list[float], last: tuple[float, float], way: tuple[bool, bool]) -> bool:
    """Whether iterations end: settled or hopeless; if nearly at rest is enough, after a whole step of `enough`."""
    if steps.enough is None:
        return left[-1] <= SETTLED or _hopeless(left, way, steps.falling)
    small = last[1] == 1.0 and last[0] <= steps.enough
    return small and (not steps.eliminating or left[-1] <= _NEAR)


def _hopeless(left: list[float], way: tuple[bool, bool], falling: bool) -> bool:
    """Whether residuals do not converge: not finite or, unless points slip or meet a shape, no smaller after some.

    `way`: whether any do, and whether it is to a point of a path without contact.

    Close to a saddle a descent turns its steps round, which double a residual: 8 times from the square of what is near.
    """
    saddle = falling and len(left) > 2 and _NEAR**2 > left[-1] > left[-2] > left[-3]
    return not np.isfinite(left[-1]) or saddle or (not way[0] and len(left) > _PATIENCE[way[1]] and left[-1] > left[0])


def judged(body: Bonded, path: Path, found: Outcome) -> Outcome:
    """Return a state that Newton's method ended at with its stability, and whether it counts."""
    if found.reason:
        return found
    least = smallest_volume(body, found.state.u, everywhere=True)
    found = replace(found, state=replace(found.state, min_J=least))
    if not least > 0.0:
        return replace(found, reason=PathEnd.INVERTED)
    S, odd = (found.S, found.odd) if found.S.size else target_stiffness(body, found.state)
    hidden = np.inf if odd is None else smallest_eigenvalue(odd, path.out_of_plane)
    value, reason = smallest_stiffness(path, S, hidden)
    return replace(found, S=S, stiffness=value, hidden=hidden, reason=reason)


def smallest_stiffness(path: Path, stiffness: Array, hidden: float) -> tuple[float, PathEnd]:
    """Return the smallest eigenvalue of the stiffness, of hidden motions, too, and which instability it shows."""
    held = path.held
    if held.any() and path.out_of_plane is not None:
        held = np.concatenate([held[:3], path.out_of_plane])[: len(held)]
    own = np.inf if path.held.all() else smallest_eigenvalue(stiffness, held)
    if own > 0.0 and hidden > 0.0:
        return min(own, hidden), PathEnd.NONE
    return (hidden, PathEnd.SIDEWAYS) if own > 0.0 else (own, PathEnd.BUCKLED)


def smallest_eigenvalue(stiffness: Array, held: Mask | None = None) -> float:
    """Return the smallest eigenvalue of the symmetric stiffness on free components; nan if not finite.

    `held` may go on to components that the body has not.
    """
    free = np.ones(len(stiffness), dtype=bool) if held is None else ~held[: len(stiffness)]
    S = stiffness[np.ix_(free, free)]
    if not np.all(np.isfinite(S)):
        return np.nan
    return float(np.linalg.eigvalsh(0.5 * (S + S.T)).min(initial=np.inf))


def affordable(body: Bonded, share: float = 0.25) -> float:
    """Return how many iterations of a path on a mesh take a share of the limit of time (memory.py).

    A quarter, as four paths may be in vain: those of the free and of the guarded family, without and with contact.
    """
    return share * SECONDS.get() / iteration_seconds(body)


def goes_on(body: Bonded, work: tuple[float, float], at: float) -> bool:
    """Whether a path at a part of its way has iterations left, and its pace will do if it spent a third of its limit.

    `work`: iterations spent, and most.
    """
    (spent, most), limit = work, affordable(body)
    return spent < most and (spent < _GIVEN * limit or at >= spent / limit)


def iteration_seconds(body: Bonded) -> float:
    """Return the processor time of an iteration on a mesh [s], some."""
    return _PACE[len(body.mesh.axes) - 2] * len(body.free)
