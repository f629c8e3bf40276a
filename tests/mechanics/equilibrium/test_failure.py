"""What is said of a load path that ended: where, by how much, and under which load a law leaves its range."""

import numpy as np

from sits_mech.mechanics.equilibrium.control import under
from sits_mech.mechanics.equilibrium.outcome import REASONS, PathEnd
from sits_mech.mechanics.levels.pair import Solved
from sits_mech.mechanics.levels.settle import path_failure
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Equilibrium, Pose, SolveReport, Wrench

LAW = Note.of(
    NoteKind.LAW_END, silicone="the yeoh law", law="yeoh", mode="planar tension", stretch=1.556, reached=2.476
)
TOLD = "the yeoh law is unstable from stretch 1.556 on in planar tension, this solve reached 2.476"


def solved(**more):
    report = SolveReport("block", 10, 3, 0.0, 0.1, 0.0, notes=(LAW,), min_J=0.6)
    found = Equilibrium(Wrench(0.0, 4.5), Pose(0.0, 1e-3), Pose(0.0, 0.0), np.zeros(0), report)
    return Solved(found, 0.225, PathEnd.BUCKLED, laws=(LAW,), **more)


def test_a_law_is_named_with_the_load_that_its_stretch_was_reached_under():
    """That of the coarse mesh, which got farther, is told once."""
    carried = Wrench(0.0, 11.0), Wrench(0.0, 0.5)
    ended = solved(coarse_part=0.5, carried=carried, limit_point=(0.55, 0.025))
    failed = path_failure(under(Wrench(0.0, 20.0)), ended, "pad")
    assert f"{TOLD}, under F_x = 0 N, F_z = 10 N, M = 0 N m on a coarse mesh" in str(failed)
    assert str(failed).count("1.556") == 1
    under_load = LAW.with_numbers(F_x=0.0, F_z=10.0, M=0.0)
    assert [note for note in failed.report.notes if note.kind is NoteKind.LAW_END] == [under_load]
    (end,) = (note for note in failed.report.notes if note.kind is NoteKind.PATH_END)
    assert end == Note.of(NoteKind.PATH_END, end=PathEnd.BUCKLED) and REASONS[PathEnd.BUCKLED] in str(failed)
    assert "carried up to F_z = 11 +- 0.5 N (55.00% +- 2.50% of the path)" in str(failed)


def test_a_path_without_a_limit_says_how_far_a_coarse_mesh_got():
    failed = path_failure(under(Wrench(2.0)), solved(coarse_part=0.5), "layer")
    assert "no largest load was found: a coarse mesh could be followed to F_x = 1 N" in str(failed)
    assert failed.report.status == "load path ended" and Note.of(NoteKind.PATH_PART, part=0.225) in failed.report.notes
