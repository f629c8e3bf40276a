"""How far does silicone lift its target that would be larger if nothing held it? Another code's answer, plane strain.

NGSolve, small strain: displacement of order 4 and a continuous pressure of order 3 on triangles graded to the corners,

    2 mu dev eps(u) : dev eps(v) + p div v + q (div u - p/K) = 3 e q,

that is ``p = K (div u - 3 e)``, e what each length would grow by. With the target held it is pressed by F, with the
target moved by one without e it needs k: the rise is F/k. Lengths in mm, mu = 1. NGSolve is no dependency of the
package; the numbers stand in tests/mechanics/test_linear.py.

Run ``python studies/common/ngsolve_rise.py``.
"""

from __future__ import annotations

import sys
from typing import Any

THICKNESS, RATIO = 2.0, 1000.0  # mm; bulk over shear modulus
CASES = ((20.0, 15.0), (20.0, 8.0), (8.0, 8.0))  # widths of layer and target


def section(width: float, target: float, size: float) -> Any:
    """Return the mesh of a layer under a target in its middle, cells of a size, finer at the bonds' ends."""
    from netgen.occ import Glue, OCCGeometry, Rectangle
    from ngsolve import Mesh

    def strip(begin: float, end: float) -> Any:
        return Rectangle(end - begin, THICKNESS).Face().Move((begin, 0, 0))

    a, b = width / 2, target / 2
    parts = [strip(-a, -b), strip(-b, b), strip(b, a)] if target < width else [strip(-a, a)]
    shape = Glue(parts)
    for edge in shape.edges:
        x, y = edge.center.x, edge.center.y
        if abs(y) < 1e-9:
            edge.name = "ground"
        elif abs(y - THICKNESS) < 1e-9 and abs(x) < b - 1e-9:
            edge.name = "target"
    for vertex in shape.vertices:
        vertex.maxh = size / 200
    return Mesh(OCCGeometry(shape, dim=2).GenerateMesh(maxh=size, grading=0.25))


def rise(width: float, target: float, size: float) -> tuple[float, int]:
    """Return the rise over e and the thickness, and the number of unknowns."""
    from ngsolve import (
        H1,
        BilinearForm,
        CoefficientFunction,
        Grad,
        GridFunction,
        Id,
        InnerProduct,
        LinearForm,
        Trace,
        VectorH1,
        div,
        dx,
    )

    mesh = section(width, target, size)
    space = VectorH1(mesh, order=4, dirichlet="ground|target") * H1(mesh, order=3)
    (u, p), (v, q) = space.TnT()
    eps = [0.5 * (Grad(w) + Grad(w).trans) for w in (u, v)]
    dev = [each - Trace(each) / 3 * Id(2) for each in eps]
    hoop = Trace(eps[0]) * Trace(eps[1]) / 9  # of the deviator across the plane
    a = BilinearForm(space, symmetric=True)
    a += (2 * (InnerProduct(*dev) + hoop) + p * div(v) + q * div(u) - p * q / RATIO) * dx
    a.Assemble()
    grown = LinearForm(3 * q * dx).Assemble()
    inverse = a.mat.Inverse(space.FreeDofs(), inverse="sparsecholesky")
    held, moved = GridFunction(space), GridFunction(space)
    held.vec.data = inverse * grown.vec
    moved.components[0].Set(CoefficientFunction((0, 1)), definedon=mesh.Boundaries("target"))
    left = moved.vec.CreateVector()
    left.data = -a.mat * moved.vec
    moved.vec.data += inverse * left
    stiffness = InnerProduct(moved.vec, (a.mat * moved.vec).Evaluate())
    force = InnerProduct(moved.vec, grown.vec) - InnerProduct(moved.vec, (a.mat * held.vec).Evaluate())
    return force / stiffness / THICKNESS, space.ndof


def main() -> None:
    """Print the rises on two meshes each."""
    for width, target in CASES:
        for size in (0.5, 0.25):
            value, unknowns = rise(width, target, size)
            sys.stdout.write(f"{width:g} mm under {target:g} mm, {unknowns} unknowns: {value:.6f}\n")


if __name__ == "__main__":
    main()
