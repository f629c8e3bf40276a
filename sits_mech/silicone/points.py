"""Memory of the silicone's points, and the energy it makes: viscosity and softening.

Strong form. With ``Cb = J^(-2/3) C`` and ``DEV[A] = A - (A : C) C^-1/3``, the stress that belongs to a law's isochoric
energy W, softened by the largest W that the point has seen, is ``S_0 = eta DEV[2 dW/dCb]``,

    eta = 1 - (1/r) erf((W_max - W)/(m + b W_max)),    W < W_max;      eta = 1,    W >= W_max,

and each branch of the Prony series (weights w_i, times tau_i) relaxes with it: quasi-linear viscosity,

    S = J p C^-1 + J^(-2/3) DEV[S_0 + sum_i Q_i],      dQ_i/dt + Q_i/tau_i = g_i dS_0/dt,    g_i = w_i/(1 - sum w).

Long times leave the law, whose constants are those of slow load; a sudden strain meets ``1/(1 - sum w)`` times it. The
pressure p does not relax. All are of the reference frame: a turn of the whole changes none of them.

Weak form. Let S_0 be linear in time over a step dt. Then the step is exact, and the rest at its end is the least of

    W_inc(F) = (1 + sum gamma_i) Phi(W) + h : Cb/2,      Phi' = eta,    gamma_i = g_i (1 - exp(-dt/tau_i)) tau_i/dt,
    h        = sum_i exp(-dt/tau_i) Q_i - gamma_i S_0                                       (of the step's beginning)
    Q_i     <- exp(-dt/tau_i) Q_i + gamma_i (S_0' - S_0),      W_max <- max(W_max, W'),

so that whatever finds the rest of an elastic layer finds that of this one: energy, symmetric tangent, line search. With
``s_h = F h : F``, ``E(x) = x erf x + exp(-x^2)/sqrt(pi)`` and ``D = m + b W_max``

    Phi = W - (D/r) (E(W_max/D) - E(max(W_max - W, 0)/D)),
    P_h = J^(-2/3) (F h - s_h/(3 J) H),
    A_h = J^(-2/3) (1 (x) h - 2/(3 J) (F h (x) H + H (x) F h) + 5/9 s_h/J^2 H (x) H - s_h/(3 J) L).

What is left is the line of S_0 between the ends of a step: of second order in dt. In plane strain ``F_yy = 1``, and
``S_yy = -P : F`` of a deviatoric P. Unknowns: stresses in initial shear moduli, components as in kinematics.py, in the
plane with yy as the fifth. Sources: J. C. Simo, Comput. Methods Appl. Mech. Eng. 60 (1987) 153; J. C. Simo, T. J. R.
Hughes, Computational Inelasticity (1998), section 10.2; R. W. Ogden, D. G. Roxburgh, Proc. R. Soc. A 455 (1999) 2861.
Neglected: inertia, relaxation of the bulk, dependence of the times on strain, permanent set.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import erf

from sits_mech.quantities import Array, Mask
from sits_mech.silicone.energy import PointState, isochoric_stress
from sits_mech.silicone.kinematics import Kinematics
from sits_mech.silicone.material import Silicone, Softening

_ROOT_PI = float(np.sqrt(np.pi))
_THIRD = 1.0 / 3.0  # of the trace, in space and in plane strain


@dataclass(frozen=True)
class PointMemory:
    """Memory of points, c = 5 components in plane strain and 9 in space [shear moduli]."""

    Q: Array  # (n, ..., c), stress of each branch
    S: Array  # (..., c), S_0
    most: Array  # (...), W_max


@dataclass(frozen=True)
class TimeStep:
    """The past of points in their energy at the end of a time step; a `Past` of energy.py."""

    stiff: float  # 1 + sum gamma_i
    h: Array  # (..., c) [shear moduli]
    most: Array  # (...), W_max [shear moduli]
    softening: Softening | None  # m in shear moduli

    def part(self, some: slice) -> TimeStep:
        """Return that of some points, counted along one axis."""
        return replace(self, h=self.h.reshape(-1, self.h.shape[-1])[some], most=self.most.reshape(-1)[some])

    def of_elements(self, some: slice | Mask) -> TimeStep:
        """Return that of some elements, the first axis."""
        return replace(self, h=self.h[some], most=self.most[some])

    def acting(self, elastic: PointState, point: Kinematics) -> PointState:
        """Return the state of ``W_inc`` from that of W."""
        k, J, a = point.F.shape[-1], point.J, np.cbrt(point.J) ** -2.0
        soft = _softened(elastic, self.softening, self.most)
        h = self.h[..., :k]
        Fh = _times(point.F, h)
        s = np.einsum("...i,...i->...", Fh, point.F) + (self.h[..., k] if point.plane else 0.0)
        P = self.stiff * soft.P + a[..., None] * (Fh - (_THIRD * s / J)[..., None] * point.H)

        def tangent(A: Array) -> None:
            """Write the tangent of W_inc."""
            soft.tangent(A)
            A *= self.stiff
            d = 2 if point.plane else 3
            right = (2.5 * _THIRD * s / J)[..., None] * point.H - Fh  # of H, times 2/(3 J); the rest is its mirror
            mixed = (-2.0 * _THIRD * a / J)[..., None] * Fh
            A += (2.0 * _THIRD * a / J)[..., None, None] * point.H[..., :, None] * right[..., None, :]
            A += mixed[..., :, None] * point.H[..., None, :]
            rows = (a[..., None] * h).reshape(*J.shape, d, d)
            for i in range(d):
                A[..., d * i : d * i + d, d * i : d * i + d] += rows
            point.add_L(A, -_THIRD * a * s / J)

        return PointState(self.stiff * soft.w + 0.5 * a * s, P, tangent)


def virgin(silicone: Silicone, shape: tuple[int, ...], components: int) -> PointMemory:
    """Return the memory of virgin points of a shape; 5 components in the plane, 9 in space."""
    branches = len(silicone.prony)
    return PointMemory(np.zeros((branches, *shape, components)), np.zeros((*shape, components)), np.zeros(shape))


def past_after(silicone: Silicone, memory: PointMemory, dt: float) -> TimeStep:
    """Return the past in the energies at the end of a time step dt >= 0 [s]; 0 is a sudden load."""
    kept, gamma = _branches(silicone, dt)
    h = np.tensordot(kept, memory.Q, axes=1) - gamma.sum() * memory.S
    return TimeStep(1.0 + float(gamma.sum()), h, memory.most, _in_moduli(silicone))


def remembered(silicone: Silicone, memory: PointMemory, dt: float, point: Kinematics) -> PointMemory:
    """Return the memory at the end of a time step, in the deformation there."""
    w, P = isochoric_stress(silicone)(point)
    softening = _in_moduli(silicone)
    if softening is not None:
        P = _left(softening, w, memory.most)[0][..., None] * P
    S = _second(P, point)
    kept, gamma = _branches(silicone, dt)
    shape = (-1, *[1] * S.ndim)
    Q = kept.reshape(shape) * memory.Q + gamma.reshape(shape) * (S - memory.S)
    return PointMemory(Q, S, np.maximum(memory.most, w))


def _branches(silicone: Silicone, dt: float) -> tuple[Array, Array]:
    """Return the decay of each branch over a step, and its gamma, shape (n,)."""
    if not silicone.prony:
        return np.zeros(0), np.zeros(0)
    w, tau = np.array(silicone.prony, dtype=float).T
    x = dt / tau
    mean = -np.expm1(-x) / np.where(x > 0.0, x, 1.0)
    return np.exp(-x), w / (1.0 - w.sum()) * np.where(x > 0.0, mean, 1.0)


def _in_moduli(silicone: Silicone) -> Softening | None:
    """Return the softening of a silicone, energies in shear moduli."""
    found = silicone.mullins
    return None if found is None else replace(found, m=found.m / silicone.shear_modulus)


def _softened(elastic: PointState, softening: Softening | None, most: Array) -> PointState:
    """Return a state with softening: energy Phi, stress and tangent."""
    if softening is None:
        return elastic
    W, P = elastic.w, elastic.P
    eta, D, away = _left(softening, W, most)
    phi = W - (_primitive(most / D) - _primitive(away)) * D / softening.r
    slope = np.where(away > 0.0, 2.0 / (_ROOT_PI * softening.r) * np.exp(-(away**2)) / D, 0.0)

    def tangent(A: Array) -> None:
        """Write ``eta A + eta' P (x) P``."""
        elastic.tangent(A)
        A *= eta[..., None, None]
        A += (slope[..., None] * P)[..., :, None] * P[..., None, :]

    return PointState(phi, eta[..., None] * P, tangent)


def _left(softening: Softening, W: Array, most: Array) -> tuple[Array, Array, Array]:
    """Return eta, D, (W_max - W)/D; W is rounded to 1e-16, and eta must not be to more than 1e-8: D is no less."""
    D = np.maximum(softening.m + softening.beta * most, 1e-8)
    away = np.maximum(most - W, 0.0) / D
    return 1.0 - erf(away) / softening.r, D, away


def _primitive(x: Array) -> Array:
    """Return the integral of erf from 0, up to a constant."""
    return x * erf(x) + np.exp(-(x**2)) / _ROOT_PI


def _times(F: Array, h: Array) -> Array:
    """Return ``F h`` by components, shape (..., k)."""
    d = 2 if F.shape[-1] == 4 else 3
    split = (*F.shape[:-1], d, d)
    return (F.reshape(split) @ h.reshape(split)).reshape(F.shape)


def _second(P: Array, point: Kinematics) -> Array:
    """Return ``J^(2/3) S`` of a deviatoric P, S = F^-1 P, shape (..., 5) in the plane, (..., 9) in space."""
    d = 2 if point.plane else 3
    split = (*point.J.shape, d, d)
    S = ((point.H.reshape(split).swapaxes(-1, -2) @ P.reshape(split)) / point.J[..., None, None]).reshape(P.shape)
    if point.plane:
        S = np.concatenate([S, -np.einsum("...i,...i->...", P, point.F)[..., None]], axis=-1)
    return (np.cbrt(point.J) ** 2)[..., None] * S
