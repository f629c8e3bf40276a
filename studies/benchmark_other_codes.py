"""How long do FElupe and NGSolve take for the planar layer's combined load at 1 % of the pose, and this package?

A neo-Hookean layer 20 x 2 mm under a rigid 15 mm target, K = 1000 mu, 267 N/m shear and 4050 N/m normal force, all
on the same graded lines, on one thread, CPU time of the best of some runs, from making the mesh to the pose. Error: the
largest of d_h, sink and tilt at the target's end, over d_h, against the median of four families of NGSolve elements and
FElupe (bars: 0.5 % of d_h). FElupe: Q1P0 and Q2Q1, its line search and cutback, target by its multi-point constraint
with rotation (penalty 100 N/mm per node: nearer the reference than its default, as fast). NGSolve: Taylor-Hood, its
damped Newton, halved load steps, target by multipliers on the trace, UMFPACK. For both, meshes, load steps and
damping are searched; the fastest below 1 % counts.

Two ratios, like with like. "one solve": of every code the fastest mesh and settings, chosen by hindsight, without any
estimate of its error; for this package one Newton solve from rest on one mesh, elements and Newton's method of the
layer, J watched at the quadrature points only (the other codes do not look at it). "with an estimate": that mesh and
the one twice as fine for the others, the whole layer with its pair of meshes, its contact and its checks for this
package. Every run of this package begins with its caches empty.

Neither code is a dependency: install ``felupe`` and ``ngsolve`` beside the package to run it; what is missing is named
and left out. Run ``python studies/benchmark_other_codes.py [--coarse] --output DIR``.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from common.accuracy import forget
from threadpoolctl import threadpool_limits

from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.pad.section import Fineness, bonded_body, layer_scales
from sits_mech.mechanics.rest.body import rest
from sits_mech.mechanics.rest.newton import SETTLED, newton
from sits_mech.meshing.structured import graded_lines, matched_cells
from sits_mech.quantities import Array, Wrench
from sits_mech.scene.sensor import Sensor, load_sensor

MU, K, F_X, F_Z = 3e-2, 30.0, 0.267, 4.05  # MPa, N/mm; lengths in mm
POSE = np.array([0.985277906, 0.203230935, 0.002045246])  # d_h, sink [mm], tilt
OWN, PAIR = "sits_mech", "Q2P1 pair"
MEANS = "not installed, left out: pip install"


@dataclass(frozen=True)
class Line:
    """One way to solve: settings, CPU seconds, error, unknowns."""

    code: str
    element: str
    cells: int
    grading: float
    settings: str
    seconds: float
    error: float
    unknowns: int


Solve = Callable[[], tuple[Array, int]]  # pose d_h, sink, tilt; unknowns


def timed(code: str, element: str, cells: int, grading: float, settings: str, solve: Solve, runs: int) -> Line:
    """Return the best of some runs; what does not converge has no number for an error."""
    best, error, unknowns = np.inf, np.nan, 0
    for _ in range(runs):
        forget()
        began = time.process_time()
        try:
            pose, unknowns = solve()
        except Exception as failure:  # whatever stops another code
            return Line(code, element, cells, grading, f"{settings}: {type(failure).__name__}", np.inf, np.nan, 0)
        best = min(best, time.process_time() - began)
        error = float(np.max(np.abs(pose - POSE) * [1.0, 1.0, 7.5]) / POSE[0])
    return Line(code, element, cells, grading, settings, best, error, unknowns)


def lines_of(cells: int, grading: float) -> tuple[Array, Array]:
    """Return the mesh lines that this package's layer has, too [mm]."""
    breaks = [-5.0, -3.75, 3.75, 5.0]
    counts = [matched_cells(b - a, 1.0, cells, grading) for a, b in zip(breaks[:-1], breaks[1:], strict=True)]
    return 2.0 * graded_lines(breaks, counts, grading), 2.0 * graded_lines([0.0, 1.0], [cells], grading)


def pad() -> Sensor:
    """Return the layer and its target as a scene of this package."""
    material = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'
    sizes = ["elastomer.length=1.0", "target.load_height=0", 'target.width="15 mm"', material]
    return load_sensor("biorob2018", sizes)


def own_pose(sensor: Sensor, tolerance: float) -> tuple[Array, int]:
    """Return this package's pose, with its error estimate on two meshes."""
    found = planar_layer(sensor, tolerance).equilibrium(Wrench(1e3 * F_X, 1e3 * F_Z))
    pose = found.pose
    return np.array([1e3 * pose.d_h, 2.0 - 1e3 * pose.d_v, pose.alpha], dtype=float), found.report.unknowns


def own_solve(sensor: Sensor, cells: int, grading: float, split: bool) -> tuple[Array, int]:
    """Return this package's pose by one Newton solve from rest on one mesh, with corners split or not."""
    body = bonded_body(sensor, Fineness(cells, grading, split))
    state = newton(body, rest(body), layer_scales(sensor).load(Wrench(1e3 * F_X, 1e3 * F_Z))[:3]).state
    if not state.residual <= SETTLED or not state.min_J > 0.0:
        raise ArithmeticError(f"residual {state.residual:.1e}")
    return state.q * [2.0, -2.0, 1.0], len(body.free) + 3


def felupe_pose(element: str, cells: int, grading: float, steps: int) -> tuple[Array, int]:
    """Return FElupe's pose."""
    import felupe as fem

    x, z = lines_of(cells, grading)
    X, Z = np.meshgrid(x, z, indexing="ij")
    first = (np.arange(len(x) - 1)[:, None] * len(z) + np.arange(len(z) - 1)).ravel()
    quads = np.stack([first, first + len(z), first + len(z) + 1, first + 1], axis=1)
    mesh = fem.Mesh(np.stack([X.ravel(), Z.ravel()], axis=1), quads, "quad")
    if element == "Q2Q1":
        mesh = mesh.add_midpoints_edges().add_midpoints_faces()
    n = mesh.npoints
    mesh.update(points=np.vstack([mesh.points, [[0.0, 2.0], [0.0, 2.0]]]))
    mesh.points_without_cells = np.array([], dtype=int)
    if element == "Q1P0":
        field = fem.FieldContainer([fem.FieldPlaneStrain(fem.RegionQuad(mesh), dim=2)])
        solid = fem.SolidBodyNearlyIncompressible(fem.NeoHooke(mu=MU), field, bulk=K)
    else:
        dual = mesh.dual(points_per_cell=4, disconnect=False)
        field = fem.FieldsMixed(fem.RegionBiQuadraticQuad(mesh), n=3, planestrain=True, mesh=dual)
        solid = fem.SolidBody(fem.NearlyIncompressible(fem.NeoHooke(mu=MU), bulk=K), field)
    X, Z = mesh.points[:n].T
    top = np.flatnonzero((np.abs(Z - 2.0) < 1e-9) & (np.abs(X) < 7.5 + 1e-9))
    target = fem.MultiPointConstraint(field, top, centerpoint=n, rotationpoint=n + 1, multiplier=1e2)
    load, ground = fem.PointLoad(field, [n]), np.append(np.abs(Z) < 1e-9, [False, False])
    ramp = {load: [share * np.array([[F_X, -F_Z]]) for share in np.linspace(0.0, 1.0, steps + 1)]}
    step = fem.Step([solid, target, load], ramp=ramp, boundaries={"ground": fem.Boundary(field[0], mask=ground)})
    fem.Job([step], plugins=[fem.LinesearchPlugin(), fem.CutbackPlugin()]).evaluate(x0=field, verbose=0, tol=1e-6)
    (d_h, rise), (turn, _) = field[0].values[n], field[0].values[n + 1]
    return np.array([d_h, -rise, -turn]), sum(item.values.size for item in field.fields)


def netgen_mesh(x: Array, z: Array) -> Any:
    """Return a mesh of quadrilaterals with boundaries ground, target and free."""
    import ngsolve
    from netgen.meshing import Element1D, Element2D, FaceDescriptor, Mesh, MeshPoint, Pnt

    mesh = Mesh(dim=2)
    p = [[mesh.Add(MeshPoint(Pnt(float(a), float(b), 0.0))) for b in z] for a in x]
    mesh.Add(FaceDescriptor(surfnr=1, domin=1, bc=1))
    for i, j in product(range(len(x) - 1), range(len(z) - 1)):
        mesh.Add(Element2D(1, [p[i][j], p[i + 1][j], p[i + 1][j + 1], p[i][j + 1]]))
    for number, name in enumerate(("ground", "target", "free")):
        mesh.SetBCName(number, name)
    for i in range(len(x) - 1):
        mesh.Add(Element1D([p[i][0], p[i + 1][0]], index=1))
        mesh.Add(Element1D([p[i + 1][-1], p[i][-1]], index=2 if abs(x[i] + x[i + 1]) < 15.0 else 3))
    for j in range(len(z) - 1):
        mesh.Add(Element1D([p[0][j + 1], p[0][j]], index=3))
        mesh.Add(Element1D([p[-1][j], p[-1][j + 1]], index=3))
    return ngsolve.Mesh(mesh)


def ngsolve_pose(order: int, cells: int, grading: float, steps: int, damping: float) -> tuple[Array, int]:
    """Return NGSolve's pose."""
    import ngsolve as ng
    from ngsolve.solvers import Newton

    ng.SetNumThreads(1)
    mesh = netgen_mesh(*lines_of(cells, grading))
    trace = ng.Compress(ng.VectorH1(mesh, order=order, definedon=mesh.Boundaries("target")))
    number = ng.NumberSpace(mesh)
    bulk = [ng.VectorH1(mesh, order=order, dirichlet="ground"), ng.H1(mesh, order=order - 1)]
    space = ng.FESpace([*bulk, trace, number, number, number])
    u, p, force, d_h, rise, turn = space.TrialFunction()
    F = ng.Id(2) + ng.Grad(u)
    J, share = ng.Det(F), ng.Parameter(0.0)
    energy = 0.5 * MU * (J ** (-2 / 3) * (ng.InnerProduct(F, F) + 1) - 3) + p * (J - 1) - p * p / (2 * K)
    rigid = ng.CF((d_h + ng.x * (ng.cos(turn) - 1), rise - ng.x * ng.sin(turn)))
    load = share * (F_X * d_h - F_Z * rise) / 15.0
    form = ng.BilinearForm(space, symmetric=True)
    form += ng.Variation(energy.Compile() * ng.dx)
    form += ng.Variation((ng.InnerProduct(force, u.Trace() - rigid) - load).Compile() * ng.ds("target"))
    state = ng.GridFunction(space)
    settings = dict(maxit=25, maxerr=1e-7, inverse="umfpack", dampfactor=damping, printing=False)
    kept, at, step = state.vec.CreateVector(), 0.0, 1.0 / steps
    kept.data = state.vec
    while at < 1.0 and step > 1e-3:
        share.Set(min(1.0, at + step))
        try:
            failed, _ = Newton(form, state, freedofs=space.FreeDofs(), **settings)
        except Exception:  # its own type for a singular matrix is not public
            failed = 1
        if failed == 0 and np.isfinite(state.vec.Norm()):
            at, kept.data = min(1.0, at + step), state.vec
        else:
            state.vec.data, step = kept, 0.5 * step
    if at < 1.0:
        raise ArithmeticError(f"reached {at:.0%} of the load")
    return np.array([state.components[3].vec[0], -state.components[4].vec[0], state.components[5].vec[0]]), space.ndof


def search(coarse: bool) -> Iterator[Line]:
    """Yield this package's rungs, then the other codes' meshes and settings."""
    runs, gradings, counts = (1, (1.5,), (2,)) if coarse else (3, (1.0, 1.5), (2, 4))
    sensor, often = pad(), 2 * runs
    own_pose(sensor, 2e-2)  # what is imported late
    for tolerance in (2e-2, 1e-2):
        words = f"tolerance {tolerance:g}"
        yield timed(OWN, PAIR, 0, 1.5, words, lambda t=tolerance: own_pose(sensor, t), often)
    for cells, grading, split in product(counts, gradings, (False, True)):
        words, mesh = "corners split" if split else "corners whole", (cells, grading, split)
        yield timed(OWN, "Q2P1", cells, grading, words, lambda mesh=mesh: own_solve(sensor, *mesh), often)
    if find_spec("felupe") is None:
        print("felupe", MEANS, "felupe")
    else:
        kinds = [("Q2Q1", c) for c in counts] + [("Q1P0", c) for c in ((8,) if coarse else (8, 10))]
        for (element, cells), grading, steps in product(kinds, gradings, (1, 4)):
            case = (element, cells, grading, steps)
            yield timed("FElupe", *case[:3], f"{steps} steps", lambda case=case: felupe_pose(*case), runs)
    if find_spec("ngsolve") is None:
        print("ngsolve", MEANS, "ngsolve")
    else:
        for order, cells, grading, steps, damping in product((2, 3), counts, gradings, (1, 2), (1.0, 0.3)):
            if order == 3 and cells > 2:
                continue
            case = (order, cells, grading, steps, damping)
            words = f"{steps} steps, damping {damping:g}"
            name = f"Q{order}Q{order - 1}"
            yield timed("NGSolve", name, cells, grading, words, lambda case=case: ngsolve_pose(*case), runs)


def ratios(lines: list[Line]) -> Iterator[str]:
    """Yield how much longer the other codes take, by both measures."""
    good = [line for line in lines if line.error <= 1e-2]
    mine = [line for line in good if line.code == OWN]
    one = min((line for line in mine if line.element != PAIR), key=lambda line: line.seconds)
    pair_of_mine = min((line for line in mine if line.element == PAIR), key=lambda line: line.seconds)
    for line in (one, pair_of_mine):
        kind = f"{line.element}, {line.cells} cells, grading {line.grading:g}" if line is one else line.element
        yield f"{OWN}, {kind}, {line.settings}: {line.seconds:.3g} s, error {line.error:.2%}"
    for code in dict.fromkeys(line.code for line in good if line.code != OWN):
        best = min((line for line in good if line.code == code), key=lambda line: line.seconds)
        kin = [line for line in lines if (line.code, line.element) == (code, best.element)]
        finer = [line.seconds for line in kin if (line.cells, line.grading) == (2 * best.cells, best.grading)]
        pair = f"{(best.seconds + min(finer)) / pair_of_mine.seconds:.2g}" if finer else "not measured"
        yield (
            f"{code}, {best.element}, {best.cells} cells, {best.settings}: {best.seconds:.3g} s, error "
            f"{best.error:.2%}; ratio one solve {best.seconds / one.seconds:.2g}, with an estimate {pair}"
        )


def main() -> None:
    """Measure; write and print the table and the ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--coarse", action="store_true", help="one run of few meshes")
    parser.add_argument("--output", type=Path, default=Path("."))
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    lines = []
    with threadpool_limits(limits=1):
        for line in search(options.coarse):
            lines.append(line)
            print(*(f"{item:.3g}" if isinstance(item, float) else item for item in vars(line).values()), flush=True)
    with (options.output / "other_codes.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([vars(lines[0]).keys(), *(vars(line).values() for line in lines)])
    said = "\n".join(ratios(lines)) + "\n"
    (options.output / "other_codes.txt").write_text(said, encoding="utf-8")
    print(said)


if __name__ == "__main__":
    main()
