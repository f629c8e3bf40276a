"""Evaluate the coils' potential at every cell of a plate, in poses or at rest.

A plate needs the mean of each coil's A over each cell; of a coil c, with the divergence-free currents w of a mode,

    g_c = integral over the plate of w . A_c dV.

A_c is taken at Gauss points of each cell: two along an axis where the windings are twice as far away as a cell is long,
and one more for each doubling of the cell. Cells of a foil that are nine gaps long are 6e-6 of A off; one point less,
and five at most, leave 5e-5, of which extrapolation makes 2e-4 of R and 6e-4 of L. Through the thickness of a plate in
its poses A is a polynomial, of few terms; at a height z above its bottom face the windings are z further away (z cos of
its tilt), and points are as many as that asks. Over a plate that stands still rings have the profile P(rho) on each
sheet's heights (see `coils.ring_field`), found once and interpolated by cubic splines; spirals, and rings over a plate
at an angle, are summed at every point.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from sits_mech.geometry.sheet_plan import CellPlan
from sits_mech.geometry.windings import kinds_of
from sits_mech.magnetics.coils.ring_field import STEP, level_potential, winding_potential
from sits_mech.magnetics.coils.straight import CACHED
from sits_mech.magnetics.space.fields import (
    Box,
    Prisms,
    chebyshev_points,
    chebyshev_values,
    gauss_points,
    to_coefficients,
)
from sits_mech.magnetics.space.lift import Lift
from sits_mech.quantities import Array, Integers
from sits_mech.scene.sensor import Coil

_MOST = 7  # Gauss points along an axis
_WITHIN = 6  # Gauss points through a sheet, for means of its polynomials: exact to the 11th order


@dataclass(frozen=True)
class Sources:
    """Coils as a plate at rest sees them."""

    coils: tuple[Coil, ...]
    windings: str  # "rings" or "spiral"
    place: tuple[float, float, float]  # of the plate's middle [m]
    distance: float  # from the windings to the plate [m]
    axes: tuple[tuple[float, ...], ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))  # its rotation, by rows

    def means(self, plan: CellPlan, prisms: Prisms) -> Array:
        """Return the mean of each coil's A over the images of n prisms, shape (3, g, 2, n, coils) [V s / (A m)].

        The plan's group moves the cells; the prisms are the upper half's.
        """
        counts = self._counts(plan, prisms)
        flips = np.array([[1.0, 1.0, s] for s in (1.0, -1.0)])
        found = np.empty((3, len(plan.group), 2, len(counts), len(self.coils)))
        for count in np.unique(counts).tolist():
            some = counts == count
            points, weights = gauss_points(prisms.some(some), count)
            moved = np.stack([np.concatenate([points[..., :2] @ g.T, points[..., 2:]], axis=-1) for g in plan.group])
            images = moved[:, None] * flips[:, None, None, :]
            A = self.potential(images.reshape(-1, 3)).reshape(*images.shape, -1)
            found[:, :, :, some] = np.einsum("gsnqac,nq->agsnc", A, weights, optimize=True)
        return found

    def points(self, plan: CellPlan, prisms: Prisms) -> int:
        """Return at how many points `means` takes the coils' potential."""
        return int(len(plan.group) * 2 * (2 * self._counts(plan, prisms) ** 2).sum())

    def _counts(self, plan: CellPlan, prisms: Prisms) -> Integers:
        """Gauss points along an axis of each cell."""
        sides = (prisms.corners.max(1) - prisms.corners.min(1)).max(axis=1)
        away = np.maximum(self._away(plan, prisms) - sides, self.distance)
        return _count(sides, away)

    def _away(self, plan: CellPlan, prisms: Prisms) -> Array:
        """Return each cell's distance, or its images', from the nearest circle around a coil, in the plan [m]."""
        turn = np.array(self.axes)[:2, :2]
        middle = np.stack([prisms.corners.mean(axis=1) @ g.T for g in plan.group]) @ turn.T + self.place[:2]
        apart = [np.linalg.norm(middle - coil.centre, axis=-1) - coil.outer_diameter / 2 for coil in self.coils]
        return np.asarray(np.min(apart, axis=(0, 1)))

    def potential(self, points: Array) -> Array:
        """Return each coil's A at points (m, 3) from the plate's middle, shape (m, 3, coils) [V s / (A m)]."""
        (kinds, which), turn = kinds_of(self.coils), np.array(self.axes)
        A, level = np.zeros((len(points), 3, len(self.coils))), np.array_equal(turn, np.eye(3))
        world = points if level else points @ turn.T
        for k, (kind, coil) in enumerate(zip(which, self.coils, strict=True)):
            placed = world + self.place - np.array((*coil.centre, 0.0))
            A[..., k] = level_potential(kinds[kind], self.windings, placed, self.distance)
        return A if level else np.einsum("ji,mjc->mic", turn, A)


@dataclass(frozen=True)
class Posed:
    """Coils as a plate sees them in p poses."""

    coils: tuple[Coil, ...]
    windings: str  # "rings" or "spiral"
    turns: Array  # (p, 3, 3) rotations
    places: Array  # (p, 3) of the bottom face's centre [m]
    step: float = STEP  # of tables of the coils' field, in distances to the windings
    lift: Lift | None = None  # of a plate that bends

    def some(self, poses: slice) -> Posed:
        """Return it in some of the poses."""
        lift = None if self.lift is None else self.lift.some(poses)
        return replace(self, turns=self.turns[poses], places=self.places[poses], lift=lift)

    @cached_property
    def mirrored(self) -> bool:
        """Whether the plate's plane of x and z is one of symmetry for each coil, but for the way of its current."""
        level = np.array([coil.centre[1] for coil in self.coils]) == self.places[:, 1:2]
        round_ = self.windings == "rings" and all(coil.is_round for coil in self.coils)
        steady = (np.stack([self.turns[:, 1], self.turns[:, :, 1]]) == (0.0, 1.0, 0.0)).all()
        return bool(round_ and steady and level.all() and self.lift is None)

    def potentials(self, points: Array, clearance: float) -> Iterator[Array]:
        """Yield A of each coil at points (q, 3) from the bottom face's centre, (p, c, q) as of `winding_potential`."""
        kinds, which = kinds_of(self.coils)
        lifted = None if self.lift is None else self.lift.at(points)
        world = self.turns @ (points.T if lifted is None else lifted.places) + self.places[:, :, None]
        centres = np.array([(*coil.centre, 0.0) for coil in self.coils])
        aside = max(float(np.linalg.norm(np.abs(world[:, :2] - c[:2, None]).max(axis=(0, 2)))) for c in centres)
        region = clearance, float(world[:, 2].max()), aside
        fields = [winding_potential(kind, self.windings, region, len(points), self.step) for kind in kinds]
        for kind, centre in zip(which, centres, strict=True):
            A = fields[kind](world - centre[:, None])
            yield A if lifted is None else self.turns @ lifted.met(self.turned_back(A))

    def turned_back(self, A: Array) -> Array:
        """Return A as of `potentials` in the plate's own axes, (p, 3, q)."""
        return np.swapaxes(self.turns[:, : A.shape[1]], 1, 2) @ A


@dataclass(frozen=True, eq=False)
class PlateCells:
    """A plate's cells, for the potential of coils in its poses."""

    plan: CellPlan
    levels: Array  # (l + 1,) z of the sheets' interfaces from the middle plane up [m]
    box: Box  # of its clearance from the coils, and the order of polynomials through its thickness

    @cached_property
    def size(self) -> float:
        """Root of the largest cell's area [m]."""
        x, y = self.plan.nodes[self.plan.cells].T
        return float(np.sqrt(np.abs((x[2] - x[0]) * (y[3] - y[1]) - (x[3] - x[1]) * (y[2] - y[0])).max() / 2))

    @cached_property
    def points(self) -> tuple[Array, Array, Integers]:
        """Return points (g, q, 3) of the cells' images on the polynomials' heights, weights (q,), first ones (n k,).

        Points are from the bottom face's centre [m], cell after cell, of each height after height; weights are of those
        along the plate. As many as each height's distance asks.
        """
        corners = self.plan.nodes[self.plan.cells]
        sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        z = self.box.half[2] * (1.0 + chebyshev_points(self.box.order[2]))
        own = np.maximum(sides[:, :2], sides[:, 2:])[:, None]
        counts = _count(own, (self.box.clearance + z)[:, None]).reshape(-1, 2)
        height = np.tile(z, len(corners))
        flat = Prisms(np.repeat(corners, z.size, axis=0), height, height)
        each, cells = list[tuple[Array, Array]](), list[Integers]()
        for one, other in np.unique(counts, axis=0).tolist():
            some = np.flatnonzero((counts == (one, other)).all(axis=1))
            points, weights = gauss_points(flat.some(some), one, other, through=1)
            each.append((points.reshape(-1, 3), weights.ravel()))
            cells.append(np.repeat(some, one * other))
        by_cell = np.argsort(np.concatenate(cells), kind="stable")
        points, weights = (np.concatenate(parts)[by_cell] for parts in zip(*each, strict=True))
        images = np.stack([np.column_stack([points[:, :2] @ g.T, points[:, 2]]) for g in self.plan.group])
        return images, weights, np.cumsum(counts.prod(axis=1)) - counts.prod(axis=1)

    @cached_property
    def middles(self) -> Array:
        """Middles of the cells' images, (g times 2 times n, 3), from the bottom face's centre [m]."""
        along = self.plan.nodes[self.plan.cells].mean(axis=1)
        z = (self.levels[1:] + self.levels[:-1]) / 2
        flat = np.stack([np.repeat(along @ g.T, z.size, axis=0) for g in self.plan.group])[:, None]
        height = np.tile(z, len(along)) * np.array([1.0, -1.0])[:, None] + self.box.half[2]
        whole = *flat.shape[:1], 2, *flat.shape[2:3]
        places = np.broadcast_to(flat, (*whole, 2)), np.broadcast_to(height[..., None], (*whole, 1))
        return np.concatenate(places, axis=-1).reshape(-1, 3)

    @cached_property
    def through(self) -> Array:
        """Matrix from values on the heights to means over the sheets of the upper and the lower half, (2, l, k)."""
        nodes, weights = np.polynomial.legendre.leggauss(_WITHIN)
        middle, half = (self.levels[1:] + self.levels[:-1]) / 2, np.diff(self.levels) / 2
        z = (middle[:, None] + half[:, None] * nodes) / self.box.half[2]
        order = self.box.order[2]
        T = chebyshev_values(np.stack([z, -z]), order)
        return np.asarray(np.einsum("slqk,q->slk", T, weights / 2) @ to_coefficients(order))

    def along(self, seen: Posed) -> Array:
        """Return means of A along the plate on the polynomials' heights, (poses, coils, 3, g, n, k), of any sheets.

        Half of a rectangle's images, by -y, see the others' A turned over where coils are mirrored too.
        """
        points, weights, first = self.points
        g, half = len(points), seen.mirrored and self.plan.tensor is not None
        points = points[: g // 2] if half else points
        found = np.empty((len(seen.places), len(seen.coils), 3, g, len(self.plan.cells), self.box.order[2]))
        step = max(1, CACHED // points.size)
        for start in range(0, len(seen.places), step):
            own, part = seen.some(slice(start, start + step)), found[start : start + step, :, :, : len(points)]
            for c, A in enumerate(own.potentials(points.reshape(-1, 3), self.box.clearance)):
                weighted = A.reshape(*A.shape[:2], *points.shape[:2]) * weights
                sums = np.add.reduceat(weighted, first, axis=3).reshape(*A.shape[:2], -1)
                part[:, c] = own.turned_back(sums).reshape(part[:, c].shape)
        if half:
            found[:, :, :, g // 2 :] = found[:, :, :, : g // 2] * np.reshape((-1.0, 1.0, -1.0), (3, 1, 1, 1))
        return found

    def means(self, along: Array) -> Array:
        """Return means over each cell's images of what is known along it, (3, g, 2, cells, poses times coils)."""
        p, c, _, g, n, _ = along.shape
        found = along @ np.concatenate(self.through).T
        found = found.reshape(p * c, 3, g, n, 2, -1).transpose(1, 2, 4, 3, 5, 0)
        return np.ascontiguousarray(found).reshape(3, g, 2, -1, p * c)


def _count(sides: Array, away: Array | float) -> Integers:
    """Return how many Gauss points along an axis cells of some sides take, a way off the windings."""
    return np.asarray(np.minimum(2 + np.ceil(np.log2(np.maximum(2.0 * sides / away, 1.0))).astype(int), _MOST))


def farthest_winding(coils: Sequence[Coil], seen: Sources | None) -> float:
    """Return how far the farthest winding is from a plate's middle along its x or y [m]; of a target that at rest."""
    turn, middle = (np.eye(3), np.zeros(3)) if seen is None else (np.array(seen.axes), np.array(seen.place))
    away = [np.abs((np.array((*coil.centre, 0.0)) - middle) @ turn)[:2].max() for coil in coils]
    return float(max(own + coil.outer_diameter / 2 for own, coil in zip(away, coils, strict=True)))
