"""Simulate a cycle with a memory at every point of the layer, and compare it with the cheap rung.

`cycle` takes the pad as a whole: one creep for all of its load, one softening by all of its energy, on 17 elastic
answers (silicone/history.py). Here the layer itself goes through the cycle, point by point (mechanics/histories.py),
and both are compared over time, in percent of what each quantity covers.
"""

from __future__ import annotations

import json

import numpy as np
import xarray as xr

from sits_mech.analysis.cycle import Programme, loop_widths
from sits_mech.analysis.histories.response import in_time
from sits_mech.cases import Progress, no_progress
from sits_mech.labels import labelled
from sits_mech.mechanics.histories import LoadHistory
from sits_mech.quantities import POSE, Wrench
from sits_mech.readout.loads import request_of
from sits_mech.readout.signals import changes, shown_signals
from sits_mech.scene.sensor import Sensor
from sits_mech.status import joined, marked


def full_cycle(
    sensor: Sensor, peak: Wrench, programme: Programme, *, tolerance: float = 1e-2, mechanics: str = "auto",
    magnetics: str = "auto", progress: Progress = no_progress,
) -> xr.Dataset:
    """Return pose, inductance and signals under a load cycle, by the memory of every point.

    As `load_cycle`, at the programme's times, without ``elastic_share``; errors as `in_time`.
    """
    data = in_time(
        sensor, LoadHistory(programme.time, programme.share[:, None] * peak.components), tolerance=tolerance,
        mechanics=mechanics, magnetics=magnetics, progress=progress, points=True,
    )
    full = data.isel(time=np.flatnonzero(data["given"].to_numpy())).assign(share=("time", programme.share))
    request = request_of(data) | {"peak": vars(peak)}
    full = full.drop_vars(["given", "status", "flags"]).assign_attrs(marked(joined(data["flags"].to_numpy())))
    full = full.assign_attrs(request=json.dumps(request))
    return labelled(
        full.assign_attrs({key: item for name in shown_signals(full) for key, item in loop_widths(full, name).items()})
    )


def difference(cheap: xr.Dataset, full: xr.Dataset) -> dict[str, float]:
    """Return the largest difference of `load_cycle` from `full_cycle` in percent of the latter's range, by quantity.

    What does not move is left out.
    """
    found = {}
    for name in (*POSE, *shown_signals(full)):
        own, other = full[name].to_numpy(), cheap[name].to_numpy()
        span, error = float(np.ptp(own)), full[f"error_{name}"].to_numpy()
        if changes(own, error) if name in shown_signals(full) else span > 2.0 * float(np.max(error)):
            found[name] = 100.0 * float(np.max(np.abs(own - other))) / span
    return found
