"""Impedance that a readout sees at a coil's terminals: idle coils shorted or open, leads, capacitance, also its own.

With the coils' own series resistance and the leads on the diagonal, ``Z = R + j omega L`` (n x n) links voltages and
currents, V = Z I. One coil is driven at a time. An open idle coil carries no current: the driven one shows Z_ii. A
shorted one has V_j = 0, and eliminating all of them leaves

    Z_i = Z_ii - Z_ij (Z_jj)^-1 Z_ji = 1 / (Z^-1)_ii,    j = the idle coils.

Live ones swing all the time, each tank with its capacitance C, on chips of their own: coupled resonators, whose modes
with the small losses left out are the eigenvectors v of L, leads included,

    L v = lambda v,    omega^2 = 1 / (lambda C),    L_i = lambda of the mode that is mostly coil i,    R_i = v^T R v,

so that equal tanks are split by their coupling k, L (1 +- k).

A capacitance across the terminals gives ``Z_i / (1 + j omega C Z_i)``, real where the tank swings (`tank_frequency`).

A coil's own capacitance is the energy between its tracks: with v the voltage at a place over that of the coil, falling
from 1 to 0 in proportion to the length in series,

    C = sum over facing tracks of neighbouring layers   int c (v - v')^2 dl
      + sum over neighbouring turns of a layer           int c_s (v - v')^2 dl.

Facing tracks that overlap by a width b, a distance d of copper from copper apart, are a pair of strips with their
fringe, which is no wider than the gap to the next turn,

    c = eps0 eps_r [b + min(f, gap)] / d,    f = (d / pi) [1 + ln(1 + 2 pi b / d)],

turns side by side coplanar strips of width w and gap s, one half of their field in the board, the other in air or, on
inner planes, in the board too (no more is known here of a coating):

    c_s = eps0 (eps_r + 1) / 2  K(k') / K(k),    k = s / (s + 2 w),  k'^2 = 1 - k^2,

K the complete elliptic integrals. For two aligned layers wound inwards and outwards the first sum is a third of that of
two plates of the tracks' area. It is an estimate, to some tens of percent, without vias, the target and other metal
nearby, farther layers, leads; of one layer no more than a lower bound: turns farther apart than neighbours, and pads,
count as much there.

Neglected: currents of an open idle coil through its own capacitance.
Sources: H. B. Palmer, Trans. AIEE 56 (1937) 363 (strips); A. Massarini and M. K. Kazimierczuk, IEEE Trans. Power
Electron. 12 (1997) 671 (energy of the voltages between turns); coplanar strips by conformal mapping, W. R. Smythe,
Static and Dynamic Electricity.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike
from scipy.constants import epsilon_0
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree
from scipy.special import ellipkm1

from sits_mech.geometry.tracks import coil_lines, standing_rings
from sits_mech.quantities import Array, Complex
from sits_mech.scene.sensor import Coil, Readout

_APART = 0.03  # of their frequencies, from which on tanks nearby are let be
_MOST = 200_000  # samples along a coil's tracks


def terminal_impedance(Z: ArrayLike, R_coil: ArrayLike, readout: Readout, omega: float) -> Complex:
    """Return coils' impedances (..., n) with leads, before the capacitance, of Z (..., n, n) without R_coil (n,)."""
    lead = readout.lead_resistance + 1j * omega * readout.lead_inductance
    whole = np.asarray(Z, dtype=complex) + np.diag(np.asarray(R_coil, dtype=float) + lead)
    if readout.idle_coil == "live":
        return _live(whole, omega)
    if readout.idle_coil == "open":
        return np.diagonal(whole, axis1=-2, axis2=-1)
    return np.asarray(1.0 / np.diagonal(np.linalg.inv(whole), axis1=-2, axis2=-1))


def _live(whole: Complex, omega: float) -> Complex:
    """Return what each tank shows while all swing, (..., n), by the modes of equal capacitances."""
    values, modes = np.linalg.eigh(whole.imag / omega)
    R = np.einsum("...im,...ij,...jm->...m", modes, whole.real, modes)
    flat = np.abs(modes).reshape(-1, *modes.shape[-2:])
    own = np.array([linear_sum_assignment(-each)[1] for each in flat]).reshape(modes.shape[:-1])
    return np.take_along_axis(R + 1j * omega * values, own, axis=-1)


def pulling(Z: ArrayLike, names: Sequence[str], omega: float) -> tuple[str, ...]:
    """Say which live tanks are so near in frequency that they pull each other; Z (..., n, n) with leads or without.

    Nearer than 3 %, or than their coupling k.
    """
    L = np.asarray(Z).imag / omega
    L = L.reshape(-1, *L.shape[-2:])
    found = []
    for i, j in combinations(range(L.shape[-1]), 2):
        apart = np.abs(np.sqrt(L[:, j, j] / L[:, i, i]) - 1.0).min(initial=np.inf)
        k = np.abs(L[:, i, j] / np.sqrt(L[:, i, i] * L[:, j, j])).max(initial=0.0)
        if apart < max(_APART, k):
            found.append(
                f"live tanks: {names[i]} and {names[j]} are {100.0 * apart:.2g} % apart in frequency and coupled by "
                f"k = {100.0 * k:.2g} %, so that they pull each other: give them other capacitances"
            )
    return tuple(found)


def with_capacitance(Z: ArrayLike, capacitance: float, omega: float) -> Complex:
    """Return impedances [ohm] with a capacitance [F] across their terminals."""
    Z = np.asarray(Z, dtype=complex)
    return Z / (1.0 + 1j * omega * capacitance * Z)


@lru_cache(maxsize=64)
def own_capacitance(coil: Coil) -> float:
    """Return the capacitance across a coil's ends by its own tracks, an estimate [F]."""
    return _between_layers(coil) + _between_turns(coil)


def _in_series(coil: Coil) -> list[tuple[Array, float]]:
    """Return centre lines in series: turns of layers alternate from outside in and from inside out."""
    lines = coil_lines(coil)
    if coil.shape == "path":
        return lines
    layers = [lines[k * coil.turns : (k + 1) * coil.turns] for k in range(coil.layers)]
    return [line for k, layer in enumerate(layers) for line in (layer if k % 2 else layer[::-1])]


def _between_layers(coil: Coil) -> float:
    """Return the sum over facing tracks of the module docstring [F]."""
    heights = coil.heights
    if len(heights) < 2:
        return 0.0
    place, way, v, size = _samples(coil)
    gap = coil.track_gap if coil.shape != "path" else coil.track_width
    total = 0.0
    for above, below in zip(heights[:-1], heights[1:], strict=True):
        upper, lower = (np.flatnonzero(place[:, 2] == z) for z in (above, below))
        d = above - below - coil.track_thickness
        near = cKDTree(place[lower, :2]).query(place[upper, :2])[1]
        step = place[lower[near], :2] - place[upper, :2]
        aside = np.abs(step[:, 0] * way[upper, 1] - step[:, 1] * way[upper, 0])
        length, width = size[upper].T
        other = size[lower[near], 1]
        beyond = np.abs(np.einsum("ij,ij->i", step, way[upper])) > (length + size[lower[near], 0]) / 2 + width
        b = np.clip((width + other) / 2 - aside, 0.0, np.minimum(width, other)) * ~beyond
        fringe = np.minimum(d / np.pi * (1.0 + np.log1p(2.0 * np.pi * b / d)), gap)
        c = np.where(b > 0.0, (b + fringe) / d, 0.0)
        total += float((c * (v[upper] - v[lower[near]]) ** 2) @ length)
    return epsilon_0 * coil.board_permittivity * total


def _samples(coil: Coil) -> tuple[Array, Array, Array, Array]:
    """Return places along the tracks, at most a width apart, with direction, voltage, and length and width of each."""
    parts = [(line[:-1], line[1:], width) for line, width in _in_series(coil)]
    start, end = (np.vstack([part[k] for part in parts]) for k in (0, 1))
    width = np.concatenate([np.full(len(a), w) for a, _, w in parts])
    step = end - start
    length = np.linalg.norm(step, axis=1)
    finest = max(1.0, length.sum() / width.min() / _MOST)
    count = np.ceil(length / (finest * width)).astype(np.int64)
    k = np.repeat(np.arange(len(count)), count)
    share = (np.arange(len(k)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[k]
    before = np.cumsum(length) - length
    v = 1.0 - (before[k] + share * length[k]) / length.sum()
    way = step[:, :2] / length[:, None]
    return start[k] + share[:, None] * step[k], way[k], v, np.column_stack([(length / count)[k], width[k]])


def _between_turns(coil: Coil) -> float:
    """Return the sum over neighbouring turns, with the rings that stand for the coil [F]."""
    rings = standing_rings(coil)
    around = 2.0 * np.pi * rings.radius
    total = 0.0
    for z in np.unique(rings.z):
        some = np.flatnonzero(rings.z == z)
        some = some[np.argsort(rings.radius[some])]
        width = rings.width[some]
        s = np.maximum(np.diff(rings.radius[some]) - (width[1:] + width[:-1]) / 2, 0.1 * width[1:])
        k = s / (s + width[1:] + width[:-1])
        length = (around[some][1:] + around[some][:-1]) / 2
        total += float((ellipkm1(k**2) / ellipkm1(1.0 - k**2) * length * (length / around.sum()) ** 2).sum())
    return epsilon_0 * (coil.board_permittivity + 1.0) / 2.0 * total
