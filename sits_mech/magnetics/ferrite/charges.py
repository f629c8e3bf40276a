"""Interaction of uniformly magnetised boxes by the charges on their faces, in closed form.

Two boxes with magnetisations M, M' have the energy ``mu0 M . K M'``, with

    K_ab = 1/(4 pi) int int' d_a d'_b (1/|r - r'|) dV dV' = -1/(4 pi) int int' d_a d_b (1/|r - r'|),

that is, charges M.n on their faces. K of a box with itself is its volume times its demagnetising factors (trace 1).
Along each axis the two integrals are second differences of antiderivatives

    f = y (z^2 - x^2)/2 asinh(y/rho_xz) + z (y^2 - x^2)/2 asinh(z/rho_xy)
        - x y z atan(y z/(x r)) + (2x^2 - y^2 - z^2) r/6,
    g = x y z asinh(z/rho_xy) + y (3z^2 - y^2)/6 asinh(x/rho_yz) + x (3z^2 - x^2)/6 asinh(y/rho_xz)
        - z^3/6 atan(x y/(z r)) - z y^2/2 atan(x z/(y r)) - z x^2/2 atan(y z/(x r)) - x y r/3,

for K_xx and K_xy, others by exchange of axes; g is odd in x and y. Differences lose digits like r^6 / (V V'): far
boxes are dipoles with their second moments left out, ``V V' (delta_ab - 3 n_a n_b) / (4 pi r^3)``.

Source: A. J. Newell, W. Williams, D. J. Dunlop, J. Geophys. Res. 98 (1993) 9551.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from sits_mech.quantities import Array, Integers

PAIRS = tuple(combinations_with_replacement(range(3), 2))
"""Components of K as they are listed."""
_LOST = 1e11  # r^6 over the product of both volumes from which on boxes are dipoles: differences lose 1e-5
_APART = 12.0  # and largest sides between them, at least: the dipoles' own error is some 1e-3 there


def box_charges(x: Array, y: Array, z: Array) -> Array:
    """Return K [m^3] between the boxes of one octant and all of the mirrored tensor mesh, shape (6, 2, 2, 2, n, n).

    The first axis is `PAIRS`; the next tell whether the second box is mirrored in x, y, z. Boxes run z fastest; x, y, z
    are nodes of the positive half axes, from 0 [m].
    """
    scale = max(axis[-1] for axis in (x, y, z))
    axes = [_Axis.of(axis / scale) for axis in (x, y, z)]
    n = [axis.size - 1 for axis in (x, y, z)]
    far = _far(axes)
    K = np.empty((len(PAIRS), 2, 2, 2, int(np.prod(n)), int(np.prod(n))))
    for row, (a, b) in zip(K, PAIRS, strict=True):
        near = _integrated(axes, a, b)
        whole = np.where(far[0], _dipoles(axes, far[1:], a, b), near) * scale**3 / (4 * np.pi)
        for octant in np.ndindex(2, 2, 2):
            X, Y, Z = (slice(m, None) if p == 0 else slice(m - 1, None, -1) for m, p in zip(n, octant, strict=True))
            row[octant] = whole[:, X, :, Y, :, Z].transpose(0, 2, 4, 1, 3, 5).reshape(row.shape[-2:])
    return K


@dataclass(frozen=True)
class _Axis:
    """Cells of a half axis by all cells along it: distances of nodes, which pair has which and its sign; sides."""

    values: Array  # (m,)
    index: Integers  # (n + 1, 2 n + 1)
    sign: Array  # (n + 1, 2 n + 1)
    first: Array  # (n,)
    second: Array  # (2 n,)
    apart: Array  # (n, 2 n)

    @classmethod
    def of(cls, nodes: Array) -> _Axis:
        """Return the cells between the nodes of a half axis."""
        full = np.concatenate([-nodes[:0:-1], nodes])
        apart = nodes[:, None] - full
        values, index = np.unique(np.round(np.abs(apart), 15), return_inverse=True)
        side, centres = np.diff(nodes), (nodes[1:] + nodes[:-1]) / 2
        both = np.concatenate([side[::-1], side])
        distance = centres[:, None] - np.concatenate([-centres[::-1], centres])
        return cls(values, index.reshape(apart.shape), np.sign(apart), side, both, distance)


def _integrated(axes: list[_Axis], a: int, b: int) -> Array:
    """Return 4 pi K_ab by differences, shape (n_x, 2 n_x, n_y, 2 n_y, n_z, 2 n_z)."""
    order = [a, *(k for k in range(3) if k != a)] if a == b else [a, b, 3 - a - b]
    values = [axes[k].values for k in order]
    function: Callable[..., Array] = _diagonal if a == b else _mixed
    F = np.moveaxis(function(*np.ix_(*values)), (0, 1, 2), order)
    for k, axis in enumerate(axes):
        F = np.moveaxis(np.moveaxis(F, 2 * k, 0)[axis.index], (0, 1), (2 * k, 2 * k + 1))
        if a != b and k in (a, b):
            F = F * axis.sign.reshape(*axis.sign.shape, *(1,) * (F.ndim - 2 * k - 2))
        F = np.diff(np.diff(F, axis=2 * k), axis=2 * k + 1)
    return np.asarray(F)


def _diagonal(x: Array, y: Array, z: Array) -> Array:
    """Return f of the module docstring at distances that are not negative."""
    r = np.sqrt(x * x + y * y + z * z)
    total = y * (z * z - x * x) / 2 * _asinh(y, x, z) + z * (y * y - x * x) / 2 * _asinh(z, x, y)
    return np.asarray(total - x * y * z * np.arctan2(y * z, x * r) + (2 * x * x - y * y - z * z) * r / 6)


def _mixed(x: Array, y: Array, z: Array) -> Array:
    """Return g of the module docstring at distances that are not negative."""
    r = np.sqrt(x * x + y * y + z * z)
    total = x * y * z * _asinh(z, x, y)
    total = total + y * (3 * z * z - y * y) / 6 * _asinh(x, y, z) + x * (3 * z * z - x * x) / 6 * _asinh(y, x, z)
    total = total - z**3 / 6 * np.arctan2(x * y, z * r) - z * y * y / 2 * np.arctan2(x * z, y * r)
    return np.asarray(total - z * x * x / 2 * np.arctan2(y * z, x * r) - x * y * r / 3)


def _asinh(a: Array, b: Array, c: Array) -> Array:
    """Return asinh(a / sqrt(b^2 + c^2)), zero where its factor vanishes."""
    rho = np.sqrt(b * b + c * c)
    return np.asarray(np.arcsinh(a / np.where(rho > 0.0, rho, 1.0)))


def _far(axes: list[_Axis]) -> tuple[NDArray[np.bool_], Array, Array]:
    """Tell which boxes are dipoles to each other; return r^2 and V V' too, in the shape of `_integrated`."""
    square, volume, largest = np.zeros((1,) * 6), np.ones((1,) * 6), np.zeros((1,) * 6)
    for k, axis in enumerate(axes):
        square = square + _shaped(axis.apart**2, k)
        volume = volume * _shaped(axis.first[:, None] * axis.second, k)
        largest = np.maximum(largest, _shaped(np.maximum(axis.first[:, None], axis.second), k))
    return (square**3 > _LOST * volume) & (square > (_APART * largest) ** 2), square, volume


def _dipoles(axes: list[_Axis], sizes: tuple[Array, Array], a: int, b: int) -> Array:
    """Return 4 pi K_ab of dipoles, from their r^2 and V V'."""
    square, volume = sizes
    square = np.where(square > 0.0, square, 1.0)
    product = _shaped(axes[a].apart, a) * _shaped(axes[b].apart, b)
    return np.asarray(volume * (float(a == b) - 3.0 * product / square) / square**1.5)


def _shaped(pairs: Array, k: int) -> Array:
    """Return pairs of cells along one axis, in the shape of `_integrated`."""
    return pairs.reshape(*(1,) * (2 * k), *pairs.shape, *(1,) * (4 - 2 * k))
