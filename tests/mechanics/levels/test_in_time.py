"""Histories of loads: errors against finer walks, against the pad as a whole and the slow answer; contact, failure."""

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.histories import LoadHistory
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.levels import in_time
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import POSE, WRENCH, SolveFailed, Wrench
from sits_mech.scene.sensor import load_sensor
from sits_mech.silicone.history import retardation
from sits_mech.silicone.material import silicone_from

PRONY = [{"weight": 0.2, "time": 1.0}, {"weight": 0.1, "time": 10.0}]


def sensor(elastomer=None, **more):
    table = {"law": "neo-hookean", "shear_modulus": 2e4, "bulk_modulus": 2e7} | more
    base = load_sensor("biorob2018")
    layer = base.elastomer.model_copy(update={"material": silicone_from(table)} | (elastomer or {}))
    return base.model_copy(update={"elastomer": layer})


def creep(silicone, time):
    """Elastic share of a step of load, C."""
    weights, times = retardation(silicone.prony)
    return 1.0 - np.exp(-np.asarray(time)[..., None] / times) @ weights


def relaxation(silicone, time):
    """Load of a step of place over that of slow load, G."""
    w, tau = np.reshape(silicone.prony, (-1, 2)).T
    return 1.0 + np.exp(-np.asarray(time)[..., None] / tau) @ w / (1.0 - w.sum())


def history(time, **loads):
    """Places are motions from rest."""
    course, held = np.zeros((len(time), 6)), np.isin(POSE, [*loads])
    for name, values in loads.items():
        course[:, (WRENCH if name in WRENCH else POSE).index(name)] = values
    return LoadHistory(np.array(time, dtype=float), course, held=held)


@pytest.mark.slow
def test_pose_is_within_its_error_of_a_finer_one():
    """Press, shear while pressed, let go of the pressure: no load is a share of another."""
    way = history([0, 1, 2, 3, 5], F_z=[0, 1.5, 1.5, 0.5, 0.0], F_x=[0, 0, 0.4, 0.4, 0.4])
    own = sensor(prony=PRONY, mullins={"r": 2.0})
    rough, fine = planar_layer(own, 5e-2).in_time(way), planar_layer(own, 1e-2).in_time(way)
    off = np.abs(rough.pose.components[rough.given] - fine.pose.components[fine.given])
    bound = rough.error.components[rough.given] + fine.error.components[fine.given]
    assert np.all(off[1:, :3] <= bound[1:, :3])
    assert fine.report.estimated_error < rough.report.estimated_error < 5e-2


@pytest.mark.slow
def test_small_loads_creep_by_the_pads_own_law():
    """A sudden small load moves the target by C(t) of the slow answer, in shear exactly."""
    own, times = sensor(prony=PRONY), np.array([0.0, 0.5, 2.0, 20.0, 400.0])
    found = planar_layer(own, 1e-3).in_time(history(times, F_x=np.full(5, 1e-3)))
    slow = planar_layer(own, 1e-3).equilibrium(Wrench(F_x=1e-3))
    expected = creep(own.elastomer.silicone, times) * slow.pose.d_h
    np.testing.assert_allclose(found.pose.d_h[found.given], expected, rtol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("model", [planar_layer, block_pad])
def test_the_force_that_holds_a_small_place_relaxes_by_the_prony_series(model):
    """In shear exactly; to what slow load moves so far."""
    own, times, place = sensor(prony=PRONY), np.array([0.0, 0.5, 2.0, 20.0, 400.0]), 2e-8
    found = model(own, 1e-2).in_time(history(times, d_h=np.full(5, place)))
    force = found.wrench[found.given][:, 0]
    np.testing.assert_allclose(force / force[-1], relaxation(own.elastomer.silicone, times), rtol=3e-4)
    slow, off = model(own, 1e-2).equilibrium(Wrench(F_x=force[-1])), found.error_wrench[-1, 0] / force[-1]
    assert abs(slow.pose.d_h - place) <= slow.error.d_h + off * place
    assert np.all(found.pose.d_h == place) and np.all(found.error.d_h == 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("names", [("d_v",), ("d_h", "d_v")])
def test_places_under_forces_are_held_by_these_forces(names):
    """What a history of forces comes to, given as places: one of them, both."""
    layer = planar_layer(sensor(prony=PRONY, mullins={"r": 2.0}), 1e-2)
    way = layer.in_time(history([0, 1, 2, 3, 5], F_z=[0, 1.5, 1.5, 0.5, 0.2], F_x=[0, 0, 0.4, 0.4, 0.4]))
    moved, held = way.pose.components - [0.0, 2e-3, 0.0, 0.0, 0.0, 0.0], np.isin(POSE, names)
    back = layer.in_time(LoadHistory(way.time, np.where(held, moved, way.wrench), held=held))
    off, rows = np.abs(back.wrench[back.given] - way.wrench), np.max(np.abs(way.wrench), axis=0)
    places = rows * np.max(way.error.components, axis=0) / np.maximum(np.max(np.abs(moved), axis=0), 1e-300)
    assert np.all(off[:, held] <= (back.error_wrench[back.given] + 2.0 * places)[:, held])  # a pad stiffens
    assert np.all(back.error_wrench[:, held] <= 1e-2 * rows[held].max())
    assert np.all(back.wrench[back.given][:, ~held] == way.wrench[:, ~held]) and not back.error_wrench[:, ~held].any()


@pytest.mark.slow
def test_steps_in_time_leave_the_error_that_is_estimated(monkeypatch):
    """A press at a given speed, then held: the force against one by steps an eighth as long, or less."""
    layer, way = planar_layer(sensor(prony=PRONY), 1e-2), history([0.0, 0.5, 5.0], d_v=[0.0, -1e-4, -1e-4])
    few = layer.in_time(way)
    monkeypatch.setattr(in_time, "_GROWTH", in_time._GROWTH / 64.0)
    many = layer.in_time(way)
    assert many.time.size > 2 * few.time.size
    off = np.max(np.abs(few.wrench[few.given] - many.wrench[many.given])) / np.max(many.wrench)
    estimate = next(dict(note.numbers)["error"] for note in few.report.notes if note.kind is NoteKind.TIMES)
    assert 0.3 * off <= estimate <= 3.0 * off


@pytest.mark.slow
def test_long_time_is_the_elastic_answer_of_a_pad_in_space():
    own = sensor(prony=PRONY)
    found = block_pad(own, 3e-2).in_time(history([0.0, 300.0], F_z=[1.0, 1.0], F_x=[0.2, 0.2]))
    slow = block_pad(own, 3e-2).equilibrium(Wrench(F_x=0.2, F_z=1.0))
    off = np.abs(found.pose.components[-1] - slow.pose.components)
    assert np.all(off <= found.error.components[-1] + slow.error.components)
    assert np.all(off[:3] <= 3e-3 * np.abs(slow.pose.components - [0, 2e-3, 0, 0, 0, 0])[:3])


@pytest.mark.slow
def test_a_load_that_leaves_the_plane_later_moves_the_whole_pad():
    """Pressed first, then along y, in space: a box as long as wide answers as it does along x."""
    own = sensor({"width": 12e-3, "length": 12e-3, "thickness": 4e-3}, prony=PRONY)
    along, across = (
        block_pad(own, 5e-2).in_time(history([0.0, 1.0], F_z=[1.0, 1.0], **{name: [0.0, 0.2]}))
        for name in ("F_x", "F_y")
    )
    assert across.pose.d_y[-1] == pytest.approx(along.pose.d_h[-1], rel=1e-4)
    assert across.pose.alpha_x[-1] == pytest.approx(-along.pose.alpha[-1], rel=1e-3)
    assert abs(across.pose.d_h[-1]) < 1e-9


@pytest.mark.slow
def test_without_rate_or_softening_it_is_the_elastic_answer():
    own = sensor()
    found = planar_layer(own, 1e-2).in_time(history([0.0, 1.0, 1.1], F_z=[0.0, 2.0, 1.0]))
    for row, force in ((1, 2.0), (2, 1.0)):
        slow = planar_layer(own, 1e-2).equilibrium(Wrench(F_z=force))
        assert abs(found.pose.d_v[row] - slow.pose.d_v) <= found.error.d_v[row] + slow.error.d_v


@pytest.mark.slow
def test_faces_that_fold_are_held_with_memory_too():
    """A layer as wide as its target folds onto it; the history is walked with contact."""
    own = sensor({"width": 8e-3, "thickness": 2e-3}, prony=PRONY)
    found = planar_layer(own, 3e-2).in_time(history([0.0, 1.0, 50.0], F_z=[0.0, 12.0, 12.0]))
    slow = planar_layer(own, 3e-2).equilibrium(Wrench(F_z=12.0))
    assert any(note.kind is NoteKind.FACE_TOUCHES for note in found.report.notes)
    assert abs(found.pose.d_v[-1] - slow.pose.d_v) <= 2 * (found.error.d_v[-1] + slow.error.d_v)


@pytest.mark.slow
def test_friction_without_rate_is_the_path_of_loads():
    """Pressed, then sheared: faces that lie on ground and target slip as they do along a path without time."""
    own = sensor({"width": 8e-3, "contact": "always", "friction": 0.6})
    found = planar_layer(own, 5e-2).in_time(history([0.0, 1.0, 2.0], F_z=[0.0, 12.0, 12.0], F_x=[0.0, 0.0, 1.0]))
    path = planar_layer(own, 5e-2).along([Wrench(F_z=12.0), Wrench(F_x=1.0, F_z=12.0)])
    off = np.abs(found.pose.components[-1] - path.pose.components)
    assert np.all(off <= found.error.components[-1] + path.error.components)


@pytest.mark.slow
def test_a_load_that_is_not_carried_ends_the_history():
    with pytest.raises(SolveFailed, match=r"at .* s of 2 s") as caught:
        planar_layer(sensor(prony=PRONY), 5e-2).in_time(history([0.0, 2.0], F_z=[0.0, -400.0]))
    assert caught.value.report.status == "history ended"


@pytest.mark.parametrize(("shear", "tolerance"), [(0.768, 3e-2), (1.2, 3e-3)])
def test_corners_of_a_flush_pad_fold_in_histories_as_under_loads(shear, tolerance):
    """A square of 8 mm, x = 1.0 and 1.7: by the order of corners that fold, and no third mesh that would fold."""
    layer = block_pad(load_sensor("biorob2018", [
        'elastomer={width="8 mm", length="8 mm", thickness="2 mm", contact="never", material={law="neo-hookean", '
        'shear_modulus=3e4, bulk_modulus=1490100.0}}',
    ]), tolerance)
    found, slow = layer.in_time(history([0.0, 1.0], F_x=[0.0, shear])), layer.equilibrium(Wrench(F_x=shear))
    assert dict(next(note for note in found.report.notes if note.kind is NoteKind.TIMES).numbers)["meshes"] == 2
    assert found.pose.d_h[-1] == pytest.approx(slow.pose.d_h, rel=1e-4)
    assert found.error.d_h[-1] > slow.error.d_h > 4e-3 * slow.pose.d_h


def test_softening_begins_with_the_least_of_loads() -> None:
    """Without m, after a load that strains by 1e-5: the press that follows ends where it does without that load."""
    own = sensor(prony=PRONY, mullins={"r": 4.0, "m": 0.0, "beta": 1.0})
    first, alone = (
        planar_layer(own, 5e-2).in_time(history(range(3), F_z=loads)) for loads in ([0.0, 1e-5, 0.5], [0.0, 0.0, 0.5])
    )
    assert first.pose.d_v[-1] == pytest.approx(alone.pose.d_v[-1], rel=1e-5)


def test_a_mesh_beyond_memory_is_noted(monkeypatch) -> None:
    """The motion is that of the meshes before, where a further one would have been walked."""
    large = Note.of(NoteKind.MESH_TOO_LARGE, needed=2.0, limit=1.0)
    monkeypatch.setattr("sits_mech.mechanics.levels.family.Levels.check_memory", lambda _, k: large if k > 1 else None)
    found = planar_layer(sensor(prony=PRONY), 2e-3).in_time(history([0.0, 1.0], F_z=[0.0, 0.5]))
    assert large in found.report.notes and found.report.estimated_error > 2e-3
