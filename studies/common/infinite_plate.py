"""A coil or a pair of wires over an infinite stack of layers: one integral over the reflected waves (Dodd and Deeds).

``exp(+j omega t)``; the layers fill z > gap, air below and above them, all linear and isotropic:

    laplace A = 0 in air,    (1/mu) laplace A = j omega sigma A in a layer,    A and (1/mu) dA/dz continuous.

For a coil below z = 0, with S of `coils.ring_field`, where the source is named too,

    A_phi = (mu0/2) int_0^inf S(k) J1(k r) [exp(-k z) + Gamma(k) exp(k (z - 2 gap))] dk    [V s/m per A],
    Delta L_complex = pi mu0 int_0^inf Gamma(k) S(k)^2 exp(-2 k gap) dk = Delta L - j R / omega;

for a planar pair of opposite currents, a distance s apart at height h, with one ampere each,

    Delta L_complex = (mu0/pi) int_0^inf Gamma(k) (1 - cos(k s)) / k  exp(-2 k h) dk   [H/m].

Reflection. Layer i has ``q_i = sqrt(k^2 + j omega mu_i sigma_i)``; between i and j

    r_ij = (q_i/mu_i - q_j/mu_j) / (q_i/mu_i + q_j/mu_j),    Gamma_i = (r_ij + Gamma_j e_j) / (1 + r_ij Gamma_j e_j),

``e_j = exp(-2 q_j t_j)``. The numerator of r_ij is written as a difference of squares, in which k^2 drops out between
non-magnetic layers: the weak reflections of low frequencies keep their digits.

Range: any frequency, conductivity (infinite: a perfect conductor), permeability. Neglected: displacement current.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.constants import mu_0
from scipy.integrate import cubature

from sits_mech.geometry.windings import Sections
from sits_mech.magnetics.coils.ring_field import source_spectrum
from sits_mech.quantities import Array, Complex

_DIGITS = 40.0  # the integrand is cut where exp(-2 k gap) falls to exp(-40)


@dataclass(frozen=True)
class Layer:
    """One layer of an infinite stack."""

    conductivity: float  # [S/m]; infinite for a perfect conductor
    thickness: float = np.inf  # [m]; infinite for a half-space, which must come last
    relative_permeability: float = 1.0  # [-]


def reflection(k: Array, omega: float, layers: Sequence[Layer]) -> Complex:
    """Return Gamma(k) at the face of a stack, nearest layer first, air behind it; -1 is a perfect conductor, 0 air."""
    air = Layer(0.0)
    stack = [air, *layers, air]
    gamma = np.zeros(np.shape(k), dtype=complex)
    for near, far in zip(stack[-2::-1], stack[:0:-1], strict=True):
        if np.isinf(far.conductivity):
            gamma = np.full(np.shape(k), -1.0 + 0j)
            continue
        if np.isinf(near.conductivity):
            continue
        q = _wave_number(k, omega, far)
        back = gamma * (0.0 if np.isinf(far.thickness) else np.exp(-2.0 * q * far.thickness))
        r = _interface(k, omega, near, far)
        gamma = (r + back) / (1.0 + r * back)
    return gamma


def _wave_number(k: Array, omega: float, layer: Layer) -> Complex:
    """Return q of a layer, with positive real part [1/m]."""
    return np.asarray(np.sqrt(k**2 + 1j * omega * mu_0 * layer.relative_permeability * layer.conductivity))


def _interface(k: Array, omega: float, near: Layer, far: Layer) -> Complex:
    """Return r_ij of the module docstring."""
    m, n = near.relative_permeability, far.relative_permeability
    difference = k**2 * (n - m) * (n + m) + 1j * omega * mu_0 * m * n * (near.conductivity * n - far.conductivity * m)
    return np.asarray(difference / (_wave_number(k, omega, near) * n + _wave_number(k, omega, far) * m) ** 2)


@dataclass(frozen=True)
class Change:
    """What a stack of layers does to a coil.

    Attributes
    ----------
    delta_L, R : ndarray
        Change of inductance and of resistance, in the shape of the gap [H, ohm; per metre for a planar pair].
    error : float
        Largest estimated error of the quadrature over the largest change [-].
    """

    delta_L: Array
    R: Array
    error: float


def coil_change(
    rings: Sections, gap: ArrayLike, frequency: float, layers: Sequence[Layer], *, tolerance: float = 1e-8
) -> Change:
    """Return what layers above a coil do to it.

    Parameters
    ----------
    rings : Sections
        The coil, below z = 0; a section of no size is a filament.
    gap : array_like
        From z = 0 to the face of the layers, positive [m].
    frequency : float
        [Hz].
    layers : sequence of Layer
        Nearest first.
    tolerance : float
        Relative error of each of Delta L and R.

    Raises
    ------
    ValueError
        If a gap is not positive or the integral does not reach its tolerance.
    """
    gap = _positive("gap", gap)
    k_max = _DIGITS / (2.0 * gap.min())

    def integrand(k: Array) -> Array:
        return np.pi * mu_0 * source_spectrum(rings, k)[:, None] ** 2 * np.exp(-2.0 * k[:, None] * gap.ravel())

    return _integral(integrand, k_max, gap, frequency, layers, tolerance)


def pair_change(
    spacing: float, height: ArrayLike, frequency: float, layers: Sequence[Layer], *, tolerance: float = 1e-8
) -> Change:
    """Return what layers do to a planar go-and-return pair, per metre.

    Parameters
    ----------
    spacing : float
        Between the two filaments [m].
    height : array_like
        From the filaments to the face of the layers, positive [m].
    frequency, layers, tolerance
        As in `coil_change`.
    """
    height = _positive("height", height)

    def integrand(k: Array) -> Array:
        shape = 2.0 * mu_0 / np.pi * np.sin(k * spacing / 2) ** 2 / k
        return np.asarray(shape[:, None] * np.exp(-2.0 * k[:, None] * height.ravel()))

    return _integral(integrand, _DIGITS / (2.0 * height.min()), height, frequency, layers, tolerance)


def _positive(name: str, value: ArrayLike) -> Array:
    """Refuse distances that are not positive numbers."""
    distance = np.asarray(value, dtype=float)
    if distance.size == 0 or not np.all(distance > 0.0):
        raise ValueError(f"{name}: must be positive, the layers are above the coil; got {distance.tolist()} m")
    return distance


def _integral(
    weight: Callable[[Array], Array], k_max: float, distance: Array, frequency: float, layers: Sequence[Layer],
    tolerance: float,
) -> Change:
    """Integrate Gamma times a weight over 0..k_max, in the shape of the distances."""
    omega = 2.0 * np.pi * frequency

    def integrand(k: Array) -> Array:
        value = reflection(k[:, 0], omega, layers)[:, None] * weight(k[:, 0])
        return np.stack([value.real, value.imag], axis=-1)

    smallest = 1e-17 * k_max * float(np.abs(weight(np.linspace(0.0, k_max, 400)[1:])).max())
    result = cubature(integrand, [0.0], [k_max], rule="gk21", rtol=tolerance, atol=smallest, max_subdivisions=4000)
    if result.status != "converged":
        raise ValueError(f"tolerance: the integral over the layers does not reach {tolerance:g}; ask for a larger one")
    delta = result.estimate.reshape(*distance.shape, 2)
    scale = float(np.abs(result.estimate).max())
    error = float(np.abs(result.error).max()) / scale if scale > 0.0 else 0.0
    return Change(delta[..., 0], -omega * delta[..., 1], error)
