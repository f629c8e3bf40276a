"""Potentials of flat triangles: a square's own in closed form, points far away, the solid angle around a point."""

import numpy as np
import pytest

from sits_mech.magnetics.permeable.triangles import triangle_potentials


def tetrahedron() -> np.ndarray:
    """Faces of a tetrahedron, corners counter-clockwise from outside."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.2, 0.0], [0.2, 0.3, 0.9]])
    return np.asarray(corners[np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])])


def test_a_squares_own_potential() -> None:
    """The mean of 1/r over a unit square with itself: 4 [asinh 1 - (sqrt 2 - 1)/3]."""
    square = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]], dtype=float)
    V, D = triangle_potentials(square, square)
    assert 4 * np.pi * V.sum() == pytest.approx(4 * (np.arcsinh(1.0) - (np.sqrt(2.0) - 1.0) / 3.0), rel=3e-3)
    assert not D.any()  # in its own plane


def test_dipoles_on_a_closed_surface_are_minus_one_inside_and_nothing_outside() -> None:
    """Of unit strength; on the surface half of it, as solid angles are."""
    faces = tetrahedron()
    _, D = triangle_potentials(faces, faces)
    area = np.linalg.norm(np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0]), axis=1) / 2
    np.testing.assert_allclose(D.sum(axis=(1, 2)), -area / 2, rtol=2e-2)
    for middle, inside in (((0.3, 0.3, 0.2), 1.0), ((3.0, 1.0, 2.0), 0.0)):
        small = 1e-3 * faces[:1] + middle
        total = triangle_potentials(small, faces)[1].sum() / (1e-6 * area[0])
        assert total == pytest.approx(-inside, abs=2e-3)


@pytest.mark.parametrize("apart, face, error", [
    (2.0, 0, 2e-3), (6.0, 0, 5e-4), (8.0, 0, 1e-4), (8.0, 1, 1e-4), (8.0, 2, 1e-4), (8.0, 3, 1e-4), (30.0, 0, 2e-4),
])
def test_near_and_far_triangles_are_as_their_small_parts(apart: float, face: int, error: float) -> None:
    """Each divided in 64: charges, and dipoles that are linear."""
    first, second = tetrahedron()[face : face + 1], tetrahedron()[1:2] + (apart, 0.4, 0.3)
    V, D = triangle_potentials(first, second)

    def parts(T: np.ndarray) -> np.ndarray:
        for _ in range(3):
            a, b, c = np.moveaxis(T, 1, 0)
            d, e, f = (a + b) / 2, (b + c) / 2, (c + a) / 2
            T = np.concatenate([np.stack(each, axis=1) for each in ((a, d, f), (d, b, e), (f, e, c), (d, e, f))])
        return T

    small = parts(second)
    v, d = triangle_potentials(parts(first), small)
    heights = np.linalg.solve(np.hstack([second[0], np.ones((3, 1))]).T[[0, 2, 3]], np.moveaxis(
        np.concatenate([small, np.ones((64, 3, 1))], axis=2)[..., [0, 2, 3]], 2, 0).reshape(3, -1))
    assert V[0, 0] == pytest.approx(v.sum(), rel=error)
    exact = heights.reshape(3, 64, 3).transpose(1, 2, 0).reshape(-1, 3).T @ d.sum(0).ravel()
    np.testing.assert_allclose(D[0, 0], exact, rtol=5e-3, atol=2e-3 * V[0, 0] / apart)
