"""Advance a layer with memory in time: rest under the energy that its past and the time step make.

Inertia plays no part: at every time the layer is at rest, and what depends on time are the silicone's points alone
(silicone/histories/points.py). A step of time changes their energies once, as if between two loads another law were
put in; the rest under the new load is then found as it is for an elastic layer, along a path of loads (path.py), or
with friction in increments (increments.py). The points remember what they come to.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from sits_mech.mechanics.element.kernel import kinematics
from sits_mech.mechanics.rest.body import Bonded, State, deformed_state
from sits_mech.mechanics.rest.increments import followed, rough
from sits_mech.mechanics.rest.linearisation import Held
from sits_mech.mechanics.rest.newton import unloaded
from sits_mech.mechanics.rest.path import follow
from sits_mech.quantities import Array
from sits_mech.silicone.histories.points import Memory, remembered, stepped, virgin

_SMALLEST = 2e-2  # step of the path to a new load, over the path so far
_PARTS = 4  # increments of a step with friction
_MOST = 100  # iterations of a step


@dataclass(frozen=True)
class Moment:
    """A layer at rest at a time, with the memory of its points."""

    state: State
    memory: Memory


def begun(body: Bonded) -> Moment:
    """Return a virgin layer, or one long at its present temperature."""
    shape, components = body.mesh.inside.weights.shape, 9 if len(body.mesh.axes) == 3 else 5
    memory, state = virgin(body.law.silicone, shape, components), unloaded(body)
    if body.swelling == 1.0:
        return Moment(state, memory)
    known = deformed_state(body, state)
    return Moment(replace(state, known=known), remembered(body.law.silicone, memory, np.inf, kinematics(known.F)))


def later(
    body: Bonded, now: Moment, dt: float, goal: Array, *, held: Held | None = None, beside: Held | None = None
) -> tuple[Moment | None, str]:
    """Return the layer a step `dt` [s] later, under a load that changes linearly, and "" or why there is none.

    ``dt = 0`` is a sudden load; `goal` (k,) as in `follow`, scaled, like `held` and `beside`.
    """
    silicone = body.law.silicone
    law = body.law.after(stepped(silicone, now.memory, dt))
    aged = replace(body, law=law, shared=cache(lambda: body.pattern))
    goals = (now.state.load, goal)
    if rough(body):
        track = followed(aged, now.state, goals, _PARTS, held=held, beside=beside)
        state, reason = track.state, track.reason
    else:
        start = replace(now.state, iterations=0)
        found = follow(aged, start, goals, smallest=_SMALLEST, held=held, beside=beside, most=_MOST)
        state, reason = found.state, found.reason
    if reason:
        return None, reason
    known = deformed_state(body, state)
    return Moment(replace(state, known=known), remembered(silicone, now.memory, dt, kinematics(known.F))), ""
