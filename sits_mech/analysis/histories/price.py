"""Price a history before it is solved: its rows, how many are solved at least, and in what time.

Times that are solved are those of `interpolant.foreseen`. Each takes what a load within reach takes from rest by counts
(`forecast_load`), of which there is one a time: the steps of a history are as short. All take the preparation of the
coils once. Of a pulse on `biorob2018` with rate and softening 19 times were solved, in 13 iterations each where 10 are
counted. Where interpolation turns out to be off more times follow.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sits_mech.analysis.histories.interpolant import foreseen
from sits_mech.chain.interpolate import BETWEEN
from sits_mech.chain.plans.plan import planned_seconds
from sits_mech.chain.plans.prices import forecast_load
from sits_mech.mechanics.histories import LoadHistory, expected_loads
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import Sensor


class HistoryPrice(NamedTuple):
    """What a history takes."""

    rows: int  # of the history
    solved: int  # times that are solved at least, some of them between rows
    seconds: float  # of processor time, by these


def peak_load(sensor: Sensor, history: LoadHistory) -> Wrench:
    """Return the largest load of a history, each component over its range; raises as `expected_loads`."""
    return expected_loads(sensor, history)[int(np.argmax(np.linalg.norm(history.shares, axis=1)))]


def history_price(
    sensor: Sensor, history: LoadHistory, *, tolerance: float = 1e-2, mechanics: str = "auto", magnetics: str = "auto"
) -> HistoryPrice:
    """Return what a history takes, by counts of its largest load; arguments as of `in_time`, none is solved."""
    largest = peak_load(sensor, history)
    seconds, counts = planned_seconds(sensor, [largest], tolerance=tolerance, mechanics=mechanics, magnetics=magnetics)
    (_, each), (_, coils) = seconds
    if history.held.any() or counts is not None:
        each = forecast_load(sensor, [Wrench()]).seconds
    solved = int(foreseen(history, BETWEEN * tolerance)[0].solved.sum())
    return HistoryPrice(len(history.time), solved, solved * each + coils)
