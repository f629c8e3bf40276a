"""Reflect a coil's field at an infinite plate, half-space or stack of layers, wave number by wave number.

``exp(+j omega t)``; the layers fill z > gap, air below and above them, all linear and isotropic:

    laplace A = 0 in air,    (1/mu) laplace A = j omega sigma A in a layer,    A and (1/mu) dA/dz continuous.

Coaxial rings below z = 0, with the section means ``S(k) = sum <a J1(k a) exp(k z)>`` [m], excite

    A_phi = (mu0/2) int_0^inf S(k) J1(k r) [exp(-k z) + Gamma(k) exp(k (z - 2 gap))] dk    [V s/m per A],
    Delta L_complex = pi mu0 int_0^inf Gamma(k) S(k)^2 exp(-2 k gap) dk = Delta L - j R / omega.

Reflection. Layer i has ``q_i = sqrt(k^2 + j omega mu_i sigma_i)``; between i and j

    r_ij = (q_i/mu_i - q_j/mu_j) / (q_i/mu_i + q_j/mu_j),    Gamma_i = (r_ij + Gamma_j e_j) / (1 + r_ij Gamma_j e_j),

``e_j = exp(-2 q_j t_j)``. The numerator of r_ij is written as a difference of squares, in which k^2 drops out between
non-magnetic layers: the weak reflections of low frequencies keep their digits.

Range: any frequency, conductivity (infinite: a perfect conductor), permeability. Neglected: displacement current.
Source: Dodd and Deeds, J. Appl. Phys. 39 (1968) 2829.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.constants import mu_0
from scipy.special import j1

from sits_mech.geometry.windings import Sections
from sits_mech.memory import GIB, VARIABLE, memory_limit
from sits_mech.quantities import Array, Complex

_PANEL = 16  # Gauss points of a panel
_ARRAYS = 4  # of a number for each ring and wave number, beside those at the Gauss points


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


def spectrum(rings: Sections, k: Array, *, points: int = 4) -> Array:
    """Return S(k), shape (n,) [m]: section means of ``a J1(k a) exp(k z)``, summed over rings of 1 A below z = 0.

    `points` are Gauss points along each ring's width. ValueError where it would take more memory than the process may.
    """
    needed, limit = 8.0 * (2 * points + _ARRAYS) * rings.radius.size * k.size, memory_limit()
    if needed > limit:
        raise ValueError(
            f"coils: the {rings.radius.size} turns of a coil, times {k.size} wave numbers of its field, must fit into "
            f"{limit / GIB:.3g} GiB (--memory, or {VARIABLE}); they take {needed / GIB:.3g} GiB"
        )
    nodes, weights = np.polynomial.legendre.leggauss(points)
    a = rings.radius[:, None] + rings.width[:, None] / 2 * nodes
    mean = np.einsum("rg,rgk,g->rk", a, j1(a[:, :, None] * k), weights) / 2
    thick = k * rings.height[:, None]
    top = (rings.z + rings.height / 2)[:, None]
    fall = np.where(thick > 0.0, -np.expm1(-thick) / np.where(thick > 0.0, thick, 1.0), 1.0)
    sign = np.broadcast_to(rings.sign, rings.radius.shape)
    return np.asarray(sign @ (mean * fall * np.exp(k * top)))


def wave_numbers(largest: float, length: float) -> tuple[Array, Array]:
    """Return Gauss points and weights on [0, largest] for what turns like ``exp(j k length)``, finer towards 0."""
    panels = 16 + int(largest * length / _PANEL)
    edges = largest * np.linspace(0.0, 1.0, panels + 1) ** 1.5
    nodes, weights = np.polynomial.legendre.leggauss(_PANEL)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1.0 + nodes)).ravel(), (half * weights).ravel()
