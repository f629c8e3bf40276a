"""Answer of a fixed permeable plate that does not conduct to the coils, and to the currents around it.

Magnetisation M [A/m], uniform in each box of a tensor mesh, with the susceptibility chi = mu_r (1 - j tan delta) - 1:

    (V/chi + K) M = integral of H_applied over the boxes,      K from the charges on their faces (`boxes`).

A is what plates see (`space.neighbours`), H = curl A / mu0, so that for field functions T with coefficients a

    G_T = integral of curl T over each box,    M = (V/chi + K)^-1 G a / mu0,    s = G^T M = Y a / (j omega),
    Y = (j omega / mu0) G^T (V/chi + K)^-1 G,    Delta Z = a^T Y a:

L rises; tan delta makes R. s are the moments of the bound currents curl M, as eddy currents have them. curl T of the
box's polynomials is integrated exactly; of the coils' own potential as n x A over the boxes' faces at Gauss points.

The plate's three mirror planes split the problem into eight classes, ``M(g x) = chi_g g M(x)``; a product
T_i T_j T_k e_a belongs to one of them. Three divisions, boxes whole, halved and in three, have errors of second order
and, from edges and faces, of an order a little higher, as measured: what the third level changes in the extrapolation
S takes by 0.45 of it more, with an estimated error of 0.2 of it; blocks, thicker than twice the length on which fields
change, nothing more, with 0.7 of it. How many boxes the first has along the sides is the tolerance's: behind one of the
published coils true errors are 0.1 to 1 of the estimates, against finite elements.

Range: plates at rest with sides along the axes, linear, isotropic, without eddies of their own (skin depth above the
thickness). Neglected: displacement current, that is dimensional resonance of very permeable ferrites.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
from scipy.constants import mu_0
from scipy.linalg import eigh, solve

from sits_mech.magnetics.space.boxes import PAIRS, box_charges
from sits_mech.magnetics.space.divisions import field_box, field_length
from sits_mech.magnetics.space.fields import Basis, Blocks, Box, decay_scale, side_by_side
from sits_mech.magnetics.space.rungs import Rung
from sits_mech.magnetics.space.sources import Sources
from sits_mech.quantities import Array, Complex, Integers, tensor_grid
from sits_mech.scene.sensor import Coil, Conductor, Target

_KEEP = 5e-5  # weaker combinations of fields are left out: their energy, to the strongest, is the square
_CURL = [(b, d, a, 1.0) for b, d, a in ((0, 1, 2), (1, 2, 0), (2, 0, 1))]
_CURL += [(b, d, a, -1.0) for b, a, d in ((0, 1, 2), (1, 2, 0), (2, 0, 1))]  # curl_b = sign d_d A_a
_FEW = 3  # boxes along the longer half side of a plate far away
_GAUSS = 2  # points along each side of a face
_ALONG = {"plate": 4, "block": 3}  # coarse boxes along the longer half side, at `_MIDDLE`
_MIDDLE, _FINER = 8.0, (0.75, 1.5)  # digits of a rung; boxes over those, at least and at most
_PER_DIGIT = 0.35  # growth of their number, by the digits
_GRADING = 1.2  # power of their distances from the rim
_BLOCK = 2.0  # thickness over the length on which the coils' field changes: graded boxes across
_ACROSS = (0.0, 0.6, 1.0)  # nodes of a block over its half thickness
_NEXT = {"plate": (0.45, 0.2), "block": (0.0, 0.7)}
"""Of what the third level changes in the extrapolation: what is added, and the estimated error."""


@dataclass(frozen=True, eq=False)
class Core:
    """A permeable plate, ready to answer."""

    box: Box  # of its fields
    bases: tuple[Basis, ...]  # combinations of fields, one a symmetry class
    unknowns: int  # of the discrete problem
    sheets: int  # boxes through the thickness
    response: Complex  # (r + n, r + n) Y / (j omega) of combinations, then n coils, symmetric [A^2 / J]

    def admittance(self, omega: float) -> Blocks:
        """Return Y; omega [rad/s]."""
        return Blocks(len(self.response), ((np.arange(len(self.response)), 1j * omega * self.response),))


@lru_cache(maxsize=32)
def prepared_core(
    plate: Target, susceptibility: complex, rung: Rung, clearance: float, sources: Sources
) -> tuple[Core, Core]:
    """Return a permeable rectangle's answer from three divisions: S extrapolated, and off by its estimated error.

    `clearance` is from other plates [m]; the rung gives the digits that fields keep, and the number of boxes along the
    sides.
    """
    half = np.array([*plate.extent, plate.thickness]) / 2
    length = min(field_length(coil, sources.distance + half[2]) for coil in sources.coils)
    kind = "plate" if plate.thickness < _BLOCK * length else "block"
    finer = np.clip(np.exp(_PER_DIGIT * (rung.terms - _MIDDLE)), *_FINER)
    longest = round(_ALONG[kind] * float(finer))
    counts = np.maximum(np.ceil(longest * half[:2] / half[:2].max()), 2).astype(int)
    x, y = (side * (1.0 - (1.0 - np.arange(n + 1) / n) ** _GRADING) for side, n in zip(half, counts, strict=False))
    z = half[2] * np.array(_ACROSS if kind == "block" else (0.0, 1.0))
    divisions = [(halved(x, n), halved(y, n), halved(z, n)) for n in (3, 2, 1)]
    box = field_box(plate, None, clearance, rung)
    third, second, first_level = prepare_core(divisions, susceptibility, box, sources)
    best = third.response + 0.8 * (third.response - second.response)
    change = best - second.response - (second.response - first_level.response) / 3
    best, error = best + _NEXT[kind][0] * change, _NEXT[kind][1] * change
    return replace(third, response=best), replace(third, response=best - error)


def prepare_core(
    divisions: Sequence[tuple[Array, Array, Array]], susceptibility: complex, box: Box, sources: Sources
) -> tuple[Core, ...]:
    """Find what a plate of susceptibility chi answers on several divisions, nodes of the half axes from the middle [m].

    The finest comes first; its combinations of fields serve for all.
    """
    bases: list[Basis] = []
    found = []
    inverse: Any = 1.0 / (susceptibility if susceptibility.imag else susceptibility.real)
    for axes in divisions:
        K, volume = box_charges(*axes), _volumes(axes)
        own, blocks, first = _coil_curls(axes, sources), [], not bases
        for k, parity in enumerate(product((1, -1), repeat=3)):
            A = _class_matrix(K, volume * inverse, parity)
            rows, G = _polynomial_curls(axes, box, parity)
            driven = _folded(own, parity)
            if first:
                bases.append(_strongest(A, G, rows, decay_scale(box)[rows]))
            basis = bases[k]
            size = decay_scale(box)[basis.rows, None]
            whole = np.vstack([(basis.fields * size).T @ (G[np.searchsorted(rows, basis.rows)] * size), driven])
            blocks.append(whole @ solve(A, whole.T, assume_a="sym") / (8.0 * mu_0))
        count = len(sources.coils)
        found.append(Core(box, tuple(bases), 24 * volume.size, 2 * (axes[2].size - 1), _joined(blocks, count)))
    return tuple(found)


def added_inductance(plate: Target | Conductor, coils: tuple[Coil, ...], middle: tuple[float, float, float]) -> Array:
    """Return what a plate of unbounded permeability, or a rectangle around it, adds to each self-inductance [H].

    With few even boxes: 1 to 5 % less than finer ones, of plates no nearer to the coils than they are wide.
    """
    half = np.array([*plate.extent, plate.thickness]) / 2
    counts = np.maximum(np.ceil(_FEW * half[:2] / half[:2].max()), 1).astype(int)
    axes = [side * np.linspace(0.0, 1.0, n + 1) for side, n in zip(half, (*counts, 1), strict=True)]
    K, own = box_charges(*axes), _coil_curls(axes, Sources(coils, "rings", middle, float(half.max())))
    found, none = np.zeros(len(coils)), np.zeros(_volumes(axes).size)
    for parity in product((1, -1), repeat=3):
        driven = _folded(own, parity)
        found += np.einsum("cn,nc->c", driven, solve(_class_matrix(K, none, parity), driven.T, assume_a="sym"))
    return found / (8.0 * mu_0)


def halved(nodes: Array, parts: int) -> Array:
    """Return nodes with every interval divided in equal parts."""
    at = np.arange(parts * (nodes.size - 1) + 1) / parts
    return np.interp(at, np.arange(nodes.size), nodes)


def _volumes(axes: Sequence[Array]) -> Array:
    """Return the volumes of the octant's boxes, z fastest [m^3]."""
    x, y, z = (np.diff(axis) for axis in axes)
    return (x[:, None, None] * y[:, None] * z).ravel()


def _class_matrix(K: Array, inverse: Any, parity: tuple[int, ...]) -> Complex:
    """Return V/chi + K of one class on the octant's boxes, component first."""
    n = inverse.size
    A = np.zeros((3, n, 3, n), dtype=inverse.dtype)
    for (a, b), images in zip(PAIRS, K, strict=True):
        for first, second in {(a, b), (b, a)}:
            for octant in np.ndindex(2, 2, 2):
                signs = [-1 if mirrored else 1 for mirrored in octant]
                character = np.prod([p for p, mirrored in zip(parity, octant, strict=True) if mirrored])
                A[first, :, second] += character * signs[second] * images[octant]
    whole = A.reshape(3 * n, 3 * n)
    whole = (whole + whole.T) / 2
    whole[np.arange(3 * n), np.arange(3 * n)] += np.tile(inverse, 3)
    return np.asarray(whole)


def _polynomial_curls(axes: Sequence[Array], box: Box, parity: tuple[int, ...]) -> tuple[Integers, Array]:
    """Return which coefficients a class sees, and the integrals of their curl over all eight images."""
    steps, means = zip(*(_along(axis / half, n) for axis, half, n in zip(axes, box.half, box.order, strict=True)),
                       strict=True)
    n = [axis.size - 1 for axis in axes]
    whole = np.zeros((3, *box.order, 3, *n))
    for b, d, a, sign in _CURL:
        factors = [steps[k] if k == d else means[k] * box.half[k] for k in range(3)]
        whole[a, :, :, :, b] += 8.0 * sign * np.einsum("ix,jy,kz->ijkxyz", *factors)
    fits = np.ones((3, *box.order), dtype=bool)
    for a, e in np.ndindex(3, 3):
        odd = parity[e] * (1 if e == a else -1) < 0
        fits[a] &= np.expand_dims(np.arange(box.order[e]) % 2 == odd, [k for k in range(3) if k != e])
    rows = np.flatnonzero(fits)
    return rows, whole.reshape(fits.size, -1)[rows]


def _along(nodes: Array, order: int) -> tuple[Array, Array]:
    """Return differences and integrals of T_0 ... between nodes of [-1, 1], shape (order, n)."""
    k = np.arange(order + 1)
    T = np.cos(k[:, None] * np.arccos(np.clip(nodes, -1.0, 1.0)))
    integral = np.empty((order, nodes.size))
    integral[0] = nodes
    if order > 1:
        integral[1] = nodes**2 / 2
    for i in range(2, order):
        integral[i] = T[i + 1] / (2 * (i + 1)) - T[i - 1] / (2 * (i - 1))
    return np.diff(T[:order], axis=1), np.diff(integral, axis=1)


def _coil_curls(axes: Sequence[Array], sources: Sources) -> Array:
    """Return integrals of curl A of each coil over all boxes of all octants, shape (3, 2 n_x, 2 n_y, 2 n_z, c)."""
    full = [np.concatenate([-axis[:0:-1], axis]) for axis in axes]
    s, w = np.polynomial.legendre.leggauss(_GAUSS)
    curls = np.zeros((3, *(axis.size - 1 for axis in full), len(sources.coils)))
    inner = [(axis[:-1, None] + np.diff(axis)[:, None] * (1 + s) / 2).ravel() for axis in full]
    for d in range(3):
        lines = [*inner[:d], full[d], *inner[d + 1 :]]
        points = tensor_grid(*lines)
        A = sources.potential(points.reshape(-1, 3)).reshape(*points.shape, -1)
        for k in (e for e in range(3) if e != d):
            weights = np.diff(full[k])[:, None] * w / 2
            split = [*A.shape[:k], -1, s.size, *A.shape[k + 1 :]]
            at_nodes = np.moveaxis(A.reshape(split), (k, k + 1), (0, 1))
            A = np.moveaxis(np.einsum("nq,nq...->n...", weights, at_nodes), 0, k)
        A = np.diff(A, axis=d)
        for b, along, a, sign in _CURL:
            if along == d:
                curls[b] += sign * A[..., a, :]
    return curls


def _folded(curls: Array, parity: tuple[int, ...]) -> Array:
    """Return sums over the images of all octants with a class's signs, shape (c, 3 n)."""
    total = curls
    for e, sign in enumerate(parity):
        n = total.shape[e + 1] // 2
        upper, lower = np.split(total, [n], axis=e + 1)[::-1]
        turn = np.array([-1.0 if b == e else 1.0 for b in range(3)]).reshape(3, 1, 1, 1, 1)
        total = upper + sign * turn * np.flip(lower, axis=e + 1)
    return np.moveaxis(total, -1, 0).reshape(total.shape[-1], -1)


def _strongest(A: Complex, G: Array, rows: Integers, size: Array) -> Basis:
    """Return a few combinations of fields in which a class sees nearly all."""
    driven = G * size[:, None]
    values, vectors = eigh(driven @ solve(A.real, driven.T, assume_a="sym"))
    some = values > _KEEP**2 * values[-1]
    return Basis(rows, vectors[:, some] / size[:, None])


def _joined(blocks: Sequence[Complex], count: int) -> Complex:
    """Return all classes' responses, each with the coils last, as one with the coils last."""
    *each, last = side_by_side([*(len(block) - count for block in blocks), count])
    S = np.zeros((last.stop, last.stop), dtype=blocks[0].dtype)
    for block, own in zip(blocks, each, strict=True):
        some = np.r_[own, last]
        S[np.ix_(some, some)] += block
    return S
