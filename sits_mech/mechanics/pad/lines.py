"""Where do the lines of a pad's mesh run? Closer towards the target's edge and the bonded faces.

The i-th of m lines of a segment of length l lies ``l (i/m)**beta`` from the singular edge. Lengths in thicknesses.
"""

from __future__ import annotations

import numpy as np

from sits_mech.meshing.bricks import Outline, covered
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Elastomer, Target

_STRETCH = 3.0  # thicknesses of half target that one cell more than through the thickness is worth
_REACH = 1.25  # thicknesses beside the target within which the pad is stressed: one cell does beyond
_OUTER = 0.3  # of the outermost cell beside the target along x, split off: the tilt under shear hangs on it
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


def box_lines(plate: Outline, pad: Outline, cells: int, grading: float) -> tuple[Array, Array, Array]:
    """Return the lines of a box along x, along y from the middle on, and through the thickness; as `bonded_block`."""
    x = _half_lines(plate.half_x, pad.half_x, cells, grading, _OUTER)
    y = _half_lines(plate.half_y, pad.half_y, cells, grading, 0.0)
    return np.concatenate([-x[:0:-1], x]), y, lines_through(cells, grading, flush(plate, pad))


def _half_lines(edge: float, end: float, cells: int, grading: float, outer: float) -> Array:
    """Lines from the middle to the end of the pad, closer towards the target's edge; `outer` splits the last cell."""
    covers = end - edge < 1e-9
    inner = cells + int(edge / _STRETCH) + int(covers)
    lines = edge * (1.0 - (np.arange(inner, -1, -1) / inner) ** grading)
    if covers:
        return np.asarray(lines)
    far = end - edge > 1.5 * _REACH
    beside = (np.arange(cells + 1) / cells) ** grading
    if outer > 0.0 and not far:
        beside = np.insert(beside, cells, 1.0 - outer * (1.0 - beside[-2]))
    lines = np.concatenate([lines, edge + (_REACH if far else end - edge) * beside[1:]])
    return np.append(lines, end) if far else lines


def ring_lines(plate: Outline, pad: Outline, cells: int, grading: float) -> tuple[Array, Array]:
    """Lines from the core to the target's outline, and from there to the pad's."""
    inner = cells + int(max(plate[:2]) / _STRETCH)
    inside = 1.0 - (np.arange(inner, -1, -1) / inner) ** grading
    if flush(plate, pad):
        return inside, np.zeros(1)
    gap = min(pad.half_x - plate.half_x, pad.half_y - plate.half_y)
    lines = _half_lines(0.0, gap, cells, grading, _OUTER)
    return inside, lines[lines.searchsorted(0.0, "right") - 1 :] / gap


def lines_through(cells: int, grading: float, flush: bool) -> Array:
    """Lines through the thickness."""
    if not flush:
        return np.asarray(1.0 - (np.arange(cells, -1, -1) / cells) ** grading)
    s = np.linspace(0.0, 1.0, cells + 2)
    lower = 0.5 * (2.0 * np.minimum(s, 1.0 - s)) ** grading
    return np.where(s < 0.5, lower, 1.0 - lower)
