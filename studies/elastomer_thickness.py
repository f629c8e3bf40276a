"""How thick should the silicone be, and which one, for a stated range of forces?

Each thickness of each silicone under the whole range of loads: ranges of both signals, resolution of one reading in
newtons at the worst load, crosstalk. Soft and thick layers move far: fine resolution, but shear that leaks into the
normal signal, and loads that the layer cannot carry. The Pareto front holds the designs that carry the range, have one
force for each reading, and that no other one beats in resolution of both forces and crosstalk; the recommended design
is the one of finest normal resolution among those whose crosstalk stays below the limit.

Resolution counts the converter's own noise only; the bench adds its own.

Run ``python studies/elastomer_thickness.py [--coarse] --output DIR``.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
from common.design import best_designs, design_row, serves
from common.outputs import study_arguments, write_rows

from sits_mech.batch.executors import workers
from sits_mech.cases import DONE, sweep
from sits_mech.report.pictures.curves import new_figure, save_figure
from sits_mech.scene.sensor import load_sensor

SENSOR = "biorob2018-w15"
THICKNESSES = [1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0]  # [mm]
SILICONES = ["ecoflex-00-30", "ecoflex-00-50", "dragon-skin-10"]
SHEAR, NORMAL = 1.0, 4.0  # the stated range: -SHEAR to SHEAR, 0 to NORMAL [N]
CROSSTALK = 50.0  # of a signal's full scale, that the design may have before it is unmixed [%]
FIGURES = ("resolution_z", "resolution_x", "crosstalk_v", "crosstalk_h")


def design(silicone: str, thickness: float, count: int, tolerance: float) -> dict[str, Any]:
    """Return the figures of one design; thickness in millimetres."""
    sensor = load_sensor(SENSOR, [f'elastomer.material="{silicone}"', f'elastomer.thickness="{thickness} mm"'])
    loads = {"F_x": np.linspace(-SHEAR, SHEAR, count).tolist(), "F_z": np.linspace(0.0, NORMAL, count).tolist()}
    return design_row(sensor, **loads, tolerance=tolerance)


def draw(rows: list[dict[str, Any]], front: list[dict[str, Any]], path: Path) -> None:
    """Draw the figures against the thickness; filled marks are on the Pareto front."""
    with new_figure(height=1.0, columns=2, rows=2) as (figure, axes):
        for number, silicone in enumerate(SILICONES):
            own = [row for row in rows if row["silicone"] == silicone and serves(row)]
            for spot, name in zip(axes, FIGURES, strict=True):
                best = [row for row in front if row["silicone"] == silicone]
                x, y = ([[row[key] for row in part] for part in (own, best)] for key in ("thickness", name))
                spot.plot(x[0], y[0], f"C{number}o-", mfc="w", label=silicone)
                spot.plot(x[1], y[1], f"C{number}o")
        labels = ("$F_z$ resolution [N]", "$F_x$ resolution [N]", "$F_x$ in $L_v$ [%]", "$F_z$ in $L_h$ [%]")
        for spot, label in zip(axes, labels, strict=True):
            spot.set(xlabel="thickness [mm]", ylabel=label, yscale="log" if "[N]" in label else "linear")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(SILICONES))
        save_figure(figure, path)


def main() -> None:
    """Sweep the designs, find the front, recommend one."""
    coarse, folder = study_arguments(__doc__ or "")
    grid: dict[str, list[Any]] = {"silicone": SILICONES, "thickness": THICKNESSES}
    if coarse:
        grid = {"silicone": SILICONES[:1], "thickness": THICKNESSES[2:8:5]}
    settings = {"count": [3 if coarse else 9], "tolerance": [0.05 if coarse else 1e-2]}
    began = time.perf_counter()
    with workers(2) as executor:
        data = sweep(design, grid | settings, executor=executor).isel(count=0, tolerance=0, drop=True)
    seconds = time.perf_counter() - began
    rows = []
    for silicone in grid["silicone"]:
        for thickness in grid["thickness"]:
            point = data.sel(silicone=silicone, thickness=thickness)
            row = {name: float(item) for name, item in point.data_vars.items() if item.dtype.kind == "f"}
            row |= {"silicone": silicone, "thickness": thickness, "status": str(point["status"].item())}
            rows.append({"silicone": silicone, "thickness": thickness} | row)
    front = best_designs([row for row in rows if row["status"] == DONE], FIGURES)
    fit = [row for row in front if max(row["crosstalk_v"], row["crosstalk_h"]) <= CROSSTALK]
    draw(rows, front, folder / "elastomer_thickness.png")
    print(write_rows(rows, folder / "elastomer_thickness.csv"))
    print(f"Pareto front: {', '.join('{silicone} {thickness:g} mm'.format(**row) for row in front) or 'none'}")
    chosen = "none within the crosstalk limit" if not fit else "{silicone} {thickness:g} mm".format(**fit[0])
    print(f"recommended for +-{SHEAR:g} N shear and {NORMAL:g} N normal force: {chosen}")
    print(f"{len(rows)} designs, {settings['count'][0] ** 2} loads each, two processes: {seconds:.1f} s")


if __name__ == "__main__":
    main()
