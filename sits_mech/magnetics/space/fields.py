"""Expand a coil's field over a plate in products of Chebyshev polynomials on its box.

The potential A of a coil is analytic over the plate but for the windings, whose distance tells how fast its
coefficients fall and so how many there are (`divisions.field_box`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate, pairwise
from typing import Any

import numpy as np

from sits_mech.geometry.sheet_plan import CellPlan
from sits_mech.quantities import Array, Complex, Integers, tensor_grid

HELD = 4_000_000  # numbers at once
_SAME = 1e-9  # of images that differ by signs, by rounding


@dataclass(frozen=True, eq=False)
class Box:
    """Where the fields' polynomials live: the plate's bounding box, and how many of them along each axis."""

    half: Array  # (3,) half sizes [m]
    order: tuple[int, int, int]  # Chebyshev polynomials along x, y, z
    decay: tuple[float, float, float]  # rho of each axis: coefficients fall like rho^-n
    clearance: float = 1e-3  # from the windings, for which it is made [m]

    def points(self) -> Array:
        """Return the Chebyshev points (z fastest) from the bottom face's centre, shape (q, 3) [m]."""
        axes = [h * chebyshev_points(n) for h, n in zip(self.half, self.order, strict=True)]
        nodes = tensor_grid(*axes).reshape(-1, 3)
        return np.asarray(nodes + (0.0, 0.0, self.half[2]))

    def coefficients(self, values: Array) -> Array:
        """Return the coefficients of fields from values at the points, (..., q), in the same order."""
        first, second, third = map(to_coefficients, self.order)
        across = values.reshape(-1, len(second) * len(third)) @ np.kron(second, third).T
        return (first @ across.reshape(-1, len(first), across.shape[1])).reshape(values.shape)


def chebyshev_points(order: int) -> Array:
    """Return the zeros of T_order, from the largest."""
    return np.cos(np.pi * (np.arange(order) + 0.5) / order)


@lru_cache(maxsize=64)
def to_coefficients(order: int) -> Array:
    """Return the matrix from values at the Chebyshev points of an axis to the coefficients."""
    T = np.cos(np.outer(np.arange(order), np.pi * (np.arange(order) + 0.5) / order)) * 2 / order
    T[0] /= 2
    return np.asarray(T)


@dataclass(frozen=True)
class Prisms:
    """Right prisms along z."""

    corners: Array  # (n, 4, 2) base, counter-clockwise; a triangle repeats its last corner [m]
    low: Array  # (n,) z of the lower face [m]
    high: Array  # (n,) of the upper [m]

    def some(self, index: Any) -> Prisms:
        """Return some of them."""
        return Prisms(self.corners[index], self.low[index], self.high[index])


def gauss_points(prisms: Prisms, n: int, across: int = 0, through: int = 2) -> tuple[Array, Array]:
    """Return Gauss points of each prism (z fastest) and their weights (sum 1): shapes (m, p, 3), (m, p).

    There are n along its sides, or along the second one as many as `across`, if that is given.
    """
    (s, ws), (t, wt), (v, wv) = map(np.polynomial.legendre.leggauss, (n, across or n, through))
    u, w = (g.ravel() for g in np.meshgrid((1 + s) / 2, (1 + t) / 2, indexing="ij"))
    c = prisms.corners
    blend = np.stack([(1 - u) * (1 - w), u * (1 - w), u * w, (1 - u) * w])
    plan = np.einsum("kp,mkd->mpd", blend, c)
    du = np.einsum("p,md->mpd", 1 - w, c[:, 1] - c[:, 0]) + np.einsum("p,md->mpd", w, c[:, 2] - c[:, 3])
    dw = np.einsum("p,md->mpd", 1 - u, c[:, 3] - c[:, 0]) + np.einsum("p,md->mpd", u, c[:, 2] - c[:, 1])
    jacobian = (du[..., 0] * dw[..., 1] - du[..., 1] * dw[..., 0]) * np.outer(ws, wt).ravel()
    weight = jacobian / jacobian.sum(1, keepdims=True)
    middle, half = (prisms.low + prisms.high) / 2, (prisms.high - prisms.low) / 2
    z = middle[:, None] + half[:, None] * v
    m, p = weight.shape
    points = np.concatenate([np.repeat(plan, through, axis=1), np.tile(z, (1, p))[..., None]], axis=2)
    return points, np.repeat(weight, through, axis=1) * np.tile(wv / 2, (m, p))


@dataclass(frozen=True, eq=False)
class Parity:
    """Means over cells of the products T_i T_j T_k that are even or odd in each of x, y and z."""

    columns: Integers  # (c,) which coefficients
    signs: Array  # (images, g) +-1 where an image is a mirror image, or half a turn, of one of g
    means: Array  # (g, 1, n, c) over the upper cells' images by these


def field_means(plan: CellPlan, prisms: Prisms, box: Box) -> list[Parity]:
    """Return the mean of each T_i T_j T_k over each cell's images, of which some differ by signs alone."""
    relative = np.einsum("gij,hkj->ghik", plan.group, plan.group)
    first = (np.abs(relative[..., 0, 1]) + np.abs(relative[..., 1, 0]) < _SAME).argmax(axis=1)
    flips = np.sign(relative[np.arange(len(first)), first][:, [0, 1], [0, 1]])
    few, place = np.unique(first, return_inverse=True)
    number, found = np.arange(math.prod(box.order)).reshape(box.order), []
    points, weights = gauss_points(prisms, 2)
    moved = np.stack([points] * len(few))
    moved[..., :2] = points[..., :2] @ np.swapaxes(plan.group[few], 1, 2)[:, None]
    each = [chebyshev_values(moved[..., i] / box.half[i], box.order[i]) for i in range(3)]
    each[0] *= weights[..., None]
    for parity in np.ndindex(2, 2, 2):
        x, y, z = (values[..., p::2] for values, p in zip(each, parity, strict=True))
        xy = (x[..., None] * y[..., None, :]).reshape(*x.shape[:3], -1)
        columns = number[tuple(slice(p, None, 2) for p in parity)].ravel()
        signs = np.zeros((len(first), 2, len(few)))
        signs[np.arange(len(first)), :, place] = np.prod(flips ** parity[:2], axis=1)[:, None]
        signs[:, 1] *= (-1.0) ** parity[2]
        means = (np.swapaxes(xy, 2, 3) @ z).reshape(len(few), 1, -1, columns.size)
        found.append(Parity(columns, signs.reshape(-1, len(few)), means))
    return found


def chebyshev_values(x: Array, order: int) -> Array:
    """Return T_0 ... T_(order-1) at x, along a new last axis; slightly outside [-1, 1] is clipped."""
    return np.cos(np.arccos(np.clip(x, -1.0, 1.0))[..., None] * np.arange(order))


def decay_scale(box: Box) -> Array:
    """Return the expected sizes of the coefficients, three components, flat."""
    logs = [-np.log(rho) * np.arange(n) for rho, n in zip(box.decay, box.order, strict=True)]
    total = logs[0][:, None, None] + logs[1][:, None] + logs[2]
    return np.tile(np.exp(total).ravel(), 3)


@lru_cache(maxsize=2)
def polynomial_gradients(box: Box) -> list[tuple[Integers, Array]]:
    """Return which coefficients the gradients of the box's polynomials have, and orthonormal ones of them, by parity.

    Orthonormal are coefficients over their sizes (`decay_scale`). All classes of a plate share them.
    """
    scale = decay_scale(box)
    slopes = [np.polynomial.chebyshev.chebder(np.eye(n + 1)[:, :n], axis=0) / h
              for n, h in zip(box.order, box.half, strict=True)]
    number = np.arange(3 * np.prod(box.order)).reshape(3, *box.order)
    found = []
    for parity in np.ndindex(2, 2, 2):
        own = [np.arange(p, n, 2) for p, n in zip(parity, box.order, strict=True)]
        rows, parts = [], []
        for k, (D, n) in enumerate(zip(slopes, box.order, strict=True)):
            flipped = np.arange(1 - parity[k], n, 2)
            factors = [D[np.ix_(flipped, some)] if i == k else np.eye(some.size) for i, some in enumerate(own)]
            parts.append(np.kron(np.kron(factors[0], factors[1]), factors[2]))
            rows.append(number[k][np.ix_(*(flipped if i == k else some for i, some in enumerate(own)))].ravel())
        index = np.concatenate(rows)
        G = np.vstack(parts) / scale[index, None]
        length = np.linalg.norm(G, axis=0)
        found.append((index, np.linalg.qr(G[:, length > 0.0] / length[length > 0.0])[0]))
    return found


def without_gradients(box: Box, rows: Integers, seen: Array) -> Array:
    """Return what some coefficients drive, less what gradients among them do, which should drive nothing.

    `rows` (n,) of the three components' coefficients ascend; `seen` (n, m) is what each drives, of its size.
    """
    seen = seen.copy()
    for index, Q in polynomial_gradients(box):
        at = np.searchsorted(rows, index)
        known = at < rows.size
        known[known] = rows[at[known]] == index[known]
        if known.all():
            seen[at] -= Q @ (Q.T @ seen[at])
    return seen


@dataclass(frozen=True)
class Basis:
    """Combinations of fields."""

    rows: Integers  # (n,) which of the three components' coefficients they hold
    fields: Array  # (n, r)

    @property
    def size(self) -> int:
        """Number of combinations."""
        return int(self.fields.shape[1])


def row_places(sizes: Iterable[int]) -> list[slice]:
    """Return where parts of some sizes are in a row of all."""
    return [slice(*ends) for ends in pairwise(accumulate(sizes, initial=0))]


@dataclass(frozen=True, eq=False)
class Blocks:
    """A symmetric matrix that is a sum of parts, each of some rows and the same columns."""

    size: int  # rows of the whole
    parts: tuple[tuple[Integers, Complex], ...]  # which rows, and the part

    def __matmul__(self, columns: Array) -> Complex:
        """Return its product with real columns, shape (size, k)."""
        found = np.zeros((self.size, columns.shape[1]), dtype=complex)
        for rows, part in self.parts:
            own = columns[rows]
            found[rows] += part.real @ own + 1j * (part.imag @ own)
        return found
