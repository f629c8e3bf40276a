"""Turn rigid bodies: rotation vectors, their matrices, and products with vectors.

A rotation vector w stands for the rotation by the angle ``|w|`` about the axis ``w/|w|``, by the right hand:
``R = 1 + sin|w|/|w| [w] + (1 - cos|w|)/|w|^2 [w]^2`` with ``[w] v = w x v`` (Rodrigues), exact for any angle.
"""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Array

_SMALL = 1e-3  # half of an angle [rad] below which a quotient is its series


def cross_matrix(v: Array) -> Array:
    """Return the matrices of the vector products with v, shape (..., 3) -> (..., 3, 3)."""
    found = np.zeros((*v.shape, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        found[..., i, j], found[..., j, i] = -v[..., k], v[..., k]
    return found


def rotation_matrix(w: Array) -> Array:
    """Return the rotation matrices, shape (..., 3, 3), of rotation vectors, shape (..., 3) [rad]."""
    W = cross_matrix(w)
    angle = np.linalg.norm(w, axis=-1)[..., None, None]
    return np.asarray(np.eye(3) + np.sinc(angle / np.pi) * W + 0.5 * np.sinc(angle / (2.0 * np.pi)) ** 2 * W @ W)


def rotation_vector(R: Array) -> Array:
    """Return the rotation vector, shape (3,) [rad], of a rotation matrix by less than half a turn."""
    axis = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine = float(np.linalg.norm(axis))
    return axis * (np.arctan2(sine, 0.5 * (np.trace(R) - 1.0)) / sine if sine > 0.0 else 1.0)


def vector_rates(w: Array) -> Array:
    """Return the derivative (3, 3) of the vector by a small rotation after that of w, on its left.

    ``1 - [w]/2 + (1 - x cot x)/|w|^2 [w]^2`` with ``x = |w|/2``. Source: J. C. Simo, L. Vu-Quoc, Comput. Methods Appl.
    Mech. Engng 58 (1986) 79.
    """
    W, x = cross_matrix(w), 0.5 * float(np.linalg.norm(w))
    quotient = 1.0 / 12.0 + x**2 / 180.0 if x < _SMALL else (1.0 - x / np.tan(x)) / (4.0 * x**2)
    return np.eye(3) - 0.5 * W + quotient * W @ W
