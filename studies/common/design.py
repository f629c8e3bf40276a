"""What is a sensor worth over a range of forces? A few figures of its table.

Resolution is what one reading's noise of the scene's converter is worth in newtons, at the worst load of the range
(one standard deviation, the forces solved together from all coils); crosstalk is the largest response of a signal to
the other force, of the signal's own full scale.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from sits_mech.analysis.readings.bench import sensor_calibration, sensor_front_end
from sits_mech.readout.crosstalk import crosstalk
from sits_mech.scene.sensor import Sensor
from sits_mech.status import ANSWERED

Row = dict[str, Any]
_FIGURES = (
    "L_v_range", "L_h_range", "crosstalk_v", "crosstalk_h", "resolution_x", "resolution_z", "unique", "error",
)


def table_row(sensor: Sensor, data: xr.Dataset) -> Row:
    """Return the figures of a sensor over a range of forces; what cannot be told is NaN.

    Parameters
    ----------
    sensor : Sensor
        With target, elastomer and converter.
    data : Dataset
        As from `calibrate`, over F_x and F_z.

    Returns
    -------
    dict
        ``L_v_range``, ``L_h_range`` [% of L0], ``crosstalk_v``, ``crosstalk_h`` [% of full scale], ``resolution_x``,
        ``resolution_z`` [N], ``unique`` (share of the range with one inverse), ``failed_loads``, ``least_gap`` [m],
        ``min_J``, ``error`` (largest of a signal, of full scale), ``seconds``.
    """
    good = data["status"].isin(ANSWERED).to_numpy()
    row: Row = dict.fromkeys(_FIGURES, np.nan)
    row |= {"failed_loads": int(np.sum(~good)), "seconds": float(data["seconds"].sum())}
    row |= {"least_gap": float(data["d_v"].min()), "min_J": float(data["min_J"].min())}
    if not good.all():
        return row
    stray = crosstalk(data).attrs
    row |= {"L_v_range": _span(data["L_v_percent"]), "L_h_range": _span(data["L_h_percent"])}
    row |= {"crosstalk_v": stray["largest_L_v_from_F_x"], "crosstalk_h": stray["largest_L_h_from_F_z"]}
    spans = [(float(data[f"error_{name}_percent"].max()), row[f"{name}_range"]) for name in ("L_v", "L_h")]
    row["error"] = max(error / span for error, span in spans if span > 0.0)
    cal = sensor_calibration(sensor, data)
    loads = np.stack(np.meshgrid(data["F_x"], data["F_z"], indexing="ij"), -1)
    noise = sensor_front_end(sensor, data)[0].noise
    resolution = cal.force_noise(loads, noise)
    row |= {"resolution_x": float(resolution[..., 0].max()), "resolution_z": float(resolution[..., 1].max())}
    row["unique"] = float(np.mean(cal.inverse(cal.forward(loads)).status == "ok"))
    return row


def _span(values: xr.DataArray) -> float:
    """Return how far values range."""
    return float(values.max() - values.min())
