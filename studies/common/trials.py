"""How good is a recommended sensor? Designs of a grid, designs at random, and sensors that are made, each solved.

What is recommended is held against what the same chain says of other designs, all by the figures and limits of its own
task; and its yield against sensors whose tolerances are drawn and whose tables are solved anew, each tared at rest and
scaled at one known load of each component, as the figures are.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.stats import qmc

from sits_mech.analysis.readings.bench import table_inductances
from sits_mech.chain.calibrate import calibrate
from sits_mech.quantities import Array, SolveFailed
from sits_mech.scene.parameters import parameter
from sits_mech.scene.sensor import Sensor
from sits_mech.status import ANSWERED, OK
from sits_mech.store import case_path, finish, read_case
from sits_mech.synthesis.required.space import Design, Space
from sits_mech.synthesis.search import Search
from sits_mech.synthesis.solved.answered import Answered, Task
from sits_mech.synthesis.solved.figures import Table
from sits_mech.synthesis.solved.solve import Solver
from sits_mech.version import __version__


def grid_designs(space: Space, most: int) -> list[Design]:
    """Return the designs of the finest grid, ends among them, that has no more than so many."""
    v = len(space.variables)
    count = max(2, int((most / len(space.choices)) ** (1.0 / v) + 1e-9)) if v else 1
    places = itertools.product(np.linspace(0.0, 1.0, count).tolist(), repeat=v)
    return [Design(choice, x) for x in places for choice in space.choices][:most]


def random_designs(space: Space, count: int, seed: int) -> list[Design]:
    """Return designs of Sobol's scrambled points in the box, and a choice of each list by the same points."""
    v, lists = len(space.variables), list(space.lists.values())
    unit = qmc.Sobol(v + len(lists), rng=np.random.default_rng(seed)).random_base2(int(np.ceil(np.log2(count))))
    return [
        Design(tuple(int(x * len(each)) for x, each in zip(row[v:], lists, strict=True)), tuple(row[:v].tolist()))
        for row in unit[:count]
    ]


@dataclass(frozen=True)
class Best:
    """The best of some designs: how many were solved, and what it comes to; merit infinite where none was answered."""

    count: int
    merit: float
    words: str


def merit_of(task: Task, found: Answered) -> float:
    """Return what is minimised, exceeded limits added, as the search weighs them."""
    return Search(task, (), 0, lambda _: found, lambda *_: None).merit(found)


def best_of(solver: Solver, task: Task, designs: Iterable[Design]) -> Best:
    """Solve designs and return the best one."""
    count, least, words = 0, np.inf, "none"
    for each in designs:
        found, count = solver(each), count + 1
        merit = merit_of(task, found)
        if merit < least:
            least, words = merit, solver.requirements.space.words(each)
    return Best(count, least, words)


def made(sensor: Sensor, names: Sequence[str], amounts: Array) -> Sensor:
    """Return a sensor whose numbers are off by some amounts."""
    for name, amount in zip(names, amounts, strict=True):
        sensor = parameter(sensor, name).changed(float(amount))
    return sensor


def shares_made(solver: Solver, task: Task, best: Answered, count: int, seed: int) -> tuple[float, float]:
    """Return the shares of drawn sensors that hold their limits: solved anew, and by the design's derivatives.

    Parameters
    ----------
    solver : Solver
        Whose tolerance sensors are solved at, and whose folder keeps them.
    task : Task
    best : Answered
        With a table.
    count, seed : int
        Sensors, and of their draw.
    """
    asked = solver.requirements
    if best.table is None or not solver.scattering:
        return np.nan, np.nan
    names, deviations = tuple(solver.scattering), np.array(list(solver.scattering.values()))
    drawn = np.random.default_rng(seed).normal(size=(count, len(names))) * deviations
    sensor = asked.space.sensor(best.design)
    nominal = _inductances(solver, best.design, np.zeros(len(names)), sensor)
    held = []
    for amounts in drawn:
        L = _inductances(solver, best.design, amounts, sensor)
        if L is None or nominal is None:
            held.append(False)
            continue
        off = Table(nominal, (L - nominal)[None], best.table.noise)
        held.append(bool(replace(task.judge, deviations=np.ones(1), drawn=np.ones((1, 1))).excess(off)[0] <= 0.0))
    predicted = replace(task.judge, drawn=drawn).excess(best.table) <= 0.0
    return float(np.mean(held)), float(np.mean(predicted))


def _inductances(solver: Solver, design: Design, amounts: Array, sensor: Sensor) -> Array | None:
    """Inductances (g, n) of one sensor that is made, kept; None where a load fails."""
    asked = solver.requirements
    key = f"{__version__} {solver.tolerance} {asked.identity} made"
    point = {"choice": list(design.choice), "x": list(design.x), "amounts": amounts.tolist()}
    path = case_path(solver.folder, key, point)
    row = read_case(path)
    if row is None:
        other = made(sensor, tuple(solver.scattering), amounts)
        row = finish(path, {"status": OK, "lasting": True, "table": _solved(solver, other)})
    return np.array(row["table"]) if row["table"] else None


def _solved(solver: Solver, sensor: Sensor) -> list[Any]:
    """The table of a sensor over the loads; empty where one fails."""
    loads = solver.operator.loads
    axes: dict[str, Any] = {name: axis.tolist() for name, axis in zip(loads.names, loads.axes, strict=True)}
    try:
        data = calibrate(sensor, **axes, tolerance=solver.tolerance)
    except SolveFailed:
        return []
    if not bool(data["status"].isin(ANSWERED).all()):
        return []
    L = table_inductances(sensor, data)["L"]
    own = L.squeeze(sorted({*L.dims} - {*loads.names, "coil"})).transpose(*loads.names, "coil").to_numpy()
    return list(own.reshape(-1, len(sensor.coils)).tolist())
