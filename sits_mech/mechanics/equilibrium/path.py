"""Advance a layer along a path, from rest to rest, by a rule that chooses increments.

    path --(rule: an increment)--> goal --(newton.py)--> state --(does it count?)--> next increment, or Outcome

What is given may be any mix of forces and places of the target (control.py): with a place given, a path goes past the
largest load that the layer carries. Increments at whose end no rest is found are shortened, as far as the rule allows,
and lengthened again after.

`PathLeg`: an elastic layer. The whole load is tried at once, as far as linear theory says that the target moves a
thickness or so; increments grow where it is easy, and end where the stiffness would vanish if it went on as it does.
From an increment that does not come to rest, or to a state that does not count (newton.py), the path goes on by its
length (limit.py), which finds the largest load, or the one at which stability is lost, as a number.

`Swelling`: what swells without load, by parts. With friction: increments.py.

Source: P. Wriggers, Nonlinear Finite Element Methods (2008), chapter 5.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from math import isclose

import numpy as np

from sits_mech.mechanics.element.target import all_six
from sits_mech.mechanics.equilibrium.body import Bonded, State, rest, smallest_volume
from sits_mech.mechanics.equilibrium.limit import pursued
from sits_mech.mechanics.equilibrium.newton import DESCENT, EASY, LONGEST, STANDS, affordable, goes_on, judged, newton
from sits_mech.mechanics.equilibrium.outcome import Outcome, Path, PathEnd
from sits_mech.mechanics.faces.rigid import Press
from sits_mech.quantities import Array

_LOG = logging.getLogger(__name__)
_CUT = 0.25  # of an increment that fails, where the path goes on by its length
_LOOKS = 3  # how often a step is solved with more and more faces that meet
_FIRST, _NARROW = 0.1, 1e-3  # of the room below a shape: the longest step, and the least of one that fails
_SAME = 1e-7  # of a force, by which that of a shape may be off
_LEAST = 1.0 / 16.0  # of the first increment, below which none is tried


class Walk:
    """A path that is followed: an increment is halved where nothing comes to rest, and doubled up to the first."""

    judges = True  # whether a rest must be stable to count

    def __init__(self, body: Bonded, start: State, path: Path, *, step: float = 1.0, most: float = np.inf) -> None:
        self.body, self.here, self.path = body, start, path  # `here`: last state at rest, with all iterations so far
        self.step = self.first = step
        self.begun, self.most = start.iterations, start.iterations + most
        self.at, self.end, self.hidden = 0.0, 0.0, np.nan  # of the path: where it is, and where its increment ends

    def left(self) -> bool:
        """Whether there are iterations left for an increment."""
        return self.here.iterations < self.most

    def rest(self, goal: Array, start: State | None = None, body: Bonded | None = None) -> Outcome:
        """Return the rest under a goal, found again where free faces it did not hold apart have met.

        Full Newton steps are tried first; where singular edges make them wander, the potential is descended.
        """
        start = start or replace(self.here, iterations=0)
        self.body = (body or self.body).near(start.u)
        for _ in range(_LOOKS):
            found = newton(self.body, start, goal, self.path.held)
            spent, wanders = found.state.iterations, found.reason and not found.length > LONGEST
            if wanders and not self.body.slips and self.here.iterations + spent < self.most:
                found = newton(self.body, start, goal, self.path.held, steps=DESCENT)
                found = replace(found, state=replace(found.state, iterations=spent + found.state.iterations))
            wider = self.body if found.reason else self.body.near(found.state.u)
            if wider is self.body:
                break
            self.body = wider
        return found

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
        (place, stiffness), self.before = self.before, (self.end, found.stiffness)
        allowed = 1.1 * (self.end - place) * found.stiffness / max(stiffness - found.stiffness, 1e-300)
        self.step = min(self.step * (2.0 if found.state.iterations <= EASY else 1.0), allowed)  # nan at first
        _LOG.info(STANDS, len(self.body.free), 100.0 * self.end, self.here.iterations)

    def shorten(self, found: Outcome) -> bool:
        """Shorten an increment that is beyond linear theory; after any other the path goes on by its length."""
        self.step, self.length = 0.9 * (self.end - self.at) * LONGEST / max(found.length, LONGEST), _CUT * found.length
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

    def rest(self, goal: Array, start: State | None = None, body: Bonded | None = None) -> Outcome:
        """Return the rest of a body that has swollen by a part."""
        some = replace(self.body, laws=self.body.laws.swollen(self.end))
        return newton(some, replace(self.here, iterations=0), goal)


class Pressing(Walk):
    """What presses on a cover by F_z about a place, ``x = M/F_z, y = -M_x/F_z``: a pressure, or a shape so deep.

    Where a shape stands is what is looked for: deeper, from rest to rest, until its force is above that of the goal,
    then by secants in F^(2/3), which is linear of a sphere on a half-space (Hertz).
    """

    def __init__(self, body: Bonded, start: State, path: Path, *, smallest: float = 1.0, most: float = np.inf) -> None:
        super().__init__(body, start, path, most=min(most, affordable(body)))
        self.bare = body

    def rest(self, goal: Array, start: State | None = None, body: Bonded | None = None) -> Outcome:
        """Return the rest of a body that is pressed on."""
        load, press = all_six(goal), self.bare.press
        if press is None or not load[1] > 0.0:
            return super().rest(goal, body=self.bare)
        place = (load[2] / load[1], -load[4] / load[1])
        if not press.touches:
            part = press.load(place, load[[0, 3, 1]] * (1.0, 1.0, -1.0))
            return super().rest(goal, body=self.bare.pressed_by(part))
        return self._shape(goal, press, place)

    def _shape(self, goal: Array, press: Press, place: tuple[float, float]) -> Outcome:
        """Return the rest under a shape that presses by a goal's force."""
        here, force, spent = replace(self.here, iterations=0), float(goal[1]), 0
        sunk, step = press.sunk(place, here.u, float(here.load[1])), _FIRST * press.room
        seen, reason = [] if here.load[1] > 0.0 else [(sunk, 0.0, here)], PathEnd.LONG
        sunk += step * len(seen)
        while spent < self.most - self.here.iterations:
            contact = press.contact(place, sunk)
            found = super().rest(goal, _ahead(self.bare, seen, sunk) or here, self.bare.pressed_by(contact))
            spent += found.state.iterations
            if found.reason:
                reason, near = found.reason, min((depth for depth, _, _ in seen), key=lambda own: abs(own - sunk), default=sunk)
                if abs(near - sunk) < _NARROW * press.room:
                    break
                sunk = 0.5 * (near + sunk)
                continue
            own = press.force(contact, found.state.u, found.state.q)
            if abs(own - force) <= _SAME * force:
                return replace(found, state=replace(found.state, iterations=spent))
            seen.append((sunk, own, found.state))
            if sunk == press.room and own < force:
                reason = PathEnd.SUNK
                break
            sunk = min(_deeper([each[:2] for each in seen], force, step), press.room)
        return Outcome(replace(here, iterations=spent), 0.0, reason)


def _deeper(seen: Sequence[tuple[float, float]], force: float, step: float) -> float:
    """Return how deep a shape is to be tried that stood at depths by forces: a step deeper, or between two."""
    depths, roots = np.array([sunk for sunk, _ in seen]), np.array([max(own, 0.0) for _, own in seen]) ** (2.0 / 3.0)
    goal, low, high = force ** (2.0 / 3.0), -np.inf, np.inf
    low = float(depths[roots < goal].max(initial=-np.inf))
    high = float(depths[roots > goal].min(initial=np.inf))
    near = np.argsort(np.abs(roots - goal))[:2]
    if len(near) < 2:
        return depths[-1] + (step if roots[-1] < goal else -step)
    slope = (roots[near[1]] - roots[near[0]]) / (depths[near[1]] - depths[near[0]])
    there = depths[near[0]] + (goal - roots[near[0]]) / slope if slope > 0.0 else np.inf
    if np.isfinite(high) and np.isfinite(low):
        return there if low < there < high else 0.5 * (low + high)
    return min(there, low + step) if np.isfinite(low) else max(there, high - step)


def _ahead(body: Bonded, seen: Sequence[tuple[float, float, State]], sunk: float) -> State | None:
    """Return the state that the two nearest depths in contact lead to at another; the nearest one where cells invert."""
    order = sorted(seen, key=lambda each: abs(each[0] - sunk))
    if not order:
        return None
    (b, force, last), *others = order
    before = next((each for each in others if each[1] > 0.0), None)
    if before is None or force == 0.0:
        return last
    share = (sunk - b) / (b - before[0])
    pairs = zip((last.u, last.q, last.p), (before[2].u, before[2].q, before[2].p), strict=True)
    u, q, p = (own + share * (own - old) for own, old in pairs)
    u[body.bonded] = body.with_target(q)
    least = smallest_volume(body, u, everywhere=False)
    return replace(last, u=u, q=q, p=p, min_J=least, known=None) if least > 0.0 else last


def advance(
    body: Bonded, start: State, path: Path, rule: Callable[..., Walk] | None = None, **options: float
) -> Outcome:
    """Follow a path from a state at rest under its first goal by a rule; ``reached == path.legs`` at the end.

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
        walk.end = leg if there > leg or isclose(there, leg) else there
        found = walk.rest(path.goal(walk.end))
        found = judged(walk.body, path, found) if walk.judges else found
        spent = walk.here.iterations + found.state.iterations
        walk.here = replace(walk.here if found.reason else found.state, iterations=spent)
        if not found.reason:
            walk.lengthen(found)
            walk.at, walk.hidden = walk.end, found.hidden
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
