"""Views in space: what is drawn is coloured as said; a first render that fails ends in one line with the packages."""

from functools import partial

import numpy as np
import pytest

from sits_mech.geometry.collision import as_plate
from sits_mech.quantities import Pose, Wrench
from sits_mech.report.pictures import spatial
from sits_mech.report.pictures.request import PictureSettings, driven_coil, kind_of_picture, resting_pose
from sits_mech.report.pictures.section import written_frequency
from sits_mech.report.pictures.stream import plate_stream
from sits_mech.scene.sensor import Conductor, SceneError, load_sensor


@pytest.fixture
def untried() -> object:
    """No render was tried yet."""
    spatial.renders.cache_clear()
    yield
    spatial.renders.cache_clear()


@pytest.mark.slow
def test_spatial_view(monkeypatch: pytest.MonkeyPatch) -> None:
    """Red winding, copper plate and grey winding are in the pixels; the scale has a unit."""
    try:
        spatial.renders()
    except SceneError as error:
        pytest.skip(str(error))
    monkeypatch.setattr(spatial, "_SIZE", (600, 400))
    monkeypatch.setattr(spatial, "plate_stream", partial(plate_stream, cells=12))
    figure = spatial.spatial_view(load_sensor("biorob2018"), Pose(1e-3, 2e-3, 0.1), 5e3, driven="C1")
    picture = np.asarray(figure.axes[0].images[0].get_array()).astype(int)
    red, green, blue = picture[..., 0], picture[..., 1], picture[..., 2]
    assert np.sum((red > 2 * green) & (red > 2 * blue) & (red > 90)) > 500
    assert np.sum((red > green + 25) & (green > blue + 25)) > 5000
    assert np.sum((blue > red + 15) & (blue < 160) & (np.abs(green - red) < 40)) > 500
    assert "[A/m]" in figure.axes[1].get_xlabel() and "5 kHz" in figure.axes[0].get_title()


def test_without_pyvista(untried: object, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spatial, "find_spec", lambda name: None)
    with pytest.raises(SceneError, match=r"pip install '\.\[view\]'"):
        spatial.renders()


@pytest.mark.parametrize("probe", ["import os\nos.kill(os.getpid(), 11)", "raise OSError('libGL.so.1')"])
def test_without_opengl(untried: object, monkeypatch: pytest.MonkeyPatch, probe: str) -> None:
    """Whether the try ends by a signal or by an error."""
    monkeypatch.setattr(spatial, "_PROBE", probe)
    with pytest.raises(SceneError, match="apt-get install libglu1-mesa .* ended: ") as caught:
        spatial.renders()
    assert "\n" not in str(caught.value)


def test_which_picture() -> None:
    assert kind_of_picture(None, Wrench(), Pose(0.0, 2e-3)) == "field"
    assert kind_of_picture(None, Wrench(0.0, 1.0), None) == "layer" == kind_of_picture(None, Wrench(), None)
    assert kind_of_picture("spatial", Wrench(0.0, 1.0), None) == "spatial"
    sensor = load_sensor("biorob2018")
    assert resting_pose(sensor, PictureSettings(Wrench(), None, 5e6)).d_v == pytest.approx(2e-3, abs=1e-9)
    assert driven_coil(sensor, None) == "C2" and driven_coil(sensor, "C1") == "C1"


@pytest.mark.parametrize(("hertz", "text"), [(5e6, "5 MHz"), (5e3, "5 kHz"), (50.0, "50 Hz")])
def test_written_frequency(hertz: float, text: str) -> None:
    assert written_frequency(hertz) == text


def test_plates_keep_their_holes():
    """Surface of a square with a slot and a hole, 56 mm2 above and below and 48 mm of rims; tilted as a target, too."""
    pyvista = pytest.importorskip("pyvista")
    slot = ((2e-3, 4e-3), (2e-3, 0.0), (1e-3, 0.0), (1e-3, 4e-3))
    rim = ((-4e-3, -4e-3), (4e-3, -4e-3), (4e-3, 4e-3), *slot, (-4e-3, 4e-3))
    hole = ((-3e-3, -1e-3), (-1e-3, -1e-3), (-1e-3, 1e-3), (-3e-3, 1e-3))
    part = Conductor(name="GND", material="copper", shape="outline", centre=(1e-3, 0.0, -1e-3), points=rim,
                     holes=(hole,), thickness=0.5e-3)
    fixed = spatial._fixed(pyvista, part)
    assert fixed.area == pytest.approx(2 * 56 + 48 * 0.5, rel=1e-5)
    np.testing.assert_allclose(fixed.bounds, (-3.0, 5.0, -4.0, 4.0, -1.25, -0.75), atol=1e-5)
    tilted = spatial._plate(pyvista, as_plate(part), Pose(0.0, 5e-3, 0.4))
    assert tilted.area == pytest.approx(2 * 56 + 48 * 0.5, rel=1e-5)
