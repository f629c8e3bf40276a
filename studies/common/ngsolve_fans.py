"""Which pose does a flush box take whose corners fold? Meshes of prisms that meet in the bonded corners.

At a bonded corner that opens or closes displacements go as ``r f(theta)``: bricks cannot follow, and fold. Here each of
the four corners of the section is within a square of half the thickness, of triangles that meet in the corner and rings
of quadrilaterals about them; the section is drawn along y. Displacements of order 4, pressures of order 2.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from common.ngsolve_mesh import graded, outer_edges
from common.ngsolve_pad import Law, Pad
from common.reference_cases import Case

from sits_mech.quantities import Array

RATIO = 0.3  # of a ring's size to that outside
LONG = 1.2  # thicknesses of the cells between the corners at most


class Fan(Pad):
    """A discrete pad of bricks and prisms."""

    def least_J(self) -> float:
        """Return the smallest volume ratio at the points of a rule on every element."""
        import ngsolve as ng

        rules = {kind: ng.IntegrationRule(kind, 2 * self.order + 2) for kind in (ng.ET.HEX, ng.ET.PRISM)}
        at = self.mesh.MapToAllElements(rules, ng.VOL)
        return float(np.min(self.volume(ng, self.state.components[0])(at)))


def fanned(case: Case, rings: int, parts: int) -> Pad:
    """Return half of a flush box: `parts` divide each side of a corner's square."""
    cells, t = section(case.pad[0], case.thickness, rings, parts), case.thickness
    mesh = drawn(*cells, t, graded(0.0, 0.5 * case.pad[1], (0, 1), LONG * t, RATIO))
    return Fan("solid", mesh, 4, Law(case.energy, case.K), 0.5, (0, 1, 2), case.height, seconds=600.0)


def section(wide: float, t: float, rings: int, parts: int) -> tuple[Array, list[list[int]]]:
    """Return points (x, z), and cells of three or four of them, counter-clockwise."""
    places: dict[tuple[float, float], int] = {}
    cells: list[list[int]] = []
    half, steps = 0.5 * t, np.linspace(0.0, 1.0, parts + 1)
    rim = [(1.0, s) for s in steps] + [(s, 1.0) for s in steps[-2::-1]]

    def add(*corners: tuple[float, float], turned: bool = False) -> None:
        """Append a cell."""
        rounded = [(round(float(x), 9), round(float(z), 9)) for x, z in corners]
        own = [places.setdefault(place, len(places)) for place in rounded]
        cells.append(own[::-1] if turned else own)

    for x, along in ((-0.5 * wide, 1), (0.5 * wide, -1)):
        for z, up in ((0.0, 1), (t, -1)):
            sizes = half * RATIO ** np.arange(rings + 1)
            for u, v in pairwise(rim):
                ring = [[(x + along * r * p[0], z + up * r * p[1]) for p in (u, v)] for r in sizes]
                for (a, b), (c, d) in pairwise(ring):
                    add(c, a, b, d, turned=along * up < 0)
                add((x, z), *ring[-1], turned=along * up < 0)
    inner = wide - t
    lines = np.linspace(-0.5 * inner, 0.5 * inner, int(np.ceil(inner / (LONG * t))) + 1)
    for low, high in pairwise(lines):
        for below, above in pairwise(np.concatenate([half * steps, t - half * steps[-2::-1]])):
            add((low, below), (high, below), (high, above), (low, above))
    return np.array(list(places)), cells


def drawn(points: Array, cells: list[list[int]], t: float, y: Array) -> Any:
    """Return NGSolve's mesh of a section drawn along y, with the boundaries of `solid_mesh`."""
    import ngsolve
    from netgen.meshing import Element2D, Element3D, FaceDescriptor, Mesh, MeshPoint, Pnt

    mesh, count = Mesh(dim=3), len(points)
    each = [mesh.Add(MeshPoint(Pnt(float(x), float(v), float(z)))) for v in y for x, z in points]
    names = ("ground", "target", "free", "mirror_x", "mirror_y")
    for number in range(len(names)):
        mesh.Add(FaceDescriptor(surfnr=number + 1, domin=1, domout=0, bc=number + 1))
    for cell in cells:
        back = cell[::-1]
        for row in range(len(y) - 1):
            mesh.Add(Element3D(1, [each[layer * count + k] for layer in (row, row + 1) for k in back]))
        mesh.Add(Element2D(5, [each[k] for k in cell]))
        mesh.Add(Element2D(3, [each[(len(y) - 1) * count + k] for k in back]))
    for a, b in outer_edges(cells):
        z = 0.5 * (points[a, 1] + points[b, 1])
        number = 1 if z < 1e-9 * t else 2 if z > (1.0 - 1e-9) * t else 3
        for low, high in pairwise(np.arange(len(y)) * count):
            mesh.Add(Element2D(number, [each[k] for k in (high + a, high + b, low + b, low + a)]))
    for number, name in enumerate(names):
        mesh.SetBCName(number, name)
    return ngsolve.Mesh(mesh)
