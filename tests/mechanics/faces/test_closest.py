"""Gaps before flat facets: a distance known otherwise, and two derivatives."""

import numpy as np
import pytest

from sits_mech.mechanics.faces.closest import behind, gaps, nearest, normals

TRIANGLE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.2, 0.8, 0.1]])
SEGMENT = np.array([[0.0, 0.0], [1.0, 0.3]])


@pytest.mark.parametrize("facet", [SEGMENT, TRIANGLE])
def test_nearest_points_are_nearer_than_any_of_a_grid(facet):
    rng, d = np.random.default_rng(0), len(facet)
    x = rng.uniform(-1.0, 2.0, size=(200, d))
    corners = np.tile(facet, (200, 1, 1))
    weights = nearest(x, corners)
    assert weights.min() >= 0.0 and np.allclose(weights.sum(axis=1), 1.0)
    away, before = behind(x, corners, weights, normals(corners))
    share = rng.dirichlet(np.ones(d) / 2.0, size=4000)
    grid = np.linalg.norm(x[:, None] - share @ facet, axis=2).min(axis=1)
    assert np.all(away <= grid + 1e-12) and np.max(grid - away) < 0.1
    assert np.all(np.abs(before) <= away + 1e-12) and (before > 0.0).any() and (before < 0.0).any()


PLACES = [
    (SEGMENT, (0.5, 0.2), 2),
    (SEGMENT, (0.5, 0.1), 2),
    (SEGMENT, (-0.1, -0.2), 1),
    (TRIANGLE, (0.4, 0.3, 0.01), 3),
    (TRIANGLE, (0.4, 0.3, -0.2), 3),
    (TRIANGLE, (0.5, -0.1, -0.1), 2),
    (TRIANGLE, (1.2, -0.1, 0.3), 1),
]


@pytest.mark.parametrize(("facet", "x", "counted"), PLACES)
def test_gaps_have_two_exact_derivatives(facet, x, counted):
    """Of a point between two nodes and of a facet whose corners stand in any order among its nodes."""
    d, h, rng = len(facet), 1e-5, np.random.default_rng(1)
    shape, places = np.zeros((1, 2 + d + 1)), 2 + np.arange(d)[::-1][None]
    shape[0, :2] = 0.3, 0.7
    start = rng.normal(size=(2 + d + 1, d))
    start[places[0]] = facet
    start[1] = (np.array(x) - 0.3 * start[0]) / 0.7

    def gap(v):
        nodes = start + v.reshape(start.shape)
        points, corners = shape[:, :2] @ nodes[:2], nodes[places]
        return gaps(points, corners, nearest(points, corners), shape, places)

    v, zero = rng.normal(size=start.size), np.zeros(start.size)
    here, up, down = gap(zero), gap(h * v), gap(-h * v)
    points, corners = np.array([x]), facet[None]
    assert np.count_nonzero(nearest(points, corners)) == counted
    away, before = behind(points, corners, nearest(points, corners), normals(corners))
    assert here.value[0] == pytest.approx(np.sign(before[0]) * away[0])
    assert (up.value - down.value)[0] / (2 * h) == pytest.approx(here.slope[0] @ v, rel=1e-7)
    np.testing.assert_allclose(here.curvature[0] @ v, (up.slope - down.slope)[0] / (2 * h), atol=1e-7)
