"""Order the displacements of a mesh for elimination by nested dissection of its elements.

The elements are cut in two where the fewest displacements are touched by both halves, the halves again, down to a few
elements. Of the tree of these pieces each displacement belongs to the smallest piece that holds all elements which
touch it, and is eliminated when that piece is put together from its two halves: what is inside of one half never meets
what is inside of the other. A piece's front has the displacements that it eliminates, its pivots, and a border that
belongs to larger pieces. With P pivots and B in the border a front costs ``P^3/3 + P^2 B + P B^2`` multiplications.

Cuts go along x, y or z, or around or away from the middle axis of what is round, between two layers of elements: of all
cuts the one with the fewest shared displacements, over the square root of the smaller half's part. Sources: A. George,
SIAM J. Numer. Anal. 10 (1973) 345, nested dissection; I. S. Duff, J. K. Reid, ACM Trans. Math. Softw. 9 (1983) 302,
fronts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import sparse

from sits_mech.mechanics.element.mesh import MixedMesh
from sits_mech.quantities import Array, Integers, Mask

_LEAF = 400  # displacements, counted for each element, below which a piece is not cut
_SAME = 1e-6  # of the extent: centres of elements in one layer
_PART = 1.0 / 32.0  # of the elements that a half has at least: irregular meshes would be peeled one by one


class Contribution(NamedTuple):
    """Stiffnesses that a front takes up."""

    group: int
    members: Integers  # which of the group
    places: Integers  # their rows in the front


class Child(NamedTuple):
    """A half of a front."""

    front: int
    runs: list[list[int]]  # runs of its border, (begin, end, begin in the front), (r, 3)


@dataclass(frozen=True)
class Front:
    """A piece of the mesh."""

    start: int  # first pivot in the order of elimination
    stop: int
    border: Integers  # (B,), displacements of larger pieces by place in the order, ascending
    halves: tuple[Child, ...]
    shares: tuple[Contribution, ...]  # stiffnesses of its elements, if it is not cut further

    @property
    def pivots(self) -> int:
        """Number of displacements it eliminates."""
        return self.stop - self.start


@dataclass(frozen=True)
class Dissection:
    """The tree of pieces, halves before the whole, and the order of the free displacements."""

    fronts: tuple[Front, ...]
    order: Integers


class _Tree(NamedTuple):
    """Pieces, halves before the whole."""

    halves: Integers  # (n, 2); -1 for an uncut piece
    whole: Integers
    first: Integers  # first uncut piece
    last: Integers  # last uncut piece
    leaf: Integers  # uncut piece of each element


def dissected(mesh: MixedMesh, own: Sequence[Integers], count: int) -> Dissection:
    """Return the order in which `count` free displacements are eliminated.

    `own`: free displacements (-1: none) of the dense stiffnesses, (e, k) each: elements first, then parts that may join
    distant elements.
    """
    tree = _tree(mesh, own[0])
    leaves = [tree.leaf, *(_nearest(numbers, own[0], tree.leaf) for numbers in own[1:])]
    low, high = _reach(own, leaves, count)
    owner = low.copy()
    while np.any(above := tree.last[owner] < high):
        owner[above] = tree.whole[owner[above]]
    order = np.lexsort((high, low, owner))
    rank = np.empty(count + 1, dtype=np.int64)
    rank[order], rank[-1] = np.arange(count), -1
    starts = np.searchsorted(owner[order], np.arange(len(tree.whole) + 1))
    return Dissection(_fronts(tree, starts, [rank[numbers] for numbers in own], leaves), order)


def leaf_size(count: int) -> int:
    """Return the number of elements, of `count` displacements each, in an uncut piece."""
    return max(1, _LEAF // count)


def _tree(mesh: MixedMesh, own: Integers) -> _Tree:
    """Bisect the elements recursively; `own` are their free displacements."""
    cells = mesh.cells
    d = own.shape[1] // cells.shape[1]
    weight = np.zeros(len(mesh.nodes))
    weight[cells] = (own >= 0).reshape(len(cells), d, -1).sum(axis=1)
    along, least = _coordinates(mesh.nodes[cells].mean(axis=1)), leaf_size(own.shape[1])
    halves: list[tuple[int, int]] = []
    leaf = np.zeros(len(cells), dtype=np.int64)

    def cut(members: Integers) -> int:
        """Number the pieces of some elements; return the number of the whole."""
        found = _cut(cells[members], along[:, members], weight) if len(members) > least else None
        if found is None:
            leaf[members] = len(halves)
            halves.append((-1, -1))
        else:
            first, shared = found
            weight[shared] = 0.0  # they count no more in what is cut further
            halves.append((cut(members[first]), cut(members[~first])))
        return len(halves) - 1

    cut(np.arange(len(cells)))
    count = len(halves)
    whole, first, last = np.full(count, -1), np.arange(count), np.arange(count)
    for number, (one, other) in enumerate(halves):
        if one >= 0:
            whole[[one, other]] = number
            first[number], last[number] = first[one], last[other]
    return _Tree(np.array(halves), whole, first, last, leaf)


def _coordinates(centres: Array) -> Array:
    """Return the coordinates along which elements are cut, shape (c, e)."""
    if centres.shape[1] == 2:
        return centres.T.copy()
    x, y = centres[:, :2].T
    return np.concatenate([centres.T, [np.hypot(x, y), np.arctan2(y, x)]])


def _cut(cells: Integers, along: Array, weight: Array) -> tuple[Mask, Integers] | None:
    """Return which elements are in the first half, and the shared nodes; None for elements in one place."""
    nodes, numbers = np.unique(cells, return_inverse=True)
    numbers = numbers.reshape(cells.shape)
    best, found = np.inf, None
    for x in along:
        order = np.argsort(x, kind="stable")
        layer = np.concatenate([[0], np.cumsum(np.diff(x[order]) > _SAME * (x[order[-1]] - x[order[0]]))])
        if layer[-1] == 0:
            continue
        low, high = _first_and_last(numbers[order], layer, len(nodes))
        begun, ended = (np.bincount(at, weight[nodes], layer[-1] + 1) for at in (low, high))
        shared = np.cumsum(begun - ended)[:-1]
        before = np.searchsorted(layer, np.arange(1, layer[-1] + 1)) / len(cells)
        less = np.minimum(before, 1.0 - before)
        cost = (1.0 + shared) / np.sqrt(less)
        cost[less < min(_PART, less.max())] = np.inf
        k = int(np.argmin(cost))
        if cost[k] < best * (1.0 - 1e-9):
            first = np.zeros(len(cells), dtype=bool)
            first[order] = layer <= k
            best, found = float(cost[k]), (first, nodes[(low <= k) & (high > k)])
    return found


def _first_and_last(numbers: Integers, layer: Integers, count: int) -> tuple[Integers, Integers]:
    """Return the first and last of the ascending layers that hold each number; -1 if none does."""
    flat, each = numbers.ravel(), np.repeat(layer, numbers.shape[1])
    low, high = np.full(count, -1), np.full(count, -1)
    high[flat] = each  # of repeated numbers the last one stays
    low[flat[::-1]] = each[::-1]
    return low, high


def _reach(own: Sequence[Integers], leaves: Sequence[Integers], count: int) -> tuple[Integers, Integers]:
    """Return the first and last uncut piece that touches each free displacement; the first if none does."""
    low, high = np.full(count + 1, np.iinfo(np.int64).max), np.full(count + 1, -1)
    for numbers, leaf in zip(own, leaves, strict=True):
        order = np.argsort(leaf, kind="stable")
        one, other = _first_and_last(numbers[order], leaf[order], count + 1)
        low, high = np.where(one >= 0, np.minimum(low, one), low), np.maximum(high, other)
    return np.where(high < 0, 0, low)[:-1], np.maximum(high, 0)[:-1]


def _nearest(numbers: Integers, elements: Integers, leaf: Integers) -> Integers:
    """Return the uncut piece that touches most of each row of numbers."""
    count = 1 + max(int(numbers.max(initial=0)), int(elements.max(initial=0)))

    def touched(rows: Integers, own: Integers) -> sparse.csr_matrix:
        on = own >= 0
        places = (np.broadcast_to(rows[:, None], own.shape)[on], own[on])
        found = sparse.csr_matrix((np.ones(len(places[0])), places), shape=(1 + int(rows.max(initial=0)), count))
        found.data[:] = 1.0
        return found

    shared = touched(np.arange(len(numbers)), numbers) @ touched(leaf, elements).T
    return np.asarray(shared.argmax(axis=1), dtype=np.int64).ravel() if len(numbers) else np.zeros(0, dtype=np.int64)


def _fronts(tree: _Tree, starts: Integers, ranks: Sequence[Integers], leaves: Sequence[Integers]) -> tuple[Front, ...]:
    """Return the fronts of the pieces, from the places of each group's displacements in the order."""
    held = [np.argsort(leaf, kind="stable") for leaf in leaves]
    bounds = [np.searchsorted(leaf[of], np.arange(len(tree.whole) + 1)) for leaf, of in zip(leaves, held, strict=True)]
    found: list[Front] = []
    for number, (start, stop) in enumerate(zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True)):
        halves = tree.halves[number][tree.halves[number] >= 0].tolist()  # none of an uncut piece
        some = [of[bound[number] : bound[number + 1]] for of, bound in zip(held, bounds, strict=True)]
        taken = [rank[members] for rank, members in zip(ranks, some, strict=True)]
        borders = [found[half].border for half in halves]
        rows = np.unique(np.concatenate([starts[:0], *borders, *(own.ravel() for own in taken if own.size)]))
        border = rows[rows >= stop]
        rows = np.concatenate([np.arange(start, stop), border])
        shares = (
            Contribution(group, members, np.where(own >= 0, np.searchsorted(rows, own), len(rows)))
            for group, (members, own) in enumerate(zip(some, taken, strict=True)) if len(members)
        )
        children = tuple(Child(half, _runs(np.searchsorted(rows, found[half].border), stop - start)) for half in halves)
        found.append(Front(start, stop, border, children, tuple(shares)))
    return tuple(found)


def _runs(places: Integers, pivots: int) -> list[list[int]]:
    """Split ascending places into runs that do not cross the end of the pivots: begin, end, begin in the front."""
    broken = np.flatnonzero((np.diff(places) != 1) | (places[1:] == pivots)) + 1
    begin, end = np.concatenate([[0], broken]), np.concatenate([broken, [len(places)]])
    return np.stack([begin, end, places[begin]], axis=1).tolist() if len(places) else []
