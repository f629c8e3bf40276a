"""How deep a touch presses by its target's pose, and what a pose is off by at a depth: by hand, for any model."""

import numpy as np
import pytest

from sits_mech.mechanics.depth import Depth, at_depth, depth_of
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Equilibrium, Pose, SolveReport, Wrench
from sits_mech.rotations import rotation_matrix
from tests.mechanics.test_touch import PUNCH, SPHERE, sensor


def at_rest(pose, error, **more):
    report = SolveReport("", 1, 1, 0.0, 0.02, 0.0, notes=more.pop("notes", ()))
    return Equilibrium(Wrench(F_z=1.0), pose, error, np.zeros(0), report, **more)


@pytest.mark.parametrize("touch", [SPHERE, PUNCH])
def test_a_depth_is_how_far_the_lowest_point_came_down(touch):
    """A sphere's centre stands a radius off the plane of the face above its place; slopes are those of differences."""
    scene, q = sensor(touch, x=1.0, y=0.5), np.array([1e-4, 1.9e-3, 0.03, -2e-4, -0.05, 0.01])
    pose, t, rho = Pose.of(q), scene.target.thickness, scene.touch.radius or 0.0
    n = rotation_matrix(pose.rotation)[:, 2]
    P = pose.centre + t * n
    low = P[2] + (rho - (np.array([1e-3, 0.5e-3]) - P[:2]) @ n[:2]) / n[2] - rho
    d, off, g = depth_of(scene, at_rest(pose, Pose.of(1e-6 * np.ones(6))), 2e-3)
    assert d == pytest.approx(2e-3 + t - low, rel=1e-12)
    flat, step = np.array([0.0, 1.9e-3, 0.0, 0.0, 0.0, 0.0]), 1e-7
    d, _, g = depth_of(scene, at_rest(Pose.of(flat), Pose(0.0, 0.0)), 2e-3)
    for k, unit in enumerate(np.eye(6)):
        there, _, _ = depth_of(scene, at_rest(Pose.of(flat + step * unit), Pose(0.0, 0.0)), 2e-3)
        assert (there - d) / step == pytest.approx(g[k], abs=1e-6)
    assert off == pytest.approx(1e-6 * np.abs(depth_of(scene, at_rest(pose, Pose(0.0, 0.0)), 2e-3)[2]).sum())


def test_errors_that_keep_the_depth_are_left_and_the_note_goes_with_them():
    """In the middle d_v is given by the depth; on a cover the depth's own error counts by its slopes."""
    scene, missed = sensor(SPHERE), Note.of(NoteKind.TOLERANCE_MISSED, error=0.02, tolerance=0.01)
    aim = Depth(1e-4, 2e-3, np.array([0.0, -0.5, 0.0, 0.0, 0.0, 0.0]), 1e4, 2e-6)
    found = at_rest(Pose(0.0, 1.9e-3), Pose(0.0, 2e-6), notes=(missed,))
    deep = at_depth(scene, found, aim._replace(per_depth=2.0 * aim.per_depth))
    assert deep.error.d_v == pytest.approx(0.0, abs=1e-18) and deep.report.notes == ()
    assert deep.error_F_z == pytest.approx(2e-2)
    covered = at_depth(scene, at_rest(Pose(0.0, 1.9e-3), Pose(0.0, 2e-6), notes=(missed,), sunk=(1e-4, 9e-6)), aim)
    assert covered.error.d_v == pytest.approx(3e-6) and covered.report.estimated_error == pytest.approx(0.03)
    assert covered.report.notes[0].known["error"] == pytest.approx(0.03)
