"""Go back from codes to inductances, and find how codes change with temperature, by what goes from L and R to codes.

Codes of another sensor than the calibrated one, or of one whose load is not known, do not say what R their tanks have:
it is taken as the table has it where all coils show the same inductances. Over the loads of `biorob2018-w15` R changes
by 0.3 %, and a change of R moves what is read for L by 2 R C times as much.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import xarray as xr

from sits_mech.analysis.readings.bench import codes_of, sensor_front_end, table_codes, terminals
from sits_mech.analysis.readings.measured import Tank
from sits_mech.chain.derivatives.temperature import changed_by, slopes_of
from sits_mech.maps.surrogate import fit_map
from sits_mech.quantities import Array
from sits_mech.readout.loads import several
from sits_mech.scene.sensor import Sensor
from sits_mech.scene.thermal import at_temperature, clock_factor


def code_slopes(sensor: Sensor, data: xr.Dataset) -> xr.DataArray:
    """Return the slopes of the codes by temperature, cause by cause, of L and R as read [1/K].

    Dims (*varied(data), thermal_cause, coil). Raises as `sensor_front_end`.
    """
    front, found = sensor_front_end(sensor, data)[0], []
    for cause in data["thermal_cause"]:
        by_one = [part.sel(thermal_cause=cause) for part in slopes_of(data)]
        less, more = (changed_by(data, [half * step for step in by_one]) for half in (-0.5, 0.5))
        found.append(table_codes(sensor, more, front) - table_codes(sensor, less, front))
    return xr.concat(found, data["thermal_cause"])


def resistance_by_inductance(sensor: Sensor, data: xr.Dataset) -> Callable[[Array], Array]:
    """Return R at the terminals as a table has it where the coils show L, (..., n) [H] to [ohm].

    A smooth map over the leading directions of L, as many as forces vary; beyond the table's readings it stays.
    """
    seen, n = terminals(sensor, data)[0], len(sensor.coils)
    L, R = (seen[name].to_numpy().reshape(-1, n) for name in ("L", "R"))
    good = np.isfinite(L).all(axis=1)
    middle, names = L[good].mean(axis=0), several(data)[:n]
    directions = np.linalg.svd(L[good] - middle)[2][: len(names)].T
    found = fit_map(names, (L[good] - middle) @ directions, R[good])
    return lambda L: found.at(np.clip((L - middle) @ directions, found.low, found.high))


def unit_codes(sensor: Sensor, data: xr.Dataset, L: Array) -> Array:
    """Return the unrounded codes of inductances at the terminals (..., n) [H] of a unit of a calibrated sensor."""
    return codes_of(sensor, sensor_front_end(sensor, data)[0], L, resistance_by_inductance(sensor, data)(L))


def tank_of(sensor: Sensor, data: xr.Dataset, clock: float | None = None) -> Tank | None:
    """Return how codes of the scene's converter, set for a table, become inductances; None where it has no settings.

    `clock` is external [Hz], by default the part's greatest.
    """
    try:
        front, _ = sensor_front_end(sensor, data, clock=clock)
    except ValueError:
        if clock is not None:
            raise
        return None
    C, reference = at_temperature(sensor).readout.parallel_capacitance, clock_factor(sensor) * front.reference
    R = resistance_by_inductance(sensor, data)
    return Tank(front.part, C, reference, front.input_divider, front.gain, front.offset, R)
