"""How finely is a plate divided for the three-dimensional model, and down to which clearance does that carry?

A plate is prepared for all clearances from some on and all frequencies up to some (`stages`). Its coils' field is
singular a clearance below it, so that polynomials, and cells, grow in number like the plate's width over the clearance,
squared; below the `carried` clearance they would be too many (`near` goes on from there).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from sits_mech.geometry.outline import Outline, outline_plan, target_outline
from sits_mech.geometry.sheet_plan import Grading, Plan, disc_plan, graded_axis, rectangle_plan
from sits_mech.geometry.tracks import standing_rings
from sits_mech.magnetics.axis.dodd_deeds import spectrum
from sits_mech.magnetics.skin import skin_depth
from sits_mech.magnetics.space.fields import Box
from sits_mech.magnetics.space.modes import Sheeted, prepare_sheets
from sits_mech.magnetics.space.near import wave_numbers
from sits_mech.magnetics.space.sources import Sources
from sits_mech.scene.sensor import Coil, Target


@dataclass(frozen=True)
class Rung:
    """How fine the coarser of the two divisions is.

    Attributes
    ----------
    skin : float
        First cell and sheet at the surface over the skin depth.
    growth : float
        Ratio of neighbouring cells.
    along : float
        Largest cell over the length on which the coils' field changes (`field_length`).
    across : float
        Largest cell over the plate's half width.
    terms : float
        Digits (natural logarithm) the coils' field keeps.
    """

    skin: float
    growth: float
    along: float
    across: float
    terms: float


# Asked error of the change of inductance -> division of the plate; measured in studies/benchmark_sheets.py.
LADDER = (
    (1e-2, Rung(skin=2.5, growth=4.0, along=0.8, across=0.4, terms=7.0)),
    (5e-3, Rung(skin=2.0, growth=4.0, along=0.6, across=0.33, terms=8.0)),
    (2e-3, Rung(skin=1.6, growth=3.4, along=0.41, across=0.25, terms=9.0)),
    (1e-3, Rung(skin=1.5, growth=2.9, along=0.34, across=0.2, terms=10.0)),
)
_FINEST = 0.16  # smallest the largest cell may get, over the half width
_MOST = 2000  # polynomials in all; what a wide plate close to the coils misses is in its estimated error
_UNSEEN = 1e-3  # share of the field that may be missed
_APART = 2.0  # digits more (natural logarithm) for coils that need fewer polynomials
_RESISTIVE = 0.8  # where the current fills the thickness, cells are smaller by this


@lru_cache(maxsize=32)
def prepared(
    target: Target, outline: Outline | None, rung: Rung, scale: tuple[float, float, float, float],
    sources: Sources | None = None,
) -> tuple[Sheeted, ...]:  # fmt: skip
    """Return the target on a fine and a coarse division, prepared for a range of clearance and frequency.

    `scale` has the clearance from which on it holds [m], the frequency up to which it does [Hz], how far from the
    target's middle the coils' currents call for small cells, and the length on which their field changes [m]. `sources`
    are the coils, if it stands still.
    """
    clearance, depth = scale[0], skin_depth(scale[1], target.metal.conductivity)
    box = field_box(target, outline, clearance, rung)
    half = box.half
    width = min(float(half[:2].min()), scale[2])
    largest = min(rung.along * scale[3], rung.across * width)
    largest = max(largest, _FINEST * width) * (_RESISTIVE if 2 * depth > target.thickness else 1.0)
    first = min(rung.skin * depth, largest)
    divisions = []
    for halvings in (1, 0):
        grading = Grading(first, rung.growth, largest, halvings, scale[2])
        levels = graded_axis(target.thickness / 2, grading, target.thickness / 2)
        divisions.append((_plan(target, outline, grading, max(box.order[:2])), levels))
    return prepare_sheets(divisions, target.metal.conductivity, box, depth=min(depth, target.thickness / 2),
                          sources=sources)  # fmt: skip


def _plan(target: Target, outline: Outline | None, grading: Grading, orders: int) -> Plan:
    """Division of the target's outline."""
    if outline is None and target.shape == "rectangle":
        return rectangle_plan(*target.extent, grading)
    if outline is None and target.shape == "disc":
        return disc_plan(target.extent[0], grading, orders=orders)
    return outline_plan(target_outline(target, outline), grading)


def carried(target: Target, outline: Outline | None, clearance: float, rung: Rung) -> float:
    """Return the clearance, or the first of its doubles, from which on a plate's polynomials carry the coils' field."""
    while unseen(field_box(target, outline, clearance, rung)) > _UNSEEN:
        clearance *= 2.0
    return clearance


def field_box(target: Target, outline: Outline | None, clearance: float, rung: Rung) -> Box:
    """Return the bounding box with the polynomials that a field singular `clearance` [m] below it needs."""
    rim = target_outline(target, outline).rim
    half = np.array([*np.abs(rim).max(0) * (1.0 + 1e-3), target.thickness / 2])
    rates = [math.asinh((clearance + half[2]) / side) for side in half]
    order = [math.ceil(rung.terms / (2 * rate)) + extra for rate, extra in zip(rates, (3, 3, 1), strict=True)]
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


