"""Show a fit: the measured points, the law's curve, the residuals, and the constants in words.

The curve is full over the fitted range and dashed up to the end of the test, where the law is used beyond its data.
"""

from __future__ import annotations

from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from sits_mech.analysis.material.fitted import Fit, Fitted
from sits_mech.analysis.material.relaxing import Relaxation
from sits_mech.analysis.material.softening import CyclicFit
from sits_mech.analysis.material.tensile import TensileTest
from sits_mech.report.pictures.style import new_figure
from sits_mech.report.tables.solves import key_table
from sits_mech.scene.files import literal
from sits_mech.silicone.homogeneous import engineering_stress
from sits_mech.silicone.laws import LAWS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STROKES = {"uniaxial": ("C0", "o"), "planar": ("C2", "s"), "biaxial": ("C3", "^")}  # colour and marker
_Many = float | None | tuple[float | None, ...] | tuple[float, ...]
_POINTS = 60  # markers per curve
_ROOM = 1.04  # of the fitted range: the last mark is whole


def fit_rows(fit: Fit) -> list[tuple[str, str]]:
    """Return a fit as rows of a table: name and text, each constant with its 95 % half-width."""
    rows = [("law", fit.law)]
    for name, value in fit.constants.items():
        width, unit = fit.confidence[name], LAWS[fit.law].units[name]
        values, widths = _as_tuple(value), _as_tuple(width)
        parts = [_with(x, w, 5) for x, w in zip(values, widths, strict=True)]
        rows.append((name, f"{', '.join(parts)} {unit}".rstrip()))
    rows += [
        ("residual (rms)", f"{fit.rms:.4g} Pa"),
        ("fitted up to", f"{100.0 * fit.max_strain:.4g} % strain, {', '.join(fit.modes)}"),
        ("stable", "yes" if fit.stable else "no"),
        *([] if fit.mode_spread is None else [("mode_spread", f"{fit.mode_spread:g}, of loads of pads by other laws")]),
        ("source", fit.source),
    ]
    return rows + [("note", note) for note in fit.notes]


def _as_tuple(value: _Many) -> tuple[float | None, ...]:
    """Return one value or many as many."""
    return value if isinstance(value, tuple) else (value,)


def _with(value: float | None, width: float | None, digits: int = 4) -> str:
    """Return a constant with its half-width where it has one."""
    return f"{value:.{digits}g}" if width is None else f"{value:.{digits}g} \u00b1 {width:.2g}"


def fit_figure(test: TensileTest, fit: Fit) -> Figure:
    """Plot engineering stress over strain, all modes of the test with the law, and the residuals beside."""
    with new_figure(height=0.8, columns=2) as (figure, (curve, rest)):
        seen = set[str]()
        for one in test.all:
            _draw_test(curve, rest, one, fit, "_" if one.mode in seen else "")
            seen.add(one.mode)
        rest.axhline(0.0, color="black", linewidth=0.5)
        rest.set(xlabel="engineering strain [%]", ylabel="measured minus law [kPa]")
        rest.set_xlim(0.0, _ROOM * 100.0 * fit.max_strain)
        curve.set(xlabel="engineering strain [%]", ylabel="engineering stress [kPa]")
        curve.set_ylim(bottom=0.0)
        curve.set_xlim(left=0.0)
        figure.suptitle(f"{fill(Path(test.source).stem, 40)}: {fit.law} is off by {1e-3 * fit.rms:.2g} kPa (rms)")
        figure.legend(loc="outside lower center", ncols=len(seen))
    return figure


def read_rows(test: TensileTest) -> list[tuple[str, str]]:
    """Return what a file of a machine was read as, in rows of a table: a row a specimen, and its notes."""
    rows = []
    for k, one in enumerate(test.all):
        left = 0 if one.left_out is None else one.left_out.shape[1]
        end = f"up to {100.0 * one.strain[-1]:.4g} % strain and {1e-3 * one.stress[-1]:.4g} kPa"
        slack = f", slack of {100.0 * one.slack:.3g} % off" if one.slack else ""
        taken = f"{one.columns}: {len(one.strain)} rows taken, {left} left out, {end}{slack}"
        rows.append((f"{one.mode} {k + 1}", taken))
    return rows + [("note", note) for note in test.notes]


def read_figure(test: TensileTest) -> Figure:
    """Plot the rows of a file as engineering stress over strain: those taken, and in grey those left out."""
    with new_figure(height=0.8) as (figure, (curve,)):
        for k, one in enumerate(test.all):
            if one.left_out is not None and one.left_out.size:
                e, s = one.left_out
                curve.plot(100.0 * e, 1e-3 * s, ".", color="0.6", markersize=3.0, label="left out" if k == 0 else None)
            curve.plot(100.0 * one.strain, 1e-3 * one.stress, color=f"C{k}", label=f"{one.mode} {k + 1}")
        curve.set(xlabel="engineering strain [%]", ylabel="engineering stress [kPa]")
        figure.suptitle(f"{fill(Path(test.source).name, 40)}: what is taken of it")
        curve.legend()
    return figure


def _draw_test(curve: Axes, rest: Axes, test: TensileTest, fit: Fit, unnamed: str) -> None:
    """Add one test and the law along it; a law that locks is drawn as far as it goes. "_" keeps it off the legend."""
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
        label=f"{unnamed}{test.mode}, measured",
    )
    for some, line, label in ((inside, "-", f"{test.mode}, {fit.law} law"), (~inside, "--", "beyond the fit")):
        curve.plot(100.0 * strain[some], 1e-3 * stress[some], line, color=colour, label=unnamed + label)
    left = test.stress - engineering_stress(fit.law, fit.constants, test.strain, test.mode)
    rest.plot(100.0 * test.strain[used][dots], 1e-3 * left[used][dots], mark, **hollow)


def fitted_tables(found: Fitted) -> list[Table | str]:
    """Return the tables of the fit of a silicone's tests."""
    tables: list[Table | str] = []
    if found.fit is not None and found.test is not None:
        tables.append(key_table(found.test.source, fit_rows(found.fit)))
    if found.relaxation is not None:
        tables.append(key_table("rate", relaxation_rows(found.relaxation)))
    if found.cyclic is not None:
        tables.append(key_table("softening", cyclic_rows(found.cyclic)))
    return [*tables, pasted(found)]


def pasted(found: Fitted) -> str:
    """Return what is known of a material as lines of a scene file."""
    lines = ["[elastomer.material]"]
    for key, value in found.table.items():
        entries = [literal(item) for item in value] if key == "prony" else []
        text = "\n".join(["[", *(f"    {entry}," for entry in entries), "]"]) if entries else literal(value)
        lines.append(f"{key} = {text}")
    return "\n".join([*lines, "# bulk_modulus: no test here shows it; catalogued silicones have 1000 shear moduli"])


def relaxation_rows(found: Relaxation) -> list[tuple[str, str]]:
    """Return a relaxation as rows of a table: name and text, each constant with its 95 % half-width."""
    rows = [
        (f"branch {k + 1}", f"weight {_with(weight, around)}, time {_with(time, about)} s")
        for k, ((weight, time), (around, about)) in enumerate(zip(found.prony, found.confidence, strict=True))
    ]
    if found.factor is not None:
        rows.append(("slow load", f"{found.factor:.4g} times the stress of the law"))
    rows += [
        ("identified", "yes" if found.slow_identified else "no"),
        ("times seen", f"{found.range[0]:.3g} s to {found.range[1]:.3g} s, at {100.0 * found.strain:.4g} % strain"),
    ]
    return rows + _origin(found)


def cyclic_rows(found: CyclicFit) -> list[tuple[str, str]]:
    """Return a softening as rows of a table: name and text, each constant with its 95 % half-width."""
    rows = []
    for name, value in ({} if found.mullins is None else vars(found.mullins)).items():
        rows.append((name, f"{_with(value, found.confidence[name])}{' Pa' if name == 'm' else ''}"))
    rows += [
        ("specimen", f"{found.factor:.4g} times the stress of the law"),
        ("peaks", f"{found.peaks}, up to {100.0 * found.max_strain:.4g} % strain"),
    ]
    return rows + _origin(found)


def _origin(found: Relaxation | CyclicFit) -> list[tuple[str, str]]:
    """Return what is left of a fit, where it comes from, and its notes, as rows."""
    rows = [("residual (rms)", f"{found.rms:.4g} Pa"), ("source", found.source)]
    return rows + [("note", note) for note in found.notes]
