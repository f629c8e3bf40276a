"""Points of flat facets that are nearest: against a grid of points."""

import numpy as np
import pytest

from sits_mech.mechanics.faces.facets import behind, nearest, normals

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
