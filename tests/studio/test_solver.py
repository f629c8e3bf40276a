"""The process beside: the same digits as in this one, what is kept, what is refused, stopped or killed."""

import time
from collections.abc import Iterator
from typing import Any

import pytest
import xarray as xr

from sits_mech.chain.calibrate import calibrate
from sits_mech.scene.sensor import changed, load_sensor
from sits_mech.studio.questions import Borne, StudioQuestion, TableQuestion, grid_of
from sits_mech.studio.solver import SolverProcess

LOADS = (("F_x", grid_of(-0.4, 0.4)), ("F_z", grid_of(0.0, 1.0)))
MODELS = ("linear", "planar", 0.1)


class Heard:
    """What a solver said."""

    def __init__(self) -> None:
        self.words: list[tuple[StudioQuestion, str, Any]] = []

    def __call__(self, question: StudioQuestion, kind: str, what: Any) -> None:
        self.words.append((question, kind, what))

    def wait(self, *kinds: str, seconds: float = 60.0) -> Any:
        """Return what came with the first word of some kinds."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for _, kind, what in list(self.words):
                if kind in kinds:
                    return what
            time.sleep(0.02)
        raise AssertionError(f"none of {kinds}: {[kind for _, kind, _ in self.words]}")


@pytest.fixture(scope="module")
def solver() -> Iterator[SolverProcess]:
    """One for all tests."""
    found = SolverProcess()
    yield found
    found.close()


def test_the_same_digits_and_kept(solver: SolverProcess) -> None:
    """As of `calibrate` in this process; asked again, by another tab, it is there at once."""
    question, heard, again = TableQuestion(load_sensor("biorob2018"), LOADS, MODELS), Heard(), Heard()
    solver.ask("one", [(question, True)], heard)
    found = heard.wait("done")
    own = calibrate(question.sensor, **dict(LOADS), mechanics="linear", magnetics="planar", tolerance=0.1)
    xr.testing.assert_identical(found["L"].drop_attrs(), own["L"].drop_attrs())
    assert {kind for _, kind, _ in heard.words} >= {"started", "progress", "done"}
    solver.ask("two", [(question, True)], again)
    assert again.wait("done") is found and [kind for _, kind, _ in again.words] == ["done"]


@pytest.mark.slow
def test_loads_that_the_pad_bears(solver: SolverProcess) -> None:
    """Asked for where there are none; shear along the axis of the coils."""
    heard = Heard()
    solver.ask("one", [(Borne(load_sensor("biorob2018"), (), MODELS), True)], heard)
    assert list(heard.wait("done")) == ["F_x", "F_z"]


@pytest.mark.slow
def test_what_cannot_be_solved_and_a_process_that_is_killed(solver: SolverProcess) -> None:
    """Each says so, and the next question is answered."""
    sensor, heard = load_sensor("biorob2018"), Heard()
    bad = TableQuestion(sensor, LOADS, ("linear", "axisymmetric", 0.1))
    solver.ask("one", [(bad, True)], heard)
    assert "must" in heard.wait("failed")
    killed = Heard()
    solver.ask("one", [(TableQuestion(sensor, LOADS, ("block", "sheets", 0.02)), True)], killed)
    killed.wait("started")
    time.sleep(0.3)
    solver._process[0].kill()
    assert "ended" in killed.wait("failed")
    after = Heard()
    solver.ask("one", [(TableQuestion(changed(sensor, ["target.width=0.009"]), LOADS, MODELS), True)], after)
    after.wait("done")


def test_what_is_no_longer_wanted_is_stopped(solver: SolverProcess) -> None:
    """A long one makes room for the next of its tab, and tells nothing; its process stays, with what it prepared."""
    sensor, slow, quick = load_sensor("biorob2018"), Heard(), Heard()
    solver.ask("one", [(TableQuestion(sensor, LOADS, ("block", "sheets", 1e-3)), True)], slow)
    slow.wait("started")
    process = solver._process[0]
    solver.ask("one", [(TableQuestion(changed(sensor, ["target.width=0.0085"]), LOADS, MODELS), True)], quick)
    quick.wait("done")
    assert "done" not in [kind for _, kind, _ in slow.words] and solver._process[0] is process


@pytest.mark.slow
def test_what_another_tab_still_wants_is_answered(solver: SolverProcess) -> None:
    """One of two tabs leaves while both wait for the same."""
    sensor, first, second = load_sensor("biorob2018"), Heard(), Heard()
    both = TableQuestion(changed(sensor, ["target.width=0.0095"]), LOADS, ("linear", "sheets", 0.05))
    solver.ask("one", [(both, True)], first)
    first.wait("started")
    solver.ask("two", [(both, True)], second)
    solver.ask("one", [], first)
    second.wait("done")
    assert "done" not in [kind for _, kind, _ in first.words]
