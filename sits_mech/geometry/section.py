"""Graded division of a rectangular section: one quadrant of tensor cells, fine at the surfaces and the corners.

From a surface inwards the cells grow geometrically from `first`, never above `largest`. A rectangle is symmetric about
both middle planes, so that its quadrant x, z > 0 and four parities describe it whole.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sits_mech.quantities import Array


@dataclass(frozen=True)
class Cells:
    """Rectangular cells.

    Attributes
    ----------
    x, z : ndarray, shape (n,)
        Centres [m].
    width, height : ndarray, shape (n,)
        Sizes along x and z [m].
    """

    x: Array
    z: Array
    width: Array
    height: Array


def graded(length: float, first: float, largest: float, growth: float) -> Array:
    """Return the nodes of ``[0, length]``, the finest cell (at most `first`) at the end `length`.

    Cells grow by at most `growth` towards 0 up to `largest`.
    """
    sizes = [min(first, length)]
    while sum(sizes) < length:
        sizes.append(min(growth * sizes[-1], largest))
    steps = np.array(sizes)
    nodes = length - np.concatenate([[0.0], np.cumsum(steps * (length / steps.sum()))])
    nodes[-1] = 0.0
    return np.asarray(nodes[::-1])


def quadrant_cells(nodes_x: Array, nodes_z: Array) -> Cells:
    """Return the tensor cells between the nodes of two half axes."""
    x, z = np.meshgrid((nodes_x[1:] + nodes_x[:-1]) / 2, (nodes_z[1:] + nodes_z[:-1]) / 2, indexing="ij")
    width, height = np.meshgrid(np.diff(nodes_x), np.diff(nodes_z), indexing="ij")
    return Cells(x.ravel(), z.ravel(), width.ravel(), height.ravel())
