"""How does a rigid body turn? Rotation vectors, their matrices, and products with vectors.

A rotation vector w stands for the rotation by the angle ``|w|`` about the axis ``w/|w|``, by the right hand:
``R = 1 + sin|w|/|w| [w] + (1 - cos|w|)/|w|^2 [w]^2`` with ``[w] v = w x v`` (Rodrigues), exact for any angle.
"""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Array


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
