"""The picture and the rows of a fit: every curve and every constant is there."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from sits_mech.analysis.material.fitted import fit_law
from sits_mech.analysis.material.tensile import TensileTest
from sits_mech.report.pictures.style import save_figure
from sits_mech.report.plots.fit import fit_figure, fit_rows, read_figure, read_rows
from sits_mech.silicone.homogeneous import engineering_stress

STRAIN = np.linspace(0.0, 1.6, 81)
GENT = {"shear_modulus": 30e3, "j_m": 6.0}


def pulls() -> TensileTest:
    """Return a uniaxial and a planar test of one silicone."""
    stress = {mode: engineering_stress("gent", GENT, STRAIN, mode) for mode in ("uniaxial", "planar")}
    return TensileTest(STRAIN, stress["uniaxial"], "made.csv", others=(
        TensileTest(STRAIN, stress["planar"], "made.csv", "planar"),))


def test_picture_shows_data_law_and_rest(tmp_path: Path, collisions: Callable[[Figure], list[str]]) -> None:
    """Two tests: points, full and dashed curve of each in kPa over %, the rest beside it; and a file."""
    test = pulls()
    fit = fit_law(test, "gent")
    figure = fit_figure(test, fit)
    curve, rest = figure.axes
    assert [axes.get_xlabel() for axes in (curve, rest)] == ["engineering strain [%]"] * 2
    assert "[kPa]" in curve.get_ylabel() and "[kPa]" in rest.get_ylabel()
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert legend == [words for mode in ("uniaxial", "planar") for words in
                      (f"{mode}, measured", f"{mode}, gent law", "beyond the fit")]
    assert collisions(figure) == []
    points, inside, beyond = curve.lines[:3]
    assert points.get_marker() == "o" and beyond.get_linestyle() == "--"
    at_half = np.interp(50.0, inside.get_xdata(), inside.get_ydata())
    assert at_half == pytest.approx(engineering_stress("gent", GENT, np.array([0.5]))[0] / 1e3, rel=1e-4)
    assert np.abs(rest.lines[0].get_ydata()).max() < 1e-3
    assert rest.lines[0].get_xdata().max() < 0.99 * rest.get_xlim()[1], "the last mark is whole"
    save_figure(fit_figure(test, fit), tmp_path / "fit.png")
    assert (tmp_path / "fit.png").stat().st_size > 5000


def test_rows_carry_unit_and_half_width() -> None:
    """Pascals for moduli, none for exponents; a term each for Ogden; a note where there is one."""
    test = pulls()
    noisy = TensileTest(STRAIN, test.stress + np.random.default_rng(0).normal(0.0, 100.0, 81), "made.csv")
    rows = dict(fit_rows(fit_law(noisy, "gent")))
    assert rows["shear_modulus"].endswith(" Pa") and "\u00b1" in rows["shear_modulus"]
    assert "Pa" not in rows["j_m"] and "\u00b1" in rows["j_m"]
    assert rows["stable"] == "yes"
    rows = dict(fit_rows(fit_law(noisy, "ogden")))
    assert rows["mu"].count(",") == rows["alpha"].count(",")
    falling = TensileTest(STRAIN, 2e4 * np.sqrt(STRAIN), "made.csv")
    assert "note" in dict(fit_rows(fit_law(falling, "gent")))


def test_what_was_read_is_drawn_and_said(tmp_path: Path, collisions: Callable[[Figure], list[str]]) -> None:
    """Each specimen in its colour, rows left out in grey, a row a specimen with its slack, and the notes."""
    back = np.stack([STRAIN[::-4], 0.5 * pulls().stress[::-4]])
    first = TensileTest(STRAIN, pulls().stress, "made.csv", slack=0.05, left_out=back, columns="e; s")
    second = TensileTest(STRAIN, 1.2 * first.stress, "made.csv", columns="f; g")
    test = replace(first, others=(second,), notes=("a loop",))
    figure = read_figure(test)
    (axes,) = figure.axes
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["left out", "uniaxial 1", "uniaxial 2"]
    np.testing.assert_allclose(axes.lines[0].get_xydata(), (back * [[100.0], [1e-3]]).T)
    assert collisions(figure) == []
    rows = read_rows(test)
    assert [name for name, _ in rows] == ["uniaxial 1", "uniaxial 2", "note"] and rows[-1][1] == "a loop"
    assert rows[0][1].startswith("e; s: 81 rows taken, 21 left out, up to 160 %") and "slack of 5 % off" in rows[0][1]
    legend = fit_figure(test, fit_law(test, "gent")).legends[0].get_texts()
    assert [text.get_text() for text in legend] == ["uniaxial, measured", "uniaxial, gent law", "beyond the fit"]
