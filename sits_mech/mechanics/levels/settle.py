"""Choose the family of meshes and the contact for a load, and solve it.

Two families of meshes (family.py) hold a layer: a free one, and one with a guard on J for loads that turn the free one
inside out at a corner. The first that reaches the load gives the answer; the coarse mesh of each is tried first, and
where neither does, the farther one gives the largest load (equilibrium/limit_point.py). A first level that buckles
under a load that the second carries is left out: the answer is that of the second and the third (pair.py).

Contact, "auto". A rest whose free faces touch the ground, the target or each other is solved again with contact, from
the rest without it: introduced gradually, as faces may stand deep behind planes; from rest where the first level
touches and the second one does not get there in one increment without contact. Where the load cannot be reached with
contact, the answer is that without, and its error the whole displacement. The notes say which.

A load path that ended too early is described by one message for layers of all kinds: where it stands, how much of
the load is carried if a limit was found, what ended it, and where the silicone's law loses its stability or leaves its
data.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from sits_mech.mechanics.equilibrium.body import pack_state
from sits_mech.mechanics.equilibrium.control import Control
from sits_mech.mechanics.equilibrium.outcome import Outcome, Path, PathEnd
from sits_mech.mechanics.equilibrium.path import advance
from sits_mech.mechanics.faces.face_contact import LEFT_SHARE, FaceContact, softened
from sits_mech.mechanics.levels.answer import enlarged, relative, scaled_control, starts, whole_error
from sits_mech.mechanics.levels.beyond import overload_refusal
from sits_mech.mechanics.levels.family import PAIR, Line
from sits_mech.mechanics.levels.load_path import along, depends_on_path
from sits_mech.mechanics.levels.pair import (
    Pair,
    Solved,
    beyond_first,
    first_look,
    from_first,
    refined_answer,
    second_look,
)
from sits_mech.mechanics.levels.words import WORDS, carried_note, carried_words, given_words, wrench_words
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Ended, Equilibrium, Pose, SolveFailed
from sits_mech.silicone.stability import end_words

_SMALLEST = (0.6, 1e-2)  # smallest increment on a family with another one to try, which cuts none, and on the last
_SOFTLY = (100.0, 10.0)  # times the contact depth, on the way from rest without contact


def last_equilibrium(line: Line, start: Equilibrium | None, controls: Sequence[Control]) -> Solved:
    """Return the last equilibrium on a path of loads, with contact where it counts; the path matters with friction.

    Answer and limit do not depend on a `start`, which is not used with friction: a path from a neighbour's equilibrium
    that fails is tried again from rest. The first entry of `start.state` is its family number.
    """
    control = controls[-1]
    if depends_on_path(line.sensor):
        return _with_friction(line, controls)
    if (beyond := overload_refusal(line, start, control)) is not None:
        return beyond
    for begin, numbers in _tries(line, start, control):
        solved = _by_families(line, numbers, begin, control)
        if solved.part == 1.0:
            break
    return solved


def _tries(line: Line, start: Equilibrium | None, control: Control) -> list[tuple[Equilibrium | None, range]]:
    """Return starts and the families to try from each: from the neighbour in contact, from it without, from rest.

    Families before the neighbour's own are left out where the load goes on from its own, or out of the plane.
    """
    if start is None:
        return [(None, range(PAIR))]
    number = int(start.state[0]) if start.state.size else -1
    in_contact = [(start, range(number, number + 1))] if number >= 0 and line.in_contact(number) else []
    onwards = control.given.items() <= vars(start.wrench).items() or control.out_of_plane != ()
    first = number if 0 <= number < PAIR and onwards else 0
    from_rest = [] if control.out_of_plane else [(None, range(PAIR))]
    return [*in_contact, (start, range(first, PAIR)), *from_rest]


def _with_friction(line: Line, controls: Sequence[Control]) -> Solved:
    """Return the last equilibrium on a path of loads with friction, which is none where free faces touch nothing.

    Raise ValueError for loads that do not all hold the same components.
    """
    if any(np.any(each.held != controls[-1].held) for each in controls):
        raise ValueError("via: must give the same forces and places as the end of the path")
    if (beyond := overload_refusal(line, None, controls[-1])) is not None:
        return beyond
    for control in controls if line.auto else ():
        pair = _on(line, range(PAIR), None, control)
        if pair.part < 1.0 or _faces(line, pair).touch:
            break
        if control is controls[-1]:
            return refined_answer(line, pair, control)
    return along(line, controls)


def _by_families(line: Line, numbers: Sequence[int], start: Equilibrium | None, control: Control) -> Solved:
    """Return the last equilibrium on the first family that reaches a load; where faces touch, with contact.

    Contact is taken at once where the first level touches and no second one gets there in one increment, unless faces
    lie on each other: there what contact changes is the error (`_with_depth`).
    """
    look = first_look(line, numbers[0], start, control)
    may_touch = line.auto and look.reached == 1.0 and not eliminates(line, numbers[0], look)
    pair = _on(line, numbers, start, control, _SMALLEST[not may_touch])
    if may_touch and pair.part < 1.0:
        touching = _on(line, line.last, start, control)
        if touching.part == 1.0 and not _faces(line, touching).held:
            return refined_answer(line, touching, control)
        pair = _on(line, numbers, start, control)
    touches = line.auto and not line.in_contact(pair.number) and _faces(line, pair).touch
    return _in_contact(line, pair, start, control) if touches else refined_answer(line, pair, control)


def _on(
    line: Line, numbers: Sequence[int], start: Equilibrium | None, control: Control, last: float = _SMALLEST[1]
) -> Pair:
    """Return the rest on the first family that gets there, else the farthest; `last`: least increment on the last."""
    looks: dict[int, Outcome] = {}
    tried: list[Pair] = []
    for number in numbers:
        looks[number] = first_look(line, number, start, control)
        if looks[number].reached == 1.0:
            smallest = (_SMALLEST[0], last)[number == numbers[-1]]
            tried.append(second_look(line, number, start, control, looks[number], smallest))
            if tried[-1].part == 1.0:
                return tried[-1]
    for number, look in looks.items():
        if eliminates(line, number, look) and (there := from_first(line, number, control, look)) is not None:
            return there
    if looks[numbers[-1]].reached == 1.0:
        return max(tried, key=lambda each: each.part)
    number = max(looks, key=lambda each: looks[each].reached)
    farthest = second_look(line, number, start, control, looks[number], _SMALLEST[1])
    return _beyond(line, start, control, looks, farthest) or farthest if farthest.second.reached == 1.0 else farthest


def _beyond(
    line: Line, start: Equilibrium | None, control: Control, looks: Mapping[int, Outcome], farthest: Pair
) -> Pair | None:
    """Return the rest by the second and the third level of the first family that gets there, if one does.

    `farthest` is the second look that was taken.
    """
    for number, look in looks.items():
        pair = farthest if number == farthest.number else second_look(line, number, start, control, look, _SMALLEST[1])
        if pair.second.reached == 1.0 and (there := beyond_first(line, control, pair)) is not None:
            return there
    return None


def eliminates(line: Line, number: int, look: Outcome) -> bool:
    """Whether a first level carries the whole load, without faces that touch: with contact no cells are eliminated."""
    apart = not line.auto or line.in_contact(number) or not line[number].coarse.touching(look.state).touch
    return look.reached == 1.0 and apart


def _faces(line: Line, pair: Pair) -> FaceContact:
    """Return what the free faces of a rest on the second level touch."""
    return line[pair.number].fine.touching(pair.states[1])


def _in_contact(line: Line, free: Pair, start: Equilibrium | None, control: Control) -> Solved:
    """Return the last equilibrium with contact; of a load not reached with it that without, with its whole error."""
    without = refined_answer(replace(line, deepest=min(line.deepest, 2)), free, control)
    begin = (_softly(line, without.found, control) if free.part == 1.0 else None) or start
    pair = _on(line, line.last, begin, control)
    if pair.part < free.part:
        found = without.found  # contact is needed and was not solved: the error is the whole displacement
        away = found.pose.components - line.scales.pose(np.zeros(line[0].fine.components)).components
        whole = whole_error(line[int(found.state[0])].fine, line.scales, away)
        return without._replace(found=enlarged(found, whole, 1.0, Note(NoteKind.CONTACT_LOST)))
    solved = refined_answer(line, pair, control)
    return _with_depth(line, without.found, solved) if free.part == 1.0 and _faces(line, pair).held else solved


def _softly(line: Line, found: Equilibrium, control: Control) -> Equilibrium | None:
    """Return a start with contact let in softly, from an equilibrium without on the same meshes; None if it is lost."""
    twin = int(found.state[0]) + PAIR
    family = line[twin]
    states, (held, end) = [], scaled_control(family.fine, line.scales, control)
    begun = starts(family, line.scales, found.wrench, found.state)
    for body, here in zip((family.fine, family.coarse), begun, strict=True):
        for factor in _SOFTLY:
            soft = replace(body, parts=softened(body.parts, factor))
            path = Path((np.where(held, here.q, here.load), end), held, control.held[3:])
            if (ended := advance(soft, here, path, smallest=1.0)).reason:
                return None
            here = ended.state
        states.append(pack_state(here))
    return replace(found, state=np.concatenate([[twin], *states]))


def _with_depth(line: Line, free: Equilibrium, held: Solved) -> Solved:
    """Add the error of the contact depth to faces that lie on each other, by what contact changes."""
    found = held.found
    k, lever = line[0].fine.components, line[0].fine.reach(line.scales.thickness)
    moved = np.abs(found.pose.components - free.pose.components)[:k]
    forces = np.abs(found.wrench.components - free.wrench.components)[:k]
    only = np.array([name.startswith("F") for name in vars(free.wrench)])[:k]
    away = np.abs(found.pose.components - line.scales.pose(np.zeros(k)).components)[:k]
    shares = (moved * lever[:k], away * lever[:k]), (forces[only], np.abs(found.wrench.components)[:k][only])
    effect = max(relative(part, whole) for part, whole in shares)
    error = found.error.components
    error[:k] += LEFT_SHARE * moved
    return held._replace(found=enlarged(found, Pose.of(error), found.report.estimated_error + LEFT_SHARE * effect))


def path_failure(control: Control, solved: Solved, body: str) -> SolveFailed:
    """Return the failure that says where and why a load path of a `body`, "pad" or "layer", ended."""
    last, seen = solved.found, {name: solved.coarse_part * value for name, value in control.given.items()}
    laws = tuple(note.with_numbers(**seen) for note in solved.laws)
    largest = list[Note]()
    if solved.carried is not None and solved.limit_point is not None:
        kind = NoteKind.WITHIN_DATA if solved.reason is PathEnd.BEYOND else NoteKind.CARRIED
        largest.append(carried_note(solved.carried, solved.limit_point, kind))
    if not largest and solved.coarse_part < 1.0:
        largest.append(Note.of(NoteKind.NO_LARGEST, **seen))
    why = (*laws, *largest, Note.of(NoteKind.PATH_END, end=solved.reason))
    others = (note for note in last.report.notes if note not in solved.laws)
    notes = (*others, *why, Note.of(NoteKind.PATH_PART, part=solved.part))
    report = replace(last.report, status=Ended.PATH, notes=notes)
    if solved.reason is PathEnd.BEYOND:  # one load: the largest within the data
        most, ends = carried_words(largest[0].known), " and ".join(map(end_words, laws))
        message = f"wrench: the {body} is within the silicone's data up to {most}; this load is too far beyond: {ends}"
    else:
        words, asked = "; ".join(WORDS[note.kind](note) for note in why), given_words(control.given)
        there = f"{wrench_words(vars(last.wrench))} ({solved.part:.1%} of the path), not to {asked}"
        message = (
            f"wrench: the {body} could be followed to {there}; smallest volume ratio there {report.min_J:.3g}; {words}"
        )
    return SolveFailed(message, report, replace(last, report=report), carried=solved.carried)
