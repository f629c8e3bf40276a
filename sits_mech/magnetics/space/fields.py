"""Expand a coil's field over a plate in products of Chebyshev polynomials on its box, as few as it needs.

The potential A of a coil is analytic over the plate but for the windings. Along an axis of the box, of half size h, the
nearest windings lie at a distance ``a h`` from its middle along the axis and ``b h`` across, on the ellipse about the
interval with

    cosh(rate) = (hypot(a - 1, b) + hypot(a + 1, b)) / 2,

and the coefficients fall like ``exp(-rate n)``. A coil under the plate needs all polynomials; one beside it few. Orders
are taken from one ladder of `sizes`; a level of it holds the polynomials below that size along every axis, so that
levels are nested.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate, pairwise

import numpy as np

from sits_mech.geometry.sheet_plan import Plan
from sits_mech.magnetics.coils.straight import Potential
from sits_mech.magnetics.space.prisms import Prisms, gauss_points
from sits_mech.quantities import Array, Complex, Integers, tensor_grid
from sits_mech.scene.sensor import Coil

HELD = 4_000_000  # numbers at once
_SIZES = (2, 3, 4, 5, 6, 7, 9, 11, 13, 16, 19, 23, 28, 34, 40, 48, 57, 68, 81, 96, 115, 137, 163, 194, 230)
"""Orders along a side below the asked one, by which a smaller set is tried; each about a fifth more than the last."""


@dataclass(frozen=True, eq=False)
class Nodes:
    """Chebyshev points of a box, and the matrices from values there to coefficients."""

    points: Array  # (q, 3) z fastest, from the bottom face's centre [m]
    first: Array  # along x
    others: Array  # along y and z together

    def coefficients(self, field: Potential, turns: Array, places: Array) -> Array:
        """Return a field's coefficients in p poses, in the plate's axes, by component, z fastest; shape (p, 3 q).

        `field` is as of `winding_potential`; rotations (p, 3, 3) and places (p, 3) are in its axes [m].
        """
        A = field(turns @ self.points.T + places[:, :, None])
        nx, nyz = len(self.first), len(self.others)
        across = A.reshape(-1, nyz) @ self.others.T
        c = (self.first @ across.reshape(-1, nx, nyz)).reshape(*A.shape[:2], -1)
        return (np.swapaxes(turns[:, : A.shape[1]], 1, 2) @ c).reshape(len(places), -1)


@dataclass(frozen=True, eq=False)
class Box:
    """Where the fields' polynomials live: the plate's bounding box, and how many of them along each axis."""

    half: Array  # (3,) half sizes [m]
    order: tuple[int, int, int]  # Chebyshev polynomials along x, y, z
    decay: tuple[float, float, float]  # rho of each axis: coefficients fall like rho^-n
    digits: float = 12.0  # natural logarithm of the accuracy kept of fields that need fewer polynomials
    clearance: float = 1e-3  # from the windings, for which it is made [m]

    @property
    def sizes(self) -> list[list[int]]:
        """Numbers of polynomials to choose from along each axis; the last is its order, alone in z."""
        return [*([size for size in _SIZES if size < n] + [n] for n in self.order[:2]), [self.order[2]]]

    def points(self, order: Sequence[int] | None = None) -> Array:
        """Return the Chebyshev points of some orders (z fastest) from the bottom face's centre, shape (q, 3) [m]."""
        counts = self.order if order is None else order
        axes = [h * chebyshev_points(n) for h, n in zip(self.half, counts, strict=True)]
        nodes = tensor_grid(*axes).reshape(-1, 3)
        return np.asarray(nodes + (0.0, 0.0, self.half[2]))

    def nodes(self, order: Sequence[int]) -> Nodes:
        """Return where polynomials of some orders are found, and how."""
        first, second, third = (to_coefficients(n) for n in order)
        return Nodes(self.points(order), first, np.asarray(np.kron(second, third), dtype=np.float64))

    def levels(self) -> Integers:
        """Return the level of each polynomial of three components, flat."""
        each = [np.searchsorted(size, np.arange(n), "right") for size, n in zip(self.sizes, self.order, strict=True)]
        level = np.maximum(np.maximum(each[0][:, None, None], each[1][:, None]), each[2])
        return np.tile(level.ravel(), 3)

    def needed(self, coils: Sequence[Coil], turns: Array, places: Array) -> Integers:
        """Return which of `sizes` the fields of n coils need along each axis in p poses, shape (p, n, 3)."""
        radius, depth = np.array([(coil.outer_diameter / 2, coil.height / 2) for coil in coils]).T[..., None]
        centres = np.column_stack([[coil.centre for coil in coils], -depth])
        up = turns[:, 2]  # the coils' axis in the plate's own axes
        middle = places + turns[:, :, 2] * self.half[2]
        apart = np.einsum("pij,pni->pnj", turns, centres - middle[:, None])
        aside = np.sqrt(np.maximum(1.0 - up**2, 0.0))
        reach = radius * aside[:, None] + depth * np.abs(up)[:, None]
        along = np.maximum(np.abs(apart) - reach, 0.0)
        clear = np.maximum(along - self.half, 0.0)
        found = np.empty(along.shape, dtype=np.int64)
        for k, (half, size) in enumerate(zip(self.half, self.sizes, strict=True)):
            a, b = along[..., k] / half, np.hypot(clear[..., k - 1], clear[..., k - 2]) / half
            rate = np.arccosh(np.maximum((np.hypot(a - 1.0, b) + np.hypot(a + 1.0, b)) / 2, 1.0))
            found[..., k] = np.searchsorted(size[:-1], self.digits / np.maximum(rate, 1e-9))
        return found


def chebyshev_points(order: int) -> Array:
    """Return the zeros of T_order, from the largest."""
    return np.cos(np.pi * (np.arange(order) + 0.5) / order)


def to_coefficients(order: int) -> Array:
    """Return the matrix from values at the Chebyshev points of an axis to the coefficients."""
    T = np.cos(np.outer(np.arange(order), np.pi * (np.arange(order) + 0.5) / order)) * 2 / order
    T[0] /= 2
    return np.asarray(T)


def field_means(plan: Plan, prisms: Prisms, box: Box) -> Array:
    """Return the mean of each T_i T_j T_k over each cell's images, shape (g, 2, n, coefficients)."""
    points, weights = gauss_points(prisms, 2)
    n, q = weights.shape
    result = np.empty((plan.group.shape[0], 2, n, int(np.prod(box.order))))
    for k, g in enumerate(plan.group):
        moved = points.copy()
        moved[..., :2] = points[..., :2] @ g.T
        for s in (0, 1):
            moved[..., 2] = (1 - 2 * s) * points[..., 2]
            x, y, z = (chebyshev(moved[..., i] / box.half[i], box.order[i]) for i in range(3))
            xy = (x * weights[..., None])[..., :, None] * y[..., None, :]
            result[k, s] = np.matmul(xy.reshape(n, q, -1).transpose(0, 2, 1), z).reshape(n, -1)
    return result


def chebyshev(x: Array, order: int) -> Array:
    """Return T_0 ... T_(order-1) at x, along a new last axis; slightly outside [-1, 1] is clipped."""
    return np.cos(np.arccos(np.clip(x, -1.0, 1.0))[..., None] * np.arange(order))


def decay_scale(box: Box) -> Array:
    """Return the expected sizes of the coefficients, three components, flat."""
    logs = [-np.log(rho) * np.arange(n) for rho, n in zip(box.decay, box.order, strict=True)]
    total = logs[0][:, None, None] + logs[1][:, None] + logs[2]
    return np.tile(np.exp(total).ravel(), 3)


@lru_cache(maxsize=2)
def gradients(box: Box) -> list[tuple[Integers, Array]]:
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
    for index, Q in gradients(box):
        at = np.searchsorted(rows, index)
        known = at < rows.size
        known[known] = rows[at[known]] == index[known]
        if known.all():
            seen[at] -= Q @ (Q.T @ seen[at])
    return seen


@dataclass(frozen=True)
class Basis:
    """Combinations of fields."""

    rows: Integers  # (n,) which of the three components' coefficients they hold, by level
    fields: Array  # (n, r) those of a level's rows alone end with its `widths`
    widths: Integers  # combinations that fields of each level drive

    @property
    def size(self) -> int:
        """Number of combinations."""
        return int(self.fields.shape[1])


def side_by_side(sizes: Iterable[int]) -> list[slice]:
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
