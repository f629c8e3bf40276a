"""How far is the planar finite element model from independent numbers, and what does it cost?

References: NGSolve 6.2, order 5, open boundary at 20 m, copper of 58 MS/m, 8 x 0.2 mm, two coils of 2 x 12 turns
(1e-6). Each row: errors of Delta L and R over their largest entries, the model's own estimate, unknowns, seconds for
one pose on one core, the mesh included. Run ``python -m benchmarks.planar_fem [--coarse] --output DIR``.
"""

from __future__ import annotations

import numpy as np
from common.outputs import study_arguments, write_rows

from sits_mech.magnetics.field import planar_fem
from sits_mech.quantities import Pose
from sits_mech.report.pictures.fields import CURRENT_HEIGHT, draw_current, draw_potential, potential_height
from sits_mech.report.pictures.style import new_figure, save_figure
from sits_mech.scene.sensor import Sensor, changed, load_sensor

# d_h, d_v [mm], f [Hz], radius where A = 0 [mm] (None: no net current), Delta L1, L2, M12 [H/m], R1, R2 [ohm/m]
ROWS = (
    (0, 1, 5e3, None, -1.2689598921607e-06, -1.2689598921607e-06, 6.3923157554979e-07, 0.18784622982, 0.18784622982),
    (0, 1, 5e6, None, -3.9944831529402e-05, -3.9944831529402e-05, 1.3991454285200e-05, 51.836221913, 51.836221913),
    (0, 2, 5e3, None, -6.0009274427628e-07, -6.0009274427628e-07, 3.4424118997161e-07, 0.08421475240, 0.08421475240),
    (0, 2, 5e6, None, -1.6960120662462e-05, -1.6960120662462e-05, 7.6432194391580e-06, 21.111396592, 21.111396592),
    (0, 5, 5e3, None, -3.1700495058595e-07, -3.1700495058595e-07, -2.1331758309677e-07, 0.02737209141, 0.02737209141),
    (0, 5, 5e6, None, -3.5703584183264e-06, -3.5703584183264e-06, -9.2706772555687e-07, 3.0513129890, 3.0513129890),
    (2, 2, 5e3, None, -5.2325500573478e-07, -5.9973678462590e-06, 1.6667088439393e-06, 0.03841497493, 0.49201650576),
    (2, 2, 5e6, None, -4.5597853943941e-06, -5.5316861111066e-05, 1.2581211484302e-05, 6.7166619081, 33.251718933),
    (0, 2, 5e6, 25.0, -3.0211498005433e-05, -3.0211498005433e-05, 2.2070338154879e-05, 16.818854984, 16.818854984),
    (0, 2, 5e6, 50.0, -2.7611887226104e-05, -2.7611887226104e-05, 1.8605208946658e-05, 17.773919865, 17.773919865),
    (0, 2, 5e6, 100.0, -2.5787832867868e-05, -2.5787832867868e-05, 1.6549498114230e-05, 18.297042268, 18.297042268),
    (0, 2, 5e6, 1000.0, -2.2516436114938e-05, -2.2516436114938e-05, 1.3200321939111e-05, 19.197114098, 19.197114098),
)
COLUMNS = (
    "tolerance", "d_h_mm", "d_v_mm", "frequency", "boundary_mm", "error_L", "error_R", "estimate", "unknowns",
    "seconds",
)


def scene(radius: float | None) -> Sensor:
    """The published sensor with the references' copper, and with a return of net current if `radius` [mm] is given."""
    overrides = ['target.conductivity="58 MS/m"']
    if radius is not None:
        overrides += ['target.net_current="free"', f'target.planar_boundary_radius="{radius} mm"']
    return changed(load_sensor("biorob2018"), overrides)


def measure(row: tuple[float | None, ...], tolerance: float) -> dict[str, object]:
    """One line of the table."""
    d_h, d_v, frequency, radius, L1, L2, M, R1, R2 = row
    found = planar_fem(scene(radius), tolerance).impedance(Pose(d_h * 1e-3, d_v * 1e-3), frequency)
    delta_L, R = np.array([[L1, M], [M, L2]]), np.array([R1, R2])
    error_L = np.abs(found.L - found.L0 - delta_L).max() / np.abs(delta_L).max()
    error_R = np.abs(np.diag(found.R) - R).max() / R.max()
    report = found.report
    values = (tolerance, d_h, d_v, frequency, radius, error_L, error_R, report.estimated_error)
    return dict(zip(COLUMNS, (*values, report.unknowns, report.seconds), strict=True))


def main() -> None:
    """Write the table and the pictures of a moved and turned target."""
    coarse, folder = study_arguments(__doc__ or "")
    tolerances, rows = ((1e-2,), ROWS[:2]) if coarse else ((1e-2, 1e-3, 1e-4, 1e-5), ROWS)
    print(write_rows([measure(row, tolerance) for tolerance in tolerances for row in rows], folder / "planar_fem.csv"))
    wide = changed(scene(None), ['target.width="15 mm"'])
    field = planar_fem(wide).field(Pose(2e-3, 4e-3, np.radians(10.0)), 5e6)
    if field is not None:
        driven = np.array([0.0, 1.017e-3])
        with new_figure(potential_height(field)) as (figure, (axes,)):
            draw_potential(axes, field, driven)
        save_figure(figure, folder / "flux_lines.png")
        with new_figure(CURRENT_HEIGHT) as (figure, (axes,)):
            draw_current(axes, field, driven)
        save_figure(figure, folder / "current_density.png")


if __name__ == "__main__":
    main()
