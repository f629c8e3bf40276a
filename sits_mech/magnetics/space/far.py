"""Reduce a plate to a few fields at a few points, for its coupling to other plates.

Of all that a plate can see (D of its combinations at its box's points, q x 3 x r: `Basis.fields` of the polynomials'
coefficients there) little comes from beyond a distance c. Whatever comes from there is the field of currents m on the
box grown by c, which drive a = D^T K m, K = 1/|r - r'|. Weighted by how strongly the plate answers, W (both parts of Y,
each to its largest, make W^2, whatever combinations span a class), random currents m show the directions Q of a that
matter,

    W a = Q Q^T W a,    a = U f,    U = W^-1 Q,    f = C^T K m,    C = D W Q.

Of a plate at rest, what the coils drive in it is in Q before all others, so that its field, which comes first, is
whole. Of the points few are kept, from which K to the others is interpolated (by pivots), and C lives on these alone.
The plate answers f with moments f' = U^T Y U f.

Source: N. Halko, P. G. Martinsson, J. A. Tropp, SIAM Rev. 53 (2011) 217: random currents, and points chosen by pivots.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Protocol

import numpy as np
from scipy.constants import mu_0
from scipy.linalg import qr, solve_triangular
from scipy.spatial.distance import cdist

from sits_mech.magnetics.space.fields import Basis, Blocks, Box, chebyshev_points, row_places, to_coefficients
from sits_mech.magnetics.space.sources import Posed
from sits_mech.memory import latest
from sits_mech.quantities import Array, Complex, Integers

Answered = tuple[Complex, Complex, Complex]
"""a^T Y a of coils (p, n, n), not symmetrised; U^T Y a (p, k, n) and U^T Y U (k, k) of far combinations U."""
_Weights = list[tuple[Integers, Array]]  # by parts of rows
_POINT = 2e-4  # of the strongest point, weaker ones are interpolated
_ROUNDING = 1e-6  # of the strongest combination of points, weaker ones are left out
_FAINT = 1e-6  # of the strongest answer, below which combinations count alike
_SKETCH = 128  # random currents, doubled until they show faint directions


class DividedPlate(Hashable, Protocol):
    """A division of a plate, of metal (`Sheeted`, `Near`) or of ferrite (`ferrite`)."""

    @property
    def box(self) -> Box: ...

    @property
    def bases(self) -> tuple[Basis, ...]: ...

    def admittance(self, omega: float) -> Blocks:
        """Return Y of its combinations and then of the coils that it sees."""
        ...


@dataclass(frozen=True)
class FieldRequest:
    """What is asked of a plate's field: B at points (k, 3) below, by each coil (p, k, 3, n), to (2, p, n, n)."""

    points: Array
    of: Callable[[Complex], Complex]


def biot_savart(at: Array, moments: Complex, points: Array) -> Complex:
    """Return B of current moments (p, n, q, 3) [A m] at places (p, q, 3), at points (k, 3), (p, k, 3, n) [T]."""
    x, y, z = (points[:, k, None] - at[:, None, :, k] for k in range(3))
    square = x * x + y * y + z * z
    weight = mu_0 / (4.0 * np.pi) / (square * np.sqrt(square))
    x, y, z = x * weight, y * weight, z * weight
    X, Y, Z = (np.ascontiguousarray(np.swapaxes(moments[..., k], 1, 2)).view(float) for k in range(3))
    found = np.stack([z @ Y - y @ Z, x @ Z - z @ X, y @ X - x @ Y], axis=2)
    return found.view(complex)


class Moving(DividedPlate, Protocol):
    """A division that answers coils in its poses, with the plate's other ones, which see the same of these."""

    def coupled(self, divisions: Sequence[Any], seen: Posed, frequency: float) -> list[Complex]:
        """Return of each division Y of n coils' fields in p poses and, to its right, of combinations, (p, n, n + r)."""
        ...


@dataclass(frozen=True, eq=False)
class Far:
    """A plate as others see it."""

    points: Array  # (q, 3) from the bottom face's centre [m]
    moments: Array  # (q, 3, k) C
    fields: Array  # (r, k) U


@latest(32, owned=True)
def seen_from(plate: DividedPlate, clearance: float, omega: float, lost: float, coils: int = 0) -> Far:
    """Return what a plate is to all that is further away than a clearance [m]; omega [rad/s].

    Directions weaker than `lost`, to the strongest, are left out; `coils` of its own are the last of its combinations.
    """
    box, Y = plate.box, plate.admittance(omega)
    points, r = box.points(), Y.size
    K = 1.0 / cdist(_around(box, clearance), points)
    strength_of, weak_of = _weights(Y, coils)
    Q, strength, known, rng = np.zeros((r, 0)), np.ones(1), np.zeros((r, 0)), np.random.default_rng(0)
    while strength[-1] > lost * strength[0] and (count := known.shape[1]) < r:
        more = min(max(count, _SKETCH), r - count)
        field = (K.T @ rng.normal(size=(len(K), 3 * more))).reshape(len(points), 3, more)
        known = np.hstack([known, _weighted(strength_of, seen(plate, field, r))])
        Q, strength = np.linalg.svd(known, full_matrices=False)[:2]
    Q = Q[:, strength > lost * strength[0]]
    if coils:
        found = Y @ np.eye(r, coils, coils - r)
        first = _weighted(weak_of, np.hstack([found.real, found.imag]))
        first[r - coils :] = 0.0
        size = np.linalg.norm(first, axis=0)
        Q = np.linalg.qr(np.hstack([first[:, size > 0.0] / size[size > 0.0], Q]))[0]
    few, carried = _chosen(K)
    moments = carried @ radiated(plate, _weighted(strength_of, Q)).reshape(len(points), -1)
    return Far(points[few], moments.reshape(len(few), 3, -1), _weighted(weak_of, Q))


@latest(64, owned=True)
def _answers_to(plate: DividedPlate, far: Far, omega: float) -> Complex:
    """Return U^T Y U of a plate's far combinations."""
    return responses(plate, far.fields, omega)


def answered_by(divisions: Sequence[Moving], seen: Posed, frequency: float, far: Far) -> list[Answered]:
    """Return what each division of a plate does to the coils' impedance, and what it answers to others."""
    n, found = len(seen.coils), divisions[0].coupled(divisions, seen, frequency)
    return [(Z[..., :n], np.swapaxes(Z[..., n:] @ far.fields, 1, 2), _answers_to(plate, far, 2 * np.pi * frequency))
            for plate, Z in zip(divisions, found, strict=True)]


def responses(plate: DividedPlate, columns: Array, omega: float) -> Complex:
    """Return U^T Y U of real combinations U of what a plate sees."""
    answer = plate.admittance(omega) @ columns
    return np.asarray(columns.T @ answer.real + 1j * (columns.T @ answer.imag))


def _weights(Y: Blocks, coils: int) -> tuple[_Weights, _Weights]:
    """Return W and its inverse, by parts of rows: both what is lost in the plate and what is not, to the largest."""
    parts = []
    for rows, part in Y.parts:
        own = rows < Y.size - coils
        block = part[np.ix_(own, own)]
        sides = [side * (np.sign(np.trace(side)) or 1.0) for side in (block.real, block.imag)]
        parts.append((rows[own], [_definite(side) for side in sides]))
    most = [max(max(np.linalg.eigvalsh(sides[k]).max() for _, sides in parts), np.finfo(float).tiny) for k in (0, 1)]
    strong: _Weights = []
    weak: _Weights = []
    for rows, (R, X) in parts:
        values, V = np.linalg.eigh(R / most[0] + X / most[1])
        root = np.sqrt(np.maximum(values, _FAINT**2))
        strong.append((rows, (V * root) @ V.T))
        weak.append((rows, (V / root) @ V.T))
    return strong, weak


def _definite(side: Array) -> Array:
    """Return a symmetric matrix; of both signs, as permeable metal has them, with all eigenvalues positive."""
    if np.diag(side).min() >= -_ROUNDING * np.diag(side).max():
        return side
    values, V = np.linalg.eigh(side)
    return np.asarray((V * np.abs(values)) @ V.T)


def _weighted(weights: _Weights, columns: Array) -> Array:
    """Return W, or its inverse, times columns; coils' rows as they are."""
    found = columns.copy()
    for rows, W in weights:
        found[rows] = W @ columns[rows]
    return found


def seen(plate: DividedPlate, field: Array, r: int) -> Array:
    """Return what a plate sees of fields at its box's points, (q, 3, m): D^T times these, shape (r, m)."""
    box, m = plate.box, field.shape[2]
    whole = np.ascontiguousarray(field.swapaxes(0, 1)).reshape(3, *box.order, m)
    whole = _along_axes(box, whole, 1).reshape(-1, m)
    found = np.vstack([basis.fields.T @ whole[basis.rows] for basis in plate.bases])
    return np.vstack([found, np.zeros((r - len(found), m))])


def radiated(plate: DividedPlate, moments: Array) -> Array:
    """Return D of moments (r, k) at the box's points, shape (q, 3, k)."""
    box, k = plate.box, moments.shape[1]
    whole = np.zeros((3 * int(np.prod(box.order)), k))
    for basis, own in zip(plate.bases, row_places(basis.size for basis in plate.bases), strict=True):
        whole[basis.rows] += basis.fields @ moments[own]
    whole = _along_axes(box, whole.reshape(3, *box.order, k), 0)
    return whole.reshape(3, -1, k).swapaxes(0, 1)


def _along_axes(box: Box, whole: Array, side: int) -> Array:
    """Take values at the box's points to coefficients along its axes (side 1), or by the transposed way (0)."""
    for k, n in enumerate(box.order):
        whole = np.moveaxis(np.tensordot(to_coefficients(n), whole, axes=(side, k + 1)), 0, k + 1)
    return whole


def _around(box: Box, clearance: float) -> Array:
    """Return points on the surface of a box grown by a clearance, as dense as its own, from the bottom's centre."""
    axes = [
        np.concatenate([[1.0], chebyshev_points(n), [-1.0]]) * (half + clearance)
        for n, half in zip(box.order, box.half, strict=True)
    ]
    ends = [np.arange(axis.size) % (axis.size - 1) == 0 for axis in axes]
    at = [index for index in product(*map(range, (axis.size for axis in axes)))
          if any(end[i] for end, i in zip(ends, index, strict=True))]
    points = np.stack([axis[i] for axis, i in zip(axes, np.array(at).T, strict=True)], axis=1)
    return np.asarray(points + (0.0, 0.0, box.half[2]))


def few_points(plate: DividedPlate, clearance: float, least: float) -> tuple[Any, Array]:
    """Return which of a box's points make its field beyond a clearance [m], and the matrix (few, all) to all of them.

    Those of `_chosen`, with their images in the box's middle planes along x and y.
    """
    K = 1.0 / cdist(_around(plate.box, clearance), plate.box.points())
    chosen = np.zeros(plate.box.order, dtype=bool)
    chosen.flat[_chosen(K, least)[0]] = True
    few = np.flatnonzero(chosen | chosen[::-1] | chosen[:, ::-1] | chosen[::-1, ::-1])
    return few, np.asarray(np.linalg.lstsq(K[:, few], K, rcond=_ROUNDING)[0], dtype=np.float64)


def _chosen(K: Array, least: float = _POINT) -> tuple[Any, Array]:
    """Return the columns of K that carry all others, and the matrix (few, all) that takes these to them.

    Columns weaker than `least`, to the strongest, are carried.
    """
    count = min(K.shape)
    rows = np.random.default_rng(1).normal(size=(min(4 * _SKETCH, count), len(K))) @ K
    R, order = qr(rows, mode="r", pivoting=True)
    strength = np.abs(np.diag(R))
    p = int(np.count_nonzero(strength > least * strength[0]))
    carried = np.zeros((p, K.shape[1]))
    carried[:, order[:p]] = np.eye(p)
    carried[:, order[p:]] = solve_triangular(R[:p, :p], R[:p, p:])
    return order[:p], carried
