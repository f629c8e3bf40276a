"""Turns of a rigid body against scipy's rotations."""

import numpy as np
from scipy.spatial.transform import Rotation

from sits_mech.rotations import cross_matrix, rotation_matrix, rotation_vector, vector_rates

VECTORS = np.random.default_rng(3).normal(size=(20, 3))


def test_matrices_are_scipys() -> None:
    """Any angle, zero and the smallest included, to rounding."""
    w = np.concatenate([VECTORS, 1e-9 * VECTORS, np.zeros((1, 3))])
    np.testing.assert_allclose(rotation_matrix(w), Rotation.from_rotvec(w).as_matrix(), atol=4e-15)


def test_vector_and_matrix_belong_together() -> None:
    """Below half a turn the vector comes back; the product with a vector is numpy's."""
    for w in np.concatenate([VECTORS * (2.5 / np.linalg.norm(VECTORS, axis=1, keepdims=True)), np.zeros((1, 3))]):
        np.testing.assert_allclose(rotation_vector(rotation_matrix(w)), w, atol=1e-14)
    np.testing.assert_allclose(cross_matrix(VECTORS[0]) @ VECTORS[1], np.cross(VECTORS[0], VECTORS[1]), rtol=1e-14)


def test_rates_of_the_vector_are_those_of_differences() -> None:
    """A small turn after that of w, large angles and small ones."""
    for w in np.concatenate([VECTORS * (2.5 / np.linalg.norm(VECTORS, axis=1, keepdims=True)), 1e-4 * VECTORS[:2]]):
        for k, turn in enumerate(1e-6 * np.eye(3)):
            ends = [rotation_vector(rotation_matrix(way * turn) @ rotation_matrix(w)) for way in (1.0, -1.0)]
            np.testing.assert_allclose(vector_rates(w)[:, k], (ends[0] - ends[1]) / 2e-6, atol=1e-8)
