"""Mirror images and copies of bricks: volumes add, halves share their plane, curved bricks stay curved."""

import numpy as np
import pytest
from skfem import Basis, MeshHex
from skfem.assembly import Dofs
from skfem.element import ElementHex2

from sits_mech.geometry.meshing.bricks import PlateOutline, both_halves, bricks_of, mesh_of, ring_bricks, side_by_side

DISC = PlateOutline(1.0, 1.0, True)
HALF, _ = ring_bricks(DISC, DISC, (np.array([0.0, 0.5, 1.0]), np.zeros(1), np.array([0.0, 1.0])), 1)


def volume(mesh):
    return float(Basis(mesh, ElementHex2(), intorder=6).dx.sum())


def test_bricks_make_the_mesh_that_they_are_of():
    again = mesh_of(bricks_of(HALF))
    np.testing.assert_array_equal(again.t, HALF.t)
    np.testing.assert_allclose(again.doflocs, HALF.doflocs, atol=0.0)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_mesh_and_its_image_are_twice_as_large_and_share_the_mirror(axis):
    box = MeshHex.init_tensor(np.linspace(0, 2, 3), np.linspace(0, 2, 4), np.linspace(0, 1, 2))
    both = both_halves(box, axis)
    assert volume(both) == pytest.approx(8.0, rel=1e-12)
    assert both.p[axis].min() == -2.0
    assert both.nvertices == (5 * 4 if axis == 0 else 3 * 7) * 2
    np.testing.assert_allclose(both.p[:, both.t[:, box.nelements :]][axis], -box.p[:, box.t][axis])


def test_copies_touch_nowhere_and_keep_their_round_sides():
    row = side_by_side([(HALF, (0.0, 0.0)), (HALF, (3.0, 0.0)), (both_halves(HALF), (0.0, 4.0))])
    assert row.nelements == 4 * HALF.nelements
    assert row.doflocs.shape[1] == len(np.unique(Dofs(row, ElementHex2()).element_dofs))  # no node is of no brick
    assert volume(row) == pytest.approx(4.0 * volume(HALF), rel=1e-12)
    assert volume(HALF) == pytest.approx(np.pi / 2.0, rel=2e-3)  # parabolas for eighths of a circle
    assert len(row.boundary_facets()) == 2 * len(HALF.boundary_facets()) + len(both_halves(HALF).boundary_facets())
