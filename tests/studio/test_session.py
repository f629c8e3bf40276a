"""A tab without its page: what it asks for, what it shows, what it says of wrong input, the command of its state."""

import shlex
import sys
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from sits_mech.cli.main import run
from sits_mech.scene.sensor import SceneError, load_sensor
from sits_mech.studio.previews import SolvedScene, open_share
from sits_mech.studio.questions import StudioQuestion, ends_asked, grid_of
from sits_mech.studio.session import Session, View


class Waiting:
    """A solver that keeps what it is asked for."""

    def __init__(self) -> None:
        self.kept: dict[Any, Any] = {}
        self.folder = Path("nowhere")
        self.asked: Sequence[tuple[StudioQuestion, bool]] = ()

    def ask(self, tab: str, questions: Sequence[tuple[StudioQuestion, bool]], send: Callable[..., None]) -> None:
        """Keep the questions."""
        self.asked, self.send = questions, send

    def answers(self, question: StudioQuestion, what: Any) -> None:
        """Answer one."""
        self.kept[question.key] = what
        self.send(question, "done", what)


@pytest.fixture
def session() -> tuple[Session, Waiting, list[View]]:
    """A tab of the published sensor, opened."""
    solver, views = Waiting(), list[View]()
    def later(call: Callable[..., Any], *arguments: Any) -> None:
        """Call at once."""
        call(*arguments)

    found = Session(solver, "tab", views.append, ("linear", "planar", 0.02), later)  # type: ignore[arg-type]
    found.open("biorob2018-w15", ends={"F_x": (-0.5, 0.5), "F_z": (0.0, 2.0)})
    return found, solver, views


def test_a_table_then_its_slopes_then_previews(session: tuple[Session, Waiting, list[View]], base: SolvedScene) -> None:
    """What is asked for first, and what is seen meanwhile."""
    tab, solver, views = session
    assert views[-1].kind == "drawing" and [urgent for _, urgent in solver.asked] == [True, False]
    table, slopes = (question for question, _ in solver.asked)
    assert table.loads == (("F_x", grid_of(-0.5, 0.5)), ("F_z", grid_of(0.0, 2.0))) and slopes.numbers
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


def test_what_another_tab_was_answered_is_taken(
    session: tuple[Session, Waiting, list[View]], base: SolvedScene
) -> None:
    """A page that is loaded again, a scene that is come back to: its range of loads and its table are there at once."""
    tab, solver, views = session
    tab.open("biorob2018-w15")
    borne = solver.asked[0][0]
    assert borne.loads == () and views[-1].state == "waits for its first table"
    solver.answers(borne, ends := {"F_x": (-0.5, 0.5), "F_z": (0.0, 2.0)})
    table, slopes = (question for question, _ in solver.asked)
    solver.answers(table, base.data)
    solver.answers(slopes, base.slopes)
    tab.open("biorob2018")
    assert views[-1].kind == "drawing"
    seen = list[View]()
    other = Session(solver, "other", seen.append, tab.models, lambda call, *what: call(*what))  # type: ignore[arg-type]
    for each, shown in ((tab, views), (other, seen)):
        each.open("biorob2018-w15")
        assert each.ends == ends and shown[-1].kind == "solved" and shown[-1].data is base.data
        each.change("elastomer.thickness", "0.0021")
        assert shown[-1].kind == "preview"


def test_how_far_a_table_is(
    session: tuple[Session, Waiting, list[View]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Loads that are done, the time left by theirs, and what is solved; why it is not, where it cannot be."""
    _, solver, views = session
    table, now = solver.asked[0][0], [100.0]
    monkeypatch.setattr("sits_mech.studio.session.time.monotonic", lambda: now[0])
    for seconds, kind, what, said in (
        (0.0, "started", None, "solving"),
        (1.0, "step", ("3674 unknowns: at rest",), "solving; 3674 unknowns: at rest"),
        (3.0, "progress", (0, 9), "solving: 0 of 9 loads; 3674 unknowns: at rest"),
        (6.0, "progress", (3, 9), "solving: 3 of 9 loads, about 12 s left; 3674 unknowns: at rest"),
        (7.0, "failed", "too soft", "not solved: too soft"), (20.0, "started", None, "solving"),
    ):
        now[0] = 100.0 + seconds
        solver.send(table, kind, what)
        assert views[-1].state == said


def test_the_command_gives_the_same(session: tuple[Session, Waiting, list[View]]) -> None:
    """Keys, loads and models; a star stands for all coils."""
    tab, _, _ = session
    tab.change("coils.*.turns", "10")
    words = shlex.split(tab.command)
    assert words[:3] == ["sits-mech", "calibrate", "biorob2018-w15"]
    assert "coils.0.turns=10" in words and "coils.1.turns=10" in words
    assert words[words.index("--fx") + 1] == "-0.5 N:0.5 N:5" and words[words.index("--mechanics") + 1] == "linear"
    tab.change("elastomer.thickness", "2.5 mm")
    tab.change("coils.C1.centre", "[-0.004, 0.001]")
    tab.change("name", "of 'two' \"marks\"")
    words = shlex.split(tab.command)
    keys = [after for word, after in pairwise(words) if word == "--set"]
    assert load_sensor(words[2], keys) == tab.sensor
    tab.open(words[2], tab.keys, tab.ends)
    assert shlex.split(tab.command) == words


def test_what_keys_cannot_tell_is_of_the_scene_file(session: tuple[Session, Waiting, list[View]]) -> None:
    """A coil more, a coil less, a key that is gone; a scene of a folder with blanks is quoted."""
    tab, _, _ = session
    opened = tab.sensor
    more = opened.coils[0].model_copy(update={"name": "C3", "centre": (0.0, 0.02)})
    bare = opened.elastomer.model_copy(update={"standoff": 0.0})
    for update in ({"coils": (*opened.coils, more)}, {"coils": opened.coils[:1]}, {"elastomer": None}):
        tab.take(opened.model_copy(update=update))
        assert tab.keys is None and shlex.split(tab.command)[2] == "scene.toml"
    tab.take(opened.model_copy(update={"elastomer": bare}))
    assert tab.keys is not None and load_sensor(tab.source, [f"{key}={value}" for key, value in tab.keys.items()]) == (
        tab.sensor)
    tab.source = "my scenes/one.toml"
    assert shlex.split(tab.command)[2] == tab.source


def test_requirements_are_judged_and_searched(session: tuple[Session, Waiting, list[View]], base: SolvedScene) -> None:
    """Their loads are shown; figures at a glance until they are solved; a search that is stopped is asked no more."""
    tab, solver, views = session
    text = (
        '[loads]\nF_x = ["-0.5 N", "0.5 N"]\nF_z = ["0 N", "2 N"]\n[vary]\n"elastomer.thickness" = ["2 mm", "3 mm"]\n'
        '[require]\nheight = "4 mm"\n'
    )
    tab.find(text)
    assert tab.ends == {"F_x": (-0.5, 0.5), "F_z": (0.0, 2.0)}
    kinds = [type(question).__name__ for question, _ in solver.asked]
    assert kinds[:3] == ["TableQuestion", "SearchQuestion", "Figures"]
    table, search, figures = (question for question, _ in solver.asked[:3])
    solver.answers(table, base.data)
    assert views[-1].judged is not None and not views[-1].judged.solved
    solver.send(search, "progress", (1, 72, "thickness 2 mm"))
    assert tab.tried == ["thickness 2 mm"] and "1 of at most 72" in views[-1].state
    solver.answers(figures, (views[-1].judged.task, views[-1].judged.found))
    assert views[-1].judged is not None and views[-1].judged.solved
    solver.send(search, "failed", "loads: no design within the bounds answers them")
    assert tab.search is None and tab.tried[-1].startswith("loads: ")
    tab.require(text.replace('"0 N", "2 N"', '"-2 N", "0 N"'))  # a side of their own
    table, figures = (question for question, _ in solver.asked[:2])
    assert dict(table.loads)["F_z"] == grid_of(-2.0, 0.0)
    solver.send(figures, "failed", "loads: must be borne")
    assert views[-1].state == "not judged: loads: must be borne"
    tab.update()
    assert figures.key not in [question.key for question, _ in solver.asked]
    tab.find(text)
    tab.stop()
    assert solver.asked == [] and views[-1].state == "stopped" and tab.search is None
    solver.send(table, "done", base.data)  # on its way as it stopped
    assert solver.asked == [] and views[-1].state == "stopped" and tab.stopped
    with pytest.raises(SceneError, match="loads.F_q: "):
        tab.require(text.replace("F_z", "F_q"))


def test_wrong_input_changes_nothing(session: tuple[Session, Waiting, list[View]]) -> None:
    """The message of the command line; what is shown stays."""
    tab, solver, views = session
    before, seen = tab.sensor, len(views)
    with pytest.raises(SceneError, match="target.width: must be a length"):
        tab.change("target.width", "-1")
    assert tab.sensor is before and len(views) == seen and not tab.keys
    solver.send(tab.question(tab.sensor), "failed", "mechanics: must be otherwise")
    assert views[-1].state == "not solved: mechanics: must be otherwise"
    tab.close()
    assert solver.asked == []


def test_without_nicegui_one_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """What must be installed; a port that cannot be, a scene that is not there."""
    monkeypatch.setitem(sys.modules, "nicegui", None)
    monkeypatch.delitem(sys.modules, "sits_mech.studio.page", raising=False)
    for words, why in ((["studio"], "studio: must have nicegui: pip install '.[studio]' in a clone"),
                       (["studio", "--port", "70000"], "--port: must be from 0 to 65535; got 70000"),
                       (["studio", "nowhere"], "nowhere: no such file"),
                       (["studio", "--mechanics", "nonsense"], "model (mechanics) must be one of"),
                       (["studio", "--tolerance", "7"], "tolerance must lie between 0 and 1; got 7.0")):
        assert run(words) == 2
        assert why in capsys.readouterr().err


def test_an_address_names_ranges_of_loads_or_the_largest() -> None:
    """Shear to both sides, as the addresses of before have it; what is no number is none."""
    asked = {"F_x": "0.3", "F_z": "-2:0.5", "M": "x", "M_x": "1:0", "M_z": "inf", "F_y": "-1", "scene": "biorob2018"}
    assert ends_asked(asked) == {"F_x": (-0.3, 0.3), "F_z": (-2.0, 0.5)}
