"""Exact planar answers: a perfectly conducting strip at any pose, a pair of wires over a half-space.

Strip. A perfectly conducting strip of width w and no thickness, isolated (no net current), in its own coordinate
``u = 2 (x + j z) / w`` on [-1, 1]. The map ``zeta = u + sqrt(u - 1) sqrt(u + 1)`` takes its outside to
``|zeta| > 1``; a line current I at zeta0, its image and the compensation of the net current give

    A = -(mu0 I / 2 pi) [ln|zeta - zeta0| - ln|zeta - 1/conj(zeta0)| + ln|zeta|].

The reaction alone is this less the free-space -(mu0 I / 2 pi) ln|u - u0|; at the current itself the limit
``u - u0 -> (zeta - zeta0) (1 - 1/zeta0^2) / 2`` holds.

Half-space. Wires at +-s/2, height h above metal of conductivity sigma, go and return:

    Delta L - j Delta R / omega = (mu0 / pi) int_0^inf (k - kappa)/(k + kappa) exp(-2 k h) (1 - cos k s) dk / k,
    kappa = sqrt(k^2 + j omega mu0 sigma).

Sources: Joukowski's map of the strip's outside; reflection of a plane harmonic field at a conducting half-space.
"""

from __future__ import annotations

import numpy as np
from scipy.constants import mu_0
from scipy.integrate import quad

from sits_mech.quantities import Array, Complex, Pose


def strip_reaction(first: Complex, second: Complex, pose: Pose, width: float) -> Array:
    """Return the change of mutual inductance between line currents near a perfectly conducting strip.

    Parameters
    ----------
    first, second : ndarray of complex, shape (m,), (n,)
        Places x + j z of the line currents [m].
    pose : Pose
        One pose; the strip lies at its origin.
    width : float
        Of the strip [m].

    Returns
    -------
    ndarray, shape (m, n)
        Per metre of depth; meaningful for sets of currents that sum to zero [H/m].
    """
    turn = np.exp(1j * pose.alpha) * 2 / width
    centre = pose.d_h + 1j * pose.d_v
    u, u0 = ((points - centre) * turn for points in (np.asarray(first)[:, None], np.asarray(second)))
    zeta, zeta0 = (v + np.sqrt(v - 1) * np.sqrt(v + 1) for v in (u, u0))
    direct = np.log(np.abs((1 - 1 / (zeta * zeta0)) / 2))  # ln|u - u0| less ln|zeta - zeta0|, without cancellation
    image = np.log(np.abs(zeta)) - np.log(np.abs(zeta - 1 / zeta0.conj()))
    return np.asarray(-mu_0 / (2 * np.pi) * (image - direct))


def pair_over_half_space(spacing: float, height: float, conductivity: float, frequency: float) -> tuple[float, float]:
    """Return Delta L [H/m] and Delta R [ohm/m] of a go-and-return pair of wires above a conducting half-space.

    Parameters
    ----------
    spacing, height : float
        Distance of the wires, and their height over the metal [m].
    conductivity, frequency : float
        [S/m], [Hz].
    """
    omega = 2 * np.pi * frequency

    def integrand(k: float) -> complex:
        kappa = np.sqrt(k * k + 1j * omega * mu_0 * conductivity)
        reflection = -(1j * omega * mu_0 * conductivity) / (k + kappa) ** 2
        return complex(reflection * np.exp(-2 * k * height) * 2 * np.sin(k * spacing / 2) ** 2 / k)

    upper = 40.0 / height
    value = mu_0 / np.pi * quad(integrand, 0.0, upper, complex_func=True, limit=400, epsabs=0.0, epsrel=1e-10)[0]
    return float(value.real), float(-omega * value.imag)
