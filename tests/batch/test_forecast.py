"""What a study takes: counted by what its cases share, forecast from a few of them, beside what it took."""

import json
from itertools import pairwise
from pathlib import Path

import pytest

from sits_mech.batch import forecast as forecasts
from sits_mech.batch.forecast import Forecast, StepCounts, forecast, note, noted
from sits_mech.batch.run import Case
from sits_mech.batch.studies.asked import Study
from sits_mech.batch.studies.study import read_study
from sits_mech.cli.main import run
from sits_mech.report.tables.cases import plan_words
from sits_mech.store import STORE, opened
from sits_mech.units import SceneError

SIMULATE = """
scene = "biorob2018"
request = "simulate"
vary."elastomer.thickness" = ["2 mm", "3 mm", "4 mm"]
vary."target.width" = ["8 mm", "10 mm"]
vary.fz = { from = "0.1 N", to = "1 N", count = 10 }
"""
INDUCTANCE = """
scene = "biorob2018"
request = "inductance"
vary."target.width" = ["8 mm", "10 mm"]
vary.dv = { from = "2 mm", to = "3 mm", count = 30 }
fixed.model = "planar"
"""
TRUE = StepCounts(process=3.0, coils=2.0, pad=0.5, rest=0.3, case=0.1)
ALONE = TRUE._replace(rest=0.0, case=0.4)  # no two cases share a rest


def written(folder: Path, text: str) -> Path:
    """Return the path of a study file with a text."""
    path = folder / "study.toml"
    path.write_text(text)
    return path


@pytest.fixture
def slow(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Let cases take what `TRUE` says, on a clock of their own; return its seconds so far."""
    clock, met = [0.0], set[object]()

    def answer(self: Case, **point: object) -> dict[str, float]:
        own = forecasts._prepared(self.study, {0: point})[0]
        new = {None: TRUE.process, ("pad", own.pad): TRUE.pad, ("rest", own.pad, own.load): TRUE.rest}
        new |= {("coils", each): TRUE.coils for each in own.coils}
        clock[0] += TRUE.case + sum(seconds for what, seconds in new.items() if what not in met)
        met.update(new)
        return {"c": 1.0}

    monkeypatch.setattr(Case, "__call__", answer)
    monkeypatch.setattr(forecasts, "time", type("Clock", (), {"process_time": lambda: clock[0]}))
    return clock


def test_steps_follow_from_a_few_cases(slow: list[float], tmp_path: Path) -> None:
    """Two sets of coils at two clearances, three pads with each, sixty cases: exactly what they take, from nine."""
    study = read_study(written(tmp_path, SIMULATE))
    found = forecast(study)
    assert found.steps == pytest.approx(ALONE, rel=1e-9, abs=1e-9) and found.counts() == (1, 4, 6, 60, 60)
    assert found.seconds() == pytest.approx(3.0 + 4 * 2.0 + 6 * 0.5 + 60 * 0.4)
    assert found.tried == (9, pytest.approx(slow[0])) and found.kept == 0
    assert found.saved == pytest.approx((59 * 3.0, 56 * 2.0, 54 * 0.5, 0.0, 0.0), abs=1e-6)


def test_counts_come_before_a_case_is_tried_and_then_what_all_takes(slow: list[float], tmp_path: Path) -> None:
    """The first two lines cost no case, the third one case, and others come as twice as much is tried."""
    said = list[Forecast]()
    clock = list[float]()
    found = forecast(
        read_study(written(tmp_path, SIMULATE)), extra=lambda: 7.0,
        report=lambda plan: (said.append(plan), clock.append(slow[0])),
    )
    assert clock[:2] == [0.0, 0.0] and said[1].tried == (0, 0.0)
    assert plan_words(said[0]) == "60 cases to solve, 0 kept; coils and plates: 4, pads: 6, rests: 60"
    assert 10.0 < said[1].seconds() < 1000.0
    assert plan_words(said[1]) == f"all some {said[1].seconds():.2g} s, as its models take on other scenes"
    assert plan_words(said[2]).startswith("tried 1 cases in ") and 0.0 < said[2].seconds() < 2.0 * found.seconds()
    assert all(later.tried[1] > 2.0 * one.tried[1] for one, later in pairwise(said[1:]))
    assert found.steps.process == pytest.approx(TRUE.process + 7.0)


def test_a_rest_counts_once_for_all_coils(slow: list[float], tmp_path: Path) -> None:
    """Two pads under three loads each with four frequencies: six rests, and what a case takes besides."""
    text = SIMULATE.replace('["8 mm", "10 mm"]', '["8 mm"]').replace("count = 10", "count = 3").replace(', "4 mm"', "")
    found = forecast(read_study(written(tmp_path, text + 'vary.frequency = ["1 MHz", "2 MHz", "3 MHz", "4 MHz"]\n')))
    assert found.steps == pytest.approx(TRUE, rel=1e-9) and found.counts() == (1, 4, 2, 6, 24)


def test_coils_are_prepared_for_each_step_of_clearances(tmp_path: Path) -> None:
    """From 1.8 mm down to 1.51 two preparations blend, below one serves again; a press gets there by linear theory."""
    text = 'scene = "biorob2018"\nrequest = "{}"\nvary.{} = {}\n'
    given = read_study(written(tmp_path, text.format("inductance", "dv", '["2 mm", "1.6 mm", "1.4 mm", "0 mm"]')))
    poses = forecasts._prepared(given, {k: {"dv": height} for k, height in enumerate(given.vary["dv"])})
    assert [own.coils for own in poses.values()] == [(((), 0),), (((), 0), ((), -1)), (((), -1),), ((),)]
    pressed = read_study(written(tmp_path, text.format("simulate", "fz", '["0.1 N", "2 N"]')))
    loads = forecasts._prepared(pressed, {k: {"fz": load} for k, load in enumerate(pressed.vary["fz"])})
    assert [len(own.coils) for own in loads.values()] == [1, 2]


def test_each_process_prepares_what_it_meets(monkeypatch: pytest.MonkeyPatch) -> None:
    """A task goes to one process: three cannot meet coils of two tasks. The first starts the others."""
    plan = Forecast(((50, 60), (50, 30, 30), (110,)), 25, TRUE)
    assert plan.counts(1) == (1, 2, 3, 1, 110) and plan.counts(3) == (4, 5, 6, 3, 110)
    assert plan.wall(1) == plan.seconds() == pytest.approx(3.0 + 2 * 2.0 + 3 * 0.5 + 0.3 + 110 * 0.1)
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    assert plan.wall(3) == pytest.approx(3.0 + (3 * 3.0 + 5 * 2.0 + 6 * 0.5 + 3 * 0.3 + 110 * 0.1) / 2)
    assert Forecast(((), (), ()), 1, TRUE).seconds(2) == 0.0


@pytest.mark.slow
def test_more_are_tried_where_that_is_cheap(slow: list[float], tmp_path: Path) -> None:
    """Of a long study more places than of a short one, and never more than a tenth of the forecast."""
    long = forecast(read_study(written(tmp_path, SIMULATE.replace("count = 10", "count = 3000"))))
    assert long.tried[0] > 20 and long.tried[1] < 0.1 * long.seconds()


def test_what_cases_share(tmp_path: Path) -> None:
    """Coils with their plates by target, frequency and models, pads by elastomer and target; loads are free."""
    study = read_study(written(tmp_path, SIMULATE))
    point = {"elastomer.thickness": "2 mm", "target.width": "8 mm", "fz": "1 N"}
    found = study.shared(point)
    assert study.shared(point | {"fz": "2 N"}) == found._replace(load=(("fz", "2 N"),))
    assert study.shared(point | {"elastomer.thickness": "3 mm"})[::2] == found[::2]
    assert study.shared(point | {"target.width": "9 mm"}).coils != found.coils
    other = study.shared(point | {"frequency": "1 MHz"})
    assert other == found._replace(coils=(*found.coils, ("frequency", "1 MHz"))) and other.order == found.order
    assert Study(study.scenes, "pose", study.vary, {}).shared(point) == ((), *found[1:])
    silicone = study.shared(point | {"elastomer.material": "ecoflex-00-50"}).order
    assert silicone[:2] == found.order[:2] and silicone[2] != found.order[2]


def test_the_command_plans_and_keeps_what_it_tried(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without a folder nothing is written; with one the run has those cases, and tells planned and taken."""
    path, out = written(tmp_path, INDUCTANCE), tmp_path / "out"
    assert run(["sweep", str(path), "--plan"]) == 0
    said = capsys.readouterr()
    assert said.err.startswith("60 cases to solve, 0 kept; coils and plates: 2, ")
    assert "inductance: 60 cases, 0 of them kept" in said.out and "with -j 1" in said.out and not out.exists()
    assert run(["sweep", str(path), "--plan", "-o", str(out), "-j", "2"]) == 0
    with opened(out) as cases:
        kept = cases.names
    said = capsys.readouterr()
    assert f"60 cases, {len(kept)} of them kept" in said.out and f"tried {len(kept)} cases in" in said.err
    assert json.loads((out / "plan.json").read_text())["kept"] == len(kept) > 3
    assert run(["sweep", str(path), "-o", str(out), "--accept"]) == 0
    assert "planned: " in capsys.readouterr().err
    assert run(["sweep", str(path), "-o", str(out), "--accept"]) == 0
    assert "planned: " not in capsys.readouterr().err
    assert run(["sweep", str(path), "--plan", "-o", str(out)]) == 0
    assert "60 cases, 60 of them kept" in capsys.readouterr().out and (out / STORE).exists()


def test_more_than_a_day_or_than_the_disk_is_asked_for(tmp_path: Path) -> None:
    """One line that says how much; two processes have two days' time; a plan of other cases says nothing."""
    with opened(tmp_path) as cases:
        cases.put([("a", {"status": "ok", "lasting": True})])
        note(Forecast(((100_000,),) * 3, 1, StepCounts(0.0, 0.0, 0.0, 0.0, 1.0)), cases)
    assert noted(tmp_path, 2) == noted(tmp_path, yes=True) == 100_000.0
    with pytest.raises(SceneError, match=r"must be planned for a day at most; 1.2 days \(--yes\)"):
        noted(tmp_path)
    with opened(tmp_path) as cases:
        note(Forecast(((10**12,),) * 3, 1), cases)
    with pytest.raises(SceneError, match="must be on a disk with room for what is planned; it needs some .* GiB of "):
        noted(tmp_path)
    with opened(tmp_path) as cases:
        cases.put([("b", {"status": "ok", "lasting": True})])
    assert noted(tmp_path) is None
    (tmp_path / "plan.json").write_text("{}")
    with pytest.raises(SceneError, match="plan.json: must be as --plan wrote it"):
        noted(tmp_path)


def test_bad_words_of_a_plan(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One line each."""
    for words, message in (([], "--output must be given"), (["--plan", "-j", "0"], "processes must be one or more")):
        assert run(["sweep", str(written(tmp_path, INDUCTANCE)), *words]) == 2
        assert message in capsys.readouterr().err


def test_a_case_that_another_try_may_better_is_not_counted_as_kept(
    slow: list[float], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Its disk was full: the run solves it again, and the plan says so."""
    study = read_study(written(tmp_path, SIMULATE))

    def full(self: Case, **point: object) -> dict[str, float]:
        """Fail as a full disk does."""
        raise OSError("no space left on device")

    monkeypatch.setattr(Case, "__call__", full)
    with opened(tmp_path) as cases:
        found = forecast(study, cases)
        assert not cases.names and (found.kept, found.cases) == (0, 60)
