"""Which meshes do the reference pads have? Quadrilaterals and bricks, geometrically graded towards bonded edges.

Towards an edge at which the bond ends, the cells shrink by a constant ratio over a number of layers: with elements of
order p that resolves the edge's singular field exponentially in p (I. Babuska, B. Guo, SIAM J. Numer. Anal. 25 (1988)
837). Boxes under a load that creases such small cells, and films, stand on the lines of the package's own families
instead, spaced by a power: errors go with a power of their number, which is measured. All are products of lines.
Lengths in mm; a plan is cut by symmetry at x = 0, or y = 0, or both.

NGSolve is no dependency of the package: it is imported where a mesh is handed to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sits_mech.geometry.meshing.bricks import CORE, PlateOutline, ring_bricks
from sits_mech.mechanics.pad.shapes import GRADING, box_lines, lines_through, low_corner, ring_lines
from sits_mech.quantities import Array

Sizes = tuple[float, float]
Cells = NDArray[np.int64]

@dataclass(frozen=True)
class Plan:
    """Points and counter-clockwise quadrilaterals of a plan, or of a section, and which are under the target.

    Attributes
    ----------
    points : ndarray, shape (n, 2)
    quads : ndarray, shape (m, 4)
    under : ndarray, shape (m,)
        Of a plan: whether the quadrilateral is bonded to the target.
    """

    points: Array
    quads: Cells
    under: NDArray[np.bool_]


def graded(first: float, last: float, layers: tuple[int, int], size: float, ratio: float) -> Array:
    """Return lines from `first` to `last` with geometric layers at each end, cells between them no longer than `size`.

    Parameters
    ----------
    layers : (int, int)
        Geometric layers at the first and at the last end.
    size : float
        Largest cell [mm]; the layers begin at 0.7 of it from their end, or at the middle.
    ratio : float
        Of the sizes of neighbouring layers.
    """
    length = last - first
    ends = sum(1 for count in layers if count)
    reach = min(0.7 * size, length / max(1, ends)) if ends else 0.0
    own = [reach * ratio ** np.arange(count, 0, -1) for count in layers]
    left = np.concatenate([[0.0], own[0], [reach]]) if layers[0] else np.zeros(1)
    right = length - (np.concatenate([[0.0], own[1], [reach]]) if layers[1] else np.zeros(1))
    middle = right.min() - left.max()
    count = int(np.ceil(middle / size - 1e-9)) if middle > 1e-9 * length else 0
    between = np.linspace(left.max(), right.min(), count + 1) if count else np.zeros(0)
    lines = np.unique(np.round(np.concatenate([left, between, right]) / length, 12))
    return np.asarray(first + length * lines)


def joined(*parts: Array) -> Array:
    """Return lines of neighbouring stretches as one."""
    return np.asarray(np.unique(np.round(np.concatenate(parts), 12)))


def side(target: float, pad: float, layers: int, size: float, ratio: float, *, whole: bool) -> Array:
    """Return lines across half a pad, or the whole, graded towards the target's edge and the pad's [mm]."""
    half = graded(0.0, 0.5 * target, (0, layers), size, ratio)
    if pad > target * (1.0 + 1e-9):
        far = max(1, layers - 2) if pad - target > 0.5 * size else layers
        half = joined(half, graded(0.5 * target, 0.5 * pad, (layers, far), size, ratio))
    return joined(-half, half) if whole else half


def family_lines(
    pad: Sizes, target: Sizes, t: float, split: int, grading: float = GRADING
) -> tuple[Array, Array, Array]:
    """Return the lines of half a box along x, along y from the middle on, and through the thickness t."""
    plate, outer = (PlateOutline(0.5 * w / t, 0.5 * b / t, False) for w, b in (target, pad))
    x, y, z = box_lines(plate, outer, split, grading)
    return t * x, t * y, t * z


def product_plan(x: Array, y: Array, under: tuple[float, float]) -> Plan:
    """Return the plan of a box, from lines along x and y and the half widths of the target."""
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    first = (np.arange(len(x) - 1)[:, None] * len(y) + np.arange(len(y) - 1)).ravel()
    quads = np.stack([first, first + len(y), first + len(y) + 1, first + 1], axis=1)
    centre = np.abs(points[quads].mean(axis=1))
    return Plan(points, quads, (centre < np.array(under)).all(axis=1))


def ring_mesh(target: float, pad: PlateOutline, t: float, split: int, *, whole: bool) -> Any:
    """Return NGSolve's mesh of a half, or a quarter, of a pad under a disc, in rings of the package's own families.

    Bricks of rings in squares, target |x|, |y| < 1 and pad up to 2, are deformed to the true outlines, order by order.
    """
    import ngsolve as ng

    plate, own = (
        PlateOutline(0.5 * target / t, 0.5 * target / t, True),
        PlateOutline(pad[0] / t, pad[1] / t, pad.is_round),
    )
    inside, outside = ring_lines(plate, own, split, GRADING)
    squares = PlateOutline(1.0, 1.0, False), PlateOutline(2.0, 2.0, False)
    bricks, _ = ring_bricks(squares[0], squares[len(outside) > 1], (inside, outside, np.arange(2.0)), split)
    low = bricks.p[2] < 0.5
    number = np.cumsum(low) - 1
    points, quads = bricks.p[:2, low].T, []
    for cell in bricks.t.T:
        corners = number[cell[low[cell]]]
        away = points[corners] - points[corners].mean(axis=0)
        quads.append(corners[np.argsort(np.arctan2(away[:, 1], away[:, 0]))])
    kept = np.array([quad for quad in quads if whole or points[quad, 0].mean() > 0.0])
    used, renumbered = np.unique(kept, return_inverse=True)
    points, cells = points[used], renumbered.reshape(kept.shape)
    plan = Plan(points, cells, np.abs(points[cells].mean(axis=1)).max(axis=1) < 1.0)
    mesh = solid_mesh(plan, t * lines_through(split, GRADING, low_corner(plate, own)))
    a, b = ng.sqrt(ng.x * ng.x), ng.sqrt(ng.y * ng.y)
    rho = ng.IfPos(a - b, a, b) + 1e-12
    side, up = ng.x / rho, ng.y / rho
    theta = 0.25 * np.pi * ng.IfPos(b - a, 2.0 - side, ng.IfPos(ng.x, up, 4.0 - up))
    round_off, core = (ng.cos(theta), ng.sin(theta)), CORE
    part, beyond = ng.IfPos(rho - core, (rho - core) / (1.0 - core), 0.0), ng.IfPos(rho - 1.0, rho - 1.0, 0.0)
    part = ng.IfPos(part - 1.0, 1.0, part)
    moved = []
    for k, straight in enumerate((side, up)):
        rim = 0.5 * target * round_off[k]
        edge = pad[k] * (round_off[k] if pad.is_round else straight)
        within = (1.0 - part) * ng.IfPos(core - rho, rho, core) * 0.4 * target * straight + part * rim
        moved.append((1.0 - beyond) * within + beyond * edge - (ng.x, ng.y)[k])
    mesh.deformed = ng.GridFunction(ng.VectorH1(mesh, order=3))
    mesh.deformed.Set(ng.CF((*moved, 0.0)))
    mesh.SetDeformation(mesh.deformed)
    return mesh


def section_mesh(x: Array, z: Array, half_target: float) -> Any:
    """Return NGSolve's mesh of a section, from lines across and up; boundaries ground, target, free, mirror_x."""
    import ngsolve
    from netgen.meshing import Element1D, Element2D, FaceDescriptor, Mesh, MeshPoint, Pnt

    mesh, plan = Mesh(dim=2), product_plan(x, z, (np.inf, np.inf))
    points = [mesh.Add(MeshPoint(Pnt(float(a), float(b), 0.0))) for a, b in plan.points]
    mesh.Add(FaceDescriptor(surfnr=1, domin=1, bc=1))
    for quad in plan.quads:
        mesh.Add(Element2D(1, [points[k] for k in quad]))
    names = ("ground", "target", "free", "mirror_x")
    for number, name in enumerate(names):
        mesh.SetBCName(number, name)
    for a, b in outer_edges(plan.quads):
        middle = plan.points[[a, b]].mean(axis=0)
        name = "free"
        if abs(middle[1] - z[0]) < 1e-9:
            name = "ground"
        elif abs(middle[1] - z[-1]) < 1e-9 and abs(middle[0]) < half_target:
            name = "target"
        elif x[0] == 0.0 and abs(middle[0]) < 1e-12:
            name = "mirror_x"
        mesh.Add(Element1D([points[a], points[b]], index=1 + names.index(name)))
    return ngsolve.Mesh(mesh)


def outer_edges(cells: Cells | list[list[int]]) -> list[tuple[int, int]]:
    """Return the edges that only one cell has, in its own sense."""
    edges = [(int(cell[k - 1]), int(cell[k])) for cell in cells for k in range(len(cell))]
    own = set(edges)
    return [(a, b) for a, b in edges if (b, a) not in own]


def solid_mesh(plan: Plan, z: Array) -> Any:
    """Return NGSolve's mesh of a pad, a plan drawn up along lines; boundaries as of `section_mesh`, and mirror_y."""
    import ngsolve
    from netgen.meshing import Element2D, Element3D, FaceDescriptor, Mesh, MeshPoint, Pnt

    mesh, count = Mesh(dim=3), len(plan.points)
    points = [mesh.Add(MeshPoint(Pnt(float(a), float(b), float(c)))) for c in z for a, b in plan.points]
    names = ("ground", "target", "free", "mirror_x", "mirror_y")
    for number in range(len(names)):
        mesh.Add(FaceDescriptor(surfnr=number + 1, domin=1, domout=0, bc=number + 1))
    for level in range(len(z) - 1):
        for quad in plan.quads:
            low = [points[level * count + k] for k in quad]
            high = [points[(level + 1) * count + k] for k in quad]
            mesh.Add(Element3D(1, low + high))
    top = (len(z) - 1) * count
    for quad, under in zip(plan.quads, plan.under, strict=True):
        mesh.Add(Element2D(1, [points[k] for k in quad[::-1]]))
        mesh.Add(Element2D(2 if under else 3, [points[top + k] for k in quad]))
    for a, b in outer_edges(plan.quads):
        places = np.abs(plan.points[[a, b]]).max(axis=0)
        number = 4 if places[0] < 1e-9 else 5 if places[1] < 1e-9 else 3
        for level in range(len(z) - 1):
            low, high = level * count, (level + 1) * count
            mesh.Add(Element2D(number, [points[low + a], points[low + b], points[high + b], points[high + a]]))
    for number, name in enumerate(names):
        mesh.SetBCName(number, name)
    return ngsolve.Mesh(mesh)
