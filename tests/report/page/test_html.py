"""The report: one file that needs nothing else, for any forces and coils; what stands in its sections."""

import re
from pathlib import Path

import pytest
import xarray as xr

from sits_mech.analysis.readings.bench import readings
from sits_mech.cli.main import run
from sits_mech.report.folder import read_calibration
from sits_mech.report.page import parts
from sits_mech.report.page.html import page
from sits_mech.report.page.parts import inverse_part, loads_part, words_part
from sits_mech.scene.sensor import Sensor, changed


@pytest.fixture(scope="module")
def made(calibrated: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report as the command makes it."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    assert run(["report", str(calibrated), "-o", str(path)]) == 0
    return path


@pytest.mark.slow
def test_forces_back(calibrated: Path) -> None:
    """Error of the map, share with an answer, noise in newtons; a sentence where forces are not resolved."""
    sensor, data = read_calibration(calibrated)
    text = inverse_part(sensor, data, readings(sensor, data))
    for word in ("F_x, F_z", "100 % of the calibrated range", "noise (1 sigma)", "mN", "best linear sum"):
        assert word in text
    alike = data.copy(deep=True)  # both coils show the same: one of two forces is lost
    alike["L"][{"coil": 1, "coil_2": 1}] = alike["L"][{"coil": 0, "coil_2": 0}]
    text = inverse_part(sensor, alike, readings(sensor, alike))
    assert "<td>F_x</td>" in text and "F_z: errors of map and table" in text and "best linear sum" in text
    few = data.isel(F_x=[0, 1], F_z=[0])
    assert "must" in inverse_part(sensor, few, readings(sensor, few))


def test_one_file_of_a_size_to_send(made: Path) -> None:
    """Below 5 MB, with its pictures; no address of another file."""
    whole = made.read_text()
    assert made.stat().st_size < 5e6 and whole.count("data:image/png;base64,") == 4
    for tag in re.findall(r"<(?:script|link|img|iframe)[^>]*>", whole):
        for address in re.findall(r'(?:src|href)="([^"]*)"', tag):
            assert address.startswith("data:")
    assert "http" not in re.sub(r"http://www\.w3\.org/2000/svg", "", whole) and "$" not in whole


def test_every_load_and_figure_has_its_error(made: Path, calibrated: Path) -> None:
    """Twenty loads with five errors each, less eight zeros by symmetry; figures, settings and scene are there."""
    whole = made.read_text()
    loads = whole[whole.index('<section id="loads">') : whole.index('<section id="scene">')]
    assert loads.count("±") == 5 * 20 - 8 and loads.count("<tr") == 21
    for word in ("crosstalk of F_x into L_v", "RCOUNT0", "ecoflex-00-30", "relative error of a pose", "Status: "):
        assert word in whole


def test_warnings_are_in_plain_words(calibrated: Path) -> None:
    """A capacitance that the converter cannot follow, strong crosstalk, a target shorter than its pad."""
    sensor, data = read_calibration(calibrated)
    slow = changed(sensor, ["readout.parallel_capacitance=1e-9", "readout.lead_resistance=10"])
    words = words_part(slow, data, readings(slow, data))
    for word in (
        "too lossy", "per metre of depth", "Left out: ends of pad and target along y: ", "the target covers 8 mm",
        "Left out: ends along y: ", "Status: 20 of 20 above tolerance",
    ):
        assert word in words
    unsure = [name for name in data.data_vars if str(name).startswith(("error_", "shared_"))]
    exact = data.assign({name: 0.0 * data[name] for name in unsure})
    assert "read all forces from all signals" in words_part(sensor, exact, readings(sensor, exact))
    assert "too lossy" not in words_part(sensor, data, readings(sensor, data))


@pytest.mark.slow
def test_any_loads_have_every_section(three_forces: Path, triaxial: tuple[Sensor, xr.Dataset], tmp_path: Path) -> None:
    """Under a moment that is the same throughout, and of four coils: explorer, readout, forces back."""
    text = page(*read_calibration(three_forces), three_forces)
    assert 'id="explorer"' in text and "under M = 0.001 N m" in text and "2 coils cannot resolve F_x, F_z, F_y" in text
    text = page(*triaxial, tmp_path)
    for words in ("F_x, F_z, F_y", "code of C4", "full scale of dL_y", "RCOUNT3", "of F_z into dL_x", "60 loads",
                  'id="limits"', "unknown: the silicone has neither", "sources differ by a factor"):
        assert words in text, words
    assert "$" not in text


def test_a_table_too_long_for_a_page(triaxial: tuple[Sensor, xr.Dataset], monkeypatch: pytest.MonkeyPatch) -> None:
    """The loads at the middle of what runs last, and a word that says so."""
    monkeypatch.setattr(parts, "_MOST", 20)
    text = loads_part(triaxial[1])
    assert "Loads with F_y = 0 N of 60; result.csv has all." in text and text.count("<tr>") == 21


def test_without_converter_or_pictures(calibrated: Path, tmp_path: Path) -> None:
    """The page still stands, without codes."""
    sensor, data = read_calibration(calibrated)
    whole = page(changed(sensor, ['readout.converter="none"']), data, tmp_path)
    assert "The scene has no converter." in whole and "The folder has no pictures" in whole and "code of" not in whole


def test_coils_that_no_converter_follows(calibrated: Path, tmp_path: Path) -> None:
    """Tracks whose losses cannot be told at the frequency: the page stands and says why it has no codes."""
    sensor, data = read_calibration(calibrated)
    reason = "tracks: none of the kind"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sits_mech.analysis.readings.bench.at_terminals", lambda *_: (None, (reason,)))
        whole = page(sensor, data, tmp_path)
    assert reason in whole and "code of" not in whole


def test_what_cannot_be_reported(calibrated: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No calibration, another ending, a folder that is not there: one line each."""
    for words, message in (
        ([str(tmp_path)], "must be the folder of a finished calibration"),
        ([str(calibrated), "-o", "report.pdf"], "--output: must end in .html; got 'report.pdf'"),
        ([str(calibrated), "-o", str(tmp_path / "no" / "r.html")], "must be writable; got: No such file"),
    ):
        assert run(["report", *words]) == 2
        error = capsys.readouterr().err
        assert message in error and error.count("\n") == 1
