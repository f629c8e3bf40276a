"""Follow a path of loads with friction, on each level by itself.

Friction depends on the path (faces/contact.py): from rest, through the loads passed, to the last one, straight from
each to the next. No state is taken from another load or a coarser mesh, and no chord closes a gap: every level of a
family follows the whole path (equilibrium/increments.py), and the pose is extrapolated as it is without friction
(answer.py), from two levels, or three where the third is cheap. The number of increments is found on the first level:
it is doubled until that moves the target by less than a share of the tolerance. As the method is of first order, the
change by the last doubling is about the remaining error, and is added to the errors.

Where no free face touches anything under any of the loads, without contact, friction plays no part (settle.py).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import prod

import numpy as np

from sits_mech.mechanics.equilibrium.body import Bonded
from sits_mech.mechanics.equilibrium.control import Control
from sits_mech.mechanics.equilibrium.increments import Friction
from sits_mech.mechanics.equilibrium.outcome import Outcome, Path
from sits_mech.mechanics.equilibrium.path import advance, unloaded
from sits_mech.mechanics.levels.answer import enlarged, extrapolated_equilibrium, scaled_control
from sits_mech.mechanics.levels.family import WALKED, Levels, Line
from sits_mech.mechanics.levels.pair import Solved, last_rest
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array, Pose
from sits_mech.scene.sensor import Sensor

_FIRST, _MOST = 4, 64  # increments of each leg
_SHARE = 0.3  # of the tolerance that the increments may be worth
_CHEAP = 1500  # cells of a level beyond the second


def depends_on_path(sensor: Sensor) -> bool:
    """Whether the equilibrium depends on the load path."""
    return sensor.elastomer is not None and sensor.elastomer.friction > 0.0


def along(line: Line, controls: Sequence[Control]) -> Solved:
    """Return the last equilibrium on a path of loads with friction, from rest to the end, on the family it gets to."""
    found = list[Solved]()
    for number in line.last:
        found.insert(0, _along(line, number, controls))
        if found[0].part == 1.0:
            break
    return max(found, key=lambda each: each.part)


def _along(line: Line, number: int, controls: Sequence[Control]) -> Solved:
    """Return the last equilibrium on the path, on one family of meshes."""
    levels, legs, control = line[number], len(controls), controls[-1]
    for level in (0, 1):
        levels.check_memory(level)
    first, parts, off = _in_increments(line, levels, controls)
    last = first if first.reason else _followed(line, levels.fine, controls, parts)
    if last.reason:
        return Solved(last_rest(line, number, last.state), last.reached / legs, last.reason)
    states, walked = (first.state, last.state), _finer(line, levels, controls, parts)
    found = extrapolated_equilibrium(replace(line, deepest=99, goal=None), number, control, states, walked)
    found = replace(found, wrench=replace(found.wrench, **control.forces))
    error, share = found.error.components, float(np.max(off[1]))
    error[: len(off[0])] += off[0] * line.scales.lengths[: len(off[0])]
    note = Note.of(NoteKind.FRICTION_PATH, legs=legs, parts=parts, change=share)
    return Solved(enlarged(found, Pose.of(error), found.report.estimated_error + share, note), 1.0)


def _in_increments(line: Line, levels: Levels, controls: Sequence[Control]) -> tuple[Outcome, int, Array]:
    """Follow the path on the first level in more and more increments until the tolerance is met.

    Return also their number on each leg, and what the last doubling changed, (2, k): of the motion [thicknesses, rad],
    and over its size.
    """
    body, parts = levels.coarse, _FIRST
    weight, held = body.levers, controls[-1].held[: body.components]
    track, off = _followed(line, body, controls, parts), np.ones((2, body.components))
    while not track.reason and parts < _MOST and not np.max(off[1]) <= _SHARE * line.asked:
        before, parts = track.state, 2 * parts
        track = _followed(line, body, controls, parts)
        found, old = (np.where(held, each.load / weight, each.q * weight) for each in (track.state, before))
        size = np.where(held, *(np.max(np.abs(found[own]), initial=1e-300) for own in (held, ~held)))
        off = np.stack([np.where(held, 0.0, np.abs(found - old) / weight), np.abs(found - old) / size])
    return track, parts, off


def _followed(line: Line, body: Bonded, controls: Sequence[Control], parts: int) -> Outcome:
    """Follow a path of loads from rest on one mesh; whole pads may leave the plane where any load does."""
    farthest = next((control for control in controls if control.out_of_plane), controls[-1])
    held, _ = scaled_control(body, line.scales, farthest)
    corners = (np.zeros(body.components), *(scaled_control(body, line.scales, control)[1] for control in controls))
    return advance(body, unloaded(body), Path(corners, held, controls[-1].held[3:]), Friction, parts=parts)


def _finer(line: Line, levels: Levels, controls: Sequence[Control], parts: int) -> Iterator[Outcome]:
    """Yield the target's rest on levels beyond the second while they are cheap."""
    for level in range(2, len(levels)):
        if level >= WALKED or prod(levels.cells(level)) > _CHEAP:
            return
        body = levels.maker(level)
        track = _followed(line, body, controls, parts)
        if track.reason:
            return
        yield replace(track, off=np.zeros(body.components))
