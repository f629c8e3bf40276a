"""On which mesh does a layer come to rest, and with which contact? Families of meshes stand in line, and the first
good one answers.

Each family is tougher and a little less accurate than the one before: the first that gets to the load with an error
near what is asked gives the answer, or else the one that gets farthest, with the smallest error. After the families
without contact those with it stand in line. A rest whose free faces fold onto the ground or the target is solved again
with contact, from the rest without it where that mesh has a twin with contact: let in softly first where faces stand
deep behind planes, or else along a path of its own. Where contact moves the target by no more than the line allows it
is left out, and what it is worth is in the error. Where the load cannot be reached with it, the answer is that without,
and its error the whole displacement. The notes say which. The coarse mesh of each family is asked first: where none
gets there, the farthest family alone says what is carried (limit.py).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from sits_mech.mechanics.faces.face_contact import LEFT_OUT, LEFT_SHARE, FaceContact, face_contact, softened
from sits_mech.mechanics.levels.answer import Scales, Solved, aim, first_look, levers, solve_levels, starts
from sits_mech.mechanics.levels.family import Levels
from sits_mech.mechanics.rest.body import packed, unpacked
from sits_mech.mechanics.rest.control import Control
from sits_mech.mechanics.rest.limit import Outcome
from sits_mech.mechanics.rest.newton import newton
from sits_mech.mechanics.rest.path import follow
from sits_mech.quantities import Array, Equilibrium, Pose
from sits_mech.scene.sensor import Sensor

_MORE = 1.5  # times what a mesh sees of contact is what may be left out: finer ones saw up to 1.45 times as much
_NEARLY = 1e-2  # residual at which a small change is known to some percent of it


@dataclass(frozen=True, eq=False)
class Line:
    """Pairs of meshes in the order they are tried, each made when it is asked for, and how they are tried.

    Attributes
    ----------
    sensor : Sensor
    scales : Scales
    makers : sequence of callable
        One for each family.
    twins : tuple
        For each family without contact, the number of that with contact on the same meshes, or None; those with contact
        come after.
    smallest : tuple of float
        Smallest increments of a load path: where no other family waits, where one does, ...
    asked : float
        Estimated error at which no finer level is tried.
    goal : ndarray, shape (s, 6), optional
        What that error is of, as of `by_goal`; the largest component of the pose by default.
    good : float
        Estimated error up to which no other family is tried.
    effect : float
        Share of the displacement that contact may be worth and still be left out.
    softly : tuple of float
        Times the contact depth, on the way from rest without contact.
    most : float
        Iterations times unknowns that a load path is given.
    deepest : int
        Levels that a load is brought to rest on at most.
    """

    sensor: Sensor
    scales: Scales
    makers: Sequence[Callable[[], Levels]]
    twins: tuple[int | None, ...]
    smallest: tuple[float, ...]
    asked: float
    good: float = np.inf
    effect: float = 0.0
    softly: tuple[float, ...] = ()
    most: float = np.inf
    deepest: int = 99
    goal: Array | None = None

    def __post_init__(self) -> None:
        """Keep what is made."""
        object.__setattr__(self, "makers", tuple(cache(maker) for maker in self.makers))

    def __len__(self) -> int:
        return len(self.makers)

    def __getitem__(self, number: int) -> Levels:
        return self.makers[number]()

    @property
    def free(self) -> int:
        """How many families at the beginning are without contact, while others have it."""
        return len(self.twins) if len(self.twins) < len(self) else len(self)


def settled(line: Line, start: Equilibrium | None, control: Control, first: int = 0) -> Solved:
    """Return the last equilibrium towards what is given, with contact where it counts.

    From a neighbour the way is another one: what is not reached from there is tried from rest, so that a load has one
    answer, and one limit, whoever asks.

    Parameters
    ----------
    line : Line
    start : Equilibrium or None
        Of a neighbour, its state beginning with the number of its family.
    control : Control
    first : int
        Number of the first family that is tried.
    """
    found = _settled(line, start, control, first)
    if found.part < 1.0 and start is not None and not control.beside:
        return _settled(line, None, control, first)
    return found


def untouched(line: Line, controls: Sequence[Control]) -> Solved | None:
    """Return the answer to the last of some loads, where free faces touch nothing under any of them; None otherwise."""
    found: Solved | None = None
    for control in controls if line.free < len(line) else ():
        found = _first_good(line, range(line.free), None, control, {})
        if found is None or found.part < 1.0 or _touches(line, found.found):
            return None
    return found


def _settled(line: Line, start: Equilibrium | None, control: Control, first: int) -> Solved:
    """The last equilibrium on the way from a start."""
    count = len(line)
    number = -1 if start is None or not start.state.size else int(start.state[0])
    if start is not None and (line.free <= number < count or (number >= 0 and _there(start, control))):
        there = _tried(line, number, start, control, 0)  # a neighbour in contact, or this load on fewer meshes
        if there.part == 1.0 and (number >= line.free or line.free == count or not _touches(line, there.found)):
            return there
    looks: dict[int, Outcome] = {}
    free = _first_good(line, range(first, line.free), start, control, looks)
    if free is None:
        return _refused(line, looks, start, control)
    if line.free == count or not (_touches(line, free.found) or free.part < 1.0):
        return free
    if free.part == 1.0:
        twin = line.twins[int(free.found.state[0])]
        change = None if twin is None or line.effect == 0.0 else _nearly_settled(line, twin, free.found, control)
        if change is not None and _effect(line, free.found, change) <= line.effect:
            return _worth_little(line, free, change)
        if twin is not None:
            held = _first_good(line, range(twin, count), _softly(line, twin, free.found, control), control, {})
            if held is not None and held.part == 1.0:
                return _chosen(line, free, held)
    elif free.refused and not _touches(line, free.found):
        return free
    held = _first_good(line, range(line.free, count), start, control, looks)
    return _without_contact(line, free) if held is None else _chosen(line, free, held)


def _there(start: Equilibrium, control: Control) -> bool:
    """Whether an equilibrium is under the very load that is given."""
    return control.given == {name: value for name, value in vars(start.wrench).items() if name in control.given}


def _refused(line: Line, looks: dict[int, Outcome], start: Equilibrium | None, control: Control) -> Solved:
    """What is said of a load that no coarse mesh without contact gets to: contact may, or the farthest one is told.

    Contact on meshes that have been tried matters only where a face touches; other meshes may get there without.
    """
    number = max(looks, key=lambda each: looks[each].reached)
    body, last = line[number].coarse, looks[number].state
    touches = face_contact(body.faces, body.mesh, body.parts, last.u, last.q).touch
    others = [n for n in range(line.free, len(line)) if touches or not (looks[number].limit or n in line.twins)]
    if others:
        held = _first_good(line, others, start, control, looks)
        if held is not None:
            return held
        number = max(looks, key=lambda each: looks[each].reached)
    found = _tried(line, number, start, control, 0, looks[number])
    return _without_contact(line, found) if number < line.free < len(line) else found


def _first_good(
    line: Line, numbers: Sequence[int], start: Equilibrium | None, control: Control, looks: dict[int, Outcome]
) -> Solved | None:
    """Of some families, the first good answer, or else the farthest and best; None if no coarse mesh gets there.

    Where the coarse meshes got to is written to `looks`.
    """
    best: Solved | None = None
    for number in numbers:
        if best is not None and best.part == 1.0 and line[number].fine.guarded:
            continue
        family = line[number]
        look = _known(line, number, looks)
        if look is None:
            look = first_look(family, line.scales, _own(family, number, start), control, line.most)
        looks[number] = look
        if look.reached < 1.0:
            continue
        own = _tried(line, number, start, control, numbers[-1] - number, look)
        if best is None or own.part > best.part or (own.part == best.part == 1.0 and _error(own) < _error(best)):
            best = own
        touches = number < line.free < len(line) and _touches(line, own.found)
        if best.part == 1.0 and (_error(best) <= line.good or touches):
            break
    if best is not None and best.part < 1.0 and looks[numbers[-1]].reached < 1.0:  # it was left early for others
        number = max(numbers, key=lambda each: looks[each].reached)
        return _tried(line, number, start, control, 0, looks[number])
    return best


def _known(line: Line, number: int, looks: dict[int, Outcome]) -> Outcome | None:
    """Where the coarse mesh of a family gets to, if another's is the same and ended on the way.

    Families may differ by what divides their cells alone, or by contact, which plays no part where no face touches.
    """
    body = line[number].coarse
    for other, look in looks.items():
        known, beside = line[other].coarse, (other < line.free) != (number < line.free)
        same = (known.K, known.guarded) == (body.K, body.guarded) and np.array_equal(known.mesh.nodes, body.mesh.nodes)
        if not same or look.reached == 1.0:
            continue
        if not (beside and face_contact(known.faces, known.mesh, known.parts, look.state.u, look.state.q).touch):
            return look
    return None


def _error(solved: Solved) -> float:
    """Estimated error of an answer."""
    return solved.found.report.estimated_error


def _own(family: Levels, number: int, start: Equilibrium | None) -> Equilibrium | None:
    """A start where it is on the same family of meshes."""
    if start is None or start.state.size != 1 + family.size or start.state[0] != number:
        return None
    return replace(start, state=start.state[1:])


def _tried(
    line: Line, number: int, start: Equilibrium | None, control: Control, waiting: int, look: Outcome | None = None
) -> Solved:
    """The last equilibrium on one family of meshes, while some others wait."""
    family, own = line[number], _own(line[number], number, start)
    smallest = line.smallest[min(waiting, len(line.smallest) - 1)]
    solved = solve_levels(
        line.sensor, family, line.scales, own, control, smallest=smallest, asked=line.asked, most=line.most,
        coarse=look, deepest=line.deepest, goal=line.goal,
    )  # fmt: skip
    return solved._replace(found=replace(solved.found, state=np.concatenate([[number], solved.found.state])))


def _touches(line: Line, found: Equilibrium) -> bool:
    """Whether a free face lies on or behind ground or target, or touches another."""
    return _contact(line, found).touch


def _contact(line: Line, found: Equilibrium) -> FaceContact:
    """What the free faces of an equilibrium touch."""
    body = line[int(found.state[0])].fine
    n, k = body.mesh.nodes.size, body.components
    u, q = found.state[1 : 1 + n], found.state[1 + n : 1 + n + k]
    return face_contact(body.faces, body.mesh, body.parts, u, q)


def _softly(line: Line, twin: int, found: Equilibrium, control: Control) -> Equilibrium:
    """An equilibrium without contact as a start on the twin of its meshes that has it, let in softly."""
    family = line[twin]
    states, (held, goal) = [], aim(family.fine, line.scales, control)
    bodies = (family.fine, family.coarse)
    for body, state in zip(bodies, starts(family, line.scales, replace(found, state=found.state[1:])), strict=True):
        here = state
        for factor in line.softly:
            soft = replace(body, parts=softened(body.parts, factor))
            begin = np.where(held, here.q, here.load)
            here = follow(soft, here, (begin, goal), smallest=1.0, held=held, beside=control.held[3:]).state
        states.append(packed(here))
    return replace(found, state=np.concatenate([[twin], *states]))


def _nearly_settled(line: Line, twin: int, found: Equilibrium, control: Control) -> tuple[Array, Array] | None:
    """How far contact moves the target of an equilibrium without it, and the forces that hold it, nearly at rest.

    Changes of motion and load in SI, shapes (k,); None where Newton's method does not get there at once.
    """
    before, after = line[int(found.state[0])].fine, line[twin].fine
    k, scales = before.components, line.scales
    here = unpacked(before, found.state[1:], scales.load(found.wrench)[:k])
    held, goal = aim(before, scales, control)
    there = newton(after.near(here.u), here, goal, held, until=_NEARLY).state
    if not there.residual <= _NEARLY:
        return None
    return (there.q - here.q) * scales.lengths[:k], (there.load - here.load) * scales.loads[:k]


def _effect(line: Line, found: Equilibrium, change: tuple[Array, Array]) -> float:
    """What contact changes, over the target's displacement or the forces, the larger share."""
    moved, forces = change
    k, lever = len(moved), levers(line[int(found.state[0])].fine, line.scales.thickness)
    at_rest = line.scales.pose(np.zeros(k)).components
    away = (found.pose.components - at_rest)[:k] + moved
    size = max(float(np.max(np.abs(away * lever[:k]))), 1e-300)
    only = np.array([name.startswith("F") for name in vars(found.wrench)])[:k]
    with_contact = float(np.max(np.abs(found.wrench.components[:k] + forces)[only]))
    share = float(np.max(np.abs(forces[only]))) / max(with_contact, 1e-300)
    return max(float(np.max(np.abs(moved * lever[:k]))) / size, share)


def _chosen(line: Line, free: Solved, held: Solved) -> Solved:
    """With contact or without: the farther; of two that arrive, that without only where contact is worth little."""
    if held.part < free.part:
        return _without_contact(line, free)
    if held.part < 1.0 or free.part < 1.0:
        return held
    change = (
        (held.found.pose.components - free.found.pose.components)[: line[0].fine.components],
        (held.found.wrench.components - free.found.wrench.components)[: line[0].fine.components],
    )
    effect = _effect(line, free.found, change)
    if effect <= line.effect:
        return _worth_little(line, free, change)
    if not _contact(line, held.found).held:
        return held
    found, error = held.found, held.found.error.components
    error[: len(change[0])] += LEFT_SHARE * np.abs(change[0])
    report = replace(found.report, estimated_error=found.report.estimated_error + LEFT_SHARE * effect)
    return held._replace(found=replace(found, error=Pose.of(error), report=report))


def _worth_little(line: Line, free: Solved, change: tuple[Array, Array]) -> Solved:
    """An answer that leaves contact out, what that changes added to its errors."""
    found, effect = free.found, _effect(line, free.found, change)
    notes = (*found.report.notes, f"contact would change this by {effect:.2g}, which is in the estimated error")
    error = found.error.components
    error[: len(change[0])] += _MORE * np.abs(change[0])
    report = replace(found.report, notes=notes, estimated_error=found.report.estimated_error + _MORE * effect)
    return free._replace(found=replace(found, error=Pose.of(error), report=report))


def _without_contact(line: Line, free: Solved) -> Solved:
    """An answer that needs contact and has none: its error is the whole displacement."""
    found = free.found
    if not _touches(line, found):
        return free
    body = line[int(found.state[0])].fine
    k, lever = body.components, levers(body, line.scales.thickness)
    away = (found.pose.components - line.scales.pose(np.zeros(k)).components) * lever
    size = np.where(np.arange(6) < k, float(np.max(np.abs(away))), 0.0)
    report = replace(found.report, estimated_error=1.0, notes=(*found.report.notes, LEFT_OUT))
    return free._replace(found=replace(found, error=Pose.of(size / lever), report=report))
