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

Source: the integral formulation is that of R. Albanese and G. Rubinacci, Adv. Imaging Electron Phys. 102 (1998) 1; an
expansion in the eigenvectors of two symmetric matrices, one of them positive: any text on linear algebra.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import eigh

from sits_mech.quantities import Array, Complex


@dataclass(frozen=True)
class Modes:
    """Modes of one conductor (or of one symmetry class of it), seen through a basis of fields.

    Attributes
    ----------
    tau : ndarray, shape (m,)
        Time constants [s].
    coupling : ndarray, shape (n, m)
        ``B v_k``: what a unit of each field function induces in each mode [sqrt(W) / (V s) per unit].
    shapes : ndarray, shape (elements, m)
        v_k: the elements' currents in each mode; empty where nobody asks for them.
    """

    tau: Array
    coupling: Array
    shapes: Array = field(default_factory=lambda: np.zeros((0, 0)))

    def admittance(self, omega: float) -> Complex:
        """Return Y(omega) of the module docstring, shape (n, n), symmetric; omega [rad/s]."""
        weight = omega**2 / (1.0 + 1j * omega * self.tau)
        return np.asarray((self.coupling * weight) @ self.coupling.T)

    def currents(self, omega: float) -> Complex:
        """Return the elements' currents for a unit of each field function, shape (elements, n)."""
        weight = -1j * omega / (1.0 + 1j * omega * self.tau)
        return np.asarray((self.shapes * weight) @ self.coupling.T)


def eddy_modes(L: Array, R: Array, basis: Array, *, constraint: Array | None = None) -> Modes:
    """Return the modes of a conductor.

    Parameters
    ----------
    L : ndarray, shape (n, n)
        Inductance matrix of the elements [H or H/m].
    R : ndarray, shape (n,)
        Their resistances [ohm or ohm/m].
    basis : ndarray, shape (b, n)
        B: mean of each field function over each element.
    constraint : ndarray, shape (n,), optional
        q of ``q^T i = 0``.
    """
    scale = 1.0 / np.sqrt(R)
    S = scale[:, None] * L * scale
    B = basis * scale
    if constraint is not None:
        q = constraint * scale
        q = q / np.linalg.norm(q)
        S = _project(S, q)
        B = B - np.outer(B @ q, q)
    tau, V = eigh(S)
    return Modes(np.maximum(tau, 0.0), B @ V, scale[:, None] * V)


def _project(S: Array, q: Array) -> Array:
    """(1 - q q^T) S (1 - q q^T) for a unit vector q."""
    Sq = S @ q
    return np.asarray(S - np.outer(q, Sq) - np.outer(Sq, q) + (q @ Sq) * np.outer(q, q))
