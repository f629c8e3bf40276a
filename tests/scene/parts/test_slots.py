"""Slots and walls in a pad: where they are, lines that refuse others."""

import numpy as np
import pytest

from sits_mech.scene.parts.elastomer import Elastomer
from sits_mech.scene.parts.slots import Slot, check_slots

PAD = Elastomer(material="ecoflex-00-30", width=20e-3, length=10e-3, thickness=2e-3)
TARGETS = {"A": np.array([[-8e-3, -3e-3], [-1e-3, 3e-3]]), "B": np.array([[1e-3, -3e-3], [8e-3, 3e-3]])}


def test_a_slot_knows_where_it_is():
    slot, wall = Slot(x=0.5e-3, width=1e-3, depth=1.5e-3), Slot(y=-4e-3, width=1e-3, wall=True)
    assert slot.ends == pytest.approx([0.0, 1e-3], abs=1e-12) and wall.ends == pytest.approx([-4.5e-3, -3.5e-3])
    assert slot.bottom(PAD) == pytest.approx(0.25) and wall.bottom(PAD) == 0.0 and (slot.axis, wall.axis) == (0, 1)
    assert wall.words == "a wall from y = -4.5 mm to -3.5 mm"
    assert not slot.meets(*TARGETS["B"]) and slot.meets(*TARGETS["B"], 1e-6)  # flush
    check_slots((slot, wall), PAD, TARGETS)


@pytest.mark.parametrize(("slots", "line"), [
    ([{"width": 1e-3}], "x or y must be given, of a slot along y or along x; got neither"),
    ([{"x": 0.0, "y": 0.0, "width": 1e-3}], "x or y must be given, of a slot along y or along x; got both"),
    ([{"x": 0.0, "width": 1e-3, "depth": 1e-3, "wall": True}], "depth must be left out of a wall, which stands on the "
     "ground; got 1 mm"),
    ([{"x": 0.0, "width": 1e-3}, {"x": 2e-3, "width": 1e-3}], "slots.1 must lie beside all targets; got a slot from "
     "x = 1.5 mm to 2.5 mm, through targets.B"),
    ([{"x": 0.0, "width": 2e-3, "wall": True}], "slots.0 must lie beside all targets; got a wall from x = -1 mm to 1 "
     "mm, at or through targets.A"),
    ([{"x": 9.5e-3, "width": 1e-3}], "slots.0 must lie within the pad, 20 mm x 10 mm; got a slot from x = 9 mm to 10 "
     "mm"),
    ([{"x": 0.0, "width": 1e-6}], "slots.0.width must be at least 0.002 mm, 0.001 of the pad's thickness; got 0.001 "
     "mm"),
    ([{"x": 0.0, "width": 1e-3, "depth": 3e-3}], "slots.0.depth must be at most the pad's thickness, 2 mm; got 3 mm"),
    ([{"x": 0.0, "width": 1e-3}, {"x": 0.5e-3, "width": 1e-3}], "slots.0 and slots.1 must lie beside each other; got a "
     "slot from x = -0.5 mm to 0.5 mm and a slot from x = 0 mm to 1 mm"),
])
def test_slots_that_cannot_be_are_refused_in_one_line(slots, line):
    with pytest.raises(ValueError, match=line):
        check_slots([Slot(**each) for each in slots], PAD, TARGETS)

