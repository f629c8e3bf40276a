"""Divide a pad into bricks where the rims of a disc and of a rectangle, both centred, cross.

A quarter of what they share, disc of radius r and rectangle |x| <= w, |y| <= h, has its rim from the x axis along the
side x = w as far as A, along the arc as far as B, and along y = h to the y axis; a side that the disc does not reach is
not there. It is divided in rings around a four-sided core whose corner looks at the middle M of the arc, or at the one
corner of the rim. What the target leaves free stands beside that:

    a disc on a box         between the arc and the box's corner C: the three-sided A B C, or four-sided where the disc
                            reaches one side alone
    a rectangle on a disc   between each side and the arc beyond it, three-sided

A three-sided piece is divided into three four-sided ones that meet within it, each with a corner of its own. The tips,
where the rims cross at the angle acos(w/r) or acos(h/r), are what limits this: small ones are refused, for the cells
there would have no width. Lengths in any unit.

Patches. A plan of four-sided Coons patches between curves has cells between lines, upright. A patch with the curves
b(s), a(s) below and above and l(t), r(t) at its left and right side has its points at

    X(s, t) = (1 - t) b(s) + t a(s) + (1 - s) l(t) + s r(t)
              - (1 - s)(1 - t) b(0) - s (1 - t) b(1) - (1 - s) t a(0) - s t a(1),

a blend of its sides. Source: S. A. Coons, Surfaces for Computer-Aided Design of Space Forms, MIT MAC-TR-41 (1967).
Patches that share a side must divide it alike; corners that lie on each other are one. Where every so many lines of a
patch are one of a base, the bricks have a division (bricks.py). Every node of the triquadratic bricks is placed by this
map, so that round sides are round. Lengths in any unit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree
from skfem import MeshHex2
from skfem.element import ElementHex1, ElementHex2

from sits_mech.geometry.meshing.bricks import (
    CORE,
    SAME,
    Bricks,
    PlateOutline,
    Subdivision,
    both_halves,
    concatenated,
    crossed,
    divided,
    mesh_of,
)
from sits_mech.quantities import Array, tensor_grid

LEAST_ANGLE = math.radians(10.0)
"""Between the rims where they cross."""
_SHORTEST = 0.02  # of the disc's radius, for the arc between two sides
Curve = Callable[[Array], Array]
"""From parameters 0 to 1, shape (n,), to points (n, 2)."""


class _Piece(NamedTuple):
    """A piece of the rim, the side of the core that it stands before, and how many cells stand along it."""

    rim: Curve
    begin: Array
    end: Array
    cells: int


def crossing_bricks(
    target: PlateOutline, pad: PlateOutline, lines: tuple[Array, Array, Array], around: int, split: int = 1
) -> tuple[MeshHex2, Subdivision]:
    """Return half a pad, y >= 0, under a target whose rim crosses the pad's, and the division of its bricks.

    `lines` go from the core (0) to the bonded rim (1), from there (0) away from it (1), and along z; `around` counts
    cells along each side and along half an arc; every `split`-th line is of the base. ValueError where the rims cross
    at too small an angle, or the arc between two sides is too short.
    """
    disc, box = (target, pad) if target.is_round else (pad, target)
    r, w, h = disc.half_x, box.half_x, box.half_y
    inside, outside, z = lines
    cuts = _cuts(r, w, h)
    pieces = _pieces(r, w, h, cuts, around)
    patches = [_core(pieces, len(cuts) == 2), *(_ring(piece, inside) for piece in pieces)]
    if target.is_round:
        patches += _beyond_arc(r, w, h, cuts, outside, around)
    else:
        patches += [own for axis in cuts for own in _beyond_side(r, (w, h), axis, outside, around)]
    quarter, division = patch_bricks(patches, z, split)
    return both_halves(quarter, axis=0), division.doubled


def _cuts(r: float, w: float, h: float) -> tuple[int, ...]:
    """Return which sides the disc crosses, 0 for x = w and 1 for y = h."""
    cuts = tuple(axis for axis, side in enumerate((w, h)) if side < r)
    for axis in cuts:
        angle = math.acos((w, h)[axis] / r)
        if angle < LEAST_ANGLE:
            raise ValueError(
                f"the rims of target and pad must not cross at less than {math.degrees(LEAST_ANGLE):.3g} deg; they do "
                f"at {math.degrees(angle):.3g} deg, for the rectangle's size along {'xy'[axis]} is "
                f"{(w, h)[axis] / r:.4g} of the disc's diameter"
            )
    if len(cuts) == 2 and (short := math.asin(h / r) - math.acos(w / r)) < _SHORTEST:
        raise ValueError(
            f"the corner of the rectangle must not end so near the rim of the disc: target and pad share {short:.2g} "
            f"radii of it, which must be {_SHORTEST} at least"
        )
    return cuts


def _ends(r: float, w: float, h: float) -> tuple[Array, Array]:
    """Return the ends A and B of the arc."""
    A = np.array([w, math.sqrt(r * r - w * w)]) if w < r else np.array([r, 0.0])
    B = np.array([math.sqrt(r * r - h * h), h]) if h < r else np.array([0.0, r])
    return A, B


def _pieces(r: float, w: float, h: float, cuts: tuple[int, ...], around: int) -> list[_Piece]:
    """Return the pieces of the rim from the x axis to the y axis, each before its part of the core's sides."""
    A, B = _ends(r, w, h)
    first, last = np.array([min(r, w), 0.0]), np.array([0.0, min(r, h)])
    rim = arc(A, B)
    curves = [rim] if len(cuts) == 1 else [part(rim, 0.0, 0.5), part(rim, 0.5, 1.0)]
    curves = [straight(first, A)] * (0 in cuts) + curves + [straight(B, last)] * (1 in cuts)
    counts = [2 * around if len(cuts) == 1 or k in (0, 3) else around for k in range(len(curves))]
    middle = rim(np.array([0.5]))[0] if len(cuts) == 2 else (A if 0 in cuts else B)
    corner, half = CORE * middle, len(curves) // 2
    sides = ((CORE * first, corner, curves[:half]), (corner, CORE * last, curves[half:]))
    at = [place for begin, end, own in sides for place in _along(begin, end, own)]
    return [_Piece(curve, *ends, count) for curve, ends, count in zip(curves, at, counts, strict=True)]


def _along(begin: Array, end: Array, curves: list[Curve]) -> list[tuple[Array, Array]]:
    """Return the ends of the parts of one side of the core, as long as the curves before them are."""
    u = np.linspace(0.0, 1.0, 33)
    lengths = np.array([float(np.linalg.norm(np.diff(curve(u), axis=0), axis=1).sum()) for curve in curves])
    share = np.concatenate([[0.0], np.cumsum(lengths) / lengths.sum()])
    points = begin + share[:, None] * (end - begin)
    return list(zip(points[:-1], points[1:], strict=True))


def _core(pieces: list[_Piece], both: bool) -> QuadPatch:
    """Return the core: its right side before the first pieces, its upper one before the others, from the y axis on."""
    half = len(pieces) // 2
    right, upper = pieces[:half], pieces[:half - 1:-1]
    x, y, corner, middle = right[0].begin, upper[0].end, right[-1].end, np.zeros(2)
    s = _shares([(piece.end, piece.begin, piece.cells) for piece in upper])
    t = _shares([(piece.begin, piece.end, piece.cells) for piece in right])
    return QuadPatch(straight(middle, x), straight(y, corner), straight(middle, y), straight(x, corner), s, t)


def _shares(parts: list[tuple[Array, Array, int]]) -> Array:
    """Return the lines along a straight side in parts, each with even cells, from 0 to 1."""
    lengths = np.array([float(np.linalg.norm(end - begin)) for begin, end, _ in parts])
    ends = np.concatenate([[0.0], np.cumsum(lengths) / lengths.sum()])
    each = [np.linspace(a, b, count + 1)[1:] for a, b, (*_, count) in zip(ends[:-1], ends[1:], parts, strict=True)]
    return np.concatenate([[0.0], *each])


def _ring(piece: _Piece, inside: Array) -> QuadPatch:
    """Return what lies between the core and a piece of the rim."""
    (rim_0, rim_1), even = piece.rim(np.array([0.0, 1.0])), np.linspace(0.0, 1.0, piece.cells + 1)
    return QuadPatch(straight(piece.begin, rim_0), straight(piece.end, rim_1), straight(piece.begin, piece.end),
                     piece.rim, inside, even)


def _beyond_arc(r: float, w: float, h: float, cuts: tuple[int, ...], outside: Array, around: int) -> list[QuadPatch]:
    """Return what of a box lies beside a disc."""
    (A, B), C = _ends(r, w, h), np.array([w, h])
    if len(cuts) == 2:
        return _three_sided(arc(A, B), straight(A, C), straight(B, C), outside, around)
    begin, end = (C, np.array([0.0, h])) if 0 in cuts else (np.array([w, 0.0]), C)
    return [QuadPatch(arc(A, B), straight(begin, end), straight(A, begin), straight(B, end),
                      np.linspace(0.0, 1.0, 2 * around + 1), outside)]


def _beyond_side(r: float, sides: tuple[float, float], axis: int, outside: Array, around: int) -> list[QuadPatch]:
    """Return what of a disc lies beyond one side of a rectangle."""
    tip = _ends(r, *sides)[axis]
    foot, top = (np.where(np.arange(2) == axis, size, 0.0) for size in (sides[axis], r))
    return _three_sided(straight(foot, tip), straight(foot, top), arc(tip, top), outside, around)


def _three_sided(bonded: Curve, first: Curve, second: Curve, outside: Array, around: int) -> list[QuadPatch]:
    """Return the three pieces of what lies between a bonded side and two curves from its ends to where they meet."""
    half = np.array([0.5])
    M, F, S = (curve(half)[0] for curve in (bonded, first, second))
    G = (M + F + S) / 3.0
    even = np.linspace(0.0, 1.0, around + 1)
    return [
        QuadPatch(part(bonded, 0.0, 0.5), straight(F, G), part(first, 0.0, 0.5), straight(M, G), even, outside),
        QuadPatch(part(bonded, 0.5, 1.0), straight(G, S), straight(M, G), part(second, 0.0, 0.5), even, outside),
        QuadPatch(straight(F, G), part(second, 1.0, 0.5), part(first, 0.5, 1.0), straight(G, S), even, even),
    ]


class QuadPatch(NamedTuple):
    """Four sides, and the lines from 0 to 1 between its cells: along s, and along t."""

    below: Curve
    above: Curve
    left: Curve
    right: Curve
    s: Array
    t: Array


def straight(begin: Array, end: Array) -> Curve:
    """Return the straight way between two points."""
    return lambda u: begin + np.multiply.outer(u, end - begin)


def arc(begin: Array, end: Array) -> Curve:
    """Return the shorter way around the origin between two points on a circle about it."""
    first, last = (float(np.arctan2(at[1], at[0])) for at in (begin, end))
    radius = float(np.hypot(*begin))

    def curve(u: Array) -> Array:
        angle = first + u * (last - first)
        return radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    return curve


def part(curve: Curve, begin: float, end: float) -> Curve:
    """Return what of a curve lies between two parameters; backwards where the second is the smaller."""
    return lambda u: curve(begin + u * (end - begin))


def patch_bricks(patches: Sequence[QuadPatch], z: Array, split: int = 1) -> tuple[MeshHex2, Subdivision]:
    """Return bricks over patches between lines along z, and their division; every `split`-th line is of the base."""
    points, places = (
        np.concatenate([_upright(patch, z, nodes) for patch in patches])
        for nodes in (ElementHex1().doflocs, ElementHex2().doflocs)
    )
    corners = points.reshape(-1, 3)
    size = SAME * float(np.ptp(corners[:, :2]))
    first = np.arange(len(corners))
    one, other = cKDTree(corners).query_pairs(size, output_type="ndarray").T
    np.minimum.at(first, other, one)
    used, numbers = np.unique(first, return_inverse=True)
    across = (crossed(divided(patch.s, split), divided(patch.t, split)) for patch in patches)
    division = concatenated([crossed(own, divided(z, split)) for own in across])
    return mesh_of(Bricks(corners[used], numbers.reshape(-1, 8), places)), division


def _upright(patch: QuadPatch, z: Array, nodes: Array) -> Array:
    """Return places (e, k, 3) of nodes of the unit cube, shape (k, 3), in every brick over a patch."""
    lines = (patch.s, patch.t, z)
    ends = [np.stack([own[:-1], own[1:]], axis=1) for own in lines]
    cells = tensor_grid(*(np.arange(len(own)) for own in ends)).reshape(-1, 3)
    s, t, up = (
        own[cell, 0][:, None] + np.diff(own, axis=1)[cell] * at
        for own, cell, at in zip(ends, cells.T, nodes.T, strict=True)
    )
    plan = _blended(patch, s.ravel(), t.ravel()).reshape(*s.shape, 2)
    return np.concatenate([plan, up[..., None]], axis=-1)


def _blended(patch: QuadPatch, s: Array, t: Array) -> Array:
    """Return points (n, 2) of a patch."""
    below, above = patch.below(s), patch.above(s)
    (b_0, b_1), (a_0, a_1) = (curve(np.array([0.0, 1.0])) for curve in (patch.below, patch.above))
    s, t = s[:, None], t[:, None]
    sides = (1.0 - s) * patch.left(t[:, 0]) + s * patch.right(t[:, 0])
    corners = (1.0 - t) * ((1.0 - s) * b_0 + s * b_1) + t * ((1.0 - s) * a_0 + s * a_1)
    return np.asarray((1.0 - t) * below + t * above + sides - corners)
