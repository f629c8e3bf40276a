"""A plate close above the coils: what it does further up, carried down along the infinite plate of the same metal.

Close to a wide plate the coils' field is too fine for the plate's polynomials and cells, but it also sees the plate as
locally infinite. With the matrices of the plate Z(x), x its smallest distance from the coil plane, and of the infinite
plate in the same place D(x) (both Delta L, or both R),

    Z(x) = (P(x) D(x) + D(x) P(x)) / 2

defines a symmetric P that tells how much of the infinite plate there is: the identity under a very wide plate, some
smooth function of x elsewhere, without the gap's fine structure. P is found at `FACTORS` times the smallest distance
that the plate is divided for, as the plate is lifted to there, and extrapolated as a polynomial; twice the last
degree's share is the estimated error.

D is the integral of Dodd and Deeds, for the coils c and d, or the rings that stand for them, a distance s apart

    D_cd = pi mu0 int_0^inf Gamma(k) S_c(k) S_d(k) J0(k s) exp(-2 k h) dk = Delta L - j R / omega,

tabulated over h and averaged over places of the windings under the plate, h the height of its lower face there.

Range: plates whose faces look up and down, give or take some tenths of a radian; the estimated error says how well.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from scipy.constants import mu_0
from scipy.special import j0

from sits_mech.geometry.outline import Outline, target_outline
from sits_mech.geometry.solids import PlacedPlate, lowest_points
from sits_mech.geometry.tracks import standing_rings, track_places
from sits_mech.geometry.windings import distinct_pairs
from sits_mech.magnetics.axis.dodd_deeds import Layer, reflection, spectrum
from sits_mech.magnetics.space.coupling import reactions
from sits_mech.magnetics.space.modes import Sheeted
from sits_mech.quantities import Array, Complex
from sits_mech.scene.outlines import inside_loops
from sits_mech.scene.sensor import Coil, Target

FACTORS = np.array([1.0, 1.4, 2.0, 2.8, 4.0])  # heights, over the smallest
_DIGITS = 32.0  # the integrand is cut where it falls to exp(-32)
_PANEL = 16  # Gauss points of a panel
_PER_OCTAVE = 8  # heights of the table
_PLACES = (4, 24)  # across and around a coil's windings
_FLAT = 1e-9  # of the gap: a plate without tilt
_STEEP = 0.2  # least cosine of a plate's tilt

Reference = Callable[[Array, slice | int], Complex]


def lowered(
    coils: tuple[Coil, ...], windings: str, part: PlacedPlate, plate: tuple[tuple[Sheeted, ...], float],
    frequency: float,
) -> tuple[list[Complex], Complex]:  # fmt: skip
    """Return Delta Z of a plate closer than it is divided for, on all divisions, and what carrying it down may be off.

    Parameters
    ----------
    coils, windings, frequency
        As of `reactions`.
    part : PlacedPlate
    plate : tuple
        Its divisions, and the smallest distance that they are for [m].
    """
    divisions, lowest = plate
    gap, up = lowest_points(part.plate, part.outline, part.turns, part.places), FACTORS * lowest
    lift = (up - gap[:, None])[..., None] * (0.0, 0.0, 1.0)
    poses = np.repeat(part.turns, up.size, axis=0), (part.places[:, None] + lift).reshape(-1, 3)
    found = reactions(coils, windings, divisions, poses, frequency)
    heights = under_plate(coils, part.plate, part.outline, (part.turns, part.places), gap)
    reach = float(heights[0].max()) + up[-1]
    plane = infinite_plate(coils, part.plate, (float(gap.min()), reach), frequency)
    above = np.stack([averaged(plane, heights, height - gap) for height in up], axis=1)
    infinite = above, averaged(plane, heights, 0.0 * gap)
    results = [carried_down(Z.reshape(above.shape), infinite, gap, lowest) for Z in found]
    return [Z for Z, _ in results], results[0][1]


def carried_down(
    nodes: Complex, infinite: tuple[Complex, Complex], gap: Array, lowest: float
) -> tuple[Complex, Complex]:
    """Return Delta Z of a plate at its gap from what it is further up.

    Parameters
    ----------
    nodes : ndarray, shape (p, f, n, n)
        Delta Z with the plate lifted to ``FACTORS * lowest`` [ohm].
    infinite : tuple of ndarray, shapes (p, f, n, n), (p, n, n)
        Of the infinite plate there and at the gap [ohm].
    gap : ndarray, shape (p,)
        Smallest distance from the coil plane [m].
    lowest : float
        [m].

    Returns
    -------
    tuple of ndarray, shapes (p, n, n)
        Delta Z and its estimated error, real and imaginary part apart [ohm].
    """
    some, all_of_them = (_weights(FACTORS[:count] * lowest, gap) for count in (FACTORS.size - 1, FACTORS.size))
    values = [np.zeros(infinite[1].shape, dtype=complex) for _ in range(2)]
    for part, unit in ((np.real, 1.0), (np.imag, 1j)):
        P, there = _shares(part(nodes), part(infinite[0])), part(infinite[1])
        for value, weights in zip(values, (all_of_them, some), strict=True):
            share = np.einsum("pf,pfij->pij", weights, P[:, : weights.shape[1]])
            value += unit * (share @ there + there @ share) / 2
    error = 2.0 * (values[0] - values[1])
    return values[0], np.abs(error.real) + 1j * np.abs(error.imag)


def _weights(nodes: Array, x: Array) -> Array:
    """Lagrange's polynomials of the nodes at x, shape (p, f)."""
    result = np.ones((x.size, nodes.size))
    for i, node in enumerate(nodes):
        for other in np.delete(nodes, i):
            result[:, i] *= (x - other) / (node - other)
    return result


def _shares(Z: Array, D: Array) -> Array:
    """P of the module docstring, from the eigenvectors of D; real symmetric matrices along the last axes."""
    d, U = np.linalg.eigh(D)
    Ut = np.swapaxes(U, -1, -2)
    return np.asarray(U @ (2.0 * (Ut @ Z @ U) / (d[..., :, None] + d[..., None, :])) @ Ut)


def infinite_plate(
    coils: tuple[Coil, ...], target: Target, heights: tuple[float, float], frequency: float
) -> Reference:
    """Return D as a function of the height; equal pairs of coils are computed once.

    Parameters
    ----------
    coils : tuple of Coil
        n coils.
    target : Target
        Whose thickness and metal the infinite plate has.
    heights : tuple of float
        Smallest and greatest [m].
    frequency : float
        [Hz]

    Returns
    -------
    callable
        An array of heights (...) in the range, and which coils' rows, to matrices (..., rows, n) [ohm].
    """
    from scipy.interpolate import CubicSpline

    omega = 2 * np.pi * frequency
    first, last = math.floor(math.log2(heights[0])), math.ceil(math.log2(heights[1]))
    lowest = 2.0 ** (first - 1)  # nodes do not depend on the heights asked; the ends of the spline are far from these
    h = np.log(2.0) * (first - 1 + np.arange(_PER_OCTAVE * (last - first + 2) + 1) / _PER_OCTAVE)
    kinds, pairs, index = distinct_pairs(coils)
    farthest = max(apart for _, _, apart in pairs)
    k, weights = wave_numbers(_DIGITS / (2 * lowest), 2 * max(c.outer_diameter for c in kinds) + farthest)
    sections = [standing_rings(kind) for kind in kinds]
    S = [spectrum(rings, k, points=4 + int(k[-1] * rings.width.max() / 4)) for rings in sections]
    gamma = reflection(k, omega, [Layer(target.metal.conductivity, target.thickness)]) * weights
    fall = np.exp(-2.0 * k[:, None] * np.exp(h))
    D = [np.pi * mu_0 * (gamma * S[c] * S[d] * j0(k * apart)) @ fall for c, d, apart in pairs]
    table = CubicSpline(h, 1j * omega * np.stack(D, axis=1))
    return lambda asked, rows: np.asarray(table(np.log(asked))[..., index[rows]])


def wave_numbers(largest: float, length: float) -> tuple[Array, Array]:
    """Return Gauss points and weights on [0, largest] for what turns like ``exp(j k length)``, finer towards 0."""
    panels = 16 + int(largest * length / _PANEL)
    edges = largest * np.linspace(0.0, 1.0, panels + 1) ** 1.5
    nodes, weights = np.polynomial.legendre.leggauss(_PANEL)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1.0 + nodes)).ravel(), (half * weights).ravel()


def under_plate(
    coils: Sequence[Coil], target: Target, outline: Outline | None, poses: tuple[Array, Array], gap: Array
) -> tuple[Array, Array]:
    """Return the plate's height over places of each coil's windings, and the places' weights (sum 1, 0 beside it).

    Parameters
    ----------
    coils : sequence of Coil
        n coils.
    target : Target
    outline : Outline or None
        Instead of the scene's.
    poses : tuple of ndarray
        Rotations (p, 3, 3) and places (p, 3) of the bottom face's centre [m].
    gap : ndarray, shape (p,)
        What no height is below [m].

    Returns
    -------
    tuple of ndarray, shapes (p, n, m)
        Heights [m], weights.
    """
    turns, places = poses
    across, around = np.meshgrid((np.arange(_PLACES[0]) + 0.5) / _PLACES[0],
                                 2 * np.pi * (np.arange(_PLACES[1]) + 0.5) / _PLACES[1])  # fmt: skip
    points = np.empty((len(coils), across.size, 2))
    for c, coil in enumerate(coils):
        if not coil.is_round:
            points[c] = track_places(coil, across.size)
            continue
        r = (coil.inner_diameter + across * (coil.outer_diameter - coil.inner_diameter)).ravel() / 2
        points[c] = coil.centre + r[:, None] * np.column_stack([np.cos(around).ravel(), np.sin(around).ravel()])
    normal = turns[:, :, 2]
    cosine = np.where(normal[:, 2] < 0.0, -1.0, 1.0) * np.maximum(np.abs(normal[:, 2]), _STEEP)
    offset = points - places[:, None, None, :2]
    height = places[:, 2] + np.minimum(target.thickness / cosine, 0.0)
    height = height[:, None, None] - np.einsum("pcmi,pi->pcm", offset, normal[:, :2]) / cosine[:, None, None]
    height = np.maximum(height, gap[:, None, None])
    full = np.concatenate([offset, height[..., None] - places[:, None, None, 2:]], axis=-1)
    own = np.einsum("pcmi,pij->pcmj", full, turns[:, :, :2])
    loops = [np.array(loop) for loop in target_outline(target, outline).loops]
    weight = inside_loops(loops, own.reshape(-1, 2)).reshape(height.shape).astype(float)
    total = weight.sum(-1, keepdims=True)
    return height, np.where(total > 0.0, weight / np.maximum(total, 1.0), 1.0 / weight.shape[-1])


def averaged(reference: Reference, places: tuple[Array, Array], lift: Array) -> Complex:
    """Return D averaged over places (heights and weights of `under_plate`) with the plate lifted, shape (p, n, n)."""
    heights, weights = places
    flat = np.ptp(heights, axis=(1, 2)) < _FLAT * heights.min()
    heights = heights + lift[:, None, None]
    if flat.all():
        return np.asarray(reference(heights[:, 0, 0], slice(None)))
    result = np.empty((lift.size, heights.shape[1], heights.shape[1]), dtype=complex)
    for c in range(heights.shape[1]):
        result[:, c] = np.einsum("pmd,pm->pd", reference(heights[:, c], c), weights[:, c])
    return np.asarray((result + np.swapaxes(result, 1, 2)) / 2)
