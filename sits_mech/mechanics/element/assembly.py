"""How do element stiffnesses become the equations of a layer with a rigid target? Straight, by a fixed map.

The displacements are free, or bonded to the target and follow its motion q with ``T = du_bonded/dq``, or held. Entries
of element stiffnesses go

    free x free        to K, a sparse matrix whose pattern stays,
    free x bonded      times T to the side C (m, k),
    bonded x bonded    times T on both sides to the corner D (k, k),

a sum over repeated places each. Free displacements are numbered so that elimination fills in little, found once for a
mesh. The equations ``K dx + C dq = -g``, ``C^T dx + D dq = -g_q`` are solved for dq first, by the stiffness that the
target feels, ``S = D - C^T K^-1 C``. Source: static condensation, R. J. Guyan, AIAA Journal 3 (1965) 380.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from sits_mech.mechanics.element.kernel import summed
from sits_mech.mechanics.element.mesh import Indices
from sits_mech.quantities import Array


class Term(NamedTuple):
    """A part of the energy, its forces (n + 6,) on the n displacements and q, its stiffness as triplets of these.

    Their rows and columns are the same in every state.
    """

    energy: float
    forces: Array
    rows: Indices
    columns: Indices
    values: Array


Part = Callable[[Array, Array], Term]
"""Displacements and q in, a part of the energy with two derivatives out."""


class _Sums(NamedTuple):
    """Which entries are summed, where to, and which rows of T they take."""

    entries: Indices
    places: Indices
    taken: Indices


@dataclass(frozen=True)
class Pattern:
    """Where the stiffnesses' entries of one mesh go.

    Attributes
    ----------
    free : ndarray, shape (m,)
        Numbers of the free displacements in the order of elimination.
    border : ndarray, shape (b,)
        Numbers of the bonded displacements and of q.
    """

    free: Indices
    border: Indices
    _indices: Indices
    _indptr: Indices
    _inner: _Sums
    _side: _Sums
    _corner: _Sums

    def equations(self, values: Array, T: Array) -> tuple[sparse.csc_matrix, Array, Array]:
        """Return K, C, D of stiffness entries; T, shape (b, k), moves the border by q."""
        m, b = len(self.free), len(self.border)
        data = summed(self._inner.places, values[self._inner.entries], len(self._indices))
        K = sparse.csc_matrix((data, self._indices, self._indptr), shape=(m, m))
        side, corner = values[self._side.entries, None] * T[self._side.taken], values[self._corner.entries]
        C = np.stack([summed(self._side.places, column, m) for column in side.T], axis=1)
        return K, C, T.T @ summed(self._corner.places, corner, b * b).reshape(b, b) @ T


def pattern(rows: Indices, columns: Indices, free: Indices, border: Indices, *, ordered: bool = False) -> Pattern:
    """Return where entries at rows and columns go.

    Parameters
    ----------
    rows, columns : ndarray
        Numbers of displacements and of q of every entry; what is neither free nor border is held.
    free, border : ndarray
    ordered : bool
        Whether `free` stands in the order of elimination already.
    """
    if ordered:
        return _pattern(rows, columns, free, border)
    inner = np.full(1 + max(int(rows.max()), int(border.max())), -1)
    inner[free] = np.arange(len(free))
    both = (inner[rows] >= 0) & (inner[columns] >= 0)
    places, ones = (inner[rows[both]], inner[columns[both]]), np.ones(np.count_nonzero(both))
    K = sparse.coo_matrix((ones, places), shape=(len(free), len(free))).tocsc()
    K.setdiag(K.diagonal() + 1.0 + K @ np.ones(len(free)))
    order = splu(K, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.0).perm_c
    return _pattern(rows, columns, free[np.argsort(order)], border)


def factored(K: sparse.csc_matrix) -> Callable[[Array], Array] | None:
    """Return the solver of a system whose order of elimination is its own; None where it is singular."""
    try:
        factor = splu(K, permc_spec="NATURAL", options={"SymmetricMode": True}, diag_pivot_thresh=0.01)
    except RuntimeError:
        return None
    return factor.solve


def entries(numbers: Indices) -> tuple[Indices, Indices]:
    """Return the rows and columns of the stiffnesses of elements with unknowns `numbers`, shape (e, k)."""
    count = numbers.shape[1]
    return np.repeat(numbers, count, axis=1).ravel(), np.tile(numbers, (1, count)).ravel()


def _pattern(rows: Indices, columns: Indices, free: Indices, border: Indices) -> Pattern:
    """Pattern in a given order of the free displacements."""
    size, m, b = 1 + max(int(rows.max()), int(border.max())), len(free), len(border)
    inner, outer = np.full(size, -1), np.full(size, -1)
    inner[free], outer[border] = np.arange(m), np.arange(b)
    both = np.flatnonzero((inner[rows] >= 0) & (inner[columns] >= 0))
    key = inner[columns[both]] * np.int64(m) + inner[rows[both]]
    kept, places = np.unique(key, return_inverse=True)
    indptr = np.searchsorted(kept, np.arange(m + 1) * np.int64(m))
    side = np.flatnonzero((inner[rows] >= 0) & (outer[columns] >= 0))
    corner = np.flatnonzero((outer[rows] >= 0) & (outer[columns] >= 0))
    none = np.zeros(0, dtype=np.int64)
    return Pattern(
        free, border, (kept % m).astype(np.int32), indptr.astype(np.int32), _Sums(both, places.ravel(), none),
        _Sums(side, inner[rows[side]], outer[columns[side]]),
        _Sums(corner, outer[rows[corner]] * b + outer[columns[corner]], none),
    )
