"""The drawing of a scene: every size is written, a metre for a millimetre too; the section is where coils are."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from sits_mech.cli.main import run
from sits_mech.report.pictures.drawing import scene_drawing
from sits_mech.scene.sensor import Conductor, changed, load_sensor

PAIR = load_sensor("biorob2018-w15")


def texts(figure: Figure) -> set[str]:
    """Return what stands in plan and section."""
    return {text.get_text() for axes in figure.axes for text in axes.texts}


def test_sizes_are_written() -> None:
    """Coils, their distance, target, pad, heights; the list of parts below."""
    figure = scene_drawing(changed(PAIR, ['elastomer.standoff="0.3 mm"']))
    for words in ("C1 ⌀ 6.8", "8", "target 15", "target 8", "pad 20", "pad 2", "target 0.2", "stand-off 0.3"):
        assert words in texts(figure), words
    assert "⌀ 2.2 to 6.8; 12 turns in 2 layers 0.085 apart" in figure.get_supxlabel()
    assert "section A, y = 0" in texts(figure) and figure.axes[0].get_aspect() == 1.0 == figure.axes[1].get_aspect()


def test_a_cover_is_drawn_around_its_target() -> None:
    """8 mm in the plan's y and 15 in x, 1.5 mm beyond; as high as target and what is over it, and the target within."""
    figure = scene_drawing(changed(PAIR, ['cover={material="dragon-skin-30", thickness="1 mm", overhang="1.5 mm"}']))
    assert {"cover 18", "cover 11", "cover 1.2", "target 0.2"} <= texts(figure)
    assert "cover: 18 x 11, 1 over the target, dragon-skin-30" in figure.get_supxlabel()
    pad, cover, target = (own.get_paths()[0].vertices for own in figure.axes[1].collections[:3])
    np.testing.assert_allclose([np.ptp(each[:, 1]) for each in (pad, cover, target)], [2.0, 1.2, 0.2], atol=1e-9)
    np.testing.assert_allclose([each[:, 1].min() for each in (cover, target)], 2.0, atol=1e-9)


def test_pillars_are_drawn_one_by_one() -> None:
    """Nine, three of them cut at y = 0, of 6.5 mm from rim to rim; wide targets beside narrower pads."""
    keys = ['elastomer.shape="pillars"', 'elastomer.pitch="2.5 mm"', 'elastomer.diameter="1.5 mm"']
    small = ['target.width="8 mm"', 'elastomer.width="8 mm"', 'elastomer.length="8 mm"']
    figure = scene_drawing(changed(PAIR, [*small, *keys]))
    assert {"target 8", "pad 6.5"} <= texts(figure)
    assert "pad: 9 pillars ⌀ 1.5 every 2.5, 2 thick" in figure.get_supxlabel()
    pillars = [np.ptp(path.vertices[:, 0]) for path in figure.axes[1].collections[0].get_paths()]
    np.testing.assert_allclose(pillars, 1.5, atol=2e-3)
    assert len(pillars) == 3
    assert {"target 15", "pad 8"} <= texts(scene_drawing(changed(PAIR, small[1:])))


def test_a_square_coil() -> None:
    """Its sides instead of a diameter, its layers by their heights."""
    figure = scene_drawing(load_sensor("square-4"))
    assert "C1 6.5" in texts(figure)
    words = "2 x 2 to 6.5 x 6.5; 8 turns in copper at z = -0.0175, -0.25, -1.35, -1.583; tracks 0.15 x 0.035, gaps 0.15"
    assert words in figure.get_supxlabel()


def test_a_metre_for_a_millimetre_shows() -> None:
    figure = scene_drawing(changed(PAIR, ['elastomer.thickness="2 m"']))
    low, high = figure.axes[1].get_ylim()
    assert "pad 2000" in texts(figure) and high - low > 2000.0


def test_the_section_is_where_coils_are() -> None:
    """Coils at y = 4 mm alone: cut there, with the chord of a round target."""
    coils = tuple(coil.model_copy(update={"centre": (coil.centre[0], 4e-3)}) for coil in PAIR.coils)
    disc = PAIR.target.model_copy(update={"shape": "disc", "width": None, "length": None, "diameter": 12e-3})
    figure = scene_drawing(PAIR.model_copy(update={"coils": coils, "target": disc}))
    assert "section A, y = 4 mm" in texts(figure) and "target ⌀ 12" in texts(figure)
    boxes = [np.ptp(path.vertices[:, 0]) for part in figure.axes[1].collections for path in part.get_paths()]
    assert min(abs(size - 2.0 * np.sqrt(36.0 - 16.0)) for size in boxes) < 0.02


def test_other_scenes() -> None:
    """Fixed metal, an outline with a hole, a curved substrate without pad, one coil."""
    nut = Conductor(
        name="nut", material="copper", shape="disc", centre=(14e-3, 6e-3, 1e-3), diameter=5e-3, thickness=3e-3
    )
    figure = scene_drawing(PAIR.model_copy(update={"conductors": (nut,)}))
    assert {"nut", "nut 3"} <= texts(figure) and "nut: ⌀ 5, 3 thick, middle at z = 1" in figure.get_supxlabel()
    rim = {
        "points": ((-6e-3, -4e-3), (7e-3, -4e-3), (0.0, 5e-3)),
        "holes": (((-1e-3, -1e-3), (1e-3, -1e-3), (0.0, 1e-3)),),
    }
    outline = PAIR.target.model_copy(update={"shape": "outline", "width": None, "length": None, **rim})
    figure = scene_drawing(PAIR.model_copy(update={"target": outline}))
    assert {"target 13", "target 9"} <= texts(figure) and "target: 13 x 9" in figure.get_supxlabel()
    round_one = PAIR.model_copy(update={"substrate_radius": 12e-3, "elastomer": None, "coils": PAIR.coils[:1]})
    figure = scene_drawing(round_one)
    assert figure.axes[1].get_ylim()[0] < -2.0 and "cylinder of radius 12" in figure.get_supxlabel()
    assert "target 0.2" not in texts(figure) and "its height is that of a pose" in figure.get_supxlabel()


def test_by_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file; a load or a pose beside it is refused."""
    assert run(["view", "biorob2018", "--kind", "scene", "-o", str(tmp_path / "scene.svg")]) == 0
    assert (tmp_path / "scene.svg").read_text().startswith("<?xml")
    for words in (["--fz", "1 N"], ["--dv", "2 mm"]):
        assert run(["view", "biorob2018", "--kind", "scene", *words]) == 2
        assert "--kind scene: must have neither a load nor a pose" in capsys.readouterr().err
