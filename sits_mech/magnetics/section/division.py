"""Divide a plate's section into bars, with two coarser divisions that estimate and mend the finest one's error.

A rectangle is symmetric about both middle planes: its quadrant x, z > 0 and four parities describe it whole. The
quadrant has tensor cells, fine at the faces and the ends, in numbers that four divides. Joining them two by two in both
directions gives the middle division, once more the coarse one. With uniform current in each bar a result's error goes
with the square of the cells, so that from two divisions

    Y = Y_fine + (Y_fine - Y_middle) / 3

is better than either; the same from the middle and the coarse one is the check. A joined cell's mean is the mean of
its parts by area, so that the coarser inductances and couplings cost nothing more: with P the shares of the area,

    L_coarse = P L P^T,   B_coarse = B P^T.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from sits_mech.quantities import Array

_LEVELS = 3


@dataclass(frozen=True)
class Resolution:
    """How fine the plate is divided."""

    skin: float  # first cell at the surface over the skin depth
    growth: float  # ratio of neighbouring cells
    along: float  # largest cell along over a quarter of the width; through, over the thickness
    near: float  # largest cell along and first one below the faces, over the field's grain
    terms: float  # digits (natural logarithm) that the samples keep


@dataclass(frozen=True)
class Lengths:
    """Smallest lengths that a prepared plate resolves."""

    clearance: float  # distance to a coil or to another plate [m]
    grain: float  # over which the field along the plate changes: the clearance, or more near wide coils [m]
    skin_depth: float  # [m]


@dataclass(frozen=True)
class Cells:
    """Rectangular cells."""

    x: Array  # (n,) centres [m]
    z: Array  # (n,)
    width: Array  # (n,) along x [m]
    height: Array  # (n,) along z [m]


@dataclass(frozen=True)
class Division:
    """One quadrant's cells."""

    cells: Cells  # bars of the quadrant x, z > 0 about the section's centre
    share: csr_array  # (cells, finest cells) P: part of each finest cell in a cell's area

    def joined(self, matrix: Array) -> Array:
        """Return the means over this division's cells of a matrix (finest cells, n) of means over the finest ones."""
        return np.asarray(self.share @ matrix)


def divisions(size: tuple[float, float], resolution: Resolution, lengths: Lengths) -> tuple[Division, ...]:
    """Return the finest, the middle and the coarse division of a section of width w and thickness t [m]."""
    x, z = (_nodes(*ends) for ends in _grading(size, resolution, lengths))
    finest = _quadrant_cells(x, z)
    found = []
    for level in range(_LEVELS):
        step = 2**level
        cells = _quadrant_cells(x[::step], z[::step])
        i, k = (n.ravel() // step for n in np.meshgrid(np.arange(x.size - 1), np.arange(z.size - 1), indexing="ij"))
        rows = i * ((z.size - 1) // step) + k
        area = finest.width * finest.height / (cells.width * cells.height)[rows]
        share = csr_array((area, (rows, np.arange(rows.size))), shape=(cells.x.size, rows.size))
        found.append(Division(cells, share))
    return tuple(found)


def bars_of(size: tuple[float, float], resolution: Resolution, lengths: Lengths) -> int:
    """Return how many bars the finest division has, without dividing; arguments as of `divisions`."""
    counts = []
    for ends in _grading(size, resolution, lengths):
        sizes, equal = _sizes(*ends)
        counts.append(_parts(len(sizes) + equal))
    return 4 * counts[0] * counts[1]


def _grading(
    size: tuple[float, float], resolution: Resolution, lengths: Lengths
) -> tuple[tuple[float, float, float, float], ...]:
    """Return half a side, its first and largest cell [m] and their growth, along and across."""
    width, thickness = size
    near = resolution.near * lengths.grain
    first = min(resolution.skin * lengths.skin_depth, near)
    largest = min(near, resolution.along * width / 4), resolution.along * thickness
    along, across = (min(first, most) for most in largest)
    return (
        (width / 2, along, largest[0], resolution.growth),
        (thickness / 2, across, largest[1], resolution.growth),
    )


def _sizes(length: float, first: float, largest: float, growth: float) -> tuple[list[float], int]:
    """Return cells that grow from `first` up to `length` or the largest, and how many largest ones follow."""
    sizes = [min(first, length)]
    filled = sizes[0]
    while filled < length and sizes[-1] < largest:
        sizes.append(min(growth * sizes[-1], largest))
        filled += sizes[-1]
    return sizes, max(math.ceil((length - filled) / largest), 0)


def _parts(count: int) -> int:
    """Return how many cells are made of graded ones: a number that the levels divide."""
    parts: int = 2 ** (_LEVELS - 1)
    return parts * -(-count // parts)


def _graded(length: float, first: float, largest: float, growth: float) -> Array:
    """Return nodes of [0, length]: cells grow from `first`, at the end, by at most `growth` up to `largest`."""
    sizes, equal = _sizes(length, first, largest, growth)
    steps = np.concatenate([sizes, np.full(equal, largest)])
    nodes = length - np.concatenate([[0.0], np.cumsum(steps * (length / steps.sum()))])
    nodes[-1] = 0.0
    return np.asarray(nodes[::-1])


def _quadrant_cells(nodes_x: Array, nodes_z: Array) -> Cells:
    """Return tensor cells between the nodes of two half axes."""
    x, z = np.meshgrid((nodes_x[1:] + nodes_x[:-1]) / 2, (nodes_z[1:] + nodes_z[:-1]) / 2, indexing="ij")
    width, height = np.meshgrid(np.diff(nodes_x), np.diff(nodes_z), indexing="ij")
    return Cells(x.ravel(), z.ravel(), width.ravel(), height.ravel())


def _nodes(length: float, first: float, largest: float, growth: float) -> Array:
    """Return graded nodes of [0, length], their intervals in a number that four divides."""
    from scipy.interpolate import PchipInterpolator

    nodes = _graded(length, first, largest, growth)
    count = nodes.size - 1
    if count == 1:
        return np.linspace(0.0, length, _parts(1) + 1)
    wanted = np.linspace(0.0, count, _parts(count) + 1)
    return np.asarray(PchipInterpolator(np.arange(count + 1), nodes)(wanted))
