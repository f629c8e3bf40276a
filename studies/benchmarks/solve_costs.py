"""What does a solve cost? Counts and seconds of each model's rungs (`Description.rungs`), measured again.

Each model answers typical scenes at each tolerance of its table, from empty caches, then another load or pose with
what is prepared: processor seconds, the least of three runs, as others on a machine make them longer and never shorter;
of several scenes the geometric mean.

    once = first - another,    each = another.

Beside them a factorisation that every machine has, 1000 x 1000, tells how fast this one is: seconds of another machine
go with it. Run ``python -m benchmarks.solve_costs [--coarse] --output DIR``: the table beside the rungs in the package,
with the unknowns of the first scene, and `costs.txt`, whose rungs are to be pasted there.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from common.accuracy import forget
from common.outputs import study_arguments, write_rows
from scipy.linalg import lu_factor
from threadpoolctl import threadpool_limits

from sits_mech.chain.models import MAGNETICS, MECHANICS
from sits_mech.description import Description
from sits_mech.quantities import Pose, Wrench
from sits_mech.scene.files import write_text
from sits_mech.scene.sensor import Sensor, load_sensor
from sits_mech.store import Row

LONG = ("elastomer.length=0.5", "target.length=0.5")
DISC = (
    'target={material="copper", shape="disc", diameter="7 mm", thickness="0.2 mm"}',
    'coils=[{name="C", centre=["0 mm", "0 mm"], layers=2, turns=12, inner_diameter="2.2 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}]',
    'elastomer={material="ecoflex-00-30", diameter="8 mm", thickness="2 mm"}',
)
KNOWN: dict[tuple[str, str], Description] = {
    (half, name): model for half, known in (("mechanics", MECHANICS), ("magnetics", MAGNETICS))
    for name, model in known.items()
}
SCENES = {
    "block": ((), ("elastomer.thickness=0.003",)), "axisymmetric": (DISC,), "axisymmetric-fem": (DISC,),
    "planar-fem": ((),),
    "linear": (LONG,),
    "planar": (LONG, (*LONG, "elastomer.thickness=0.003")), "closed-form": ((*LONG, "elastomer.width=0.008"),),
}
LOADS = (Wrench(0.3, 1.0), Wrench(0.25, 1.2))
POSES = (Pose(0.2e-3, 1.9e-3, 0.02), Pose(-0.3e-3, 1.8e-3, -0.02))
ON_AXIS = (Pose(0.0, 1.9e-3), Pose(0.0, 1.8e-3))
RUNS = 3


def seconds(ask: Callable[[], Any]) -> float:
    """Return the processor time of a question."""
    began = time.process_time()
    ask()
    return time.process_time() - began


def solver(half: str, model: str, sensor: Sensor, tolerance: float) -> list[Callable[[], Any]]:
    """Return the first question of a model, which makes it, and another."""
    made: list[Any] = []
    if half == "mechanics":
        long = 25.0 if sensor.elastomer is not None and sensor.elastomer.extent[1] > 0.1 else 1.0
        along = 0.0 if model == "axisymmetric" else long
        loads = [Wrench(along * load.F_x, long * load.F_z) for load in LOADS]

        def first() -> Any:
            made.append(MECHANICS[model](sensor, tolerance))
            return made[0].equilibrium(loads[0])

        return [first, lambda: made[0].equilibrium(loads[1])]
    poses = ON_AXIS if model.startswith("axisymmetric") else POSES

    def shown() -> Any:
        made.append(MAGNETICS[model](sensor, tolerance))
        return made[0].impedance(poses[0], sensor.frequency)

    return [shown, lambda: made[0].impedance(poses[1], sensor.frequency)]


def measured(half: str, model: str, tolerance: float, runs: int) -> tuple[float, float, int]:
    """Return the seconds once and for each load or pose, of a rung, and the unknowns of the first scene."""
    found, unknowns = [], 0
    for overrides in SCENES.get(model, ((), ("target.width=0.015",))):
        sensor, pairs = load_sensor("biorob2018", list(overrides)), []
        for _ in range(runs):
            forget()
            asks = solver(half, model, sensor, tolerance)
            pairs.append([seconds(ask) for ask in asks])
            unknowns = unknowns or asks[1]().report.unknowns
        first, another = np.min(pairs, axis=0)
        found.append((max(first - another, 1e-6), max(another, 1e-6)))
    once, each = np.exp(np.mean(np.log(found), axis=0))
    return float(once), float(each), unknowns


def asked_at(half: str, model: str) -> list[float]:
    """Return the tolerances of a model's rungs; the finest is asked for a third of the one before, or 1e-2."""
    own = [rung.tolerance for rung in KNOWN[half, model].rungs]
    return [at or (own[-2] / 3.0 if len(own) > 1 else 1e-2) for at in own]


def table(coarse: bool) -> list[Row]:
    """Return each rung's seconds beside those in the package."""
    rows: list[Row] = []
    for (half, model), description in KNOWN.items():
        pairs = zip(description.rungs, asked_at(half, model), strict=True)
        for rung, asked in list(pairs)[: 1 if coarse else None]:
            own, more, unknowns = measured(half, model, asked, 1 if coarse else RUNS)
            rows.append({
                "half": half, "model": model, "from": rung.tolerance, "asked": asked, "once [s]": own, "each [s]": more,
                "unknowns": unknowns, "in the package": rung.unknowns,
                "told": rung.once + rung.each, "measured over told": (own + more) / (rung.once + rung.each),
            })
    return rows


def as_text(rows: list[Row]) -> str:
    """Return the table as it stands in the package, no rung cheaper than one before."""
    lines = []
    for name in dict.fromkeys((row["half"], row["model"]) for row in rows):
        own = [row for row in rows if (row["half"], row["model"]) == name]
        for before, after in pairwise(own):
            if after["once [s]"] < before["once [s]"]:
                after["each [s]"] = max(after["each [s]"], before["each [s]"])
        each = ((r["from"], r["unknowns"], r["once [s]"], r["each [s]"]) for r in own)
        rungs = ", ".join(f"({at:g}, {unknowns}, {once:.2g}, {more:.2g})" for at, unknowns, once, more in each)
        lines.append(f"    {name}: ({rungs},),".replace("'", '"'))
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measure all rungs, or with --coarse the first of each model once; write the table."""
    coarse, folder = study_arguments(__doc__ or "", timed=True)
    with threadpool_limits(limits=1):
        matrix = np.random.default_rng(0).normal(size=(1000, 1000))
        speed = min(seconds(lambda: lu_factor(matrix)) for _ in range(RUNS))
        rows = table(coarse)
    print(write_rows(rows, folder / "costs.csv"))
    write_text(folder / "costs.txt", f"# a factorisation of 1000 x 1000 in {speed:.3f} s\n{as_text(rows)}")


if __name__ == "__main__":
    main()
