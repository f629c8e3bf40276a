"""Assemble dense stiffnesses into the equations of a layer with a rigid target.

What stores energy has stiffnesses on a few unknowns each: elements, and parts beside them, such as faces in contact.
The displacements are free, or bonded to the target and follow its motion q with ``T = du_bonded/dq``, or held:

    free x free        makes K, which is factored front by front (dissection.py),
    free x bonded      times T the side C (m, k),
    bonded x bonded    times T on both sides the corner D (k, k).

The equations ``K dx + C dq = -g``, ``C^T dx + D dq = -g_q`` are solved for dq first, by the stiffness that the target
feels, ``S = D - C^T K^-1 C``. Source: static condensation, R. J. Guyan, AIAA Journal 3 (1965) 380.

An indefinite K may lose digits in fronts, which pivot inside of themselves only. Then solutions are corrected by their
residual, and where that does not help SuperLU factors it, which pivots over all rows.

Fronts (dissection.py). One is the sum of the stiffnesses of its elements, or of what its two halves left

    (A, B^T; B, C),   pivots first;    A = L L^T,   W = B L^-T,   C - W W^T goes on to the larger piece,

and a solution goes down the tree, ``y = L^-1 b``, ``b_border -= W y``, and up again, ``x = L^-T (y - W^T x_border)``.
Only lower triangles are held and added up. Where A is not positive, ``A = L D L^T`` is found with pivoting inside of
the front (J. R. Bunch, L. Kaufman, Math. Comp. 31 (1977) 163), ``W = B`` stays, and ``C - B A^-1 B^T`` goes on. The
negative eigenvalues of all D are as many as those of the whole (J. J. Sylvester, Phil. Mag. 4 (1852) 138).

Pivots are not taken from outside of a front, so an indefinite matrix may be factored poorly though it is regular: the
factor says so, and whoever solves looks at the residual. One thread and one order of sums: the same digits each time.
Source: I. S. Duff, J. K. Reid, ACM Trans. Math. Softw. 9 (1983) 302.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.linalg import blas, lapack
from scipy.sparse.linalg import splu

from sits_mech.mechanics.element.dissection import Child, Dissection, Front, dissected
from sits_mech.mechanics.element.kernel import summed
from sits_mech.mechanics.element.mesh import MixedMesh
from sits_mech.quantities import Array, Integers

Stiffness = Sequence[Array]
"""Dense stiffnesses of each group, shape (e, k, k): of the elements, then of each part."""

_POOR = 1e-6  # residual of a solution, over its right-hand side, above which one correction does not help enough
_SMALL = 1e-7  # of the largest pivot's root: a front with smaller ones may have lost digits if the whole is indefinite
_WIDTH = 64  # columns that LAPACK takes at a time


class Term(NamedTuple):
    """A part of the energy, with dense stiffnesses that are symmetric on displacements."""

    energy: float
    forces: Array  # (n + 6,), on n displacements and q
    numbers: Integers  # (e, k), displacements and q; the same in every state
    stiffness: Array  # (e, k, k)


Part = Callable[[Array, Array], Term]
"""Maps displacements and q to a part of the energy with two derivatives."""


class Factored(NamedTuple):
    """A factored K."""

    solve: Callable[[Array], Array]  # right-hand sides (m,) or (m, k)
    negative: int | None  # number of negative eigenvalues; None if unknown (pivoted over all rows)


class _Group(NamedTuple):
    """Places of a group's stiffnesses."""

    free: Integers  # rows among the free; m for none
    bordering: Integers  # those on the border
    taken: Integers  # their rows of T; b for none


@dataclass(frozen=True, eq=False)
class Pattern:
    """Assembly pattern of the stiffnesses of one mesh."""

    mesh: MixedMesh
    numbers: tuple[Integers, ...]  # displacements and q of each group, (e, k) each
    free: Integers  # (m,), free displacements
    border: Integers  # (b,), bonded displacements and q
    dissection: Dissection
    _groups: tuple[_Group, ...]

    def following(self, numbers: Sequence[Integers]) -> Pattern:
        """Return the pattern of these numbers, itself if unchanged: faces in contact may change."""
        pairs = zip(self.numbers, numbers, strict=False)
        if len(numbers) == len(self.numbers) and all(own is new or np.array_equal(own, new) for own, new in pairs):
            return self
        return pattern(self.mesh, numbers, self.free, self.border)

    def sides(self, values: Stiffness, T: Array) -> tuple[Array, Array]:
        """Return C and D; T, shape (b, k), is the derivative of the border by q."""
        m, k = len(self.free), T.shape[1]
        C, D, rows = np.zeros((m + 1, k)), np.zeros((k, k)), np.vstack([T, np.zeros((1, k))])
        for group, each in zip(self._groups, values, strict=True):
            moved = rows[group.taken]
            pushed = each[group.bordering] @ moved
            C += _summed(group.free[group.bordering], pushed, m + 1)
            D += np.tensordot(moved, pushed, axes=((0, 1), (0, 1)))
        return C[:m], D

    def product(self, values: Stiffness, x: Array) -> Array:
        """Return K x for x of shape (m, k)."""
        m, k = x.shape
        full, found = np.vstack([x, np.zeros((1, k))]), np.zeros((m + 1, k))
        for group, each in zip(self._groups, values, strict=True):
            found += _summed(group.free, each @ full[group.free], m + 1)
        return found[:m]

    def matrix(self, values: Stiffness) -> sparse.csc_matrix:
        """Return K."""
        m = len(self.free)
        found = sparse.csc_matrix((m, m))
        for group, each in zip(self._groups, values, strict=True):
            rows, columns = (np.broadcast_to(own, each.shape) for own in (group.free[..., None], group.free[:, None]))
            on = (rows < m) & (columns < m)
            found = found + sparse.coo_matrix((each[on], (rows[on], columns[on])), shape=(m, m)).tocsc()
        return found

    def factored(self, values: Stiffness) -> Factored | None:
        """Return the factored K; None if singular or not finite."""
        found = factor(self.dissection, values)
        if found is not None and found.safe:
            return Factored(found.solve, found.negative)
        if not all(np.all(np.isfinite(each)) for each in values):
            return None
        probe = self.product(values, np.ones((len(self.free), 1)))
        left = np.inf if found is None else np.linalg.norm(probe - self.product(values, found.solve(probe)))
        if found is None or not left < _POOR * np.linalg.norm(probe):
            try:  # with pivots from all rows
                whole = splu(self.matrix(values), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True},
                             diag_pivot_thresh=0.01)
            except RuntimeError:  # singular
                return None
            return Factored(whole.solve, None)
        solve = found.solve

        def corrected(b: Array) -> Array:
            """Solve, and correct once by the residual."""
            x = solve(b)
            left = b - self.product(values, x.reshape(len(b), -1)).reshape(b.shape)
            return x + solve(left)

        return Factored(corrected, found.negative)


def pattern(mesh: MixedMesh, numbers: Sequence[Integers], free: Integers, border: Integers) -> Pattern:
    """Return the assembly pattern of groups of numbers (e, k), elements first; neither free nor border means held."""
    size = 1 + max(int(each.max(initial=0)) for each in (*numbers, free, border))
    inner, outer = np.full(size, len(free)), np.full(size, len(border))
    inner[free], outer[border] = np.arange(len(free)), np.arange(len(border))
    groups = []
    for each in numbers:
        taken = outer[each]
        bordering = np.flatnonzero(np.any(taken < len(border), axis=1))
        groups.append(_Group(inner[each], bordering, taken[bordering]))
    own = [np.where(group.free < len(free), group.free, -1) for group in groups]
    return Pattern(mesh, tuple(numbers), free, border, dissected(mesh, own, len(free)), tuple(groups))


def _summed(places: Integers, values: Array, size: int) -> Array:
    """Sum values (e, k, r) into their places (e, k), shape (size, r)."""
    return np.stack([summed(places, column, size) for column in np.moveaxis(values, -1, 0)], axis=1)


@dataclass(frozen=True)
class _Pivots:
    """A front's factor."""

    L: Array  # Cholesky's L, or the factored A
    W: Array
    exchanges: Integers | None  # of L D L^T; None for Cholesky


@dataclass(frozen=True)
class FactoredStiffness:
    """A factored stiffness."""

    negative: int  # number of negative eigenvalues
    safe: bool  # accurate to rounding; otherwise check the residual
    _order: Integers
    _each: tuple[tuple[Front, _Pivots], ...]

    def solve(self, b: Array) -> Array:
        """Return the solution for right-hand sides of shape (m,) or (m, k)."""
        x = np.asfortranarray(b.reshape(len(b), -1)[self._order])
        each = [(slice(front.start, front.stop), front.border, own) for front, own in self._each if front.pivots]
        for here, border, own in each:
            if own.exchanges is None:
                x[here] = y = blas.dtrsm(1.0, own.L, x[here], lower=1)
            else:
                y = _symmetric(own.L, own.exchanges, x[here])
            if len(border):
                x[border] -= own.W @ y
        for here, border, own in reversed(each):
            y = x[here] - own.W.T @ x[border] if len(border) else x[here]
            if own.exchanges is None:
                x[here] = blas.dtrsm(1.0, own.L, y, lower=1, trans_a=1, overwrite_b=1)
            else:
                x[here] = _symmetric(own.L, own.exchanges, y)
        found = np.empty_like(x)
        found[self._order] = x
        return found.reshape(b.shape)


def factor(dissection: Dissection, values: Sequence[Array]) -> FactoredStiffness | None:
    """Factor the sum of the groups' dense stiffnesses, (e, k, k) each, symmetric on free entries; None if singular."""
    left: dict[int, Array] = {}
    pivots: list[_Pivots] = []
    negative, safe = 0, True
    for number, front in enumerate(dissection.fronts):
        A, B, C = _assembled(front, values, left)
        found = _eliminated(A, B, C)
        if found is None:
            return None
        own, left[number], count, good = found
        pivots.append(own)
        negative, safe = negative + count, safe and good
    return FactoredStiffness(negative, safe, dissection.order, tuple(zip(dissection.fronts, pivots, strict=True)))


def _assembled(front: Front, values: Sequence[Array], left: dict[int, Array]) -> tuple[Array, Array, Array]:
    """Return A, B, C of a front, column by column; what its halves left is consumed."""
    P, n = front.pivots, front.pivots + len(front.border)
    if front.shares:
        whole = np.zeros((n + 1) ** 2)
        for share in front.shares:
            places = share.places[:, :, None] * (n + 1) + share.places[:, None, :]
            whole += summed(places, values[share.group][share.members], whole.size)
        square = whole.reshape(n + 1, n + 1)  # symmetric: rows are columns
        A, B, C = square[:P, :P].T, square[:P, P:n].T, square[P:n, P:n].T
    else:
        A, B, C = np.zeros((P, P)), np.zeros((P, n - P)).T, np.zeros((n - P, n - P)).T
    A, B, C = (np.asfortranarray(part) for part in (A, B, C))
    for half in front.halves:
        _add(half, left.pop(half.front), A, B, C)
    return A, B, C


def _add(half: Child, X: Array, A: Array, B: Array, C: Array) -> None:
    """Add the lower triangle left by a half to a front, run by run."""
    P = len(A)
    for k, (begin, end, at) in enumerate(half.runs):
        if at < P:
            A[at : at + end - begin, at : at + end - begin] += X[begin:end, begin:end]
            columns = slice(at, at + end - begin)
            for first, last, row in half.runs[k + 1 :]:
                if row < P:
                    A[row : row + last - first, columns] += X[first:last, begin:end]
                else:
                    B[row - P : row - P + last - first, columns] += X[first:last, begin:end]
        else:
            columns = slice(at - P, at - P + end - begin)
            for first, last, row in half.runs[k:]:
                C[row - P : row - P + last - first, columns] += X[first:last, begin:end]


def _eliminated(A: Array, B: Array, C: Array) -> tuple[_Pivots, Array, int, bool] | None:
    """Return a front's factor, the Schur complement, its negative pivots, whether all are large enough."""
    if not len(A):
        return _Pivots(A, B, None), C, 0, True
    L, failed = lapack.dpotrf(A, lower=1, clean=0)
    if not failed:
        pivots = L.diagonal()
        good = bool(pivots.min() > _SMALL * pivots.max())
        if len(C):
            B = blas.dtrsm(1.0, L, B, side=1, lower=1, trans_a=1, overwrite_b=1)
            C = blas.dsyrk(-1.0, B, beta=1.0, c=C, lower=1, overwrite_c=1)
        return _Pivots(L, B, None), C, 0, good
    L, exchanges, failed = lapack.dsytrf(A, lower=1, lwork=_WIDTH * len(A))
    if failed or not np.all(np.isfinite(L.diagonal())):
        return None
    if len(C):
        C = blas.dgemm(-1.0, B, _symmetric(L, exchanges, B.T), beta=1.0, c=C, overwrite_c=1)
    alone = exchanges > 0  # a pair of two has one eigenvalue of each sign
    negative = int(np.count_nonzero(L.diagonal()[alone] < 0.0) + np.count_nonzero(~alone) // 2)
    return _Pivots(L, B, exchanges), C, negative, False


def _symmetric(L: Array, exchanges: Integers, b: Array) -> Array:
    """Solve with L D L^T."""
    return np.asarray(lapack.dsytrs(L, exchanges, b, lower=1)[0])
