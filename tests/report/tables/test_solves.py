"""Numbers with their errors, to the digits that the error leaves."""

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from sits_mech.chain.simulate import simulate
from sits_mech.notes import Omission, OmissionKind, Relative
from sits_mech.quantities import Equilibrium, Pose, SolveReport, Wrench
from sits_mech.report.tables.drift import temperatures_table
from sits_mech.report.tables.solves import equilibrium_table, figure_text, point_name, short, sizes_of, with_error
from sits_mech.scene.sensor import load_sensor


@pytest.mark.parametrize(("value", "error", "expected"), [
    (12.3456, 0.21, "12.35 +- 0.21"), (12.3456, 3.4, "12.3 +- 3.4"), (1234.5, 56.0, "1234 +- 56"),
    (0.0, 0.0, "0"), (2000.0, 0.0, "2000 +- 0"), (math.nan, 0.1, "-"), (1.5, math.inf, "1.5 +- ?"),
    (-0.00123, 0.000045, "-0.001230 +- 0.000045"),
])
def test_digits_follow_the_error(value: float, error: float, expected: str) -> None:
    """Two digits of the error; neither invented nor lost."""
    assert with_error(value, error) == expected


@pytest.mark.parametrize(("value", "error", "expected"), [
    (-1.68895e-14, 0.0, "0"), (1e-14, 3e-15, "0"), (2.5, 1e-9, "2.5 +- 0"), (-1e-14, 0.01, "0.000 +- 0.010"),
    (1e-14, math.inf, "0 +- ?"), (2.5, 4e-6, "2.5000000 +- 0.0000040"),
])
def test_what_is_below_a_millionth_of_the_run_is_nothing(value: float, error: float, expected: str) -> None:
    """Of a run whose values of this kind are as large as 3; a millionth of that is 3e-6."""
    assert with_error(value, error, 3.0) == expected
    if abs(value) < 1e-6 and error < 1e-6:
        assert figure_text(value, 1.1 * abs(value), unit="N", size=3.0) == "0 N"


@pytest.mark.parametrize(("size", "expected"), [(math.nan, "2000 +- ? um"), (0.1, "2000.0 +- 1.0 um")])
def test_a_pose_of_which_something_is_not_known_has_no_bar(size: float, expected: str) -> None:
    left = Omission(OmissionKind.NO_TARGET, size, Relative.DISPLACEMENT)
    report = SolveReport("linear", 10, 1, 0.0, 1e-3, 0.1, left_out=(left,))
    found = Equilibrium(Wrench(0.0, 1.0), Pose(0.0, 2e-3), Pose(0.0, 1e-6), np.zeros(1), report)
    assert expected in [*equilibrium_table(found).columns[1].cells]


def test_what_no_decimals_show_is_nothing() -> None:
    """Of a run whose values of this kind are as small themselves: a change of inductance at some millihertz."""
    assert [with_error(value, 4e-13, 1e-12) for value in (474.8, -4e-13)] == ["474.8 +- 0", "0"]
    assert figure_text(1e-13, 2e-13, unit="N") == "0 N"


def test_kinds_of_a_run_have_one_size() -> None:
    """Lengths together, of the height its range; angles; signals: by the largest value or error."""
    data = {"d_h": [0.0, 1e-14], "d_v": [2e-3, 1.9e-3], "error_d_v": [1e-6, math.nan], "alpha": [0.0, math.nan]}
    data |= {"error_alpha": [1e-5, 2e-5], "L_v_percent": [190.0, 187.0], "L_h_percent": [1e-14, -5.0]}
    found = sizes_of(data, [name for name in data if not name.startswith("error_")])
    assert found == pytest.approx({"d_h": 1e-4, "d_v": 1e-4, "alpha": 2e-5, "L_v_percent": 5.0, "L_h_percent": 5.0})


@pytest.mark.parametrize(("value", "error", "expected"), [
    (0.5, 3.4, "below its error of 3.4 N"), (-0.5, 0.5, "below its error of 0.50 N"),
    (0.0, 55.0, "below its error of 55 N"),
    (0.5, 0.021, "0.500 +- 0.021 N"), (0.0, 0.0, "0 N"), (math.nan, 0.1, "-"), (0.4521, math.nan, "0.452 N"),
    (0.5, math.inf, "not determined: within the errors of the signals"),
])
def test_a_figure_that_its_error_exceeds_is_not_quoted(value: float, error: float, expected: str) -> None:
    """The error is, instead; scaled alike."""
    assert figure_text(value, error, unit="N") == expected
    assert figure_text(1e-3 * value, 1e-3 * error, 1e3, "N") == expected


def test_three_digits_without_an_exponent() -> None:
    """As a reader writes them."""
    numbers = (0.00351, 22.84, 1234.5, 0.0000012345, 1.5e7)
    assert [short(x) for x in numbers] == ["0.00351", "22.8", "1234", "1.23e-06", "1.5e+07"]
    assert [short(x, 2) for x in (123.4, 0.00351)] == ["123", "0.0035"]


def test_motion_out_of_the_plane_is_shown_over_temperature() -> None:
    """All six components where one answer has such."""
    flat = simulate(load_sensor("biorob2018"), Wrench(F_z=0.5), mechanics="linear", magnetics="planar", tolerance=0.1)
    pose = replace(flat.equilibrium.pose, d_y=1e-4)
    aside = replace(flat, equilibrium=replace(flat.equilibrium, pose=pose))
    for found, count in (([flat, flat], 3), ([flat, aside], 6)):
        table = temperatures_table(["C1", "C2"], [280.0, 300.0], found)
        assert len(table.columns) == 1 + count + 2 + 1
    assert list(table.columns[4].cells) == ["0.000", "100.000"] and table.columns[4].header == "d_y [um]"


def test_a_point_is_named_with_lengths_as_they_are_written() -> None:
    """In millimetres; other numbers in their SI unit, words as they are."""
    where = {"dv": 2e-4, "alpha": 0.1745, "elastomer.material": "rtv615", "F_z": 2.0}
    row = xr.Dataset({"status": ((), "failed")}, where)
    row["dv"].attrs["units"], row["alpha"].attrs["units"] = "m", "rad"
    assert point_name(row) == "dv = 0.2 mm, alpha = 0.1745 rad, elastomer.material = rtv615, F_z = 2 N"
