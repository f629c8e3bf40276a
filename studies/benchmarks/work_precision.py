"""Error against seconds of the four magnetic models, on one pose and on a thousand.

The published coils at 5 MHz, 2 mm below copper 0.2 mm thick; the errors are those of Delta L and R of that pose.
References: planar, NGSolve 6.2, p = 5, plate 8 mm wide (1e-6); axisymmetric, NGSolve 6.2, p = 6, coaxial disc of
3.5 mm radius (1e-6); three-dimensional, NGSolve 6.2 on two kinds of mesh, plate 8 x 8 mm (2e-4 of Delta L, 1e-3 of R).

Seconds are processor time. One pose: everything from the scene on, caches empty. A thousand: the same plus a
thousand poses within 5 % of the gap; a model that meshes every pose anew is timed on three and scaled.

Run ``python -m benchmarks.work_precision [--coarse] --output DIR``: writes CSV, Markdown and a picture.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from common.accuracy import Rung, draw_ladders, forget
from common.outputs import study_arguments, write_rows
from threadpoolctl import threadpool_limits

from sits_mech.chain.models import MAGNETICS
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import Sensor, load_sensor

GAP, FREQUENCY, POSES = 2e-3, 5e6, 1000
DISC = (
    'target={material="copper", shape="disc", diameter="7 mm", thickness="0.2 mm"}',
    'coils=[{name="C", centre=["0 mm", "0 mm"], layers=2, turns=12, inner_diameter="2.2 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}]',
)
# model: overrides of the published scene, Delta L1, R1 (SI; planar per metre), tolerances
CASES = {
    "planar": ((), -1.696012066246201e-05, 21.111396592136952, (1e-2, 1e-3, 1e-4, 1e-5)),
    "planar-fem": ((), -1.696012066246201e-05, 21.111396592136952, (1e-2, 1e-3, 1e-4, 1e-5)),
    "axisymmetric": (DISC, -1.722086964359416e-07, 0.11527379963961844, (1e-2, 1e-3, 1e-4)),
    "sheets": ((), -59.0133840453461e-9, 0.07347140328414503, (1e-2, 5e-3, 2e-3, 1e-3)),
}
RESOLVED = {"planar": 1e-6, "planar-fem": 1e-6, "axisymmetric": 1e-6, "sheets": 2e-4}  # errors of the references


@dataclass(frozen=True)
class Line:
    """One line of the table; errors relative, seconds of one and of a thousand poses."""

    model: str
    tolerance: float
    unknowns: int
    error_L: float
    estimated_L: float
    error_R: float
    estimated_R: float
    one_pose: float
    thousand_poses: float


def measure(name: str, sensor: Sensor, tolerance: float, delta_L: float, R: float) -> Line:
    """Return a model's line at a tolerance."""
    forget()
    began = time.process_time()
    model = MAGNETICS[name](sensor, tolerance)
    z = model.impedance(Pose(0.0, GAP), FREQUENCY)
    one = time.process_time() - began
    count = 3 if name == "planar-fem" else POSES
    began = time.process_time()
    model.impedance(Pose(0.0, GAP * np.linspace(1.0, 1.05, count)), FREQUENCY)
    many = one + (time.process_time() - began) * POSES / count
    errors = (abs((z.L - z.L0)[0, 0] / delta_L - 1), z.error_L.max() / abs(delta_L))
    errors += (abs(z.R[0, 0] / R - 1), z.error_R.max() / R)
    return Line(name, tolerance, z.report.unknowns, *(float(error) for error in errors), one, many)


def main() -> None:
    """Run the ladders; write table and picture."""
    coarse, folder = study_arguments(__doc__ or "", timed=True)
    lines = []
    with threadpool_limits(limits=1):
        for name, (overrides, delta_L, R, tolerances) in CASES.items():
            sensor = load_sensor("biorob2018", ['target.conductivity="58 MS/m"', *overrides])
            for tolerance in tolerances[:1] if coarse else tolerances:
                lines.append(measure(name, sensor, tolerance, delta_L, R))
                print(*vars(lines[-1]).values(), flush=True)
    write_rows([vars(line) for line in lines], folder / "work_precision.csv")
    panels: dict[str, list[Rung]] = {"one pose from the scene on": [], "a thousand poses": []}
    for x in lines:
        for seconds, rungs in zip((x.one_pose, x.thousand_poses), panels.values(), strict=True):
            rungs.append(Rung(x.model, x.tolerance, seconds, x.error_L, x.estimated_L, RESOLVED[x.model]))
    draw_ladders(panels, folder / "work_precision.png")


if __name__ == "__main__":
    main()
