"""Advance a layer along a path, from rest to rest, by a rule that chooses increments.

    path --(rule: an increment)--> load --(newton.py)--> state --(does it count?)--> next increment, or Outcome

What is given may be any mix of forces and places of the target (control.py): with a place given, a path goes past the
largest load that the layer carries. Increments at whose end no rest is found are shortened, as far as the rule allows,
and lengthened again after.

`PathLeg`: an elastic layer. The whole load is tried at once, as far as linear theory says that the target moves a
thickness or so; increments grow where it is easy, and end where the stiffness would vanish if it went on as it does.
From an increment that does not come to rest, or to a state that does not count (newton.py), the path goes on by its
length (limit_point.py), which finds the largest load, or the one at which stability is lost, as a number.

`Swelling`: what swells without load, by parts. With friction: increments.py.

Source: P. Wriggers, Nonlinear Finite Element Methods (2008), chapter 5.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from math import isclose

import numpy as np

from sits_mech.mechanics.equilibrium.body import Bonded, State, rest
from sits_mech.mechanics.equilibrium.limit_point import pursued
from sits_mech.mechanics.equilibrium.newton import (
    DESCENT,
    EASY,
    LONGEST,
    PLAIN,
    STANDS,
    affordable,
    goes_on,
    judged,
    newton,
)
from sits_mech.mechanics.equilibrium.outcome import Outcome, Path, PathEnd
from sits_mech.mechanics.faces.rigid import Press
from sits_mech.quantities import Array

_LOG = logging.getLogger(__name__)
_CUT = 0.25  # of an increment that fails, where the path goes on by its length
_LOOKS = 3  # how often a step is solved with more and more faces that meet
_LEAST = 1.0 / 16.0  # of the first increment, below which none is tried


class Walk:
    """A path that is followed: an increment is halved where nothing comes to rest, and doubled up to the first."""

    judges = True  # whether a rest must be stable to count
    steps = PLAIN  # of Newton's method, tried first

    def __init__(self, body: Bonded, start: State, path: Path, *, step: float = 1.0, most: float = np.inf) -> None:
        self.body, self.here, self.path = body, start, path  # `here`: last state at rest, with all iterations so far
        self.step = self.first = step
        self.begun, self.most = start.iterations, start.iterations + most
        self.at, self.to, self.hidden = 0.0, 0.0, np.nan  # of the path: where it is, and where its increment ends

    def left(self) -> bool:
        """Whether there are iterations left for an increment."""
        return self.here.iterations < self.most

    def rest(self, end: Array, start: State | None = None, body: Bonded | None = None) -> Outcome:
        """Return the rest at the end of an increment, found again where free faces it did not hold apart have met.

        Full Newton steps are tried first; where singular edges make them wander, the potential is descended.
        """
        start = start or replace(self.here, iterations=0)
        self.body = (body or self.body).near(start.u)
        for _ in range(_LOOKS):
            found = newton(self.body, start, end, self.path.held, steps=self.steps)
            if self._wanders(found):
                found = newton(self.body, start, end, self.path.held, steps=DESCENT).after(found)
            wider = self.body if found.reason else self.body.near(found.state.u)
            if wider is self.body:
                break
            self.body = wider
        return found

    def _wanders(self, found: Outcome) -> bool:
        """Whether full steps wander, where there are iterations left to descend."""
        left = self.here.iterations + found.state.iterations < self.most
        return bool(found.reason) and left and not (found.length > LONGEST or self.steps.falling or self.body.slips)

    def lengthen(self, found: Outcome) -> None:
        """Choose the next increment after one that came to rest."""
        self.step = min(2.0 * self.step, self.first)

    def shorten(self, found: Outcome) -> bool:
        """Choose a shorter increment after one that failed; whether it is tried."""
        self.step *= 0.5
        return self.step >= _LEAST * self.first

    def outcome(self, reason: PathEnd) -> Outcome:
        """Return how the path ended."""
        return Outcome(self.here, self.at, reason, hidden=np.nan if reason else self.hidden)


class PathLeg(Walk):
    """One leg, followed by increments of the load, then by its length.

    `smallest`: least step over the path so far; above a quarter the first failed increment ends the path. `most`: limit
    of iterations, besides that of time (`affordable`).
    """

    def __init__(self, body: Bonded, start: State, path: Path, *, smallest: float = 1e-3, most: float = np.inf) -> None:
        super().__init__(body, start, path, most=min(most, affordable(body)))
        self.smallest, self.before, self.length = smallest, (0.0, np.nan), 0.0  # before: place, and stiffness there

    def left(self) -> bool:
        """Whether there are iterations left, and the pace will do."""
        return goes_on(self.body, (self.here.iterations - self.begun, self.most - self.begun), self.at)

    def lengthen(self, found: Outcome) -> None:
        """Choose an increment that the stiffness allows."""
        (place, stiffness), self.before = self.before, (self.to, found.stiffness)
        allowed = 1.1 * (self.to - place) * found.stiffness / max(stiffness - found.stiffness, 1e-300)
        self.step = min(self.step * (2.0 if found.state.iterations <= EASY else 1.0), allowed)  # nan at first
        _LOG.info(STANDS, len(self.body.free), 100.0 * self.to, self.here.iterations)

    def shorten(self, found: Outcome) -> bool:
        """Shorten an increment that is beyond linear theory; after any other the path goes on by its length."""
        self.step, self.length = 0.9 * (self.to - self.at) * LONGEST / max(found.length, LONGEST), _CUT * found.length
        return found.length > LONGEST

    def outcome(self, reason: PathEnd) -> Outcome:
        """Return how the path ended, by its length from an increment that failed."""
        if not reason or reason is PathEnd.LONG:
            return super().outcome(reason)
        if _CUT < self.smallest:
            return super().outcome(reason if self.here.iterations < self.most else PathEnd.LONG)
        here = self.here, self.at
        return pursued(self.body, self.path, here, self.length, smallest=self.smallest, most=self.most)


class Swelling(Walk):
    """Swelling without load, by parts."""

    judges = False

    def rest(self, end: Array, start: State | None = None, body: Bonded | None = None) -> Outcome:
        """Return the rest of a body that has swollen by a part."""
        some = replace(self.body, laws=self.body.laws.swollen(self.to))
        return newton(some, replace(self.here, iterations=0), end)


class Pressing(Walk):
    """A cover that is pressed on, by increments of the force; the path is not followed by its length.

    The potential is descended; from where a shape hardly touches, and few points carry it, it is let in softly first.
    """

    steps = DESCENT

    def __init__(self, body: Bonded, start: State, path: Path, *, smallest: float = 1.0, most: float = np.inf) -> None:
        super().__init__(body, start, path, most=min(most, affordable(body)))

    def rest(self, end: Array, start: State | None = None, body: Bonded | None = None) -> Outcome:
        """Return the rest at the end of an increment, where what presses has room."""
        begun, own = replace(start or self.here, iterations=0), body or self.body
        if (press := own.press) is None or not press.meets(end):
            return super().rest(end, begun, own)
        ways = ((press.depth,), press.depths)[not press.meets(begun.load) :]
        found = self._let_in(own, begun, end, press, ways[0])
        if found.reason and len(ways) > 1:
            found = self._let_in(own, begun, end, press, ways[1]).after(found)
        sunk = not found.reason and -found.state.height > press.room
        return replace(found, reason=PathEnd.SUNK) if sunk else found

    def _let_in(self, body: Bonded, begun: State, end: Array, press: Press, depths: Sequence[float]) -> Outcome:
        """Return the rest at the end of an increment, through rests by which a shape is let in more and more."""
        found = Outcome(begun)
        for depth in depths:
            softer, begun = replace(body, press=replace(press, depth=depth)), replace(found.state, iterations=0)
            found = super().rest(end, begun, softer).after(found)
            if found.reason:
                break
        return found


def advance(
    body: Bonded, start: State, path: Path, rule: Callable[..., Walk] | None = None, **options: float
) -> Outcome:
    """Follow a path from a state at rest at its first corner by a rule; ``reached == path.legs`` at the end.

    The rule is that of a leg, or of a cover that is pressed on; `options` are the rule's. A body finds it once for the
    same numbers.
    """
    rule = rule or (PathLeg if body.press is None else Pressing)
    name = body.name_of(start, path, rule, options)
    known: Outcome | None = body.rests.get(name)
    if known is not None:
        return known
    walk, reason = rule(body, start, path, **options), PathEnd.NONE
    while walk.at < path.legs and not reason:
        if not walk.left():
            reason = PathEnd.LONG
            break
        there, leg = walk.at + walk.step, int(walk.at) + 1.0
        walk.to = leg if there > leg or isclose(there, leg) else there
        found = walk.rest(path.at(walk.to))
        found = judged(walk.body, path, found) if walk.judges else found
        spent = walk.here.iterations + found.state.iterations
        walk.here = replace(walk.here if found.reason else found.state, iterations=spent)
        if not found.reason:
            walk.lengthen(found)
            walk.at, walk.hidden = walk.to, found.hidden
        elif not walk.shorten(found):
            reason = found.reason
    return body.keep(name, walk.outcome(reason))


def unloaded(body: Bonded) -> State:
    """Return the state without load: undeformed, or swollen at once or by parts; undeformed where a part fails."""
    if not body.laws.swell:
        return rest(body)
    none = np.zeros(body.components)
    found = advance(body, rest(body), Path((none, none)), Swelling)
    return rest(body) if found.reason else replace(found.state, iterations=0)
