"""Bricks of a pad and its cover, the target left out: volumes, points, base cells."""

import numpy as np
import pytest
from skfem import Basis
from skfem.element import ElementHex2

from sits_mech.geometry.meshing.bricks import PlateOutline, box_bricks, ring_bricks
from sits_mech.geometry.meshing.inclusion import Inclusion, hollowed

SQUARE, DISC = ((PlateOutline(1.0, 1.0, r), PlateOutline(2.0, 2.0, r)) for r in (False, True))
Z = np.array([0.0, 0.5, 1.0, 1.1, 1.2, 1.6, 2.0])
X = np.array([-3.0, -2.0, -1.5, -1.0, 0.0, 1.0, 1.5, 2.0, 3.0])


def meshed(target, cover, pad):
    if not target.is_round:
        return box_bricks(X, X[4:], Z, (X[[0, 1, 3, 5, 7, 8]], X[[4, 5, 7, 8]], Z[::2]))
    return ring_bricks(target, pad, (np.array([0.0, 1.0]), np.array([0.0, 1.0, 2.0]), Z), 2, cover=cover)


@pytest.mark.parametrize(("outlines", "pad"), [
    (SQUARE, PlateOutline(3.0, 3.0, False)), (DISC, PlateOutline(3.0, 3.0, True)),
    (DISC, PlateOutline(3.0, 2.5, False)),
])
def test_what_is_left_is_pad_and_cover_without_the_target(outlines, pad):
    mesh, division = hollowed(*meshed(*outlines, pad), Inclusion(*outlines, 1.0, 1.2).filled)
    dx = Basis(mesh, ElementHex2(), intorder=5).dx
    target, cover, below = ((np.pi if each.is_round else 4.0) * each.half_x * each.half_y for each in (*outlines, pad))
    assert dx.min() > 0.0
    assert 2.0 * dx.sum() == pytest.approx(below + cover * 1.0 - target * 0.2, rel=2e-3 if pad.is_round else 1e-3)
    corners = mesh.t.max() + 1
    assert np.array_equal(np.unique(mesh.t), np.arange(corners))  # no point is left over
    assert np.array_equal(np.unique(division.base), np.arange(division.bases)) and len(division.base) == mesh.t.shape[1]


def test_every_part_of_a_base_cell_is_left_or_none():
    mesh, division = hollowed(*meshed(*SQUARE, PlateOutline(3.0, 3.0, False)), Inclusion(*SQUARE, 1.0, 1.2).filled)
    size = (division.high - division.low).prod(axis=1)
    assert np.bincount(division.base, size) == pytest.approx(1.0, rel=1e-12)
