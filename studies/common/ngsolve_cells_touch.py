"""How do two rigid targets on one pad move under a pressure on the pad, or on a cover over both? Another code's answer.

NGSolve at small strain, as ngsolve_cells.py: half of 30 x 20 x 2 mm of silicone, K = 1000 mu, under two targets of
8 x 8 mm with a gap between them; a pressure of 1 N in all on an area off the middle. With w_m the displacement where
motion m of (d_h, d_z, alpha) of both is one and the others zero, a the elastic energy's form and l the load's,

    K_mn = 2 a(w_m, w_n),      q = K^-1 2 l(w).

Prints mu q of target A and B [mm, rad], by meshes with smaller cells at the targets' edges. NGSolve is no dependency
of the package; the numbers stand in tests/mechanics/cells/test_targets.py.

Run ``python -m common.ngsolve_cells_touch`` in studies (some minutes).
"""

from __future__ import annotations

import sys
from typing import NamedTuple

import numpy as np
from common.ngsolve_cells import DEEP, SIDE, WIDE, T, motions

EDGES = (0.5, 0.25, 0.15)  # mm


class Case(NamedTuple):
    """A pair of targets with what presses on it [mm]."""

    pitch: float
    area: tuple[float, float, float]  # middle along x, width, length
    rim: float = 0.0  # thickness of the targets within a cover
    over: float = 0.0  # of the cover above them
    hang: float = 0.0  # and beside them


CASES = {"bare": Case(12.0, (0.6, 1.6, 4.0)), "covered": Case(9.6, (2.0, 4.0, 4.0), 0.5, 1.0, 1.5)}


def moved(case: Case, edge: float) -> np.ndarray:
    """Return mu q, (6,), by cells of a size at the targets' edges [mm]."""
    from netgen.occ import Axes, Box, Glue, OCCGeometry, WorkPlane
    from ngsolve import CoefficientFunction, InnerProduct, Integrate, Mesh

    centres, half = (-case.pitch / 2, case.pitch / 2), SIDE / 2
    pad = Box((-WIDE / 2, 0, 0), (WIDE / 2, DEEP / 2, T))
    top = T + case.rim + case.over
    if case.over:
        far = case.pitch / 2 + half + case.hang
        pad = pad + Box((-far, 0, T), (far, half + case.hang, top))
        for c in centres:
            pad = pad - Box((c - half, 0, T), (c + half, half, T + case.rim))
    pad.faces.Min((0, 0, 1)).name, pad.faces.Min((0, 1, 0)).name = "ground", "middle"
    middle, width, length = case.area
    faces = [(middle - width / 2, top, width, length / 2, "pressed", 0.5)]
    faces += [] if case.over else [(c - half, T, SIDE, half, name, edge) for c, name in zip(centres, "AB", strict=True)]
    plates = []
    for low, height, wide, deep, name, size in faces:
        face = WorkPlane(Axes((low, 0, height), (0, 0, 1), (1, 0, 0))).Rectangle(wide, deep).Face()
        face.name, face.edges.maxh = name, size
        plates.append(face)
    if case.over:
        for face in pad.faces:
            at = face.center
            for c, name in zip(centres, "AB", strict=True):
                within = abs(at.x - c) <= half + 1e-6 and at.y <= half + 1e-6 and T - 1e-6 < at.z < T + case.rim + 1e-6
                if within and at.y > 1e-6:
                    face.name, face.edges.maxh = name, edge
        for face in pad.faces:
            if abs(face.center.y) < 1e-6:
                face.name = "middle"
    mesh = Mesh(OCCGeometry(Glue([pad, *plates])).GenerateMesh(maxh=1.0, grading=0.5))
    X, ways, pushed = motions(mesh, centres)
    area = mesh.Boundaries("pressed")
    size = 2 * Integrate(CoefficientFunction(1), mesh, definedon=area)
    load = [-2 / size * Integrate(w.components[0][2], mesh, definedon=area) for w in ways]
    sys.stdout.write(f"{edge} mm, {X.ndof} unknowns, {size:.6g} mm^2\n")
    return np.linalg.solve([[2 * InnerProduct(w.vec, each) for each in pushed] for w in ways], load)


if __name__ == "__main__":
    for name, case in CASES.items():
        if name not in (sys.argv[1:] or CASES):
            continue
        for edge in EDGES:
            sys.stdout.write(f"{name}: {moved(case, edge).tolist()}\n")
            sys.stdout.flush()
