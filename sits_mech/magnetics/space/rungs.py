"""Choose how finely a plate is divided for the three-dimensional model, and extrapolate its divisions.

A rung of the ladder has three levels along the plate and three across; one of each is shared (`star`). A division that
takes more than the limit of memory gives way to a coarser one (`fitting`).

On levels with cells divided into m_1 < m_2 < m_3 parts along each axis a result behaves like

    y_m = y + a m^-p + b m^-(p+1),    Y = y_3 + d_2 / ((m_3/m_2)^p - 1),    Y - y = b (...),

with differences d_1 and d_2, the limit Y of two levels and its error, which is known as the three levels give a, b and
y (`extrapolated_rest`). The order p is 2. Along thin plates b is taken too, which leaves
``c / (m_1 m_2 m_3 (m_1 + m_2 + m_3))`` of c m^-(p+2), where b left ``b / (m_2 m_3 (m_2 + m_3))``;
where current crowds at the rim R and L fall faster (`ImpedanceLimit`). The limit is linear in the levels, so that it is
as smooth over poses and frequencies as they are, and is taken of what answers all poses, once a frequency (`coupling`).

Source: L. F. Richardson, Phil. Trans. R. Soc. A 210 (1911) 307.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np

from sits_mech.magnetics.coils.ring_field import STEP
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array, Complex
from sits_mech.scene.sensor import Target

_NEXT, _SAFETY = 3.0, 1.5  # c over b of the docstring; error over the next term where coils are close


def extrapolated_rest(d1: Array, d2: Array, sizes: Sequence[float], order: float) -> tuple[Array, Array]:
    """Return the extrapolated rest ``Y - y_3`` from the differences of three levels, and its error, entry by entry.

    It is the next term, of which levels beyond found -0.6 to 0.8 across plates of 5 to 140 skin depths.
    """
    return remainder(sizes, order) * d2, np.abs(next_term(d1, d2, sizes, order))


def next_term(d1: Any, d2: Any, sizes: Sequence[float], order: float) -> Any:
    """Return what the next term of an order adds to the extrapolated rest."""
    powers = np.asarray(sizes, dtype=float) ** -np.array([[0.0], [order], [order + 1.0]])
    w1, _, w3 = np.linalg.solve(powers, (1.0, 0.0, 0.0))  # y = w . (y_1, y_2, y_3)
    return (w3 - 1.0 - remainder(sizes, order)) * d2 - w1 * d1


def remainder(sizes: Sequence[float], order: float) -> float:
    """Return what is added to the last of three levels, over the last difference."""
    return float(1.0 / ((sizes[2] / sizes[1]) ** order - 1.0))


@dataclass(frozen=True)
class PlateRung:
    """How fine the divisions are."""

    along: tuple[int, int, int]  # levels of the cells along the plate, the coarsest first
    across: tuple[int, int, int]  # levels of its sheets, the coarsest first
    terms: float  # digits (natural logarithm) the coils' field keeps
    step: float = 2 * STEP  # of tables of the coils' field, in distances to the windings: 5e-6 of Delta Z
    few: bool = False  # so few cells that all of what is extrapolated is its error
    single: bool = False  # the coarsest division is all: no extrapolation, no error


# Asked error of the changes of inductance and resistance -> division; measured in benchmarks/sheets.py.
LADDER = (
    (1e-2, PlateRung(along=(3, 4, 5), across=(2, 3, 4), terms=7.0)),
    (5e-3, PlateRung(along=(3, 4, 5), across=(3, 4, 5), terms=8.0)),
    (2e-3, PlateRung(along=(4, 5, 6), across=(3, 4, 5), terms=9.0)),
    (1e-3, PlateRung(along=(4, 5, 6), across=(4, 5, 6), terms=10.0)),
)
ROUGHEST = 1e-1, PlateRung(along=(2, 3, 4), across=(1, 2, 3), terms=7.0, step=4 * STEP, few=True)
"""Where memory is short."""
DIVISIONS = 5  # of a plate: levels along and across, one of them twice
_STEM = 4  # level along on which the sheets are refined
_ORDER, _FASTER = 2.0, (6.0, 1.0)  # of errors in the cells' size; how much higher for R and L where current crowds
_CROWDED, _COARSE = 2.3, 0.3  # thickness, and skin depth divided for, over the skin depth where it begins to
ACROSS, ACROSS_LEVEL = 0.58, 4.0
"""Sheet at a face over the skin depth, on a level across; on others in proportion."""
_ANY = {"ring": ((2, 3, 4), (3, 4, 6)), "outline": ((2, 3, 4), (3, 4, 5))}
"""Levels along: of rings R is a third as far off as by (4, 5, 6); outlines by (3, 4, 6) take twice the time."""
ROUGH = 3e-2
"""The asked error from which the first will do."""
_LEFT = 5e-5  # of R and of omega Delta L, what no division shows: means of 1/r, 2e-5 by `prisms`, extrapolated
_RIM = 5e-3, 2e-4  # the same where levels show no order: of R at rims, a fifth in more cells, of both close to coils
_BETWEEN = 0.5  # error over what is between order 2 and faster ones
_OUTSIDE = 0.25, 2.5  # error over what corners outside leave by the last step, of L from four parts on: 0.15, 2.2 found
_CLOSE = 0.45, 0.15  # of what is added to both where cells are as long as the gap, of half a skin depth and more
_Plates = TypeVar("_Plates")


class TooLarge(ValueError):
    """The divisions of a plate take more memory than they may; `numbers` are those of the note on it."""

    def __init__(self, text: str, numbers: Mapping[str, float] | None = None) -> None:
        super().__init__(text)
        self.numbers = dict(numbers or {})


def rung_for(tolerance: float, plates: Sequence[Target], half: float) -> PlateRung:
    """Return the rung for an asked error of Delta Z, and plates at most `half` skin depths from middle to face.

    Where a third of each half is no thicker than the finest sheet at the face of thick plates, plates begin with one
    sheet a half (at 1.3 skin depths 8e-5 of Delta L off, 2e-3 of R). Where no smooth map divides one of the plates'
    outlines, all have two levels along, and the levels of rings where one is a ring; plates that answer each other have
    one level less, as measured against rings.
    """
    rung = next((rung for error, rung in (ROUGHEST, *LADDER) if tolerance >= error), LADDER[-1][1])
    if len(plates) > 1:
        along, across = ((a - 1, b - 1, c - 1) for a, b, c in (rung.along, rung.across))
        rung = replace(rung, along=along, across=across if across[0] > 1 else rung.across)
    if half / 3 <= ACROSS * ACROSS_LEVEL / rung.across[2]:
        rung = replace(rung, across=(1, 2, 3))
    other = [_ANY[plate.shape] for plate in plates if plate.shape in _ANY]
    if other:
        return replace(rung, along=max(other)[int(tolerance < ROUGH)])
    return rung


def rungs_for(tolerance: float, plates: Sequence[Target], half: float = math.inf) -> tuple[PlateRung, ...]:
    """Return the rung for an asked error (`rung_for`), and coarser ones to take where it needs too much memory."""
    coarser = sorted(error for error in (*(error for error, _ in LADDER), ROUGH, ROUGHEST[0]) if error > tolerance)
    return tuple(dict.fromkeys(rung_for(error, plates, half) for error in (tolerance, *coarser)))


def fitting(
    tolerance: float, plates: Sequence[Target], half: float, divided: Callable[[PlateRung], _Plates]
) -> tuple[_Plates, PlateRung, tuple[Note, ...]]:
    """Return plates as the first of `rungs_for` divides them that memory holds, it, and notes on finer ones.

    TooLarge where not even the coarsest one does.
    """
    *finer, coarsest = rungs_for(tolerance, plates, half)
    remarks: tuple[Note, ...] = ()
    for rung in finer:
        try:
            return divided(rung), rung, remarks
        except TooLarge as refusal:
            remarks = (Note.of(NoteKind.PLATE_TOO_LARGE, **refusal.numbers),)
    return divided(coarsest), coarsest, remarks


def _stem(rung: PlateRung) -> int:
    """Return the level along the plate on which a rung's sheets are refined."""
    return rung.along.index(_STEM) if _STEM in rung.along[:2] else 0


def star(rung: PlateRung) -> list[tuple[int, int]]:
    """Return levels along and across of a rung's divisions; of a single one, the coarsest of both.

    All levels along with the fewest sheets, the finest first; then all other numbers of sheets on one level along.
    """
    if rung.single:
        return [(rung.along[0], rung.across[0])]
    return [(m, rung.across[0]) for m in rung.along[::-1]] + [(rung.along[_stem(rung)], k) for k in rung.across[1:]]


@dataclass(frozen=True)
class ImpedanceLimit:
    """What the answers of a rung's divisions tend to, real and imaginary part apart, and their errors.

    `thickness` of the plate and `finest`, the skin depth for which it is divided, are over the skin depth; `close` says
    whether coils are as close as its cells are long, and show the next term less. Along a plate errors fall like the
    square of the cells, that term of thin ones like their cube. Where the current of a thick plate crowds at the rim,
    that of R falls much faster in few cells, less than four parts, that of L, but close to coils, between both: the
    error holds half of what is between; close to coils all faces are as rims. At a corner of an angle w in the metal
    where current crowds, and of w outside it around a thick plate, the field goes like r^(pi / w) and errors fall like
    h^(2 pi / w) (`corners`, both least orders): that of rectangles, 4/3, shows as 1.4 in levels 4 to 11. What is more
    than h^2 is error; rims, which err the other way, hide half of that of L in levels 4 to 6, nearly all in 3 to 5.
    Where one sheet a half begins the levels across, which is of no family, their whole rest is its error; where cells
    are few, that of all levels at least. From two parts on, close to coils, and from three where current is uneven, the
    next term may vanish by chance: |rest| / m^2 is the least error there (1.4 |rest| / n^2 was seen).
    """

    rung: PlateRung
    thickness: float
    finest: float
    close: bool = False
    corners: tuple[float, ...] = (2.0, 2.0)

    @property
    def thick(self) -> float:
        """How thick a plate is for its current, from 0 to 1."""
        return 1.0 - 1.0 / (1.0 + (self.thickness / _CROWDED) ** 6)

    @property
    def crowded(self) -> float:
        """How far the current of a plate crowds at its rim, from 0 to 1."""
        return self.thick * (1.0 - 1.0 / (1.0 + (self.finest / _COARSE) ** 6))

    def _rest(self, d1: Complex, d2: Complex) -> Complex:
        """Return what is added along the plate to the last of three levels, by their differences."""
        along = self.rung.along
        faster, more = _FASTER[0] * self.crowded, _FASTER[1] * self.crowded * (not self.close)
        of_R = remainder(along, _ORDER + faster * (along[0] < _STEM))
        of_L = (remainder(along, _ORDER) + remainder(along, _ORDER + more)) / 2.0
        third = (1.0 - self.thick) * next_term(d1, d2, along, _ORDER)
        return np.asarray(of_R * d2.real + 1j * of_L * d2.imag + third)

    def forms(self, values: Sequence[Complex]) -> list[Complex]:
        """Return the limit of the divisions' values, and the differences of levels along and across, coarsest first.

        Linear in the values, which may be Delta Z or what makes it; then what others, off by another error, are off the
        first one.
        """
        if self.rung.single:
            return [values[0]]
        stem = values[2 - _stem(self.rung)]
        levels = [*values[2::-1]], [stem, *values[3:DIVISIONS]]
        steps = [after - before for each in levels for before, after in pairwise(each)]
        across = levels[1][-1] - stem + remainder(self.rung.across, _ORDER) * steps[3]
        value = levels[0][-1] + self._rest(*steps[:2]) + across
        return [value, *steps, *(other - values[0] for other in values[DIVISIONS:])]

    def errors(self, forms: Sequence[Complex]) -> Complex:
        """Return the errors of the real and the imaginary part of a limit Delta Z (p, n, n), by its `forms` [ohm]."""
        if len(forms) == 1:
            return np.zeros_like(forms[0])
        rung, found, (m, n, o) = self.rung, list[Array](), self.rung.along
        into, out = (remainder(rung.along, order) - remainder(rung.along, _ORDER) for order in self.corners)
        uneven = min(2.0 * self.thickness, 1.0) ** 2
        k, few = self.crowded, self.crowded * (m < _STEM)
        shown, rims = _NEXT * (n + o) / (m * (m + n + o)), (_RIM[0] * max(few, 0.2 * k), 0.0)
        if self.close:
            shown, rims = _SAFETY, (_RIM[0] * self.thick, _RIM[1] * self.thick)
        orders, shares = (_FASTER[0] * few, _FASTER[1] * k * (not self.close)), (shown * (1.0 - few), shown)
        least = max(rung.few, max(self.close, m == 2, uneven * (m < _STEM)) / m**2)
        corners = (max(k * into, share * self.thick * out) for share in (_OUTSIDE[0], _OUTSIDE[m >= _STEM]))
        parts = [Z.real for Z in forms], [Z.imag for Z in forms]
        for (value, *d), faster, share, rim, close, corner in zip(
            parts, orders, shares, rims, np.array(_CLOSE) * self.close, corners, strict=True
        ):
            x, error_x = extrapolated_rest(d[0], d[1], rung.along, _ORDER)
            z, error_z = extrapolated_rest(d[2], d[3], rung.across, _ORDER)
            between = x - remainder(rung.along, _ORDER + faster) * d[1]
            own = share * error_x + _BETWEEN * np.abs(between) + close * uneven * np.abs(x) + corner * np.abs(d[1])
            own = own + np.maximum(error_z, np.abs(z) * (rung.across[0] == 1))
            own = np.maximum(own, least * np.abs(x) + rung.few * np.abs(z))
            found.append(own + sum(map(np.abs, d[4:])) + (_LEFT + rim) * np.abs(value))
        return found[0] + 1j * found[1]
