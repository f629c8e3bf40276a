"""Histories: what is none, times between, models without a memory of their own."""

import numpy as np
import pytest

from sits_mech.mechanics.closed_form import Strip
from sits_mech.mechanics.histories import LoadHistory, motion_of
from sits_mech.mechanics.linear import small_strain
from sits_mech.notes import NoteKind
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import SceneError, load_sensor
from sits_mech.silicone.history import relaxed_share, retardation
from sits_mech.silicone.material import silicone_from


def soft(**more):
    table = {"law": "neo-hookean", "shear_modulus": 2e4, "bulk_modulus": 2e7} | more
    base = load_sensor("biorob2018")
    layer = base.elastomer.model_copy(update={"material": silicone_from(table)})
    return base.model_copy(update={"elastomer": layer})


def creep(silicone, time):
    """Elastic share of a step of load, C."""
    weights, times = retardation(silicone.prony)
    return 1.0 - np.exp(-np.asarray(time)[..., None] / times) @ weights


@pytest.mark.parametrize(
    ("time", "wrench", "words"),
    [
        ([0.0, 1.0, 0.5], np.zeros((3, 6)), "time must not run back; got 0.5 s after 1 s in row 3"),
        ([0.0, 1.0], np.zeros((3, 6)), "must be n times with n x 6 loads"),
        ([0.0, np.nan], np.zeros((2, 6)), "must be finite numbers"),
    ],
)
def test_what_is_no_history_is_refused(time, wrench, words):
    with pytest.raises(SceneError, match=words.replace("(", r"\(")):
        LoadHistory(np.array(time), wrench)


def test_loads_are_divided_by_their_range():
    wrench = np.zeros((4, 6))
    wrench[:, 1] = [0.0, 2.0, 2.0, 1.5]
    found, own = LoadHistory(np.array([0.0, 1.0, 5.0, 6.0]), wrench).divided(8)
    assert found.time.size == 1 + 8 + 1 + 2
    np.testing.assert_allclose(found.time[own], [0.0, 1.0, 5.0, 6.0])
    np.testing.assert_allclose(np.diff(found.course[:9, 1]), 0.25)
    sudden, own = LoadHistory(np.array([0.0, 1.0, 1.0, 2.0]), wrench[[0, 0, 1, 1]]).divided(8)
    assert sudden.time.tolist() == [0.0, 1.0, 1.0, 2.0] and own.all() and sudden.solved.all()


@pytest.mark.slow
def test_a_linear_model_creeps_component_by_component():
    own, time = soft(prony=[{"weight": 0.3, "time": 2.0}]), np.array([0.0, 1.0, 3.0])
    layer = small_strain(own, 1e-2)
    wrench = np.zeros((3, 6))
    wrench[:, 0], wrench[1:, 1] = 1e-3, 2e-3
    wrench[:, 1] = 2e-3
    found = motion_of(own, layer, LoadHistory(time, wrench))
    slow = layer.equilibrium(Wrench(F_x=1e-3, F_z=2e-3)).pose
    share = creep(own.elastomer.silicone, time)
    np.testing.assert_allclose(found.pose.d_h[found.given], share * slow.d_h, rtol=1e-3)
    every = creep(own.elastomer.silicone, found.time) * slow.d_h  # and times between, where it still moves
    np.testing.assert_allclose(found.pose.d_h, every, rtol=1e-3)
    assert found.time.size > 10
    assert any(note.kind is NoteKind.AS_A_WHOLE for note in found.report.notes)


def test_a_sudden_change_is_no_ramp():
    """At rest for 10 s, then a load at once: both rows of that time are given, and the pad creeps from the second."""
    own, time, wrench = soft(prony=[{"weight": 0.3, "time": 1.0}]), [0.0, 10.0, 10.0, 20.0], np.zeros((4, 6))
    wrench[2:, 0] = 1e-3
    layer = Strip(own.target, own.elastomer, (1e3, 1e4, 1.0))
    found = motion_of(own, layer, LoadHistory(time, wrench.tolist()))
    given, slow = found.given, layer.equilibrium(Wrench(F_x=1e-3)).pose
    np.testing.assert_array_equal(found.time[given], time)
    np.testing.assert_array_equal(found.wrench[given], wrench)
    share = relaxed_share(own.elastomer.silicone, np.array(time), wrench[:, 0] / 1e-3)
    assert share[2] == pytest.approx(0.7)
    np.testing.assert_allclose(found.pose.d_h[given], share * slow.d_h, rtol=1e-12)
    every = np.where(found.time > 10.0, creep(own.elastomer.silicone, found.time - 10.0) * slow.d_h, 0.0)
    np.testing.assert_allclose(found.pose.d_h[~given], every[~given], rtol=1e-9)


def test_places_need_a_memory_at_every_point():
    own, press = soft(prony=[{"weight": 0.3, "time": 2.0}]), np.array([[0.0, -1e-5, 0.0, 0.0, 0.0, 0.0]])
    with pytest.raises(SceneError, match="places need a model at finite strain"):
        layer = Strip(own.target, own.elastomer, (1e3, 1e4, 1.0))
        motion_of(own, layer, LoadHistory([0.0], press, held=press[0] < 0.0))


@pytest.mark.slow
def test_a_linear_model_refuses_softening():
    own = soft(mullins={"r": 2.0})
    with pytest.raises(SceneError, match="softening"):
        motion_of(own, small_strain(own, 1e-2), LoadHistory(np.array([0.0, 1.0]), np.zeros((2, 6))))
