"""Several plates in the three-dimensional model: each answers to the coils and to the others' eddy currents.

Plate X feels a few combinations ``a_X = D_X^T A(points of X)`` of the potential at its box's Chebyshev points
(`sheet_coupling`) and answers with ``s_X = Y_X a_X / (j omega)``. The same combinations are the currents' moments: with
polynomials T of its box, the integral of J T over X is D_X s_X at the points. 1 / |r - r'| is a polynomial of r on
X's box and of r' on Y's; so with Gamma, its values between the two sets of points, and the rotations R

    P_XY = mu0 / (4 pi) D_X^T (R_X^T R_Y x Gamma) D_Y,    a_X = a0_X + sum over Y != X of P_XY s_Y.

Each plate's modes are found once, alone; no air is meshed. The fixed plates F together have the admittance
``Y_F (1 - P_FF Y_F / (j omega))^-1``, and the target t feels the coils through them:

    b = a0_t + T a0_F,    T = P_tF Y_F / (j omega),
    Delta Z = a0_F^T Y_F a0_F + b^T Y_t (1 - T P_Ft Y_t / (j omega))^-1 b.

P_YX = P_XY^T makes the result reciprocal to rounding. A pose costs P_tF, T and one linear solve.

Range: plates whose boxes do not overlap; the boxes' polynomials know the smallest distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.constants import mu_0
from scipy.linalg import block_diag
from scipy.spatial.distance import cdist

from sits_mech.magnetics.sheet_coupling import box_points, drives
from sits_mech.magnetics.sheet_loops import Complex
from sits_mech.magnetics.sheet_modes import Sheeted
from sits_mech.quantities import Array
from sits_mech.sensor import Coil


@dataclass(frozen=True)
class Answering:
    """A plate in its places, ready to answer.

    Attributes
    ----------
    divisions : tuple of Sheeted
        The plate, divided in one or several ways, all with the same box.
    turns : ndarray, shape (p, 3, 3)
        Rotations; p = 1 if it does not move.
    places : ndarray, shape (p, 3)
        Of the bottom face's centre [m].
    """

    divisions: tuple[Sheeted, ...]
    turns: Array
    places: Array

    def at(self, pose: int) -> tuple[Array, Array]:
        """Rotation and the box's Chebyshev points in one pose, (3, 3) and (q, 3)."""
        return self.turns[pose], box_points(self.divisions[0].box) @ self.turns[pose].T + self.places[pose]


@dataclass(frozen=True)
class _Ready:
    """A plate at one frequency: D (q, 3, r), Y (r, r) of each division and the coils' a0 (p, n, r)."""

    transform: Array
    admittances: list[Complex]
    own: Array


def coupled_reactions(
    coils: tuple[Coil, ...], windings: str, target: Answering | None, others: Sequence[Answering], frequency: float
) -> list[Complex]:
    """Return what plates together do to the coils' impedance.

    Parameters
    ----------
    coils : tuple of Coil
        n coils.
    windings : str
        "rings" or "spiral".
    target : Answering or None
        What moves.
    others : sequence of Answering
        Fixed plates, at least one, with as many divisions.
    frequency : float
        [Hz]

    Returns
    -------
    list of ndarray, shapes (p, n, n)
        Delta Z, one array a division, not yet symmetrised [ohm]; p = 1 without target.
    """
    omega = 2 * np.pi * frequency
    fixed = [_ready(coils, windings, other, omega) for other in others]
    P, own = _between(others, fixed), np.hstack([part.own[0] for part in fixed])
    joined = [_joined(Ys, P, omega) for Ys in zip(*(part.admittances for part in fixed), strict=True)]
    alone = [own @ Y @ own.T for Y in joined]
    if target is None:
        return [Z[None] for Z in alone]
    moving = _ready(coils, windings, target, omega)
    results = [np.empty((target.places.shape[0], *Z.shape), dtype=complex) for Z in alone]
    for pose in range(target.places.shape[0]):
        P = np.hstack([
            _mutual(target.at(pose), other.at(0), moving.transform, part.transform)
            for other, part in zip(others, fixed, strict=True)
        ])  # fmt: skip
        for result, Z, Y, Y_F in zip(results, alone, moving.admittances, joined, strict=True):
            result[pose] = Z + _shielded(moving.own[pose], Y, P, (own, Y_F), omega)
    return results


def _ready(coils: tuple[Coil, ...], windings: str, plate: Answering, omega: float) -> _Ready:
    """A plate's divisions, its combinations by point."""
    first = plate.divisions[0]
    felt = [drive for _, drive in drives(coils, windings, first, (plate.turns, plate.places))]
    by_point = np.ascontiguousarray(first.transform.reshape(3, -1, first.transform.shape[1]).transpose(1, 0, 2))
    admittances = [block_diag(*(part.admittance(omega) for part in each.classes)) for each in plate.divisions]
    return _Ready(by_point, admittances, np.concatenate(felt))


def _between(plates: Sequence[Answering], parts: Sequence[_Ready]) -> Array:
    """P of all fixed plates, in blocks; nothing on the diagonal."""
    ends = np.cumsum([0, *(part.own.shape[2] for part in parts)])
    P = np.zeros((int(ends[-1]), int(ends[-1])))
    for k in range(len(plates)):
        for i in range(k):
            mutual = _mutual(plates[i].at(0), plates[k].at(0), parts[i].transform, parts[k].transform)
            P[ends[i] : ends[i + 1], ends[k] : ends[k + 1]] = mutual
            P[ends[k] : ends[k + 1], ends[i] : ends[i + 1]] = mutual.T
    return P


def _joined(admittances: Sequence[Complex], P: Array, omega: float) -> Complex:
    """Admittance of fixed plates together."""
    Y = np.asarray(block_diag(*admittances))
    return Y if len(admittances) == 1 else np.asarray(np.linalg.solve(np.eye(len(Y)) + 1j / omega * (Y @ P), Y))


def _mutual(first: tuple[Array, Array], second: tuple[Array, Array], D: Array, E: Array) -> Array:
    """P of two plates at given rotations and points, with their D; shape (r, r')."""
    if D.shape[2] < E.shape[2]:
        return _mutual(second, first, E, D).T
    q, _, r = E.shape
    currents = np.einsum("ab,qbr->qar", first[0].T @ second[0], E, optimize=True).reshape(q, 3 * r)
    field = (mu_0 / (4 * np.pi) / cdist(first[1], second[1])) @ currents
    return np.asarray(D.reshape(-1, D.shape[2]).T @ field.reshape(-1, r))


def _shielded(own: Array, Y: Complex, P: Array, others: tuple[Array, Complex], omega: float) -> Complex:
    """What the target adds to Delta Z among the others, from their a0 and joint admittance, shape (n, n)."""
    T = (P @ others[1].real + 1j * (P @ others[1].imag)) / (1j * omega)
    b = own + others[0] @ T.T
    return np.asarray(b @ Y @ np.linalg.solve(np.eye(len(Y)) - (T @ P.T) @ Y / (1j * omega), b.T))
