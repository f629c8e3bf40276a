"""Follow a layer to its load: Newton's method (newton.py) along an adaptive path.

The whole load is tried at once, as far as linear theory says that the target moves a thickness or so; increments grow
where it is easy, and end where the stiffness would vanish if it went on as it does. From an increment that does not
come to rest, or to a state that does not count (newton.py), the path goes on by its length, which finds the largest
load, or the one at which stability is lost, as a number.

What is given may be any mix of forces and places of the target: with a place given, the path goes past the largest
load that the layer carries. Source: P. Wriggers, Nonlinear Finite Element Methods (2008), chapter 5.

The part of a load that a layer carries. A point of the path is the motion q of the target and the part t of the load.
From a stable state the next one is looked for in a plane across the path, a length s ahead, with t found (newton.py,
`Arc`),

    n . (q - q_0) = s,        n = W^2 q'/|W q'|,        q' = dq/dt,

W the levers that turn the components of q into ways of the target's edge. The smallest eigenvalue e of the target's
stiffness is positive at the one end of a bracket and not at the other, or the load falls there; the secant of e(s) and
the parabola t(s), by its slope at the stable end, shrink the bracket:

    t = t_0 + m s + c s^2,        t_limit = t(min(s_e, s_t)),        e(s_e) = 0,    t'(s_t) = 0,

so that a load at which stability is lost (e = 0) and a largest load (t' = 0) are one search. Where e does not go to
zero the other end was another branch, and the path is lost there, not limited.

Source: E. Riks, Int. J. Solids Struct. 15 (1979) 529; W. C. Rheinboldt, SIAM J. Numer. Anal. 18 (1981) 925.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

import numpy as np

from sits_mech.mechanics.equilibrium.body import Bonded, State, remembered
from sits_mech.mechanics.equilibrium.linearisation import Arc, Held
from sits_mech.mechanics.equilibrium.newton import (
    LONGEST,
    SETTLED,
    Iterated,
    Verdict,
    Way,
    newton,
    rate,
    verdict,
)
from sits_mech.mechanics.equilibrium.outcome import Outcome, PathEnd
from sits_mech.memory import SECONDS
from sits_mech.quantities import Array

_LOG, _STANDS = logging.getLogger(__name__), "%d unknowns: at rest under %.0f %% of the load after %d iterations"
_EASY = 5  # iterations up to which the next increment grows
_PACE = (1e-5, 3.3e-5)  # s that an iteration takes for an unknown, of sections and solids: 0.6 to 1.5, 1.1 to 3.2 seen
_GIVEN = 1.0 / 3.0  # of the limit of time, what a path is given before its pace is looked at
_CUT = 0.25  # of an increment that fails, where the path goes on by its length
_LOOKS = 3  # how often a step is solved with more and more faces that meet
PRECISE = 2e-3
"""Relative width of the bracket around a limit."""

_GONE = 1e-3  # of it: what is left of the stiffness where a slightly crooked layer buckles into a bent one
_STRAIGHT, _CORNER = 0.5, 1e-4  # cosine up to which a path may turn in a step, and length that is not resolved
_LITTLE = 0.03  # of it: a path that is lost there was about to lose its stability
_SMALL = 0.3  # of the stiffness at the beginning: a stiffness above it has not gone to zero
_BEYOND = 1.1  # times the length at which the stiffness seems to vanish that is gone at once


@remembered
def follow(
    body: Bonded, start: State, goals: tuple[Array, Array], *, smallest: float = 1e-3, held: Held | None = None,
    out_of_plane: Held | None = None, most: float = np.inf,
) -> Outcome:
    """Follow the straight path between two goals from a state at rest under the first; ``reached == 1`` at the end.

    Goals (k,) are forces F_x, F_z, M, ..., or places d_h, d_z, alpha, ... where `held`, scaled. `out_of_plane` (3,):
    which components out of the plane are given, none by default; the target must withstand a push on the others.
    `smallest`: least step over the path so far; above a quarter the first failed increment ends the path. `most`:
    limit of iterations, besides that of time (`affordable`).
    """
    most = start.iterations + min(most, affordable(body))
    way = Way(*goals, np.zeros(body.components, dtype=bool) if held is None else held, out_of_plane)
    here, at, increment, before = start, 0.0, 1.0, (0.0, np.nan)
    length = 0.0
    while _goes_on(body, (here.iterations - start.iterations, most - start.iterations), at):
        target = min(1.0, at + increment)
        body, found = among_faces(body, replace(here, iterations=0), way.goal(target), held, most - here.iterations)
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
        increment = min(increment, 1.1 * gone * said.stiffness / max(fallen, 1e-300))  # nan, at first, limits nothing
        if at == 1.0:
            return Outcome(here, at, hidden=said.hidden)
        _LOG.info(_STANDS, len(body.free), 100.0 * at, here.iterations)
    else:
        return Outcome(here, at, PathEnd.LONG)
    if _CUT < smallest:
        return Outcome(here, at, said.reason if here.iterations < most else PathEnd.LONG)
    return pursued(body, way, (here, at), length, smallest=smallest, most=most)


def affordable(body: Bonded, share: float = 0.25) -> float:
    """Return how many iterations of a path on a mesh take a share of the limit of time (memory.py).

    A quarter, as four paths may be in vain: those of the free and of the guarded family, without and with contact.
    """
    return share * SECONDS.get() / iteration_seconds(body)


def _goes_on(body: Bonded, work: tuple[float, float], at: float) -> bool:
    """Whether a path at a part of its way has iterations left, and its pace will do if it spent a third of its limit.

    `work`: iterations spent, and most.
    """
    (spent, most), limit = work, affordable(body)
    return spent < most and (spent < _GIVEN * limit or at >= spent / limit)


def iteration_seconds(body: Bonded) -> float:
    """Return the processor time of an iteration on a mesh [s], some."""
    return _PACE[len(body.mesh.axes) - 2] * len(body.free)


def among_faces(
    body: Bonded, start: State, goal: Array, held: Held | None, most: float = np.inf
) -> tuple[Bonded, Iterated]:
    """Return a body and its rest under a goal, solved again where free faces it did not hold apart have met.

    Full Newton steps are tried first; where singular edges make them wander, the potential is descended, unless they
    were as many as `most`.
    """
    body = body.near(start.u)
    for _ in range(_LOOKS):
        found = newton(body, start, goal, held)
        wanders = not found.state.residual <= SETTLED and not found.length > LONGEST
        if wanders and not body.slips and found.state.iterations < most:
            spent, found = found.state.iterations, newton(body, start, goal, held, falling=True)
            found = found._replace(state=replace(found.state, iterations=spent + found.state.iterations))
        wider = body.near(found.state.u) if found.state.residual <= SETTLED else body
        if wider is body:
            break
        body = wider
    return body, found


@dataclass(frozen=True)
class _Place:
    """A stable state on the path."""

    state: State
    part: float  # of the load
    stiffness: float  # smallest eigenvalue
    rate: float  # displacement of the edge by the part
    normal: Array  # of the path


@dataclass(frozen=True)
class _End:
    """A point beyond the stable path: distance, part of the load, smallest stiffness, reason."""

    ahead: float
    part: float
    stiffness: float
    reason: PathEnd


def pursued(
    body: Bonded, way: Way, start: tuple[State, float], length: float, *, smallest: float, most: float
) -> Outcome:
    """Follow a path by its length from a stable state to its goal or to what ends it.

    `start`: state and its part of the path; `length`: first step [thicknesses]; `smallest`: least step over the path so
    far; `most`: limit of all iterations, those before included.
    """
    here = _place(body, way, *start, verdict(body, way, Iterated(start[0], None)))
    end, reason, before = None, PathEnd.LOST, here
    gone = _GONE * here.stiffness if np.isfinite(here.stiffness) else 0.0  # it is infinite where every place is held
    begun, spent, first = body.length(start[0].q) + length, start[0].iterations, here.stiffness
    while True:
        if end is not None and _located(here, end, first):
            return _limited(here, end, spent, first)
        if length <= smallest * (1.0 if end is None else PRECISE) * max(begun, body.length(here.state.q)):
            break
        if not _goes_on(body, (spent, most), here.part if end is None else 1.0):
            reason = PathEnd.LONG
            break
        step, to, said = _ahead(body, way, here, length)
        spent += step.iterations
        if not said.reason and to >= 1.0:
            step, to, said = _ahead(body, way, here, None)
            spent += step.iterations
            if not said.reason:
                return Outcome(replace(step, iterations=spent), 1.0, hidden=said.hidden)
        astray = not said.reason and to <= here.part  # stable, on another branch
        if astray or said.reason in (PathEnd.LOST, PathEnd.INVERTED):
            reason, length = said.reason or PathEnd.LOST, 0.25 * length
        elif said.reason or said.stiffness <= gone:
            end = _End(length, to, said.stiffness - gone, said.reason or PathEnd.BUCKLED)
            length = _next(here, end, beyond=False)
        else:
            there = _place(body, way, step, to, said)
            if _angle(body, here, there) < _STRAIGHT and length > _CORNER * begun:
                length *= 0.25
                continue
            before, here = here, there
            _LOG.info(_STANDS, len(body.free), 100.0 * to, spent)
            end = None if end is None or length >= end.ahead else replace(end, ahead=end.ahead - length)
            length *= 2.0 if step.iterations <= _EASY else 1.0
            length = min(length, LONGEST, _vanishing(before, here)) if end is None else _next(here, end, beyond=True)
    return _left(before, here, replace(here.state, iterations=spent), first, reason)


def _left(before: _Place, here: _Place, state: State, first: float, reason: PathEnd) -> Outcome:
    """End a lost path; with little stiffness left, extrapolate the limit to where it vanishes."""
    fall, ahead = before.stiffness - here.stiffness, here.part - before.part
    if not (here.stiffness <= _LITTLE * first and fall > 0.0 and ahead > 0.0):
        return Outcome(state, here.part, reason)
    further = ahead * here.stiffness / fall
    return Outcome(state, here.part, PathEnd.BUCKLED, (here.part + further, further))


def _place(body: Bonded, way: Way, state: State, part: float, said: Verdict) -> _Place:
    """Describe a stable state on the path."""
    ahead = rate(body, state, said.S, way.held, way.slope)
    size = body.length(ahead)
    normal = body.levers**2 * ahead / size if 0.0 < size < np.inf else np.zeros_like(ahead)
    return _Place(state, part, said.stiffness, size, normal)


def _angle(body: Bonded, before: _Place, here: _Place) -> float:
    """Return the cosine of the angle between the path's directions at two places."""
    one, other = before.normal / body.levers, here.normal / body.levers
    size = float(np.linalg.norm(one)) * float(np.linalg.norm(other))
    return float(one @ other) / max(size, 1e-300)


def _ahead(body: Bonded, way: Way, here: _Place, length: float | None) -> tuple[State, float, Verdict]:
    """Solve for the state a length ahead, or at the goal; return it, its part of the load, and its verdict."""
    arc = None if length is None else Arc(here.state.q, here.normal, length, way.slope)
    goal = way.goal(1.0 if arc is None else here.part)
    found = newton(body, replace(here.state, iterations=0), goal, way.held, arc=arc)
    said = verdict(body, way, found)
    return replace(found.state, min_J=said.min_J), 1.0 if arc is None else here.part + found.part, said


def _vanishing(before: _Place, here: _Place) -> float:
    """Extrapolate the length at which the stiffness vanishes from two places, and add a little."""
    fall, gone = before.stiffness - here.stiffness, float(np.abs(here.normal @ (here.state.q - before.state.q)))
    return _BEYOND * here.stiffness / fall * gone if fall > 0.0 else np.inf


def _root(here: _Place, end: _End) -> float:
    """Return the length at which the stiffness vanishes or the load is largest, whichever is first."""
    fall = here.stiffness - end.stiffness
    zero = end.ahead * here.stiffness / fall if fall > 0.0 and end.stiffness <= 0.0 else end.ahead
    m, c = _parabola(here, end)
    return min(zero, -0.5 * m / c) if c < 0.0 else zero


def _parabola(here: _Place, end: _End) -> tuple[float, float]:
    """Return slope and curvature of the load by length."""
    m = 1.0 / here.rate
    return m, (end.part - here.part - m * end.ahead) / end.ahead**2


def _next(here: _Place, end: _End, *, beyond: bool) -> float:
    """Return the length to a point a little beyond or before the limit, so that both ends of the bracket move."""
    off = 0.02 * end.ahead
    return float(np.clip(_root(here, end) + (off if beyond else -off), 0.02 * end.ahead, 0.98 * end.ahead))


def _value(here: _Place, end: _End) -> float:
    """Return the part of the load at the limit."""
    (m, c), s = _parabola(here, end), _root(here, end)
    return here.part + m * s + c * s**2


def _located(here: _Place, end: _End, first: float) -> bool:
    """Whether the bracket is narrow enough."""
    value = _value(here, end)
    near = here.stiffness <= _SMALL * first or end.ahead <= _CORNER
    return near and max(abs(end.part - here.part), abs(value - here.part)) <= PRECISE * abs(value)


def _limited(here: _Place, end: _End, spent: int, first: float) -> Outcome:
    """Return the end of the path: at a limit, or lost where the stiffness jumps."""
    value, state = _value(here, end), replace(here.state, iterations=spent)
    if here.stiffness > _SMALL * first:
        return Outcome(state, here.part, PathEnd.LOST)
    m, c = _parabola(here, end)
    turned = end.reason is PathEnd.BUCKLED and c < 0.0 and -0.5 * m / c < end.ahead
    error = max(abs(end.part - here.part), abs(value - here.part))
    return Outcome(state, here.part, PathEnd.TURNED if turned else end.reason, (value, error))
