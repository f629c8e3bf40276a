"""What coils that are shorted while they idle take of a driven one: by an answer, or at most, before there is one.

Shorted coils reduce the inductance of a driven one: with Z = R + j omega L of the model, each coil alone driven, and J
the shorted coils,

    Z_i - Z_ii = -Z_iJ (Z_JJ)^-1 Z_Ji,                                                                     (1)

which is M^2/L_J of L_ii for one of them without losses. Where no pose is known it has a bound for all poses at rest's
distance and beyond, from free space (0) and rest: with D = L0 - L, d_ij = |D_ij|/sqrt(L0_ii L0_jj), which falls with
the distance of the target, k_ij the same of L0, and r_ij of R/omega,

    |Z_ij|^2 <= omega^2 L0_ii L0_jj [(k_ij + d_ij)^2 + r_ij^2],    |Z_JJ| >= omega L0_JJ (1 - max d_jj) (1 - lambda),

lambda the largest sum of (k + d)_jl/(1 - max d_jj) over the other shorted coils l (Gershgorin): (1) is at most

    omega L0_ii sum_j [(k_ij + d_ij)^2 + r_ij^2] / ((1 - max d_jj) (1 - lambda)).                           (2)

Leads and the tracks' own resistance, which make it less, are left out. Closer than at rest the answer's own (1) counts.
"""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Array, Impedance


def idle_share(found: Impedance) -> float:
    """Return the largest part of a coil's free-space inductance that shorted coils take, by (1) [-]."""
    omega, n = 2.0 * np.pi * found.frequency, len(found.L0)
    if n < 2:
        return 0.0
    Z = (found.R + 1j * omega * found.L).reshape(-1, n, n)
    left = 1.0 / np.diagonal(np.linalg.inv(Z), axis1=1, axis2=2)  # the Schur complement of all other coils, for each
    taken = np.abs(np.diagonal(Z, axis1=1, axis2=2) - left)
    return float((taken / (omega * np.diagonal(found.L0))).max(initial=0.0))


def coupling(found: Impedance) -> float:
    """Return the largest coupling of two coils, by which live tanks of equal frequency split [-]."""
    own = np.sqrt(np.abs(np.diagonal(found.L, axis1=-2, axis2=-1)))
    return float(np.abs(_without_own(np.abs(found.L) / (own[..., None] * own[..., None, :]))).max(initial=0.0))


def idle_bound(rest: Impedance) -> float:
    """Return an upper bound of what shorted coils take of a coil's free-space inductance, by (2) [-].

    `rest` has the target at rest, or none; infinite where the coils are coupled too closely for the bound.
    """
    L0, n = rest.L0, len(rest.L0)
    if n < 2:
        return 0.0
    scale = np.sqrt(np.outer(np.diag(L0), np.diag(L0)))
    taken = np.abs(L0 - rest.L).reshape(-1, n, n).max(axis=0) / scale
    mutual = _without_own(np.abs(L0) / scale + taken)
    lost = _without_own(np.abs(rest.R).reshape(-1, n, n).max(axis=0) / (2.0 * np.pi * rest.frequency * scale))
    left = 1.0 - float(np.diag(taken).max())
    driven = np.where(np.eye(n, dtype=bool), np.inf, mutual).min(axis=1)
    among = float((mutual.sum(axis=1) - driven).max()) / left if left > 0.0 else 0.0
    if left <= 0.0 or among >= 1.0:
        return float("inf")
    return float((mutual**2 + lost**2).sum(axis=1).max() / (left * (1.0 - among)))


def _without_own(matrix: Array) -> Array:
    """Return a matrix without its diagonal."""
    return np.where(np.eye(matrix.shape[-1], dtype=bool), 0.0, matrix)
