"""Forces and places of the target in any mix: round trip, instabilities followed, refusals."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.mechanics.equilibrium.control import Control
from sits_mech.mechanics.equilibrium.outcome import PathEnd
from sits_mech.mechanics.layer import planar_layer
from sits_mech.notes import NoteKind
from sits_mech.quantities import SolveFailed, Wrench
from sits_mech.scene.sensor import load_sensor

MM = 1e-3
NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'


def pad(W, w, t, *more):
    sizes = [f'elastomer.width="{W} mm"', f'elastomer.thickness="{t} mm"', f'target.width="{w} mm"']
    return load_sensor("biorob2018", ["elastomer.length=1.0", NEO_HOOKEAN, *sizes, *more])


def only(layer, number):
    """A layer with one of its pairs of meshes."""
    return replace(layer, line=replace(layer.line, makers=(layer.line.makers[number],) * 2))


@pytest.mark.parametrize("given", [("d_h",), ("sink", "alpha"), ("d_h", "sink", "alpha"), ("alpha",)])
def test_places_found_under_forces_give_the_forces_back(given):
    """The force acts above the bonded face: what is held must know its lever.

    Exact on each mesh; of what is extrapolated, to second order in the error.
    """
    layer, wrench = planar_layer(pad(20, 15, 2), 2e-2), Wrench(60.0, 800.0, 0.2)
    free = layer.equilibrium(wrench)
    places = {"d_h": free.pose.d_h, "sink": 2.0 * MM - free.pose.d_v, "alpha": free.pose.alpha}
    forces = {"d_h": "F_x", "sink": "F_z", "alpha": "M"}
    control = {place: places[place] for place in given}
    control |= {force: getattr(wrench, force) for place, force in forces.items() if place not in given}
    held = layer.controlled(Control(**control))
    near = 0.05 * (free.report.estimated_error + held.report.estimated_error)
    for force in forces.values():
        assert getattr(held.wrench, force) == pytest.approx(getattr(wrench, force), rel=near)
    assert held.pose.alpha == pytest.approx(free.pose.alpha, rel=near)


@pytest.mark.slow
def test_tall_block_is_followed_past_its_largest_load():
    """Pressed with its tilt free a block as high as wide gives way sideways; with d_h given it is followed on."""
    layer = planar_layer(pad(6, 6, 6), 2e-2)
    with pytest.raises(SolveFailed, match="could be followed to") as caught:
        layer.equilibrium(Wrench(1.0, 300.0))
    largest = caught.value.last.wrench.F_z
    pressed, found = [], None
    for d_h in (0.5, 1.0, 2.0):
        found = layer.controlled(Control(d_h=d_h * MM, sink=1.5 * MM, M=0.0), start=found)
        pressed.append(found.wrench.F_x)
    assert pressed[-1] < 0.0  # it must be held back: the load has passed the critical one
    assert found.wrench.F_z > 0.5 * largest


def test_tilt_is_given_and_the_moment_found():
    layer = planar_layer(pad(20, 15, 2), 2e-2)
    held = layer.controlled(Control(alpha=0.02))
    free = layer.equilibrium(Wrench(M=held.wrench.M))
    near = 0.05 * (free.report.estimated_error + held.report.estimated_error)
    assert free.pose.alpha == pytest.approx(0.02, rel=near)
    assert held.error.alpha == 0.0 and held.report.estimated_error > 0.0


@pytest.mark.slow
def test_a_held_path_that_ends_gives_back_the_last_state():
    layer = planar_layer(pad(15, 15, 3, 'elastomer.contact="always"'), 2e-2)
    with pytest.raises(SolveFailed, match="sink = 0.00294") as caught:
        only(layer, 1).controlled(Control(d_h=0.0, sink=2.94 * MM, alpha=0.0))
    last = caught.value.last
    assert last.report.min_J > 0.0 and 0.5 * MM < 3.0 * MM - last.pose.d_v < 2.94 * MM
    (end,) = (note.known["end"] for note in last.report.notes if note.kind is NoteKind.PATH_END)
    assert end in (PathEnd.INVERTED, PathEnd.LOST, PathEnd.TURNED)


def test_refusals():
    with pytest.raises(ValueError, match="F_x and d_h"):
        Control(F_x=1.0, d_h=1e-3)
    with pytest.raises(ValueError, match="sink must be a finite number"):
        Control(sink=np.inf)
    layer = planar_layer(pad(20, 15, 2), 2e-2)
    for name in ("F_y", "d_y", "alpha_z"):
        with pytest.raises(ValueError, match=f"wrench: {name} must be zero for the model planar, which is plane"):
            layer.controlled(Control(F_z=1.0, **{name: 1e-3}))
    for found in (layer.equilibrium, lambda load: layer.along([load])):
        with pytest.raises(ValueError, match="wrench: F_y, M_z must be zero for the model planar"):
            found(Wrench(F_y=1.0, M_z=1.0))
        with pytest.raises(ValueError, match="wrench: must be finite numbers"):
            found(Wrench(F_x=np.nan))


def test_a_path_without_a_load_is_at_rest():
    layer = planar_layer(pad(20, 15, 2), 2e-2)
    assert layer.along([]).pose == layer.equilibrium(Wrench()).pose


@pytest.mark.slow
def test_law_that_is_unstable_where_it_was_used_is_named():
    """Yeoh with c20/c10 = -1/5: planar tension fails first, at stretch 1.556 (stability.py has its own test)."""
    falling = 'elastomer.material={law="yeoh", c10=1.5e4, c20=-3e3, c30=0, bulk_modulus=3e7}'
    layer = planar_layer(pad(20, 15, 2, falling, 'elastomer.contact="never"'), 2e-2)
    layer = only(layer, -1)
    small = layer.controlled(Control(d_h=0.3 * MM, sink=0.0, alpha=0.0))
    assert not any(note.kind is NoteKind.LAW_END for note in small.report.notes)
    with pytest.raises(SolveFailed) as caught:
        layer.controlled(Control(d_h=1.0 * MM, sink=0.0, alpha=0.0), start=small)
    law = next(note for note in caught.value.report.notes if note.kind is NoteKind.LAW_END)
    assert law.known["stretch"] == pytest.approx(1.556, abs=5e-4) and law.known["mode"] == "planar tension"
    assert "unstable from stretch 1.556 on in planar tension" in str(caught.value)
