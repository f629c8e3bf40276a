"""Does a plan keep what it promises? Seconds and error that a first look tells, against what was taken and reached.

Sixty scenes and loads by chance: the sensors of the catalogue with pads of 1 to 4 mm and five silicones, targets and
pads of other sizes, loads whose small strain would be off by 3 to 60 %, at 1e-2 or 3e-3 of the signals' full scale.
Beside them tables of loads. Of each

    seconds, error    taken and reached over planned (`tolerance.promise`), within a factor of 2 on what share of them,
    by meshes         of the same loads, what a third mesh and all of them take and leave over the first two: medians
                      of these stand in `chain/plans/prices.py`.

Run ``python -m benchmarks.promises [--coarse] --output DIR``: `promises.csv`, `tables.csv` and the shares.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from common.accuracy import first_strain, forget
from common.outputs import study_arguments, write_rows
from threadpoolctl import threadpool_limits

from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.simulate import simulate
from sits_mech.geometry.collision import Collision
from sits_mech.mechanics.block import block_pad
from sits_mech.quantities import SolveFailed, Wrench
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor

MM = 1e-3
SCENES = ("biorob2018", "biorob2018-w15", "triaxial-4")
SILICONES = (
    "ecoflex-00-10", "ecoflex-00-30", "ecoflex-00-50", "ecoflex-00-30-neo-hookean", "ecoflex-00-10-neo-hookean",
)
COUNT, COARSE = 60, 1  # scenes; of coarse runs
Table = tuple[str, tuple[str, ...], dict[str, tuple[float, float, int]]]
TABLES: tuple[Table, ...] = (
    ("biorob2018-w15", (), {"F_x": (-1.0, 1.0, 9), "F_z": (0.0, 4.0, 9)}),
    ("biorob2018", (), {"F_x": (-1.0, 1.0, 9), "F_z": (0.0, 4.0, 9)}),
    ("biorob2018", (), {"F_x": (-0.4, 0.4, 5), "F_z": (0.0, 1.5, 5)}),
    ("biorob2018", ("elastomer.thickness=0.003",), {"F_x": (-0.5, 0.5, 5), "F_z": (0.0, 2.0, 5)}),
    ("biorob2018-w15", (), {"F_z": (0.0, 4.0, 9)}),
    ("biorob2018-w15", ("elastomer.thickness=0.001",), {"F_x": (-1.0, 1.0, 7), "F_z": (0.0, 6.0, 7)}),
    ("biorob2018-w15", (), {"F_z": (0.0, 3.0, 5), "M": (-3e-3, 3e-3, 5)}),
    ("triaxial-4", (), {"F_x": (-0.5, 0.5, 5), "F_y": (-0.5, 0.5, 5), "F_z": (0.0, 2.0, 5)}),
    ("triaxial-4", (), {"F_x": (-0.3, 0.3, 3), "F_y": (-0.3, 0.3, 3), "F_z": (0.0, 1.0, 5)}),
)
SMALL: Table = ("biorob2018-w15", (), {"F_z": (0.0, 3.0, 3)})  # of coarse runs
Row = dict[str, Any]


def drawn(some: np.random.Generator) -> tuple[str, list[str], Sensor, Wrench, float]:
    """Return a scene by chance with its overrides, a load and a tolerance."""
    scene, silicone = str(some.choice(SCENES)), str(some.choice(SILICONES))
    more = [f"elastomer.thickness={some.uniform(1.0, 4.0) * MM:.6f}", f'elastomer.material="{silicone}"']
    if scene != "triaxial-4":
        more.append(f"target.width={some.uniform(6.0, 15.0) * MM:.6f}")
    sensor = load_sensor(scene, more)
    slant, size = some.uniform(0.0, 0.6), 10.0 ** some.uniform(np.log10(0.03), np.log10(0.6))
    factor = size / first_strain(sensor, Wrench(slant, 1.0))
    return scene, more, sensor, Wrench(slant * factor, factor), float(some.choice([1e-2, 3e-3]))


def of_load(sensor: Sensor, load: Wrench, tolerance: float) -> Row:
    """Return what a load took and reached, over what was planned; or why there is no answer."""
    forget()
    try:
        kept = simulate(sensor, load, tolerance=tolerance, mechanics="block").promise
    except (SolveFailed, SceneError, Collision) as error:
        return {"ended": str(error)[:100]}
    if kept is None:
        return {"ended": "nothing planned"}
    row: Row = dict(kept.record)
    planned = kept.planned
    row |= {"seconds over planned": kept.seconds / planned.seconds, "error over planned": kept.error / planned.error}
    return row


def by_meshes(sensor: Sensor, load: Wrench, finest: float) -> Row:
    """Return what a third mesh, and all that a tolerance takes, cost and leave, over the first two."""
    pad, found = block_pad(sensor, finest), []
    for model in (pad.rough, pad.towards(np.eye(6), 0.0, 3), pad):
        began = time.process_time()
        error = model.equilibrium(load).report.estimated_error
        found.append((time.process_time() - began, error))
    first = found[0]
    named = zip(("third", "all"), found[1:], strict=True)
    return {f"{name}: {what}": own[k] / first[k] for name, own in named for k, what in enumerate(("seconds", "error"))}


def loads(count: int, finest: float) -> list[Row]:
    """Return a row for each scene by chance; its meshes go as far as a tolerance."""
    some, rows = np.random.default_rng(30), list[Row]()
    for _ in range(count):
        scene, more, sensor, load, tolerance = drawn(some)
        row: Row = {"scene": scene, "keys": " ".join(more), "F_x": load.F_x, "F_z": load.F_z, "asked": tolerance}
        row |= of_load(sensor, load, tolerance)
        try:
            row |= by_meshes(sensor, load, finest)
        except SolveFailed as error:
            row |= {"ended": str(error)[:100]}
        rows.append(row)
    return rows


def tables(asked: Sequence[Table]) -> list[Row]:
    """Return a row for each table."""
    rows = list[Row]()
    for scene, more, axes in asked:
        sensor = load_sensor(scene, list(more))
        forget()
        began = time.process_time()
        data = calibrate(sensor, **{name: np.linspace(*own).tolist() for name, own in axes.items()})
        spent, (seconds, error) = time.process_time() - began, data.attrs["planned"]
        row: Row = {"scene": scene, "keys": " ".join(more), "loads": data["status"].size, "planned [s]": seconds}
        row |= {"seconds over planned": spent / seconds, "planned": error, "reached": data.attrs["reached"]}
        rows.append(row | {"error over planned": data.attrs["reached"] / error})
    return rows


def shares(name: str, rows: list[Row]) -> str:
    """Return on what share of rows a promise was kept within a factor of 2, and the medians of all ratios."""
    own = [row for row in rows if "error over planned" in row]
    lines = [f"{name}: {len(own)} of {len(rows)} answered"]
    for what in [key for key in (own[0] if own else {}) if "over" in key or ":" in key]:
        ratios = np.array([row[what] for row in own if what in row])
        within = np.mean((ratios >= 0.5) & (ratios <= 2.0))
        lines.append(f"  {what}: median {np.median(ratios):.2f}, within 2 on {within:.0%}")
    return "\n".join(lines)


def main() -> None:
    """Measure all, or with --coarse a scene and a small table."""
    coarse, folder = study_arguments(__doc__ or "", timed=True)
    with threadpool_limits(limits=1):
        single = loads(COARSE, 1e-2) if coarse else loads(COUNT, 1e-6)
        many = tables([SMALL] if coarse else TABLES)
    print(write_rows(single, folder / "promises.csv"))
    print(write_rows(many, folder / "tables.csv"))
    print(shares("loads", single), shares("tables", many), sep="\n")


if __name__ == "__main__":
    main()
