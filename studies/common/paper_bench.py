"""Which set-up explains the measured sensor? `compare` on the printed points, its parameters, what they share.

What the experiment leaves open, with what a bench of two linear stages, a rotation stage and a board may be off by. The
tank's capacitance is not printed: beside the scene's 330 pF stands what L0 asks for, 90 pF, known to 50 pF;
it scales every L and leaves percentages alone. A reading is weighed with 0.3 points of L0: 0.05 are its rounding, the
rest what three repeats and the scene leave. The two rows at 2 mm belong to the rotation, others to the vertical test.

As one set-up, C1 at 2 mm stays 0.73 and C2 at 1 mm 0.61 points off: at 1 mm C1 sees more of the plate than C2, at 2 mm
less, and no offset or tilt that both rows share turns round between them. As two, every point is within 0.5 and L0
within 0.5 %. Leads cannot be told from capacitance, nor offset from tilt, nor the axis's place along x from that along
z; the points say nothing of the conductivity.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from common.outputs import write_rows
from common.paper import DEGREE, FREE_MEASURED, MEASURED, MM
from common.profiles import profile

from sits_mech.analysis.built.comparison import Comparison, compare
from sits_mech.analysis.readings.measured import Measured
from sits_mech.report.pictures.style import new_figure, save_figure
from sits_mech.scene.sensor import Sensor, load_sensor

NOISE = 0.3e-2 * 3.2e-6  # of a reading [H]
KNOWN = {
    "capacitance": ("90 +- 50 pF", 1e12, "pF"), "lead": ("0 +- 100 nH", 1e9, "nH"),
    "gap": ("0 +- 0.2 mm", 1e3, "mm"), "d_h": ("0 +- 0.2 mm", 1e3, "mm"), "alpha": ("0 +- 2 deg", 1 / DEGREE, "deg"),
    "axis_x": ("0 +- 1 mm", 1e3, "mm"), "axis_z": ("0 +- 1 mm", 1e3, "mm"),
    "target.conductivity": ("55 +- 4 MS/m", 1e-6, "MS/m"),
}
SHIFTS = tuple(KNOWN)[:-1]  # without the conductivity, which the points do not resolve: profiles
STILL = ("capacitance", "lead", "gap", "d_h", "alpha", "target.conductivity")  # nothing turns
FEW = ("gap", "capacitance")  # coarse
HALF = 0.5  # [% of L0]
ONE = "one set-up"
TESTS = {ONE: (1, 2, 5), "vertical test": (1, 5), "rotation test": (2,)}


def bench(gaps: Sequence[int]) -> Measured:
    """Return the free coils and the printed points at some heights [mm] as a measurement."""
    places = [place for place in MEASURED if place[0] in gaps]
    poses = np.array([[0.0, z * MM, a * DEGREE, 0.0, 0.0, 0.0] for z, a in ((np.inf, 0), *places)])
    percent = np.array([(100.0, 100.0), *(MEASURED[place] for place in places)])
    return Measured(np.zeros((len(poses), 0)), percent / 100.0 * FREE_MEASURED, "BioRob 2018", poses)


def fitted(test: str, names: Sequence[str], tolerance: float) -> Comparison:
    """Return the comparison of a test by some parameters, with a model to a tolerance."""
    free = [f"{name} = {KNOWN[name][0]}" for name in names]
    return compare(scene(), None, bench(TESTS[test]), free, noise=NOISE, magnetics="sheets", tolerance=tolerance)


def scene() -> Sensor:
    """Return the published sensor; its conductivity may vary."""
    return load_sensor("biorob2018", ['target.conductivity="55 MS/m"'])


def points(test: str, found: Comparison) -> list[dict[str, object]]:
    """Return measured and fitted points with their distances [% of each coil's own L0]."""
    own = found.measured.L - found.fit.residual
    percent, before = (100.0 * L / L[0] for L in (own, found.predicted))
    rows: list[dict[str, object]] = []
    places = [place for place in MEASURED if place[0] in TESTS[test]]
    for k, (d_v, alpha) in enumerate(places, 1):
        for coil in (0, 1):
            measured = 100.0 * found.measured.L[k, coil] / FREE_MEASURED[coil]
            rows.append(
                {"fit": test, "d_v [mm]": d_v, "alpha [deg]": alpha, "coil": f"C{coil + 1}",
                 "measured [%]": float(measured), "scene [%]": float(before[k, coil]),
                 "scene less measured": float(before[k, coil] - measured), "fitted [%]": float(percent[k, coil]),
                 "fitted less measured": float(percent[k, coil] - measured)}
            )
    return rows


def parameters(test: str, found: Comparison) -> list[dict[str, object]]:
    """Return what was known of each parameter and what is after the fit, in its own unit."""
    rows: list[dict[str, object]] = []
    for k, name in enumerate(found.fit.names):
        scale, unit = KNOWN[name][1:]
        own, value = found.free[k], float(found.fit.values[k])
        others = [(abs(c), other, c) for other, c in zip(found.fit.names, found.fit.correlation[k], strict=True)
                  if other != name]
        _, partner, share = max(others)
        rows.append(
            {"fit": test, "parameter": f"{name} [{unit}]", "beforehand": KNOWN[name][0], "value": scale * value,
             "95 % half-width": scale * float(found.fit.half_widths[k]),
             "off [deviations]": (value - own.start) / own.deviation,
             "resolved": max(0.0, float(1.0 - (found.fit.half_widths[k] / (1.96 * own.deviation)) ** 2)),
             "strongest correlation": f"{partner} {share:+.2f}"}
        )
    return rows


def draw_profiles(found: Comparison, coarse: bool, path: Path) -> list[dict[str, object]]:
    """Draw the correlations and each parameter's profile, coarse: the last one's, and return these as rows."""
    names, rows = found.fit.names, []
    columns, rows_shown = (2, 1) if coarse else (3, 3)
    with new_figure(0.22 * rows_shown, columns, rows_shown, width=7.0 * columns / 3) as (figure, axes):
        axes[0].imshow(found.fit.correlation, vmin=-1, vmax=1, cmap="RdBu")
        short = [name.rpartition(".")[2] for name in names]
        axes[0].set_xticks(range(len(names)), short, rotation=60, ha="right", rotation_mode="anchor", fontsize=6)
        axes[0].set_yticks(range(len(names)), short, fontsize=6)
        axes[0].set_title("correlations: blue +1, red \u22121", fontsize=7)
        axes[0].grid(False)
        for spot, name, own in list(zip(axes[1:], names, found.free, strict=False))[-1 if coarse else 0 :]:
            scale, unit = KNOWN[name][1:]
            values, rise = profile(found, name, points=3 if coarse else 7)
            spot.plot(scale * values, rise, "o-", color="black")
            fine = np.linspace(values[0], values[-1], 60)
            spot.plot(scale * fine, ((fine - own.start) / own.deviation) ** 2, ":", color="C0")
            spot.axhline(3.84, color="C3", linewidth=0.6)
            spot.set(ylim=(-0.3, 8.0), xlabel=f"{short[names.index(name)]} [{unit}]", ylabel="rise of $\\chi^2$")
            for value, up in zip(values.tolist(), rise.tolist(), strict=True):
                rows.append({"parameter": f"{name} [{unit}]", "value": scale * value, "rise of chi^2": up})
        for spot in axes:
            if not spot.has_data():
                spot.set_axis_off()
        figure.suptitle("black: by the measured points; dotted: by what was known before; red: 95 %", fontsize=7)
    save_figure(figure, path)
    return rows


def measured_sensor(coarse: bool, folder: Path) -> str:
    """Write every table and the picture of the measured sensor, and return them for a reader."""
    tables: dict[str, list[dict[str, object]]] = {"measured_points": [], "measured_parameters": []}
    tolerance = 0.1 if coarse else 2e-2
    for test in (ONE,) if coarse else TESTS:
        found = fitted(test, FEW if coarse else STILL if test == "vertical test" else tuple(KNOWN), tolerance)
        tables["measured_points"] += points(test, found)
        tables["measured_parameters"] += parameters(test, found)
        free = 100.0 * (found.measured.L[0] - found.fit.residual[0]) / found.measured.L[0] - 100.0
        last = dict.fromkeys(tables["measured_parameters"][0], "") | {"fit": test, "value": float(np.abs(free).max())}
        tables["measured_parameters"].append(last | {"parameter": "L0, fitted less measured, at most [%]"})
    shown = found if coarse else fitted(ONE, SHIFTS, tolerance)
    tables["measured_profiles"] = draw_profiles(shown, coarse, folder / "measured_profiles.png")
    found_text = "\n".join(f"{name}\n\n{write_rows(rows, folder / f'{name}.csv')}" for name, rows in tables.items())
    return f"{found_text}\n{left_over(tables['measured_points'])}"


def left_over(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return which points each fit leaves farther off than half a point of L0."""
    lines = []
    for test in dict.fromkeys(row["fit"] for row in rows):
        own = [row for row in rows if row["fit"] == test]
        away = {f"{r['coil']} at {r['d_v [mm]']} mm, {r['alpha [deg]']} deg": r["fitted less measured"] for r in own}
        far = ", ".join(f"{place}: {off:+.2f}" for place, off in away.items() if abs(off) > HALF) or "none"
        rms = float(np.sqrt(np.mean(np.square(list(away.values())))))
        lines.append(f"{test}: not explained to {HALF} points: {far}; rms {rms:.2f}\n")
    return "".join(lines)
