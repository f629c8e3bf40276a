"""Add rate and history to any elastic model of a pad: viscosity and softening.

Viscosity is quasi-linear: each stress is the convolution of the elastic one, of any law, with one function of time,

    P(t) = int_0^t G(t - s) dP_e(F(s)),    G(t) = (1 - sum_i w_i + sum_i w_i exp(-t/tau_i)) / (1 - sum_i w_i),

with weights w_i and times tau_i of a Prony series. ``G(infinity) = 1``: the law's constants are those of slow load,
and a sudden load meets ``1/(1 - sum_i w_i)`` times their stiffness. Let the pose q alone decide how the layer deforms,
as it does in the elastic pad. Then the work of P integrates to the same convolution of the wrench Q, and a prescribed
load decides by itself to which elastic load Q_e, and so to which elastic pose q_e, the pad has come:

    Q(t) = int_0^t G(t - s) dQ_e(s)   <=>   Q_e(t) = int_0^t C(t - s) dQ(s),      q(t) = q_e(Q_e(t))
    C(t) = 1 - sum_j c_j exp(-t/lambda_j),     C(0) = 1 - sum_i w_i

Rates 1/lambda_j and weights c_j are eigenvalues and projections of ``-diag(1/tau) + v v^T/G(0)``,
``v_i = sqrt(w_i/(1 - sum w)/tau_i)``; a load that is linear between samples is then integrated exactly.

Softening is the pseudo-elastic one of the whole pad: below the largest energy it has stored, it pushes back less,

    Q_e = eta Q_virgin(q),    eta = 1 - (1/r) erf((U_max - U)/(m V + beta U_max)),    U = int Q_virgin . dq

with the pad's volume V, so that the first loading is virgin, and unloading and every loading up to the former peak
follow one softer curve. Where m = 0 and beta = 1, the energy lost is ``(U_max/r) (erf(1) - (1 - 1/e)/sqrt(pi)) =
0.486 U_max/r``, whatever the pad.

Unknowns: shares s of a peak wrench [-], loads being proportional to it; poses [m, rad].
Sources: Y. C. Fung, Biomechanics, 2nd ed. (1993), section 7.6; R. W. Ogden, D. G. Roxburgh, Proc. R. Soc. A 455 (1999)
2861; W. V. Mars, Tire Sci. Technol. 32 (2004) 120, for beta. Both are of a point: a pad takes its mean energy density.
Valid: viscosity is exact at small strain for a bulk modulus that relaxes as the shear modulus does, or is infinite, and
with the load at the bonded face (above it, the force's lever is that of the present pose). A finite one that does not
relax makes a sudden compression softer, by about ``0.4 (12 mu S^2/K) w/(1 - w)``: 1 % at S = 2, K = 1000 mu, w = 0.3.
Neglected: inertia, dependence of G on strain, softening point by point, permanent set, temperature.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from sits_mech.quantities import Array, Equilibrium, MechanicalModel, Pose, Wrench
from sits_mech.rotations import rotation_matrix, rotation_vector
from sits_mech.silicone.material import Silicone, Softening

_SAMPLES = 200  # of a cycle


@dataclass(frozen=True)
class ElasticCurve:
    """Virgin elastic answer of a pad to shares of a peak wrench."""

    peak: Wrench  # load at share 1 [N, N m]
    share: Array  # (n,), ascending from 0 to 1
    found: tuple[Equilibrium, ...]
    energy: Callable[[float], float]  # stored energy [J] by share


def retardation(prony: Sequence[tuple[float, float]]) -> tuple[Array, Array]:
    """Return creep weights c [-] and times lambda [s] of a Prony series, shape (n,) each."""
    if not prony:
        return np.zeros(0), np.ones(0)
    w, tau = np.array(prony, dtype=float).T
    slow = 1.0 - w.sum()
    v = np.sqrt(w / (slow * tau))
    rates, vectors = np.linalg.eigh(np.diag(-1.0 / tau) + slow * np.outer(v, v))
    return (vectors.T @ (v * tau)) * (vectors.T @ v) * slow, -1.0 / rates


def relaxed_share(silicone: Silicone, time: Array, share: Array) -> Array:
    """Return the elastically equivalent share of a load history, linear between samples, by its Prony series.

    `time` (n,) does not descend, repeated for a step [s]; before the first sample the share is zero.
    """
    weights, times = retardation(silicone.prony)
    lag = weights * share[0]
    found = [float(share[0] - lag.sum())]
    for step, rise, now in zip(np.diff(time), np.diff(share), share[1:], strict=True):
        kept = np.exp(-step / times)
        mean = np.ones_like(times) if step == 0.0 else -np.expm1(-step / times) * times / step
        lag = lag * kept + weights * rise * mean
        found.append(float(now - lag.sum()))
    return np.array(found)


def softened_share(
    softening: Softening | None, energy: Callable[[float], float], share: Array, *, volume: float = 0.0
) -> Array:
    """Return the virgin share equivalent to a history of shares (n,) >= 0 on a softened pad.

    `energy`: stored energy [J] by virgin share, increasing; `volume` of the pad [m^3] counts if the softening has an m.
    """
    if softening is None:
        return share.copy()
    peak, found, factor = 0.0, [], partial(softening.factor, volume=volume)
    for wanted in share.tolist():
        peak = max(peak, wanted)
        found.append(peak if wanted == peak else _below_peak(factor, energy, wanted, peak))
    return np.array(found)


def _below_peak(factor: Callable[..., Array], energy: Callable[[float], float], wanted: float, peak: float) -> float:
    """Return the virgin share at which a pad once at `peak` pushes back with the share `wanted`."""
    from scipy.optimize import brentq

    largest = energy(peak)
    if not (wanted > 0.0 and largest > 0.0):
        return wanted

    def excess(share: float) -> float:
        return share * float(factor(energy(share), largest)) - wanted

    return float(brentq(excess, 0.0, peak, xtol=1e-13))


def loop_width(silicone: Silicone, period: float = 1.0) -> float:
    """Return the largest difference of loading and unloading at one load, over the pose under the peak [-].

    Of a linear pad in the second cycle of a triangular load of `period` [s]; the softening's m is left out (large load,
    where it is deepest). nan if the silicone has neither ``prony`` nor ``mullins``.
    """
    if not silicone.has_history:
        return float("nan")
    phase = np.linspace(0.0, 2.0, 2 * _SAMPLES + 1)
    share = 1.0 - np.abs(2.0 * (phase % 1.0) - 1.0)
    came = softened_share(silicone.mullins, lambda part: part**2, relaxed_share(silicone, period * phase, share))
    half = _SAMPLES // 2
    rising, falling = came[_SAMPLES : _SAMPLES + half + 1], came[: _SAMPLES + half - 1 : -1]
    return float(np.max(np.abs(falling - rising)))


def left_share(silicone: Silicone, after: float) -> float:
    """Return the share of displacement left `after` [s] release of a long-held load, 1 - C; nan without ``prony``."""
    weights, times = retardation(silicone.prony)
    return float(weights @ np.exp(-after / times)) if silicone.prony else float("nan")


def history_share(silicone: Silicone) -> float:
    """Return the relative change of displacement under a sudden load, or below a larger load of the past [-]."""
    quick = sum(weight for weight, _ in silicone.prony)
    mullins = silicone.mullins
    deepest = 0.0 if mullins is None else math.erf(1.0 / mullins.beta) if mullins.beta else 1.0
    left = 1.0 if mullins is None else 1.0 - deepest / mullins.r
    return max(quick, 1.0 / left - 1.0)


def elastic_curve(layer: MechanicalModel, peak: Wrench, *, height: float = 0.0, points: int = 17) -> ElasticCurve:
    """Return the virgin elastic answer of a pad from no load to the peak [N, N m].

    `height`: of the force above the bonded face [m]; `points`: loads solved, odd, at least 5, or ValueError. Raise
    SolveFailed without equilibrium on the way.
    """
    from scipy.interpolate import CubicSpline

    if points < 5 or points % 2 == 0:
        raise ValueError(f"points must be an odd number from 5 on; got {points}")
    shares = np.linspace(0.0, 1.0, points)
    found: list[Equilibrium] = []
    for share in shares:
        found.append(layer.equilibrium(Wrench(*(share * peak.components)), start=found[-1] if found else None))
    way = CubicSpline(shares, _work(peak, [item.pose for item in found], height))
    below = way.antiderivative()

    def energy(share: float) -> float:
        return float(share * way(share) - below(share))  # int s dx = s x - int x ds

    return ElasticCurve(peak, shares, tuple(found), energy)


def _work(peak: Wrench, poses: Sequence[Pose], height: float) -> Array:
    """Return the work of the whole peak wrench from the first pose to each; rotations add up from pose to pose."""
    turns = rotation_matrix(np.array([pose.rotation for pose in poses]))
    ends = np.array([pose.centre for pose in poses]) + height * turns[:, :, 2]
    steps = [rotation_vector(after @ before.T) for before, after in itertools.pairwise(turns)]
    turned = np.cumsum([np.zeros(3), *steps], axis=0)
    force, moment = np.array([peak.F_x, peak.F_y, -peak.F_z]), np.array([peak.M_x, peak.M, peak.M_z])
    return np.asarray((ends - ends[0]) @ force + turned @ moment)
