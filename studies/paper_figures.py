"""The published figures again: does a model give what was printed, and which of its unstated choices matter?

D. Jones, J. Kow, A. Alazmani, P. Culmer, Computational Design Tools for Soft Inductive Tactile Sensors, BioRob 2018
(doi:10.1109/BIOROB.2018.8487666) moves a rigid copper plate over two coils. Figure 6 a-c: inductance of each coil
against d_v, d_h and alpha; d, e: their sum against d_v and difference against d_h; f: the shear that a rotation reads
as. Figure 7: sum and difference over d_h and d_v for targets 8, 15 and 22 mm wide. All in percent of the free-space L0.

The planar answer hangs on three choices that the text leaves open or gives otherwise than its numbers: whether both
coils are driven together (their mutual inductance then counts), whether the plate's net current is free to return at
the boundary, and the frequency (5 kHz in the text; the changes printed appear at 5 MHz only). All eight combinations
are tabulated. The 3D model has none of the first two choices and compares with the measured points.

What the width study's ranges span is not said. Taken as the difference over d_h from -5 to 5 mm at 2 mm, and the sum
from free space to 1 mm, each coil driven alone and no net current, the planar model comes near most of them.

Run ``python studies/paper_figures.py [--coarse] --output DIR``.
"""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
from common.outputs import study_arguments, write_rows
from scipy.optimize import minimize_scalar

from sits_mech.chain.models import magnetic_model
from sits_mech.quantities import Array, Pose
from sits_mech.report.pictures.curves import new_figure, save_figure
from sits_mech.scene.sensor import Sensor, load_sensor

MM, DEGREE = 1e-3, np.pi / 180.0
# d_v [mm], alpha [deg]: L1, L2 [% of L0], as printed
MEASURED = {(1, 0): (90.1, 92.0), (2, 0): (97.8, 97.2), (5, 0): (99.7, 99.8), (2, 20): (99.5, 92.8)}
SIMULATED = {(1, 0): (93.8, 93.8), (2, 0): (97.7, 97.7), (5, 0): (98.9, 98.9), (2, 20): (99.3, 96.2)}
RANGES = {8: (29.6, 24.2), 15: (31.4, 71.0), 22: (12.8, 69.1)}  # width [mm]: shear, normal range [%], as printed


def scene(width: float, net_current: str = "zero") -> Sensor:
    """Return the published sensor with a target of another width [m]; the layer is as wide as it must be."""
    changes = [f"target.width={width}", "elastomer.width=0.03"]
    if net_current == "free":
        changes += ['target.net_current="free"', 'target.planar_boundary_radius="100 mm"']
    return load_sensor("biorob2018", changes)


def percent(
    sensor: Sensor, pose: Pose, *, model: str, drive: str = "one", frequency: float = 5e6, tolerance: float
) -> Array:
    """Return the coils' inductances at poses of shape (p,) as a percentage of L0, shape (p, 2).

    Driven together, a coil's inductance is what it links of both equal currents, with the target and without.
    """
    found = magnetic_model(sensor, model, tolerance)[0].impedance(pose, frequency)
    if drive == "both":
        return np.asarray(100.0 * found.L.sum(axis=-1) / found.L0.sum(axis=-1))
    return np.asarray(100.0 * np.diagonal(found.L, axis1=-2, axis2=-1) / np.diagonal(found.L0))


def poses(d_h: Array | float = 0.0, d_v: Array | float = 2.0, alpha: Array | float = 0.0) -> Pose:
    """Return poses [mm, deg] as one."""
    parts = np.broadcast_arrays(*(np.atleast_1d(np.asarray(part, float)) for part in (d_h, d_v, alpha)))
    return Pose(parts[0] * MM, parts[1] * MM, parts[2] * DEGREE)


def switches(tolerance: float) -> list[dict[str, object]]:
    """Return the printed points by each combination of the planar model's unstated choices, and by the 3D model."""
    rows: list[dict[str, object]] = [_row("printed simulation", SIMULATED), _row("measured", MEASURED)]
    spots = np.array([*SIMULATED], dtype=float)
    for drive, net, frequency in product(("one", "both"), ("zero", "free"), (5e3, 5e6)):
        found = percent(
            scene(8 * MM, net), poses(0.0, spots[:, 0], spots[:, 1]), model="planar", drive=drive, frequency=frequency,
            tolerance=tolerance,
        )  # fmt: skip
        name = f"planar, {drive} driven, net current {net}, {frequency / 1e3:g} kHz"
        rows.append(_row(name, dict(zip(SIMULATED, map(tuple, found), strict=True))))
    found = percent(scene(8 * MM), poses(0.0, spots[:, 0], spots[:, 1]), model="sheets", tolerance=tolerance)
    rows.append(_row("sheets (3D), 5000 kHz", dict(zip(SIMULATED, map(tuple, found), strict=True))))
    return rows


def _row(name: str, values: dict[tuple[int, int], tuple[float, ...]]) -> dict[str, object]:
    """Return one line: L1 at each d_v, both coils rotated, and the largest distance from the printed simulation."""
    row: dict[str, object] = {"model": name}
    for (d_v, alpha), (first, second) in values.items():
        place = f"d_v {d_v} mm" if alpha == 0 else f"{alpha} deg at {d_v} mm"
        row |= {f"{place}: L1 [%]": float(first)} | ({f"{place}: L2 [%]": float(second)} if alpha else {})
    away = max(abs(a - b) for key, pair in values.items() for a, b in zip(pair, SIMULATED[key], strict=True))
    return row | {"from printed simulation": float(away)}


def figure_6(count: int, tolerance: float, folder: Path) -> list[dict[str, object]]:
    """Draw figure 6, planar and 3D side by side, and return the shear that 20 degrees read as."""
    d_v, d_h, alpha = np.linspace(1, 5, count), np.linspace(0, 5, count), np.linspace(0, 20, count)
    rows = []
    for model, title in (("planar", "planar, each coil driven alone"), ("sheets", "3D")):
        sensor = scene(8 * MM)
        moved = [
            percent(sensor, place, model=model, tolerance=tolerance)
            for place in (poses(d_v=d_v), poses(d_h=d_h), poses(alpha=alpha))
        ]
        shear = (moved[1][:, 0] - moved[1][:, 1], moved[2][:, 0] - moved[2][:, 1])
        reads = np.interp(shear[1], shear[0], d_h) if shear[0][-1] > 0 else np.interp(-shear[1], -shear[0], d_h)
        rows.append({"model": title, "20 deg at 2 mm read as a shear of [mm]": float(reads[-1]), "printed": 0.5})
        with new_figure(height=1.25, columns=3, rows=2) as (figure, axes):
            for spot, along, values in zip(axes[:3], (d_v, d_h, alpha), moved, strict=True):
                spot.plot(along, values, label=["C1", "C2"])
            axes[3].plot(d_v, moved[0].sum(axis=1), "k")
            axes[4].plot(d_h, shear[0], "k")
            axes[5].plot(alpha, reads, "k")
            for (gap, angle), pair in MEASURED.items():
                spot = axes[2] if angle else axes[0]
                spot.plot([angle or gap] * 2, pair, "kx", ms=4)
            for (gap, angle), pair in SIMULATED.items():
                spot = axes[2] if angle else axes[0]
                spot.plot([angle or gap] * 2, pair, "r+", ms=4)
            axes[0].set(xlabel="$d_v$ [mm]", ylabel="$L/L_0$ [%]")
            axes[1].set(xlabel="$d_h$ [mm]")
            axes[2].set(xlabel="$\\alpha$ [deg]")
            axes[3].set(xlabel="$d_v$ [mm]", ylabel="$(L_1+L_2)/L_0$ [%]")
            axes[4].set(xlabel="$d_h$ [mm]", ylabel="$(L_1-L_2)/L_0$ [%]")
            axes[5].set(xlabel="$\\alpha$ [deg]", ylabel="reads as shear [mm]")
            figure.suptitle(f"{title}; x measured, + printed simulation", fontsize=7)
            axes[1].legend(loc="center right")
        save_figure(figure, folder / f"figure_6_{model}.png")
    return rows


def ranges(width: float, *, model: str, count: int, tolerance: float) -> tuple[float, float, Array]:
    """Return span of the difference, of the sum from free space, and figure 7's map of both coils [%]."""
    gaps = np.linspace(1.0, 5.0, count)
    d_h, d_v = (part.ravel() for part in np.meshgrid(np.linspace(0.0, 5.0, count), np.append(gaps, 2.0), indexing="ij"))
    found = percent(scene(width), poses(d_h, d_v), model=model, tolerance=tolerance).reshape(count, count + 1, 2)
    difference, total = found[:, -1, 0] - found[:, -1, 1], found[0, :-1].sum(axis=-1)
    return float(2.0 * np.max(np.abs(difference))), float(200.0 - np.min(total)), found[:, :-1]


def figure_7(count: int, tolerance: float, folder: Path) -> list[dict[str, object]]:
    """Draw figure 7 and return the ranges of the width study beside those printed."""
    rows = []
    for model in ("planar", "sheets"):
        with new_figure(height=0.8, columns=3, rows=2) as (figure, axes):
            for number, (width, printed) in enumerate(RANGES.items()):
                shear, normal, found = ranges(width * MM, model=model, count=count, tolerance=tolerance)
                rows.append(
                    {"model": model, "width [mm]": width, "shear range [%]": shear, "printed shear [%]": printed[0],
                     "normal range [%]": normal, "printed normal [%]": printed[1]}
                )  # fmt: skip
                for place, values in ((number, found[..., 0] - found[..., 1]), (number + 3, found.sum(axis=-1))):
                    picture = axes[place].pcolormesh(np.linspace(0, 5, count), np.linspace(1, 5, count), values.T)
                    figure.colorbar(picture, ax=axes[place]).ax.tick_params(labelsize=5)
                axes[number].set_title(f"{width} mm", fontsize=7)
                axes[number + 3].set(xlabel="$d_h$ [mm]")
            axes[0].set(ylabel="$L_h$ [%]; $d_v$ [mm]")
            axes[3].set(ylabel="$L_v$ [%]; $d_v$ [mm]")
        save_figure(figure, folder / f"figure_7_{model}.png")
    return rows


def optimum_width(count: int, tolerance: float, coarse: bool) -> list[dict[str, object]]:
    """Return the width of the largest product of both ranges, between 6 and 22 mm, for each model."""
    rows = []
    for model, accuracy in (("planar", 0.1), ("sheets", 0.25)):

        def cost(width: float, model: str = model) -> float:
            shear, normal, _ = ranges(width * MM, model=model, count=count, tolerance=tolerance)
            return -shear * normal

        options = {"xatol": accuracy, "maxiter": 3 if coarse else 30}
        found = minimize_scalar(cost, bounds=(6.0, 22.0), method="bounded", options=options)
        shear, normal, _ = ranges(found.x * MM, model=model, count=count, tolerance=tolerance)
        rows.append(
            {"model": model, "best width [mm]": float(found.x), "to": accuracy, "shear range [%]": shear,
             "normal range [%]": normal, "printed best [mm]": 15.0, "evaluations": int(found.nfev)}
        )  # fmt: skip
    return rows


def main() -> None:
    """Make every table and picture."""
    coarse, folder = study_arguments(__doc__ or "")
    count, tolerance = (5, 1e-2) if coarse else (21, 2e-3)
    for name, rows in (
        ("switches", switches(tolerance)),
        ("figure_6", figure_6(count, tolerance, folder)),
        ("figure_7", figure_7(count, tolerance, folder)),
        ("optimum_width", optimum_width(min(count, 6), tolerance, coarse)),
    ):
        print(f"{name}\n\n{write_rows(rows, folder / f'{name}.csv')}")


if __name__ == "__main__":
    main()
