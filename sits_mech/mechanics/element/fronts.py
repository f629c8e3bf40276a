"""Factor and solve a symmetric stiffness front by front, with dense algebra.

In the order of dissection.py a front is the sum of the stiffnesses of its elements, or of what its two halves left

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

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import blas, lapack

from sits_mech.mechanics.element.dissection import Child, Dissection, Front, Share
from sits_mech.mechanics.element.kernel import summed
from sits_mech.mechanics.element.mesh import Indices
from sits_mech.quantities import Array

_SMALL = 1e-7  # of the largest pivot's root: a front with smaller ones may have lost digits if the whole is indefinite
_WIDTH = 64  # columns that LAPACK takes at a time


@dataclass(frozen=True)
class _Pivots:
    """A front's factor."""

    L: Array  # Cholesky's L, or the factored A
    W: Array
    exchanges: Indices | None  # of L D L^T; None for Cholesky


@dataclass(frozen=True)
class Factor:
    """A factored stiffness."""

    negative: int  # number of negative eigenvalues
    safe: bool  # accurate to rounding; otherwise check the residual
    _order: Indices
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


def factor(dissection: Dissection, values: Sequence[Array]) -> Factor | None:
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
    return Factor(negative, safe, dissection.order, tuple(zip(dissection.fronts, pivots, strict=True)))


def _assembled(front: Front, values: Sequence[Array], left: dict[int, Array]) -> tuple[Array, Array, Array]:
    """Return A, B, C of a front, column by column; what its halves left is consumed."""
    P, n = front.pivots, front.pivots + len(front.border)
    if front.shares:
        whole = np.zeros((n + 1) ** 2)
        for share in front.shares:
            whole += _summed(share, values[share.group], n + 1)
        square = whole.reshape(n + 1, n + 1)  # symmetric: rows are columns
        A, B, C = square[:P, :P].T, square[:P, P:n].T, square[P:n, P:n].T
    else:
        A, B, C = np.zeros((P, P)), np.zeros((P, n - P)).T, np.zeros((n - P, n - P)).T
    A, B, C = (np.asfortranarray(part) for part in (A, B, C))
    for half in front.halves:
        _add(half, left.pop(half.front), A, B, C)
    return A, B, C


def _summed(share: Share, values: Array, size: int) -> Array:
    """Sum stiffnesses into a front's square, shape (size**2,)."""
    places = share.places[:, :, None] * size + share.places[:, None, :]
    return summed(places, values[share.members], size**2)


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


def _symmetric(L: Array, exchanges: Indices, b: Array) -> Array:
    """Solve with L D L^T."""
    return np.asarray(lapack.dsytrs(L, exchanges, b, lower=1)[0])
