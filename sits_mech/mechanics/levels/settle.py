"""Choose the family of meshes and the contact for a load, and solve it.

Two families of meshes (family.py) hold a layer: a free one, and one with a guard on J for loads that turn the free one
inside out at a corner. The first that reaches the load gives the answer; the coarse mesh of each is tried first, and
where neither does, the farther one gives the largest load (equilibrium/path.py).

Contact, "auto". A rest whose free faces touch the ground, the target or each other is solved again with contact, from
the rest without it: introduced gradually, as faces may stand deep behind planes. Where the load cannot be reached with
contact, the answer is that without, and its error the whole displacement. The notes say which.

A load path that ended before its goal is described by one message for layers of all kinds: where it stands, how much of
the load is carried if a limit was found, what ended it, and where the silicone's law loses its stability or leaves its
data.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sits_mech.mechanics.equilibrium.body import packed
from sits_mech.mechanics.equilibrium.control import Control
from sits_mech.mechanics.equilibrium.outcome import Outcome, PathEnd
from sits_mech.mechanics.equilibrium.path import follow
from sits_mech.mechanics.faces.face_contact import LEFT_SHARE, FaceContact, face_contact, softened
from sits_mech.mechanics.levels.answer import aim, starts
from sits_mech.mechanics.levels.beyond import refused
from sits_mech.mechanics.levels.family import PAIR, Line
from sits_mech.mechanics.levels.pair import Solved, first_look, from_first, own_start, solve_levels
from sits_mech.mechanics.levels.words import WORDS, carried_note, carried_words, given_words, wrench_words
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Ended, Equilibrium, Pose, SolveFailed
from sits_mech.silicone.stability import end_words

_SMALLEST = (0.6, 1e-2)  # increment of the load path on each: of the free one none is cut, as the other waits
_SOFTLY = (100.0, 10.0)  # times the contact depth, on the way from rest without contact


def settled(line: Line, start: Equilibrium | None, control: Control) -> Solved:
    """Return the last equilibrium on the path to a load, with contact where it counts.

    A path from a neighbour's equilibrium that fails is tried again from rest, so that answer and limit do not depend on
    `start`; the first entry of `start.state` is its family number.
    """
    if (beyond := refused(line, start, control)) is not None:
        return beyond
    found = _settled(line, start, control)
    if found.part < 1.0 and start is not None and not control.out_of_plane:
        return _settled(line, None, control)
    return found


def untouched(line: Line, controls: Sequence[Control]) -> Solved | None:
    """Return the answer to the last load if free faces touch nothing under any of them, else None."""
    found: Solved | None = None
    for control in controls if line.auto else ():
        found = _on(line, range(PAIR), None, control)
        if found.part < 1.0 or _touches(line, found.found):
            return None
    return found


def _settled(line: Line, start: Equilibrium | None, control: Control) -> Solved:
    """Return the last equilibrium on the path from a start."""
    number = -1 if start is None or not start.state.size else int(start.state[0])
    if number >= PAIR:  # a neighbour in contact
        there = _on(line, range(number, number + 1), start, control)
        if there.part == 1.0:
            return there
    here = start is not None and control.given.items() <= vars(start.wrench).items()
    onwards = start is not None and 0 <= number < PAIR and (here or control.out_of_plane != ())
    numbers = range(number if onwards else 0, PAIR)
    free = _on(replace(line, deepest=min(line.deepest, 2)) if line.auto else line, numbers, start, control)
    if not line.auto:
        return free
    if not _touches(line, free.found):  # its first levels are remembered
        return free if line.deepest <= 2 else _on(line, numbers, start, control)
    begin = _softly(line, free.found, control) if free.part == 1.0 else start
    held = _on(line, line.last, begin, control)
    if held.part < free.part:
        return _without_contact(line, free)
    return held if free.part < 1.0 else _with_depth(line, free.found, held)


def _on(line: Line, numbers: Sequence[int], start: Equilibrium | None, control: Control) -> Solved:
    """Return the rest on the first family that gets there, or else what the farthest one carries."""
    looks: dict[int, Outcome] = {}
    tried: list[Solved] = []
    for number in numbers:
        own = own_start(line[number], number, start)
        looks[number] = first_look(line, line[number], own, control)
        if looks[number].reached == 1.0:
            tried.append(_tried(line, number, own, control, looks[number], _SMALLEST[number == numbers[-1]]))
            if tried[-1].part == 1.0:
                return tried[-1]
    for number in (each for each in numbers if looks[each].reached == 1.0):
        there = from_first(line, line[number], control, looks[number])
        if there is not None:
            return _tried(line, number, None, control, looks[number], there)
    if looks[numbers[-1]].reached == 1.0:
        return max(tried, key=lambda each: each.part)
    number = max(looks, key=lambda each: looks[each].reached)
    return _tried(line, number, own_start(line[number], number, start), control, looks[number], _SMALLEST[1])


def _tried(
    line: Line, number: int, own: Equilibrium | None, control: Control, look: Outcome, second: Outcome | float
) -> Solved:
    """Return the last equilibrium on one family, as `solve_levels`, with its number."""
    solved = solve_levels(line, line[number], own, control, look, second)
    return solved._replace(found=replace(solved.found, state=np.concatenate([[number], solved.found.state])))


def _touches(line: Line, found: Equilibrium) -> bool:
    """Whether a free face lies on or behind ground, target or another face."""
    return _contact(line, found).touch


def _contact(line: Line, found: Equilibrium) -> FaceContact:
    """Return what the free faces of an equilibrium touch."""
    body = line[int(found.state[0])].fine
    n, k = body.mesh.nodes.size, body.components
    u, q = found.state[1 : 1 + n], found.state[1 + n : 1 + n + k]
    return face_contact(body.faces, body.mesh, body.parts, u, q)


def _softly(line: Line, found: Equilibrium, control: Control) -> Equilibrium:
    """Return a start with contact from an equilibrium without, on the same meshes, with contact let in softly."""
    twin = int(found.state[0]) + PAIR
    family = line[twin]
    states, (held, goal) = [], aim(family.fine, line.scales, control)
    bodies = (family.fine, family.coarse)
    for body, state in zip(bodies, starts(family, line.scales, replace(found, state=found.state[1:])), strict=True):
        here = state
        for factor in _SOFTLY:
            soft = replace(body, parts=softened(body.parts, factor))
            begin = np.where(held, here.q, here.load)
            here = follow(soft, here, (begin, goal), smallest=1.0, held=held, out_of_plane=control.held[3:]).state
        states.append(packed(here))
    return replace(found, state=np.concatenate([[twin], *states]))


def _with_depth(line: Line, free: Equilibrium, held: Solved) -> Solved:
    """Add the error of the contact depth, where faces lie on each other."""
    found = held.found
    if not _contact(line, found).held:
        return held
    k, lever = line[0].fine.components, line[0].fine.reach(line.scales.thickness)
    moved = np.abs(found.pose.components - free.pose.components)[:k]
    forces = np.abs(found.wrench.components - free.wrench.components)[:k]
    only = np.array([name.startswith("F") for name in vars(free.wrench)])[:k]
    away = np.abs(found.pose.components - line.scales.pose(np.zeros(k)).components)[:k]
    shares = (moved * lever[:k], away * lever[:k]), (forces[only], np.abs(found.wrench.components)[:k][only])
    effect = max(float(np.max(part)) / max(float(np.max(whole)), 1e-300) for part, whole in shares)
    error = found.error.components
    error[:k] += LEFT_SHARE * moved
    report = replace(found.report, estimated_error=found.report.estimated_error + LEFT_SHARE * effect)
    return held._replace(found=replace(found, error=Pose.of(error), report=report))


def _without_contact(line: Line, free: Solved) -> Solved:
    """Set the error to the whole displacement where contact is needed but missing."""
    found = free.found
    body = line[int(found.state[0])].fine
    k, lever = body.components, body.reach(line.scales.thickness)
    away = (found.pose.components - line.scales.pose(np.zeros(k)).components) * lever
    size = np.where(np.arange(6) < k, float(np.max(np.abs(away))), 0.0)
    report = replace(found.report, estimated_error=1.0, notes=(*found.report.notes, Note(NoteKind.CONTACT_LOST)))
    return free._replace(found=replace(found, error=Pose.of(size / lever), report=report))


def ended(control: Control, solved: Solved, body: str) -> SolveFailed:
    """Return the message where and why a load path of a `body`, "pad" or "layer", ended."""
    last, seen = solved.found, {name: solved.seen * value for name, value in control.given.items()}
    laws = tuple(note.with_numbers(**seen) for note in solved.laws)
    limit = list[Note]()
    if solved.carried is not None and solved.limit is not None:
        limit.append(carried_note(solved.carried, solved.limit))
    if not limit and solved.seen < 1.0:
        limit.append(Note.of(NoteKind.NO_LARGEST, **seen))
    why = (*laws, *limit, Note.of(NoteKind.PATH_END, end=solved.reason))
    others = (note for note in last.report.notes if note not in solved.laws)
    notes = (*others, *why, Note.of(NoteKind.PATH_PART, part=solved.part))
    report = replace(last.report, status=Ended.PATH, notes=notes)
    if solved.reason is PathEnd.BEYOND:  # one load: the largest within the data
        most, ends = carried_words(limit[0].known), " and ".join(map(end_words, laws))
        message = f"wrench: the {body} holds no more than {most}: {ends}"
    else:
        words, asked = "; ".join(WORDS[note.kind](note) for note in why), given_words(control.given)
        there = f"{wrench_words(vars(last.wrench))} ({solved.part:.1%} of the path), not to {asked}"
        message = (
            f"wrench: the {body} could be followed to {there}; smallest volume ratio there {report.min_J:.3g}; {words}"
        )
    return SolveFailed(message, report, replace(last, report=report), carried=solved.carried)
