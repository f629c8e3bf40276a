"""Families of meshes: what one of them has shown of a load that is not carried is not looked for again."""

import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.equilibrium.control import under
from sits_mech.mechanics.levels import settle
from sits_mech.mechanics.levels.answer import first_look
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor


@pytest.mark.slow
def test_a_load_that_is_not_carried_is_looked_at_once_on_each_family(monkeypatch):
    """Without contact and, as faces touch, with it."""
    line, control, calls = block_pad(load_sensor("biorob2018"), 1e-2).half, under(Wrench(M=0.05)), []

    def counted(*given):
        calls.append(given[1])
        return first_look(*given)

    monkeypatch.setattr(settle, "first_look", counted)
    assert settle.settled(line, None, control).part < 1.0
    assert calls == [line[number] for number in range(4)]
