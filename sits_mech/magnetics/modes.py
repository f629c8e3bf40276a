"""Eddy-current modes of a divided conductor: what every integral model of the target shares.

The target is divided into elements with currents i, resistance matrix R (diagonal or not) and inductance matrix L, both
independent of where the target is. A coil c that carries 1 A links the elements with the flux ``g_c(pose)``, so

    (R + j omega L) i = -j omega g_c,    Delta Z_cd = omega^2 g_c^T (R + j omega L)^-1 g_d.

With the symmetric eigenproblem ``L v = tau R v, v^T R v = 1`` every frequency is a sum over modes with time constants
tau [s],

    (R + j omega L)^-1 = sum_k v_k v_k^T / (1 + j omega tau_k).

A linear constraint ``q^T i = 0`` (an isolated conductor's net current) is eliminated before.

The fluxes come from a field that is smooth over the target: ``g_c = B^T c``, with a few pose-dependent coefficients c
and the mean B (n_coefficients, n_elements) of each of its functions over each element. Condensing B onto the modes once
leaves a pose to pay for the coefficients alone:

    Delta Z_cd = c_c^T Y(omega) c_d,    Y = omega^2 sum_k (B v_k) (B v_k)^T / (1 + j omega tau_k).

Many elements under few fields need few modes. The fluxes B are answered by ``(R + s_k L)^-1 B^T`` for few real s_k
(`_SHIFTS`, over the highest angular frequency); what currents there are from zero to that frequency is a combination
of these, to 1e-3 of the resistance, and L and R projected on them have the modes that are kept (`few_modes`).

Source: the integral formulation is that of R. Albanese and G. Rubinacci, Adv. Imaging Electron Phys. 102 (1998) 1; an
expansion in the eigenvectors of two symmetric matrices, one of them positive: any text on linear algebra; rational
Krylov spaces: A. Ruhe, Linear Algebra Appl. 58 (1984) 391.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.constants import mu_0
from scipy.linalg import cho_factor, cho_solve, eigh

from sits_mech.quantities import Array, Complex
from sits_mech.scene.sensor import Sensor

RESOLVED = 1.5
"""Skin depth that is resolved well, over the one that elements are made for."""

_SHIFTS = ((0.0, 1), (1.0 / 3.0, 2), (3.0, 2))  # s over the angular frequency, and how often it is applied
_WHOLE = 2.0  # elements, over what the shifts would leave, up to which all modes are kept
DEPTHS = np.array([1.0, 1.6, 2.6])
"""Skin depths, over the least that is resolved, from which is gone on."""
_NOTHING = 1e-15  # of the strongest field: weaker ones are of another symmetry
_SPAN = 1e-10  # of the strongest direction: weaker ones are rounding


def skin_depth(frequency: float, conductivity: float, relative_permeability: float = 1.0) -> float:
    """Return delta = 1 / sqrt(pi f mu sigma) [m]."""
    return float(1.0 / np.sqrt(np.pi * frequency * mu_0 * relative_permeability * conductivity))


@dataclass(frozen=True)
class Modes:
    """Modes of one conductor (or of one symmetry class of it), seen through a basis of fields.

    Beyond `highest`, with the skin depth d, ``Re Y / (omega d)`` is linear and ``Im Y / omega`` quadratic in d, known
    at frequencies below.
    """

    tau: Array  # (m,) time constants [s]
    coupling: Array  # (n, m) B v_k: what a unit of each field function induces in each mode [sqrt(W) / (V s) per unit]
    shapes: Array = field(default_factory=lambda: np.zeros((0, 0)))  # (elements, m) v_k: currents, if asked for
    highest: float = np.inf  # angular frequency up to which the elements resolve d [rad/s]

    def admittance(self, omega: float) -> Complex:
        """Return Y(omega) of the module docstring, shape (n, n), symmetric; omega [rad/s]."""
        return self.reaction(self.coupling, omega)

    def reaction(self, induced: Array, omega: float) -> Complex:
        """Return ``c^T Y(omega) c``, (..., n, n), by what fields induce, ``c^T coupling`` (..., n, m), at omega."""
        if omega > self.highest:
            return beyond(lambda lower: self.reaction(induced, lower), omega, self.highest)
        weight = omega**2 / (1.0 + 1j * omega * self.tau)
        return np.asarray((induced * weight) @ np.swapaxes(induced, -1, -2))

    def currents(self, omega: float) -> Complex:
        """Return the elements' currents for a unit of each field function, shape (elements, n)."""
        weight = -1j * omega / (1.0 + 1j * omega * self.tau)
        return np.asarray((self.shapes * weight) @ self.coupling.T)


def eddy_modes(L: Array, R: Array, basis: Array, *, constraint: Array | None = None) -> Modes:
    """Return the modes of a conductor: L (n, n) [H or H/m] and R (n,) [ohm or ohm/m] of its elements.

    `basis` (b, n) is B, the mean of each field function over each element; `constraint` (n,) is q of ``q^T i = 0``.
    """
    scale = 1.0 / np.sqrt(R)
    S = scale[:, None] * L * scale
    B = basis * scale
    if constraint is not None:
        q = constraint * scale
        q = q / np.linalg.norm(q)
        Sq = S @ q
        S = S - np.outer(q, Sq) - np.outer(Sq, q) + (q @ Sq) * np.outer(q, q)
        B = B - np.outer(B @ q, q)
    tau, V = eigh(S)
    return Modes(np.maximum(tau, 0.0), B @ V, scale[:, None] * V)


def beyond(reaction: Callable[[float], Complex], omega: float, highest: float) -> Complex:
    """Return a reaction at an angular frequency, from lower ones if that is above the highest; see `Modes.highest`."""
    if omega <= highest:
        return reaction(omega)
    depth = np.sqrt(highest / omega)
    known = [reaction(highest / d**2) for d in DEPTHS]
    R = _onwards(depth, DEPTHS[::2], [depth * d * Y.real for d, Y in zip(DEPTHS, known, strict=True)][::2])
    L = _onwards(depth, DEPTHS, [d**2 * Y.imag for d, Y in zip(DEPTHS, known, strict=True)])
    return np.asarray((R + 1j * L) * omega / highest)


def few_modes(L: Complex, R: Complex, B: Complex, omega: float, *, weight: float = 1.0) -> Modes:
    """Return modes that answer the fluxes B (b, n) as all modes do, from zero to an angular frequency [rad/s].

    L and R (n, n) are Hermitian, R positive. `weight` is how often a class of complex currents, of which the real part
    of the reaction counts, is there.
    """
    if len(R) <= _WHOLE * sum(times for _, times in _SHIFTS) * len(B):
        tau, V = eigh(L, R)
    else:
        Q = _krylov_space(L, R, B, omega)
        tau, V = eigh(Q.conj().T @ (L @ Q), Q.conj().T @ (R @ Q))
        V = Q @ V
    seen = B @ V
    if np.iscomplexobj(seen):
        seen = np.hstack([seen.real, seen.imag]) * np.sqrt(weight)
        tau = np.tile(tau, 2)
    return Modes(np.maximum(tau, 0.0), (seen.real), highest=omega / RESOLVED**2)


def _krylov_space(L: Complex, R: Complex, B: Complex, omega: float) -> Complex:
    """Return the answers of shifts to the fluxes B, R-orthonormal, shape (n, k).

    The space need not be exact, only its projection: solves in single precision are enough.
    """
    single = np.complex64 if np.iscomplexobj(R) else np.float32
    blocks: list[Complex] = []
    strength = np.linalg.norm(B, axis=1)
    some = strength > _NOTHING * strength.max()
    B = B[some] / strength[some, None]
    for share, times in _SHIFTS:
        factor = _factored(R + share * omega * L, single)
        driven = B.conj().T
        for _ in range(times):
            found = np.asarray(cho_solve(factor, driven.astype(factor[0].dtype), check_finite=False), dtype=R.dtype)
            driven = R @ found
            size = np.sqrt(np.real(np.einsum("ij,ij->j", found.conj(), driven)))
            blocks.append(found / size)
            driven = driven / size
    X = np.hstack(blocks)
    values, vectors = eigh(X.conj().T @ (R @ X))
    kept = values > _SPAN * values[-1]
    return np.asarray(X @ (vectors[:, kept] / np.sqrt(values[kept])))


def _factored(matrix: Complex, single: type) -> Any:
    """Return Cholesky's factor in single precision; in double where that loses the small resistances."""
    try:
        return cho_factor(matrix.astype(single), lower=True, overwrite_a=True, check_finite=False)
    except np.linalg.LinAlgError:
        return cho_factor(matrix, lower=True, check_finite=False)


def _onwards(at: float, nodes: Array, values: Sequence[Array]) -> Array:
    """Return Lagrange's polynomial through values at the nodes."""
    shares = (np.prod((at - np.delete(nodes, k)) / (d - np.delete(nodes, k))) for k, d in enumerate(nodes))
    return np.asarray(sum(share * value for share, value in zip(shares, values, strict=True)))


def skin_depths(sensor: Sensor) -> float:
    """Return the target's thickness in skin depths at the scene's frequency; 0 without a target."""
    target = sensor.target
    if target is None:
        return 0.0
    conductivity = target.metal.conductivity * target.metal.relative_permeability
    return target.thickness / skin_depth(sensor.frequency, conductivity)
