"""How far is the planar layer from independent numbers, and what does it cost?

References: finite strain, NGSolve 6.2 (four families of elements, high order) and FElupe 11.3, median and largest
deviation of a family, none with contact, which is left out here, too; small strain, graded P2-P1 linear finite
elements (2e-5 or better at S = 2). The stiffnesses of layers and pads are factored and solved beside SuperLU, its order
of elimination found once, too: processor time. Run
``python -m benchmarks.mechanics [--coarse] --output DIR``.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np
from common.elimination import memory_of
from scipy.sparse.linalg import splu

from sits_mech.chain.interpolate import loads_of
from sits_mech.mechanics.element.assembly import pattern
from sits_mech.mechanics.element.kernel import element_stiffness
from sits_mech.mechanics.equilibrium.body import border, rest
from sits_mech.mechanics.layer import PlanarLayer, planar_layer
from sits_mech.mechanics.linear import linear_layer
from sits_mech.mechanics.loads import settle
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.mechanics.pad.solid import bonded_block
from sits_mech.mechanics.symmetry import Symmetry
from sits_mech.quantities import SolveReport, Wrench
from sits_mech.scene.sensor import Sensor, load_sensor
from sits_mech.threads import one_thread

Result = TypeVar("Result")

MM = 1e-3
SUPERLU = {"options": {"SymmetricMode": True}, "diag_pivot_thresh": 0.01}
# W, w, t [mm]; F_x, F_z [N/m]; M clockwise [N]; d_h, sink [mm], alpha clockwise; their bars.
POSES = [
    (20, 15, 2, 0, 1810, 0, (0.0, 0.100264069, 0.0), (0.0, 0.000508300, 0.0)),
    (20, 15, 2, 267, 4050, 0, (0.985277906, 0.203230935, 0.002045246), (0.004514500, 0.003999102, 0.000501722)),
    (20, 15, 2, 0, 0, -1.75, (0.045158340, -0.004511318, -0.020319573), (0.000537356, 0.0000380463, 0.000129518)),
    (20, 15, 2, 53.9, 0, 0, (0.200583815, -0.000121460, -0.001356579), (0.0000798167, 9.75386e-6, 8.5427e-6)),
    (15, 15, 3, 0, 709, 0, (0.0, 0.153379047, 0.0), (0.0, 0.000564286, 0.0)),
    (15, 15, 3, 42.5, 0, 0, (0.300828925, 0.000735818, 0.002526180), (0.000136003, 4.51254e-6, 5.25480e-6)),
    (15, 15, 3, 213, 0, 0, (1.502045028, 0.018176537, 0.013724642), (0.000702889, 0.000523238, 0.000170504)),
]
STRIPS = [  # S, K / mu, E_c in shear moduli, E_b in shear moduli where it is known
    (1, 1e7, 8.0088, 5.0826), (2, 1e7, 19.4304, 7.365), (3.75, 1e7, 58.627, 15.104), (4, 1e7, 66.226, None),
    (5.5, 1e7, 122.315, 27.715), (7.5, 1e7, 225.1, 48.119), (15, 1e7, 895.5, 181.61),
    (2, 1e4, 19.395, None), (2, 1e3, 19.084, None), (2, 1e2, 16.486, None),
    (3.75, 1e4, 58.247, None), (3.75, 1e3, 55.042, None), (3.75, 1e2, 35.842, None),
    (5.5, 1e4, 120.6, None), (5.5, 1e3, 107.15, None), (5.5, 1e2, 51.57, None),
]
POSE_HEADER = [
    "W_mm", "w_mm", "t_mm", "F_x", "F_z", "M", "tolerance", "d_h_over_bar", "sink_over_bar", "alpha_over_bar",
    "estimated", "min_J", "unknowns", "solves", "seconds",
]
SOLVER_HEADER = [
    "model", "cells", "unknowns", "stiffness_s", "order_s", "factor_s", "solve_s", "factor_MB", "memory_MB",
    "lu_order_s", "lu_factor_s", "lu_solve_s", "lu_factor_MB", "difference",
]
STRIP_HEADER = ["S", "K_over_mu", "E_c_error", "k_x_error", "E_b_error", "unknowns", "seconds"]


def make_pad(W: float, w: float, t: float, mu: float = 3e4, K: float = 3e7, *, contact: str = "auto") -> Sensor:
    """Return a neo-Hookean pad a metre long [mm, Pa]: newtons are newtons per metre, acting at the bonded face."""
    material = f'elastomer.material={{law="neo-hookean", shear_modulus={mu}, bulk_modulus={K}}}'
    sizes = [f'elastomer.width="{W} mm"', f'elastomer.thickness="{t} mm"', f'target.width="{w} mm"']
    more = ["elastomer.length=1.0", "target.load_height=0", f'elastomer.contact="{contact}"', material]
    return load_sensor("biorob2018", [*more, *sizes])


def pose_row(
    tolerance: float, case: tuple[float, ...], pose: tuple[float, ...], bar: tuple[float, ...]
) -> list[object]:
    """Return one row: deviation from the reference over its bar, or over 0.5 % where the bar is smaller."""
    W, w, t, F_x, F_z, M = case
    layer = planar_layer(make_pad(W, w, t, contact="never"), tolerance)
    found = layer.equilibrium(Wrench(F_x, F_z, M))
    sink = layer.sensor.elastomer.thickness - found.pose.d_v if layer.sensor.elastomer is not None else np.nan
    away = np.array([found.pose.d_h / MM, sink / MM, found.pose.alpha]) - pose
    share = away / np.maximum(np.maximum(bar, 0.005 * np.abs(pose)), 1e-9)
    report: SolveReport = found.report
    sizes = (report.estimated_error, report.min_J, report.unknowns, report.iterations, report.seconds)
    return [*case, tolerance, *(float(value) for value in share), *sizes]


def strip_row(S: float, K: float, E_c: float, E_b: float | None) -> list[object]:
    """Return one row: relative errors of the stiffnesses at rest."""
    w, began = 2.0 * S, time.perf_counter()
    layer = linear_layer(make_pad(1e3 * w, 1e3 * w, 1e3, 1.0, K), 1e-3)
    k = layer.stiffness[0]
    seconds = time.perf_counter() - began
    turn = np.array([0.5, 0.0, 1.0])  # about mid-height
    shear = k[0, 0] / (w - 0.2308) - 1.0 if K >= 1e7 else np.nan
    tilt = 12.0 * turn @ k @ turn / w**3 / E_b - 1.0 if E_b is not None else np.nan
    unknowns = len(layer.levels.maker(len(layer.compliances) - 1).free) + 3
    return [S, K, float(k[1, 1] / w / E_c - 1.0), float(shear), float(tilt), unknowns, seconds]


def grid_seconds(layer: PlanarLayer, points: int, share: float = 1.0) -> tuple[float, float]:
    """Return the seconds of a square grid of a share of the catalogued sensor's loads, in all and of the slowest."""
    shear, normal = np.linspace(-share, share, points), np.linspace(0.0, 4.0 * share, points)
    forces = {"F_x": shear.tolist(), "F_z": normal.tolist()}
    began = time.perf_counter()
    rows = settle(layer, loads_of(forces), symmetry=Symmetry())
    return time.perf_counter() - began, max(one.seconds for one in rows.values())


def timed(call: Callable[[], Result]) -> tuple[float, Result]:
    """Return the processor time of the second call, and what it returns: the first one warms the caches."""
    call()
    began = time.process_time()
    found = call()
    return time.process_time() - began, found


@one_thread
def solver_row(model: str, cells: int) -> list[object]:
    """Return one row: a stiffness at rest factored and solved for the three sides of the target, both ways."""
    body = (
        bonded_body(load_sensor("biorob2018"), SectionFineness(cells, 1.5)) if model == "section"
        else bonded_block(load_sensor("biorob2018-w15"), cells, 2.5, 0.0).body
    )
    at_rest = rest(body)
    stiffness, made = timed(lambda: element_stiffness(body.mesh, body.laws, at_rest.u, at_rest.p))
    numbers, (values, edge) = (body.mesh.dofs,), ((made,), border(body.mesh, body.bonded))
    order, own = timed(lambda: pattern(body.mesh, numbers, body.free, edge))
    sides, _ = own.sides(values, np.eye(len(edge))[:, :3])
    factor, made_of = timed(lambda: own.factored(values))
    if made_of is None:
        raise ValueError(f"{model}, {cells} cells: the stiffness at rest is singular")
    solving, found = timed(lambda: made_of.solve(sides))
    memory = memory_of(own)
    K = own.matrix(values)
    lu_order, first = timed(lambda: splu(K, **SUPERLU, permc_spec="MMD_AT_PLUS_A"))
    place = np.argsort(first.perm_c)
    sorted_K = K[place][:, place].tocsc()
    lu_factor, lu = timed(lambda: splu(sorted_K, **SUPERLU, permc_spec="NATURAL"))
    lu_solving, other = timed(lambda: lu.solve(sides[place]))
    away = float(np.abs(found[place] - other).max() / np.abs(other).max())
    return [
        model, cells, len(body.free), stiffness, order, factor, solving, memory.factor / 1e6, sum(memory) / 1e6,
        lu_order - lu_factor, lu_factor, lu_solving, 12e-6 * lu.nnz, away,
    ]


def write(path: Path, header: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """Write a table and print it."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(rows)
    print(*header)
    for row in rows:
        print(*(f"{item:.2g}" if isinstance(item, float) else item for item in row))


def main() -> None:
    """Write the tables and print them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--coarse", action="store_true", help="two poses, two strips, 3 x 3 slight loads")
    parser.add_argument("--output", type=Path, default=Path("."))
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    tolerances, poses, strips = ((1e-2,), POSES[3:5], STRIPS[:2]) if options.coarse else ((1e-2, 1e-3), POSES, STRIPS)
    rows = [pose_row(tolerance, case[:6], case[6], case[7]) for tolerance in tolerances for case in poses]
    write(options.output / "mechanics_poses.csv", POSE_HEADER, rows)
    write(options.output / "mechanics_strips.csv", STRIP_HEADER, [strip_row(*strip) for strip in strips])
    sizes = {"section": (4,), "block": (1, 2)} if options.coarse else {"section": (4, 8, 16), "block": (1, 2, 3, 4, 5)}
    solved = [solver_row(model, cells) for model, every in sizes.items() for cells in every]
    write(options.output / "mechanics_solver.csv", SOLVER_HEADER, solved)
    points, share = (3, 0.2) if options.coarse else (9, 1.0)
    whole, slowest = grid_seconds(planar_layer(load_sensor("biorob2018"), 1e-2), points, share)
    words = f"{points} x {points} loads up to {share:g} and {4.0 * share:g} N on biorob2018 at 1e-2"
    print(f"{words}: {whole:.2f} s, slowest {slowest:.2f} s")


if __name__ == "__main__":
    main()
