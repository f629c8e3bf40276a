"""A plate that sees the coils' potential itself, cell by cell, and answers at one frequency: close to them, or at rest.

Close to a wide plate the polynomials of the coils' field over its box would be too many (`divisions.is_near`), and a
plate that does not move needs none. Nothing stands between here: the mean of each coil's A over each cell, in each
pose, drives the currents of every symmetry class (`classes`), whose matrices are factored once a frequency,

    (R + j omega L) i_c = -j omega g_c,    Delta Z_cd = omega^2 g_c^H (R + j omega L)^-1 g_d.

A pose costs some tens of milliseconds; at rest the potential is taken once (`sources`). Other plates are further away
than the coils: their fields it sees through few polynomials (`modes.combined`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from sits_mech.geometry.sheet_plan import Plan
from sits_mech.magnetics.coils.ring_field import check_straight
from sits_mech.magnetics.modes import DEPTHS, beyond
from sits_mech.magnetics.space.classes import Problem, driven, first_alike, kernel, problems, scaled, stacked
from sits_mech.magnetics.space.far import Answered, Asked, Far, answers_to, biot_savart
from sits_mech.magnetics.space.fields import HELD, Basis, Blocks, Box, field_means, side_by_side
from sits_mech.magnetics.space.modes import combined
from sits_mech.magnetics.space.sources import Cells, Posed, Sources
from sits_mech.memory import kept_by_first
from sits_mech.quantities import Array, Complex, Integers

_Solved = Callable[[float], list[Complex]]  # currents at an angular frequency, class by class
_CLOSE = 0.45  # distance over the largest cell's size from which on the middles show
_KEEP = 1e-4  # weaker combinations of other plates' fields are left out, a tenth of what `neighbours` leaves out


@dataclass(frozen=True)
class _Class:
    """A symmetry class with L and R on unknowns of like resistance."""

    problem: Problem
    L: Complex
    R: Complex
    unit: Array  # of each unknown
    fluxes: Complex  # of combinations of other fields and of coils at rest
    columns: Integers  # which of all those are its


@dataclass(frozen=True, eq=False)
class Near:
    """A plate's division, for any coil and pose."""

    cells: Cells
    classes: tuple[_Class, ...]
    highest: float  # angular frequency up to which the cells resolve the skin depth [rad/s]
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

    @kept_by_first(2)
    def admittance(self, omega: float) -> Blocks:
        """Return Y of the combinations of other plates' fields, and of coils at rest after them; omega [rad/s]."""
        return Blocks(self.seen, tuple(
            (part.columns, beyond(partial(_seen, self, k), omega, self.highest)) for k, part in enumerate(self.classes)
        ))

    def reactions(
        self, divisions: Sequence[Near], seen: Posed, frequency: float, asked: Asked | None = None
    ) -> tuple[list[Complex], Complex | None]:
        """Return what a plate does to the coils' impedance, and what is asked of its field; as `Sheeted.reactions`."""
        _check_field(divisions, seen)
        omega, n = 2 * np.pi * frequency, len(seen.coils)
        shown = _shown(divisions)
        both = [_reaction(plate, seen, omega, asked if plate is shown else None) for plate in divisions]
        return [Z[..., :n] for Z, _ in both], next((field for _, field in both if field is not None), None)

    def answered(self, divisions: Sequence[Near], seen: Posed, frequency: float, far: Far) -> list[Answered]:
        """Return what a plate does to the coils' impedance, and what it answers to others; as `Sheeted.answered`."""
        found, n, omega = [], len(seen.coils), 2 * np.pi * frequency
        _check_field(divisions, seen)
        for plate in divisions:
            answer, _ = _reaction(plate, seen, omega)
            e = np.swapaxes(answer[..., n:] @ far.fields, 1, 2)
            found.append((answer[..., :n], e, answers_to(plate, far, omega)[1]))
        return found

    def field(self, seen: Posed, frequency: float, points: Array) -> Complex:
        """Return B of the plate's currents at points; as `Sheeted.field`, of each cell's current in its middle."""
        omega = 2 * np.pi * frequency
        if self.sources:
            own = (points - seen.places[0]) @ seen.turns[0]
            return np.asarray(seen.turns[0] @ _resting(self, omega, own.tobytes()))[None]
        _check_field([self], seen)
        (found,) = np.asarray(_reaction(self, seen, omega, Asked(points, lambda B: B[None]))[1])
        return np.asarray(found)

    @property
    def seen(self) -> int:
        """Combinations of other plates' fields, and coils at rest."""
        return self.sources + sum(basis.size for basis in self.bases)


def prepare_near(
    divisions: Sequence[tuple[Plan, Array]], conductivity: float, box: Box, *, highest: float, depth: float = 0.0,
    beside: Box | Sources | None = None,
) -> tuple[Near, ...]:
    """Return a plate's divisions; `divisions` to `depth` as of `prepare_sheets`, `box` of the coils' fields.

    `beside` is the box of other plates' fields, if there are any; or the coils that a plate at rest sees, others'
    fields on `box`.
    """
    others, sources = (box, beside) if isinstance(beside, Sources) else (beside, None)
    found: list[dict[tuple[int, int], _Class]] = []
    bases: dict[tuple[int, int], Basis] = {}
    metal, seen, alike = (conductivity, depth), (others, sources), first_alike(divisions)
    if sources is not None:
        points = sum(sources.points(divisions[k][0], stacked(*divisions[k])) for k in set(alike))
        check_straight(sources.coils, sources.windings, sources.distance, points)
    for (plan, levels), first in zip(divisions, alike, strict=True):
        found.append(found[first] if first < len(found) else _classes(plan, levels, metal, seen, bases))
    if not found[0]:
        raise ValueError("outline: the division leaves the currents no freedom; the metal is too narrow")
    number = len(sources.coils) if sources else 0
    return tuple(
        Near(Cells(*division, box), _numbered(classes, bases, number), 2 * np.pi * highest, others or box,
             tuple(bases.values()), number)
        for division, classes in zip(divisions, found, strict=True)
    )


def _numbered(
    classes: Mapping[tuple[int, int], _Class], bases: Mapping[tuple[int, int], Basis], coils: int
) -> tuple[_Class, ...]:
    """Return classes with the numbers of what they see: combinations of their own, class by class, and all coils."""
    *each, last = side_by_side([*(basis.size for basis in bases.values()), coils])
    columns = {key: np.r_[own, last] for key, own in zip(bases, each, strict=True)}
    return tuple(replace(one, columns=columns.get(key, last.start + np.arange(coils))) for key, one in classes.items())


def _classes(
    plan: Plan, levels: Array, metal: tuple[float, float], seen: tuple[Box | None, Sources | None],
    bases: dict[tuple[int, int], Basis],
) -> dict[tuple[int, int], _Class]:
    """Return classes of a division; the first one fills `bases`. `metal`: conductivity, `depth` of `prepare_sheets`."""
    (conductivity, depth), (others, sources) = metal, seen
    prisms, first = stacked(plan, levels), not bases
    means = kernel(plan, levels, prisms)
    fields = None if others is None else field_means(plan, prisms, others)
    driving = None if sources is None else sources.means(plan, prisms)
    classes = {}
    for key, problem in problems(plan, levels, depth):
        L, R, unit = scaled(problem, means, conductivity)
        B: Any = np.zeros((0, len(unit)))
        if others is not None and (first or key in bases):
            bases[key], B = combined(problem, others, np.asarray(fields), (R, unit), bases.get(key), _KEEP)
        if driving is not None:
            B = np.vstack([B, driven(problem, driving) * unit])
        classes[key] = _Class(problem, L, R, unit, B, np.zeros(0, dtype=int))
    return classes


def _check_field(divisions: Sequence[Near], seen: Posed) -> None:
    """Refuse coils of straight tracks whose field on all divisions, in one pose, takes too long."""
    points = sum(plate.cells.points[0].size // 3 for plate in divisions)
    check_straight(seen.coils, seen.windings, divisions[0].cells.box.clearance, points)


def _reaction(
    plate: Near, seen: Posed, omega: float, asked: Asked | None = None
) -> tuple[Complex, Complex | None]:
    """Return Delta Z of a division and, to its right, Y of coils' fields and combinations, shape (p, n, n + r).

    With it what is asked of the field, pose by pose.
    """
    n = len(seen.coils)
    result, field = np.empty((len(seen.places), n, n + plate.seen), dtype=complex), list[Complex]()
    step = max(1, HELD // (plate.cells.points[0].size * n))
    for first in range(0, len(result), step):
        some = slice(first, first + step)
        driving = plate.cells.means(seen.some(some))
        fluxes = [driven(part.problem, driving) * part.unit for part in plate.classes]
        solved = cache(partial(_solved, plate, fluxes))
        result[some] = beyond(partial(_answer, plate, fluxes, solved, n), omega, plate.highest)
        if asked is None:
            continue
        moments = _moments(plate, omega, fluxes, solved)
        moments = moments.reshape(-1, n, *moments.shape[1:])
        for turn, place, each in zip(seen.turns[some], seen.places[some], moments, strict=True):
            B = biot_savart(plate.cells.middles[None], each[None], (asked.points - place) @ turn)
            field.append(asked.of(turn @ B))
    return result, np.concatenate(field, axis=1) if field else None


def _answer(plate: Near, fluxes: Sequence[Complex], solved: _Solved, n: int, omega: float) -> Complex:
    """Return `_reaction` of some poses, from the fluxes of n coils in each, (poses times n, unknowns) by class."""
    answer = np.zeros((len(fluxes[0]) // n, n, n + plate.seen), dtype=complex)
    others = _by_others(plate, omega)
    for part, by_others, B, each in zip(plate.classes, others, fluxes, solved(omega), strict=True):
        own = B.reshape(-1, n, B.shape[-1])
        currents = each.reshape(own.shape)
        answer[..., :n] += _symmetric(part, own @ np.swapaxes(currents, 1, 2))
        if len(part.fluxes):
            both = own @ by_others.T + currents @ part.fluxes.T
            answer[..., n:][..., part.columns] += _weight(part) * both
    return np.asarray(omega**2 * answer)


def _seen(plate: Near, k: int, omega: float) -> Complex:
    """Return Y of one class; the factors of a plate at rest, which is asked once, are not kept."""
    part = plate.classes[k]
    currents = _currents(_factor(part, omega), part.fluxes) if plate.sources else _by_others(plate, omega)[k]
    return omega**2 * _symmetric(part, part.fluxes @ currents.T)


def _currents(factor: Any, B: Complex) -> Complex:
    """Return the currents that fluxes (m, unknowns) drive, without -j omega."""
    return lu_solve(factor, B.conj().T, check_finite=False).T


def _solved(plate: Near, fluxes: Sequence[Complex], omega: float) -> list[Complex]:
    """Return `_currents` class by class."""
    return [_currents(factor, B) for factor, B in zip(_factors(plate, omega), fluxes, strict=True)]


@kept_by_first(2)
def _resting(plate: Near, omega: float, points: bytes) -> Complex:
    """Return B by the coils that a plate at rest sees, (k, 3, n) [T/A], in its own axes; its factors are not kept."""
    fluxes = [part.fluxes[-plate.sources :] for part in plate.classes]
    moments = _moments(plate, omega, fluxes, partial(_solved, plate, fluxes))
    vars(plate).pop(_factors.__qualname__, None)
    found = biot_savart(plate.cells.middles[None], moments[None], np.frombuffer(points).reshape(-1, 3))
    return np.asarray(found[0])


def _moments(plate: Near, omega: float, fluxes: Sequence[Complex], solved: _Solved) -> Complex:
    """Return the moments in all images of the cells of what fluxes (m, unknowns) drive, (m, images times cells, 3)."""
    omega = min(omega, plate.highest)
    each = zip(plate.classes, _factors(plate, omega), fluxes, solved(omega), strict=True)
    return np.asarray(-1j * omega * sum(_cell_moments(*one) for one in each))


def _cell_moments(part: _Class, factor: Any, B: Complex, currents: Complex) -> Complex:
    """Return a class's share of `_moments` over -j omega, by the currents that fluxes drive."""
    loops, factors = part.problem.parts[2], part.problem.factors()
    both = np.einsum("gsab,bcm->mgsca", factors, [m @ (currents * part.unit).T for m in loops])
    if np.iscomplexobj(part.R):
        back = lu_solve(factor, B.T, trans=1, check_finite=False).T
        both += np.einsum("gsab,bcm->mgsca", factors.conj(), [m.conj() @ (back * part.unit).T for m in loops])
    else:
        both *= 2.0
    return np.asarray(_weight(part) * both.reshape(len(B), -1, 3))


def _shown(divisions: Sequence[Near]) -> Near:
    """Return the coarsest division whose cells, taken in their middles, show a clearance off; else the finest one.

    Currents in the middles of cells h apart miss exp(-2 pi g/h) of their field at a distance g, along tracks about a
    tenth of that: at 0.45 6 %, and 0.4 % seen.
    """
    small = [each for each in divisions if each.cells.size <= each.cells.box.clearance / _CLOSE]
    if small:
        return min(small, key=lambda each: each.unknowns)
    return min(divisions, key=lambda each: (each.cells.size, each.unknowns))


def _weight(part: _Class) -> float:
    """Return half of how often a class is there: its fields act on each other both ways."""
    return 0.5 * (part.problem.weight if np.iscomplexobj(part.R) else 1.0)


def _symmetric(part: _Class, Z: Complex) -> Complex:
    """Return a class's reaction both ways, from one of them."""
    return _weight(part) * (Z + np.swapaxes(Z, -1, -2))


@kept_by_first(DEPTHS.size)
def _factors(plate: Near, omega: float) -> list[Any]:
    """Return LU factors of R + j omega L, class by class."""
    return [_factor(part, omega) for part in plate.classes]


def _factor(part: _Class, omega: float) -> Any:
    """Return LU factors of one class."""
    return lu_factor(part.R + 1j * omega * part.L, overwrite_a=True, check_finite=False)


@kept_by_first(DEPTHS.size)
def _by_others(plate: Near, omega: float) -> list[Complex]:
    """Return the currents that combinations of other plates' fields drive, class by class."""
    return [_currents(factor, part.fluxes) for part, factor in zip(plate.classes, _factors(plate, omega), strict=True)]
