"""Several plates in the three-dimensional model: each answers to the coils and to the others' eddy currents.

Plate X sees a few combinations ``a_X = D_X^T A(points of X)`` of the potential at its box's Chebyshev points
(`coupling`) and answers with ``s_X = Y_X a_X / (j omega)``. The same combinations are the currents' moments: with
polynomials T of its box, the integral of J T over X is D_X s_X at the points. 1 / |r - r'| is a polynomial of r on
X's box and of r' on Y's; so with Gamma, its values between the two sets of points, and the rotations R

    P_XY = mu0 / (4 pi) D_X^T (R_X^T R_Y x Gamma) D_Y,    a_X = a0_X + sum over Y != X of P_XY s_Y.

Each plate's modes are found once, alone; no air is meshed. A fixed plate sees the coils without polynomials between
(`sources`): each coil is one combination more, a_X ends with the unit vector of coil c, D_X and P_XY have zeros there.
Its polynomials carry what moves and what other plates radiate. The fixed plates F together have the admittance
``Y_F (1 - P_FF Y_F / (j omega))^-1``, and the target t sees the coils through them:

    b = a0_t + T a0_F,    T = P_tF Y_F / (j omega),
    Delta Z = a0_F^T Y_F a0_F + b^T Y_t (1 - T P_Ft Y_t / (j omega))^-1 b.

P_YX = P_XY^T makes the result reciprocal to rounding. Plates apart see little detail of each other: P_tF = Q X has few
columns Q, found with random currents that are as strong as they are answered (Delta Z keeps 1e-5), and a pose costs
their field, products and a small solve.

Range: plates whose boxes do not overlap; the boxes' polynomials know the smallest distance.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple, Protocol

import numpy as np
from scipy.constants import mu_0
from scipy.linalg import block_diag
from scipy.spatial.distance import cdist

from sits_mech.magnetics.space.coupling import drives
from sits_mech.magnetics.space.fields import Box
from sits_mech.magnetics.space.modes import Blocks, Sheeted
from sits_mech.quantities import Array, Complex
from sits_mech.scene.sensor import Coil

_SKETCH = 100  # currents that first tell what two plates see of each other
_PROBES = 4  # that check it
_FAINT = 1e-6  # of the strongest answer, below which combinations count alike
_LOST = 1e-4  # of what they see, at most: the detail that is lost first drives least


class Plate(Hashable, Protocol):
    """A division of a plate, of metal (`Sheeted`) or of ferrite (`ferrite.core`)."""

    @property
    def box(self) -> Box: ...

    @property
    def transform(self) -> Array: ...

    def admittance(self, omega: float) -> Blocks:
        """Return Y of its combinations and then of the coils that it sees."""
        ...


@dataclass(frozen=True)
class SpacePlate:
    """A plate in its places, ready to answer.

    Attributes
    ----------
    divisions : tuple of Plate
        The plate, divided in one or several ways, all with the same box.
    turns : ndarray, shape (p, 3, 3)
        Rotations; p = 1 if it does not move.
    places : ndarray, shape (p, 3)
        Of the bottom face's centre [m].
    """

    divisions: tuple[Plate, ...]
    turns: Array
    places: Array

    def at(self, pose: int) -> tuple[Array, Array]:
        """Rotation and the box's Chebyshev points in one pose, (3, 3) and (q, 3)."""
        return self.turns[pose], self.divisions[0].box.points() @ self.turns[pose].T + self.places[pose]


@dataclass(frozen=True, eq=False)
class _Ready:
    """A plate at one frequency: D (q, 3, r), Y (r, r) of each division and the coils' a0 (p, n, r)."""

    transform: Array
    admittances: list[Blocks]
    own: Array

    @cached_property
    def weight(self) -> Array:
        """How strongly each combination is answered, the root of Y's diagonal to its largest, shape (r,)."""
        size = np.sqrt(np.abs(self.admittances[0].diagonal))
        return np.asarray(np.maximum(size / size.max(), _FAINT))


class _Placed(NamedTuple):
    """A plate in one pose: rotation and points, and what it is."""

    place: tuple[Array, Array]
    plate: _Ready


def coupled_reactions(
    coils: tuple[Coil, ...], windings: str, target: SpacePlate | None, others: Sequence[SpacePlate], frequency: float
) -> list[Complex]:
    """Return what plates together do to the coils' impedance.

    Parameters
    ----------
    coils, windings, frequency
        As in `coupling.reactions`.
    target : SpacePlate or None
        What moves.
    others : sequence of SpacePlate
        Fixed plates, at least one, with as many divisions.

    Returns
    -------
    list of ndarray, shapes (p, n, n)
        Delta Z, one array a division, not yet symmetrised [ohm]; p = 1 without target.
    """
    omega = 2 * np.pi * frequency
    fixed = [_at_rest(coils, other, omega) for other in others]
    own = np.hstack([part.own[0] for part in fixed])
    placed = [_Placed(other.at(0), part) for other, part in zip(others, fixed, strict=True)]
    linked = _links(placed)
    divisions = list(zip(*(part.admittances for part in fixed), strict=True))
    if target is None:
        return [_answer(Ys, linked, own.T, omega)[None] for Ys in divisions]
    moving, n = _ready(coils, windings, target, omega), len(coils)
    results = [np.empty((target.places.shape[0], n, n), dtype=complex) for _ in divisions]
    for pose in range(target.places.shape[0]):
        Q, X = _factors(_Placed(target.at(pose), moving), placed)
        for result, Y, Ys in zip(results, moving.admittances, divisions, strict=True):
            F = _answer(Ys, linked, np.hstack([own.T, X.T]), omega)
            result[pose] = F[:n, :n] + _shielded(moving.own[pose], Y, Q, F[n:], omega)
    return results


def _ready(coils: tuple[Coil, ...], windings: str, plate: SpacePlate, omega: float) -> _Ready:
    """A plate's divisions, its combinations by point."""
    first = plate.divisions[0]
    if not isinstance(first, Sheeted):
        raise TypeError(f"a plate that moves must be of metal, got {type(first).__name__}")
    found = drives(coils, windings, first, (plate.turns, plate.places))
    linked = [np.take_along_axis(drive, rank[..., None], axis=1) for _, drive, rank, _ in found]
    return _Ready(_by_point(first), [each.admittance(omega) for each in plate.divisions], np.concatenate(linked))


def _at_rest(coils: tuple[Coil, ...], plate: SpacePlate, omega: float) -> _Ready:
    """A fixed plate's divisions: it sees each coil as one of its own combinations, the last ones."""
    transform = _by_point(plate.divisions[0])
    own = np.eye(len(coils), transform.shape[2], transform.shape[2] - len(coils))
    return _Ready(transform, [each.admittance(omega) for each in plate.divisions], own[None])


@lru_cache(maxsize=16)
def _by_point(plate: Plate) -> Array:
    """A plate's combinations by point, shape (q, 3, r)."""
    transform = plate.transform
    return np.ascontiguousarray(transform.reshape(3, -1, transform.shape[1]).transpose(1, 0, 2))


def _links(placed: Sequence[_Placed]) -> tuple[list[Array], Array]:
    """Q_X of each fixed plate and C with P_XY = Q_X C_XY Q_Y^T, nothing on the diagonal."""
    if len(placed) == 1:
        return [np.zeros((placed[0].plate.transform.shape[2], 0))], np.zeros((0, 0))
    found = [_factors(plate, [*placed[:k], *placed[k + 1 :]]) for k, plate in enumerate(placed)]
    Qs = [Q for Q, _ in found]
    rows = [X @ block_diag(*Qs[:k], *Qs[k + 1 :]) for k, (_, X) in enumerate(found)]
    starts = np.cumsum([0, *(Q.shape[1] for Q in Qs)])
    C = np.vstack([np.insert(row, start, np.zeros((Q.shape[1], 1)), axis=1)
                   for row, start, Q in zip(rows, starts[:-1], Qs, strict=True)])  # fmt: skip
    return Qs, (C + C.T) / 2


def _answer(admittances: Sequence[Blocks], links: tuple[list[Array], Array], V: Array, omega: float) -> Complex:
    """V^T Y_F V of fixed plates together, (1 - P Y / (j omega))^-1 by the few columns of P."""
    (Qs, C), ends = links, np.cumsum([Y.size for Y in admittances])[:-1]
    parts = [np.hstack(pair) for pair in zip(np.split(V, ends), Qs, strict=True)]
    columns = V.shape[1]
    found = [_between_both(part, Y) for part, Y in zip(parts, admittances, strict=True)]
    outer, B = sum(Z[:columns, :columns] for Z in found), np.hstack([Z[:columns, columns:] for Z in found])
    whole, L = block_diag(*(Z[columns:, columns:] for Z in found)), C / (1j * omega)
    return np.asarray(outer + B @ L @ np.linalg.solve(np.eye(len(C)) - whole @ L, B.T))


def _mutual(first: tuple[Array, Array], second: tuple[Array, Array], D: Array, E: Array) -> Array:
    """P of two plates at given rotations and points, with their D; shape (r, r')."""
    return _mutual(second, first, E, D).T if D.shape[2] < E.shape[2] else _linked(first, second, D, E)


def _factors(target: _Placed, fixed: Sequence[_Placed]) -> tuple[Array, Array]:
    """Q (r, k) and X (k, r') with P_tF = Q X to `_LOST`, as k random currents of F tell.

    Combinations count as strongly as they are answered, on either side: most of them are faint. Where half of them are
    needed all the same, Q is the identity.
    """
    place, D, w = target.place, target.plate.transform, target.plate.weight[:, None]
    seen = [(other.place, other.plate.transform, other.plate.weight[:, None]) for other in fixed]
    r, count, rng = sum(len(v) for _, _, v in seen), _SKETCH, np.random.default_rng(0)
    linked = np.zeros((len(w), 0))
    while 2 * count < min(len(w), r):
        more = count + _PROBES - linked.shape[1]
        some = [(other, np.tensordot(E, v * rng.normal(size=(len(v), more)), 1)) for other, E, v in seen]
        linked = np.hstack([linked, w * sum(_linked(place, other, D, moments) for other, moments in some)])
        Q, probes = np.linalg.qr(linked[:, :count])[0], linked[:, count:]
        if np.linalg.norm(probes - Q @ (Q.T @ probes)) <= _LOST * np.linalg.norm(probes):
            return Q / w, np.vstack([_linked(other, place, E, np.tensordot(D, w * Q, 1)) for other, E, _ in seen]).T
        count = 2 * count
    return np.eye(len(w)), np.hstack([_mutual(place, other, D, E) for other, E, _ in seen])


def _linked(first: tuple[Array, Array], second: tuple[Array, Array], D: Array, moments: Array) -> Array:
    """What a plate with D sees of another's moments (q, 3, k) at its points, by both rotations and points; (r, k)."""
    q, _, k = moments.shape
    turned = np.einsum("ab,qbr->qar", first[0].T @ second[0], moments, optimize=True).reshape(q, 3 * k)
    field = (mu_0 / (4 * np.pi) / cdist(first[1], second[1])) @ turned
    return np.asarray(D.reshape(-1, D.shape[2]).T @ field.reshape(-1, k))


def _between_both(Q: Array, Y: Blocks) -> Complex:
    """Q^T Y Q for real Q."""
    answer = Y @ Q
    return np.asarray(Q.T @ answer.real + 1j * (Q.T @ answer.imag))


def _shielded(own: Array, Y: Blocks, Q: Array, seen: Complex, omega: float) -> Complex:
    """What the target adds to Delta Z among the others, from X Y_F (a0_F, X^T); shape (n, n)."""
    n = len(own)
    b = own + seen[:, :n].T @ Q.T / (1j * omega)
    S = seen[:, n:] / (1j * omega) ** 2
    answer = (Y @ b.real.T + 1j * (Y @ b.imag.T)).T
    u = np.linalg.solve(np.eye(len(S)) - _between_both(Q, Y) @ S, Q.T @ answer.T)
    return np.asarray(answer @ b.T + (answer @ Q) @ (S @ u))
