"""Pictures: what they show stands where the numbers say; axes have units; files appear whole."""

import json
import os
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from sits_mech.mechanics.block import BlockPad
from sits_mech.mechanics.element.mesh import DeformedSection
from sits_mech.quantities import Equilibrium, Pose, SolveReport, Wrench
from sits_mech.report.pictures.section import layer_view, load_angle, load_view
from sits_mech.report.pictures.style import STYLE, new_figure, numbered_labels, save_figure, strokes
from sits_mech.report.plots.curves import calibration_pictures, crosstalk_map, signal_curves
from sits_mech.report.tables.loops import loop_curves
from sits_mech.scene.sensor import SceneError, load_sensor

Collisions = Callable[[Figure], list[str]]


@pytest.fixture
def data() -> xr.Dataset:
    """L_v even and L_h odd in F_x."""
    found = xr.Dataset(coords={"F_x": [-1.0, 0.0, 1.0], "F_z": [0.0, 1.0, 2.0], "coil": ["C1", "C2"]})
    x, z = found.F_x + 0.0 * found.F_z, 0.0 * found.F_x + found.F_z
    errors = {f"error_{name}_percent": 0.01 + 0.0 * x for name in ("L_v", "L_h")}
    return found.assign({"L_v_percent": 190.0 - z - x**2, "L_h_percent": (3.0 + z) * x, **errors})


def test_normal_curves_show_the_numbers(data: xr.Dataset) -> None:
    """Mirrored curves are one, with both signs in the legend."""
    (axes,) = signal_curves(data, "F_z").axes
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["0", "±1"]
    np.testing.assert_allclose(axes.containers[1].lines[0].get_ydata(), [189.0, 188.0, 187.0])
    assert "[N]" in axes.get_xlabel() and "[% of $L_0$]" in axes.get_ylabel()


def test_shear_curves_show_the_numbers(data: xr.Dataset) -> None:
    """One curve per normal force."""
    (axes,) = signal_curves(data, "F_x").axes
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["0", "1", "2"]
    np.testing.assert_allclose(axes.containers[2].lines[0].get_ydata(), [-5.0, 0.0, 5.0])


def test_bars_are_drawn_where_they_are_seen(data: xr.Dataset) -> None:
    """Not behind their marks; the title says the largest error either way."""
    figure = signal_curves(data.assign(error_L_v_percent=0.0 * data["error_L_v_percent"] + 0.5), "F_z")
    assert "bars: errors up to 0.5 %" in figure.get_suptitle() and figure.axes[0].containers[0].has_yerr
    figure = signal_curves(data, "F_z")
    assert "bars" not in figure.get_suptitle() and not figure.axes[0].containers[0].has_yerr


def test_a_legend_keeps_clear_of_bars(data: xr.Dataset) -> None:
    """Of errors larger than the curves, whose bars reach into every corner but the upper middle."""
    wide = data.assign(error_L_h_percent=0.0 * data["L_h_percent"] + 8.0 * np.abs(data.F_x))
    figure = signal_curves(wide, "F_x")
    figure.canvas.draw()
    (axes,) = figure.axes
    box = axes.get_legend().get_window_extent()
    ends = [axes.transData.transform(bar) for drawn in axes.containers for bar in drawn.lines[2][0].get_segments()]
    assert len(ends) == 9 and not any(
        box.x0 < x < box.x1 and low < box.y1 and high > box.y0 for (x, low), (_, high) in ends
    )


def test_lines_of_equal_crosstalk_are_labelled_upright(data: xr.Dataset) -> None:
    """A 6 stays a 6 where its line goes down, and a minus is one."""
    texts = [text for axes in crosstalk_map(data).axes[:2] for text in axes.texts]
    assert texts and all(text.get_rotation() == 0.0 and "-" not in text.get_text() for text in texts)
    assert any(text.get_text().startswith("\u2212") for text in texts)


def test_crosstalk_map_shows_both_ways(data: xr.Dataset) -> None:
    """2 of 6 for F_z into L_h, -1 of 2 for F_x into L_v; symmetric colour scales with units."""
    figure = crosstalk_map(data)
    maps = [axes.collections[0] for axes in figure.axes[:2]]
    assert [float(np.max(np.abs(picture.get_array()))) for picture in maps] == pytest.approx([100.0 / 3.0, 50.0])
    assert all(picture.get_clim()[0] == -picture.get_clim()[1] for picture in maps)
    for axes in figure.axes[:2]:
        written = {float(text.get_text().replace("\u2212", "-")) for text in axes.texts}
        assert written and written <= set(axes.collections[1].levels.tolist())


def test_other_forces_are_at_the_middle(data: xr.Dataset) -> None:
    """A slice, with a title that says where; without the usual forces those that there are."""
    wide = data.expand_dims({"F_y": [-1.0, 0.5, 1.0]}, axis=2).assign_coords(M=2e-3)
    wide = wide.assign(L_v_percent=wide["L_v_percent"] + wide["F_y"])
    figure = signal_curves(wide, "F_z")
    np.testing.assert_allclose(figure.axes[0].containers[1].lines[0].get_ydata(), [189.5, 188.5, 187.5])
    assert figure.get_suptitle() == "normal signal; $M$ = 0.002 N m, $F_y$ = 0.5 N\nerrors up to 0.01 % of $L_0$"
    (axes,) = signal_curves(wide.isel(F_x=0).drop_vars("F_x"), "F_x").axes
    assert "F_y" in axes.get_xlabel() and "F_z" in axes.get_legend().get_title().get_text()
    figure = signal_curves(wide.isel(F_x=0, F_z=1), "F_z")
    assert "F_y" in figure.axes[0].get_xlabel() and figure.axes[0].get_legend() is None
    assert "$F_x$ = -1 N, $F_z$ = 1 N" in figure.get_suptitle()
    single = wide.isel(F_x=0, F_z=0, F_y=0)
    for draw in (crosstalk_map, lambda one: signal_curves(one, "F_z")):
        with pytest.raises(SceneError, match="needs? a table over"):
            draw(single)


@pytest.fixture
def triple() -> xr.Dataset:
    """Four coils over three forces."""
    nodes = {"F_x": [-1.0, 0.0, 1.0], "F_z": [0.0, 2.0], "F_y": [-1.0, 0.0, 1.0]}
    found = xr.Dataset(coords=nodes | {"coil": list("ABCD")})
    x, z, y = xr.broadcast(found.F_x, found.F_z, found.F_y)
    shown = {"dL_v": -z + 0.5 * x**2, "dL_x": 2.0 * x + 0.5 * x * z, "dL_y": 3.0 * y + 0.01 * x}
    return found.assign(shown | {f"error_{name}": 0.02 + 0.0 * x for name in shown})


def test_three_forces_have_three_curves_and_a_matrix(triple: xr.Dataset) -> None:
    """Each signal against its own force; shares of full scale that exceed their errors, full scales between them."""
    pictures = calibration_pictures(triple)
    assert list(pictures) == ["dL_v", "dL_x", "dL_y", "crosstalk"]
    figure = pictures["dL_y"]()
    (axes,) = figure.axes
    np.testing.assert_allclose(axes.containers[0].lines[0].get_ydata(), [-3.0, 0.0, 3.0])
    assert "F_y" in axes.get_xlabel() and "$F_x$ = 0 N" in figure.get_suptitle() and "Delta L_y" in axes.get_ylabel()
    texts = [text.get_text() for text in pictures["crosstalk"]().axes[0].texts]
    assert len(texts) == 9 and sum(text.startswith("full scale") for text in texts) == 3
    assert any(text.startswith("25 %") for text in texts)  # 0.5 of 2 by F_x into dL_v, 1 of 4 by F_z into dL_x
    assert any("below its\nerror" in text for text in texts)


def test_a_layer_without_its_state_is_not_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """A pad solved whole that keeps no state has no section to show: one line that names the other picture."""
    report = SolveReport("by hand", 1, 1, 0.0, 0.0, 0.0)
    found = Equilibrium(Wrench(0.1, F_y=0.2), Pose(0.0, 2e-3), Pose(0.0, 0.0), np.zeros(0), report)
    monkeypatch.setattr(BlockPad, "equilibrium", lambda *_, **__: found)
    with pytest.raises(SceneError, match="needs a load in the plane y = 0 .*; got F_y too: ask for --kind spatial"):
        load_view(load_sensor("biorob2018"), found.wrench)


def test_a_layer_is_drawn_by_the_model_that_solved_it() -> None:
    """A coaxial disc over F_z alone, by its half meridian."""
    pad = 'elastomer={material="ecoflex-00-30", diameter="14 mm", thickness="2 mm"}'
    disc = 'target={material="copper", shape="disc", diameter="8 mm", thickness="0.2 mm"}'
    sensor = load_sensor("biorob2018", [pad, disc])
    title = load_view(sensor, Wrench(F_z=0.5), 0.1, "axisymmetric").axes[0].get_title()
    assert title == "layer by axisymmetric, $F_x$ = 0 N, $F_z$ = 0.5 N"


def test_a_section_draws_the_coils_that_it_cuts() -> None:
    """Four coils beside y = 0: none of them there, and named; two of them on the diagonal."""
    pair = load_sensor("biorob2018")
    places = [(-4e-3, -4e-3), (4e-3, -4e-3), (4e-3, 4e-3), (-4e-3, 4e-3)]
    coils = [pair.coils[0].model_copy(update={"name": f"C{k}", "centre": xy}) for k, xy in enumerate(places, 1)]
    sensor = pair.model_copy(update={"coils": tuple(coils)})
    report = SolveReport("by hand", 1, 1, 0.0, 0.0, 0.0)
    for shear, cut, missed in (((0.5, 0.0), 0, "y = 0; not cut: C1, C2, C3, C4"), ((0.5, 0.5), 2, "45° from x")):
        wrench = Wrench(shear[0], 1.0, F_y=shear[1])
        found = Equilibrium(wrench, Pose(1e-4, 1.9e-3), Pose(0.0, 0.0), np.zeros(1), report)
        axes = layer_view(sensor, found, angle=load_angle(wrench)).axes[0]
        tracks = [drawn for drawn in axes.collections[:-1] if len(drawn.get_paths())]
        assert len(tracks) == cut and missed in axes.texts[0].get_text()


@pytest.mark.parametrize(("load", "degrees"), [
    ({"F_x": -1.0}, 0), ({"F_y": -1.0}, 90), ({"F_x": 1.0, "F_y": -1.0}, -45), ({"M": 1.0}, 0), ({"M_x": 1.0}, 90),
    ({}, 0),
])
def test_where_a_load_is_cut(load: dict[str, float], degrees: float) -> None:
    """Along the shear; across the moment without one."""
    assert np.degrees(load_angle(Wrench(**({"F_x": 0.0} | load)))) == pytest.approx(degrees)


def test_layer_view_and_files(tmp_path: Path, collisions: Collisions) -> None:
    """Layer, two coils and target are drawn; the file is whole or not there."""
    sensor = load_sensor("biorob2018")
    report = SolveReport("by hand", 1, 1, 0.0, 0.0, 0.0)
    found = Equilibrium(Wrench(0.5, 2.0), Pose(1e-4, 1.9e-3, 0.01), Pose(0.0, 0.0), np.zeros(1), report)
    points = np.array([[-1e-2, 0.0], [1e-2, 0.0], [1e-2, 1.9e-3], [-1e-2, 1.9e-3]])
    rest = np.where(points == 1.9e-3, 2e-3, points)
    mesh = DeformedSection(points, np.array([[0, 1, 2, 3]]), np.array([0.5]), np.array([1.2]), rest)
    figure = layer_view(sensor, found, mesh)
    assert len(figure.axes[0].collections) == 5 and figure.axes[0].get_aspect() == 1.0
    assert figure.axes[1].get_xlabel() == "displacement [mm], at most 0.1" and collisions(figure) == []
    stretched = layer_view(sensor, found, mesh, show="stretch")
    assert stretched.axes[1].get_xlabel() == "largest principal stretch, or its reciprocal [-], at most 1.2"
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert legend == ["track, current along $+y$", "track, current along $-y$", "target"]
    ticks = [text.get_window_extent() for text in figure.axes[1].get_xticklabels() if text.get_text()]
    assert all(a.x1 < b.x0 for a, b in pairwise(sorted(ticks, key=lambda box: box.x0)))
    save_figure(figure, tmp_path / "layer.png")
    assert os.listdir(tmp_path) == ["layer.png"] and (tmp_path / "layer.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(SceneError, match="must be writable"):
        save_figure(figure, tmp_path / "nowhere" / "layer.png")


@pytest.mark.parametrize(("J", "said"), [(0.95, ""), (0.85, "smallest volume ratio, away from bonded edges, 0.850")])
def test_a_layer_that_shrinks_is_said_to(J: float, said: str) -> None:
    """Below 0.9, in the middle; not of the cells at the bonded edges, where the mesh decides."""
    sensor = load_sensor("biorob2018")
    report = SolveReport("by hand", 1, 1, 0.0, 0.0, 0.0)
    found = Equilibrium(Wrench(0.0, 2.0), Pose(0.0, 2e-3), Pose(0.0, 0.0), np.zeros(1), report)
    x = np.array([-10e-3, -5e-3, -4e-3, -3e-3, 3e-3, 4e-3, 5e-3, 10e-3])  # the target ends at 4 mm
    points = np.stack(np.meshgrid(x, [0.0, 2e-3]), -1).reshape(-1, 2)
    quads = np.array([[k, k + 1, k + 9, k + 8] for k in range(7)])
    mesh = DeformedSection(points, quads, np.array([0.1, 0.2, 0.3, J, 0.3, 0.2, 0.1]), np.ones(7), points)
    assert layer_view(sensor, found, mesh).axes[1].get_xlabel().partition("\n")[2] == said


@pytest.mark.slow
@pytest.mark.parametrize("table", ["data", pytest.param("triple", marks=pytest.mark.slow)])
def test_a_calibration_is_ready_for_print(
    table: str, collisions: Collisions, request: pytest.FixtureRequest
) -> None:
    """Units on every axis of numbers, a legend entry for every curve, bars explained, no text over another."""
    data = request.getfixturevalue(table).assign_attrs(name="A sensor whose name is as long as names of sensors are")
    for name, draw in calibration_pictures(data).items():
        figure = draw()
        assert collisions(figure) == [], name
        assert figure.get_figwidth() == pytest.approx(88.0 / 25.4)
        if name == "crosstalk":
            continue
        (axes,) = figure.axes
        assert all("[" in label for label in (axes.get_xlabel(), axes.get_ylabel()))
        assert len(axes.get_legend().get_texts()) == len(axes.containers) > 1
        assert "errors up to" in figure.get_suptitle() and data.attrs["name"] in figure.get_suptitle()
    maps = crosstalk_map(request.getfixturevalue("data"))
    assert all("[N]" in axes.get_xlabel() for axes in maps.axes[:2])
    assert all("[%]" in axes.get_xlabel() for axes in maps.axes[2:]) and "equal values" in maps.get_suptitle()


def test_curves_are_apart_in_grey() -> None:
    """No two of nine share marker and dashes; their greys rise from the first to the last."""
    nine = strokes(9)
    assert len({(one["marker"], one["linestyle"]) for one in nine}) == 9
    grey = [float(np.dot(one["color"][:3], [0.2126, 0.7152, 0.0722])) for one in nine]
    assert all(a < b for a, b in pairwise(grey))


@pytest.mark.slow
def test_vector_files(data: xr.Dataset, tmp_path: Path) -> None:
    """Text is text, axes are vectors, and the same picture is the same file."""
    for form in ("svg", "pdf"):
        for name in ("one", "two"):
            save_figure(crosstalk_map(data), tmp_path / f"{name}.{form}")
        assert (tmp_path / f"one.{form}").read_bytes() == (tmp_path / f"two.{form}").read_bytes()
    root = ElementTree.parse(tmp_path / "one.svg").getroot()
    words, paths = (list(root.iter(f"{{http://www.w3.org/2000/svg}}{tag}")) for tag in ("text", "path"))
    assert any("lines: equal values" in "".join(each.itertext()) for each in words) and len(paths) > 9
    whole = (tmp_path / "one.pdf").read_bytes()
    assert b"/FontFile2" in whole and b"CreationDate" not in whole


def test_numbers_stand_beside_their_own_marks() -> None:
    """Inside the axes, over no other mark where there is room; those of one place share a label."""
    places = np.array([[0.5, 0.1], [0.52, 0.1], [0.65, 0.2], [0.98, 0.98]])
    found = numbered_labels(places, np.vstack([places, [[0.62, 0.22]]]))
    assert [numbers for numbers, _ in found] == [[1, 2], [3], [4]]
    assert [side.tolist() for _, side in found] == [[-1, 1], [1, 1], [-1, -1]]
    crowd = 0.5 + 0.041 * np.stack(np.meshgrid(np.arange(6), np.arange(6)), axis=-1).reshape(-1, 2)
    labels = numbered_labels(crowd, crowd)
    assert len(labels) < 36 and sorted(sum((numbers for numbers, _ in labels), [])) == list(range(1, 37))


def test_the_style_is_a_file_for_matplotlib() -> None:
    """`style.use` takes it; what is drawn has it; it is gone afterwards."""
    import matplotlib.style

    before = matplotlib.rcParams["font.size"]
    with matplotlib.style.context(STYLE):
        assert matplotlib.rcParams["font.size"] == 8.0
    with new_figure() as (_, (axes,)):
        assert axes.plot([0.0, 1.0])[0].get_color() == "#0072B2"
    assert matplotlib.rcParams["font.size"] == before


def test_loops_show_each_cycle(collisions: Collisions) -> None:
    """Each from the least share to the next, with arrows along the first and the last."""
    share = np.concatenate([np.linspace(0.0, 1.0, 50, endpoint=False), np.linspace(1.0, 0.0, 50, endpoint=False)] * 3)
    peak = dict.fromkeys(("F_x", "M", "F_y", "M_x", "M_z"), 0.0) | {"F_z": 4.0}
    lag = np.roll(share, 5)
    data = xr.Dataset({"share": ("time", share), "L_v_percent": ("time", -lag), "L_h_percent": ("time", lag**2)})
    data = data.assign_coords(coil=["C1", "C2"]).assign_attrs(name="Pad", request=json.dumps({"peak": peak}))
    figure = loop_curves(data)
    for axes in figure.axes:
        assert [line.get_label() for line in axes.lines] == ["cycle 1", "cycle 2", "cycle 3"]
        assert all(max(line.get_xdata()) == pytest.approx(4.0) for line in axes.lines) and len(axes.texts) == 4
        assert "F_z" in axes.get_xlabel() and "[N]" in axes.get_xlabel() and "[% of $L_0$]" in axes.get_ylabel()
    assert len(figure.legends[0].get_texts()) == 3 and collisions(figure) == []
