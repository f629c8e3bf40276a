"""Inductance of circular loops and rings: coaxial by a closed form, side by side by a quadrature around one of them.

Two coaxial loops of radii a and b, a distance d apart, r1 and r2 the greatest and the least distance of their points
(Maxwell's second form; of small k^2 by the power series of (K - E) / k^2, so that nothing cancels in any regime):

    M(a, b, d) = 16 mu0 (a b)^2 / (r1 + r2)^3  (K - E) / k^2,    1 - k^2 = 4 r1 r2 / (r1 + r2)^2,
    r1^2 = (a + b)^2 + d^2,    r2^2 = (a - b)^2 + d^2.

Rings of rectangular section with uniform current density: the mean of M over both sections. Near its singularity M is
``-mu0 sqrt(a b) ln r2``, whose mean is known in closed form (`section.kernels`); what is left varies on the scale of
the radii and is taken at Gauss points, of unlike number in the two sections so that they never meet.

Loops with parallel axes a distance D apart: the line integral of A_phi = M(a, rho, d) / (2 pi rho) around the second,

    M = 1/(2 pi) int_0^2pi M(a, rho, d) / rho^2  b (b + D cos t) dt,    rho^2 = b^2 + D^2 + 2 b D cos t,

by the trapezium rule, which converges geometrically because the integrand is periodic and analytic. M / rho^2 of all
filaments of a winding is a polynomial of rho across the other one, to rounding (`_across`).

Coils that are not round: `straight`. Units: H, m. Neglected: the spiral's pitch, displacement current, uneven current
in the section (`resistance`).
Source: Maxwell, Treatise, art. 701.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.polynomial.polynomial import polyval
from numpy.typing import ArrayLike
from scipy.constants import mu_0
from scipy.special import ellipe, ellipkm1

from sits_mech.geometry.tracks import coil_tracks
from sits_mech.geometry.windings import Sections, coil_sections, kinds_of, placed_pairs
from sits_mech.magnetics.coils.straight import PAIRS, linkage
from sits_mech.magnetics.section.kernels import gauss_count, gauss_rule, mean_log
from sits_mech.memory import check_seconds
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Coil

_ANGLES = 8192  # most points around a loop: coils whose edges touch need the most
_SHARED = 8  # layers from which on equal distances are shared
_PAIR = 5e-6  # s of processor time that a pair of rings takes, by 3 points through the thickness
_TALL = 24.0  # such points over thickness by radius: 4e-7 of a ring as tall as its radius, where 3 leave 4e-4
_APART = 1e-6  # error of filaments that stand for rings side by side, of their own field
_MOST = 12, 4  # of them along a width and a height: of rings 2 mm wide, 0.1 mm over others, 1e-4 of M off
_POWERS = np.pi / 4 * np.cumprod([1.0, *(np.arange(1, 11) ** 2 - 0.25) / np.arange(1, 11) / np.arange(2, 12)])
_DIGITS = 36.0  # natural logarithm of the accuracy of the field across another winding: rounding


def mutual_loops(a: ArrayLike, b: ArrayLike, d: ArrayLike) -> Array:
    """Return the mutual inductance [H] of coaxial filaments, radii a, b, distance d [m]; infinite if they coincide."""
    a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    return np.asarray((a * b) ** 2 * reduced_mutual(a, b, np.asarray(d, dtype=float)))


def reduced_mutual(a: Array, b: Array, d: Array) -> Array:
    """Return M / (a b)^2 of coaxial filaments [H/m^4], finite for a or b = 0, to 1e-14."""
    far, near = np.hypot(a + b, d), np.hypot(a - b, d)
    total = far + near
    left = 4.0 * far * near / total**2
    small = (m := 1.0 - left) < 0.05  # where K - E cancels, and ten powers are right to 1e-14
    over_m = np.where(small, polyval(m, _POWERS), (ellipkm1(left) - ellipe(m)) / np.where(small, 1.0, m))
    return np.asarray(16.0 * mu_0 / total**3 * over_m)


def ring_mutual(first: Sections, second: Sections, *, points: tuple[int, int] = (3, 3)) -> Array:
    """Return the mutual inductances (n, m) of coaxial rings [H]; of a ring with itself its self-inductance.

    `points` are Gauss points along r and z for the regular part, one more along r in the second section; the result is
    symmetric only up to this quadrature (see `ring_inductance`).
    """
    others = points[0] + 1, points[1]
    step = max(1, PAIRS // (second.radius.size * math.prod(others)))
    rows = (first.some(np.s_[k : k + step, None]) for k in range(0, first.radius.size, step))
    return np.concatenate([paired_mutual(some, second, points, others) for some in rows])


def paired_mutual(first: Sections, second: Sections, points: tuple[int, int], others: tuple[int, int]) -> Array:
    """Return the mutual inductances of rings of one shape with those of another, pair by pair as they broadcast [H].

    `points`, `others` are Gauss points of each section along r and z; where sections meet they must differ along r.
    """
    a, b, d = first.radius, second.radius, second.z - first.z
    scale = np.sqrt(a * b)
    total = -mu_0 * scale * mean_log(b - a, d, (first.width, first.height), (second.width, second.height))
    db, zb, weight_b = _offsets(second, others)
    db, zb = (each.reshape(len(each), *[1] * (total.ndim - b.ndim), *b.shape) for each in (db, zb))
    for da, za, weight_a in zip(*_offsets(first, points), strict=True):
        r1, r2, distance = a + da, b + db, d + zb - za
        logarithm = 0.5 * np.log((r1 - r2) ** 2 + distance**2)
        parts = mutual_loops(r1, r2, distance) + mu_0 * scale * logarithm
        total = np.concatenate([total[None], (weight_a * weight_b * parts.T).T]).sum(axis=0)
    return total


def ring_inductance(rings: Sections, *, points: tuple[int, int] = (3, 3)) -> Array:
    """Return the symmetric inductance matrix of coaxial rings [H], shape (n, n)."""
    L = ring_mutual(rings, rings, points=points)
    return (L + L.T) / 2


def _offsets(rings: Sections, points: tuple[int, int]) -> tuple[Array, Array, Array]:
    """Return g Gauss points of sections (...): offsets along r and z from the centres (g, ...), and weights (g,)."""
    (gr, wr), (gz, wz) = map(gauss_rule, points)
    r, z = np.repeat(gr, len(gz)), np.tile(gz, len(gr))
    return np.multiply.outer(r, rings.width / 2), np.multiply.outer(z, rings.height / 2), np.outer(wr, wz).ravel()


@lru_cache(maxsize=32)
def free_inductances(coils: tuple[Coil, ...], windings: str = "rings") -> Array:
    """Return the free-space inductance matrix of n coils with parallel axes, none overlapping, shape (n, n) [H].

    Of rings each mutual inductance is right to 1e-9 of both self-inductances. Round coils are "rings" or a "spiral";
    others are straight tracks, and so are round ones for their mutual inductances with them. Equal windings, and equal
    pairs of them at equal places of each other, are computed once.
    """
    kinds, _ = kinds_of(coils)
    as_rings = [kind.is_round and windings == "rings" for kind in kinds]
    pairs, index = placed_pairs(coils, as_rings)
    own = [_own(kind, windings, each) for kind, each in zip(kinds, as_rings, strict=True)]
    found = np.empty(len(pairs))
    for k, (one, other, apart) in enumerate(pairs):
        if one == other and apart == (0.0, 0.0):
            found[k] = own[one]
        elif as_rings[one] and as_rings[other]:
            rings = coil_sections(kinds[one]), coil_sections(kinds[other])
            error = 1e-9 * math.sqrt(own[one] * own[other])
            found[k] = mutual_side_by_side(*rings, apart[0], error=error)
        else:
            found[k] = linkage(coil_tracks(kinds[one], windings), coil_tracks(kinds[other], windings).moved(*apart))
    return found[index]


def _own(coil: Coil, windings: str, as_rings: bool) -> float:
    """Return the self-inductance of a winding as rings, or as tracks [H]."""
    if as_rings:
        return series_inductance(coil_sections(coil))
    tracks = coil_tracks(coil, windings)
    return linkage(tracks, tracks)


def series_inductance(rings: Sections) -> float:
    """Return the inductance of coaxial rings in series [H]; a coil of n equal layers costs n pairs of them, not n^2."""
    levels, level = np.unique(rings.z, return_inverse=True)
    layers = [rings.some(level == k) for k in range(levels.size)]
    first, ways = layers[0], np.array([rings.signs[level == k][0] for k in range(levels.size)])
    shapes = {np.stack([each.radius, each.width, each.height]).tobytes() for each in layers}
    shared = levels.size >= _SHARED and len(shapes) == 1 and np.array_equal(ways[level], rings.signs)
    through = _through(rings, (first if shared else rings).radius.size * rings.radius.size)
    if not shared:
        return float(rings.signs @ ring_inductance(rings, points=(3, through)) @ rings.signs)
    depth = levels[-1] - levels[0]
    apart, number = np.unique(np.round(np.abs(levels[:, None] - levels) / depth, 12), return_inverse=True)
    count = np.bincount(number.ravel(), np.outer(ways, ways).ravel())
    columns = np.broadcast_arrays(first.radius, first.z + depth * apart[:, None], first.width, first.height)
    M = ring_mutual(first, Sections(*(each.ravel() for each in columns)), points=(3, through))
    return float(count @ M.reshape(-1, *columns[0].shape).sum(axis=(0, 2)))


def _through(rings: Sections, pairs: int) -> int:
    """Return how many Gauss points through the thickness so many pairs of rings take; refuse those without number."""
    points = max(3, math.ceil(_TALL * float((rings.height / rings.radius).max())))
    check_seconds(_PAIR * pairs * (points / 3) ** 2, f"coils: the inductance of a coil of {rings.radius.size} turns")
    return points


def mutual_side_by_side(first: Sections, second: Sections, distance: float, *, error: float = 1e-16) -> float:
    """Return the mutual inductance of two windings with parallel axes, all their rings in series [H].

    `distance` is of the axes [m]; rings must not cut each other. `error` is asked of the quadrature, absolute [H].
    """
    if distance == 0.0:
        through = max(_through(rings, first.radius.size * second.radius.size) for rings in (first, second))
        return float(first.signs @ ring_mutual(first, second, points=(3, through)) @ second.signs)
    clear = _clearance(first, second, distance)
    b, zb, wb = _filaments(second, clear)
    heights, level = np.unique(zb, return_inverse=True)
    reach = float(np.abs(b - distance).min()), float(b.max()) + distance
    field = _filaments(first, clear)
    fields = [_across(field, height, reach) for height in heights]
    count, before = 16, np.inf
    while True:
        # half the points by symmetry; the mid-points keep clear of the closest approach at t = pi
        cosine = np.cos(np.pi * (np.arange(count) + 0.5) / count)
        value = 0.0
        for k, profile in enumerate(fields):
            radius, weight = b[level == k, None], wb[level == k]
            rho = np.sqrt(radius**2 + distance**2 + 2 * radius * distance * cosine)
            value += float(weight @ (profile(rho) * radius * (radius + distance * cosine)).mean(axis=1))
        if abs(value - before) <= error or count >= _ANGLES:
            return value
        count, before = 2 * count, value


def _clearance(first: Sections, second: Sections, distance: float) -> float:
    """Return how far two windings with axes a distance apart are from each other at least [m]."""
    (low, high), (least, most) = (((each.radius - each.width / 2).min(), (each.radius + each.width / 2).max())
                                  for each in (first, second))
    radial = max(distance - high - most, low - distance - most, least - distance - high, 0.0)
    levels = np.abs(first.z[:, None] - second.z) - (first.height[:, None] + second.height) / 2
    return math.hypot(radial, max(float(levels.min()), 0.0))


def _across(filaments: tuple[Array, Array, Array], height: float, reach: tuple[float, float]) -> Chebyshev:
    """Return M(a, rho, d) / rho^2 of all filaments of a winding at one height, over a range of rho away from them.

    Analytic but for rho = a +- j d, whose nearest ellipse tells how many polynomials reach rounding.
    """
    a, z, weight = filaments
    middle, half = sum(reach) / 2, max(reach[1] - reach[0], 1e-6 * reach[1]) / 2
    w = (a + 1j * (z - height) - middle) / half
    rate = math.acosh(max(1.0, float((np.abs(w - 1) + np.abs(w + 1)).min()) / 2))
    degree = min(_ANGLES, math.ceil(_DIGITS / max(rate, _DIGITS / _ANGLES)))
    return Chebyshev.interpolate(
        lambda rho: (weight * a**2) @ reduced_mutual(a[:, None], rho, (z - height)[:, None]), degree,
        domain=[middle - half, middle + half],
    )


def _filaments(rings: Sections, clear: float) -> tuple[Array, Array, Array]:
    """Return rings as Gauss filaments, right from a distance on, and in their moment: radii, heights, weights, flat."""
    across, through = (
        min(max(2, gauss_count(float(side.max()), clear, _APART)), most)
        for side, most in zip((rings.width, rings.height), _MOST, strict=True)
    )
    r, z, weight = _offsets(rings, (across, through))
    return (rings.radius + r).ravel(), (rings.z + z).ravel(), np.multiply.outer(weight, rings.signs).ravel()
