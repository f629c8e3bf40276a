"""Follow a layer with friction along a path of loads, increment by increment, each from the end of the last.

The path goes straight from load to load, each leg of it in a number of equal increments. In each of them the potential
of the layer with friction (faces/contact.py) is brought to rest by Newton's method, with the pressures p of the
contacts as they were at its beginning, then with those found, pass by pass, until

    sum w |p_new - p|  <=  1e-3 sum w p_new

on every surface, w the areas of its points. Newton's method goes on from the pass before, or else from the increment's
beginning, where no point has slipped yet. The elastic slip s_0 goes down with the number of increments, so that one
comparison of two numbers tells of both. An increment whose passes do not settle, or that comes to no rest that counts
(newton.py), is halved. Tractions and places at its end are the beginning of the next one. The method is of first order
in the increments: twice as many halve what is left (measured: tests). Source: J. C. Simo, T. A. Laursen, Comput.
Struct. 42 (1992) 97, increments of frictional contact.

A layer with memory advances in time by the rest under the energy that its past and the time step make. Inertia plays no
part: at every time the layer is at rest, and what depends on time are the silicone's points alone
(silicone/points.py). A step of time changes their energies once, as if between two loads another law were put
in; the rest under the new load is then found as it is for an elastic layer, along a path of loads (path.py), or with
friction in increments. The points remember what they come to.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from sits_mech.mechanics.element.kernel import kinematics
from sits_mech.mechanics.equilibrium.body import Bonded, State, deformed_state
from sits_mech.mechanics.equilibrium.newton import affordable
from sits_mech.mechanics.equilibrium.outcome import Outcome, Path, PathEnd
from sits_mech.mechanics.equilibrium.path import Walk, advance, unloaded
from sits_mech.mechanics.faces.contact import Contact, Grip, gripped
from sits_mech.quantities import Array, Mask
from sits_mech.silicone.points import PointMemory, past_after, remembered, virgin

_SLIP = 2e-3  # thicknesses over the number of increments of a leg: elastic slip before a point slides
_SAME = 1e-3  # of the pressures on a surface, by which they may still change
_PASSES = 12  # solutions of an increment with other points that stick or slip, at most
_SHORTEST = 2e-2  # step of the path to a new load, over the path so far
_PARTS = 4  # increments of a step with friction


class Friction(Walk):
    """Legs in equal increments with friction, each from the end of the last; the start has its tractions.

    `parts`: increments of a leg. Half the limit of time is for each leg.
    """

    def __init__(self, body: Bonded, start: State, path: Path, *, parts: int) -> None:
        super().__init__(body, start, path, step=1.0 / parts, most=affordable(body, 0.5 * path.legs))
        self.slip = _SLIP / parts

    def rest(self, end: Array, start: State | None = None, body: Bonded | None = None) -> Outcome:
        """Return the rest at the end of an increment, whose pressures are those that its slip was limited by."""
        here, before = self.here, _looked_at(self.body, self.here)
        tractions = here.grip or tuple(np.zeros_like(place) for place, _, _ in before)
        starts = [(place, traction) for (place, _, _), traction in zip(before, tractions, strict=True)]
        seen, pressures, spent, guess = before, [p for _, p, _ in before], 0, here
        for _ in range(_PASSES):
            grips = [
                gripped(part.friction * p, begin, normal, self.slip)
                for part, p, begin, (_, _, normal) in zip(rough(self.body), pressures, starts, seen, strict=True)
            ]
            for first in (guess, here):  # from its beginning points come out of sticking, which is the surer way
                found = super().rest(end, replace(first, iterations=0), _with(self.body, grips))
                spent += found.state.iterations
                if not found.reason:
                    break
            if found.reason:
                return Outcome(replace(here, iterations=spent), 0.0, PathEnd.LOST)
            guess, seen = found.state, _looked_at(self.body, found.state)
            new = [p for _, p, _ in seen]
            weights = [part.surface.weight.ravel() for part in rough(self.body)]
            each = zip(weights, pressures, new, strict=True)
            if all(float(w @ np.abs(own - p)) <= _SAME * float(w @ own) for w, p, own in each):
                grip = tuple(own.traction(place) for own, (place, _, _) in zip(grips, seen, strict=True))
                return replace(found, state=replace(guess, grip=grip, iterations=spent))
            pressures = new
        return Outcome(replace(here, iterations=spent), 0.0, PathEnd.SLIPPING)


def rough(body: Bonded) -> list[Contact]:
    """Return the contacts of a body that have friction."""
    return [part for part in body.parts if isinstance(part, Contact) and part.friction > 0.0]


def _looked_at(body: Bonded, state: State) -> list[tuple[Array, Array, Array]]:
    """Return places, pressures and normals at the points of the contacts with friction."""
    return [part.looked_at(state.u, state.q) for part in rough(body)]


def _with(body: Bonded, grips: Sequence[Grip]) -> Bonded:
    """Give the contacts of a body their friction; the pattern stays."""
    left = iter(grips)
    parts = tuple(
        replace(part, grip=next(left)) if isinstance(part, Contact) and part.friction > 0.0 else part
        for part in body.parts
    )
    shared = body.shared or cache(lambda: body.pattern)
    return replace(body, parts=parts, shared=shared)


@dataclass(frozen=True)
class Moment:
    """A layer at rest at a time, with the memory of its points."""

    state: State
    memories: tuple[PointMemory, ...]  # of each silicone's points


def begun(body: Bonded) -> Moment:
    """Return a virgin layer, or one long at its present temperature."""
    shape, components = body.mesh.inside.weights.shape, 9 if len(body.mesh.axes) == 3 or body.mesh.hoop else 5
    counts, state = [shape[0]] if body.laws.of is None else np.bincount(body.laws.of).tolist(), unloaded(body)
    memories = tuple(
        virgin(law.silicone, (count, *shape[1:]), components)
        for law, count in zip(body.laws.each, counts, strict=True)
    )
    return _moment(body, memories, state, np.inf) if body.laws.swell else Moment(state, memories)


def later(body: Bonded, now: Moment, dt: float, end: Array, held: Mask) -> Moment | PathEnd:
    """Return the layer a step `dt` [s] later, under loads or places that change linearly, or why there is none.

    ``dt = 0`` is a sudden change; `end` (k,) as at the end of a `Path`, scaled, like `held`.
    """
    begin = np.where(held, now.state.q, now.state.load)
    pairs = zip(body.laws.each, now.memories, strict=True)
    laws = body.laws.after([past_after(law.silicone, memory, dt) for law, memory in pairs])
    aged, path = replace(body, laws=laws, shared=cache(lambda: body.pattern)), Path((begin, end), held)
    rule: dict[str, Any] = {"rule": Friction, "parts": _PARTS} if rough(body) else {"smallest": _SHORTEST}
    found = advance(aged, replace(now.state, iterations=0), path, **rule)
    return found.reason or _moment(body, now.memories, found.state, dt)


def _moment(body: Bonded, memories: tuple[PointMemory, ...], state: State, dt: float) -> Moment:
    """Return a state with what its points remember, a step of time after their memories."""
    known, found = deformed_state(body, state), list[PointMemory]()
    for number, (law, memory) in enumerate(zip(body.laws.each, memories, strict=True)):
        F = known.F[body.laws.elements(number)]
        found.append(remembered(law.silicone, memory, dt, kinematics(F)))
    return Moment(replace(state, known=known), tuple(found))
