"""Is an answer that says `ok` right? Random scenes and loads, solved again at a third of the tolerance.

Five hundred: those of `random_scenes` under loads, whatever their kind, and those of `promises` by turns. Each is
answered by `simulate` at the default tolerance. Where the status is `ok` a finer answer judges it. With s_i(pose) -
s_i(rest) the change of a signal and S the largest of them, the full scale that the status is of (chain/plans/goal.py),

    difference    max_i |change_i - change_i of the finer answer|/S;
    wrong         an `ok` whose difference is above the tolerance and the finer answer's own error together, or whose
                  finer answer is beyond data, not carried or failed; one that takes too long judges nothing;
    over bars     difference of each told figure, over the errors that both answers state.

Run ``python -m benchmarks.statuses [--coarse] --output DIR``: one row a scene is kept in DIR as it is done, and a
stopped run goes on; then `statuses.csv` and the counts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from benchmarks.promises import drawn
from benchmarks.random_scenes import draw
from common.children import asked_apart
from common.outputs import kept_rows, study_arguments, write_rows
from threadpoolctl import threadpool_limits

from sits_mech.chain.models import loaded_model
from sits_mech.chain.plans.aimed import aim_at
from sits_mech.chain.plans.goal import goal_at, goal_rows
from sits_mech.chain.propagation import poses_of
from sits_mech.chain.simulate import Simulation, simulate
from sits_mech.geometry.collision import Collision
from sits_mech.quantities import Array, MagneticModel, Pose, SolveFailed, Wrench
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.status import ABOVE, ANSWERED, FAILED, OK, WORDS

TOLERANCE, FINER = 1e-2, 3.0  # the default, and over that of the finer answer
COUNT, COARSE = 500, (0, 25)
SECONDS, MEMORY = 60.0, 6.0  # of a solve: processor time, GiB
LATE = "no answer in time"
ROUNDING = 1e-9  # of a figure
Row = dict[str, Any]


def scene(number: int) -> tuple[str, Sensor, Wrench]:
    """Return what a scene is called, the scene, and its load."""
    if number % 2:
        name, keys, sensor, load, _ = drawn(np.random.default_rng([32, number]))
        return " ".join([name, *keys]), sensor, load
    kind, sensor, _, some = draw(number // 2, loaded=True)
    assert some is not None
    return kind, sensor, some


def answered(sensor: Sensor, load: Wrench, tolerance: float) -> Row:
    """Return status, error over the full scale, changes of the signals, and told figures with their errors."""
    try:
        found = simulate(sensor, load, tolerance=tolerance)
    except (SolveFailed, SceneError, Collision) as reason:
        return {"status": reason.status if isinstance(reason, SolveFailed) else FAILED, "why": str(reason)}
    field, error = judged(sensor, load, tolerance, found)
    layer, pose = sensor.elastomer, found.equilibrium.pose
    assert layer is not None
    both = field.impedance(Pose.of(np.array([pose.components, [0, layer.standoff + layer.thickness, 0, 0, 0, 0]])),
                           sensor.frequency)
    L = np.diagonal(both.L, axis1=1, axis2=2)
    changes = goal_rows(sensor) @ (L[0] - L[1]) / np.mean(np.diag(both.L0))
    stretch = found.equilibrium.report.stretch
    return {"status": found.status, "error": error, "stretch": stretch, "changes": changes, "told": figures(found)}


def judged(sensor: Sensor, load: Wrench, tolerance: float, found: Simulation) -> tuple[MagneticModel, float]:
    """Return the magnetic model of an answer, and the error that its status is judged by."""
    rest = found.equilibrium
    if found.promise is not None and (aim := aim_at(sensor, "auto", tolerance, [load], [rest.pose])) is not None:
        return aim.field, found.promise.error
    field = loaded_model(sensor, "auto", tolerance, [load])[0]
    goal = goal_at(sensor, field, [rest.pose])
    return field, 0.0 if goal is None else goal.of(poses_of([rest]))


def figures(found: Simulation) -> dict[str, tuple[Array, Array]]:
    """Return what an answer tells, with its errors."""
    rest, known = found.equilibrium, found.signals.known
    shown = {name: (getattr(rest.pose, name), getattr(rest.error, name)) for name in ("d_v", "d_h", "alpha")}
    shown |= {name: (getattr(found.impedance, name), getattr(found.impedance, f"error_{name}")) for name in ("L", "R")}
    shown |= {name: (known[name], known[f"error_{name}"]) for name in known if f"error_{name}" in known}
    return {name: (np.asarray(value), np.asarray(error)) for name, (value, error) in shown.items()}


def over_bars(one: tuple[Array, Array], other: tuple[Array, Array]) -> float:
    """Return how far two values of a figure are from each other, over both errors."""
    off = np.abs(one[0] - other[0])
    bars = one[1] + other[1] + ROUNDING * np.max(np.abs(other[0]), initial=0.0)
    return float(np.max(off[off > 0.0] / bars[off > 0.0], initial=0.0))


def measure(number: int) -> Row:
    """Return the row of a scene."""
    name, sensor, load = scene(number)
    row: Row = {"scene": number, "name": name, "F_x": load.F_x, "F_z": load.F_z, "M": load.M}
    first, row["seconds"] = apart(sensor, load, TOLERANCE)
    row |= {"status": first["status"], "why": first.get("why", "")}
    row |= {name: first.get(name, np.nan) for name in ("error", "stretch")}
    if first["status"] != OK:
        return row
    finer, row["seconds of finer"] = apart(sensor, load, TOLERANCE / FINER)
    return row | compared(first, finer)


def apart(sensor: Sensor, load: Wrench, tolerance: float) -> tuple[Row, float]:
    """Return what is answered in a process of its own, with limits, and its seconds of processor time."""
    ended = asked_apart(lambda: answered(sensor, load, tolerance), seconds=SECONDS, gib=MEMORY)
    return ended.value or {"status": LATE if ended.killed.startswith("more than") else ended.killed}, ended.seconds


def compared(first: Mapping[str, Any], finer: Mapping[str, Any]) -> Row:
    """Return what a finer answer says of one that is `ok`."""
    row: Row = {"finer": finer["status"], "why": finer.get("why", ""), "wrong": False}
    if finer["status"] not in ANSWERED:
        return row | {"wrong": finer["status"] != LATE}
    size = float(np.max(np.abs(finer["changes"])))
    off = float(np.max(np.abs(first["changes"] - finer["changes"]))) / size if size > 0.0 else 0.0
    row |= {"finer's error": finer["error"], "finer's stretch": finer["stretch"], "difference": off}
    row |= {f"{name} over bars": over_bars(first["told"][name], own) for name, own in finer["told"].items()}
    return row | {"wrong": finer["status"] not in (OK, ABOVE) or off > TOLERANCE + finer["error"]}


def summary(rows: Sequence[Row]) -> str:
    """Return how many answers have each status, and how many of those that are `ok` are wrong."""
    statuses = [row["status"] for row in rows]
    counts = ", ".join(f"{statuses.count(word)} {word}" for word in dict.fromkeys((*WORDS, *statuses)))
    late = sum(row.get("finer") == LATE for row in rows)
    wrong = [row["scene"] for row in rows if row.get("wrong")]
    numbers = f" (scenes {', '.join(map(str, wrong))})" if wrong else ""
    return f"{len(rows)} scenes: {counts}; {late} ok not judged in time, {len(wrong)} wrong{numbers}"


def main() -> None:
    """Go through the scenes; write rows and counts."""
    coarse, folder = study_arguments(__doc__ or "", timed=True)
    with threadpool_limits(limits=1):
        rows = kept_rows(COARSE if coarse else range(COUNT), measure, folder)
    write_rows(rows, folder / "statuses.csv")
    print(summary(rows))


if __name__ == "__main__":
    main()
