"""Lines of a pad under several targets, and what lies where on it: targets, slots, walls.

A tensor grid has lines through every side of every target, of the cover and of slots, graded towards them as
pad/shapes.py has them beside one target. Nothing is singular at the sides of the pad and of its pieces; at a wall
silicone is held, and at the edges of a slot's bottom it is as at the foot of a cover (pad/stack.py). Lengths in
thicknesses of the pad.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from sits_mech.geometry.meshing.bricks import PlateOutline
from sits_mech.mechanics.pad.shapes import GRADING, NEAR, graded, lines_through, low_corner, outside_lines, under_lines
from sits_mech.mechanics.pad.stack import Interface, covering, interfaces
from sits_mech.quantities import Array, Mask
from sits_mech.scene.cells import Cells
from sits_mech.scene.parts.elastomer import Elastomer
from sits_mech.scene.parts.slots import Slot

ONE = 1e-4
"""Thicknesses: sides of targets that are closer have one line."""


def scaled_ends(cells: Cells) -> Array:
    """Return the least and the largest x and y of each target, shape (n, 2, 2) [thicknesses]."""
    return cells.ends / cells.pad.thickness


def in_slots(slots: Sequence[Slot], pad: Elastomer, places: Array, slack: float = 0.0) -> Mask:
    """Return which places (n, 3) are in one of some slots of a pad."""
    found = np.zeros(len(places), dtype=bool)
    for slot in slots:
        (low, high), at = slot.ends / pad.thickness, places[:, slot.axis]
        found |= (at > low - slack) & (at < high + slack) & (places[:, 2] > slot.bottom(pad))
    return found


def inside_of(ends: Array, places: Array) -> Mask:
    """Return which places (n, 3) are under a target between ends (2, 2)."""
    low, high = ends
    return np.asarray(np.all((places[:, :2] > low - 2.0 * ONE) & (places[:, :2] < high + 2.0 * ONE), axis=1))


def cell_lines(cells: Cells, split: int, layers: int) -> tuple[Array, Array, Array]:
    """Return the lines of the pad along x, y and z [thicknesses]."""
    pad, t = cells.pad, cells.pad.thickness
    ends, half, way = scaled_ends(cells), 0.5 * np.array(pad.extent) / t, (split, GRADING, layers)
    x, y = (
        _lines_across(
            ends[:, :, k], float(half[k]), way, cells.cover_ends[:, k] / t,
            [_Cut(slot.ends / t, slot.bottom(pad), slot.wall) for slot in cells.slots if slot.axis == k],
        )
        for k in (0, 1)
    )
    around, whole = (PlateOutline(size[0], size[1], False) for size in (np.abs(ends).max(axis=(0, 1)), half))
    low = low_corner(around, whole) or any(_is_near(slot, cells) for slot in cells.slots)
    between = list(interfaces(pad))  # where layers meet, and the bottoms of slots
    for height in (slot.bottom(pad) for slot in cells.slots):
        if height > ONE:
            between = [each for each in between if abs(each.height - height) > ONE] + [Interface(height, True)]
    return x, y, lines_through(*way[:2], low, layers, tuple(sorted(between)), covering(cells.sensor))


class _Cut(NamedTuple):
    """A slot along an axis [thicknesses]."""

    sides: Array  # (2,)
    bottom: float
    wall: bool

    @property
    def parts(self) -> bool:
        """Whether it goes through the pad."""
        return self.bottom <= ONE


def _is_near(slot: Slot, cells: Cells) -> bool:
    """Return whether a slot goes through the pad so near a target that the corner at its foot is graded, too."""
    aside = np.abs(scaled_ends(cells)[:, :, slot.axis, None] - slot.ends / cells.pad.thickness).min()
    return slot.bottom(cells.pad) <= ONE and bool(aside < NEAR)


def _lines_across(
    ends: Array, half: float, way: tuple[int, float, int], foot: Array, cuts: Sequence[_Cut] = ()
) -> Array:
    """Return the lines along an axis of a pad from -half to half, over targets between `ends` (n, 2).

    `foot` are the ends of a cover, if any. Nothing is singular at the sides of the pad and its pieces.
    """
    free = np.concatenate([[-half, half], *(cut.sides for cut in cuts if cut.parts and not cut.wall)])
    sides, lines = [-half], [np.array([-half])]
    for side in np.sort(np.concatenate([ends.ravel(), foot, *(cut.sides for cut in cuts)])).tolist():
        sides += [side] if sides[-1] + ONE < side < half - ONE else []
    for low, high in pairwise([*sides, half]):
        middle = (low + high) / 2.0
        covered = bool(np.any((ends[:, 0] < middle) & (middle < ends[:, 1])))
        singular = np.abs(np.subtract.outer([low, high], free)).min(axis=1) > ONE
        inside = any(cut.parts and cut.sides[0] < middle < cut.sides[1] for cut in cuts)
        lines.append(np.array([high]) if inside else low + _segment(high - low, covered, singular.tolist(), way)[1:])
    return np.concatenate(lines)


def _segment(length: float, covered: bool, singular: Sequence[bool], way: tuple[int, float, int]) -> Array:
    """Return the lines of a segment from its lower end (0): below targets, or beside them, which ends are singular.

    A narrow gap is graded to the two targets alone: halfway there is no side of the pad.
    """
    half = length / 2.0
    if covered:
        own = under_lines(half, *way)
        return half + np.concatenate([-own[:0:-1], own])
    if all(singular):
        own = outside_lines(half, *way) if half > 1.0 else half * graded(*way)
        return np.concatenate([own, length - own[-2::-1]])
    own = outside_lines(length, *way)
    return own if singular[0] else length - own[::-1]
