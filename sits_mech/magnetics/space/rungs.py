"""How finely is a plate divided for the three-dimensional model, and down to which clearance does that carry?

A plate is prepared for all clearances from some on and all frequencies up to some (`stages`). Its coils' field is
singular a clearance below it, so that polynomials, and cells, grow in number like the plate's width over the clearance,
squared; below the `carried` clearance they would be too many (`near` goes on from there).

What a division's dense matrices take is known from its n prisms, the u currents of its largest class, its g images and
q polynomials, before any of them is made (`modes`): numbers of 8 bytes, c = 2 for complex classes,

    2 g n (n + q) + c max(4 n^2 + 2 n u + 2 u^2, 5 u^2 + 7.5 q u / min(g, 4)),

the means of 1/r and of the fields, and either the kernel mixed to an inductance, or L and R scaled to find modes, and
what drives them. One that takes more than the limit of memory gives way to a coarser one (`fitting`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TypeVar

import numpy as np

from sits_mech.extrapolation import added
from sits_mech.geometry.outline import Outline, outline_plan, target_outline
from sits_mech.geometry.sheet_plan import Grading, Plan, disc_plan, graded_axis, rectangle_plan, stretched
from sits_mech.geometry.tracks import standing_rings
from sits_mech.magnetics.axis.dodd_deeds import spectrum, wave_numbers
from sits_mech.magnetics.modes import RESOLVED
from sits_mech.magnetics.skin import skin_depth
from sits_mech.magnetics.space.fields import Box
from sits_mech.magnetics.space.loops import most_unknowns
from sits_mech.magnetics.space.modes import Sheeted, prepare_sheets
from sits_mech.magnetics.space.near import Near, prepare_near
from sits_mech.magnetics.space.sources import Sources
from sits_mech.memory import GIB, VARIABLE, check_seconds, memory_limit
from sits_mech.quantities import Array, Complex
from sits_mech.scene.sensor import Coil, Target


@dataclass(frozen=True)
class Rung:
    """How fine the divisions are.

    Attributes
    ----------
    along, across : tuple of int
        Levels of the cells along the plate and of its sheets, the coarsest first.
    terms : float
        Digits (natural logarithm) the coils' field keeps.
    single : bool
        Whether the coarsest division is all: nothing is extrapolated, and no error told.
    """

    along: tuple[int, int, int]
    across: tuple[int, int, int]
    terms: float
    single: bool = False


# Asked error of the changes of inductance and resistance -> division; measured in studies/benchmark_sheets.py.
LADDER = (
    (1e-2, Rung(along=(3, 4, 5), across=(2, 3, 4), terms=7.0)),
    (5e-3, Rung(along=(3, 4, 5), across=(3, 4, 5), terms=8.0)),
    (2e-3, Rung(along=(4, 5, 6), across=(3, 4, 5), terms=9.0)),
    (1e-3, Rung(along=(4, 5, 6), across=(4, 5, 6), terms=10.0)),
)
ROUGHEST = 1e-1, Rung(along=(2, 3, 4), across=(1, 2, 3), terms=7.0)  # for what a part of a scene is worth
DIVISIONS = 5  # of a plate: levels along and across, one of them twice
_ALONG = Grading(first=1.3, growth=1.9, largest=0.5)  # first over the skin depth, largest over `field_length`
_ACROSS = Grading(first=0.58, growth=1.35, largest=np.inf)  # sheets over the skin depth
_LEVELS = 5.5, 4.0  # of cells of these sizes, along and across
_WIDEST, _FINEST = 0.4, 0.1  # largest cell over the plate's half width, at most and at least
_SINGLE = 0.3  # half thickness over the skin depth up to which one sheet a half carries the current
_DEEPEST, _NARROWEST = 0.13, 0.006  # least skin depth that is resolved, over the half thickness and half width
_THICK = 5.0  # half thickness over the skin depth from which on higher frequencies follow from lower ones
_STEM = 4  # level along on which the sheets are refined
_VERTICAL = 3.0  # half thicknesses from the rim up to which current passes between sheets
_KEPT = 1.1  # of that, from the rim on where cells keep their sizes when a plate grows
_ORDER, _FASTER = 2.0, 6.0  # of the error in the size of cells; how much higher at a rim where current crowds
_CROWDED, _COARSE = 2.3, 0.3  # thickness, and skin depth divided for, over the skin depth where it begins to
_TRIANGLES = (2, 2, 4), (3, 3, 6)  # levels of divisions that follow no smooth map
ROUGH = 3e-2
"""The asked error from which on the first of them will do; where memory has no room for the second, twice what is told.
"""
_TRUST = 1.0, 0.4  # errors of R and of Delta L over what `extrapolation` says, as measured
_EVEN = 0.1  # of R where current fills the plate, and from there with the thickness over the skin depth
_REDUCED = 2e-3, 3e-4  # of R and of omega Delta L: what few modes and fields, and means of prisms, leave; on discs
_MOST = 2000  # polynomials in all; what a wide plate close to the coils misses is in its estimated error
_GIB = 20.0  # s of processor time that a plate of a GiB takes to prepare, some
_UNSEEN = 1e-3  # share of the field that may be missed
_APART = 4.0  # digits more (natural logarithm) for coils that need fewer polynomials
_SLACK = 1.15  # of memory: what the large matrices leave out, as measured


_Plates = TypeVar("_Plates")


class TooLarge(ValueError):
    """The divisions of a plate take more memory than they may."""


@dataclass(frozen=True, eq=False)
class _Family:
    """Divisions of a plate, what prepares them (as `prepare_sheets`), and the bytes that the largest takes."""

    divisions: tuple[tuple[Plan, Array], ...]
    box: Box
    highest: float
    depth: float
    resolved: bool
    needed: float


@lru_cache(maxsize=12)
def prepared(
    target: Target, outline: Outline | None, rung: Rung, scale: tuple[float, float, float, float],
    sources: Sources | None = None, become: Target | None = None, *, near: bool = False, others: float = 0.0,
) -> tuple[Sheeted, ...] | tuple[Near, ...]:  # fmt: skip
    """Return the target on some divisions, the finest first, prepared for a range of clearance and frequency.

    `scale` has the clearance from which on it holds [m], the frequency up to which it does [Hz], how far from the
    target's middle the coils' currents call for small cells, and the length on which their field changes [m]. `sources`
    are the coils, if it stands still. A rectangle or disc that the target has `become`, a little larger or smaller, has
    the target's cells and polynomials, so that differences of both are free of what other divisions change. One that is
    `near` does without polynomials along the plate but of what comes from `others`, so far away [m]; 0: there are none.

    Raises
    ------
    TooLarge
        Before the first large array.
    """
    family, limit = _family(target, outline, rung, scale, near), memory_limit()
    family = family if become is None else _carried_to(family, target, become)
    if family.needed > limit:
        x, y = np.ptp(target_outline(target, outline).rim, axis=0) * 1e3
        cells = max(plan.cells.shape[0] * 2 * (z.size - 1) * len(plan.group) for plan, z in family.divisions)
        raise TooLarge(
            f"memory: {cells} cells of the plate of {x:.3g} x {y:.3g} mm take some {family.needed / GIB:.2g} GiB, more "
            f"than the limit of {limit / GIB:.3g} GiB (--memory, or {VARIABLE})"
        )
    check_seconds(_GIB * family.needed / GIB, f"sheets: the preparation of a plate of {family.needed / GIB:.2g} GiB")
    ways = {"highest": family.highest, "depth": family.depth}
    if near:
        ways["highest"] = math.inf if family.resolved else family.highest / RESOLVED**2
        beyond = field_box(target, outline, others, rung) if others > 0.0 else None
        return prepare_near(family.divisions, target.metal.conductivity, family.box, others=beyond, **ways)
    found = prepare_sheets(family.divisions, target.metal.conductivity, family.box, sources=sources, **ways)
    return tuple(plate.resolved for plate in found) if family.resolved else found


@lru_cache(maxsize=64)
def _family(
    target: Target, outline: Outline | None, rung: Rung, scale: tuple[float, float, float, float], near: bool
) -> _Family:
    """A plate's divisions, as in `prepared`."""
    clearance, depth = scale[0], skin_depth(scale[1], target.metal.conductivity)
    box = field_box(target, outline, clearance, rung)
    half, width = target.thickness / 2, min(float(box.half[:2].min()), scale[2])
    least = min(_DEEPEST * half, _NARROWEST * float(box.half[:2].min()))
    highest, depth = scale[1] * min(1.0, depth / least) ** 2, max(depth, least)
    largest = max(min(_ALONG.largest * scale[3], _WIDEST * width), _FINEST * width)
    along = Grading(min(_ALONG.first * depth, largest), _ALONG.growth, largest, reach=scale[2])
    plans = {m: _plan(target, outline, _level(along, m, _LEVELS[0]), max(box.order[:2])) for m in rung.along}
    sheets = {m: _interfaces(half, depth, m) for m in rung.across}
    divisions = tuple((plans[m], sheets[k]) for m, k in _star(rung))
    vertical = _VERTICAL * half
    seen = 1 if near else math.prod(box.order)
    needed = max(memory_of(plan, z.size - 1, vertical, seen) for plan, z in divisions)
    return _Family(divisions, box, highest, vertical, half <= _THICK * depth, needed)


def _carried_to(family: _Family, target: Target, other: Target) -> _Family:
    """A plate's divisions with their nodes where another of the same shape has them."""
    now, was = (np.array([*plate.extent, plate.thickness]) for plate in (other, target))
    x, y = ((now - was)[:2] / 2).tolist()
    plans = {id(plan): stretched(plan, (x, y), _KEPT * family.depth) for plan, _ in family.divisions}
    divisions = tuple((plans[id(plan)], z * now[2] / was[2]) for plan, z in family.divisions)
    return replace(family, divisions=divisions, box=replace(family.box, half=family.box.half * now / was))


def memory_of(plan: Plan, sheets: int, depth: float, polynomials: int) -> float:
    """Return what the modes of a division take at most, by the module's formula [bytes].

    Parameters
    ----------
    plan : Plan
    sheets : int
        Of the upper half.
    depth : float
        How far from the rim current may pass between sheets [m].
    polynomials : int
        Of the box, along all axes.
    """
    g, q, n = len(plan.group), polynomials, plan.cells.shape[0] * sheets
    u, c = sheets * most_unknowns(plan, depth), 2 if np.iscomplex(plan.characters).any() else 1
    dense = max(4.0 * n**2 + 2.0 * n * u + 2.0 * u**2, 5.0 * u**2 + 7.5 * q * u / min(g, 4))
    return float(_SLACK * 8.0 * (2.0 * g * n * (n + q) + c * dense))


def rung_for(tolerance: float, plates: Sequence[tuple[Target, Outline | None]]) -> Rung:
    """Return the rung for an asked error of the changes of inductance and resistance.

    Where no smooth map divides one of the plates' outlines, all have two levels along; plates that answer each other
    have one level less, as measured against rings.
    """
    rung = next((rung for error, rung in (ROUGHEST, *LADDER) if tolerance >= error), LADDER[-1][1])
    if len(plates) > 1:
        along, across = ((a - 1, b - 1, c - 1) for a, b, c in (rung.along, rung.across))
        rung = replace(rung, along=along, across=across if across[0] > 1 else rung.across)
    smooth = all(outline is None and plate.shape in ("rectangle", "disc") for plate, outline in plates)
    return rung if smooth else replace(rung, along=_TRIANGLES[int(tolerance < ROUGH)])


def rungs_for(tolerance: float, plates: Sequence[tuple[Target, Outline | None]]) -> tuple[Rung, ...]:
    """Return the rung for an asked error (`rung_for`), and coarser ones to take where it needs too much memory."""
    coarser = sorted(error for error in (*(error for error, _ in LADDER), ROUGH) if error > tolerance)
    return tuple(dict.fromkeys(rung_for(error, plates) for error in (tolerance, *coarser)))


def fitting(
    tolerance: float, plates: Sequence[tuple[Target, Outline | None]], divided: Callable[[Rung], _Plates]
) -> tuple[_Plates, Rung, tuple[str, ...]]:
    """Return plates as the first of `rungs_for` divides them that memory holds, it, and what to say of finer ones.

    Raises
    ------
    TooLarge
        Where not even the coarsest one does.
    """
    *finer, coarsest = rungs_for(tolerance, plates)
    said: tuple[str, ...] = ()
    for rung in finer:
        try:
            return divided(rung), rung, said
        except TooLarge as refusal:
            said = (f"{refusal}: a coarser division is taken, whose error is told",)
    return divided(coarsest), coarsest, said


def _stem(rung: Rung) -> int:
    """Which of a rung's levels along the plate the sheets are refined on."""
    return rung.along.index(_STEM) if _STEM in rung.along[:2] else 0


def _star(rung: Rung) -> list[tuple[int, int]]:
    """Levels along and across of a rung's divisions: all levels along with the fewest sheets, the finest first; then
    all other numbers of sheets on one level along. Of a single one, the coarsest of both.
    """
    if rung.single:
        return [(rung.along[0], rung.across[0])]
    return [(m, rung.across[0]) for m in rung.along[::-1]] + [(rung.along[_stem(rung)], k) for k in rung.across[1:]]


def limit(values: Sequence[Complex], rung: Rung, thickness: float, finest: float) -> tuple[Complex, Complex]:
    """Return what the answers of a rung's divisions tend to, real and imaginary part apart, and their errors.

    Along a plate the error of R falls like the square of the cells, and much faster where the current of a thick plate
    crowds at the rim in few of them.

    Parameters
    ----------
    values : sequence of ndarray, shape (p, n, n)
        Delta Z of each division; then of the first one, off by another error [ohm].
    rung : Rung
    thickness, finest : float
        Of the plate, and skin depth for which it is divided, over the skin depth.
    """
    if rung.single:
        return values[0], np.zeros_like(values[0])
    along, stem, others = values[2::-1], values[2 - _stem(rung)], values[DIVISIONS:]
    across = stem, *values[3:DIVISIONS]
    crowded = math.prod(x**6 / (1.0 + x**6) for x in (thickness / _CROWDED, finest / _COARSE))
    results = []
    orders = _ORDER + _FASTER * crowded, _ORDER
    skin = min(1.0, thickness / _CROWDED)
    trusts = max(_EVEN, 0.7 * skin) * _TRUST[0], _TRUST[1]
    for part, order, trust in zip((np.real, np.imag), orders, trusts, strict=True):
        x, error_x = added([part(Z) for Z in along], rung.along, order)
        z, error_z = added([part(Z) for Z in across], rung.across, _ORDER)
        error = trust * (error_x + error_z) + sum(np.abs(part(Z - values[0])) for Z in others)
        results.append((part(along[-1] + across[-1] - stem) + x + z, error))
    (R, error_R), (X, error_X) = results
    return R + 1j * X, error_R + _REDUCED[0] * (skin**2 + 0.13) * np.abs(R) + 1j * (error_X + _REDUCED[1] * np.abs(X))


def _level(sizes: Grading, parts: int, nominal: float) -> Grading:
    """A level of a family, from the sizes of its cells on a nominal level."""
    return replace(sizes.coarser(nominal), parts=parts)


def _interfaces(half: float, depth: float, parts: int) -> Array:
    """Interfaces of the sheets of the upper half of a plate [m]."""
    if half < _SINGLE * depth:
        return np.array([0.0, half])
    return graded_axis(half, _level(replace(_ACROSS, first=_ACROSS.first * depth), parts, _LEVELS[1]))


def _plan(target: Target, outline: Outline | None, grading: Grading, orders: int) -> Plan:
    """Division of the target's outline."""
    if outline is None and target.shape == "rectangle":
        return rectangle_plan(*target.extent, grading)
    if outline is None and target.shape == "disc":
        return disc_plan(target.extent[0], grading, orders=orders)
    return outline_plan(target_outline(target, outline), grading)


def is_near(target: Target, outline: Outline | None, clearance: float, rung: Rung) -> bool:
    """Say whether a plate is so close to the coils that its polynomials do not carry their field."""
    return unseen(field_box(target, outline, clearance, rung)) > _UNSEEN


def field_box(target: Target, outline: Outline | None, clearance: float, rung: Rung) -> Box:
    """Return the bounding box with the polynomials that a field singular `clearance` [m] below it needs."""
    rim = target_outline(target, outline).rim
    half = np.array([*np.abs(rim).max(0) * (1.0 + 1e-3), target.thickness / 2])
    rates = [*(math.asinh(clearance / side) for side in half[:2]), math.acosh(1.0 + clearance / half[2])]
    order = [math.ceil(rung.terms / (2 * rate)) + extra for rate, extra in zip(rates, (3, 3, 2), strict=True)]
    short, long = (0, 1) if half[0] <= half[1] else (1, 0)
    order[short] = min(order[short], math.isqrt(_MOST // order[2]))
    order[long] = min(order[long], _MOST // (order[2] * order[short]))
    decay = math.exp(rates[0]), math.exp(rates[1]), math.exp(rates[2])
    return Box(half, (order[0], order[1], order[2]), decay, _APART + rung.terms, clearance)


@lru_cache(maxsize=64)
def field_length(coil: Coil, distance: float) -> float:
    """Return 1 / k of the root mean square wave number of a coil's field at a distance from its plane [m]."""
    k, weights = wave_numbers(20.0 / distance, coil.outer_diameter)
    energy = spectrum(standing_rings(coil), k) ** 2 * np.exp(-2.0 * k * distance) * weights
    return float(np.sqrt(energy.sum() / (k**2 * energy).sum()))


def unseen(box: Box) -> float:
    """Share of the coils' field energy that the box's polynomials miss: rho^-2n."""
    return float(max(rho ** (-2.0 * n) for rho, n in zip(box.decay[:2], box.order[:2], strict=True)))


