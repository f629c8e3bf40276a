"""Follow a load on the first two levels of a family: what it comes to, or where its path ends.

The first level follows the path, the second comes to rest under the same load, or follows it as far. A limit that the
first one found gets its error from the second. Where the second level cannot follow a load that the first one carries,
it may come to rest from there, cells at rims eliminated (equilibrium/elimination.py). Where only the first level
buckles, or turns, levels two and three take the place of the pair: pulls stretch coarse cells so far.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.equilibrium.body import Bonded, State, rest
from sits_mech.mechanics.equilibrium.control import Control
from sits_mech.mechanics.equilibrium.newton import (
    MOST,
    iteration_seconds,
    judged,
    newton,
    smallest_eigenvalue,
    target_stiffness,
)
from sits_mech.mechanics.equilibrium.outcome import Outcome, Path, PathEnd, carried
from sits_mech.mechanics.equilibrium.path import advance, unloaded
from sits_mech.mechanics.levels.answer import (
    extrapolated_equilibrium,
    law_notes,
    layer_stretch,
    scaled_control,
    starts,
    whole_error,
)
from sits_mech.mechanics.levels.family import Levels, Line
from sits_mech.mechanics.levels.refine import nearly_at_rest
from sits_mech.memory import check_seconds, latest
from sits_mech.notes import Note
from sits_mech.quantities import Array, Equilibrium, SolveReport, Wrench

VERDICT = 60
"""Iterations that the finer mesh is given to locate a limit that the coarse one has found."""

_LOOK = 2e-2  # smallest length of the path on the coarse mesh, over that so far
_LAST = 25  # iterations where it has found none, for a last state
_SETTLES = 1e-3  # step over the target's displacement from which plain Newton steps go on, on the finer mesh
_UPRIGHT = 0.5  # of the stiffness without load; levels differ by 0.03 of it at most (test_answer.py)


class Pair(NamedTuple):
    """The first two levels of a family at rest on the path to a load, as far as both carry it."""

    number: int  # of the family
    states: tuple[State, State]  # of the first level and the second, under one load
    first: Outcome  # of the first level on its path
    second: Outcome  # of the second, as far as it was followed
    part: float = 1.0  # of the path at which the states are
    reason: PathEnd = PathEnd.NONE
    limit_point: tuple[float, float] | None = None  # largest load as a fraction of the path, with its error, if any
    begin: Array | float = 0.0  # of the path: load, or place where held, (k,)


class Solved(NamedTuple):
    """The last equilibrium on the path, the fraction of the path it stands at, and what ended the path."""

    found: Equilibrium
    part: float
    reason: PathEnd = PathEnd.NONE
    carried: tuple[Wrench, Wrench] | None = None  # largest load and its error, if limited
    limit_point: tuple[float, float] | None = None  # the same as a fraction of the path, with its error
    laws: tuple[Note, ...] = ()  # notes on the silicone's law in the farthest state of the coarse mesh
    coarse_part: float = 1.0  # fraction of the path the coarse mesh got to


def first_look(line: Line, number: int, start: Equilibrium | None, control: Control, share: float = 1.0) -> Outcome:
    """Follow the path, or a share of it, on a family's coarse mesh alone."""
    levels = line[number]
    for level in (0, 1):
        levels.check_memory(level)
    check_seconds(MOST * iteration_seconds(levels.fine), f"a load on a mesh of {len(levels.fine.free)} unknowns")
    state, (held, end) = _begun(line, number, start, 0), scaled_control(levels.coarse, line.scales, control)
    begin = np.where(held, state.q, state.load)
    end = (1.0 - share) * begin + share * end
    return advance(levels.coarse, state, Path((begin, end), held, control.held[3:]), smallest=_LOOK)


def second_look(
    line: Line, number: int, start: Equilibrium | None, control: Control, first: Outcome, smallest: float
) -> Pair:
    """Follow the path on the second level, too, as far as the first got; the states of both are under one load.

    Without `start`, or with one on another family, the path begins at rest; `first` is the result of `first_look`;
    `smallest` the least increment. A limit found on the coarse mesh gets its error from the finer one within a few
    iterations.
    """
    levels, coarse_start = line[number], _begun(line, number, start, 0)
    held, end = scaled_control(levels.fine, line.scales, control)
    begin = np.where(held, coarse_start.q, coarse_start.load)
    path, midway = partial(Path, held=held, out_of_plane=control.held[3:]), begin + first.reached * (end - begin)
    spend = np.inf if first.reached == 1.0 else _LAST if first.limit_point is None else VERDICT
    body = levels.fine.plain if _stands(levels, first, control) else levels.fine
    fine = advance(body, _begun(line, number, start, 1), path((begin, midway)), smallest=smallest, most=spend)
    fine = fine.over(0.0, first.reached)
    there, rest_below = fine, first.state
    if first.limit_point is not None and fine.reached == first.reached:  # and how far beyond?
        left = advance(levels.fine, fine.state, path((midway, end)), smallest=_LOOK, most=VERDICT)
        there = left.over(first.reached, 1.0)
    elif fine.reached < first.reached:  # both must rest under one load for the error to mean something
        stop = begin + fine.reached * (end - begin)
        rest_below = advance(levels.coarse, coarse_start, path((begin, stop)), smallest=smallest).state
    why = (there if there.limit_point is not None or first.reached == 1.0 else first).reason
    return Pair(number, (rest_below, fine.state), first, there, fine.reached, why, carried(first, there), begin)


def from_first(line: Line, number: int, control: Control, first: Outcome) -> Pair | None:
    """Bring the second level to rest from the first level's; None where it does not rest."""
    levels, (held, end) = line[number], scaled_control(line[number].fine, line.scales, control)
    found = _from_before(levels, first.state, Path((0.0 * end, end), held, control.held[3:]))
    return None if found is None else Pair(number, (first.state, found.state), first, found)


def beyond_first(line: Line, control: Control, pair: Pair) -> Pair | None:
    """Bring the second and the third level to rest under a load at which the first one alone is unstable.

    `pair`: of the first two, at the largest load of the first. From there the third level goes on; None where it does
    not get to the load, or there is none.
    """
    number = line.without_first(pair.number)
    if number is None:
        return None
    levels, (held, end) = line[number], scaled_control(line[number].fine, line.scales, control)
    path = partial(Path, held=held, out_of_plane=control.held[3:])
    midway = pair.begin + pair.part * (end - pair.begin)
    found = _from_before(levels, pair.states[1], path((0.0 * end, midway)))
    begun = (unloaded(levels.fine), 0.0 * end) if found is None else (replace(found.state, iterations=0), midway)
    there = advance(levels.fine, begun[0], path((begun[1], end)), smallest=_LOOK)
    return None if there.reason else Pair(number, (pair.second.state, there.state), pair.second, there)


def _from_before(levels: Levels, state: State, path: Path) -> Outcome | None:
    """Bring the second level to rest from a state of the first, cells at rims eliminated; None where it does not rest.

    The state is at the end of the path.
    """
    body, end, held = levels.fine, path.corners[-1], path.held
    enough = _SETTLES * body.length(state.q)
    near = None if body.patch is None else nearly_at_rest(levels, 1, state, (held, end), enough)
    if near is None or near.reason:
        return None
    found = judged(body, path, newton(body, replace(near.state, iterations=0), end, held)).after(near)
    return None if found.reason else found


def refined_answer(line: Line, pair: Pair, control: Control) -> Solved:
    """Return the equilibrium of two levels, refined as asked of the line if they got to the end of their path."""
    whole, levels = pair.part == 1.0, line[pair.number]
    found = extrapolated_equilibrium(line if whole else replace(line, deepest=2), pair.number, control, pair.states)
    if whole:
        found = replace(found, wrench=replace(found.wrench, **control.forces))
    there = pair.limit_point
    load = None if there is None else largest_load(line, levels.fine, control, found, there, pair.begin)
    laws = () if whole else law_notes(line.sensor, layer_stretch(levels.coarse, pair.first.state.u, apart=0.0).each)
    return Solved(found, pair.part, pair.reason, load, there, laws, pair.first.reached)


def own_start(line: Line, number: int, start: Equilibrium | None) -> Equilibrium | None:
    """Return a start if it is on a family's meshes."""
    own = start is not None and start.state.size == 1 + line[number].size and start.state[0] == number
    return start if own else None


def _begun(line: Line, number: int, start: Equilibrium | None, level: int) -> State:
    """Return the start on one of the first two levels: an equilibrium of the same family, or the unloaded state."""
    own, levels = own_start(line, number, start), line[number]
    there = None if own is None else starts(levels, line.scales, own.wrench, own.state)[1 - level]
    return there if there is not None and there.min_J > 0.0 else unloaded(levels.maker(level))


def last_rest(line: Line, number: int, state: State) -> Equilibrium:
    """Return the last rest on one mesh of a path that ended, its error as large as the displacement."""
    scales, body = line.scales, line[number].maker(int(state.u.size != line[number].coarse.mesh.nodes.size))
    error = whole_error(body, scales, state.q * scales.lengths[: len(state.q)])
    spent, stretch = state.iterations, layer_stretch(body, state.u).value
    report = SolveReport("", state.u.size, spent, state.residual, 1.0, 0.0, min_J=state.min_J, stretch=stretch)
    return Equilibrium(scales.wrench(state.load), scales.pose(state.q), error, np.array([float(number)]), report)


def _stands(levels: Levels, first: Outcome, control: Control) -> bool:
    """Whether the first level is so stable against falling sideways that the second need not be checked."""
    if not (first.reached == 1.0 and np.isfinite(first.hidden)):
        return False
    return first.hidden >= _UPRIGHT * smallest_eigenvalue(_hidden_at_rest(levels), control.held[3:])


@latest(1, owned=True)
def _hidden_at_rest(levels: Levels) -> Array:
    """Return the stiffness of the undeformed first level on motions that symmetry hides, (3, 3); zero for none."""
    found = target_stiffness(levels.coarse, rest(levels.coarse))[1]
    return np.zeros((3, 3)) if found is None else found


def largest_load(
    line: Line, body: Bonded, control: Control, found: Equilibrium, limit_point: tuple[float, float],
    begin: Array | float = 0.0,
) -> tuple[Wrench, Wrench]:
    """Return the largest load and its error; with places given, the forces of the last equilibrium.

    `limit_point`: that as a part of the path from `begin` to the control, with its error.
    """
    scales, (held, end) = line.scales, scaled_control(body, line.scales, control)
    there = scales.load(found.wrench)[: body.components]
    load, way_off = np.where(held, there, begin + limit_point[0] * (end - begin)), np.abs(end - begin)
    return scales.wrench(load), scales.wrench(np.where(held | (way_off == 0.0), 0.0, limit_point[1] * way_off))
