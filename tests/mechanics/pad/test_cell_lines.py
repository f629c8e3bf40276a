"""Lines of a pad under several targets: at every side, graded towards singular ones, none within a slot through it."""

import numpy as np
import pytest

from sits_mech.mechanics.pad.cell_lines import cell_lines, in_slots
from sits_mech.scene.cells import load_cells

KEYS = [
    'coils=[{name="C", centre=[0, 0], turns=4, layers=2, inner_diameter="1 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}]', 'elastomer.width="30 mm"',
    'targets=[{name="A", centre=["-5 mm", 0]}, {name="B", centre=["4 mm", 0], width="6 mm", length="5 mm"}]',
]


def lines(*keys, split=2, layers=1):
    cells = load_cells("biorob2018", [*KEYS, *keys])
    return cells, [2.0 * own for own in cell_lines(cells, split, layers)]  # mm


def holds(lines, *places):
    return np.abs(np.subtract.outer(places, lines)).min(axis=1) == pytest.approx(0.0, abs=1e-12)


def test_every_side_of_every_target_has_a_line():
    _, (x, y, z) = lines()
    assert holds(x, -15.0, -9.0, -1.0, 1.0, 7.0, 15.0) and holds(y, -10.0, -4.0, -2.5, 2.5, 4.0, 10.0)
    assert all(np.all(np.diff(own) > 0.0) for own in (x, y, z))


def test_sides_that_nearly_agree_have_one_line():
    _, (_, y, _) = lines('targets.B.length="8.0001 mm"')
    _, (_, alike, _) = lines('targets.B.length="8 mm"')
    assert len(y) == len(alike)


def test_a_slot_through_the_pad_is_one_cell_and_parts_it():
    cells, (x, _, _) = lines('slots=[{x=0, width="0.5 mm"}]')
    low, high = (int(np.abs(x - at).argmin()) for at in (-0.25, 0.25))
    assert high == low + 1 and holds(x, -0.25, 0.25)
    near = np.array([[-0.2, 0.0, 0.1], [0.2, 0.0, 1.9], [0.3, 0.0, 1.0]]) / 2.0
    assert in_slots(cells.slots, cells.pad, near).tolist() == [True, True, False]


def test_a_slot_of_a_depth_has_a_line_at_its_bottom_and_lines_within():
    cells, (x, _, z) = lines('slots=[{x=0, width="0.5 mm", depth="0.7 mm"}]')
    _, (_, _, without) = lines()
    assert holds(z, 1.3) and not holds(without, 1.3) and np.count_nonzero(np.abs(x) < 0.24) > 1
    assert in_slots(cells.slots, cells.pad, np.array([[0.0, 0.0, 0.64], [0.0, 0.0, 0.66]])).tolist() == [False, True]
