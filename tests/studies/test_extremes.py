"""The table of extremes: its checks see what is wrong, and its quick rows hold."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from benchmarks import extremes
from common.children import asked_apart
from extreme import any_answer, any_scene, checks, driven, films, layers, plates, poses, solids, walls
from extreme.rows import DONE, Row, measured

from sits_mech.chain.models import MAGNETICS
from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.layer import planar_layer
from sits_mech.quantities import Pose, SolveFailed, SolveReport, Wrench
from sits_mech.scene.sensor import SceneError


def test_a_row_holds_only_if_converged_and_consistent_or_refused_by_name() -> None:
    good = Row("", "", DONE, 0.5, 1e-9, 1e-6)
    assert good.holds and replace(good, status="load path ended").holds
    assert not replace(good, violation=1e-3).holds
    assert not replace(good, min_J=-0.1).holds and not replace(good, violation=np.nan).holds
    assert not replace(good, status="load path ended", must=True).holds
    assert not measured("", "", lambda: 1 / 0).holds  # type: ignore[arg-type, return-value]


def test_work_that_is_not_the_stored_energy_is_seen() -> None:
    """Poses of which one is wrong by a hundredth, and a state that is another load's."""
    layer, peak = planar_layer(layers.pad(20, 15, 2), 2e-2), Wrench(50.0, 500.0)
    way = checks.Way((peak.F_x, peak.F_z, 0.0), False, np.linspace(0.0, 1.0, 5).tolist(), [])
    for share in way.points:
        way.path.append(layer.equilibrium(checks.scaled(peak, share), start=way.path[-1] if way.path else None))
    assert checks.energy_row(layer, way).holds
    broken = replace(way.path[-1], state=way.path[-2].state)
    assert not checks.energy_row(layer, way._replace(path=[*way.path[:-1], broken])).holds


@pytest.mark.slow
@pytest.mark.parametrize("place", ["d_h", "alpha"])
def test_work_of_the_force_that_is_found_is_the_stored_energy(place: str) -> None:
    layer = planar_layer(layers.pad(20, 15, 2), 2e-2)
    goal = 1.0 if place == "alpha" else 0.05
    kind = driven.Drive("led", place, (goal,), goal / 4.0)
    (_, question), *_ = driven.drive(layer, kind)
    row = question()
    assert row.status == DONE and row.holds and row.violation < 2e-3


@pytest.mark.slow
def test_work_on_a_solid_pad_is_its_stored_energy() -> None:
    pad = block_pad(solids.pad(), 2e-2)
    (_, question), *_ = driven.drive(pad, driven.Drive("pressed", "sink", (0.04,), 0.01, by_force=True))
    row = question()
    assert row.status == DONE and row.violation < row.allowed < 2e-4


@pytest.mark.slow
def test_a_way_that_ends_says_where_and_why() -> None:
    """A block as high as wide, pressed by force alone, gives way sideways; its work is looked at as far as it went."""
    layer = planar_layer(layers.pad(6, 6, 6), 5e-2)
    questions = driven.drive(layer, driven.Drive("pressed", "sink", (0.1, 0.6), 0.1, by_force=True))
    rows = [question() for _, question in questions]
    assert rows[0].status == DONE and rows[1].status == "load path ended"
    assert rows[1].holds and rows[1].violation <= rows[1].allowed
    assert rows[1].remark.startswith("stopped at") and "buckles" in rows[1].remark


def test_an_interrupted_run_leaves_the_rows_it_had(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    good = Row("chain", "one", DONE, 0.5, 1e-9, 1e-6)

    def some(coarse: bool) -> Iterator[Row]:
        yield good
        yield replace(good, case="two")
        written = (tmp_path / "extremes.csv").read_text()
        assert "one" in written and "two" in written
        raise KeyboardInterrupt

    monkeypatch.setitem(extremes.PARTS, "chain", some)
    rows = extremes.ask(["chain"], True, tmp_path)
    assert [row.holds for row in rows] == [True, True, False]
    assert "| chain | two | converged | True |" in (tmp_path / "extremes.md").read_text()


def test_a_plate_that_is_not_passive_is_seen() -> None:
    sensor = plates.scene("planar", 8, 0.2, 5.8e7)
    before, z = (MAGNETICS["planar"](sensor, 1e-2).impedance(Pose(3e-4, 2e-3), f) for f in (1e4, 1e6))
    assert plates.worst(z, before, False) <= plates.ROUNDING
    lopsided = z.L + np.array([[0.0, 1e-6 * z.L[0, 0]], [0.0, 0.0]])
    for wrong in (replace(z, R=-z.R), replace(z, L=z.L0 * 1.001), replace(z, L=lopsided), replace(z, R=z.R * np.nan)):
        assert plates.worst(wrong, None, False) > plates.ROUNDING
    assert plates.worst(before, z, False) > plates.ROUNDING  # shrinks with frequency


def test_the_limit_of_thin_layers() -> None:
    """A thousandth of a millimetre is compressed as a whole, M A/t; 5 mm are squeezed out as if incompressible."""
    square, disc = (films.PARTS[name] for name in ("flush 20 x 20 mm", "flush disc of 20 mm"))
    for part, area in ((square, 4e-4), (disc, np.pi * 1e-4)):
        assert films.stiffness_down(solids.shaped(*part, 1e-3)) == pytest.approx(3.004e7 * area / 1e-6, rel=2e-3)
    squeezed = [films.stiffness_down(solids.shaped(*part, 5.0)) * 0.005**3 / 3e4 for part in (square, disc)]
    assert squeezed[0] == pytest.approx(12 * 0.140577 * 0.02**4 / 4, rel=0.02)  # as Saint-Venant's torsion of a square
    assert squeezed[1] == pytest.approx(1.5 * np.pi * 0.01**4, rel=0.02)  # J. Stefan 1874


def test_a_column_falls_over_under_eulers_load() -> None:
    slim = walls.Column(1.0, 1.0, 100.0)
    assert slim.carried == pytest.approx(np.pi**2 * 9e4 * 1e-12 / 12.0 / 4.0 / 0.1**2, rel=1e-3)
    assert walls.Column(2.0, 20.0, 10.0).carried == walls.Column(20.0, 2.0, 10.0).carried


@pytest.mark.slow
@pytest.mark.parametrize("rows", [films.films, walls.walls])
def test_rows_of_films_and_walls_hold_and_see_what_is_wrong(rows, monkeypatch: pytest.MonkeyPatch) -> None:  # type: ignore[no-untyped-def]
    assert all(row.holds for row in rows(True))
    monkeypatch.setattr(films, "stiffness_down", lambda sensor, own=films.stiffness_down: 1.1 * own(sensor))
    monkeypatch.setattr(walls, "MU", 1.3 * walls.MU)
    assert not any(row.holds for row in rows(True) if row.status == DONE)


@pytest.mark.parametrize("name", ["no load", "load to and fro", "moment identity, sheared by half"])
def test_quick_rows_hold(name: str) -> None:
    thin = planar_layer(layers.pad(20, 15, 2))
    row = {
        "no load": lambda: checks.nothing(thin, 2e-3),
        "load to and fro": lambda: checks.to_and_fro(thin, Wrench(100.0, 1000.0), 7.5e-3),
        "moment identity, sheared by half": lambda: checks.identity(layers.pad(15, 15, 3), Wrench(F_x=200.0)),
    }[name]()
    assert row.holds and row.status == DONE


def test_random_scenes_are_the_same_ones_and_of_all_kinds() -> None:
    drawn = [any_scene.random_case(number) for number in range(40)]
    again = any_scene.random_case(7)
    assert (again.sensor, again.given, again.tolerance) == (drawn[7].sensor, drawn[7].given, drawn[7].tolerance)
    assert {case.kind for case in drawn} == {"inductance", "pose", "simulate"}
    assert {case.sensor.coils[0].shape for case in drawn} == {"circle", "rectangle", "path"}
    layers_of = {case.sensor.elastomer.kind for case in drawn if case.sensor.elastomer is not None}
    assert layers_of == {"box", "cylinder", "pillars"}


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (ValueError("too many values to unpack"), "exception"), (ZeroDivisionError("by zero"), "exception"),
        (np.linalg.LinAlgError("8-th leading minor"), "exception"), (SceneError("target: must be"), "bad input"),
        (SolveFailed("lost", SolveReport("planar", 1, 1, 0.0, 1.0, 0.0, "load path ended")), "load path ended"),
    ],
)
def test_what_is_refused_by_name_and_what_only_broke(error: Exception, status: str) -> None:
    try:
        raise error
    except Exception as caught:
        assert any_answer.refusal(caught).status == status


@pytest.mark.slow
def test_a_question_that_does_not_end_and_one_that_takes_too_much_are_seen() -> None:
    def endless() -> None:
        while True:
            pass

    ended = asked_apart(endless, seconds=0.5, gib=4.0)
    assert ended.value is None and ended.killed == "more than 0.5 s" and ended.seconds < 5.0
    assert asked_apart(lambda: np.ones(2**31), seconds=5.0, gib=4.0).killed == "no answer"
    assert asked_apart(lambda: 3, seconds=5.0, gib=4.0).value == 3
    with pytest.raises(RuntimeError, match="KeyError: 'gone'"):
        asked_apart(lambda: {}["gone"], seconds=5.0, gib=4.0)


def test_what_a_study_holds_leaves_a_question_its_memory() -> None:
    """Scenes by chance came after a thousand plates, and a fifth of them had no memory left."""
    held = np.empty(2**27)
    assert asked_apart(lambda: float(np.ones(2**25).sum()), seconds=5.0, gib=0.5).value == 2.0**25
    assert held.nbytes > 0.5 * 2**30


def test_answers_that_cannot_be_are_seen() -> None:
    sensor = plates.scene("planar", 8, 0.2, 5.8e7)
    z = MAGNETICS["planar"](sensor, 1e-2).impedance(Pose(3e-4, 2e-3), 1e6)
    assert not any_answer.field_wrong(sensor, z)
    wrongs = (replace(z, R=-z.R), replace(z, L=1.01 * z.L0), replace(z, L=-z.L), replace(z, error_L=np.nan * z.L))
    assert all(any_answer.field_wrong(sensor, wrong) for wrong in wrongs)
    layer = planar_layer(layers.pad(20, 15, 2), 2e-2)
    rest = layer.equilibrium(Wrench(50.0, 500.0))
    assert not any_answer.rest_wrong(layer.sensor, rest)
    assert any_answer.rest_wrong(layer.sensor, replace(rest, wrench=Wrench(-50.0, -500.0)))
    moved = replace(rest, pose=replace(rest.pose, d_v=float(rest.pose.d_v) + 3.0 * float(rest.error.d_v)))
    assert any_answer.apart((rest, None), (moved, None)) == pytest.approx(1.5, rel=1e-2)


def test_rows_of_poses_hold_and_see_what_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = poses.questions()["tolerance 0.3"]
    assert poses.richer(asked).holds
    wider = replace(asked, sensor=poses.plate(turns=13))
    own = MAGNETICS["planar"]
    models = {"planar": lambda sensor, tolerance: own(wider.sensor if tolerance < 1e-2 else sensor, tolerance)}
    monkeypatch.setattr(poses, "MAGNETICS", models)
    assert not poses.richer(asked).holds
