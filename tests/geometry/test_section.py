"""Division of a rectangle: it fills its quadrant, finest where it should be."""

import numpy as np
import pytest

from sits_mech.geometry.section import graded, quadrant_cells


@pytest.mark.parametrize("length", [1.0, 0.013, 7.3])
def test_nodes_grow_from_the_surface(length: float) -> None:
    """From zero to the length; the last cell at most the first asked, none above the largest, none jumps."""
    nodes = graded(length, 0.02, 0.4, 1.5)
    steps = np.diff(nodes)
    assert nodes[0] == 0.0 and nodes[-1] == length and np.all(steps > 0.0)
    assert steps[-1] <= 0.02 * (1 + 1e-12) and steps.max() <= 0.4 * (1 + 1e-12)
    assert np.all(steps[:-1] <= 1.5 * steps[1:] * (1 + 1e-12))


def test_cells_fill_the_quadrant() -> None:
    """Area and first moments are those of the rectangle."""
    cells = quadrant_cells(graded(2.0, 0.1, 0.5, 1.3), graded(0.5, 0.05, 0.2, 1.3))
    area = cells.width * cells.height
    found = [area.sum(), (area * cells.x).sum(), (area * cells.z).sum()]
    np.testing.assert_allclose(found, [1.0, 1.0, 0.25], rtol=1e-14)
