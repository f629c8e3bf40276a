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
from fractions import Fraction
from functools import cache

import numpy as np

from sits_mech.mechanics.element.kernel import kinematics
from sits_mech.mechanics.equilibrium.body import Bonded, State, deformed_state
from sits_mech.mechanics.equilibrium.linearisation import Held
from sits_mech.mechanics.equilibrium.newton import SETTLED, Way, unloaded, verdict
from sits_mech.mechanics.equilibrium.outcome import Outcome, PathEnd
from sits_mech.mechanics.equilibrium.path import affordable, among_faces, follow
from sits_mech.mechanics.faces.contact import Contact, Grip, gripped
from sits_mech.quantities import Array
from sits_mech.silicone.points import Memory, remembered, stepped, virgin

_SLIP = 2e-3  # thicknesses over the number of increments of a leg: elastic slip before a point slides
_SAME = 1e-3  # of the pressures on a surface, by which they may still change
_PASSES = 12  # solutions of an increment with other points that stick or slip, at most
_SMALLEST = Fraction(1, 16)  # of an increment, below which a path is given up
_SHORTEST = 2e-2  # step of the path to a new load, over the path so far
_PARTS = 4  # increments of a step with friction


def followed(
    body: Bonded, start: State, goals: Sequence[Array], parts: int, *, held: Held | None = None,
    out_of_plane: Held | None = None,
) -> Outcome:
    """Follow a path of loads with friction from a state at rest under the first goal, with its tractions.

    `goals` (k,) are forces at the start, at each load passed, at the end, or places where `held`; `parts` increments a
    leg; `held` and `out_of_plane` as in `follow`.
    """
    held = np.zeros(body.components, dtype=bool) if held is None else held
    way = Way(goals[0], goals[-1], held, out_of_plane)
    states, at, step = [start], Fraction(0), Fraction(1, parts)
    left = affordable(body, 0.5 * (len(goals) - 1))  # half the limit for each leg
    while at < len(goals) - 1:
        if left <= 0:
            return Outcome(states[-1], float(at), PathEnd.LONG, states=tuple(states))
        leg = int(at)
        end = min(at + step, Fraction(leg + 1))
        share = float(end - leg)
        goal = (1.0 - share) * goals[leg] + share * goals[leg + 1]
        body, found = _increment(body, states[-1], way, goal, _SLIP / parts)
        left -= found.iterations
        if found.reason:
            step /= 2
            if step < _SMALLEST / parts:
                return Outcome(states[-1], float(at), found.reason, states=tuple(states))
            continue
        states, at = [*states, found.state], end
        step = min(2 * step, Fraction(1, parts))
    return Outcome(states[-1], float(at), states=tuple(states))


def _increment(body: Bonded, here: State, way: Way, goal: Array, slip: float) -> tuple[Bonded, Outcome]:
    """Find the rest at the end of an increment; return also the body with the faces that met."""
    before = _looked_at(body, here)
    tractions = here.grip or tuple(np.zeros_like(place) for place, _, _ in before)
    starts = [(place, traction) for (place, _, _), traction in zip(before, tractions, strict=True)]
    seen, pressures, spent, guess = before, [p for _, p, _ in before], 0, here
    for _ in range(_PASSES):
        grips = [
            gripped(part.friction * p, start, normal, slip)
            for part, p, start, (_, _, normal) in zip(rough(body), pressures, starts, seen, strict=True)
        ]
        for begin in (guess, here):  # from its beginning points come out of sticking, which is the surer way
            body, found = among_faces(_with(body, grips), replace(begin, iterations=0), goal, way.held)
            spent += found.state.iterations
            if found.state.residual <= SETTLED:
                break
        if not found.state.residual <= SETTLED:
            return body, Outcome(replace(here, iterations=spent), 0.0, PathEnd.LOST)
        guess, seen = found.state, _looked_at(body, found.state)
        new = [p for _, p, _ in seen]
        weights = [part.surface.weight.ravel() for part in rough(body)]
        each = zip(weights, pressures, new, strict=True)
        if all(float(w @ np.abs(own - p)) <= _SAME * float(w @ own) for w, p, own in each):
            said = verdict(body, way, found)
            grip = tuple(own.traction(place) for own, (place, _, _) in zip(grips, seen, strict=True))
            state = replace(guess, iterations=spent, min_J=said.min_J, grip=grip)
            return body, Outcome(state, 1.0, said.reason)
        pressures = new
    return body, Outcome(replace(here, iterations=spent), 0.0, PathEnd.SLIPPING)


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
    memory: Memory


def begun(body: Bonded) -> Moment:
    """Return a virgin layer, or one long at its present temperature."""
    shape, components = body.mesh.inside.weights.shape, 9 if len(body.mesh.axes) == 3 or body.mesh.hoop else 5
    memory, state = virgin(body.law.silicone, shape, components), unloaded(body)
    if body.swelling == 1.0:
        return Moment(state, memory)
    known = deformed_state(body, state)
    return Moment(replace(state, known=known), remembered(body.law.silicone, memory, np.inf, kinematics(known.F)))


def later(
    body: Bonded, now: Moment, dt: float, goal: Array, *, held: Held | None = None
) -> tuple[Moment | None, PathEnd]:
    """Return the layer a step `dt` [s] later, under a load that changes linearly, or why there is none.

    ``dt = 0`` is a sudden load; `goal` (k,) as in `follow`, scaled, like `held`.
    """
    silicone = body.law.silicone
    law = body.law.after(stepped(silicone, now.memory, dt))
    aged = replace(body, law=law, shared=cache(lambda: body.pattern))
    goals = (now.state.load, goal)
    if rough(body):
        found = followed(aged, now.state, goals, _PARTS, held=held)
    else:
        found = follow(aged, replace(now.state, iterations=0), goals, smallest=_SHORTEST, held=held)
    if found.reason:
        return None, found.reason
    state = found.state
    known = deformed_state(body, state)
    return Moment(replace(state, known=known), remembered(silicone, now.memory, dt, kinematics(known.F))), PathEnd.NONE
