"""Read a calibration: each coil's inductance in henry, and the codes of the scene's converter.

The inductances are the table's own (`bench.own_inductances`), each coil driven alone; the codes are of what the coils
show at the end of their leads (`bench.terminals`), resonating with the readout's capacitance.
"""

from __future__ import annotations

from dataclasses import dataclass

import xarray as xr

from sits_mech.analysis.bench import codes_of, own_inductances, sensor_front_end, terminals
from sits_mech.quantities import Array
from sits_mech.readout.front_end import FrontEnd
from sits_mech.scene.sensor import Sensor


@dataclass(frozen=True)
class Readings:
    """Readings at each load of a table, in the order of `varied`; NaN where a load has no result."""

    L: Array  # (*sizes, n) [H]
    error_L: Array  # estimated [H]
    L0: Array  # (n,), without target [H]
    front: FrontEnd | None  # settings of the converter; None without one that fits
    codes: Array | None  # (*sizes, n), not rounded
    left_out: tuple[str, ...]  # what the codes leave out, or why there are none


def readings(sensor: Sensor, data: xr.Dataset) -> Readings:
    """Return inductances and codes over a calibration."""
    own = own_inductances(sensor, data)
    L, error, L0 = (own[name].to_numpy() for name in ("L", "error_L", "L0"))
    if sensor.readout.converter == "none":
        return Readings(L, error, L0, None, None, ("the scene has no converter",))
    try:
        front, missing = sensor_front_end(sensor, data)
    except ValueError as reason:
        return Readings(L, error, L0, None, None, (str(reason),))
    seen = terminals(sensor, data)[0]["L"].to_numpy()
    return Readings(L, error, L0, front, codes_of(sensor, front, seen), missing)
