"""Families of meshes in line: what one of them has shown of a load that is not carried is not looked for again."""


from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.levels import retry
from sits_mech.mechanics.levels.answer import first_look
from sits_mech.mechanics.rest.control import under
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor


def test_a_load_that_is_not_carried_is_looked_at_once_with_each_guard(monkeypatch):
    """A load that is not carried: one look with each guard."""
    line, control, calls = block_pad(load_sensor("biorob2018"), 1e-2).half, under(Wrench(M=0.05)), []

    def counted(*given):
        calls.append(given[0])
        return first_look(*given)

    monkeypatch.setattr(retry, "first_look", counted)
    looks = {}
    assert retry._first_good(line, range(line.free), None, control, looks) is None
    assert calls == [line[0], line[1]] and sorted(looks) == [0, 1]
