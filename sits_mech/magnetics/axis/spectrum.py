"""The field of coaxial rings by its wave numbers.

Rings below z = 0, 1 A each, with the section means ``S(k) = sum <a J1(k a) exp(k z)>`` [m], have above them

    A_phi = (mu0/2) int_0^inf S(k) J1(k r) exp(-k z) dk    [V s/m per A].

Source: Dodd and Deeds, J. Appl. Phys. 39 (1968) 2829.
"""

from __future__ import annotations

import numpy as np
from scipy.special import j1

from sits_mech.geometry.windings import Sections
from sits_mech.memory import GIB, VARIABLE, memory_limit
from sits_mech.quantities import Array

_PANEL = 16  # Gauss points of a panel
_ARRAYS = 4  # of a number for each ring and wave number, beside those at the Gauss points


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
