"""Convert a load history to codes: the scene's converter, set for the history, reads one coil after the other.

What each coil shows at the end of its leads (analysis/spectrum.py) is interpolated from solved times to all others
between the corners of the load (response.py, `between`), and through the converter in time (scan.py).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from sits_mech.analysis.bench import absolute, table_impedance
from sits_mech.analysis.histories.response import between
from sits_mech.analysis.histories.scan import scan
from sits_mech.analysis.spectrum import at_terminals
from sits_mech.labels import labelled
from sits_mech.quantities import WRENCH
from sits_mech.readout.converter import converter
from sits_mech.readout.front_end import front_end
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.scene.thermal import at_temperature, clock_factor

_FINE = 8  # times between two solved ones, of what the converter is given


def checked_count(sensor: Sensor, rcount: int | None) -> int:
    """Return a reference count of the scene's converter, by default its greatest; raise SceneError for a bad one."""
    if sensor.readout.converter == "none":
        if rcount is None:
            return 0
        raise SceneError(f'rcount: must be left out with readout.converter = "none"; got {rcount}')
    low, high = converter(sensor.readout.converter).rcount
    if rcount is not None and not low <= rcount <= high:
        raise SceneError(f"rcount: must be from {low} to {high} for the {sensor.readout.converter}; got {rcount}")
    return high if rcount is None else rcount


def with_codes(sensor: Sensor, data: xr.Dataset, *, rcount: int = 0xFFFF, seed: int | None = 0) -> xr.Dataset:
    """Return a history from `in_time` with the codes of the converter.

    Adds, by ``scan`` and coil, ``code``, ``code_time`` (the middle of its window), ``code_ready`` [s] and ``code_L`` at
    the terminals [H]; attributes ``window`` and ``period`` [s], ``rcount`` (longer conversions are quieter, and smear
    more). `seed` None: no noise. Without a converter that can follow, the history with the reason in its ``notes``.
    """
    try:
        return _scanned(sensor, data, rcount, seed)
    except ValueError as reason:
        notes = "; ".join(part for part in (data.attrs["notes"], f"no codes: {reason}") if part)
        return data.assign_attrs(notes=notes)


def _scanned(sensor: Sensor, data: xr.Dataset, rcount: int, seed: int | None) -> xr.Dataset:
    """Return the history with codes; raise ValueError where there are none."""
    if sensor.readout.converter == "none":
        raise ValueError("the scene has no converter")
    seen, reasons = at_terminals(sensor, absolute(sensor, table_impedance(data, ("time",)))[0])
    if seen is None:
        raise ValueError("; ".join(reasons))
    part, C = converter(sensor.readout.converter), at_temperature(sensor).readout.parallel_capacitance
    front = front_end(part, seen.L, seen.R, C, rcount=rcount)
    front = replace(front, reference=clock_factor(sensor) * front.reference)
    time, load = data["time"].to_numpy(), np.stack([data[name].to_numpy() for name in WRENCH], axis=1)
    every = np.interp(np.arange(_FINE * (len(time) - 1) + 1) / _FINE, np.arange(len(time)), time)
    found = scan(front, C, every, between(time, load, seen.L)(every), seed=seed)
    dims = ("scan", "coil")
    columns = {"code": found.code, "code_time": found.time, "code_ready": found.ready, "code_L": found.L}
    data = data.assign({name: (dims, values) for name, values in columns.items()})
    data = data.set_coords(["code_time", "code_ready"])
    return labelled(data.assign_attrs(window=found.window, period=found.period, rcount=rcount))
