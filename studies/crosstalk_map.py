"""How much does each force leak into the other's signal, over the whole range, and how much is left after the inverse?

For each catalogued sensor: crosstalk of both signals over the range of forces (the response to the other force, of the
signal's own full scale), what the target's rotation alone is mistaken for, and the force that is left wrong when the
readings of a coarse table's inverse are compared with loads that the table does not hold.

Run ``python studies/crosstalk_map.py [--coarse] --output DIR``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from common.outputs import study_arguments, write_rows

from sits_mech.analysis.readings.bench import sensor_calibration
from sits_mech.chain.calibrate import calibrate
from sits_mech.readout.crosstalk import crosstalk, rotation_error
from sits_mech.report.pictures.style import save_figure
from sits_mech.report.plots.curves import crosstalk_map
from sits_mech.scene.sensor import Sensor, load_sensor
from sits_mech.status import ANSWERED

SENSORS = ("biorob2018", "biorob2018-w15", "biorob2018-w22")
SHEAR, NORMAL = 1.0, 4.0  # [N]


def left_over(sensor: Sensor, data: xr.Dataset) -> tuple[float, float]:
    """Return the largest error of each force [N] at every second load, by the inverse of the other loads' table."""
    cal = sensor_calibration(sensor, data.isel(F_x=slice(0, None, 2), F_z=slice(0, None, 2)))
    F_x, F_z = data["F_x"].to_numpy()[1::2], data["F_z"].to_numpy()[1::2]
    full = sensor_calibration(sensor, data)
    loads = np.stack(np.meshgrid(F_x, F_z, indexing="ij"), -1)
    found = cal.inverse(full.forward(loads)).forces
    worst = np.nanmax(np.abs(found - loads), axis=(0, 1)) if np.isfinite(found).any() else np.full(2, np.nan)
    return float(worst[0]), float(worst[1])


def main() -> None:
    """Map every sensor."""
    coarse, folder = study_arguments(__doc__ or "")
    count, tolerance = (5, 0.05) if coarse else (9, 1e-2)
    models = dict.fromkeys(("mechanics", "magnetics"), "planar" if coarse else "auto")
    rows = []
    for name in SENSORS[:1] if coarse else SENSORS:
        sensor = load_sensor(name)
        F_x, F_z = np.linspace(-SHEAR, SHEAR, count).tolist(), np.linspace(0.0, NORMAL, count).tolist()
        data = calibrate(sensor, F_x=F_x, F_z=F_z, tolerance=tolerance, **models)
        save_figure(crosstalk_map(data), folder / f"crosstalk_{name}.png")
        stray, turned = crosstalk(data).attrs, rotation_error(data)
        wrong = left_over(sensor, data)
        row: dict[str, Any] = {"sensor": name, "failed loads": int((~data["status"].isin(ANSWERED)).sum())}
        row |= {"F_x into L_v [% of full scale]": stray["largest_L_v_from_F_x"]}
        row |= {"F_z into L_h [% of full scale]": stray["largest_L_h_from_F_z"]}
        row |= {"rotation reads as F_x [N]": float(np.nanmax(np.abs(turned["F_x_error"])))}
        row |= {"left after the inverse, F_x [N]": wrong[0], "left after the inverse, F_z [N]": wrong[1]}
        rows.append(row)
    print(write_rows(rows, folder / "crosstalk_map.csv"))


if __name__ == "__main__":
    main()
