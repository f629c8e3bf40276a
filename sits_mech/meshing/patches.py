"""Divide a plan of four-sided patches into bricks: Coons patches between curves, cells between lines, upright.

A patch with the curves b(s), a(s) below and above and l(t), r(t) at its left and right side has its points at

    X(s, t) = (1 - t) b(s) + t a(s) + (1 - s) l(t) + s r(t)
              - (1 - s)(1 - t) b(0) - s (1 - t) b(1) - (1 - s) t a(0) - s t a(1),

a blend of its sides. Source: S. A. Coons, Surfaces for Computer-Aided Design of Space Forms, MIT MAC-TR-41 (1967).
Patches that share a side must divide it alike; corners that lie on each other are one. Where every so many lines of a
patch are one of a base, the bricks have a division (bricks.py). Every node of the triquadratic bricks is placed by this
map, so that round sides are round. Lengths in any unit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree
from skfem import MeshHex2
from skfem.element import ElementHex1, ElementHex2

from sits_mech.meshing.bricks import Division, crossed, divided, joined
from sits_mech.meshing.copies import Bricks, mesh_of
from sits_mech.quantities import Array

Curve = Callable[[Array], Array]
"""From parameters 0 to 1, shape (n,), to points (n, 2)."""

_SAME = 1e-9  # of the plan's size: corners that are nearer are one


class Patch(NamedTuple):
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


def patch_bricks(patches: Sequence[Patch], z: Array, split: int = 1) -> tuple[MeshHex2, Division]:
    """Return bricks over patches between lines along z, and their division; every `split`-th line is of the base."""
    points, places = (
        np.concatenate([_upright(patch, z, nodes) for patch in patches])
        for nodes in (ElementHex1().doflocs, ElementHex2().doflocs)
    )
    corners = points.reshape(-1, 3)
    size = _SAME * float(np.ptp(corners[:, :2]))
    first = np.arange(len(corners))
    one, other = cKDTree(corners).query_pairs(size, output_type="ndarray").T
    np.minimum.at(first, other, one)
    used, numbers = np.unique(first, return_inverse=True)
    across = (crossed(divided(patch.s, split), divided(patch.t, split)) for patch in patches)
    division = joined([crossed(own, divided(z, split)) for own in across])
    return mesh_of(Bricks(corners[used], numbers.reshape(-1, 8), places)), division


def _upright(patch: Patch, z: Array, nodes: Array) -> Array:
    """Return places (e, k, 3) of nodes of the unit cube, shape (k, 3), in every brick over a patch."""
    lines = (patch.s, patch.t, z)
    ends = [np.stack([own[:-1], own[1:]], axis=1) for own in lines]
    cells = np.stack(np.meshgrid(*(np.arange(len(own)) for own in ends), indexing="ij"), axis=-1).reshape(-1, 3)
    s, t, up = (
        own[cell, 0][:, None] + np.diff(own, axis=1)[cell] * at
        for own, cell, at in zip(ends, cells.T, nodes.T, strict=True)
    )
    plan = _blended(patch, s.ravel(), t.ravel()).reshape(*s.shape, 2)
    return np.concatenate([plan, up[..., None]], axis=-1)


def _blended(patch: Patch, s: Array, t: Array) -> Array:
    """Return points (n, 2) of a patch."""
    below, above = patch.below(s), patch.above(s)
    (b_0, b_1), (a_0, a_1) = (curve(np.array([0.0, 1.0])) for curve in (patch.below, patch.above))
    s, t = s[:, None], t[:, None]
    sides = (1.0 - s) * patch.left(t[:, 0]) + s * patch.right(t[:, 0])
    corners = (1.0 - t) * ((1.0 - s) * b_0 + s * b_1) + t * ((1.0 - s) * a_0 + s * a_1)
    return np.asarray((1.0 - t) * below + t * above + sides - corners)
