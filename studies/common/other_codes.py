"""Which pose do FElupe and NGSolve find for a pad's load, on the lines of this package's own meshes?

FElupe: Q1P0, or Q2Q1 with a continuous pressure, its line search and cutback, the target by its multi-point constraint
with rotation (penalty 100 N/mm per node: nearer the reference than its default, as fast). NGSolve, in the plane:
Taylor-Hood, its damped Newton, halved load steps, target by multipliers on the trace, UMFPACK. NGSolve, in the plane
and in space: Q_k displacements with pressures P_(k-1) condensed in the element, the target eliminated, its own sparse
Cholesky (ngsolve_pad.py). In space half the pad is meshed, as the load allows. Lengths in mm, forces in N, stresses in
MPa, in plane strain for a millimetre of depth.

Neither code is a dependency: each is imported where it is asked.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from common.ngsolve_mesh import family_lines, product_plan, section_mesh, solid_mesh
from common.ngsolve_pad import Law, Pad
from common.reference_cases import ECOFLEX, Case

from sits_mech.mechanics.pad.fillet import graded_lines, matched_cells
from sits_mech.quantities import Array

Solved = tuple[Array, int]  # pose d_h, sink, alpha; unknowns


@dataclass(frozen=True)
class Question:
    """A pad under a combined load, and where its target goes.

    Attributes
    ----------
    case : Case
        Neo-Hookean or of the catalogue's ecoflex-00-30, without a moment.
    moved : ndarray, shape (3,)
        d_h, sink [mm], alpha of the reference.
    sure : float
        Error of the reference, over the size of the displacement.
    """

    case: Case
    moved: Array
    sure: float

    @property
    def spatial(self) -> bool:
        """Whether it is a pad in three dimensions."""
        return self.case.kind == "box"

    def away(self, pose: Array) -> float:
        """Return how far a pose is from the reference, over the displacement, an angle at the target's end."""
        lever = np.array([1.0, 1.0, 0.5 * self.case.target[0]])
        return float(np.max(np.abs(pose - self.moved) * lever) / np.max(np.abs(self.moved) * lever))

    def lines(self, cells: int, grading: float) -> list[Array]:
        """Return the mesh lines that this package's pad has, too: along x, along y from the middle on in space, z."""
        t = self.case.thickness
        if self.spatial:
            return list(family_lines(self.case.pad, self.case.target, t, cells, grading))
        W, w = 0.5 * self.case.pad[0] / t, 0.5 * self.case.target[0] / t
        breaks = [-W, -w, w, W]
        counts = [matched_cells(b - a, cells, grading) for a, b in zip(breaks[:-1], breaks[1:], strict=True)]
        return [t * graded_lines(breaks, counts, grading), t * graded_lines([0.0, 1.0], [cells], grading)]


def felupe_pose(asked: Question, element: str, cells: int, grading: float, steps: int) -> Solved:
    """Return FElupe's pose."""
    import felupe as fem

    case, t = asked.case, asked.case.thickness
    mesh = fem.Grid(*asked.lines(cells, grading))
    if element == "Q2Q1":
        mesh = mesh.add_midpoints_edges().add_midpoints_faces()
        mesh = mesh.add_midpoints_volumes() if asked.spatial else mesh
    n, centre = mesh.npoints, [0.0] * (mesh.dim - 1) + [t + case.height]
    mesh.update(points=np.vstack([mesh.points, [centre, centre]]))
    mesh.points_without_cells = np.array([], dtype=int)
    field, solid = _felupe_solid(fem, mesh, element, case)
    places, own = mesh.points, np.arange(n + 2) < n
    under = (np.abs(places[:, :-1]) < 0.5 * np.array(case.target[: mesh.dim - 1]) + 1e-9).all(axis=1)
    top = np.flatnonzero(own & (np.abs(places[:, -1] - t) < 1e-9) & under)
    target = fem.MultiPointConstraint(field, top, centerpoint=n, rotationpoint=n + 1, multiplier=1e2)
    bounds = {"ground": fem.Boundary(field[0], mask=own & (np.abs(places[:, -1]) < 1e-9))}
    force = (0.5 if asked.spatial else 1e-3) * np.array([case.load[0], *[0.0] * (mesh.dim - 2), -case.load[1]])
    if asked.spatial:
        in_plane = (np.abs(places[:, 1]) < 1e-9) & (np.arange(n + 2) <= n)
        bounds["mirror"] = fem.Boundary(field[0], mask=in_plane, skip=(True, False, True))
        bounds["upright"] = fem.Boundary(field[0], mask=np.arange(n + 2) > n, skip=(False, True, False))
    load = fem.PointLoad(field, [n])
    ramp = {load: [share * force[None] for share in np.linspace(0.0, 1.0, steps + 1)]}
    step = fem.Step([solid, target, load], ramp=ramp, boundaries=bounds)
    fem.Job([step], plugins=[fem.LinesearchPlugin(), fem.CutbackPlugin()]).evaluate(x0=field, verbose=0, tol=1e-6)
    moved, turn = field[0].values[n], field[0].values[n + 1]
    alpha = turn[1] if asked.spatial else -turn[0]
    d_h, rise = moved[0] - case.height * np.sin(alpha), moved[-1] + case.height * (1.0 - np.cos(alpha))
    return np.array([d_h, -rise, alpha]), sum(item.values.size for item in field.fields)


def _felupe_solid(fem: Any, mesh: Any, element: str, case: Case) -> tuple[Any, Any]:
    """Return FElupe's field and body of silicone."""
    mu, spatial = 1e-3 * case.mu, mesh.dim == 3
    law = _felupe_yeoh(fem, mu, 2e-6 * ECOFLEX[1]) if case.law == "ecoflex" else fem.NeoHooke(mu=mu)
    K = case.K * mu
    if element == "Q1P0":
        region = fem.RegionHexahedron(mesh) if spatial else fem.RegionQuad(mesh)
        one = fem.Field(region, dim=3) if spatial else fem.FieldPlaneStrain(region, dim=2)
        field = fem.FieldContainer([one])
        return field, fem.SolidBodyNearlyIncompressible(law, field, bulk=K)
    dual = mesh.dual(points_per_cell=8 if spatial else 4, disconnect=False)
    region = fem.RegionTriQuadraticHexahedron(mesh) if spatial else fem.RegionBiQuadraticQuad(mesh)
    field = fem.FieldsMixed(region, n=3, planestrain=not spatial, mesh=dual)
    return field, fem.SolidBody(fem.NearlyIncompressible(law, bulk=K), field)


def _felupe_yeoh(fem: Any, mu: float, second: float) -> Any:
    """Return ``mu psi + 2 second psi^2``, psi the neo-Hookean (I1 - 3)/2, by FElupe's own derivatives of psi."""

    class Yeoh(fem.NeoHooke):  # type: ignore[misc, name-defined]
        """FElupe's neo-Hookean law of modulus 1, and its square."""

        def gradient(self, x: Any, *args: Any, **more: Any) -> Any:
            """First derivative by F."""
            slope = mu + 4.0 * second * super().function(x)[0]
            P, *state = super().gradient(x)
            return [slope * P, *state]

        def hessian(self, x: Any, *args: Any, **more: Any) -> Any:
            """Second derivative by F."""
            slope = mu + 4.0 * second * super().function(x)[0]
            P = super().gradient(x)[0]
            return [slope * super().hessian(x)[0] + 4.0 * second * np.einsum("ij...,kl...->ijkl...", P, P)]

    return Yeoh(mu=1.0)


def condensed_pose(asked: Question, order: int, cells: int, grading: float, steps: int) -> Solved:
    """Return NGSolve's pose by condensed pressures and an eliminated target."""
    import ngsolve as ng

    ng.SetNumThreads(1)
    case, lines = asked.case, asked.lines(cells, grading)
    half = [0.5 * size for size in case.target]
    if asked.spatial:
        mesh = solid_mesh(product_plan(lines[0], lines[1], (half[0], half[1])), lines[2])
    else:
        mesh = section_mesh(*lines, half[0])
    kind, share = ("solid", 0.5) if asked.spatial else ("plane", 1.0)
    pad = Pad(kind, mesh, order, Law(case.energy, case.K), share, (0, 1, 2), case.height, complete=True)
    load = np.array(case.load) / case.mu  # kPa = mN/mm^2; N/m = mN/mm
    q = pad.solve(1e3 * load if asked.spatial else load, steps)
    return np.array([q[0], -q[1], q[2]]), pad.space.ndof


def taylor_hood_pose(asked: Question, order: int, cells: int, grading: float, steps: int, damping: float) -> Solved:
    """Return NGSolve's pose in plane strain by Taylor-Hood elements and multipliers on the target."""
    import ngsolve as ng
    from ngsolve.solvers import Newton

    ng.SetNumThreads(1)
    case, mu = asked.case, 1e-3 * asked.case.mu
    K, (F_x, F_z), width = case.K * mu, 1e-3 * np.array(case.load[:2]), case.target[0]
    mesh = section_mesh(*asked.lines(cells, grading), 0.5 * width)
    trace = ng.Compress(ng.VectorH1(mesh, order=order, definedon=mesh.Boundaries("target")))
    number = ng.NumberSpace(mesh)
    bulk = [ng.VectorH1(mesh, order=order, dirichlet="ground"), ng.H1(mesh, order=order - 1)]
    space = ng.FESpace([*bulk, trace, number, number, number])
    u, p, force, d_h, rise, turn = space.TrialFunction()
    F = ng.Id(2) + ng.Grad(u)
    J, share = ng.Det(F), ng.Parameter(0.0)
    energy = 0.5 * mu * (J ** (-2 / 3) * (ng.InnerProduct(F, F) + 1) - 3) + p * (J - 1) - p * p / (2 * K)
    rigid = ng.CF((d_h + ng.x * (ng.cos(turn) - 1), rise - ng.x * ng.sin(turn)))
    load = share * (F_x * d_h - F_z * rise) / width
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
