"""A disc's own eddy currents: rings of rectangular section, seen through waves J1(k r) exp(-k z) from below.

Unknowns: the currents i [A] of coaxial rings, uniform in each section (w by h at radius r), graded to faces and rim:

    R_i = 2 pi r_i / (sigma w_i h_i) [ohm],    L_ij = section means of the coaxial loops' M [H]  (`loops`),

with the field of a coil below the disc, bottom face at d_v, per ampere,

    A_phi = (mu0/2) int S(k) exp(-k d_v) J1(k r) exp(-k eta) dk,    eta = z - d_v,

taken at Gauss nodes k_q: the flux through ring i is ``sum_q c_q(d_v) B_qi``, with B_qi the section mean of
``2 pi r J1(k_q r) exp(-k_q eta)`` and

    c_q = weight_q (mu0/2) S(k_q) exp(-k_q d_v).

A pose costs the c_q, their product with what each wave induces in each mode, and a sum over the modes.

The disc is symmetric about its middle plane, so the upper half's rings carry an even and an odd class.

Error: means of piecewise constants, second order in the cell size (measured). Halving all cells and
``Y = (4 Y_fine - Y_coarse) / 3`` takes the leading term away.

Neglected: displacement current; relative permeability is 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.constants import mu_0
from scipy.special import j1

from sits_mech.magnetics.dodd_deeds import spectrum
from sits_mech.magnetics.loops import Sections, ring_mutual
from sits_mech.magnetics.modes import Modes, eddy_modes
from sits_mech.quantities import Array

_TAIL = 16.0  # fields are cut where exp(-k gap) falls to exp(-16), their energy to exp(-32)
_FIRST, _GROWTH, _ALONG = 2.0, 2.0, 1.0  # first cell / skin depth, ratio of cells, largest / distance to the coil
_ROWS = 64  # of a matrix at once
_PANEL = 60.0  # phase of the fastest wave over one panel of the quadrature [rad]
_GAUSS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True)
class DiscProblem:
    """What a division of the disc must serve.

    Attributes
    ----------
    radius, thickness, conductivity : float
        Of the disc [m, m, S/m].
    inner, outer : float
        The coil's smallest and largest radius [m].
    gaps : tuple of float
        Smallest and largest distance of the coil plane to the disc [m].
    skin_depth : float
        Smallest skin depth [m].
    """

    radius: float
    thickness: float
    conductivity: float
    inner: float
    outer: float
    gaps: tuple[float, float]
    skin_depth: float


@dataclass(frozen=True)
class Disc:
    """A disc at one level of division.

    Attributes
    ----------
    modes : tuple of Modes
        Even and odd class.
    rings : int
        Number of rings in the whole disc.
    """

    modes: tuple[Modes, Modes]
    rings: int

    def reaction(self, waves: Array, omega: float) -> NDArray[np.complex128]:
        """Return Delta Z = c^T Y(omega) c of poses with the coefficients c_q, shape (p, q), in ohm, shape (p,)."""
        total = np.zeros(waves.shape[0], dtype=complex)
        for modes in self.modes:
            total += (waves @ modes.coupling) ** 2 @ (omega**2 / (1.0 + 1j * omega * modes.tau))
        return total


def prepare_disc(problem: DiscProblem, level: int, *, points: int = 1) -> Disc:
    """Divide the disc, halving the coarsest cells `level` times, and find its modes.

    Parameters
    ----------
    problem : DiscProblem
    level : int
        0 is the coarsest; each next one has four times the rings.
    points : int
        Of the loops' quadrature along r: 1 is good to 1e-4 of R, 2 to 1e-6.
    """
    r, z = _nodes(problem)
    for _ in range(level):
        r, z = _halved(r), _halved(z)
    rings = _rings(r, z)
    R = 2.0 * np.pi * rings.radius / (problem.conductivity * rings.width * rings.height)
    own, image = (_mutual(rings, other, points) for other in (rings, rings.mirrored()))
    even, odd = _means(r, z, waves(problem)[0])
    root = np.sqrt(2.0)  # both halves
    modes = (eddy_modes(own + image, R, root * even), eddy_modes(own - image, R, root * odd))
    return Disc(modes, 2 * R.size)


def count_rings(problem: DiscProblem, level: int) -> int:
    """Return the number of rings in half the disc at a level, before anything is built."""
    r, z = _nodes(problem)
    return int((r.size - 1) * (z.size - 1) * 4**level)


def waves(problem: DiscProblem) -> tuple[Array, Array]:
    """Return the wave numbers k_q [1/m] and their weights, for all gaps of the problem.

    Panels halve towards k = 0 until exp(-k gap) is smooth on the lowest, and are cut where the waves over the disc and
    the coil turn too often for one rule.
    """
    reach = problem.radius + problem.outer
    edges = [_TAIL / problem.gaps[0]]
    while edges[-1] * problem.gaps[1] > 2 * _TAIL:
        edges.append(edges[-1] / 2)
    edges.append(0.0)
    k, weight = [], []
    for high, low in zip(edges[:-1], edges[1:], strict=True):
        pieces = 1 + int((high - low) * reach / _PANEL)
        width = (high - low) / pieces
        nodes, weights = np.polynomial.legendre.leggauss(12 + int(width * reach / 2))
        k.append((low + width * (np.arange(pieces)[:, None] + (nodes + 1) / 2)).ravel())
        weight.append(np.tile(width / 2 * weights, pieces))
    return np.concatenate(k), np.concatenate(weight)


def coil_waves(rings: Sections, problem: DiscProblem, d_v: Array) -> Array:
    """Return c_q of the module docstring for a coil below z = 0 and discs at d_v [V s/m per A]; shape (p, q)."""
    k, weight = waves(problem)
    return np.asarray(weight * mu_0 / 2 * spectrum(rings, k) * np.exp(-np.outer(d_v, k)))


def _nodes(problem: DiscProblem) -> tuple[Array, Array]:
    """Nodes of the coarsest division: along the radius, and from the middle plane to the top face."""
    gap, thickness = problem.gaps[0], problem.thickness
    first = min(_FIRST * problem.skin_depth, _ALONG * gap, thickness / 2, problem.radius / 2)
    r, step = [problem.radius], first
    while r[-1] > step / 2:
        r.append(r[-1] - step)
        away = max(problem.inner - r[-1], r[-1] - problem.outer, 0.0)
        step = min(_GROWTH * step, _ALONG * gap + away / 3)
    inward = _fitted(r)
    tallest = max(first, inward[1])  # the loops' quadrature fails for rings much higher than their radius
    z, step = [thickness / 2], first
    while z[-1] > step / 2:
        z.append(z[-1] - step)
        step = min(_GROWTH * step, thickness / 4, tallest)
    return inward, _fitted(z)


def _fitted(descending: list[float]) -> Array:
    """Stretch nodes so that the last one is 0; ascending."""
    nodes = np.array(descending)
    top = nodes[0]
    return np.asarray((top - (top - nodes) * (top / (top - nodes[-1])))[::-1])


def _halved(nodes: Array) -> Array:
    """Nodes and their mid-points."""
    return np.sort(np.concatenate([nodes, (nodes[1:] + nodes[:-1]) / 2]))


def _rings(r: Array, z: Array) -> Sections:
    """Tensor cells between nodes."""
    radius, height = np.meshgrid((r[1:] + r[:-1]) / 2, (z[1:] + z[:-1]) / 2, indexing="ij")
    sizes = np.meshgrid(np.diff(r), np.diff(z), indexing="ij")
    return Sections(radius.ravel(), height.ravel(), sizes[0].ravel(), sizes[1].ravel())


def _mutual(rings: Sections, others: Sections, points: int) -> Array:
    """Mutual inductances, some rows at a time; symmetric, though the quadrature treats its two sections unlike."""
    parts = [slice(start, start + _ROWS) for start in range(0, rings.radius.size, _ROWS)]
    rows = [Sections(rings.radius[p], rings.z[p], rings.width[p], rings.height[p]) for p in parts]
    matrix = np.concatenate([ring_mutual(row, others, points=(points, 1)) for row in rows])
    return np.asarray((matrix + matrix.T) / 2)


def _means(r: Array, z: Array, k: Array) -> tuple[Array, Array]:
    """Even and odd part of B about the middle plane, each of shape (q, n); nothing overflows for k t >> 1."""
    nodes, weights = _GAUSS
    radius = ((r[1:] + r[:-1]) / 2)[:, None] + np.diff(r)[:, None] / 2 * nodes
    along = np.stack([np.pi * (radius * j1(wave * radius)) @ weights for wave in k])
    kh = np.outer(k, np.diff(z))
    fall = -np.expm1(-kh) / kh
    low, high = fall * np.exp(-np.outer(k, z[-1] + z[:-1])), fall * np.exp(-np.outer(k, z[-1] - z[1:]))
    shape = (k.size, (r.size - 1) * (z.size - 1))
    even, odd = ((along[:, :, None] * part[:, None, :]).reshape(shape) / 2 for part in (low + high, low - high))
    return even, odd
