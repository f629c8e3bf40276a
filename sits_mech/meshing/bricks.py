"""How is half a pad divided into bricks? Tensor grids for boxes, rings around a core where anything is round.

Half a plate or pad, y >= 0, is the image of half a square of size rho <= 1, on which ``e = (a, b)/rho``, rho the larger
of |a| and |b|, walks around the square's edge and stands for a place on an outline:

    rectangle   (a X, b Y)                      disc   R (cos theta, sin theta), theta linear in e on each side

A point of the target lies between a rectangular core and the target's outline T, one beside it between T and the pad's
outline P; lines are straight along rho. Every node of the triquadratic cells is placed by this map, so that round faces
are round. Source of the layout: the O-grid of structured meshing. Lengths in any unit; z starts at 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from skfem import MeshHex, MeshHex2
from skfem.element import ElementHex1

from sits_mech.quantities import Array

_SAME = 1e-9  # by which sizes that are equal as written may differ, relative
_CORE = 0.5  # where the core ends on the way from the middle to the target's outline
_SHRUNK = 0.8  # size of the core of a disc over that of the square around it


class Outline(NamedTuple):
    """A plate seen from above: half its sizes along x and y, and whether it is an ellipse or a rectangle."""

    half_x: float
    half_y: float
    is_round: bool


def within(outline: Outline, points: Array, slack: float) -> Array:
    """Say which points, shape (n, 2 or more), lie in an outline with `slack` around it."""
    a, b = np.abs(points[:, 0]) / (outline.half_x + slack), np.abs(points[:, 1]) / (outline.half_y + slack)
    return np.asarray(np.hypot(a, b) < 1.0 if outline.is_round else np.maximum(a, b) < 1.0)


def covered(plate: Outline, pad: Outline) -> Outline | None:
    """Return the outline of what a target covers of its pad, both centred: there they are bonded.

    Of two rectangles, or of two discs, the smaller size along each direction; of a disc and a rectangle the one that
    lies within the other. None where those two cross.
    """
    if plate.is_round == pad.is_round:
        return Outline(min(plate.half_x, pad.half_x), min(plate.half_y, pad.half_y), pad.is_round)
    return next((inner for inner, outer in ((plate, pad), (pad, plate)) if _holds(outer, inner)), None)


def _holds(outer: Outline, inner: Outline) -> bool:
    """Whether a disc lies within a rectangle, or a rectangle within a disc."""
    limit = 1.0 + _SAME
    if outer.is_round:
        return math.hypot(inner.half_x, inner.half_y) <= limit * outer.half_x
    return inner.half_x <= limit * outer.half_x and inner.half_y <= limit * outer.half_y


def box_bricks(x: Array, y: Array, z: Array) -> MeshHex:
    """Return the bricks between given lines."""
    return MeshHex.init_tensor(x, y, z)


def ring_bricks(target: Outline, pad: Outline, lines: tuple[Array, Array, Array], around: int) -> MeshHex2:
    """Return half a pad, y >= 0, in rings around a core.

    Parameters
    ----------
    target, pad : Outline
        The pad's is used where `lines` reach beyond the target.
    lines : tuple of ndarray
        From the core (0) to the target's outline (1); from there (0) to the pad's (1), or one value where both are the
        same; and along z.
    around : int
        Cells from a corner of the core to the next middle of a side; four times as many go around half the pad.
    """
    inside, beside, z = lines
    rho = np.concatenate([_CORE + (1.0 - _CORE) * inside, 1.0 + beside[1:]])
    flat, cells = _square(rho, around)
    quads = len(cells)
    points = np.vstack([np.column_stack([flat, np.full(len(flat), level)]) for level in z])
    corners = ElementHex1().doflocs.astype(int)
    hexes = np.empty((8, quads * (len(z) - 1)), dtype=np.int64)
    for k in range(len(z) - 1):
        for number, (i, j, up) in enumerate(corners):
            hexes[number, k * quads : (k + 1) * quads] = cells[:, i + 2 * j] + (k + up) * len(flat)
    straight = MeshHex2.from_mesh(MeshHex(points.T, hexes))
    placed = straight.doflocs.copy()
    placed[:2] = _placed(straight.doflocs[:2], target, pad)
    return MeshHex2(placed, straight.t)


def _square(rho: Array, around: int) -> tuple[Array, Array]:
    """Corners (n, 2) and cells (m, 4), as (0, 0), (1, 0), (0, 1), (1, 1), of half a square in rings around a core."""
    core = np.linspace(-1.0, 1.0, 2 * around + 1) * rho[0]
    a, b = np.meshgrid(core, core[around:], indexing="ij")
    inner = np.column_stack([a.ravel(), b.ravel()])
    index = np.arange(len(inner)).reshape(a.shape)
    walk = np.concatenate([index[-1, :], index[-2::-1, -1], index[0, -2::-1]])
    block = np.stack([index[:-1, :-1], index[1:, :-1], index[:-1, 1:], index[1:, 1:]], axis=-1).reshape(-1, 4)
    points, cells, last = [inner], [block], walk
    for number, size in enumerate(rho[1:]):
        ring = len(inner) + number * len(walk) + np.arange(len(walk))
        points.append(inner[walk] * size / rho[0])
        cells.append(np.stack([last[:-1], ring[:-1], last[1:], ring[1:]], axis=-1))
        last = ring
    return np.vstack(points), np.vstack(cells)


def _placed(flat: Array, target: Outline, pad: Outline) -> Array:
    """Where points of the square, shape (2, n), lie in the pad."""
    rho = np.abs(flat).max(axis=0)
    edge = flat / np.where(rho > 0.0, rho, 1.0)
    core = _on(Outline(target.half_x, target.half_y, False), edge) * (_SHRUNK if target.is_round else 1.0)
    part = np.clip((rho - _CORE) / (1.0 - _CORE), 0.0, 1.0)
    inside = (1.0 - part) * np.minimum(rho, _CORE) * core + part * _on(target, edge)
    beyond = np.clip(rho - 1.0, 0.0, 1.0)
    return np.asarray((1.0 - beyond) * inside + beyond * _on(pad, edge))


def _on(outline: Outline, edge: Array) -> Array:
    """Points of an outline, shape (2, n), that stand for points of the square's edge."""
    a, b = edge
    if outline.is_round:
        side = np.where(a > 0.0, b, 4.0 - b)
        theta = 0.25 * np.pi * np.where(np.abs(b) >= np.abs(a), 2.0 - a, side)
        a, b = np.cos(theta), np.sin(theta)
    return np.stack([outline.half_x * a, outline.half_y * b])
