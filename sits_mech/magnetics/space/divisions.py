"""Choose a plate's cells, sheets and polynomials in the three-dimensional model, and prepare it by a rung.

A plate is prepared for all clearances from some on and all frequencies up to some (`answer`). Its coils' field is
singular a clearance below it, so that polynomials, and cells, grow in number like the plate's width over the clearance,
squared; below the `carried` clearance they would be too many (`near` goes on from there).

What a division's dense matrices take is known from its n prisms, the u currents of its largest class, its g images and
q polynomials, before any of them is made (`modes`): numbers of 8 bytes, c = 2 for complex classes,

    2 g n^2 + max(g/2, 1) n q + c max(4 n^2 + 2 n u + 2 u^2, 5 u^2 + 7.5 q u / min(g, 4)),

the means of 1/r and, but for images that differ by signs alone, of the fields, and either the kernel mixed to an
inductance, or L and R scaled and reduced, and what drives them. A near plate keeps of all k classes of each division
what its currents see, c k u^2; those made before, and all but the last class, are there beside a division's dense
matrices, and 3 c u^2 while that is reduced.
What takes more memory or time than the limits is refused.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from sits_mech.disk_cache import kept
from sits_mech.geometry.outline import outline_plan, target_outline
from sits_mech.geometry.sheet_plan import CellPlan, Grading, disc_plan, graded_axis, rectangle_plan, with_rim
from sits_mech.geometry.tracks import standing_rings
from sits_mech.magnetics.coils.ring_field import source_spectrum, wave_numbers
from sits_mech.magnetics.modes import RESOLVED, skin_depth
from sits_mech.magnetics.space.classes import first_alike, kernel_seconds
from sits_mech.magnetics.space.coupling import Sheeted
from sits_mech.magnetics.space.fields import Box
from sits_mech.magnetics.space.loops import most_unknowns
from sits_mech.magnetics.space.modes import division_arrays, division_from_arrays, prepare_sheets
from sits_mech.magnetics.space.near import Near, prepare_near
from sits_mech.magnetics.space.rungs import ACROSS, ACROSS_LEVEL, PlateRung, TooLarge, star
from sits_mech.magnetics.space.sources import Sources
from sits_mech.memory import GIB, MEMORY, beyond_memory, check_seconds, give_back, latest
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Coil, Target

_LOG = logging.getLogger(__name__)
_ALONG = Grading(first=1.3, growth=1.9, largest=0.5)  # first over the skin depth, largest over `field_length`
_ACROSS = Grading(first=ACROSS, growth=1.35, largest=np.inf)  # sheets over the skin depth
_LEVELS = 5.5, ACROSS_LEVEL  # of cells of these sizes, along and across
_WIDEST, _FINEST = 0.4, 0.1  # largest cell over the plate's half width, at most and at least
_SINGLE = 0.3  # half thickness over the skin depth up to which one sheet a half carries the current
_DEEPEST, _NARROWEST = 0.13, 0.006  # least skin depth that is resolved, over the half thickness and half width
_THICK = 5.0  # half thickness over the skin depth from which on higher frequencies follow from lower ones
_VERTICAL = 3.0  # half thicknesses from the rim up to which current passes between sheets
_KEPT = 1.1  # of that, from the rim on where cells keep their sizes when a plate grows
_SHORTEST = 10.0  # wave number over 1 / distance up to which a field has energy: exp(-20) beyond, 3e-10 of its length
_MOST = 2000  # polynomials in all; what a wide plate close to the coils misses is in its estimated error
_GIB = 20.0  # s of processor time that a plate of a GiB takes to prepare, some
_REDUCED = 2e-10  # the same of a near plate's class but its kernel, over the cube of its currents: 1.1 and 1.6 seen
_UNSEEN = 1e-3  # share of the field that may be missed
_SLACK = 1.15  # of memory: what the large matrices leave out, as measured
_Scale = tuple[float, float, tuple[float, float], float]  # as of `prepared`


@dataclass(frozen=True, eq=False)
class _Family:
    """Divisions of a plate, what prepares them (as `prepare_sheets`), the bytes and the seconds that they take.

    `resolved` is the angular frequency up to which cells resolve the skin depth [rad/s].
    """

    divisions: tuple[tuple[CellPlan, Array], ...]
    box: Box
    resolved: float
    depth: float
    needed: float
    seconds: float

    @property
    def cells(self) -> int:
        """Return the number of cells of the finest division."""
        return max(int(plan.cells.shape[0]) * 2 * (z.size - 1) * len(plan.group) for plan, z in self.divisions)


def lone_frequency(
    target: Target, rung: PlateRung, scale: _Scale, way: object, frequency: float
) -> float:
    """Return the angular frequency to prepare a near plate for alone, or 0 for all: that of the first that it is asked.

    `way` is what else it is prepared for in `prepared_near`; frequency of the scene [Hz], 0 for another. Where its
    cells do not resolve the skin depth an answer takes three frequencies, for which modes pay: of all currents they
    take 1.3 to 1.7 times as long as a factor. Who knows to ask two frequencies asks the scene's own last. A round
    plate has complex classes, which have no factor.
    """
    omega, asked = 2 * np.pi * frequency, _asked(target, rung, scale, way)
    asked[:] = asked or [omega]
    pays = omega <= _family(target, rung, scale, True).resolved and not target.is_round
    return omega if pays and asked[0] == omega else 0.0


@latest(64)
def _asked(*_plate: object) -> list[float]:
    """Return where the first angular frequency that a plate is asked for is kept, empty at first."""
    return []


@latest(12)
def prepared(
    target: Target, rung: PlateRung, scale: _Scale, become: Target | None = None
) -> tuple[Sheeted, ...]:
    """Return the target on some divisions, the finest first, prepared for a range of clearance and frequency.

    `scale` has the clearance from which on it holds [m], the frequency up to which it does [Hz], how far from the
    target's middle cells are small, and grow slowly, and the length on which the coils' field changes [m]. A
    rectangle or disc that the target has `become`, a little larger or smaller, has the target's cells and polynomials,
    so that differences are free of what other divisions change. TooLarge before the first large array.
    """
    family, metal = _fitting_family(target, rung, scale, (False, become)), target.metal.conductivity
    asked = family.divisions, metal, family.box, family.resolved, family.depth
    read = partial(division_from_arrays, family.box, family.resolved)

    def make() -> tuple[Sheeted, ...]:
        _announce(family, scale)
        return prepare_sheets(*asked)

    return kept(asked, make, division_arrays, read, __name__)


@latest(64)
def prepared_near(
    target: Target, rung: PlateRung, scale: _Scale, nearby: float | Sources = 0.0,
    become: Target | None = None, omega: float = 0.0,
) -> tuple[Near, ...]:
    """Return a plate without polynomials along itself, but of what comes from others; otherwise as `prepared`.

    `nearby` is how far these are away [m], 0 where there are none; or the coils of a plate at rest, others being as far
    away as it is prepared for. It is for one frequency `omega` [rad/s], or for all.
    """
    family = _fitting_family(target, rung, scale, (True, become))
    _announce(family, scale)
    others = None if nearby == 0.0 else nearby
    return prepare_near(
        family.divisions, (target.metal.conductivity, family.depth), family.box, family.resolved,
        nearby=field_box(target, others, rung) if isinstance(others, float) else others, omega=omega,
    )


def _fitting_family(target: Target, rung: PlateRung, scale: _Scale, way: tuple[bool, Target | None]) -> _Family:
    """Return a plate's divisions, near or by polynomials, of what it has become; or refuse."""
    give_back()  # what plates before took
    near, become = way
    family = _family(target, rung, scale, near)
    family = family if become is None else _carried_to(family, target, become)
    _check_memory(family.box, family.cells, family.needed)
    check_seconds(family.seconds, f"sheets: the preparation of a plate of {family.needed / GIB:.2g} GiB")
    return family


def _announce(family: _Family, scale: _Scale) -> None:
    """Log what is prepared, and the seconds that it takes."""
    range_words = f"for gaps from {1e3 * scale[0]:.3g} mm on up to {1e-6 * scale[1]:.3g} MHz"
    words = f"a plate of {family.cells} cells, {range_words}, about {family.seconds:.2g} s"
    _LOG.info(words, extra={"seconds": family.seconds})


def _check_memory(box: Box, cells: float, needed: float) -> None:
    """Refuse so many cells of a plate that take so much [bytes]."""
    if beyond := beyond_memory(needed):
        x, y = 2e3 / (1.0 + 1e-3) * box.half[:2]  # of `field_box`
        size = {"width": float(1e-3 * x), "length": float(1e-3 * y)}
        raise TooLarge(
            f"memory: {cells:.0f} cells of the plate of {x:.3g} x {y:.3g} mm take {beyond}",
            {"cells": float(cells), **size, "needed": float(needed), "limit": MEMORY.get() * GIB},
        )


@lru_cache(maxsize=64)
def _family(target: Target, rung: PlateRung, scale: _Scale, near: bool) -> _Family:
    """Return a plate's divisions, as in `prepared`, or `prepared_near`."""
    clearance, depth = scale[0], skin_depth(scale[1], target.metal.conductivity)
    box, (reach, far) = field_box(target, clearance, rung), scale[2]
    half, width = target.thickness / 2, min(float(box.half[:2].min()), reach)
    least = min(_DEEPEST * half, _NARROWEST * float(box.half[:2].min()))
    highest, depth = 2 * np.pi * scale[1] * min(1.0, depth / least) ** 2, max(depth, least)
    largest = max(min(_ALONG.largest * scale[3], _WIDEST * width), _FINEST * width)
    cells = float(np.prod(np.maximum(1.0, np.minimum(box.half[:2], reach) / largest)))  # of a quarter, at least
    _check_memory(box, 4.0 * cells, 64.0 * cells**2)  # before there are any
    along = Grading(min(_ALONG.first * depth, largest), _ALONG.growth, largest, reach=reach, far=far)
    plans = {m: target_plan(target, along.coarser(_LEVELS[0], m), max(box.order[:2])) for m in rung.along}
    sheets = {m: _interfaces(half, depth, m) for m in rung.across}
    divisions = tuple((plans[m], sheets[k]) for m, k in star(rung))
    vertical = _VERTICAL * half
    resolved = math.inf if half <= _THICK * depth else highest / RESOLVED**2
    terms = 1 if near else math.prod(box.order)
    dense = [memory_of(plan, z.size - 1, vertical, terms) for plan, z in divisions]
    kernels = sum(kernel_seconds(*divisions[k]) for k in set(first_alike(divisions)))
    needed = float(np.max(dense))
    seconds = _GIB * needed / GIB
    if near:
        needed, seconds = _near_cost(divisions, dense, vertical)
    return _Family(divisions, box, resolved, vertical, needed, seconds + kernels)


def _carried_to(family: _Family, target: Target, other: Target) -> _Family:
    """Return a plate's divisions with their nodes where another of the same shape has them."""
    now, was = (np.array([*plate.extent, plate.thickness]) for plate in (other, target))
    x, y = ((now - was)[:2] / 2).tolist()
    plans = {id(plan): with_rim(plan, (x, y), _KEPT * family.depth) for plan, _ in family.divisions}
    divisions = tuple((plans[id(plan)], z * now[2] / was[2]) for plan, z in family.divisions)
    return replace(family, divisions=divisions, box=replace(family.box, half=family.box.half * now / was))


def memory_of(plan: CellPlan, sheets: int, depth: float, polynomials: int) -> Array:
    """Return what a class of a division takes mixed and then reduced, (2,), by the module's formula [bytes].

    `sheets` are of the upper half, `depth` is how far from the rim current passes between them [m].
    """
    g, q, n = len(plan.group), polynomials, plan.cells.shape[0] * sheets
    u, c = sheets * most_unknowns(plan, depth), 2 if np.iscomplex(plan.characters).any() else 1
    dense = np.array([4.0 * n**2 + 2.0 * n * u + 2.0 * u**2, 5.0 * u**2 + 7.5 * q * u / min(g, 4)])
    return np.asarray(_SLACK * 8.0 * (2.0 * g * n**2 + max(g / 2, 1.0) * n * q + c * dense))


def _near_cost(
    divisions: Sequence[tuple[CellPlan, Array]], dense: Sequence[Array], depth: float
) -> tuple[float, float]:
    """Return the most that a near plate takes [bytes], with dense matrices of its divisions, and to reduce it [s]."""
    first = sorted(set(first_alike(divisions)))
    different = [divisions[k] for k in first]
    u = np.array([(z.size - 1) * most_unknowns(plan, depth) for plan, z in different], dtype=float)
    classes, c = np.array([(2 * len(p.characters), 1 + np.iscomplex(p.characters).any()) for p, _ in different]).T
    each = 8.0 * c * u**2
    mixed, whole = np.array(dense)[first].T
    making = np.cumsum(classes * each) - each + np.maximum(mixed, whole + 3.0 * each)
    return float(making.max()), _REDUCED * float(classes @ u**3)


def _interfaces(half: float, depth: float, parts: int) -> Array:
    """Return interfaces of the sheets of the upper half of a plate [m]."""
    if half < _SINGLE * depth:
        return np.array([0.0, half])
    return graded_axis(half, replace(_ACROSS, first=_ACROSS.first * depth).coarser(_LEVELS[1], parts))


def target_plan(target: Target, grading: Grading, orders: int) -> CellPlan:
    """Return the division of the target's outline, of a disc in angular orders up to some."""
    if target.shape == "rectangle":
        return rectangle_plan(*target.extent, grading)
    if target.is_round:
        return disc_plan(target.extent[0], grading, orders=orders, inner=target.hole)
    return outline_plan(target_outline(target), grading)


@lru_cache(maxsize=64)
def is_near(target: Target, clearance: float, rung: PlateRung) -> bool:
    """Say whether a plate is so close to the coils that its polynomials do not carry their field."""
    return unseen(field_box(target, clearance, rung)) > _UNSEEN


def field_box(target: Target, clearance: float, rung: PlateRung) -> Box:
    """Return the bounding box with the polynomials that a field singular `clearance` [m] below it needs."""
    rim = target_outline(target).rim
    half = np.array([*np.abs(rim).max(0) * (1.0 + 1e-3), target.thickness / 2])
    rates = [*(math.asinh(clearance / side) for side in half[:2]), math.acosh(1.0 + clearance / half[2])]
    order = [math.ceil(rung.terms / (2 * rate)) + extra for rate, extra in zip(rates, (3, 3, 2), strict=True)]
    short, long = (0, 1) if half[0] <= half[1] else (1, 0)
    order[short] = min(order[short], math.isqrt(_MOST // order[2]))
    order[long] = min(order[long], _MOST // (order[2] * order[short]))
    decay = math.exp(rates[0]), math.exp(rates[1]), math.exp(rates[2])
    return Box(half, (order[0], order[1], order[2]), decay, clearance)


@lru_cache(maxsize=64)
def field_length(coil: Coil, distance: float) -> float:
    """Return 1 / k of the root mean square wave number of a coil's field at a distance from its plane [m]."""
    k, weights = wave_numbers(_SHORTEST / distance, coil.outer_diameter)
    energy = source_spectrum(standing_rings(coil), k) ** 2 * np.exp(-2.0 * k * distance) * weights
    return float(np.sqrt(energy.sum() / (k**2 * energy).sum()))


def unseen(box: Box) -> float:
    """Return the share of the coils' field energy that the box's polynomials miss: rho^-2n."""
    return float(max(rho ** (-2.0 * n) for rho, n in zip(box.decay[:2], box.order[:2], strict=True)))
