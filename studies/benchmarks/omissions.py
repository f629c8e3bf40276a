"""What does each omission of a plan save, what does it cost in accuracy, and are the plan's seconds true?

Every omission that the plan of a catalogued scene can hold is answered with and without, by the models it stands
between: seconds of the processor, and the difference relative to what the promise is of (the largest displacement, the
change of inductance, L0) beside the promise and what both answers know of themselves. For the inside of a thick plate
the seconds are those of finite elements on either side of three skin depths, the difference is to the bars, which
divide the whole thickness. Of the ends along y the plan says what they are worth. Nothing is measured
where there is nothing to compare: a pose that is given needs no mechanics, a scene without target no eddy currents.

Then the plan's expected seconds beside those of the processor, single solves and a grid.

Run ``python -m benchmarks.omissions [--coarse] --output DIR``: two tables and a figure.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from common.accuracy import first_strain, forget
from common.outputs import study_arguments, write_rows
from threadpoolctl import threadpool_limits

from sits_mech.analysis.spectrum import at_terminals
from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.interpolate import LayerGrid, loads_of, poses_on_grid
from sits_mech.chain.models import MAGNETICS, MECHANICS, magnetic_model, mechanical_model
from sits_mech.chain.plan import plan
from sits_mech.chain.propagation import read_poses
from sits_mech.chain.simulate import simulate
from sits_mech.description import sized
from sits_mech.magnetics.idle import idle_share
from sits_mech.mechanics.loads import Settled, settle
from sits_mech.mechanics.models import strain_bound
from sits_mech.mechanics.symmetry import Symmetry, symmetry_of
from sits_mech.quantities import Bounded, Pose, Wrench
from sits_mech.report.pictures.style import new_figure, save_figure
from sits_mech.scene.sensor import Sensor, load_sensor
from sits_mech.store import Row

LONG = ("elastomer.length=0.5", "target.length=0.5")
FERRITE = (
    'conductors=[{name="backing", material="ferrite", shape="rectangle", centre=["0 mm", "-1 mm"], width="18 mm", '
    'length="18 mm", thickness="1 mm"}]'
)
DISC = (
    'target={material="copper", shape="disc", diameter="7 mm", thickness="0.2 mm"}',
    'coils=[{name="C", centre=["0 mm", "0 mm"], layers=2, turns=12, inner_diameter="2.2 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}]',
)
GAP = Pose(0.0, 2e-3)
ROUNDING = 1e-6  # what two converged solves of one load differ by, over the largest displacement


@dataclass(frozen=True)
class Saving:
    """An omission: seconds without and with what it leaves out, difference, promise, what the answers know [-]."""

    what: str
    without: float
    with_: float
    difference: float
    promised: float
    known: float

    @property
    def row(self) -> Row:
        """Return it as it stands in the table."""
        kept = "not promised" if math.isnan(self.promised) else self.difference <= self.promised + self.known
        return {
            "left out": self.what, "s, left out": self.without, "s, solved": self.with_,
            "times faster": self.with_ / self.without, "difference": self.difference, "promised": self.promised,
            "error of both answers": self.known, "kept": kept,
        }


def timed(ask: Callable[[], Any]) -> tuple[Any, float]:
    """Return an answer from empty caches, and the seconds of the processor that it took."""
    forget()
    began = time.process_time()
    return ask(), time.process_time() - began


def moved(sensor: Sensor, pose: Pose) -> np.ndarray:
    """Return how far a target, its edges included, is from rest [m]."""
    assert sensor.target is not None and sensor.elastomer is not None
    rest = sensor.elastomer.standoff + sensor.elastomer.thickness
    return np.array([pose.d_h, rest - pose.d_v, 0.5 * sensor.target.extent[0] * pose.alpha], dtype=float)


def apart(sensor: Sensor, first: dict[Wrench, Settled], second: dict[Wrench, Settled]) -> float:
    """Return the largest difference of two answers to a grid, over the largest displacement."""
    each = [[some[load].rest for load in first] for some in (first, second)]
    poses = [np.array([moved(sensor, rest.pose) for rest in rests if rest]) for rests in each]
    return float(np.abs(poses[0] - poses[1]).max() / np.abs(poses[0]).max())


def finite_strain() -> Saving:
    """Return what one compliance saves of a long pad, at a load that strains it to the promise of 1 %."""
    sensor, asked = load_sensor("biorob2018", LONG), Wrench(0.5, 1.0)
    part = 1e-2 / first_strain(sensor, asked)
    load = Wrench(part * asked.F_x, part * asked.F_z)
    (small, few), (full, many) = (
        timed(lambda name=name: MECHANICS[name](sensor, 1e-2).equilibrium(load)) for name in ("linear", "planar")
    )
    missed = np.abs(moved(sensor, small.pose) - moved(sensor, full.pose)).max() / np.abs(moved(sensor, full.pose)).max()
    known = small.report.estimated_error + full.report.estimated_error
    return Saving("finite strain", few, many, float(missed), strain_bound(sensor, [load]), known)


def images_of_loads(count: int, overrides: Sequence[str] = ()) -> Saving:
    """Return what mirror images save on a grid."""
    sensor = load_sensor("biorob2018", overrides)
    loads = loads_of({"F_x": np.linspace(-0.5, 0.5, 3).tolist(), "F_z": np.linspace(0.0, 2.0, count).tolist()})
    (half, few), (whole, many) = (
        timed(lambda symmetry=symmetry: settle(mechanical_model(sensor)[0], loads, symmetry=symmetry))
        for symmetry in (symmetry_of(sensor), Symmetry())
    )
    return Saving("mirrored loads", few, many, apart(sensor, whole, half), 0.0, ROUNDING)


def loads_between(count: int) -> Saving:
    """Return what a smooth map saves on a grid of count x count loads."""
    sensor = load_sensor("biorob2018-w15")
    grid = {"F_x": np.linspace(-1.0, 1.0, count).tolist(), "F_z": np.linspace(0.0, 4.0, count).tolist()}
    own = symmetry_of(sensor)
    some, few = timed(lambda: poses_on_grid(LayerGrid(sensor, mechanical_model(sensor)[0], grid, own, 1e-2)))
    all_, many = timed(lambda: settle(mechanical_model(sensor)[0], loads_of(grid), symmetry=own))
    return Saving("loads between solved ones", few, many, apart(sensor, all_, some), 1e-2, ROUNDING)


def places_beside(count: int, tolerance: float) -> Saving:
    """Return what is saved where a symmetric load has no error to the side and none of rotation."""
    sensor, zero = load_sensor("biorob2018"), np.zeros(count)
    model, _ = magnetic_model(sensor, "sheets", tolerance)
    pose = Pose(zero, np.linspace(1.5e-3, 2e-3, count), zero)
    model.impedance(pose, sensor.frequency)
    found = []
    for less in (0.0, 1e-9):
        error = Pose(zero + less, zero + 1e-5, zero + less)
        began = time.process_time()
        reading = read_poses(sensor, model, Bounded.of(pose.components, error.components))
        found.append((reading.signals, time.process_time() - began))
    (few, without), (all_, with_) = found
    missed = np.abs(few.error_L_v_percent - all_.error_L_v_percent).max() / np.abs(all_.error_L_v_percent).max()
    return Saving("out-of-plane displacement and rotation", without, with_, float(missed), 0.0, 1e-6)


def other_model(what: str, scene: str, models: tuple[str, str], promised: float, tolerance: float) -> Saving:
    """Return what one magnetic model saves against another, of the change relative to L0 (units cancel)."""
    sensor = load_sensor(scene)
    (few, without), (all_, with_) = (
        timed(lambda name=name: MAGNETICS[name](sensor, tolerance).impedance(GAP, sensor.frequency)) for name in models
    )
    changes = [(found.L - found.L0)[0, 0] / found.L0[0, 0] for found in (few, all_)]
    known = few.report.estimated_error + all_.report.estimated_error
    return Saving(what, without, with_, float(abs(changes[0] / changes[1] - 1.0)), promised, known)


def ends_along_y(tolerance: float) -> Saving:
    """Return what a section saves, and what its ends are worth: of the section's own change, as it is promised."""
    sensor = load_sensor("biorob2018")
    found = other_model("ends along y", "biorob2018", ("planar", "sheets"), math.nan, tolerance)
    shown = magnetic_model(sensor, "planar", tolerance)[0].impedance(GAP, sensor.frequency)
    promised = sized(shown.report.left_out)
    return replace(found, difference=found.difference / (1.0 + found.difference), promised=promised)


def idle_coil(tolerance: float) -> Saving:
    """Return what the current of the shorted coil is worth, over L0."""
    sensor = load_sensor("biorob2018")
    scenes = [
        sensor.model_copy(update={"readout": sensor.readout.model_copy(update={"idle_coil": idle})})
        for idle in ("open", "shorted")
    ]
    found = magnetic_model(sensor, "sheets", tolerance)[0].impedance(GAP, sensor.frequency)
    (alone, few), (seen, many) = (timed(lambda scene=scene: at_terminals(scene, found)[0]) for scene in scenes)
    missed, promised = np.abs(seen.L - alone.L).max() / found.L0[0, 0], idle_share(found)
    return Saving("current in the idle coil", few, many, float(missed), promised, 0.05 * promised)


def predicted(coarse: bool) -> list[Row]:
    """Return the plan's seconds beside those of the processor."""
    sensor, wide, long = load_sensor("biorob2018"), load_sensor("biorob2018-w15"), load_sensor("biorob2018", LONG)
    single, count = [Wrench(0.5, 2.0)], 9
    grid = {"F_x": np.linspace(-1.0, 1.0, count).tolist(), "F_z": np.linspace(0.0, 4.0, count).tolist()}
    loads = [Wrench(x, z) for x in grid["F_x"] for z in grid["F_z"]]
    slight, heavy = [Wrench(0.1, 1.0)], Wrench(25.0, 500.0)
    asked: list[tuple[str, Sensor, Sequence[Wrench], float, str, Callable[[], Any]]] = [
        (f"{count} x {count} loads, 15 mm", wide, loads, 1e-2, "auto", lambda: calibrate(wide, **grid)),
        ("one load, 8 mm", sensor, single, 1e-2, "auto", lambda: simulate(sensor, *single)),
        ("one load, long pad", long, [heavy], 1e-2, "auto", lambda: simulate(long, heavy)),
        ("slight load, long pad", long, slight, 1e-2, "auto", lambda: simulate(long, *slight)),
    ]
    asked = asked[-1:] if coarse else asked
    poses = [("planar", sensor, 1e-3), ("planar-fem", load_sensor("biorob2018", [FERRITE]), 1e-3),
             ("axisymmetric", load_sensor("biorob2018", DISC), 1e-3), ("sheets", sensor, 1e-2)]
    if coarse:
        poses = poses[:1]
    else:
        poses += [("planar", sensor, 1e-4), ("sheets", sensor, 5e-3), ("sheets", wide, 2e-3)]
        finer = lambda: simulate(sensor, *single, tolerance=5e-3)  # noqa: E731
        asked += [("one load, 8 mm", sensor, single, 5e-3, "auto", finer)]
    for name, scene, tolerance in poses:
        ask = lambda at=(name, scene, tolerance): MAGNETICS[at[0]](at[1], at[2]).impedance(GAP, at[1].frequency)  # noqa: E731
        asked.append((f"one pose, {name}", scene, [], tolerance, name, ask))
    rows: list[Row] = []
    for what, scene, some, tolerance, name, ask in asked:
        expected = plan(scene, some, tolerance=tolerance, magnetics=name)
        seconds = timed(ask)[1]
        models = "" if expected.mechanics is None else f"{expected.mechanics.name}, "
        rows.append({
            "request": what, "models": models + expected.magnetics.name, "tolerance": tolerance,
            "expected [s]": expected.seconds, "measured [s]": seconds, "ratio": expected.seconds / seconds,
        })
    return rows


def draw(savings: Sequence[Saving], path: Path) -> None:
    """Write what each omission saves and how far it keeps its promise as a picture."""
    places, names = np.arange(len(savings)), [item.what for item in savings]
    with new_figure(height=1.3, rows=2) as (figure, (upper, lower)):
        upper.barh(places, [item.with_ / item.without for item in savings], color="C0")
        upper.set(xscale="log", xlabel="times faster", yticks=places, yticklabels=names)
        promises = [item.promised + item.known for item in savings]
        lower.plot([max(item.difference, 1e-16) for item in savings], places, "o", label="difference")
        lower.plot(promises, places, "|", ms=10, label="promised, and error of both answers")
        lower.set(xscale="log", xlabel="relative", yticks=places, yticklabels=names, ylim=(-0.6, len(savings) - 0.4))
        figure.legend(*lower.get_legend_handles_labels(), loc="outside lower center", ncols=2)
        save_figure(figure, path)


def main() -> None:
    """Run each omission with and without, and the plan's seconds; write tables and figure."""
    coarse, folder = study_arguments(__doc__ or "", timed=True)
    tolerance = 1e-1 if coarse else 1e-2
    with threadpool_limits(limits=1):
        savings = [
            finite_strain(), images_of_loads(*(2, LONG) if coarse else (3,)), *([] if coarse else [loads_between(9)]),
            other_model("mesh of the air", "biorob2018", ("planar", "planar-fem"), 0.0, tolerance),
            places_beside(5 if coarse else 81, tolerance), idle_coil(tolerance),  # by the same sheets
            ends_along_y(tolerance),
        ]
        rows = predicted(coarse)
    draw(savings, folder / "omissions.png")
    print(write_rows([item.row for item in savings], folder / "omissions.csv"))
    print(write_rows(rows, folder / "seconds.csv"))


if __name__ == "__main__":
    main()
