"""Where do the lines of a pad's mesh run? Closer towards the target's edge and the bonded faces.

The i-th of n lines of a segment of length l lies ``l (i/n)**beta`` from the singular edge. A base has few cells: one
or more beside the target, under it and through the thickness. Every cell is divided into m parts so that the segment
keeps its grading: the meshes of m = 1, 2, 3, ... are a family, and errors go with a power of 1/m. Where the target is
much wider than the pad is thick nothing happens in its middle but the flow of pressure: base cells there grow by a
factor away from the edge. Lengths in thicknesses.
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
_FLUSH = 1e-4  # thicknesses between the rims of target and layer up to which the two are flush
_CLEAR = 2.5e-3  # of a disc's radius that its rim keeps from the sides of a box: cells there would have no width


def outlines(target: Target, elastomer: Elastomer) -> tuple[Outline, Outline]:
    """Return target and pad seen from above, a box a little wider than a disc that touches its side [thicknesses]."""
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
    """Say whether a target reaches a side of its pad, or goes on beyond it."""
    own = covered(plate, pad)
    return own is None or pad.half_x - own.half_x < 1e-9 or pad.half_y - own.half_y < 1e-9


def box_lines(plate: Outline, pad: Outline, split: int, grading: float) -> tuple[Array, Array, Array]:
    """Return the lines of a box along x, along y from the middle on, and through the thickness.

    Parameters
    ----------
    plate, pad : Outline
        Half the sizes of target and pad [thicknesses].
    split : int
        Parts of a base cell along each axis.
    grading : float
        Power of the lines' spacing towards the target's edge and the faces; 1 is uniform.
    """
    x, y = (
        np.concatenate([under_lines(edge, split, grading), edge + beside_lines(end - edge, split, grading)[1:]])
        for edge, end in zip(plate[:2], pad[:2], strict=True)
    )
    return np.concatenate([-x[:0:-1], x]), y, lines_through(split, grading, flush(plate, pad))


def ring_lines(plate: Outline, pad: Outline, split: int, grading: float) -> tuple[Array, Array]:
    """Return the lines from the core (0) to the target's outline (1), and from there (0) to the pad's (1)."""
    half = max(plate[:2])
    inside = under_lines(half, split, grading) / half
    gap = min(pad.half_x - plate.half_x, pad.half_y - plate.half_y)
    return inside, np.zeros(1) if flush(plate, pad) else beside_lines(gap, split, grading) / gap


def under_lines(edge: float, split: int, grading: float) -> Array:
    """Return the lines from the middle to the target's edge."""
    graded = min(edge, _LONG)
    fine = (1 + int(graded / _STRETCH)) * split
    away = graded * (np.arange(fine + 1) / fine) ** grading
    last = away[-1] - away[-1 - split]
    while away[-1] < edge * (1.0 - 1e-9):
        left = edge - away[-1]
        last = left if left < 1.5 * _GROWTH * last else _GROWTH * last
        away = np.concatenate([away, away[-1] + last * np.arange(1, split + 1) / split])
    lines = edge - away[::-1]
    lines[0] = 0.0
    return np.asarray(lines)


def beside_lines(gap: float, split: int, grading: float) -> Array:
    """Return the lines from the target's edge (0) to the pad's side; none but the first where there is no gap."""
    if gap < 1e-9:
        return np.zeros(1)
    graded = (np.arange(split + 1) / split) ** grading
    if gap <= 1.5 * _REACH:
        return np.asarray(gap * graded)
    return np.concatenate([_REACH * graded, np.linspace(_REACH, gap, split + 1)[1:]])


def lines_through(split: int, grading: float, flush: bool) -> Array:
    """Return the lines through the thickness: towards the upper face, or both where the lower corner is as singular."""
    if not flush:
        return np.asarray(1.0 - (np.arange(split, -1, -1) / split) ** grading)
    lower = 0.5 * (np.arange(split + 1) / split) ** grading
    return np.concatenate([lower, 1.0 - lower[-2::-1]])
