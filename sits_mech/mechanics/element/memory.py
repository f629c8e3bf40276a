"""Predict the memory of a layer's equations from the numbers of its cells.

It is predicted before stiffnesses or even the mesh are made. A mesh holds the gradients of its shape functions at its
quadrature points; each element has a stiffness; the factor holds L and W of each front, and while it is made, what the
halves of the pieces left (element/assembly.py). With P pivots and B in the border of a front, and the peak of what its
first and second half took,

    factor = sum P (P + B),    peak = max(peak_1, B_1^2 + peak_2, B_1^2 + B_2^2 + (P + B)^2 + P^2).

Of a box of bricks, or of a section of squares, P and B follow from the numbers of cells: pieces are boxes, too, that
are cut as element/dissection.py cuts them. A mesh in rings takes about as much as a box with as many cells around,
outwards and through the thickness. Left out: contact, a few percent; the two meshes of an error estimate count one by
one.
"""

from __future__ import annotations

from functools import lru_cache
from math import prod, sqrt
from typing import NamedTuple

from sits_mech.mechanics.element.dissection import leaf_size

NUMBER = 8  # bytes
_FREE, _SHARED, _HELD = 0, 1, 2  # what an end of a box is: free, shared with another piece, held

_End = tuple[int, int, int]  # cells along an axis, and what its two ends are


class Memory(NamedTuple):
    """Peak memory of a solution [bytes]."""

    mesh: int  # arrays of the mesh
    stiffness: int  # element stiffnesses
    factor: int
    working: int  # besides the factor while it is made


class FrontSize(NamedTuple):
    """A piece with its halves, in numbers held."""

    border: int  # size of its border
    factor: int  # of all its fronts
    peak: int  # largest at a time


def memory_of_box(cells: tuple[int, ...]) -> Memory:
    """Return the memory of a layer held at its lower face, from its cells along x, y, z, or x, z of a section."""
    d, e = len(cells), prod(cells)
    k = q = 3**d
    *across, through = cells
    whole = (*((count, _FREE, _FREE) for count in across), (through, _HELD, _FREE))
    piece = _box(whole, leaf_size(d * k))
    sizes = (e * per_element(q, d, k, d + 1, d == 2), e * (d * k) ** 2, piece.factor, piece.peak)
    return Memory(*(NUMBER * size for size in sizes))


def per_element(q: int, d: int, k: int, m: int, nodal: bool) -> int:
    """Return the numbers held per element: gradients, weights, pressures, four lists of displacements."""
    return q * (d * k + 1) * (2 if nodal else 1) + q * m + k + 4 * d * k


def front(P: int, B: int, halves: list[FrontSize]) -> FrontSize:
    """Combine the halves of a piece."""
    left, peak = 0, 0
    for half in halves:
        left, peak = left + half.border**2, max(peak, left + half.peak)
    factor = P * (P + B) + sum(half.factor for half in halves)
    return FrontSize(B, factor, max(peak, left + (P + B) ** 2 + P**2))


@lru_cache(maxsize=4096)
def _box(box: tuple[_End, ...], least: int) -> FrontSize:
    """Describe a box, cut down to pieces of at most `least` cells."""
    d, cells = len(box), prod(count for count, *_ in box)
    nodes = [2 * count + 1 - ends.count(_HELD) for count, *ends in box]
    own = [count - ends.count(_SHARED) for count, (_, *ends) in zip(nodes, box, strict=True)]
    border = d * (prod(nodes) - prod(own))
    if cells <= least:
        return front(d * prod(own), border, [])

    def cost(axis: int) -> float:
        """Return the cost of a cut as in element/dissection.py."""
        count = box[axis][0]
        return (1.0 + d * prod(own[:axis] + own[axis + 1 :])) / sqrt(count // 2 / count) if count > 1 else float("inf")

    axis = min(range(d), key=cost)
    (count, low, high), half = box[axis], box[axis][0] // 2
    ends = ((half, low, _SHARED), (count - half, _SHARED, high))
    halves = [_box((*box[:axis], end, *box[axis + 1 :]), least) for end in ends]
    return front(d * prod(own[:axis] + own[axis + 1 :]), border, halves)
