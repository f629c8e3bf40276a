"""Layers with friction: no different without touching, path dependent with it, in the plane as in space."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.equilibrium.body import rest
from sits_mech.mechanics.equilibrium.control import Control
from sits_mech.mechanics.equilibrium.increments import Friction
from sits_mech.mechanics.equilibrium.outcome import Path
from sits_mech.mechanics.equilibrium.path import advance
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.mechanics.pad.solid import bonded_block
from sits_mech.memory import SECONDS
from sits_mech.notes import NoteKind
from sits_mech.quantities import PathModel, SolveFailed, Wrench
from sits_mech.scene.sensor import load_sensor
from sits_mech.units import SceneError

NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'
ROUGH = "elastomer.friction=0.5"


def pad(width, target, t, *more):
    sizes = [f'elastomer.width="{width} mm"', f'elastomer.thickness="{t} mm"', f'target.width="{target} mm"']
    return load_sensor("biorob2018", ["elastomer.length=1.0", "target.load_height=0", NEO_HOOKEAN, *sizes, *more])


def test_friction_of_faces_that_touch_nothing_changes_no_digit():
    load, via = Wrench(60.0, 200.0), Wrench(F_x=60.0)
    smooth, rough = (planar_layer(pad(20, 15, 2, *more)) for more in ((), (ROUGH,)))
    expected = smooth.equilibrium(load)
    for found in (rough.equilibrium(load), rough.along([via, load])):
        assert found.pose == expected.pose and found.error == expected.error
        assert not any(note.kind is NoteKind.FRICTION_PATH or "friction" in note.known for note in found.report.notes)


@pytest.mark.slow
def test_a_coefficient_of_zero_changes_no_digit():
    load = Wrench(40.0, 900.0)
    never_written, zero = (planar_layer(pad(9, 9, 3, *more)).rough for more in ((), ("elastomer.friction=0",)))
    expected, found = never_written.equilibrium(load), zero.equilibrium(load)
    assert any(note.known.get("friction") == 0.0 for note in expected.report.notes)
    assert found.pose == expected.pose and found.error == expected.error


@pytest.mark.slow
def test_the_pad_in_space_takes_friction_alike():
    """The same digits where nothing touches, in half a pad and in a whole one."""
    smooth, rough = (block_pad(load_sensor("biorob2018-w15", more)) for more in ((), (ROUGH,)))
    load = Wrench(F_x=0.2, F_z=0.5)
    assert isinstance(rough, PathModel)
    assert rough.along([Wrench(F_z=0.5), load]).pose == smooth.equilibrium(load).pose


@pytest.mark.slow
def test_the_way_of_the_load_decides_where_faces_touch():
    """A flush layer whose sides bulge onto both planes: stiffer against pressing, and another place by each way."""
    load, layer = Wrench(40.0, 900.0), planar_layer(pad(9, 9, 3, ROUGH)).rough
    smooth = planar_layer(pad(9, 9, 3)).rough.equilibrium(load)
    straight = layer.equilibrium(load)
    pressed, drawn = (layer.along([via, load]) for via in (Wrench(F_z=900.0), Wrench(F_x=40.0)))
    for found in (straight, pressed, drawn):
        assert found.report.min_J > 0.0
        assert sum(note.known.get("friction") == 0.5 for note in found.report.notes) == 2
        assert found.pose.d_v > smooth.pose.d_v
    assert any(note.kind is NoteKind.FRICTION_PATH and note.known["legs"] == 1 for note in straight.report.notes)
    assert any(note.kind is NoteKind.FRICTION_PATH and note.known["legs"] > 1 for note in pressed.report.notes)
    assert abs(pressed.pose.d_h - drawn.pose.d_h) > 1e-6
    again = layer.equilibrium(load, start=pressed)  # a neighbour's state is no beginning of a path
    assert again.pose == straight.pose


@pytest.mark.slow
def test_more_increments_stay_within_the_error():
    """The share that the increments are said to be worth holds what four times as many change, on the first mesh."""
    layer = planar_layer(pad(9, 9, 3, ROUGH)).rough
    body = layer.line[layer.line.last[0]].coarse
    load = layer.line.scales.load(Wrench(40.0, 900.0))[:3]
    path = Path((np.zeros(3), load))
    places = [advance(body, rest(body), path, Friction, parts=parts).state.q for parts in (4, 8, 32)]
    said, left = (np.abs(places[k] - places[1]).max() for k in (0, 2))
    assert left < 2.0 * said + 1e-4 * np.abs(places[1]).max()


@pytest.mark.slow
def test_a_slab_that_cannot_move_sideways_is_the_layer_in_plane_strain():
    """Forces of a flush pad pressed and drawn on both planes with friction, y held; the layer's own error is 1 %.

    Without friction it takes 3 % less to press both; that is seen in space within a fifth of it.
    """
    sides = [f'{part}.{side}="15 mm"' for part in ("elastomer", "target") for side in ("width", "length")]
    sizes = [*sides, 'elastomer.thickness="3 mm"']
    way, held = [np.zeros(3), np.array([0.0, -0.2, 0.0]), np.array([0.3, -0.2, 0.0])], np.ones(3, dtype=bool)
    found = {}
    for friction in ("elastomer.friction=0", ROUGH):
        scene = load_sensor("biorob2018", ["target.load_height=0", NEO_HOOKEAN, *sizes, friction])
        solid = bonded_block(scene, 3, 1.5, 0.0, 1e-4).body
        flat = replace(solid, free=solid.free[solid.free % 3 != 1], shared=None, hidden=None)
        section = bonded_body(pad(15, 15, 3, friction), SectionFineness(8, 1.5, fan=True, depth=1e-5))
        tracks = [advance(body, rest(body), Path(way, held), Friction, parts=4) for body in (flat, section)]
        assert all(track.reached == 2.0 for track in tracks)
        found[friction] = [track.state.load[:2] / depth for track, depth in zip(tracks, (2.5, 1.0), strict=True)]
        np.testing.assert_allclose(*found[friction], rtol=0.02)
    stiffer = [with_it[1] - without[1] for without, with_it in zip(*found.values(), strict=True)]
    assert stiffer[0] == pytest.approx(stiffer[1], rel=0.2) and stiffer[1] > 1.0


def test_a_path_with_friction_keeps_to_the_limit_of_time(monkeypatch):
    """Its increments, too; it says where it stands."""
    line = planar_layer(pad(9, 9, 3, ROUGH), 1e-2)
    monkeypatch.setenv(SECONDS.variable, "0.2")
    with pytest.raises(SolveFailed, match=r"\(--seconds\)"):
        line.equilibrium(Wrench(40.0, 900.0))


def test_places_of_the_way_must_be_those_of_the_end():
    layer = planar_layer(pad(9, 9, 3, ROUGH))
    with pytest.raises(ValueError, match="via: must give the same forces and places"):
        layer.controlled(Control(d_h=1e-4), via=[Control(F_x=1.0)])


def test_friction_without_contact_is_refused():
    with pytest.raises(SceneError, match=r'friction must be 0 where contact is "never"'):
        pad(9, 9, 3, ROUGH, 'elastomer.contact="never"')
    with pytest.raises(SceneError, match="friction: must be zero or a coefficient"):
        pad(9, 9, 3, "elastomer.friction=-0.1")


@pytest.mark.slow
def test_a_path_that_ends_says_how_far_it_came():
    """A square section buckles; the last rest is told, and no state that would be taken for an answer."""
    layer = planar_layer(pad(6, 6, 3, ROUGH)).rough
    with pytest.raises(SolveFailed, match=r"could be followed to .* of the path") as error:
        layer.equilibrium(Wrench(F_z=900.0))
    assert error.value.last is not None and error.value.last.report.estimated_error == 1.0
