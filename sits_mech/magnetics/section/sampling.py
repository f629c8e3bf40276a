"""Place the samples of the field above the coils: few nodes in a plate's section that carry every field from outside.

Sources stay at least a clearance g away from the rectangle w x t. Two unknown densities, one inductance kernel
phi = -ln r, tell how many complex samples N and where: charge the rectangle's rim to 1 and the curve at distance g
to 0; the total charge Q on the rim gives the modulus ln(rho) = 1 / Q of the ring between them. Fields from outside fall
like rho^-n over the rim, their energies like rho^-2n, so that

    N = terms / (2 ln rho)

keeps `terms` digits (natural logarithm) of an energy. The nodes lie at equal parts of the charge on an inner curve, at
the mirrored distance g below the rim (in a thin plate: on its mid-line, where they become Chebyshev's points).

The map from samples to fields is a least-squares fit over test charges on curves at the distances g, 4 g, 16 g ... With
the samples ``f'(z_i)`` of unit charges as F and what the charges induce in the cells as G,

    F = U S V^T,   c = S^-1 U^T (Re f', Im f'),   field in the cells = (G V) c.

Fields of the rectangle's mirror classes do not mix; each class has its own fit. Every charge weighs as one that gives
the nodes a unit of f' in all, so that far sources are held to the same relative error.

Source: Walsh, Interpolation and Approximation (equally charged nodes); the fit is the method of fundamental solutions
read backwards. Range: any proportion of w, t and g.
"""

from __future__ import annotations

import math

import numpy as np

from sits_mech.quantities import Array, Complex

_CUT = 1e-10  # singular values below this part of the largest are rounding
_SPREAD = 4.0  # ratio of the distances of neighbouring curves of test charges


CLASSES = ((1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0))  # parities of the potential in xi and in eta


def quadrant_images(p: Complex) -> tuple[Complex, Complex, Complex, Complex]:
    """Return places and their images in xi, in eta and in both."""
    return p, -p.conj(), p.conj(), -p


def signs(parities: tuple[float, float]) -> tuple[float, float, float, float]:
    """Return the signs of a class on the four images of `quadrant_images`."""
    return 1.0, parities[0], parities[1], parities[0] * parities[1]


def probe_charges(size: tuple[float, float], clearance: float) -> Complex:
    """Return places xi + j eta of test charges in one quadrant, on curves from `clearance` on [m]."""
    reach, distances = 4.0 * max(size), [clearance]
    while distances[-1] < reach:
        distances.append(_SPREAD * distances[-1])
    return np.concatenate([_offset_curve(size, d, d / 4)[0] for d in distances])


def sample_nodes(size: tuple[float, float], clearance: float, terms: float) -> tuple[Complex, int]:
    """Return one quadrant's places xi + j eta [m] where the plate samples f', and their copies: 4, or 2 on an axis.

    `size` is width w and thickness t, `clearance` the smallest distance g of a source [m]; `terms` are the digits
    (natural logarithm) of an energy that the samples keep. All nodes are those of `all_nodes`.
    """
    if size[1] > size[0]:
        places, copies = sample_nodes((size[1], size[0]), clearance, terms)
        return 1j * places.conj(), copies
    outer = _offset_curve(size, clearance, clearance / 1.5)
    rim = _rectangle(size[0] / 2, size[1] / 2, clearance / 1.5)
    count = terms * float(np.sum(_charge(rim, outer))) * 4 / 2 + 3
    flat = size[1] <= min(2 * clearance, size[0] / 4)
    depth = size[1] / 2 if flat else min(size[1] / 4, clearance)
    inner = _rectangle(size[0] / 2 - depth, 0.0 if flat else size[1] / 2 - depth, clearance / 1.5)
    density = _charge(inner, outer)
    copies = 2 if flat else 4
    edges, parts = np.concatenate([[0.0], np.cumsum(np.maximum(density, 0.0))]), int(np.ceil(count / copies))
    wanted = (np.arange(parts) + 0.5) / parts * edges[-1]  # middles of equal parts of the charge
    middles = (edges[1:] + edges[:-1]) / 2
    return np.interp(wanted, middles, inner[0].real) + 1j * np.interp(wanted, middles, inner[0].imag), copies


def all_nodes(places: Complex, copies: int) -> Complex:
    """Return one quadrant's places and their images."""
    return np.concatenate(quadrant_images(places) if copies == 4 else (places, -places))


def _charge(inner: tuple[Complex, Array], outer: tuple[Complex, Array]) -> Array:
    """Return charges of one quadrant's inner panels at potential 1 against the outer curve at 0."""
    places, lengths = (np.concatenate(pair) for pair in zip(inner, outer, strict=True))
    matrix = np.zeros((places.size,) * 2)
    for image in quadrant_images(places):
        distance = np.abs(places[:, None] - image)
        matrix -= np.log(np.maximum(distance, lengths / (2 * math.e)))
    potential = np.where(np.arange(places.size) < inner[0].size, 1.0, 0.0)
    ones = np.ones(places.size)
    # total charge zero: the potential at infinity is free
    found, shift = np.linalg.solve(matrix, np.stack([potential, ones], axis=1)).T
    found = found - shift * (found.sum() / shift.sum())
    return np.asarray(found[: inner[0].size])


def _rectangle(half_width: float, half_height: float, step: float) -> tuple[Complex, Array]:
    """Return panels (middles, lengths) on a quadrant of a rectangle's rim or a line, finer towards corner and end."""
    corner = complex(half_width, half_height)
    top = _panels(corner - half_width, corner, step)
    if half_height == 0.0:
        return top
    side = _panels(corner - 1j * half_height, corner, step)
    return np.concatenate([top[0], side[0][::-1]]), np.concatenate([top[1], side[1][::-1]])


def _panels(start: complex, end: complex, step: float) -> tuple[Complex, Array]:
    """Return panels of a straight line, finer towards its end."""
    length = abs(end - start)
    edges = np.sin(np.linspace(0.0, np.pi / 2, 9 + int(np.ceil(np.pi / 2 * length / step))))
    return start + (end - start) * (edges[1:] + edges[:-1]) / 2, length * np.diff(edges)


def _offset_curve(size: tuple[float, float], distance: float, step: float) -> tuple[Complex, Array]:
    """Return panels on one quadrant of the curve at `distance` around a rectangle."""
    corner = complex(size[0] / 2, size[1] / 2)
    arc = np.pi / 2 * distance
    counts = [max(3, int(np.ceil(length / step))) for length in (corner.real, arc, corner.imag)]
    top, turn, side = ((np.arange(count) + 0.5) / count for count in counts)
    places = [
        corner.real * top + 1j * (corner.imag + distance), corner + distance * np.exp(0.5j * np.pi * (1.0 - turn)),
        corner.real + distance + 1j * corner.imag * (1.0 - side),
    ]
    lengths = [np.full(n, s / n) for n, s in zip(counts, (corner.real, arc, corner.imag), strict=True)]
    return np.concatenate(places), np.concatenate(lengths)


def field_basis(samples: Array, fields: Array, parities: tuple[float, float], copies: int) -> tuple[Array, Array]:
    """Return the basis S^-1 U^T, shape (k, copies x samples), and the field of each coefficient, shape (cells, k).

    `samples` (2 m, q) are real, then imaginary parts of f' at one quadrant's m nodes, for each test charge with its
    images; `fields` (cells, q) their mean potential in each cell; `copies` is 4, or 2 where the nodes lie on an axis.
    """
    U, S, V = np.linalg.svd(samples, full_matrices=False)
    kept = S > _CUT * S[0]
    real, imaginary = np.split(U.T[kept] / (copies * S[kept, None]), 2, axis=1)
    x, z = parities
    images = ((1.0, 1.0), (-x, x), (z, -z), (-x * z, -x * z)) if copies == 4 else ((1.0, 1.0), (-x * z, -x * z))
    basis = [sign[0] * real for sign in images] + [sign[1] * imaginary for sign in images]
    return np.concatenate(basis, axis=1), fields @ V[kept].T
