"""What does a full force calibration give, by which models, and at which price?

The catalogued sensor over its range of forces: table with errors, ranges, resolution, crosstalk, and how many of its
loads stand between solved ones; and, for what the choice of the mechanical model is worth, the same by the layer in
plane strain and by the 3D pad.

Run ``python studies/force_calibration.py [--coarse] --output DIR``.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from common.design import table_row
from common.outputs import study_arguments, write_rows

from sits_mech.chain.calibrate import calibrate
from sits_mech.notes import Note, NoteKind, unpacked
from sits_mech.report.pictures.style import save_figure
from sits_mech.report.plots.curves import calibration_pictures
from sits_mech.scene.sensor import load_sensor

SENSOR = "biorob2018-w15"
SHEAR, NORMAL = 1.0, 4.0  # [N]
MECHANICS = ("planar", "block")


def main() -> None:
    """Calibrate by each model."""
    coarse, folder = study_arguments(__doc__ or "", timed=True)
    count, tolerance = (3, 0.05) if coarse else (9, 1e-2)
    F_x, F_z = np.linspace(-SHEAR, SHEAR, count).tolist(), np.linspace(0.0, NORMAL, count).tolist()
    sensor, rows = load_sensor(SENSOR), []
    for mechanics in MECHANICS[:1] if coarse else MECHANICS:
        began = time.perf_counter()
        data = calibrate(sensor, F_x=F_x, F_z=F_z, tolerance=tolerance, mechanics=mechanics)
        row: dict[str, Any] = {"mechanics": mechanics, "loads": data["status"].size}
        notes = map(unpacked, data["notes"].to_numpy().ravel())
        row["between solved ones"] = sum(Note(NoteKind.INTERPOLATED) in each for each in notes)
        row["wall [s]"] = time.perf_counter() - began
        rows.append(row | table_row(sensor, data))
        for name, draw in calibration_pictures(data).items():
            save_figure(draw(), folder / f"{mechanics}_{name}.png")
    names = list(dict.fromkeys(name for row in rows for name in row))
    print(write_rows([{name: row.get(name, "") for name in names} for row in rows], folder / "force_calibration.csv"))


if __name__ == "__main__":
    main()
