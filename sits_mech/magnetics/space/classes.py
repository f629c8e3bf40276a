"""The matrices of one symmetry class of a plate: what its loops' currents cost, and what drives them.

    L_ab = mu0 / (4 pi) << w_a, w_b / |r - r'| >>,    R_ab = <w_a, w_b> / sigma,    g_a = <w_a, A>,

w the divergence-free currents of `loops`, over all images of the fundamental part by the plate's symmetries, each with
the class's character. A loop's moment in each cell meets the mean of 1/r between cells (`prisms`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.constants import mu_0
from scipy.linalg import hadamard

from sits_mech.geometry.sheet_plan import CellPlan
from sits_mech.magnetics.space.boxes import box_means
from sits_mech.magnetics.space.fields import Prisms
from sits_mech.magnetics.space.loops import Loops, plan_sums
from sits_mech.magnetics.space.prisms import FEW, MANY, prism_means, prism_seconds
from sits_mech.quantities import Array, Complex


@dataclass(frozen=True)
class Problem:
    """A class with its loops."""

    plan: CellPlan
    loops: Loops
    character: Complex
    mirror: int
    weight: float

    @cached_property
    def parts(self) -> tuple[list[tuple[int, int]], Any, list[Any]]:
        """Which components act on which, the images' weights of each pair, the moments; real if the character is."""
        real = not np.iscomplex(self.character).any()
        factors: Any = self.factors().real if real else self.factors()
        pairs = [(a, b) for a, b in np.ndindex(3, 3) if factors[:, :, a, b].any()]
        weights = np.stack([factors[:, :, a, b].ravel() for a, b in pairs])
        return pairs, weights, [m.real if real else m for m in self.loops.moments]

    @cached_property
    def transposed(self) -> list[Any]:
        """The moments' transposes, which take A to fluxes."""
        return [m.T.tocsr() for m in self.parts[2]]

    @cached_property
    def losses(self) -> Any:
        """R times the conductivity, sparse; real if the character is."""
        weighted = [(m.T.conj().multiply(1.0 / self.loops.volume)) @ m for m in self.parts[2]]
        uneven = self.loops.uneven if np.iscomplexobj(self.parts[1]) else self.loops.uneven.real
        return (sum(weighted) + uneven.conj().T @ uneven) * self.parts[1].shape[1]

    def factors(self) -> Complex:
        """Return the factor and matrix of each image: chi(g) s (g with z -> s z), shape (g, 2, 3, 3)."""
        result = np.zeros((self.plan.group.shape[0], 2, 3, 3), dtype=complex)
        for s in (0, 1):
            flip = self.mirror if s else 1
            result[:, s, :2, :2] = flip * self.character[:, None, None] * self.plan.group
            result[:, s, 2, 2] = flip * self.character * (-1.0 if s else 1.0)
        return result


def problems(plan: CellPlan, levels: Array, depth: float) -> Iterator[tuple[tuple[int, int], Problem]]:
    """Return the classes of a plate with currents, by order and mirror; `levels`, `depth` as of `prepare_sheets`."""
    sums = plan_sums(plan, depth)
    for order, (character, weight) in enumerate(zip(plan.characters, plan.weights, strict=True)):
        flows = sums.flows(character)
        for mirror in (1, -1):
            loops = flows.loops(np.diff(levels), mirror)
            if loops.unknowns > 0:
                yield (order, mirror), Problem(plan, loops, character, mirror, weight)


def first_alike(divisions: Sequence[tuple[CellPlan, Array]]) -> list[int]:
    """Return for each division which is the first that is the same."""
    return [
        next(i for i, (other, z) in enumerate(divisions) if other is plan and np.array_equal(z, levels))
        for plan, levels in divisions
    ]


def stacked(plan: CellPlan, levels: Array) -> Prisms:
    """Return the upper half's cells, sheet fastest."""
    count = levels.size - 1
    cells = plan.cells.shape[0]
    corners = np.repeat(plan.nodes[plan.cells], count, axis=0)
    return Prisms(corners, np.tile(levels[:-1], cells), np.tile(levels[1:], cells))


def kernel(plan: CellPlan, levels: Array, prisms: Prisms) -> Array:
    """Return the mean 1/r from each cell to each cell's images, (g, 2, n, n); of a rectangle, by `image_classes`."""
    if plan.tensor is not None:
        boxes = box_means(*plan.tensor, levels)
        for axis in range(3):
            one, other = np.moveaxis(boxes, axis, 0)
            one += other
            other *= -2.0
            other += one
        n = boxes.shape[-1]
        return boxes.transpose(1, 0, 2, 3, 4).reshape(4, 2, n, n)
    n, g, (points, symmetric) = prisms.low.size, len(plan.group), _way(plan)
    found = prism_means(prisms, _images(plan, prisms), points=points, symmetric=symmetric)
    found = found.reshape(n, -1, 2, n).transpose(1, 2, 0, 3)
    return np.ascontiguousarray(found[[min(k, g - k) if symmetric else k for k in range(g)]])


def kernel_seconds(plan: CellPlan, levels: Array) -> float:
    """Return about what `kernel` takes of prisms; that of boxes is little [s]."""
    if plan.tensor is not None:
        return 0.0
    prisms, (points, symmetric) = stacked(plan, levels), _way(plan)
    return prism_seconds(prisms, _images(plan, prisms), points) / (1.0 + symmetric)


def _way(plan: CellPlan) -> tuple[int, bool]:
    """Return Gauss points of near prisms, and whether what two cells have with each other's images is symmetric.

    It is for a whole outline, and where each cell of a disc's sector is its own mirror image in the sector's axis, x:
    to turn it either way is the same then.
    """
    if len(plan.group) == 1:
        return FEW, True
    corners = plan.nodes[plan.cells]
    apart = corners[:, :, None] * (1.0, -1.0) - corners[:, None]
    return MANY, bool(np.abs(apart).max(axis=3).min(axis=2).max() <= 1e-12 * np.abs(plan.nodes).max())


def _images(plan: CellPlan, prisms: Prisms) -> Prisms:
    """Return prisms' images by a plan's turns, up to half of them where that is all, each and then its mirror image."""
    turns = plan.group[: len(plan.group) // 2 + 1] if _way(plan)[1] else plan.group
    corners = prisms.corners @ np.repeat(np.swapaxes(turns, 1, 2), 2, axis=0)[:, None]
    ends = np.stack([(prisms.low, prisms.high), (-prisms.high, -prisms.low)], axis=1)
    low, high = np.tile(ends.reshape(2, -1), len(turns))
    return Prisms(corners.reshape(-1, 4, 2), low, high)


def scaled(problem: Problem, means: Array, conductivity: float) -> tuple[Complex, Complex, Array]:
    """Return L and R of one class on unknowns of like resistance, real if its character is, and the unit of each."""
    loops = problem.loops
    pairs, weights, _ = problem.parts
    back = [m.conj() for m in problem.transposed]
    turned: Any = np.zeros((loops.unknowns, loops.unknowns), dtype=weights.dtype)  # L transposed, not yet Hermitian
    if problem.plan.tensor is not None:
        sums = [(sign, means[k]) for k, sign in image_classes(weights)]
    else:
        sums = [(1.0, G) for G in mixed(weights, means)]
    for (a, b), (sign, G) in zip(pairs, sums, strict=True):
        turned += problem.transposed[b] @ ((sign * back[a]) @ G).T
    L = turned.T + turned.conj()
    L *= weights.shape[1] * mu_0 / (8 * np.pi)
    R = problem.losses.toarray() / conductivity
    unit = 1.0 / np.sqrt(np.real(np.diag(R)))
    for matrix in (L, R):
        matrix *= unit[:, None]
        matrix *= unit
    return L, R, unit


def driven(problem: Problem, driving: Array) -> Complex:
    """Return fluxes of coils in one class, from their A in its images (3, g, 2, n, c); (c, unknowns)."""
    pairs, weights, _ = problem.parts
    found: Any = 0.0
    for a in range(3):
        some = [k for k, pair in enumerate(pairs) if pair[0] == a]
        for k, P in zip(some, mixed(weights[some], driving[a]) if some else (), strict=True):
            found = found + problem.transposed[pairs[k][1]] @ P
    return np.asarray(found.T)


def image_moments(problem: Problem, ways: Sequence[Complex]) -> Complex:
    """Return the moments in all images of a class's cells of currents (unknowns, m), (m, q, 3).

    Those of the conjugate class follow, where it is complex.
    """
    loops, factors, total = problem.parts[2], problem.factors(), np.zeros(1, dtype=complex)
    for back, currents in enumerate(ways):
        each = [(m.conj() if back else m) @ currents for m in loops]
        total = total + np.einsum("gsab,bcm->mgsca", factors.conj() if back else factors, each)
    return total.reshape(ways[0].shape[1], -1, 3)


def image_classes(weights: Array) -> list[tuple[tuple[int, int], float]]:
    """Return which sum of a rectangle's eight images rows of weights are, and its factor.

    In each class of its mirror planes the images' signs are a row of Hadamard's matrix.
    """
    shares = weights @ hadamard(8) / 8.0
    index = np.argmax(np.abs(shares), axis=1)
    return [(divmod(k, 2), float(row[k])) for k, row in zip(index.tolist(), shares, strict=True)]


def mixed(weights: Any, images: Array) -> Any:
    """Return sums of the images' arrays, one a row of weights, real if these are; one product reads them once."""
    rows = np.vstack([weights.real, weights.imag]) if np.iscomplexobj(weights) else weights
    sums = (rows @ images.reshape(weights.shape[1], -1)).reshape(-1, *images.shape[2:])
    return sums[: len(weights)] + 1j * sums[len(weights) :] if np.iscomplexobj(weights) else sums
