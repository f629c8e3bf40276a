"""Tables for other programs: the same numbers, with their units."""

import csv
import io
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import openpyxl
import pytest
from scipy.io import loadmat

from sits_mech.export.formats import export, format_of, formats, plain_name
from sits_mech.export.source import Source, interpolated_pose, resting_load
from sits_mech.labels import unit_of
from sits_mech.quantities import POSE, Pose, Wrench
from sits_mech.report.folder import read_calibration
from sits_mech.report.tables.loads import csv_text
from sits_mech.store import read_table


@pytest.fixture(scope="module")
def source(calibrated: Path) -> Source:
    """The small calibration."""
    return Source(*read_calibration(calibrated))


def test_csv_is_that_of_the_folder(source: Source, calibrated: Path, tmp_path: Path) -> None:
    """One table, one text."""
    path, notes = export(source, "csv", tmp_path / "t.csv")
    assert path.read_text() == (calibrated / "result.csv").read_text() and notes == ()


def test_netcdf_has_units(source: Source, tmp_path: Path) -> None:
    """The numbers to the last digit; the unit of each with it."""
    path, _ = export(source, "netcdf", tmp_path / "t.nc")
    data = read_table(path)
    np.testing.assert_array_equal(data["L"], source.data["L"])
    found = {name: data[name].attrs.get("units") for name in ("F_x", "d_h", "alpha", "L", "error_R", "L_v_percent")}
    assert found == {"F_x": "N", "d_h": "m", "alpha": "rad", "L": "H/m", "error_R": "ohm/m", "L_v_percent": "%"}
    np.testing.assert_array_equal(data["L_coil"].sel(coil="C1"), data["L"].sel(coil="C1", coil_2="C1"))
    assert data["L_coil"].attrs["units"] == "H/m" and "L_terminal" not in data
    assert "units" not in data["status"].attrs


def test_workbook_holds_numbers(source: Source, calibrated: Path, tmp_path: Path) -> None:
    """What is a number in the CSV is a number in the cell; the scene is text; headings name the units."""
    named = source.data.assign_attrs(scene_hash="12e34567")
    path, _ = export(replace(source, data=named), "xlsx", tmp_path / "t.xlsx")
    book = openpyxl.load_workbook(path)
    assert book.sheetnames == ["loads", "figures", "scene", "about"]
    names, *rows = csv.reader(io.StringIO(csv_text(source.data, units=False)))
    cells = list(book["loads"].values)
    assert list(cells[0]) == names and len(cells) == 2 + len(rows) == 2 + 20
    column = names.index("L[C1][C2]")
    assert cells[1][column] == "H/m"
    np.testing.assert_allclose([row[column] for row in cells[2:]], [float(row[column]) for row in rows], rtol=1e-15)
    assert cells[2][names.index("status")] == "above tolerance"
    assert all(cell.data_type != "f" for sheet in book for row in sheet for cell in row)
    assert dict(book["about"].values)["scene_hash"] == "12e34567"
    assert ("target.width" not in book["scene"]["A1"].value) and len(list(book["figures"].values)) > 5


@pytest.mark.parametrize(("name", "unit"), [
    ("L[C1][C2]", "H/m"), ("error_L_v", "H/m"), ("error_L_v_percent", "% of L0"), ("R[C1][C1]", "ohm/m"),
    ("error_d_v", "m"), ("error_alpha", "rad"), ("status", ""), ("reason", ""), ("seconds", "s"),
])
def test_units(name: str, unit: str) -> None:
    """By the name of a column."""
    assert unit_of(name, "H/m") == unit


@pytest.mark.slow
def test_tables_of_three_forces(three_forces: Path, tmp_path: Path) -> None:
    """Every component of the loads has its column and unit, in every format; a load's numbers stand in its own row."""
    source = Source(*read_calibration(three_forces))
    units = {"F_x": "N", "F_z": "N", "F_y": "N", "M": "N m", "d_y": "m", "alpha_x": "rad", "dL_v": "% of L0"}
    units |= {"error_dL_x": "% of L0", "dL_y": "% of L0", "L[C1][C2]": "H/m"}
    text, _ = export(source, "csv", tmp_path / "t.csv")
    headings, *rows = csv.reader(io.StringIO(text.read_text()))
    assert {f"{name} [{unit}]" for name, unit in units.items()} <= {*headings}
    names = [heading.partition(" [")[0] for heading in headings]
    y, z = names.index("F_y"), names.index("F_z")
    there = next(row for row in rows if (float(row[y]), float(row[z])) == (0.4, 2.0))
    picked = source.data.sel(F_x=float(there[names.index("F_x")]), F_z=2.0, F_y=0.4)
    for name in ("d_h", "d_y", "dL_v"):
        assert float(there[names.index(name)]) == float(picked[name])
    assert len(rows) == 60 and float(there[names.index("M")]) == 1e-3
    data = read_table(export(source, "netcdf", tmp_path / "t.nc")[0])
    book = openpyxl.load_workbook(export(source, "xlsx", tmp_path / "t.xlsx")[0])
    heading, below, first = list(book["loads"].values)[:3]
    for name, unit in units.items():
        assert below[heading.index(name)] == unit
        if "[" not in name:
            assert data[name].attrs["units"] == unit.removesuffix(" of L0")
    assert isinstance(first[heading.index("alpha_z")], float | int)


def test_pose_of_a_load_in_space(three_forces: Path) -> None:
    """All components of load and pose: on a load the table's own, between two their mean; others are the table's."""
    sensor, data = read_calibration(three_forces)
    there = data.sel(F_x=0.5, F_z=2.0, F_y=0.4)
    found = interpolated_pose(Source(sensor, data, Wrench(0.5, 2.0, F_y=0.4)))
    assert found == Pose(**{name: float(there[name]) for name in POSE})
    half = interpolated_pose(Source(sensor, data, Wrench(0.5, 2.0, M=1e-3, F_y=0.2)))
    assert half.d_y == pytest.approx(0.5 * float(found.d_y)) and half.d_v == pytest.approx(float(found.d_v))
    assert resting_load(Source(sensor, data, Wrench(0.5, 2.0))) == Wrench(0.5, 2.0, M=1e-3)
    for load, message in (
        (Wrench(F_y=0.5), "--fy: must lie within the calibration, from -0.4 N to 0.4 N; got 0.5 N"),
        (Wrench(M=2e-3), "--moment: must be 0.001 N m, as in the calibration; got 0.002 N m"),
        (Wrench(M_z=1e-3), "--mz: must be 0 N m, as in the calibration; got 0.001 N m"),
    ):
        with pytest.raises(ValueError, match=message):
            interpolated_pose(Source(sensor, data, load))


def test_pose_between_loads(source: Source) -> None:
    """On a load the table's own pose; halfway the mean; outside refused."""
    there = source.data.sel(F_x=0.5, F_z=2.0)
    for name in ("d_h", "d_v", "alpha"):
        assert getattr(interpolated_pose(Source(source.sensor, source.data, Wrench(0.5, 2.0))), name) == float(
            there[name]
        )
    between = interpolated_pose(Source(source.sensor, source.data, Wrench(0.5, 1.5)))
    both = source.data["d_v"].sel(F_x=0.5, F_z=[1.0, 2.0])
    assert between.d_v == pytest.approx(float(both.mean()), rel=1e-14)
    with pytest.raises(ValueError, match=r"--fz: must lie within the calibration, from 0 N to 3 N; got 4 N"):
        interpolated_pose(Source(source.sensor, source.data, Wrench(0.0, 4.0)))
    broken = source.data.copy(deep=True)
    broken["status"].loc[{"F_x": 0.5, "F_z": 2.0}] = "stalled"
    with pytest.raises(ValueError, match="load: must have results on all sides"):
        interpolated_pose(Source(source.sensor, broken, Wrench(0.5, 1.5)))


def test_what_cannot_be_written(source: Source, tmp_path: Path) -> None:
    """Unknown format, wrong ending, no such folder: one line each."""
    with pytest.raises(ValueError, match="--to: must be one of c, csv, kicad, .*; got 'dxf'"):
        export(source, "dxf", tmp_path / "t.dxf")
    with pytest.raises(ValueError, match=r"--output: must end in .kicad_mod for --to kicad; got 't.h', as for c"):
        export(source, "kicad", tmp_path / "t.h")
    for kind in ("csv", "netcdf", "xlsx", "kicad"):
        with pytest.raises(ValueError, match="--output: must be in a folder that exists"):
            export(source, kind, tmp_path / "nowhere" / f"t{format_of(kind).suffix}")
    assert plain_name("BioRob 2018: µ/2") == "BioRob_2018_2" and plain_name("..") == "sensor"


def test_a_format_of_another_package(source: Source, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The page's: found beside our own once it is installed; one that cannot be loaded says so."""
    page = (Path(__file__).parents[2] / "docs/howto/plugin.md").read_text(encoding="utf-8")
    code = re.findall(r"```python\n(.*?)```", page, re.S)[0]
    (tmp_path / "sits_mech_matlab.py").write_text(code, encoding="utf-8")
    about = tmp_path / "sits_mech_matlab-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: sits-mech-matlab\nVersion: 1.0\n")
    lines = ["[sits_mech.exports]", "matlab = sits_mech_matlab:MATLAB", "gone = sits_mech_matlab:GONE"]
    (about / "entry_points.txt").write_text("\n".join(lines))
    monkeypatch.syspath_prepend(str(tmp_path))
    formats.cache_clear()
    try:
        path, notes = export(source, "matlab", tmp_path / "s.mat")
        assert loadmat(path)["L"].shape == source.data["L"].shape and notes == ("load with: load('s.mat')",)
        with pytest.raises(ValueError, match="--output: must end in .nc for --to netcdf; got 's.mat', as for matlab"):
            export(source, "netcdf", tmp_path / "s.mat")
        with pytest.raises(ValueError, match="gone must be a format that can be loaded; got sits_mech_matlab:GONE"):
            export(source, "gone", tmp_path / "s.x")
    finally:
        formats.cache_clear()
