"""Show a measurement against the model: measured over computed inductance, residuals, the fit in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sits_mech.analysis.built.comparison import Comparison
from sits_mech.report.pictures.style import MARKS, new_figure
from sits_mech.report.records import named
from sits_mech.report.tables.built import unknown_scale

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FACTOR = "times the scene's"
_UNITS = ((1e9, "nH"), (1e12, "pH"), (1e15, "fH"))


def comparison_record(found: Comparison, coils: Sequence[str]) -> dict[str, Any]:
    """Return a comparison for a program, SI."""
    fit = found.fit
    values = {
        name: {"value": float(value), "half_width": float(width), "known": known.start, "deviation": known.deviation}
        for name, value, width, known in zip(fit.names, fit.values, fit.half_widths, found.free, strict=True)
    }
    return {
        "parameters": values,
        "correlation": fit.correlation.tolist(),
        "shear_modulus": found.shear_modulus,
        "rms": fit.rms,
        "rms_before": fit.rms_before,
        "map_error": found.map_error,
        "rows": len(found.measured.L),
        "residual": named(coils, fit.residual.T),
        "source": found.measured.source,
    }


def comparison_rows(found: Comparison) -> list[tuple[str, str]]:
    """Return a comparison as rows of a table: each parameter with its 95 % half-width."""
    fit, rows = found.fit, []
    for name, value, width in zip(fit.names, fit.values, fit.half_widths, strict=True):
        scale, unit = unknown_scale(name)
        rows.append((name, f"{scale * value:.5g} \u00b1 {scale * width:.2g} {unit or _FACTOR}"))
    if "modulus" in fit.names:
        rows.append(("shear modulus", f"{1e-3 * found.shear_modulus:.4g} kPa at small strain"))
    strong = [
        f"{a} and {b} {fit.correlation[i, j]:+.3f}"
        for i, a in enumerate(fit.names) for j, b in enumerate(fit.names[:i]) if abs(fit.correlation[i, j]) > 0.95
    ]
    if strong:
        rows.append(("hardly resolved", f"correlation of {'; '.join(strong)}"))
    before = f"{100.0 * fit.rms_before:.3g} % before the fit"
    rows.append(("residual (rms)", f"{100.0 * fit.rms:.3g} % of the range, {before}"))
    if found.map_error > 0.0:
        rows.append(("map", f"error {found.map_error:.1e} of the range between the loads of the table"))
    return [*rows, ("rows", f"{len(found.measured.L)} of {found.measured.source}")]


def comparison_figure(found: Comparison, coils: Sequence[str]) -> Figure:
    """Return measured over computed inductance, and beside it what the fit leaves, over the rows."""
    fit, L = found.fit, found.measured.L
    scale, unit = next((each for each in _UNITS if each[0] * np.max(np.abs(fit.residual)) >= 1.0), _UNITS[-1])
    with new_figure(height=0.8, columns=2) as (figure, (both, rest)):
        for k, coil in enumerate(coils):
            colour, mark = f"C{k % 7}", MARKS[k % len(MARKS)]
            both.plot(1e6 * (L - fit.residual)[:, k], 1e6 * L[:, k], mark, color=colour, label=f"{coil}, fitted")
            both.plot(
                1e6 * found.predicted[:, k], 1e6 * L[:, k], mark, color=colour, markerfacecolor="none",
                markeredgewidth=0.5, alpha=0.7, label=f"{coil}, before the fit",
            )
            rest.plot(np.arange(1, len(L) + 1), scale * fit.residual[:, k], mark + "-", color=colour, linewidth=0.5)
        ends = [1e6 * float(L.min()), 1e6 * float(L.max())]
        both.plot(ends, ends, color="black", linewidth=0.5, label="equal")
        both.set(xlabel="computed [\u00b5H]", ylabel="measured [\u00b5H]", title="inductance of each coil")
        rest.axhline(0.0, color="black", linewidth=0.5)
        rms = scale * float(np.sqrt(np.mean(fit.residual**2)))
        rest.set(xlabel="row of the bench file", ylabel=f"measured minus computed [{unit}]")
        rest.set_title(f"what the fit leaves: {rms:.2g} {unit} (rms)")
        figure.legend(loc="outside lower center", ncols=3, handlelength=1.2)
    return figure
