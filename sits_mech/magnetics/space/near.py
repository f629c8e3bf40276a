"""A plate that sees the coils' potential itself, cell by cell, at one frequency or all: close to them, or at rest.

Close to a wide plate the polynomials of the coils' field over its box would be too many (`divisions.is_near`), and a
plate that does not move needs none. Nothing stands between here: the mean of each coil's A over each cell, in each
pose, drives the currents of every symmetry class (`classes`), which are reduced once (`magnetics.modes`),

    (R + j omega L) i_c = -j omega g_c,    Delta Z_cd = omega^2 g_c^H (R + j omega L)^-1 g_d.

A pose costs some tens of milliseconds; at rest the potential is taken once (`sources`). Other plates are further away
than the coils: their fields it sees through few polynomials (`modes.combined`).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import repeat
from typing import Any

import numpy as np

from sits_mech.geometry.sheet_plan import CellPlan
from sits_mech.magnetics.coils.ring_field import check_straight
from sits_mech.magnetics.modes import Factored, Reduced, factored, reduced
from sits_mech.magnetics.space.classes import Problem, driven, first_alike, image_moments, problems, stacked
from sits_mech.magnetics.space.far import FieldRequest, biot_savart
from sits_mech.magnetics.space.fields import HELD, Basis, Blocks, Box, row_places
from sits_mech.magnetics.space.modes import check_free, matrices_of
from sits_mech.magnetics.space.rungs import ImpedanceLimit
from sits_mech.magnetics.space.sources import PlateCells, Posed, Sources
from sits_mech.memory import latest
from sits_mech.quantities import Array, Complex, Integers

_CLOSE = 0.45  # distance over the largest cell's size from which on the middles show
_Key = tuple[int, int]  # of a class, by order and mirror
_KEEP = 1e-4  # weaker combinations of other plates' fields are left out, a tenth of what `neighbours` leaves out


@dataclass(frozen=True)
class _Class:
    """A symmetry class."""

    problem: Problem
    unit: Array  # of each unknown: these have like resistance
    reduced: Any  # `Reduced` or `Factored`, seen through each unknown
    seen: Any  # what combinations of other fields and coils at rest induce in it (m, reduced)
    columns: Integers  # which of all those are these

    def induced(self, driving: Array, mirrored: bool) -> Any:
        """Return what A in its images (3, g, 2, n, c) induces, (c, reduced); `mirrored` as of `Posed`.

        Of what is mirrored but for the way of the coils' current, currents that are so drive nothing.
        """
        plan = self.problem.plan
        if mirrored and plan.tensor is not None and self.problem.character[2] == 1.0:
            return np.zeros((driving.shape[-1], len(self.unit)))
        return self.reduced.induced(driven(self.problem, driving) * self.unit)

    def cell_moments(self, induced: Any, omega: float) -> Complex:
        """Return the moments in all images of its cells of what is induced (m, reduced), (m, q, 3)."""
        omega = min(omega, self.reduced.highest)
        ways = self.reduced.currents(induced, omega)
        return -1j * omega * image_moments(self.problem, [self.unit[:, None] * each for each in ways])


@dataclass(frozen=True, eq=False)
class Near:
    """A plate's division, for any coil and pose."""

    cells: PlateCells
    classes: tuple[_Class, ...]
    box: Box  # of other plates' fields
    bases: tuple[Basis, ...] = ()  # combinations of these, one a symmetry class; empty without other plates
    sources: int = 0  # coils that it sees at rest, after these

    @property
    def sheets(self) -> int:
        """Number of sheets."""
        return 2 * (self.cells.levels.size - 1)

    @property
    def unknowns(self) -> int:
        """Size of the discrete problem."""
        return sum(part.problem.loops.unknowns * int(part.problem.weight) for part in self.classes)

    @cached_property
    def whole(self) -> Reduced | Factored:
        """All classes' reduced currents, one class after the other; factors react alike, whatever they are."""
        parts = [part.reduced for part in self.classes]
        if isinstance(parts[0], Factored):
            return parts[0]
        off = np.concatenate([np.append(part.off_diagonal, 0.0) for part in parts])[:-1]
        return Reduced(np.concatenate([part.diagonal for part in parts]), off, np.empty((0, 0)), parts[0].highest)

    @latest(2, owned=True)
    def admittance(self, omega: float) -> Blocks:
        """Return Y of combinations of other plates' fields, and of coils at rest after them; omega [rad/s]."""
        parts = tuple((part.columns, part.reduced.reaction(part.seen, omega)) for part in self.classes)
        return Blocks(self.seen, parts)

    def reactions(
        self, divisions: Sequence[Near], seen: Posed, frequency: float, limit: ImpedanceLimit | None = None,
        asked: FieldRequest | None = None,
    ) -> tuple[list[Complex], Complex | None]:
        """Return what a plate does to the coils' impedance, and what is asked of its field; as `Sheeted.reactions`."""
        found, field = _reactions(divisions, seen, 2 * np.pi * frequency, asked)
        values = [Z[..., : len(seen.coils)] for Z in found]
        values = [(Z + np.swapaxes(Z, 1, 2)) / 2 for Z in values]
        return values if limit is None else limit.forms(values), field

    def coupled(self, divisions: Sequence[Near], seen: Posed, frequency: float) -> list[Complex]:
        """Return Y of coils and combinations, as `far.Moving`."""
        return _reactions(divisions, seen, 2 * np.pi * frequency)[0]

    @property
    def seen(self) -> int:
        """Combinations of other plates' fields, and coils at rest."""
        return self.sources + sum(basis.size for basis in self.bases)


def prepare_near(
    divisions: Sequence[tuple[CellPlan, Array]], metal: tuple[float, float], box: Box, highest: float = math.inf,
    nearby: Box | Sources | None = None, omega: float = 0.0,
) -> tuple[Near, ...]:
    """Return a plate's divisions; `divisions` to `highest` as of `prepare_sheets`, `box` of the coils' fields.

    `metal` is its conductivity, and the depth of `prepare_sheets`; `nearby` the box of other plates' fields, if there
    are any, or the coils that a plate at rest sees, others' fields on `box`. It is for one frequency `omega` [rad/s],
    or for all; where classes are complex, or cells do not resolve it, for all.
    """
    others, sources = (box, nearby) if isinstance(nearby, Sources) else (nearby, None)
    found: list[dict[_Key, _Class]] = []
    bases: dict[_Key, Basis] = {}
    alike = first_alike(divisions)
    _check_at_rest(sources, [divisions[k] for k in set(alike)])
    for division, first in zip(divisions, alike, strict=True):
        classes = problems(*division, metal[1])
        each = matrices_of(division, classes, metal[0], (others, sources), bases, _KEEP) if first == len(found) else ()
        new = {key: _reduced(problem, own, B, highest, omega) for key, problem, own, B in each}
        found.append(new or found[first])
    check_free(found[0])
    number, seen, kept = len(sources.coils) if sources else 0, others or box, tuple(bases.values())
    return tuple(
        Near(PlateCells(*division, box), _numbered(classes, bases, number), seen, kept, number)
        for division, classes in zip(divisions, found, strict=True)
    )


def _check_at_rest(sources: Sources | None, different: Sequence[tuple[CellPlan, Array]]) -> None:
    """Refuse coils of straight tracks whose field on a plate at rest takes too long."""
    if sources is not None:
        points = sum(sources.points(plan, stacked(plan, levels)) for plan, levels in different)
        check_straight(sources.coils, sources.windings, sources.distance, points)


def _numbered(classes: Mapping[_Key, _Class], bases: Mapping[_Key, Basis], coils: int) -> tuple[_Class, ...]:
    """Return classes with the numbers of what they see: combinations of their own, class by class, and all coils."""
    *each, last = row_places([*(basis.size for basis in bases.values()), coils])
    columns = {key: np.r_[own, last] for key, own in zip(bases, each, strict=True)}
    return tuple(replace(one, columns=columns.get(key, last.start + np.arange(coils))) for key, one in classes.items())


def _reduced(
    problem: Problem, matrices: tuple[Complex, Complex, Array], B: Complex, highest: float, omega: float
) -> _Class:
    """Return a class by L, R and units, and the fluxes of what it sees besides coils in poses; `omega` as above."""
    L, R, unit = matrices
    whole: Reduced | Factored
    if 0.0 < omega <= highest and not np.iscomplex(problem.plan.characters).any():
        whole = factored(L, R, omega)
    else:
        whole = reduced(L, R, np.eye(len(unit), dtype=R.dtype), weight=problem.weight, highest=highest)
    return _Class(problem, unit, whole, whole.induced(B), np.zeros(0, dtype=int))


def _reactions(
    divisions: Sequence[Near], seen: Posed, omega: float, asked: FieldRequest | None = None
) -> tuple[list[Complex], Complex | None]:
    """Return Delta Z of divisions and, to its right, Y of coils' fields and combinations, shape (p, n, n + r).

    With it what is asked of the field of the division that shows it, pose by pose. Divisions of one plan see the same.
    """
    n, shown, field = len(seen.coils), _shown(divisions), list[Complex]()
    plans = {id(plate.cells.plan): plate for plate in divisions}
    results = np.zeros((len(divisions), len(seen.places), n, n + divisions[0].seen), dtype=complex)
    step = _at_once(divisions, plans.values(), seen)
    for first in range(0, len(seen.places), step):
        some = slice(first, first + step)
        own = seen.some(some)
        along = {plan: plate.cells.along(own) for plan, plate in plans.items()}
        for plate, result in zip(divisions, results, strict=True):
            driving = plate.cells.means(along[id(plate.cells.plan)])
            induced = [part.induced(driving, own.mirrored) for part in plate.classes]
            result[some] = _answer(plate, [each.reshape(len(own.places), n, -1) for each in induced], omega)
            if plate is shown and asked is not None:
                moments = np.asarray(sum(map(_Class.cell_moments, plate.classes, induced, repeat(omega))))
                field += _field(plate, own, moments, asked)
    return list(results), np.concatenate(field, axis=1) if field else None


def _answer(plate: Near, induced: Sequence[Array], omega: float) -> Complex:
    """Return `_reactions` of a division from what n coils in p poses induce class by class, (p, n, reduced)."""
    p, n, _ = induced[0].shape
    result = np.zeros((p, n, n + plate.seen), dtype=complex)
    result[..., :n] = plate.whole.reaction(np.concatenate(induced, axis=2), omega)
    for part, a in zip(plate.classes, induced, strict=True):
        if part.columns.size:
            result[..., n + part.columns] += part.reduced.reaction(a, omega, part.seen)
    return result


def _at_once(divisions: Sequence[Near], plates: Collection[Near], seen: Posed) -> int:
    """Return how many poses are taken at once; refuse straight tracks whose field at all plans' points takes long."""
    points = sum(plate.cells.points[0].size // 3 for plate in plates)
    check_straight(seen.coils, seen.windings, divisions[0].cells.box.clearance, points)
    most = max(len(plate.cells.plan.cells) * len(plate.cells.plan.group) * plate.sheets for plate in divisions)
    return max(1, HELD // (8 * len(seen.coils) * most))  # three means by each coil, twice, and what they sum to


def _field(plate: Near, seen: Posed, moments: Complex, asked: FieldRequest) -> list[Complex]:
    """Return what is asked of the field of moments by n coils in p poses, (p times n, images times cells, 3)."""
    each = moments.reshape(len(seen.places), -1, *moments.shape[1:])
    return [
        asked.of(turn @ biot_savart(plate.cells.middles[None], own[None], (asked.points - place) @ turn))
        for turn, place, own in zip(seen.turns, seen.places, each, strict=True)
    ]


@latest(2, owned=True)
def resting_field(plate: Near, omega: float, points: bytes) -> Complex:
    """Return B by the coils that a plate at rest sees, at points (k, 3) in its own axes, (k, 3, n) [T/A]."""
    moments = sum(part.cell_moments(part.seen[-plate.sources :], omega) for part in plate.classes)
    found = biot_savart(plate.cells.middles[None], np.asarray(moments)[None], np.frombuffer(points).reshape(-1, 3))
    return np.asarray(found[0])


def _shown(divisions: Sequence[Near]) -> Near:
    """Return the coarsest division whose cells, taken in their middles, show a clearance off; else the finest one.

    Currents in the middles of cells h apart miss exp(-2 pi g/h) of their field at a distance g, along tracks about a
    tenth of that: at 0.45 6 %, and 0.4 % seen.
    """
    return min(divisions, key=lambda each: (max(each.cells.size, each.cells.box.clearance / _CLOSE), each.unknowns))
