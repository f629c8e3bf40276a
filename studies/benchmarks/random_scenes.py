"""Do the answers of `auto` hold on scenes that nobody chose, and does `explain` know the time?

Two hundred scenes by chance: one to three coils, rectangles and discs of four metals from 0.02 to 1 mm, gaps from 0.8
to 4 mm, 10 kHz to 10 MHz, poses shifted and tilted, loads that strain a pad by 0.3 to 20 %, long pads, a plate nearby.
Each is answered as `auto` does at 1e-2 and by the richest models, sheets and block, on a finer rung:

    covered    |L/L0 - L/L0 of the richest| <= both stated errors, for every coil; the pose's components alike;
    apart      a nut some decimetres away, left out, changes L by less than 1e-4 of the change, and takes
               processor time: with over without, of all such scenes together and of each;
    seconds    the processor's over those of `explain`.

The target's steel has no richer model: such scenes are answered, counted, and not judged. Solves that end before their
load say so and are counted apart.

Run ``python -m benchmarks.random_scenes [--coarse] --output DIR``: one row a scene is kept in DIR as it is done, and a
stopped run goes on; then the counts, and a figure of true over stated differences and of measured over told seconds.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from common.accuracy import first_strain, forget
from common.outputs import kept_rows, study_arguments, write_rows
from threadpoolctl import threadpool_limits

from sits_mech.chain.models import magnetic_model
from sits_mech.chain.omitted.mechanical import mechanical_omissions
from sits_mech.chain.plans.plan import plan
from sits_mech.chain.rests import at_rest
from sits_mech.chain.simulate import Simulation, simulate, simulation_at
from sits_mech.geometry.collision import Collision
from sits_mech.magnetics.coils.tracks import Tracked
from sits_mech.magnetics.modes import skin_depths
from sits_mech.magnetics.sheets import not_representable, sheets
from sits_mech.mechanics.block import block_pad
from sits_mech.quantities import Array, Impedance, Pose, SolveFailed, Wrench
from sits_mech.report.pictures.style import new_figure, save_figure
from sits_mech.scene.sensor import Conductor, Sensor, load_sensor

MM, ASKED = 1e-3, 1e-2
COUNT, COARSE = 200, (0, 3, 6, 56)
FINER = {"sheets": 5e-3}  # of sheets; where auto took another model ASKED is enough
STIFF, LONG = 2e-3, 0.3  # of block; of a long pad, whose section leaves out tenths and whose cells are many
NAMES = ("d_h", "d_v", "alpha")
Row = dict[str, Any]
Drawn = tuple[str, Sensor, Pose | None, Wrench | None]


def coils(some: np.random.Generator, count: int) -> str:
    """Round coils in a row."""
    turns, layers, inner = int(some.integers(4, 11)), int(some.integers(1, 3)), some.uniform(1.0, 3.0)
    outer = inner + 2 * (0.2 * turns - 0.1)
    pitch = outer + some.uniform(0.3, 4.0)
    rows = [
        f'{{name="C{k + 1}", centre=["{(k - (count - 1) / 2) * pitch:.4f} mm", "0 mm"], layers={layers}, '
        f'turns={turns}, inner_diameter="{inner:.4f} mm", track_width="0.1 mm", track_gap="0.1 mm", '
        'track_thickness="35 um", layer_pitch="85 um"}'
        for k in range(count)
    ]
    return f"coils=[{', '.join(rows)}]"


def target(some: np.random.Generator, kind: str) -> str:
    """A plate of some metal."""
    metal = f"conductivity={some.choice([5.8e7, 3.5e7, 1.5e7, 1.4e6])}"  # copper, aluminium, brass, stainless
    if kind == "steel":
        metal = "conductivity=7e6, relative_permeability=100"
    thickness = 10 ** some.uniform(math.log10(0.02), 0.0)
    least, most = {"long load": (1.4, 1.9), "load": (3.0, 6.0)}.get(kind, (3.0, 10.0))
    width = some.uniform(least, most)
    length = 20.0 if kind == "long load" else some.uniform(least, most)
    sizes = f'shape="rectangle", width="{width:.4f} mm", length="{length:.4f} mm"'
    if kind in ("disc", "disc beside"):
        sizes = f'shape="disc", diameter="{width:.4f} mm"'
    return f'target={{{metal}, {sizes}, thickness="{thickness:.4f} mm"}}'


KINDS = {"section": 0.60, "load": 0.11, "disc": 0.15, "disc beside": 0.04, "long load": 0.02, "nearby": 0.03,
         "steel": 0.05}


def draw(number: int, loaded: bool = False) -> Drawn:
    """Return kind, scene, and pose or load of a number; where asked a load, whatever the kind."""
    some = np.random.default_rng([18, number])
    kind = str(some.choice(list(KINDS), p=list(KINDS.values())))
    keys = [coils(some, 1 if kind == "disc" else int(some.choice([1, 2, 2, 2, 3]))), target(some, kind)]
    thickness = some.uniform(0.8, 4.0)
    keys += [f'frequency="{10 ** some.uniform(4.0, 7.0):.4f} Hz"', f'elastomer.thickness="{thickness:.4f} mm"']
    plate = load_sensor("biorob2018", keys).target
    assert plate is not None
    (width, length), long = plate.extent, kind == "long load"
    more = (1.0, 1.0) if long else some.uniform(1.0, 2.5, 2)
    keys += [f"elastomer.width={width * more[0]}", f"elastomer.length={length * more[1]}"]
    keys += [] if not long else [f"elastomer.thickness={some.uniform(0.3, 0.5) * width}", 'elastomer.standoff="0.4 mm"']
    sensor = load_sensor("biorob2018", keys)
    assert sensor.elastomer is not None
    gap = sensor.elastomer.standoff + sensor.elastomer.thickness
    if kind == "nearby":
        depth = -0.3 * MM - some.uniform(0.5, 3.0) * MM
        part = Conductor(name="plane", material="copper", shape="rectangle", centre=(0.0, 0.0, depth),
                         width=20 * MM, length=20 * MM, thickness=0.2 * MM)
        sensor = sensor.model_copy(update={"conductors": (part,)})
    if loaded or "load" in kind:
        way = some.normal(size=2) * (0.3, 1.0)
        unit = Wrench(float(way[0]), abs(float(way[1])), float(some.normal() * 0.2 * width))
        bound = first_strain(sensor, unit)
        if math.isinf(bound):  # slender: its own sink under that load
            bound = max(abs(unit.F_x), unit.F_z) / (sensor.elastomer.silicone.shear_modulus * width * length)
        share = 10 ** some.uniform(-2.5, -0.7) / bound
        return kind, sensor, None, Wrench(share * unit.F_x, share * unit.F_z, share * unit.M)
    tilt = some.uniform(-0.4, 0.4) * gap / width if kind != "disc" else 0.0
    return kind, sensor, Pose(float(some.uniform(-1, 1) * MM * (kind != "disc")), gap, float(tilt)), None


def answered(sensor: Sensor, pose: Pose | None, load: Wrench | None) -> tuple[Impedance, Array, Array]:
    """Return what the coils show by `auto`, and pose and its errors."""
    if load is not None:
        return read(simulate(sensor, load, tolerance=ASKED))
    assert pose is not None
    shown = magnetic_model(sensor, "auto", ASKED, [pose])[0].impedance(pose, sensor.frequency)
    return shown, pose.components[:3], np.zeros(3)


def richest(
    sensor: Sensor, pose: Pose | None, load: Wrench | None, tolerance: float
) -> tuple[Impedance, Array, Array]:
    """Return the same by block on finer meshes and by sheets to a tolerance."""
    if load is not None:
        pad = block_pad(sensor, STIFF if short(sensor) is sensor else LONG)
        rest = at_rest(sensor, pad, load, mechanical_omissions(sensor, "block", [load]))
        return read(simulation_at(sensor, Tracked(sheets(short(sensor), tolerance), short(sensor)), rest))
    assert pose is not None
    shown = Tracked(sheets(sensor, tolerance), sensor).impedance(pose, sensor.frequency)
    return shown, pose.components[:3], np.zeros(3)


def short(sensor: Sensor) -> Sensor:
    """Return a scene whose long plate ends three coil diameters from its middle: what lies beyond shows nothing."""
    target, reach = sensor.target, 6.0 * max(coil.outer_diameter for coil in sensor.coils)
    if target is None or target.length is None or target.length < 20.0 * MM:
        return sensor
    return sensor.model_copy(update={"target": target.model_copy(update={"length": min(reach, target.length)})})


def read(found: Simulation) -> tuple[Impedance, Array, Array]:
    """Return inductances, pose and its errors."""
    return found.impedance, found.equilibrium.pose.components[:3], found.equilibrium.error.components[:3]


def timed(ask: Callable[[], Any]) -> tuple[Any, float]:
    """Return an answer from empty caches, and the seconds of the processor that it took."""
    forget()
    began = time.process_time()
    return ask(), time.process_time() - began


def stated_error(sensor: Sensor, load: Wrench | None, model: str) -> float:
    """Return the seconds that a plan tells; of a pose by the model that its place needs."""
    if load is not None:
        return plan(sensor, [load], tolerance=ASKED).seconds
    usual = plan(sensor, tolerance=ASKED)
    return (usual if usual.magnetics.name == model else plan(sensor, tolerance=ASKED, magnetics=model)).seconds


def relative(found: Impedance) -> tuple[Array, Array]:
    """Return each coil's L over its L0, and its error."""
    free = np.diag(found.L0)
    return np.diag(found.L) / free, np.diag(found.error_L) / free


def varied(sensor: Sensor, number: int) -> Sensor:
    """Return a scene with a nut that does not matter."""
    some = np.random.default_rng([19, number])
    away = some.uniform(0.2, 0.6) * (way := some.normal(size=3)) / np.linalg.norm(way)
    nut = Conductor(name="nut", material="copper", shape="rectangle", width=2 * MM, length=2 * MM, thickness=MM,
                    centre=(float(away[0]), float(away[1]), float(away[2])))
    return sensor.model_copy(update={"conductors": (*sensor.conductors, nut)})


def measure(number: int) -> Row:
    """Return the row of a scene."""
    kind, sensor, pose, load = draw(number)
    row: Row = {"scene": number, "kind": kind, "skin depths": skin_depths(sensor), "status": "judged"}
    try:
        (found, place, error), seconds = timed(lambda: answered(sensor, pose, load))
    except (SolveFailed, Collision) as reason:
        return row | {"status": "ended", "why": str(reason)}
    row |= {"mechanics": "" if load is None else plan(sensor, [load], tolerance=ASKED).rungs[0]}
    row |= {"model": found.report.model, "seconds": seconds, "told": stated_error(sensor, load, found.report.model)}
    r, own = relative(found)
    if number % 3 == 0:
        more = varied(sensor, number)
        (nut, *_), with_nut = timed(lambda: answered(more, pose, load))
        moved = float(np.abs(relative(nut)[0] - r).max() / np.abs(r - 1.0).max())
        row |= {"nut": moved, "nut seconds": with_nut}
    if not_representable(sensor) is not None:
        return row | {"status": "no richer model"}
    finer = FINER.get(found.report.model, ASKED)
    (best, right, off), row["seconds of richest"] = timed(lambda: richest(sensor, pose, load, finer))
    true, other = relative(best)
    share = [float(np.max(np.abs(r - true) / (own + other)))]
    row |= {"change": float(np.abs(true - 1.0).max()), "difference": float(np.abs(r - true).max())}
    row |= {"bar": float(own.max()), "bar of richest": float(other.max())}
    if load is not None:
        assert sensor.target is not None
        bars = error + off
        share.append(float(np.max(np.abs(place - right)[bars > 0.0] / bars[bars > 0.0], initial=0.0)))
    return row | {"L over bar": share[0], "pose over bar": share[-1] if load is not None else math.nan}


def counts(rows: Sequence[Row]) -> list[Row]:
    """Return what the scenes say together: how many of how many."""
    judged = [row for row in rows if row["status"] == "judged"]
    loaded = [row for row in judged if "load" in row["kind"]]
    timed_, far = ([row for row in rows if key in row] for key in ("seconds", "nut"))
    ratios = [row["seconds"] / row["told"] for row in timed_]
    extra = [row["nut seconds"] / row["seconds"] for row in far]
    together = sum(row["nut seconds"] for row in far) / sum(row["seconds"] for row in far) if far else math.nan

    def part(what: str, some: Sequence[bool], wanted: str) -> Row:
        held = sum(some)
        return {"what": what, "of": len(some), "hold": held, "share": held / max(len(some), 1), "wanted": wanted}

    return [
        part("ended before the load, named", [row["status"] == "ended" for row in rows], ""),
        part("no richer model", [row["status"] == "no richer model" for row in rows], ""),
        part("L within both errors", [row["L over bar"] <= 1.0 for row in judged], "0.95"),
        part("pose within both errors", [row["pose over bar"] <= 1.0 for row in loaded], "0.95"),
        part("errors of L under 10 times the difference", [row["L over bar"] >= 0.1 for row in judged], ""),
        part("a nut changes L by less than 1e-4", [row["nut"] < 1e-4 for row in far], "1"),
        part("a nut takes less than 5 % more", [ratio < 1.05 for ratio in extra], ""),
        part(f"all nuts together: {together - 1.0:+.1%}", [together < 1.05], "1"),
        part("seconds within 3 of explain's", [1.0 / 3.0 < ratio < 3.0 for ratio in ratios], "0.9"),
    ]


def drawn(rows: Sequence[Row], path: Path) -> None:
    """Write differences over bars, and seconds over those told, as a picture."""
    judged = [row for row in rows if row["status"] == "judged"]
    with new_figure(height=1.2, rows=2) as (figure, (upper, lower)):
        for k, kind in enumerate(KINDS):
            own = [row for row in judged if row["kind"] == kind]
            over = [max(row["L over bar"], 1e-3) for row in own]
            upper.plot([row["change"] for row in own], over, f"C{k}.", label=kind)
            own = [row for row in rows if row["kind"] == kind and "told" in row]
            lower.plot([row["told"] for row in own], [row["seconds"] / row["told"] for row in own], f"C{k}.")
        upper.axhline(1.0, color="k", lw=0.5)
        upper.set(xscale="log", yscale="log", xlabel="change of L over L0", ylabel="difference over both errors")
        lower.axhspan(1.0 / 3.0, 3.0, color="0.9")
        lower.set(xscale="log", yscale="log", xlabel="seconds by explain", ylabel="measured over told")
        figure.legend(*upper.get_legend_handles_labels(), loc="outside lower center", ncols=4)
        save_figure(figure, path)


def main() -> None:
    """Go through the scenes; write rows, counts and figure."""
    coarse, folder = study_arguments(__doc__ or "", timed=True)
    with threadpool_limits(limits=1):
        answered(*draw(0)[1:])  # what is loaded once is no scene's time
        rows = kept_rows(COARSE if coarse else range(COUNT), measure, folder)
    write_rows(rows, folder / "scenes.csv", missing=math.nan)
    print(write_rows(counts(rows), folder / "counts.csv"))
    drawn(rows, folder / "random_scenes.png")


if __name__ == "__main__":
    main()
