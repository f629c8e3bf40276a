"""Follow a path by its length, to its last corner or to what ends it: a largest load, or stability that is lost.

A point of the path is the motion q of the target and the part t of the load. From a stable state the next one is looked
for in a plane across the path, a length s ahead, with t found (linearisation.py, `Arc`),

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
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.equilibrium.body import Bonded, State
from sits_mech.mechanics.equilibrium.newton import EASY, LONGEST, STANDS, goes_on, judged, newton, rate
from sits_mech.mechanics.equilibrium.outcome import Arc, Outcome, Path, PathEnd
from sits_mech.quantities import Array

_LOG = logging.getLogger(__name__)
PRECISE = 2e-3
"""Relative width of the bracket around a limit."""

_GONE = 1e-3  # of it: what is left of the stiffness where a slightly crooked layer buckles into a bent one
_STRAIGHT, _CORNER = 0.5, 1e-4  # cosine up to which a path may turn in a step, and length that is not resolved
_LITTLE = 0.03  # of it: a path that is lost there was about to lose its stability
_SMALL = 0.3  # of the stiffness at the beginning: a stiffness above it has not gone to zero
_BEYOND = 1.1  # times the length at which the stiffness seems to vanish that is gone at once


class _Place(NamedTuple):
    """A stable state on the path."""

    state: State
    part: float  # of the load
    stiffness: float  # smallest eigenvalue
    rate: float  # displacement of the edge by the part
    normal: Array  # of the path


class _Bracket(NamedTuple):
    """A stable place and a point ahead, beyond the stable path."""

    here: _Place
    ahead: float  # distance
    part: float  # of the load there, with smallest stiffness and reason
    stiffness: float
    reason: PathEnd

    @property
    def parabola(self) -> tuple[float, float]:
        """Slope and curvature of the load by length."""
        m = 1.0 / self.here.rate
        return m, (self.part - self.here.part - m * self.ahead) / self.ahead**2

    @property
    def root(self) -> float:
        """Length at which the stiffness vanishes or the load is largest, whichever is first."""
        fall = self.here.stiffness - self.stiffness
        zero = self.ahead * self.here.stiffness / fall if fall > 0.0 and self.stiffness <= 0.0 else self.ahead
        m, c = self.parabola
        return min(zero, -0.5 * m / c) if c < 0.0 else zero

    @property
    def value(self) -> float:
        """Part of the load at the limit."""
        (m, c), s = self.parabola, self.root
        return self.here.part + m * s + c * s**2

    @property
    def width(self) -> float:
        """Parts of the load between which the limit is."""
        return max(abs(self.part - self.here.part), abs(self.value - self.here.part))

    def near_root(self, side: float) -> float:
        """Return the length to a point a little beyond, 1, or before the limit, -1: both ends of the bracket move."""
        return float(np.clip(self.root + side * 0.02 * self.ahead, 0.02 * self.ahead, 0.98 * self.ahead))

    def located(self, first: float) -> bool:
        """Whether the bracket is narrow enough; `first`: stiffness at the beginning."""
        near = self.here.stiffness <= _SMALL * first or self.ahead <= _CORNER
        return near and self.width <= PRECISE * abs(self.value)

    def outcome(self, spent: int, first: float) -> Outcome:
        """Return the end of the path: at a limit, or lost where the stiffness jumps."""
        state, (m, c) = replace(self.here.state, iterations=spent), self.parabola
        if self.here.stiffness > _SMALL * first:
            return Outcome(state, self.here.part, PathEnd.LOST)
        turned = self.reason is PathEnd.BUCKLED and c < 0.0 and -0.5 * m / c < self.ahead
        return Outcome(state, self.here.part, PathEnd.TURNED if turned else self.reason, (self.value, self.width))


def pursued(
    body: Bonded, path: Path, start: tuple[State, float], length: float, *, smallest: float, most: float
) -> Outcome:
    """Follow a path of one leg by its length from a stable state to its last corner or to what ends it.

    `start`: state and its part of the path; `length`: first step [thicknesses]; `smallest`: least step over the path so
    far; `most`: limit of all iterations, those before included.
    """
    before = here = _place(body, path, judged(body, path, Outcome(*start)))
    end: _Bracket | None = None
    gone = _GONE * here.stiffness if np.isfinite(here.stiffness) else 0.0  # it is infinite where every place is held
    begun, spent, first = body.length(start[0].q) + length, start[0].iterations, here.stiffness
    reason = PathEnd.LOST
    while end is None or not end.located(first):
        if length <= smallest * (1.0 if end is None else PRECISE) * max(begun, body.length(here.state.q)):
            return _left(before, here, spent, first, reason)
        if not goes_on(body, (spent, most), here.part if end is None else 1.0):
            return _left(before, here, spent, first, PathEnd.LONG)
        there = _ahead(body, path, here, length)
        spent += there.state.iterations
        if not there.reason and there.reached >= 1.0:
            there = _ahead(body, path, here, None)
            spent += there.state.iterations
            if not there.reason:
                return replace(there, state=replace(there.state, iterations=spent))
        astray = not there.reason and there.reached <= here.part  # stable, on another branch
        if astray or there.reason in (PathEnd.LOST, PathEnd.INVERTED):
            reason, length = there.reason or PathEnd.LOST, 0.25 * length
        elif there.reason or there.stiffness <= gone:
            why = there.reason or PathEnd.BUCKLED
            end = _Bracket(here, length, there.reached, there.stiffness - gone, why)
            length = end.near_root(-1.0)
        else:
            new = _place(body, path, there)
            one, other = here.normal / body.levers, new.normal / body.levers
            size = max(float(np.linalg.norm(one) * np.linalg.norm(other)), 1e-300)
            if one @ other < _STRAIGHT * size and length > _CORNER * begun:
                length *= 0.25
                continue
            before, here = here, new
            _LOG.info(STANDS, len(body.free), 100.0 * here.part, spent)
            if end is None or length >= end.ahead:
                end, length = None, length * (2.0 if there.state.iterations <= EASY else 1.0)
                fall, gone_by = before.stiffness - here.stiffness, here.normal @ (here.state.q - before.state.q)
                zero = _BEYOND * here.stiffness / fall * abs(float(gone_by)) if fall > 0.0 else np.inf
                length = min(length, LONGEST, zero)  # where the stiffness seems to vanish, and a little
            else:
                end = end._replace(here=here, ahead=end.ahead - length)
                length = end.near_root(1.0)
    return end.outcome(spent, first)


def _left(before: _Place, here: _Place, spent: int, first: float, reason: PathEnd) -> Outcome:
    """End a lost path; with little stiffness left, extrapolate the limit to where it vanishes."""
    state = replace(here.state, iterations=spent)
    fall, ahead = before.stiffness - here.stiffness, here.part - before.part
    if not (here.stiffness <= _LITTLE * first and fall > 0.0 and ahead > 0.0):
        return Outcome(state, here.part, reason)
    further = ahead * here.stiffness / fall
    return Outcome(state, here.part, PathEnd.BUCKLED, (here.part + further, further))


def _place(body: Bonded, path: Path, found: Outcome) -> _Place:
    """Describe a stable state on the path."""
    ahead = rate(body, found.state, found.S, path.held, path.slope)
    size = body.length(ahead)
    normal = body.levers**2 * ahead / size if 0.0 < size < np.inf else np.zeros_like(ahead)
    return _Place(found.state, found.reached, found.stiffness, size, normal)


def _ahead(body: Bonded, path: Path, here: _Place, length: float | None) -> Outcome:
    """Solve for the state a length ahead, or at the last corner; it has reached its part of the load."""
    arc = None if length is None else Arc(here.state.q, here.normal, length, path.slope)
    end = path.at(1.0 if arc is None else here.part)
    found = newton(body, replace(here.state, iterations=0), end, path.held, arc=arc)
    return replace(judged(body, path, found), reached=1.0 if arc is None else here.part + found.reached)
