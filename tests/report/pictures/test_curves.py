"""Pictures: what they show stands where the numbers say; axes have units; files appear whole."""

import os
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.mechanics.block import BlockPad
from sits_mech.quantities import Equilibrium, Pose, SolveReport, Wrench
from sits_mech.report.pictures.curves import calibration_pictures, crosstalk_map, save_figure, signal_curves
from sits_mech.report.pictures.section import layer_view, load_angle, load_view
from sits_mech.scene.sensor import SceneError, load_sensor


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
    assert "[N]" in axes.get_xlabel() and "[%]" in axes.get_ylabel()


def test_shear_curves_show_the_numbers(data: xr.Dataset) -> None:
    """One curve per normal force."""
    (axes,) = signal_curves(data, "F_x").axes
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["0", "1", "2"]
    np.testing.assert_allclose(axes.containers[2].lines[0].get_ydata(), [-5.0, 0.0, 5.0])


def test_crosstalk_map_shows_both_ways(data: xr.Dataset) -> None:
    """2 of 6 for F_z into L_h, -1 of 2 for F_x into L_v; symmetric colour scales with units."""
    figure = crosstalk_map(data)
    maps = [axes.collections[0] for axes in figure.axes[:2]]
    assert [float(np.max(np.abs(picture.get_array()))) for picture in maps] == pytest.approx([100.0 / 3.0, 50.0])
    assert all(picture.get_clim()[0] == -picture.get_clim()[1] for picture in maps)


def test_other_forces_are_at_the_middle(data: xr.Dataset) -> None:
    """A slice, with a title that says where; without the usual forces those that there are."""
    wide = data.expand_dims({"F_y": [-1.0, 0.5, 1.0]}, axis=2).assign_coords(M=2e-3)
    wide = wide.assign(L_v_percent=wide["L_v_percent"] + wide["F_y"])
    (axes,) = signal_curves(wide, "F_z").axes
    np.testing.assert_allclose(axes.containers[1].lines[0].get_ydata(), [189.5, 188.5, 187.5])
    assert axes.get_title() == "M = 0.002 N m, F_y = 0.5 N"
    (axes,) = signal_curves(wide.isel(F_x=0).drop_vars("F_x"), "F_x").axes
    assert "F_y" in axes.get_xlabel() and "F_z" in axes.get_legend().get_title().get_text()
    (axes,) = signal_curves(wide.isel(F_x=0, F_z=1), "F_z").axes
    assert "F_y" in axes.get_xlabel() and axes.get_legend() is None and "F_x = -1 N, F_z = 1 N" in axes.get_title()
    single = wide.isel(F_x=0, F_z=0, F_y=0)
    for draw in (crosstalk_map, lambda one: signal_curves(one, "F_z")):
        with pytest.raises(SceneError, match="needs? a table over"):
            draw(single)


def test_three_forces_have_three_curves_and_a_matrix() -> None:
    """Each signal against its own force; shares of full scale that exceed their errors, full scales between them."""
    nodes = {"F_x": [-1.0, 0.0, 1.0], "F_z": [0.0, 2.0], "F_y": [-1.0, 0.0, 1.0]}
    found = xr.Dataset(coords=nodes | {"coil": list("ABCD")})
    x, z, y = xr.broadcast(found.F_x, found.F_z, found.F_y)
    shown = {"dL_v": -z + 0.5 * x**2, "dL_x": 2.0 * x + 0.5 * x * z, "dL_y": 3.0 * y + 0.01 * x}
    data = found.assign(shown | {f"error_{name}": 0.02 + 0.0 * x for name in shown})
    pictures = calibration_pictures(data)
    assert list(pictures) == ["dL_v", "dL_x", "dL_y", "crosstalk"]
    (axes,) = pictures["dL_y"]().axes
    np.testing.assert_allclose(axes.containers[0].lines[0].get_ydata(), [-3.0, 0.0, 3.0])
    assert "F_y" in axes.get_xlabel() and axes.get_title() == "F_x = 0 N" and "Delta L_y" in axes.get_ylabel()
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


def test_a_section_draws_the_coils_that_it_cuts() -> None:
    """Four coils beside y = 0: none of them there, and named; two of them on the diagonal."""
    pair = load_sensor("biorob2018")
    places = [(-4e-3, -4e-3), (4e-3, -4e-3), (4e-3, 4e-3), (-4e-3, 4e-3)]
    coils = [pair.coils[0].model_copy(update={"name": f"C{k}", "centre": xy}) for k, xy in enumerate(places, 1)]
    sensor = pair.model_copy(update={"coils": tuple(coils)})
    report = SolveReport("by hand", 1, 1, 0.0, 0.0, 0.0)
    for shear, cut, missed in (((0.5, 0.0), 0, "y = 0; beside it: C1, C2, C3, C4"), ((0.5, 0.5), 2, "45° from x")):
        wrench = Wrench(shear[0], 1.0, F_y=shear[1])
        found = Equilibrium(wrench, Pose(1e-4, 1.9e-3), Pose(0.0, 0.0), np.zeros(1), report)
        axes = layer_view(sensor, found, angle=load_angle(wrench)).axes[0]
        tracks = [drawn for drawn in axes.collections[:-1] if len(drawn.get_paths())]
        assert len(tracks) == cut and missed in axes.texts[0].get_text()


@pytest.mark.parametrize(("load", "degrees"), [
    ({"F_x": -1.0}, 0), ({"F_y": -1.0}, 90), ({"F_x": 1.0, "F_y": -1.0}, -45), ({"M": 1.0}, 0), ({"M_x": 1.0}, 90),
    ({}, 0),
])  # fmt: skip
def test_where_a_load_is_cut(load: dict[str, float], degrees: float) -> None:
    """Along the shear; across the moment without one."""
    assert np.degrees(load_angle(Wrench(**({"F_x": 0.0} | load)))) == pytest.approx(degrees)


def test_layer_view_and_files(tmp_path: Path) -> None:
    """Layer, two coils and target are drawn; the file is whole or not there."""
    sensor = load_sensor("biorob2018")
    report = SolveReport("by hand", 1, 1, 0.0, 0.0, 0.0)
    found = Equilibrium(Wrench(0.5, 2.0), Pose(1e-4, 1.9e-3, 0.01), Pose(0.0, 0.0), np.zeros(1), report)
    points = np.array([[-1e-2, 0.0], [1e-2, 0.0], [1e-2, 1.9e-3], [-1e-2, 1.9e-3]])
    figure = layer_view(sensor, found, (points, np.array([[0, 1, 2, 3]]), np.array([0.99])))
    assert len(figure.axes[0].collections) == 4 and figure.axes[0].get_aspect() == 1.0
    assert "smallest here 0.9900" in figure.axes[1].get_xlabel()
    ticks = [text.get_window_extent() for text in figure.axes[1].get_xticklabels() if text.get_text()]
    assert all(a.x1 < b.x0 for a, b in pairwise(sorted(ticks, key=lambda box: box.x0)))
    save_figure(figure, tmp_path / "layer.png")
    assert os.listdir(tmp_path) == ["layer.png"] and (tmp_path / "layer.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(SceneError, match="must be writable"):
        save_figure(figure, tmp_path / "nowhere" / "layer.png")
