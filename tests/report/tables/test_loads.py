"""Tables: every number with its error, to the digits that the error leaves."""

import csv
import io
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from rich.console import Console

from sits_mech.notes import Note, NoteKind, packed
from sits_mech.report.folder import read_calibration
from sits_mech.report.tables.loads import csv_text, failures, figures, in_width, load_table, remarks, summary_table

COILS = ["C1", "C2"]


NOTES = tuple(Note.of(NoteKind.STATED, text=text) for text in ("coarse; few", "folded"))


def made(error: float = 0.01) -> xr.Dataset:
    """A calibration of formulas: L_v = 190 - 2 F_z, L_h = 3 F_x, a tenth of it by rotation; one load failed."""
    F_x, F_z = np.array([-1.0, 0.0, 1.0]), np.array([0.0, 1.0, 2.0])
    data = xr.Dataset(coords={"F_x": F_x, "F_z": F_z, "coil": COILS, "coil_2": COILS}, attrs={"name": "by hand"})
    x, z = data.F_x + 0.0 * data.F_z, 0.0 * data.F_x + data.F_z
    formulas = {
        "d_h": 1e-4 * x, "d_v": 2e-3 - 1e-4 * z, "alpha": 1e-3 * x, "L_v_percent": 190.0 - 2.0 * z,
        "L_h_percent": 3.0 * x, "L_h_untilted_percent": 2.7 * x, "seconds": 0.0 * x,
    }
    data = data.assign(formulas)
    data = data.assign({f"error_{name}": error + 0.0 * x for name in ("L_v_percent", "L_h_percent")})
    data = data.assign({f"error_{name}": 1e-6 + 0.0 * x for name in ("d_h", "d_v", "alpha")})
    data["L"] = (("F_x", "F_z", "coil", "coil_2"), np.arange(36.0).reshape(3, 3, 2, 2))
    texts = {"status": "ok", "flags": "ok", "reason": "", "notes": packed(NOTES)}
    data = data.assign({name: (("F_x", "F_z"), np.full((3, 3), text, dtype=object)) for name, text in texts.items()})
    data["status"][2, 2], data["flags"][2, 2] = "failed", "failed"
    data["reason"][2, 2], data["notes"][2, 2] = "too much", ""
    return data


def text_of(table: object) -> str:
    """Return what a table looks like."""
    console = Console(file=io.StringIO(), width=200, markup=False)
    console.print(table)
    return console.file.getvalue()


def test_the_load_table_has_an_error_on_every_number() -> None:
    """Five quantities for nine loads, in the scaled units of the headings."""
    text = text_of(load_table(made()))
    assert text.count("+-") == 45 and "d_h [um]" in text and "alpha [mrad]" in text and "failed" in text
    assert "100.0 +- 1.0" in text and "188.000 +- 0.010" in text


def test_figures_of_merit_by_hand() -> None:
    """Slopes, full scales, and the error that each may have when the signals are off by theirs."""
    found = {name: (value, error) for name, value, error, _ in figures(made())}
    assert found["d(L_v)/dF_z mid-grid"] == pytest.approx((-2.0, 0.01))
    assert found["d(L_h)/dF_x mid-grid"] == pytest.approx((3.0, 0.01))
    assert found["full scale of L_h"] == pytest.approx((6.0, 0.02)) and found["full scale of L_v"][0] == 4.0
    assert found["crosstalk of F_z into L_h"] == pytest.approx((0.0, 2.0 * 0.01 * 100.0 / (6.0 - 2.0 * 0.01)))
    # at the end of the grid a slope is (-3 y_0 + 4 y_1 - y_2) / 2: an error of 0.01 each makes 0.04
    assert found["rotation read as shear force"] == pytest.approx((0.1, 0.1 * 0.24 / 2.96))
    assert found["rotation read as displacement"][0] == pytest.approx(1e6 * 0.3 * 1e-4 / 2.7)
    text = text_of(summary_table(made()))
    assert len(found) == 10 and text.count("+-") == 6 and text.count("below its error") == 4


def test_a_figure_within_the_errors_is_not_quoted() -> None:
    """A full scale that may be zero makes no percentage."""
    text = text_of(summary_table(made(error=3.5)))
    assert text.count("not determined") == 4 and "crosstalk" in text


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_errors_of_the_figures_hold(sign: float) -> None:
    """Signals off by their whole error at random change no figure by more than it says."""
    generator = np.random.default_rng(7)
    exact, off = made(), made()
    for name in ("L_v_percent", "L_h_percent"):
        off[name] = off[name] + sign * 0.01 * np.sign(generator.standard_normal((3, 3)))
    for (name, value, error, _), (_, moved, _, _) in zip(figures(exact), figures(off), strict=True):
        assert abs(moved - value) <= 1.001 * error, name


def test_failures_and_remarks_are_lines() -> None:
    """Each missing load with its reason; each note once, with its count."""
    assert failures(made()) == ["F_x = 1 N, F_z = 2 N: failed: too much"]
    worst = "8 of 9 loads, worst F_x = -1 N, F_z = 0 N"
    assert remarks(made()) == [f"{worst}: {words}" for words in ("coarse; few", "folded")]
    data = made()
    parts = [[0.1 * x + 0.01 * z for z in range(3)] for x in range(3)]
    data["notes"][:] = [[packed([Note.of(NoteKind.PATH_PART, part=part)]) for part in row] for row in parts]
    data["stretch"] = data.F_x + data.F_z
    failed = "9 of 9 loads, worst F_x = 1 N, F_z = 2 N: reached 22.0% of the path"
    assert remarks(data) == [failed]
    data["status"][0, 0], data["status"][2, 2] = "beyond data", "ok"
    assert remarks(data) == ["9 of 9 loads, worst F_x = -1 N, F_z = 0 N: reached 0.0% of the path"]


def test_csv_keeps_every_digit() -> None:
    """One line per load; matrices by pairs of coils."""
    rows = list(csv.DictReader(io.StringIO(csv_text(made(), units=False))))
    named = csv_text(made()).splitlines()[0].split(",")
    assert [name.partition(" [")[0] for name in named] == list(rows[0]) and "reason" in named
    assert {"F_x [N]", "F_z [N]", "d_v [m]", "L[C2][C1] [H]", "alpha [rad]"} <= {*named}
    assert len(rows) == 9 and rows[5]["F_x"] == "0.0" and rows[5]["F_z"] == "2.0"
    assert [float(row["d_v"]) for row in rows] == made()["d_v"].transpose("F_x", "F_z").to_numpy().ravel().tolist()
    assert float(rows[4]["L[C2][C1]"]) == 4 * 4 + 2 and rows[8]["reason"] == "too much"


@pytest.mark.slow
def test_a_table_of_three_forces(three_forces: Path) -> None:
    """One line per load with all that moves; sensitivities by each force, what is not available by name."""
    _, data = read_calibration(three_forces)
    table, rows = load_table(data), list(csv.DictReader(io.StringIO(csv_text(data, units=False))))
    headings = [str(column.header) for column in table.columns]
    assert headings[:6] == ["F_x [N]", "F_z [N]", "F_y [N]", "d_h [um]", "d_v [um]", "alpha [mrad]"]
    assert "d_y [um]" in headings and "M = 0.001 N m" in str(table.title) and table.row_count == len(rows) == 60
    assert [rows[4][name] for name in ("F_x", "F_z", "F_y", "M")] == ["-1.0", "1.0", "0.0", "0.001"]
    assert float(rows[-1]["d_y"]) == pytest.approx(4e-5) and list(rows[0])[:4] == ["F_x", "F_z", "F_y", "M"]
    found = {name: value for name, value, *_ in figures(data)}
    names = ("F_x", "F_z", "F_y")
    slopes = {f"d({signal})/d{name} mid-grid" for signal in ("L_v", "L_h") for name in names}
    assert set(found) >= slopes | {"full scale of L_h", "crosstalk of F_y into L_v", "rotation read as shear force"}
    lower, upper = (data["L_v_percent"].isel(F_x=2, F_y=1, F_z=k) for k in (1, 3))
    assert found["d(L_v)/dF_z mid-grid"] == pytest.approx(float(upper - lower) / 2.0)
    scale, stray = found["full scale of L_v"], found["crosstalk of F_y into L_v"]
    assert stray == pytest.approx(100.0 * 0.4**2 / scale)


def test_a_table_of_moments_has_their_unit() -> None:
    """Per newton metre; a table of one load has no figures."""
    data = made().isel(F_z=0).rename(F_x="M")
    assert [unit for *_, unit in figures(data) ] == ["% of L0 / (N m)"] * 2
    assert failures(made().rename(F_x="M")) == ["M = 1 N m, F_z = 2 N: failed: too much"]
    single = data.isel(M=0).drop_vars("M")
    assert figures(single) == [] and summary_table(single).row_count == 0
    assert csv_text(single).count("\n") == 2 and load_table(single).row_count == 1


def test_a_wide_table_is_cut_into_parts_of_a_terminal_s_width() -> None:
    """Every number is shown, behind its load, no line is longer; what fits stays one table."""
    whole = load_table(made())
    assert len(in_width(whole, 2, 1000)) == 1
    parts = in_width(whole, 2, 80)
    headings = [str(column.header) for part in parts for column in part.columns[2:]]
    assert len(parts) > 1 and headings == [str(column.header) for column in whole.columns[2:]]
    assert all(part.row_count == whole.row_count and part.columns[0].header == "F_x [N]" for part in parts)
    for part in parts:
        with (console := Console(width=80, markup=False)).capture() as shown:
            console.print(part)
        assert "\N{HORIZONTAL ELLIPSIS}" not in shown.get()
