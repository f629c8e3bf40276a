"""Families of meshes in line: what one of them has shown of a load that is not carried is not looked for again."""

import numpy as np

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.levels import retry
from sits_mech.mechanics.levels.answer import first_look
from sits_mech.mechanics.rest.control import under
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor


def test_families_of_one_coarse_mesh_look_once(monkeypatch):
    """Gradings differ from the second level on, a guard on the first one, too: of four families two are looked at."""
    line, control, calls = block_pad(load_sensor("biorob2018"), 1e-2).half, under(Wrench(M=0.05)), []

    def counted(*given):
        calls.append(given[0])
        return first_look(*given)

    monkeypatch.setattr(retry, "first_look", counted)
    looks = {}
    assert retry._first_good(line, range(line.free), None, control, looks) is None
    assert calls == [line[0], line[3]] and sorted(looks) == [0, 1, 2, 3]
    again = first_look(line[1], line.scales, None, control, line.most)
    assert looks[1].limit == again.limit and np.array_equal(looks[1].state.u, again.state.u)
