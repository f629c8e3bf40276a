"""Bricks where the rims of a disc and a rectangle cross: areas by closed form, nested meshes, thin tips refused."""

from math import acos, pi, sqrt

import numpy as np
import pytest
from scipy.spatial import cKDTree
from skfem import Basis
from skfem.element import ElementHex2

from sits_mech.geometry.meshing.bricks import PlateOutline, inside_outline
from sits_mech.geometry.meshing.crossing import crossing_bricks

LINES = (np.linspace(0.0, 1.0, 4) ** 0.5, np.linspace(0.0, 1.0, 3) ** 2, np.array([0.0, 0.6, 1.0]))
DISC = PlateOutline(5.0, 5.0, True)
BOXES = [PlateOutline(*size, False) for size in ((4.0, 4.0), (4.0, 6.0), (6.0, 4.0), (4.5, 3.5))]
PAIRS = [pair for box in BOXES for pair in ((DISC, box), (box, DISC))]


def split_lines(lines, m):
    """Every cell in m even parts."""
    return np.interp(np.arange(m * (len(lines) - 1) + 1) / m, np.arange(len(lines)), lines)


def shared(disc, box):
    """Area that a disc and a rectangle share whose corners are outside: the disc less its segments beyond the sides."""
    r = disc.half_x
    beyond = (2.0 * (r**2 * acos(w / r) - w * sqrt(r**2 - w**2)) for w in (box.half_x, box.half_y) if w < r)
    return pi * r**2 - sum(beyond)


@pytest.mark.parametrize(("target", "pad"), PAIRS)
def test_the_whole_pad_is_meshed_and_what_is_bonded_has_its_area(target, pad):
    mesh, _ = crossing_bricks(target, pad, LINES, 2)
    basis = Basis(mesh, ElementHex2(), intorder=6)
    whole = pi * pad.half_x**2 if pad.is_round else 4.0 * pad.half_x * pad.half_y
    assert basis.dx.sum() == pytest.approx(whole / 2.0, rel=1e-5)  # half of it; parabolas for arcs
    assert mesh.p[1].min() == 0.0
    over = np.all([inside_outline(target, corner.T, 1e-9) for corner in mesh.p[:, mesh.t].swapaxes(0, 1)], axis=0)
    disc, box = (target, pad) if target.is_round else (pad, target)
    assert basis.dx[over].sum() == pytest.approx(shared(disc, box) / 2.0, rel=1e-5)


@pytest.mark.parametrize(("target", "pad"), PAIRS[:4])
def test_split_cells_are_nested_and_fit_each_other(target, pad):
    (coarse, base), (fine, division) = (
        crossing_bricks(target, pad, tuple(split_lines(own, m) for own in LINES), m, m) for m in (1, 2)
    )
    assert base.bases == division.bases == coarse.nelements
    assert fine.nelements == 8 * coarse.nelements
    assert len(fine.boundary_facets()) == 4 * len(coarse.boundary_facets())  # no faces within, where cells misfit
    near = cKDTree(fine.p.T).query(coarse.p.T)[0]
    assert near.max() < 1e-12


def test_thin_tips_are_refused():
    with pytest.raises(ValueError, match=r"not cross at less than 10 deg; they do at 8.11 deg, .* along x"):
        crossing_bricks(DISC, PlateOutline(4.95, 6.0, False), LINES, 1)
    with pytest.raises(ValueError, match=r"so near the rim of the disc: .* share 0.01\d radii"):
        crossing_bricks(PlateOutline(3.0, 4.05, False), DISC, LINES, 1)
