"""Lines across and along the axis that bound the cells of coaxial discs and of the air around them.

A line lies on every face and every rim. Between them the cells grow from these in proportion to the distance, on both
sides alike: a rim is singular where a disc is permeable or its skin thin. The first cell is a share of the skin depth,
of a permeable disc of its thickness as well, whichever is smaller. Where a disc sees the coil, cells are besides no
larger than the distance to the nearest track; of that size their number across and along is all that more tracks ask.

Away from the discs the cells grow on up to the far boundary, at `_FAR` times their size: of a steel disc (radius 4 mm,
mu_r 200, 1 MHz) the change of L is then right to 1e-8, with 8 times to 1e-6, with 4 times to 4e-5; of copper to a tenth
of these.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.geometry.windings import Sections
from sits_mech.magnetics.modes import skin_depth
from sits_mech.quantities import Array, integrals

_FAR = 20.0  # of the discs' radius, or half height
_SKIN, _EDGE = 0.7, 0.5  # first cell over skin depth, over thickness
_CORNER = 0.02  # over thickness of a permeable disc: ferrite's rims are off by 5e-5 of Delta L from 0.1 on
_SHARPER = 3.0  # power of the fineness by which first cells at permeable rims shrink: their error goes as h^(4/3)
_GROWTH, _NEAR, _SHARE = 1.0, 1.0, 0.25  # cell over distance from a face or rim, from a track, over radius
_LEAST = 1e-6  # of the radius: the smallest first cell
_SAME = 1e-9  # of the reach: rims as near as that are one
_SAMPLES = 300  # of a size along a span, and on each side of a face or rim


@dataclass(frozen=True)
class CoaxialDisc:
    """A disc about the coil's axis, or a ring."""

    radius: float  # [m]
    bottom: float  # z of its lower face [m]
    top: float  # z of its upper face [m]
    conductivity: float  # [S/m]
    permeability: complex  # mu_r (1 - j tan delta)
    inner: float = 0.0  # radius of its hole [m]

    @property
    def rims(self) -> tuple[float, ...]:
        """Radii of its rims [m]."""
        return (self.inner, self.radius) if self.inner > 0.0 else (self.radius,)

    def away(self, tracks: Sections) -> float:
        """Return its distance from the nearest of the coil's tracks [m]."""
        out, into = tracks.radius - self.radius, self.inner - tracks.radius
        radial, half = np.maximum(np.maximum(out, into) - tracks.width / 2, 0.0), tracks.height / 2
        above = np.maximum(np.maximum(tracks.z - half - self.top, self.bottom - tracks.z - half), 0.0)
        return max(float(np.hypot(radial, above).min()), _LEAST * self.radius)

    def first_cell(self, frequency: float, fineness: float) -> float:
        """Return the size of the cells at its faces and rim [m]."""
        thickness, magnetic = self.top - self.bottom, self.permeability != 1.0
        first = min(_SKIN * skin_depth(frequency, self.conductivity, abs(self.permeability)), _EDGE * thickness)
        if magnetic:
            first = min(first, _CORNER * thickness)
        return max(first * float(fineness ** (_SHARPER if magnetic else 1.0)), _LEAST * self.radius)


@dataclass(frozen=True)
class Lines:
    """Edges of the cells."""

    r: Array  # from the axis to the far boundary [m]
    z: Array  # from below to above [m]

    def unknowns(self, order: int) -> int:
        """Return the number of unknowns of elements of an order."""
        return int(order * (self.r.size - 1) * (order * (self.z.size - 1) + 1))


def divide_axis(discs: Sequence[CoaxialDisc], tracks: Sections, frequency: float, fineness: float) -> Lines:
    """Return the lines for some discs over or under a coil; `fineness` is 1 for the coarsest cells that are of use."""
    firsts = [disc.first_cell(frequency, fineness) for disc in discs]
    faces = np.sort([face for disc in discs for face in (disc.bottom, disc.top)])
    widest, middle = max(disc.radius for disc in discs), (faces[0] + faces[-1]) / 2
    far = _FAR * max(widest, (faces[-1] - faces[0]) / 2)
    rims = np.sort([rim for disc in discs for rim in disc.rims])
    rims = rims[np.append(np.diff(rims) > _SAME * widest, True)]

    def across(r: Array) -> Array:
        """Return the largest cells at distances from the axis."""
        size = np.full(r.shape, np.inf)
        for disc, first in zip(discs, firsts, strict=True):
            radial, half = np.maximum(np.abs(r[:, None] - tracks.radius) - tracks.width / 2, 0.0), tracks.height / 2
            above = np.maximum(np.maximum(tracks.z - half - disc.top, disc.bottom - tracks.z - half), 0.0)
            away = np.maximum(np.hypot(radial, above).min(axis=1), _LEAST * disc.radius)
            own = np.minimum(_NEAR * away, _SHARE * disc.radius)
            size = np.minimum(size, np.where((r >= disc.inner) & (r <= disc.radius), fineness * own, np.inf))
            for rim in disc.rims:
                size = np.minimum(size, first + fineness * _GROWTH * np.abs(r - rim))
        return size

    def along(z: Array) -> Array:
        """Return the largest cells at heights."""
        size = np.full(z.shape, np.inf)
        for disc, first in zip(discs, firsts, strict=True):
            from_face = np.minimum(np.abs(z - disc.bottom), np.abs(z - disc.top))
            near = fineness * _NEAR * (disc.away(tracks) + from_face)
            size = np.minimum(np.minimum(size, near), first + fineness * _GROWTH * from_face)
        return size

    return Lines(
        _joined(np.array([0.0, *rims, far]), across),
        _joined(np.array([middle - far, *faces, middle + far]), along),
    )


def _joined(corners: Array, size: Callable[[Array], Array]) -> Array:
    """Return the lines between corners, these included, whose distances follow `size`."""
    reach = float(corners[-1] - corners[0])
    steps = reach * np.geomspace(_LEAST / 100, 1.0, _SAMPLES)
    near = (corners[:, None] + np.concatenate([-steps, [0.0], steps])).ravel()
    parts = [corners[:1]]
    for start, stop in zip(corners[:-1], corners[1:], strict=True):
        x = np.unique(np.concatenate([near[(near > start) & (near < stop)], np.linspace(start, stop, _SAMPLES)]))
        count = integrals(1.0 / size(x), x)
        cells = np.linspace(0.0, count[-1], max(1, int(np.ceil(count[-1]))) + 1)[1:-1]
        parts += [np.interp(cells, count, x), np.array([stop])]
    return np.concatenate(parts)
