"""How do two rigid targets on one pad move under a force on one of them? Another code's answer, at small strain.

NGSolve, displacements of order 3 and a continuous pressure of order 2 on tetrahedra, half the pad by its mirror plane
y = 0. Two targets of 8 x 8 mm stand 9.6 mm apart on 30 x 20 x 2 mm of silicone, K = 1000 mu; with w_m the displacement
where motion m of (d_h, d_z, alpha) of both is one and the others zero, and a the elastic energy's form,

    K_mn = 2 a(w_m, w_n),      C = K^-1,      forces act at the lower face of the targets.

Prints mu times C of (d_h, d_z, alpha) of target A and B by forces on A [mm, N], by meshes with smaller cells at the
targets' edges. NGSolve is no dependency of the package; the numbers stand in tests/mechanics/test_cells.py.

Run ``python studies/common/ngsolve_cells.py`` (some minutes).
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

WIDE, DEEP, T, SIDE, PITCH, BULK = 30.0, 20.0, 2.0, 8.0, 9.6, 1000.0  # mm; bulk modulus over shear modulus
EDGES = (0.5, 0.25, 0.125)  # mm


def motions(mesh: Any, centres: Sequence[float]) -> tuple[Any, list[Any], list[Any]]:
    """Return the space of half a pad, w_m of both targets, the faces A and B about centres [mm], and a(., w_m)."""
    from ngsolve import (
        H1,
        BilinearForm,
        CoefficientFunction,
        Grad,
        GridFunction,
        InnerProduct,
        Sym,
        VectorH1,
        div,
        dx,
        x,
        z,
    )

    V = VectorH1(mesh, order=3, dirichletx="ground|A|B", dirichlety="ground|middle|A|B", dirichletz="ground|A|B")
    X = V * H1(mesh, order=2)
    (u, p), (v, q) = X.TnT()
    deviator = 2 * InnerProduct(Sym(Grad(u)), Sym(Grad(v))) - 2 / 3 * div(u) * div(v)
    form = BilinearForm(X, symmetric=True)
    form += (deviator + p * div(v) + q * div(u) - p * q / BULK) * dx
    form.Assemble()
    inverse, ways = form.mat.Inverse(X.FreeDofs(), inverse="umfpack"), []
    for name, centre in zip("AB", centres, strict=True):
        for motion in ((1, 0, 0), (0, 0, 1), (z - T, 0, centre - x)):
            w = GridFunction(X)
            w.components[0].Set(CoefficientFunction(motion), definedon=mesh.Boundaries(name))
            w.vec.data -= inverse @ form.mat * w.vec
            ways.append(w)
    pushed = [w.vec.CreateVector() for w in ways]
    for product, w in zip(pushed, ways, strict=True):
        product.data = form.mat * w.vec
    return X, ways, pushed


def compliance(edge: float) -> np.ndarray:
    """Return mu C, (6, 6), by cells of a size at the targets' edges [mm]."""
    from netgen.occ import Axes, Box, Glue, OCCGeometry, WorkPlane
    from ngsolve import InnerProduct, Mesh

    pad = Box((-WIDE / 2, 0, 0), (WIDE / 2, DEEP / 2, T))
    pad.faces.Min((0, 0, 1)).name, pad.faces.Min((0, 1, 0)).name = "ground", "middle"
    plates = []
    for name, centre in (("A", -PITCH / 2), ("B", PITCH / 2)):
        low = WorkPlane(Axes((centre - SIDE / 2, 0, T), (0, 0, 1), (1, 0, 0)))
        plate = low.Rectangle(SIDE, SIDE / 2).Face()
        plate.name, plate.edges.maxh = name, edge
        plates.append(plate)
    mesh = Mesh(OCCGeometry(Glue([pad, *plates])).GenerateMesh(maxh=1.0, grading=0.5))
    X, ways, pushed = motions(mesh, (-PITCH / 2, PITCH / 2))
    sys.stdout.write(f"{edge} mm, {X.ndof} unknowns\n")
    return np.linalg.inv([[2 * InnerProduct(w.vec, each) for each in pushed] for w in ways])


if __name__ == "__main__":
    for edge in EDGES:
        sys.stdout.write(f"{compliance(edge)[:, :3].tolist()}\n")
        sys.stdout.flush()
