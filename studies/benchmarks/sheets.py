"""What does the three-dimensional model cost, and how far is it off? Error against seconds, rung by rung.

The change of inductance and the resistance of the catalogue's two-coil sensor (8 x 8 x 0.2 mm copper plate) and of one
coil over coaxial discs, against volume and axisymmetric finite elements (NGSolve 6.2; errors 2e-4 / 1e-3 and 1e-6):

    python -m benchmarks.sheets [--coarse] --output DIR

Whether stated errors hold, on scenes of all kinds by chance: benchmarks/sheets_errors.py.

Seconds are processor time on one core: of the preparation, and of a thousand poses after it.

Uses of the published sensor: one pose cold, one after it (poses asked one by one), a batch of a thousand, a spectrum of
200 frequencies from 10 kHz to 20 MHz, cold; of 64 coils over its plate, a pose cold and one of a hundred after it.

Arrays of coils: the published winding on square grids 8 mm apart, under plates pressed down from 2 mm by up to 0.15
mm, 5 MHz; L0 of all coils, and a batch of 100 poses of all six components after the plate's preparation.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from common.outputs import study_arguments, write_rows
from threadpoolctl import threadpool_limits

from sits_mech.magnetics.coils.loops import free_inductances
from sits_mech.magnetics.rings import axisymmetric
from sits_mech.magnetics.sheets import Sheets, sheets
from sits_mech.magnetics.space.divisions import prepared, prepared_near
from sits_mech.quantities import Array, Pose
from sits_mech.scene.sensor import Sensor, load_sensor

# frequency [Hz], gap [m], Delta L1 [H], R1 [ohm] (not known where nan)
PLATE = (
    (5e6, 1e-3, -176.14e-9, np.nan), (5e6, 2e-3, -59.01338e-9, 0.07347140), (5e6, 5e-3, -5.684821e-9, 0.005169888),
    (5e3, 2e-3, -2.171675e-9, 2.962316e-4), (5e3, 5e-3, -0.3517857e-9, 3.786894e-5),
)
DISCS = {
    3.5e-3: ((5e3, 2e-3, -1.09405875e-8, 1.26011961e-3), (5e6, 2e-3, -1.72208696e-7, 0.115273800)),
    7.5e-3: ((5e3, 2e-3, -4.65903043e-8, 2.61817465e-3), (5e6, 2e-3, -2.18587417e-7, 0.0952016920)),
}
# 0.2 mm copper discs at small gaps, 5 MHz, one coil: diameter, gap [m]; against the axisymmetric model at 2e-3
SMALL_GAPS = ((4.6e-3, 5e-5), (4.6e-3, 2e-4), (15e-3, 5e-5))
COLUMNS = (
    "target", "tolerance", "frequency", "gap", "unknowns", "error_L", "estimated_L", "error_R", "estimated_R",
    "prepare_seconds", "thousand_poses_seconds",
)
TARGETS = (
    'shape="rectangle", width="8 mm", length="8 mm"', 'shape="disc", diameter="8 mm"',
    'shape="disc", diameter="12 mm"', 'shape="rectangle", width="12 mm", length="12 mm"',
    'shape="rectangle", width="16 mm", length="16 mm"',
)
USE_COLUMNS = ("use", "count", "seconds", "ms_each")
ARRAY_COLUMNS = ("coils", "target", "L0_seconds", "prepare_seconds", "pose_ms", "estimated_L", "process_MB")


def disc_sensor(radius: float, thickness: float = 2e-4) -> Sensor:
    """One coil about z, the other out of the way, and a coaxial disc."""
    target = f'target={{material="copper", shape="disc", diameter={2 * radius}, thickness={thickness}}}'
    places = ['coils.C1.centre=["0 mm","0 mm"]', 'coils.C2.centre=["30 mm","0 mm"]']
    return load_sensor("biorob2018", [target, *places])


def unprepared(sensor: Sensor, tolerance: float) -> Sheets:
    """The model of a sensor, when no plate is prepared any more."""
    for plates in (prepared, prepared_near):
        plates.cache_clear()
    return sheets(sensor, tolerance)


def measure(name: str, sensor: Sensor, tolerance: float, row: tuple[float, float, float, float]) -> dict[str, object]:
    """One line of the table."""
    f, gap, delta_L, R = row
    model = unprepared(sensor, tolerance)
    began = time.process_time()
    z = model.impedance(Pose(0.0, gap), f)
    prepare = time.process_time() - began
    s = np.linspace(0.0, 1.0, 1000)
    poses = Pose(1e-4 * (2 * s - 1), gap * (1.06 + 0.1 * s), min(0.01, gap / 0.01) * (2 * s - 1))
    began = time.process_time()
    model.impedance(poses, f)
    thousand = time.process_time() - began
    change = (z.L - z.L0)[0, 0]
    errors = (change / delta_L - 1, z.error_L[0, 0] / abs(change), z.R[0, 0] / R - 1, z.error_R[0, 0] / z.R[0, 0])
    return dict(zip(COLUMNS, (name, tolerance, f, gap, z.report.unknowns, *errors, prepare, thousand), strict=True))


def small_gaps(tolerance: float) -> list[dict[str, object]]:
    """Lines of the small gaps: a disc whose edge lies above the windings, and one wider than the coil."""
    lines = []
    for diameter, gap in SMALL_GAPS:
        sensor = disc_sensor(diameter / 2)
        alone = sensor.model_copy(update={"coils": sensor.coils[:1]})
        z = axisymmetric(alone, 2e-3).impedance(Pose(0.0, gap), 5e6)
        row = (5e6, gap, float((z.L - z.L0)[0, 0]), float(z.R[0, 0]))
        lines.append(measure(f"disc {1e3 * diameter:g} mm", sensor, tolerance, row))
    return lines


def table(coarse: bool) -> list[dict[str, object]]:
    """All lines."""
    plate, few = load_sensor("biorob2018"), slice(1 if coarse else None)
    lines = []
    for tolerance in (1e-1,) if coarse else (1e-2, 5e-3, 2e-3, 1e-3):
        lines += [measure("8 x 8 mm", plate, tolerance, row) for row in PLATE[few]]
        for radius, rows in list(DISCS.items())[: 1 if coarse else 2]:
            lines += [measure(f"disc {2e3 * radius:g} mm", disc_sensor(radius), tolerance, row) for row in rows[few]]
        lines += [] if coarse else small_gaps(tolerance)
    return lines


def moved(count: int) -> Array:
    """Poses of all components about 2 mm, shape (count, 6)."""
    away = np.array([5e-4, 1e-4, 2e-3, 5e-4, 2e-3, 0.05])
    return np.random.default_rng(0).uniform(-away, away, (count, 6)) + [0.0, 1.95e-3, 0.0, 0.0, 0.0, 0.0]


def uses(coarse: bool) -> list[dict[str, object]]:
    """What one pose, many, and a spectrum cost, cold and after a preparation."""
    sensor, (tolerance, few) = load_sensor("biorob2018"), (1e-1, 50) if coarse else (5e-3, 1)
    rest, alone, batch = Pose(0.0, 2e-3), moved(5 if coarse else 50), moved(1000 // few)
    spectrum, array_poses = np.geomspace(1e4, 2e7, 200 // few), moved(100 // few)
    model, many = sheets(sensor, tolerance), sheets(array(2 if coarse else 8, TARGETS[0]), tolerance)
    asked: dict[str, tuple[int, Callable[[], object]]] = {
        "one pose, cold": (1, lambda: model.impedance(rest, 5e6)),
        "poses one by one, warm": (len(alone), lambda: [model.impedance(Pose.of(p), 5e6) for p in alone]),
        "batch of poses, warm": (len(batch), lambda: model.impedance(Pose.of(batch), 5e6)),
        "spectrum, cold": (len(spectrum), lambda: [model.impedance(rest, float(f)) for f in spectrum]),
        f"{len(many.sensor.coils)} coils, cold": (1, lambda: many.impedance(rest, 5e6)),
        f"{len(many.sensor.coils)} coils, warm": (len(array_poses), lambda: many.impedance(Pose.of(array_poses), 5e6)),
    }
    lines: list[dict[str, object]] = []
    for use, (count, answer) in asked.items():
        if use.endswith("cold"):
            unprepared(sensor, tolerance)
        began = time.process_time()
        answer()
        seconds = time.process_time() - began
        lines.append(dict(zip(USE_COLUMNS, (use, count, seconds, 1e3 * seconds / count), strict=True)))
    return lines


def array(count: int, target: str) -> Sensor:
    """The published winding on a square grid."""
    sensor = load_sensor("biorob2018", [f'target={{material="copper", thickness="0.2 mm", {target}}}'])
    places = 8e-3 * (np.arange(count) - (count - 1) / 2)
    grid = [(f"C{i}_{j}", (float(x), float(y))) for i, x in enumerate(places) for j, y in enumerate(places)]
    coils = tuple(sensor.coils[0].model_copy(update={"name": name, "centre": centre}) for name, centre in grid)
    return sensor.model_copy(update={"coils": coils})


def arrays(coarse: bool) -> list[dict[str, object]]:
    """What coils on a grid cost: L0, a plate's preparation, a pose."""
    lines: list[dict[str, object]] = []
    low, high = (np.array([side * 5e-4, gap, side * 2e-3, side * 5e-4, side * 2e-3, side * 0.05])
                 for side, gap in ((-1, 1.85e-3), (1, 2.05e-3)))
    poses = np.random.default_rng(0).uniform(low, high, (10 if coarse else 100, 6))
    for count in (2,) if coarse else (2, 4, 8):
        for target in TARGETS[:1] if coarse else TARGETS:
            sensor = array(count, target)
            began = time.process_time()
            free_inductances(sensor.coils)
            seconds = [time.process_time() - began]
            model = unprepared(sensor, 1e-1 if coarse else 5e-3)
            for some in (poses[:1], poses):
                began = time.process_time()
                found = model.impedance(Pose.of(some), 5e6)
                seconds.append(time.process_time() - began)
            seconds[2] *= 1e3 / len(poses)
            values = (count**2, target, *seconds, found.report.estimated_error, memory())
            lines.append(dict(zip(ARRAY_COLUMNS, values, strict=True)))
    return lines


def memory() -> float:
    """Largest memory that this process has held [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def draw(lines: list[dict[str, object]], path: Path) -> None:
    """Error of Delta L and of R against the seconds of preparation."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 3.2), layout="constrained")
    for axes, key, label in zip(figure.subplots(1, 2), ("error_L", "error_R"), ("change of L", "R"), strict=True):
        for kind, marker in (("8 x 8 mm", "s"), ("disc 7 mm", "o"), ("disc 15 mm", "^")):
            for f, fill in ((5e3, "none"), (5e6, "full")):
                some = [line for line in lines if line["target"] == kind and line["frequency"] == f]
                x, y = ([float(str(line[k])) for line in some] for k in ("prepare_seconds", key))
                axes.plot(x, np.abs(y), marker, fillstyle=fill, label=f"{kind}, {f / 1e3:g} kHz")
        axes.set(xscale="log", yscale="log", xlabel="seconds to prepare", ylabel=f"relative error of {label}")
        axes.grid(True, which="major", alpha=0.3)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=6)
    figure.savefig(path, dpi=150)


def main() -> None:
    """Write each table when it is known, and its picture."""
    coarse, folder = study_arguments(__doc__ or "", timed=True)
    with threadpool_limits(1):
        print(write_rows(uses(coarse), folder / "benchmark_sheets_uses.csv"), flush=True)
        print(write_rows(arrays(coarse), folder / "benchmark_sheets_arrays.csv"), flush=True)
        lines = table(coarse)
        print(write_rows(lines, folder / "benchmark_sheets.csv"))
        draw(lines, folder / "benchmark_sheets.png")


if __name__ == "__main__":
    main()
