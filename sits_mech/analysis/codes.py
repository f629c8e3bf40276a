"""What is read over a calibration? Each coil's inductance in henry, and the codes of the scene's converter.

The inductances are the table's own (`bench.own_inductances`), each coil driven alone; the codes are of what the coils
show at the end of their leads (`bench.terminals`), swinging with the readout's capacitance.
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
    """What is read at each load of a table, in the order of `varied`; NaN where a load has no result.

    Attributes
    ----------
    L, error_L : ndarray, shape (*sizes, n)
        Inductance of each coil and its estimated error [H].
    L0 : ndarray, shape (n,)
        Without target [H].
    front : FrontEnd or None
        Settings of the converter; None where the sensor has none, or none that fit it.
    codes : ndarray or None, shape (*sizes, n)
        What the converter gives, not rounded.
    left_out : tuple of str
        One line for each thing that the codes do not have, or why there are none.
    """

    L: Array
    error_L: Array
    L0: Array
    front: FrontEnd | None
    codes: Array | None
    left_out: tuple[str, ...]


def readings(sensor: Sensor, data: xr.Dataset) -> Readings:
    """Return what is read over a calibration.

    Parameters
    ----------
    sensor : Sensor
        With its readout.
    data : Dataset
        As from `calibrate`.
    """
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
