"""The planar target's own eddy currents: a rectangular plate as bars, seen through few samples of the coils' field.

Unknowns: the currents i [A] of rectangular bars along y, per metre of depth, graded to the faces and the ends:

    R_i = 1 / (sigma a_i b_i) [ohm/m],    L_ij = -(mu0 / 2 pi) <ln(r / R_b)>_ij [H/m],

closed form in `kernels`. Isolated plate: sum i = 0, and the radius R_b of the return drops out. Plate whose current
returns where A = 0: R_b is that circle's radius; its image of the target's own current is `bars`' business.

The coils' potential is harmonic over the plate: few samples of its slope f' at the nodes of `sampling` carry it
through the whole section, whatever the proportion of width, thickness and clearance. Coefficients c fitted to them, a
set for each of the four mirror classes, give every bar's mean potential. The classes decouple: one quadrant's cells
carry each.

That quadrant x, z > 0 has tensor cells, fine at the faces and the ends, in numbers that four divides. Joining them two
by two in both directions gives the middle division, once more the coarse one. With uniform current in each bar a
result's error goes with the square of the cells, so that from two divisions

    Y = Y_fine + (Y_fine - Y_middle) / 3

is better than either; the same from the middle and the coarse one is the check. A joined cell's mean is the mean of
its parts by area, so that the coarser inductances and couplings cost nothing more: with P the shares of the area,

    L_coarse = P L P^T,   B_coarse = B P^T.

Neglected: the plate's ends along y (planar), displacement current.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.constants import mu_0
from scipy.linalg import block_diag
from scipy.sparse import csr_array

from sits_mech.magnetics.modes import Modes, eddy_modes
from sits_mech.magnetics.section.kernels import mean_log
from sits_mech.magnetics.section.sampling import (
    CLASSES,
    all_nodes,
    field_basis,
    probe_charges,
    quadrant_images,
    sample_nodes,
    signs,
)
from sits_mech.quantities import Array, Complex, SolveFailed, SolveReport

_LEVELS = 3  # divisions: two for the answer, one more for its check
_GAUSS_X, _GAUSS_Z = np.polynomial.legendre.leggauss(4), np.polynomial.legendre.leggauss(2)
_MOST_BARS, _MOST_NODES = 11_200, 1_500  # about a minute and two gigabytes


@dataclass(frozen=True)
class Resolution:
    """How fine the plate is divided."""

    skin: float  # first cell at the surface over the skin depth
    growth: float  # ratio of neighbouring cells
    along: float  # largest cell along over a quarter of the width; through, over the thickness
    near: float  # largest cell along and first one below the faces, over the field's grain
    terms: float  # digits (natural logarithm) that the samples keep


@dataclass(frozen=True)
class Lengths:
    """Smallest lengths that a prepared plate resolves."""

    clearance: float  # distance to a coil or to another plate [m]
    grain: float  # over which the field along the plate changes: the clearance, or more near wide coils [m]
    skin_depth: float  # [m]


@dataclass(frozen=True)
class QuadrantCells:
    """Bars of the quadrant x, z > 0 about the section's centre."""

    x: Array  # (n,) centres [m]
    z: Array  # (n,)
    width: Array  # (n,) along x [m]
    height: Array  # (n,) along z [m]
    share: Any = None  # (n, finest cells) P: part of each finest cell in a cell's area, sparse


def divisions(size: tuple[float, float], resolution: Resolution, lengths: Lengths) -> tuple[QuadrantCells, ...]:
    """Return the finest, the middle and the coarse division of a section of width w and thickness t [m]."""
    x, z = (_nodes(*ends) for ends in _grading(size, resolution, lengths))
    finest = _quadrant_cells(x, z)
    found = []
    for level in range(_LEVELS):
        step = 2**level
        cells = _quadrant_cells(x[::step], z[::step])
        i, k = (n.ravel() // step for n in np.meshgrid(np.arange(x.size - 1), np.arange(z.size - 1), indexing="ij"))
        rows = i * ((z.size - 1) // step) + k
        area = finest.width * finest.height / (cells.width * cells.height)[rows]
        share = csr_array((area, (rows, np.arange(rows.size))), shape=(cells.x.size, rows.size))
        found.append(replace(cells, share=share))
    return tuple(found)


def bars_of(size: tuple[float, float], resolution: Resolution, lengths: Lengths) -> int:
    """Return how many bars the finest division has, without dividing; arguments as of `divisions`."""
    counts = []
    for ends in _grading(size, resolution, lengths):
        sizes, equal = _sizes(*ends)
        counts.append(_parts(len(sizes) + equal))
    return 4 * counts[0] * counts[1]


def _grading(
    size: tuple[float, float], resolution: Resolution, lengths: Lengths
) -> tuple[tuple[float, float, float, float], ...]:
    """Return half a side, its first and largest cell [m] and their growth, along and across."""
    width, thickness = size
    near = resolution.near * lengths.grain
    first = min(resolution.skin * lengths.skin_depth, near)
    largest = min(near, resolution.along * width / 4), resolution.along * thickness
    along, across = (min(first, most) for most in largest)
    return ((width / 2, along, largest[0], resolution.growth), (thickness / 2, across, largest[1], resolution.growth))


def _sizes(length: float, first: float, largest: float, growth: float) -> tuple[list[float], int]:
    """Return cells that grow from `first` up to `length` or the largest, and how many largest ones follow."""
    sizes = [min(first, length)]
    filled = sizes[0]
    while filled < length and sizes[-1] < largest:
        sizes.append(min(growth * sizes[-1], largest))
        filled += sizes[-1]
    return sizes, max(math.ceil((length - filled) / largest), 0)


def _parts(count: int) -> int:
    """Return how many cells are made of graded ones: a number that the levels divide."""
    parts: int = 2 ** (_LEVELS - 1)
    return parts * -(-count // parts)


def _graded(length: float, first: float, largest: float, growth: float) -> Array:
    """Return nodes of [0, length]: cells grow from `first`, at the end, by at most `growth` up to `largest`."""
    sizes, equal = _sizes(length, first, largest, growth)
    steps = np.concatenate([sizes, np.full(equal, largest)])
    nodes = length - np.concatenate([[0.0], np.cumsum(steps * (length / steps.sum()))])
    nodes[-1] = 0.0
    return nodes[::-1]


def _quadrant_cells(nodes_x: Array, nodes_z: Array) -> QuadrantCells:
    """Return tensor cells between the nodes of two half axes."""
    x, z = np.meshgrid((nodes_x[1:] + nodes_x[:-1]) / 2, (nodes_z[1:] + nodes_z[:-1]) / 2, indexing="ij")
    width, height = np.meshgrid(np.diff(nodes_x), np.diff(nodes_z), indexing="ij")
    return QuadrantCells(x.ravel(), z.ravel(), width.ravel(), height.ravel())


def _nodes(length: float, first: float, largest: float, growth: float) -> Array:
    """Return graded nodes of [0, length], their intervals in a number that four divides."""
    from scipy.interpolate import PchipInterpolator

    nodes = _graded(length, first, largest, growth)
    count = nodes.size - 1
    if count == 1:
        return np.linspace(0.0, length, _parts(1) + 1)
    wanted = np.linspace(0.0, count, _parts(count) + 1)
    return PchipInterpolator(np.arange(count + 1), nodes)(wanted)


@dataclass(frozen=True)
class PreparedPlate:
    """A plate prepared for all poses with at least its clearance and all frequencies up to its skin depth.

    `modes` and `cells` are of each division, from the finest on; modes one set a mirror class as `sampling.CLASSES`.
    """

    thickness: float  # t [m]
    nodes: Complex  # (m,) where the plate samples f', xi + j eta from the centre of the section [m]
    basis: Array  # (k, samples) from samples to coefficients, class by class
    modes: tuple[tuple[Modes, ...], ...]
    cells: tuple[QuadrantCells, ...]

    @property
    def bars(self) -> int:
        """Number of bars in the whole section."""
        return 4 * self.cells[0].x.size

    def coefficients(self, samples: Array) -> Array:
        """Return the coefficients c, shape (..., k), of samples (`coupling.samples`)."""
        return samples @ self.basis.T

    def admittance(self, omega: float, finest: int = 0) -> Complex:
        """Return Y(omega), shape (k, k), so that ``c^T Y c`` is in ohm/m; from the divisions `finest` and the next."""
        fine, coarse = (
            block_diag(*(modes.admittance(omega) for modes in self.modes[level])) for level in (finest, finest + 1)
        )
        return fine + (fine - coarse) / 3

    def currents(self, omega: float, finest: int = 0) -> tuple[Complex, Complex]:
        """Return the centres xi + j eta (b,) of all bars [m] and their currents (b, k) per unit coefficient [A].

        Bars of the division `finest` and of the next; currents of the finer ones weigh 4/3, of the coarser ones -1/3.
        """
        places: list[Complex] = []
        rows: list[Complex] = []
        for level, weight in ((finest, 4 / 3), (finest + 1, -1 / 3)):
            places += quadrant_images(self.cells[level].x + 1j * self.cells[level].z)
            columns = []
            for parities, modes in zip(CLASSES, self.modes[level], strict=True):
                own = weight / 2.0 * modes.currents(omega)  # the coupling counts all four quadrants in its square
                columns.append(np.concatenate([sign * own for sign in signs(parities)]))
            rows.append(np.concatenate(columns, axis=1))
        return np.concatenate(places), np.concatenate(rows)


@lru_cache(maxsize=64)
def prepare_plate(
    size: tuple[float, float], conductivity: float, resolution: Resolution, lengths: Lengths,
    return_radius: float | None = None,
) -> PreparedPlate:
    """Divide a plate of width w and thickness t [m] and find its modes; SolveFailed if its bars do not fit; kept.

    `return_radius` is R_b, where A = 0 for a plate with free net current; None for an isolated plate [m].
    """
    _check_size(bars_of(size, resolution, lengths), size, lengths.clearance, resolution.terms)
    levels = divisions(size, resolution, lengths)
    cells = levels[0]
    logs = _image_logs(cells, 1.0 if return_radius is None else return_radius)
    places, copies = sample_nodes(size, lengths.clearance, resolution.terms)
    charges = probe_charges(size, lengths.clearance)
    slopes = (1.0 / (places[:, None] - image) for image in quadrant_images(charges))  # f' of f = ln(p - p_k)
    sampled = tuple(np.concatenate([slope.real, slope.imag]) for slope in slopes)
    potentials = _potentials(cells, charges)
    weight = 1.0 / np.linalg.norm(sampled[0], axis=0)
    modes, bases = [], []
    for parities in CLASSES:
        L = -mu_0 / (2 * np.pi) * _combined(logs, parities)
        sampled_by_class, induced = (_combined(images, parities) * weight for images in (sampled, potentials))
        basis, fields = field_basis(sampled_by_class, induced, parities, copies)
        if return_radius is not None:  # the last sample is the potential of the centre
            basis = np.pad(basis, ((0, 0), (0, 1)))
            if parities == CLASSES[0]:
                basis = np.vstack([basis, np.eye(1, basis.shape[1], basis.shape[1] - 1)])
                fields = np.hstack([fields, np.ones((cells.x.size, 1))])
        isolated = parities == CLASSES[0] and return_radius is None
        modes.append([_modes(level, L, fields, conductivity, isolated) for level in levels])
        bases.append(basis)
    by_level = tuple(zip(*modes, strict=True))
    return PreparedPlate(
        size[1], all_nodes(places, copies), np.concatenate(bases), by_level, levels
    )


def _modes(level: QuadrantCells, L: Array, fields: Array, conductivity: float, isolated: bool) -> Modes:
    """Return modes of one class on one division, from the finest one's inductances and fields."""
    R = 1.0 / (conductivity * level.width * level.height)
    own = level.share @ (level.share @ L).T
    return eddy_modes(own, R, 2.0 * (level.share @ fields).T, constraint=np.ones(R.size) if isolated else None)


def _combined(images: tuple[Array, ...], parities: tuple[float, float]) -> Array:
    """Return the sum over the four images with a class's signs."""
    return np.asarray(sum(sign * image for sign, image in zip(signs(parities), images, strict=True)))


def _check_size(bars: int, size: tuple[float, float], clearance: float, terms: float) -> None:
    """Refuse more bars, or more nodes for the coils' field, than fit in memory and a minute."""
    nodes = int(terms * sum(size) / (2 * np.pi * clearance))
    if bars > _MOST_BARS or nodes > _MOST_NODES:
        raise SolveFailed(
            f"planar: a plate of {size[0] * 1e3:.4g} mm at a clearance down to {clearance * 1e3:.3g} mm needs {bars} "
            f"bars and {nodes} field nodes for this tolerance, {_MOST_BARS} and {_MOST_NODES} fit; ask for a larger "
            "tolerance, or for 'planar-fem'",
            SolveReport("planar", bars, 0, 0.0, 1.0, 0.0, "too many bars"),
        )


def _image_logs(cells: QuadrantCells, unit: float) -> tuple[Array, Array, Array, Array]:
    """Return the mean ln(r / unit) from each cell to each cell's own place and its images in x, in z and in both."""
    x, z = cells.x, cells.z
    first = (cells.width[:, None], cells.height[:, None])
    second = (cells.width, cells.height)

    def logs(mirror_x: float, mirror_z: float) -> Array:
        dx, dz = mirror_x * x - x[:, None], mirror_z * z - z[:, None]
        return np.asarray(mean_log(dx, dz, first, second) - np.log(unit))

    return logs(1, 1), logs(-1, 1), logs(1, -1), logs(-1, -1)


def _potentials(cells: QuadrantCells, charges: Complex) -> tuple[Array, ...]:
    """Return the mean of ln|p - p_k| over each cell, less that of the section's centre; each (cells, charges)."""
    means = []
    for image in quadrant_images(charges):
        mean = np.zeros((cells.x.size, charges.size))
        for gx, wx in zip(*_GAUSS_X, strict=True):
            for gz, wz in zip(*_GAUSS_Z, strict=True):
                dx = (cells.x + cells.width / 2 * gx)[:, None] - image.real
                dz = (cells.z + cells.height / 2 * gz)[:, None] - image.imag
                mean += wx * wz / 8 * np.log((dx * dx + dz * dz) / np.abs(image) ** 2)
        means.append(mean)
    return tuple(means)
