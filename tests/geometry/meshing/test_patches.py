"""Bricks over plans of four-sided patches: areas by hand, sides shared, curves followed."""

import numpy as np
import pytest
from skfem import Basis
from skfem.element import ElementHex2

from sits_mech.geometry.meshing.crossing import QuadPatch, arc, part, patch_bricks, straight

EVEN = np.linspace(0.0, 1.0, 4)
Z = np.array([0.0, 0.3, 1.0])


def volume(mesh):
    return float(Basis(mesh, ElementHex2(), intorder=6).dx.sum())


def points(*places):
    return [np.array(place, dtype=float) for place in places]


def test_two_patches_side_by_side_share_their_corners_and_fill_a_trapezium():
    a, b, c, d, e, f = points((0, 0), (1, 0), (3, 0), (0, 1), (1, 1.5), (3, 2.5))
    left = QuadPatch(straight(a, b), straight(d, e), straight(a, d), straight(b, e), EVEN, EVEN)
    right = QuadPatch(straight(b, c), straight(e, f), straight(b, e), straight(c, f), EVEN, EVEN)
    mesh, division = patch_bricks([left, right], Z)
    assert volume(mesh) == pytest.approx(3.0 * (1.0 + 2.5) / 2.0, rel=1e-12)
    assert mesh.nelements == division.bases == 2 * 9 * 2
    assert mesh.nvertices == (7 * 4) * 3  # 4 lines across and 7 along, at three heights
    sides = 2 * (2 * 9) + 2 * (2 * 6 + 2 * 3)  # lower and upper faces of the cells; around, in two layers
    assert len(mesh.boundary_facets()) == sides


def test_a_quarter_of_a_ring_has_its_area_at_fourth_order():
    (a, b), (c, d) = points((1, 0), (0, 1)), points((2, 0), (0, 2))
    areas = []
    for count in (2, 4):
        even = np.linspace(0.0, 1.0, count + 1)
        ring = QuadPatch(arc(a, b), arc(c, d), straight(a, c), straight(b, d), even, even)
        areas.append(volume(patch_bricks([ring], Z)[0]))
    wrong = np.abs(np.array(areas) - 0.75 * np.pi)
    assert wrong[0] < 2e-3 and wrong[0] / wrong[1] == pytest.approx(16.0, rel=0.1)  # parabolas for arcs: h^4


def test_bricks_lie_in_those_of_the_base():
    """Of a patch with four lines, every second of which is of the base: corners where the division says."""
    a, b, c, d = points((0, 0), (6, 0), (0, 2), (6, 2))
    s, t, z = np.array([0.0, 0.1, 0.5, 0.8, 1.0]), np.array([0.0, 0.6, 1.0]), np.array([0.0, 0.3, 1.0])
    mesh, own = patch_bricks([QuadPatch(straight(a, b), straight(c, d), straight(a, c), straight(b, d), s, t)], z, 2)
    assert own.bases == 2
    low = mesh.p[:, mesh.t].min(axis=1).T
    np.testing.assert_allclose((low - np.outer(own.base, [3.0, 0.0, 0.0])) / (3.0, 2.0, 1.0), own.low, atol=1e-12)
    np.testing.assert_array_equal(np.sort(own.part[own.base == 1], axis=0), np.sort(own.part[own.base == 0], axis=0))


def test_part_of_a_curve_runs_backwards_where_its_ends_do():
    way = straight(*points((0, 0), (4, 2)))
    np.testing.assert_allclose(part(way, 0.75, 0.25)(np.array([0.0, 1.0])), [[3, 1.5], [1, 0.5]])
