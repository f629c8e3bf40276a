"""Follow a load on the first two levels of a family: what it comes to, or where its path ends.

The first level follows the path, the second comes to rest under the same load, or follows it as far. A limit that the
first one found gets its error from the second. Where the second level cannot follow a load that the first one carries,
it may come to rest from there, cells at rims eliminated (equilibrium/elimination.py).
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.equilibrium.body import Bonded, State, rest
from sits_mech.mechanics.equilibrium.control import Control, Scales
from sits_mech.mechanics.equilibrium.newton import (
    MOST,
    Way,
    approached,
    newton,
    smallest_eigenvalue,
    target_stiffness,
    unloaded,
    verdict,
)
from sits_mech.mechanics.equilibrium.outcome import Outcome, PathEnd, carried
from sits_mech.mechanics.equilibrium.path import follow, iteration_seconds
from sits_mech.mechanics.levels.answer import aim, answer, largest_stretch, law_notes, starts
from sits_mech.mechanics.levels.family import Levels, Line, prolonged
from sits_mech.memory import check_seconds, latest
from sits_mech.notes import Note
from sits_mech.quantities import WRENCH, Array, Equilibrium, Pose, SolveReport, Wrench

VERDICT = 60
"""Iterations that the finer mesh is given to locate a limit that the coarse one has found."""

_LOOK = 2e-2  # smallest length of the path on the coarse mesh, over that so far
_LAST = 25  # iterations where it has found none, for a last state
_SETTLES = 1e-3  # of the target's way, a step of the finer mesh from which plain ones go on
_UPRIGHT = 0.5  # of the stiffness without load; levels differ by 0.03 of it at most (test_answer.py)


class Solved(NamedTuple):
    """The last equilibrium on the path, the fraction of the path it stands at, and what ended the path."""

    found: Equilibrium
    part: float
    reason: PathEnd = PathEnd.NONE
    carried: tuple[Wrench, Wrench] | None = None  # largest load and its error, if limited
    limit: tuple[float, float] | None = None  # the same as a fraction of the path, with its error
    laws: tuple[Note, ...] = ()  # notes on the silicone's law in the farthest state of the coarse mesh
    seen: float = 1.0  # fraction of the path the coarse mesh got to


def first_look(
    line: Line, levels: Levels, start: Equilibrium | None, control: Control, share: float = 1.0
) -> Outcome:
    """Follow the path, or a share of it, on the coarse mesh alone."""
    for level in (0, 1):
        levels.check_memory(level)
    check_seconds(MOST * iteration_seconds(levels.fine), f"a load on a mesh of {len(levels.fine.free)} unknowns")
    state, (held, end) = _begun(levels, line.scales, start, 0), aim(levels.coarse, line.scales, control)
    begin = np.where(held, state.q, state.load)
    end = (1.0 - share) * begin + share * end
    return follow(levels.coarse, state, (begin, end), smallest=_LOOK, held=held, out_of_plane=control.held[3:])


def solve_levels(
    line: Line, levels: Levels, start: Equilibrium | None, control: Control, first: Outcome, second: Outcome | float
) -> Solved:
    """Follow the path on the first two levels of a line's family, then refine until the error is as asked of the line.

    Without `start` the path begins at rest; `first` is the result of `first_look`; `second` is that of the finer mesh,
    or the least increment of its path. A limit found on the coarse mesh gets its error from the finer one within a few
    iterations.
    """
    scales, (held, end) = line.scales, aim(levels.fine, line.scales, control)
    coarse_start = _begun(levels, scales, start, 0)
    begin = np.where(held, coarse_start.q, coarse_start.load)
    followed = partial(follow, held=held, out_of_plane=control.held[3:])
    midway = begin + first.reached * (end - begin)
    spend = np.inf if first.reached == 1.0 else _LAST if first.limit is None else VERDICT
    fine, smallest = (second, _LOOK) if isinstance(second, Outcome) else (None, second)
    if fine is None:
        body = levels.fine.plain if _stands(levels, first, control) else levels.fine
        fine = followed(body, _begun(levels, scales, start, 1), (begin, midway), smallest=smallest, most=spend)
    fine = fine.over(0.0, first.reached)
    there, rest_below = fine, first.state
    if first.limit is not None and fine.reached == first.reached:  # and how far beyond?
        left = followed(levels.fine, fine.state, (midway, end), smallest=_LOOK, most=VERDICT)
        there = left.over(first.reached, 1.0)
    elif fine.reached < first.reached:  # both must rest under one goal for the error to mean something
        goal = begin + fine.reached * (end - begin)
        rest_below = followed(levels.coarse, coarse_start, (begin, goal), smallest=smallest).state
    part, limit = fine.reached, carried(first, there)
    reason = (there if there.limit is not None or first.reached == 1.0 else first).reason
    last = line if part == 1.0 else replace(line, deepest=2)
    found = answer(last, levels, control, (rest_below, fine.state))
    if part == 1.0:
        given = {name: value for name in WRENCH if (value := getattr(control, name)) is not None}
        found = replace(found, wrench=replace(found.wrench, **given))
    load = None if limit is None else largest_load(line, levels.fine, control, found, limit, begin)
    laws = law_notes(line.sensor, largest_stretch(levels.coarse, first.state.u, apart=0.0)) if part < 1.0 else ()
    return Solved(found, part, reason, load, limit, laws, first.reached)


def from_first(line: Line, levels: Levels, control: Control, first: Outcome) -> Outcome | None:
    """Return the second level's rest from that of the first, cells at rims eliminated; None where it does not rest."""
    body, (held, goal) = levels.fine, aim(levels.fine, line.scales, control)
    start = None if body.patch is None else prolonged(levels, 1, first.state)
    enough = _SETTLES * body.length(first.state.q)
    near = None if start is None else approached(body, start, goal, held, enough, eliminating=True)
    if near is None:
        return None
    found = newton(body, replace(near.state, iterations=0), goal, held)
    said = verdict(body, Way(0.0 * goal, goal, held, control.held[3:]), found)
    spent = near.state.iterations + found.state.iterations
    return None if said.reason else Outcome(replace(found.state, min_J=said.min_J, iterations=spent), 1.0)


def own_start(levels: Levels, number: int, start: Equilibrium | None) -> Equilibrium | None:
    """Return the start, without its number, if it is on the same family of meshes."""
    if start is None or start.state.size != 1 + levels.size or start.state[0] != number:
        return None
    return replace(start, state=start.state[1:])


def last_rest(line: Line, number: int, state: State, iterations: int) -> Equilibrium:
    """Return the last rest on one mesh of a path that ended, its error as large as the displacement."""
    scales, k = line.scales, len(state.q)
    body = line[number].maker(int(state.u.size != line[number].coarse.mesh.nodes.size))
    lever = body.reach(scales.thickness)
    size = float(np.max(np.abs(state.q * scales.lengths[:k]) * lever[:k]))
    error = Pose.of(np.where(np.arange(6) < k, size / lever, 0.0))
    stretch = largest_stretch(body, state.u)
    report = SolveReport("", state.u.size, iterations, state.residual, 1.0, 0.0, min_J=state.min_J, stretch=stretch)
    return Equilibrium(scales.wrench(state.load), scales.pose(state.q), error, np.array([float(number)]), report)


def _stands(levels: Levels, first: Outcome, control: Control) -> bool:
    """Whether the first level is so far from falling out of its symmetry that the second need not be asked."""
    if not (first.reached == 1.0 and np.isfinite(first.hidden)):
        return False
    return first.hidden >= _UPRIGHT * smallest_eigenvalue(_hidden_at_rest(levels), control.held[3:])


@latest(1, owned=True)
def _hidden_at_rest(levels: Levels) -> Array:
    """Return the stiffness of the undeformed first level on motions that symmetry hides, (3, 3); zero for none."""
    found = target_stiffness(levels.coarse, rest(levels.coarse))[1]
    return np.zeros((3, 3)) if found is None else found


def largest_load(
    line: Line, body: Bonded, control: Control, found: Equilibrium, limit: tuple[float, float],
    begin: Array | float = 0.0,
) -> tuple[Wrench, Wrench]:
    """Return the largest load and its error; with places given, the forces of the last equilibrium.

    `limit`: that as a part of the path from `begin` to the control's goal, with its error.
    """
    scales, (held, end) = line.scales, aim(body, line.scales, control)
    there = scales.load(found.wrench)[: body.components]
    load, way_off = np.where(held, there, begin + limit[0] * (end - begin)), np.abs(end - begin)
    return scales.wrench(load), scales.wrench(np.where(held | (way_off == 0.0), 0.0, limit[1] * way_off))


def _begun(levels: Levels, scales: Scales, start: Equilibrium | None, level: int) -> State:
    """Return the start on one of the first two levels: an equilibrium, or the unloaded state."""
    return unloaded(levels.maker(level)) if start is None else starts(levels, scales, start)[1 - level]
