"""Place bricks beside their own images: mirror images across a plane, copies side by side, round pillars.

Bricks have 27 nodes each, so that curved ones stay curved; copies are numbered alike, one after the other, and share
the corners that lie on each other.

Pillars are each divided in rings like a cylinder of its own (bricks.py). Their pattern is its own mirror image in y:
half of it, y >= 0, is meshed, pillars on the plane by their halves. Pillars touch nowhere, and each has base cells of
its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from skfem import MeshHex, MeshHex2
from skfem.assembly import Dofs
from skfem.element import ElementHex2

from sits_mech.geometry.meshing.bricks import Division, Outline, joined, ring_bricks
from sits_mech.quantities import Array, Integers

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
    disc: Outline, middles: Sequence[tuple[float, float]], lines: tuple[Array, Array], around: int, split: int = 1,
    base: tuple[Array, Array] | None = None,
) -> tuple[MeshHex2, Division]:
    """Return the pillars at y >= 0, half of those that the plane y = 0 cuts through the middle, and their division.

    `disc` is one pillar's outline, `middles` are of all of them (those at y < 0 are images of others), `lines` go from
    the core (0) to the pillar's side (1), and along z; the others as of `ring_bricks`.
    """
    first = None if base is None else (base[0], np.zeros(1), base[1])
    half, division = ring_bricks(disc, disc, (lines[0], np.zeros(1), lines[1]), around, split, first)
    whole = both_halves(half)
    on_plane = [(half, (x, 0.0)) for x, y in middles if abs(y) <= _PLANE]
    beside = [(whole, (x, y)) for x, y in middles if y > _PLANE]
    divisions = [division] * len(on_plane) + [division.doubled] * len(beside)
    return side_by_side([*on_plane, *beside]), joined(divisions)
