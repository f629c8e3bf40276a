"""Contact of the 3D pad's free faces: derivatives, the layer in plane strain, work, what the answer hangs on."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad, solved_body
from sits_mech.mechanics.element.kernel import element_forces
from sits_mech.mechanics.element.target import moved
from sits_mech.mechanics.equilibrium.body import rest
from sits_mech.mechanics.equilibrium.outcome import Path
from sits_mech.mechanics.equilibrium.path import advance
from sits_mech.mechanics.faces.contact import Contact
from sits_mech.mechanics.pad import families
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.mechanics.pad.solid import bonded_block
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import Elastomer, Target, load_sensor
from tests.mechanics.derivatives import check_faces, shaken

MM = 1e-3
HELD = np.ones(3, dtype=bool)
TURNED = (0.02, -0.01, 0.002, -0.01, 0.003, -0.2)
NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'


def scene(pad, target, t=2.0):
    """A pad of one size or two [mm], a diameter or width and length, under a target; the force acts at its bottom."""
    base = load_sensor("biorob2018", ["target.load_height=0", NEO_HOOKEAN])
    outline = [dict(zip(("width", "length") if len(size) == 2 else ("diameter",), (each * MM for each in size),
                        strict=True)) for size in (pad, target)]
    shape = {"shape": "disc" if len(target) == 1 else "rectangle", "material": "copper", "load_height": 0.0}
    plate = Target.model_validate({**outline[1], **shape, "thickness": 0.2 * MM})
    layer = Elastomer.model_validate({**outline[0], "material": base.elastomer.material, "thickness": t * MM})
    return base.model_copy(update={"target": plate, "elastomer": layer})


@pytest.mark.parametrize(
    ("pad", "target", "plane", "q", "lift"),
    [
        ((8, 8), (8, 8), "ground", (0.05, -0.2, 0.1), -0.3),
        ((8, 8), (8, 8), "plane", (0.05, -0.2, 0.1), 0.1),
        ((8, 6), (5, 3), "wall", (0.02, -0.01, 0.001), 0.008),
        ((8,), (8,), "plane", (0.05, -0.2, 0.1), 0.1),
        ((8,), (5,), "wall", (0.02, -0.01, 0.001), 0.008),
        ((8, 8), (8, 8), "ground", TURNED, -0.3),
        ((8, 8), (8, 8), "plane", TURNED, 0.1),
        ((8, 6), (5, 3), "wall", TURNED, 0.008),
    ],
)
def test_contact_has_an_exact_tangent(pad, target, plane, q, lift):
    """Forces along du, dc and dw, and how they change in the fixed frame; of half a pad in its plane alone."""
    body = bonded_block(scene(pad, target), 2, 1.5, 0.0, 0.05).body
    contact = next(part for part in body.parts if isinstance(part, Contact) and part.plane == plane)
    u, v = shaken(body, plane, lift)
    if len(q) == 3:
        v[-3:] = 0.0
    check_faces(contact, u, np.array(q), v, moved if len(q) == 6 else lambda q, step: q + step[:3])


@pytest.mark.parametrize(("plane", "axis"), [("ground", 2), ("mirror", 1)])
def test_a_plane_that_stands_pushes_by_the_depth_of_each_point(plane, axis):
    """Ground and plane of symmetry: p = d^2/2 up to the contact depth, d - 1/2 beyond, d in depths below the plane."""
    body = bonded_block(scene((8, 8), (8, 8)), 2, 1.5, 0.0, 0.05).body
    sides = next(part for part in body.parts if isinstance(part, Contact) and part.plane == "ground")
    u, q, along = np.zeros(body.mesh.nodes.size), np.zeros(3), np.zeros(body.mesh.nodes.size)
    along[axis::3] = 1.0
    places = sides.surface.places(u)[..., axis]
    level = 0.0 if plane == "ground" else float(places.min())
    contact = replace(sides, plane=plane, level=level)
    for shift in (0.02, 0.3):
        d = np.maximum((level - places + shift) / contact.depth, 0.0)
        pressure = np.where(d < 1.0, d**2 / 2.0, d - 0.5)
        assert (pressure > 0.0).any()
        found = contact(u - shift * along, q).forces[: u.size] @ along
        assert -found == pytest.approx(float((contact.surface.weight * pressure).sum()), rel=1e-12)


def pressed(body, *places):
    """The state at the last of some places of the target, all held, on the way from rest."""
    state, before = rest(body), np.zeros(3)
    for place in map(np.array, places):
        found = advance(body, state, Path((before, place), HELD))
        assert found.reached == 1.0 and found.state.min_J > 0.0
        state, before = found.state, place
    return state


def stored(body, state):
    elements = element_forces(body.mesh, body.laws, state.u).energy
    return elements + sum(part(state.u, state.q).energy for part in body.parts)


@pytest.mark.slow
@pytest.mark.parametrize("shear", [0.0, 0.3])
def test_a_slab_that_cannot_move_sideways_is_the_layer_in_plane_strain(shear):
    """Forces of a flush pad with its faces on both planes, y held; the layer's own error is below 1 %."""
    solid = bonded_block(scene((15, 15), (15, 15), 3.0), 3, 1.5, 0.0, 1e-4)
    flat = replace(solid.body, free=solid.body.free[solid.body.free % 3 != 1], shared=None, hidden=None)
    place = (shear, -0.2, 0.0)
    state = pressed(flat, place)
    load = state.load / 2.5  # per depth, of the half that is meshed
    assert all(part(state.u, state.q).energy > 0.0 for part in flat.parts if isinstance(part, Contact))
    long = load_sensor(
        "biorob2018", ["elastomer.length=1.0", "target.load_height=0", NEO_HOOKEAN, 'elastomer.width="15 mm"',
                       'elastomer.thickness="3 mm"', 'target.width="15 mm"'])
    layer = bonded_body(long, SectionFineness(8, 1.5, fan=True, depth=1e-5))
    expected = pressed(layer, place).load
    np.testing.assert_allclose(load[[0, 1]], expected[[0, 1]], rtol=0.03, atol=1e-6)
    free = replace(flat, parts=())
    away = abs(pressed(free, place).load[1] / 2.5 - expected[1])
    assert away > 2.0 * abs(load[1] - expected[1])  # without contact it is another pad


PRESSED = [((15, 15), (15, 15), 3.0, (0.2, -0.2, 0.0)), ((15,), (15,), 3.0, (0.2, -0.2, 0.0))]


@pytest.mark.slow
@pytest.mark.parametrize(("pad", "target", "t", "place"), PRESSED)
def test_moment_identity_holds_with_contact(pad, target, t, place):
    """Exact for a pad that is its own image under a half turn: |M| = (F_x (t - sink) + F_z d_h)/2."""
    body = bonded_block(scene(pad, target, t), 2, 1.5, 0.0, 1e-4).body
    state = pressed(body, place)
    planes = [part for part in body.parts if getattr(part, "plane", "") in ("ground", "plane")]
    assert len(planes) == 2 and all(part(state.u, state.q).energy > 1e-10 for part in planes)
    F_x, F_z, M = state.load
    assert abs(M) == pytest.approx((F_x * (1.0 + place[1]) + F_z * place[0]) / 2, rel=1e-6)


@pytest.mark.parametrize(
    ("pad", "target", "place"),
    [
        pytest.param((15, 15), (15, 15), (0.2, -0.3, 0.02), marks=pytest.mark.slow),
        ((12, 12), (8, 8), (0.6, -0.2, 0.1)),
        pytest.param((20,), (8,), (0.5, -0.2, 0.0), marks=pytest.mark.slow),
    ],
)
def test_forces_are_the_slope_of_the_energy_with_contact(pad, target, place):
    t, h = (3.0 if pad == target else 2.0), 1e-4
    body = bonded_block(scene(pad, target, t), 2, 2.0, 0.0, 1e-2).body
    middle = pressed(body, place)
    assert any(part(middle.u, middle.q).energy > 1e-8 for part in body.parts)
    way = np.array([0.5, -1.0, 0.3])
    up, down = (
        stored(body, advance(body, middle, Path((np.array(place), np.array(place) + s * h * way), HELD)).state)
        for s in (1, -1)
    )
    forces = middle.load * [1.0, -1.0, 1.0]  # on d_h, d_z, alpha; the force acts at the bonded face
    assert (up - down) / (2 * h) == pytest.approx(forces @ way, rel=1e-5)


@pytest.mark.slow
def test_faces_of_a_flush_pad_lie_on_both_planes():
    sensor, wrench = scene((15, 15), (15, 15), 3.0), Wrench(F_z=55.0)
    pad = block_pad(sensor)
    found = pad.equilibrium(wrench)
    assert sum(note.known.get("friction") == 0.0 for note in found.report.notes) == 2
    body = solved_body(pad, found)
    u, q = np.split(found.state[1:], [body.mesh.nodes.size])
    z = (body.mesh.nodes + u.reshape(-1, 3))[body.faces.nodes, 2]
    assert z.min() > -0.02 and z.max() < 1.0 + q[1] + 0.02  # nodes; what is held is the points between them
    points = body.parts[0].surface.places(u)
    assert points[..., 2].min() > -3e-3 and points[..., 2].max() < 1.0 + q[1] + 3e-3  # 30 shear moduli press
    assert 0.28 < -q[1] < 0.32


@pytest.mark.slow
def test_contact_stiffens_a_flush_pad():
    """Beside its answer without contact, on one mesh."""
    sensor = scene((15, 15), (15, 15), 3.0)
    pad = block_pad(sensor)
    never = block_pad(sensor.model_copy(update={"elastomer": sensor.elastomer.model_copy(update={"contact": "never"})}))
    free = never.equilibrium(Wrench(F_z=28.0))
    assert any(note.kind is NoteKind.FACE_FOLDS for note in free.report.notes)
    touching = pad.equilibrium(Wrench(F_z=28.0))
    size = solved_body(pad, touching).mesh.nodes.size
    assert free.state[2 + size] < touching.state[2 + size] < 0.0  # contact stiffens, on one mesh
    assert abs(free.pose.d_v - touching.pose.d_v) < free.error.d_v + touching.error.d_v


@pytest.mark.slow
@pytest.mark.parametrize("depth", [5e-5, 2e-4])
def test_the_answer_hangs_on_the_contact_depth_less_than_its_error(depth, monkeypatch):
    """Half and twice of it, each answer on the meshes that get there."""
    sensor, wrench = scene((15, 15), (15, 15), 3.0), Wrench(F_z=55.0)
    found = block_pad(sensor).equilibrium(wrench)
    monkeypatch.setattr(families, "PRESSED", depth)
    other = block_pad(sensor).equilibrium(wrench)
    assert abs(other.pose.d_v - found.pose.d_v) < found.error.d_v + other.error.d_v


@pytest.mark.slow
def test_contact_goes_on_from_load_to_load():
    """Silicone rises at the target's sides from some 1 N across and 6 N down on, as meshes graded to its edge show."""
    pad = block_pad(load_sensor("biorob2018", []))
    near = pad.equilibrium(Wrench(1.0, 6.0))
    assert any(note == Note.of(NoteKind.FACE_TOUCHES, surface="sides", friction=0.0) for note in near.report.notes)
    on, own = pad.equilibrium(Wrench(1.0, 6.1), start=near), pad.equilibrium(Wrench(1.0, 6.1))
    assert on.state[0] in pad.half.last and abs(on.pose.d_h - own.pose.d_h) < on.error.d_h
    back = pad.equilibrium(Wrench(0.1, 1.0), start=on)
    faces = {NoteKind.FACE_TOUCHES, NoteKind.FACE_FOLDS, NoteKind.FACES_TOUCH, NoteKind.FACES_CROSS}
    assert not any(note.kind in {*faces, NoteKind.FACE_RISES} for note in back.report.notes)
    assert back.pose.d_h == pytest.approx(pad.equilibrium(Wrench(0.1, 1.0)).pose.d_h, abs=back.error.d_h)


@pytest.mark.parametrize(("pad", "area"), [((15, 15), 10.0), ((15,), 2.5 * np.pi)])
def test_points_of_the_faces_hold_their_area(pad, area):
    """Sides of half a pad 3 mm thick, in thicknesses; on strongly graded meshes too."""
    for cells, grading in ((2, 1.5), (4, 3.0)):
        surface = bonded_block(scene(pad, pad, 3.0), cells, grading, 0.0, 1e-4).body.parts[0].surface
        assert surface.weight.sum() == pytest.approx(area, rel=2e-4)
        assert surface.rest[..., 2].min() > 0.0 and surface.rest[..., 2].max() < 1.0
