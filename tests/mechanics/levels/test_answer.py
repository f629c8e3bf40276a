"""Poses from levels: scales there and back, errors that fall with the tolerance, states that do not change with it."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.equilibrium.control import Control, Scales, under
from sits_mech.mechanics.equilibrium.newton import smallest_eigenvalue, target_stiffness
from sits_mech.mechanics.equilibrium.outcome import Path
from sits_mech.mechanics.equilibrium.path import advance, unloaded
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.levels.answer import errors_of, extrapolated_equilibrium, relative, scaled_control
from sits_mech.mechanics.levels.words import wrench_words
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor

MM = 1e-3
NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'


def pad(W, w, t, law=NEO_HOOKEAN):
    """A pad a metre long; the force acts at the bonded face."""
    sizes = [f'elastomer.width="{W} mm"', f'elastomer.thickness="{t} mm"', f'target.width="{w} mm"']
    return load_sensor("biorob2018", ["elastomer.length=1.0", "target.load_height=0", law, *sizes])


def test_scales_lead_there_and_back():
    """A load on half a body is half the target's; forces in mu t^2, moments in mu t^3, places in t above the film."""
    scales, wrench = Scales(2 * MM, 0.12, 1e-4, 0.5), Wrench(1.0, 2.0, 3e-3, 4.0, 5e-3, 6e-3)
    load = scales.load(wrench)
    np.testing.assert_allclose(load, 0.5 * np.array([1.0, 2.0, 1.5, 4.0, 2.5, 3.0]) / 0.12)
    np.testing.assert_allclose(scales.wrench(load).components, wrench.components, rtol=1e-14)
    pose = scales.pose(np.array([0.1, -0.2, 0.05]))
    assert (pose.d_h, pose.d_v, pose.alpha) == pytest.approx((0.2 * MM, 1.7 * MM, 0.05))


def test_no_component_is_called_better_than_a_share_of_the_worst():
    """An angle counts as the way of the target's end."""
    lever = np.array([1.0, 1.0, 7.5 * MM])
    found = errors_of(np.array([1e-6, 0.0, 0.0]), 0.05, lever)
    np.testing.assert_allclose(found, [1e-6, 5e-8, 5e-8 / (7.5 * MM)])
    assert relative(found, np.array([1e-4, 0.0, 0.0]), lever) == pytest.approx(0.01)
    assert relative(found, np.array([0.0, 0.0, 0.1]), lever) == pytest.approx(1e-6 / (0.1 * 7.5 * MM))
    assert relative(np.zeros(3), np.zeros(3), lever) == 0.0


def test_lever_is_half_the_target():
    body = bonded_body(pad(20, 15, 2), SectionFineness(2, 1.5))
    np.testing.assert_allclose(body.reach(2 * MM), [1.0, 1.0, 7.5 * MM, 1.0, 7.5 * MM, 7.5 * MM])


def test_what_is_given_and_what_is_free():
    body = bonded_body(pad(20, 15, 2), SectionFineness(2, 1.5))
    held, end = scaled_control(body, Scales(2 * MM, 60.0, 0.0), Control(F_x=30.0, sink=0.2 * MM, alpha=0.01))
    assert held.tolist() == [False, True, True]
    np.testing.assert_allclose(end, [0.5, -0.1, 0.01])


def test_words_of_a_load_leave_out_what_is_not_there():
    assert wrench_words({"F_x": 0.0, "F_z": 1.5, "M": 0.0, "F_y": 0.0}) == "F_x = 0 N, F_z = 1.5 N, M = 0 N m"
    assert wrench_words({"F_x": 0.1, "M_x": 2e-3}) == "F_x = 0.1 N, M_x = 0.002 N m"


def test_a_level_on_which_the_target_does_not_settle_is_left_out():
    """Its last move, in one component, is larger than the error of two levels: the pose is theirs."""
    line = replace(planar_layer(pad(20, 15, 2), 1e-6).line, deepest=3)
    levels, control = line[0], under(Wrench(100.0, 1500.0, 0.2))
    held, end = scaled_control(levels.fine, line.scales, control)
    path = Path((0.0 * end, end), held)
    three = [advance(levels.maker(level), unloaded(levels.maker(level)), path) for level in range(3)]
    pair = three[0].state, three[1].state
    two, good, bad = (
        extrapolated_equilibrium(replace(line, deepest=most), 0, control, pair, iter([replace(three[2], off=off)]))
        for most, off in ((2, np.zeros(3)), (3, np.zeros(3)), (3, np.array([0.0, 0.5, 0.0])))
    )
    assert bad.pose == two.pose != good.pose and bad.error == two.error
    assert good.report.estimated_error < two.report.estimated_error


def test_a_level_beyond_memory_is_noted(monkeypatch):
    """The answer is that of the levels before, where a further one would have been solved."""
    layer, large = planar_layer(pad(20, 15, 2), 4e-4), Note.of(NoteKind.MESH_TOO_LARGE, needed=2.0, limit=1.0)
    monkeypatch.setattr("sits_mech.mechanics.levels.family.Levels.check_memory", lambda _, k: large if k > 1 else None)
    found = layer.equilibrium(Wrench(100.0, 1500.0, 0.2))
    assert large in found.report.notes and found.report.estimated_error > 4e-4


@pytest.fixture(scope="module")
def answers():
    """One load at falling tolerances."""
    return [planar_layer(pad(20, 15, 2), each).equilibrium(Wrench(100.0, 1500.0, 0.2)) for each in (5e-2, 2e-3, 4e-4)]


@pytest.mark.slow
def test_the_error_never_rises_when_the_tolerance_falls(answers):
    errors = [found.report.estimated_error for found in answers]
    assert errors == sorted(errors, reverse=True) and errors[-1] < 0.7 * errors[0]
    sizes = [found.report.unknowns for found in answers]
    assert sizes == sorted(sizes) and sizes[0] < sizes[-1]


def test_poses_at_two_tolerances_are_within_both_errors(answers):
    *rough, best = answers
    for found in rough:
        away = np.abs(found.pose.components - best.pose.components)
        lever = np.array([1.0, 1.0, 7.5 * MM])
        assert np.max(away[:3] * lever) < np.max((found.error.components + best.error.components)[:3] * lever)


YEOH = 'elastomer.material={law="yeoh", c10=1.5e4, c20=1500.0, c30=100.0, bulk_modulus=3e7}'


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sizes", "law", "load"),
    [
        pytest.param((15, 15, 3), NEO_HOOKEAN, (100.0, 1000.0), marks=pytest.mark.slow),
        ((10, 10, 2), YEOH, (30.0, 660.0)),
        pytest.param((20, 20, 2), NEO_HOOKEAN, (60.0, 4800.0), marks=pytest.mark.slow),
    ],
)
def test_poses_in_contact_at_two_tolerances_are_within_both_errors(sizes, law, load):
    """Flush layers whose free faces lie on ground and target: the first two levels agree there by chance."""
    sensor = pad(*sizes, law)
    rough, best = (planar_layer(sensor, each).equilibrium(Wrench(*load)) for each in (1e-2, 2e-3))
    assert any(note.kind is NoteKind.FACE_TOUCHES and note.known["surface"] == "ground" for note in rough.report.notes)
    assert best.report.estimated_error < rough.report.estimated_error and best.report.unknowns > rough.report.unknowns
    away = np.abs(rough.pose.components - best.pose.components)[:3]
    assert np.all(away <= (rough.error.components + best.error.components)[:3])


def test_the_state_that_is_kept_is_that_of_the_first_two_levels(answers):
    """So that a neighbour can start from it, whatever the tolerance."""
    for found in answers[1:]:
        np.testing.assert_array_equal(found.state, answers[0].state)


def test_forces_that_hold_the_target_have_the_error_of_forces():
    layer = planar_layer(pad(20, 15, 2), 1e-2)
    found = layer.controlled(Control(d_h=0.1 * MM, sink=0.02 * MM, alpha=0.0))
    assert (found.pose.d_h, found.pose.alpha) == (pytest.approx(0.1 * MM), 0.0)
    np.testing.assert_array_equal(found.error.components[:3], 0.0)
    assert 0.0 < found.report.estimated_error < 1e-2 and found.wrench.F_x > 0.0


@pytest.mark.parametrize(
    ("sizes", "load"),
    [((20, 20, 8, 8, 2), (0.4, 1.6)), ((8, 4, 8, 4, 2), (0.2, 0.2)), ((8, 8, 8, 8, 6), (0.03, 0.1))],
)
def test_two_levels_agree_on_what_symmetry_hides(sizes, load):
    """Its stiffness over that without load: so closely that one level tells of the other where half of it is left."""
    keys = ("elastomer.width", "elastomer.length", "target.width", "target.length", "elastomer.thickness")
    line = block_pad(load_sensor("biorob2018", [f"{k}={v * MM}" for k, v in zip(keys, sizes, strict=True)])).half
    control, shares = under(Wrench(*load)), []
    for body in (line[0].coarse, line[0].fine):
        held, end = scaled_control(body, line.scales, control)
        found = advance(body, unloaded(body), Path((0.0 * end, end), held, control.held[3:]))
        shares.append(found.hidden / smallest_eigenvalue(target_stiffness(body, unloaded(body))[1]))
    assert abs(shares[1] - shares[0]) < 0.03 and min(shares) > 0.5
    plain = line[0].fine.plain
    assert plain.hidden is None and plain.pattern is line[0].fine.pattern and plain is line[0].fine.plain
