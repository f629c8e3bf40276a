"""The published figures again: does a model give what was printed, and which of its unstated choices matter?

D. Jones, J. Kow, A. Alazmani, P. Culmer, Computational Design Tools for Soft Inductive Tactile Sensors, BioRob 2018
(doi:10.1109/BIOROB.2018.8487666) moves a rigid copper plate over two coils. Figure 4: flux lines; figure 6 a-c:
inductance of each coil against d_v, d_h and alpha; d, e: their sum against d_v and difference against d_h; f: the shear
that a rotation reads as. Figure 7: sum and difference over d_h and d_v for targets 8, 15 and 22 mm wide. All in percent
of the free-space L0.

The planar answer hangs on three choices that the text leaves open or gives otherwise than its numbers: whether both
coils are driven together in the same sense (their mutual inductance then counts), whether the plate's net current is
free to return where A = 0, at 100 mm, and the frequency (5 kHz in the text). All eight combinations are tabulated; of
them both coils, free, 5 MHz comes near every printed point, the coils' own inductance (L0 + M12) and the shear that
20 degrees read as. Every figure is drawn in the setting that is stated, in the one that fits, and in space.

What the width study's ranges span is not said. They are taken as the difference over d_h from -5 to 5 mm at 2 mm, and
the sum from free space to 1 mm. `figure_7` tells what no setting gives: the normal range of 8 mm, 24.2 % printed.

The measured sensor is compared with the model in space, as it is and with what the experiment leaves open
(common/paper_bench.py).

Run ``python studies/paper_figures.py [--coarse] --output DIR``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from common.accuracy import forget
from common.outputs import study_arguments, write_rows
from common.paper import (
    ALONE,
    BEST_WIDTH,
    DEGREE,
    FITTING,
    FREE_MEASURED,
    FREE_SIMULATED,
    MEASURED,
    MM,
    RANGES,
    READS,
    SIMULATED,
    SPATIAL,
    STATED,
    Setting,
    Spots,
    distances,
    poses,
    spots,
)
from common.paper_bench import measured_sensor
from scipy.optimize import minimize_scalar

from sits_mech.magnetics.field import planar_fem
from sits_mech.quantities import Array, Pose
from sits_mech.report.pictures.style import add_polygons, new_figure, save_figure

SHOWN = (STATED, FITTING, SPATIAL)
FIGURE_7 = (STATED, ALONE, FITTING, SPATIAL)
_FEW = 3  # heights of a coarse map
PARTS = 8  # in which a field is asked: finding all places at once in a graded mesh takes 0.8 GB
WIDE = 7.0  # of figures side by side [in]
FIELDS = {"2 mm": (0.0, 2.0, 0.0), "$d_v$ 1 mm": (0.0, 1.0, 0.0), "$d_h$ 3 mm": (3.0, 2.0, 0.0),
          "$\\alpha$ 20 deg": (0.0, 2.0, 20.0)}


def switches(tolerance: float) -> list[dict[str, object]]:
    """Return the printed points by each combination of the planar model's unstated choices, and by the 3D model."""
    rows = [_row("printed simulation", SIMULATED, FREE_SIMULATED), _row("measured", MEASURED, FREE_MEASURED[0])]
    for both, net, frequency in product((False, True), ("zero", "free"), (5e3, 5e6)):
        drive = "both" if both else "one"
        name = f"planar, {drive} driven, net current {net}, {frequency / 1e3:g} kHz"
        rows.append(_asked(replace(ALONE, name=name, both=both, net_current=net, frequency=frequency), tolerance))
    return [*rows, _asked(SPATIAL, tolerance)]


def _asked(setting: Setting, tolerance: float) -> dict[str, object]:
    """Return a line of a setting."""
    found = setting.percent(spots(), tolerance)
    values: Spots = dict(zip(SIMULATED, map(tuple, found.tolist()), strict=True))
    return _row(setting.name, values, setting.free_inductance())


def _row(name: str, values: Spots, free: float) -> dict[str, object]:
    """Return one line: both coils at each point, distances from both printed sets, and what a free coil shows."""
    row: dict[str, object] = {"model": name}
    for (d_v, alpha), (first, second) in values.items():
        place = f"d_v {d_v} mm" if alpha == 0 else f"{alpha} deg"
        row |= {f"{place}: C1": first, f"{place}: C2": second}
    found = np.array([*values.values()])
    for printed, title in ((SIMULATED, "simulation"), (MEASURED, "measured")):
        most, rms = distances(found, printed)
        row |= {f"from {title}: most": most, f"from {title}: rms": rms}
    return row | {"free [uH, uH/m]": 1e6 * free}


def figure_4(coarse: bool, folder: Path) -> None:
    """Draw flux lines while coil 2 alone carries 1 mA, stated, and while both do, as it fits."""
    chosen = list(FIELDS.items())[-1:] if coarse else list(FIELDS.items())
    shown = (STATED,) if coarse else (STATED, FITTING)
    x, z = np.linspace(-12.0, 12.0, 161), np.linspace(-4.0, 8.0, 81)
    places = (x + 1j * z[:, None]) * MM
    height = 0.17 * len(shown) + 0.04
    width = WIDE * max(len(chosen), 2) / len(FIELDS)
    with new_figure(height * WIDE / width, len(chosen), len(shown), width=width) as (figure, axes):
        for spot, (setting, (name, place)) in zip(axes, product(shown, chosen), strict=True):
            pose = Pose(place[0] * MM, place[1] * MM, place[2] * DEGREE)
            field = planar_fem(setting.sensor(), 0.1).field(pose, setting.frequency)
            if field is None:
                raise SystemExit("figure 4: the target acts on nothing")
            currents = np.array([1e-3 if setting.both else 0.0, 1e-3], dtype=complex)
            parts = [field.potential(part, currents).real for part in np.array_split(places.ravel(), PARTS)]
            A = np.concatenate(parts).reshape(places.shape)
            steps = np.abs(A).max() * np.linspace(0.02, 1.0, 14) ** 2
            lines = np.concatenate([-steps[::-1], steps])
            ways = ["--"] * len(steps) + ["-"] * len(steps)
            spot.contour(x, z, A, lines, cmap="viridis", linewidths=0.5, linestyles=ways)
            for plate in field.plates:
                corners = np.stack([plate.corners.real, plate.corners.imag], -1) / MM
                add_polygons(spot, corners[None], facecolor="peru", edgecolor="black", linewidth=0.4, zorder=5)
            spot.grid(False)
            spot.set_aspect("equal")
            spot.set_title(f"{name}, {setting.short}", fontsize=7)
            if not coarse:
                forget()
        for spot in axes[-len(chosen) :]:
            spot.set_xlabel("$x$ [mm]")
        for spot in axes[:: len(chosen)]:
            spot.set_ylabel("$z$ [mm]")
        words = ("stated: coil 2 carries 1 mA at 5 kHz", "fitting: both do at 5 MHz")[: len(shown)]
        figure.suptitle(f"lines of flux; {', '.join(words)}", fontsize=8)
    save_figure(figure, folder / "figure_4.png")


def figure_6(count: int, tolerance: float, folder: Path) -> list[dict[str, object]]:
    """Draw figure 6 in each setting side by side, and return what 20 degrees read as and how far the points are."""
    along = np.linspace(1, 5, count), np.linspace(0, 5, count), np.linspace(0, 20, count)
    rows = []
    with new_figure(height=1.5, columns=len(SHOWN), rows=6, width=WIDE) as (figure, axes):
        for column, setting in enumerate(SHOWN):
            moved = [
                setting.percent(place, tolerance)
                for place in (poses(d_v=along[0]), poses(d_h=along[1]), poses(alpha=along[2]))
            ]
            shear, turned = (part[:, 0] - part[:, 1] for part in moved[1:])
            rising = int(np.argmax(np.abs(shear))) + 1  # up to the largest: beyond it a shear has two readings
            sign = np.sign(shear[rising - 1])
            reads = np.interp(sign * turned, sign * shear[:rising], along[1][:rising])
            reads = np.where(sign * turned > -1e-9, reads, np.nan)  # the other way: no shear to this side
            own = axes[column :: len(SHOWN)]
            for spot, at, values in zip(own, along, moved, strict=False):
                spot.plot(at, values, label=["C1", "C2"])
            own[3].plot(along[0], moved[0].sum(axis=1), "k")
            own[4].plot(along[1], shear, "k")
            own[5].plot(along[2], reads, "k")
            if not np.any(reads > 0.0):
                own[5].text(10, READS / 2, "turned, it reads as shear\nto the other side", ha="center", fontsize=7)
            _mark(own)
            if count > _FEW:
                forget()
            own[0].set_title(setting.name.replace(": ", ":\n"), fontsize=7)
            found = setting.percent(spots(), tolerance)
            rows.append(
                {"setting": setting.name, "20 deg at 2 mm reads [mm]": float(reads[-1]), "printed [mm]": READS,
                 "from simulation: most": distances(found, SIMULATED)[0],
                 "from measured: most": distances(found, MEASURED)[0], "largest shear [%]": float(np.abs(shear).max()),
                 "at d_h [mm]": float(along[1][rising - 1])}
            )
        for row, (x, y) in enumerate(_LABELS):
            for spot in axes[row * len(SHOWN) : (row + 1) * len(SHOWN)]:
                spot.set_xlabel(x, labelpad=1)
            axes[row * len(SHOWN)].set_ylabel(f"{'abcdef'[row]}) {y}")
            level(axes[row * len(SHOWN) : (row + 1) * len(SHOWN)])
        axes[len(SHOWN)].legend(loc="best")
        figure.suptitle("x measured, + printed simulation; C1 blue, C2 orange", fontsize=8)
    save_figure(figure, folder / "figure_6.png")
    return rows


def level(axes: Sequence[Any]) -> None:
    """Give axes side by side one scale."""
    ends = np.array([spot.get_ylim() for spot in axes])
    for spot in axes:
        spot.set_ylim(ends[:, 0].min(), ends[:, 1].max())


_LABELS = (
    ("$d_v$ [mm]", "$L/L_0$ [%]"), ("$d_h$ [mm]", "$L/L_0$ [%]"), ("$\\alpha$ [deg]", "$L/L_0$ [%]"),
    ("$d_v$ [mm]", "sum [%]"), ("$d_h$ [mm]", "difference [%]"), ("$\\alpha$ [deg]", "reads as [mm]"),
)


def _mark(own: list[Any]) -> None:
    """Draw the printed points into the six axes of a setting."""
    for printed, mark in ((MEASURED, "x"), (SIMULATED, "+")):
        for (gap, angle), pair in printed.items():
            for value, colour in zip(pair, ("C0", "C1"), strict=True):
                both = mark == "x"
                spot, at = (own[2], angle) if angle else (own[0], gap)
                spot.plot(at, value, mark, color=colour if both else "red", ms=4)
                if gap == 2 and not angle:
                    own[1].plot(0, value, mark, color=colour if both else "red", ms=4)
                    own[2].plot(0, value, mark, color=colour if both else "red", ms=4)
            if not angle:
                own[3].plot(gap, sum(pair), mark, color="black" if mark == "x" else "red", ms=4)
            if gap == 2 and not angle:
                own[4].plot(0, pair[0] - pair[1], mark, color="black" if mark == "x" else "red", ms=4)
    own[5].plot(20, READS, "+", color="red", ms=5)


def ranges(setting: Setting, width: float, count: int, tolerance: float) -> tuple[float, float, Array]:
    """Return span of the difference, of the sum from free space, and figure 7's map of both coils [%]."""
    gaps = np.linspace(1.0, 5.0, count)
    d_h, d_v = (part.ravel() for part in np.meshgrid(np.linspace(0.0, 5.0, count), np.append(gaps, 2.0), indexing="ij"))
    found = setting.percent(poses(d_h, d_v), tolerance, width).reshape(count, count + 1, 2)
    if count > _FEW:
        forget()  # plates of many widths are not kept: memory
    difference, total = found[:, -1, 0] - found[:, -1, 1], found[0, :-1].sum(axis=-1)
    return float(2.0 * np.max(np.abs(difference))), float(200.0 - np.min(total)), found[:, :-1]


def figure_7(count: int, tolerance: float, folder: Path) -> list[dict[str, object]]:
    """Draw figure 7 in each setting side by side and return the ranges of the width study beside those printed."""
    rows, maps, at = [], [], (np.linspace(0, 5, count), np.linspace(1, 5, count))
    printed_ranges = list(RANGES.items())[: 1 if count <= _FEW else None]
    cases, columns = list(product(FIGURE_7, printed_ranges)), len(printed_ranges)
    for setting, (width, printed) in cases:
        shear, normal, found = ranges(setting, width, count, tolerance)
        maps.append(found)
        rows.append(
            {"setting": setting.name, "width [mm]": width, "shear range [%]": shear, "printed shear [%]": printed[0],
             "normal range [%]": normal, "printed normal [%]": printed[1]}
        )
    for signal in ("difference", "sum"):
        with new_figure(height=1.0, columns=columns, rows=len(FIGURE_7), width=WIDE) as (figure, axes):
            for number, (spot, (setting, (width, _)), found) in enumerate(zip(axes, cases, maps, strict=True)):
                values = found[..., 0] - found[..., 1] if signal == "difference" else found.sum(axis=-1)
                picture = spot.contourf(*at, values.T, levels=24)
                figure.colorbar(picture, ax=spot).ax.tick_params(labelsize=6)
                spot.grid(False)
                spot.set_title(f"{setting.short}, {width} mm", fontsize=7)
                if number % columns == 0:
                    spot.set_ylabel("$d_v$ [mm]")
                if number >= len(cases) - columns:
                    spot.set_xlabel("$d_h$ [mm]")
            figure.suptitle(f"{signal} of both coils [% of $L_0$]", fontsize=8)
        save_figure(figure, folder / f"figure_7_{signal}.png")
    return rows


def shear_sentence(rows: list[dict[str, object]]) -> str:
    """Say how the shear ranges in space stand beside those printed."""
    own = [row for row in rows if row["setting"] == SPATIAL.name]
    found = ", ".join(f"{row['shear range [%]']:.2f}" for row in own)
    printed = ", ".join(f"{row['printed shear [%]']:.1f}" for row in own)
    return (
        f"Shear ranges in space for 8, 15 and 22 mm are {found} % of L0, printed {printed} %: a section, endless along "
        "y, couples a coil with the plate all along, a plate 8 mm long covers it in part; 22 mm gives least in both.\n"
    )


def optimum_width(count: int, tolerance: float, coarse: bool) -> list[dict[str, object]]:
    """Return the width of the largest product of both ranges, between 6 and 22 mm, for each setting."""
    rows = []
    for setting, accuracy in ((ALONE, 0.1), (FITTING, 0.1), (SPATIAL, 0.25))[: 1 if coarse else 3]:

        def cost(width: float, setting: Setting = setting) -> float:
            shear, normal, _ = ranges(setting, round(width, 3), count, tolerance)
            return -shear * normal

        options = {"xatol": accuracy, "maxiter": 2 if coarse else 30}
        found = minimize_scalar(cost, bounds=(6.0, 22.0), method="bounded", options=options)
        shear, normal, _ = ranges(setting, round(found.x, 3), count, tolerance)
        rows.append(
            {"setting": setting.name, "best width [mm]": float(found.x), "to": accuracy, "shear range [%]": shear,
             "normal range [%]": normal, "printed best [mm]": BEST_WIDTH, "evaluations": int(found.nfev)}
        )
    return rows


def main() -> None:
    """Make every table and picture."""
    coarse, folder = study_arguments(__doc__ or "")
    count, tolerance = (3, 1e-1) if coarse else (21, 5e-3)
    figure_4(coarse, folder)
    for name, rows in (
        ("switches", switches(tolerance)),
        ("figure_6", figure_6(count, tolerance, folder)),
        ("figure_7", widths := figure_7(min(count, 11), tolerance, folder)),
        ("optimum_width", optimum_width(min(count, 6), tolerance, coarse)),
    ):
        print(f"{name}\n\n{write_rows(rows, folder / f'{name}.csv')}")
    print(shear_sentence(widths))
    print(measured_sensor(coarse, folder))


if __name__ == "__main__":
    main()
