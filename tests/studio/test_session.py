"""A tab without its page: what it asks for, what it shows, what it says of wrong input, the command of its state."""

import shlex
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from sits_mech.cli.main import run
from sits_mech.scene.sensor import SceneError, scene_text
from sits_mech.studio.previews import Solved, open_share
from sits_mech.studio.questions import Question, grid_of
from sits_mech.studio.session import Session, View


class Waiting:
    """A solver that keeps what it is asked for."""

    def __init__(self) -> None:
        self.kept: dict[Any, Any] = {}
        self.folder = Path("nowhere")
        self.asked: Sequence[tuple[Question, bool]] = ()

    def ask(self, tab: str, questions: Sequence[tuple[Question, bool]], told: Callable[..., None]) -> None:
        """Keep the questions."""
        self.asked, self.told = questions, told

    def answers(self, question: Question, what: Any) -> None:
        """Answer one."""
        self.kept[question.key] = what
        self.told(question, "done", what)


@pytest.fixture
def session() -> tuple[Session, Waiting, list[View]]:
    """A tab of the published sensor, opened."""
    solver, views = Waiting(), list[View]()
    def later(call: Callable[..., Any], *arguments: Any) -> None:
        """Call at once."""
        call(*arguments)

    found = Session(solver, "tab", views.append, ("linear", "planar", 0.02), later)  # type: ignore[arg-type]
    found.open("biorob2018-w15", most={"F_x": 0.5, "F_z": 2.0})
    return found, solver, views


def test_a_table_then_its_slopes_then_previews(session: tuple[Session, Waiting, list[View]], base: Solved) -> None:
    """What is asked for first, and what is seen meanwhile."""
    tab, solver, views = session
    assert views[-1].kind == "drawing" and [urgent for _, urgent in solver.asked] == [True, False]
    table, slopes = (question for question, _ in solver.asked)
    assert table.loads == (("F_x", grid_of("F_x", 0.5)), ("F_z", grid_of("F_z", 2.0))) and slopes.numbers
    solver.answers(table, base.data)
    assert views[-1].kind == "solved" and views[-1].data is base.data
    solver.answers(slopes, base.slopes)
    tab.change("elastomer.thickness", "0.0021")
    assert views[-1].kind == "preview" and views[-1].data is not None
    assert open_share(views[-1].data) > open_share(base.data)
    kinds = [(question.sensor.elastomer.thickness, urgent) for question, urgent in solver.asked]
    assert kinds[0] == (0.0021, True) and [one for one, urgent in kinds[1:]] == pytest.approx([0.00176, 0.00228])
    tab.change("elastomer.thickness", "0.002")
    assert views[-1].kind == "solved"


def test_the_command_gives_the_same(session: tuple[Session, Waiting, list[View]]) -> None:
    """Keys, loads and models; a star stands for all coils."""
    tab, _, _ = session
    tab.change("coils.*.turns", "10")
    words = shlex.split(tab.command)
    assert words[:3] == ["sits-mech", "calibrate", "biorob2018-w15"]
    assert "coils.C1.turns=10" in words and "coils.C2.turns=10" in words
    assert words[words.index("--fx") + 1] == "-0.5 N:0.5 N:5" and words[words.index("--mechanics") + 1] == "linear"
    text = scene_text(tab.sensor).replace("thickness = 0.002", "thickness = 0.0025")
    from sits_mech.studio.page import sensor_of

    tab.take(sensor_of(text))
    assert tab.sensor.elastomer.thickness == 0.0025 and tab.keys["elastomer.thickness"] == "0.0025"


def test_requirements_are_judged_and_searched(session: tuple[Session, Waiting, list[View]], base: Solved) -> None:
    """Their loads are shown; figures at a glance until they are solved; a search that is stopped is asked no more."""
    tab, solver, views = session
    text = (
        '[loads]\nF_x = ["-0.5 N", "0.5 N"]\nF_z = ["0 N", "2 N"]\n[vary]\n"elastomer.thickness" = ["2 mm", "3 mm"]\n'
        '[require]\nheight = "4 mm"\n'
    )
    tab.find(text)
    assert tab.most == {"F_x": 0.5, "F_z": 2.0}
    kinds = [type(question).__name__ for question, _ in solver.asked]
    assert kinds[:3] == ["Table", "Search", "Figures"]
    table, search, figures = (question for question, _ in solver.asked[:3])
    solver.answers(table, base.data)
    assert views[-1].judged is not None and not views[-1].judged.solved
    solver.told(search, "progress", (1, 72, "thickness 2 mm"))
    assert tab.tried == ["thickness 2 mm"] and "1 of at most 72" in views[-1].state
    solver.answers(figures, (views[-1].judged.task, views[-1].judged.found))
    assert views[-1].judged is not None and views[-1].judged.solved
    solver.told(search, "failed", "loads: no design within the bounds answers them")
    assert tab.search is None and tab.tried[-1].startswith("loads: ")
    tab.find(text)
    tab.stop()
    assert solver.asked == [] and views[-1].state == "stopped" and tab.search is None
    with pytest.raises(SceneError, match="loads: "):
        tab.require(text.replace("F_z", "F_q"))


def test_wrong_input_changes_nothing(session: tuple[Session, Waiting, list[View]]) -> None:
    """The message of the command line; what is shown stays."""
    tab, solver, views = session
    before, seen = tab.sensor, len(views)
    with pytest.raises(SceneError, match="target.width: must be a length"):
        tab.change("target.width", "-1")
    assert tab.sensor is before and len(views) == seen and not tab.keys
    solver.told(tab.question(tab.sensor), "failed", "mechanics: must be otherwise")
    assert views[-1].state == "not solved: mechanics: must be otherwise"
    tab.close()
    assert solver.asked == []


def test_without_nicegui_one_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """What must be installed; a port that cannot be, a scene that is not there."""
    monkeypatch.setitem(sys.modules, "nicegui", None)
    monkeypatch.delitem(sys.modules, "sits_mech.studio.page", raising=False)
    for words, why in ((["studio"], "studio: must have nicegui: pip install 'sits-mech[studio]'"),
                       (["studio", "--port", "70000"], "--port: must be from 0 to 65535; got 70000"),
                       (["studio", "nowhere"], "nowhere: no such file")):
        assert run(words) == 2
        assert why in capsys.readouterr().err
