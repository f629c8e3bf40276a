"""What is required of a scene: read, judged by a table at a glance, drawn as rows and lines."""

import numpy as np
import pytest

from sits_mech.scene.sensor import SceneError
from sits_mech.studio.asked import Judged, first_words, glanced, lines, read_asked, rows_html
from sits_mech.studio.previews import SolvedScene
from sits_mech.studio.questions import Figures
from sits_mech.synthesis.required.requirements import Requirements

TEXT = """scene = "of another file"
[loads]
F_x = ["-0.5 N", "0.5 N"]
F_z = ["0 N", "1 N"]
[vary]
"elastomer.thickness" = { from = "1 mm", to = "4 mm" }
[require]
resolution = { F_x = "0.1 uN", F_z = "10 mN" }
error = { F_z = "5 %" }
height = "4 mm"
rate = "10 Hz"
[tolerance]
"elastomer.thickness" = "0.05 mm"
"""


@pytest.fixture
def asked(base: SolvedScene) -> Requirements:
    """Requirements of the scene that is shown."""
    return read_asked(TEXT, base.sensor)


@pytest.fixture
def judged(base: SolvedScene, asked: Requirements) -> Judged:
    """Its figures by its table."""
    found = glanced(asked, base.sensor, base.data)
    assert found is not None
    return found


def test_a_text_of_requirements_is_read_for_the_scene_that_is_shown(base: SolvedScene, asked: Requirements) -> None:
    """Its own scene is left aside; what is wrong is said as `design` says it."""
    assert asked.space.base == base.sensor and asked.limits["height"] == pytest.approx(4e-3)
    slip = TEXT.replace("resolution", "resolutoin")
    for text, why in (("[loads", "requirements: must be TOML"), (slip, "require.resolutoin: ")):
        with pytest.raises(SceneError, match=why):
            read_asked(text, base.sensor)
    first = read_asked(first_words({"F_x": (-0.5, 0.5), "F_z": (0.0, 2.0)}, base.sensor), base.sensor)
    assert first.loads == {"F_x": (-0.5, 0.5), "F_z": (0.0, 2.0)} and first.space.names == ("elastomer.thickness",)
    moment = read_asked(first_words({"F_z": (0.0, 2.0), "M": (-2e-3, 2e-3)}, base.sensor), base.sensor)
    assert moment.minimised == {"error.M": 1.0} and moment.loads["M"] == (-2e-3, 2e-3)


def test_figures_at_a_glance_have_no_error_by_tolerances(
    base: SolvedScene, judged: Judged, asked: Requirements
) -> None:
    """Those with a limit first, each with what is spare of it; of a preview without errors; nothing of a hole."""
    rows = {each.name: each for each in judged.rows}
    assert rows["height"].holds == rows["resolution.F_z"].holds == rows["rate"].holds == "yes"
    assert rows["resolution.F_x"].holds == "no" and not any(name.startswith("error.") for name in rows)
    text = rows_html(judged)
    assert 'class="sits-asked preview"' in text and "at least 10 Hz" in text and "no, -" in text
    like = glanced(asked, base.sensor, base.data, judged)
    assert like is not None and like.found.table is not None and judged.found.table is not None
    np.testing.assert_array_equal(like.found.table.L, judged.found.table.L)
    assert not like.found.error and judged.found.error
    hole = base.data.copy(deep=True)
    hole["status"][0, 0] = "not carried"
    assert glanced(asked, base.sensor, hole) is None


def test_lines_over_the_explorer(base: SolvedScene, judged: Judged) -> None:
    """Ranges of loads, the height above the coils' top, resolution at each load where there is a limit."""
    found = lines(judged, base.sensor, base.data)
    assert found.ranges == {"F_x": (-0.5, 0.5), "F_z": (0.0, 1.0)}
    assert found.height == pytest.approx(2.2e-3 + 4e-3 - judged.found.plain["height"])
    each = {item["name"]: item for item in found.items}
    assert list(each) == ["resolution_F_x", "resolution_F_z"]
    most = max(float(np.max(item["values"])) for item in found.items)
    figures = judged.task.figures(judged.found)
    assert 0.0 < most <= 1.001 * max(figures[f"resolution.{name}"] for name in found.ranges)


@pytest.mark.slow
def test_figures_solved_as_a_design_is(base: SolvedScene, asked: Requirements) -> None:
    """With errors by tolerances, at the loads of the requirements; nothing of it stands beyond these loads."""
    found = Judged(True, asked, *Figures(base.sensor, (), ("linear", "planar", 0.1), asked).answer(lambda *_: None))
    rows = {each.name: each for each in found.rows}
    assert rows["error.F_z"].value > 0.0 and rows["strain"].limit is not None and found.share.value <= 1.0
    assert "sensors that hold all" in rows_html(found)
    curves = {item["name"]: item["values"] for item in lines(found, base.sensor, base.data).items}
    assert np.isnan(curves["error_F_z"][:, -1]).all() and np.isfinite(curves["error_F_z"][:, :-1]).all()
