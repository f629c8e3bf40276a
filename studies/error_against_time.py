"""How much error for how much time, in each half of the chain and in the whole of it?

Every model's ladder of tolerances against the best number there is, processor time on one BLAS thread, caches emptied
before each solve; the error that each solve itself reports beside the true one.

References. Layer in plane strain: bonded strip at small strain, graded P2-P1 FEM (E_c/mu = 58.627); neo-Hookean layer
20 x 2 mm under a 15 mm target, NGSolve 6.2 and FElupe 11.3 (shear 0.1 %; combined load of 267 N/m and 4050 N/m: 0.5 %
of d_h, 2 % of the sink). 3D pad 20 x 20 x 2 mm under 15 x 15 mm, NGSolve 6.2 and FElupe 11.3 (0.6 % of the sink, 0.3 %
of d_h). Coils 2 mm below copper 0.2 mm thick at 5 MHz, Delta L, NGSolve 6.2: plate 8 mm wide in section (1e-6), coaxial
disc of 7 mm (1e-6), plate 8 x 8 mm (2e-4). Chain: loads of the published sensors, signals in percent of full scale
against the finest rungs of both halves, whose own estimate is given: in section (`planar`, `planar`, target 8 mm wide)
and in space (`block`, `sheets`, which is what `auto` takes; target 15 mm wide).

Run ``python studies/error_against_time.py [--coarse] --output DIR``; the picture in the README is its full run.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
import xarray as xr
from common.accuracy import Rung, draw_ladders, forget, machine, rung_rows
from common.outputs import study_arguments, write_rows
from threadpoolctl import threadpool_limits

from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.models import MAGNETICS
from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.linear import linear_layer
from sits_mech.quantities import MechanicalModel, Pose, Wrench
from sits_mech.scene.sensor import Sensor, load_sensor

MM = 1e-3
_EXACT = 1e-9  # of full scale
MATERIAL = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'
LAYER = ["elastomer.length=1.0", "target.load_height=0", 'target.width="15 mm"', MATERIAL]
STIFF = 'elastomer.material={law="neo-hookean", shear_modulus=1.0, bulk_modulus=1e7}'
STRIP = ['elastomer.width="15 mm"', *LAYER[:3], STIFF]
PAD = ["target.load_height=0", 'target.width="15 mm"', 'target.length="15 mm"', MATERIAL]
STIFFNESS = 58.627 * 7.5  # of the strip's sink [Pa per metre of sink and of depth, at mu = 1 Pa]
# name, model, changes of the scene, load, component of the pose, its value [m], error of that value
LOADS = (
    ("linear, sink", linear_layer, STRIP, Wrench(0.0, 1e-6), "sink", 1e-6 / STIFFNESS, 1e-5),
    ("planar, shear", planar_layer, LAYER, Wrench(53.9, 0.0), "d_h", 0.200583815 * MM, 1e-3),
    ("planar, combined: d_h", planar_layer, LAYER, Wrench(267.0, 4050.0), "d_h", 0.985277906 * MM, 5e-3),
    ("planar, combined: sink", planar_layer, LAYER, Wrench(267.0, 4050.0), "sink", 0.203230935 * MM, 2e-2),
    ("block, sink", block_pad, PAD, Wrench(0.0, 13.0), "sink", 0.09766044209916538 * MM, 6e-3),
    ("block, shear", block_pad, PAD, Wrench(1.8, 0.0), "d_h", 0.40668730902712297 * MM, 3e-3),
)
DISC = (
    'target={material="copper", shape="disc", diameter="7 mm", thickness="0.2 mm"}',
    'coils=[{name="C", centre=["0 mm", "0 mm"], layers=2, turns=12, inner_diameter="2.2 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}]',
)
# model: changes of the scene, Delta L1 (SI; planar per metre), its error, tolerances
COILS = {
    "planar": ((), -1.696012066246201e-05, 1e-6, (1e-2, 1e-3, 1e-4, 1e-5)),
    "planar-fem": ((), -1.696012066246201e-05, 1e-6, (1e-2, 1e-3, 1e-4, 1e-5)),
    "axisymmetric": (DISC, -1.722086964359416e-07, 1e-6, (1e-2, 1e-3, 1e-4)),
    "sheets": ((), -59.0133840453461e-9, 2e-4, (1e-2, 5e-3, 2e-3, 1e-3)),
}
# name, sensor, models of both halves, tolerances, the finest one, which is the reference
CHAINS = (
    ("section", "biorob2018", ("planar", "planar"), (1e-1, 3e-2, 1e-2, 3e-3), 1e-3),
    ("space", "biorob2018-w15", ("block", "sheets"), (1e-1, 3e-2, 1e-2), 3e-3),
)


def mechanics(tolerances: Sequence[float]) -> list[Rung]:
    """Return the rungs of every mechanical model, from rest."""
    rungs = []
    for name, factory, changes, wrench, part, value, resolved in LOADS:
        sensor = load_sensor("biorob2018", changes)
        for tolerance in tolerances:
            forget()
            began = time.process_time()
            model: MechanicalModel = factory(sensor, tolerance)
            found = model.equilibrium(wrench)
            seconds = time.process_time() - began
            got = found.pose.d_h if part == "d_h" else 2 * MM - found.pose.d_v
            estimated = (found.error.d_h if part == "d_h" else found.error.d_v) / abs(got)
            rungs.append(Rung(name, f"{tolerance:g}", seconds, abs(got / value - 1), float(estimated), resolved))
    return rungs


def magnetics(rungs_of_each: int | None) -> list[Rung]:
    """Return the rungs of every magnetic model, one pose from the scene on."""
    rungs = []
    for name, (changes, delta_L, resolved, tolerances) in COILS.items():
        sensor = load_sensor("biorob2018", ['target.conductivity="58 MS/m"', *changes])
        for tolerance in tolerances[:rungs_of_each]:
            forget()
            began = time.process_time()
            found = MAGNETICS[name](sensor, tolerance).impedance(Pose(0.0, 2 * MM), 5e6)
            seconds = time.process_time() - began
            error = abs(float((found.L - found.L0)[0, 0]) / delta_L - 1)
            estimated = float(found.error_L.max()) / abs(delta_L)
            rungs.append(Rung(name, f"{tolerance:g}", seconds, error, estimated, resolved))
    return rungs


def chain(
    title: str, sensor: Sensor, models: tuple[str, str], tolerances: Sequence[float], finest: float, count: int
) -> tuple[list[Rung], list[str]]:
    """Return the rungs of the whole chain over a grid of loads, and how many loads' estimates hold at each."""
    chosen = dict(zip(("mechanics", "magnetics"), models, strict=True))
    F_x, F_z = np.linspace(-1.0, 1.0, count).tolist(), np.linspace(0.0, 4.0, count).tolist()
    rungs, remarks = [], []
    best = calibrate(sensor, F_x=F_x, F_z=F_z, tolerance=finest, **chosen)
    if not bool((best.status == "converged").all()):
        raise SystemExit(f"chain in {title}: the reference, tolerance {finest:g}, does not carry every load")
    scale = {name: float(np.ptp(best[f"{name}_percent"].to_numpy())) for name in ("L_v", "L_h")}
    for tolerance in tolerances:
        forget()
        began = time.process_time()
        data = calibrate(sensor, F_x=F_x, F_z=F_z, tolerance=tolerance, **chosen)
        seconds = time.process_time() - began
        for name, full in scale.items():
            true, estimated, resolved = points(data, best, name, full)
            if not np.any(true > _EXACT):
                remarks.append(f"{title}, {name} at {tolerance:g}: the answer of the reference itself, no point")
                continue
            largest = (float(item.max()) for item in (true, estimated, resolved))
            rungs.append(Rung(f"{title}, {name}", f"{tolerance:g}", seconds, *largest))
            loads_told = true > _EXACT  # L_h of a load without shear is zero by symmetry
            each = zip(true[loads_told], estimated[loads_told], resolved[loads_told], strict=True)
            single = [Rung("", "", 0.0, *map(float, one)) for one in each]
            held = sum(one.honest for one in single)
            remarks.append(f"{title}, {name} at {tolerance:g}: {held} of {len(single)} loads within a factor of 5")
    return rungs, remarks


def points(data: xr.Dataset, best: xr.Dataset, name: str, full: float) -> tuple[np.ndarray, ...]:
    """Return true and estimated errors of every load, and those of the reference, over full scale."""
    signal, error = f"{name}_percent", f"error_{name}_percent"
    found = (data[signal] - best[signal], data[error], best[error])
    return tuple(np.abs(item.to_numpy()).ravel() / full for item in found)


def main() -> None:
    """Run the ladders and write tables and picture."""
    coarse, folder = study_arguments(__doc__ or "")
    with threadpool_limits(limits=1):
        parts = {
            "mechanics: one load from rest": mechanics([2e-2, 1e-2] if coarse else [3e-2, 1e-2, 3e-3, 1e-3]),
            "magnetics: one pose from the scene on": magnetics(1 if coarse else None),
        }
        rungs: list[Rung] = []
        remarks: list[str] = []
        for title, name, models, tolerances, finest in CHAINS:
            ladder = ((3e-2,), 5e-3, 2) if coarse else (tolerances, finest, 5)
            found, told = chain(title, load_sensor(name), models, *ladder)
            rungs, remarks = rungs + found, remarks + told
        parts["chain: a calibration, of full scale"] = rungs
    draw_ladders(parts, folder / "error_against_time.png")
    print(write_rows(rung_rows(parts), folder / "error_against_time.csv"), *remarks, machine(), sep="\n")


if __name__ == "__main__":
    main()
