"""Several plates in the three-dimensional model: each answers to the coils and to the others' eddy currents.

Plate X sees a few combinations f_X of what comes from the others, and answers with moments f'_X = Y_X f_X / (j omega),
whose field the others see (`far`); with C, their moments at their points, K = 1/|r - r'| and the rotations R,

    P_XY = mu0 / (4 pi) C_X^T (R_X^T R_Y x K) C_Y,    f_X = sum over Y != X of P_XY f'_Y.

Fixed plates F see the coils without polynomials between (`sources`). What they answer together, to the coils and to
what comes from elsewhere, is found once for all poses:

    Y_F = (1 - Y P_FF / (j omega))^-1 Y,    (Z_FF, T; T^T, S) = Y_F by coils and by combinations.

The moving target t sees the coils itself, in each pose, a (`coupling`, `near`): Delta Z_t = a^T Y_t a of its own, and
e = U^T Y_t a of its far combinations. With B = P_tF S P_Ft / (j omega)^2 and g = P_tF T^T / (j omega),

    Delta Z = Z_FF + Delta Z_t + e^T g + g^T e + g^T Y_t g + h^T B (1 - Y_t B)^-1 h,    h = e + Y_t g.

P_YX = P_XY^T makes the result reciprocal to rounding. No air is meshed, and a pose costs products of small matrices.

Range: plates whose boxes do not overlap; the boxes' polynomials know the smallest distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from scipy.constants import mu_0
from scipy.linalg import lu_factor, lu_solve
from scipy.spatial.distance import cdist

from sits_mech.geometry.collision import PlacedPlate
from sits_mech.magnetics.space.far import DividedPlate, Far, FieldRequest, Moving, answered_by, responses, seen_from
from sits_mech.magnetics.space.fields import HELD, Blocks, row_places
from sits_mech.magnetics.space.near import resting_field
from sits_mech.magnetics.space.plates import Divided
from sits_mech.magnetics.space.sources import Posed
from sits_mech.memory import latest
from sits_mech.quantities import Array, Complex

_MOVING, _FIXED = 1e-3, 5e-3  # directions that are left out, to the strongest: tests/magnetics/space/test_far.py
_LEFT = 3e-3  # of what is solved in steps: its square counts


@dataclass(frozen=True)
class SpacePlate:
    """A fixed plate in its place, ready to answer."""

    divisions: tuple[DividedPlate, ...]  # in one or several ways, all with the same box
    turns: Array  # (1, 3, 3) rotation
    places: Array  # (1, 3) of the bottom face's centre [m]


@dataclass(frozen=True, eq=False)
class _Placed:
    """A plate's points and moments in space: (q, 3) and (q, 3, k)."""

    points: Array
    moments: Array

    @classmethod
    def of(cls, far: Far, turn: Array, place: Array) -> _Placed:
        """Return a plate in one of its places."""
        return cls(far.points @ turn.T + place, turn @ far.moments)

    def linked(self, other: _Placed) -> Array:
        """Return P between two, shape (k, k')."""
        K = mu_0 / (4 * np.pi) / cdist(self.points, other.points)
        field = K @ other.moments.reshape(len(other.points), -1)
        k = self.moments.shape[2]
        return self.moments.reshape(-1, k).T @ field.reshape(self.moments.shape[0] * 3, -1)


@dataclass(frozen=True, eq=False)
class _Together:
    """What fixed plates answer together, on one division."""

    coils: Complex  # Z_FF (n, n)
    fields: Complex  # T^T / (j omega), (k, n)
    alone: tuple[tuple[slice, Complex], ...]  # Y / (j omega)^2, by the plates' places in it
    factor: Any  # of 1 - Y P_FF / (j omega)

    def __matmul__(self, columns: Complex) -> Complex:
        """Return S / (j omega)^2 times columns (k, m)."""
        driven = np.concatenate([Y @ columns[own] for own, Y in self.alone])
        return lu_solve(self.factor, driven, overwrite_b=True, check_finite=False)


def coupled_reactions(
    target: Sequence[Moving], seen: Posed, others: Sequence[SpacePlate], frequency: float
) -> list[Complex]:
    """Return Delta Z of plates together, one (p, n, n) [ohm] a division, not yet symmetrised; p = 1 without target.

    `target` are the divisions of what moves, if anything does, `others` at least one fixed plate, with as many.
    """
    omega, n = 2 * np.pi * frequency, len(seen.coils)
    where = tuple((*part.turns[0].ravel().tolist(), *part.places[0].tolist()) for part in others)
    plates = tuple(part.divisions for part in others)
    fixed, answers = _fixed(plates[0][0], plates, where, omega, n)
    if not target:
        return [together.coils[None] for together in answers]
    clearance = min(part.divisions[0].box.clearance for part in others)
    far = seen_from(target[0], clearance, omega, _MOVING)
    found = answered_by(target, seen, frequency, far)
    results = [np.empty((len(seen.places), n, n), dtype=complex) for _ in found]
    for pose, place in enumerate(zip(seen.turns, seen.places, strict=True)):
        moved = _Placed.of(far, *place)
        P = np.hstack([moved.linked(other) for other in fixed])
        V = np.zeros((P.shape[0], 0), dtype=complex)
        for result, (own, e, Y), together in zip(results, found, answers, strict=True):
            g = _times(P, together.fields)
            h = e[pose] + Y @ g
            V, back = _back(V, Y, P, together, h)
            result[pose] = together.coils + own[pose] + e[pose].T @ g + g.T @ h + back
    return results


@latest(16, owned=True)
def _fixed(
    first: DividedPlate, plates: tuple[tuple[DividedPlate, ...], ...], where: tuple[tuple[float, ...], ...],
    omega: float, n: int
) -> tuple[tuple[_Placed, ...], tuple[_Together, ...]]:
    """Return where fixed plates are, and what they answer together to n coils, by divisions.

    Of plates by their divisions (the first keeps it), and their turns and places.
    """
    fars = [seen_from(divisions[0], divisions[0].box.clearance, omega, _FIXED, n) for divisions in plates]
    places = zip(fars, np.reshape(where, (-1, 4, 3)), strict=True)
    placed = tuple(_Placed.of(far, at[:3], at[3]) for far, at in places)
    columns = row_places(far.fields.shape[1] for far in fars)
    L = np.zeros((columns[-1].stop, columns[-1].stop))
    for (other, own), (one, rows) in combinations(zip(placed, columns, strict=True), 2):
        L[rows, own] = one.linked(other)
    L += L.T
    answers = []
    for divisions in zip(*plates, strict=True):
        each = [
            responses(plate, np.hstack([np.eye(len(far.fields), n, n - len(far.fields)), far.fields]), omega)
            for plate, far in zip(divisions, fars, strict=True)
        ]
        Y = Blocks(len(L), tuple((np.r_[own], Z[n:, n:]) for own, Z in zip(columns, each, strict=True)))
        T = np.vstack([Z[n:, :n] for Z in each])
        A = np.eye(len(L)) + (Y @ L) * (1j / omega)
        factor = lu_factor(A, overwrite_a=True, check_finite=False)
        through = lu_solve(factor, T, check_finite=False) / (1j * omega)
        outer = sum(Z[:n, :n] for Z in each) + T.T @ L @ through
        alone = tuple((own, Z[n:, n:] / (1j * omega) ** 2) for own, Z in zip(columns, each, strict=True))
        answers.append(_Together(outer, through, alone, factor))
    return placed, tuple(answers)


def _times(P: Array, X: Complex) -> Complex:
    """Return P X for a real P, which is not made complex."""
    return (P @ np.ascontiguousarray(X).view(np.float64)).view(np.complex128)


def _back(V: Complex, Y: Complex, P: Array, S: _Together, h: Complex) -> tuple[Complex, Complex]:
    """Return orthonormal directions of x, from some (k, m) on, and h^T B x, where (1 - Y B) x = h, B = P S P^T.

    What is left of h, l, by least squares in these directions, adds the next ones; x^T B h + l^T B x is symmetric, and
    off by the square of l, as B and Y are symmetric.
    """
    new = np.linalg.qr(np.hstack([V, h]))[0]
    V = BV = A = np.zeros((len(h), 0), dtype=complex)
    while new.size:
        y = _times(P, S @ _times(P.T, new))
        V, BV, A = np.hstack([V, new]), np.hstack([BV, y]), np.hstack([A, new - Y @ y])
        c = np.linalg.lstsq(A, h)[0]
        left = h - A @ c
        enough = np.linalg.norm(left) <= _LEFT * np.linalg.norm(h)
        new = new[:, :0] if enough else np.linalg.qr(np.hstack([V, left]))[0][:, V.shape[1] :]
    y = BV @ c
    return V, y.T @ h + left.T @ y


def field_of_all(
    parts: Sequence[PlacedPlate], plates: Sequence[Divided], seen: Posed, frequency: float, asked: FieldRequest
) -> Complex:
    """Return what is asked of the field of plates, each by the coils alone, some poses after others."""
    found, step = list[Complex](), max(1, HELD // (asked.points.size * len(seen.coils)))
    each = [replace(seen, turns=part.turns, places=part.places) for part in parts]
    for first in range(0, len(seen.places), step):
        some = [own if len(own.turns) == 1 else own.some(slice(first, first + step)) for own in each]
        each_of = zip((plate.divisions[0] for plate in plates), some, strict=True)
        found.append(asked.of(np.asarray(sum(field_of(*one, frequency, asked.points) for one in each_of))))
    return np.concatenate(found, axis=1)


def field_of(plate: Any, seen: Posed, frequency: float, points: Array) -> Complex:
    """Return B of a plate's currents by each coil at points (k, 3), (p, k, 3, n) [T/A]; at rest once for all poses."""
    if getattr(plate, "sources", 0):
        own = ((points - seen.places[0]) @ seen.turns[0]).tobytes()
        return np.asarray(seen.turns[0] @ resting_field(plate, 2 * np.pi * frequency, own))[None]
    _, (found,) = plate.reactions([plate], seen, frequency, None, FieldRequest(points, lambda B: B[None]))
    return np.asarray(found)
