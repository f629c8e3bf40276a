"""Mean logarithm between two parallel rectangular bars: the planar inductance kernel.

The vector potential of a straight current I along y is ``A = -(mu0 I / 2 pi) ln r``; between two bars with uniform
current density the mutual inductance per metre is ``-(mu0 / 2 pi) <ln r>``, the mean over both sections.

Near pairs use the closed form. With

    K(x, z) = 1/2 [(x^2 z^2/4 - x^4/24 - z^4/24) ln(x^2 + z^2) + x^3 z/3 atan(z/x) + x z^3/3 atan(x/z)]

one has d4K/dx2dz2 = ln r + 25/12, so the mean is a double second difference of K over the two sections' corner
distances, less 25/12. That difference loses digits when the bars are small against their distance, where far pairs
use the expansion of ln in the moments of ``w = w1 - w2`` (complex offset within the sections),

    <ln|zeta + w|> = Re[ln zeta - m2/(2 zeta^2) - m4/(4 zeta^4) - m6/(6 zeta^6) - ...],   m_k = <w^k>.

Source: Gray, Absolute Measurements in Electricity and Magnetism (geometric mean distances); the sixth moment leaves
an error below 1e-7 from 3.5 widths on.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from sits_mech.quantities import Array

_NEAR = 3.5  # in the longest side of either bar
_TOUCHING = 0.03  # least distance over half a side that Gauss points are counted for


def gauss_count(side: float, distance: float, error: float) -> int:
    """Return how many Gauss points for a side of a bar have its field to an error, of its size, from a distance on.

    By the ellipse around the side through the nearest such point, which is asinh(2 distance / side) of it away; where
    bars all but touch, as many as are of use for what is integrable there.
    """
    rate = max(float(np.arcsinh(2.0 * distance / side)), _TOUCHING)
    return max(1, int(np.ceil(-np.log(error) / (2.0 * rate))))


@lru_cache(maxsize=64)
def gauss_rule(count: int) -> tuple[Array, Array]:
    """Return so many Gauss points of a side, from -1 to 1, and weights of sum 1."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights / 2.0


def mean_log(dx: Array, dz: Array, first: tuple[Array, Array], second: tuple[Array, Array]) -> Array:
    """Return the mean of ln r between rectangular bars, all arguments broadcast together, in any unit.

    dx, dz are of the second bar's centre less the first's; each bar has its width (along x) and thickness (along z).
    """
    dx, dz, a1, b1, a2, b2 = np.broadcast_arrays(dx, dz, *first, *second)
    near = dx**2 + dz**2 < (_NEAR * np.maximum(np.maximum(a1, a2), np.maximum(b1, b2))) ** 2
    result = np.empty(dx.shape)
    far = ~near
    result[far] = _far(dx[far], dz[far], (a1[far], b1[far]), (a2[far], b2[far]))
    result[near] = _near(dx[near], dz[near], (a1[near], b1[near]), (a2[near], b2[near]))
    return result


def _near(dx: Array, dz: Array, first: tuple[Array, Array], second: tuple[Array, Array]) -> Array:
    """Return closed form: double second difference of K."""
    total = np.zeros(dx.shape)
    for x, sign_x in _corners(dx, first[0], second[0]):
        for z, sign_z in _corners(dz, first[1], second[1]):
            xx, zz, xz, angle = x * x, z * z, x * z, np.arctan2(z, x)  # K of the module docstring for x, z >= 0
            log = np.log(np.where(xx + zz > 0.0, xx + zz, 1.0))
            K = (xx * zz / 4 - (xx * xx + zz * zz) / 24) * log + xz / 3 * (xx * angle + zz * (np.pi / 2 - angle))
            total += 0.5 * sign_x * sign_z * K
    return total / (first[0] * first[1] * second[0] * second[1]) - 25.0 / 12.0


def _corners(d: Array, side1: Array, side2: Array) -> list[tuple[Array, float]]:
    """Return distances between the ends of two intervals, with their signs in the second difference."""
    outer, inner = (side1 + side2) / 2, (side1 - side2) / 2
    return [(np.abs(d + outer), 1.0), (np.abs(d + inner), -1.0), (np.abs(d - inner), -1.0), (np.abs(d - outer), 1.0)]


def _far(dx: Array, dz: Array, first: tuple[Array, Array], second: tuple[Array, Array]) -> Array:
    """Return the moment expansion."""
    p2, p4, p6 = _moments(*first)
    q2, q4, q6 = _moments(*second)
    m2, m4 = p2 + q2, p4 + 6 * p2 * q2 + q4
    m6 = p6 + 15 * p4 * q2 + 15 * p2 * q4 + q6
    zeta2 = (dx + 1j * dz) ** 2
    inverse = 1.0 / zeta2
    series = inverse * (m2 / 2 + inverse * (m4 / 4 + inverse * m6 / 6))
    return np.asarray(0.5 * np.log(np.abs(zeta2)) - series.real)


def _moments(a: Array, b: Array) -> tuple[Array, Array, Array]:
    """Return means of (x + jz)^k, k = 2, 4, 6, over a rectangle a by b about its centre."""
    x2, x4, x6 = a**2 / 12, a**4 / 80, a**6 / 448
    z2, z4, z6 = b**2 / 12, b**4 / 80, b**6 / 448
    return x2 - z2, x4 - 6 * x2 * z2 + z4, x6 - 15 * x4 * z2 + 15 * x2 * z4 - z6
