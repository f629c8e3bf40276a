"""How much error for how much time, in each half of the planar chain, and in what each is asked to reach?

References: mechanics, NGSolve 6.2 and FElupe 11.3 on a neo-Hookean layer 20 x 2 mm under a 15 mm target (combined
load of 267 N/m shear and 4050 N/m normal: their own error bars are 0.5 % of d_h and 2 % of the sink); bonded strips,
graded P2-P1 linear FEM. Magnetics, NGSolve 6.2, p = 5, on the published coils under an 8 mm copper plate (1e-6). Times
are wall times on one BLAS thread, first call included.

Run ``python studies/error_against_time.py [--coarse] --output DIR``; the picture in the README is its full run.
"""

from __future__ import annotations

import argparse
import csv
import time
from dataclasses import astuple, fields
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from sits_mech.magnetics.bars import planar_bars, section_modes
from sits_mech.mechanics.layer import linear_layer, planar_layer
from sits_mech.quantities import Pose, Wrench
from sits_mech.report.accuracy import Rung, draw_ladders, markdown
from sits_mech.sensor import Sensor, load_sensor

MM = 1e-3
# d_v [mm], f [Hz]: Delta L1 [H/m], R1 [ohm/m]
PLATE = {
    (1, 5e6): (-3.994483152940223e-05, 51.83622191281245),
    (2, 5e6): (-1.696012066246201e-05, 21.111396592136952),
    (2, 5e3): (-6.000927442762491e-07, 0.08421475240454547),
}
COMBINED = (Wrench(267.0, 4050.0), 0.985277906, 0.203230935)  # d_h, sink [mm]
SHEAR = (Wrench(53.9, 0.0), 0.200583815)
MATERIAL = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'


def layer_sensor() -> Sensor:
    """Return the reference layer, a metre long so that newtons are newtons per metre."""
    sizes = ["elastomer.length=1.0", "target.load_height=0", 'target.width="15 mm"', MATERIAL]
    return load_sensor("biorob2018", sizes)


def mechanics(tolerances: list[float]) -> list[Rung]:
    """Return the rungs of the planar layer: shear alone (error of d_h), and the combined load (the worse of both)."""
    rungs, sensor = [], layer_sensor()
    for tolerance in tolerances:
        layer = planar_layer(sensor, tolerance)
        found = layer.equilibrium(SHEAR[0])
        error, estimated = abs(found.pose.d_h / MM / SHEAR[1] - 1), found.error.d_h / found.pose.d_h
        rungs.append(Rung("layer, shear", f"{tolerance:g}", found.report.seconds, error, estimated))
        found = layer.equilibrium(COMBINED[0])
        sink = 2 * MM - found.pose.d_v
        error = max(abs(found.pose.d_h / MM / COMBINED[1] - 1), abs(sink / MM / COMBINED[2] - 1))
        estimated = max(found.error.d_h / found.pose.d_h, found.error.d_v / sink)
        rungs.append(Rung("layer, combined load", f"{tolerance:g}", found.report.seconds, error, estimated))
    return rungs


def magnetics(tolerances: list[float]) -> list[Rung]:
    """Return the rungs of the planar integral model, plate prepared anew each time."""
    rungs, sensor = [], load_sensor("biorob2018")
    for (d_v, frequency), (delta_L, _) in PLATE.items():
        for tolerance in tolerances:
            section_modes.cache_clear()
            found = planar_bars(sensor, tolerance).impedance(Pose(0.0, d_v * MM, 0.0), frequency)
            error = abs((found.L - found.L0)[0, 0] / delta_L - 1)
            name = f"coils, {d_v} mm, {frequency / 1e3:g} kHz"
            rungs.append(Rung(name, f"{tolerance:g}", found.report.seconds, error, found.report.estimated_error))
    return rungs


def speeds() -> list[tuple[str, str]]:
    """Return what the models cost in use."""
    sensor, random, count = load_sensor("biorob2018"), np.random.default_rng(0), 10_000
    model = planar_bars(sensor, 1e-3)
    poses = Pose(*(random.uniform(*ends, count) for ends in ((-MM, MM), (1.2 * MM, 2 * MM), (-0.03, 0.03))))
    section_modes.cache_clear()
    began = time.perf_counter()
    model.impedance(Pose(0.0, 1.2 * MM, 0.0), sensor.frequency)
    prepared = time.perf_counter()
    model.impedance(poses, sensor.frequency)
    done = time.perf_counter()
    strip = linear_layer(load_sensor("biorob2018", [*STRIP]), 1e-3)
    stiffness = np.linalg.inv(strip.compliance)[1, 1] / 7.5
    return [
        ("plate prepared at 1e-3", f"{prepared - began:.2f} s"),
        ("poses a second at 1e-3", f"{count / (done - prepared):.0f}"),
        ("small strain, S = 3.75", f"E_c/mu = {stiffness:.4f} (58.627) with {len(strip.body.free) + 3} unknowns"),
    ]


STRIP = [
    'elastomer.width="15 mm"', 'target.width="15 mm"', "elastomer.length=1.0",
    'elastomer.material={law="neo-hookean", shear_modulus=1.0, bulk_modulus=1e7}',
]  # fmt: skip


def main() -> None:
    """Run the ladders and write table and picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--coarse", action="store_true", help="two rungs of each ladder")
    parser.add_argument("--output", type=Path, required=True)
    asked = parser.parse_args()
    asked.output.mkdir(parents=True, exist_ok=True)
    with threadpool_limits(limits=1):
        rungs = mechanics([2e-2, 1e-2] if asked.coarse else [2e-2, 1e-2, 1e-3])
        rungs += magnetics([1e-2, 1e-3] if asked.coarse else [1e-2, 1e-3, 1e-4, 1e-5])
        figures = speeds()
    with (asked.output / "error_against_time.csv").open("w", newline="") as file:
        csv.writer(file).writerows([[field.name for field in fields(Rung)], *(astuple(rung) for rung in rungs)])
    (asked.output / "error_against_time.md").write_text(markdown(rungs))
    draw_ladders(rungs, asked.output / "error_against_time.png")
    print(markdown(rungs), *(f"{name}: {value}" for name, value in figures), sep="\n")


if __name__ == "__main__":
    main()
