"""Energy, stress and stiffness of a deformed silicone: one chain rule for any law.

A law of the invariants ``I1 = J^(-2/3) s`` and ``I2 = J^(-4/3) r`` depends on F by s, r and J alone (kinematics.py), in
space and in plane strain. With its derivatives by these

    P = w_s ds + w_r dr + w_J dJ
    A = w_s d2s + w_r d2r + w_J d2J + sum_xy w_xy v_x x v_y,        v = (ds, dr, dJ)

One of the principal stretches has, with ``F = U diag(lambda) V`` and derivatives w_i, w_ij by the stretches, in the
frame of U and V

    P_ii = w_i,    dP_ii = sum_j w_ij dF_jj,    2 dP_ij = (s + t) dF_ij + (s - t) dF_ji for i != j,
    s = (w_i - w_j)/(lambda_i - lambda_j),      t = (w_i + w_j)/(lambda_i + lambda_j).

With ``beta_i = lambda_i w_i``, s is ``((beta_i - beta_j)/(lambda_i - lambda_j) - w_j)/lambda_i``; the quotient comes
from the law, which divides nothing by what vanishes: smooth through equal stretches, where directions are undefined.

Every law is split into an isochoric part, which is here, and ``K/2 (J - 1)^2``, which belongs to the mixed element. A
part of K may act pointwise as ``guard (J - 1 - ln J)``, without bound towards inversion. All in units of the initial
shear modulus. Source: G. A. Holzapfel, Nonlinear Solid Mechanics (2000), chapter 6; the tangent in principal directions
R. W. Ogden, Non-linear Elastic Deformations (1984), section 6.1.4.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from sits_mech.quantities import Array
from sits_mech.silicone.kinematics import POINTS, Kinematics, Principal, diagonal
from sits_mech.silicone.laws import Constants, known_law
from sits_mech.silicone.laws.law import InvariantDerivatives, Invariants, OfInvariants, OfStretches, StretchDerivatives
from sits_mech.silicone.material import Silicone

Energy = Callable[[Kinematics], tuple[Array, Array, Array]]
"""Energy density (...), stress P (..., k) and tangent A (..., k, k) of a deformation [shear moduli]."""

Stress = Callable[[Kinematics], tuple[Array, Array]]
"""Energy density (...) and stress P (..., k) of a deformation [shear moduli]."""


class PointState(NamedTuple):
    """Energy density and stress at points; `tangent` writes A into an array of its shape."""

    w: Array
    P: Array
    tangent: Callable[[Array], None]


class Past(Protocol):
    """The history of each point of an array (points.py)."""

    def part(self, some: slice) -> Past:
        """Return the past of some points, counted along one axis."""

    def acting(self, elastic: PointState, point: Kinematics) -> PointState:
        """Return an elastic state with softening and viscous stresses, volume apart."""


_PAIRS = ((1, 2), (2, 0), (0, 1))
_THIRDS = np.full(3, 1.0 / 3.0)


def isochoric_energy(silicone: Silicone, guard: float = 0.0, past: Past | None = None) -> Energy:
    """Return ``Kinematics -> (w, P, A)`` in units of the initial shear modulus, in space and plane strain.

    `guard`: part of the bulk modulus that acts pointwise as ``guard (J - 1 - ln J)``; `past` of the points evaluated.
    Raise ValueError for an unknown law.
    """
    state = _isochoric(silicone, guard)

    def energy(point: Kinematics) -> tuple[Array, Array, Array]:
        k = point.F.shape[-1]
        w, P, A = np.empty(point.J.size), np.empty((point.J.size, k)), np.empty((point.J.size, k, k))
        count = POINTS * 81 // k**2
        for start in range(0, len(w), count):
            part = slice(start, start + count)
            w[part], P[part], tangent = state(point.part(part), None if past is None else past.part(part))
            tangent(A[part])
        shape = point.J.shape
        return w.reshape(shape), P.reshape(*shape, k), A.reshape(*shape, k, k)

    return energy


def isochoric_stress(silicone: Silicone, guard: float = 0.0, past: Past | None = None) -> Stress:
    """Return ``Kinematics -> (w, P)``: `isochoric_energy` without the tangent."""
    state = _isochoric(silicone, guard)

    def stress(point: Kinematics) -> tuple[Array, Array]:
        w, P, _ = state(point, past)
        return w, P

    return stress


def _isochoric(silicone: Silicone, guard: float) -> Callable[[Kinematics, Past | None], PointState]:
    """Return the state of a point under a law with constants in units of its shear modulus."""
    law = known_law(silicone.law)
    modulus, energy = silicone.shear_modulus, law.energy
    constants = law.rescaled(silicone.constants, lambda value: value / modulus)

    def state(point: Kinematics, past: Past | None) -> PointState:
        if isinstance(energy, OfInvariants):
            found = _by_invariants(energy, constants, point)
        else:
            found = _by_stretches(energy, constants, point)
        found = found if past is None else past.acting(found, point)
        return _guarded(found, guard, point) if guard else found

    return state


def _guarded(found: PointState, guard: float, point: Kinematics) -> PointState:
    """Add ``guard (J - 1 - ln J)`` to a state."""
    J, H, slope = point.J, point.H, guard * (1.0 - 1.0 / point.J)

    def tangent(A: Array) -> None:
        """Write the tangent with that of the guard."""
        found.tangent(A)
        A += (guard / J**2)[..., None, None] * H[..., :, None] * H[..., None, :]
        point.add_L(A, slope)

    return PointState(found.w + guard * (J - 1.0 - np.log(J)), found.P + slope[..., None] * H, tangent)


def _by_invariants(energy: OfInvariants, constants: Constants, point: Kinematics) -> PointState:
    """Apply the chain rule from the isochoric invariants; dr only where the law depends on I2."""
    J, a = point.J, np.cbrt(point.J) ** -2.0
    at = Invariants(a * point.s, lambda: a * a * point.r)
    d = energy.derivatives(constants, at)
    along_F, w_J = 2.0 * a * d.w_1, -2.0 / 3.0 * d.w_1 * at.I1 / J
    if d.w_2 is not None:
        w_J -= 4.0 / 3.0 * d.w_2 * at.I2 / J
    P = along_F[..., None] * point.F
    P += w_J[..., None] * point.H
    if d.w_2 is not None:
        P += (a * a * d.w_2)[..., None] * point.dr

    def tangent(A: Array) -> None:
        """Write the products of first derivatives and the second derivatives of s, r and J."""
        left, rows = _products(d, at, a, point)
        np.matmul(left.swapaxes(-1, -2), rows, out=A)
        diagonal(A)[...] += along_F[..., None]
        point.add_L(A, w_J)
        if d.w_2 is not None:
            point.add_d2r(A, a * a * d.w_2)

    return PointState(d.w, P, tangent)


def _products(d: InvariantDerivatives, at: Invariants, a: Array, point: Kinematics) -> tuple[Array, Array]:
    """Return ``sum_y w_xy v_y`` and v, by the rows F, H and, where the law depends on I2, dr, shape (..., rows, k)."""
    J = point.J
    rows = np.stack([point.F, point.H] if d.w_2 is None else [point.F, point.H, point.dr], axis=-2)
    C = np.zeros((*J.shape, rows.shape[-2], rows.shape[-2]))
    C[..., 0, 1] = C[..., 1, 0] = -4.0 / 3.0 * d.w_1 * a / J
    C[..., 1, 1] = 10.0 / 9.0 * d.w_1 * at.I1 / J**2
    if d.w_2 is not None:
        C[..., 1, 2] = C[..., 2, 1] = -4.0 / 3.0 * d.w_2 * a * a / J
        C[..., 1, 1] += 28.0 / 9.0 * d.w_2 * at.I2 / J**2
    zero = np.zeros_like(J)
    d1 = np.stack([2.0 * a, -2.0 / 3.0 * at.I1 / J, zero][: rows.shape[-2]], axis=-1)
    d2 = d1 if d.w_2 is None else np.stack([zero, -4.0 / 3.0 * at.I2 / J, a * a], axis=-1)
    for w, x, y in ((d.w_11, d1, d1), (d.w_12, d1, d2), (d.w_12, d2, d1), (d.w_22, d2, d2)):
        if w is not None:
            C += (w[..., None] * x)[..., :, None] * y[..., None, :]
    return np.asarray(C @ rows), rows


def _by_stretches(energy: OfStretches, constants: Constants, point: Kinematics) -> PointState:
    """Apply the chain rule from the principal stretches; sums over directions are products with thirds."""
    frame, scale = point.principal(), np.cbrt(point.J)
    d = energy.derivatives(constants, np.log(frame.stretch / scale[..., None]))
    first = (d.f_1 - (d.f_1 @ _THIRDS)[..., None]) / frame.stretch
    P = ((frame.U * first[..., None, frame.within]) @ frame.V).reshape(point.F.shape)
    return PointState(3.0 * (d.f @ _THIRDS), P, lambda A: _write_turned(A, d, first, scale, frame))


def _write_turned(A: Array, d: StretchDerivatives, first: Array, scale: Array, frame: Principal) -> None:
    """Write the tangent from derivatives by the stretches, rotated from the principal directions."""
    count, stretch = len(frame.within), np.moveaxis(frame.stretch, -1, 0)
    w, f_11 = np.moveaxis(first, -1, 0), np.moveaxis(d.f_11, -1, 0)
    rows = (frame.U.swapaxes(-1, -2)[..., :, None, :, None] * frame.V[..., None, :, None, :]).reshape(A.shape)
    D = np.zeros_like(A)  # in the frame, by dF_ii and by the sum and difference of dF_ij and dF_ji
    shared = (d.f_11 @ _THIRDS) / 3.0
    for i, a in enumerate(frame.within):
        for j, b in enumerate(frame.within):
            slope = shared - (f_11[a] + f_11[b]) / 3.0
            if a == b:
                slope += f_11[a] - stretch[a] * w[a]
            D[..., i * (count + 1), j * (count + 1)] = slope / (stretch[a] * stretch[b])
    for third, (a, b) in enumerate(_PAIRS):
        if a in frame.within and b in frame.within:
            i, j = frame.within.index(a), frame.within.index(b)
            one, other = i * count + j, j * count + i
            rows[..., one, :] += rows[..., other, :]
            rows[..., other, :] *= -2.0
            rows[..., other, :] += rows[..., one, :]
            D[..., one, one] = 0.5 * (d.quotient[..., third] / scale - w[b]) / stretch[a]
            D[..., other, other] = 0.5 * (w[a] + w[b]) / (stretch[a] + stretch[b])
    np.matmul((D @ rows).swapaxes(-1, -2), rows, out=A)
