"""Find a design's figures from a table that is there, without a solve."""

from __future__ import annotations

import numpy as np
import xarray as xr

from sits_mech.analysis.bench import table_inductances
from sits_mech.readout.loads import request_of, several, varied
from sits_mech.scene.sensor import Sensor
from sits_mech.synthesis.required.requirements import Requirements
from sits_mech.synthesis.required.space import Design, size_of
from sits_mech.synthesis.solved.answered import Answered, Task
from sits_mech.synthesis.solved.figures import Judge, Table
from sits_mech.synthesis.solved.loads import Loads, Operator
from sits_mech.synthesis.solved.solve import Solver, figure_errors


def at_a_glance(
    asked: Requirements, sensor: Sensor, data: xr.Dataset, like: Answered | None = None
) -> tuple[Task, Answered]:
    """Return what a table over any grid of loads tells of a sensor's figures, without tolerances and overload.

    The task is that of the limits, figures are of the table's loads. Noise and rate are those of a sensor that is
    `like` it, where one is given, and errors are left out. Raises ValueError where a load has no result.
    """
    loads = Loads(several(data), tuple(data[name].to_numpy() for name in several(data)))
    L = table_inductances(sensor, data)["L"].transpose(*varied(data), "coil").to_numpy().reshape(-1, len(sensor.coils))
    if not np.isfinite(L).all():
        raise ValueError("loads: every one must have a result for figures of merit")
    solver, none = Solver(asked, float(request_of(data)["tolerance"])), np.zeros((0, *L.shape))
    judge = Judge(Operator(loads), np.zeros(0), asked.limits, asked.least_yield)
    if like is None or like.table is None:
        own, repeated, rate = solver.converter(sensor, data)
        table = Table(L, none, np.hypot(own, repeated))
        known = figure_errors(sensor, data, judge, table)
    else:
        table, rate, known = Table(L, none, like.table.noise), like.plain["rate"], {}
    task = Task(judge, asked.limits, asked.goal)
    plain = size_of(sensor) | {"rate": rate}
    return task, Answered(Design((), ()), "", table, none, plain, {}, known)
