"""Divide half a pad into bricks: tensor grids for boxes, rings around a core where anything is round.

A mesh is a base whose cells are each divided into m parts along every axis. The meshes of one base are a family: where
in its base cell each cell lies, in the coordinates of the reference brick, is its division.

Half a plate or pad, y >= 0, is the image of half a square of size rho <= 1, on which ``e = (a, b)/rho``, rho the larger
of |a| and |b|, walks around the square's edge and stands for a place on an outline:

    rectangle   (a X, b Y)                      disc   R (cos theta, sin theta), theta linear in e on each side

A point of the target lies between a rectangular core and the target's outline T, one beside it between T and the pad's
outline P; lines are straight along rho. Every node of the triquadratic cells is placed by this map, so that round faces
are round. Source of the layout: the O-grid of structured meshing. Lengths in any unit; z starts at 0.

Bricks have 27 nodes each; copies are numbered alike, one after the other, and share corners that lie on each other.
Pillars are each divided in rings like a cylinder of its own, pillars on the plane y = 0 by their halves; they touch
nowhere, and each has base cells of its own.

A cover's outline may be a third one, between the target's and the pad's (inclusion.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from skfem import MeshHex, MeshHex2
from skfem.assembly import Dofs
from skfem.element import ElementHex1, ElementHex2

from sits_mech.quantities import Array, Integers, Mask, tensor_grid

SAME = 1e-9  # by which sizes that are equal as written may differ, relative
CORE = 0.5  # where the core ends on the way from the middle to the target's outline
_SHRUNK = 0.8  # size of the core of a disc over that of the square around it


class PlateOutline(NamedTuple):
    """A plate seen from above: half its sizes along x and y, and whether it is an ellipse or a rectangle."""

    half_x: float
    half_y: float
    is_round: bool


def inside_outline(outline: PlateOutline, points: Array, slack: float) -> Mask:
    """Say which points, shape (n, 2 or more), lie in an outline with `slack` around it."""
    a, b = np.abs(points[:, 0]) / (outline.half_x + slack), np.abs(points[:, 1]) / (outline.half_y + slack)
    return np.hypot(a, b) < 1.0 if outline.is_round else np.maximum(a, b) < 1.0


def covered(plate: PlateOutline, pad: PlateOutline) -> PlateOutline | None:
    """Return the outline of what a target covers of its pad, both centred: there they are bonded.

    Of two rectangles, or of two discs, the smaller size along each direction; of a disc and a rectangle the one that
    lies within the other. None where those two cross.
    """
    if plate.is_round == pad.is_round:
        return PlateOutline(min(plate.half_x, pad.half_x), min(plate.half_y, pad.half_y), pad.is_round)
    return next((inner for inner, outer in ((plate, pad), (pad, plate)) if _holds(outer, inner)), None)


def _holds(outer: PlateOutline, inner: PlateOutline) -> bool:
    """Tell whether a disc lies within a rectangle, or a rectangle within a disc."""
    limit = 1.0 + SAME
    if outer.is_round:
        return math.hypot(inner.half_x, inner.half_y) <= limit * outer.half_x
    return inner.half_x <= limit * outer.half_x and inner.half_y <= limit * outer.half_y


class Subdivision(NamedTuple):
    """Where the cells of a mesh lie in those of its base."""

    base: Integers  # (e,) number of the base cell
    part: Integers  # (e, d) number of the part along each axis of the reference cell
    low: Array  # (e, d) its lower end there, in reference coordinates
    high: Array  # (e, d)

    @property
    def bases(self) -> int:
        """Number of base cells."""
        return int(self.base.max()) + 1

    @property
    def doubled(self) -> Subdivision:
        """Division of these cells and as many others, in base cells of their own."""
        return concatenated([self, self])


def concatenated(divisions: Sequence[Subdivision]) -> Subdivision:
    """Return the division of cells that come one after the other, each in base cells of their own."""
    first = np.cumsum([0, *(own.bases for own in divisions)])
    numbered = [own._replace(base=own.base + start) for own, start in zip(divisions, first[:-1], strict=True)]
    return Subdivision(*(np.concatenate(parts) for parts in zip(*numbered, strict=True)))


def divided(lines: Array, base: int | Array) -> Subdivision:
    """Return the division of cells between lines along an axis; the base has given ones of these, or every so many."""
    first = lines[::base] if isinstance(base, int) else base
    cell = np.searchsorted(first, 0.5 * (lines[1:] + lines[:-1])) - 1
    start, size = first[cell], np.diff(first)[cell]
    low, high = (((ends - start) / size)[:, None] for ends in (lines[:-1], lines[1:]))
    part = np.arange(len(cell)) - np.searchsorted(cell, cell)
    return Subdivision(cell, part[:, None], low, high)


def crossed(first: Subdivision, second: Subdivision) -> Subdivision:
    """Return the division of the products of two sets of cells, the second running faster."""
    i, j = (part.ravel() for part in np.indices((len(first.base), len(second.base))))
    base = first.base[i] * second.bases + second.base[j]
    part = np.hstack([first.part[i], second.part[j]])
    low, high = np.hstack([first.low[i], second.low[j]]), np.hstack([first.high[i], second.high[j]])
    return Subdivision(base, part, low, high)


Lines = tuple[Array, Array, Array]


def box_bricks(x: Array, y: Array, z: Array, base: Lines | None = None) -> tuple[MeshHex, Subdivision]:
    """Return the bricks between lines, and their division; all lines are of the base, or those given."""
    own = base or (x, y, z)
    flat = tensor_grid(x, y).reshape(-1, 2)
    quads = _quads(np.arange(len(flat)).reshape(len(x), len(y)))
    return _extruded(flat, quads, crossed(divided(x, own[0]), divided(y, own[1])), z, own[2])


def ring_bricks(
    target: PlateOutline, pad: PlateOutline, lines: Lines, around: int, split: int = 1, base: Lines | None = None,
    cover: PlateOutline | None = None,
) -> tuple[MeshHex2, Subdivision]:
    """Return half a pad, y >= 0, in rings around a core, and the division of its bricks.

    `lines` go from the core (0) to the target's outline (1); from there (0) to the pad's (1), or one value where both
    are the same; and along z. `around` counts cells from a corner of the core to the next middle of a side; four times
    as many go around half the pad. With a `cover` lines go from the target's outline to that (1), and on to the pad's
    (2). Every `split`-th line is of the base, or those in `base`.
    """
    rho, z = _rings(lines), lines[2]
    outwards, through = (split, split) if base is None else (_rings(base), base[2])
    flat, quads = _square(rho, around)
    core, half, walk = (divided(np.arange(count + 1.0), split) for count in (2 * around, around, 4 * around))
    across = concatenated([crossed(core, half), crossed(divided(rho, outwards), walk)])
    mesh, division = _extruded(flat, quads, across, z, through)
    straight = MeshHex2.from_mesh(mesh)
    placed = straight.doflocs.copy()
    outlines = (target, pad) if cover is None else (target, cover, pad)
    placed[:2] = _placed(straight.doflocs[:2], *outlines)
    return MeshHex2(placed, straight.t), division


def _rings(lines: Lines) -> Array:
    """Return lines outwards: 0 in the middle, 1 at the target's outline, 2 at the pad's."""
    inside, outside, _ = lines
    return np.concatenate([CORE + (1.0 - CORE) * inside, 1.0 + outside[1:]])


def _quads(index: Integers) -> Integers:
    """Return cells, as (0, 0), (1, 0), (0, 1), (1, 1), of a grid of numbered points."""
    each = [index[:-1, :-1], index[1:, :-1], index[:-1, 1:], index[1:, 1:]]
    return np.stack(each, axis=-1).reshape(-1, 4)


def _extruded(
    flat: Array, quads: Integers, across: Subdivision, z: Array, base: int | Array
) -> tuple[MeshHex, Subdivision]:
    """Return bricks over flat cells, one layer after the other."""
    points = np.vstack([np.column_stack([flat, np.full(len(flat), level)]) for level in z])
    layers = np.arange(len(z) - 1)[:, None] * len(flat)
    corners = ElementHex1().doflocs.astype(int)
    hexes = np.stack([(layers + up * len(flat) + quads[:, i + 2 * j]).ravel() for i, j, up in corners])
    found = crossed(divided(z, base), across)  # z runs slowest, but comes last
    part, (low, high) = np.roll(found.part, -1, axis=1), (np.roll(ends, -1, axis=1) for ends in found[2:])
    mesh = MeshHex(np.ascontiguousarray(points.T), np.ascontiguousarray(hexes))
    return mesh, Subdivision(found.base, part, low, high)


def _square(rho: Array, around: int) -> tuple[Array, Integers]:
    """Return corners (n, 2) and cells (m, 4), as of `_quads`, of half a square in rings around a core."""
    core = np.linspace(-1.0, 1.0, 2 * around + 1) * rho[0]
    a, b = np.meshgrid(core, core[around:], indexing="ij")
    inner = np.column_stack([a.ravel(), b.ravel()])
    index = np.arange(len(inner)).reshape(a.shape)
    walk = np.concatenate([index[-1, :], index[-2::-1, -1], index[0, -2::-1]])
    points, cells, last = [inner], [_quads(index)], walk
    for number, size in enumerate(rho[1:]):
        ring = len(inner) + number * len(walk) + np.arange(len(walk))
        points.append(inner[walk] * size / rho[0])
        cells.append(np.stack([last[:-1], ring[:-1], last[1:], ring[1:]], axis=-1))
        last = ring
    return np.vstack(points), np.vstack(cells)


def _placed(flat: Array, target: PlateOutline, *outside: PlateOutline) -> Array:
    """Return where points of the square, shape (2, n), lie in the pad; `outside` are outlines from the target's on."""
    rho = np.abs(flat).max(axis=0)
    edge = flat / np.where(rho > 0.0, rho, 1.0)
    core = _on(PlateOutline(target.half_x, target.half_y, False), edge) * (_SHRUNK if target.is_round else 1.0)
    part = np.clip((rho - CORE) / (1.0 - CORE), 0.0, 1.0)
    inside = (1.0 - part) * np.minimum(rho, CORE) * core + part * _on(target, edge)
    for number, outline in enumerate(outside, 1):
        beyond = np.clip(rho - number, 0.0, 1.0)
        inside = (1.0 - beyond) * inside + beyond * _on(outline, edge)
    return np.asarray(inside)


def _on(outline: PlateOutline, edge: Array) -> Array:
    """Return points of an outline, shape (2, n), that stand for points of the square's edge."""
    a, b = edge
    if outline.is_round:
        side = np.where(a > 0.0, b, 4.0 - b)
        theta = 0.25 * np.pi * np.where(np.abs(b) >= np.abs(a), 2.0 - a, side)
        a, b = np.cos(theta), np.sin(theta)
    return np.stack([outline.half_x * a, outline.half_y * b])


_BRICK = ElementHex2()
_PLANE = 1e-9  # how near to the mirror a corner, or the middle of a pillar, lies in it


class Bricks(NamedTuple):
    """Bricks by themselves: points (n, 3), each one's corners (e, 8), the places of its nodes (e, 27, 3)."""

    points: Array
    corners: Integers
    places: Array


def bricks_of(mesh: MeshHex) -> Bricks:
    """Return the bricks of a mesh, straight or curved."""
    curved = mesh if isinstance(mesh, MeshHex2) else MeshHex2.from_mesh(mesh)
    nodes = curved.doflocs.T[Dofs(curved, _BRICK).element_dofs.T]
    return Bricks(mesh.p.T[: mesh.t.max() + 1], mesh.t.T, nodes)  # of curved ones other nodes come after


def mesh_of(bricks: Bricks) -> MeshHex2:
    """Return the mesh of some bricks."""
    points, corners, places = bricks
    straight = MeshHex(np.ascontiguousarray(points.T), np.ascontiguousarray(corners.T))  # or it has to turn them
    mesh = MeshHex2.from_mesh(straight)
    nodes = mesh.doflocs.copy()
    nodes[:, Dofs(mesh, _BRICK).element_dofs.T] = np.moveaxis(places, -1, 0)
    return MeshHex2(nodes, mesh.t)


def both_halves(half: MeshHex, axis: int = 1) -> MeshHex2:
    """Return a mesh on y >= 0, or along another axis, with its mirror image, whose bricks come after its own."""
    points, corners, places = bricks_of(half)
    own = points[:, axis] > _PLANE
    image = np.where(own, len(points) - 1 + np.cumsum(own), np.arange(len(points)))
    flip = np.where(np.arange(3) == axis, -1.0, 1.0)
    each = ((points, points[own] * flip), (corners, image[corners]), (places, places * flip))
    return mesh_of(Bricks(*(np.concatenate(part) for part in each)))


def side_by_side(parts: Sequence[tuple[MeshHex, tuple[float, float]]]) -> MeshHex2:
    """Return meshes that touch nowhere as one, each moved along x and y."""
    first, found = 0, []
    for mesh, (x, y) in parts:
        own, away = bricks_of(mesh), np.array([x, y, 0.0])
        found.append((own.points + away, own.corners + first, own.places + away))
        first += len(own.points)
    return mesh_of(Bricks(*(np.concatenate(part) for part in zip(*found, strict=True))))


def pillar_bricks(
    disc: PlateOutline, middles: Sequence[tuple[float, float]], lines: tuple[Array, Array], around: int, split: int = 1,
    base: tuple[Array, Array] | None = None,
) -> tuple[MeshHex2, Subdivision]:
    """Return the pillars at y >= 0, half of those that the plane y = 0 cuts through the middle, and their division.

    `disc` is one pillar's outline, `middles` are of all of them (those at y < 0 are images of others), `lines` go from
    the core (0) to the pillar's side (1), and along z; the others as of `ring_bricks`.
    """
    first = None if base is None else (base[0], np.zeros(1), base[1])
    half, division = ring_bricks(disc, disc, (lines[0], np.zeros(1), lines[1]), around, split, first)
    whole = both_halves(half)
    on_plane = [(half, (x, 0.0)) for x, y in middles if abs(y) <= _PLANE]
    outside = [(whole, (x, y)) for x, y in middles if y > _PLANE]
    divisions = [division] * len(on_plane) + [division.doubled] * len(outside)
    return side_by_side([*on_plane, *outside]), concatenated(divisions)
