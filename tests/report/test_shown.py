"""What a notebook shows: the numbers of a scene or a table, in a frame or a file that needs nothing else."""

import html
import re
import sys
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from sits_mech.chain.calibrate import calibrate
from sits_mech.report.page.parts import figures_part
from sits_mech.report.shown import Shown, show
from sits_mech.scene.sensor import SceneError, changed, load_sensor
from sits_mech.store import save_table

PAIR = load_sensor("biorob2018")
KINDS = {"svg": b"<?xml", "png": b"\x89PNG"}


@pytest.fixture(scope="module")
def data() -> xr.Dataset:
    """Four loads by models that cost little."""
    models: dict[str, Any] = {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}
    return calibrate(PAIR, F_x=[-0.2, 0.2], F_z=[0.0, 1.0], **models)


def framed(what: Shown) -> str:
    """Return the page within the frame that a notebook gets."""
    text = what._repr_html_()
    assert text.startswith("<iframe ") and text.count("<") == 2
    return html.unescape(text.partition('srcdoc="')[2].rpartition('" style=')[0])


@pytest.mark.parametrize("what", [PAIR, "biorob2018"])
def test_a_sensor_with_its_sizes(what: Any, tmp_path: Path) -> None:
    """Sizes stand in the drawing and the tables; the file is what the frame holds."""
    text = framed(show(what))
    for words in ("target 8", "section A, y = 0", "5 MHz · 2 coils · target of copper", "LDC1614", "<svg"):
        assert words in text
    assert "implausible" not in text and "$" not in text and repr(show(what)) == f"<sensor: {PAIR.name}>"
    show(what).save(tmp_path / "sensor.html")
    assert (tmp_path / "sensor.html").read_text(encoding="utf-8") == text


def test_what_is_implausible_is_said() -> None:
    """In a name as well as in a note, what is HTML's is text."""
    text = framed(show(changed(PAIR, ["elastomer.thickness=0.5", 'name="<i>a & b</i>"'])))
    assert "<li>implausible: elastomer.thickness = 0.5 m" in text
    assert "<h2>&lt;i&gt;a &amp; b&lt;/i&gt;</h2>" in text and "<i>" not in text


def test_a_calibration_with_its_figures(data: xr.Dataset, tmp_path: Path) -> None:
    """The explorer and the figures of the report; of a table that was written and read back the same."""
    text = framed(show(data))
    for words in ("Calibration over 4 loads", 'id="s-F_x"', 'id="stage"', 'id="plan"', 'id="map"', figures_part(data)):
        assert words in text
    assert re.findall(r'(?:src|href)="(?!data:)', text) == []
    assert "http" not in text.replace("http://www.w3.org/2000/svg", "")
    save_table(data, tmp_path / "result.nc")
    with xr.open_dataset(tmp_path / "result.nc", engine="netcdf4") as read:
        assert framed(show(read)) == text


def test_a_table_that_does_not_name_its_scene(data: xr.Dataset) -> None:
    """Takes the sensor that is given; one that is not its own is refused."""
    bare = data.assign_attrs()
    del bare.attrs["scene"]
    assert show(bare, PAIR).page() == show(data).page() == show(data, PAIR).page()
    with pytest.raises(SceneError, match="sensor: must be given for a table without"):
        show(bare)
    with pytest.raises(SceneError, match='sensor: must be that of the table, with coils C1, C2; got "Square coil'):
        show(bare, load_sensor("square-4"))
    with pytest.raises(SceneError, match="sensor: must be that of the table"):
        show(data, changed(PAIR, ["elastomer.thickness=1e-3"]))


def test_what_cannot_be_shown(data: xr.Dataset) -> None:
    """Another thing, scene, kind of table, version: one line, with what came."""
    failed = data.copy(deep=True)
    failed["status"][:] = "failed"
    for what, message in (
        (3, "what: must be a sensor, a scene's name or path, or a table of calibrate; got int"),
        (data["L"], "got DataArray"),
        ("nowhere", "nowhere: no such file"),
        (xr.Dataset({"a": ("x", [1.0])}), "what: must be the table of a calibration; status is missing"),
        (data.drop_vars("R"), "R is missing"),
        (data.assign(R=data["R"].astype(str)), "must hold numbers in R; got words"),
        (data.assign_attrs({}).drop_attrs(), "request is missing"),
        (data.rename(F_x="width"), "over components of a load; got ('width', 'F_z')"),
        (data.isel(F_x=0, F_z=0), "over components of a load; got ()"),
        (data.assign_attrs(version="0.0.9"), "must be a calibration by version"),
        (failed, "must hold at least one load that converged"),
    ):
        with pytest.raises(SceneError, match=re.escape(message)) as caught:
            show(what)  # type: ignore[arg-type]
        assert "\n" not in str(caught.value)
    with pytest.raises(SceneError, match="sensor: must be left out where no table is shown"):
        show("biorob2018", PAIR)


def test_pictures_as_files(data: xr.Dataset, tmp_path: Path) -> None:
    """Each that is named can be had in both formats; none is named that the table has no loads for."""
    line, what = show(data.isel(F_x=[0])), show(PAIR)
    assert line.pictures() == ("drawing", "L_v") and line.picture("L_v").startswith(KINDS["svg"])
    assert what.pictures() == ("drawing",) == show(data.isel(F_x=[0], F_z=[1])).pictures()
    assert show(data).picture("L_h", "png").startswith(KINDS["png"]) and b"target 8" in what.picture("drawing")
    for name, form, message in (
        ("layer", "svg", 'name: must be one of drawing, L_v, L_h, crosstalk; got "layer"'),
        ("L_v", "pdf", 'format: must be one of svg, png; got "pdf"'),
    ):
        with pytest.raises(SceneError, match=message):
            show(data).picture(name, form)
    with pytest.raises(SceneError, match="path: must end in .html; got"):
        show(PAIR).save(tmp_path / "sensor.svg")


def test_without_matplotlib(monkeypatch: pytest.MonkeyPatch) -> None:
    """The numbers stand, and a line that says what is missing."""
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    text = framed(show(PAIR))
    assert "pictures need matplotlib" in text and "LDC1614" in text and "<svg" not in text


@pytest.mark.slow
def test_in_a_browser(data: xr.Dataset, browser: Any, tmp_path: Path) -> None:
    """In a notebook's frames, as high as what they show, and from a disk: sliders work, nothing complains."""
    book = tmp_path / "book.html"
    head = '<meta charset="utf-8"><meta name="viewport" content="width=device-width"><link rel="icon" href="data:,">'
    cells = "".join(show(what)._repr_html_() for what in (PAIR, data))
    book.write_text(f"<!DOCTYPE html>{head}{cells}", encoding="utf-8")
    show(data).save(tmp_path / "calibration.html")
    for width in (1280, 390):
        browser.width(width)
        browser.open(book)
        inner = "n.contentDocument.documentElement"
        for high, all_of_it, wide, room in browser.every(
            "iframe", f"[n.clientHeight, n.contentDocument.body.scrollHeight, {inner}.scrollWidth, n.clientWidth]"
        ):
            assert all_of_it <= high <= all_of_it + 24 and wide <= room <= width and high > 400
        assert browser.complaints() == []
    browser.open(tmp_path / "calibration.html")
    browser.slide(F_x=-0.2, F_z=1.0)
    expected = float(data["L_h_percent"].sel(F_x=-0.2, F_z=1.0))
    assert browser.shown("L_h_percent") == pytest.approx(expected, abs=6e-4) and browser.complaints() == []
