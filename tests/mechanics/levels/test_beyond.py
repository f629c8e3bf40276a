"""Loads far beyond are refused from the first level, by the largest load that holds."""

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.element.assembly import Pattern
from sits_mech.mechanics.equilibrium.control import Control, under
from sits_mech.mechanics.equilibrium.outcome import PathEnd
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.levels.beyond import overload_refusal
from sits_mech.notes import NoteKind
from sits_mech.quantities import SolveFailed, Wrench
from sits_mech.scene.sensor import load_sensor


@pytest.fixture
def sizes(monkeypatch):
    """Unknowns of what is factored, one by one."""
    found, factored = [], Pattern.factored

    def counted(self, values):
        found.append(len(self.free))
        return factored(self, values)

    monkeypatch.setattr(Pattern, "factored", counted)
    return found


@pytest.mark.parametrize(
    ("name", "load", "envelope"),
    [
        ("biorob2018", Wrench(F_z=50.0), 3.04),
        ("biorob2018-w15", Wrench(F_z=67.0), 5.60),
        ("biorob2018-w15", Wrench(F_x=14.0, F_z=42.0), 3.53),
    ],
)
def test_a_load_far_beyond_the_data_is_refused_by_the_first_level(name, load, envelope, sizes):
    """No mesh above 1000 unknowns is factored; the largest load is, within its error, that of `envelope` (0.3)."""
    said = r"within the silicone's data up to F_.* of the path\); this load is too far beyond: .* end at stretch 2$"
    with pytest.raises(SolveFailed, match=said) as ended:
        block_pad(load_sensor(name), 1e-2).equilibrium(load)
    assert max(sizes) < 1000 and len(sizes) < 180
    most, error = (part.F_z for part in ended.value.carried)
    assert abs(most - envelope) <= error + 0.3 and error < 0.35 * most
    assert not any(note.kind is NoteKind.CARRIED for note in ended.value.report.notes)  # finer meshes carry more
    assert "\n" not in str(ended.value) and str(ended.value).count("F_z") == 1


def test_a_section_tells_the_load_at_the_end_of_its_data():
    """Its stretch there is that end, as finer meshes see it."""
    layer = planar_layer(load_sensor("biorob2018"), 1e-2)
    with pytest.raises(SolveFailed) as ended:
        layer.equilibrium(Wrench(F_z=30.0))
    most, error = (part.F_z for part in ended.value.carried)
    ends = [layer.equilibrium(Wrench(F_z=most + side * error)).report.stretch for side in (-1.0, 1.0)]
    assert ends[0] < 2.0 < ends[1]


def test_a_load_beyond_half_of_what_is_carried_is_refused_where_the_second_level_is_slow(sizes):
    """Pulled beyond buckling; within it, and beyond the data by a little, the second level is asked."""
    pad = block_pad(load_sensor("biorob2018"), 1e-2)
    found = overload_refusal(pad.half, None, under(Wrench(F_z=-20.0)))
    assert found is not None and found.reason is PathEnd.BUCKLED and np.isnan(found.limit_point[1])
    assert 0.25 < found.part <= found.limit_point[0] < 0.35 and max(sizes) < 1000
    assert all(overload_refusal(pad.half, None, under(Wrench(F_z=force))) is None for force in (-8.0, 7.0))
    assert overload_refusal(pad.half, None, Control(sink=1e-4)) is None
