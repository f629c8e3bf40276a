"""How do two rigid targets on one pad move under a force on one of them? Another code's answer, at small strain.

NGSolve, displacements of order 3 and a continuous pressure of order 2 on tetrahedra, half the pad by its mirror plane
y = 0. Two targets, A of 8 x 8 mm and B alike or of 6 x 4 mm, stand 1.6 mm apart on 30 x 20 x 2 mm of silicone, K = 1000
mu, between alike ones nothing or a slot of 0.6 mm, through the pad or 1 mm deep, or a wall; with w_m the displacement
where motion m of (d_h, d_z, alpha) of both is one and the others zero, and a the elastic energy's form,

    K_mn = 2 a(w_m, w_n),      C = K^-1,      forces act at the lower face of the targets.

Prints mu times C of (d_h, d_z, alpha) of target A and B by forces on A [mm, N], by meshes with smaller cells at the
targets' edges. NGSolve is no dependency of the package; the numbers stand in tests/mechanics/cells/test_targets.py.

Run ``python studies/common/ngsolve_cells.py`` (some minutes a case), or with the name of one of `CASES`.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

WIDE, DEEP, T, SIDE, BULK = 30.0, 20.0, 2.0, 8.0, 1000.0  # mm; bulk modulus over shear modulus
EDGES = (0.5, 0.25, 0.125)  # mm
Plates = tuple[tuple[float, float, float], ...]
PAIR: Plates = ((-4.8, SIDE, SIDE), (4.8, SIDE, SIDE))  # mm: middle, width and length of A and B
UNLIKE: Plates = ((-4.8, SIDE, SIDE), (3.8, 6.0, 4.0))
CASES: dict[str, tuple[Plates, float, bool]] = {  # plates, depth of the slot [mm], whether it is a wall
    "alike": (PAIR, 0.0, False), "unlike": (UNLIKE, 0.0, False), "slot": (PAIR, T, False),
    "half a slot": (PAIR, T / 2, False), "wall": (PAIR, T, True),
}
SLOT = 0.6  # mm


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


def compliance(edge: float, plates: Plates = PAIR, depth: float = 0.0, wall: bool = False) -> np.ndarray:
    """Return mu C, (6, 6), by cells of a size at the targets' edges [mm]."""
    from netgen.occ import Axes, Box, Glue, OCCGeometry, WorkPlane
    from ngsolve import InnerProduct, Mesh

    pad = Box((-WIDE / 2, 0, 0), (WIDE / 2, DEEP / 2, T))
    if depth:
        pad = pad - Box((-SLOT / 2, -1, T - depth), (SLOT / 2, DEEP, T + 1))
    for face in pad.faces:
        x, y, z = face.center
        inside = abs(x) < 0.51 * SLOT and z < T - 1e-6 and abs(y) > 1e-6 and y < DEEP / 2 - 1e-6
        if inside and depth:
            face.edges.maxh = edge
        face.name = "ground" if z < 1e-6 or (wall and inside) else "middle" if abs(y) < 1e-6 else "free"
    found = []
    for name, (centre, width, length) in zip("AB", plates, strict=True):
        low = WorkPlane(Axes((centre - width / 2, 0, T), (0, 0, 1), (1, 0, 0)))
        plate = low.Rectangle(width, length / 2).Face()
        plate.name, plate.edges.maxh = name, edge
        found.append(plate)
    mesh = Mesh(OCCGeometry(Glue([pad, *found])).GenerateMesh(maxh=1.0, grading=0.5))
    X, ways, pushed = motions(mesh, [centre for centre, *_ in plates])
    sys.stdout.write(f"{edge} mm, {X.ndof} unknowns\n")
    return np.linalg.inv([[2 * InnerProduct(w.vec, each) for each in pushed] for w in ways])


if __name__ == "__main__":
    for case in sys.argv[1:] or CASES:
        sys.stdout.write(f"{case}\n")
        for edge in EDGES:
            sys.stdout.write(f"{compliance(edge, *CASES[case])[:, :3].tolist()}\n")
            sys.stdout.flush()
