"""Refine what is asked of a layer on the levels of a family (family.py), one after the other, until it is as wanted.

    levels --(measured on one after the other)--> values --(as wanted?)--> answer, or the next level

So a pose is refined (answer.py), a history of poses (in_time.py) and a compliance (linear.py): who asks takes the
values of `refinements` until they will do.

The first two levels are brought to rest (equilibrium/path.py). On finer ones Newton steps from the state of the level
before, cells at rims eliminated (equilibrium/elimination.py), end when the target no longer moves. If cells at rims
cannot follow, the level is left out. With contact or a guard steps go down the potential, from rest where a cell
of that state would be turned inside out. Corners need not come to rest: the iteration also ends where the next step
would turn one inside out, and how far the last step moved the target is in the error.

A level is solved if its terms promise the error asked or 0.7 of the present one (what came then was 0.5 to 0.6). So one
that divides all cells but those at the edge is left out where the edge's term is the error; in space also one whose
rims would crease.

Source: J. Xu, SIAM J. Numer. Anal. 33 (1996) 1759, Newton steps from coarse solutions.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from typing import TypeVar

import numpy as np

from sits_mech.mechanics.element.kernel import deformation
from sits_mech.mechanics.equilibrium.body import State
from sits_mech.mechanics.equilibrium.elimination import relaxed
from sits_mech.mechanics.equilibrium.newton import Steps, affordable, newton
from sits_mech.mechanics.equilibrium.outcome import Outcome, Path
from sits_mech.mechanics.equilibrium.path import advance, unloaded
from sits_mech.mechanics.levels.family import Levels
from sits_mech.quantities import Array, Mask

_Measured = TypeVar("_Measured")
_FURTHER = 0.04  # of the limit of time: what a path beyond the second level may take
_NEAR, _AT_END = 0.05, 0.01  # of the size of the load: forces in a patch at which its boundary moves on, and at its end
_ENOUGH = 0.05  # of the difference of two levels: a correction that is closer is not gone on with


def refinements(levels: Levels, values: Iterator[_Measured], most: int) -> Iterator[list[_Measured]]:
    """Yield the values of the first two levels, then those of one more each time, of at most `most`.

    It ends where `values` do, or memory. Raise ValueError where that does not hold the first two.
    """
    for level in (0, 1):
        levels.check_memory(level)
    found = list(islice(values, 2))
    yield found
    for level in range(2, most):
        if levels.check_memory(level) or (there := next(values, None)) is None:
            return
        found.append(there)
        yield found


def prolonged(levels: Levels, level: int, state: State) -> State | None:
    """Carry a state from the level before; None without a carrier, or where a cell would be turned inside out.

    Where cells at rims are cut, volume is kept in the coarse cell, not in its parts: those are brought to rest between
    the others (equilibrium/elimination.py).
    """
    way, body = levels.carrier(level), levels.maker(level)
    if way is None:
        return None
    u, p = np.asarray(way.displacements(state.u)), way.pressures(state.p)
    u[body.bonded] = body.with_target(state.q)
    if body.cut is not None and (patch := body.patch) is not None:
        size, begun = float(np.linalg.norm(state.load)), unloaded(body)
        found = relaxed(body, patch, (begun.u, begun.p[patch.cells]), u, (_NEAR * size, _AT_END * size))
        if found.part < 1.0:
            return None
        u[patch.inner], p[patch.cells] = found.u[patch.inner], found.p
    least = float(deformation(body.mesh, u)[1].min())
    return State(u, state.q, p, state.load, min_J=least) if least > 0.0 else None


def nearly_at_rest(
    levels: Levels, level: int, before: State | None, aim: tuple[Mask, Array], enough: float
) -> Outcome | None:
    """Bring a target nearly to rest on a level, its last step at most `enough`; a body finds it once.

    From a state of the level before, cells at rims eliminated, None where it cannot be carried; from rest, or of a
    cover that is pressed on, down the potential.
    """
    body, (held, end), falling = levels.maker(level), aim, before is None or levels.fine.press is not None
    steps = Steps(falling=falling, eliminating=not falling, enough=enough)
    name = body.name_of(before or unloaded(body), aim, steps)
    known: Outcome | None = body.rests.get(name)
    if known is not None:
        return known
    start = None if before is None else prolonged(levels, level, before)
    if start is None and falling:
        start = unloaded(body)
    return None if start is None else body.keep(name, newton(body, start, end, held, steps=steps))


def later_rests(
    levels: Levels, states: tuple[State, State], aim: tuple[Mask, Array], given: bool
) -> Iterator[Outcome]:
    """Yield the target's rest on the third level and beyond, as far as they are reached.

    `states` are those of the first two levels; `given`: the target is moved, not loaded, so that its forces depend on
    every corner, and all must come to rest, but where a cover is pressed on.
    """
    before, state = states
    for level in range(2, min(levels.rested, len(levels))):
        body, all_of_it = levels.maker(level), given and levels.fine.press is None
        enough = None if all_of_it else _ENOUGH * body.length(state.q - before.q)
        for found in _tries(levels, level, state, aim, enough):
            if found is not None and not found.reason:
                break
        else:
            return
        state, before = replace(found.state, known=None), state
        yield replace(found, state=state)
        if body.length(found.off) > (enough or 0.0):  # finer cells settle later still
            return


def _tries(
    levels: Levels, level: int, state: State, aim: tuple[Mask, Array], enough: float | None
) -> Iterator[Outcome | None]:
    """Yield what comes of a level, each way where those before it fail; without `enough` at rest at every corner.

    From the level before, which is all of a cover that is pressed on; down the potential where no cells at rims are
    eliminated; along a path, in space only to rest at every corner: there it is too long.
    """
    body, (held, end) = levels.maker(level), aim
    if enough is not None:
        yield nearly_at_rest(levels, level, state, aim, enough)
    if levels.fine.press is None:
        if enough is not None and not body.patch:
            yield nearly_at_rest(levels, level, None, aim, enough)
        if enough is None or len(body.mesh.axes) == 2:
            there = advance(body, unloaded(body), Path((0.0 * end, end), held), most=affordable(body, _FURTHER))
            yield replace(there, off=0.0 * end)
