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

Where the eigenvectors themselves are not asked for, half of their work will do: with Cholesky's R = C C^T and
Householder reflections Q that make ``C^-1 L C^-T = Q T Q^T`` tridiagonal, a frequency is a tridiagonal solution
(`reduced`),

    Y = omega^2 W (1 + j omega T)^-1 W^T,    W = B C^-T Q.

Of n elements that takes n^3 / 3, n^3 and 4 n^3 / 3 products and sums, a third of them in products of a matrix and one
vector, which are as slow as memory. One frequency by itself takes 2 n^3 in all, in products of matrices: both parts of
R + j omega L are positive, so that it has a symmetric root without pivots,

    F F^T = R + j omega L,    Delta Z_cd = omega^2 a_c^T a_d,    a_c = F^-1 g_c.

Source: the integral formulation is that of R. Albanese and G. Rubinacci, Adv. Imaging Electron Phys. 102 (1998) 1; an
expansion in the eigenvectors of two symmetric matrices, one of them positive, and their reduction: G. H. Golub and
C. F. Van Loan, Matrix Computations, 4th ed. (2013), 8.3 and 8.7; the root: N. J. Higham, Math. Comp. 67 (1998) 1591.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.constants import mu_0
from scipy.linalg import eigh, get_lapack_funcs, lapack, solve_banded, solve_triangular

from sits_mech.quantities import Array, Complex
from sits_mech.scene.sensor import Sensor

RESOLVED = 1.5
"""Skin depth that is resolved well, over the one that elements are made for."""

_BLOCK = 64  # columns that LAPACK reflects together
DEPTHS = np.array([1.0, 1.6, 2.6])
"""Skin depths, over the least that is resolved, from which is gone on."""


def skin_depth(frequency: float, conductivity: float, relative_permeability: float = 1.0) -> float:
    """Return delta = 1 / sqrt(pi f mu sigma) [m]."""
    return float(1.0 / np.sqrt(np.pi * frequency * mu_0 * relative_permeability * conductivity))


@dataclass(frozen=True)
class Modes:
    """Modes of one conductor, seen through a basis of fields."""

    tau: Array  # (m,) time constants [s]
    coupling: Array  # (n, m) B v_k: what a unit of each field function induces in each mode [sqrt(W) / (V s) per unit]
    shapes: Array = field(default_factory=lambda: np.zeros((0, 0)))  # (elements, m) v_k: currents, if asked for

    def admittance(self, omega: float) -> Complex:
        """Return Y(omega) of the module docstring, shape (n, n), symmetric; omega [rad/s]."""
        weight = omega**2 / (1.0 + 1j * omega * self.tau)
        return np.asarray((self.coupling * weight) @ self.coupling.T)

    def currents(self, omega: float) -> Complex:
        """Return the elements' currents for a unit of each field function, shape (elements, n)."""
        weight = -1j * omega / (1.0 + 1j * omega * self.tau)
        return np.asarray((self.shapes * weight) @ self.coupling.T)


@dataclass(frozen=True)
class Factored:
    """One conductor, or a class of it, at one frequency, for any fluxes; of `Reduced` seen through each element."""

    highest: float  # omega [rad/s]
    packed: Complex  # lower triangle of F, as LAPACK packs it in a full rectangle

    def induced(self, fluxes: Any) -> Complex:
        """Return F^-1 of fluxes (b, n), shape (b, n)."""
        columns = np.asarray(fluxes.T, dtype=complex, order="F")
        return np.asarray(lapack.ztfsm(1.0, self.packed, columns, uplo="L").T)

    def currents(self, induced: Complex, omega: float) -> list[Complex]:
        """Return (R + j omega L)^-1 of the fluxes (b, n) that induced these, (n, b), as `Reduced`."""
        columns = np.asarray(induced.T.conj(), order="F")
        return [np.asarray(lapack.ztfsm(1.0, self.packed, columns, uplo="L", trans="C").conj())]

    def reaction(self, induced: Complex, omega: float, other: Complex | None = None) -> Complex:
        """Return ``a^T Y b`` (..., n, k), as `Reduced`; ValueError at another frequency."""
        if omega != self.highest:
            raise ValueError(f"omega: must be {self.highest:g} rad/s, for which the plate is solved; got {omega:g}")
        return np.asarray(omega**2 * (induced @ np.swapaxes(induced if other is None else other, -1, -2)))


@dataclass(frozen=True)
class Reduced:
    """One conductor (or one symmetry class of it), seen through a basis of fields, at any frequency.

    Beyond `highest`, with the skin depth d, ``Re Y / (omega d)`` is linear and ``Im Y / omega`` quadratic in d, known
    at frequencies below.
    Of complex currents the real and the imaginary part of what they see follow each other, each with the same T.
    """

    diagonal: Array  # (m,) of T [s]
    off_diagonal: Array  # (m - 1,)
    coupling: Array  # (n, m) W: what a unit of each field function induces [sqrt(W) / (V s) per unit]
    highest: float = np.inf  # angular frequency up to which the elements resolve the skin depth [rad/s]

    def admittance(self, omega: float) -> Complex:
        """Return Y(omega) of the module docstring, shape (n, n), symmetric; omega [rad/s]."""
        return self.reaction(self.coupling, omega)

    def reaction(self, induced: Array, omega: float, other: Array | None = None) -> Complex:
        """Return ``a^T Y(omega) b`` (..., n, k) by what fields induce, ``a^T W`` (..., n, m) and ``b^T W``, or a's."""

        def resolved(lower: float) -> Complex:
            """Return it where the skin depth is resolved."""
            X = self.answer(induced, lower)
            b = np.swapaxes(induced if other is None else other, -1, -2)
            return np.asarray(lower**2 * (X.real @ b + 1j * (X.imag @ b)))

        return reaction_at(resolved, omega, self.highest)

    def induced(self, fluxes: Any) -> Array:
        """Return what fluxes (b, n) induce, of a conductor seen through each of its n elements."""
        W, n = self.coupling, len(self.coupling)
        found = np.asarray(fluxes.real @ W)
        if W.shape[1] > n:  # of complex currents
            other = fluxes.imag @ W
            found += np.hstack([-other[:, n:], other[:, :n]])
        return found

    def currents(self, induced: Array, omega: float) -> list[Complex]:
        """Return the currents by what fluxes induce (n, b), of complex ones then those of the conjugate class."""
        answer, W, n = self.answer(induced, omega), self.coupling, len(self.coupling)
        if W.shape[1] == n:
            return [W @ answer.T]
        (p, q), V = (answer[:, :n] / 2, answer[:, n:] / 2), W[:, :n] + 1j * W[:, n:]
        return [V @ (p - 1j * q).T, V.conj() @ (p + 1j * q).T]

    def answer(self, induced: Array, omega: float) -> Complex:
        """Return ``(1 + j omega T)^-1 W^T c`` of what fields induce, (..., n, m)."""
        m = self.diagonal.size
        bands = np.ones((3, m), dtype=complex)
        bands[1] += 1j * omega * self.diagonal
        bands[0, 1:] = bands[2, :-1] = 1j * omega * self.off_diagonal
        flat = induced.reshape(-1, m)
        if not flat.size:
            return np.zeros(induced.shape, dtype=complex)
        found = solve_banded((1, 1), bands, flat.T.astype(complex), check_finite=False)  # one row of reals fails
        return found.T.reshape(induced.shape)


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


def reaction_at(reaction: Callable[[float], Complex], omega: float, highest: float) -> Complex:
    """Return a reaction at an angular frequency, from lower ones if that is above the highest; see `Reduced`."""
    if omega <= highest:
        return reaction(omega)
    depth = np.sqrt(highest / omega)
    known = [reaction(highest / d**2) for d in DEPTHS]
    R = _onwards(depth, DEPTHS[::2], [depth * d * Y.real for d, Y in zip(DEPTHS, known, strict=True)][::2])
    L = _onwards(depth, DEPTHS, [d**2 * Y.imag for d, Y in zip(DEPTHS, known, strict=True)])
    return np.asarray((R + 1j * L) * omega / highest)


def reduced(L: Any, R: Any, B: Any, *, weight: float = 1.0, highest: float = np.inf) -> Reduced:
    """Return what fluxes B (b, n) see of a conductor whose L and R (n, n) are Hermitian, R positive.

    `weight` is how often a class of complex currents, of which the real part of the reaction counts, is there;
    `highest` is that of `Reduced`.
    """
    names = ("potrf", "hegst", "hetrd", "unmqr") if np.iscomplexobj(R) else ("potrf", "sygst", "sytrd", "ormqr")
    lapack: Any = get_lapack_funcs(names, (L, R))
    potrf, sygst, sytrd, ormqr = lapack
    C = _done(potrf(np.asfortranarray(R), lower=1))
    S = _done(sygst(np.asfortranarray(L), C, lower=1))
    S, diagonal, off_diagonal, tau, _ = sytrd(S, lower=1, lwork=_BLOCK * len(S), overwrite_a=1)
    W = solve_triangular(C, B.conj().T, lower=True, check_finite=False)
    if len(S) > 1:
        way = "C" if np.iscomplexobj(R) else "T"
        W[1:] = ormqr("L", way, S[1:, :-1], tau, np.asfortranarray(W[1:]), _BLOCK * max(1, W.shape[1]))[0]
    W = W.conj().T
    if np.iscomplexobj(W):
        W = np.hstack([W.real, W.imag]) * np.sqrt(weight)
        diagonal, off_diagonal = np.tile(diagonal, 2), np.concatenate([off_diagonal, [0.0], off_diagonal])
    return Reduced(diagonal, off_diagonal, W, highest)


def factored(L: Any, R: Any, omega: float) -> Factored:
    """Return a conductor, whose L and R (n, n) are real, at one frequency [rad/s]."""
    F = np.empty(R.shape, dtype=complex, order="F")
    F.real, F.imag = R, L
    F.imag *= omega
    _take_root(F)
    return Factored(omega, lapack.ztrttf(F, uplo="L")[0])


def _take_root(A: Complex) -> None:
    """Put the symmetric root of a matrix in place of its lower triangle, by halves."""
    n, half = len(A), len(A) // 2
    if n <= _BLOCK:
        for k in range(n):
            A[k:, k] /= np.sqrt(A[k, k])
            A[k + 1 :, k + 1 :] -= np.outer(A[k + 1 :, k], A[k + 1 :, k])
        return
    _take_root(A[:half, :half])
    side = solve_triangular(A[:half, :half], A[half:, :half].T, lower=True, check_finite=False)
    A[half:, :half] = side.T
    A[half:, half:] -= side.T @ side
    _take_root(A[half:, half:])


def _done(found: tuple[Any, int]) -> Any:
    """Return what LAPACK found; LinAlgError where a matrix is not positive."""
    matrix, info = found
    if info:
        raise np.linalg.LinAlgError(f"leading minor {info} of the resistances is not positive")
    return matrix


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
