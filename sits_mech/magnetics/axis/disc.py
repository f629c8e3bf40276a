"""A disc's own eddy currents: rings of rectangular section, seen by one coil below at any gap.

Unknowns: the currents i [A] of coaxial rings, uniform in each section (w by h at radius r):

    R_i = 2 pi r_i / (sigma w_i h_i) [ohm],    L_ij = section means of the coaxial loops' M [H]  (`coils.loops`),

with the field of a coil below the disc, bottom face at d_v, per ampere,

    A_phi = (mu0/2) int S(k) exp(-k d_v) J1(k r) exp(-k eta) dk,    eta = z - d_v,

at Gauss nodes of k: the flux through ring i is the section mean of ``2 pi r A_phi``. A dipole at a radius a, upright or
outwards, has the field of ``S = k/(2 pi) J0(k a) exp(k z)`` or ``-k/(2 pi) J1(k a) exp(k z)``: what it shares with the
coil is B of the disc's currents there. Over a range of gaps the flux is a smooth function of u = ln d_v, singular at
Im u = pi/2: a Chebyshev series of a few terms, the disc's field functions. A pose costs their values, their product
with what each induces in each mode, and a sum over the modes.

Division: rows parallel to the faces, their height growing from `first` (some skin depths, no more than the gap) by a
factor of two at most; in a row the cells are graded from the rim as the rows are from the face, and no larger than
the row's distance to the coil. What lies deep below the skin of a thick disc is a few large cells.

The disc is symmetric about its middle plane, so the upper half's rings carry an even and an odd class.

Error: means of piecewise constants, second order in the cell size (measured). Halving all cells and
``Y = (4 Y_fine - Y_coarse) / 3`` takes the leading term away.

Neglected: displacement current; relative permeability is 1.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.constants import mu_0
from scipy.special import j0, j1

from sits_mech.geometry.windings import Sections, coil_sections
from sits_mech.magnetics.coils.loops import paired_mutual
from sits_mech.magnetics.coils.ring_field import source_spectrum
from sits_mech.magnetics.modes import Modes, eddy_modes
from sits_mech.magnetics.space.fields import chebyshev_points, chebyshev_values, to_coefficients
from sits_mech.quantities import Array, Complex
from sits_mech.scene.sensor import Coil

_TAIL = 16.0  # fields are cut where exp(-k gap) falls to exp(-16), their energy to exp(-32)
_FIRST, _GROWTH, _ALONG = 2.0, 2.0, 1.0  # first cell / skin depth, ratio of cells, largest / distance to the coil
_TALL = 0.25  # highest row over the radius: the loops' quadrature fails for rings much higher than that
_ROWS = 64  # of a matrix at once
_NEAR = 4.0  # pairs closer than so many of their longest side
_PANEL = 60.0  # phase of the fastest wave over one panel of the quadrature [rad]
_DIGITS = 24.0  # natural logarithm of what the Chebyshev series leaves out
_WAVES = 400  # at once
_GAUSS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True)
class DiscProblem:
    """What a division of the disc must serve."""

    radius: float  # of the disc [m]
    thickness: float  # [m]
    conductivity: float  # [S/m]
    coil: Coil  # on the same axis
    gaps: tuple[float, float]  # smallest and largest distance of the coil plane to the disc, different [m]
    skin_depth: float  # smallest one [m]
    places: tuple[tuple[float, float], ...] = ()  # r and z at which B of the disc's currents is asked [m]


@dataclass(frozen=True)
class Row:
    """Cells of one height side by side: from z = `low` to `high` above the middle plane, between the nodes r [m]."""

    low: float
    high: float
    r: Array


@dataclass(frozen=True)
class Disc:
    """A disc at one level of division."""

    modes: tuple[Modes, Modes]  # even and odd class, without shapes; their field functions are Chebyshev's of ln d_v
    rings: int  # in the whole disc
    gaps: tuple[float, float]  # range of d_v [m]

    sources: int = 1  # the coil, and dipoles at the places

    def reaction(self, d_v: Array, omega: float) -> Complex:
        """Return Delta Z [ohm] at heights within the range of the gaps, shape (p,)."""
        return np.asarray(self._shared(d_v, omega, 1)[0])

    def field(self, d_v: Array, omega: float) -> Complex:
        """Return B upright and outwards at the places by the coil, (p, places, 2) [T/A]."""
        found = self._shared(d_v, omega, self.sources)[1:] / (1j * omega)
        return np.moveaxis(found.reshape(-1, 2, d_v.size), 2, 0)

    def _shared(self, d_v: Array, omega: float, count: int) -> Complex:
        """Return Delta Z that the first sources share with the coil, (count, p)."""
        total, (low, high) = np.zeros((count, d_v.size), dtype=complex), np.log(self.gaps)
        for modes in self.modes:
            coupling = modes.coupling.reshape(self.sources, -1, modes.tau.size)[:count]
            fields = chebyshev_values((2 * np.log(d_v) - low - high) / (high - low), coupling.shape[1])
            seen = fields @ coupling
            total += (seen * seen[0]) @ (omega**2 / (1.0 + 1j * omega * modes.tau))
        return total


@lru_cache(maxsize=64)
def prepare_disc(problem: DiscProblem, level: int) -> Disc:
    """Divide the disc, halving the coarsest cells `level` times, each time four times the rings, and find its modes."""
    rows = divided_disc(problem, level)
    rings = _rings(rows)
    R = 2.0 * np.pi * rings.radius / (problem.conductivity * rings.width * rings.height)
    own, image = (_mutual(rings, other) for other in (rings, rings.mirrored()))
    even, odd = _fluxes(problem, rows)
    root = np.sqrt(2.0)  # both halves
    pair = eddy_modes(own + image, R, root * even), eddy_modes(own - image, R, root * odd)
    first, second = (Modes(modes.tau, modes.coupling) for modes in pair)
    return Disc((first, second), 2 * R.size, problem.gaps, 1 + 2 * len(problem.places))


def divided_disc(problem: DiscProblem, level: int) -> list[Row]:
    """Return the rows of cells in the upper half of the disc, from the middle plane up."""
    gap, thickness, radius = problem.gaps[0], problem.thickness, problem.radius
    first = min(_FIRST * problem.skin_depth, _ALONG * gap, thickness / 2, radius / 2)
    z, step = [thickness / 2], first
    while z[-1] > step / 2:
        depth = thickness / 2 - z[-1] + step
        z.append(z[-1] - step)
        step = min(_GROWTH * step, thickness / 4, _ALONG * (gap + depth), _TALL * radius)
    nodes = _fitted(z)
    rows = [
        Row(low, high, _across(problem, first, gap + thickness / 2 - high))
        for low, high in zip(nodes[:-1].tolist(), nodes[1:].tolist(), strict=True)
    ]
    for _ in range(level):
        rows = [half for row in rows for half in _quartered(row)]
    return rows


def count_rings(problem: DiscProblem, level: int) -> int:
    """Return the number of rings in half the disc at a level, before anything is built."""
    return int(sum(row.r.size - 1 for row in divided_disc(problem, 0)) * 4**level)


def _across(problem: DiscProblem, first: float, height: float) -> Array:
    """Return nodes along the radius of cells `height` above the coil plane, fine at the rim and over the coil."""
    inner, outer = problem.coil.inner_diameter / 2, problem.coil.outer_diameter / 2
    r, step = [problem.radius], first
    while r[-1] > step / 2:
        r.append(r[-1] - step)
        away = max(inner - r[-1], r[-1] - outer, 0.0)
        step = min(_GROWTH * step, _ALONG * height + away / 3)
    return _fitted(r)


def _fitted(descending: list[float]) -> Array:
    """Stretch nodes so that the last one is 0; ascending."""
    nodes = np.array(descending)
    top = nodes[0]
    return np.asarray((top - (top - nodes) * (top / (top - nodes[-1])))[::-1])


def _quartered(row: Row) -> tuple[Row, Row]:
    """Return both halves of a row, every cell halved along r."""
    r = np.sort(np.concatenate([row.r, (row.r[1:] + row.r[:-1]) / 2]))
    middle = (row.low + row.high) / 2
    return Row(row.low, middle, r), Row(middle, row.high, r)


def _rings(rows: list[Row]) -> Sections:
    """Return the cells of all rows."""
    parts = [
        ((row.r[1:] + row.r[:-1]) / 2, np.full(row.r.size - 1, (row.low + row.high) / 2), np.diff(row.r),
         np.full(row.r.size - 1, row.high - row.low))
        for row in rows
    ]
    radius, z, width, height = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Sections(radius, z, width, height)


def _mutual(rings: Sections, others: Sections) -> Array:
    """Return symmetric mutual inductances, some rows at a time from the diagonal on.

    Near pairs need unlike points in the two sections: the mean of both orders is taken.
    """
    n = rings.radius.size
    side = np.maximum(np.maximum(rings.width, rings.height), np.maximum(others.width, others.height))
    matrix = np.empty((n, n))
    for start in range(0, n, _ROWS):
        i, j = (index.ravel() for index in np.mgrid[start : min(start + _ROWS, n), start:n])
        i, j = i[i <= j], j[i <= j]
        apart = np.hypot(rings.radius[i] - others.radius[j], rings.z[i] - others.z[j])
        near = apart < _NEAR * np.maximum(side[i], side[j])
        value = np.empty(i.size)
        far = ~near
        value[far] = paired_mutual(rings.some(i[far]), others.some(j[far]), (2, 1), (2, 1))
        orders = [(i[near], j[near]), (j[near], i[near])]
        value[near] = sum(paired_mutual(rings.some(p), others.some(q), (2, 1), (3, 1)) for p, q in orders) / 2
        matrix[i, j] = matrix[j, i] = value
    return matrix


def _fluxes(problem: DiscProblem, rows: list[Row]) -> tuple[Array, Array]:
    """Return Chebyshev coefficients of the sources' flux through each cell, even and odd part, (s m, n).

    Of the coil [V s/A], then of dipoles at each place, upright and outwards [V s/(A m^2)].
    """
    spread = np.log(problem.gaps[1] / problem.gaps[0])
    count = 4 + int(np.ceil(_DIGITS / np.arcsinh(np.pi / spread)))  # by the distance of the singularity in ln d_v
    low, high = np.log(problem.gaps)
    gaps = np.exp((low + high) / 2 + (high - low) / 2 * chebyshev_points(count))
    sources = 1 + 2 * len(problem.places)
    total = [np.zeros((2, sources * count, row.r.size - 1)) for row in rows]
    a, z = np.reshape(problem.places, (-1, 2)).T[:, :, None]
    for k, weight in _waves(problem):
        dipoles = np.stack([j0(k * a), -j1(k * a)], axis=1) * (k / (2.0 * np.pi)) * np.exp(k * z[:, None])
        S = np.vstack([source_spectrum(coil_sections(problem.coil), k), dipoles.reshape(-1, k.size)])
        c = (S[:, None] * (weight * mu_0 / 2 * np.exp(-np.outer(gaps, k)))).reshape(sources * count, -1)
        for row, flux in zip(rows, total, strict=True):
            near = problem.thickness / 2 - row.high
            if k.min() * (problem.gaps[0] + near) < 2 * _TAIL:
                flux += _through(row, k, c, problem.thickness / 2)
    below, above = np.concatenate(total, axis=2)
    transform = to_coefficients(count)
    both = [(transform @ each.reshape(sources, count, -1)).reshape(each.shape) / 2 for each in (below, above)]
    return both[0] + both[1], both[0] - both[1]


def _through(row: Row, k: Array, c: Array, half: float) -> Array:
    """Return flux through a row's cells in the lower and the upper half (2, m, n); no overflow for k t >> 1."""
    nodes, weights = _GAUSS
    radius = ((row.r[1:] + row.r[:-1]) / 2)[:, None] + np.diff(row.r)[:, None] / 2 * nodes
    along = np.pi * np.einsum("ng,qng,g->qn", radius, j1(k[:, None, None] * radius), weights)
    kh = k * (row.high - row.low)
    fall = -np.expm1(-kh) / kh
    lower, upper = fall * np.exp(-k * (half - row.high)), fall * np.exp(-k * (half + row.low))
    return np.stack([(c * lower) @ along, (c * upper) @ along])


def _waves(problem: DiscProblem) -> Iterator[tuple[Array, Array]]:
    """Return wave numbers k [1/m] and their weights, some at a time, for all gaps of the problem.

    Panels halve towards k = 0 until exp(-k gap) is smooth on the lowest, and are cut where the waves over the disc and
    the coil turn too often for one rule.
    """
    reach = problem.radius + problem.coil.outer_diameter / 2
    edges = [_TAIL / problem.gaps[0]]
    while edges[-1] * problem.gaps[1] > 2 * _TAIL:
        edges.append(edges[-1] / 2)
    edges.append(0.0)
    for high, low in zip(edges[:-1], edges[1:], strict=True):
        pieces = 1 + int((high - low) * reach / _PANEL)
        width = (high - low) / pieces
        nodes, weights = np.polynomial.legendre.leggauss(12 + int(width * reach / 2))
        step = max(1, _WAVES // nodes.size)
        for start in range(0, pieces, step):
            places = np.arange(start, min(start + step, pieces))
            k = low + width * (places[:, None] + (nodes + 1) / 2)
            yield k.ravel(), np.tile(width / 2 * weights, places.size)
