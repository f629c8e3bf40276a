"""Divide the plane around the metal: graded tensor triangles in each plate, gmsh between, a circle around all.

Every part is a rectangle in the section: target, ground plane, ferrite backing. Its own axes xi (along) and eta (up
from the middle of the bottom face) are turned clockwise by alpha. Along each axis nodes follow a wanted size

    h(s) = min(first + growth d(s), near c(s), share of the length),

d the distance to the nearer end, c the distance to the nearest coil bar or other part (the coils' field is as smooth
as it is far from its bars). `first` is a fraction of the skin depth, or of the thickness where that is the smaller, so
that the skin is resolved at every frequency: the number of layers grows like the logarithm of thickness over skin
depth. The air mesh takes over the sections' outlines edge by edge and coarsens towards the circle. To refine, divide
anew with smaller sizes: halving slim triangles would open their angles to 180 degrees, and the error with them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from skfem import MeshTri

from sits_mech.geometry.meshing.unstructured import fill_between
from sits_mech.geometry.plates import PlateSection
from sits_mech.quantities import Array, Complex, Integers, integrals
from sits_mech.units import millimetres as mm

_SMALLEST = 1e-7  # first cell at least this share of a plate's length: finer skins are not resolved


@dataclass(frozen=True)
class Fineness:
    """Sizes of the division."""

    skin: float  # first cell over the skin depth
    edge: float  # first cell over the thickness, where that is smaller
    growth: float  # increase of cell size per distance from a face
    near: float  # largest cell over the distance to a coil or another part
    share: float  # largest cell over the side
    around: float  # edges of the outer circle

    def times(self, factor: float) -> Fineness:
        """Return all sizes larger by `factor`; never less than two cells across a thickness."""
        return Fineness(
            self.skin * factor, min(self.edge * factor, 0.5), self.growth * factor, self.near * factor,
            self.share * factor, self.around / factor,
        )


@dataclass(frozen=True)
class DividedPlane:
    """The divided plane."""

    mesh: MeshTri
    part: Integers  # (elements,) 0 in air, k + 1 in plate k
    centre: complex  # of the outer circle [m]
    radius: float  # of the outer circle [m]


def divide_plane(
    plates: tuple[PlateSection, ...],
    bars: Complex,
    skin_depths: Array,
    fineness: tuple[Fineness, ...],
    ground: float | None = None,
) -> DividedPlane:
    """Divide the plane around plates, apart from each other, up to a circle.

    `bars` are the places x + j z of the coils' bars, `skin_depths` and `fineness` one a plate (the circle takes the
    finest `around`), `ground` the radius where A = 0 [m]. ValueError if plates reach beyond the grounded circle.
    """
    centre, radius, around = _outer_circle(plates, max(f.around for f in fineness), ground)
    grids = []
    for k, plate in enumerate(plates):
        others = [outline_samples(other) for i, other in enumerate(plates) if i != k]
        grids.append(_grid(plate, np.concatenate([bars, *others]), float(skin_depths[k]), fineness[k]))
    half, (nodes, weights) = np.pi / around, np.polynomial.legendre.leggauss(8)  # mean ln r is the circle's
    turn = 2 * np.pi * (np.arange(around) + 0.5) / around
    corner = float(radius * np.exp(weights / 2 @ np.log(np.cos(half * nodes)) - np.log(np.cos(half))))
    circle = centre + corner * np.exp(1j * turn)
    holes = [_rim(grid) for grid in grids]
    air = fill_between(_pairs(circle), [_pairs(grid[rim]) for grid, rim in zip(grids, holes, strict=True)])
    return _joined(grids, holes, air, (centre, radius, around))


def _outer_circle(plates: tuple[PlateSection, ...], around: float, ground: float | None) -> tuple[complex, float, int]:
    """Return the centre and radius of the circle, and its number of edges."""
    corners = np.concatenate([plate.corners for plate in plates])
    if ground is None:
        centre = complex((corners.real.min() + corners.real.max()) / 2, (corners.imag.min() + corners.imag.max()) / 2)
        return centre, 5.0 * float(np.abs(corners - centre).max()), int(around)
    reach = float(np.abs(corners).max())
    if reach >= ground:
        raise ValueError(
            f"target.planar_boundary_radius: must enclose every plate (reach {mm(reach)}), got {mm(ground)}"
        )
    radius = min(5.0 * reach, float(np.sqrt(reach * ground)))
    return 0j, radius, min(600, int(around * max(1.0, radius / (radius - reach) / 1.25)))


def outline_samples(plate: PlateSection) -> Complex:
    """Return points along a plate's outline."""
    sides = np.concatenate([plate.corners, plate.corners[:1]])
    steps = np.linspace(0.0, 1.0, 200)
    return np.concatenate([a + (b - a) * steps for a, b in zip(sides[:-1], sides[1:], strict=True)])


def _grid(plate: PlateSection, sources: Complex, skin_depth: float, fineness: Fineness) -> Complex:
    """Return places of the tensor nodes, shape (along, up)."""
    first = min(fineness.skin * skin_depth, fineness.edge * plate.thickness)
    first = max(first, _SMALLEST * max(plate.width, plate.thickness))
    local = (sources - plate.bottom) * np.exp(1j * plate.alpha)
    xi, eta = local.real + plate.width / 2, local.imag

    def size(s: Array, length: float, same: Array, away: Array) -> Array:
        distance = np.hypot(s[:, None] - same, away).min(axis=1)
        ends = first + fineness.growth * np.minimum(s, length - s)
        return np.asarray(np.minimum(np.minimum(ends, fineness.share * length), fineness.near * distance))

    above = np.maximum(np.maximum(-eta, eta - plate.thickness), 0.0)
    beyond = np.maximum(np.maximum(-xi, xi - plate.width), 0.0)
    along = graded_nodes(plate.width, lambda s: size(s, plate.width, xi, above), first)
    up = graded_nodes(plate.thickness, lambda s: size(s, plate.thickness, eta, beyond), first)
    return plate.placed(along[:, None] - plate.width / 2 + 1j * up)


def graded_nodes(length: float, size: Callable[[Array], Array], first: float) -> Array:
    """Return nodes of [0, length] whose spacing follows `size`; both ends included."""
    inner = np.geomspace(min(first / 4, 5e-3 * length), length / 2, 400)
    half = np.unique(np.concatenate([[0.0], inner, np.linspace(0.0, length / 2, 800)]))
    samples = np.concatenate([half, length - half[-2::-1]])
    count = integrals(1.0 / size(samples), samples)
    nodes = np.interp(np.linspace(0.0, count[-1], max(2, int(np.ceil(count[-1]))) + 1), count, samples)
    nodes[[0, -1]] = 0.0, length
    return np.asarray(nodes)


def _rim(grid: Complex) -> tuple[Integers, Integers]:
    """Return indices of a grid's outline, counter-clockwise."""
    n, m = grid.shape
    i = np.concatenate([np.arange(n - 1), np.full(m - 1, n - 1), np.arange(n - 1, 0, -1), np.zeros(m - 1, dtype=int)])
    j = np.concatenate([np.zeros(n - 1, dtype=int), np.arange(m - 1), np.full(n - 1, m - 1), np.arange(m - 1, 0, -1)])
    return i, j


def _pairs(places: Complex) -> Array:
    """Return complex places as rows x, z."""
    return np.column_stack([places.real, places.imag])


def _tensor_triangles(number: Integers) -> Integers:
    """Return two triangles a cell, the diagonals mirrored about the grid's middle; shape (m, 3)."""
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    i, j = np.indices(a.shape)
    rising = (i < a.shape[0] / 2) == (j < a.shape[1] / 2)
    first = np.where(rising[..., None], np.stack([a, b, c], -1), np.stack([a, b, d], -1))
    second = np.where(rising[..., None], np.stack([a, c, d], -1), np.stack([b, c, d], -1))
    return np.concatenate([first.reshape(-1, 3), second.reshape(-1, 3)])


def _joined(
    grids: list[Complex], rims: list[tuple[Integers, Integers]], air: tuple[Array, Integers],
    circle: tuple[complex, float, int],
) -> DividedPlane:
    """Number the plates' inner nodes after the air's and join all triangles."""
    points, triangles = [air[0]], [air[1]]
    part = [np.zeros(len(air[1]), dtype=np.int64)]
    start, total = circle[2], len(air[0])
    for k, (grid, rim) in enumerate(zip(grids, rims, strict=True)):
        number = np.full(grid.shape, -1)
        number[rim] = start + np.arange(len(rim[0]))
        start += len(rim[0])
        inner = number < 0
        number[inner] = total + np.arange(inner.sum())
        total += int(inner.sum())
        points.append(_pairs(grid[inner]))
        triangles.append(_tensor_triangles(number))
        part.append(np.full(len(triangles[-1]), k + 1))
    mesh = MeshTri(np.ascontiguousarray(np.vstack(points).T), np.ascontiguousarray(np.vstack(triangles).T))
    return DividedPlane(mesh, np.concatenate(part), circle[0], circle[1])
