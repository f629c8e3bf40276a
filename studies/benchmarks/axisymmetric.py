"""How far is the axisymmetric model from independent numbers, and what does it cost?

References: NGSolve 6.2, p = 6, axisymmetric, one coil of 2 x 12 rings, copper disc 0.2 mm thick, gap 2 mm (1e-6); the
infinite plate by the Dodd-Deeds integral. Run ``python -m benchmarks.axisymmetric [--coarse] --output DIR``.
"""

from __future__ import annotations

import time

import numpy as np
from common.infinite_plate import Layer, coil_change
from common.outputs import study_arguments, write_rows
from common.track_losses import coil_losses

from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.coils.resistance import track_resistance
from sits_mech.magnetics.rings import axisymmetric
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import Coil, Sensor, Target

MM = 1e-3
GAP = 2 * MM
DISCS = [
    (3.5, 5e3, -1.0940587457181086e-08, 0.0012601196119705871),
    (3.5, 5e6, -1.722086964359416e-07, 0.11527379963961844),
    (7.5, 5e3, -4.659030431522552e-08, 0.0026181746454115745),
    (7.5, 5e6, -2.1858741804936318e-07, 0.09520169200761902),
]
PLATE = [(5e3, -5.8325180325808516e-08, 0.0025675831423334306), (5e6, -2.201923393250477e-07, 0.0939925486348742)]
HEADER = ["model", "radius_mm", "frequency_Hz", "tolerance", "L_error", "R_error", "estimated", "prepare_s", "pose_s"]


def make_coil() -> Coil:
    """Return the reference coil."""
    return Coil(
        name="C", centre=(0.0, 0.0), layers=2, turns=12, inner_diameter=2.2 * MM, track_width=0.1 * MM,
        track_gap=0.1 * MM, track_thickness=35e-6, layer_pitch=85e-6,
    )


def disc_row(tolerance: float, radius: float, frequency: float, delta_L: float, R: float) -> list[object]:
    """Return one row: errors against the reference, time to prepare and time a pose afterwards."""
    target = Target(material="copper", shape="disc", diameter=2 * radius * MM, thickness=0.2 * MM)
    model = axisymmetric(Sensor(name="disc", frequency=frequency, coils=(make_coil(),), target=target), tolerance)
    began = time.perf_counter()
    found = model.impedance(Pose(0.0, GAP), frequency)
    prepared = time.perf_counter()
    model.impedance(Pose(0.0, np.linspace(1.0, 1.05, 1000) * GAP), frequency)
    again = time.perf_counter()
    model.impedance(Pose(0.0, np.linspace(1.0, 1.05, 1000) * GAP), frequency)
    per_pose = (time.perf_counter() - again) / 1000
    errors = (float((found.L - found.L0)[0, 0] / delta_L - 1), float(found.R[0, 0] / R - 1))
    estimated = found.report.estimated_error
    return ["disc", radius, frequency, tolerance, *errors, estimated, prepared - began, per_pose]


def plate_row(frequency: float, delta_L: float, R: float) -> list[object]:
    """Return the infinite plate's row."""
    began = time.perf_counter()
    change = coil_change(coil_sections(make_coil()), GAP, frequency, [Layer(5.8e7, 0.2 * MM)])
    seconds = time.perf_counter() - began
    errors = (float(change.delta_L / delta_L - 1), float(change.R / R - 1))
    return ["plate", "inf", frequency, 1e-8, *errors, change.error, 0.0, seconds]


def main() -> None:
    """Write the table and print it."""
    coarse, folder = study_arguments(__doc__ or "", timed=True)
    tolerances, discs = ((1e-2,), DISCS[1:2]) if coarse else ((1e-2, 1e-3, 1e-4), DISCS)
    rows = [disc_row(tolerance, *disc) for tolerance in tolerances for disc in discs]
    rows += [plate_row(*plate) for plate in PLATE]
    print(write_rows([dict(zip(HEADER, row, strict=True)) for row in rows], folder / "axisymmetric.csv"))
    coil = make_coil()
    for frequency in (5e3, 5e6):
        run = coil_losses(coil, frequency)
        ratio = run.R / track_resistance(coil)
        print(f"tracks at {frequency:g} Hz: R_ac / R_dc = {ratio:.4f}, L = {run.L * 1e6:.5f} uH")


if __name__ == "__main__":
    main()
