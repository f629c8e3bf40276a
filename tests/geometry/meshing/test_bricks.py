"""Bricks of half a pad: volumes, outlines met by the mesh lines, no cell inside out."""

import numpy as np
import pytest
from skfem import Basis
from skfem.element import ElementHex2

from sits_mech.geometry.meshing.bricks import PlateOutline, box_bricks, covered, ring_bricks

SQUARE, DISC, WIDE = PlateOutline(2.0, 2.0, False), PlateOutline(2.0, 2.0, True), PlateOutline(5.0, 4.0, False)
ROUND = PlateOutline(3.0, 3.0, True)
Z = np.array([0.0, 0.7, 1.0])


def area(outline):
    """Of the whole outline."""
    return (np.pi if outline.is_round else 4.0) * outline.half_x * outline.half_y


@pytest.mark.parametrize(("target", "pad"), [(DISC, WIDE), (DISC, ROUND), (SQUARE, ROUND)])
def test_rings_fill_half_the_pad(target, pad):
    mesh, _ = ring_bricks(target, pad, (np.array([0, 0.8, 1.0]), np.array([0, 0.3, 1.0]), Z), 2)
    basis = Basis(mesh, ElementHex2(), intorder=5)
    assert basis.dx.min() > 0.0
    assert basis.dx.sum() == pytest.approx(area(pad) / 2, rel=2e-4 if pad.is_round else 1e-12)
    x, y, _ = basis.doflocs
    size = np.hypot(x, y) / 2.0 if target.is_round else np.maximum(np.abs(x), np.abs(y)) / 2.0
    assert (np.abs(size - 1.0) < 1e-12).sum() >= 17 * 5  # 8 cells around, 2 through: the nodes on the target's edge
    assert y.min() > -1e-12


@pytest.mark.parametrize(
    ("plate", "pad", "shared"),
    [
        (PlateOutline(5.0, 5.0, True), PlateOutline(3.0, 4.0, False), PlateOutline(3.0, 4.0, False)),
        # 3-4-5: corners on the rim
        (PlateOutline(3.0, 4.0, False), PlateOutline(5.0, 5.0, True), PlateOutline(3.0, 4.0, False)),
        (DISC, WIDE, DISC),
        (WIDE, DISC, DISC),
        (ROUND, PlateOutline(2.5, 2.5, False), None),
        (PlateOutline(2.5, 7.0, False), ROUND, None),
        (PlateOutline(6.0, 3.0, False), WIDE, PlateOutline(5.0, 3.0, False)),
        (ROUND, DISC, DISC),
    ],
)
def test_what_a_target_covers_of_its_pad(plate, pad, shared):
    assert covered(plate, pad) == shared


def test_round_volumes_converge_at_fourth_order():
    errors = []
    for around in (1, 2, 4):
        mesh, _ = ring_bricks(DISC, DISC, (np.array([0.0, 1.0]), np.zeros(1), Z), around)
        errors.append(abs(Basis(mesh, ElementHex2(), intorder=5).dx.sum() / (area(DISC) / 2) - 1.0))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(rates > 3.8)


def test_box():
    mesh, _ = box_bricks(np.array([-1.0, 0.0, 2.0]), np.array([0.0, 1.0]), Z)
    assert Basis(mesh, ElementHex2(), intorder=5).dx.sum() == pytest.approx(3.0)
