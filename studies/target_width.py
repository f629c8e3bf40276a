"""How wide should the target be over a pair of coils, when forces, not poses, are what it has to resolve?

The published study chose the width by moving the target by hand. Here the layer answers a range of forces: a wider
target is held by more silicone and moves less, but covers more of the coils. The best width is that of the least
product of the two resolutions (converter noise in newtons at the worst load), by bounded minimisation over the whole
chain; the curve beside it shows how sharp the optimum is.

Run ``python studies/target_width.py [--coarse] --output DIR``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from common.design import design_row, serves
from common.outputs import study_arguments, write_rows
from scipy.optimize import minimize_scalar

from sits_mech.report.pictures.curves import new_figure, save_figure
from sits_mech.scene.sensor import load_sensor

SENSOR, LAYER = "biorob2018", 'elastomer.width="30 mm"'
WIDTHS = (5.0, 22.0)  # [mm]
SHEAR, NORMAL = 1.0, 4.0  # [N]
ACCURACY = 0.25  # of the best width [mm]


def design(width: float, count: int, tolerance: float) -> dict[str, Any]:
    """Return the figures of a target's width [mm]."""
    sensor = load_sensor(SENSOR, [LAYER, f'target.width="{width} mm"'])
    loads = {"F_x": np.linspace(-SHEAR, SHEAR, count).tolist(), "F_z": np.linspace(0.0, NORMAL, count).tolist()}
    row = design_row(sensor, **loads, tolerance=tolerance)
    worth = np.log10(row["resolution_x"] * row["resolution_z"]) if serves(row) else np.inf
    return {"width": float(width)} | row | {"log10 of the product": float(worth)}


def main() -> None:
    """Scan the widths, find the best one, draw."""
    coarse, folder = study_arguments(__doc__ or "")
    count, tolerance = (3, 0.05) if coarse else (5, 1e-2)
    rows = [design(width, count, tolerance) for width in np.linspace(*WIDTHS, 3 if coarse else 10)]

    def cost(width: float) -> float:
        rows.append(design(width, count, tolerance))
        return float(min(rows[-1]["log10 of the product"], 0.0))

    good = [row for row in rows if np.isfinite(row["log10 of the product"])]
    middle = min(good, key=lambda row: row["log10 of the product"])["width"]
    around = (max(middle - 2.0, WIDTHS[0]), min(middle + 2.0, WIDTHS[1]))
    options = {"xatol": ACCURACY, "maxiter": 2 if coarse else 20}
    found = minimize_scalar(cost, bounds=around, method="bounded", options=options)
    rows.sort(key=lambda row: row["width"])
    with new_figure(height=0.45, columns=2) as (figure, axes):
        x = [row["width"] for row in rows]
        for name, label in (("resolution_x", "$F_x$"), ("resolution_z", "$F_z$")):
            axes[0].semilogy(x, [row[name] for row in rows], ".-", label=label)
        axes[0].set(xlabel="target width [mm]", ylabel="resolution [N]")
        for name, label in (("L_v_range", "$L_v$"), ("L_h_range", "$L_h$")):
            axes[1].plot(x, [row[name] for row in rows], ".-", label=label)
        axes[1].set(xlabel="target width [mm]", ylabel="range [% of $L_0$]")
        for spot in axes:
            spot.axvline(found.x, color="0.7", lw=0.8)
            spot.legend()
        save_figure(figure, folder / "target_width.png")
    print(write_rows(rows, folder / "target_width.csv"))
    print(f"best width: {found.x:.2f} mm (to {ACCURACY} mm), {len(rows)} designs of {count**2} loads")


if __name__ == "__main__":
    main()
