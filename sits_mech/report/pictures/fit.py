"""Show a fit: the measured points, the law's curve, the residuals, and the constants in words.

The curve is full over the fitted range and dashed up to the end of the test, where the law is used beyond its data.
"""

from __future__ import annotations

from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from sits_mech.report.pictures.curves import new_figure
from sits_mech.silicone.fitting import Fit
from sits_mech.silicone.homogeneous import engineering_stress
from sits_mech.silicone.laws import LAWS
from sits_mech.silicone.tensile import TensileTest

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STROKES = {"uniaxial": ("C0", "o"), "planar": ("C2", "s"), "biaxial": ("C3", "^")}  # colour and marker
_Many = float | None | tuple[float | None, ...] | tuple[float, ...]
_POINTS = 60  # markers per curve


def fit_rows(fit: Fit) -> list[tuple[str, str]]:
    """Return a fit as rows of a table: name and text, each constant with its 95 % half-width."""
    rows = [("law", fit.law)]
    for name, value in fit.constants.items():
        width, unit = fit.confidence[name], LAWS[fit.law].units[name]
        values, widths = _as_tuple(value), _as_tuple(width)
        parts = [_with_width(x, w) for x, w in zip(values, widths, strict=True)]
        rows.append((name, f"{', '.join(parts)} {unit}".rstrip()))
    rows += [
        ("residual (rms)", f"{fit.rms:.4g} Pa"),
        ("fitted up to", f"{100.0 * fit.max_strain:.4g} % strain, {', '.join(fit.modes)}"),
        ("stable", "yes" if fit.stable else "no"),
        ("source", fit.source),
    ]
    return rows + [("note", note) for note in fit.notes]


def _as_tuple(value: _Many) -> tuple[float | None, ...]:
    """Return one value or many as many."""
    return value if isinstance(value, tuple) else (value,)


def _with_width(value: float | None, width: float | None) -> str:
    """Return a constant with its half-width where it has one."""
    return f"{value:.5g}" if width is None else f"{value:.5g} \u00b1 {width:.2g}"


def fit_figure(test: TensileTest, fit: Fit) -> Figure:
    """Plot engineering stress over strain, all modes of the test with the law, and the residuals beside."""
    with new_figure(height=0.8, columns=2) as (figure, (curve, rest)):
        for one in (test, *test.others):
            _draw_test(curve, rest, one, fit)
        for axes in (curve, rest):
            axes.set_xlabel("engineering strain [%]")
        curve.set_ylabel("engineering stress [kPa]")
        rest.set_ylabel("measured minus law [kPa]")
        rest.axhline(0.0, color="black", linewidth=0.5)
        rest.set_xlim(0.0, 100.0 * fit.max_strain)
        curve.set_ylim(bottom=0.0)
        curve.set_xlim(left=0.0)
        figure.suptitle(f"{fill(Path(test.source).stem, 40)}: tensile test and {fit.law} law")
        figure.legend(loc="outside lower center", ncols=1 + len(test.others))
    return figure


def _draw_test(curve: Axes, rest: Axes, test: TensileTest, fit: Fit) -> None:
    """Add one test and the law along it; a law that locks is drawn as far as it goes."""
    (colour, mark), used = _STROKES[test.mode], test.strain <= fit.max_strain
    shown = test.strain <= 1.5 * fit.max_strain
    dots = slice(None, None, max(1, int(np.count_nonzero(shown)) // _POINTS))
    strain = np.linspace(0.0, float(test.strain[shown][-1]), 301)
    stress = engineering_stress(fit.law, fit.constants, strain, test.mode)
    stress = np.where((stress < 0.0) | (stress > 3.0 * test.stress[shown].max()), np.nan, stress)
    inside = strain <= fit.max_strain
    hollow: dict[str, Any] = {"color": colour, "markersize": 2.0, "markerfacecolor": "none", "markeredgewidth": 0.5}
    curve.plot(
        100.0 * test.strain[shown][dots], 1e-3 * test.stress[shown][dots], mark, **hollow,
        label=f"{test.mode}, measured",
    )
    curve.plot(100.0 * strain[inside], 1e-3 * stress[inside], color=colour, label=f"{test.mode}, {fit.law} law")
    curve.plot(100.0 * strain[~inside], 1e-3 * stress[~inside], color=colour, linestyle="--", label="beyond the fit")
    left = test.stress - engineering_stress(fit.law, fit.constants, test.strain, test.mode)
    rest.plot(100.0 * test.strain[used][dots], 1e-3 * left[used][dots], mark, **hollow)

