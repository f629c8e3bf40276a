"""How far does a sphere sink into the cover of a disc on a cylinder, and the disc with it? Another code's answer.

NGSolve about the axis at finite strain, on triangles, u in P_3 and pressures p in P_2, both continuous (Taylor, Hood):
saddle point of

    int (mu/2 (J^(-2/3) (|F|^2 + F_tt^2) - 3) + p (J - 1) - p^2/(2 K)) r  +  int_top eps/2 max(d, 0)^2 r,

two silicones, the disc a gap whose boundary moves by one unknown, free of force; d how deep a
point of the top lies in a sphere that is put a given depth below the face at rest. Its force is that of the second
term; by two eps, ten times apart, it is off by the depth p/eps, a thousandth of the depths here. Nothing of this
package's elements, laws, contact or Newton's method is used. Lengths in mm, moduli in kPa, forces in mN.

Prints depth, force and sink of the disc by meshes with smaller cells at edges and under the sphere. NGSolve is no
dependency of the package; the numbers stand in tests/mechanics/test_cover_touch.py.

Run ``python -m common.ngsolve_cover_touch`` in studies (some minutes).
"""

from __future__ import annotations

import sys
from typing import Any, NamedTuple

import numpy as np

PARTS = (0.1, 0.2, 0.33)  # of the cover's thickness


class Case(NamedTuple):
    """A pad, its target and its cover under a sphere [mm, kPa]."""

    pad: float = 6.0  # radius
    thick: float = 2.0
    target: float = 4.0  # radius
    rim: float = 0.2  # its thickness
    over: float = 1.0  # of the cover above it
    hang: float = 1.5  # and beside it
    sphere: float = 10.0  # radius
    mu: tuple[float, float] = (30.0, 90.0)  # pad, cover
    K: tuple[float, float] = (30e3, 90e3)


CASES = {"wide sphere": Case(), "soft cover": Case(over=2.0, sphere=4.0, mu=(60.0, 30.0), K=(60e3, 30e3))}


def pressed(case: Case, size: float, eps: float) -> list[tuple[float, float, float]]:
    """Return depth [mm], force [mN] and sink [mm] by cells of a size under the sphere, a fifth of it at edges."""
    import ngsolve as ng
    from netgen.occ import Glue, OCCGeometry, WorkPlane

    top = case.thick + case.rim + case.over
    wide = case.target + case.hang
    pad = WorkPlane().Rectangle(case.pad, case.thick).Face()
    over = WorkPlane().MoveTo(0, case.thick).Rectangle(wide, case.rim + case.over).Face()
    over = over - WorkPlane().MoveTo(0, case.thick).Rectangle(case.target, case.rim).Face()
    pad, target = pad - over, (case.thick - 1e-6, case.thick + case.rim + 1e-6)
    pad.faces.name, over.faces.name = "pad", "cover"
    shape = Glue([pad, over])
    for edge in shape.edges:
        x, y = edge.center.x, edge.center.y
        on = target[0] < y < target[1] and x < case.target + 1e-6 and x > 1e-6
        on = on and not (abs(x - case.target) < 1e-6 and y > target[1])
        edge.name = "axis" if x < 1e-6 else "ground" if y < 1e-6 else "top" if y > top - 1e-6 else "free"
        edge.name = "target" if on and edge.name == "free" else edge.name
        edge.maxh = size if edge.name == "top" else 1.0
    for vertex in shape.vertices:
        x, y = vertex.p.x, vertex.p.y
        if (abs(x - case.target) < 1e-6 and target[0] < y < target[1]) or (x > wide - 1e-6 and y < top - 1e-6):
            vertex.maxh = 0.2 * size
    mesh = ng.Mesh(OCCGeometry(shape, dim=2).GenerateMesh(maxh=2.0 * size, grading=0.3))
    u_space = ng.VectorH1(mesh, order=3, dirichlet="ground", dirichletx="axis|target", dirichlety="ground|target")
    space = u_space * ng.H1(mesh, order=2)
    u, p = space.TrialFunction()
    mu, K = (mesh.MaterialCF(dict(zip(("pad", "cover"), each, strict=True))) for each in (case.mu, case.K))
    F, hoop = ng.Id(2) + ng.Grad(u), 1 + u[0] / ng.x
    J = ng.Det(F) * hoop
    energy = mu / 2 * (J ** (-2 / 3) * (ng.InnerProduct(F, F) + hoop**2) - 3) + p * (J - 1) - p * p / (2 * K)
    depth = ng.Parameter(0.0)

    def behind(moved: Any) -> tuple[Any, Any]:
        """How deep points lie in the sphere."""
        r, z = ng.x + moved[0], ng.y + moved[1] - (top - depth + case.sphere)
        d = case.sphere - ng.sqrt(r * r + z * z)
        return ng.IfPos(d, d, 0.0), z

    form = ng.BilinearForm(space, symmetric=True)
    form += ng.Variation((energy * ng.x).Compile() * ng.dx(bonus_intorder=2))
    form += ng.Variation((eps / 2 * behind(u.Trace())[0] ** 2 * ng.x).Compile() * ng.ds("top", bonus_intorder=6))
    state, up, found = ng.GridFunction(space), ng.GridFunction(space), []
    up.components[0].Set((0.0, 1.0), definedon=mesh.Boundaries("target"))
    kept, residual, step, image = (state.vec.CreateVector() for _ in range(4))
    at, further = 0.0, 0.02 * case.over
    for goal in (part * case.over for part in PARTS):
        while at < goal - 1e-9:
            there = min(goal, at + further)
            depth.Set(there)
            kept.data = state.vec
            done = False
            for _ in range(25):
                form.Apply(state.vec, residual)
                form.AssembleLinearization(state.vec)
                try:
                    inverse = form.mat.Inverse(space.FreeDofs(), inverse="umfpack")
                except Exception:  # singular: its own type is not public
                    break
                image.data = form.mat * up.vec
                way = up.vec.CreateVector()
                way.data = up.vec - inverse * image
                image.data = form.mat * way
                step.data = inverse * residual + float(way.InnerProduct(residual) / up.vec.InnerProduct(image)) * way
                state.vec.data -= step
                size_of_step = float(step.Norm()) / max(float(state.vec.Norm()), 1e-12)
                if not np.isfinite(size_of_step):
                    break
                if size_of_step < 1e-9:
                    done = True
                    break
            if done:
                at, further = there, min(1.5 * further, 0.04 * case.over)
            else:
                state.vec.data, further = kept, 0.5 * further
                if further < 1e-5:
                    raise ArithmeticError(f"reached a depth of {at} mm")
        d, z = behind(state.components[0])
        pressure = 2 * np.pi * eps * d * (-z / (case.sphere - d)) * ng.x
        own = ng.Integrate(pressure, mesh, definedon=mesh.Boundaries("top"), order=12)
        around = mesh.Boundaries("target")
        rises, length = (ng.Integrate(each, mesh, definedon=around) for each in (state.components[0][1], ng.CF(1.0)))
        sink = -rises / length
        found.append((goal, own, sink))
    sys.stdout.write(f"cells of {size} mm, eps {eps:g} kPa/mm, {space.ndof} unknowns: {found}\n")
    sys.stdout.flush()
    return found


if __name__ == "__main__":
    for name, case in CASES.items():
        sys.stdout.write(f"{name}: {case}\n")
        for size, eps in ((0.4, 1e5), (0.2, 1e5), (0.2, 1e6), (0.1, 1e5)):
            pressed(case, size, eps)
