"""Bricks of pillars: as many as stand at y >= 0, halves on the plane, nested when split."""

import numpy as np
import pytest
from scipy.spatial import cKDTree
from skfem import Basis
from skfem.element import ElementHex2

from sits_mech.geometry.meshing.bricks import PlateOutline, pillar_bricks

DISC = PlateOutline(0.5, 0.5, True)
LINES = (np.array([0.0, 0.6, 1.0]), np.array([0.0, 0.4, 1.0]))
GRID = tuple((x, y) for x in (-2.0, 0.0, 2.0) for y in (-2.0, 0.0, 2.0))


def split_lines(lines, m):
    """Every cell in m even parts."""
    return np.interp(np.arange(m * (len(lines) - 1) + 1) / m, np.arange(len(lines)), lines)


def test_nine_pillars_are_three_halves_and_three_whole_ones():
    mesh, division = pillar_bricks(DISC, GRID, LINES, 2, 2)
    area = Basis(mesh, ElementHex2(), intorder=6).dx.sum()
    assert division.bases == mesh.nelements // 8 == 9 * (2 + 4)  # halves: of the core, around it
    assert area == pytest.approx(4.5 * np.pi * 0.25, rel=1e-4)
    assert mesh.p[1].min() == 0.0 and mesh.p[1].max() == 2.5 and mesh.p[0].min() == -2.5


def test_split_pillars_are_nested():
    (coarse, _), (fine, _) = (
        pillar_bricks(DISC, GRID[:2], tuple(split_lines(own, m) for own in LINES), m, m) for m in (1, 2)
    )
    assert fine.nelements == 8 * coarse.nelements
    near = cKDTree(fine.p.T).query(coarse.p.T)[0]
    assert near.max() < 1e-12
