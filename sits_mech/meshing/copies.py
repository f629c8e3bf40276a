"""Place bricks beside their own images: mirror images across a plane, copies side by side.

Bricks have 27 nodes each, so that curved ones stay curved; copies are numbered alike, one after the other, and share
the corners that lie on each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from skfem import MeshHex, MeshHex2
from skfem.assembly import Dofs
from skfem.element import ElementHex2

from sits_mech.quantities import Array

_BRICK = ElementHex2()
_PLANE = 1e-9  # how near to the mirror a corner lies in it


class Bricks(NamedTuple):
    """Bricks by themselves: points (n, 3), each one's corners (e, 8), the places of its nodes (e, 27, 3)."""

    points: Array
    corners: NDArray[np.int64]
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
