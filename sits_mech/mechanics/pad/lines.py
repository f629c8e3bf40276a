"""Lines of a pad's mesh, closer towards the target's edge and the bonded faces.

The i-th of n lines of a segment of length l lies ``l (i/n)**beta`` from the singular edge. A base has few cells: one
or more beside the target, under it and through the thickness. Every cell is divided into m parts so that the segment
keeps its grading: the meshes of m = 1, 2, 3, ... are a family, and errors go with a power of 1/m. Where the target is
much wider than the pad is thick nothing happens in its middle but the flow of pressure: base cells there grow by a
factor away from the edge. Some meshes have further layers at the edge alone: the cell that touches it is cut where
twice as many parts would have their first line, once for each layer. Meshes of m = 1, 2, 2 with a layer, 4, ... nest.
Lengths in thicknesses.
"""

from __future__ import annotations

import numpy as np

from sits_mech.meshing.bricks import Outline, covered
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Elastomer, Target

_STRETCH = 3.0  # thicknesses of half target that one base cell more than one is worth
_LONG = 6.0  # thicknesses from the target's edge from which on cells grow,
_GROWTH = 3.0  # by so much each
_REACH = 1.25  # thicknesses beside the target within which the pad is stressed: one base cell does beyond
_NEAR = 1.0  # thicknesses beside the target within which the corner of side and ground is loaded like the target's edge
_FLUSH = 1e-4  # thicknesses between the rims of target and layer up to which the two are flush
_CLEAR = 2.5e-3  # of a disc's radius that its rim keeps from the sides of a box: cells there would have no width


def outlines(target: Target, elastomer: Elastomer) -> tuple[Outline, Outline]:
    """Return target and pad seen from above [thicknesses]; a box touching a disc is widened a little."""
    t = elastomer.thickness
    plate, pad = ([length / (2.0 * t) for length in part.extent] for part in (target, elastomer))
    disc, cylinder = target.shape == "disc", elastomer.is_round
    if disc and not cylinder and plate[0] < (1.0 + 1e-9) * min(pad):
        pad = [max(size, (1.0 + _CLEAR) * plate[0]) for size in pad]
    if disc == cylinder:
        plate = [widened(*both) for both in zip(plate, pad, strict=True)]
    return Outline(plate[0], plate[1], disc), Outline(pad[0], pad[1], cylinder)


def widened(half_target: float, half_layer: float) -> float:
    """Return half the size of a target; its layer's where no cell has room between [thicknesses]."""
    return half_layer if 0.0 < half_layer - half_target < _FLUSH else half_target


def flush(plate: Outline, pad: Outline) -> bool:
    """Whether a target reaches a side of its pad, or goes on beyond it."""
    own = covered(plate, pad)
    return own is None or pad.half_x - own.half_x < 1e-9 or pad.half_y - own.half_y < 1e-9


def graded(split: int, grading: float, layers: int = 0) -> Array:
    """Return the lines of a segment of length 1 from its singular end (0): `split` parts, spacing power `grading`.

    The part that touches the end is cut `layers` times.
    """
    lines = (np.arange(split + 1) / split) ** grading
    cuts = lines[1] * 2.0 ** (-grading * np.arange(layers, 0, -1))
    return np.concatenate([lines[:1], cuts, lines[1:]])


def low_corner(plate: Outline, pad: Outline) -> bool:
    """Whether a side of the pad is so near its target that the corner at its foot is graded, too."""
    own = covered(plate, pad)
    return own is None or min(pad.half_x - own.half_x, pad.half_y - own.half_y) < _NEAR


def _both_ends(split: int, grading: float, layers: int) -> Array:
    """Return the lines of a segment of length 1 that is singular at both ends, of two base cells."""
    lower = 0.5 * graded(split, grading, layers)
    return np.concatenate([lower, 1.0 - lower[-2::-1]])


def box_lines(
    plate: Outline, pad: Outline, split: int, grading: float, layers: int = 0
) -> tuple[Array, Array, Array]:
    """Return the lines of a box along x, along y from the middle on, and through the thickness.

    Half sizes of target and pad in thicknesses; `split` parts of a base cell; grading and layers as in `graded`.
    """
    way = (split, grading, layers)
    x, y = (
        np.concatenate([under_lines(edge, *way), edge + beside_lines(end - edge, *way)[1:]])
        for edge, end in zip(plate[:2], pad[:2], strict=True)
    )
    return np.concatenate([-x[:0:-1], x]), y, lines_through(split, grading, low_corner(plate, pad), layers)


def ring_lines(plate: Outline, pad: Outline, split: int, grading: float, layers: int = 0) -> tuple[Array, Array]:
    """Return the lines from the core (0) to the target's outline (1), and from there (0) to the pad's (1)."""
    half = max(plate[:2])
    inside = under_lines(half, split, grading, layers) / half
    gap = min(pad.half_x - plate.half_x, pad.half_y - plate.half_y)
    return inside, np.zeros(1) if flush(plate, pad) else beside_lines(gap, split, grading, layers) / gap


def under_lines(edge: float, split: int, grading: float, layers: int = 0) -> Array:
    """Return the lines from the middle to the target's edge."""
    near = min(edge, _LONG)
    away = near * graded((1 + int(near / _STRETCH)) * split, grading, layers)
    last = away[-1] - away[-1 - split]
    while away[-1] < edge * (1.0 - 1e-9):
        left = edge - away[-1]
        last = left if left < 1.5 * _GROWTH * last else _GROWTH * last
        away = np.concatenate([away, away[-1] + last * np.arange(1, split + 1) / split])
    lines = edge - away[::-1]
    lines[0] = 0.0
    return np.asarray(lines)


def beside_lines(gap: float, split: int, grading: float, layers: int = 0) -> Array:
    """Return the lines from the target's edge (0) to the pad's side; none but the first where there is no gap."""
    if gap < 1e-9:
        return np.zeros(1)
    if gap < _NEAR:
        return np.asarray(gap * _both_ends(split, grading, layers))
    near = graded(split, grading, layers)
    if gap <= 1.5 * _REACH:
        return np.asarray(gap * near)
    return np.concatenate([_REACH * near, np.linspace(_REACH, gap, split + 1)[1:]])


def lines_through(split: int, grading: float, both: bool, layers: int = 0) -> Array:
    """Return the lines through the thickness, graded to the upper face or, for a singular lower corner, to both."""
    return _both_ends(split, grading, layers) if both else np.asarray(1.0 - graded(split, grading, layers)[::-1])
