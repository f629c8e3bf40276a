"""Assemble dense stiffnesses into the equations of a layer with a rigid target.

What stores energy has stiffnesses on a few unknowns each: elements, and parts beside them, such as faces in contact.
The displacements are free, or bonded to the target and follow its motion q with ``T = du_bonded/dq``, or held:

    free x free        makes K, which is factored front by front (dissection.py, fronts.py),
    free x bonded      times T the side C (m, k),
    bonded x bonded    times T on both sides the corner D (k, k).

The equations ``K dx + C dq = -g``, ``C^T dx + D dq = -g_q`` are solved for dq first, by the stiffness that the target
feels, ``S = D - C^T K^-1 C``. Source: static condensation, R. J. Guyan, AIAA Journal 3 (1965) 380.

An indefinite K may lose digits in fronts, which pivot inside of themselves only. Then solutions are corrected by their
residual, and where that does not help SuperLU factors it, which pivots over all rows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from sits_mech.mechanics.element.dissection import Dissection, dissected
from sits_mech.mechanics.element.fronts import factor
from sits_mech.mechanics.element.kernel import summed
from sits_mech.mechanics.element.mesh import Indices, MixedMesh
from sits_mech.quantities import Array

Stiffness = Sequence[Array]
"""Dense stiffnesses of each group, shape (e, k, k): of the elements, then of each part."""

_POOR = 1e-6  # residual of a solution, over its right-hand side, above which one correction does not help enough


class Term(NamedTuple):
    """A part of the energy, with dense stiffnesses that are symmetric on displacements."""

    energy: float
    forces: Array  # (n + 6,), on n displacements and q
    numbers: Indices  # (e, k), displacements and q; the same in every state
    stiffness: Array  # (e, k, k)


Part = Callable[[Array, Array], Term]
"""Maps displacements and q to a part of the energy with two derivatives."""


class Factored(NamedTuple):
    """A factored K."""

    solve: Callable[[Array], Array]  # right-hand sides (m,) or (m, k)
    negative: int | None  # number of negative eigenvalues; None if unknown (pivoted over all rows)


class _Group(NamedTuple):
    """Places of a group's stiffnesses."""

    free: Indices  # rows among the free; m for none
    bordering: Indices  # those on the border
    taken: Indices  # their rows of T; b for none


@dataclass(frozen=True, eq=False)
class Pattern:
    """Assembly pattern of the stiffnesses of one mesh."""

    mesh: MixedMesh
    numbers: tuple[Indices, ...]  # displacements and q of each group, (e, k) each
    free: Indices  # (m,), free displacements
    border: Indices  # (b,), bonded displacements and q
    dissection: Dissection
    _groups: tuple[_Group, ...]

    def following(self, numbers: Sequence[Indices]) -> Pattern:
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
            return _pivoted(self.matrix(values))
        solve = found.solve

        def corrected(b: Array) -> Array:
            """Solve, and correct once by the residual."""
            x = solve(b)
            left = b - self.product(values, x.reshape(len(b), -1)).reshape(b.shape)
            return np.asarray(x + solve(left))

        return Factored(corrected, found.negative)


def pattern(mesh: MixedMesh, numbers: Sequence[Indices], free: Indices, border: Indices) -> Pattern:
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


def _summed(places: Indices, values: Array, size: int) -> Array:
    """Sum values (e, k, r) into their places (e, k), shape (size, r)."""
    return np.stack([summed(places, column, size) for column in np.moveaxis(values, -1, 0)], axis=1)


def _pivoted(K: sparse.csc_matrix) -> Factored | None:
    """Factor with pivots from all rows; None if singular."""
    try:
        found = splu(K, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.01)
    except RuntimeError:
        return None
    return Factored(found.solve, None)
