"""Lines of a layer's section, graded towards its corners, and its fillets.

Fillets have a stated edge radius, where the layer's free side faces meet the rigid plates. A sharp bonded corner is
singular: displacements go as ``r**0.59`` at a right angle between a clamped and a free face of an incompressible layer,
strains grow without bound, and poses converge as ``h**1.19``. For smaller angles the exponent k, the smallest root of
``cos(k angle) = k sin(angle)``, grows; it is 1 at 45 degrees, from where strains are bounded, and 1.47 at the 30
degrees used here (D. Leguillon, E. Sanchez-Palencia, Computation of Singular Solutions in Elliptic Problems and
Elasticity (1987)): poses then converge as ``h**2.9``.

So the side face is drawn in between the plates, whose bonded widths stay, and reaches a plate along an arc of radius r,
concave like a meniscus, that leaves the side face smoothly and ends 30 degrees from the plate:

    x(z) = half width - r/2 + r - sqrt(r**2 - (c - z)**2)    for z < c = r sin 60,        half width - r/2    above.

At a target flush with the layer likewise from above. A target narrower than the layer ends in the middle of a flat
face: there is no side face at its edge that could have a fillet, and that edge stays singular. Lengths in thicknesses.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from sits_mech.quantities import Array
from sits_mech.units import millimetres as mm

_SWEPT = np.pi / 3.0  # of the arc, from the side face to 30 degrees from the plate
_LEAST = 0.05  # thicknesses, the smallest radius that a mesh resolves
SLACK = 1e-4
"""Of a count of cells: sizes that are round keep theirs where they change a little, as for derivatives (1e-6)."""
_FILL = 0.9  # of the height, or of the width beside the target, that fillets may take


class Fillet(NamedTuple):
    """Fillets of a layer."""

    radius: float  # [thicknesses]
    half_layer: float  # half width [thicknesses]
    half_target: float  # half width [thicknesses]

    @property
    def flush(self) -> bool:
        """Whether the layer ends with its target."""
        return self.half_layer - self.half_target < 1e-9

    @property
    def height(self) -> float:
        """Height of one arc."""
        return float(self.radius * np.sin(_SWEPT))

    @property
    def drawn(self) -> float:
        """How far the side face is drawn in."""
        return float(self.radius * (1.0 - np.cos(_SWEPT)))


def fitting_fillet(fillet: Fillet, thickness: float) -> Fillet:
    """Return a fillet that fits a layer of `thickness` [m].

    Raise ValueError for a radius that does not fit between the plates or beside the target, or that no mesh resolves.
    """
    tall = _FILL / (2.0 if fillet.flush else 1.0) / np.sin(_SWEPT)
    room = fillet.half_layer if fillet.flush else fillet.half_layer - fillet.half_target
    most = min(tall, _FILL * room / (1.0 - np.cos(_SWEPT)))
    if not _LEAST <= fillet.radius <= most:
        raise ValueError(
            f"elastomer.edge_radius: must lie between {mm(_LEAST * thickness)} and {mm(most * thickness)} for this "
            f"layer and target; got {mm(fillet.radius * thickness)}"
        )
    return fillet


def fillet_lines(fillet: Fillet, cells: int, grading: float) -> tuple[Array, Array]:
    """Return mesh lines along x and z before the sides are drawn in: even over the arcs, graded away from them.

    `cells` through the thickness without fillets, half as many along an arc; `grading`: power of the spacing, 1 is
    uniform.
    """
    along, c = max(1, cells // 2), fillet.height
    arc = np.linspace(0.0, c, along + 1)

    def segment(start: float, end: float) -> Array:
        """Return lines whose smallest spacing is an arc's: up to twice the cells, then a stronger grading."""
        fewest, ratio = matched_cells(end - start, cells, grading), max(1.0, 0.5 * (end - start) * along / c)
        count = max(fewest, min(2 * fewest, 2 * int(np.ceil(ratio ** (1.0 / grading) - SLACK))))
        power = grading if count == 2 else max(grading, np.log(ratio) / np.log(0.5 * count))
        return graded_segment(start, end, count, power)

    end = 1.0 - c if fillet.flush else 1.0
    z = np.concatenate([arc, segment(c, end)[1:], (1.0 - arc[-2::-1]) if fillet.flush else []])
    wide, narrow = fillet.half_layer, fillet.half_target
    if fillet.flush:
        return segment(-wide, wide), z
    outside, under = segment(narrow, wide), matched_cells(2.0 * narrow, cells, grading)
    return np.concatenate([-outside[:0:-1], graded_segment(-narrow, narrow, under, grading), outside[1:]]), z


def drawn_in(fillet: Fillet, places: Array) -> Array:
    """Map places x, z, shape (n, 2), of a rectangle to the filleted section; those under the target stay.

    Of a flush layer the whole width follows the sides, in proportion to the distance from the middle.
    """
    x, z = places.T
    near = np.minimum(z, 1.0 - z) if fillet.flush else z
    left = np.maximum(fillet.height - near, 0.0)
    flare = fillet.radius - np.sqrt(fillet.radius**2 - left**2)
    inner = 0.0 if fillet.flush else fillet.half_target
    share = np.maximum(np.abs(x) - inner, 0.0) / (fillet.half_layer - inner)
    return np.stack([x - np.sign(x) * share * (fillet.drawn - flare), z], axis=1)


def graded_segment(start: float, end: float, cells: int, beta: float) -> Array:
    """Return ``cells + 1`` mesh lines, rising and symmetric, graded towards both ends; ValueError for odd `cells`."""
    if cells < 2 or cells % 2 or not end > start or not beta >= 1.0:
        raise ValueError(f"segment: needs even cells, start < end, beta >= 1, not {cells}, {start}..{end}, {beta}")
    half = 0.5 * np.linspace(0.0, 1.0, cells // 2 + 1) ** beta
    unit = np.concatenate([half, 1.0 - half[-2::-1]])
    return start + (end - start) * unit


def graded_lines(breaks: Sequence[float], cells: Sequence[int], beta: float) -> Array:
    """Return mesh lines through all `breaks`, graded towards each; an even number of cells for each segment."""
    pieces = [graded_segment(a, b, n, beta) for a, b, n in zip(breaks[:-1], breaks[1:], cells, strict=True)]
    return np.concatenate([pieces[0]] + [piece[1:] for piece in pieces[1:]])


def matched_cells(length: float, cells: int, beta: float) -> int:
    """Return the even number of cells that gives a segment the same smallest cell as one of length 1 has."""
    return 2 * max(1, int(np.ceil(0.5 * cells * length ** (1.0 / beta) - SLACK)))


def divided_lines(lines: Array, near: float, parts: int) -> Array:
    """Return lines whose cells within a distance of the axis are divided, as by i of so many parts at near (i/parts)^2.

    What touches there begins at the axis, and cells are about as small beside the radius that it has come to.
    """
    if near == 0.0:
        return lines
    found = list[Array]()
    for ends in pairwise(lines):
        begin, end = np.sign(ends) * np.sqrt(np.abs(ends) / near)
        count = int(np.ceil((end - begin) * parts - SLACK)) if min(np.abs(ends)) < near else 1
        roots = np.linspace(begin, end, count, endpoint=False)
        found.append(near * np.sign(roots) * roots**2)
        found[-1][0] = ends[0]
    return np.append(np.concatenate(found), lines[-1])
