"""How far can a layer or pad be led by one force or one place of its target, and what stops it?

Further and further from rest, each point from the one before. By place, the control that belongs to the question: a
target pressed or pulled is held upright and in the middle, one sheared or tilted bears no other force. By force it
shows the instabilities that such holding hides. A goal that is not reached is a row as well: work against energy
as far as the way went, and, read off the last state, what stands there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from extreme.checks import REST, Way, elastomer_of, energy_row, places
from extreme.rows import DONE, Row

from sits_mech.mechanics.block import BlockPad, solved_body
from sits_mech.mechanics.element.kernel import deformation
from sits_mech.mechanics.equilibrium.control import Control
from sits_mech.mechanics.layer import PlanarLayer
from sits_mech.notes import NoteKind
from sits_mech.quantities import Array, Equilibrium, SolveFailed, Wrench
from sits_mech.report.notes import sentences

NAMES = ("d_h", "sink", "alpha")
_NEAR = 0.15  # thicknesses from the edge that count as at it
_BREAKS = 10.0  # stretch: Ecoflex 00-30, the softest of the catalogue, tears at 900 % (its data sheet)
_STATED = 0.999  # of a goal by force that counts as reached


@dataclass(frozen=True)
class Drive:
    """One way of loading: which place grows, its goals and step; held places stay zero, others bear no force.

    Lengths are in thicknesses, angles in degrees. ``by_force``: the force of the place grows, nothing is held.
    """

    name: str
    place: str
    goals: Sequence[float]
    step: float
    sign: float = 1.0
    held: tuple[str, ...] = ()
    by_force: bool = False

    def size(self, model: PlanarLayer | BlockPad) -> float:
        """Return what one of the goals' units is [m, rad]."""
        return float(np.pi / 180.0 if self.place == "alpha" else elastomer_of(model).thickness)

    def at(self, model: PlanarLayer | BlockPad, found: Equilibrium) -> float:
        """Return where a state stands on the way, in the goals' units."""
        return float(self.sign * places(model, found)[NAMES.index(self.place)] / self.size(model))

    def amount(self, goal: float) -> str:
        """Return a goal in words."""
        by = " by force alone" if self.by_force else ""
        return f"{self.name} {goal:g} degrees{by}" if self.place == "alpha" else f"{self.name} {goal:.0%}{by}"


def drive(model: PlanarLayer | BlockPad, kind: Drive) -> Iterator[tuple[float, Callable[[], Row]]]:
    """Yield the goals of a kind with what to ask for each, from goal to goal."""
    unit = tuple(kind.sign * float(name == kind.place) for name in NAMES)
    way = Way((unit[0], unit[1], unit[2]), not kind.by_force, [0.0], [model.equilibrium(REST)])
    ended: list[Row] = []

    def reach(goal: float) -> Row:
        if ended:
            return ended[0]
        try:
            (_by_force if kind.by_force else _by_place)(model, kind, way, goal)
        except SolveFailed as failed:
            ended.append(_stopped(model, kind, way, failed))
            return ended[0]
        return energy_row(model, way)

    for goal in kind.goals:
        yield goal, lambda goal=goal: reach(goal)


def _by_place(model: PlanarLayer | BlockPad, kind: Drive, way: Way, goal: float) -> None:
    """Lead the target's place to a goal."""
    assert isinstance(model, PlanarLayer)
    size = kind.size(model)
    here = way.points[-1] / size
    for value in np.linspace(here, goal, 1 + max(1, round((goal - here) / kind.step)))[1:]:
        control = Control(**{kind.place: kind.sign * value * size}, **dict.fromkeys(kind.held, 0.0))
        way.path.append(model.controlled(control, start=way.path[-1]))
        way.points.append(float(value * size))


def _by_force(model: PlanarLayer | BlockPad, kind: Drive, way: Way, goal: float) -> None:
    """Let the force grow until its place is at a goal."""
    while kind.at(model, way.path[-1]) < _STATED * goal:
        here = kind.at(model, way.path[-1])
        following = min(here + kind.step, goal)
        if len(way.path) == 1:
            share = _first(model, way) * following * kind.size(model)
        else:
            slope = (way.points[-1] - way.points[-2]) / max(here - kind.at(model, way.path[-2]), 1e-9)
            share = way.points[-1] + slope * max(following - here, 0.02 * kind.step)
        way.path.append(model.equilibrium(Wrench(*(share * np.array(way.unit))), start=way.path[-1]))
        way.points.append(float(share))


def _first(model: PlanarLayer | BlockPad, way: Way) -> float:
    """Return the stiffness against the force of a way, from the answer to a small one."""
    elastomer = elastomer_of(model)
    t = elastomer.thickness
    small = 1e-3 * elastomer.silicone.shear_modulus * t * (elastomer.length if isinstance(model, PlanarLayer) else t)
    unit = np.array(way.unit)
    share = small * (t if unit[2] else 1.0)
    return share / float(unit @ places(model, model.equilibrium(Wrench(*(share * unit)))))


def _stopped(model: PlanarLayer | BlockPad, kind: Drive, way: Way, failed: SolveFailed) -> Row:
    """Return the row of a way that ended: consistent as far as it went, and what stands at its end."""
    report = failed.report
    seen = [kind.at(model, found) for found in (way.path[-1], failed.last) if found is not None]
    clauses = [f"stopped at {kind.amount(max(seen)).removeprefix(kind.name).strip()}"]
    if failed.last is not None:
        clauses.append(strained(model, failed.last))
    notes = sentences(note for note in report.notes if note.kind is not NoteKind.PATH_PART)
    remark = "; ".join((*clauses, *notes))
    row = Row("", "", DONE, estimated=report.estimated_error)
    if len(way.path) > 2:
        row = energy_row(model, way)
    min_J = np.nan if report.min_J is None else report.min_J
    return replace(row, status=report.status, min_J=min_J, estimated=report.estimated_error, remark=remark)


def strained(model: PlanarLayer | BlockPad, found: Equilibrium) -> str:
    """Say where a state's smallest volume ratio is in the undeformed layer, and how far the silicone is stretched."""
    t = elastomer_of(model).thickness
    body = model.line[int(found.state[0])].fine if isinstance(model, PlanarLayer) else solved_body(model, found)
    mesh = body.mesh
    F, J = deformation(mesh, found.state[1 : 1 + mesh.nodes.size])
    point = mesh.nodes[mesh.cells[int(np.argmin(J.min(axis=1)))]].mean(axis=0)
    inside, height = float(body.X.max()) - abs(float(point[0])), float(point[-1])
    near = "at the target's edge" if abs(inside) < _NEAR and height > 1.0 - _NEAR else "in the layer"
    where = f"{near}, {inside * t / 1e-3:.2g} mm from its end and {height * t / 1e-3:.2g} mm high"
    stretch = float(np.sqrt(np.linalg.eigvalsh(right_stretch(F)).max()))
    beyond = ", more than silicones bear" if stretch > _BREAKS else ""
    return f"smallest J {found.report.min_J:.2g} {where}; stretched up to {stretch:.2g}{beyond}"


def refused(model: PlanarLayer | BlockPad, question: Callable[[], Row]) -> Row:
    """Return the row of a question; of a load path that ended, with what stands at its end."""
    try:
        return question()
    except SolveFailed as failed:
        report = failed.report
        remarks: tuple[str, ...] = ()
        if failed.last is not None:
            remarks = f"followed to {failed.last.wrench}", strained(model, failed.last)
        min_J = np.nan if report.min_J is None else report.min_J
        remark = "; ".join((*sentences(report.notes), *remarks))
        return Row("", "", report.status, min_J, estimated=report.estimated_error, remark=remark)


def right_stretch(F: Array) -> Array:
    """Return F^T F of gradients (..., 4) in plane strain or (..., 9), row by row."""
    d = 2 if F.shape[-1] == 4 else 3
    whole = F.reshape(*F.shape[:-1], d, d)
    return np.asarray(np.swapaxes(whole, -1, -2) @ whole)
